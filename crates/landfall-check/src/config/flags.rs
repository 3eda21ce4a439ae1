//! What the flags of a caller set for all shaders, and the parsers of their values.

use std::path::PathBuf;

use landfall_layout::{Rules, Target};
use landfall_lint::settings::Target as Limits;

/// Settings of a caller; they precede those of the configuration.
#[derive(Clone, Debug, Default)]
pub struct Flags {
    /// Macros, and features of WESL.
    pub defines: Vec<(String, String)>,
    pub preludes: Vec<PathBuf>,
    pub include_dirs: Vec<PathBuf>,
    pub overrides: Vec<(String, String)>,
    pub targets: Option<GivenTargets>,
    pub rules: Option<Rules>,
    pub gather: bool,
}

/// The target APIs.
#[derive(Clone, Debug, Default)]
pub struct GivenTargets {
    /// The dialect of GLSL that they have in common.
    pub dialect: Option<Target>,
    pub limits: Vec<Limits>,
}

/// The dialect of GLSL for several APIs; `None` if they disagree.
pub fn dialect(mut dialects: impl Iterator<Item = Target>) -> Option<Target> {
    let first = dialects.next()?;
    dialects.all(|other| other == first).then_some(first)
}

/// Parses `NAME` or `NAME=false` as the definition of that name.
pub fn feature(text: &str) -> Result<(String, String), String> {
    let (name, value) = text.split_once('=').unwrap_or((text, "true"));
    match value {
        "true" | "false" if !name.is_empty() => Ok((name.to_string(), value.to_string())),
        _ => Err("write NAME, NAME=true or NAME=false".to_string()),
    }
}

/// Parses `NAME` or `NAME=TEXT`.
pub fn define(text: &str) -> Result<(String, String), String> {
    let (name, value) = text.split_once('=').unwrap_or((text, "1"));
    // Names of macros are ASCII in GLSL.
    let mut letters = name.chars();
    let starts = letters.next().is_some_and(|c| c == '_' || c.is_ascii_alphabetic());
    if starts && letters.all(|c| c == '_' || c.is_ascii_alphanumeric()) {
        Ok((name.to_string(), value.to_string()))
    } else {
        Err("a macro is NAME or NAME=TEXT; names consist of letters, digits and _".to_string())
    }
}

/// Parses `NAME=VALUE`.
pub fn setting(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((name, value)) if !name.trim().is_empty() && !value.trim().is_empty() => {
            Ok((name.trim().to_string(), value.trim().to_string()))
        }
        _ => Err("expected NAME=VALUE".to_string()),
    }
}
