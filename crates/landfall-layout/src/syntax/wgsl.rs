//! The WGSL parser: from text to [`Shape`], by the module-scope declarations that blocks depend on.
//!
//! [`outline`] finds the declarations in one pass that skips function bodies; then every buffer
//! variable resolves its type, and the type its structures and constants. Declarations that no
//! block depends on are not parsed.
//!
//! The comment above a parser function is the production that it reads, by its name in the grammar
//! of WGSL: terminals are quoted, `?` is optional, `*` and `+` repeat. There is no syntax tree:
//! types are resolved, and expressions evaluated, as they are parsed.

mod attribute_names;
mod attributes;
mod comments;
mod constants;
mod expressions;
#[cfg(feature = "naga")]
mod fallback;
/// Without naga, expressions that landfall cannot evaluate have no value.
#[cfg(not(feature = "naga"))]
mod fallback {
    pub(super) fn positive(
        _: &super::outline::Outline<'_>,
        _: &str,
        _: super::Span,
    ) -> Option<u32> {
        None
    }
}
mod handles;
pub(super) mod interface;
mod lengths;
mod lexer;
pub(crate) mod link;
mod name_errors;
mod numbers;
mod outline;
mod predeclared;
mod reader;
mod report;
mod reserved;
mod siblings;
mod structs;
mod types;
mod uses;
mod variables;

use crate::diagnostic::Code;
use outline::Class;
use reader::ModuleReader;
use report::Reports;
use types::Meaning;

use super::{BodyErrors, Parsed};
use crate::Diagnostic;
use crate::shape::{Block, LengthConstant, Rules, Shape, Type};
use crate::source::{Files, ReadOptions, Source, Span};

pub(crate) fn tokens(text: &str) -> Vec<&str> {
    let mut lexer = lexer::WgslLexer::new(text, 0);
    std::iter::from_fn(|| {
        let token = lexer.next();
        (token.kind != lexer::Kind::End).then(|| lexer.text_of(token))
    })
    .collect()
}

// Stages: imports and conditions are resolved to one text; the outline finds its declarations;
// buffer variables are read, with the types and constants that they need; at last the structures
// that none needs, for their syntax errors.
pub(crate) fn read(source: &Source, options: &ReadOptions) -> Parsed {
    let (source, warnings) = match link::linked(source, options) {
        Ok(Some((linked, warnings))) => (&linked.clone(), warnings),
        Ok(None) => (source, Vec::new()),
        Err(failed) => {
            return Parsed {
                files: failed.files,
                diagnostics: failed.diagnostics,
                ..Parsed::default()
            };
        }
    };
    let files = Files::from_source(source);
    if let Some(foreign) = source.foreign {
        let span = Span { file: 0, start: foreign.first, end: foreign.first };
        let message = "WGSL must be UTF-8, which this byte is not";
        let found = Diagnostic::error(Code::NotUtf8, span, message);
        let diagnostics = vec![found.with_help("save the file as UTF-8")];
        return Parsed { files, diagnostics, ..Parsed::default() };
    }
    let text: &str = &source.text;
    let mut reports = Reports::default();
    warnings.into_iter().for_each(|warning| reports.push(warning));
    let outline = outline::read(text, &mut reports);
    if !outline.incomplete {
        attribute_names::check(text, &outline, &mut reports);
    }
    // A text with lines of another tool is not the one that is compiled, so nothing in it is laid
    // out.
    if outline.incomplete || reports.saw_preprocessor {
        return Parsed { files, diagnostics: reports.finish(), ..Parsed::default() };
    }
    let mut reader = ModuleReader::new(text, &outline, options, reports);
    if let Some(name) = &options.structure {
        let linked = source.linked.as_ref().and_then(|linked| linked.structure.as_deref());
        let blocks = structure(&mut reader, linked.unwrap_or(name)).into_iter().collect();
        let constants = LengthConstant::distinct(reader.length_constants.drain(..));
        let shape = Shape { blocks, constants, ..Shape::default() };
        return Parsed { shape, files, diagnostics: reader.reports.finish(), ..Parsed::default() };
    }
    let mut blocks = Vec::new();
    for item in outline.items.iter().filter(|item| item.class == Class::Var) {
        // Otherwise the variable is not a buffer, or an error was reported.
        if let Ok(Some(block)) = variables::block(&mut reader, item) {
            blocks.push(block);
        }
    }
    let overrides = std::mem::take(&mut reader.overrides);
    let constants = LengthConstant::distinct(reader.length_constants.drain(..));
    // Only syntax errors are reported of structures that no block uses.
    let known = reader.reports.len();
    for (index, item) in outline.items.iter().enumerate() {
        if item.class == Class::Struct {
            let _ = types::check(&mut reader, index);
        }
    }
    reader.reports.keep_syntax_errors(known);
    let shape = Shape { blocks, overrides, constants, ..Shape::default() };
    let mut diagnostics = reader.reports.finish();
    siblings::name_preludes(&mut diagnostics, source, options);
    let standard_uniforms = outline.standard_uniforms;
    let bodies = outline.bodies;
    Parsed { shape, files, diagnostics, bodies, standard_uniforms, ..Parsed::default() }
}

/// Returns a structure, by its name or that of an alias.
fn structure(reader: &mut ModuleReader<'_>, name: &str) -> Option<Block> {
    let outline = reader.outline;
    let is_type = |class| matches!(class, Class::Struct | Class::Alias);
    let index = outline.names.get(name).copied();
    let Some(index) = index.filter(|&index| is_type(outline.items[index].class)) else {
        let types = outline.items.iter().filter(|item| is_type(item.class));
        reader.reports.push(super::no_structure(name, types.map(|item| item.name)));
        return None;
    };
    match types::check(reader, index)?.meaning {
        Meaning::Data(Type::Struct(structure)) => {
            Some(Block::of_structure(&structure, Rules::Wgsl))
        }
        Meaning::Data(_) | Meaning::Opaque | Meaning::Bindings(..) => {
            let message = format!("`{name}` is no structure");
            let at = outline.items[index].name_span;
            reader.reports.push(Diagnostic::error(Code::UnknownBlock, at, message));
            None
        }
    }
}

/// Returns an error for each name that is reserved or, in a module with an entry point, not declared.
pub(crate) fn body_errors(source: &Source) -> BodyErrors {
    let outline = outline::read(&source.text, &mut Reports::default());
    let has_entry_point = attribute_names::has_entry_point(&source.text, &outline);
    let mut errors = Vec::new();
    if !outline.incomplete {
        errors.extend(reserved::errors(&source.text, &outline));
        if has_entry_point {
            // A name that is refused where it is declared is not missing where it is used.
            errors.extend(name_errors::undeclared(&source.text, &outline));
        }
    }
    BodyErrors { errors, has_entry_point }
}

/// Returns the functions of a text, attributes included.
#[cfg(feature = "naga")]
pub(crate) fn functions(text: &str) -> Vec<Span> {
    let outline = outline::read(text, &mut Reports::default());
    let functions = outline.items.iter().filter(|item| item.class == Class::Fn);
    functions.map(|item| Span { file: 0, start: item.start, end: item.end }).collect()
}
