//! Hex dumps of a block's bytes, with the component of each 4-byte word.

use std::io::{self, Write};

use unicode_width::UnicodeWidthStr as _;

use super::columns::{GAP, WIDTH};
use super::paint::{FAINT, Paint};
use crate::layout::BlockLayout;
use crate::layout::byte::{ByteOwner, owner_of_byte};

/// Bytes of a line, the most first.
const LINES: [usize; 3] = [16, 8, 4];
const WORD: usize = 4;

/// The label of a word of padding.
const PADDING: &str = "--";

/// The label of a word in which no component starts.
const CONTINUED: &str = "..";

/// Writes the bytes of a block, each line followed by the component of each word: its path, or
/// only its last step if the word before belongs to the same leaf. `--` is padding, `..` the rest
/// of a component longer than a word. Without a number of bytes in a `line`, it is the most of 16, 8
/// and 4 with which all lines fit 80 columns.
///
/// # Errors
/// Returns the errors of `out`.
pub fn dump(
    block: &BlockLayout,
    bytes: &[u8],
    line: Option<usize>,
    paint: Paint,
    out: &mut dyn Write,
) -> io::Result<()> {
    let last = bytes.len().saturating_sub(1) / WORD * WORD;
    let width = last.to_string().len().max("offset".len());
    let rows = |line: usize| {
        bytes.chunks(line).enumerate().map(move |(nth, part)| ((nth * line) as u64, part))
    };
    let fits = |line: &usize| {
        rows(*line).all(|(start, part)| {
            let words = names(block, start, part.len() as u64, Paint::Plain);
            let words = words.iter().map(|word| GAP.len() + word.width()).sum::<usize>();
            2 + width + GAP.len() + columns(*line) + words <= WIDTH
        })
    };
    let line = line.or_else(|| LINES.into_iter().find(fits)).unwrap_or(WORD);
    let columns = columns(line);
    let titles = format!("  {:>width$}  {:columns$}  words", "offset", "bytes");
    writeln!(out, "{}", paint.text(FAINT, &titles))?;
    for (start, part) in rows(line) {
        let words = part.chunks(WORD).map(|word| {
            word.iter().map(|byte| format!("{byte:02x}")).collect::<Vec<_>>().join(" ")
        });
        let hex = words.collect::<Vec<_>>().join(GAP);
        let words = names(block, start, part.len() as u64, paint).join(GAP);
        writeln!(out, "  {start:>width$}  {hex:columns$}  {words}")?;
    }
    Ok(())
}

/// The columns of the bytes of a line.
const fn columns(line: usize) -> usize {
    // Three columns for each byte but the space after the last, and one more between words.
    3 * line - 1 + line / WORD - 1
}

/// The label of each word of a line.
fn names(block: &BlockLayout, start: u64, len: u64, paint: Paint) -> Vec<String> {
    let mut before = String::new();
    let words = (start..start + len).step_by(WORD);
    words.map(|word| name(block, word..(start + len).min(word + 4), &mut before, paint)).collect()
}

/// The label of a word; `before` is the last leaf named.
fn name(
    block: &BlockLayout,
    mut word: std::ops::Range<u64>,
    before: &mut String,
    paint: Paint,
) -> String {
    let mut parts = Vec::new();
    let mut continues = false;
    while word.start < word.end {
        match owner_of_byte(block, word.start) {
            ByteOwner::Component { leaf, path, offset, size, byte, .. } => {
                // A component longer than a word, or several in one: on to the end of whatever owns
                // the byte.
                word.start = offset + size;
                if byte > 0 {
                    continues = true;
                } else if leaf == *before && path.len() > leaf.len() {
                    parts.push(path[leaf.len()..].to_string());
                } else {
                    parts.push(path);
                    *before = leaf;
                }
            }
            ByteOwner::Padding { offset, size, .. } => word.start = offset + size,
            ByteOwner::Beyond { .. } | ByteOwner::Loose => word.start += 1,
        }
    }
    match parts.as_slice() {
        [] if continues => paint.text(FAINT, CONTINUED),
        [] => {
            before.clear();
            paint.text(FAINT, PADDING)
        }
        parts => parts.join(","),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::examples;
    use crate::shape::Rules;

    fn lines(block: &BlockLayout, len: usize) -> Vec<String> {
        let bytes: Vec<u8> = (0..len).map(|byte| byte as u8).collect();
        let mut out = Vec::new();
        dump(block, &bytes, Some(16), Paint::Plain, &mut out).expect("memory takes every byte");
        String::from_utf8(out).expect("text").lines().map(str::to_string).collect()
    }

    #[test]
    fn each_word_is_named() {
        let lines = lines(&examples::point_lights(), 6160);
        assert_eq!(lines.len(), 1 + 6160 / 16);
        for (line, wanted) in [
            (0, "  offset  bytes                                               words"),
            (
                1,
                "       0  00 01 02 03  04 05 06 07  08 09 0a 0b  0c 0d 0e 0f  \
                 data[0].pos.x  .y  .z  --",
            ),
            (
                3,
                "      32  20 21 22 23  24 25 26 27  28 29 2a 2b  2c 2d 2e 2f  \
                 data[0].constant  data[0].linear  data[0].quadratic  --",
            ),
            (
                385,
                "    6144  00 01 02 03  04 05 06 07  08 09 0a 0b  0c 0d 0e 0f  \
                 actually_used_count  --  --  --",
            ),
        ] {
            assert_eq!(lines[line], wanted);
        }
    }

    #[test]
    fn components_of_two_words_go_on() {
        let lines = lines(&examples::doubles(Rules::Std430), 20);
        assert!(lines[1].contains("  .."), "{}", lines[1]);
        assert_eq!(lines.len(), 3);
    }
}
