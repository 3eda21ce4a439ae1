//! `landfall layout`: prints the layout of every block of every shader.

mod writer;

use landfall_layout::diagnostic::Code;
use std::path::PathBuf;

use landfall_layout::format as emit;
use landfall_layout::format::{EmitOptions, Format, Paint};
use landfall_layout::source::Files;
use landfall_layout::{
    BlockLayout, Diagnostic, Error, Options, Severity, ShaderLayout, Source, Variant,
};
use landfall_lint::Settings;

use crate::args::LayoutArgs;
use crate::output::{CommandFailure, FindingForm, FindingStyle, Outcome, Streams};
use crate::{config, read, templates, watch, without_effect};
use landfall_check::caught::caught;
use landfall_check::inputs::{Input, Inputs};
use landfall_check::templates::Templates;
use landfall_ir::threads;
use writer::Writer;

pub fn run(args: &LayoutArgs, streams: &Streams) -> Result<Outcome, CommandFailure> {
    if args.naga && !cfg!(feature = "naga") {
        let error = Error::new("--naga", "is not in this build: it needs the feature `analysis`");
        return Err(error.with_help("cargo install landfall --features analysis").into());
    }
    let config = config::load(&args.config, &args.files, streams)?;
    let format = args.format.form();
    let form = FindingForm::json_if(format == Format::Json);
    let paint = if args.out.is_some() { Paint::Plain } else { streams.paint };
    let mut emit = EmitOptions::new(format);
    (emit.expand, emit.paint) = (args.expand, paint);
    let job = LayoutJob {
        args,
        settings: &config.settings,
        options: read::options(&args.read)
            .with_naga(args.naga || format == Format::Json)
            .with_structure(args.only.structure.clone()),
        emit,
        style: streams.style(form),
        templates: Templates::default(),
    };
    let mut writer = Writer::new(args, &job.emit, job.style, streams);
    // Laid out by several threads, written in the order of the inputs.
    threads::ordered(
        Inputs::new(args.files.clone(), watch::stop()),
        args.jobs,
        |input| job.one(input),
        |done| writer.take(&done).map(|()| done),
    )?;
    Ok(writer.finish(&job.templates)?)
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
    // One structure may be asked of many shaders: those without it are passed over.
    options.read.structure.as_ref()?;
    let at = shader.diagnostics.iter().position(|found| found.code == Code::UnknownBlock)?;
    Some(Diagnostic { path: Some(shader.path.clone()), ..shader.diagnostics.remove(at) })
}

/// The errors of a variant, each with its macros.
pub fn in_variant(layout: &ShaderLayout, variant: &Variant) -> Vec<Diagnostic> {
    let errors = layout.diagnostics.iter().filter(|found| {
        // The structure of `--struct` may be one of other variants.
        found.severity == Severity::Error && found.code != Code::UnknownBlock
    });
    let note = format!("with `{}`", variant.name());
    errors.map(|error| error.clone().with_note(&note)).collect()
}

/// The settings shared by all shaders of a run.
struct LayoutJob<'a> {
    args: &'a LayoutArgs,
    settings: &'a Settings,
    options: Options,
    emit: EmitOptions,
    style: FindingStyle,
    templates: Templates,
}

/// The result for one shader.
#[derive(Default)]
struct Done {
    path: PathBuf,
    /// Whether it is a template that a search found.
    is_template: bool,
    /// The output path below `--out`.
    relative: PathBuf,
    /// The formatted layouts; `None` if there is nothing to write.
    product: Option<String>,
    /// The includes that are not found, formatted.
    missing: Vec<(String, Diagnostic)>,
    /// The other findings, formatted.
    findings: String,
    failed: bool,
    /// Names of blocks excluded by `--block`.
    others: Vec<String>,
    /// The error that a shader does not declare the structure of `--struct`.
    absent: Option<Diagnostic>,
    /// The shader and its includes, if a file is written.
    files: Files,
}

impl Done {
    /// The result for a template.
    fn nothing(input: Input) -> Done {
        Done { path: input.path, is_template: true, ..Done::default() }
    }
}

impl threads::Weighed for Done {
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
        let source = match templates::source(&self.templates, &input, &self.args.read) {
            Ok(Some(source)) => source,
            Ok(None) => return Done::nothing(input),
            Err(error) => return self.failed(input.path, error.into()),
        };
        let path = input.path.clone();
        let work = || self.laid_out(input, &source);
        // A panic on one shader is a finding of that one.
        caught(&path.display().to_string(), work).unwrap_or_else(|found| self.failed(path, found))
    }

    fn failed(&self, path: PathBuf, found: Diagnostic) -> Done {
        Done { path, findings: self.style.one(found), failed: true, ..Done::default() }
    }

    fn laid_out(&self, input: Input, source: &Source) -> Done {
        let mut shader = self.settings.layout(source, &self.options);
        without_effect::record_of(&shader);
        let absent = take_absent(&mut shader, &self.options);
        // Missing includes are reported once for all shaders.
        let (missing, others): (Vec<Diagnostic>, Vec<Diagnostic>) =
            shader.diagnostics.iter().cloned().partition(|d| d.code == Code::MissingInclude);
        let text =
            |one: Diagnostic| (self.style.text(std::slice::from_ref(&one), &shader.files), one);
        let missing = missing.into_iter().map(text).collect();
        let mut findings = self.style.text(&others, &shader.files);
        let mut failed = shader.has_errors();
        for (variant, layout) in shader.failed_variants() {
            let errors: Vec<Diagnostic> = in_variant(layout, variant);
            findings.push_str(&self.style.text(&errors, &layout.files));
            failed = true;
        }
        let mut left_out = Vec::new();
        let files = if self.args.out.is_some() { shader.files.clone() } else { Files::default() };
        let mut parts = self.settings.divided(source, shader);
        for part in &mut parts {
            if let Some(name) = &self.args.block {
                let blocks = std::mem::take(&mut part.blocks).into_iter();
                let (kept, left) = blocks.partition(|b| is_named(b, name));
                part.blocks = kept;
                let left: Vec<BlockLayout> = left;
                left_out.extend(left.iter().map(|block| block.name.to_string()));
            }
            let refused = emit::refused(part, &self.emit);
            failed |= refused.iter().any(|found| found.severity == Severity::Error);
            findings.push_str(&self.style.text(&refused, &part.files));
        }
        // Parts of a file that have no blocks are not printed beside others that have.
        parts.retain(|part| part.condition.is_none() || !part.blocks.is_empty());
        if parts.len() > 1 {
            parts.retain(|part| !part.blocks.is_empty());
        }
        let writes = parts.iter().any(|part| self.writes(part, failed));
        Done {
            product: writes.then(|| match self.args.out {
                Some(_) => emit::documents(&parts, &self.emit),
                None => emit::shaders(&parts, &self.emit),
            }),
            missing,
            findings,
            is_template: false,
            path: input.path,
            relative: input.relative,
            failed,
            others: left_out,
            absent,
            files,
        }
    }

    /// Whether there is output for a shader.
    fn writes(&self, shader: &ShaderLayout, failed: bool) -> bool {
        // A file contains all blocks or is not written; stdout also takes some of the blocks.
        // A syntax error may have hidden members.
        if failed && (self.args.out.is_some() || shader.diagnostics.iter().any(is_syntax)) {
            return false;
        }
        let is_part = self.args.block.is_some() || self.args.only.structure.is_some();
        let lists_all = self.emit.format.is_data() && !is_part;
        lists_all || !shader.blocks.is_empty()
    }
}
