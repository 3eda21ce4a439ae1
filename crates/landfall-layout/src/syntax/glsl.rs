//! The GLSL parser: desktop 1.10 to 4.60, ES 1.00 to 3.20, and Vulkan GLSL.
//!
//! `lexer` tokenises a file, `preprocess` (with `directive`, `include`, `macros`) produces one
//! token stream per shader, `parser` builds a syntax tree (`ast`) from it, and `declarations` (with
//! `members`, `blocks`, `constants`) extracts the blocks and types with a layout. `evaluate`
//! computes constant expressions. Function bodies are skipped, or parsed on demand.

pub mod ast;
mod blocks;
mod conditional_blocks;
mod constants;
mod declarations;
mod dialect;
mod directive;
pub mod evaluate;
mod functions;
mod globals;
mod handles;
mod implicit_size;
mod include;
pub(super) mod interface;
mod later_keywords;
mod layout_ids;
mod legality;
mod length_constants;
pub mod lexer;
mod line_numbers;
mod macros;
mod member_uses;
mod members;
mod name_errors;
mod nested;
pub mod parser;
mod preprocess;
pub mod qualifiers;
pub mod raw;
mod report;
mod reserved;
mod scopes;
mod splice;
mod target;
mod texts;
pub mod types;
mod variables;
pub mod walk;

use std::borrow::Cow;
use std::path::Path;

use rustc_hash::FxHashMap;

use crate::diagnostic::{Code, Diagnostic};
use crate::shape::{
    AddressSpace, Block, DEFAULT_BLOCK, LengthConstant, Member, Rules, Shape, Type, Written,
};
use crate::source::{Files, ReadOptions, Source, Span, Target, kind_of_path};
use crate::syntax::{BodyErrors, Parsed};
use ast::Item;
pub(crate) use conditional_blocks::conditional_blocks;
use declarations::DeclarationReader;
pub use implicit_size::sized;
pub(super) use layout_ids::image_format;
use parser::{Bodies, Parser};
use preprocess::Preprocessor;
use target::TargetDecision;
pub use texts::Texts;

/// Errors that stop the parse and discard its results, which are unreliable then.
const FATAL: &[Code] =
    &[Code::CyclicInclude, Code::MacroBomb, Code::IncludeBomb, Code::OtherLanguage];

/// Parses the declarations of a GLSL shader. With `gather`, loose uniforms become a std140 block.
/// Those of a file with several stages are the blocks of all.
// The stages of one file are read one after the other from the same text, with the same numbers of
// files, so that spans of all can be compared: what two stages have in common is kept once.
pub(super) fn read(source: &Source, options: &ReadOptions, gather: bool) -> Parsed {
    let stages = dialect::stages(&source.text).len();
    if stages < 2 {
        return read_stage(source, options, gather, &Files::default());
    }
    if stages > dialect::MAX_STAGES {
        let message = format!("the file has more than {} stages", dialect::MAX_STAGES);
        let error = Diagnostic::error(Code::TooLarge, Span::default(), message);
        let files = Files::from_source(source);
        return Parsed { files, diagnostics: vec![error], ..Parsed::default() };
    }
    let of_stage = |index| ReadOptions { stage_index: Some(index), ..options.clone() };
    let mut parsed = read_stage(source, &of_stage(0), gather, &Files::default());
    for options in (1..stages).map(of_stage) {
        let stage = read_stage(source, &options, gather, &parsed.files);
        parsed.files = stage.files;
        let blocks = stage.shape.blocks.into_iter();
        let known = &mut parsed.shape.blocks;
        blocks.for_each(|block| match known.iter().any(|other| same_block(other, &block)) {
            true => {}
            false => known.push(block),
        });
        add_new(&mut parsed.shape.overrides, stage.shape.overrides);
        add_new(&mut parsed.shape.specialised, stage.shape.specialised);
        add_new(&mut parsed.shape.sized_by_use, stage.shape.sized_by_use);
        let constants = std::mem::take(&mut parsed.shape.constants).into_iter();
        parsed.shape.constants = LengthConstant::distinct(constants.chain(stage.shape.constants));
        add_new(&mut parsed.diagnostics, stage.diagnostics);
        parsed.bodies.extend(stage.bodies);
    }
    parsed
}

fn add_new<T: PartialEq>(known: &mut Vec<T>, new: Vec<T>) {
    new.into_iter().for_each(|new| match known.contains(&new) {
        true => {}
        false => known.push(new),
    });
}

