//! The edits between two fields that put the second where the shader reads it.
//!
//! Used by [`plan`](super::plan).

use super::library::Writer;
use super::plan::End;

/// A field between two that mirror members.
pub(super) struct Padding {
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
    /// A smaller type that fits, and its size.
    pub size: Option<(String, u64)>,
}

/// Where the fields so far end, once the helps so far are followed.
pub(super) struct Reach {
    writer: Writer,
    /// The end of the last field that mirrors a member.
    pub end: u64,
    pub before: Option<Before>,
    /// The fields behind it.
    pub pads: Vec<Padding>,
    /// The last of them that stays.
    pub kept: Option<String>,
}

impl Reach {
    pub fn new(writer: Writer) -> Reach {
        Reach { writer, end: 0, before: None, pads: Vec::new(), kept: None }
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
                None if pad.offset < wanted && self.writer == Writer::Memory => {
                    parts.push(resized(&pad.name, wanted - pad.offset));
                    self.pads.push(Padding { size: wanted - pad.offset, ..pad });
                }
                None => gone.push(format!("`{}`", pad.name)),
            }
        }
        if !gone.is_empty() {
            gone.reverse();
            parts.push(format!("remove {}", gone.join(" and ")));
        }
        if self.cursor() > wanted {
            let smaller = self.before.as_ref().and_then(|before| {
                let (text, size) = before.size.as_ref()?;
                let end = before.offset + size;
                (end <= wanted).then(|| (before.name.clone(), text.clone(), end))
            });
            if let Some((before, text, end)) = smaller {
                parts.push(format!(
                    "make `{before}` `{text}`: `{name}` follows directly in the shader"
                ));
                self.end = end;
            }
        }
        self.kept = self.pads.last().map(|pad| pad.name.clone());
        if let Some((at, gap)) = self.gap(wanted, align) {
            parts.push(self.fill(at, gap, wanted, name));
        }
        self.pads.clear();
        removed
    }

    /// The edit that adds so many bytes before a field.
    fn fill(&self, at: u64, gap: u64, wanted: u64, name: &str) -> String {
        let last = self.pads.last().filter(|pad| pad.finding.is_none());
        match (self.writer, last, &self.before) {
            (Writer::Memory, Some(pad), _) => resized(&pad.name, wanted - pad.offset),
            (Writer::Encase, _, Some(before)) => {
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
    pub fn tail(&mut self, end: End, align: u64) -> Option<String> {
        let size = |reach: &Reach| reach.cursor().checked_next_multiple_of(align);
        let wanted = match end {
            End::Exactly(size) | End::AtLeast(size) => size,
            End::Free => return None,
        };
        let mut parts = Vec::new();
        if end == End::Exactly(wanted) && wanted.is_multiple_of(align) {
            let mut gone = Vec::new();
            while size(self).is_none_or(|size| size > wanted) {
                let Some(pad) = self.pads.pop() else { break };
                if pad.offset < wanted && self.writer == Writer::Memory {
                    parts.push(resized(&pad.name, wanted - pad.offset));
                    self.pads.push(Padding { size: wanted - pad.offset, ..pad });
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
                (Writer::Memory, Some(pad), _) => resized(&pad.name, wanted - pad.offset),
                (Writer::Encase, last, Some(before)) => {
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
