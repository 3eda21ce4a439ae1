//! The global declarations of a shader as ranges of its tokens: what stands
//! where, so that it can be edited. Types are not resolved.
//!
//! Taken from the syntax tree of the text as it stands, macros not expanded.

use rustc_hash::FxHashSet;

use crate::syntax::glsl::ast;
use crate::syntax::glsl::ast::Item;
pub(super) use crate::syntax::glsl::ast::Tokens;
use crate::syntax::glsl::lexer::Kind;
use crate::syntax::glsl::parser::Parser;
use crate::syntax::glsl::raw::{RawText, lexed};

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
pub(super) fn declarations<'a>(
    text: &'a str,
    code: &[Token<'a>],
    macros: FxHashSet<&'a str>,
) -> Vec<Declaration> {
    let tokens = lexed(text, code.iter().map(|token| (token.kind, token.start, token.end)));
    let mut parser = Parser::over(tokens).with_qualifier_macros(macros);
    let mut outline = Outline { code, parser: &mut parser };
    let mut all = Vec::new();
    loop {
        let start = outline.parser.position();
        let Some(item) = outline.parser.item() else { return all };
        let end = outline.parser.position();
        if matches!(&item, Item::Other(_)) && end == start + 1 && code[start].text == ";" {
            continue;
        }
        let understood = outline.parser.diagnostics().is_empty();
        outline.parser.forget_diagnostics();
        let read = if understood { outline.declaration(item, start..end) } else { None };
        all.push(read.unwrap_or(Declaration::Other(start..end)));
    }
}

struct Outline<'c, 'a> {
    code: &'c [Token<'a>],
    parser: &'c mut Parser<'a>,
}

impl<'a> Outline<'_, 'a> {
    fn declaration(&mut self, item: Item<'a>, tokens: Tokens) -> Option<Declaration> {
        Some(match item {
            Item::Variables(declaration) => self.variables_or_structure(&declaration)?,
            Item::Block(block) => Declaration::Block(self.block(&block)?),
            Item::Interface(mut block) => {
                self.parser.complete_interface(&mut block).ok()?;
                Declaration::Block(self.block(&block)?)
            }
            Item::Function(function) => {
                let parameters = self.parser.parameters_of(&function).ok()?;
                Declaration::Function(Function {
                    tokens,
                    name: function.name.at,
                    parameters: parameters.iter().map(parameter).collect(),
                    body: function.body_tokens.clone(),
                })
            }
            Item::Defaults(_) => Declaration::Defaults,
            Item::Precision(_) => Declaration::Precision,
            Item::Requalified(..) | Item::Other(_) => return None,
        })
    }

    fn variables_or_structure(&self, declaration: &ast::Declaration<'a>) -> Option<Declaration> {
        let structure = match &declaration.ty.base {
            ast::TypeBase::Struct(structure) => Some(self.structure(structure)?),
            ast::TypeBase::Name(_) => None,
        };
        if !declaration.names.is_empty() {
            return Some(Declaration::Variables(self.variables(declaration, structure)));
        }
        let structure = structure?;
        let words = self.qualifiers(&declaration.qualifiers).words;
        let tokens = declaration.tokens.clone();
        words.is_empty().then_some(Declaration::Structure(Structure { tokens, ..structure }))
    }

    fn variables(
        &self,
        declaration: &ast::Declaration<'a>,
        structure: Option<Structure>,
    ) -> Variables {
        let declarators = declaration.names.iter().map(|declarator| {
            let value = &declarator.tokens;
            Declarator {
                name: declarator.name.at,
                dims: dims(&declarator.dims),
                initialiser: (!value.is_empty()).then(|| value.start - 1..value.end),
            }
        });
        Variables {
            tokens: declaration.tokens.clone(),
            qualifiers: self.qualifiers(&declaration.qualifiers),
            ty: declaration.ty.at,
            structure,
            type_dims: dims(&declaration.ty.dims),
            declarators: declarators.collect(),
        }
    }

    fn structure(&self, structure: &ast::StructDecl<'a>) -> Option<Structure> {
        Some(Structure {
            tokens: structure.tokens.clone(),
            name: (!structure.name.text.is_empty()).then_some(structure.name.at),
            members: self.members(&structure.members)?,
            body: structure.tokens.clone(),
        })
    }

    fn block(&self, block: &ast::BlockDecl<'a>) -> Option<Block> {
        Some(Block {
            tokens: block.tokens.clone(),
            qualifiers: self.qualifiers(&block.qualifiers),
            name: block.name.at,
            members: self.members(&block.members)?,
        })
    }

    fn members(&self, members: &[ast::Declaration<'a>]) -> Option<Vec<Variables>> {
        let member = |member: &ast::Declaration<'a>| {
            let named = matches!(member.ty.base, ast::TypeBase::Name(_));
            named.then(|| self.variables(member, None))
        };
        members.iter().map(member).collect()
    }

    fn qualifiers(&self, qualifiers: &ast::Qualifiers<'a>) -> Qualifiers {
        let mut found = Qualifiers::default();
        let mut depth = 0;
        for at in qualifiers.tokens.clone() {
            match self.code[at].text {
                "(" => {
                    depth += 1;
                    if depth == 1 {
                        found.layouts.push(at + 1..at + 1);
                    }
                }
                ")" => {
                    depth -= 1;
                    if let (0, Some(layout)) = (depth, found.layouts.last_mut()) {
                        layout.end = at;
                    }
                }
                "layout" => {}
                _ if depth == 0 => found.words.push(at),
                _ => {}
            }
        }
        found
    }
}

fn dims(dims: &[ast::Dim<'_>]) -> Vec<Tokens> {
    dims.iter().map(|dim| dim.tokens.clone()).collect()
}

fn parameter(parameter: &ast::Parameter<'_>) -> Parameter {
    let mut all = dims(&parameter.ty.dims);
    all.extend(dims(&parameter.dims));
    Parameter {
        tokens: parameter.tokens.clone(),
        ty: parameter.ty.at,
        name: (!parameter.name.text.is_empty()).then_some(parameter.name.at),
        dims: all,
    }
}
