//! Parses a Rust file's structures, constants, aliases and imports, and the comments that declare a
//! structure a mirror.
//!
//! Only these declarations are parsed; function bodies, macros and new syntax elsewhere are
//! skipped. Used by [`types`](super::types).

use std::str::FromStr;

use proc_macro2::{TokenStream, TokenTree};
use rustc_hash::FxHashMap;
use syn::spanned::Spanned;

use super::items::{bounded, ends_item, keyword};
use super::syntax::{self, Alias, Imports, parse, unraw};
use crate::settings::RustFile;
use landfall_layout::error::Error;
use landfall_layout::finding::Place;
use landfall_layout::source::{Files, Span};

pub(super) struct Declarations {
    pub structures: Vec<Structure>,
    /// Initialisers by name.
    pub constants: FxHashMap<String, TokenStream>,
    pub aliases: FxHashMap<String, syn::Type>,
    /// Imported names with their paths; a glob import has `*` and the path as its key.
    pub imports: FxHashMap<String, Vec<String>>,
    pub comments: Vec<Comment>,
}

pub(super) struct Structure {
    pub name: String,
    pub place: Place,
    /// The start of the declaration, including attributes, and the position of the keyword.
    from: usize,
    keyword: usize,
    pub repr: Repr,
    /// The last names of the derived traits: `ShaderType`.
    pub derives: Vec<String>,
    /// Whether it has parameters other than lifetimes.
    pub generic: bool,
    /// Whether its fields have no names.
    pub tuple: bool,
    pub fields: Vec<Field>,
}

/// The content of `#[repr(…)]`.
#[derive(Clone, Copy, Default)]
pub(super) struct Repr {
    pub c: bool,
    pub transparent: bool,
    pub align: Option<u64>,
    pub packed: Option<u64>,
}

pub(super) struct Field {
    /// The name, or the index in a tuple structure.
    pub name: String,
    pub place: Place,
    pub ty: syn::Type,
    /// The type in the text.
    pub written: String,
    /// Whether it depends on a `cfg`.
    pub conditional: bool,
    /// `#[shader(align(16), size(32))]`, which encase reads.
    pub align: Option<u64>,
    pub size: Option<u64>,
}

/// `// landfall: mirror(…)`.
pub(super) struct Comment {
    pub place: Place,
    /// Shader (empty for any) and block, for each in the list.
    pub blocks: Vec<(String, String)>,
    /// The structure directly below it.
    pub structure: Option<String>,
}

/// Reads the declarations of a file.
///
/// # Errors
/// The text is not valid Rust, with line and column.
pub(super) fn read(file: &RustFile) -> Result<Declarations, Error> {
    let text = file.text.strip_prefix('\u{feff}').unwrap_or(&file.text);
    let mut files = Files::default();
    files.add(&file.path, text.into());
    let mut reader = ItemReader {
        text,
        files,
        declarations: Declarations {
            structures: Vec::new(),
            constants: FxHashMap::default(),
            aliases: FxHashMap::default(),
            imports: FxHashMap::default(),
            comments: Vec::new(),
        },
        literals: Vec::new(),
    };
    let tokens = TokenStream::from_str(text).map_err(|cause| {
        reader.refused(cause.span(), "it is not valid Rust", &cause.to_string())
    })?;
    reader.items(tokens)?;
    // Modules were read last; searches need the structures in the order of the text.
    reader.declarations.structures.sort_by_key(|structure| structure.keyword);
    reader.literals.sort_by_key(|range| range.start);
    reader.comments();
    Ok(reader.declarations)
}

struct ItemReader<'t> {
    text: &'t str,
    files: Files,
    declarations: Declarations,
    /// The literals, in which comment delimiters are not comments.
    literals: Vec<std::ops::Range<usize>>,
}

