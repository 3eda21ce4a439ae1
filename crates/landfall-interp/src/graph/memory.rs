//! Loads, stores and texture reads while a function is followed.

use super::super::code::{Access, Class, Cmp, Stored, WordBinary};
use super::super::machine::elements;
use super::exact;
use super::function::{CodeTooLarge, Followed, GraphBuilder};
use super::node::{NodeId, NodeOp};
use super::word;

/// An element: the offset of its registers or bytes, and the values that the indices then have.
type Element = (usize, Vec<(NodeId, u32)>);

/// The most elements that an index is followed to.
const ELEMENTS: usize = 256;

impl GraphBuilder<'_> {
    /// Returns the elements that indices may name; `None` if they are too many.
    fn elements(
        &mut self,
        access: &Access,
        head: &[u32],
        class: usize,
    ) -> Followed<Option<Vec<Element>>> {
        // Every combination of the values that the indices may have.
        let mut all = vec![(0usize, Vec::new())];
        for (&reg, dynamic) in head.iter().zip(&access.dynamics) {
            let index = self.get(Class::Word, reg);
            let bytes = self.buffers.get(access.buffer as usize).map_or(0, |b| b.len());
            let len = elements(dynamic.bound, bytes);
            // For its fault: an index outside of the elements.
            self.node(NodeOp::Index(len), Class::Word, &[index])?;
            let seen = self.bounds.values[index as usize];
            let range = word::signed(seen, false);
            let last = f64::from(len.saturating_sub(1));
            let (low, high) =
                (range.low.clamp(0.0, last) as u32, range.high.clamp(0.0, last) as u32);
            if exact::is_empty(range) || all.len() * (high - low + 1) as usize > ELEMENTS {
                return Ok(None);
            }
            let stride = dynamic.strides[class] as usize;
            let mut next = Vec::new();
            for (offset, at) in &all {
                for value in low..=high {
                    let mut at: Vec<(NodeId, u32)> = at.clone();
                    at.push((index, value));
                    next.push((offset + value as usize * stride, at));
                }
            }
            all = next;
        }
        Ok(Some(all))
    }

    /// Returns a condition that indices have values.
    fn indexed(&mut self, at: &[(NodeId, u32)]) -> Result<Option<NodeId>, CodeTooLarge> {
        let mut all = None;
        for &(index, value) in at {
            let value = self.constant(Class::Word, f64::from(value as i32))?;
            let same =
                self.node(NodeOp::CompareWords(Cmp::Eq, false), Class::Word, &[index, value])?;
            all = Some(match all {
                None => same,
                Some(before) => {
                    let and = NodeOp::WordBinary(WordBinary::And);
                    self.node(and, Class::Word, &[before, same])?
                }
            });
        }
        Ok(all)
    }

    fn anything(&mut self, class: Class) -> Result<NodeId, CodeTooLarge> {
        let most = f64::from(f32::MAX);
        // With the fault that it is not followed.
        self.node(NodeOp::Unfollowed, Class::Word, &[])?;
        let act = match class {
            Class::Real => NodeOp::within(-most, most),
            Class::Word | Class::Wide => NodeOp::within(word::ANY_WORD.low, word::ANY_WORD.high),
        };
        self.node(act, class, &[])
    }

    pub(super) fn gather(
        &mut self,
        class: Class,
        access: u32,
        head: &[u32],
        operands: &[u32],
    ) -> Result<(), CodeTooLarge> {
        let access = self.program.accesses[access as usize].clone();
        let elements = self.elements(&access, head, class as usize)?;
        for group in operands.chunks_exact(2) {
            let id = match &elements {
                None => self.anything(class)?,
                Some(all) => {
                    let mut found = None;
                    // The last stands for an index past the end, too.
                    for (offset, at) in all.iter().rev() {
                        let element = self.get(class, group[1] + *offset as u32);
                        found = Some(match (found, self.indexed(at)?) {
                            (Some(other), Some(same)) if other != element => {
                                self.node(NodeOp::Select, class, &[same, element, other])?
                            }
                            (_, _) => element,
                        });
                    }
                    match found {
                        Some(id) => id,
                        None => self.anything(class)?,
                    }
                }
            };
            self.set(class, group[0], id);
        }
        Ok(())
    }

    pub(super) fn scatter(
        &mut self,
        class: Class,
        access: u32,
        head: &[u32],
        operands: &[u32],
    ) -> Result<(), CodeTooLarge> {
        let access = self.program.accesses[access as usize].clone();
        // A store to one of very many elements would make every one of them a choice.
        let Some(all) = self.elements(&access, head, class as usize)? else {
            return Err(CodeTooLarge);
        };
        let single = all.len() == 1;
        for group in operands.chunks_exact(2) {
            let value = self.get(class, group[0]);
            for (offset, at) in &all {
                let reg = group[1] + *offset as u32;
                let before = self.get(class, reg);
                let id = match self.indexed(at)? {
                    Some(same) if !single => {
                        self.node(NodeOp::Select, class, &[same, value, before])?
                    }
                    _ => value,
                };
                self.set(class, reg, id);
            }
        }
        Ok(())
    }

    pub(super) fn load(
        &mut self,
        access: u32,
        head: &[u32],
        operands: &[u32],
    ) -> Result<(), CodeTooLarge> {
        let access = self.program.accesses[access as usize].clone();
        let elements = self.elements(&access, head, 0)?;
        let bytes = self.buffers[access.buffer as usize];
        for group in operands.chunks_exact(3) {
            let stored = Stored::ALL[group[2] as usize];
            let class = stored.class();
            let number = |offset: usize| number(bytes, group[1] as usize + offset, stored);
            // A buffer that was written is empty here, so that its numbers are not known.
            let all: Option<Vec<f64>> =
                elements.as_ref().and_then(|all| all.iter().map(|(at, _)| number(*at)).collect());
            let id = match all.as_deref() {
                Some([one]) => self.constant(class, *one)?,
                Some(all) if !all.is_empty() => {
                    let low = all.iter().copied().fold(f64::INFINITY, f64::min);
                    let high = all.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                    self.node(NodeOp::within(low, high), class, &[])?
                }
                _ => self.anything(class)?,
            };
            self.set(class, group[0], id);
        }
        Ok(())
    }

    /// Reads a texture: any colour from its least to its greatest texel.
    pub(super) fn texels(&mut self, operands: &[u32]) -> Result<(), CodeTooLarge> {
        let most = f64::from(f32::MAX);
        let number = self.bounds.values[self.get(Class::Word, operands[4]) as usize];
        // Which texture it is may depend on the inputs.
        let image = match number.low == number.high {
            true => self.images.get(number.low as usize).copied(),
            false => None,
        };
        for (channel, &to) in operands[..4].iter().enumerate() {
            let texels = image.iter().flat_map(|image| image.texels);
            // A lookup outside of the texture gives zero.
            let all = texels.map(|texel| f64::from(texel[channel])).chain([0.0]);
            let (low, high) = match image {
                Some(_) => all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
                    (low.min(x), high.max(x))
                }),
                None => (-most, most),
            };
            let id = self.node(NodeOp::within(low, high), Class::Real, &[])?;
            self.set(Class::Real, to, id);
        }
        Ok(())
    }

    pub(super) fn image_size(&mut self, operands: &[u32]) -> Result<(), CodeTooLarge> {
        for &to in &operands[..2] {
            let id = self.node(NodeOp::within(0.0, 65536.0), Class::Word, &[])?;
            self.set(Class::Word, to, id);
        }
        Ok(())
    }
}

/// Returns a number of a buffer; `None` past its end, and for what is not finite.
fn number(bytes: &[u8], at: usize, stored: Stored) -> Option<f64> {
    let from = bytes.get(at..at + stored.width())?;
    let mut word = [0; 8];
    word[..from.len()].copy_from_slice(from);
    let bits = u64::from_le_bytes(word);
    let number = match stored {
        Stored::F32 => f64::from(f32::from_bits(bits as u32)),
        Stored::F16 => half::f16::from_bits(bits as u16).to_f64(),
        Stored::B32 => f64::from(bits as u32 as i32),
        Stored::I16 => f64::from(bits as u16 as i16),
        Stored::U16 => f64::from(bits as u16),
        Stored::Bool => f64::from(u8::from(bits != 0)),
        Stored::B64 => return None,
    };
    number.is_finite().then_some(number)
}
