//! Shards of a check, and their merging.
//!
//! A shader belongs to a shard by the hash of its path below the configuration's directory. The
//! JSON report of a shard also contains the data for lints over all shaders.

use std::path::Path;

use landfall_layout::Error;
use landfall_layout::finding::Finding;
use landfall_lint::render::read_json;
use serde::{Deserialize, Serialize};

use super::basis::{Basis, VERSION};
use super::check_shader::Checked;
use super::hash::Hash;
use super::pass::Pass;
use crate::args::Shard;
use crate::read;

#[derive(Debug, Serialize, Deserialize)]
struct Part {
    index: u32,
    of: u32,
    basis: Basis,
    /// The shaders without their findings, which are in the report.
    checked: Vec<Checked>,
    /// Number of findings about invalid inputs, which come last.
    no_input: usize,
}

#[derive(Deserialize)]
struct Outer {
    shard: Option<serde_json::Value>,
}

#[derive(Deserialize)]
struct Whole {
    shard: Part,
}

/// The shard's data for `merge` as JSON. The findings in the report are in the order of shaders.
pub fn part(shard: Shard, basis: &Basis, pass: &Pass) -> String {
    let bare =
        |checked: &Checked| Checked { findings: Vec::new(), stamps: Vec::new(), ..checked.clone() };
    let part = Part {
        index: shard.index,
        of: shard.count,
        basis: basis.clone(),
        checked: pass.checked.iter().map(bare).collect(),
        no_input: pass.no_input.len(),
    };
    serde_json::to_string(&part).expect("keys are strings")
}

/// The merged shards of a check.
pub struct MergedCheck {
    pub basis: Basis,
    pub pass: Pass,
    /// The findings in single shaders.
    pub findings: Vec<Finding>,
}

/// Reads and merges the reports of all shards.
pub fn merge_reports(paths: &[impl AsRef<Path>]) -> Result<MergedCheck, Error> {
    let mut parts: Vec<(String, Part, Vec<Finding>)> = Vec::new();
    for path in paths {
        let (shown, text) = (read::display_path(path.as_ref()), read::text(path.as_ref())?);
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
                let message = format!("covers `{}`, as does `{other}`", checked.path);
                return Err(Error::new(shown, message)
                    .with_help("run every shard from the same directory on the same commit"));
            }
            pass.checked.push(checked);
        }
        all.extend(findings);
        // Every shard reports the same invalid inputs.
        no_input = no_input.max(part.no_input);
        basis.get_or_insert(part.basis);
    }
    let basis = basis.ok_or_else(|| Error::new("merge", "has no report to merge"))?;
    pass.checked.sort_by(|a, b| a.path.cmp(&b.path));
    pass.missing = no_input;
    unchanged(&pass)?;
    Ok(MergedCheck { basis, pass, findings: all })
}

fn part_of(shown: &str, text: &str) -> Result<Part, Error> {
    let broken = |cause: serde_json::Error| {
        Error::new(shown, format!("is not a report of a shard: {cause}"))
            .with_help("run the shard again with the same version of landfall as this one")
    };
    let outer: Outer = serde_json::from_str(text).map_err(broken)?;
    let Some(shard) = outer.shard else {
        return Err(Error::new(shown, "is the report of a whole check, not of a shard")
            .with_help("only reports of `landfall check --shard I/N` are merged"));
    };
    let version = shard["basis"]["version"].as_str().unwrap_or("an unknown version").to_string();
    if version != VERSION {
        let message = format!("was written by landfall {version}, and this is {VERSION}");
        return Err(Error::new(shown, message)
            .with_help("check and merge with the same version of landfall"));
    }
    // Again from the text: its deserializer is compiled for the cache, too.
    serde_json::from_str(text).map(|Whole { shard }| shard).map_err(broken)
}

/// Fails unless these are all shards of one check, each once.
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
                .with_help("give every shard the same configuration, flags and directory"));
        }
        if let Some((other, ..)) = parts[..i].iter().find(|(_, other, _)| other.index == part.index)
        {
            let message = format!("is shard {} of {}, as is `{other}`", part.index, part.of);
            return Err(Error::new(shown, message).with_help("name the report of each shard once"));
        }
    }
    let missing: Vec<String> = (1..=head.of)
        .filter(|index| parts.iter().all(|(_, part, _)| part.index != *index))
        .map(|index| format!("{index}/{}", head.of))
        .collect();
    if !missing.is_empty() {
        let s = if missing.len() == 1 { "" } else { "s" };
        let message = format!("is incomplete without shard{s} {}", missing.join(", "));
        return Err(Error::new(first, message).with_help("name the reports of all shards"));
    }
    Ok(())
}

/// Fails if a file has changed since it was checked: excerpts and lints over all shaders read it.
fn unchanged(pass: &Pass) -> Result<(), Error> {
    for checked in &pass.checked {
        let files = std::iter::once((&checked.path, &checked.hash))
            .chain(checked.includes.iter().map(|(path, hash)| (path, hash)));
        for (path, hash) in files {
            let now = || std::fs::read(path).ok().map(|bytes| Hash::of(&bytes));
            // Without a hash, the shard could not read it either.
            if hash.is_known() && now().as_ref() != Some(hash) {
                return Err(Error::new(path, "has changed since it was checked")
                    .with_help("merge in a checkout of the commit that the shards checked"));
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use landfall_layout::Options;
    use landfall_lint::Settings;

    use super::super::basis::Scope;
    use super::*;

    #[test]
    fn a_build_reads_the_shards_that_it_writes() {
        let options = Options::default();
        let basis = Basis::new(Scope::default(), &options, None, None, Settings::default());
        let shard = part(Shard { index: 1, count: 1 }, &basis, &Pass::default());
        let read = part_of("r.json", &format!("{{\"shard\":{shard}}}")).expect("its own shard");
        assert_eq!(read.basis, basis);
        let other = shard.replace(VERSION, "0.0.1");
        let refused = part_of("r.json", &format!("{{\"shard\":{other}}}"));
        assert!(refused.is_err_and(|error| error.to_string().contains("by landfall 0.0.1")));
    }
}
