//! The loop over instructions, in the widest registers that the processor has.
//!
//! One function holds the loops over lanes of all frequent instructions: from one to the next it takes
//! a jump. Those that are not frequent are functions of their own.

use pulp::NullaryFnOnce;

use super::super::code::{Op, RealBinary};
use super::super::counts::InstructionCost;
use super::super::real::Real;
use super::{Machine, Stopped, wide};

/// A run from an instruction to the end of the function that was invoked.
struct Interpret<'m, 'p, 'j, R: Real> {
    machine: &'m mut Machine<'p, 'j, R>,
    pc: usize,
}

impl<R: Real> NullaryFnOnce for Interpret<'_, '_, '_, R> {
    type Output = Result<(), Stopped>;

    #[inline(always)]
    fn call(self) -> Result<(), Stopped> {
        let Interpret { machine, mut pc } = self;
        let watched = machine.watch.is_some();
        let program = machine.program;
        let (code, costs, pool) = (&program.code[..], &program.costs[..], &program.pool[..]);
        loop {
            let this = pc;
            let (inst, cost) = (&code[this], &costs[this]);
            pc += 1;
            machine.count(cost);
            if watched {
                machine.before(this);
            } else if inst.once {
                // What a batch before has computed for all batches.
                if machine.done[this] {
                    continue;
                }
                // Without an active lane an expensive function computes nothing.
                machine.done[this] = machine.active != 0;
            }
            let at = inst.at as usize;
            let operands = &pool[at..at + cost.operands as usize];
            match inst.op {
                // The product goes straight into the sum; watched, it is stored and inspected.
                Op::RealBinary(RealBinary::Mul) if inst.fused && !watched && !R::PERMITTED => {
                    let (then, cost) = (&code[pc], &costs[pc]);
                    pc += 1;
                    machine.count(cost);
                    let at = then.at as usize;
                    machine.multiply_and(then.op, operands, &pool[at..at + cost.operands as usize]);
                }
                Op::RealUnary(f) => machine.f1(f, operands),
                Op::RealBinary(f) => machine.f2(f, operands),
                Op::RealTernary(f) => machine.f3(f, operands),
                Op::FCmp(cmp) => machine.compare_reals(cmp, operands),
                Op::Dot(n) => machine.dot(usize::from(n), operands),
                Op::Length(n) => machine.length(usize::from(n), operands),
                Op::Distance(n) => machine.distance(usize::from(n), operands),
                Op::Normalize(n) => machine.normalize(usize::from(n), operands),
                Op::Cross => machine.cross(operands),
                Op::WordBinary(f) => machine.i2(f, operands),
                Op::CmpSint(cmp) => machine.compare_words(cmp, true, operands),
                Op::CmpUint(cmp) => machine.compare_words(cmp, false, operands),
                Op::Select(class) => machine.select(class, operands),
                Op::Move(class) | Op::Undefined(class) => machine.shift(class, operands),
                Op::Store(class) => machine.store(class, operands),
                Op::Load(access) => {
                    let (head, operands) = operands.split_at(usize::from(inst.head));
                    machine.load(access, head, operands);
                }
                Op::Sample => machine.sample(operands),
                Op::Texel => machine.texel(operands),
                Op::Sampled | Op::Nop => {}
                Op::Inlined(function) => {
                    // Code in place of a call counts as a call.
                    machine.tally.calls[function as usize] += machine.count;
                    machine.call_tick(this)?;
                }
                Op::End => match machine.end() {
                    Some(back) => pc = back,
                    None => return Ok(()),
                },
                Op::Call(function) => pc = machine.enter(function, this)?,
                Op::LoopBack(target) => {
                    // Without an active lane, the loop is over.
                    if machine.active != 0 {
                        machine.tick(this, target)?;
                        pc = target as usize;
                    }
                }
                Op::Barrier => machine.barrier(this)?,
                Op::If(_)
                | Op::Else(_)
                | Op::EndIf(_)
                | Op::Loop
                | Op::Continuing(_)
                | Op::BreakIf
                | Op::LoopEnd(_)
                | Op::Switch
                | Op::Case(_)
                | Op::CaseSkip(_)
                | Op::CaseEnd
                | Op::SwitchEnd(_)
                | Op::Break
                | Op::Continue
                | Op::Return
                | Op::Kill => {
                    if let Some(target) = machine.branch(inst.op, operands) {
                        pc = target as usize;
                    }
                }
                op => machine.interpret_rare(op, operands.split_at(usize::from(inst.head))),
            }
            if watched {
                machine.after(this);
            }
        }
    }
}

/// An instruction of one operand that is not frequent.
struct Rare<'m, 'p, 'j, R: Real> {
    machine: &'m mut Machine<'p, 'j, R>,
    op: Op,
    operands: &'m [u32],
}

impl<R: Real> NullaryFnOnce for Rare<'_, '_, '_, R> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Rare { machine, op, operands } = self;
        match op {
            Op::FTest(test) => machine.test_reals(test, operands),
            Op::Ldexp => machine.ldexp(operands),
            Op::WordUnary(f) => machine.i1(f, operands),
            Op::Cast(cast) => machine.cast(cast, operands),
            other => unreachable!("{other:?} is not of these"),
        }
    }
}

impl<R: Real> Machine<'_, '_, R> {
    /// Runs a function from its first instruction to its end.
    pub(super) fn interpret(&mut self, pc: usize) -> Result<(), Stopped> {
        let arch = self.arch;
        let run = Interpret { machine: self, pc };
        // Intervals are computed one by one.
        if R::PERMITTED { run.call() } else { arch.dispatch(run) }
    }

    #[inline(always)]
    fn count(&mut self, cost: &InstructionCost) {
        self.tally.kinds[cost.kind as usize] += u64::from(cost.weight) * self.count;
    }

    #[inline(never)]
    fn interpret_rare(&mut self, op: Op, (head, operands): (&[u32], &[u32])) {
        match op {
            Op::ExtractSint => self.extract(true, operands),
            Op::ExtractUint => self.extract(false, operands),
            Op::Insert => self.insert(operands),
            Op::StoreMemory(access) => self.save(access, head, operands),
            Op::Gather(class, access) => self.gather(class, access, head, operands),
            Op::Scatter(class, access) => self.scatter(class, access, head, operands),
            Op::Atomic(access) => self.atomic(access, head, operands),
            Op::ArrayLength(access) => self.array_length(access, operands),
            Op::ImageSize => self.image_size(operands),
            Op::DerivativeFine(axis) => self.derivative(axis, true, operands),
            Op::DerivativeCoarse(axis) => self.derivative(axis, false, operands),
            Op::FTest(_) | Op::Ldexp | Op::WordUnary(_) | Op::Cast(_) => {
                let arch = self.arch;
                let run = Rare { machine: self, op, operands };
                if R::PERMITTED { run.call() } else { arch.dispatch(run) }
            }
            _ => wide::compute(op, operands, &mut self.words, &mut self.wides),
        }
    }
}
