//! The limits within which a text is given to naga, which recurses on a text's nesting without a bound
//! of its own. Only code counts: comments, directives and text between `#if 0` and its end do not.

use rustc_hash::FxHashMap;

use super::code::{code, continuations, joined};
use crate::source::Language;

/// The limit on nested brackets: naga recurses on them without a bound of its own.
const DEEPEST_BRACKETS: u64 = 64;

/// The limit on chained operators with nested operands: `1 + 1 + 1 + …`, `a ? b : c ? …`.
const LONGEST_CHAIN: u64 = 200;

/// The limit on declarations, which may depend on each other, and on functions, which naga compares
/// with all others of their name.
const MAX_STATEMENTS: u64 = 4_000;

/// The limit on members of nested structures: naga 30.0.1 visits every member of every member when
/// it lays out a GLSL structure, and when it validates one of either language.
const MAX_NESTED_MEMBERS: u64 = 1 << 16;

/// The limit on the words of a WGSL function, and on the root of the sum of their squares for all
/// functions: naga 30.0.1 walks over all expressions of a function for each of them. At the limit it
/// takes 0.12 s of processor time in a release build, and four times the words take 1.6 s.
const MAX_WORDS: u64 = 16_000;

/// The limit on line continuations in a row: naga's preprocessor recurses on them.
const MAX_CONTINUATIONS: u64 = 1_000;

/// The limit on the length of a text in bytes of code.
const LONGEST_TEXT: u64 = 1 << 20;

/// Returns what in a text is beyond a limit for naga, with the limit: `has functions of 20000 words,
/// more than the 16000 that naga is given`.
pub fn excess(text: &str, language: Language) -> Option<String> {
    let beyond = |count: u64, most: u64, what: &str| {
        (count > most).then(|| format!("{what}, more than the {most} that naga is given"))
    };
    let of =
        |count: u64, most: u64, what: &str| beyond(count, most, &format!("has {count} {what}"));
    // Before lines are joined, which naga does by recursion.
    let continued = of(continuations(text, language), MAX_CONTINUATIONS, "joined lines in a row");
    if continued.is_some() {
        return continued;
    }
    let text = joined(text, language);
    let tokens = code(&text, language);
    let bytes: u64 = tokens.iter().map(|token| token.len() as u64).sum();
    let statements = || tokens.iter().filter(|token| matches!(**token, ";" | "{")).count() as u64;
    // Cheap counts come first: each needs one pass over the tokens.
    let words = || squared_words(&tokens).isqrt();
    of(bytes, LONGEST_TEXT, "bytes of code")
        .or_else(|| {
            of(nesting(&tokens), DEEPEST_BRACKETS, "brackets or prefix operators in each other")
        })
        .or_else(|| of(longest_chain(&tokens), LONGEST_CHAIN, "operators in one expression"))
        .or_else(|| of(statements(), MAX_STATEMENTS, "statements, members and bodies"))
        .or_else(|| of(nested_members(&tokens), MAX_NESTED_MEMBERS, "members in nested structures"))
        .or_else(|| {
            let words = words();
            let what = format!("has a function of {words} words, or several of as much work");
            beyond(words, MAX_WORDS, &what)
        })
}

fn is_word(token: &str) -> bool {
    token.starts_with(|c: char| c.is_alphanumeric() || c == '_')
}

/// Estimates the number of members of a text's structures, counting the members of nested
/// structures each time: a word inside the braces of a structure that names an earlier one stands
/// for all of its members.
fn nested_members(tokens: &[&str]) -> u64 {
    let mut sizes: FxHashMap<&str, u64> = FxHashMap::default();
    let mut all = 0u64;
    let mut rest = tokens;
    // Structures in the order of the text: those that a body names are sized already.
    while let Some(at) = rest.iter().position(|token| *token == "struct") {
        rest = &rest[at + 1..];
        let name = rest.first().copied().filter(|token| is_word(token));
        rest = &rest[usize::from(name.is_some())..];
        let Some((&"{", body)) = rest.split_first() else { continue };
        let body = body.iter().take_while(|token| **token != "}");
        let words = body.filter(|token| is_word(token));
        let size = words
            .fold(0u64, |sum, word| sum.saturating_add(sizes.get(*word).copied().unwrap_or(1)));
        all = all.saturating_add(size);
        sizes.insert(name.unwrap_or_default(), size);
    }
    all
}

/// Returns the sum of the squares of the numbers of words between `fn` and the next one.
fn squared_words(tokens: &[&str]) -> u64 {
    let (mut sum, mut words, mut is_function) = (0u64, 0u64, false);
    // A last `fn` ends the last function; words before the first one are in none.
    for word in tokens.iter().copied().filter(|token| is_word(token)).chain(["fn"]) {
        match word {
            "fn" if is_function => {
                sum = sum.saturating_add(words * words);
                words = 0;
            }
            "fn" => is_function = true,
            _ => words += u64::from(is_function),
        }
    }
    sum
}

/// Returns the greatest nesting of brackets; a run of prefix operators counts as nesting.
fn nesting(tokens: &[&str]) -> u64 {
    let (mut open, mut deepest, mut prefixes) = (0u64, 0u64, 0u64);
    for token in tokens {
        // Signs that are infix as well count only in a row: `a - b` has a run of one.
        prefixes = if matches!(*token, "-" | "!" | "~" | "&" | "*") { prefixes + 1 } else { 0 };
        match *token {
            "(" | "[" | "{" | "<" => open += 1,
            ")" | "]" | "}" | ">" => open = open.saturating_sub(1),
            // `<` may be a comparison: no template list extends past this.
            ";" => open = 0,
            _ => {}
        }
        deepest = deepest.max(open).max(prefixes);
    }
    deepest
}

/// Returns the longest run of operators without a comma or semicolon; naga recurses on their
/// operands.
fn longest_chain(tokens: &[&str]) -> u64 {
    let (mut chain, mut longest) = (0u64, 0u64);
    for token in tokens {
        match *token {
            "," | ";" | "{" | "}" => chain = 0,
            "+" | "-" | "*" | "/" | "%" | "?" | "&" | "|" | "^" | "=" | "<" | ">" => chain += 1,
            _ => {}
        }
        longest = longest.max(chain);
    }
    longest
}

#[cfg(test)]
mod tests;
