//! The report of read coverage: the bytes of each leaf that a shader reads, with a total per block.
//!
//! Formats the data of [`harness::coverage`](landfall_exec::harness::coverage); part of the report
//! of [`verify`](super::verify).

use std::fmt::Write as _;

use unicode_width::UnicodeWidthStr;

use landfall_exec::harness::coverage::{BlockCoverage, LeafCoverage, Verdict};
pub use landfall_layout::format::paint::{CAUTION, FAINT, PLAIN, Paint};
pub use landfall_layout::format::phrases;

/// The most ranges of elements shown for a leaf.
const MAX_RANGES: usize = 4;

/// Returns the lines of one block, indented to stand below its heading.
pub fn block(coverage: &BlockCoverage, paint: Paint) -> String {
    let mut text = String::new();
    let BlockCoverage { bytes, read, never, leaves, failures, .. } = coverage;
    let mut total = format!("{} of {} read", phrases::number(*read), phrases::bytes(*bytes));
    if *never > 0 {
        let _ = write!(total, ", {} certainly never read", phrases::number(*never));
    }
    let _ = writeln!(text, "    {total}");
    let paths = leaves.iter().map(|leaf| leaf.path.width()).max().unwrap_or(0);
    let sizes: Vec<String> = leaves.iter().map(|leaf| phrases::number(leaf.bytes)).collect();
    let digits = sizes.iter().map(|size| size.width()).max().unwrap_or(0);
    for (leaf, size) in leaves.iter().zip(&sizes) {
        // What is certain is set apart from what these runs happened not to read.
        let (style, line) = verdict(leaf);
        let _ = writeln!(
            text,
            "      {}{}  {}{size}  {}",
            leaf.path,
            " ".repeat(paths - leaf.path.width()),
            " ".repeat(digits - size.width()),
            paint.text(style, &line),
        );
    }
    for failure in failures {
        let _ = writeln!(text, "    {}", paint.text(CAUTION, failure));
    }
    text
}

fn verdict(leaf: &LeafCoverage) -> (anstyle::Style, String) {
    match leaf.verdict {
        Verdict::Read => (PLAIN, "read".to_string()),
        Verdict::Never => (CAUTION, "never read (certain)".to_string()),
        Verdict::Unread => (FAINT, "not read in these runs".to_string()),
        Verdict::Partly => {
            let mut line = format!("{} read", phrases::number(leaf.read));
            if leaf.elements > 1 {
                let mut ranges: Vec<String> = leaf
                    .elements_read
                    .iter()
                    .take(MAX_RANGES)
                    .map(|[first, last]| match first == last {
                        true => format!("[{first}]"),
                        false => format!("[{first}..{last}]"),
                    })
                    .collect();
                if leaf.elements_read.len() > MAX_RANGES {
                    ranges.push("…".to_string());
                }
                let elements = phrases::number(leaf.elements);
                let _ = write!(line, ", in {} of {elements} elements", ranges.join(", "));
            }
            // What is certain is told beside what was not read by chance.
            if leaf.never > 0 {
                let _ = write!(line, "; {} never read (certain)", phrases::number(leaf.never));
            }
            (PLAIN, line)
        }
    }
}
