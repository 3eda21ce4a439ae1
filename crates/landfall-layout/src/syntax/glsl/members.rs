//! Members of structures and blocks, and loose uniforms: names, types, array
//! dimensions, layout qualifiers, comments.

mod resolve;

use crate::diagnostic::Code;
use std::sync::Arc;

use rustc_hash::FxHashSet;

use super::declarations::{Declarator, Dim, Named, Reader};
use super::lexer::{Kind, Token};
use super::qualifiers::Qualifiers;
use crate::diagnostic::Diagnostic;
use crate::shape::{ArrayLen, DEEPEST_NESTING, Majorness, Member, Struct, Type, Written};
use crate::source::Span;
pub(super) use resolve::{Resolved, TypeName};

/// Structures may be declared inside each other this deep; the language forbids it altogether.
const DEEPEST_STRUCTURE: u32 = 16;

/// The members between two braces.
#[derive(Default)]
pub(super) struct Members {
    pub members: Vec<Member>,
    pub opaque: Vec<Arc<str>>,
    /// What is wrong with them.
    pub problems: Vec<Diagnostic>,
    /// Their names.
    taken: FxHashSet<Arc<str>>,
}

/// What members may be here.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Place {
    Struct,
    /// A block; with bindless handles, opaque members are 8-byte addresses.
    Block {
        bindless: bool,
        runtime_tail: bool,
    },
}

