//! The lines that begin with `#`: conditions, definitions and imports of naga_oil, and files that
//! are included as text.

use super::super::lexer::WgslLexer;
use super::Linker;
use super::imports::{self, Import};
use crate::diagnostic::{Code, Diagnostic};
use crate::source::Span;
use crate::source::joined::Joined;

/// What the lines of a file and of the files it includes give.
#[derive(Default)]
pub(super) struct Lines {
    pub(super) text: Joined,
    pub(super) imports: Vec<Import>,
}

/// A condition that is open.
struct OpenCondition {
    /// Whether the text around it is kept.
    is_outer_kept: bool,
    /// Whether one of its branches was kept.
    is_taken: bool,
    is_kept: bool,
    at: Span,
}

/// Reads a file, and puts what it includes in its place.
///
/// # Errors
/// The first line that is wrong.
// Line by line, before any token is read: what a condition leaves out need not be WGSL. A `#` in a
// block comment is no directive, so the depth of comments is followed across lines.
pub(super) fn read(
    linker: &mut Linker<'_>,
    file: u32,
    lines: &mut Lines,
) -> Result<(), Diagnostic> {
    let text = linker.text(file);
    let mut conditions: Vec<OpenCondition> = Vec::new();
    let (mut next, mut comments) = (0, 0u32);
    while next < text.len() {
        let at = next;
        let end = text[at..].find('\n').map_or(text.len(), |end| at + end + 1);
        next = end;
        let line = &text[at..end];
        let start = at + line.len() - line.trim_start().len();
        let span = Span { file, start: start as u32, end: (at + line.trim_end().len()) as u32 };
        let is_kept = conditions.last().is_none_or(|condition| condition.is_kept);
        let directive = line.trim_start().strip_prefix('#').filter(|_| comments == 0);
        let word = directive.map(first_word);
        let rest = directive.zip(word).map_or("", |(line, word)| &line[word.len()..]);
        let rest = rest.split("//").next().unwrap_or("").trim();
        match word {
            Some(word @ ("ifdef" | "ifndef" | "if" | "else" | "endif")) => {
                condition(linker, word, rest, span, &mut conditions)?;
            }
            Some("import" | "include" | "define" | "define_import_path") if !is_kept => {}
            Some("define") => {
                let (name, value) = rest.split_once(char::is_whitespace).unwrap_or((rest, ""));
                linker.defines.insert(name.to_string(), value.trim().to_string());
            }
            Some("define_import_path") => linker.is_naga_oil = true,
            Some("include") => {
                let name = rest.trim_matches(['"', '<', '>']);
                include(linker, file, name, span, lines)?;
            }
            Some("import") => next = import(linker, file, &text, start, end, lines)?,
            _ => {
                match (is_kept, comments) {
                    (true, 0) => substituted(linker, file, line, at, lines)?,
                    (true, _) => {
                        let span = Span { file, start: at as u32, end: end as u32 };
                        lines.text.push(line, span);
                    }
                    (false, _) => {}
                }
                comments = comment_depth(line, comments);
            }
        }
    }
    match conditions.pop() {
        Some(open) => {
            Err(Diagnostic::error(Code::Syntax, open.at, "this condition is never closed")
                .with_help("write `#endif` where it ends"))
        }
        None => Ok(()),
    }
}

/// Opens, changes or closes a condition.
fn condition(
    linker: &mut Linker<'_>,
    word: &str,
    rest: &str,
    at: Span,
    open: &mut Vec<OpenCondition>,
) -> Result<(), Diagnostic> {
    match word {
        "endif" => match open.pop() {
            Some(_) => Ok(()),
            None => Err(Diagnostic::error(Code::Syntax, at, "`#endif` without a condition")),
        },
        // A branch is kept if what is around the whole condition is, and none before it was.
        "else" => {
            let Some(condition) = open.last_mut() else {
                return Err(Diagnostic::error(Code::Syntax, at, "`#else` without a condition"));
            };
            let may_hold = condition.is_outer_kept && !condition.is_taken;
            // `#else ifdef NAME` and `#else if NAME == VALUE` go on with the same condition.
            let (word, rest) = rest.split_once(char::is_whitespace).unwrap_or((rest, ""));
            condition.is_kept = match word {
                "" => may_hold,
                "ifdef" | "ifndef" | "if" => may_hold && holds(linker, word, rest.trim(), at)?,
                _ => {
                    let message = format!("`#else` is followed by `{word}`");
                    return Err(Diagnostic::error(Code::Syntax, at, message));
                }
            };
            condition.is_taken |= condition.is_kept;
            Ok(())
        }
        _ => {
            let is_outer_kept = open.last().is_none_or(|condition| condition.is_kept);
            let is_kept = is_outer_kept && holds(linker, word, rest, at)?;
            open.push(OpenCondition { is_outer_kept, is_taken: is_kept, is_kept, at });
            Ok(())
        }
    }
}

