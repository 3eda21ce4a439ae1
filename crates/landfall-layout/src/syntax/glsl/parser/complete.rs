//! Parsing on demand: expressions, parameters and bodies of declarations.

use std::rc::Rc;

use super::declaration::parametric;
use super::qualifiers::is_float;
use super::{Parsed, Parser};
use crate::source::Stage;
use crate::syntax::glsl::ast::{
    BlockDecl, Declaration, Dim, FunctionDecl, Item, Name, Parameter, PrecisionQualifier,
    Precisions, Qualifiers, Storage, TypeBase, TypeSpec,
};
use crate::syntax::glsl::lexer::Kind;

impl<'a> Parser<'a> {
    /// Parses the expressions, parameters and bodies kept as tokens, for a shader of that stage.
    ///
    /// # Errors
    /// The first syntax error.
    // In the order of the text, because `precision` statements set defaults for what follows.
    pub fn complete(&mut self, items: &mut [Item<'a>], stage: Option<Stage>) -> Parsed<()> {
        self.varying = match stage {
            // GLSL ES 1.00 §4.3.5: `varying` is written by the vertex and read by the fragment
            // shader.
            Some(Stage::Vertex) => Storage::Out,
            _ => Storage::In,
        };
        // GLSL ES 3.20 §4.7.4: a fragment shader has no default precision for floats.
        let float = (stage != Some(Stage::Fragment)).then_some(PrecisionQualifier::High);
        self.stage_float = float.filter(|_| self.has_precisions);
        self.precisions = Precisions { float: self.stage_float, ..Precisions::default() };
        for item in items {
            match item {
                Item::Variables(declaration) => {
                    let declaration = Rc::get_mut(declaration).expect("nobody shares it yet");
                    self.complete_declaration(declaration)?;
                }
                Item::Block(block) => {
                    self.complete_qualifiers(&mut block.qualifiers)?;
                    for member in &mut block.members {
                        self.complete_declaration(member)?;
                    }
                    self.complete_dims(&mut block.dims)?;
                }
                Item::Interface(block) => {
                    self.complete_qualifiers(&mut block.qualifiers)?;
                    self.complete_interface(block)?;
                }
                Item::Function(function) => {
                    let function = Rc::get_mut(function).expect("nobody shares it yet");
                    self.complete_function(function)?;
                }
                Item::Defaults(qualifiers) | Item::Requalified(qualifiers, _) => {
                    self.complete_qualifiers(qualifiers)?;
                }
                Item::Precision(tokens) => self.part(tokens, |parser| {
                    parser.precision_statement();
                    Ok(())
                })?,
                Item::Other(_) => {}
            }
        }
        Ok(())
    }

    fn complete_declaration(&mut self, declaration: &mut Declaration<'a>) -> Parsed<()> {
        self.complete_qualifiers(&mut declaration.qualifiers)?;
        self.complete_type(&mut declaration.ty)?;
        for declarator in &mut declaration.names {
            self.complete_dims(&mut declarator.dims)?;
            if !declarator.tokens.is_empty() {
                declarator.init = Some(Box::new(self.expression_of(&declarator.tokens)?));
            }
        }
        Ok(())
    }

    fn complete_qualifiers(&mut self, qualifiers: &mut Qualifiers<'a>) -> Parsed<()> {
        if qualifiers.storage == Storage::Varying {
            qualifiers.storage = self.varying;
        }
        for id in &mut qualifiers.layout {
            if !id.tokens.is_empty() {
                id.value = Some(Box::new(self.expression_of(&id.tokens)?));
            }
        }
        Ok(())
    }

    fn complete_dims(&mut self, dims: &mut [Dim<'a>]) -> Parsed<()> {
        for dim in dims {
            if !dim.tokens.is_empty() {
                dim.size = Some(Box::new(self.part(&dim.tokens, Self::expression)?));
            }
        }
        Ok(())
    }

    fn complete_type(&mut self, ty: &mut TypeSpec<'a>) -> Parsed<()> {
        if ty.parameters {
            return Err(parametric(ty.span));
        }
        if let TypeBase::Struct(structure) = &mut ty.base {
            let structure = Rc::get_mut(structure).expect("nobody shares it yet");
            for member in &mut structure.members {
                self.complete_declaration(member)?;
            }
        }
        // A float type without a precision has the stage's default.
        if matches!(ty.base, TypeBase::Name(name) if is_float(name)) {
            ty.precision = ty.precision.or(self.stage_float);
        }
        self.complete_dims(&mut ty.dims)
    }

    fn complete_function(&mut self, function: &mut FunctionDecl<'a>) -> Parsed<()> {
        self.complete_type(&mut function.returns)?;
        function.parameters = self.parameters_of(function)?;
        if let Some(tokens) = &function.body_tokens {
            function.body = Some(self.part(tokens, Self::body)?);
        }
        Ok(())
    }

    /// Parses the members of a block of inputs or outputs.
    pub fn complete_interface(&mut self, block: &mut BlockDecl<'a>) -> Parsed<()> {
        // From the `{`, which follows the name.
        let body = block.name.at + 1..block.tokens.end;
        self.part(&body, |parser| parser.interface_body(block))
    }

    pub fn parameters_of(&mut self, function: &FunctionDecl<'a>) -> Parsed<Vec<Parameter<'a>>> {
        self.part(&function.parameter_tokens, Self::parameters)
    }

    // function_parameters: parameter_declaration { COMMA parameter_declaration }
    // parameter_declaration: [type_qualifier] (parameter_declarator | parameter_type_specifier)
    // parameter_declarator: type_specifier IDENTIFIER [array_specifier]
    fn parameters(&mut self) -> Parsed<Vec<Parameter<'a>>> {
        let mut parameters = Vec::new();
        if self.is("void") && self.ahead(1).kind == Kind::End {
            self.bump();
        }
        while self.token().kind != Kind::End {
            let start = self.at;
            let count = self.diagnostics().len();
            let qualifiers = self.qualifiers();
            self.failed_since(count)?;
            let ty = self.type_spec()?;
            let name = match self.token().kind {
                Kind::Name => self.name()?,
                _ => Name { text: "", span: ty.span, at: ty.at },
            };
            let dims = self.dims();
            self.failed_since(count)?;
            let tokens = start..self.at;
            parameters.push(Parameter { tokens, qualifiers, ty, name, dims });
            if !self.eat(",") && self.token().kind != Kind::End {
                return Err(self.unexpected(super::Wanted::CommaOr(")")));
            }
        }
        Ok(parameters)
    }
}
