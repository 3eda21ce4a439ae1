//! Removes copies: a read of a variable becomes a read of what was stored there, a variable that
//! nothing reads is not stored, and an argument is computed where the callee expects it.
//!
//! What is known of a variable holds as long as every lane that reads it has stored it: up to the end
//! of the branch or loop, and from before one, if nothing in it writes the variable. Registers that
//! are indexed at run time keep their copies.

use rustc_hash::{FxHashMap, FxHashSet};

use super::super::body::{Body, Compiled};
use super::super::code::{Access, ElementCount, Op, Reg, WriteRegion};
use super::{RegisterRole, drop_unread, registers};

/// Removes the copies of a function; `accesses` are those of its indices, `interface` the registers
/// of its arguments and its result.
pub(super) fn remove_copies(body: &mut Body, accesses: &[Access], interface: &Compiled) {
    let indexed = indexed(body, accesses);
    let locals: FxHashSet<Reg> =
        body.locals.iter().copied().filter(|reg| !indexed.contains(reg)).collect();
    let fixed = fixed(body, &indexed, interface);
    let own: FxHashSet<Reg> = locals.union(&fixed).copied().collect();
    let kept = TrackedRegisters { indexed: &indexed, fixed: &fixed, own: &own };
    // What is not read any more may have been the last reader of something else.
    for _ in 0..ROUNDS {
        forward(body, &kept);
        if !drop_unread_locals(body, &locals) {
            break;
        }
        drop_unread(body);
    }
    drop_first_values(body, &locals);
    compute_in_place(body, &indexed, &interface.result);
    drop_unread(body);
}

/// Returns the arguments that a function does not write.
fn fixed(body: &Body, indexed: &FxHashSet<Reg>, interface: &Compiled) -> FxHashSet<Reg> {
    let arguments = interface.arguments.iter().flat_map(|argument| argument.regs.iter());
    let mut fixed: FxHashSet<Reg> =
        arguments.copied().filter(|reg| !indexed.contains(reg)).collect();
    for inst in &body.code {
        registers(inst, |place, role| {
            if role == RegisterRole::Write {
                fixed.remove(&Reg(body.pool[inst.at as usize + place]));
            }
        });
    }
    fixed
}

/// Copies of copies of copies are rare.
const ROUNDS: usize = 4;

/// Returns the variables that instructions find by an index.
fn indexed(body: &Body, accesses: &[Access]) -> FxHashSet<Reg> {
    let mut all = FxHashSet::default();
    for inst in &body.code {
        let (Op::Gather(class, access) | Op::Scatter(class, access)) = inst.op else { continue };
        // Registers from the first element's to the last one's.
        let reach = |dynamic: &super::super::code::Dynamic| match dynamic.bound {
            ElementCount::Known(len) => len.saturating_sub(1) * dynamic.strides[class as usize],
            ElementCount::Runtime { .. } => 0,
        };
        let last: u32 = accesses[access as usize].dynamics.iter().map(reach).sum();
        let from = inst.at as usize + usize::from(inst.head);
        for group in body.pool[from..from + 2 * inst.groups as usize].chunks_exact(2) {
            all.extend((0..=last).map(|i| Reg(group[1] + i)));
        }
    }
    all
}

/// Whether an instruction leaves the active lanes as they are, or a part of them.
fn keeps_lanes(op: Op) -> bool {
    let empty = matches!(op, Op::Nop | Op::Inlined(_) | Op::Sampled | Op::Barrier);
    op.shape().len() > 0 || empty || matches!(op, Op::If(_) | Op::Call(_))
}

/// What happens in a branch, loop or switch.
#[derive(Default)]
struct Construct {
    /// The variables that are written.
    written: FxHashSet<Reg>,
    /// Whether functions are called.
    calls: bool,
}

/// Returns the constructs by the instruction that opens each.
fn constructs(body: &Body) -> FxHashMap<usize, Construct> {
    let mut all = FxHashMap::default();
    let mut open: Vec<(usize, Construct)> = Vec::new();
    for (index, inst) in body.code.iter().enumerate() {
        match inst.op {
            Op::If(_) | Op::Loop | Op::Switch => open.push((index, Construct::default())),
            Op::EndIf(_) | Op::LoopEnd(_) | Op::SwitchEnd(_) => {
                let (opened, inner) = open.pop().expect(PAIRED);
                // What an inner construct writes, the outer one writes, too.
                if let Some((_, outer)) = open.last_mut() {
                    outer.written.extend(&inner.written);
                    outer.calls |= inner.calls;
                }
                all.insert(opened, inner);
            }
            op => {
                let Some((_, construct)) = open.last_mut() else { continue };
                construct.calls |= matches!(op, Op::Call(_));
                registers(inst, |place, role| {
                    let reg = Reg(body.pool[inst.at as usize + place]);
                    if role == RegisterRole::Write && reg.region() == WriteRegion::Variable {
                        construct.written.insert(reg);
                    }
                });
            }
        }
    }
    all
}

