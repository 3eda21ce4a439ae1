//! Reads layouts from JSON: a lock, or the output of `layout --format json`.
//!
//! [`json`](crate::text::json) parses values with their offsets, `place` checks their types, and
//! `blocks` reads the layout of one shader.

mod blocks;
mod variants;

use std::sync::Arc;

use super::place::{JsonText, Object};
use super::{FIRST_SCHEMA_VERSION, Lock, SCHEMA_VERSION};
use crate::error::Error;
use crate::source::Files;
use crate::text::json;
use crate::text::json::{Node, Value};
use blocks::{BlockReader, Shape};

/// Reads a lock, or the layout of one shader as `layout --format json` prints it.
///
/// # Errors
/// The text is truncated, holds merge-conflict markers, is not JSON, has a newer schema, has a
/// value of the wrong type, or is inconsistent. Each error has its line and a help.
pub fn read(path: &str, text: &str) -> Result<Lock, Error> {
    let mut all = read_all(path, text)?;
    match (all.pop(), all.len()) {
        (Some(lock), 0) => Ok(lock),
        (None, _) => Err(Error::new(path, "holds the layout of no shader")
            .with_help("name a shader when writing it: `landfall layout SHADER --format json`")),
        (Some(_), more) => {
            let message = format!("holds the layouts of {} shaders, not of one", more + 1);
            Err(Error::new(path, message)
                .with_help("write one file per shader with `landfall lock`, or `layout --out DIR`"))
        }
    }
}

/// Reads a lock, or the layouts of all shaders in the output of `layout --format json`.
///
/// # Errors
/// Returns the errors of [`read`].
pub fn read_all(path: &str, text: &str) -> Result<Vec<Lock>, Error> {
    // A byte order mark, which editors of Windows put before UTF-8.
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let place = JsonText { path, text };
    // Before parsing, whose error would name the marker as an unexpected character only.
    if let Some((line, marker)) = conflict(text) {
        let message = format!("has a merge conflict at line {line}: `{marker}`");
        return Err(Error::new(path, message).with_help(
            "resolve the conflicts in the shaders, then write the lock again with `landfall lock`",
        ));
    }
    if text.trim().is_empty() {
        return Err(Error::new(path, "is empty, not a lock")
            .with_help("write it again with `landfall lock`"));
    }
    let root = json::parse(text).map_err(|fault| place.fault(&fault))?;
    let mut files = Files::default();
    files.add(path, Arc::from(text));
    let root = place.object(&root, "the whole text")?;
    // Only locks have variants, and so a second version.
    let newest = if root.get("blocks").is_some() { SCHEMA_VERSION } else { FIRST_SCHEMA_VERSION };
    place.version(&root, newest)?;
    let reader = |object: Object<'_>, shape: Shape| {
        BlockReader { place, shape, files: files.clone() }.lock(object)
    };
    // A lock is the layout of one shader; the output of `layout` lists several.
    if root.get("blocks").is_some() {
        return Ok(vec![reader(root, Shape::Lock)?]);
    }
    let Some(shaders) = root.get("shaders") else {
        return Err(Error::new(path, "is not a lock: it has neither `blocks` nor `shaders`")
            .with_help("write it again with `landfall lock`"));
    };
    root.known(&place, &["schema_version", "tool", "shaders"])?;
    place
        .list(shaders, "shaders")?
        .iter()
        .map(|shader| reader(place.object(shader, "a shader")?, Shape::Layout))
        .collect()
}

/// Whether a text was written by a newer landfall, and so must not be overwritten.
pub fn is_newer(text: &str) -> bool {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let Ok(Node { value: Value::Object(entries), .. }) = json::parse(text) else { return false };
    // The number alone is trusted: all else of a newer format may differ.
    entries.iter().any(|(key, _, node)| match &node.value {
        Value::Number(written) if key == "schema_version" => {
            written.parse::<u64>().is_ok_and(|version| version > u64::from(SCHEMA_VERSION))
        }
        _ => false,
    })
}

/// Whether a text is a lock or the output of `layout --format json`, possibly truncated or with
/// merge-conflict markers; only such files may be removed or overwritten.
pub fn is_lock(text: &str) -> bool {
    // The keys stand at the start; a large file that is no lock is not searched through.
    const LIMIT: usize = 4096;
    let start: String = text.chars().take(LIMIT).collect();
    let has = |key: &str| start.contains(&format!("\"{key}\""));
    let ours = has("language") && has("blocks") || has("tool") && has("landfall");
    start.contains('{') && has("schema_version") && ours
}

/// The first merge-conflict marker, with its line number.
fn conflict(text: &str) -> Option<(usize, &str)> {
    let lines = text.lines().enumerate();
    let marks = |line: &str| {
        // The markers of Git, of which `|||||||` comes with the style diff3.
        ["<<<<<<<", ">>>>>>>", "|||||||"].iter().any(|mark| line.starts_with(mark))
            || line == "======="
    };
    lines.map(|(i, line)| (i + 1, line.trim_end())).find(|(_, line)| marks(line))
}
