//! The shape of a shader from its parsed declarations: structures, blocks, loose uniforms and
//! constants; everything else is passed over.

use std::sync::Arc;

use rustc_hash::FxHashMap;

use super::ast::{Declaration, Item, Qualifiers, Storage, TypeBase};
use super::constants::Constants;
use super::evaluate::kind_of;
use super::lexer::Token;
use super::members::TypeName;
use super::parser::Parser;
use super::types::{Builtin, builtin};
use crate::diagnostic::Diagnostic;
use crate::shape::{Block, Majorness, Member, Rules, Struct, Type};
use crate::source::ReadOptions;

/// Collects the shape of a shader from its declarations.
pub(super) struct Reader<'a> {
    pub parser: Parser<'a>,
    pub types: FxHashMap<&'a str, Named<'a>>,
    pub constants: Constants<'a>,
    pub uniform_defaults: Defaults,
    pub buffer_defaults: Defaults,
    pub blocks: Vec<Block>,
    /// Loose uniforms that hold data.
    pub loose: Vec<Member>,
    /// Loose uniforms that are handles: their names.
    pub loose_opaque: Vec<Arc<str>>,
}

/// What `layout(…) uniform;` and `layout(…) buffer;` set for the blocks that follow.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Defaults {
    /// The rules, if set; `None` inside means the driver's own (`shared`, `packed`).
    pub rules: Option<Option<Rules>>,
    pub majorness: Option<Majorness>,
}

/// A type the shader declares.
#[derive(Clone, Debug)]
pub(super) enum Named<'a> {
    Struct(Arc<Struct>),
    /// `layout(buffer_reference) buffer NAME`.
    Reference,
    /// A structure that cannot be laid out, and why; told when something is made of it.
    Broken {
        name: Token<'a>,
        why: Vec<Diagnostic>,
        told: bool,
    },
}

impl<'a> Reader<'a> {
    pub fn new(parser: Parser<'a>) -> Reader<'a> {
        Reader {
            parser,
            types: FxHashMap::default(),
            constants: Constants::default(),
            uniform_defaults: Defaults::default(),
            buffer_defaults: Defaults::default(),
            blocks: Vec::new(),
            loose: Vec::new(),
            loose_opaque: Vec::new(),
        }
    }

    /// Reads the whole shader, and gives each declaration to `keep`.
    pub fn read(&mut self, mut keep: impl FnMut(&mut Parser<'a>, Item<'a>)) {
        while let Some(item) = self.parser.item() {
            self.item(&item);
            keep(&mut self.parser, item);
        }
        self.tell_unused_broken_types();
    }

    pub fn options(&mut self) -> &'a ReadOptions {
        self.parser.preprocessor().options
    }

    pub fn report(&mut self, diagnostic: Diagnostic) {
        self.parser.report(diagnostic);
    }

    fn item(&mut self, item: &Item<'a>) {
        match item {
            Item::Defaults(qualifiers) => self.set_defaults(qualifiers),
            Item::Block(block) => self.block(block),
            // `layout(buffer_reference) buffer NAME;` ahead of its body.
            Item::Requalified(qualifiers, name) => {
                let buffer = qualifiers.storage == Storage::Buffer;
                if buffer && qualifiers.find("buffer_reference").is_some() {
                    self.types.insert(name.text, Named::Reference);
                }
            }
            Item::Variables(declaration) => self.variables(declaration),
            Item::Interface(_) | Item::Function(_) | Item::Precision(_) | Item::Other(_) => {}
        }
    }

    /// `layout(…) uniform;` sets defaults; so does `layout(…) buffer;`.
    fn set_defaults(&mut self, qualifiers: &Qualifiers<'a>) {
        let defaults = match qualifiers.storage {
            Storage::Uniform => &mut self.uniform_defaults,
            Storage::Buffer => &mut self.buffer_defaults,
            _ => return,
        };
        let own = super::blocks::own_defaults(qualifiers);
        defaults.rules = own.rules.or(defaults.rules);
        defaults.majorness = own.majorness.or(defaults.majorness);
    }

    /// `TYPE a, b;` or `struct NAME { … } a, b;`
    fn variables(&mut self, declaration: &Declaration<'a>) {
        let Declaration { qualifiers, ty, names, broken, .. } = declaration;
        if *broken {
            return; // a syntax error: said already
        }
        let type_name = match &ty.base {
            TypeBase::Struct(structure) => match self.structure(structure) {
                Some(named) => TypeName::Declared(named),
                None => return,
            },
            TypeBase::Name(_) => TypeName::Name(self.parser.tokens()[ty.at]),
        };
        if qualifiers.subroutine {
            // A subroutine uniform is set by its own call and has no bytes.
        } else if qualifiers.storage == Storage::Uniform {
            self.loose_uniforms(&type_name, declaration);
        } else if let (true, TypeBase::Name(name)) = (qualifiers.constant, &ty.base) {
            for declarator in names {
                let kind = match builtin(name) {
                    Some(Builtin::Data(Type::Scalar(scalar)))
                        if ty.dims.is_empty() && declarator.dims.is_empty() =>
                    {
                        Some(kind_of(scalar))
                    }
                    _ => None,
                };
                self.add_constant(declarator, kind, qualifiers);
            }
        }
    }

    fn tell_unused_broken_types(&mut self) {
        let types = std::mem::take(&mut self.types);
        let mut untold: Vec<_> = types
            .into_values()
            .filter_map(|named| match named {
                Named::Broken { why, told: false, .. } => Some(why),
                Named::Broken { .. } | Named::Struct(_) | Named::Reference => None,
            })
            .flatten()
            .collect();
        untold.sort_by_key(|d| d.labels.first().map(|label| (label.span.file, label.span.start)));
        for diagnostic in untold {
            self.report(diagnostic);
        }
    }
}