const PAIRED: &str = "every construct that is opened is closed";

/// The registers whose values are known in a function.
struct TrackedRegisters<'a> {
    /// Registers that are found by an index, of which nothing is known.
    indexed: &'a FxHashSet<Reg>,
    /// Arguments that the function does not write.
    fixed: &'a FxHashSet<Reg>,
    /// The variables that no callee writes: fixed arguments and local variables.
    own: &'a FxHashSet<Reg>,
}

impl TrackedRegisters<'_> {
    /// Whether a register may get another value.
    fn changes(&self, reg: Reg) -> bool {
        reg.region() == WriteRegion::Variable && !self.fixed.contains(&reg)
    }
}

/// What is known of registers at an instruction, in the lanes that are active there.
#[derive(Default)]
struct KnownRegisters {
    /// By temporary: the register that it copies, for good.
    copied: FxHashMap<Reg, Reg>,
    /// By variable: what was stored there, and is unchanged since.
    stored: FxHashMap<Reg, Reg>,
    /// By temporary: the variable that it copies, unchanged since.
    read: FxHashMap<Reg, Reg>,
    /// By variable: those of which `read` and `stored` say that they copy it.
    readers: FxHashMap<Reg, Vec<Reg>>,
    /// The samples of the blocks around the instruction, by their colours and by their operands.
    samples: Vec<([Reg; 4], [Reg; 3])>,
    /// The number of samples before each block.
    before: Vec<usize>,
}

impl KnownRegisters {
    fn source(&self, reg: Reg) -> Reg {
        // One step suffices: what is recorded is the source of the source.
        let copied = self.copied.get(&reg).or_else(|| self.read.get(&reg));
        copied.or_else(|| self.stored.get(&reg)).copied().unwrap_or(reg)
    }

    /// Forgets what a variable held.
    fn overwrite(&mut self, variable: Reg) {
        self.stored.remove(&variable);
        for reader in self.readers.remove(&variable).unwrap_or_default() {
            self.read.remove(&reader);
            if self.stored.get(&reader) == Some(&variable) {
                self.stored.remove(&reader);
            }
        }
    }

    /// Forgets what a construct may overwrite.
    fn pass(&mut self, construct: &Construct, kept: &TrackedRegisters<'_>) {
        construct.written.iter().for_each(|variable| self.overwrite(*variable));
        if construct.calls {
            self.call(kept);
        }
    }

    /// Forgets what a callee may overwrite.
    fn call(&mut self, kept: &TrackedRegisters<'_>) {
        let changes = |reg: &Reg| reg.region() == WriteRegion::Variable && !kept.own.contains(reg);
        self.stored.retain(|variable, source| !changes(variable) && !changes(source));
        self.readers.retain(|variable, _| !changes(variable));
        self.read.retain(|_, variable| !changes(variable));
    }

    /// Returns whether a texture was sampled at the same place before, for good; its colours are then
    /// those of that sample.
    fn sample(&mut self, operands: &[u32], kept: &TrackedRegisters<'_>) -> bool {
        let &[r, g, b, a, image, u, v] = operands else { return false };
        let (colors, from) = ([r, g, b, a].map(Reg), [image, u, v].map(Reg));
        if from.iter().any(|reg| kept.changes(*reg)) {
            return false;
        }
        match self.samples.iter().find(|(_, known)| *known == from) {
            Some((known, _)) => self.copied.extend(colors.into_iter().zip(*known)),
            None => {
                self.samples.push((colors, from));
                return false;
            }
        }
        true
    }

    fn copy(&mut self, to: Reg, from: Reg, kept: &TrackedRegisters<'_>) {
        let from = self.source(from);
        let changes = kept.changes(from);
        if to == from || [to, from].iter().any(|reg| kept.indexed.contains(reg)) {
            return;
        }
        match to.region() {
            WriteRegion::Temporary if changes => self.read.insert(to, from),
            WriteRegion::Temporary => self.copied.insert(to, from),
            _ => self.stored.insert(to, from),
        };
        if changes {
            self.readers.entry(from).or_default().push(to);
        }
    }
}

