//! Warnings about options without effect: `-I` with a path that is not a directory, `-O` for a
//! constant that no shader has, `--adapter` where nothing runs on the GPU, and options of `emit` for
//! another language.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::{Mutex, OnceLock, PoisonError};

use landfall_layout::diagnostic::Code;
use landfall_layout::source::Files;
use landfall_layout::{Diagnostic, Error, Severity};

#[cfg(feature = "exec")]
use crate::args::BackendName;
use crate::args::{Command, EmitArgs, EmitLang, TextArgs};
use crate::output::{FindingForm, Streams};

/// The names of `-O`, and those that some shader has a constant for.
struct OverrideNames {
    names: Vec<String>,
    matched: Mutex<Matched>,
}

#[derive(Default)]
struct Matched {
    names: BTreeSet<String>,
    any: bool,
}

/// The `-O` options of this process.
static GIVEN: OnceLock<OverrideNames> = OnceLock::new();

/// Records the `-O` options, and warns about `-I` paths that are not directories, an adapter that
/// nothing runs on, and options of `emit` for another language.
pub fn begin(command: &Command, streams: &Streams) {
    #[cfg(feature = "exec")]
    if let Some(name) = unused_adapter(command) {
        let error =
            Error::new(format!("--adapter {name}"), "has no effect without `--backend gpu`");
        warn(Code::UnusedOption, error, streams);
    }
    if let Command::Emit(args) = command {
        for option in unused_of_emit(args) {
            let error = Error::new(option, format!("has no effect on {}", args.lang.shown()));
            warn(Code::UnusedOption, error, streams);
        }
    }
    let Some(text) = text_of(command) else { return };
    let names = text.overrides.iter().map(|(name, _)| name.clone()).collect();
    let _ = GIVEN.set(OverrideNames { names, matched: Mutex::default() });
    include_dirs(&text.include_dirs, "`-I DIR` names a directory", streams);
}

/// The options of `emit` that are for the other language.
fn unused_of_emit(args: &EmitArgs) -> Vec<&'static str> {
    let given = match args.lang {
        EmitLang::Rust => vec![(!args.prefix.is_empty(), "--prefix")],
        EmitLang::C => vec![
            (args.vectors.is_some(), "--vectors"),
            (args.crate_visible, "--crate-visible"),
            (args.no_tables, "--no-tables"),
        ],
    };
    given.into_iter().filter(|(is, _)| *is).map(|(_, option)| option).collect()
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

/// The adapter named for a command that does not use the GPU.
#[cfg(feature = "exec")]
fn unused_adapter(command: &Command) -> Option<&str> {
    let gpu = BackendName::Gpu;
    let (adapter, is_used) = match command {
        Command::Verify(args) => {
            (&args.adapter, args.backends.is_empty() || args.backends.contains(&gpu))
        }
        Command::Bench(args) => {
            (&args.adapter, args.backend.is_empty() || args.backend.contains(&gpu))
        }
        Command::Run(args) => (&args.adapter, args.backend == gpu),
        Command::Stress(args) => (&args.adapter, args.backends.contains(&gpu)),
        Command::Render(args) => {
            let compares = args.compare.iter().any(|what| what.eq_ignore_ascii_case("gpu"));
            (&args.adapter, args.backend == gpu || compares)
        }
        _ => return None,
    };
    adapter.as_deref().filter(|_| !is_used)
}

/// The names of `-O` that a shader has constants for.
pub fn known(files: &Files) -> Vec<String> {
    let Some(given) = GIVEN.get().filter(|given| !given.names.is_empty()) else {
        return Vec::new();
    };
    let known = |name: &&String| files.iter().any(|file| has_constant(&file.text, name));
    given.names.iter().filter(known).cloned().collect()
}

/// Records the constants of a shader.
pub fn record(files: &Files) {
    record_names(&known(files));
}

/// Records the constants of a cached shader.
pub fn record_names(names: &[String]) {
    let Some(given) = GIVEN.get().filter(|given| !given.names.is_empty()) else { return };
    let mut matched = given.matched.lock().unwrap_or_else(PoisonError::into_inner);
    matched.any = true;
    matched.names.extend(names.iter().cloned());
}

