//! Warnings about options and configuration without effect: constants and macros that no shader
//! has, patterns that exclude nothing, include directories that are none, and options of another
//! language, backend or mode.

mod unused;

use std::path::PathBuf;

use landfall_check::config::Config;
use landfall_check::given_names::{GivenNames, NameKind, NamedOption};
use landfall_layout::diagnostic::Code;
#[cfg(feature = "exec")]
use landfall_layout::source::Files;
use landfall_layout::{Diagnostic, Error, Severity, ShaderLayout};

use crate::args::{Command, ReadArgs, RulesArgs, TextArgs};
use crate::output::Streams;

/// The names given to this command.
pub static NAMES: GivenNames = GivenNames::new();

/// Records the names given to a command, and warns about its options without effect.
pub fn begin(command: &Command, streams: &Streams) {
    // What an option cannot affect is known from the options alone; whether a name is used only
    // after reading.
    unused::warn_of_options(command, streams);
    let Some((text, defines, rules)) = text_of(command) else { return };
    let option = if matches!(command, Command::Check(_)) { "--define" } else { "-D" };
    let given = |kind, name: &String, option| NamedOption {
        kind,
        name: name.clone(),
        option: format!("{option} {name}"),
    };
    let constants = text.overrides.iter().map(|(name, _)| given(NameKind::Constant, name, "-O"));
    let macros = defines.iter().map(|(name, _)| given(NameKind::Macro, name, option));
    // What cannot be decided yet is recorded, and told at the end.
    let mut all: Vec<NamedOption> = constants.chain(macros).collect();
    if let Some(option) = unused::mediump(command) {
        all.push(NamedOption { kind: NameKind::Precision, name: String::new(), option });
    }
    if let Some(stage) = text.stage {
        let language = text.language.map(|language| language.language().name());
        let name = language.unwrap_or_default().to_string();
        all.push(NamedOption {
            kind: NameKind::Stage,
            name,
            option: format!("--stage {}", stage.name()),
        });
    }
    if rules.gather {
        all.push(NamedOption {
            kind: NameKind::Gather,
            name: String::new(),
            option: "--gather".to_string(),
        });
    }
    NAMES.give(all);
    // A directory that does not exist is told now: shaders without includes would hide it.
    include_dirs(&text.include_dirs, "`-I DIR` names a directory", streams);
}

/// Warns about patterns that exclude nothing; `whole` if all shaders were searched.
pub fn warn_of_patterns(config: &Config, whole: bool, streams: &Streams) {
    let options = config.unused_patterns(whole).into_iter();
    options.for_each(|option| warn_option(option, "no shader matches it", streams));
}

/// Warns about rows of the configuration for files that a check of all shaders did not read.
pub fn warn_of_rows(config: &Config, read: impl FnOnce() -> Vec<PathBuf>, streams: &Streams) {
    let options = config.unused_rows(read).into_iter();
    options.for_each(|option| warn_option(option, "no file that was read matches it", streams));
}

pub fn warn_option(option: String, why: &str, streams: &Streams) {
    let error = Error::new(option, format!("has no effect: {why}"));
    warn(Code::UnusedOption, error, streams);
}

/// Warns about include directories that are none.
pub fn include_dirs(folders: &[PathBuf], help: &str, streams: &Streams) {
    for folder in folders.iter().filter(|folder| !folder.is_dir()) {
        let what = match folder.exists() {
            true => "is not a directory; no include is searched there",
            false => "does not exist; no include is searched there",
        };
        let error = Error::new(folder.display().to_string(), what);
        warn(Code::NoIncludeDir, error.with_help(help), streams);
    }
}

/// Records the names of a shader's text.
#[cfg(feature = "exec")]
pub fn record(files: &Files) {
    NAMES.found(&NAMES.in_files(files.iter()));
}

pub fn record_of(shader: &ShaderLayout) {
    NAMES.found(&NAMES.in_shader(shader));
}

/// Warns about the names given that no shader has.
pub fn finish(streams: &Streams) {
    NAMES.unused().into_iter().for_each(|found| streams.finding(found));
}

fn warn(code: Code, error: Error, streams: &Streams) {
    streams.finding(Diagnostic { code, severity: Severity::Warning, ..error.into() });
}

/// The options of a command for reading shaders, its macros, and the layout that it asks for.
type ReadingOptions<'c> = (&'c TextArgs, &'c [(String, String)], &'c RulesArgs);

fn text_of(command: &Command) -> Option<ReadingOptions<'_>> {
    let read: &ReadArgs = match command {
        Command::Layout(args) => &args.read,
        Command::Explain(args) => &args.read,
        Command::Report(args) => &args.read,
        Command::Emit(args) => &args.read,
        #[cfg(feature = "port")]
        Command::Port(args) => &args.read,
        Command::Encode(args) => &args.read,
        Command::Decode(args) => &args.read,
        #[cfg(feature = "exec")]
        Command::Verify(args) => &args.read,
        #[cfg(feature = "exec")]
        Command::Run(args) => &args.read,
        #[cfg(feature = "exec")]
        Command::Stress(args) => &args.read,
        #[cfg(feature = "exec")]
        Command::Prove(args) => &args.read,
        #[cfg(feature = "exec")]
        Command::Render(args) => &args.read,
        #[cfg(feature = "exec")]
        Command::Bench(args) => &args.read,
        #[cfg(not(feature = "exec"))]
        Command::Verify(_)
        | Command::Run(_)
        | Command::Stress(_)
        | Command::Prove(_)
        | Command::Render(_)
        | Command::Bench(_) => return None,
        #[cfg(feature = "analysis")]
        Command::Lights(args) => &args.read,
        #[cfg(not(feature = "analysis"))]
        Command::Lights(_) => return None,
        Command::Lock(args) => &args.read,
        Command::Diff(args) => &args.read,
        Command::Check(args) => return Some((&args.text, &args.levels.defines, &args.rules)),
        Command::Completions(_)
        | Command::Devices(_)
        | Command::Init(_)
        | Command::Lsp(_)
        | Command::Man(_)
        | Command::Rule(_)
        | Command::Schema(_)
        | Command::Serve(_) => return None,
        #[cfg(not(feature = "port"))]
        Command::Port(_) => return None,
        #[cfg(any(feature = "gl", feature = "gpu"))]
        Command::Reader(_) => return None,
    };
    Some((&read.text, &read.defines, &read.rules))
}
