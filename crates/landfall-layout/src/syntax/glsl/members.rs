//! Members of structures and blocks, and loose uniforms: names, types, array dimensions, layout
//! qualifiers, comments.

mod resolve;

use std::sync::Arc;

use rustc_hash::FxHashSet;

use super::ast::{
    Declaration, Declarator, Dim, LayoutId, Qualifiers, StructDecl, Tokens, TypeBase,
};
use super::declarations::{DeclarationReader, Named, Unknown, Unsized};
use super::lexer::{Kind, Token};
use super::report::diagnostic_at;
use crate::diagnostic::{Code, Diagnostic};
use crate::shape::{ArrayLen, DEEPEST_NESTING, MatrixLayout, Member, Struct, Type, Written};
use crate::source::Span;
use crate::text::edit_distance::suggestion;
pub(super) use resolve::{COMMON_TYPES, Resolved, TypeName};

/// The members between two braces.
#[derive(Default)]
pub(super) struct Members {
    pub members: Vec<Member>,
    pub opaque: Vec<Arc<str>>,
    pub problems: Vec<Diagnostic>,
    taken: FxHashSet<Arc<str>>,
}

/// The context of a member, which determines the members allowed.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum MemberOwner {
    Struct,
    /// A block; with bindless handles, opaque members are 8-byte addresses.
    Block {
        bindless: bool,
        runtime_tail: bool,
    },
}

const ONLY_TAILS: &str = "only the last member of a `buffer` block may be runtime-sized";

/// The source of the length of an array declared without one.
#[derive(Clone, Copy)]
enum OpenLength {
    Refused,
    /// From its uses: as long as its constant indices need.
    FromUse,
    Runtime,
}

fn unsized_array(name: &Token<'_>, span: Span) -> Diagnostic {
    let message = format!("array `{}` has no size", name.text);
    Diagnostic::error(Code::ArraySize, span, message)
        .with_help("write the number of elements between the brackets")
}

