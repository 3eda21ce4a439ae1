//! `landfall layout`: prints the layout of every block of every shader.

mod writer;

use landfall_layout::diagnostic::Code;
use std::path::PathBuf;

use landfall_layout::format as emit;
use landfall_layout::format::{EmitOptions, Format, Paint};
use landfall_layout::source::Files;
use landfall_layout::{BlockLayout, Diagnostic, Error, Options, ShaderLayout};

use crate::args::LayoutArgs;
use crate::inputs::{Input, Inputs};
use crate::output::{Failure, FindingForm, FindingStyle, Outcome, Streams};
use crate::panics::caught;
use crate::{read, without_effect, work};
use writer::Writer;

pub fn run(args: &LayoutArgs, streams: &Streams) -> Result<Outcome, Failure> {
    if args.naga && !cfg!(feature = "naga") {
        let error = Error::new("--naga", "is not in this build: it needs the feature `analysis`");
        return Err(error.with_help("cargo install landfall --features analysis"));
    }
    let format = args.format.form();
    let form = if format == Format::Json { FindingForm::Json } else { FindingForm::Human };
    let paint = if args.out.is_some() { Paint::Plain } else { streams.paint };
    let mut emit = EmitOptions::new(format);
    (emit.expand, emit.paint) = (args.expand, paint);
    let job = LayoutJob {
        args,
        options: read::options(&args.read)
            .with_naga(args.naga || format == Format::Json)
            .with_structure(args.only.structure.clone()),
        emit,
        style: streams.style(form),
    };
    let mut writer = Writer::new(args, &job.emit, job.style, streams);
    work::ordered(
        Inputs::new(args.files.clone()),
        args.jobs,
        |input| job.one(input),
        |done| writer.take(&done).map(|()| done),
    )?;
    writer.finish()
}

/// Whether a finding ends the parsing of a shader.
pub fn is_syntax(found: &Diagnostic) -> bool {
    found.code.ends_parsing()
}

/// Whether a block or its instance has this name.
pub fn is_named(block: &BlockLayout, name: &str) -> bool {
    *block.name == *name || block.instance.as_deref() == Some(name)
}

/// Removes the error that a shader does not declare the structure that is laid out.
pub fn take_absent(shader: &mut ShaderLayout, options: &Options) -> Option<Diagnostic> {
    options.read.structure.as_ref()?;
    let at = shader.diagnostics.iter().position(|found| found.code == Code::UnknownBlock)?;
    Some(Diagnostic { path: Some(shader.path.clone()), ..shader.diagnostics.remove(at) })
}

/// The settings shared by all shaders of a run.
struct LayoutJob<'a> {
    args: &'a LayoutArgs,
    options: Options,
    emit: EmitOptions,
    style: FindingStyle,
}

/// The result for one shader.
struct Done {
    path: PathBuf,
    /// The output path below `--out`.
    relative: PathBuf,
    /// The formatted layouts; `None` if there is nothing to write.
    product: Option<String>,
    /// The formatted findings.
    findings: String,
    failed: bool,
    /// Names of blocks excluded by `--block`.
    others: Vec<String>,
    /// The error that a shader does not declare the structure of `--struct`.
    absent: Option<Diagnostic>,
    /// The shader and its includes, if a file is written.
    files: Files,
}

impl work::Weighed for Done {
    fn bytes(&self) -> usize {
        self.findings.len() + self.product.as_ref().map_or(0, String::len)
    }
}

impl LayoutJob<'_> {
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
        caught(&path.display().to_string(), work).unwrap_or_else(|found| self.failed(path, found))
    }

    fn failed(&self, path: PathBuf, found: Diagnostic) -> Done {
        Done {
            path,
            relative: PathBuf::new(),
            product: None,
            findings: self.style.text(&[found], &Files::default()),
            failed: true,
            others: vec![],
            absent: None,
            files: Files::default(),
        }
    }

    fn laid_out(&self, input: Input, mut shader: ShaderLayout) -> Done {
        without_effect::record_of(&shader);
        let mut others = Vec::new();
        if let Some(name) = &self.args.block {
            let (kept, left) = shader.blocks.into_iter().partition(|b| is_named(b, name));
            shader.blocks = kept;
            let left: Vec<BlockLayout> = left;
            others.extend(left.iter().map(|block| block.name.to_string()));
        }
        let absent = take_absent(&mut shader, &self.options);
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
            absent,
            files: if self.args.out.is_some() { shader.files } else { Files::default() },
        }
    }

    /// Whether there is output for a shader.
    fn writes(&self, shader: &ShaderLayout, failed: bool) -> bool {
        // A file contains all blocks or is not written; stdout also takes some of the blocks.
        if failed && (self.args.out.is_some() || shader.diagnostics.iter().any(is_syntax)) {
            return false;
        }
        let is_part = self.args.block.is_some() || self.args.only.structure.is_some();
        let lists_all = self.emit.format.is_data() && !is_part;
        lists_all || !shader.blocks.is_empty()
    }
}