/// Replaces reads of copies by reads of what they copy.
fn forward(body: &mut Body, kept: &TrackedRegisters<'_>) {
    let constructs = constructs(body);
    let mut known = KnownRegisters::default();
    let mut open: Vec<&Construct> = Vec::new();
    for (index, inst) in body.code.iter_mut().enumerate() {
        let shape = inst.op.shape();
        let start = inst.at as usize;
        let (head, groups) = (start + usize::from(inst.head), inst.groups as usize);
        for place in start..head {
            body.pool[place] = known.source(Reg(body.pool[place])).0;
        }
        match inst.op {
            Op::If(_) | Op::Switch | Op::Loop => {
                known.before.push(known.samples.len());
                open.push(&constructs[&index]);
                // What the end of a loop writes, its start reads.
                if inst.op == Op::Loop {
                    known.pass(&constructs[&index], kept);
                }
            }
            // The lanes are others than those of the instructions before.
            Op::Else(_) | Op::Continuing(_) | Op::Case(_) | Op::CaseEnd => {
                known.samples.truncate(*known.before.last().expect(PAIRED));
                known.pass(open.last().expect(PAIRED), kept);
            }
            Op::EndIf(_) | Op::LoopEnd(_) | Op::SwitchEnd(_) => {
                known.samples.truncate(known.before.pop().expect(PAIRED));
                known.pass(open.pop().expect(PAIRED), kept);
            }
            Op::Call(_) => known.call(kept),
            _ => {}
        }
        for group in 0..groups {
            let at = head + group * shape.len();
            for place in at + shape.writes..at + shape.writes + shape.reads {
                body.pool[place] = known.source(Reg(body.pool[place])).0;
            }
            for place in at..at + shape.writes {
                known.overwrite(Reg(body.pool[place]));
            }
            // This holds in the active lanes alone; where others become active, `pass` forgets it.
            if let Op::Move(_) | Op::Store(_) = inst.op {
                known.copy(Reg(body.pool[at]), Reg(body.pool[at + 1]), kept);
            }
        }
        let operands = &body.pool[head..head + groups * shape.len()];
        if inst.op == Op::Sample && known.sample(operands, kept) {
            inst.op = Op::Sampled;
        }
    }
}

/// Removes the first value of a local variable that is stored before it is read, in the same
/// block: a lane that leaves the block before the store does not read the variable either.
fn drop_first_values(body: &mut Body, locals: &FxHashSet<Reg>) {
    /// The first use of a variable after that value.
    #[derive(Clone, Copy, PartialEq)]
    enum First {
        None { block: usize },
        Overwritten,
        Read,
    }
    let mut first: FxHashMap<Reg, First> = FxHashMap::default();
    // Blocks by the instruction before them; before the function's own there is none.
    let mut open = vec![usize::MAX];
    for (index, inst) in body.code.iter().enumerate() {
        match inst.op {
            Op::If(_) | Op::Loop | Op::Switch => open.push(index),
            Op::Else(_) | Op::Continuing(_) | Op::Case(_) | Op::CaseEnd => {
                *open.last_mut().expect(PAIRED) = index;
            }
            Op::EndIf(_) | Op::LoopEnd(_) | Op::SwitchEnd(_) => drop(open.pop()),
            _ => {}
        }
        let block = *open.last().expect(PAIRED);
        // Stores, and nothing else, write a variable again.
        let is_first = is_first_value(inst.op);
        // All reads of an instruction are before its writes.
        for role in [RegisterRole::Read, RegisterRole::Write] {
            registers(inst, |place, of| {
                let reg = Reg(body.pool[inst.at as usize + place]);
                match first.get(&reg) {
                    None if is_first
                        && of == role
                        && role == RegisterRole::Write
                        && locals.contains(&reg) =>
                    {
                        first.insert(reg, First::None { block });
                    }
                    Some(&First::None { block: before }) if of == role => {
                        let whole = role == RegisterRole::Write && block == before && !is_first;
                        first.insert(reg, if whole { First::Overwritten } else { First::Read });
                    }
                    _ => {}
                }
            });
        }
    }
    retain_copies(body, |op, to, _| {
        !is_first_value(op) || first.get(&to) != Some(&First::Overwritten)
    });
}

fn is_first_value(op: Op) -> bool {
    matches!(op, Op::Undefined(_) | Op::Move(_))
}

