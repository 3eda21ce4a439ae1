//! The local names of a function that are written once, with their expressions.

use std::collections::HashMap;
use std::ops::Range;

use super::formula::Formula;

#[derive(Clone, Debug, Default)]
pub(super) struct Names(HashMap<String, Formula>);

impl Names {
    /// Returns the names that are declared before a byte of a text, in the same function.
    pub fn before(text: &str, at: usize) -> Names {
        let each = declarations(text, at).into_iter();
        let read =
            |(name, at): (&str, Range<usize>)| Some((name.to_string(), Formula::read(&text[at])?));
        Names(each.filter_map(read).collect())
    }

    /// Returns the name of an expression: of several the first in the alphabet.
    pub fn name_of(&self, formula: &Formula) -> Option<String> {
        let own = self.0.iter().filter(|(_, of)| *of == formula);
        own.map(|(name, _)| name.clone()).min()
    }

    /// Returns the expression of a name, or the formula itself.
    pub fn read(&self, formula: &Formula) -> Formula {
        // Names stand for names: `float d2 = d; float e = d2;`.
        let mut formula = formula;
        // A name's expression has only earlier names.
        for _ in 0..self.0.len() {
            match formula {
                Formula::Leaf(name) => match self.0.get(name) {
                    Some(of) => formula = of,
                    None => break,
                },
                _ => break,
            }
        }
        formula.clone()
    }
}

/// Returns the bytes of the expression that a name is declared with before a byte of a text, in the
/// same function.
pub(super) fn declaration(text: &str, at: usize, name: &str) -> Option<Range<usize>> {
    declarations(text, at).into_iter().find(|(own, _)| *own == name).map(|(_, place)| place)
}

/// Returns the names that are written once, where they are declared, with their expressions' bytes.
fn declarations(text: &str, at: usize) -> Vec<(&str, Range<usize>)> {
    // A function of the text, as far as formatted code tells: from a line that starts with `}` to
    // the next one.
    let start = text[..at].rfind("\n}").map_or(0, |found| found + 2);
    let end = text[at..].find("\n}").map_or(text.len(), |found| at + found);
    let function = &text[start..end];
    let ends = [';', '{', '}'];
    let mut all = Vec::new();
    let mut next = start;
    // Statements end at `;` or a brace; a declaration is what has `=` and two words or a type
    // before it.
    for statement in text[start..at].split_inclusive(ends) {
        let first = next;
        next += statement.len();
        let statement = statement.trim_end_matches(ends);
        let Some((left, _)) = statement.split_once('=') else { continue };
        let place = first + left.len() + 1..first + statement.len();
        let left = left.split("//").last().unwrap_or(left);
        // `let x: f32 = …`, `float x = …`
        let words: Vec<&str> = left.split(':').next().unwrap_or(left).split_whitespace().collect();
        let [.., _, name] = words[..] else { continue };
        // Written once, or the expression may not be its value where it is used.
        if writes(function, name) == 1 {
            all.push((name, place));
        }
    }
    all
}

/// Returns how often a name is written in a text.
fn writes(text: &str, name: &str) -> usize {
    let is_part = |c: char| c.is_alphanumeric() || c == '_';
    let written = |(at, _): &(usize, &str)| {
        let before = text[..*at].chars().next_back().is_some_and(is_part);
        let rest = &text[at + name.len()..];
        if before || rest.starts_with(is_part) {
            return false;
        }
        // Components count as writes to the whole: `v.x = 1.0`.
        let rest = rest.trim_start().trim_start_matches(|c| c == '.' || is_part(c)).trim_start();
        let typed = rest.strip_prefix(':').and_then(|rest| rest.split_once('=')).is_some();
        let plain = rest.starts_with('=') && !rest.starts_with("==");
        let compound = ["+=", "-=", "*=", "/=", "++", "--"].iter().any(|op| rest.starts_with(op));
        let step = text[..*at].trim_end().ends_with("++") || text[..*at].trim_end().ends_with("--");
        plain || compound || typed || step
    };
    text.match_indices(name).filter(written).count()
}
