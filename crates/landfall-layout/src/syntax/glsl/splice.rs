//! Removal of line continuations (GLSL 4.60 §3.2): a backslash before the end of a line joins it
//! with the next, also inside tokens and at the end of comments.

use std::rc::Rc;

/// A position in a spliced text before which bytes of the original were removed.
#[derive(Clone, Copy, Debug)]
pub struct Cut {
    /// Offset in the spliced text of the byte after the cut.
    at: u32,
    /// Bytes removed so far, including this cut's.
    removed: u32,
}

/// The cuts of a text in order.
pub type Cuts = Rc<[Cut]>;

/// Returns the text without its line continuations, and the cuts; `None` if it has none.
pub fn splice(text: &str) -> Option<(String, Cuts)> {
    let bytes = text.as_bytes();
    let mut continued = memchr::memchr_iter(b'\\', bytes).filter_map(|at| {
        let end = match bytes.get(at + 1..)? {
            [b'\r', b'\n', ..] => at + 3,
            [b'\r' | b'\n', ..] => at + 2,
            _ => return None,
        };
        Some((at, end))
    });
    let first = continued.next()?;
    let mut clean = String::with_capacity(text.len());
    let mut cuts: Vec<Cut> = Vec::new();
    let (mut from, mut removed) = (0, 0);
    for (at, end) in std::iter::once(first).chain(continued) {
        clean.push_str(&text[from..at]);
        removed += (end - at) as u32;
        from = end;
        let at = clean.len() as u32;
        match cuts.last_mut() {
            // Two continuations in a row remove text at one place.
            Some(last) if last.at == at => last.removed = removed,
            Some(_) | None => cuts.push(Cut { at, removed }),
        }
    }
    clean.push_str(&text[from..]);
    Some((clean, cuts.into()))
}

/// Maps an offset in the spliced text to the original: cuts before it are passed.
// A range that begins at a cut begins after it, one that ends there ends before it; so a token has
// no backslash at its ends.
pub fn start(cuts: &Cuts, at: usize) -> u32 {
    original(cuts, at as u32, cuts.partition_point(|cut| cut.at <= at as u32))
}

/// Maps the end of a range in the spliced text to the original, one past its last byte.
pub fn end(cuts: &Cuts, at: usize) -> u32 {
    original(cuts, at as u32, cuts.partition_point(|cut| cut.at < at as u32))
}

fn original(cuts: &Cuts, at: u32, passed: usize) -> u32 {
    at + passed.checked_sub(1).map_or(0, |last| cuts[last].removed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_in_the_spliced_text_is_found_in_the_original() {
        let text = "a\\\nb\\\r\n\\\rc d\\";
        let (clean, cuts) = splice(text).expect("it has three");
        assert_eq!(clean, "abc d\\");
        for (at, byte) in clean.bytes().enumerate() {
            assert_eq!(text.as_bytes()[start(&cuts, at) as usize], byte, "{at}");
            assert_eq!(text.as_bytes()[end(&cuts, at + 1) as usize - 1], byte, "{at}");
        }
        assert!(splice("a \\ \n b").is_none(), "a blank after the backslash leaves it alone");
    }
}
