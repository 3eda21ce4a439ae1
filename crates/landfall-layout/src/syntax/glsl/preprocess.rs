//! The GLSL preprocessor: executes directives, expands macros, opens includes.
//!
//! Feeds [`declarations`](super::declarations) one token stream, each token with its span in the
//! user's text. Function bodies are skipped as text.

mod expand;

use std::cell::{Cell, OnceCell};
use std::rc::Rc;
use std::sync::Arc;

use rustc_hash::{FxHashMap, FxHashSet};

use super::dialect::{self, StageText};
use super::directive::Condition;
use super::lexer::{Kind, Lexer, Stop, Token};
use super::line_numbers::LineNumbers;
use super::macros::Macro;
use super::target::{self, TargetDecision};
use super::texts::Texts;
use crate::diagnostic::{Code, Diagnostic};
use crate::interface::Include;
use crate::source::{Files, Foreign, ReadOptions, Span, Stage, Target};
use crate::text::counts;

/// The limit on errors reported for one shader.
// A text that is no GLSL at all has an error on almost every line.
const MAX_ERRORS: usize = 100;

// `frames` is a stack of sources, the innermost last: an include or a macro is read to its end
// before the text after it. A token leaves the stack by `next`, which expands it, and never comes
// back except as `TokenSource::Tokens`.
pub struct Preprocessor<'a> {
    pub(super) texts: &'a Texts,
    pub(super) options: &'a ReadOptions,
    pub(super) files: Files,
    pub(super) macros: FxHashMap<&'a str, Rc<Macro<'a>>>,
    /// Names removed by `#undef`, the language's own macros among them.
    pub(super) undefined: FxHashSet<&'a str>,
    /// Undefined names in conditions that were reported.
    pub(super) undefined_reported: FxHashSet<String>,
    pub(super) conditions: Vec<Condition>,
    pub(super) frames: Vec<TokenSource<'a>>,
    /// The number of files that the stages before this one read.
    pub(super) known_files: usize,
    /// The files before the shader's own text, whose `#version` is that of the shader.
    pub(super) preludes: Vec<u32>,
    /// Texts included so far by path, so that a file is read once.
    pub(super) included: FxHashMap<String, (u32, &'a str)>,
    pub(super) included_bytes: usize,
    /// The number of `#include` directives executed.
    pub(super) includes: usize,
    /// Those that opened a file.
    pub(super) opened: Vec<Include>,
    /// The `#line` directives executed so far.
    pub(super) lines: Vec<LineNumbers>,
    pub(super) comments: Vec<Span>,
    pub(super) diagnostics: Vec<Diagnostic>,
    pub(super) version: Version,
    pub(super) version_declared: bool,
    /// The shader's own text, from which the API is inferred.
    text: Arc<str>,
    decision: OnceCell<TargetDecision>,
    /// The stage of a file that a tool splits into several.
    pub(super) stage: Option<Stage>,
    /// Whether the tool that splits the file into stages compiles them for Vulkan.
    is_vulkan: bool,
    /// Whether the text tests for the macro `VULKAN`.
    pub(super) tests_vulkan: Cell<bool>,
    pub(super) extensions: Vec<&'a str>,
    /// The directives executed so far, by the span of their `#`.
    pub(super) obeyed: Vec<Span>,
    /// Function bodies of the shader's own file: from after `{` to before `}`.
    pub(super) bodies: Vec<Span>,
    /// Whether some macro has unbalanced braces: then bodies are read token by token.
    pub(super) brace_macros: bool,
    /// Set by an error after which the stream ends.
    pub(super) stopped: bool,
    expanded: usize,
    argument_depth: u32,
    /// Frames below this index are not read: they belong to the caller of an expansion.
    floor: usize,
    directive_errors: usize,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Version {
    /// `#version NUMBER`; 110 when there is none.
    pub number: u32,
    pub es: bool,
    pub profile: Profile,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Profile {
    /// `core`, also the default.
    Core,
    Compatibility,
}

pub(super) enum TokenSource<'a> {
    /// A file; `conditions` is the number open when it began.
    File { lexer: Lexer<'a>, conditions: usize },
    /// The expansion of a macro, in which its name is not expanded again.
    Macro { definition: Rc<Macro<'a>>, tokens: Vec<Token<'a>>, at: usize },
    /// Tokens put back, or expanded on their own.
    Tokens { tokens: Vec<Token<'a>>, at: usize },
}

impl<'a> TokenSource<'a> {
    fn lexer(&mut self) -> Option<&mut Lexer<'a>> {
        match self {
            TokenSource::File { lexer, .. } => Some(lexer),
            TokenSource::Macro { .. } | TokenSource::Tokens { .. } => None,
        }
    }
}

impl<'a> Preprocessor<'a> {
    /// Starts at a shader whose text is file 0. Of a file with several stages it reads `wanted`, unless
    /// the options say which.
    pub fn new(
        path: &str,
        text: &Arc<str>,
        wanted: Option<Stage>,
        texts: &'a Texts,
        options: &'a ReadOptions,
    ) -> Preprocessor<'a> {
        let mut files = Files::default();
        let file = files.add(path, text.clone());
        let whole = text.clone();
        let mut stages = dialect::stages(text);
        let is_wanted = |stage: &StageText<'_>| Some(stage.stage) == wanted;
        let index = options.stage_index.or_else(|| stages.iter().position(is_wanted)).unwrap_or(0);
        let stage_text = (index < stages.len()).then(|| stages.swap_remove(index));
        let text = stage_text.as_ref().map_or(text.clone(), |stage| stage.text(text).into());
        let text: &'a str = texts.alloc(text);
        // GLSL 4.60 §3.3: a text without `#version` is GLSL 1.10.
        let mut preprocessor = Preprocessor {
            texts,
            options,
            files,
            macros: FxHashMap::default(),
            undefined: FxHashSet::default(),
            undefined_reported: FxHashSet::default(),
            conditions: Vec::new(),
            frames: vec![TokenSource::File {
                lexer: Lexer::of_file(text, file, texts),
                conditions: 0,
            }],
            known_files: 0,
            preludes: Vec::new(),
            included: FxHashMap::default(),
            included_bytes: 0,
            includes: 0,
            opened: Vec::new(),
            lines: Vec::new(),
            comments: Vec::new(),
            diagnostics: Vec::new(),
            version: Version {
                number: stage_text.as_ref().map_or(110, |stage| stage.version),
                es: false,
                profile: Profile::Core,
            },
            version_declared: false,
            text: whole,
            decision: OnceCell::new(),
            stage: stage_text.as_ref().map(|stage| stage.stage),
            is_vulkan: stage_text.as_ref().is_some_and(|stage| stage.is_vulkan),
            tests_vulkan: Cell::new(false),
            extensions: Vec::new(),
            obeyed: Vec::new(),
            bodies: Vec::new(),
            brace_macros: false,
            stopped: false,
            expanded: 0,
            argument_depth: 0,
            floor: 0,
            directive_errors: 0,
        };
        // Preludes are pushed last, hence read first; the macros of the command line hold in them
        // too.
        preprocessor.define_given();
        preprocessor.open_preludes();
        preprocessor
    }

    /// Goes on with the files of a reading of the same text by the same options.
    pub(super) fn know(&mut self, files: &Files) {
        if files.get(0).is_some() {
            self.files = files.clone();
            self.known_files = files.iter().count();
        }
    }

    /// The API the text is read for; `None` if it defaults to OpenGL.
    pub fn target(&self) -> Option<Target> {
        match self.decision() {
            TargetDecision::Known(target) => Some(target),
            TargetDecision::Assumed(Target::Vulkan) => Some(Target::Vulkan),
            TargetDecision::Assumed(Target::OpenGl)
            | TargetDecision::Either
            | TargetDecision::Loose => None,
        }
    }

    /// Returns how the API was determined.
    // Asked by what depends on the API, `VULKAN` above all, or never: inference preprocesses the
    // text once more.
    pub(crate) fn decision(&self) -> TargetDecision {
        *self.decision.get_or_init(|| match self.options.target {
            Some(target) => TargetDecision::Known(target),
            None if self.is_vulkan => TargetDecision::Known(Target::Vulkan),
            None => {
                let version = self.version_declared.then_some(self.version);
                let path = self.files.get(0).map_or("", |file| &file.path);
                target::decide(path, &self.text, self.options, version)
            }
        })
    }

    /// Copies a text to the arena, so that it lives as long as the tokens.
    pub(super) fn keep(&self, text: &str) -> &'a str {
        self.texts.alloc(Arc::from(text))
    }

    /// Records a diagnostic; past [`MAX_ERRORS`] the stream ends.
    pub fn report(&mut self, diagnostic: Diagnostic) {
        if self.stopped {
            return; // later errors follow from the early end
        }
        self.diagnostics.push(diagnostic);
        self.directive_errors += 1;
        if self.directive_errors >= MAX_ERRORS {
            self.stopped = true;
        }
    }

    /// Records an error after which the stream ends.
    pub(super) fn stop(&mut self, error: Diagnostic) {
        self.report(error);
        self.stopped = true;
    }

    /// The lexer of the innermost source, if that is a file.
    pub(super) fn lexer(&mut self) -> Option<&mut Lexer<'a>> {
        self.frames.last_mut()?.lexer()
    }

    /// Returns the next token of the line of a directive, or `None` at its end.
    pub(super) fn on_line(&mut self) -> Option<Token<'a>> {
        self.frames.last_mut()?.lexer()?.next_on_line(&mut self.comments)
    }

    /// The files that are open, the shader's own first.
    pub(super) fn open_files(&self) -> impl DoubleEndedIterator<Item = u32> {
        self.frames.iter().filter_map(|frame| match frame {
            TokenSource::File { lexer, .. } => Some(lexer.file()),
            TokenSource::Macro { .. } | TokenSource::Tokens { .. } => None,
        })
    }

    /// Records once per file that some of its bytes are not UTF-8.
    pub(crate) fn note_foreign(&mut self, file: u32, foreign: Option<Foreign>) {
        let Some(Foreign { first, count }) = foreign else { return };
        let span = Span { file, start: first, end: first };
        let bytes = if count == 1 {
            "1 byte is".to_string()
        } else {
            format!("{} are", counts::bytes(count as u64))
        };
        let message = format!("{bytes} not UTF-8 and read as Latin-1");
        self.diagnostics.push(
            Diagnostic::warning(Code::NotUtf8, span, message)
                .with_note("GLSL allows any byte in a comment, but not outside"),
        );
    }

    /// Returns the next token with macros expanded.
    // GLSL 4.60 §3.3 expands as the preprocessor of C++ does: what a macro yields is scanned again
    // together with the text after it, except for the macro's own name. The loop is that rescan.
    #[inline]
    pub fn next(&mut self) -> Token<'a> {
        loop {
            let token = self.next_raw();
            if token.kind != Kind::Name || token.frozen {
                return token;
            }
            if let Some(token) = self.expand(token) {
                return token;
            }
        }
    }

    /// Returns the next token as it is; directives before it are executed.
    fn next_raw(&mut self) -> Token<'a> {
        loop {
            if self.stopped || self.frames.len() == self.floor {
                return self.end();
            }
            match self.frames.last_mut() {
                None => return self.end(),
                Some(
                    TokenSource::Macro { tokens, at, .. } | TokenSource::Tokens { tokens, at },
                ) => {
                    if let Some(token) = tokens.get(*at) {
                        *at += 1;
                        return *token;
                    }
                    // From here on the name may be expanded again; while it is read, recursion
                    // would not end.
                    if let Some(TokenSource::Macro { definition, .. }) = self.frames.pop() {
                        definition.expanding.set(false);
                    }
                }
                Some(TokenSource::File { lexer, .. }) => {
                    let token = lexer.next(&mut self.comments);
                    match token.kind {
                        Kind::Punctuation if token.first && token.is("#") => self.directive(token),
                        Kind::End => {
                            self.end_of_file();
                            // The end of the shader's own file stays on the stack, and is returned
                            // as often as asked.
                            if self.frames.len() == 1 {
                                return token;
                            }
                            self.frames.pop();
                        }
                        _ => return token,
                    }
                }
            }
        }
    }

    /// Reports a comment or conditions left open at the end of a file.
    fn end_of_file(&mut self) {
        let Some(lexer) = self.lexer() else { return };
        let (open, file, is_spliced) = (lexer.open_comment(), lexer.file(), lexer.is_spliced());
        if let Some(span) = open {
            let message = "`/*` is never closed";
            self.report(Diagnostic::error(Code::UnclosedComment, span, message));
        }
        if is_spliced && !self.has_continuations() {
            self.report_continued_comments(file);
        }
        // A condition does not reach past the file that it is opened in.
        self.check_open_conditions();
    }

    /// Whether the version has line continuations: GLSL 4.20, ES 3.00, or
    /// GL_ARB_shading_language_420pack.
    fn has_continuations(&self) -> bool {
        !self.version_declared
            || self.version.number >= if self.version.es { 300 } else { 420 }
            || self.extensions.contains(&"GL_ARB_shading_language_420pack")
    }

    /// Reports `//` comments that end with a backslash in a version without line continuations,
    /// where compilers differ: Mesa continues the comment on the next line, glslang does not.
    fn report_continued_comments(&mut self, file: u32) {
        let continued = |comment: &&Span| {
            let text = self.files.text(**comment);
            let mut lines = text.split(['\n', '\r']).skip(1).map(str::trim);
            comment.file == file
                && text.starts_with("//")
                && lines.any(|line| !line.is_empty() && !line.starts_with("//"))
        };
        let Some(comment) = self.comments.iter().find(continued).copied() else { return };
        let number = self.version.number;
        let message = "a backslash continues this comment on the next line";
        self.diagnostics.push(
            Diagnostic::warning(Code::LineContinuation, comment, message)
                .with_note(format!(
                    "GLSL {number} has no line continuation, so compilers differ: Mesa's continues the \
                     comment, glslang's reads the next line as code"
                ))
                .with_help("remove the backslash at the end of the comment"),
        );
    }

    fn end(&self) -> Token<'a> {
        let span = match self.frames.first() {
            Some(TokenSource::File { lexer, .. }) => {
                Span { file: 0, start: lexer.offset(), end: lexer.offset() }
            }
            _ => Span::default(),
        };
        Token { comments: self.comments.len() as u32, ..Token::end(span) }
    }

    /// Skips a function body, whose `{` is `open`; returns whether it was closed.
    // Bodies are most of a shader's bytes and have no layouts, so they are searched for braces
    // instead of read as tokens. Directives are executed on the way: they may take a brace out of
    // the text, and define macros for later declarations. A macro with a lone `{` or `}` hides
    // braces from the search, so from its definition on, bodies are read as tokens.
    pub(crate) fn skip_body(&mut self, open: &Token<'a>) -> bool {
        let mut depth = 1u32;
        loop {
            if self.stopped {
                return true;
            }
            let is_skipped = !self.brace_macros;
            if let Some(lexer) = self.lexer().filter(|_| is_skipped) {
                match lexer.skip_to_brace() {
                    Stop::Open => depth += 1,
                    Stop::Close => depth -= 1,
                    Stop::Directive => {
                        if let Some(hash) = self.on_line() {
                            self.directive(hash);
                        }
                    }
                    // A body may begin in an include and end in the file that includes it.
                    Stop::End if self.frames.len() > 1 => {
                        self.end_of_file();
                        self.frames.pop();
                    }
                    Stop::End => return false,
                }
            } else {
                let token = self.next();
                match token.text {
                    _ if token.kind == Kind::End => return false,
                    "{" => depth += 1,
                    "}" => depth -= 1,
                    _ => {}
                }
            }
            if depth == 0 {
                self.note_body(open);
                return true;
            }
        }
    }

    // The offsets are of the shader's own text, so a body is only noted if both braces stand there.
    fn note_body(&mut self, open: &Token<'a>) {
        if let (Some(TokenSource::File { lexer, .. }), 0) = (self.frames.last(), open.span.file) {
            if self.frames.len() == 1 && open.definition.is_none() {
                let end = lexer.offset() - 1;
                self.bodies.push(Span { file: 0, start: open.span.end, end });
            }
        }
    }
}