/// Whether the condition of `#ifdef`, `#ifndef` or `#if` holds.
fn holds(linker: &mut Linker<'_>, word: &str, rest: &str, at: Span) -> Result<bool, Diagnostic> {
    match word {
        "ifdef" => return Ok(linker.defines.contains_key(rest)),
        "ifndef" => return Ok(!linker.defines.contains_key(rest)),
        _ => {}
    }
    let parts: Vec<&str> = rest.split_whitespace().collect();
    let [name, operator, value] = parts[..] else {
        let message = "`#if` expects `NAME == VALUE`, or another comparison";
        return Err(Diagnostic::error(Code::Syntax, at, message));
    };
    // As naga_oil, which compares numbers and words with the definition of a name.
    let known = |name| linker.defines.get(name).map(String::as_str);
    let Some(left) = known(name) else {
        linker.undefined_condition(name, at);
        return Ok(false);
    };
    let right = known(value).unwrap_or(value);
    let number = |text: &str| text.trim_end_matches(['u', 'i']).parse::<i64>().ok();
    let order = match (number(left), number(right)) {
        (Some(left), Some(right)) => left.cmp(&right),
        _ => left.cmp(right),
    };
    match operator {
        "==" => Ok(order.is_eq()),
        "!=" => Ok(order.is_ne()),
        "<" => Ok(order.is_lt()),
        "<=" => Ok(order.is_le()),
        ">" => Ok(order.is_gt()),
        ">=" => Ok(order.is_ge()),
        _ => {
            let message = format!("`{operator}` is no comparison");
            Err(Diagnostic::error(Code::Syntax, at, message))
        }
    }
}

/// Reads `#import`, which may go on for several lines; returns its end.
fn import(
    linker: &mut Linker<'_>,
    file: u32,
    text: &str,
    start: usize,
    line_end: usize,
    lines: &mut Lines,
) -> Result<usize, Diagnostic> {
    let from = start + "#import".len();
    let rest = text[from..line_end].split("//").next().unwrap_or("").trim();
    let span = Span {
        file,
        start: start as u32,
        end: (from + text[from..line_end].trim_end().len()) as u32,
    };
    // `#import "file"` includes a text, `#import a::b` names a module; a single word is a module if
    // one states that path, otherwise a file.
    let quoted = rest.len() > 1 && (rest.starts_with('"') && rest.ends_with('"'))
        || (rest.starts_with('<') && rest.ends_with('>'));
    let is_word = !rest.is_empty() && rest.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    if quoted || is_word && linker.find_text(file, rest).is_some() && !linker.is_module(file, rest)
    {
        include(linker, file, rest.trim_matches(['"', '<', '>']), span, lines)?;
        return Ok(line_end);
    }
    let mut lexer = WgslLexer::new(text, from as u32);
    let in_file = |mut error: Diagnostic| {
        error.labels.iter_mut().for_each(|label| label.at.file = file);
        error
    };
    linker.is_naga_oil = true;
    let mut imports = imports::read(&mut lexer).map_err(in_file)?;
    imports.iter_mut().for_each(|import| import.at.file = file);
    lines.imports.extend(imports);
    let end = lexer.peek().start as usize;
    // The rest of the line belongs to it, comments included.
    let last = text[from..end].trim_end().len() + from;
    Ok(text[last..].find('\n').map_or(text.len(), |end| last + end + 1).max(line_end))
}

/// Puts the text of another file here, once.
// Once per shader, like `#pragma once`: a second inclusion would declare all again.
fn include(
    linker: &mut Linker<'_>,
    file: u32,
    name: &str,
    at: Span,
    lines: &mut Lines,
) -> Result<(), Diagnostic> {
    let Some(path) = linker.find_text(file, name) else {
        return Err(linker.no_text(file, name, at));
    };
    let included = linker.load(&path, at)?;
    if !linker.included.insert(included) {
        return Ok(());
    }
    linker.enter(at, |linker| read(linker, included, lines))
}

/// Adds a line with the values of `#NAME` and `#{NAME}`.
fn substituted(
    linker: &mut Linker<'_>,
    file: u32,
    line: &str,
    start: usize,
    lines: &mut Lines,
) -> Result<(), Diagnostic> {
    let place = |from: usize, to: usize| Span {
        file,
        start: (start + from) as u32,
        end: (start + to) as u32,
    };
    let mut at = 0;
    let code = line.split("//").next().unwrap_or("").len();
    while let Some(sign) = line[at..code].find('#').map(|sign| at + sign) {
        let rest = &line[sign + 1..code];
        let name =
            rest.strip_prefix('{').and_then(|rest| rest.split_once('}')).map(|(name, _)| name);
        let word = first_word(rest);
        let (name, end) = match name {
            Some(name) => (name, sign + name.len() + 3),
            None => (word, sign + word.len() + 1),
        };
        let span = place(sign, end);
        lines.text.push(&line[at..sign], place(at, sign));
        match linker.value(name, span, &line[..sign])? {
            // What is no definition of naga_oil is reported by who reads the text.
            None => lines.text.push(&line[sign..end], span),
            Some(value) => lines.text.push(&value, span),
        }
        at = end;
    }
    lines.text.push(&line[at..], place(at, line.len()));
    Ok(())
}

/// The word that a text begins with, which may be empty.
fn first_word(text: &str) -> &str {
    let end = text.find(|c: char| !c.is_ascii_alphanumeric() && c != '_');
    &text[..end.unwrap_or(text.len())]
}

/// The number of block comments that are open after a line.
fn comment_depth(line: &str, mut depth: u32) -> u32 {
    let bytes = line.as_bytes();
    let mut at = 0;
    while at + 1 < bytes.len() {
        match &bytes[at..at + 2] {
            b"//" if depth == 0 => return depth,
            b"/*" => depth += 1,
            b"*/" => depth = depth.saturating_sub(1),
            _ => {
                at += 1;
                continue;
            }
        }
        at += 2;
    }
    depth
}
