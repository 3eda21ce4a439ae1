//! `landfall emit`: generates mirrors of blocks and tables of offsets.

use landfall_layout::diagnostic::Code;
use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};

use landfall_codegen::c::CVectors;
use landfall_codegen::languages::{C, LANGUAGES, RUST};
use landfall_codegen::rust::{Api, Modules, RustOptions, Sources, Tables, Vectors, Visibility};
use landfall_codegen::{CodeOptions, OutputLanguage};
use landfall_layout::source::Files;
use landfall_layout::{Diagnostic, Error, Severity, ShaderLayout};

use crate::args::EmitArgs;
use crate::layout::{in_variant, take_absent};
use crate::output::{CommandFailure, FindingForm, Outcome, Streams};
use crate::{config, read, templates, watch, without_effect, write};
use landfall_check::asserted::AssertionText;
use landfall_check::basis::{Basis, CheckScope};
use landfall_check::config::{Config, absolute, relative_path};
use landfall_check::inputs::{Input, Inputs};
use landfall_check::templates::Templates;
use landfall_check::texts::Texts;
use landfall_check::walk::slashes;
use landfall_layout::file::Written;
use landfall_layout::format::phrases::counted;
use landfall_lint::render::{ReportFormat, ReportOptions, report};

pub fn run(args: &EmitArgs, streams: &Streams) -> Result<Outcome, CommandFailure> {
    if args.list {
        streams.source(&list())?;
        return Ok(Outcome::Clean);
    }
    let Some(lang) = args.lang else { return configured(args, streams) };
    if args.check && args.out.is_none() {
        return Err(Error::new("--check", "compares nothing without `--out FILE`").into());
    }
    let report = |found: &[Diagnostic], files: &Files| {
        streams.report(&streams.style(FindingForm::Human).text(found, files));
    };
    let config = config::load(&args.config, &args.files, streams)?;
    let of_project = lang == RUST && !config.bindings.apis.is_empty();
    let has_bindings = of_project || !args.bindings.is_empty();
    let mut shaders = Vec::new();
    let (templates, mut is_any) = (Templates::default(), false);
    let mut absent = None;
    let mut failed = false;
    for input in Inputs::new(args.files.clone(), watch::stop())
        .filter(|input| config.takes(input, &args.files))
    {
        let read = |input: Input| match has_bindings {
            true => templates::shader_text(&templates, &input, &args.read),
            false => templates::source(&templates, &input, &args.read),
        };
        let source = input.and_then(read);
        let Some(source) = source.transpose() else { continue };
        is_any = true;
        match source {
            Ok(source) => {
                let options = read::options(&args.read)
                    .with_interface(has_bindings)
                    .with_structure(args.structure.clone());
                let mut shader = config.settings.layout(&source, &options);
                without_effect::record_of(&shader);
                let missing = take_absent(&mut shader, &options);
                report(&shader.diagnostics, &shader.files);
                for (variant, layout) in shader.failed_variants() {
                    report(&in_variant(layout, variant), &layout.files);
                    failed = true;
                }
                failed |= shader.has_errors();
                match missing {
                    Some(missing) => absent = absent.or(Some(missing)),
                    None => shaders.extend(config.settings.distinct_variants(&source, &shader)),
                }
            }
            Err(error) => {
                streams.finding(error.into());
                failed = true;
            }
        }
    }
    failed |= templates::report(&templates, !is_any, streams.style(FindingForm::Human), streams);
    if let (Some(absent), []) = (absent, shaders.as_slice()) {
        streams.finding(absent);
        failed = true;
    }
    // The existing file stays unchanged.
    if watch::is_stopped() {
        return Ok(Outcome::Interrupted);
    }
    if failed {
        return Ok(Outcome::CouldNot);
    }
    let whole: Vec<&ShaderLayout> = shaders.iter().collect();
    let mut options = options(args, lang, &config)?;
    bindings(args, &config, &whole, &mut options.rust);
    let output = match args.assertions.as_slice() {
        [] => lang.generate(&whole, &options),
        _ => lang.assertions(&whole, &options),
    };
    let (text, refused) = (output.text, output.diagnostics);
    for found in &refused {
        let shader = shaders.iter().find(|shader| found.path.as_ref() == Some(&shader.path));
        report(std::slice::from_ref(found), shader.map_or(&Files::default(), |s| &s.files));
        failed |= found.severity == Severity::Error;
    }
    let is_useless =
        refused.iter().any(|found| matches!(found.code, Code::BadName | Code::NoBinding));
    if is_useless || failed && !args.assertions.is_empty() {
        return Ok(Outcome::CouldNot);
    }
    let outcome = match (&args.out, args.check) {
        (Some(out), true) => check(out, &text, streams),
        (Some(out), false) => {
            let named = args.files.iter().chain(&config.file).map(PathBuf::as_path);
            let writer = write::protecting(named, shaders.iter().map(|s| &s.files));
            write::to(out, &text, &writer, streams)?;
            Outcome::Clean
        }
        (None, _) => {
            streams.source(&text)?;
            Outcome::Clean
        }
    };
    Ok(if failed { Outcome::CouldNot } else { outcome })
}

