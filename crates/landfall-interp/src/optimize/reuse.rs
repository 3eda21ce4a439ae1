//! Gives temporaries that are never needed at the same time one register, so that the columns of a
//! loop fit the processor's first cache.

use rustc_hash::{FxHashMap, FxHashSet};

use super::super::body::Body;
use super::super::code::{Class, Op, Reg, WriteRegion};
use super::{RegisterRole, registers};

/// The instructions from the first to the last at which a temporary is needed.
#[derive(Clone, Copy)]
struct LiveRange {
    from: usize,
    to: usize,
    /// The innermost loop around its first instruction.
    within: Option<usize>,
}

/// The instructions of a loop.
struct LoopRange {
    from: usize,
    to: usize,
    around: Option<usize>,
}

/// Numbers the temporaries of a function anew; `kept` share no register with others.
pub(super) fn reuse(body: &mut Body, kept: &FxHashSet<Reg>) {
    let mut spans = spans(body);
    spans.retain(|reg, _| !kept.contains(reg));
    // A linear scan: in the order of their starts, with the registers of those that ended.
    let mut starts: Vec<(usize, Reg)> = spans.iter().map(|(reg, span)| (span.from, *reg)).collect();
    let mut ends: Vec<(usize, Reg)> = spans.iter().map(|(reg, span)| (span.to, *reg)).collect();
    starts.sort_unstable();
    ends.sort_unstable();
    let mut ends = ends.into_iter().peekable();
    let mut numbers: FxHashMap<Reg, Reg> = FxHashMap::default();
    let mut free: [Vec<Reg>; 3] = Default::default();
    let mut counts = [0; 3];
    let mut next = |class: Class| {
        counts[class as usize] += 1;
        Reg::new(class, WriteRegion::Temporary, counts[class as usize] - 1)
    };
    for reg in kept {
        numbers.insert(*reg, next(reg.class()));
    }
    for (from, reg) in starts {
        // An instruction does not write what it reads.
        while let Some((_, ended)) = ends.next_if(|(to, _)| *to < from) {
            free[ended.class() as usize].push(numbers[&ended]);
        }
        let class = reg.class();
        let number = free[class as usize].pop().unwrap_or_else(|| next(class));
        numbers.insert(reg, number);
    }
    for inst in &body.code {
        registers(inst, |place, _| {
            let word = &mut body.pool[inst.at as usize + place];
            *word = numbers.get(&Reg(*word)).map_or(*word, |reg| reg.0);
        });
    }
    body.temporaries = counts;
}

/// Returns the span of each temporary. One from before a loop that reads it is needed up to the loop's
/// end; one that is read after a loop that writes it, from the loop's start.
fn spans(body: &Body) -> FxHashMap<Reg, LiveRange> {
    let loops = loops(body);
    let mut spans: FxHashMap<Reg, LiveRange> = FxHashMap::default();
    let mut next = 0;
    // From the outermost.
    let mut open: Vec<usize> = Vec::new();
    for (index, inst) in body.code.iter().enumerate() {
        match inst.op {
            Op::Loop => {
                open.push(next);
                next += 1;
            }
            Op::LoopEnd(_) => drop(open.pop()),
            _ => {}
        }
        registers(inst, |place, role| {
            let reg = Reg(body.pool[inst.at as usize + place]);
            if reg.region() != WriteRegion::Temporary {
                return;
            }
            // What a fused instruction reads is read by the next one.
            let index = index + usize::from(inst.fused && role == RegisterRole::Read);
            let within = open.last().copied();
            let span = spans.entry(reg).or_insert(LiveRange { from: index, to: index, within });
            // The outermost loop that begins after the value was written reads it in every
            // iteration.
            let reading = open.iter().map(|number| &loops[*number]).find(|l| l.from > span.from);
            span.to = span.to.max(reading.map_or(index, |reading| reading.to));
            while let Some(left) = span.within.map(|l| &loops[l]).filter(|l| l.to < index) {
                span.from = span.from.min(left.from);
                span.within = left.around;
            }
        });
    }
    spans
}

/// Returns the loops in the order of their starts.
fn loops(body: &Body) -> Vec<LoopRange> {
    let mut loops: Vec<LoopRange> = Vec::new();
    let mut open: Vec<usize> = Vec::new();
    for (index, inst) in body.code.iter().enumerate() {
        match inst.op {
            Op::Loop => {
                loops.push(LoopRange { from: index, to: index, around: open.last().copied() });
                open.push(loops.len() - 1);
            }
            Op::LoopEnd(_) => {
                let closed = open.pop().expect("a loop that ends began");
                loops[closed].to = index;
            }
            _ => {}
        }
    }
    loops
}
