//! Records every operation of one invocation and the sources of its operands: the graph of the
//! computation, with loops unrolled and copies resolved.
//!
//! Like [`sanitizer`](super::sanitizer) it reads registers after each instruction; the public form
//! is [`Trace`].

use rustc_hash::FxHashMap;

use super::super::code::{Class, Op, RealBinary, RealTernary, RealUnary, Reg, Stored, WordBinary};
use super::super::lanes::Lanes;
use super::super::program::FunctionCode;
use super::super::real::Real;
use super::super::trace::{Comparison, Number, Operand, Operation, Source, Trace, TracedOperation};
use super::super::undefined::UndefinedKind;
use super::memory::elements;
use super::{Machine, column, integer};

/// Maximum number of recorded steps.
const LIMIT: usize = 1 << 17;

/// A trace under construction.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tracer {
    pub trace: Trace,
    /// By class and register: the source of the last value written.
    written: FxHashMap<(u8, u32), Source>,
    /// By buffer and byte: the source of what the invocation stored.
    stored: FxHashMap<(u32, u32), Source>,
}

impl Tracer {
    /// Starts the trace; the arguments are in their registers.
    pub fn begin(&mut self, code: &FunctionCode) {
        for (parameter, argument) in code.arguments.iter().enumerate() {
            for (scalar, reg) in argument.regs.iter().enumerate() {
                let source = Source::Input { parameter: parameter as u32, scalar: scalar as u32 };
                self.written.insert((reg.class() as u8, reg.number()), source);
            }
        }
    }

    /// Ends the trace; the results are in their registers.
    pub fn finish(&mut self, code: &FunctionCode) {
        self.trace.results = self.sources(&code.result);
        let arguments = code.arguments.iter();
        self.trace.returned = arguments.map(|argument| self.sources(&argument.regs)).collect();
    }

    /// Ends the trace of an entry point; its output is in these registers.
    pub fn finish_output(&mut self, regs: &[Reg]) {
        self.trace.results = self.sources(regs);
    }

    fn sources(&self, regs: &[Reg]) -> Vec<Source> {
        regs.iter().map(|reg| self.source(reg.class(), reg.number())).collect()
    }

    fn push(&mut self, step: TracedOperation) {
        match self.trace.steps.len() < LIMIT {
            true => self.trace.steps.push(step),
            false => self.trace.cut = true,
        }
    }

    fn source(&self, class: Class, reg: u32) -> Source {
        // Registers that nothing has written hold constants, or the zeros they begin with.
        self.written.get(&(class as u8, reg)).copied().unwrap_or(Source::Constant)
    }

    fn write(&mut self, class: Class, reg: u32, source: Source) {
        self.written.insert((class as u8, reg), source);
    }
}

impl<R: Real> Machine<'_, '_, R> {
    /// Records an executed instruction for the first lane.
    pub(super) fn trace(&mut self, pc: usize, op: Op, head: &[u32], operands: &[u32]) {
        if self.active & 1 == 0 || op.shape().len() == 0 {
            return;
        }
        // Taken out, as the methods below borrow the machine.
        let Some(mut tracer) = self.watch.as_mut().and_then(|watch| watch.tracer.take()) else {
            return;
        };
        self.trace_indices(&mut tracer, pc, op, head);
        for group in operands.chunks_exact(op.shape().len()) {
            self.trace_group(&mut tracer, pc, op, head, group);
        }
        if let Some(watch) = &mut self.watch {
            watch.tracer = Some(tracer);
        }
    }

    /// Records the indices of an access, with the lengths of their arrays.
    fn trace_indices(&self, t: &mut Tracer, pc: usize, op: Op, head: &[u32]) {
        let (Op::Gather(_, access)
        | Op::Scatter(_, access)
        | Op::Load(access)
        | Op::StoreMemory(access)
        | Op::Atomic(access)) = op
        else {
            return;
        };
        let access = &self.program.accesses[access as usize];
        let bytes = self.buffers.get(access.buffer as usize).map_or(0, |b| b.bytes.len());
        for (&reg, dynamic) in head.iter().zip(&access.dynamics) {
            let index = column(&self.words, reg)[0];
            let len = elements(dynamic.bound, bytes);
            let number = |x: f64| Number { single: x as f32, double: x };
            // Past 2^31, it was a negative integer.
            let shown = if len <= i32::MAX as u32 { f64::from(index as i32) } else { index.into() };
            let operands = vec![
                Operand { number: number(shown), source: t.source(Class::Word, reg) },
                Operand { number: number(f64::from(len)), source: Source::Constant },
            ];
            let undefined = (index >= len).then_some(UndefinedKind::IndexOutOfBounds);
            t.push(TracedOperation {
                operation: Operation::Index,
                operands,
                results: Vec::new(),
                undefined,
                origin: self.program.origins[pc],
            });
        }
    }

