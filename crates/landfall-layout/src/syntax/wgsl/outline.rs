//! The outline of a WGSL text: the names declared at module scope, found in one pass.
//!
//! Declarations are parsed later, when a block depends on them; errors in others are not reported.

use rustc_hash::FxHashMap;

use super::comments;
use super::lexer::{Kind, WgslLexer, WgslToken};
use super::report::{self, Reports};
use crate::other_language;
use crate::source::Span;
use crate::text::named::named;

named! {
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub(super) enum Class {
        Struct = "a struct",
        Alias = "an alias",
        Const = "a constant",
        Override = "an override",
        Var = "a variable",
        Fn = "a function",
    }
}

#[derive(Clone, Debug)]
pub(super) struct OutlineItem<'a> {
    pub(super) class: Class,
    pub(super) name: &'a str,
    pub(super) name_span: Span,
    /// The first byte, attributes included.
    pub(super) start: u32,
    /// The byte after the name.
    pub(super) rest: u32,
    /// One past the last byte.
    pub(super) end: u32,
    /// The address space of a `var<space>`, with its span.
    pub(super) space: Option<(&'a str, Span)>,
    /// The comments that belong to a `var`.
    pub(super) comment: Vec<Span>,
}

#[derive(Debug, Default)]
pub(super) struct Outline<'a> {
    pub(super) items: Vec<OutlineItem<'a>>,
    pub(super) names: FxHashMap<&'a str, usize>,
    /// Function bodies, without their braces.
    pub(super) bodies: Vec<Span>,
    /// Whether the text has `enable f16;`.
    pub(super) f16: bool,
    /// Whether the text has `requires uniform_buffer_standard_layout;`.
    pub(super) standard_uniforms: bool,
    /// Whether the text is a template that another tool must complete, so that results are
    /// unreliable.
    pub(super) incomplete: bool,
    /// Attributes before what can have none: from the first `@` to the end of the declaration, and
    /// what it is.
    pub(super) without_attributes: Vec<(u32, u32, &'static str)>,
    /// The starts of directives that stand after a declaration.
    pub(super) late_directives: Vec<u32>,
    /// Whether a declaration that is not in `items` was read: an assertion or an empty one.
    declared_other: bool,
}

const DECLARING: [&str; 7] = ["struct", "fn", "var", "const", "override", "alias", "const_assert"];

// translation_unit: global_directive* ( global_decl | global_assert | `;` )*
// Only where each declaration begins and ends is read here. An error skips to the next declaration,
// and the rest is read as if it had not been there.
pub(super) fn read<'a>(text: &'a str, reports: &mut Reports) -> Outline<'a> {
    let mut outline = Outline::default();
    outline.names.reserve(8 + text.len() / 256);
    let mut lexer = WgslLexer::new(text, 0);
    let mut last_end = 0;
    loop {
        lexer.comments.clear();
        let first = lexer.peek();
        let (trailing, before) = comments::split(text, &lexer.comments, last_end, first);
        if let Some(item) = outline.items.last_mut().filter(|item| item.class == Class::Var) {
            item.comment.extend(comments::spans(trailing));
        }
        let before = before.to_vec();
        if first.kind == Kind::End {
            break;
        }
        let declared = declaration(&mut lexer, &mut outline, reports, &before);
        match declared {
            Ok(end) => last_end = end,
            Err(report::Refused) if reports.saw_preprocessor => {
                outline.incomplete = true;
                return outline;
            }
            Err(report::Refused) => {
                recover(&mut lexer);
                last_end = lexer.peek().start;
            }
        }
    }
    if let Some(start) = lexer.unclosed_comment {
        reports.push(report::unclosed_comment(start));
    }
    outline
}