/// Removes the stores of local variables that nothing reads; returns whether there were any.
fn drop_unread_locals(body: &mut Body, locals: &FxHashSet<Reg>) -> bool {
    let mut read: FxHashSet<Reg> = FxHashSet::default();
    for inst in &body.code {
        registers(inst, |place, role| {
            if role == RegisterRole::Read {
                read.insert(Reg(body.pool[inst.at as usize + place]));
            }
        });
    }
    retain_copies(body, |_, to, _| !locals.contains(&to) || read.contains(&to))
}

/// Removes the copies, stores and zeros, by their registers, that are not to be kept; returns whether
/// there were any.
fn retain_copies(body: &mut Body, keep: impl Fn(Op, Reg, Reg) -> bool) -> bool {
    let mut dropped = false;
    for inst in &mut body.code {
        let (Op::Move(_) | Op::Store(_) | Op::Undefined(_)) = inst.op else { continue };
        let start = inst.at as usize;
        let mut kept = 0;
        for at in (0..inst.groups as usize).map(|group| start + 2 * group) {
            if keep(inst.op, Reg(body.pool[at]), Reg(body.pool[at + 1])) {
                body.pool.copy_within(at..at + 2, start + 2 * kept);
                kept += 1;
            } else {
                dropped = true;
            }
        }
        inst.groups = kept as u32;
        if kept == 0 {
            inst.op = Op::Nop;
        }
    }
    dropped
}

/// The instruction that computes a temporary, and where its pool names it.
struct Producer {
    index: usize,
    place: usize,
}

/// Writes temporaries that are only copied, to an argument or a result, there at once.
fn compute_in_place(body: &mut Body, indexed: &FxHashSet<Reg>, results: &[Reg]) {
    let mut reads: FxHashMap<Reg, u32> = FxHashMap::default();
    let mut stores: FxHashMap<Reg, u32> = FxHashMap::default();
    for inst in &body.code {
        registers(inst, |place, role| {
            let reg = Reg(body.pool[inst.at as usize + place]);
            match role {
                RegisterRole::Read => *reads.entry(reg).or_default() += 1,
                RegisterRole::Write => *stores.entry(reg).or_default() += 1,
            }
        });
    }
    let mut loops = 0u32;
    // Since the active lanes last changed: producers, and by variable the last instruction that
    // uses it.
    let mut producers: FxHashMap<Reg, Producer> = FxHashMap::default();
    let mut used: FxHashMap<Reg, usize> = FxHashMap::default();
    for index in 0..body.code.len() {
        let inst = body.code[index];
        match inst.op {
            Op::Loop => loops += 1,
            Op::LoopEnd(_) => loops -= 1,
            _ => {}
        }
        // A callee reads and writes its own.
        if !keeps_lanes(inst.op) || matches!(inst.op, Op::Call(_) | Op::If(_)) {
            producers.clear();
            used.clear();
            continue;
        }
        let start = inst.at as usize;
        if let Op::Move(_) | Op::Store(_) = inst.op {
            for at in (0..inst.groups as usize).map(|group| start + 2 * group) {
                let (to, from) = (Reg(body.pool[at]), Reg(body.pool[at + 1]));
                // The lanes that do not store are those that return nothing.
                let whole = match inst.op {
                    Op::Move(_) => true,
                    _ => loops == 0 && stores[&to] == 1 && results.contains(&to),
                };
                let alone = to.region() == WriteRegion::Variable
                    && !indexed.contains(&to)
                    && reads.get(&from) == Some(&1);
                let producer = producers.get(&from).filter(|_| whole && alone);
                if let Some(producer) = producer {
                    // An instruction after the producer that uses the target would meet the new
                    // value too early.
                    if used.get(&to).is_none_or(|last| *last < producer.index) {
                        body.pool[producer.place] = to.0;
                        // The copy of a register to itself does nothing.
                        body.pool[at + 1] = to.0;
                    }
                }
                used.insert(to, index);
                used.insert(from, index);
            }
            continue;
        }
        registers(&inst, |place, role| {
            let reg = Reg(body.pool[start + place]);
            let computes = inst.op.computes_reals() || matches!(inst.op, Op::Load(_));
            if role == RegisterRole::Write && reg.region() == WriteRegion::Temporary && computes {
                producers.insert(reg, Producer { index, place: start + place });
            }
            used.insert(reg, index);
        });
    }
    retain_copies(body, |_, to, from| to != from);
}
