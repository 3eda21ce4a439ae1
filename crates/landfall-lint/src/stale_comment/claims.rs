//! Parses the numbers that a comment states: offsets, alignments, sizes, strides, totals.
//!
//! A number is a claim only if the words around it allow no other reading. Used by
//! [`checks`](super::checks) and [`columns`](super::columns).

use super::tokens::{CommentNumber, CommentWord, Kind, Sign, has_digit, tokens};
use landfall_layout::text::word_list::WordList;

#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct LayoutClaim {
    pub kind: Kind,
    pub number: CommentNumber,
    /// The end of `16 - 28`.
    pub to: Option<CommentNumber>,
    /// Whether the unit is stated as bytes.
    pub unit: bool,
    /// Whether a word names the quantity, not only the unit.
    pub keyword: bool,
}

/// The most claims of one comment, which bounds the time on hostile texts.
const MAX_CLAIMS: usize = 32;

/// The words that show that a comment is not about this layout.
const ELSEWHERE: WordList = WordList(
    "cpu host hlsl msl metal directx d3d c cpp rust packed tightly was were old formerly \
     previously should would instead not if when war früher vorher sollte statt nicht wenn 原来 之前 \
     如果",
);

/// The words that may precede a keyword without changing its meaning.
const NEUTRAL: WordList = WordList(
    "base aligned byte bytes struct structure block at starts begins beginnt liegt ab bei belegt \
     takes occupies its own the array matrix gpu glsl wgsl std140 std430 scalar element member \
     field in and with is has whole 占 占用 位于 每个 为 是",
);

/// The words between `starts` and `byte 16`.
const AT: WordList = WordList("at on in bei ab");

/// The words that say that a number of bytes is where something begins.
const BEGINS: WordList = WordList(
    "starts begins start begin located lies sits is beginnt startet liegt ab 从 位于 起始于",
);

/// Returns the claims of a comment about something of that name, laid out by those rules.
pub(super) fn claims(comment: &str, name: &str, rules: &str) -> Vec<LayoutClaim> {
    if !has_digit(comment) || is_code(comment) {
        return Vec::new();
    }
    let tokens = tokens(comment);
    if are_elsewhere(&tokens, rules) {
        return Vec::new();
    }
    let mut found = Vec::new();
    let mut at = 0;
    // Where the last claim ended: the next may follow it without a sign between.
    let mut follows = usize::MAX;
    while at < tokens.len() && found.len() < MAX_CLAIMS {
        let clause = opens_clause(&tokens, at, follows);
        // A claim begins with a word for a quantity, with a number, or with a unit.
        let read = match tokens[at].sign {
            Sign::Keyword(kind) => keyword_claim(&tokens, at, kind),
            Sign::Number(_) if clause || names_it(&tokens, at, comment, name) => {
                unit_claim(&tokens, at)
            }
            Sign::Unit => byte_claim(&tokens, at, clause),
            Sign::Number(_) | Sign::Text | Sign::Mark(_) | Sign::Odd => None,
        };
        let Some((claim, next, separated)) = read.filter(|read| closes(&tokens, read.1)) else {
            at += 1;
            continue;
        };
        // A word before it may make it something else: `uv offset: 4`.
        let before = at.checked_sub(1).map(|before| &tokens[before]);
        let free = before.filter(|word| match word.sign {
            Sign::Text => {
                let word = &*word.lower;
                let starts = matches!(tokens[at].sign, Sign::Unit) && BEGINS.contains(word);
                !starts && !NEUTRAL.contains(word) && word != name.to_lowercase()
            }
            Sign::Keyword(_) | Sign::Unit | Sign::Number(_) | Sign::Mark(_) | Sign::Odd => false,
        });
        let anchored = match free {
            None => clause || before.is_some_and(|word| !matches!(word.sign, Sign::Odd)),
            // `// 颜色 alignment:16`: what it is, then what it has; `// uv offset: 4` is no claim.
            Some(word) => {
                let described = !comment[word.range.clone()].is_ascii();
                separated && described && !matches!(claim.kind, Kind::Size | Kind::Total)
            }
        };
        if anchored || (free.is_some() && separated && claim.keyword) {
            found.push((claim, anchored));
        }
        at = next;
        follows = next;
    }
    // `// position alignment:16 offset:0`: together they can only be about the layout.
    let has = |kind| found.iter().any(|(claim, _): &(LayoutClaim, bool)| claim.kind == kind);
    let both = has(Kind::Align) && has(Kind::Offset);
    found.into_iter().filter(|(_, anchored)| *anchored || both).map(|(claim, _)| claim).collect()
}

/// Returns whether a comment is about other rules, the host or the past.
pub(super) fn is_elsewhere(comment: &str, rules: &str) -> bool {
    are_elsewhere(&tokens(comment), rules)
}

fn are_elsewhere(tokens: &[CommentWord], rules: &str) -> bool {
    tokens.iter().any(|token| match &token.sign {
        Sign::Text => {
            let word = &*token.lower;
            let other_rules = ["std140", "std430"].contains(&word) && word != rules;
            other_rules || ELSEWHERE.contains(word)
        }
        Sign::Keyword(_) | Sign::Unit | Sign::Number(_) | Sign::Mark(_) | Sign::Odd => false,
    })
}