/// Whether two stages declare one block: its layout and its place are the same.
// Not the span: a block in an include or before the stages has one span in all of them, one that is
// written out in each stage has several.
fn same_block(a: &Block, b: &Block) -> bool {
    (&a.name, &a.instance, a.space, a.rules) == (&b.name, &b.instance, b.space, b.rules)
        && (a.group, a.binding, &a.count) == (b.group, b.binding, &b.count)
        && same_members(&a.members, &b.members)
}

fn same_members(a: &[Member], b: &[Member]) -> bool {
    let number = |written: Option<Written>| written.map(|written| written.value);
    let same = |(a, b): (&Member, &Member)| {
        let is_same = match (a.ty.innermost(), b.ty.innermost()) {
            (Type::Struct(one), Type::Struct(other)) => {
                a.ty.dims() == b.ty.dims() && same_members(&one.members, &other.members)
            }
            _ => a.ty == b.ty,
        };
        is_same
            && (&a.name, a.matrix_layout) == (&b.name, b.matrix_layout)
            && (number(a.offset), number(a.align)) == (number(b.offset), number(b.align))
    };
    a.len() == b.len() && a.iter().zip(b).all(same)
}

/// Parses the stage of the options' index; `files` are those that the stages before it read.
fn read_stage(source: &Source, options: &ReadOptions, gather: bool, files: &Files) -> Parsed {
    let texts = Texts::new();
    let mut reader = reader(source, options, &texts, Bodies::Skip);
    reader.parser.preprocessor().know(files);
    let empty = reader.parser.tokens()[0].kind == lexer::Kind::End;
    // Declarations are read as they are parsed; tokens and trees go at once.
    reader.read(|parser, _| parser.forget());
    // `float a[];` in the middle of a block has the length that the bodies use, which were skipped:
    // such a text is read twice more, with its bodies for the lengths, then again for the layouts.
    if let Some(again) = with_lengths(&mut reader, source, options, &texts, Bodies::Skip) {
        reader = again;
        reader.parser.preprocessor().know(files);
        reader.read(|parser, _| parser.forget());
    }
    let preprocessor = reader.parser.preprocessor();
    let nested = nested::blocks(source, options, &preprocessor.bodies);
    reader.report_all(nested);
    shape(&mut reader, source, gather, empty)
}

/// Returns a text without its line continuations.
pub(super) fn joined_lines(text: &str) -> Cow<'_, str> {
    splice::splice(text).map_or(Cow::Borrowed(text), |(joined, _)| Cow::Owned(joined))
}

/// Returns the tokens of a text without line continuations, with a `;` after each directive.
// Directives end with their line, which a list of tokens does not show; the `;` does.
pub(super) fn tokens(text: &str) -> Vec<&str> {
    let mut lexer = lexer::Lexer::new(text, 0);
    let (mut tokens, mut comments) = (Vec::new(), Vec::new());
    let mut directive = false;
    loop {
        let token = lexer.next(&mut comments);
        let ends = token.kind == lexer::Kind::End;
        if directive && (token.first || ends) {
            tokens.push(";");
            directive = false;
        }
        if ends {
            return tokens;
        }
        directive |= token.first && token.is("#");
        tokens.push(token.text);
    }
}

/// A shader's syntax tree and the shape of its blocks.
pub struct Shader<'a> {
    /// The declarations; expressions and bodies are parsed by [`Parser::complete`].
    pub items: Vec<ast::Item<'a>>,
    /// The parser with all tokens, bodies included and macros expanded.
    pub parser: Parser<'a>,
    pub parsed: Parsed,
}

/// Parses a GLSL shader, keeping function bodies to be parsed on demand; `texts` owns the text its
/// tokens refer to.
pub fn parse<'a>(
    source: &Source,
    options: &'a ReadOptions,
    texts: &'a Texts,
    gather: bool,
) -> Shader<'a> {
    let mut reader = reader(source, options, texts, Bodies::Keep);
    let empty = reader.parser.tokens()[0].kind == lexer::Kind::End;
    let mut items = reader.read_items();
    if let Some(again) = with_lengths(&mut reader, source, options, texts, Bodies::Keep) {
        reader = again;
        items = reader.read_items();
    }
    let parsed = shape(&mut reader, source, gather, empty);
    Shader { items, parser: reader.parser, parsed }
}

