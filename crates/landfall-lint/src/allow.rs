//! `// landfall: allow(code)` and `allow-file(code)` in the comments of a shader and its includes.
//!
//! Read from the files of a [`ShaderLayout`](landfall_layout::ShaderLayout) and applied by
//! [`run`](super::run). Stored with paths and lines, so that suppressions can be cached
//! from several runs.

use std::collections::BTreeSet;
use std::ops::Range;

use rustc_hash::FxHashMap;
use serde::{Deserialize, Serialize};

use super::levels::{at_levels, level, level_in};
use super::registry::{LINTS, lint};
use super::settings::Settings;
use landfall_layout::finding::{Finding, Level, Place};
use landfall_layout::source::{Files, Language, Span};
use landfall_layout::text::edit_distance::nearest;

/// The lint that reports comments without effect.
const UNUSED: &str = "unused-allow";

/// One code in one comment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Allow {
    /// The lint's code; the text of the comment if it is malformed.
    pub code: String,
    pub place: Place,
    /// The text to remove with this code: the code alone, the comment, or the comment's line.
    pub removal: Place,
    /// The first and last line that it applies to; `None` for the whole file.
    pub lines: Option<(u32, u32)>,
    /// Whether the comment is malformed: neither `allow(…)` nor `allow-file(…)`.
    pub garbled: bool,
    /// Whether it suppressed a finding.
    pub used: bool,
}

/// Returns the allow comments of a shader and its includes.
pub fn allows(files: &Files, language: Language) -> Vec<Allow> {
    let mut found = Vec::new();
    // Most files have no such comment: a search is cheaper than finding their comments.
    let marker = memchr::memmem::Finder::new("landfall:");
    for (number, file) in files.iter().enumerate() {
        if marker.find(file.text.as_bytes()).is_none() {
            continue;
        }
        let (text, file) = (&*file.text, number as u32);
        let breaks = memchr::memchr_iter(b'\n', text.as_bytes()).collect();
        let text = CommentedText { files, file, text, breaks, runs: runs(text) };
        for comment in comments(text.text, language) {
            text.read(comment, &mut found);
        }
    }
    found
}

/// Removes the findings that a comment allows, and marks those comments as used.
pub fn suppress(findings: &mut Vec<Finding>, allows: &mut [Allow]) {
    if allows.is_empty() {
        return;
    }
    // By code and file, as there may be many findings and many comments.
    let mut lines: FxHashMap<(&str, &str), Vec<u32>> = FxHashMap::default();
    for finding in findings.iter() {
        let place = finding.place();
        lines.entry((&finding.code, &place.path)).or_default().push(place.line);
    }
    lines.values_mut().for_each(|lines| lines.sort_unstable());
    for allow in allows.iter_mut().filter(|allow| !allow.garbled) {
        let Some(lines) = lines.get(&(&*allow.code, &*allow.place.path)) else { continue };
        allow.used |= allow.lines.is_none_or(|(first, last)| {
            lines.get(lines.partition_point(|line| *line < first)).is_some_and(|line| *line <= last)
        });
    }
    let covered = Covered::by(allows.iter());
    findings.retain(|finding| !covered.has(finding));
}

/// The lines that comments apply to, by code and file, sorted and disjoint.
struct Covered<'a>(FxHashMap<(&'a str, &'a str), Vec<(u32, u32)>>);