impl<'a> Reader<'a> {
    /// `struct [NAME] { … }`; `None` when it could not be read to its end.
    pub(super) fn structure(&mut self) -> Option<Named<'a>> {
        let keyword = self.bump();
        let name = if self.token.kind == Kind::Name { self.bump() } else { keyword };
        let anonymous = name.is("struct");
        let open = self.token;
        if !self.expect("{") {
            self.recover();
            return None;
        }
        if self.open_structures == DEEPEST_STRUCTURE {
            let message = format!(
                "structures are declared inside each other more than {DEEPEST_STRUCTURE} deep"
            );
            self.report_at(&name, Code::NestedTooDeep, message);
            self.preprocessor.stopped = true;
            return None;
        }
        self.open_structures += 1;
        let mut read = self.members(Place::Struct, &name);
        self.open_structures -= 1;
        if !self.close(&open) {
            return None;
        }
        if read.members.is_empty() && read.opaque.is_empty() && read.problems.is_empty() {
            let message = "a structure has at least one member";
            read.problems.push(self.diagnostic(&name, Code::EmptyStruct, message));
        }
        let named = if read.problems.is_empty() {
            let text = if anonymous { "" } else { name.text };
            Named::Struct(Arc::new(Struct::new(text.into(), read.members, read.opaque, name.span)))
        } else {
            Named::Broken { name, why: read.problems, told: false }
        };
        if !anonymous {
            self.declare_type(name, named.clone());
        }
        Some(named)
    }

    pub(super) fn declare_type(&mut self, name: Token<'a>, named: Named<'a>) {
        let before = match self.types.get(name.text) {
            Some(Named::Struct(s)) => Some(s.span),
            Some(Named::Broken { name, .. }) => Some(name.span),
            Some(Named::Reference) | None => None,
        };
        if let Some(before) = before {
            let message = format!("structure `{}` is declared twice", name.text);
            let diagnostic = self.diagnostic(&name, Code::DuplicateName, message);
            self.report(diagnostic.with_label(before, "declared before here"));
        }
        self.types.insert(name.text, named);
    }

    /// Passes `}`; says what was left open if it is not there.
    pub(super) fn close(&mut self, open: &Token<'a>) -> bool {
        if self.token.is("}") {
            self.bump();
            return true;
        }
        if self.token.kind == Kind::End {
            self.report_at(open, Code::UnclosedBrace, "`{` is never closed");
        } else {
            self.recover();
        }
        false
    }

    /// The members up to `}`. `owner` names the structure or block in messages.
    pub(super) fn members(&mut self, place: Place, owner: &Token<'a>) -> Members {
        let mut result = Members::default();
        while !self.token.is("}") && self.token.kind != Kind::End {
            if self.token.is(";") {
                self.bump();
                continue;
            }
            let errors = self.preprocessor.diagnostics.len();
            let position = self.token.span;
            self.member(place, owner, &mut result);
            if self.preprocessor.diagnostics.len() > errors && position == self.token.span {
                break; // nothing was passed: the rest is no member list
            }
        }
        result
    }

    fn member(&mut self, place: Place, owner: &Token<'a>, result: &mut Members) {
        let before = self.previous;
        let first = self.token;
        let qualifiers = self.qualifiers();
        let ty = if self.token.is("struct") {
            match self.structure() {
                Some(named) => TypeName::Declared(named),
                None => return,
            }
        } else if self.token.kind == Kind::Name {
            TypeName::Name(self.bump())
        } else {
            let message =
                format!("unexpected `{}` among the members of `{}`", self.token.text, owner.text);
            self.report_at(&self.token.clone(), Code::Syntax, message);
            return self.recover_member();
        };
        if let (Place::Struct, Some(id)) = (place, qualifiers.layout.first()) {
            // GLSL 4.60 §4.1.8: members of a structure take no layout qualifiers.
            let message = format!("`{}` does not go on a member of a structure", id.name.text);
            let diagnostic = self.diagnostic(&id.name, Code::LayoutQualifier, message);
            let help = format!("write it on the member of the block that is a `{}`", owner.text);
            result.problems.push(diagnostic.with_help(help));
        }
        let type_dims = self.dims();
        let errors = self.preprocessor.diagnostics.len();
        let declarators = self.declarators();
        if self.preprocessor.diagnostics.len() > errors {
            return; // a syntax error: said already
        }
        let comment = self.comments_of(&before, &first);
        let resolved = self.resolve(&ty, owner, &mut result.problems);
        let last = declarators.len().wrapping_sub(1);
        for (index, Declarator { name, dims, .. }) in declarators.iter().enumerate() {
            if result.taken.contains(name.text) {
                let message = format!("`{}` has two members named `{}`", owner.text, name.text);
                result.problems.push(self.diagnostic(name, Code::DuplicateName, message));
                continue;
            }
            let data = match (&resolved, place) {
                (Resolved::Broken, _) => continue,
                (Resolved::Data(ty), _) => ty.clone(),
                (Resolved::Opaque, Place::Struct) => {
                    result.opaque.push(name.text.into());
                    continue;
                }
                (Resolved::Opaque, Place::Block { bindless: true, .. }) => {
                    Type::Address(ty.text().into())
                }
                (Resolved::Opaque, Place::Block { bindless: false, .. }) => {
                    result.problems.push(self.opaque_in_block(name, &ty, owner));
                    continue;
                }
            };
            let tail = index == last && self.token.is("}");
            let runtime = matches!(place, Place::Block { runtime_tail: true, .. }) && tail;
            match self.build_member(name, data, dims, &type_dims, &qualifiers, runtime) {
                Ok(mut member) => {
                    member.comment = comment.clone();
                    result.taken.insert(Arc::clone(&member.name));
                    result.members.push(member);
                }
                Err(diagnostic) => result.problems.push(diagnostic),
            }
        }
    }

    /// After a syntax error among members: on to the next `;` or before the closing brace.
    fn recover_member(&mut self) {
        while !matches!(self.token.text, ";" | "}") && self.token.kind != Kind::End {
            if matches!(self.token.text, "(" | "[" | "{") {
                self.skip_balanced();
            } else {
                self.bump();
            }
        }
    }

    fn build_member(
        &mut self,
        name: &Token<'a>,
        data: Type,
        dims: &[Dim<'a>],
        type_dims: &[Dim<'a>],
        qualifiers: &Qualifiers<'a>,
        runtime: bool,
    ) -> Result<Member, Diagnostic> {
        let ty = self.array(name, data, dims, type_dims, runtime)?;
        let offset = qualifiers.find("offset").map(|id| self.written(id)).transpose()?;
        let align = qualifiers.find("align").map(|id| self.alignment(id)).transpose()?;
        Ok(Member {
            name: name.text.into(),
            ty,
            majorness: majorness(qualifiers),
            offset,
            align,
            size: None,
            span: name.span,
            comment: Vec::new(),
        })
    }

    fn written(&mut self, id: &super::qualifiers::LayoutId<'a>) -> Result<Written, Diagnostic> {
        Ok(Written { value: self.layout_number(id)?, span: id.name.span })
    }

    /// `align = N`: a power of two (GLSL 4.60 §4.4.5).
    pub(super) fn alignment(
        &mut self,
        id: &super::qualifiers::LayoutId<'a>,
    ) -> Result<Written, Diagnostic> {
        let written = self.written(id)?;
        if !written.value.is_power_of_two() {
            let message = format!("`align = {}` is no power of two", written.value);
            let next = written.value.max(1).next_power_of_two();
            return Err(self
                .diagnostic(&id.name, Code::LayoutQualifier, message)
                .with_help(format!("write `align = {next}`")));
        }
        Ok(written)
    }

    /// `T[3] a[2]` is an array of 2 arrays of 3 (GLSL 4.60 §4.1.9): a name's dimensions come first.
    fn array(
        &mut self,
        name: &Token<'a>,
        element: Type,
        dims: &[Dim<'a>],
        type_dims: &[Dim<'a>],
        runtime: bool,
    ) -> Result<Type, Diagnostic> {
        let all: Vec<&Dim<'a>> = dims.iter().chain(type_dims).collect();
        let depth = element.depth() as usize + all.len();
        if depth > DEEPEST_NESTING as usize {
            let message = format!(
                "`{}` nests structures and arrays {depth} deep, landfall takes {DEEPEST_NESTING}",
                name.text
            );
            return Err(self.diagnostic(name, Code::NestedTooDeep, message));
        }
        let mut ty = element;
        for (index, dim) in all.iter().enumerate().rev() {
            let len = if dim.size.is_empty() {
                if !(runtime && index == 0) {
                    return Err(self.unsized_array(name, dim.span));
                }
                ArrayLen::Runtime
            } else {
                ArrayLen::Fixed(self.array_size(name, dim)?)
            };
            ty = Type::Array { element: Arc::new(ty), len };
        }
        Ok(ty)
    }

    fn unsized_array(&self, name: &Token<'a>, span: Span) -> Diagnostic {
        let message = format!("the size of array `{}` is not written", name.text);
        Diagnostic::error(Code::ArraySize, span, message)
            .with_note("only the last member of a `buffer` block may be runtime-sized")
            .with_help("write the number of elements between the brackets")
    }

    /// The number of elements a dimension says: a constant from 1 (GLSL 4.60 §4.1.9).
    pub(super) fn array_size(
        &mut self,
        name: &Token<'a>,
        dim: &Dim<'a>,
    ) -> Result<u32, Diagnostic> {
        let fail = |this: &Self, span: Span, message: String| {
            let diagnostic = Diagnostic::error(Code::ArraySize, span, message);
            match dim.size.iter().find(|t| t.span == span).and_then(|t| t.definition) {
                Some(definition) => diagnostic.with_label(definition, "from this macro"),
                None => match dim.size.first().and_then(|t| t.definition) {
                    Some(definition) if this.token.kind != Kind::Text => {
                        diagnostic.with_label(definition, "from this macro")
                    }
                    _ => diagnostic,
                },
            }
        };
        let value = match self.constant_integer(&dim.size, dim.span) {
            Ok(value) => value,
            Err(problem) => {
                let message = format!("the size of array `{}` {}", name.text, problem.message);
                return Err(fail(self, problem.span, message));
            }
        };
        match u32::try_from(value) {
            Ok(size) if size > 0 => Ok(size),
            _ => {
                let bound = if value > 0 { "at most 4294967295" } else { "at least 1" };
                let message = format!(
                    "array `{}` has size {value}, but an array has {bound} element",
                    name.text
                );
                Err(fail(self, dim.size[0].span, message))
            }
        }
    }

    fn opaque_in_block(
        &self,
        name: &Token<'a>,
        ty: &TypeName<'a>,
        owner: &Token<'a>,
    ) -> Diagnostic {
        let message = format!(
            "`{}` is a `{}`, which has no bytes, and cannot stand in block `{}`",
            name.text,
            ty.text(),
            owner.text
        );
        self.diagnostic(name, Code::OpaqueInBlock, message).with_help(format!(
            "declare `uniform {} {};` outside the block",
            ty.text(),
            name.text
        ))
    }

    /// `uniform TYPE a, b;` outside a block.
    pub(super) fn loose_uniforms(
        &mut self,
        ty: TypeName<'a>,
        type_dims: &[Dim<'a>],
        declarators: Vec<Declarator<'a>>,
        before: Token<'a>,
        first: Token<'a>,
    ) {
        let mut problems = Vec::new();
        let owner = Token { text: "", ..first };
        let resolved = self.resolve(&ty, &owner, &mut problems);
        let comment = self.comments_of(&before, &first);
        for Declarator { name, dims, .. } in &declarators {
            let data = match &resolved {
                Resolved::Data(data) => data.clone(),
                Resolved::Opaque => {
                    self.loose_opaque.push(name.text.into());
                    continue;
                }
                Resolved::Broken => continue,
            };
            // `uniform float a[];` takes its size from its use; it has no offset to be wrong.
            match self.array(name, data, dims, type_dims, true) {
                Ok(ty) => self.loose.push(Member {
                    comment: comment.clone(),
                    ..Member::plain(name.text.into(), ty, name.span)
                }),
                Err(diagnostic) => problems.push(diagnostic),
            }
        }
        for problem in problems {
            self.report(problem);
        }
    }

    /// The comments of a declaration that was just read to its `;`: those on the lines before
    /// it, inside it, and after it on its last line.
    pub(super) fn comments_of(&self, before: &Token<'a>, first: &Token<'a>) -> Vec<Span> {
        let all = &self.preprocessor.comments;
        let end = self.previous;
        let range = |from: u32, to: u32| {
            all.get(from as usize..to as usize).unwrap_or_default().iter().copied()
        };
        let leading = range(before.comments, first.comments)
            .filter(|c| before.kind == Kind::End || !self.same_line(before.span, *c));
        let inside = range(first.comments, end.comments);
        let trailing =
            range(end.comments, self.token.comments).filter(|c| self.same_line(end.span, *c));
        leading.chain(inside).chain(trailing).collect()
    }

    /// Whether a comment begins on the line on which a token ends.
    fn same_line(&self, token: Span, comment: Span) -> bool {
        token.file == comment.file && token.end <= comment.start && {
            let between = Span { start: token.end, end: comment.start, ..token };
            !self.preprocessor.files.text(between).contains('\n')
        }
    }
}

/// `row_major` or `column_major`; the last one counts.
pub(super) fn majorness(qualifiers: &Qualifiers<'_>) -> Option<Majorness> {
    qualifiers.layout.iter().rev().find_map(|id| {
        if id.is("row_major") {
            Some(Majorness::Row)
        } else if id.is("column_major") {
            Some(Majorness::Column)
        } else {
            None
        }
    })
}
