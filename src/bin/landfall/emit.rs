//! `landfall emit`: generates mirrors of blocks and tables of offsets.

use landfall_layout::diagnostic::Code;
use std::fs;
use std::path::{Path, PathBuf};

use landfall_layout::codegen::CodeOptions;
use landfall_layout::codegen::rust::{Modules, Tables, Vectors, Visibility};
use landfall_layout::source::Files;
use landfall_layout::{Diagnostic, Error, Severity};

use crate::args::EmitArgs;
use crate::config::Config;
use crate::inputs::Inputs;
use crate::output::{Failure, FindingForm, Outcome, Streams};
use crate::{config, given, read, watch, write};

pub fn run(args: &EmitArgs, streams: &Streams) -> Result<Outcome, Failure> {
    let report = |found: &[Diagnostic], files: &Files| {
        streams.report(&streams.style(FindingForm::Human).text(found, files));
    };
    let Some(config) = config::load(&args.config, &args.files, streams)? else {
        return Ok(Outcome::CouldNot);
    };
    let mut shaders = Vec::new();
    let mut failed = false;
    for input in Inputs::new(args.files.clone()) {
        let source = input.and_then(|input| read::source(&input.path, &args.read));
        match source {
            Ok(source) => {
                let shader = landfall_layout::layout(&source, &read::options(&args.read));
                given::record_of(&shader);
                report(&shader.diagnostics, &shader.files);
                failed |= shader.has_errors();
                shaders.push(shader);
            }
            Err(error) => {
                report(&[error.into()], &Files::default());
                failed = true;
            }
        }
    }
    // The existing file stays unchanged.
    if watch::is_stopped() {
        return Ok(Outcome::Interrupted);
    }
    if failed {
        return Ok(Outcome::CouldNot);
    }
    if shaders.iter().all(|shader| shader.blocks.is_empty()) {
        let what =
            Diagnostic::without_place(Code::NoBlocks, Severity::Warning, "no blocks to mirror");
        report(&[what], &Files::default());
    }
    let options = options(args, config);
    let output = args.lang.generate(&shaders.iter().collect::<Vec<_>>(), &options);
    let (text, refused) = (output.text, output.diagnostics);
    for found in &refused {
        let shader = shaders.iter().find(|shader| found.path.as_ref() == Some(&shader.path));
        report(std::slice::from_ref(found), shader.map_or(&Files::default(), |s| &s.files));
        failed |= found.severity == Severity::Error;
    }
    if refused.iter().any(|found| found.code == Code::BadName) {
        return Ok(Outcome::CouldNot);
    }
    let outcome = match (&args.out, args.check) {
        (Some(out), true) => check(out, &text, streams),
        (Some(out), false) => {
            let named = args.files.iter().map(PathBuf::as_path);
            write::protecting(named, shaders.iter().map(|s| &s.files)).write(out, &text)?;
            Outcome::Clean
        }
        (None, _) => {
            streams.source(&text)?;
            Outcome::Clean
        }
    };
    Ok(if failed { Outcome::CouldNot } else { outcome })
}

/// The options of the generated code.
fn options(args: &EmitArgs, config: Config) -> CodeOptions {
    let mut options = CodeOptions::default();
    let rust = &mut options.rust;
    rust.vectors = args.vectors.as_deref().and_then(Vectors::from_name).unwrap_or_default();
    rust.modules = args.modules.as_deref().and_then(Modules::from_name).unwrap_or_default();
    rust.rename = args.rename.clone();
    rust.project_renames = config.rename;
    rust.types = args.types.clone();
    rust.project_types = config.types;
    rust.derives = args.derives.clone();
    if args.crate_visible {
        rust.visibility = Visibility::Crate;
    }
    if args.no_tables {
        rust.tables = Tables::Without;
    }
    let file = args.out.as_deref().and_then(Path::file_name).unwrap_or_default();
    options.file = file.to_string_lossy().into_owned();
    options.prefix = args.prefix.clone();
    options
}

/// Compares the existing file with the generated one.
fn check(out: &Path, text: &str, streams: &Streams) -> Outcome {
    let stale = match fs::read_to_string(out) {
        Ok(there) if there == text => return Outcome::Clean,
        Ok(_) => "is out of date",
        Err(_) => "does not exist",
    };
    let error = Error::new(out.display().to_string(), stale)
        .with_help("run the same command without `--check`");
    let found = Diagnostic { code: Code::StaleOutput, ..error.into() };
    streams.report(&streams.style(FindingForm::Human).text(&[found], &Files::default()));
    Outcome::Findings
}
