//! The names that functions use, resolved by scope: local names hide those of the module (WGSL §5).

use rustc_hash::{FxHashMap, FxHashSet};

use super::lexer::{Kind, WgslLexer, WgslToken};
use super::outline::{Class, Outline, OutlineItem};
use super::report;
use crate::syntax::reached;

/// The names that functions use, all by their index in the outline.
#[derive(Default)]
pub(super) struct Uses {
    functions: FxHashMap<usize, FxHashSet<usize>>,
    /// Textures with the samplers they are sampled with, both named in the call.
    pub(super) pairs: Vec<(usize, usize)>,
}

impl Uses {
    /// What a function and the functions it calls use.
    // Reachability in the graph of calls, the function itself included. WGSL forbids recursion, but
    // a text may have it.
    pub(super) fn reached(&self, function: usize) -> FxHashSet<usize> {
        reached([function], |one| self.functions.get(&one).into_iter().flatten().copied())
    }
}

pub(super) fn read<'a>(text: &'a str, outline: &Outline<'a>) -> Uses {
    let mut uses = Uses::default();
    for (index, item) in outline.items.iter().enumerate() {
        if item.class == Class::Fn {
            let mut used = FxHashSet::default();
            let pairs = &mut uses.pairs;
            walk(text, outline, item, &mut |names, word, _, lexer| {
                if let Word::Module(of) = word {
                    used.insert(of);
                }
                pairs.extend(names.pair(word, lexer));
            });
            uses.functions.insert(index, used);
        }
    }
    uses
}

/// What a word in a function is.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Word {
    /// A name of the module, by its index in the outline.
    Module(usize),
    Local,
    /// A member or components: what follows `.`.
    Member,
    /// A keyword, a predeclared name, or none.
    Other,
}

#[derive(Default)]
struct LocalScope<'a> {
    names: FxHashSet<&'a str>,
    /// Whether it is that of a `for`, which ends with the loop's body.
    is_loop: bool,
}

/// The names in effect at a place in a function.
pub(super) struct Names<'o, 'a> {
    outline: &'o Outline<'a>,
    scopes: Vec<LocalScope<'a>>,
    /// A local name that is declared from the next `;`.
    pending: Option<&'a str>,
}

/// Passes the words of a function's body to `see`, with the lexer after each. Words that declare a
/// name and attributes are left out.
// Words are classified without a parse: `let`, `const` and `var` declare the word after them,
// braces and `for` make scopes, a `.` makes a member. That is all that scopes of WGSL depend on
// (§5).
pub(super) fn walk<'a>(
    text: &'a str,
    outline: &Outline<'a>,
    item: &OutlineItem<'a>,
    see: &mut impl FnMut(&Names<'_, 'a>, Word, WgslToken, &WgslLexer<'a>),
) {
    let mut names = Names { outline, scopes: vec![LocalScope::default()], pending: None };
    let mut lexer = WgslLexer::new(text, item.rest);
    let mut before = None;
    let mut in_body = false;
    while let Some(token) = lexer.next_before(item.end) {
        match token.kind {
            Kind::Sign(b'{') => {
                in_body = true;
                names.scopes.push(LocalScope::default());
            }
            Kind::Sign(b'}') => names.close(),
            Kind::Sign(b';') => names.declare(),
            Kind::Sign(b'@') => {
                lexer.next();
                if lexer.take(b'(') {
                    let _ = report::skip_past(&mut lexer, b'(', b')');
                }
            }
            // `name:` in the head is a parameter; types and results are of the module.
            Kind::Word if !in_body => {
                let word = lexer.text_of(token);
                if lexer.peek().is(b':') {
                    names.scopes[0].names.insert(word);
                }
            }
            Kind::Word => {
                let word = lexer.text_of(token);
                match word {
                    _ if before == Some(b'.') => see(&names, Word::Member, token, &lexer),
                    "let" | "const" | "var" => names.pending = declared(&mut lexer),
                    "for" => {
                        names.scopes.push(LocalScope { is_loop: true, ..LocalScope::default() })
                    }
                    _ => see(&names, names.of(word), token, &lexer),
                }
            }
            Kind::Number | Kind::Sign(_) | Kind::End => {}
        }
        before = token.sign();
    }
}

impl<'a> Names<'_, 'a> {
    /// Leaves a scope, and that of a loop with the loop's body.
    fn close(&mut self) {
        self.declare();
        self.scopes.pop();
        if self.scopes.last().is_some_and(|scope| scope.is_loop) {
            self.scopes.pop();
        }
    }

    fn declare(&mut self) {
        if let (Some(name), Some(scope)) = (self.pending.take(), self.scopes.last_mut()) {
            scope.names.insert(name);
        }
    }

    fn of(&self, name: &str) -> Word {
        if self.scopes.iter().any(|scope| scope.names.contains(name)) {
            return Word::Local;
        }
        self.outline.names.get(name).map_or(Word::Other, |index| Word::Module(*index))
    }

    pub(super) fn locals(&self) -> impl Iterator<Item = &'a str> {
        self.scopes.iter().flat_map(|scope| &scope.names).copied()
    }

    /// The texture and the sampler in the arguments of a call.
    // Of `textureSample(t, s, …)`: the first two arguments, if they name variables of the module.
    fn pair(&self, word: Word, call: &WgslLexer<'a>) -> Option<(usize, usize)> {
        let mut lexer = call.clone();
        if word != Word::Other || !lexer.take(b'(') {
            return None;
        }
        let mut first = self.argument(&mut lexer);
        if first.is_none() {
            // `textureGather` begins with a component.
            first = self.argument(&mut lexer);
        }
        first.zip(self.argument(&mut lexer))
    }

    /// The declaration that an argument begins with; its `,` is consumed.
    // Only its first word counts: `textures[i]` is the variable `textures`.
    fn argument(&self, lexer: &mut WgslLexer<'a>) -> Option<usize> {
        let first: WgslToken = lexer.peek();
        let found = match first.kind {
            Kind::Word => match self.of(lexer.text_of(first)) {
                Word::Module(index) => Some(index),
                Word::Local | Word::Member | Word::Other => None,
            },
            Kind::Number | Kind::Sign(_) | Kind::End => None,
        };
        let mut depth = 0u32;
        loop {
            match lexer.peek().kind {
                Kind::Sign(b'(' | b'[') => depth += 1,
                Kind::Sign(b',') if depth == 0 => break,
                Kind::Sign(b')' | b']') if depth == 0 => return found,
                Kind::Sign(b')' | b']') => depth -= 1,
                Kind::End | Kind::Sign(b';') => return found,
                Kind::Word | Kind::Number | Kind::Sign(_) => {}
            }
            lexer.next();
        }
        lexer.next();
        found
    }
}

/// The name after `let`, `const` or `var`.
pub(super) fn declared<'a>(lexer: &mut WgslLexer<'a>) -> Option<&'a str> {
    if lexer.take(b'<') {
        while !matches!(lexer.next().kind, Kind::Sign(b'>') | Kind::End) {}
    }
    let name = lexer.next();
    (name.kind == Kind::Word).then(|| lexer.text_of(name))
}