impl ItemReader<'_> {
    fn place(&self, span: proc_macro2::Span) -> Place {
        let range = span.byte_range();
        Place::new(&self.files, Span { file: 0, start: range.start as u32, end: range.end as u32 })
    }

    fn refused(&self, span: proc_macro2::Span, what: &str, cause: &str) -> Error {
        let place = self.place(span);
        Error::new(
            &place.path,
            format!(
                "cannot be read: {what} at line {}, column {}: {cause}",
                place.line, place.column
            ),
        )
        .with_help("correct it, or leave it out of the mirrors that are checked")
    }

    /// The items of a file or module.
    fn items(&mut self, tokens: TokenStream) -> Result<(), Error> {
        // Modules inside, to be read without recursion.
        let mut waiting = vec![tokens];
        while let Some(tokens) = waiting.pop() {
            let mut item = Vec::new();
            for token in tokens {
                let ends = ends_item(&item, &token);
                item.push(token);
                if ends {
                    waiting.extend(self.item(std::mem::take(&mut item))?);
                }
            }
            waiting.extend(self.item(item)?);
        }
        Ok(())
    }

    /// One item; returns the inside of a module.
    fn item(&mut self, item: Vec<TokenTree>) -> Result<Option<TokenStream>, Error> {
        self.note_literals(&item);
        let Some(at) = keyword(&item) else { return Ok(None) };
        let TokenTree::Ident(word) = &item[at] else { return Ok(None) };
        match word.to_string().as_str() {
            "mod" => {
                return Ok(match item.last() {
                    Some(TokenTree::Group(inside)) => Some(inside.stream()),
                    Some(_) | None => None,
                });
            }
            "struct" => self.structure(item, at)?,
            "const" | "static" => self.constant(&item[at..]),
            // syn is recursive: what nests too deeply is left out.
            "type" if bounded(&item) => {
                if let Ok(alias) = parse::<Alias>(&item) {
                    if !alias.generic {
                        self.declarations.aliases.insert(alias.name.to_string(), alias.ty);
                    }
                }
            }
            "use" if bounded(&item) => {
                if let Ok(Imports(imports)) = parse(&item) {
                    self.declarations.imports.extend(imports);
                }
            }
            _ => {}
        }
        Ok(None)
    }

    fn structure(&mut self, item: Vec<TokenTree>, at: usize) -> Result<(), Error> {
        let from = item[0].span().byte_range().start;
        let keyword = item[at].span();
        // A structure that is left out may be the mirror.
        if !bounded(&item) {
            return Err(self.refused(
                keyword,
                "a structure nests too deeply",
                "landfall stops here",
            ));
        }
        let parsed = syntax::structure(&item)
            .map_err(|cause| self.refused(cause.span(), "invalid structure", &cause.to_string()))?;
        let syn::Data::Struct(data) = parsed.data else { return Ok(()) };
        let repr = repr(&parsed.attrs);
        let tuple = matches!(data.fields, syn::Fields::Unnamed(_));
        let fields = data.fields.into_iter().enumerate().map(|(index, field)| {
            let span = field.ident.as_ref().map_or_else(|| field.ty.span(), |name| name.span());
            let range = field.ty.span().byte_range();
            let (align, size) = shader_attributes(&field.attrs);
            Field {
                name: field.ident.as_ref().map_or_else(|| index.to_string(), unraw),
                place: self.place(span),
                written: self.text.get(range).unwrap_or("").to_string(),
                conditional: field.attrs.iter().any(|attr| attr.path().is_ident("cfg")),
                ty: field.ty,
                align,
                size,
            }
        });
        let structure = Structure {
            name: unraw(&parsed.ident),
            place: self.place(parsed.ident.span()),
            from,
            keyword: keyword.byte_range().start,
            repr,
            derives: derives(&parsed.attrs),
            generic: parsed.generics.type_params().next().is_some()
                || parsed.generics.const_params().next().is_some(),
            tuple,
            fields: fields.collect(),
        };
        self.declarations.structures.push(structure);
        Ok(())
    }

    /// Parses `const NAME: T = …;` outside `impl` blocks, not a `const fn`.
    fn constant(&mut self, item: &[TokenTree]) {
        let [_, TokenTree::Ident(name), TokenTree::Punct(colon), ..] = item else { return };
        let equals =
            item.iter().position(|t| matches!(t, TokenTree::Punct(p) if p.as_char() == '='));
        let Some(equals) = equals.filter(|_| colon.as_char() == ':') else { return };
        // What is between the `=` and the `;`.
        let value = &item[equals + 1..item.len().saturating_sub(1)];
        if bounded(value) {
            self.declarations.constants.insert(name.to_string(), value.iter().cloned().collect());
        }
    }

    fn note_literals(&mut self, tokens: &[TokenTree]) {
        // Literals matter only where one may contain such a comment.
        if !self.text.contains(MARK) {
            return;
        }
        let mut waiting: Vec<TokenTree> = tokens.to_vec();
        while let Some(token) = waiting.pop() {
            match token {
                TokenTree::Group(group) => waiting.extend(group.stream()),
                TokenTree::Literal(literal) => {
                    let range = literal.span().byte_range();
                    if self.text.get(range.clone()).is_some_and(|text| text.contains(MARK)) {
                        self.literals.push(range);
                    }
                }
                TokenTree::Ident(_) | TokenTree::Punct(_) => {}
            }
        }
    }

    fn comments(&mut self) {
        let text = self.text;
        for (at, _) in text.match_indices(MARK) {
            let line = text[..at].rfind('\n').map_or(0, |newline| newline + 1);
            let end = text[at..].find('\n').map_or(text.len(), |newline| at + newline);
            // Comments behind code are no mirrors.
            let own = text[line..at].trim();
            if own != "//" || self.in_literal(at) {
                continue;
            }
            let rest = text[at + MARK.len()..end].trim_start();
            let Some(list) = rest.strip_prefix('(').and_then(|rest| rest.split_once(')')) else {
                continue;
            };
            let start = line + text[line..at].len() - text[line..at].trim_start().len();
            let span = Span { file: 0, start: start as u32, end: end as u32 };
            let comment = Comment {
                place: Place::new(&self.files, span),
                blocks: list.0.split(',').map(shader_and_block).collect(),
                structure: self.below(end),
            };
            self.declarations.comments.push(comment);
        }
    }

    fn in_literal(&self, at: usize) -> bool {
        // Literals are in order, and do not overlap.
        let before = self.literals.partition_point(|range| range.start <= at);
        before.checked_sub(1).is_some_and(|last| self.literals[last].contains(&at))
    }

    /// Returns the structure below a comment that ends there, with only attributes and further
    /// comments between.
    fn below(&self, end: usize) -> Option<String> {
        let structures = &self.declarations.structures;
        let next = structures.get(structures.partition_point(|s| s.keyword < end))?;
        // Inside its attributes, or right before the first of them.
        let between = self.text.get(end..next.from.max(end))?;
        let blank = between.lines().all(|line| {
            let line = line.trim();
            line.is_empty() || line.starts_with("//")
        });
        blank.then(|| next.name.clone())
    }
}

