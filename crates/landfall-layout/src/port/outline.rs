//! The global declarations of a shader as ranges of its tokens: what stands
//! where, so that it can be edited. Types are not resolved.

use std::ops::Range;

use rustc_hash::FxHashSet;

use crate::syntax::glsl::lexer::Kind;
use crate::syntax::glsl::qualifiers::is_qualifier;
use crate::syntax::glsl::raw::RawText;

/// A token the compiler reads, outside directives.
#[derive(Clone, Copy, Debug)]
pub(super) struct Token<'a> {
    pub kind: Kind,
    pub text: &'a str,
    /// First byte.
    pub start: usize,
    /// One past the last byte.
    pub end: usize,
}

/// Indices of tokens.
pub(super) type Tokens = Range<usize>;

/// A global declaration. Ranges include its `;` or `}`.
#[derive(Clone, Debug)]
pub(super) enum Declaration {
    /// `struct NAME { … };`
    Structure(Structure),
    /// `uniform NAME { … } instance;`, and `in` and `out` blocks.
    Block(Block),
    /// Variables of any storage.
    Variables(Variables),
    /// A function or its prototype.
    Function(Function),
    /// `layout(…) uniform;`
    Defaults,
    /// `precision mediump float;`
    Precision,
    /// `invariant gl_Position;` and what is not understood.
    Other(Tokens),
}

/// The qualifiers of a declaration.
#[derive(Clone, Debug, Default)]
pub(super) struct Qualifiers {
    /// Single words.
    pub words: Vec<usize>,
    /// What stands between the brackets of each `layout(…)`.
    pub layouts: Vec<Tokens>,
}

#[derive(Clone, Debug)]
pub(super) struct Structure {
    pub tokens: Tokens,
    /// `None` for `struct { … }`.
    pub name: Option<usize>,
    pub members: Vec<Variables>,
    /// From `struct` to `}`.
    pub body: Tokens,
}

#[derive(Clone, Debug)]
pub(super) struct Block {
    pub tokens: Tokens,
    pub qualifiers: Qualifiers,
    pub name: usize,
    pub members: Vec<Variables>,
}

#[derive(Clone, Debug)]
pub(super) struct Variables {
    pub tokens: Tokens,
    pub qualifiers: Qualifiers,
    /// The type's name, or `struct`.
    pub ty: usize,
    pub structure: Option<Structure>,
    pub type_dims: Vec<Tokens>,
    pub declarators: Vec<Declarator>,
}

#[derive(Clone, Debug)]
pub(super) struct Declarator {
    pub name: usize,
    /// What stands between each pair of `[` and `]`.
    pub dims: Vec<Tokens>,
    /// From `=` to the end of the expression.
    pub initialiser: Option<Tokens>,
}

#[derive(Clone, Debug)]
pub(super) struct Function {
    pub tokens: Tokens,
    pub name: usize,
    pub parameters: Vec<Parameter>,
    /// What stands between the braces.
    pub body: Option<Tokens>,
}

#[derive(Clone, Debug)]
pub(super) struct Parameter {
    pub tokens: Tokens,
    pub ty: usize,
    pub name: Option<usize>,
    pub dims: Vec<Tokens>,
}

/// The tokens the compiler reads, directives left out.
pub(super) fn code<'a>(text: &'a str, raw: &RawText) -> Vec<Token<'a>> {
    let read = raw.tokens.iter().filter(|token| token.active && token.directive.is_none());
    read.map(|t| Token { kind: t.kind, text: &text[t.start..t.end], start: t.start, end: t.end })
        .collect()
}

/// The global declarations in order. `macros` are names that stand for qualifiers.
pub(super) fn declarations(code: &[Token<'_>], macros: &FxHashSet<&str>) -> Vec<Declaration> {
    let mut reader = Reader { code, macros, at: 0 };
    let mut all = Vec::new();
    while reader.at < code.len() {
        let start = reader.at;
        if reader.is(";") {
            reader.at += 1;
            continue;
        }
        let read = reader.declaration();
        all.push(read.unwrap_or_else(|| {
            reader.at = start;
            reader.skip();
            Declaration::Other(start..reader.at)
        }));
        reader.at = reader.at.max(start + 1);
    }
    all
}

struct Reader<'c, 'a> {
    code: &'c [Token<'a>],
    macros: &'c FxHashSet<&'c str>,
    at: usize,
}

impl Reader<'_, '_> {
    fn is(&self, text: &str) -> bool {
        self.code.get(self.at).is_some_and(|token| token.text == text)
    }

    fn name(&mut self) -> Option<usize> {
        let found = self.code.get(self.at).is_some_and(|token| token.kind == Kind::Name);
        self.at += usize::from(found);
        found.then(|| self.at - 1)
    }

    fn eat(&mut self, text: &str) -> Option<usize> {
        let found = self.is(text);
        self.at += usize::from(found);
        found.then(|| self.at - 1)
    }

    /// What stands between a bracket here and its partner; both are passed.
    fn balanced(&mut self) -> Option<Tokens> {
        let start = self.at;
        let mut depth = 0usize;
        while let Some(token) = self.code.get(self.at) {
            match token.text {
                "(" | "[" | "{" => depth += 1,
                ")" | "]" | "}" => depth = depth.checked_sub(1)?,
                _ => {}
            }
            self.at += 1;
            if depth == 0 {
                return Some(start + 1..self.at - 1);
            }
        }
        None
    }

