//! Warnings about options and configuration without effect: constants and macros that no shader
//! has, patterns that exclude nothing, include directories that are none, and options of another
//! language, backend or mode.

mod unused;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use landfall_layout::diagnostic::Code;
use landfall_layout::source::{File, Files};
use landfall_layout::{Diagnostic, Error, Language, Severity, ShaderLayout};

use crate::args::{Command, TextArgs};
use crate::output::{FindingForm, Streams};

/// The kind of option that a name is given for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum NameKind {
    Constant,
    Macro,
    Precision,
    Stage,
    Gather,
}

/// The name in caches of shaders with loose uniforms that were gathered.
const GATHER: &str = "#gather";

/// A name that has no effect unless a shader has it.
#[derive(Clone, Debug)]
struct NamedOption {
    kind: NameKind,
    name: String,
    /// Where it is given.
    option: String,
}

impl NamedOption {
    /// The name in caches, which tells kinds apart.
    fn key(&self) -> String {
        match self.kind {
            NameKind::Constant => self.name.clone(),
            NameKind::Macro => format!("#{}", self.name),
            NameKind::Precision => "#es".to_string(),
            NameKind::Stage => "#stage".to_string(),
            NameKind::Gather => GATHER.to_string(),
        }
    }

    fn is_in(&self, file: &File) -> bool {
        let text = &*file.text;
        match self.kind {
            NameKind::Constant => has_constant(text, &self.name),
            NameKind::Macro => has_word(text, &self.name),
            NameKind::Precision => {
                is_es(text) && (has_word(text, "mediump") || has_word(text, "lowp"))
            }
            // The name is that of `--language`.
            NameKind::Stage => match self.name.as_str() {
                "" => Path::new(&file.path)
                    .extension()
                    .is_none_or(|end| end != "wgsl" && end != "spv"),
                language => language != Language::Wgsl.name(),
            },
            // Recorded with the layout.
            NameKind::Gather => false,
        }
    }

    fn unused(&self) -> (Code, Error) {
        match self.kind {
            NameKind::Constant => {
                let error = Error::new(&*self.option, "has no effect: no shader has this constant");
                let help = "constants are those of `layout(constant_id = N)` in GLSL and `override` \
                            in WGSL, by name or number";
                (Code::UnknownOverride, error.with_help(help))
            }
            NameKind::Macro => {
                let what = "has no effect: no shader contains this name";
                (Code::UnusedOption, Error::new(&*self.option, what))
            }
            NameKind::Stage => {
                let what = "has no effect: WGSL and SPIR-V state the stages of their functions";
                (Code::UnusedOption, Error::new(&*self.option, what))
            }
            NameKind::Gather => {
                let what = "has no effect: no shader has a uniform outside blocks";
                (Code::UnusedOption, Error::new(&*self.option, what))
            }
            NameKind::Precision => {
                let what = "has no effect: the shader is not of OpenGL ES, or declares nothing \
                            `mediump` or `lowp`";
                (Code::UnusedOption, Error::new(&*self.option, what))
            }
        }
    }
}

/// The names given, and those that some shader has.
#[derive(Default)]
struct GivenNames {
    given: Vec<NamedOption>,
    matched: BTreeSet<String>,
    any: bool,
}

static NAMES: Mutex<GivenNames> =
    Mutex::new(GivenNames { given: Vec::new(), matched: BTreeSet::new(), any: false });

fn names() -> MutexGuard<'static, GivenNames> {
    NAMES.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Records the names given to a command, and warns about its options without effect.
pub fn begin(command: &Command, streams: &Streams) {
    unused::warn_of_options(command, streams);
    let Some((text, defines)) = text_of(command) else { return };
    let option = if matches!(command, Command::Check(_)) { "--define" } else { "-D" };
    let given = |kind, name: &String, option| NamedOption {
        kind,
        name: name.clone(),
        option: format!("{option} {name}"),
    };
    let constants = text.overrides.iter().map(|(name, _)| given(NameKind::Constant, name, "-O"));
    let macros = defines.iter().map(|(name, _)| given(NameKind::Macro, name, option));
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
    if text.gather && unused::lays_out(command) {
        all.push(NamedOption {
            kind: NameKind::Gather,
            name: String::new(),
            option: "--gather".to_string(),
        });
    }
    names().given = all;
    include_dirs(&text.include_dirs, "`-I DIR` names a directory", streams);
}