impl<'a> Covered<'a> {
    fn by(allows: impl Iterator<Item = &'a Allow>) -> Covered<'a> {
        let mut all: FxHashMap<(&str, &str), Vec<(u32, u32)>> = FxHashMap::default();
        for allow in allows.filter(|allow| !allow.garbled) {
            let lines = allow.lines.unwrap_or((0, u32::MAX));
            all.entry((&allow.code, &allow.place.path)).or_default().push(lines);
        }
        for lines in all.values_mut() {
            lines.sort_unstable();
            // Ranges that meet become one, so that a bisection finds the only one around a line.
            lines.dedup_by(|next, before| {
                let meets = next.0 <= before.1;
                before.1 = if meets { before.1.max(next.1) } else { before.1 };
                meets
            });
        }
        Covered(all)
    }

    fn has(&self, finding: &Finding) -> bool {
        let place = finding.place();
        let Some(lines) = self.0.get(&(finding.code.as_ref(), &*place.path)) else { return false };
        let after = lines.partition_point(|(first, _)| *first <= place.line);
        after > 0 && place.line <= lines[after - 1].1
    }
}

/// Returns the findings of comments that suppressed nothing. `asked` returns whether this run
/// included a lint; comments for other lints are not reported.
///
/// A comment in an include is used if it suppressed a finding for any shader.
pub fn unused(allows: &[Allow], settings: &Settings, asked: impl Fn(&str) -> bool) -> Vec<Finding> {
    if level(UNUSED, settings) == Level::Allow {
        return Vec::new();
    }
    let mut idle: Vec<&Allow> = allows.iter().filter(|a| !a.used && a.code != UNUSED).collect();
    // Each shader with an include has read its comments.
    idle.sort_by(|a, b| a.place.cmp(&b.place));
    idle.dedup_by(|a, b| a.place == b.place);
    let used: BTreeSet<&Place> = allows.iter().filter(|a| a.used).map(|a| &a.place).collect();
    idle.retain(|idle| !used.contains(&idle.place));
    let found = idle.into_iter().filter_map(|allow| allow.idle(settings, &asked)).collect();
    let mut findings = at_levels(found, settings);
    // Comments may allow this lint, too: `allow(unused-allow)`.
    let covered = Covered::by(allows.iter().filter(|allow| allow.code == UNUSED));
    findings.retain(|finding| !covered.has(finding));
    findings
}

impl Allow {
    fn idle(&self, settings: &Settings, asked: impl Fn(&str) -> bool) -> Option<Finding> {
        let finding =
            |message: String| Finding::at(UNUSED, &*self.code, self.place.clone(), message);
        if self.garbled {
            let message = format!("malformed comment `landfall: {}`", self.code);
            return Some(finding(message).with_help(
                "write `landfall: allow(CODE)` for the next line, or `landfall: allow-file(CODE)`",
            ));
        }
        if lint(&self.code).is_none() {
            let message = format!("unknown lint `{}`: the comment allows nothing", self.code);
            let near = nearest(&self.code, LINTS.iter().map(|lint| lint.code));
            return Some(match near {
                Some(near) => finding(message)
                    .with_help(format!("did you mean `{near}`?"))
                    .with_edit(self.place.clone(), near),
                None => finding(message).with_help("`landfall rule` lists the lints"),
            });
        }
        // Nothing is known of a lint that was off, or that did not run.
        if level_in(&self.code, &self.place.path, settings) == Level::Allow || !asked(&self.code) {
            return None;
        }
        let reach = match self.lines {
            None => "in this file".to_string(),
            Some((first, last)) if first == last => format!("in line {first}"),
            Some((_, last)) => format!("in line {last}"),
        };
        Some(
            finding(format!("`allow({})` suppresses nothing {reach}", self.code))
                .with_text("no such finding")
                .with_help("remove it")
                .with_edit(self.removal.clone(), ""),
        )
    }
}

/// One file of a shader.
struct CommentedText<'a> {
    files: &'a Files,
    file: u32,
    text: &'a str,
    /// The line feeds of the text.
    breaks: Vec<usize>,
    /// By line, the number of allow comments in a row that begin lines from there on.
    runs: Vec<u32>,
}

fn runs(text: &str) -> Vec<u32> {
    let is_allow = |line: &str| {
        let line = line.trim_start();
        line.starts_with('/') && line.contains("landfall:")
    };
    let mut runs: Vec<u32> = text.split('\n').map(|line| u32::from(is_allow(line))).collect();
    // From the last line up: a run is one longer than that of the line below.
    for line in (1..runs.len()).rev() {
        runs[line - 1] *= 1 + runs[line];
    }
    runs
}