/// `offset: 16`, `alignment 16 bytes`, `size = 12`, `offsets 16-27`, `@ 0x20`.
fn keyword_claim(
    tokens: &[CommentWord],
    at: usize,
    kind: Kind,
) -> Option<(LayoutClaim, usize, bool)> {
    let mut next = at + 1;
    // `offset in bytes: 16`, `alignment (bytes): 16`.
    let mut unit = false;
    if is_word(tokens, next, &["in"]) && matches!(tokens.get(next + 1)?.sign, Sign::Unit) {
        unit = true;
        next += 2;
    }
    let separated = match tokens.get(next)?.sign {
        Sign::Mark(mark @ (':' | '=' | '(')) => {
            next += 1;
            // `sizeof == 48`
            if mark == '=' && matches!(tokens.get(next)?.sign, Sign::Mark('=')) {
                next += 1;
            }
            true
        }
        Sign::Text if is_word(tokens, next, &["is", "of", "at", "为", "是"]) => {
            next += 1;
            false
        }
        Sign::Text
        | Sign::Number(_)
        | Sign::Keyword(_)
        | Sign::Unit
        | Sign::Mark(_)
        | Sign::Odd => false,
    };
    let opened = next > 0 && matches!(tokens[next - 1].sign, Sign::Mark('('));
    let number = number(tokens, next)?;
    next += 1;
    let mut to = None;
    if kind == Kind::Offset {
        if let Some((end, after)) = range_end(tokens, next) {
            to = Some(end);
            next = after;
        }
    }
    if matches!(tokens.get(next).map(|t| &t.sign), Some(Sign::Unit)) {
        unit = true;
        next += 1;
    }
    if opened && matches!(tokens.get(next).map(|t| &t.sign), Some(Sign::Mark(')'))) {
        next += 1;
    }
    Some((LayoutClaim { kind, number, to, unit, keyword: true }, next, separated))
}

/// `bytes 36-39`, `byte 16`, `starts at byte 16`, `从字节 16 开始`.
fn byte_claim(
    tokens: &[CommentWord],
    at: usize,
    clause: bool,
) -> Option<(LayoutClaim, usize, bool)> {
    let number = number(tokens, at + 1)?;
    let mut next = at + 2;
    let mut to = None;
    if let Some((end, after)) = range_end(tokens, next) {
        to = Some(end);
        next = after;
    }
    let before = |back: usize| at.checked_sub(back).map(|before| &tokens[before]);
    let opens =
        |word: Option<&CommentWord>| word.is_none_or(|word| matches!(word.sign, Sign::Mark(_)));
    let begins = |word: Option<&CommentWord>| word.is_some_and(|word| BEGINS.contains(&word.lower));
    let placed = before(1).is_some_and(|word| AT.contains(&word.lower))
        && (opens(before(2)) || begins(before(2)));
    if !clause && !placed && !begins(before(1)) {
        return None;
    }
    Some((LayoutClaim { kind: Kind::Offset, number, to, unit: true, keyword: true }, next, true))
}

/// `112 bytes`, `112 字节`, `112 bytes total`, `48 bytes each`, `每个 48 字节`.
fn unit_claim(tokens: &[CommentWord], at: usize) -> Option<(LayoutClaim, usize, bool)> {
    let number = number(tokens, at)?;
    let Sign::Unit = tokens.get(at + 1)?.sign else { return None };
    let mut next = at + 2;
    let mut kind = Kind::Size;
    if is_word(tokens, next, &["in"]) {
        next += 1;
    }
    match tokens.get(next).map(|token| &token.sign) {
        Some(Sign::Keyword(Kind::Total)) => {
            kind = Kind::Total;
            next += 1;
        }
        _ if is_word(tokens, next, &["all"]) => {
            kind = Kind::Total;
            next += 1;
        }
        _ if is_word(tokens, next, &["each", "apiece", "je", "jeweils"]) => {
            kind = Kind::Stride;
            next += 1;
        }
        // `48 bytes per light`.
        Some(Sign::Text) if is_word(tokens, next, &["per", "pro"]) => {
            kind = Kind::Stride;
            next += 2;
        }
        _ if at > 0 && is_word(tokens, at - 1, &["每个", "je", "jeweils"]) => kind = Kind::Stride,
        _ => {}
    }
    Some((LayoutClaim { kind, number, to: None, unit: true, keyword: false }, next, true))
}

