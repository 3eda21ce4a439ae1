//! Names that options and a configuration give to all shaders: constants and macros above all, which have
//! no effect unless some shader has them.

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};

use landfall_layout::diagnostic::Code;
use landfall_layout::source::File;
use landfall_layout::{Diagnostic, Error, Language, Severity, ShaderLayout};

/// The kind of option that a name is given for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum NameKind {
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
pub struct NamedOption {
    pub kind: NameKind,
    pub name: String,
    /// Where it is given.
    pub option: String,
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

/// Whether the names that `key` of a configuration holds are constants or macros.
#[derive(Clone, Copy, Debug)]
pub enum ConfiguredKey {
    Override,
    Define,
    Permutations,
}

#[derive(Default)]
struct NameRecord {
    given: Vec<NamedOption>,
    matched: BTreeSet<String>,
    any: bool,
    /// Whether it was told which names no shader has.
    is_told: bool,
}

/// The names given, and those that some shader has.
pub struct GivenNames(Mutex<NameRecord>);

impl Default for GivenNames {
    fn default() -> GivenNames {
        GivenNames::new()
    }
}

impl GivenNames {
    pub const fn new() -> GivenNames {
        GivenNames(Mutex::new(NameRecord {
            given: Vec::new(),
            matched: BTreeSet::new(),
            any: false,
            is_told: false,
        }))
    }

    fn record(&self) -> MutexGuard<'_, NameRecord> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Sets the names of the options.
    pub fn give(&self, names: Vec<NamedOption>) {
        self.record().given = names;
    }

    /// Adds a name of a configuration file, unless an option gives it, too.
    pub fn give_configured(&self, key: ConfiguredKey, name: &str, file: &Path) {
        let (kind, key) = match key {
            ConfiguredKey::Override => (NameKind::Constant, "override"),
            ConfiguredKey::Define => (NameKind::Macro, "define"),
            ConfiguredKey::Permutations => (NameKind::Macro, "permutations"),
        };
        let option = format!("{name}` in `{key}` of `{}", file.display());
        let new = NamedOption { kind, name: name.to_string(), option };
        let mut record = self.record();
        if !record.given.iter().any(|old| old.key() == new.key()) {
            record.given.push(new);
        }
    }

    /// The names given that a shader's text has.
    pub fn in_files<'a>(&self, files: impl Iterator<Item = &'a File>) -> Vec<String> {
        let given = self.record().given.clone();
        // Macros of the command line are files, too: `-D NAME`.
        let files: Vec<&File> = files.filter(|file| !file.path.starts_with("-D ")).collect();
        let is_known = |given: &&NamedOption| files.iter().any(|file| given.is_in(file));
        given.iter().filter(is_known).map(NamedOption::key).collect()
    }

    /// The names given that a shader has.
    pub fn in_shader(&self, shader: &ShaderLayout) -> Vec<String> {
        let gathered = shader.blocks.iter().any(|block| block.gathered);
        // A module has no text to look for a constant in.
        let of_module = shader.overrides.iter().filter(|_| shader.language == Language::SpirV);
        let of_module =
            of_module.flat_map(|one| [Some(one.name.to_string()), one.id.map(|id| id.to_string())]);
        let known = self.in_files(shader.all_files()).into_iter().chain(of_module.flatten());
        known.chain(gathered.then(|| GATHER.to_string())).collect()
    }

    /// Records the names that a shader has.
    pub fn found(&self, names: &[String]) {
        let mut record = self.record();
        record.any = true;
        record.matched.extend(names.iter().cloned());
    }

    /// Warnings about the names given that no shader has, once; none if no shader was read.
    pub fn unused(&self) -> Vec<Diagnostic> {
        let mut record = self.record();
        if !record.any || std::mem::replace(&mut record.is_told, true) {
            return Vec::new();
        }
        let unused = record.given.iter().filter(|given| !record.matched.contains(&given.key()));
        let warning = |(code, error): (Code, Error)| Diagnostic {
            code,
            severity: Severity::Warning,
            ..error.into()
        };
        unused.map(NamedOption::unused).map(warning).collect()
    }
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
    // A text without a version may be of either.
    version.is_none_or(|version| has_word(version, "es") || has_word(version, "100"))
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