impl CommentedText<'_> {
    fn place(&self, range: Range<usize>) -> Place {
        let span = Span { file: self.file, start: range.start as u32, end: range.end as u32 };
        Place::new(self.files, span)
    }

    fn read(&self, comment: Range<usize>, found: &mut Vec<Allow>) {
        let whole = &self.text[comment.clone()];
        let body = whole.strip_suffix("*/").unwrap_or(whole);
        // Any beginning: `//`, `///`, `//!`, `/*`, `/**`.
        let Some(said) =
            body.trim_start_matches(['/', '*', '!', ' ', '\t']).strip_prefix("landfall:")
        else {
            return;
        };
        let said = said.trim();
        // The parts are slices of the text, so that their addresses tell their places.
        let at = |part: &str| part.as_ptr() as usize - self.text.as_ptr() as usize;
        let word =
            said.split(|c: char| c != '-' && !c.is_ascii_alphanumeric()).next().unwrap_or("");
        let list =
            said[word.len()..].trim_start().strip_prefix('(').and_then(|l| l.split_once(')'));
        let (own, covered) = self.lines(&comment);
        let lines = match (word, list) {
            ("allow", Some(_)) => Some((own, covered)),
            ("allow-file", Some(_)) => None,
            _ => {
                // Prose may begin with `landfall:` too.
                if word.contains("allow")
                    || nearest(word, ["allow", "allow-file"].into_iter()).is_some()
                {
                    let range = at(said)..at(said) + said.len();
                    found.push(Allow {
                        code: said.to_string(),
                        place: self.place(range.clone()),
                        removal: self.place(range),
                        lines: None,
                        garbled: true,
                        used: false,
                    });
                }
                return;
            }
        };
        let Some((list, _)) = list else { return };
        let codes: Vec<&str> = list.split(',').collect();
        for (i, part) in codes.iter().enumerate() {
            let code = part.trim();
            let start = at(code);
            let removal = match (codes.len(), i) {
                (1, _) => self.around(&comment),
                // The first goes with the comma after it, the others with the one before.
                (_, 0) => at(part)..at(codes[1].trim_start()),
                (_, i) => at(codes[i - 1]) + codes[i - 1].len()..at(part) + part.len(),
            };
            found.push(Allow {
                code: code.to_string(),
                place: self.place(start..start + code.len()),
                removal: self.place(removal),
                lines,
                garbled: false,
                used: false,
            });
        }
    }

    /// Returns the line that contains a byte, without its line end.
    fn line(&self, at: usize) -> Range<usize> {
        let start = self.text[..at].rfind('\n').map_or(0, |i| i + 1);
        let end = self.text[at..].find('\n').map_or(self.text.len(), |i| at + i);
        start..end
    }

    /// Returns whether the comment is alone in its lines.
    fn is_alone(&self, comment: &Range<usize>) -> bool {
        let before = self.line(comment.start).start..comment.start;
        let after = comment.end..self.line(comment.end).end;
        self.text[before].trim().is_empty() && self.text[after].trim().is_empty()
    }

    /// Returns the line a comment begins in, and the last line it applies to: a comment alone in
    /// its line applies to the next line that is not an allow comment.
    fn lines(&self, comment: &Range<usize>) -> (u32, u32) {
        let own = self.place(comment.start..comment.start).line;
        let last = self.place(comment.end..comment.end).line;
        if !self.is_alone(comment) {
            return (own, last);
        }
        // The index, from 0, of the line below the comment.
        let next = self.breaks.partition_point(|at| *at < comment.end) + 1;
        (own, last + 1 + self.runs.get(next).copied().unwrap_or(0))
    }

    /// Returns the text to remove with a comment: the spaces before it, or its whole line.
    fn around(&self, comment: &Range<usize>) -> Range<usize> {
        if self.is_alone(comment) {
            let end = self.line(comment.end).end;
            return self.line(comment.start).start..(end + 1).min(self.text.len());
        }
        let before = self.text[..comment.start].trim_end_matches([' ', '\t']).len();
        let code_after = !self.text[comment.end..self.line(comment.end).end].trim().is_empty();
        // With code behind it, the spaces stay between that and the code before.
        if code_after { comment.clone() } else { before..comment.end }
    }
}

/// Returns the comments of a text, including their delimiters.
pub(super) fn comments(text: &str, language: Language) -> Vec<Range<usize>> {
    let bytes = text.as_bytes();
    let mut found = Vec::new();
    let mut at = 0;
    while let Some(slash) = memchr::memchr(b'/', &bytes[at..]) {
        let start = at + slash;
        at = match bytes.get(start + 1) {
            Some(b'/') => {
                let end = memchr::memchr(b'\n', &bytes[start..]).map_or(bytes.len(), |i| start + i);
                // A carriage return is part of the line end.
                let end = if bytes[..end].ends_with(b"\r") { end - 1 } else { end };
                found.push(start..end);
                end
            }
            Some(b'*') => {
                let end = closing(bytes, start, language);
                found.push(start..end);
                end
            }
            _ => start + 1,
        };
    }
    found
}

