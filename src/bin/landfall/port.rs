//! `landfall port`: rewrites legacy GLSL for Vulkan, naga or WGSL.

use std::fmt::Write as _;

use landfall_layout::diagnostic::Code;
use landfall_layout::port::{Dialect, PortOptions, Ported, port};
use landfall_layout::shape::DEFAULT_BLOCK;
use landfall_layout::source::Files;
use landfall_layout::{Diagnostic, Severity, Source};

use crate::args::{PortArgs, PortTo};
use crate::output::{Failure, FindingForm, Outcome, Streams};
use crate::shader::finding;
use crate::{given, read, write};

pub fn run(args: &PortArgs, streams: &Streams) -> Result<Outcome, Failure> {
    let report = |found: &[Diagnostic], files: &Files| {
        streams.report(&streams.style(FindingForm::Human).text(found, files));
    };
    let partner = args.partner.as_ref().map(|path| read::source(path, &args.read)).transpose();
    let sources = read::source(&args.file, &args.read).and_then(|s| Ok((s, partner?)));
    let (source, partner) = match sources {
        Ok(sources) => sources,
        Err(error) => {
            report(&[error.into()], &Files::default());
            return Ok(Outcome::CouldNot);
        }
    };
    let mut options = PortOptions::default();
    options.dialect = match args.to {
        PortTo::Vulkan => Dialect::Vulkan,
        PortTo::Naga => Dialect::Naga,
        PortTo::Wgsl => Dialect::Wgsl,
    };
    options.read = read::options(&args.read).read;
    options.block = args.block.clone();
    options.set = args.set;
    options.first_binding = args.first_binding;
    options.partner = partner;
    options.locations = args.locations.clone();
    given::record(&landfall_layout::layout(&source, &read::options(&args.read)).files);
    let ported = match port(&source, &options) {
        Ok(ported) => ported,
        Err(found) => {
            report(&found, &files_of(&source));
            return Ok(Outcome::CouldNot);
        }
    };
    match &args.out {
        Some(out) => {
            let files = landfall_layout::layout(&source, &read::options(&args.read)).files;
            let named = std::iter::once(args.file.as_path()).chain(args.partner.as_deref());
            write::protecting(named, [&files]).write(out, ported.source.text.as_bytes())?;
        }
        None => streams.source(&ported.source.text)?,
    }
    if !ported.warnings.is_empty() {
        report(&ported.warnings, &files_of(&source));
    }
    streams.notes(&notes(&ported));
    if ported.block.is_none() && args.block != DEFAULT_BLOCK {
        let option = format!("--block {}", args.block);
        given::without_effect(option, "no uniform is outside blocks", streams);
    }
    for (name, _) in &args.locations {
        if !ported.locations.iter().any(|location| location.name == *name) {
            let message = format!("`--location {name}` has no effect: nothing has this name");
            let help = "name an input or output of the stage".to_string();
            let found = finding(&source.path, Code::UnknownName, message, Some(help));
            report(&[Diagnostic { severity: Severity::Warning, ..found }], &Files::default());
        }
    }
    Ok(Outcome::Clean)
}

/// The source files of findings in a shader read on its own.
fn files_of(source: &Source) -> Files {
    let mut files = Files::default();
    files.add(source.path.clone(), source.text.clone());
    files
}

/// The changes that the program using the shader must follow, one per line.
fn notes(ported: &Ported) -> String {
    let mut text = String::new();
    for binding in &ported.bindings {
        let _ = writeln!(text, "set {} binding {}: {}", binding.set, binding.binding, binding.name);
    }
    for location in &ported.locations {
        let way = location.direction.name();
        let _ = writeln!(text, "location {} {way}: {}", location.location, location.name);
    }
    for value in &ported.values {
        let _ = writeln!(text, "upload: {} = {}", value.name, value.value);
    }
    for (old, new) in &ported.renamed {
        let _ = writeln!(text, "renamed: {old} to {new}");
    }
    text
}