/// The language of a declaration that begins with this word, if it is not WGSL.
fn other_language(lexer: &WgslLexer<'_>, first: &str) -> Option<&'static str> {
    let next = lexer.text_of(lexer.clone().next());
    other_language::of_words_in_wgsl(first, next)
}

/// What begins with a token, if no attribute may stand before it.
fn without_attributes(lexer: &WgslLexer<'_>, first: WgslToken) -> Option<&'static str> {
    match (first.kind, lexer.text_of(first)) {
        (Kind::Word, "enable" | "requires" | "diagnostic") => Some("a directive"),
        (Kind::Word, "const_assert") => Some("an assertion"),
        (Kind::Sign(b';'), _) => Some("an empty declaration"),
        _ => None,
    }
}

/// Reads one declaration; returns its end.
// global_decl: attribute* function_decl | attribute* global_variable_decl `;`
//     | global_value_decl `;` | type_alias_decl `;` | struct_decl
// global_directive: diagnostic_directive | enable_directive | requires_directive
// After attributes the first word decides. What follows the name is not parsed but skipped.
fn declaration<'a>(
    lexer: &mut WgslLexer<'a>,
    outline: &mut Outline<'a>,
    reports: &mut Reports,
    before: &[(u32, u32)],
) -> Result<u32, report::Refused> {
    let start = lexer.peek().start;
    while lexer.take(b'@') {
        lexer.next();
        if lexer.take(b'(') {
            reports.checked(report::skip_past(lexer, b'(', b')'))?;
        }
    }
    let token = lexer.next();
    if let Some(what) = without_attributes(lexer, token).filter(|_| token.start != start) {
        outline.without_attributes.push((start, token.start, what));
    }
    let class = match (token.kind, lexer.text_of(token)) {
        (Kind::Sign(b';'), _) => {
            outline.declared_other = true;
            return Ok(token.end);
        }
        (Kind::Sign(b'#'), _) => return Err(reports.refuse(report::preprocessor(lexer, token))),
        (Kind::Sign(b'['), _) if lexer.peek().is(b'[') => {
            return Err(reports.refuse(report::bracket_attribute(token)));
        }
        (Kind::Word, "enable" | "requires" | "diagnostic") => {
            return directive(lexer, outline, reports, token);
        }
        (Kind::Word, "const_assert") => {
            outline.declared_other = true;
            return skip_to_semicolon(lexer, reports);
        }
        // Imports at the beginning were taken out by `link`; this one stands after a declaration.
        (Kind::Word, "import") => return Err(reports.refuse(report::preprocessor(lexer, token))),
        (Kind::Word, "struct") => Class::Struct,
        (Kind::Word, "alias") => Class::Alias,
        (Kind::Word, "const") => Class::Const,
        (Kind::Word, "override") => Class::Override,
        (Kind::Word, "var") => Class::Var,
        (Kind::Word, "fn") => Class::Fn,
        (Kind::Word, "let") => return Err(reports.refuse(report::module_let(token))),
        (Kind::Word, first) if other_language(lexer, first).is_some() => {
            let language = other_language(lexer, first).unwrap_or_default();
            return Err(reports.refuse(report::other_language(lexer, token, language)));
        }
        _ => {
            reports.push(report::unexpected(lexer, token, "a declaration"));
            if token.is(b'{') {
                lexer.skip_body();
            }
            return Err(report::Refused);
        }
    };
    let mut space = None;
    // variable_decl: `var` template_list? optionally_typed_ident
    if class == Class::Var && lexer.take(b'<') {
        let word = lexer.next();
        space = Some((lexer.text_of(word), report::span(word)));
        while !lexer.take(b'>') {
            let token = lexer.next();
            if !matches!(token.kind, Kind::Word | Kind::Sign(b',')) {
                return Err(reports.refuse(report::unexpected(lexer, token, "`>`")));
            }
        }
    }
    let name = reports.checked(report::word(lexer, "a name"))?;
    let end = match class {
        Class::Struct => skip_struct(lexer, reports, name)?,
        Class::Fn => skip_function(lexer, outline, reports, name)?,
        Class::Alias | Class::Const | Class::Override | Class::Var => {
            skip_to_semicolon(lexer, reports)?
        }
    };
    let item = OutlineItem {
        class,
        name: lexer.text_of(name),
        name_span: report::span(name),
        start,
        rest: name.end,
        end,
        space,
        comment: match class {
            Class::Var => comments::spans(before).collect(),
            Class::Struct | Class::Alias | Class::Const | Class::Override | Class::Fn => Vec::new(),
        },
    };
    // The first declaration keeps the name; the second is an error, but is read for its own.
    if let Some(&first) = outline.names.get(item.name) {
        reports.push(report::duplicate(item.name, item.name_span, outline.items[first].name_span));
    } else {
        outline.names.insert(item.name, outline.items.len());
    }
    outline.items.push(item);
    Ok(end)
}

/// Reads from after `enable`, `requires` or `diagnostic`, which is `first`, past the `;`.
// enable_directive: `enable` enable_extension_list `;`
// requires_directive: `requires` software_extension_list `;`
// diagnostic_directive: `diagnostic` diagnostic_control `;`
fn directive<'a>(
    lexer: &mut WgslLexer<'a>,
    outline: &mut Outline<'a>,
    reports: &mut Reports,
    first: WgslToken,
) -> Result<u32, report::Refused> {
    if outline.declared_other || !outline.items.is_empty() {
        outline.late_directives.push(first.start);
    }
    let mut words = lexer.clone();
    let end = skip_to_semicolon(lexer, reports)?;
    loop {
        let word = words.next();
        match (word.kind, lexer.text_of(first), words.text_of(word)) {
            (Kind::End | Kind::Sign(b';'), ..) => return Ok(end),
            (Kind::Word, "enable", "f16") => outline.f16 = true,
            (Kind::Word, "requires", feature) => {
                outline.standard_uniforms |= feature == "uniform_buffer_standard_layout";
                if !report::LANGUAGE_FEATURES.contains(&feature) {
                    reports.push(report::unknown_feature(feature, word));
                }
            }
            _ => {}
        }
    }
}

