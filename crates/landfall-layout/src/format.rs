//! Text output of layouts, findings and values: one module per format, each reading only the
//! [model](mod@crate::layout) or [decoded](crate::buffer::Decoded) values.
//!
//! A document of several shaders is [`opening`], each [`shader`] separated by [`between`], then
//! [`closing`], so that only one shader need be in memory; [`document`] is a whole document of
//! one shader.

#[doc(hidden)]
pub mod columns;
pub mod csv;
pub mod diagnostics;
pub mod diff;
mod expand;
pub mod explain;
#[doc(hidden)]
pub mod hex;
pub mod json;
mod listing;
mod markdown;
#[doc(hidden)]
pub mod paint;
#[doc(hidden)]
pub mod phrases;
mod place;
mod table;
#[doc(hidden)]
pub mod values;

pub use crate::lock::LOCK_SCHEMA;
pub use expand::MAX_OFFSETS;
pub use paint::Paint;

use std::borrow::Cow;

use crate::ShaderLayout;
use crate::diagnostic::Diagnostic;
use crate::text::escape;

/// The tool's name in its output, whichever crate writes it.
pub const NAME: &str = "landfall";

/// The tool in one sentence.
pub const DESCRIPTION: &str =
    "Every byte you upload lands where the shader reads it: byte layouts of GLSL and WGSL blocks";

/// The version of the JSON output, raised by every incompatible change.
pub const SCHEMA_VERSION: u32 = 1;

/// The JSON Schema (draft 2020-12) of the JSON output.
pub const LAYOUT_SCHEMA: &str = include_str!("../schema/layout.json");

/// The JSON Schema (draft 2020-12) of a finding in JSON.
pub const DIAGNOSTIC_SCHEMA: &str = include_str!("../schema/diagnostic.json");

/// The JSON Schema (draft 2020-12) of the JSON output of `explain`.
pub const EXPLAIN_SCHEMA: &str = include_str!("../schema/explain.json");

/// An output format of layouts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Format {
    /// Aligned columns.
    Table,
    /// The structures in the shader's language, each member with its offset.
    Listing,
    /// JSON that follows [`LAYOUT_SCHEMA`].
    Json,
    /// CSV (RFC 4180), one row per leaf.
    Csv,
    /// Markdown tables.
    Markdown,
}

impl Format {
    /// The file extension of this format.
    pub fn extension(self) -> &'static str {
        match self {
            Format::Table | Format::Listing => "txt",
            Format::Json => "json",
            Format::Csv => "csv",
            Format::Markdown => "md",
        }
    }

    /// Whether programs read it: shaders without blocks are in it, too.
    pub fn is_data(self) -> bool {
        match self {
            Format::Json | Format::Csv => true,
            Format::Table | Format::Listing | Format::Markdown => false,
        }
    }
}

/// Options of the layout output.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct EmitOptions {
    /// The format.
    pub format: Format,
    /// Whether to write every array element instead of one pattern; at most [`MAX_OFFSETS`] per
    /// block.
    pub expand: bool,
    /// Colours, in formats that have any.
    pub paint: Paint,
}

impl EmitOptions {
    /// Options for `format`, with patterns and without colours.
    pub fn new(format: Format) -> EmitOptions {
        EmitOptions { format, expand: false, paint: Paint::Plain }
    }
}

/// The text before the first shader.
pub fn opening(options: &EmitOptions) -> String {
    match options.format {
        Format::Table | Format::Listing | Format::Markdown => String::new(),
        Format::Json => json::opening(),
        Format::Csv => csv::HEADER.to_string(),
    }
}

/// The text between two shaders.
pub fn between(options: &EmitOptions) -> &'static str {
    match options.format {
        Format::Table | Format::Listing | Format::Markdown => "\n",
        Format::Json => ",\n",
        Format::Csv => "",
    }
}

/// The text after the last of `shaders` shaders.
pub fn closing(options: &EmitOptions, shaders: usize) -> &'static str {
    match options.format {
        Format::Table | Format::Listing | Format::Markdown | Format::Csv => "",
        // A list of no shaders is closed in its own line.
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
    escape_controls(text, options.paint)
}

/// Escapes control sequences in human-readable text, except landfall's own styles.
pub fn escape_controls(text: String, paint: Paint) -> String {
    match escape::output(&text, paint.styles()) {
        // Most texts have nothing to escape, and are not copied.
        Cow::Borrowed(_) => text,
        Cow::Owned(safe) => safe,
    }
}

/// The layouts of several shaders, or of a shader in the parts of [`ShaderLayout::divided`].
pub fn shaders(parts: &[ShaderLayout], options: &EmitOptions) -> String {
    let texts: Vec<String> = parts.iter().map(|part| shader(part, options)).collect();
    texts.join(between(options))
}

/// A whole document of one shader.
pub fn document(layouts: &ShaderLayout, options: &EmitOptions) -> String {
    documents(std::slice::from_ref(layouts), options)
}

/// A whole document of [`shaders`].
pub fn documents(parts: &[ShaderLayout], options: &EmitOptions) -> String {
    let mut text = opening(options);
    text.push_str(&shaders(parts, options));
    text.push_str(closing(options, parts.len()));
    text
}

/// Whether `text` looks like a [`document`] of the file `name`, and so may be overwritten.
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

/// Errors for blocks with more than [`MAX_OFFSETS`] elements to expand, which are written as
/// patterns.
pub fn refused(shader: &ShaderLayout, options: &EmitOptions) -> Vec<Diagnostic> {
    if options.expand { expand::refused(shader) } else { Vec::new() }
}