/// Warns about `-O` options that no shader has a constant for.
pub fn finish(streams: &Streams) {
    let Some(given) = GIVEN.get() else { return };
    let matched = given.matched.lock().unwrap_or_else(PoisonError::into_inner);
    if !matched.any {
        return;
    }
    for name in given.names.iter().filter(|name| !matched.names.contains(*name)) {
        let error = Error::new(format!("-O {name}"), "has no effect: no shader has this constant");
        let help = "constants are those of `layout(constant_id = N)` in GLSL and `override` in \
                    WGSL, by name or number";
        warn(Code::UnknownOverride, error.with_help(help), streams);
    }
}

fn warn(code: Code, error: Error, streams: &Streams) {
    let found = Diagnostic { code, severity: Severity::Warning, ..error.into() };
    streams.report(&streams.style(FindingForm::Human).text(&[found], &Files::default()));
}

/// Whether a source may have a specialization constant or override of this name or number. A name
/// built by a macro is found by its number only.
fn has_constant(text: &str, name: &str) -> bool {
    let is_number = name.bytes().all(|b| b.is_ascii_digit());
    let marks: &[&str] =
        if is_number { &["constant_id", "@id"] } else { &["constant_id", "override"] };
    marks.iter().any(|mark| has_word(text, mark.trim_start_matches('@'))) && has_word(text, name)
}

/// Whether a text contains a whole word.
fn has_word(text: &str, word: &str) -> bool {
    let inside = |c: char| c == '_' || c.is_alphanumeric();
    text.match_indices(word).any(|(at, _)| {
        let (before, after) = (&text[..at], &text[at + word.len()..]);
        !before.ends_with(inside) && !after.starts_with(inside)
    })
}

/// The options of a command for reading shaders.
fn text_of(command: &Command) -> Option<&TextArgs> {
    Some(match command {
        Command::Layout(args) => &args.read.text,
        Command::Explain(args) => &args.read.text,
        Command::Emit(args) => &args.read.text,
        Command::Port(args) => &args.read.text,
        Command::Encode(args) => &args.read.text,
        Command::Decode(args) => &args.read.text,
        #[cfg(feature = "exec")]
        Command::Verify(args) => &args.read.text,
        #[cfg(feature = "exec")]
        Command::Run(args) => &args.read.text,
        #[cfg(feature = "exec")]
        Command::Stress(args) => &args.read.text,
        #[cfg(feature = "exec")]
        Command::Prove(args) => &args.read.text,
        #[cfg(feature = "exec")]
        Command::Render(args) => &args.read.text,
        #[cfg(feature = "exec")]
        Command::Bench(args) => &args.read.text,
        #[cfg(not(feature = "exec"))]
        Command::Verify(_)
        | Command::Run(_)
        | Command::Stress(_)
        | Command::Prove(_)
        | Command::Render(_)
        | Command::Bench(_) => return None,
        #[cfg(feature = "analysis")]
        Command::Lights(args) => &args.read.text,
        #[cfg(not(feature = "analysis"))]
        Command::Lights(_) => return None,
        Command::Lock(args) => &args.read.text,
        Command::Diff(args) => &args.read.text,
        Command::Check(args) => &args.text,
        Command::Completions(_)
        | Command::Devices(_)
        | Command::Init(_)
        | Command::Man(_)
        | Command::Merge(_)
        | Command::Rule(_)
        | Command::Schema(_) => return None,
        #[cfg(any(feature = "gl", feature = "gpu"))]
        Command::Reader(_) => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constants_are_words_beside_their_mark() {
        let glsl = "layout(constant_id = 3) const int COUNT = 4;";
        assert!(has_constant(glsl, "COUNT") && has_constant(glsl, "3"));
        assert!(!has_constant(glsl, "COUN") && !has_constant(glsl, "nope"));
        assert!(!has_constant(glsl, "33") && !has_constant("const int COUNT = 3;", "COUNT"));
        let wgsl = "@id(7) override scale: f32 = 1.0;";
        assert!(has_constant(wgsl, "scale") && has_constant(wgsl, "7"));
    }
}
