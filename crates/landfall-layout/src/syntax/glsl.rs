//! GLSL as people have it: desktop 1.10 to 4.60, ES 1.00 to 3.20, Vulkan flavour.
//!
//! [`lexer`] makes tokens of a file, [`preprocess`] (with [`directive`],
//! [`include`], [`macros`]) makes one stream of a shader, [`declarations`]
//! (with [`qualifiers`], [`members`], [`blocks`], [`constants`]) reads what has
//! a layout from it. Function bodies are passed over.

mod blocks;
mod constants;
mod declarations;
mod directive;
mod expression;
mod include;
pub mod lexer;
mod macros;
mod members;
mod preprocess;
pub mod qualifiers;
pub mod raw;
mod target;
pub mod types;

use crate::diagnostic::Code;
use crate::diagnostic::Diagnostic;
use crate::shape::{AddressSpace, Block, DEFAULT_BLOCK, Majorness, OffsetOrder, Rules, Shape};
use crate::source::{ReadOptions, Source, Span};
use crate::syntax::Parsed;
use declarations::Reader;
use preprocess::Preprocessor;
pub use preprocess::Texts;

/// Errors after which a text is read no further: what was read before them is not to be trusted.
const FATAL: &[Code] = &[Code::CyclicInclude, Code::MacroBomb, Code::IncludeBomb];

/// Reads the declarations of a GLSL shader. With `gather`, loose uniforms become a std140 block.
pub(super) fn read(source: &Source, options: &ReadOptions, gather: bool) -> Parsed {
    let texts = Texts::new();
    let preprocessor = Preprocessor::new(&source.path, &source.text, &texts, options);
    let mut reader = Reader::new(preprocessor);
    let empty = reader.token.kind == lexer::Kind::End;
    reader.read();

    let mut blocks = std::mem::take(&mut reader.blocks);
    if let Some(default) = default_block(&mut reader, gather) {
        blocks.push(default);
    }
    let used = reader.constants.used.iter();
    let overrides = reader.constants.overrides.iter().zip(used);
    let overrides = overrides.filter(|(_, used)| **used).map(|(o, _)| o.clone()).collect();
    let mut preprocessor = reader.preprocessor;
    let mut diagnostics = std::mem::take(&mut preprocessor.diagnostics);
    if empty && diagnostics.is_empty() && source.text.trim().is_empty() {
        diagnostics.push(Diagnostic::error(Code::EmptyFile, Span::default(), "the file is empty"));
    }
    if diagnostics.iter().any(|d| FATAL.contains(&d.code)) {
        // A text that was read several times over says the same things several times.
        let mut told = Vec::new();
        diagnostics.retain(|d| {
            let new = d.code != Code::DuplicateName && !told.contains(&d.labels);
            told.push(d.labels.clone());
            new
        });
        blocks.clear();
    }
    Parsed {
        shape: Shape { blocks, overrides },
        files: preprocessor.files,
        diagnostics,
        bodies: preprocessor.bodies,
    }
}

/// Every token of a shader, bodies included, macros expanded; the last one is the end.
pub struct Stream<'a> {
    /// The preprocessed tokens.
    pub tokens: Vec<lexer::Token<'a>>,
    /// The files they come from.
    pub files: crate::source::Files,
    /// Errors and warnings of lexer and preprocessor.
    pub diagnostics: Vec<Diagnostic>,
    /// Whether it is written for OpenGL ES.
    pub es: bool,
}

/// Longer shaders are not run: a text of so many tokens was made to exhaust memory.
const MOST_TOKENS: usize = 1 << 20;

/// Reads all tokens of a shader; `texts` keeps what they point into.
pub fn tokens<'a>(source: &Source, options: &'a ReadOptions, texts: &'a Texts) -> Stream<'a> {
    let mut preprocessor = Preprocessor::new(&source.path, &source.text, texts, options);
    let mut tokens = Vec::with_capacity(source.text.len() / 4);
    loop {
        let token = preprocessor.next();
        tokens.push(token);
        if token.kind == lexer::Kind::End {
            break;
        }
        if tokens.len() == MOST_TOKENS {
            let message = format!("the shader has more than {MOST_TOKENS} tokens");
            preprocessor.report(Diagnostic::error(Code::CannotRun, token.span, message));
            preprocessor.stopped = true;
        }
    }
    Stream {
        tokens,
        es: preprocessor.version.es,
        files: preprocessor.files,
        diagnostics: preprocessor.diagnostics,
    }
}

/// The loose uniforms as one block: without offsets of their own, or gathered.
fn default_block(reader: &mut Reader<'_>, gather: bool) -> Option<Block> {
    let mut members = std::mem::take(&mut reader.loose);
    let opaque = std::mem::take(&mut reader.loose_opaque);
    let span = members.first()?.span;
    if gather {
        members.retain(|member| {
            let sized = member.ty.dims().iter().all(|len| *len != crate::ArrayLen::Runtime);
            if !sized {
                let message =
                    format!("`{}` cannot be gathered: its size is not written", member.name);
                let diagnostic = Diagnostic::error(Code::ArraySize, member.span, message);
                reader.preprocessor.report(
                    diagnostic.with_help("write the number of elements between the brackets"),
                );
            }
            sized
        });
    }
    Some(Block {
        name: DEFAULT_BLOCK.into(),
        instance: None,
        space: if gather { AddressSpace::Uniform } else { AddressSpace::Default },
        rules: Rules::Std140,
        rules_declared: false,
        gathered: true,
        group: None,
        binding: None,
        count: Vec::new(),
        majorness: Majorness::Column,
        members,
        opaque,
        offset_order: OffsetOrder::Ascending,
        span,
        comment: Vec::new(),
    })
}
