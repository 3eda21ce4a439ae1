//! Layouts, findings and values as text: one file a format, each reading only the
//! [model](mod@crate::layout), or the values [decoded](crate::buffer::Decoded) by it.
//!
//! A document over many shaders is [`opening`], then each [`shader`] with
//! [`between`] between them, then [`closing`], so that no more than one shader
//! need be in memory; [`document`] is all of it for one.

pub mod columns;
pub mod csv;
pub mod diagnostics;
pub mod diff;
mod expand;
pub mod explain;
pub mod hex;
pub mod json;
mod listing;
mod markdown;
pub mod paint;
mod place;
mod table;
pub mod values;
pub mod words;

pub use crate::lock::LOCK_SCHEMA;
pub use expand::MOST_OFFSETS;
pub use paint::Paint;

use std::borrow::Cow;

use crate::ShaderLayout;
use crate::diagnostic::Diagnostic;
use crate::text::escape;

/// Name of the tool in its products, whichever of its crates writes them.
pub const NAME: &str = "landfall";

/// The tool in one sentence.
pub const DESCRIPTION: &str =
    "Every byte you upload lands where the shader reads it: byte layouts of GLSL and WGSL blocks";

/// Version of the JSON output; a change that could break a reader raises it.
pub const SCHEMA_VERSION: u32 = 1;

/// JSON Schema (draft 2020-12) of the JSON output.
pub const LAYOUT_SCHEMA: &str = include_str!("../schema/layout.json");

/// JSON Schema (draft 2020-12) of a finding in JSON.
pub const DIAGNOSTIC_SCHEMA: &str = include_str!("../schema/diagnostic.json");

/// JSON Schema (draft 2020-12) of the JSON output of `explain`.
pub const EXPLAIN_SCHEMA: &str = include_str!("../schema/explain.json");

/// A form layouts are written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Columns for the eye.
    Table,
    /// The structures in their own language, each member with its place.
    Listing,
    /// JSON as [`LAYOUT_SCHEMA`] describes it.
    Json,
    /// One row a leaf, RFC 4180.
    Csv,
    /// Markdown tables.
    Markdown,
}

impl Format {
    /// The extension of files in this format.
    pub fn extension(self) -> &'static str {
        match self {
            Format::Table | Format::Listing => "txt",
            Format::Json => "json",
            Format::Csv => "csv",
            Format::Markdown => "md",
        }
    }
}

/// How layouts are written.
#[derive(Clone, Copy, Debug)]
pub struct EmitOptions {
    /// The form.
    pub format: Format,
    /// Every element of every array instead of one pattern; at most [`MOST_OFFSETS`] a block.
    pub expand: bool,
    /// Colours, where the form has any.
    pub paint: Paint,
}

impl EmitOptions {
    /// That format, patterns, no colours.
    pub fn new(format: Format) -> EmitOptions {
        EmitOptions { format, expand: false, paint: Paint::Plain }
    }
}

/// What stands before the first shader.
pub fn opening(options: &EmitOptions) -> String {
    match options.format {
        Format::Table | Format::Listing | Format::Markdown => String::new(),
        Format::Json => json::opening(),
        Format::Csv => csv::HEADER.to_string(),
    }
}

/// What stands between two shaders.
pub fn between(options: &EmitOptions) -> &'static str {
    match options.format {
        Format::Table | Format::Listing | Format::Markdown => "\n",
        Format::Json => ",\n",
        Format::Csv => "",
    }
}

/// What stands after the last shader of `shaders`.
pub fn closing(options: &EmitOptions, shaders: usize) -> &'static str {
    match options.format {
        Format::Table | Format::Listing | Format::Markdown | Format::Csv => "",
        Format::Json if shaders == 0 => "]}\n",
        Format::Json => "\n]}\n",
    }
}

/// The layouts of one shader.
pub fn shader(shader: &ShaderLayout, options: &EmitOptions) -> String {
    let text = match options.format {
        Format::Table => table::shader(shader, options),
        Format::Listing => listing::shader(shader, options),
        Format::Json => return json::shader(shader, options),
        Format::Csv => csv::shader(shader, options),
        Format::Markdown => markdown::shader(shader, options),
    };
    shown(text, options.paint)
}

/// A text for people, without anything that a terminal or a log obeys but our own styles.
pub fn shown(text: String, paint: Paint) -> String {
    match escape::output(&text, paint.styles()) {
        Cow::Borrowed(_) => text,
        Cow::Owned(safe) => safe,
    }
}

/// A whole document about one shader.
pub fn document(layouts: &ShaderLayout, options: &EmitOptions) -> String {
    let mut text = opening(options);
    text.push_str(&shader(layouts, options));
    text.push_str(closing(options, 1));
    text
}

/// Whether a text looks like a [`document`] about a file of that name, so that nothing else is
/// lost when it is written anew.
pub fn is_document(text: &str, format: Format, name: &str) -> bool {
    let first = text.lines().next().unwrap_or_default();
    match format {
        Format::Json => crate::lock::is_lock(text),
        Format::Csv => first.starts_with(CSV_START),
        Format::Markdown => first.starts_with("# ") && first.contains(name),
        Format::Table | Format::Listing => first.contains(name),
    }
}

/// The first columns of a CSV document.
const CSV_START: &str = "shader,block,instance,";

/// What these options cannot be met for: blocks with more than [`MOST_OFFSETS`] elements to
/// expand. They are written as patterns.
pub fn refused(shader: &ShaderLayout, options: &EmitOptions) -> Vec<Diagnostic> {
    if options.expand { expand::refused(shader) } else { Vec::new() }
}