    fn number(&self, op: Op, class: Class, reg: u32) -> Number {
        match class {
            Class::Real => {
                let x = column(&self.reals, reg).lane(0);
                Number { single: x.single(), double: x.double() }
            }
            Class::Word => {
                let x = integer::operand(op, column(&self.words, reg)[0]);
                Number { single: x as f32, double: x }
            }
            Class::Wide => {
                let x = f64::from_bits(column(&self.wides, reg)[0]);
                Number { single: x as f32, double: x }
            }
        }
    }

    fn trace_group(&self, t: &mut Tracer, pc: usize, op: Op, head: &[u32], group: &[u32]) {
        let way = |access: u32, class: Class| {
            let access = &self.program.accesses[access as usize];
            self.computed_offset(access, head, 0, class as usize) as u32
        };
        let place = |access: u32, offset: u32| {
            let access = &self.program.accesses[access as usize];
            (access.buffer, offset + self.computed_offset(access, head, 0, 0) as u32)
        };
        // Copies pass on their source.
        match op {
            Op::Move(class) | Op::Undefined(class) | Op::Store(class) => {
                let source = t.source(class, group[1]);
                return t.write(class, group[0], source);
            }
            Op::Select(class) => {
                let yes = column(&self.words, group[1])[0] != 0;
                let source = t.source(class, if yes { group[2] } else { group[3] });
                return t.write(class, group[0], source);
            }
            Op::Gather(class, access) => {
                let source = t.source(class, group[1] + way(access, class));
                return t.write(class, group[0], source);
            }
            Op::Scatter(class, access) => {
                let source = t.source(class, group[0]);
                return t.write(class, group[1] + way(access, class), source);
            }
            Op::Load(access) => {
                let (buffer, byte) = place(access, group[1]);
                let loaded = Source::Buffer { buffer, byte };
                // A load of what the invocation stored is a copy.
                let source = t.stored.get(&(buffer, byte)).copied().unwrap_or(loaded);
                return t.write(Stored::ALL[group[2] as usize].class(), group[0], source);
            }
            Op::StoreMemory(access) => {
                let source = t.source(Stored::ALL[group[2] as usize].class(), group[0]);
                t.stored.insert(place(access, group[1]), source);
                return;
            }
            _ => {}
        }
        let Some((operation, to, from)) = form(op) else {
            // The sources of doubles, atomics and image sizes are not followed. Of every class, as
            // `form` has not told which.
            for class in [Class::Real, Class::Word, Class::Wide] {
                for &reg in &group[..op.shape().writes] {
                    t.write(class, reg, Source::Unknown);
                }
            }
            return;
        };
        let shape = op.shape();
        let (writes, rest) = group.split_at(shape.writes);
        // No instruction overwrites its operands, so they are still there.
        let mut operands = Vec::with_capacity(shape.reads);
        for (at, &reg) in rest[..shape.reads].iter().enumerate() {
            // The exponent of `ldexp` is a word.
            let class = if op == Op::Ldexp && at == 1 { Class::Word } else { from };
            let number = self.number(op, class, reg);
            operands.push(Operand { number, source: t.source(class, reg) });
        }
        let mut results: Vec<Number> = writes.iter().map(|&reg| self.number(op, to, reg)).collect();
        if let (Op::FCmp(cmp), [a, b]) = (op, &operands[..]) {
            // What the doubles would decide.
            results[0].double = f64::from(u8::from(cmp.holds(a.number.double, b.number.double)));
        }
        let step = t.trace.steps.len() as u32;
        for (part, &reg) in writes.iter().enumerate() {
            let part = part as u32;
            // A step that was left out has no number.
            let full = step as usize >= LIMIT;
            let source = if full { Source::Unknown } else { Source::Step { step, part } };
            t.write(to, reg, source);
        }
        let undefined = self.undefined_group(op, &rest[..shape.reads], 0).map(|(kind, _)| kind);
        let origin = self.program.origins[pc];
        t.push(TracedOperation { operation, operands, results, undefined, origin });
    }
}

