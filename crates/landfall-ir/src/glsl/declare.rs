//! From tokens to [`ast`](super::ast): declarations, blocks, functions.

use landfall_layout::diagnostic::Code;
use std::rc::Rc;

use super::ast::*;
use super::parse::{Parsed, Parser};
use landfall_layout::diagnostic::Diagnostic;
use landfall_layout::source::Span;
pub use landfall_layout::syntax::glsl::lexer::Kind;
pub use landfall_layout::syntax::glsl::qualifiers::{OTHER_STORAGE, SILENT};

/// Structures may be declared inside each other this deep.
const DEEPEST_STRUCTURE: u32 = 16;

/// Whether a qualifier may stand alone: `layout(…) in;`.
fn is_alone(word: &str) -> bool {
    matches!(word, "in" | "out" | "uniform" | "buffer")
}

fn precision(word: &str) -> Option<Precision> {
    match word {
        "lowp" => Some(Precision::Low),
        "mediump" => Some(Precision::Medium),
        "highp" => Some(Precision::High),
        _ => None,
    }
}

/// Whether a word stands before types.
pub fn is_qualifier(word: &str) -> bool {
    matches!(word, "uniform" | "buffer" | "const" | "layout" | "subroutine")
        || OTHER_STORAGE.contains(&word)
        || SILENT.contains(&word)
}

