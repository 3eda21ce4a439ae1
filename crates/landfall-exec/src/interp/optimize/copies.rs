//! Removes copies: a read of a variable becomes a read of what was stored there, a variable that
//! nothing reads is not stored, and an argument is computed where the callee expects it.
//!
//! What is known of variables holds from one change of the active lanes to the next, where a lane
//! that stores is a lane that reads. Registers that are indexed at run time keep their copies.

use rustc_hash::{FxHashMap, FxHashSet};

use super::super::body::Body;
use super::super::code::{Access, ElementCount, Op, Reg, Region};
use super::{Role, drop_unread, registers};

/// Removes the copies of a function; `accesses` are those of its indices, `results` the registers
/// that it returns.
pub(super) fn remove_copies(body: &mut Body, accesses: &[Access], results: &[Reg]) {
    let indexed = indexed(body, accesses);
    let locals: FxHashSet<Reg> =
        body.locals.iter().copied().filter(|reg| !indexed.contains(reg)).collect();
    // What is not read any more may have been the last reader of something else.
    for _ in 0..ROUNDS {
        forward(body, &indexed, &locals);
        if !drop_unread_locals(body, &locals) {
            break;
        }
        drop_unread(body);
    }
    compute_in_place(body, &indexed, results);
    drop_unread(body);
}

/// Copies of copies of copies are rare.
const ROUNDS: usize = 4;

/// Returns the variables that instructions find by an index.
fn indexed(body: &Body, accesses: &[Access]) -> FxHashSet<Reg> {
    let mut all = FxHashSet::default();
    for inst in &body.code {
        let (Op::Gather(class, access) | Op::Scatter(class, access)) = inst.op else { continue };
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
    op.shape().len() > 0 || matches!(op, Op::Nop | Op::If(_) | Op::Call(_) | Op::Barrier)
}

/// What is known of registers at an instruction.
#[derive(Default)]
struct Known {
    /// By temporary: the register that it copies, for good.
    copied: FxHashMap<Reg, Reg>,
    /// By variable: the temporary or constant that was stored there.
    stored: FxHashMap<Reg, Reg>,
    /// By temporary: the variable that it copies, unchanged since, and the reverse.
    read: FxHashMap<Reg, Reg>,
    readers: FxHashMap<Reg, Vec<Reg>>,
}

impl Known {
    fn source(&self, reg: Reg) -> Reg {
        self.copied.get(&reg).or_else(|| self.read.get(&reg)).copied().unwrap_or(reg)
    }

    fn forget(&mut self) {
        self.stored.clear();
        self.read.clear();
        self.readers.clear();
    }

    /// Forgets what a variable held.
    fn overwrite(&mut self, variable: Reg) {
        self.stored.remove(&variable);
        for reader in self.readers.remove(&variable).unwrap_or_default() {
            self.read.remove(&reader);
        }
    }

    /// Forgets what a callee may overwrite.
    fn call(&mut self, locals: &FxHashSet<Reg>) {
        self.stored.retain(|variable, _| locals.contains(variable));
        self.readers.retain(|variable, _| locals.contains(variable));
        self.read.retain(|_, variable| locals.contains(variable));
    }

    fn copy(&mut self, to: Reg, from: Reg, indexed: &FxHashSet<Reg>) {
        match (to.region(), from.region()) {
            (Region::Temporary, Region::Variable) if !indexed.contains(&from) => {
                match self.stored.get(&from) {
                    Some(&source) => {
                        self.copied.insert(to, source);
                    }
                    None => {
                        self.read.insert(to, from);
                        self.readers.entry(from).or_default().push(to);
                    }
                }
            }
            (Region::Temporary, Region::Temporary | Region::Constant) => {
                self.copied.insert(to, from);
            }
            (Region::Variable, Region::Temporary | Region::Constant) if !indexed.contains(&to) => {
                self.stored.insert(to, from);
            }
            _ => {}
        }
    }
}

/// Replaces reads of copies by reads of what they copy.
fn forward(body: &mut Body, indexed: &FxHashSet<Reg>, locals: &FxHashSet<Reg>) {
    let mut known = Known::default();
    for inst in &body.code {
        if !keeps_lanes(inst.op) {
            known.forget();
        }
        let shape = inst.op.shape();
        let start = inst.at as usize;
        let (head, groups) = (start + usize::from(inst.head), inst.groups as usize);
        for place in start..head {
            body.pool[place] = known.source(Reg(body.pool[place])).0;
        }
        for group in 0..groups {
            let at = head + group * shape.len();
            for place in at + shape.writes..at + shape.writes + shape.reads {
                body.pool[place] = known.source(Reg(body.pool[place])).0;
            }
            for place in at..at + shape.writes {
                known.overwrite(Reg(body.pool[place]));
            }
            if let Op::Move(_) | Op::Store(_) = inst.op {
                known.copy(Reg(body.pool[at]), Reg(body.pool[at + 1]), indexed);
            }
        }
        if let Op::Call(_) = inst.op {
            known.call(locals);
        }
    }
}

/// Removes the stores of local variables that nothing reads; returns whether there were any.
fn drop_unread_locals(body: &mut Body, locals: &FxHashSet<Reg>) -> bool {
    let mut read: FxHashSet<Reg> = FxHashSet::default();
    for inst in &body.code {
        registers(inst, |place, role| {
            if role == Role::Read {
                read.insert(Reg(body.pool[inst.at as usize + place]));
            }
        });
    }
    let mut dropped = false;
    for inst in &mut body.code {
        let (Op::Move(_) | Op::Store(_) | Op::Blank(_)) = inst.op else { continue };
        let start = inst.at as usize;
        let mut kept = 0;
        for group in 0..inst.groups as usize {
            let at = start + 2 * group;
            let to = Reg(body.pool[at]);
            if locals.contains(&to) && !read.contains(&to) {
                dropped = true;
            } else {
                body.pool.copy_within(at..at + 2, start + 2 * kept);
                kept += 1;
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
                Role::Read => *reads.entry(reg).or_default() += 1,
                Role::Write => *stores.entry(reg).or_default() += 1,
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
                let alone = to.region() == Region::Variable
                    && !indexed.contains(&to)
                    && reads.get(&from) == Some(&1);
                let producer = producers.get(&from).filter(|_| whole && alone);
                if let Some(producer) = producer {
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
            if role == Role::Write && reg.region() == Region::Temporary && computes {
                producers.insert(reg, Producer { index, place: start + place });
            }
            used.insert(reg, index);
        });
    }
    drop_copies_to_themselves(body);
}

fn drop_copies_to_themselves(body: &mut Body) {
    for inst in &mut body.code {
        let (Op::Move(_) | Op::Store(_)) = inst.op else { continue };
        let start = inst.at as usize;
        let mut kept = 0;
        for at in (0..inst.groups as usize).map(|group| start + 2 * group) {
            if body.pool[at] != body.pool[at + 1] {
                body.pool.copy_within(at..at + 2, start + 2 * kept);
                kept += 1;
            }
        }
        inst.groups = kept as u32;
        if kept == 0 {
            inst.op = Op::Nop;
        }
    }
}
