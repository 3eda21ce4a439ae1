//! The edits between two fields that put the second where the shader reads it.
//!
//! Used by [`plan`](super::plan).

use super::library::MirrorWriter;
use super::plan::MirrorEnd;
use super::suggest::Suggestion;

/// A field between two that mirror members.
pub(super) struct PaddingField {
    pub name: String,
    pub offset: u64,
    pub size: u64,
    /// The finding about it, if its name does not say that it is padding.
    pub finding: Option<usize>,
}

/// The field before, which mirrors a member.
pub(super) struct Before {
    pub name: String,
    pub offset: u64,
    pub align: u64,
    /// Where what is in front of it ends.
    pub from: u64,
    pub smaller: Option<Suggestion>,
}

/// Where the fields so far end, once the helps so far are followed.
pub(super) struct Reach {
    writer: MirrorWriter,
    /// The end of the last field that mirrors a member.
    pub end: u64,
    pub before: Option<Before>,
    /// The fields behind it.
    pub pads: Vec<PaddingField>,
    /// The last of them that stays.
    pub kept: Option<String>,
    /// The largest alignment of the fields that no edit changes any more.
    pub align: u64,
    /// Where what is in front of the next field ends.
    pub from: u64,
}

impl Reach {
    pub fn new(writer: MirrorWriter, align: u64) -> Reach {
        Reach { writer, end: 0, before: None, pads: Vec::new(), kept: None, align, from: 0 }
    }

    pub fn largest_align(&self) -> u64 {
        self.before.as_ref().map_or(self.align, |before| before.align.max(self.align))
    }

    /// The end of all fields so far.
    pub fn cursor(&self) -> u64 {
        self.pads.last().map_or(self.end, |pad| pad.offset.saturating_add(pad.size))
    }

    /// Returns the padding that is needed behind the fields so far.
    pub fn gap(&self, wanted: u64, align: u64) -> Option<(u64, u64)> {
        let cursor = self.cursor();
        let natural = cursor.checked_next_multiple_of(align)?;
        (natural < wanted).then(|| (cursor, wanted - cursor))
    }

    /// Adds the edits that put a field of that alignment at a byte; returns the findings about
    /// fields that have to be removed for it.
    pub fn to(
        &mut self,
        wanted: u64,
        align: u64,
        name: &str,
        parts: &mut Vec<String>,
    ) -> Vec<usize> {
        let mut removed = Vec::new();
        let natural = |reach: &Reach| reach.cursor().checked_next_multiple_of(align);
        // Fields that push it too far are removed or shortened, the last first.
        let mut gone = Vec::new();
        while natural(self).is_none_or(|natural| natural > wanted) {
            let Some(pad) = self.pads.pop() else { break };
            match pad.finding {
                Some(finding) => removed.push(finding),
                None if pad.offset < wanted && self.writer == MirrorWriter::Memory => {
                    parts.push(resized(&pad.name, wanted - pad.offset));
                    self.pads.push(PaddingField { size: wanted - pad.offset, ..pad });
                }
                None => gone.push(format!("`{}`", pad.name)),
            }
        }
        if !gone.is_empty() {
            gone.reverse();
            parts.push(format!("remove {}", gone.join(" and ")));
        }
        // Nothing is left to remove: the field before is too large.
        if self.cursor() > wanted {
            let fits = |before: &&mut Before| {
                let smaller = before.smaller.as_ref();
                smaller.is_some_and(|smaller| before.offset + smaller.size <= wanted)
            };
            if let Some(before) = self.before.as_mut().filter(fits)
                && let Some(smaller) = before.smaller.take()
            {
                // Its alignment may have been what put it there.
                if before.from.next_multiple_of(smaller.align) < before.offset {
                    let padding = self.writer.padding(before.from, before.offset - before.from);
                    parts.push(format!("put {padding} before `{}`", before.name));
                }
                parts.push(format!(
                    "make `{}` `{}`: `{name}` follows directly in the shader",
                    before.name, smaller.text
                ));
                self.end = before.offset + smaller.size;
                before.align = smaller.align;
            }
        }
        self.align = self.largest_align();
        self.kept = self.pads.last().map(|pad| pad.name.clone());
        self.from = self.cursor();
        if let Some((at, gap)) = self.gap(wanted, align) {
            parts.push(self.fill(at, gap, wanted, name));
            self.from = wanted;
        }
        self.pads.clear();
        removed
    }

    /// The edit that adds so many bytes before a field.
    fn fill(&self, at: u64, gap: u64, wanted: u64, name: &str) -> String {
        let last = self.pads.last().filter(|pad| pad.finding.is_none());
        match (self.writer, last, &self.before) {
            (MirrorWriter::Memory, Some(pad), _) => resized(&pad.name, wanted - pad.offset),
            (MirrorWriter::Encase, _, Some(before)) => {
                let (last, from) = match self.pads.last() {
                    Some(pad) => (&pad.name, pad.offset),
                    None => (&before.name, before.offset),
                };
                format!("put `#[shader(size({}))]` before `{last}`", wanted - from)
            }
            (_, _, _) => format!("put {} before `{name}`", self.writer.padding(at, gap)),
        }
    }

    /// Returns the edit that gives the structure its size; `None` if it has it.
    pub fn tail(&mut self, end: MirrorEnd) -> Option<String> {
        let align = self.largest_align();
        let size = |reach: &Reach| reach.cursor().checked_next_multiple_of(align);
        let wanted = match end {
            MirrorEnd::Exactly(size) | MirrorEnd::AtLeast(size) => size,
            MirrorEnd::Free => return None,
        };
        let mut parts = Vec::new();
        // Only an element is made shorter: a longer structure fills a block as well.
        if end == MirrorEnd::Exactly(wanted) && wanted.is_multiple_of(align) {
            let mut gone = Vec::new();
            while size(self).is_none_or(|size| size > wanted) {
                let Some(pad) = self.pads.pop() else { break };
                if pad.offset < wanted && self.writer == MirrorWriter::Memory {
                    parts.push(resized(&pad.name, wanted - pad.offset));
                    self.pads.push(PaddingField { size: wanted - pad.offset, ..pad });
                } else {
                    gone.push(format!("`{}`", pad.name));
                }
            }
            if !gone.is_empty() {
                gone.reverse();
                parts.push(format!("remove {}", gone.join(" and ")));
            }
        }
        let cursor = self.cursor();
        if size(self).is_some_and(|size| size < wanted) {
            let last = self.pads.last().filter(|pad| pad.finding.is_none());
            parts.push(match (self.writer, last, &self.before) {
                (MirrorWriter::Memory, Some(pad), _) => resized(&pad.name, wanted - pad.offset),
                (MirrorWriter::Encase, last, Some(before)) => {
                    let (name, from) =
                        last.map_or((&before.name, before.offset), |pad| (&pad.name, pad.offset));
                    format!("put `#[shader(size({}))]` before `{name}`", wanted - from)
                }
                (_, _, _) => {
                    format!("end it with {}", self.writer.padding(cursor, wanted - cursor))
                }
            });
            self.end = wanted;
            self.pads.clear();
        }
        (!parts.is_empty()).then(|| parts.join(" and "))
    }
}

fn resized(name: &str, size: u64) -> String {
    format!("make `{name}` `[u8; {size}]`")
}
