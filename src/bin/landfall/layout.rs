//! `landfall layout`: every block of every shader in one of the formats.

mod writer;

use landfall_layout::diagnostic::Code;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

use landfall_layout::format as emit;
use landfall_layout::format::{EmitOptions, Format, Paint};
use landfall_layout::source::Files;
use landfall_layout::{BlockLayout, Diagnostic, Error, Options, ShaderLayout};

use crate::args::LayoutArgs;
use crate::inputs::{Input, Inputs};
use crate::output::{Failure, FindingForm, FindingStyle, Outcome, Streams};
use crate::{given, read, work};
use writer::Writer;

/// Errors after which the rest of a shader cannot be told apart: none of its blocks is printed.
const SYNTAX: &[Code] = &[
    Code::Syntax,
    Code::UnexpectedToken,
    Code::UnclosedBrace,
    Code::UnclosedComment,
    Code::UnmatchedDirective,
];

pub fn run(args: &LayoutArgs, streams: &Streams) -> Result<Outcome, Failure> {
    let format = args.format.form();
    let form = if format == Format::Json { FindingForm::Json } else { FindingForm::Human };
    let paint = if args.out.is_some() { Paint::Plain } else { streams.paint };
    let job = Job {
        args,
        options: Options { naga: args.naga || format == Format::Json, ..read::options(&args.read) },
        emit: EmitOptions { format, expand: args.expand, paint },
        style: streams.style(form),
    };
    let mut writer = Writer::new(args, &job.emit, job.style, streams);
    work::ordered(
        Inputs::new(args.files.clone()),
        args.jobs,
        |input| job.one(input),
        |done| writer.take(done),
    )?;
    writer.finish()
}

/// Whether a finding says that a shader's text cannot be told apart.
pub fn is_syntax(found: &Diagnostic) -> bool {
    SYNTAX.contains(&found.code)
}

/// Whether a block goes by that name.
pub fn is_named(block: &BlockLayout, name: &str) -> bool {
    *block.name == *name || block.instance.as_deref() == Some(name)
}

/// What is the same for all shaders of a run.
struct Job<'a> {
    args: &'a LayoutArgs,
    options: Options,
    emit: EmitOptions,
    style: FindingStyle,
}

/// What became of one shader.
struct Done {
    path: PathBuf,
    /// Where the product goes below `--out`.
    relative: PathBuf,
    /// The layouts as text; `None` when there is nothing to write.
    product: Option<String>,
    /// The findings as text.
    findings: String,
    failed: bool,
    /// Blocks that `--block` left out.
    others: Vec<String>,
    /// The shader and its includes, where a file is written.
    files: Files,
}

impl work::Weighed for Done {
    fn bytes(&self) -> usize {
        self.findings.len() + self.product.as_ref().map_or(0, String::len)
    }
}

impl Job<'_> {
    fn one(&self, input: Result<Input, Error>) -> Done {
        let input = match input {
            Ok(input) => input,
            Err(error) => {
                let found = Diagnostic { code: Code::NoInput, ..error.into() };
                return self.failed(PathBuf::new(), found);
            }
        };
        let source = match read::source(&input.path, &self.args.read) {
            Ok(source) => source,
            Err(error) => return self.failed(input.path, error.into()),
        };
        let path = input.path.clone();
        let work = || self.laid_out(input, landfall_layout::layout(&source, &self.options));
        match catch_unwind(AssertUnwindSafe(work)) {
            Ok(done) => done,
            Err(_) => {
                let found = panicked(&path);
                self.failed(path, found)
            }
        }
    }

    fn failed(&self, path: PathBuf, found: Diagnostic) -> Done {
        Done {
            path,
            relative: PathBuf::new(),
            product: None,
            findings: self.style.text(&[found], &Files::default()),
            failed: true,
            others: vec![],
            files: Files::default(),
        }
    }

    fn laid_out(&self, input: Input, mut shader: ShaderLayout) -> Done {
        given::saw(&shader.files);
        let mut others = Vec::new();
        if let Some(name) = &self.args.block {
            let (kept, left) = shader.blocks.into_iter().partition(|b| is_named(b, name));
            shader.blocks = kept;
            let left: Vec<BlockLayout> = left;
            others.extend(left.iter().map(|block| block.name.to_string()));
        }
        let refused = emit::refused(&shader, &self.emit);
        shader.diagnostics.extend(refused);
        let failed = shader.has_errors();
        Done {
            product: self.writes(&shader, failed).then(|| match self.args.out {
                Some(_) => emit::document(&shader, &self.emit),
                None => emit::shader(&shader, &self.emit),
            }),
            findings: self.style.text(&shader.diagnostics, &shader.files),
            path: input.path,
            relative: input.relative,
            failed,
            others,
            files: if self.args.out.is_some() { shader.files } else { Files::default() },
        }
    }

    /// Whether there is something to write about a shader.
    fn writes(&self, shader: &ShaderLayout, failed: bool) -> bool {
        // A file holds all blocks or is not written; on stdout the sound blocks are welcome.
        if failed && (self.args.out.is_some() || shader.diagnostics.iter().any(is_syntax)) {
            return false;
        }
        match self.emit.format {
            Format::Json | Format::Csv => self.args.block.is_none() || !shader.blocks.is_empty(),
            Format::Table | Format::Listing | Format::Markdown => !shader.blocks.is_empty(),
        }
    }
}

pub fn panicked(path: &Path) -> Diagnostic {
    let error = Error::new(path.display().to_string(), "made landfall panic: this is its fault")
        .with_help("please report it with the file; the other files are not affected");
    Diagnostic { code: Code::InternalError, ..error.into() }
}