impl<'a> Parser<'a, '_> {
    /// The whole shader.
    pub fn items(&mut self) -> Parsed<Vec<Item<'a>>> {
        let mut items = Vec::new();
        while self.token().kind != Kind::End {
            if self.eat(";") {
                continue;
            }
            if self.is("precision") {
                self.precision_statement();
                continue;
            }
            if let Some(item) = self.item()? {
                items.push(item);
            }
        }
        Ok(items)
    }

    fn item(&mut self) -> Parsed<Option<Item<'a>>> {
        let qualifiers = self.qualifiers()?;
        if self.eat(";") {
            return Ok(Some(Item::Defaults(qualifiers)));
        }
        let blockish = matches!(
            qualifiers.storage,
            Storage::Uniform | Storage::Buffer | Storage::In | Storage::Out | Storage::Foreign
        );
        if self.ahead(1).is("{") && blockish && !self.is("struct") {
            return self.block_item(qualifiers).map(Some);
        }
        if qualifiers.any && (self.ahead(1).is(";") || self.ahead(1).is(",")) && !self.is("struct")
        {
            // `invariant gl_Position;`
            self.skip_to_semicolon();
            return Ok(None);
        }
        let ty = self.type_spec()?;
        if self.token().kind == Kind::Name && self.ahead(1).is("(") {
            return self.function(ty).map(|f| Some(Item::Function(Rc::new(f))));
        }
        let names = self.declarators()?;
        Ok(Some(Item::Variables(Rc::new(Declaration { qualifiers, ty, names }))))
    }

    fn block_item(&mut self, qualifiers: Qualifiers<'a>) -> Parsed<Item<'a>> {
        let name = self.name()?;
        let members = self.members()?;
        let mut instance = None;
        let mut dims = Vec::new();
        if self.token().kind == Kind::Name {
            instance = Some(self.name()?);
            dims = self.dims()?;
        }
        self.expect(";")?;
        Ok(Item::Block(BlockDecl { qualifiers, name, members, instance, dims }))
    }

    fn members(&mut self) -> Parsed<Vec<Declaration<'a>>> {
        self.expect("{")?;
        let mut members = Vec::new();
        while !self.eat("}") {
            if self.eat(";") {
                continue;
            }
            let qualifiers = self.qualifiers()?;
            let ty = self.type_spec()?;
            let names = self.declarators()?;
            members.push(Declaration { qualifiers, ty, names });
        }
        Ok(members)
    }

    /// A declaration in a body; `None` for a prototype or another thing without effect.
    pub fn local_declaration(&mut self) -> Parsed<Option<Declaration<'a>>> {
        let qualifiers = self.qualifiers()?;
        if qualifiers.any && (self.ahead(1).is(";") || self.ahead(1).is(",")) && !self.is("struct")
        {
            self.skip_to_semicolon();
            return Ok(None);
        }
        let ty = self.type_spec()?;
        if self.token().kind == Kind::Name && self.ahead(1).is("(") {
            self.skip_to_semicolon();
            return Ok(None);
        }
        let names = self.declarators()?;
        Ok(Some(Declaration { qualifiers, ty, names }))
    }

    fn function(&mut self, returns: TypeSpec<'a>) -> Parsed<FunctionDecl<'a>> {
        let name = self.name()?;
        self.expect("(")?;
        let mut parameters = Vec::new();
        if self.is("void") && self.ahead(1).is(")") {
            self.bump();
        }
        while !self.eat(")") {
            let qualifiers = self.qualifiers()?;
            let ty = self.type_spec()?;
            let name = match self.token().kind {
                Kind::Name => self.name()?,
                _ => Name { text: "", span: ty.span },
            };
            let dims = self.dims()?;
            parameters.push(Parameter { qualifiers, ty, name, dims });
            if !self.eat(",") && !self.is(")") {
                return Err(self.unexpected("expected `,` or `)`"));
            }
        }
        let body = match self.eat("{") {
            true => Some(self.block()?),
            false => {
                self.expect(";")?;
                None
            }
        };
        Ok(FunctionDecl { name, returns, parameters, body })
    }

    /// `a, b[2] = …;`
    fn declarators(&mut self) -> Parsed<Vec<Declarator<'a>>> {
        let mut names = Vec::new();
        while !self.eat(";") {
            let name = self.name()?;
            let dims = self.dims()?;
            let init = if self.eat("=") { Some(self.assignment()?) } else { None };
            names.push(Declarator { name, dims, init });
            if !self.eat(",") && !self.is(";") {
                return Err(self.unexpected("expected `,` or `;`"));
            }
        }
        Ok(names)
    }

    pub fn dims(&mut self) -> Parsed<Vec<Dim<'a>>> {
        let mut dims = Vec::new();
        while self.is("[") {
            self.bump();
            let size = if self.is("]") { None } else { Some(self.expression()?) };
            self.expect("]")?;
            dims.push(Dim { size });
        }
        Ok(dims)
    }

    /// `precision mediump float;`
    pub fn precision_statement(&mut self) {
        let (said, ty) = (precision(self.ahead(1).text), self.ahead(2).text);
        if let (Some(precisions), Some(said)) = (&mut self.precisions, said) {
            match ty {
                "float" => precisions.float = Some(said),
                "sampler2D" | "samplerCube" => precisions.sampled = said,
                _ => {}
            }
        }
        self.skip_to_semicolon();
    }

    /// The precision of a type: what was said before it, or the default.
    fn precision_of(&self, said: Option<Precision>, base: &TypeBase<'a>) -> Option<Precision> {
        let precisions = self.precisions?;
        let TypeBase::Name(name) = base else { return None };
        match *name {
            "float" => said.or(precisions.float),
            "sampler2D" | "samplerCube" => said.or(Some(precisions.sampled)),
            _ if name.starts_with("vec") || name.starts_with("mat") => said.or(precisions.float),
            _ if name.starts_with("sampler") => said,
            _ => None,
        }
    }

    pub fn type_spec(&mut self) -> Parsed<TypeSpec<'a>> {
        let said = self.said.take();
        let start = self.token().span;
        let base = if self.is("struct") {
            TypeBase::Struct(Rc::new(self.structure()?))
        } else {
            TypeBase::Name(self.name()?.text)
        };
        if self.is("<") {
            let message = "types with parameters cannot run";
            return Err(Box::new(Diagnostic::error(Code::CannotRun, start, message)));
        }
        let span = match base {
            TypeBase::Struct(_) => start,
            TypeBase::Name(_) => self.since(start),
        };
        let precision = self.precision_of(said, &base);
        Ok(TypeSpec { base, dims: self.dims()?, span, precision })
    }

    fn structure(&mut self) -> Parsed<StructDecl<'a>> {
        let keyword = self.bump().span;
        let name = match self.token().kind {
            Kind::Name => self.name()?,
            _ => Name { text: "", span: keyword },
        };
        self.open_structures += 1;
        if self.open_structures > DEEPEST_STRUCTURE {
            let message = "structures are declared inside each other too deep";
            return Err(Box::new(Diagnostic::error(Code::NestedTooDeep, name.span, message)));
        }
        let members = self.members()?;
        self.open_structures -= 1;
        if !name.text.is_empty() {
            self.structures.insert(name.text);
        }
        Ok(StructDecl { name, members })
    }

    pub fn qualifiers(&mut self) -> Parsed<Qualifiers<'a>> {
        let mut qualifiers = Qualifiers::default();
        self.said = None;
        while self.token().kind == Kind::Name {
            let word = self.token().text;
            if !self.stands_qualifier() {
                break;
            }
            qualifiers.any = true;
            self.bump();
            match word {
                "layout" => {
                    self.layout(&mut qualifiers.layout)?;
                }
                "subroutine" => {
                    qualifiers.subroutine = true;
                    self.skip_round();
                }
                "const" => {
                    qualifiers.constant = true;
                    if qualifiers.storage == Storage::Plain {
                        qualifiers.storage = Storage::Const;
                    }
                }
                "in" | "attribute" => qualifiers.storage = Storage::In,
                "out" => qualifiers.storage = Storage::Out,
                "inout" => qualifiers.storage = Storage::InOut,
                // Which of the two it is, the stage says.
                "varying" => {
                    qualifiers.storage =
                        if self.stage_reads_varyings { Storage::In } else { Storage::Out }
                }
                "uniform" => qualifiers.storage = Storage::Uniform,
                "buffer" => qualifiers.storage = Storage::Buffer,
                "shared" => qualifiers.storage = Storage::Shared,
                "flat" => qualifiers.flat = true,
                "noperspective" => qualifiers.noperspective = true,
                "centroid" => qualifiers.centroid = true,
                "sample" => qualifiers.sample = true,
                "patch" => qualifiers.patch = true,
                "lowp" | "mediump" | "highp" => self.said = precision(word),
                "readonly" => qualifiers.readonly = true,
                "writeonly" => qualifiers.writeonly = true,
                _ if word.starts_with("spirv_") => self.skip_round(),
                _ if OTHER_STORAGE.contains(&word) => qualifiers.storage = Storage::Foreign,
                _ => {}
            }
        }
        Ok(qualifiers)
    }

    /// Whether a qualifier stands here: in old versions some are names, as `sample` is.
    pub fn stands_qualifier(&self) -> bool {
        let word = self.token().text;
        if !is_qualifier(word) && !word.starts_with("spirv_") {
            return false;
        }
        let next = self.ahead(1);
        next.kind == Kind::Name || next.is("(") || next.is("{") || (next.is(";") && is_alone(word))
    }

    /// `(…)`, if it stands here.
    fn skip_round(&mut self) {
        if !self.is("(") {
            return;
        }
        let mut depth = 0u32;
        loop {
            match self.token().text {
                "(" => depth += 1,
                ")" => depth -= 1,
                _ if self.token().kind == Kind::End => return,
                _ => {}
            }
            self.bump();
            if depth == 0 {
                return;
            }
        }
    }

    fn layout(&mut self, ids: &mut Vec<LayoutId<'a>>) -> Parsed<Span> {
        self.expect("(")?;
        while !self.is(")") {
            let name = self.name()?;
            let value = if self.eat("=") { Some(self.assignment()?) } else { None };
            ids.push(LayoutId { name, value });
            if !self.eat(",") {
                break;
            }
        }
        self.expect(")")
    }
}
