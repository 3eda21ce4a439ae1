//! The module-scope names that functions use; local names hide them by scope (WGSL §5).

use rustc_hash::{FxHashMap, FxHashSet};

use super::lexer::{Kind, Lexer, Token};
use super::outline::{Class, Item, Outline};

/// The names that functions use, all by their index in the outline.
#[derive(Default)]
pub(super) struct Uses {
    functions: FxHashMap<usize, FxHashSet<usize>>,
    /// Textures with the samplers they are sampled with, both named in the call.
    pub(super) pairs: Vec<(usize, usize)>,
}

impl Uses {
    /// What a function and the functions it calls use.
    pub(super) fn reached(&self, function: usize) -> Vec<usize> {
        let mut reached = FxHashSet::from_iter([function]);
        let mut open = vec![function];
        while let Some(one) = open.pop() {
            for &used in self.functions.get(&one).into_iter().flatten() {
                if reached.insert(used) {
                    open.push(used);
                }
            }
        }
        reached.into_iter().collect()
    }
}

/// Reads every function of a text.
pub(super) fn read<'a>(text: &'a str, outline: &Outline<'a>) -> Uses {
    let mut uses = Uses::default();
    for (index, item) in outline.items.iter().enumerate() {
        if item.class == Class::Fn {
            let mut body = Body { outline, scopes: vec![Scope::default()], pending: None };
            let used = body.read(text, item, &mut uses.pairs);
            uses.functions.insert(index, used);
        }
    }
    uses
}

#[derive(Default)]
struct Scope<'a> {
    names: FxHashSet<&'a str>,
    /// Whether it is that of a `for`, which ends with the loop's body.
    is_loop: bool,
}

struct Body<'o, 'a> {
    outline: &'o Outline<'a>,
    scopes: Vec<Scope<'a>>,
    /// A local name that is declared from the next `;`.
    pending: Option<&'a str>,
}

impl<'a> Body<'_, 'a> {
    fn read(
        &mut self,
        text: &'a str,
        item: &Item<'a>,
        pairs: &mut Vec<(usize, usize)>,
    ) -> FxHashSet<usize> {
        let mut used = FxHashSet::default();
        let mut lexer = Lexer::new(text, item.rest);
        let mut before = None;
        let mut in_body = false;
        loop {
            let token = lexer.next();
            if token.kind == Kind::End || token.start >= item.end {
                return used;
            }
            match token.kind {
                Kind::Sign(b'{') => {
                    in_body = true;
                    self.scopes.push(Scope::default());
                }
                Kind::Sign(b'}') => self.close(),
                Kind::Sign(b';') => self.declare(),
                Kind::Word if !matches!(before, Some(b'.' | b'@')) => {
                    let word = lexer.text_of(token);
                    match word {
                        "let" | "const" | "var" => self.pending = declared(&mut lexer),
                        "for" => self.scopes.push(Scope { is_loop: true, ..Scope::default() }),
                        _ if !in_body && lexer.peek().is(b':') => {
                            self.scopes[0].names.insert(word);
                        }
                        _ => {
                            used.extend(self.global(word));
                            if sampler_call(word) {
                                pairs.extend(self.pair(&lexer));
                            }
                        }
                    }
                }
                Kind::Word | Kind::Number | Kind::Sign(_) | Kind::End => {}
            }
            before = match token.kind {
                Kind::Sign(sign) => Some(sign),
                Kind::Word | Kind::Number | Kind::End => None,
            };
        }
    }

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

    /// The declaration that a name stands for at module scope.
    fn global(&self, name: &str) -> Option<usize> {
        let is_local = self.scopes.iter().any(|scope| scope.names.contains(name));
        self.outline.names.get(name).copied().filter(|_| !is_local)
    }

    /// The texture and the sampler in the arguments of a call.
    fn pair(&self, call: &Lexer<'a>) -> Option<(usize, usize)> {
        let mut lexer = call.clone();
        if !lexer.take(b'(') {
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
    fn argument(&self, lexer: &mut Lexer<'a>) -> Option<usize> {
        let first: Token = lexer.peek();
        let found = match first.kind {
            Kind::Word => self.global(lexer.text_of(first)),
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

fn sampler_call(name: &str) -> bool {
    name.starts_with("textureSample") || name.starts_with("textureGather")
}

/// The name after `let`, `const` or `var`.
fn declared<'a>(lexer: &mut Lexer<'a>) -> Option<&'a str> {
    if lexer.take(b'<') {
        while !matches!(lexer.next().kind, Kind::Sign(b'>') | Kind::End) {}
    }
    let name = lexer.next();
    (name.kind == Kind::Word).then(|| lexer.text_of(name))
}