/// The languages: each name with what is written.
fn list() -> String {
    let name = |language: &OutputLanguage| language.name.len();
    let width = LANGUAGES.iter().map(name).max().unwrap_or(0);
    LANGUAGES.iter().map(|one| format!("{:width$}  {}\n", one.name, one.about)).collect()
}

/// Writes the files of `[[assert]]`, or compares them.
fn configured(args: &EmitArgs, streams: &Streams) -> Result<Outcome, CommandFailure> {
    let config = config::load(&args.config, &[], streams)?;
    if config.assertions.is_empty() {
        let help = "name shaders and a language, `landfall emit shaders/*.frag --lang rust`, or list \
                    files in `[[assert]]` of landfall.toml";
        return Err(Error::new("landfall emit", "has nothing to write").with_help(help).into());
    }
    let options = config.options(&args.read.flags());
    let scope = CheckScope::new(&config, &[], None, None);
    let basis = Basis::new(scope, options, args.read.text.stage, None, config.settings.clone());
    let (mut written, mut unchanged, mut stale, mut failed) = (0, 0, false, false);
    // Each file is written or compared on its own, so that one faulty entry does not hide the
    // others.
    for file in &config.assertions {
        let AssertionText { text, files } = match file.text(&basis, &watch::stop()) {
            Ok(text) => text,
            Err(found) => {
                let texts = Texts::new(HashMap::new());
                let options = ReportOptions {
                    paint: streams.finding_paint,
                    text: &|path| texts.of(path),
                    shaders: found.len(),
                };
                streams.report(&(report(&found, ReportFormat::Human, &options) + "\n"));
                failed = true;
                continue;
            }
        };
        if args.check {
            stale |= check(&file.out, &text, streams) == Outcome::Findings;
            continue;
        }
        let mut writer = config.writer(file.out.parent().unwrap_or(Path::new("")), false);
        writer.protect(files.iter().chain(&config.file));
        match writer.write(&file.out, &text)? {
            Written::Changed => written += 1,
            Written::Unchanged => unchanged += 1,
        }
    }
    if !args.check {
        streams.notes(&format!("{} written, {unchanged} unchanged\n", counted(written, "file")));
    }
    Ok(match (failed, stale) {
        (true, _) => Outcome::CouldNot,
        (false, true) => Outcome::Findings,
        (false, false) => Outcome::Clean,
    })
}