/// Skips from a struct's name past its `}`.
// struct_decl: `struct` ident struct_body_decl
// A `{` before the `}` means that the struct is not closed: members have no braces.
fn skip_struct(
    lexer: &mut WgslLexer<'_>,
    reports: &mut Reports,
    name: WgslToken,
) -> Result<u32, report::Refused> {
    let open = lexer.next();
    if !open.is(b'{') {
        return Err(reports.refuse(report::unexpected(lexer, open, "`{`")));
    }
    let close = lexer.scan_to(*b"{}#}");
    match close.kind {
        Kind::Sign(b'}') => Ok(close.end),
        Kind::Sign(b'#') => Err(reports.refuse(report::preprocessor(lexer, close))),
        Kind::Word | Kind::Number | Kind::Sign(_) | Kind::End => {
            // Continue at the first word that begins a declaration.
            lexer.jump(open.end);
            let inside = lexer.text_of(name);
            let found = report::unclosed_brace(inside, report::span(open));
            let is_template = lexer.text()[close.start as usize..].starts_with("{{");
            Err(reports.refuse(match is_template {
                true => found.with_note("`{{` is a template's: fill it in first"),
                false => found,
            }))
        }
    }
}

/// Skips from a function's name past its body.
// function_decl: attribute* function_header compound_statement
// The next `{` begins the body, since parameters and results have no braces.
fn skip_function(
    lexer: &mut WgslLexer<'_>,
    outline: &mut Outline<'_>,
    reports: &mut Reports,
    name: WgslToken,
) -> Result<u32, report::Refused> {
    let open = lexer.scan_to(*b"{;}#");
    if !open.is(b'{') {
        return Err(reports.refuse(report::unexpected(lexer, open, "`{`")));
    }
    match lexer.skip_body() {
        Some(close) => {
            outline.bodies.push(Span { file: 0, start: open.end, end: close });
            Ok(close + 1)
        }
        // The unclosed comment is reported instead.
        None if lexer.unclosed_comment.is_some() => Err(report::Refused),
        None => {
            Err(reports.refuse(report::unclosed_brace(lexer.text_of(name), report::span(open))))
        }
    }
}

// A word that begins a declaration ends the search: a `;` is missing, and without this the next
// declaration would be lost with it.
fn skip_to_semicolon(
    lexer: &mut WgslLexer<'_>,
    reports: &mut Reports,
) -> Result<u32, report::Refused> {
    loop {
        let token = lexer.peek();
        let declares = token.kind == Kind::Word && DECLARING.contains(&lexer.text_of(token));
        if declares || matches!(token.kind, Kind::End | Kind::Sign(b'{' | b'}' | b'@' | b'#')) {
            return Err(reports.refuse(report::unexpected(lexer, token, "`;`")));
        }
        let token = lexer.next();
        if token.is(b';') {
            return Ok(token.end);
        }
    }
}

/// Recovers from an error: skips past the next `;`, or to the next word or `@` that begins a
/// declaration.
fn recover(lexer: &mut WgslLexer<'_>) {
    loop {
        let token = lexer.peek();
        match token.kind {
            Kind::End => return,
            Kind::Word if DECLARING.contains(&lexer.text_of(token)) => return,
            Kind::Sign(b'@') if starts_line(lexer.text(), token) => return,
            Kind::Word | Kind::Number | Kind::Sign(_) => {}
        }
        let token = lexer.next();
        match token.kind {
            Kind::Sign(b';') => return,
            Kind::Sign(b'{') => drop(lexer.skip_body()),
            Kind::Word | Kind::Number | Kind::Sign(_) | Kind::End => {}
        }
    }
}

/// Whether a token starts its line: attributes of members are indented, those of declarations are
/// not.
fn starts_line(text: &str, token: WgslToken) -> bool {
    let start = token.start as usize;
    start == 0 || matches!(text.as_bytes()[start - 1], b'\n' | b'\r')
}