/// Whether the names that `key` of a configuration holds are constants or macros.
#[derive(Clone, Copy, Debug)]
pub enum ConfiguredKey {
    Override,
    Define,
    Permutations,
}

/// Records a name of a configuration file, unless an option gives it, too.
pub fn configured(key: ConfiguredKey, name: &str, file: &Path) {
    let (kind, key) = match key {
        ConfiguredKey::Override => (NameKind::Constant, "override"),
        ConfiguredKey::Define => (NameKind::Macro, "define"),
        ConfiguredKey::Permutations => (NameKind::Macro, "permutations"),
    };
    let option = format!("{name}` in `{key}` of `{}", file.display());
    let new = NamedOption { kind, name: name.to_string(), option };
    let mut names = names();
    if !names.given.iter().any(|old| old.key() == new.key()) {
        names.given.push(new);
    }
}

/// Warns about an option with a pattern that excludes nothing.
pub fn excludes_nothing(option: String, streams: &Streams) {
    warn_option(option, "no shader matches it", streams);
}

/// Warns about an option that has no effect.
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

/// The names given that a shader's text has.
fn known<'a>(files: impl Iterator<Item = &'a File>) -> Vec<String> {
    let given = names().given.clone();
    // Macros of the command line are files, too: `-D NAME`.
    let files: Vec<&File> = files.filter(|file| !file.path.starts_with("-D ")).collect();
    let known = |given: &&NamedOption| files.iter().any(|file| given.is_in(file));
    given.iter().filter(known).map(NamedOption::key).collect()
}

/// The names given that a shader has.
pub fn known_of(shader: &ShaderLayout) -> Vec<String> {
    let gathered = shader.blocks.iter().any(|block| block.gathered);
    // A module has no text to look for a constant in.
    let of_module = shader.overrides.iter().filter(|_| shader.language == Language::SpirV);
    let of_module =
        of_module.flat_map(|one| [Some(one.name.to_string()), one.id.map(|id| id.to_string())]);
    let known = known(shader.all_files()).into_iter().chain(of_module.flatten());
    known.chain(gathered.then(|| GATHER.to_string())).collect()
}

/// Records the names of a shader's text.
#[cfg(feature = "exec")]
pub fn record(files: &Files) {
    record_names(&known(files.iter()));
}

/// Records the names of a shader.
pub fn record_of(shader: &ShaderLayout) {
    record_names(&known_of(shader));
}

/// Records the names of a cached shader.
pub fn record_names(known: &[String]) {
    let mut names = names();
    names.any = true;
    names.matched.extend(known.iter().cloned());
}

/// Warns about the names given that no shader has.
pub fn finish(streams: &Streams) {
    let names = names();
    if !names.any {
        return;
    }
    for given in names.given.iter().filter(|given| !names.matched.contains(&given.key())) {
        let (code, error) = given.unused();
        warn(code, error, streams);
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

/// Whether a text is of OpenGL ES.
fn is_es(text: &str) -> bool {
    let version = text.lines().find_map(|line| line.trim_start().strip_prefix("#version"));
    version.is_none_or(|version| has_word(version, "es") || has_word(version, "100"))
}

/// The options of a command for reading shaders, and its macros.
fn text_of(command: &Command) -> Option<(&TextArgs, &[(String, String)])> {
    let read = match command {
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
        Command::Check(args) => return Some((&args.text, &args.levels.defines)),
        Command::Completions(_)
        | Command::Devices(_)
        | Command::Init(_)
        | Command::Man(_)
        | Command::Rule(_)
        | Command::Schema(_)
        | Command::Serve(_) => return None,
        #[cfg(not(feature = "port"))]
        Command::Port(_) => return None,
        #[cfg(any(feature = "gl", feature = "gpu"))]
        Command::Reader(_) => return None,
    };
    Some((&read.text, &read.defines))
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
