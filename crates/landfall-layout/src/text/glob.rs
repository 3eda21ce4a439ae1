//! Globs of paths, by which settings and arguments select files.
//!
//! `*` and `?` match within a directory, `**` across directories, `{a,b}` either alternative,
//! `[a-z]` one character of a set, `\` takes the special meaning from what follows it.

#[cfg(test)]
mod tests;

use std::fmt;

/// The most patterns that the braces of a glob stand for.
const MAX_ALTERNATIVES: usize = 256;

/// The most characters that those patterns have together.
const MAX_TOKENS: usize = 16_384;

/// Maximum nesting of braces.
const DEEPEST_BRACES: usize = 16;

/// Maximum length in bytes.
const LONGEST: usize = 4096;

/// A parsed glob.
#[derive(Clone, Debug)]
pub struct Glob {
    alternatives: Vec<GlobPattern>,
}

#[derive(Clone, Debug)]
struct GlobPattern {
    tokens: Vec<GlobToken>,
    /// The literal text at its end, which tells most paths apart.
    end: String,
}

/// Why a text is not a glob.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum GlobError {
    /// A `[` without its `]`.
    OpenClass,
    /// A `{` without its `}`.
    OpenBrace,
    /// A `}` without its `{`.
    UnopenedBrace,
    /// A `\` at the end.
    TrailingBackslash,
    /// `[z-a]`.
    EmptyRange(char, char),
    /// Too many bytes.
    TooLong,
    /// Too many braces in one another.
    TooDeep,
    /// Braces that stand for too many patterns, or for too long ones.
    TooManyAlternatives,
}

impl fmt::Display for GlobError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            GlobError::OpenClass => f.write_str("a `[` is not closed by a `]`"),
            GlobError::OpenBrace => f.write_str("a `{` is not closed by a `}`"),
            GlobError::UnopenedBrace => f.write_str("a `}` closes no `{`"),
            GlobError::TrailingBackslash => f.write_str("nothing follows the `\\` at its end"),
            GlobError::EmptyRange(from, to) => write!(f, "the range `{from}-{to}` is empty"),
            GlobError::TooLong => write!(f, "it has more than {LONGEST} bytes"),
            GlobError::TooDeep => write!(f, "its braces nest more than {DEEPEST_BRACES} deep"),
            GlobError::TooManyAlternatives => {
                write!(
                    f,
                    "its braces stand for more than {MAX_ALTERNATIVES} patterns, or {MAX_TOKENS} \
                     characters"
                )
            }
        }
    }
}

impl std::error::Error for GlobError {}

#[derive(Clone, Debug, PartialEq)]
enum GlobToken {
    Literal(char),
    /// `?`.
    Any,
    /// `[a-z]`, or `[!a-z]`.
    Class {
        ranges: Vec<(char, char)>,
        negated: bool,
    },
    /// `*`.
    Star,
    /// `**`.
    DeepStar,
    /// `**/` at the start of a component: any directories, or none.
    Directories,
    Open,
    Comma,
    Close,
}

impl Glob {
    /// Parses a glob of a setting or an argument. On Windows, `\` separates directories.
    ///
    /// # Errors
    ///
    /// Its brackets or braces are not balanced, or it exceeds a limit.
    pub fn new(text: &str) -> Result<Glob, GlobError> {
        if cfg!(windows) { Glob::escaped(&text.replace('\\', "/")) } else { Glob::escaped(text) }
    }

    /// Parses a glob in which `\` escapes on all systems, as in an ignore file.
    ///
    /// # Errors
    ///
    /// As of [`Glob::new`].
    pub fn escaped(text: &str) -> Result<Glob, GlobError> {
        if text.len() > LONGEST {
            return Err(GlobError::TooLong);
        }
        let tokens = tokens(text)?;
        // Braces are expanded first: a run of stars may only come about by that.
        let alternatives = expanded(&mut tokens.into_iter(), false)?;
        let alternatives = alternatives.iter().map(|pattern| {
            let tokens = with_deep_stars(pattern);
            let literal =
                |token: &GlobToken| if let GlobToken::Literal(c) = token { Some(*c) } else { None };
            let end: Vec<char> = tokens.iter().rev().map_while(literal).collect();
            GlobPattern { tokens, end: end.into_iter().rev().collect() }
        });
        Ok(Glob { alternatives: alternatives.collect() })
    }

    /// The number of characters of all patterns that it stands for.
    pub fn size(&self) -> usize {
        self.alternatives.iter().map(|pattern| pattern.tokens.len()).sum()
    }

    /// The glob of a path's end, from some directory on.
    #[must_use]
    pub fn anywhere(mut self) -> Glob {
        for pattern in &mut self.alternatives {
            if pattern.tokens.first() != Some(&GlobToken::Directories) {
                pattern.tokens.insert(0, GlobToken::Directories);
            }
        }
        self
    }

