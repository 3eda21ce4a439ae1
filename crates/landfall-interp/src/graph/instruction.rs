//! Turns an instruction into values.

use super::super::code::{Class, DerivativeAxis, Inst, Op, RealBinary, RealUnary, WordBinary};
use super::function::{CodeTooLarge, GraphBuilder};
use super::node::{NodeId, NodeOp};
use super::word;

impl GraphBuilder<'_> {
    /// Follows an instruction that computes, copies, loads or stores.
    pub(super) fn instruction(&mut self, inst: Inst) -> Result<(), CodeTooLarge> {
        let program = self.program;
        let from = inst.at as usize;
        let pool = &program.pool[from..from + inst.operands()];
        let (head, operands) = pool.split_at(usize::from(inst.head));
        let shape = inst.op.shape();
        match inst.op {
            Op::Load(access) => return self.load(access, head, operands),
            Op::StoreMemory(access) | Op::Atomic(access) => {
                let buffer = program.accesses[access as usize].buffer as usize;
                // What is read back later is any number.
                self.buffers[buffer] = &[];
                if let Op::Atomic(_) = inst.op {
                    let any = NodeOp::within(word::ANY_WORD.low, word::ANY_WORD.high);
                    for &to in &operands[..2] {
                        let id = self.node(any, Class::Word, &[])?;
                        self.set(Class::Word, to, id);
                    }
                }
                return Ok(());
            }
            Op::Gather(class, access) => return self.gather(class, access, head, operands),
            Op::Scatter(class, access) => return self.scatter(class, access, head, operands),
            Op::Sample | Op::Texel => return self.texels(operands),
            Op::ImageSize => return self.image_size(operands),
            Op::ArrayLength(_) => {
                let id = self.node(NodeOp::within(0.0, 4_294_967_295.0), Class::Word, &[])?;
                self.set(Class::Word, operands[0], id);
                return Ok(());
            }
            _ => {}
        }
        for group in operands.chunks_exact(shape.len().max(1)) {
            self.group(inst.op, &group[..shape.writes], &group[shape.writes..])?;
        }
        Ok(())
    }

    fn group(&mut self, op: Op, to: &[u32], from: &[u32]) -> Result<(), CodeTooLarge> {
        let most = f64::from(f32::MAX);
        let any_word = NodeOp::within(word::ANY_WORD.low, word::ANY_WORD.high);
        let (reads, class, act) = match op {
            Op::RealUnary(f) => (Class::Real, Class::Real, NodeOp::RealUnary(f)),
            Op::RealBinary(f) => (Class::Real, Class::Real, NodeOp::RealBinary(f)),
            Op::RealTernary(f) => (Class::Real, Class::Real, NodeOp::RealTernary(f)),
            Op::FCmp(cmp) => (Class::Real, Class::Word, NodeOp::Compare(cmp)),
            Op::FTest(test) => (Class::Real, Class::Word, NodeOp::Test(test)),
            Op::Dot(_) => (Class::Real, Class::Real, NodeOp::Dot),
            Op::Length(1) => (Class::Real, Class::Real, NodeOp::RealUnary(RealUnary::Abs)),
            Op::Length(_) => (Class::Real, Class::Real, NodeOp::Length),
            Op::Distance(n) => {
                if n == 1 {
                    let ids = [0, 1].map(|i| self.get(Class::Real, from[i]));
                    let between =
                        self.node(NodeOp::RealBinary(RealBinary::Sub), Class::Real, &ids)?;
                    let id =
                        self.node(NodeOp::RealUnary(RealUnary::Abs), Class::Real, &[between])?;
                    self.set(Class::Real, to[0], id);
                    return Ok(());
                }
                (Class::Real, Class::Real, NodeOp::Distance)
            }
            Op::Normalize(_) => return self.normalize(to, from),
            Op::Cross => return self.cross(to, from),
            Op::WordUnary(f) => (Class::Word, Class::Word, NodeOp::WordUnary(f)),
            Op::WordBinary(f) => (Class::Word, Class::Word, NodeOp::WordBinary(f)),
            Op::CmpSint(cmp) => (Class::Word, Class::Word, NodeOp::CompareWords(cmp, true)),
            Op::CmpUint(cmp) => (Class::Word, Class::Word, NodeOp::CompareWords(cmp, false)),
            Op::ExtractSint => (Class::Word, Class::Word, NodeOp::Extract(true)),
            Op::ExtractUint => (Class::Word, Class::Word, NodeOp::Extract(false)),
            Op::Ldexp => {
                let ids = [self.get(Class::Real, from[0]), self.get(Class::Word, from[1])];
                let id = self.node(NodeOp::Ldexp, Class::Real, &ids)?;
                self.set(Class::Real, to[0], id);
                return Ok(());
            }
            Op::Cast(cast) => {
                let (reads, writes) = cast.classes();
                (reads, writes, NodeOp::Cast(cast))
            }
            Op::Select(class) => {
                let [c, a, b] =
                    [0, 1, 2].map(|i| self.get(if i == 0 { Class::Word } else { class }, from[i]));
                // The same value either way is no choice.
                let id = if a == b { a } else { self.node(NodeOp::Select, class, &[c, a, b])? };
                self.set(class, to[0], id);
                return Ok(());
            }
            Op::Move(class) | Op::Undefined(class) | Op::Store(class) => {
                let id = self.get(class, from[0]);
                self.set(class, to[0], id);
                return Ok(());
            }
            Op::DerivativeFine(axis) | Op::DerivativeCoarse(axis) => {
                let low = if axis == DerivativeAxis::Width { 0.0 } else { -most };
                (Class::Real, Class::Real, NodeOp::within(low, most))
            }
            Op::Insert => (Class::Word, Class::Word, any_word),
            Op::DCmp(_) | Op::DCmpSint(_) | Op::DCmpUint(_) | Op::DTest(_) => {
                (Class::Wide, Class::Word, NodeOp::within(0.0, 1.0))
            }
            // Double precision and 64-bit integers are not followed.
            _ => (Class::Wide, Class::Wide, any_word),
        };
        let opaque = matches!(act, NodeOp::Within(..));
        // The fault that the operation is not followed.
        if class == Class::Wide || reads == Class::Wide {
            self.node(NodeOp::Unfollowed, Class::Word, &[])?;
        }
        let ids: Vec<NodeId> = match opaque {
            true => Vec::new(),
            false => from.iter().map(|&reg| self.get(reads, reg)).collect(),
        };
        let id = match act {
            NodeOp::WordBinary(f) => self.integer(f, &ids)?,
            _ => self.node(act, class, &ids)?,
        };
        self.set(class, to[0], id);
        Ok(())
    }

    /// Simplifies what conditions are made of.
    fn integer(&mut self, f: WordBinary, ids: &[NodeId]) -> Result<NodeId, CodeTooLarge> {
        if ids[0] == ids[1] && matches!(f, WordBinary::And | WordBinary::Or) {
            return Ok(ids[0]);
        }
        self.node(NodeOp::WordBinary(f), Class::Word, ids)
    }

    fn normalize(&mut self, to: &[u32], from: &[u32]) -> Result<(), CodeTooLarge> {
        let ids: Vec<NodeId> = from.iter().map(|&reg| self.get(Class::Real, reg)).collect();
        let mut unit = Vec::new();
        for (nth, _) in to.iter().enumerate() {
            unit.push(self.node(NodeOp::Normalize(nth as u8), Class::Real, &ids)?);
        }
        for (&to, &id) in to.iter().zip(&unit) {
            self.set(Class::Real, to, id);
        }
        // Equal vectors have the same nodes, which are a unit already.
        if !self.graph.unit_of.contains_key(&unit[0]) {
            self.unit(unit);
        }
        Ok(())
    }

    fn cross(&mut self, to: &[u32], from: &[u32]) -> Result<(), CodeTooLarge> {
        let ids: Vec<NodeId> = from.iter().map(|&reg| self.get(Class::Real, reg)).collect();
        let mut all = Vec::new();
        for nth in 0..3 {
            all.push(self.node(NodeOp::Cross(nth), Class::Real, &ids)?);
        }
        for (&to, id) in to.iter().zip(all) {
            self.set(Class::Real, to, id);
        }
        Ok(())
    }
}
