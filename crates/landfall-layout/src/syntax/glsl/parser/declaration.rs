//! Declarations: types, variables, blocks, functions (GLSL 4.60 §4, §6.1).

use std::rc::Rc;

use super::{Bodies, Parsed, Parser, SyntaxError, Wanted};
use crate::diagnostic::{Code, Diagnostic};
use crate::other_language;
use crate::source::Span;
use crate::syntax::glsl::ast::{
    BlockDecl, Declaration, Declarator, Dim, Expr, FunctionDecl, Item, Name, Qualifiers, Storage,
    StructDecl, Tokens, TypeBase, TypeSpec,
};
use crate::syntax::glsl::lexer::{Kind, Token};
use crate::syntax::glsl::report::diagnostic_at;
use crate::syntax::glsl::types::builtin;

/// The limit on structures declared inside each other; the language forbids it altogether.
const DEEPEST_STRUCTURE: u32 = 16;

impl<'a> Parser<'a> {
    /// Parses the next global declaration; `None` at the end. Syntax errors are reported.
    // external_declaration: function_definition | declaration | SEMICOLON      (GLSL 4.60 §9)
    pub fn item(&mut self) -> Option<Item<'a>> {
        // By place, since `forget` shifts indices; tokens of one macro call differ in the second.
        let here = (self.token().span, self.token().definition);
        if self.passed == Some(here) {
            self.bump(); // guarantee progress
        }
        if self.token().kind == Kind::End {
            return None;
        }
        self.passed = Some((self.token().span, self.token().definition));
        self.has_precisions = self.is_es();
        Some(self.item_here())
    }

    // declaration: init_declarator_list SEMICOLON | function_prototype SEMICOLON
    //     PRECISION precision_qualifier type_specifier SEMICOLON
    //     type_qualifier [block | IDENTIFIER [identifier_list]] SEMICOLON
    // The forms are told apart after `type_qualifier`, with which each but PRECISION may begin.
    fn item_here(&mut self) -> Item<'a> {
        let start = self.at;
        match self.token().text {
            ";" => {
                self.bump();
                return Item::Other(start..self.at);
            }
            "precision" => {
                self.precision_statement();
                return Item::Precision(start..self.at);
            }
            "[" => {
                self.skip_balanced();
                return Item::Other(start..self.at);
            }
            _ => {}
        }
        if self.is_other_language() {
            while self.token().kind != Kind::End {
                self.bump();
            }
            return Item::Other(start..self.at);
        }
        let qualifiers = self.qualifiers();
        if self.is(";") && qualifiers.any {
            self.bump();
            return Item::Defaults(qualifiers);
        }
        if self.is("struct") {
            return self.variables_of_structure(start, qualifiers);
        }
        if self.token().kind != Kind::Name {
            self.report_unexpected();
            return Item::Other(start..self.at);
        }
        let next = *self.ahead(1);
        let with_bytes = matches!(qualifiers.storage, Storage::Uniform | Storage::Buffer);
        let without_bytes = !matches!(qualifiers.storage, Storage::Plain | Storage::Const);
        if next.is("{") && with_bytes {
            self.block_item(start, qualifiers)
        } else if next.is("{") && without_bytes {
            self.interface(start, qualifiers)
        } else if (next.is(";") || next.is(",")) && qualifiers.any {
            let name = Name { text: self.token().text, span: self.token().span, at: self.at };
            self.skip_statement();
            Item::Requalified(qualifiers, name)
        } else {
            self.variables(start, qualifiers)
        }
    }

    // `struct S { a: vec3f, …` begins like GLSL: five tokens show the colon and the type.
    fn other_language(&mut self, first: &Token<'a>) -> Option<&'static str> {
        if first.definition.is_some() {
            return None;
        }
        if matches!(first.text, "struct" | "const") {
            let after = [1, 2, 3, 4, 5].map(|count| self.ahead(count).text);
            return other_language::of_members(first.text, after);
        }
        if self.structures.contains(first.text) || !other_language::may_begin(first.text) {
            return None;
        }
        other_language::of_words(first.text, self.ahead(1).text)
    }

    /// Rejects a shader whose next declaration is in another shading language.
    fn is_other_language(&mut self) -> bool {
        let first = *self.token();
        let Some(language) = self.other_language(&first) else { return false };
        let Some(preprocessor) = &mut self.preprocessor else { return false };
        let message = match first.text {
            "struct" | "const" => format!("this declaration is in {language}, not GLSL"),
            word => format!("`{word}` begins a declaration in {language}, not GLSL"),
        };
        let help = match language {
            "WGSL" => "name the file `.wgsl`, or pass `--language wgsl`",
            _ => "landfall reads GLSL and WGSL",
        };
        preprocessor.stop(diagnostic_at(&first, Code::OtherLanguage, message).with_help(help));
        true
    }

    /// Parses `in NAME { … } name[];`, which has locations instead of bytes.
    fn interface(&mut self, start: usize, qualifiers: Qualifiers<'a>) -> Item<'a> {
        let name = self.name_here();
        self.skip_balanced();
        self.skip_statement();
        Item::Interface(BlockDecl {
            tokens: start..self.at,
            qualifiers,
            name,
            members: Vec::new(),
            instance: None,
            dims: Vec::new(),
            closed: true,
            diagnostics: self.diagnostics().len(),
        })
    }

    // block: IDENTIFIER LEFT_BRACE struct_declaration_list RIGHT_BRACE [IDENTIFIER array_specifier]
    fn block_item(&mut self, start: usize, qualifiers: Qualifiers<'a>) -> Item<'a> {
        let name = self.name_here();
        let open = self.bump();
        let diagnostics = self.diagnostics().len();
        let members = self.members(name.text);
        let closed = self.close(&open);
        let (mut instance, mut dims) = (None, Vec::new());
        if closed {
            if self.token().kind == Kind::Name {
                instance = Some(self.name_here());
                dims = self.dims();
            }
            self.end_of_statement();
        }
        let tokens = start..self.at;
        Item::Block(BlockDecl {
            tokens,
            qualifiers,
            name,
            members,
            instance,
            dims,
            closed,
            diagnostics,
        })
    }

    /// Parses the body of a block that was skipped.
    pub(super) fn interface_body(&mut self, block: &mut BlockDecl<'a>) -> Parsed<()> {
        let count = self.diagnostics().len();
        self.expect("{")?;
        block.members = self.members(block.name.text);
        self.failed_since(count)?;
        self.expect("}")?;
        if self.token().kind == Kind::Name {
            block.instance = Some(self.name()?);
            block.dims = self.dims();
            self.failed_since(count)?;
        }
        self.expect(";")?;
        Ok(())
    }

    fn variables_of_structure(&mut self, start: usize, qualifiers: Qualifiers<'a>) -> Item<'a> {
        let (mut ty, closed) = self.structure_type();
        let mut names = Vec::new();
        if closed {
            if self.is(";") {
                self.bump();
            } else {
                ty.dims = self.dims();
                names = self.declarators();
            }
        }
        let tokens = start..self.at;
        Item::Variables(Rc::new(Declaration { tokens, qualifiers, ty, names, broken: false }))
    }

    fn structure_type(&mut self) -> (TypeSpec<'a>, bool) {
        self.written = None;
        let (at, span) = (self.at, self.token().span);
        let structure = self.structure();
        let closed = structure.closed;
        let base = TypeBase::Struct(Rc::new(structure));
        let ty = TypeSpec { base, at, dims: Vec::new(), span, parameters: false, precision: None };
        (ty, closed)
    }

    fn named_type(&mut self) -> TypeSpec<'a> {
        let written = self.written.take();
        let name = self.name_here();
        TypeSpec {
            base: TypeBase::Name(name.text),
            at: name.at,
            dims: Vec::new(),
            span: name.span,
            parameters: false,
            precision: self.precision_of(written, name.text),
        }
    }

    // init_declarator_list: fully_specified_type declarators
    // function_prototype: fully_specified_type IDENTIFIER LEFT_PAREN … RIGHT_PAREN
    fn variables(&mut self, start: usize, qualifiers: Qualifiers<'a>) -> Item<'a> {
        let mut ty = self.named_type();
        let uniform = qualifiers.storage == Storage::Uniform;
        let (mut names, mut broken) = (Vec::new(), false);
        if self.is("<") {
            ty.parameters = true;
            self.skip_angles();
            broken = !uniform && !self.ahead(1).is("(");
        }
        if broken {
            // The initialiser of such a type may contain commas of its own.
            self.skip_statement();
        } else {
            ty.dims = self.dims();
            if self.token().kind != Kind::Name {
                self.report_unexpected();
                broken = true;
            } else if self.ahead(1).is("(") && !uniform {
                return self.function(start, ty);
            } else {
                names = self.declarators();
            }
        }
        let tokens = start..self.at;
        Item::Variables(Rc::new(Declaration { tokens, qualifiers, ty, names, broken }))
    }

    // function_definition: function_prototype compound_statement_no_new_scope
    fn function(&mut self, start: usize, returns: TypeSpec<'a>) -> Item<'a> {
        let name = self.name_here();
        let open = self.at;
        self.skip_balanced();
        let parameter_tokens = open + 1..(self.at - 1).max(open + 1);
        let mut body_tokens = None;
        if self.is("{") {
            let first = self.at + 1;
            self.pass_body(name.text);
            body_tokens = Some(first.min(self.at)..self.at.saturating_sub(1).max(first));
        } else {
            self.end_of_statement();
        }
        Item::Function(Rc::new(FunctionDecl {
            tokens: start..self.at,
            name,
            returns,
            parameter_tokens,
            parameters: Vec::new(),
            body_tokens,
            body: None,
        }))
    }

    /// Consumes the body of a function, whose `{` is the current token.
    fn pass_body(&mut self, function: &str) {
        let open = *self.token();
        let closed = match self.bodies {
            Bodies::Keep => self.skip_braces(),
            Bodies::Skip => self.preprocessor().skip_body(&open),
        };
        if !closed {
            let message = format!("the body of `{function}` is never closed");
            self.report(diagnostic_at(&open, Code::UnclosedBrace, message));
        }
        // The preprocessor passed the `}` without a token. `{` is the last token loaded, so a `}`
        // in its place keeps the list in step; the second `bump` loads what follows the body.
        if self.bodies == Bodies::Skip {
            self.tokens.push(Token { text: "}", ..open });
            self.bump();
            self.bump();
        }
    }

    // struct_specifier: STRUCT [IDENTIFIER] LEFT_BRACE struct_declaration_list RIGHT_BRACE
    fn structure(&mut self) -> StructDecl<'a> {
        let start = self.at;
        let keyword = self.bump();
        let name = match self.token().kind {
            Kind::Name => self.name_here(),
            _ => Name { text: "", span: keyword.span, at: start },
        };
        let mut structure =
            StructDecl { name, members: Vec::new(), closed: false, tokens: start..self.at };
        let open = *self.token();
        if !self.expect_or_report("{") {
            self.recover();
            return structure;
        }
        if self.open_structures == DEEPEST_STRUCTURE {
            let message = format!(
                "structures are declared inside each other more than {DEEPEST_STRUCTURE} deep"
            );
            let token = self.token_of(&name);
            let error = diagnostic_at(&token, Code::NestedTooDeep, message);
            match &mut self.preprocessor {
                Some(preprocessor) => preprocessor.stop(error),
                None => self.diagnostics.push(error),
            }
            return structure;
        }
        self.open_structures += 1;
        structure.members = self.members(self.token_of(&name).text);
        self.open_structures -= 1;
        structure.closed = self.close(&open);
        structure.tokens.end = self.at;
        // The name is not in scope among its own members (§4.2.2).
        if !name.text.is_empty() {
            self.structures.insert(name.text);
        }
        structure
    }

    /// Parses the members up to `}`. `owner` is the structure or block in messages.
    fn members(&mut self, owner: &str) -> Vec<Declaration<'a>> {
        let mut members = Vec::new();
        self.open_members += 1;
        while !self.is("}") && self.token().kind != Kind::End {
            if self.eat(";") {
                continue;
            }
            let diagnostics = self.diagnostics().len();
            let position = self.token().span;
            members.extend(self.member(owner));
            if self.diagnostics().len() > diagnostics && position == self.token().span {
                break; // no progress: the rest is not a member list
            }
        }
        self.open_members -= 1;
        members
    }

    // struct_declaration: [type_qualifier] type_specifier struct_declarator_list SEMICOLON
    fn member(&mut self, owner: &str) -> Option<Declaration<'a>> {
        let start = self.at;
        let qualifiers = self.qualifiers();
        let mut ty = if self.is("struct") {
            let (ty, closed) = self.structure_type();
            if !closed {
                let (tokens, names) = (start..self.at, Vec::new());
                return Some(Declaration { tokens, qualifiers, ty, names, broken: true });
            }
            ty
        } else if self.token().kind == Kind::Name {
            self.named_type()
        } else {
            let token = *self.token();
            let message = format!("unexpected `{}` among the members of `{owner}`", token.text);
            self.report(diagnostic_at(&token, Code::Syntax, message));
            self.recover_member();
            return None;
        };
        ty.dims = self.dims();
        let errors = self.errors();
        let names = self.declarators();
        let broken = self.errors() > errors;
        Some(Declaration { tokens: start..self.at, qualifiers, ty, names, broken })
    }

    /// Parses a declaration in a body; `None` for a prototype or another without effect.
    pub(super) fn local_declaration(&mut self) -> Parsed<Option<Declaration<'a>>> {
        let start = self.at;
        let qualifiers = self.qualifiers();
        let again = qualifiers.any && !self.is("struct");
        if again && (self.ahead(1).is(";") || self.ahead(1).is(",")) {
            self.skip_to_semicolon();
            return Ok(None);
        }
        let count = self.diagnostics().len();
        let ty = self.type_spec()?;
        if self.token().kind == Kind::Name && self.ahead(1).is("(") {
            // `vec4 f(vec2);` is a prototype. `a b(c);` is not: an operator is missing after `a`.
            let is_type = ty
                .base_name()
                .is_none_or(|name| builtin(name).is_some() || self.structures.contains(name));
            if !is_type {
                return Err(self.unexpected(Wanted::Token(";")));
            }
            self.skip_to_semicolon();
            return Ok(None);
        }
        let names = if self.eat(";") { Vec::new() } else { self.declarators() };
        self.failed_since(count)?;
        let tokens = start..self.at;
        Ok(Some(Declaration { tokens, qualifiers, ty, names, broken: false }))
    }

    // declarators: IDENTIFIER [array_specifier] [EQUAL initializer] { COMMA … }
    fn declarators(&mut self) -> Vec<Declarator<'a>> {
        let mut declarators = Vec::with_capacity(1);
        loop {
            if self.token().kind != Kind::Name {
                self.report_unexpected();
                return declarators;
            }
            let name = self.name_here();
            let dims = self.dims();
            let (mut tokens, mut init) = (self.at..self.at, None);
            if self.eat("=") {
                (tokens, init) = self.code(&[",", ";"]);
                if tokens.is_empty() {
                    let error = self.unexpected(Wanted::Expression).diagnostic();
                    self.report(*error);
                }
            }
            declarators.push(Declarator { name, dims, tokens, init });
            if !self.eat(",") {
                break;
            }
        }
        self.end_of_statement();
        declarators
    }

    // array_specifier: { LEFT_BRACKET [conditional_expression] RIGHT_BRACKET }
    pub(super) fn dims(&mut self) -> Vec<Dim<'a>> {
        let mut dims = Vec::new();
        while self.is("[") {
            let open = self.bump();
            let (tokens, size) = self.code(&["]"]);
            let span = open.span.to(self.token().span);
            if !self.expect_or_report("]") {
                break;
            }
            dims.reserve_exact(1);
            dims.push(Dim { tokens, span, size });
        }
        dims
    }

    /// Parses an expression up to one of `ends` where bodies are parsed, otherwise skips it.
    // Layouts need few of the expressions: a tree is only built by `expression_of`.
    pub(super) fn code(&mut self, ends: &[&str]) -> (Tokens, Option<Box<Expr<'a>>>) {
        let start = self.at;
        if !self.direct {
            self.skip_until(ends);
            return (start..self.at, None);
        }
        if ends.iter().any(|end| self.is(end)) {
            return (start..start, None);
        }
        let parsed = if ends == ["]"] { self.expression() } else { self.assignment() };
        let expr = parsed.map_err(|error| self.report(*error.diagnostic())).ok();
        (start..self.at, expr.map(Box::new))
    }

    pub(super) fn type_spec(&mut self) -> Parsed<TypeSpec<'a>> {
        let count = self.diagnostics().len();
        let mut ty = if self.is("struct") {
            self.structure_type().0
        } else if self.token().kind == Kind::Name {
            self.named_type()
        } else {
            return Err(self.unexpected(Wanted::Name));
        };
        if self.is("<") {
            return Err(parametric(ty.span));
        }
        ty.dims = self.dims();
        self.failed_since(count)?;
        Ok(ty)
    }
}

pub(super) fn parametric(span: Span) -> SyntaxError {
    let message = "types with parameters, such as `coopmat<…>`, cannot be executed";
    SyntaxError::Other(Box::new(Diagnostic::error(Code::CannotRun, span, message)))
}