fn options(args: &EmitArgs, lang: OutputLanguage, config: &Config) -> Result<CodeOptions, Error> {
    let mut options = CodeOptions::default();
    let rust = &mut options.rust;
    rust.modules = args.modules.as_deref().and_then(Modules::from_name).unwrap_or_default();
    rust.rename = args.rename.clone();
    rust.project_renames = config.rename.clone();
    rust.types = args.types.clone();
    rust.project_types = config.types.clone();
    rust.derives = config.derives.iter().chain(&args.derives).cloned().collect();
    if args.crate_visible {
        rust.visibility = Visibility::Crate;
    }
    if args.no_tables {
        rust.tables = Tables::Without;
    }
    let c = &mut options.c;
    c.namespace = args.namespace.clone();
    c.types = args.types.clone();
    c.project_types = config.c_types.clone();
    c.includes = args.include_header.clone();
    // A kind of vectors belongs to one language.
    if let Some(name) = &args.vectors {
        let unknown = |help| {
            let message = format!("has no vectors for {}", lang.title);
            Err(Error::new(format!("--vectors {name}"), message).with_help(help))
        };
        match (Vectors::from_name(name), CVectors::from_name(name)) {
            (Some(vectors), _) if lang == RUST => options.rust.vectors = vectors,
            (_, Some(vectors)) if lang == C => options.c.vectors = vectors,
            (None, _) if lang == RUST => return unknown("Rust has `glam` and `array`"),
            (_, None) if lang == C => return unknown("C has `glm` and `array`"),
            // A warning says that it has no effect.
            (_, _) => {}
        }
    }
    let file = args.out.as_deref().and_then(Path::file_name).unwrap_or_default();
    options.file = file.to_string_lossy().into_owned();
    options.prefix = args.prefix.clone();
    options.assertions.structures = args.assertions.clone();
    options.assertions.fields = args.fields.clone();
    options.assertions.field_prefix = args.field_prefix.clone();
    Ok(options)
}

/// Sets the options of the bindings: those of the configuration, and those of the command line.
fn bindings(
    args: &EmitArgs,
    config: &Config,
    shaders: &[&ShaderLayout],
    options: &mut RustOptions,
) {
    let bindings = &mut options.bindings;
    *bindings = config.bindings.clone();
    if !args.bindings.is_empty() {
        bindings.apis = args.bindings.iter().filter_map(|name| Api::from_name(name)).collect();
    }
    let files = |files: &str| files.split(',').map(str::to_string).collect();
    let programs = args.program.iter().map(|(name, text)| (name.clone(), files(text)));
    // A program or count of the command line replaces that of the same name in the configuration.
    bindings.programs.retain(|(name, _)| args.program.iter().all(|(other, _)| other != name));
    bindings.programs.extend(programs);
    bindings.counts.retain(|(name, _)| args.counts.iter().all(|(other, _)| other != name));
    bindings.counts.extend(args.counts.iter().cloned());
    bindings.dynamic_offsets.extend(args.dynamic_offset.iter().cloned());
    bindings.unfilterable.extend(args.unfilterable.iter().cloned());
    let named = args.program.iter().map(|(name, _)| name);
    let named = named.chain(args.counts.iter().map(|(name, _)| name));
    let named: Vec<&String> = named.chain(&args.dynamic_offset).chain(&args.unfilterable).collect();
    // Names of the project that no shader has are not warned about, unless they are given here.
    bindings.project_names.retain(|name| !named.contains(&name));
    let embedded = args.embed_sources || bindings.sources == Sources::Embedded;
    // Paths of `include_str!` are relative to the file.
    bindings.sources = Sources::Without;
    if let (true, Some(out)) = (embedded, &args.out) {
        bindings.sources = Sources::Embedded;
        let paths = shaders.iter().map(|shader| format!("{:?}", from_file(out, &shader.path)));
        bindings.paths = paths.collect();
    }
}

/// The path of a shader from the folder that a file is in, as `include_str!` takes it on every system.
fn from_file(file: &Path, shader: &str) -> String {
    let current = std::env::current_dir().unwrap_or_default();
    // Lexically, since neither file need exist.
    let [file, shader] = [file, Path::new(shader)].map(|path| absolute(&current, path));
    slashes(&relative_path(file.parent().unwrap_or(&file), &shader))
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
    streams.finding(Diagnostic { code: Code::StaleOutput, ..error.into() });
    Outcome::Findings
}