    /// Whether it matches a path, whose directories are separated by `/`.
    pub fn matches(&self, path: &str) -> bool {
        // Most paths fail at the literal end, before any matching.
        let mut patterns = self.alternatives.iter();
        patterns.any(|p| path.ends_with(&p.end) && matches_pattern(&p.tokens, path, false))
    }

    /// Whether it matches a path or a directory that contains it.
    pub fn contains(&self, path: &str) -> bool {
        self.alternatives.iter().any(|pattern| matches_pattern(&pattern.tokens, path, true))
    }
}

/// A text as a glob that matches this text alone.
pub fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for sign in text.chars() {
        match sign {
            '*' | '?' | '[' | '{' | '}' => out.extend(['[', sign, ']']),
            '\\' if !cfg!(windows) => out.push_str("\\\\"),
            sign => out.push(sign),
        }
    }
    out
}

/// Whether a glob matches a path, or its end from some directory on: `lights/*.frag` matches
/// `shaders/lights/point.frag`. An empty one matches every path, one that is not valid none.
pub fn matches(pattern: &str, path: &str) -> bool {
    let pattern = pattern.trim().trim_start_matches("./");
    if pattern.is_empty() {
        return true;
    }
    let path = path.replace('\\', "/");
    let glob = Glob::new(pattern).map(Glob::anywhere);
    glob.is_ok_and(|glob| glob.matches(path.trim_start_matches("./")))
}

fn tokens(text: &str) -> Result<Vec<GlobToken>, GlobError> {
    let mut tokens = Vec::with_capacity(text.len());
    let mut rest = text;
    let mut depth = 0;
    while let Some(sign) = rest.chars().next() {
        rest = &rest[sign.len_utf8()..];
        tokens.push(match sign {
            '?' => GlobToken::Any,
            '*' => GlobToken::Star,
            '[' => {
                let (class, after) = class(rest)?;
                rest = after;
                class
            }
            '{' => {
                depth += 1;
                GlobToken::Open
            }
            '}' if depth == 0 => return Err(GlobError::UnopenedBrace),
            '}' => {
                depth -= 1;
                GlobToken::Close
            }
            ',' if depth > 0 => GlobToken::Comma,
            '\\' => {
                let escaped = rest.chars().next().ok_or(GlobError::TrailingBackslash)?;
                rest = &rest[escaped.len_utf8()..];
                GlobToken::Literal(escaped)
            }
            sign => GlobToken::Literal(sign),
        });
        if depth > DEEPEST_BRACES {
            return Err(GlobError::TooDeep);
        }
    }
    if depth > 0 { Err(GlobError::OpenBrace) } else { Ok(tokens) }
}

/// The class after a `[`, and what follows it. A `]` at its start is a member.
fn class(text: &str) -> Result<(GlobToken, &str), GlobError> {
    let inside = text.strip_prefix(['!', '^']);
    let negated = inside.is_some();
    let mut rest = inside.unwrap_or(text).chars();
    let mut ranges = Vec::new();
    // The next character of the class, or the one that a `\` escapes.
    let next = |rest: &mut std::str::Chars<'_>| match rest.next() {
        Some('\\') => rest.next().ok_or(GlobError::OpenClass),
        sign => sign.ok_or(GlobError::OpenClass),
    };
    loop {
        // At its start a `]` is a member, as POSIX has it.
        if !ranges.is_empty() && rest.as_str().starts_with(']') {
            return Ok((GlobToken::Class { ranges, negated }, &rest.as_str()[1..]));
        }
        let from = next(&mut rest)?;
        // A `-` before the `]` is a member.
        let is_range = rest.as_str().strip_prefix('-').is_some_and(|end| !end.starts_with(']'));
        let to = if is_range {
            rest.next();
            next(&mut rest)?
        } else {
            from
        };
        if from > to {
            return Err(GlobError::EmptyRange(from, to));
        }
        ranges.push((from, to));
    }
}

