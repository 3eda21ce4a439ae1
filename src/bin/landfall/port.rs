//! `landfall port`: rewrites legacy GLSL for Vulkan, naga or WGSL.

mod compiler;

use std::fmt::Write as _;

use landfall_layout::diagnostic::Code;
use landfall_layout::shape::DEFAULT_BLOCK;
use landfall_layout::source::{Files, Span};
use landfall_layout::{Diagnostic, Severity, Source};
use landfall_port::{Dialect, PortOptions, Ported, port};

use crate::args::{PortArgs, PortTo, ReadArgs};
use compiler::Verdict;

use crate::output::{CommandFailure, FindingForm, Outcome, Streams};
use crate::shader::{self, finding};
use crate::{read, without_effect, write};

pub fn run(args: &PortArgs, streams: &Streams) -> Result<Outcome, CommandFailure> {
    let style = streams.style(FindingForm::Human);
    // `--stage` is that of the shader alone; the partner's stage follows from its name.
    let mut beside = ReadArgs::clone(&args.read);
    beside.text.stage = None;
    let partner = args.partner.as_ref().map(|path| read::shader_text(path, &beside)).transpose();
    let sources = read::shader_text(&args.file, &args.read).and_then(|s| Ok((s, partner?)));
    let (source, partner) = sources.map_err(|error| style.refused(error.into()))?;
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
    shader::record(&source, &read::options(&args.read), streams, style);
    let ported =
        port(&source, &options).map_err(|found| style.failure(&found, &files_of(&source)))?;
    // glslangValidator does not read WGSL.
    let mut warnings = ported.warnings.clone();
    if !args.no_compiler && args.to != PortTo::Wgsl {
        match compiler::verdict(&source, &ported, args) {
            // Without the compiler the result is given as it is; the option `--no-compiler` does
            // the same.
            Verdict::Accepted | Verdict::NotCompiled => {}
            Verdict::Refused { message, line } => {
                let found = refused(&source, &message, line);
                return Err(style.failure(&[found], &files_of(&source)));
            }
            Verdict::Late => {
                let late = format!("it runs past its limit of {} s", args.limit.as_secs_f64());
                warnings.push(
                    unknown(&late).with_help("raise it with `--limit`, or pass `--no-compiler`"),
                );
            }
            Verdict::Failed(reason) => warnings.push(unknown(&reason)),
        }
    }
    match &args.out {
        Some(out) => {
            let files = landfall_layout::layout(&source, &read::options(&args.read)).files;
            // Neither the shader, its partner nor an include is overwritten by the result.
            let named = std::iter::once(args.file.as_path()).chain(args.partner.as_deref());
            let writer = write::protecting(named, [&files]);
            write::to(out, ported.source.text.as_bytes(), &writer, streams)?;
        }
        None => streams.source(&ported.source.text)?,
    }
    streams.report(&style.text(&warnings, &files_of(&source)));
    streams.notes(&notes(&ported, args));
    if ported.block.is_none() && ported.shared.is_none() && args.block != DEFAULT_BLOCK {
        let option = format!("--block {}", args.block);
        without_effect::warn_option(option, "no uniform is outside blocks", streams);
    }
    for (name, _) in &args.locations {
        if !ported.locations.iter().any(|location| location.name == *name) {
            let message = format!("`--location {name}` has no effect: nothing has this name");
            let help = "name an input or output of the stage".to_string();
            let found = finding(&source.path, Code::UnknownName, message, Some(help));
            streams.finding(Diagnostic { severity: Severity::Warning, ..found });
        }
    }
    Ok(Outcome::Clean)
}

/// The warning of a compiler without a verdict.
fn unknown(reason: &str) -> Diagnostic {
    let name = compiler::NAME;
    let message = format!("{name} cannot tell whether the result compiles: {reason}");
    Diagnostic::warning(Code::NotPortable, Span::default(), message)
}

/// The error for a result that the compiler refuses, at the line of the original.
fn refused(source: &Source, message: &str, line: Option<u32>) -> Diagnostic {
    let starts = source.text.match_indices('\n').map(|(at, _)| at + 1);
    // The lines of the compiler count from 1, as in `#line`.
    let start = line.and_then(|line| std::iter::once(0).chain(starts).nth(line as usize - 1));
    let span = start.map_or(Span::default(), |start| {
        let text = source.text[start..].lines().next().unwrap_or("");
        let indent = text.len() - text.trim_start().len();
        let end = start + text.trim_end().len();
        Span { file: 0, start: (start + indent).min(end) as u32, end: end as u32 }
    });
    let message = format!("{} refuses the ported shader: {message}", compiler::NAME);
    Diagnostic::error(Code::NotPortable, span, message)
        .with_help("mend the shader, or pass `--no-compiler` to write the result as it is")
}

/// The source files of findings in a shader read on its own.
fn files_of(source: &Source) -> Files {
    let mut files = Files::default();
    files.add(source.path.clone(), source.text.clone());
    files
}

/// The changes that the program using the shader must follow, one per line.
fn notes(ported: &Ported, args: &PortArgs) -> String {
    let mut text = String::new();
    if let (Some(shared), Some(partner)) = (&ported.shared, &args.partner) {
        let _ = writeln!(text, "shared with {}: {shared}", partner.display());
    }
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
    for (old, new) in ported.renamed.iter().chain(&ported.functions) {
        let _ = writeln!(text, "renamed: {old} to {new}");
    }
    text
}
