//! Lays out Rust types by rustc's rules, or by those of a library that writes them: primitives,
//! arrays, `repr(C)` structures of the same file, and the math types of [`known`](super::known).
//!
//! Other types are errors that name the type.

use std::cell::Cell;
use std::rc::Rc;

use syn::{Expr, Lit};

use super::file::{Declarations, Structure};
use super::known;
use super::library::{self, MirrorWriter, Wrapped};
use super::rust_type::{LaidField, RustType, Shape, StructureLayout, TypeArgument, UnknownLayout};
use super::syntax;

/// The deepest nesting of structures, aliases and constants.
const DEEPEST: u32 = 32;

/// The most types examined for one structure, which bounds the time on hostile texts.
const MAX_STEPS: u32 = 100_000;

/// Lays out the types of one file.
pub(super) struct Types<'d> {
    declarations: &'d Declarations,
    /// Who places the fields in the buffer.
    writer: MirrorWriter,
    steps: Cell<u32>,
}

impl<'d> Types<'d> {
    pub fn new(declarations: &'d Declarations, writer: MirrorWriter) -> Types<'d> {
        Types { declarations, writer, steps: Cell::new(0) }
    }

    /// Returns the layout of a structure of the file; one without `repr` is laid out as `repr(C)`.
    pub fn structure(&self, index: usize) -> Result<RustType, UnknownLayout> {
        self.steps.set(0);
        self.structure_at(index, 0)
    }

    /// Counts a step; an error past the limits of nesting or time.
    fn step(&self, depth: u32) -> Result<(), UnknownLayout> {
        self.steps.set(self.steps.get() + 1);
        match depth > DEEPEST || self.steps.get() > MAX_STEPS {
            true => Err(UnknownLayout("its type nests too deeply".to_string())),
            false => Ok(()),
        }
    }

    fn structure_at(&self, index: usize, depth: u32) -> Result<RustType, UnknownLayout> {
        let structure = &self.declarations.structures[index];
        if structure.generic {
            return Err(UnknownLayout(format!("`{}` is generic", structure.name)));
        }
        if let Some(cause) = self.writer.refuses(structure) {
            return Err(UnknownLayout(cause));
        }
        let least_align = self.writer.least_align(structure);
        let (mut end, mut align) = (0u64, least_align);
        let mut fields = Vec::with_capacity(structure.fields.len());
        for field in &structure.fields {
            if field.conditional {
                return Err(UnknownLayout(format!(
                    "field `{}` exists only under a `cfg`",
                    field.name
                )));
            }
            let ty = self.of(&field.ty, depth + 1).map_err(|UnknownLayout(cause)| {
                // The innermost field is named, not those around it.
                match cause.starts_with("field") {
                    true => UnknownLayout(cause),
                    false => UnknownLayout(format!("field `{}`: {cause}", field.name)),
                }
            })?;
            // A field is at the next multiple of its alignment.
            let own = self.writer.field_align(structure, field, &ty);
            let size = self.writer.field_size(field, &ty);
            let offset = end.checked_next_multiple_of(own).ok_or_else(|| too_large(structure))?;
            end = offset.checked_add(size).ok_or_else(|| too_large(structure))?;
            align = align.max(own);
            fields.push(LaidField { name: field.name.clone(), offset, align: own, size, ty });
        }
        let size = end.checked_next_multiple_of(align).ok_or_else(|| too_large(structure))?;
        let name = structure.name.clone();
        let laid = StructureLayout { name, fields, index, least_align, writer: self.writer };
        Ok(RustType { size, align, shape: Shape::Struct(Rc::new(laid)), composite: true })
    }

    fn of(&self, ty: &syn::Type, depth: u32) -> Result<RustType, UnknownLayout> {
        self.step(depth)?;
        match ty {
            syn::Type::Array(array) => {
                let element = self.of(&array.elem, depth + 1)?;
                let len = self.value(&array.len, depth + 1)?;
                self.writer.array(element, len)
            }
            // A runtime-sized array of encase, of at least one element.
            syn::Type::Slice(slice) if self.writer == MirrorWriter::Encase => {
                self.writer.array(self.of(&slice.elem, depth + 1)?, 1)
            }
            syn::Type::Reference(inner) if self.writer == MirrorWriter::Encase => {
                self.of(&inner.elem, depth + 1)
            }
            syn::Type::Paren(inner) => self.of(&inner.elem, depth + 1),
            syn::Type::Group(inner) => self.of(&inner.elem, depth + 1),
            syn::Type::Path(path) if path.qself.is_none() => self.named(&path.path, depth),
            _ => Err(UnknownLayout("the layout of its type is unknown".to_string())),
        }
    }

    fn named(&self, path: &syn::Path, depth: u32) -> Result<RustType, UnknownLayout> {
        let segments: Vec<String> = path.segments.iter().map(|s| s.ident.to_string()).collect();
        let last = path.segments.last().expect("a path has a segment");
        let local = match segments.as_slice() {
            [_] => true,
            [first, ..] => matches!(first.as_str(), "self" | "super" | "crate"),
            [] => false,
        };
        // A name that is imported is not the file's own.
        let imported = self.declarations.imports.contains_key(&segments[0]);
        if local && !imported {
            let name = &segments[segments.len() - 1];
            if let Some(alias) = self.declarations.aliases.get(name) {
                return self.of(alias, depth + 1);
            }
            let structures = &self.declarations.structures;
            if let Some(index) = structures.iter().position(|s| s.name == *name) {
                return self.structure_at(index, depth + 1);
            }
        }
        let arguments = self.arguments(&last.arguments, depth)?;
        let full = self.resolved(&segments);
        if self.writer == MirrorWriter::Encase {
            if let Some(wrapped) = library::wrapped(&full, &arguments) {
                return match wrapped {
                    Wrapped::Same(ty) => Ok(ty),
                    Wrapped::Elements(ty) => self.writer.array(ty, 1),
                };
            }
        }
        let ty = known::named(&full, &self.globs(), &arguments).ok_or_else(|| {
            UnknownLayout(format!("the layout of `{}` is not known", full.join("::")))
        })?;
        self.writer.known(&full, ty)
    }

    /// `<f32>`, `<f32, 3>`.
    fn arguments(
        &self,
        arguments: &syn::PathArguments,
        depth: u32,
    ) -> Result<Vec<TypeArgument>, UnknownLayout> {
        let syn::PathArguments::AngleBracketed(list) = arguments else { return Ok(Vec::new()) };
        list.args
            .iter()
            .filter(|argument| !matches!(argument, syn::GenericArgument::Lifetime(_)))
            .map(|argument| match argument {
                // A constant by name looks like a type.
                syn::GenericArgument::Type(ty) => match self.of(ty, depth + 1) {
                    Ok(ty) => Ok(TypeArgument::Type(ty)),
                    Err(unknown) => match ty {
                        syn::Type::Path(path) => self
                            .constant(&path.path, depth + 1)
                            .map(TypeArgument::Number)
                            .map_err(|_| unknown),
                        _ => Err(unknown),
                    },
                },
                syn::GenericArgument::Const(value) => {
                    self.value(value, depth + 1).map(TypeArgument::Number)
                }
                _ => Err(UnknownLayout("the layout of its type is unknown".to_string())),
            })
            .collect()
    }

    /// Returns a path with its first name replaced by its import.
    fn resolved(&self, segments: &[String]) -> Vec<String> {
        match self.declarations.imports.get(&segments[0]) {
            Some(full) => full.iter().chain(&segments[1..]).cloned().collect(),
            None => segments.to_vec(),
        }
    }

    /// Returns the glob imports: `glam::*`.
    fn globs(&self) -> Vec<&str> {
        let imports = self.declarations.imports.iter();
        let mut globs: Vec<&str> = imports
            .filter(|(name, _)| name.starts_with('*'))
            .filter_map(|(_, path)| path.first().map(String::as_str))
            .collect();
        globs.sort_unstable();
        globs
    }

    /// Evaluates an array's length.
    fn value(&self, value: &Expr, depth: u32) -> Result<u64, UnknownLayout> {
        let unknown = || UnknownLayout("its array's length is not known".to_string());
        self.step(depth)?;
        match value {
            Expr::Lit(literal) => match &literal.lit {
                Lit::Int(number) => number.base10_parse().map_err(|_| unknown()),
                _ => Err(unknown()),
            },
            Expr::Paren(inner) => self.value(&inner.expr, depth + 1),
            Expr::Group(inner) => self.value(&inner.expr, depth + 1),
            Expr::Cast(cast) => self.value(&cast.expr, depth + 1),
            Expr::Verbatim(block) => {
                let inner = syntax::inside_block(block).ok_or_else(unknown)?;
                self.value(&inner, depth + 1)
            }
            Expr::Path(path) => self.constant(&path.path, depth),
            Expr::Binary(binary) => {
                let left = self.value(&binary.left, depth + 1)?;
                let right = self.value(&binary.right, depth + 1)?;
                operate(&binary.op, left, right).ok_or_else(unknown)
            }
            Expr::Call(call) => self.size_of(call, depth).ok_or_else(unknown),
            _ => Err(unknown()),
        }
    }

    fn constant(&self, path: &syn::Path, depth: u32) -> Result<u64, UnknownLayout> {
        let name = path.segments.last().map(|s| s.ident.to_string()).unwrap_or_default();
        let unknown = || UnknownLayout(format!("constant `{name}` is not known"));
        let tokens = self.declarations.constants.get(&name).ok_or_else(unknown)?;
        let value = syntax::expression(tokens.clone()).map_err(|_| unknown())?;
        self.value(&value, depth + 1)
    }

    /// `size_of::<T>()`, under any path.
    fn size_of(&self, call: &syn::ExprCall, depth: u32) -> Option<u64> {
        let Expr::Path(function) = &*call.func else { return None };
        let last = function.path.segments.last()?;
        if last.ident != "size_of" || !call.args.is_empty() {
            return None;
        }
        match self.arguments(&last.arguments, depth + 1).ok()?.as_slice() {
            [TypeArgument::Type(ty)] => Some(ty.size),
            _ => None,
        }
    }
}

fn operate(op: &syn::BinOp, left: u64, right: u64) -> Option<u64> {
    let shift = u32::try_from(right).ok();
    match op {
        syn::BinOp::Add(_) => left.checked_add(right),
        syn::BinOp::Sub(_) => left.checked_sub(right),
        syn::BinOp::Mul(_) => left.checked_mul(right),
        syn::BinOp::Div(_) => left.checked_div(right),
        syn::BinOp::Rem(_) => left.checked_rem(right),
        syn::BinOp::Shl(_) => left.checked_shl(shift?),
        syn::BinOp::Shr(_) => left.checked_shr(shift?),
        syn::BinOp::BitAnd(_) => Some(left & right),
        syn::BinOp::BitOr(_) => Some(left | right),
        _ => None,
    }
}

fn too_large(structure: &Structure) -> UnknownLayout {
    UnknownLayout(format!("`{}` is too large", structure.name))
}