/// Returns the end of a block comment; in WGSL they nest.
fn closing(bytes: &[u8], start: usize, language: Language) -> usize {
    let nests = match language {
        Language::Wgsl => true,
        Language::Glsl | Language::SpirV => false,
    };
    let mut depth = 1;
    let mut at = start + 2;
    while let Some(mark) = memchr::memchr2(b'/', b'*', &bytes[at..]) {
        at += mark;
        match bytes.get(at..at + 2) {
            Some(b"*/") if depth == 1 => return at + 2,
            Some(b"*/") => (depth, at) = (depth - 1, at + 2),
            Some(b"/*") if nests => (depth, at) = (depth + 1, at + 2),
            _ => at += 1,
        }
    }
    // A comment without an end goes on to the end of the text.
    bytes.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> (Files, Vec<Allow>) {
        let mut files = Files::default();
        files.add("a.frag", text.into());
        let found = allows(&files, Language::Glsl);
        (files, found)
    }

    /// Code and lines of every allow.
    fn told(text: &str) -> Vec<(String, Option<(u32, u32)>)> {
        read(text).1.into_iter().map(|allow| (allow.code, allow.lines)).collect()
    }

    #[test]
    fn a_comment_after_code_holds_for_its_line_and_one_alone_for_the_next() {
        let text = "int a; // landfall: allow(stale-comment)\n  // landfall: allow(mat3-padding)\nint b;\n";
        let expected = [
            ("stale-comment".to_string(), Some((1, 1))),
            ("mat3-padding".to_string(), Some((2, 3))),
        ];
        assert_eq!(told(text), expected);
    }

    #[test]
    fn comments_above_one_another_hold_for_the_same_line() {
        let text = "// landfall: allow(a-b)\r\n/* landfall: allow(c-d, e-f) */\r\nint b;\r\n";
        let lines: Vec<_> = told(text).into_iter().map(|allow| allow.1).collect();
        assert_eq!(lines, [Some((1, 3)), Some((2, 3)), Some((2, 3))]);
    }

    #[test]
    fn what_is_no_comment_or_no_order_allows_nothing() {
        assert_eq!(told("int landfall; // see landfall: allow(x)\n"), []);
        assert_eq!(told("// landfall: computes this\n/* unclosed landfall: allow(x"), []);
        assert_eq!(told("/* // landfall: allow(x-y) */"), [("x-y".to_string(), Some((1, 2)))]);
        assert!(read("// landfall: alow(stale-comment)\n").1[0].garbled);
    }

    #[test]
    fn nested_comments_end_where_wgsl_says() {
        let text = "/* /* */ landfall: */ // landfall: allow-file(x-y)\n";
        let mut files = Files::default();
        files.add("a.wgsl", text.into());
        let found = allows(&files, Language::Wgsl);
        assert_eq!((found.len(), found[0].lines), (1, None));
    }

    fn without(text: &str) -> String {
        let (_, found) = read(text);
        let gone = &found.last().unwrap().removal;
        format!("{}{}", &text[..gone.start as usize], &text[gone.end as usize..])
    }

    #[test]
    fn removing_a_code_takes_its_comma_and_the_last_one_the_comment() {
        assert_eq!(without("int a; // landfall: allow(b-c)\nint d;\n"), "int a;\nint d;\n");
        assert_eq!(without("int a;\n  // landfall: allow(b-c)\nint d;\n"), "int a;\nint d;\n");
        assert_eq!(without("/* landfall: allow(b-c) */ int d;\n"), " int d;\n");
        assert_eq!(without("// landfall: allow(b-c, d-e)\n"), "// landfall: allow(b-c)\n");
        let (_, found) = read("// landfall: allow(b-c, d-e)\n");
        assert_eq!((found[0].removal.start, found[0].removal.end), (19, 24));
    }

    #[test]
    fn an_allow_that_a_second_shader_needs_is_used() {
        let (_, mut found) = read("int a; // landfall: allow(stale-comment)\n");
        let mut second = found.clone();
        let idle = unused(&found, &Settings::default(), |_| true);
        assert_eq!(idle.len(), 1);
        assert_eq!(idle[0].message, "`allow(stale-comment)` suppresses nothing in line 1");
        second[0].used = true;
        found.extend(second);
        assert_eq!(unused(&found, &Settings::default(), |_| true), []);
    }

    #[test]
    fn nothing_is_known_of_lints_that_were_not_asked() {
        let (_, found) = read("// landfall: allow(stale-comment)\n");
        assert_eq!(unused(&found, &Settings::default(), |_| false), []);
        let off = vec![("stale-comment".to_string(), Level::Allow)];
        let settings = Settings { levels: off, ..Settings::default() };
        assert_eq!(unused(&found, &settings, |_| true), []);
    }

    #[test]
    fn a_misspelt_code_is_told_the_nearest() {
        let (_, found) = read("// landfall: allow(stale-coment)\n");
        let idle = unused(&found, &Settings::default(), |_| false);
        assert_eq!(idle[0].help.as_deref(), Some("did you mean `stale-comment`?"));
        assert_eq!(idle[0].fix[0].new, "stale-comment");
    }
}