/// Returns the first syntax error of a shader, function bodies included.
pub(super) fn syntax_error(source: &Source, options: &ReadOptions) -> Option<Diagnostic> {
    let texts = Texts::new();
    let mut shader = parse(source, options, &texts, false);
    parse_bodies(&mut shader, source).err()
}

/// Parses what [`parse`] kept as tokens.
///
/// # Errors
/// The first syntax error, or the limit that cut the tokens off: the parser would find an error at
/// the cut.
fn parse_bodies(shader: &mut Shader<'_>, source: &Source) -> Result<(), Diagnostic> {
    let limit = shader.parsed.diagnostics.iter().find(|d| d.code == Code::CannotRun);
    if let Some(limit) = limit {
        return Err(limit.clone());
    }
    // Of a file with several stages, that which is read.
    let stage = shader.parser.preprocessor().stage.or(source.stage);
    let completed = shader.parser.complete(&mut shader.items, stage);
    completed.map_err(|error| *error.diagnostic())
}

/// Returns what no compiler takes in function bodies: the first syntax error, or every name that is
/// reserved or, in a shader with an entry point, not declared; of a file with several stages, in each.
pub(super) fn body_errors(source: &Source, options: &ReadOptions) -> BodyErrors {
    let stages = dialect::stages(&source.text).len();
    if stages < 2 || options.stage_index.is_some() {
        return body_errors_of_stage(source, options);
    }
    let mut all = BodyErrors { errors: Vec::new(), has_entry_point: false };
    for stage_index in (0..stages).map(Some) {
        let options = ReadOptions { stage_index, ..options.clone() };
        let found = body_errors_of_stage(source, &options);
        add_new(&mut all.errors, found.errors);
        all.has_entry_point |= found.has_entry_point;
    }
    all
}

// A text without `main` is a part of others: what it does not declare may be theirs, and so may a
// macro that makes its syntax whole.
fn body_errors_of_stage(source: &Source, options: &ReadOptions) -> BodyErrors {
    let texts = Texts::new();
    let mut shader = parse(source, options, &texts, false);
    let is_main = |item: &ast::Item<'_>| match item {
        ast::Item::Function(function) => function.name.text == "main",
        _ => false,
    };
    let has_entry_point = shader.items.iter().any(is_main);
    let errors = match parse_bodies(&mut shader, source) {
        Err(error) => has_entry_point.then_some(error).into_iter().collect(),
        Ok(()) => {
            let mut errors = later_keywords::errors(&shader.items, &mut shader.parser);
            if has_entry_point {
                errors.extend(name_errors::undeclared(&shader.items, &shader.parser));
            }
            errors
        }
    };
    BodyErrors { errors, has_entry_point }
}

/// Returns the values of `KEY = N` in the layout qualifiers of global declarations, by the first
/// byte of each key in the shader's own text.
pub fn layout_numbers(source: &Source, options: &ReadOptions) -> FxHashMap<u32, u32> {
    let texts = Texts::new();
    let mut reader = reader(source, options, &texts, Bodies::Skip);
    let items = reader.read_items();
    let mut numbers = FxHashMap::default();
    for item in &items {
        let qualifiers = match item {
            Item::Block(block) | Item::Interface(block) => &block.qualifiers,
            Item::Variables(variables) => &variables.qualifiers,
            Item::Defaults(qualifiers) | Item::Requalified(qualifiers, _) => qualifiers,
            Item::Function(_) | Item::Precision(_) | Item::Other(_) => continue,
        };
        for id in qualifiers.layout.iter().filter(|id| !id.tokens.is_empty()) {
            let number = reader.layout_number(id).ok().and_then(|n| u32::try_from(n).ok());
            let own = id.name.span.file == 0;
            numbers.extend(number.filter(|_| own).map(|number| (id.name.span.start, number)));
        }
    }
    numbers
}

fn reader<'a>(
    source: &Source,
    options: &'a ReadOptions,
    texts: &'a Texts,
    bodies: Bodies,
) -> DeclarationReader<'a> {
    let mut preprocessor =
        Preprocessor::new(&source.path, &source.text, source.stage, texts, options);
    preprocessor.note_foreign(0, source.foreign);
    let of_tool = preprocessor.stage;
    let parser = Parser::new(preprocessor, bodies);
    // Probes run a shader's declarations in other stages than its own.
    let own = kind_of_path(Path::new(&source.path)).and_then(|(_, stage)| stage);
    let stage = own.filter(|own| source.stage == Some(*own)).or(of_tool);
    DeclarationReader { stage, ..DeclarationReader::new(parser) }
}