/// Returns the operation of an instruction, and the classes of its results and operands.
fn form(op: Op) -> Option<(Operation, Class, Class)> {
    use Class::{Real, Wide, Word};
    Some(match op {
        Op::RealUnary(f) => (unary(f), Real, Real),
        Op::RealBinary(f) => (binary(f), Real, Real),
        Op::RealTernary(f) => (ternary(f), Real, Real),
        Op::FCmp(cmp) => (Operation::Compare(Comparison::Numbers(cmp)), Word, Real),
        Op::FTest(test) => (Operation::Compare(Comparison::Test(test)), Word, Real),
        Op::Ldexp => (Operation::Other, Real, Real),
        Op::Dot(_) => (Operation::Dot, Real, Real),
        Op::Length(_) => (Operation::Length, Real, Real),
        Op::Distance(_) => (Operation::Distance, Real, Real),
        Op::Normalize(_) => (Operation::Normalize, Real, Real),
        Op::Cross => (Operation::Cross, Real, Real),
        Op::DerivativeFine(_) | Op::DerivativeCoarse(_) => (Operation::Other, Real, Real),
        Op::WordBinary(WordBinary::DivSint | WordBinary::DivUint) => (Operation::Div, Word, Word),
        Op::WordBinary(WordBinary::RemSint | WordBinary::RemUint) => (Operation::Rem, Word, Word),
        Op::WordUnary(_) | Op::WordBinary(_) | Op::CmpSint(_) | Op::CmpUint(_) => {
            (Operation::Integer, Word, Word)
        }
        Op::ExtractSint | Op::ExtractUint | Op::Insert => (Operation::Integer, Word, Word),
        Op::Sample | Op::Texel => (Operation::Texture, Real, Real),
        Op::Cast(cast) => {
            let (from, to) = cast.classes();
            if from == Wide || to == Wide {
                return None;
            }
            (Operation::Convert, to, from)
        }
        _ => return None,
    })
}

fn unary(f: RealUnary) -> Operation {
    match f {
        RealUnary::Neg => Operation::Neg,
        RealUnary::Abs => Operation::Abs,
        RealUnary::Saturate => Operation::Clamp,
        RealUnary::Sqrt => Operation::Root,
        RealUnary::InverseSqrt => Operation::InverseRoot,
        RealUnary::Exp | RealUnary::Exp2 => Operation::Exp,
        RealUnary::Log | RealUnary::Log2 => Operation::Log,
        RealUnary::Sin | RealUnary::Cos | RealUnary::Tan => Operation::Trigonometric,
        RealUnary::Asin => Operation::Function("asin"),
        RealUnary::Acos => Operation::Function("acos"),
        RealUnary::Atan => Operation::Function("atan"),
        RealUnary::Sinh => Operation::Function("sinh"),
        RealUnary::Cosh => Operation::Function("cosh"),
        RealUnary::Tanh => Operation::Function("tanh"),
        RealUnary::Asinh => Operation::Function("asinh"),
        RealUnary::Acosh => Operation::Function("acosh"),
        RealUnary::Atanh => Operation::Function("atanh"),
        RealUnary::Sign => Operation::Function("sign"),
        RealUnary::Floor => Operation::Function("floor"),
        RealUnary::Ceil => Operation::Function("ceil"),
        RealUnary::Round => Operation::Function("round"),
        RealUnary::Trunc => Operation::Function("trunc"),
        RealUnary::Fract => Operation::Function("fract"),
        RealUnary::Radians => Operation::Function("radians"),
        RealUnary::Degrees => Operation::Function("degrees"),
        RealUnary::Quantize | RealUnary::FrexpFract => Operation::Other,
    }
}

fn binary(f: RealBinary) -> Operation {
    match f {
        RealBinary::Add => Operation::Add,
        RealBinary::Sub => Operation::Sub,
        RealBinary::Mul => Operation::Mul,
        RealBinary::Div => Operation::Div,
        RealBinary::Rem => Operation::Rem,
        RealBinary::Min => Operation::Min,
        RealBinary::Max => Operation::Max,
        RealBinary::Step => Operation::Edge,
        RealBinary::Pow => Operation::Pow,
        RealBinary::Atan2 => Operation::Function("atan"),
    }
}

fn ternary(f: RealTernary) -> Operation {
    match f {
        RealTernary::Fma => Operation::Fma,
        RealTernary::Mix => Operation::Mix,
        RealTernary::Clamp => Operation::Clamp,
        RealTernary::SmoothStep => Operation::SmoothStep,
    }
}