/// The patterns that a sequence stands for; `inside` braces it ends at a comma or the closing one.
fn expanded(
    tokens: &mut std::vec::IntoIter<GlobToken>,
    inside: bool,
) -> Result<Vec<Vec<GlobToken>>, GlobError> {
    // Those of all sequences before a comma, and of the current one.
    let mut ended: Vec<Vec<GlobToken>> = Vec::new();
    let mut current: Vec<Vec<GlobToken>> = vec![Vec::new()];
    while let Some(token) = tokens.next() {
        match token {
            GlobToken::Open => {
                let parts = expanded(tokens, true)?;
                if current.len() * parts.len() > MAX_ALTERNATIVES {
                    return Err(GlobError::TooManyAlternatives);
                }
                // Each pattern so far goes on with each alternative.
                let joined = |start: &Vec<GlobToken>| {
                    let start = start.clone();
                    parts.iter().map(move |part| [&start[..], part].concat())
                };
                current = current.iter().flat_map(joined).collect();
            }
            GlobToken::Comma => {
                ended.append(&mut std::mem::replace(&mut current, vec![Vec::new()]))
            }
            GlobToken::Close if inside => break,
            token => current.iter_mut().for_each(|pattern| pattern.push(token.clone())),
        }
        // The limits are checked with each token, so that nested braces end before they use up
        // memory.
        let lengths = ended.iter().chain(&current).map(Vec::len);
        if ended.len() + current.len() > MAX_ALTERNATIVES || lengths.sum::<usize>() > MAX_TOKENS {
            return Err(GlobError::TooManyAlternatives);
        }
    }
    ended.append(&mut current);
    Ok(ended)
}

/// A pattern with one token for each run of stars.
fn with_deep_stars(pattern: &[GlobToken]) -> Vec<GlobToken> {
    let mut out: Vec<GlobToken> = Vec::with_capacity(pattern.len());
    let mut at = 0;
    while let Some(token) = pattern.get(at) {
        let stars = pattern[at..].iter().take_while(|t| **t == GlobToken::Star).count();
        if stars < 2 {
            out.push(token.clone());
            at += 1;
            continue;
        }
        at += stars;
        // `**/` stands for any directories, or none, only where a component starts.
        let starts = out
            .last()
            .is_none_or(|t| *t == GlobToken::Literal('/') || *t == GlobToken::Directories);
        if starts && pattern.get(at) == Some(&GlobToken::Literal('/')) {
            at += 1;
            out.push(GlobToken::Directories);
        } else {
            out.push(GlobToken::DeepStar);
        }
    }
    out
}

impl GlobToken {
    /// The length of the character at the start of a text, if it matches.
    fn length_in(&self, text: &str) -> Option<usize> {
        let found = text.chars().next()?;
        let fits = match self {
            GlobToken::Literal(sign) => *sign == found,
            GlobToken::Any => found != '/',
            GlobToken::Class { ranges, negated } => {
                let holds = ranges.iter().any(|(from, to)| (*from..=*to).contains(&found));
                found != '/' && holds != *negated
            }
            _ => false,
        };
        fits.then(|| found.len_utf8())
    }
}

/// Whether a pattern matches a whole path, or with `below` a directory that contains it.
///
/// On a mismatch the last `*` takes one character more, and once it has reached the end of its
/// directory, the last `**`. Earlier ones need not be tried again, because the text between two
/// stars is found at its first place. A `**` before a `*` goes on after the next `/`: from other
/// places in a name, the `*` has fewer ways to match.
fn matches_pattern(pattern: &[GlobToken], path: &str, below: bool) -> bool {
    let (mut token, mut at) = (0, 0);
    // What follows the star, and the start of the path that remains after its match.
    let mut star: Option<(usize, usize)> = None;
    let mut deep: Option<(usize, usize)> = None;
    // Whether a `*` was met since the last `**` took more.
    let mut has_star = false;
    loop {
        // Each round matches one token, or goes back to a star.
        let rest = &path[at..];
        match pattern.get(token) {
            None if rest.is_empty() || below && rest.starts_with('/') => return true,
            Some(GlobToken::Star) => {
                token += 1;
                (star, has_star) = (Some((token, at)), true);
                continue;
            }
            Some(GlobToken::DeepStar | GlobToken::Directories) => {
                token += 1;
                (star, deep, has_star) = (None, Some((token, at)), false);
                continue;
            }
            Some(single) => {
                if let Some(length) = single.length_in(rest) {
                    // A `*` before a `/` has matched the rest of its directory's name.
                    star = star.filter(|_| !rest.starts_with('/'));
                    token += 1;
                    at += length;
                    continue;
                }
            }
            None => {}
        }
        let more = star.and_then(|(after, from)| {
            let length = GlobToken::Any.length_in(&path[from..])?;
            Some((after, from + length))
        });
        star = more;
        if let Some(more) = more {
            (token, at) = more;
            continue;
        }
        // No `*` can take more: the last `**` does.
        let Some((after, from)) = deep else { return false };
        let rest = &path[from..];
        let length = if has_star || pattern[after - 1] == GlobToken::Directories {
            rest.find('/').map(|end| end + 1)
        } else {
            rest.chars().next().map(char::len_utf8)
        };
        let Some(length) = length else { return false };
        (deep, has_star) = (Some((after, from + length)), false);
        (token, at) = (after, from + length);
    }
}