/// Returns a new reader that knows the lengths of the members whose declarations leave them open,
/// if the reader met such members.
fn with_lengths<'a>(
    reader: &mut DeclarationReader<'a>,
    source: &Source,
    options: &'a ReadOptions,
    texts: &'a Texts,
    bodies: Bodies,
) -> Option<DeclarationReader<'a>> {
    let members = std::mem::take(&mut reader.unsized_members);
    if members.is_empty() {
        return None;
    }
    let mut whole = self::reader(source, options, texts, Bodies::Keep);
    let items = whole.read_items();
    let lengths = implicit_size::lengths(&mut whole, items, &members);
    Some(DeclarationReader { lengths, ..self::reader(source, options, texts, bodies) })
}

fn shape(reader: &mut DeclarationReader<'_>, source: &Source, gather: bool, empty: bool) -> Parsed {
    let mut blocks = std::mem::take(&mut reader.blocks);
    match &reader.options().structure {
        Some(name) => blocks = reader.structure_named(name).into_iter().collect(),
        None => blocks.extend(default_block(reader, gather)),
    }
    let constants = std::mem::take(&mut reader.length_constants);
    let constants = length_constants::of_blocks(constants, &blocks);
    let used = reader.constants.used.iter();
    let overrides = reader.constants.overrides.iter().zip(used);
    let overrides = overrides.filter(|(_, used)| **used).map(|(o, _)| o.clone()).collect();
    let preprocessor = reader.parser.preprocessor();
    let mut diagnostics = std::mem::take(&mut preprocessor.diagnostics);
    if empty && diagnostics.is_empty() && source.text.trim().is_empty() {
        diagnostics.push(Diagnostic::error(Code::EmptyFile, Span::default(), "the file is empty"));
    }
    // The parse stopped somewhere: members may be missing from what was read so far.
    if diagnostics.iter().any(|d| FATAL.contains(&d.code)) {
        // A text expanded several times repeats its diagnostics.
        let mut reported = Vec::new();
        diagnostics.retain(|d| {
            let new = d.code != Code::DuplicateName && !reported.contains(&d.labels);
            reported.push(d.labels.clone());
            new
        });
        blocks.clear();
    }
    // The decision may cost a second reading, so only a text that tests for `VULKAN` is asked.
    let (assumed, assumed_of_loose) = match preprocessor.tests_vulkan.get() {
        true => match preprocessor.decision() {
            TargetDecision::Assumed(target) => (Some(target), false),
            TargetDecision::Loose => (Some(Target::OpenGl), true),
            TargetDecision::Known(_) | TargetDecision::Either => (None, false),
        },
        false => (None, false),
    };
    Parsed {
        stage: None,
        shape: Shape {
            blocks,
            overrides,
            specialised: std::mem::take(&mut reader.specialised),
            constants,
            sized_by_use: std::mem::take(&mut reader.sized_by_use),
        },
        assumed,
        assumed_of_loose,
        opengl_es: preprocessor.version.es && preprocessor.target() != Some(Target::Vulkan),
        standard_uniforms: false,
        files: std::mem::take(&mut preprocessor.files),
        diagnostics,
        bodies: std::mem::take(&mut preprocessor.bodies),
    }
}

/// Returns the loose uniforms as one block, either gathered or without offsets.
// OpenGL gives loose uniforms locations, not offsets (GLSL 4.60 §4.3.5), so without `gather` the
// block only lists them. `gather` lays them out as if they were declared in a block, in std140.
fn default_block(reader: &mut DeclarationReader<'_>, gather: bool) -> Option<Block> {
    let mut members = std::mem::take(&mut reader.loose);
    let opaque = std::mem::take(&mut reader.loose_opaque);
    let span = members.first()?.span;
    if gather {
        members.retain(|member| {
            let sized = member.ty.dims().iter().all(|len| *len != crate::ArrayLen::Runtime);
            if !sized {
                let message = format!(
                    "`{}` cannot become a member of a block: its size is unknown",
                    member.name
                );
                let diagnostic = Diagnostic::error(Code::ArraySize, member.span, message);
                let help = "write the number of elements between the brackets";
                reader.report(diagnostic.with_help(help));
            }
            sized
        });
    }
    let space = if gather { AddressSpace::Uniform } else { AddressSpace::Default };
    let block = Block::unqualified(DEFAULT_BLOCK.into(), space, Rules::Std140, members, span);
    Some(Block { rules_declared: false, gathered: true, opaque, ..block })
}