/// `- 28`, `..28`, `to 28` behind a number.
pub(super) fn range_end(tokens: &[CommentWord], at: usize) -> Option<(CommentNumber, usize)> {
    let mut next = at;
    match tokens.get(next)?.sign {
        Sign::Mark('-' | '–' | '—' | '~' | '…') => next += 1,
        Sign::Mark('.') => {
            // `..`, `..=`, `..<`.
            while let Some(Sign::Mark('.' | '=' | '<')) = tokens.get(next).map(|t| &t.sign) {
                next += 1;
            }
        }
        Sign::Text if is_word(tokens, next, &["to", "bis", "到", "至"]) => next += 1,
        Sign::Text
        | Sign::Number(_)
        | Sign::Keyword(_)
        | Sign::Unit
        | Sign::Mark(_)
        | Sign::Odd => return None,
    }
    Some((number(tokens, next)?, next + 1))
}

fn number(tokens: &[CommentWord], at: usize) -> Option<CommentNumber> {
    match &tokens.get(at)?.sign {
        Sign::Number(number) => Some(number.clone()),
        Sign::Text | Sign::Keyword(_) | Sign::Unit | Sign::Mark(_) | Sign::Odd => None,
    }
}

fn is_word(tokens: &[CommentWord], at: usize, words: &[&str]) -> bool {
    tokens.get(at).is_some_and(|token| words.contains(&&*token.lower))
}

/// Whether a token starts a clause: first of all, behind a sign that ends one, or behind a claim.
fn opens_clause(tokens: &[CommentWord], at: usize, follows: usize) -> bool {
    let Some(before) = at.checked_sub(1).map(|before| &tokens[before]) else { return true };
    match before.sign {
        Sign::Mark(mark) => matches!(mark, ',' | ';' | '|' | '(' | '[' | '/' | '\n'),
        Sign::Text => {
            at == follows
                || is_word(
                    tokens,
                    at - 1,
                    &["takes", "occupies", "belegt", "je", "jeweils", "占", "占用", "每个"],
                )
        }
        Sign::Number(_) | Sign::Keyword(_) | Sign::Unit | Sign::Odd => at == follows,
    }
}

/// `PointLight: 48 bytes`, `PointLight is 48 bytes`, `= 48 bytes`.
fn names_it(tokens: &[CommentWord], at: usize, comment: &str, name: &str) -> bool {
    let Some(mut before) = at.checked_sub(1) else { return true };
    let joined = matches!(tokens[before].sign, Sign::Mark(':' | '='))
        || is_word(tokens, before, &["is", "为", "是"]);
    if !joined {
        return false;
    }
    if before == 0 {
        return true;
    }
    before -= 1;
    before == 0 && &comment[tokens[0].range.clone()] == name
}

/// Whether a claim may end before that token.
fn closes(tokens: &[CommentWord], at: usize) -> bool {
    match tokens.get(at).map(|token| &token.sign) {
        None | Some(Sign::Keyword(_)) => true,
        Some(Sign::Mark('.')) => {
            // A full stop, but neither a range nor a fraction.
            !matches!(tokens.get(at + 1).map(|t| &t.sign), Some(Sign::Mark('.') | Sign::Number(_)))
        }
        // `offset 16 - the colour`, not `offset 16 - 28`.
        Some(Sign::Mark('-' | '–' | '—')) => {
            matches!(tokens.get(at + 1).map(|t| &t.sign), None | Some(Sign::Text))
        }
        Some(Sign::Mark(mark)) => {
            matches!(mark, ',' | ';' | ':' | '|' | ')' | '(' | ']' | '/' | '\n')
        }
        Some(Sign::Text) => is_word(tokens, at, &["takes", "and", "开始"]),
        Some(Sign::Number(_) | Sign::Unit | Sign::Odd) => false,
    }
}

/// Returns whether a comment is a commented-out declaration, whose numbers mean something else.
pub(super) fn is_code(comment: &str) -> bool {
    let text = comment.trim_end_matches(['*', '/', ' ', '\n', '\t']).trim_end();
    let body = comment.trim_start_matches(['/', '*', '!', '<', ' ', '\t', '\n']);
    // `// float old; // offset 12`
    let declares = body.split_once("//").is_some_and(|(before, _)| declares(before.trim()));
    declares
        || text.ends_with([';', '{', '}'])
        || comment.contains("layout")
        || comment.contains("#define")
        || comment.contains("@size(")
        || comment.contains("@align(")
}

/// Returns whether that is a member of GLSL or WGSL: `float old;`, `old: array<vec4f, 4>,`.
fn declares(text: &str) -> bool {
    if text.ends_with(';') {
        return true;
    }
    let Some((name, ty)) = text.trim_end_matches(',').split_once(':') else { return false };
    let is_name = |c: char| c.is_alphanumeric() || c == '_';
    let ty = ty.trim();
    let word = ty.split(|c| !is_name(c)).next().unwrap_or("");
    let is_type = ["vec", "mat", "array", "atomic", "f32", "i32", "u32", "f16"]
        .iter()
        .any(|known| word.starts_with(known));
    !name.is_empty() && name.trim().chars().all(is_name) && is_type
}

/// Returns whether a line is about bytes between members, as the rows of the specification of WGSL
/// and of `--format listing` are.
pub(super) fn is_about_padding(line: &str) -> bool {
    let line = line.to_lowercase();
    ["padding", "hole", "unused", "filler", "füll", "填充"].iter().any(|word| line.contains(word))
}
