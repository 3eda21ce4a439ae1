//! Extracts the shape of a shader from its parsed declarations: structures, blocks, loose uniforms
//! and constants. Other declarations are skipped.

use std::sync::Arc;

use rustc_hash::FxHashMap;

use super::ast::{Declaration, Item, Qualifiers, Storage, TypeBase};
use super::constants::Constants;
use super::globals::Globals;
use super::lexer::Token;
use super::members::TypeName;
use super::parser::Parser;
use super::types::{Builtin, builtin};
use crate::diagnostic::Diagnostic;
use crate::shape::{
    Block, LengthConstant, MatrixLayout, Member, Rules, SpecialisedLength, Struct, Type,
};
use crate::source::{ReadOptions, Span, Stage};

/// Collects the shape of a shader from its declarations.
// GLSL declares before it uses (§4.2.2), so one pass over the declarations resolves all types and
// constants; what is known so far is what is in scope.
pub(super) struct DeclarationReader<'a> {
    pub parser: Parser<'a>,
    /// The stage, if the file's name or the caller tells.
    pub stage: Option<Stage>,
    pub types: FxHashMap<&'a str, Named<'a>>,
    pub constants: Constants<'a>,
    pub uniform_defaults: Defaults,
    pub buffer_defaults: Defaults,
    pub blocks: Vec<Block>,
    /// Loose uniforms that hold data.
    pub loose: Vec<Member>,
    /// Names of loose uniforms that are opaque handles.
    pub loose_opaque: Vec<Arc<str>>,
    /// Members of blocks whose length is left to their use.
    pub unsized_members: Vec<Unsized<'a>>,
    /// The instance of the block whose members are read.
    pub instance: Option<&'a str>,
    /// Lengths of such members, once the bodies were read for them.
    pub lengths: Lengths<'a>,
    pub globals: Globals<'a>,
    /// The arrays whose lengths depend on specialisation constants.
    pub specialised: Vec<SpecialisedLength>,
    /// The constants that lengths are written with, each with the name of the member or block.
    pub length_constants: Vec<(Span, LengthConstant)>,
    /// The members whose lengths were taken from their uses.
    pub sized_by_use: Vec<Span>,
}

/// Defaults for later blocks, set by `layout(…) uniform;` and `layout(…) buffer;`.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Defaults {
    /// The rules, if set; `Some(None)` means the driver's own (`shared`, `packed`).
    pub rules: Option<Option<Rules>>,
    pub matrix_layout: Option<MatrixLayout>,
}

#[derive(Clone, Debug)]
pub(super) enum Named<'a> {
    Struct(Arc<Struct>),
    /// `layout(buffer_reference) buffer NAME`.
    Reference,
    /// A structure that cannot be laid out, and the reason; reported when it is used.
    // Its errors wait for the first use, to stand before what follows from them. Those of
    // structures that are never used are reported at the end.
    Broken {
        name: Token<'a>,
        why: Vec<Diagnostic>,
        reported: bool,
    },
}

/// A member whose length the text leaves open.
#[derive(Clone, Debug)]
pub(super) struct Unsized<'a> {
    /// The instance of its block, if that has one.
    pub instance: Option<&'a str>,
    pub name: &'a str,
    pub brackets: Span,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Unknown {
    /// No constant index is used.
    Unused,
    /// The index here is not constant.
    NotConstant(Span),
    /// The name is used without an index here, or what stands here cannot be read.
    Ambiguous(Span),
}

/// The length of each member by its block's instance and its name, or why it is not known.
pub(super) type Lengths<'a> = FxHashMap<(Option<&'a str>, &'a str), Result<u32, Unknown>>;

impl<'a> DeclarationReader<'a> {
    pub fn new(parser: Parser<'a>) -> DeclarationReader<'a> {
        DeclarationReader {
            parser,
            stage: None,
            types: FxHashMap::default(),
            constants: Constants::default(),
            uniform_defaults: Defaults::default(),
            buffer_defaults: Defaults::default(),
            blocks: Vec::new(),
            loose: Vec::new(),
            loose_opaque: Vec::new(),
            unsized_members: Vec::new(),
            instance: None,
            lengths: Lengths::default(),
            globals: Globals::default(),
            specialised: Vec::new(),
            length_constants: Vec::new(),
            sized_by_use: Vec::new(),
        }
    }

    /// Reads the whole shader and passes each declaration to `keep`.
    pub fn read(&mut self, mut keep: impl FnMut(&mut Parser<'a>, Item<'a>)) {
        while let Some(item) = self.parser.item() {
            self.item(&item);
            keep(&mut self.parser, item);
        }
        self.report_unused_broken_types();
    }

    /// Reads the whole shader and returns its declarations.
    pub fn read_items(&mut self) -> Vec<Item<'a>> {
        let mut items = Vec::new();
        self.read(|_, item| items.push(item));
        items
    }

