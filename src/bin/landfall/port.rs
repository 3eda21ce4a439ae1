//! `landfall port`: legacy GLSL to Vulkan's, its loose uniforms in one block.

use std::fmt::Write as _;

use landfall_layout::port::{Dialect, PortOptions, Ported, port};
use landfall_layout::source::Files;
use landfall_layout::{Diagnostic, Source};

use crate::args::{PortArgs, PortTo};
use crate::output::{Failure, FindingForm, Outcome, Streams};
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
    let options = PortOptions {
        dialect: match args.to {
            PortTo::Vulkan => Dialect::Vulkan,
            PortTo::Naga => Dialect::Naga,
            PortTo::Wgsl => Dialect::Wgsl,
        },
        read: read::options(&args.read).read,
        block: args.block.clone(),
        set: args.set,
        first_binding: args.first_binding,
        partner,
        locations: args.locations.clone(),
    };
    given::saw(&landfall_layout::layout(&source, &read::options(&args.read)).files);
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
    streams.notes(&notes(&ported));
    Ok(Outcome::Clean)
}

/// The places of findings about a text that was read on its own.
fn files_of(source: &Source) -> Files {
    let mut files = Files::default();
    files.add(source.path.clone(), source.text.clone());
    files
}

/// What the program that used the original has to know, a line each.
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
        let _ = writeln!(text, "to be uploaded now: {} = {}", value.name, value.value);
    }
    for (old, new) in &ported.renamed {
        let _ = writeln!(text, "renamed: {old} is {new}");
    }
    text
}