    /// Passes what is not understood: up to `;` or the end of a body.
    fn skip(&mut self) {
        while self.at < self.code.len() {
            if self.eat(";").is_some() {
                return;
            }
            if self.is("{") {
                self.balanced();
                self.eat(";");
                return;
            }
            self.at += 1;
        }
    }

    fn qualifies(&self, word: &str) -> bool {
        is_qualifier(word) || self.macros.contains(word)
    }

    fn qualifiers(&mut self) -> Option<Qualifiers> {
        let mut qualifiers = Qualifiers::default();
        loop {
            if self.eat("layout").is_some() {
                qualifiers.layouts.push(self.balanced()?);
            } else if self.code.get(self.at).is_some_and(|t| self.qualifies(t.text)) {
                qualifiers.words.push(self.at);
                self.at += 1;
            } else {
                return Some(qualifiers);
            }
        }
    }

    fn declaration(&mut self) -> Option<Declaration> {
        let start = self.at;
        if self.is("precision") {
            self.skip();
            return Some(Declaration::Precision);
        }
        let qualifiers = self.qualifiers()?;
        if self.eat(";").is_some() {
            return Some(Declaration::Defaults);
        }
        if self.is("struct") {
            let mut structure = self.structure()?;
            if qualifiers.words.is_empty() && self.eat(";").is_some() {
                structure.tokens = start..self.at;
                return Some(Declaration::Structure(structure));
            }
            let ty = structure.body.start;
            return self.variables(start, qualifiers, ty, Some(structure));
        }
        let ty = self.name()?;
        if self.is("{") {
            return self.block(start, qualifiers, ty);
        }
        if self.is(";") || self.is(",") {
            self.skip();
            return Some(Declaration::Other(start..self.at));
        }
        let after = self.at;
        self.dims()?;
        let name = self.name()?;
        if self.is("(") {
            return self.function(start, name);
        }
        self.at = after;
        self.variables(start, qualifiers, ty, None)
    }

    fn structure(&mut self) -> Option<Structure> {
        let start = self.eat("struct")?;
        let name = self.name();
        let members = self.members()?;
        Some(Structure { tokens: start..self.at, name, members, body: start..self.at })
    }

    fn members(&mut self) -> Option<Vec<Variables>> {
        self.eat("{")?;
        let mut members = Vec::new();
        while self.eat("}").is_none() {
            let start = self.at;
            let qualifiers = self.qualifiers()?;
            let ty = self.name()?;
            match self.variables(start, qualifiers, ty, None)? {
                Declaration::Variables(variables) => members.push(variables),
                _ => return None,
            }
        }
        Some(members)
    }

    fn block(&mut self, start: usize, qualifiers: Qualifiers, name: usize) -> Option<Declaration> {
        let members = self.members()?;
        self.name();
        self.dims()?;
        self.eat(";")?;
        let tokens = start..self.at;
        Some(Declaration::Block(Block { tokens, qualifiers, name, members }))
    }

    fn dims(&mut self) -> Option<Vec<Tokens>> {
        let mut dims = Vec::new();
        while self.is("[") {
            dims.push(self.balanced()?);
        }
        Some(dims)
    }

    fn variables(
        &mut self,
        start: usize,
        qualifiers: Qualifiers,
        ty: usize,
        structure: Option<Structure>,
    ) -> Option<Declaration> {
        let type_dims = self.dims()?;
        let mut declarators = Vec::new();
        loop {
            let name = self.name()?;
            let dims = self.dims()?;
            let mut initialiser = None;
            if let Some(equals) = self.eat("=") {
                while !self.is(",") && !self.is(";") {
                    match self.code.get(self.at)?.text {
                        "(" | "[" | "{" => {
                            self.balanced()?;
                        }
                        _ => self.at += 1,
                    }
                }
                initialiser = Some(equals..self.at);
            }
            declarators.push(Declarator { name, dims, initialiser });
            if self.eat(",").is_none() {
                break;
            }
        }
        self.eat(";")?;
        let tokens = start..self.at;
        Some(Declaration::Variables(Variables {
            tokens,
            qualifiers,
            ty,
            structure,
            type_dims,
            declarators,
        }))
    }

    fn function(&mut self, start: usize, name: usize) -> Option<Declaration> {
        let list = self.balanced()?;
        let after = self.at;
        let mut parameters = Vec::new();
        self.at = list.start;
        while self.at < list.end && !(self.is("void") && list.len() == 1) {
            let first = self.at;
            self.qualifiers()?;
            let ty = self.name()?;
            let mut dims = self.dims()?;
            let name = self.name();
            dims.extend(self.dims()?);
            parameters.push(Parameter { tokens: first..self.at, ty, name, dims });
            if self.at < list.end {
                self.eat(",")?;
            }
        }
        self.at = after;
        let mut body = None;
        if self.is("{") {
            body = Some(self.balanced()?);
        } else {
            self.eat(";")?;
        }
        Some(Declaration::Function(Function { tokens: start..self.at, name, parameters, body }))
    }
}