    pub fn options(&mut self) -> &'a ReadOptions {
        self.parser.preprocessor().options
    }

    pub fn report(&mut self, diagnostic: Diagnostic) {
        self.parser.report(diagnostic);
    }

    pub fn report_all(&mut self, all: impl IntoIterator<Item = Diagnostic>) {
        all.into_iter().for_each(|diagnostic| self.report(diagnostic));
    }

    fn item(&mut self, item: &Item<'a>) {
        let clashes = self.globals.declare(&self.parser, item);
        self.report_all(clashes);
        self.check_names(item);
        match item {
            Item::Defaults(qualifiers) => {
                let errors = self.illegal_defaults(qualifiers);
                self.report_all(errors);
                self.set_defaults(qualifiers);
            }
            Item::Block(block) => self.block(block),
            // `layout(buffer_reference) buffer NAME;`, a forward declaration.
            Item::Requalified(qualifiers, name) => {
                self.check_requalified(qualifiers, name);
                let buffer = qualifiers.storage == Storage::Buffer;
                if buffer && qualifiers.find("buffer_reference").is_some() {
                    self.types.insert(name.text, Named::Reference);
                }
            }
            Item::Variables(declaration) => self.variables(declaration),
            Item::Interface(block) => self.interface(block),
            Item::Precision(tokens) => {
                let error = self.illegal_precision(tokens);
                self.report_all(error);
            }
            Item::Function(function) => self.check_function(function),
            Item::Other(_) => {}
        }
    }

    /// Applies `layout(…) uniform;` or `layout(…) buffer;`, which set defaults.
    fn set_defaults(&mut self, qualifiers: &Qualifiers<'a>) {
        let defaults = match qualifiers.storage {
            Storage::Uniform => &mut self.uniform_defaults,
            Storage::Buffer => &mut self.buffer_defaults,
            _ => return,
        };
        // A later default overrides an earlier one, each kind on its own (§4.4.5).
        let own = super::blocks::own_defaults(qualifiers);
        defaults.rules = own.rules.or(defaults.rules);
        defaults.matrix_layout = own.matrix_layout.or(defaults.matrix_layout);
    }

    /// Reads `TYPE a, b;` or `struct NAME { … } a, b;`.
    fn variables(&mut self, declaration: &Declaration<'a>) {
        let Declaration { qualifiers, ty, names, broken, .. } = declaration;
        if *broken {
            return; // a syntax error, reported before
        }
        let errors = self.illegal_variables(declaration);
        self.report_all(errors);
        let type_name = match &ty.base {
            TypeBase::Struct(structure) => match self.structure(structure) {
                Some(named) => TypeName::Declared(named),
                None => return,
            },
            TypeBase::Name(_) => TypeName::Name(self.parser.tokens()[ty.at]),
        };
        // `loose_uniforms` resolves the types of uniforms.
        if let (TypeName::Name(token), true) = (&type_name, qualifiers.storage != Storage::Uniform)
        {
            self.check_declared_type(token);
        }
        if qualifiers.subroutine {
            // A subroutine uniform is set by separate calls and has no bytes.
        } else if qualifiers.storage == Storage::Uniform {
            self.loose_uniforms(&type_name, declaration);
        } else if let (true, TypeBase::Name(name)) = (qualifiers.constant, &ty.base) {
            for declarator in names {
                let is_single = ty.dims.is_empty() && declarator.dims.is_empty();
                let scalar = match builtin(name) {
                    Some(Builtin::Data(Type::Scalar(scalar))) if is_single => Some(scalar),
                    _ => None,
                };
                self.add_constant(declarator, scalar, qualifiers);
            }
        }
    }

    /// Returns a structure as a block; what is wrong with it is reported.
    pub fn structure_named(&mut self, name: &str) -> Option<Block> {
        match self.types.get(name) {
            Some(Named::Struct(structure)) => {
                return Some(Block::of_structure(structure, Rules::Std140));
            }
            Some(Named::Broken { .. }) => return None,
            Some(Named::Reference) | None => {}
        }
        let structures = self.types.iter();
        let mut known: Vec<&str> = structures
            .filter_map(|(name, named)| matches!(named, Named::Struct(_)).then_some(*name))
            .collect();
        known.sort_unstable();
        self.report(crate::syntax::no_structure(name, known.into_iter()));
        None
    }

    fn report_unused_broken_types(&mut self) {
        let unreported = self.types.values().filter_map(|named| match named {
            Named::Broken { why, reported: false, .. } => Some(why),
            Named::Broken { .. } | Named::Struct(_) | Named::Reference => None,
        });
        let mut unreported: Vec<_> = unreported.flatten().cloned().collect();
        // The table has no order; messages are in that of the text.
        unreported.sort_by_key(|d| d.labels.first().map(|label| (label.at.file, label.at.start)));
        self.report_all(unreported);
    }
}
