//! The declarators of a GLSL declaration, split at its tokens.
//!
//! Used by [`rewrite`](super) for declarations whose initialisers are postponed.

/// One declarator of a declaration.
pub(super) struct RewrittenDeclarator<'w, 't> {
    /// The name with its dimensions; the first declarator with its type too: `vec3 n`, then
    /// `q [ 2 ]`.
    pub target: &'w [&'t str],
    /// The initialiser.
    pub value: Option<&'w [&'t str]>,
}

impl<'w, 't> RewrittenDeclarator<'w, 't> {
    /// Parses the tokens of one declarator.
    pub fn new(tokens: &'w [&'t str]) -> RewrittenDeclarator<'w, 't> {
        let mut parts = split(tokens, "=");
        RewrittenDeclarator { target: parts.next().unwrap_or_default(), value: parts.next() }
    }

    /// Returns the index of the name in [`RewrittenDeclarator::target`], before its dimensions.
    pub fn name_index(&self) -> Option<usize> {
        let mut depth = 0u32;
        self.target.iter().rposition(|token| {
            match *token {
                "]" => depth += 1,
                "[" => depth = depth.saturating_sub(1),
                _ => return depth == 0,
            }
            false
        })
    }

    /// Returns the declared name.
    pub fn name(&self) -> Option<&'t str> {
        self.name_index().map(|at| self.target[at])
    }

    /// Returns the type before the name; a structure defined here by its name.
    pub fn ty(&self) -> Option<Vec<&'t str>> {
        let tokens = self.target[..self.name_index()?].to_vec();
        match tokens.iter().position(|token| *token == "struct") {
            Some(at) => tokens.get(at + 1).map(|name| vec![*name]),
            None => Some(tokens),
        }
    }
}

/// Splits tokens at a separator outside brackets.
pub(super) fn split<'w, 't>(
    tokens: &'w [&'t str],
    separator: &'static str,
) -> impl Iterator<Item = &'w [&'t str]> + use<'w, 't> {
    let mut depth = 0u32;
    tokens.split(move |token| {
        match *token {
            "(" | "[" | "{" => depth += 1,
            ")" | "]" | "}" => depth = depth.saturating_sub(1),
            _ => {}
        }
        depth == 0 && *token == separator
    })
}

/// Returns the number of elements of `float[](a, b)` or `{ a, b }`; with a level above 0, that of
/// their first element at that depth.
pub(super) fn elements(value: &[&str], level: usize) -> usize {
    let opening = value.iter().position(|token| matches!(*token, "(" | "{")).unwrap_or(0);
    let inside = value.get(opening + 1..value.len().saturating_sub(1)).unwrap_or_default();
    // A trailing comma is allowed.
    let mut each = split(inside, ",").filter(|element| !element.is_empty());
    match level.checked_sub(1) {
        None => each.count(),
        Some(level) => each.next().map_or(0, |first| elements(first, level)),
    }
}
