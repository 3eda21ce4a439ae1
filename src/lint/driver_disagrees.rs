//! `driver-disagrees`: leaves that a driver was seen to read from another byte.
//!
//! Reads the JSON report of `verify`, no more of it than it needs; the layouts
//! of the same shaders, where given, say where in the text each leaf stands.

use rustc_hash::FxHashMap;
use serde::Deserialize;

use super::walk::listing;
use super::{Check, Finding, Level, Lint, Place};
use crate::ShaderLayout;
use crate::error::Error;
use crate::layout::{BlockLayout, Leaf};

pub(super) const LINT: Lint = Lint {
    code: "driver-disagrees",
    // Seen on a machine, not computed: wherever that driver runs, the upload is misread.
    level: Level::Deny,
    what: "reports leaves that a driver reads from another byte than the rules say",
    why: "`verify` fills a block with known words and asks the driver what it sees. Where that is \
          another word, either the driver is wrong or the rules are its own (`shared`, `packed`, \
          or none at all): every upload made by the rules is misread there.",
    example: "\
#version 330 core
uniform Light { // no std140: where `intensity` is, is up to the driver
    vec3 color;
    float intensity;
};
void main() {}
",
    fix: "declare std140 or std430; where they are declared, work around the construct that the \
          driver gets wrong, and report it",
    check: Check::Elsewhere,
};

/// The version of `verify`'s report that is read here.
const SCHEMA_VERSION: u32 = 1;

/// `verify`'s report, as far as it is read; further keys are passed over.
#[derive(Deserialize)]
struct Report {
    schema_version: u32,
    shaders: Vec<Shader>,
}

#[derive(Deserialize)]
struct Shader {
    path: String,
    blocks: Vec<Block>,
}

#[derive(Deserialize)]
struct Block {
    name: String,
    leaves: Vec<Probe>,
}

/// What one reader saw of one element of a leaf.
#[derive(Deserialize)]
struct Probe {
    /// `data[].color`.
    path: String,
    /// `data[3].color`; the leaf's own path where it is no array.
    element: Option<String>,
    /// `gl`, `gpu`, `cpu`, with the driver's name if the report gives it.
    reader: String,
    /// Where the layout puts it, from the start of the block.
    expected_byte: u64,
    /// Where the reader found what it read; `None` when it was no byte of the block.
    byte_read: Option<u64>,
    /// What the reader takes to be the reason.
    cause: Option<String>,
}

/// The disagreements in a report, one finding for each leaf and reader.
///
/// # Errors
/// The text is no report of `verify`, or one of a newer version.
pub fn findings(
    path: &str,
    report: &str,
    shaders: &[&ShaderLayout],
) -> Result<Vec<Finding>, Error> {
    let report = read(path, report)?;
    let mut findings = Vec::new();
    for shader in &report.shaders {
        let layout = shaders.iter().find(|layout| layout.path == shader.path).copied();
        for block in &shader.blocks {
            let known =
                layout.and_then(|l| l.blocks.iter().find(|known| *known.name == block.name));
            for probes in by_leaf(block) {
                findings.push(finding(&shader.path, block, &probes, layout.zip(known)));
            }
        }
    }
    Ok(findings)
}

fn read(path: &str, text: &str) -> Result<Report, Error> {
    /// Asked first: a newer report may have another form.
    #[derive(Deserialize)]
    struct Version {
        schema_version: u32,
    }
    let refused = |cause: serde_json::Error| {
        Error::new(path, format!("is no report of `landfall verify`: {cause}"))
            .with_help("write it anew with `landfall verify --format json`")
    };
    let Version { schema_version } = serde_json::from_str(text).map_err(refused)?;
    if schema_version > SCHEMA_VERSION {
        let message = format!(
            "is a report of schema version {schema_version}; this landfall reads {SCHEMA_VERSION}"
        );
        return Err(Error::new(path, message).with_help("use the landfall that wrote it"));
    }
    let report: Report = serde_json::from_str(text).map_err(refused)?;
    debug_assert_eq!(report.schema_version, schema_version);
    Ok(report)
}

/// The probes that disagree, those of one leaf and reader together, in the order of the report.
fn by_leaf(block: &Block) -> Vec<Vec<&Probe>> {
    let mut groups: Vec<Vec<&Probe>> = Vec::new();
    let mut index: FxHashMap<(&str, &str), usize> = FxHashMap::default();
    for probe in block.leaves.iter().filter(|probe| probe.byte_read != Some(probe.expected_byte)) {
        let at = *index.entry((&probe.path, &probe.reader)).or_insert(groups.len());
        match groups.get_mut(at) {
            Some(group) => group.push(probe),
            None => groups.push(vec![probe]),
        }
    }
    groups
}

fn finding(
    path: &str,
    block: &Block,
    probes: &[&Probe],
    known: Option<(&ShaderLayout, &BlockLayout)>,
) -> Finding {
    let first = probes[0];
    let element = first.element.as_deref().unwrap_or(&first.path);
    let read = match first.byte_read {
        Some(byte) => format!("from byte {byte} instead of {}", first.expected_byte),
        None => format!("from no byte of the block; it is at {}", first.expected_byte),
    };
    let message = format!("`{}` reads `{element}` of block `{}` {read}", first.reader, block.name);
    let leaf: Option<&Leaf> =
        known.and_then(|(_, layout)| layout.leaves.iter().find(|leaf| leaf.path == first.path));
    let place = match (known, leaf) {
        (Some((shader, _)), Some(leaf)) => Place::of(&shader.files, leaf.span),
        (Some((shader, layout)), None) => Place::of(&shader.files, layout.span),
        (None, _) => Place::file(path),
    };
    let about = format!("{}.{} in {}", block.name, first.path, first.reader);
    let mut finding = Finding::new(LINT.code, about, place, message);
    if let Some((shader, layout)) = known {
        finding.listing = listing(shader, layout);
        if !layout.rules_declared {
            finding = finding
                .with_note("the block declares no rules: its offsets are the driver's")
                .with_help(format!("declare `layout({})`", layout.rules.name()));
        }
    }
    if probes.len() > 1 {
        let (elements, are) = match probes.len() - 1 {
            1 => ("1 further element".to_string(), "is"),
            n => (format!("{n} further elements"), "are"),
        };
        finding = finding
            .with_note(format!("{elements} of `{}` {are} read from other bytes too", first.path));
    }
    match &first.cause {
        Some(cause) => finding.with_note(cause.clone()),
        None => finding,
    }
}