const MARK: &str = "landfall: mirror";

/// `Block`, `shaders/x.frag: Block`.
fn shader_and_block(text: &str) -> (String, String) {
    match text.rsplit_once(':') {
        Some((shader, block)) => (shader.trim().to_string(), block.trim().to_string()),
        None => (String::new(), text.trim().to_string()),
    }
}

/// Returns the last names of the paths in `#[derive(…)]`.
fn derives(attributes: &[syn::Attribute]) -> Vec<String> {
    let mut found = Vec::new();
    for attribute in attributes.iter().filter(|attribute| attribute.path().is_ident("derive")) {
        // Syntax errors here are left to rustc.
        let _ = attribute.parse_nested_meta(|meta| {
            found.extend(meta.path.segments.last().map(|last| last.ident.to_string()));
            Ok(())
        });
    }
    found
}

/// Returns the numbers of `#[shader(align(16), size(32))]`, or of `#[align(16)]` and `#[size(32)]`,
/// as encase before 0.4 has them.
fn shader_attributes(attributes: &[syn::Attribute]) -> (Option<u64>, Option<u64>) {
    let (mut align, mut size) = (None, None);
    for attribute in attributes {
        let written = |name: &str| match attribute.path().is_ident(name) {
            true => attribute.parse_args::<syn::LitInt>().ok()?.base10_parse::<u64>().ok(),
            false => None,
        };
        align = align.or_else(|| written("align"));
        size = size.or_else(|| written("size"));
        if attribute.path().is_ident("shader") {
            let _ = attribute.parse_nested_meta(|meta| {
                let inside;
                syn::parenthesized!(inside in meta.input);
                // `size(runtime)` is known by its type.
                let Ok(number) = inside.parse::<syn::LitInt>() else {
                    inside.parse::<syn::Ident>()?;
                    return Ok(());
                };
                let number = number.base10_parse()?;
                if meta.path.is_ident("align") {
                    align = Some(number);
                } else if meta.path.is_ident("size") {
                    size = Some(number);
                }
                Ok(())
            });
        }
    }
    // encase takes powers of two.
    (align.filter(|align| align.is_power_of_two()), size)
}

fn repr(attributes: &[syn::Attribute]) -> Repr {
    let mut repr = Repr::default();
    for attribute in attributes.iter().filter(|attribute| attribute.path().is_ident("repr")) {
        // Syntax errors here are left to rustc.
        let _ = attribute.parse_nested_meta(|meta| {
            let number = |meta: &syn::meta::ParseNestedMeta<'_>| -> syn::Result<u64> {
                let inside;
                syn::parenthesized!(inside in meta.input);
                inside.parse::<syn::LitInt>()?.base10_parse()
            };
            // rustc accepts powers of two up to 2^29.
            let fits = |n: &u64| n.is_power_of_two() && *n <= 1 << 29;
            if meta.path.is_ident("C") {
                repr.c = true;
            } else if meta.path.is_ident("transparent") {
                repr.transparent = true;
            } else if meta.path.is_ident("align") {
                repr.align = Some(number(&meta)?).filter(fits).max(repr.align);
            } else if meta.path.is_ident("packed") {
                let written = meta.input.peek(syn::token::Paren);
                repr.packed = Some(if written { number(&meta)? } else { 1 }).filter(fits);
            }
            Ok(())
        });
    }
    repr
}