impl<'a> DeclarationReader<'a> {
    /// Returns the type a structure declares; `None` if it was not parsed to its end.
    pub(super) fn structure(&mut self, structure: &StructDecl<'a>) -> Option<Named<'a>> {
        let name = self.parser.token_of(&structure.name);
        let mut read = self.members(MemberOwner::Struct, &name, &structure.members);
        if !structure.closed {
            return None;
        }
        let is_broken = structure.members.iter().any(|member| member.broken);
        let is_empty = read.members.is_empty() && read.opaque.is_empty();
        if is_empty && read.problems.is_empty() && !is_broken {
            let message = "a structure needs at least one member";
            read.problems.push(diagnostic_at(&name, Code::EmptyStruct, message));
        }
        // A structure with errors is declared as well, or each use would be an unknown type
        // besides.
        let named = if read.problems.is_empty() {
            let text = structure.name.text;
            Named::Struct(Arc::new(Struct::new(text.into(), read.members, read.opaque, name.span)))
        } else {
            Named::Broken { name, why: read.problems, reported: false }
        };
        if !structure.name.text.is_empty() {
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
            let diagnostic = diagnostic_at(&name, Code::DuplicateName, message);
            self.report(diagnostic.with_label(before, "previously declared here"));
        }
        self.types.insert(name.text, named);
    }

    /// Reads the members of a structure or block. `owner` is its name in messages.
    pub(super) fn members(
        &mut self,
        place: MemberOwner,
        owner: &Token<'a>,
        declarations: &[Declaration<'a>],
    ) -> Members {
        let mut result = Members::default();
        for declaration in declarations {
            self.member(place, owner, declaration, &mut result);
        }
        result
    }

    // GLSL 4.60 §4.1.8 and §4.3.9, `struct_declaration`: one type, several names, each with
    // dimensions of its own. Errors are collected in `result`, since a structure that has some is
    // only reported when it is used.
    fn member(
        &mut self,
        place: MemberOwner,
        owner: &Token<'a>,
        declaration: &Declaration<'a>,
        result: &mut Members,
    ) {
        let Declaration { tokens, qualifiers, ty: spec, names, broken } = declaration;
        result.problems.extend(self.structure_inside(declaration));
        let ty = match &spec.base {
            TypeBase::Struct(structure) => match self.structure(structure) {
                Some(named) => TypeName::Declared(named),
                None => return,
            },
            TypeBase::Name(_) => TypeName::Name(self.parser.tokens()[spec.at]),
        };
        if let (MemberOwner::Struct, Some(id)) = (place, qualifiers.layout.first()) {
            // GLSL 4.60 §4.1.8: members of a structure take no layout qualifiers.
            let message = format!("`{}` is not allowed on a member of a structure", id.name.text);
            let token = self.parser.token_of(&id.name);
            let diagnostic = diagnostic_at(&token, Code::LayoutQualifier, message);
            let help = format!("write it on the member of the block that is a `{}`", owner.text);
            result.problems.push(diagnostic.with_help(help));
        }
        if *broken {
            return; // a syntax error, reported before
        }
        if place == MemberOwner::Struct {
            result.problems.extend(self.illegal_in_structure(qualifiers));
        }
        if let TypeName::Name(token) = &ty {
            self.check_type(token);
        }
        let comment = self.comments_of(tokens);
        let last_declaration = self.parser.tokens().get(tokens.end).is_some_and(|t| t.is("}"));
        let resolved = self.resolve(&ty, owner, &mut result.problems);
        let last = names.len().wrapping_sub(1);
        for (index, Declarator { name, dims, .. }) in names.iter().enumerate() {
            let name = &self.parser.token_of(name);
            if result.taken.contains(name.text) {
                let message = format!("`{}` has two members named `{}`", owner.text, name.text);
                result.problems.push(diagnostic_at(name, Code::DuplicateName, message));
                continue;
            }
            let data = match (&resolved, place) {
                (Resolved::Broken, _) => continue,
                (Resolved::Data(ty), _) => ty.clone(),
                (Resolved::Opaque, MemberOwner::Struct) => {
                    result.opaque.push(name.text.into());
                    continue;
                }
                // ARB_bindless_texture, NV_bindless_texture: handles are 64 bits.
                (Resolved::Opaque, MemberOwner::Block { bindless: true, .. }) => {
                    Type::Address(ty.text().into())
                }
                (Resolved::Opaque, MemberOwner::Block { bindless: false, .. }) => {
                    result.problems.push(self.opaque_in_block(name, &ty, owner));
                    continue;
                }
            };
            // Of `float a[], b[];` only `b` is the last member.
            let tail = index == last && last_declaration;
            let open = match place {
                MemberOwner::Struct => OpenLength::Refused,
                MemberOwner::Block { runtime_tail: true, .. } if tail => OpenLength::Runtime,
                MemberOwner::Block { .. } => OpenLength::FromUse,
            };
            match self.build_member(name, data, dims, &spec.dims, qualifiers, open) {
                Ok(mut member) => {
                    member.comment = comment.clone();
                    result.taken.insert(Arc::clone(&member.name));
                    result.members.push(member);
                }
                Err(diagnostic) => result.problems.push(diagnostic),
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
        open: OpenLength,
    ) -> Result<Member, Diagnostic> {
        let ty = self.array(name, data, dims, type_dims, open)?;
        let offset = qualifiers.find("offset").map(|id| self.written(id)).transpose()?;
        let align = qualifiers.find("align").map(|id| self.alignment(id)).transpose()?;
        Ok(Member {
            matrix_layout: matrix_layout(qualifiers),
            offset,
            align,
            ..Member::unqualified(name.text.into(), ty, name.span)
        })
    }

    fn written(&mut self, id: &LayoutId<'a>) -> Result<Written, Diagnostic> {
        Ok(Written { value: self.layout_number(id)?, span: id.name.span })
    }

    /// Reads `align = N`, a power of two (GLSL 4.60 §4.4.5).
    pub(super) fn alignment(&mut self, id: &LayoutId<'a>) -> Result<Written, Diagnostic> {
        let written = self.written(id)?;
        if !written.value.is_power_of_two() {
            let message = format!("`align = {}` is not a power of two", written.value);
            let next = written.value.max(1).next_power_of_two();
            let name = self.parser.token_of(&id.name);
            return Err(diagnostic_at(&name, Code::LayoutQualifier, message)
                .with_help(format!("write `align = {next}`")));
        }
        Ok(written)
    }

    /// `T[3] a[2]` is an array of 2 arrays of 3 (GLSL 4.60 §4.1.9): the name's dimensions come
    /// first.
    fn array(
        &mut self,
        name: &Token<'a>,
        element: Type,
        dims: &[Dim<'a>],
        type_dims: &[Dim<'a>],
        open: OpenLength,
    ) -> Result<Type, Diagnostic> {
        let all: Vec<&Dim<'a>> = dims.iter().chain(type_dims).collect();
        let depth = element.depth() as usize + all.len();
        if depth > DEEPEST_NESTING as usize {
            let message = format!(
                "`{}` nests structures and arrays {depth} deep, landfall takes {DEEPEST_NESTING}",
                name.text
            );
            return Err(diagnostic_at(name, Code::NestedTooDeep, message));
        }
        let mut ty = element;
        // From the innermost dimension, the last, outwards; only the outermost may be left open
        // (§4.1.9).
        for (index, dim) in all.iter().enumerate().rev() {
            let len = if dim.tokens.is_empty() {
                match open {
                    OpenLength::Runtime if index == 0 => ArrayLen::Runtime,
                    OpenLength::FromUse if index == 0 => {
                        ArrayLen::Fixed(self.implicit_length(name, dim.span)?)
                    }
                    _ => return Err(unsized_array(name, dim.span).with_note(ONLY_TAILS)),
                }
            } else {
                self.note_specialised(name, dim);
                self.note_length_constants(name.span, dim);
                ArrayLen::Fixed(self.array_size(name, dim)?)
            };
            ty = Type::Array { element: Arc::new(ty), len };
        }
        Ok(ty)
    }

    /// The length of a member of a block that is declared without one, from its use.
    // The first reading notes the member and fails; a second one, with `lengths`, knows it. GLSL ES
    // has no implicit sizes.
    fn implicit_length(&mut self, name: &Token<'a>, span: Span) -> Result<u32, Diagnostic> {
        let error = unsized_array(name, span);
        if self.parser.is_es() {
            return Err(error.with_note(ONLY_TAILS));
        }
        match self.lengths.get(&(self.instance, name.text)).copied() {
            Some(Ok(length)) => {
                self.sized_by_use.push(name.span);
                Ok(length)
            }
            Some(Err(Unknown::Unused)) => {
                Err(error.with_note("no constant index says how long it is (GLSL 4.60 §4.1.9)"))
            }
            Some(Err(Unknown::NotConstant(at))) => Err(error.with_label(
                at,
                "an array without a size takes constant indices only (GLSL 4.60 §4.1.9)",
            )),
            Some(Err(Unknown::Ambiguous(at))) => {
                Err(error.with_label(at, "so its length is not taken from its uses"))
            }
            None => {
                let instance = self.instance;
                let member = Unsized { instance, name: name.text, brackets: span };
                self.unsized_members.push(member);
                Err(error.with_note(ONLY_TAILS))
            }
        }
    }

    /// Returns the number of elements of a dimension, a constant of at least 1 (GLSL 4.60 §4.1.9).
    pub(super) fn array_size(
        &mut self,
        name: &Token<'a>,
        dim: &Dim<'a>,
    ) -> Result<u32, Diagnostic> {
        let tokens = &self.parser.tokens()[dim.tokens.clone()];
        let first = tokens[0];
        // An error inside the expression points to the use of a macro; the label shows the macro's
        // body.
        let macros: Vec<_> = tokens.iter().filter_map(|t| Some((t.span, t.definition?))).collect();
        let fail = |span: Span, message: String| {
            let diagnostic = Diagnostic::error(Code::ArraySize, span, message);
            let found =
                macros.iter().find(|(of, _)| *of == span).map(|(_, definition)| *definition);
            match found.or(first.definition) {
                Some(definition) => diagnostic.with_label(definition, "from this macro"),
                None => diagnostic,
            }
        };
        let value = match self.constant_integer(&dim.tokens, dim.span) {
            Ok(value) => value,
            Err(problem) => {
                let message = format!("the size of array `{}` {}", name.text, problem.message);
                let help = problem.unknown.and_then(|unknown| self.known_constant(&unknown));
                return Err(Diagnostic { help, ..fail(problem.span, message) });
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
                Err(fail(first.span, message))
            }
        }
    }

    /// The help for a name in the size of an array that is neither a macro nor a constant.
    fn known_constant(&mut self, name: &str) -> Option<String> {
        let macros = self.parser.preprocessor().macros.keys().copied();
        let constants = self.constants.names();
        suggestion(name, macros.chain(constants)).or_else(|| {
            // A variable of the shader cannot be defined; macros are in capitals by convention.
            let is_macro = !name.contains(|c: char| c.is_ascii_lowercase());
            is_macro.then(|| format!("define it with `--define {name}=N`"))
        })
    }

    fn opaque_in_block(
        &self,
        name: &Token<'a>,
        ty: &TypeName<'a>,
        owner: &Token<'a>,
    ) -> Diagnostic {
        let message = format!(
            "`{}` has the opaque type `{}`, which is not allowed in block `{}`",
            name.text,
            ty.text(),
            owner.text
        );
        diagnostic_at(name, Code::OpaqueInBlock, message).with_help(format!(
            "declare `uniform {} {};` outside the block",
            ty.text(),
            name.text
        ))
    }

    /// Reads `uniform TYPE a, b;` outside a block.
    pub(super) fn loose_uniforms(&mut self, ty: &TypeName<'a>, declaration: &Declaration<'a>) {
        let first = self.parser.tokens()[declaration.tokens.start];
        if let TypeName::Name(token) = ty {
            self.check_type(token);
        }
        let mut problems = Vec::new();
        let owner = Token { text: "", ..first };
        let resolved = self.resolve(ty, &owner, &mut problems);
        let comment = self.comments_of(&declaration.tokens);
        for Declarator { name, dims, .. } in &declaration.names {
            let name = &self.parser.token_of(name);
            let data = match &resolved {
                Resolved::Data(data) => data.clone(),
                Resolved::Opaque => {
                    self.loose_opaque.push(name.text.into());
                    continue;
                }
                Resolved::Broken => continue,
            };
            // `uniform float a[];` gets its size from its use; it has no offset that could be
            // wrong.
            match self.array(name, data, dims, &declaration.ty.dims, OpenLength::Runtime) {
                Ok(ty) => self.loose.push(Member {
                    comment: comment.clone(),
                    ..Member::unqualified(name.text.into(), ty, name.span)
                }),
                Err(diagnostic) => problems.push(diagnostic),
            }
        }
        self.report_all(problems);
    }

    /// Returns the comments of a declaration: on the lines before it, inside it, and after it on
    /// its last line.
    // Each token has the number of comments before it, so the comments between two tokens are a
    // range of the list.
    pub(super) fn comments_of(&mut self, tokens: &Tokens) -> Vec<Span> {
        let before = self.parser.before(tokens.start);
        let (first, end) = (self.parser.tokens()[tokens.start], self.parser.before(tokens.end));
        let after = self.parser.tokens().get(tokens.end).map_or(end.comments, |t| t.comments);
        let preprocessor = self.parser.preprocessor();
        let range = |from: u32, to: u32| {
            let all = &preprocessor.comments;
            all.get(from as usize..to as usize).unwrap_or_default().iter().copied()
        };
        // Whether a comment begins on the line on which a token ends.
        let same_line = |token: Span, comment: Span| {
            token.file == comment.file && token.end <= comment.start && {
                let between = Span { start: token.end, end: comment.start, ..token };
                !preprocessor.files.text(between).contains('\n')
            }
        };
        let leading = range(before.comments, first.comments)
            .filter(|c| before.kind == Kind::End || !same_line(before.span, *c));
        let inside = range(first.comments, end.comments);
        let trailing = range(end.comments, after).filter(|c| same_line(end.span, *c));
        leading.chain(inside).chain(trailing).collect()
    }
}

/// Returns the last of `row_major` and `column_major`.
pub(super) fn matrix_layout(qualifiers: &Qualifiers<'_>) -> Option<MatrixLayout> {
    qualifiers.layout.iter().rev().find_map(|id| {
        if id.is("row_major") {
            Some(MatrixLayout::Row)
        } else if id.is("column_major") {
            Some(MatrixLayout::Column)
        } else {
            None
        }
    })
}
