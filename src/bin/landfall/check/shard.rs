//! One part of a check that is spread over machines, and the parts put together again.
//!
//! Every shader belongs to one part by the hash of its path below the configuration's folder. A
//! part's JSON report holds, besides its findings, what lints over all shaders have to know.

use std::path::Path;

use landfall_layout::Error;
use landfall_layout::finding::Finding;
use landfall_lint::render::read_json;
use serde::{Deserialize, Serialize};

use super::basis::Basis;
use super::hash::Hash;
use super::one::Checked;
use super::pass::Pass;
use crate::args::Shard;
use crate::read;

#[derive(Debug, Serialize, Deserialize)]
struct Part {
    index: u32,
    of: u32,
    basis: Basis,
    /// Shaders without their findings, which stand in the report.
    checked: Vec<Checked>,
    /// How many findings are about inputs that are none; they come last.
    no_input: usize,
}

#[derive(Deserialize)]
struct Outer {
    shard: Option<serde_json::Value>,
}

/// What a part's report holds besides its findings, as a JSON value. The findings of the report
/// are those of the shaders one after the other.
pub fn part(shard: Shard, basis: &Basis, pass: &Pass) -> String {
    let bare = |checked: &Checked| Checked { findings: Vec::new(), ..checked.clone() };
    let part = Part {
        index: shard.index,
        of: shard.count,
        basis: basis.clone(),
        checked: pass.checked.iter().map(bare).collect(),
        no_input: pass.no_input.len(),
    };
    serde_json::to_string(&part).expect("keys are strings")
}

/// The parts of one check.
pub struct Whole {
    pub basis: Basis,
    pub pass: Pass,
    /// What was found in shaders one by one.
    pub findings: Vec<Finding>,
}

/// Reads the reports of all parts and puts them together.
pub fn together(paths: &[impl AsRef<Path>]) -> Result<Whole, Error> {
    let mut parts: Vec<(String, Part, Vec<Finding>)> = Vec::new();
    for path in paths {
        let (shown, text) = (read::shown(path.as_ref()), read::text(path.as_ref())?);
        let findings = read_json(&shown, &text)?;
        parts.push((shown.clone(), part_of(&shown, &text)?, findings));
    }
    agree(&parts)?;
    let mut pass = Pass::default();
    let mut all = Vec::new();
    let mut owners: std::collections::HashMap<String, String> = std::collections::HashMap::new();
    let mut basis = None;
    let mut no_input = 0;
    for (shown, part, findings) in parts {
        for checked in part.checked {
            if let Some(other) = owners.insert(checked.path.clone(), shown.clone()) {
                let message = format!("is about `{}`, and so is `{other}`", checked.path);
                return Err(Error::new(shown, message)
                    .with_help("run every shard from the same folder on the same commit"));
            }
            pass.checked.push(checked);
        }
        all.extend(findings);
        // Every part meets the same inputs that are none.
        no_input = no_input.max(part.no_input);
        basis.get_or_insert(part.basis);
    }
    let basis = basis.ok_or_else(|| Error::new("merge", "has no report to merge"))?;
    pass.checked.sort_by(|a, b| a.path.cmp(&b.path));
    pass.missing = no_input;
    unchanged(&pass)?;
    Ok(Whole { basis, pass, findings: all })
}

fn part_of(shown: &str, text: &str) -> Result<Part, Error> {
    let broken = |cause: serde_json::Error| {
        Error::new(shown, format!("is no report of a shard: {cause}"))
            .with_help("run the shard again with the same version of landfall as this one")
    };
    let outer: Outer = serde_json::from_str(text).map_err(broken)?;
    let Some(shard) = outer.shard else {
        return Err(Error::new(shown, "is no report of a shard, but of a whole check")
            .with_help("only reports of `landfall check --shard I/N` are merged"));
    };
    let version = shard["basis"]["version"].as_str().unwrap_or("an unknown version").to_string();
    if version != env!("CARGO_PKG_VERSION") {
        let message =
            format!("was written by landfall {version}, and this is {}", env!("CARGO_PKG_VERSION"));
        return Err(Error::new(shown, message)
            .with_help("check and merge with the same version of landfall"));
    }
    serde_json::from_value(shard).map_err(broken)
}

/// Whether these are all parts of one check, each once.
fn agree(parts: &[(String, Part, Vec<Finding>)]) -> Result<(), Error> {
    let Some((first, head, _)) = parts.first() else { return Ok(()) };
    for (i, (shown, part, _)) in parts.iter().enumerate() {
        if part.of != head.of {
            let message = format!(
                "is shard {} of {}, but `{first}` is shard {} of {}",
                part.index, part.of, head.index, head.of
            );
            return Err(Error::new(shown, message).with_help("merge the shards of one check only"));
        }
        if part.basis != head.basis {
            let message = format!("was checked with other settings than `{first}`");
            return Err(Error::new(shown, message)
                .with_help("give every shard the same configuration, flags and folder"));
        }
        if let Some((other, ..)) = parts[..i].iter().find(|(_, other, _)| other.index == part.index)
        {
            let message = format!("is shard {} of {}, and so is `{other}`", part.index, part.of);
            return Err(Error::new(shown, message).with_help("name the report of each shard once"));
        }
    }
    let missing: Vec<String> = (1..=head.of)
        .filter(|index| parts.iter().all(|(_, part, _)| part.index != *index))
        .map(|index| format!("{index}/{}", head.of))
        .collect();
    if !missing.is_empty() {
        let s = if missing.len() == 1 { "" } else { "s" };
        let message = format!("lacks its counterpart{s}: shard{s} {}", missing.join(", "));
        return Err(Error::new(first, message).with_help("name the reports of all shards"));
    }
    Ok(())
}

/// Excerpts and lints over all shaders want the files that were checked.
fn unchanged(pass: &Pass) -> Result<(), Error> {
    for checked in &pass.checked {
        let files = std::iter::once((&checked.path, &checked.hash))
            .chain(checked.includes.iter().map(|(path, hash)| (path, hash)));
        for (path, hash) in files {
            let now = || std::fs::read(path).ok().map(|bytes| Hash::of(&bytes));
            // Without a hash it could not be read there either.
            if hash.is_known() && now().as_ref() != Some(hash) {
                return Err(Error::new(path, "is not the file that was checked")
                    .with_help("merge in a checkout of the commit that the shards checked"));
            }
        }
    }
    Ok(())
}
