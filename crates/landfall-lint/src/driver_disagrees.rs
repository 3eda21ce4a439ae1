//! `driver-disagrees`: leaves that a driver was seen to read from another byte.
//!
//! Reads the parts it needs of the JSON report of `verify`, and takes the places of leaves from the
//! layouts of the same shaders.

use rustc_hash::FxHashMap;
use serde::Deserialize;

use super::definition::{Check, Lint};
use super::show::full_listing;
use landfall_layout::ShaderLayout;
use landfall_layout::error::Error;
use landfall_layout::finding::{Finding, Level, Place};
use landfall_layout::layout::{BlockLayout, Leaf};

pub(super) const LINT: Lint = Lint {
    code: "driver-disagrees",
    // Observed on a machine, not computed: that driver misreads the upload wherever it runs.
    level: Level::Deny,
    what: "members that a driver reads from another byte than the layout rules give",
    why: "`verify` fills a block with known values and compares them with what the driver reads. \
          Where they differ, either the driver is wrong or the block has no portable layout \
          (`shared`, `packed`, or no qualifier at all): every upload that follows the rules is \
          misread there.",
    example: "\
#version 330 core
uniform Light { // no std140: where `intensity` is, is up to the driver
    vec3 color;
    float intensity;
};
void main() {}
",
    fix: "Declare std140 or std430; where the block declares one of them, work around the \
          construct that the driver gets wrong, and report it.",
    check: Check::Elsewhere,
};

/// The supported version of `verify`'s report.
const SCHEMA_VERSION: u32 = 1;

/// The parts of `verify`'s report that are read; other keys are ignored.
#[derive(Debug, Deserialize)]
pub struct Report {
    shaders: Vec<VerifiedShader>,
}

#[derive(Debug, Deserialize)]
struct VerifiedShader {
    path: String,
    blocks: Vec<VerifiedBlock>,
}

#[derive(Debug, Deserialize)]
struct VerifiedBlock {
    name: String,
    backends: Vec<BackendReads>,
}

/// The results of one backend for a block.
#[derive(Debug, Deserialize)]
struct BackendReads {
    /// `gl`, `gpu`, `cpu`.
    backend: String,
    /// The text that was run: `original`, `naga`.
    form: String,
    reads: Vec<VerifiedRead>,
    causes: Vec<VerifiedCause>,
}

#[derive(Debug, Deserialize)]
struct VerifiedRead {
    /// `data[3].color.y`.
    path: String,
    /// `data[].color`.
    leaf: String,
    /// The offset in the layout, from the start of the block.
    expected_byte: u64,
    /// The offset whose bytes the backend read; `None` when nothing of the upload was read.
    byte_read: Option<u64>,
}

/// The likely cause, as the report names it.
#[derive(Debug, Deserialize)]
struct VerifiedCause {
    leaf: String,
    cause: String,
}

impl Report {
    /// The shaders it is about.
    pub fn paths(&self) -> impl Iterator<Item = &str> {
        self.shaders.iter().map(|shader| shader.path.as_str())
    }

    /// The disagreements about the shaders whose layouts are known, one finding for each leaf and
    /// backend.
    pub fn findings<'s>(&self, known: &dyn Fn(&str) -> Option<&'s ShaderLayout>) -> Vec<Finding> {
        let mut findings = Vec::new();
        for shader in &self.shaders {
            let Some(layout) = known(&shader.path) else { continue };
            for block in &shader.blocks {
                let Some(known) = layout.blocks.iter().find(|known| *known.name == block.name)
                else {
                    continue;
                };
                let leaves = by_leaf(block);
                findings.extend(leaves.iter().map(|leaf| finding(block, leaf, (layout, known))));
            }
        }
        findings
    }
}

/// Reads a report.
///
/// # Errors
/// The text is no report of `verify`, or one of a newer version.
pub fn read(path: &str, text: &str) -> Result<Report, Error> {
    /// The version, read first because a newer report may have another form.
    #[derive(Deserialize)]
    struct ReportVersion {
        schema_version: u32,
    }
    let refused = |cause: serde_json::Error| {
        Error::new(path, format!("is no report of `landfall verify`: {cause}"))
            .with_help("write it again with `landfall verify --format json`")
    };
    let ReportVersion { schema_version } = serde_json::from_str(text).map_err(refused)?;
    if schema_version > SCHEMA_VERSION {
        let message = format!(
            "is a report of schema version {schema_version}; this landfall reads {SCHEMA_VERSION}"
        );
        return Err(
            Error::new(path, message).with_help("use the version of landfall that wrote it")
        );
    }
    serde_json::from_str(text).map_err(refused)
}

/// The reads of one leaf that one backend made at other offsets.
struct Elsewhere<'r> {
    backend: &'r BackendReads,
    reads: Vec<&'r VerifiedRead>,
}

/// The reads that disagree, in the order of the report.
fn by_leaf(block: &VerifiedBlock) -> Vec<Elsewhere<'_>> {
    let mut groups: Vec<Elsewhere<'_>> = Vec::new();
    let mut index: FxHashMap<(&str, &str, &str), usize> = FxHashMap::default();
    for backend in &block.backends {
        for read in backend.reads.iter().filter(|read| read.byte_read != Some(read.expected_byte)) {
            // Other stages and access modes repeat the same mismatch.
            let at =
                *index.entry((&read.leaf, &backend.backend, &backend.form)).or_insert(groups.len());
            match groups.get_mut(at) {
                Some(group) if group.reads.iter().any(|other| other.path == read.path) => {}
                Some(group) => group.reads.push(read),
                None => groups.push(Elsewhere { backend, reads: vec![read] }),
            }
        }
    }
    groups
}

fn finding(
    block: &VerifiedBlock,
    elsewhere: &Elsewhere<'_>,
    (shader, layout): (&ShaderLayout, &BlockLayout),
) -> Finding {
    let (first, backend) = (elsewhere.reads[0], elsewhere.backend);
    let read = match first.byte_read {
        Some(byte) => format!("from byte {byte} instead of {}", first.expected_byte),
        None => format!("from no byte of the block; it is at {}", first.expected_byte),
    };
    let who = &backend.backend;
    let message = format!("`{who}` reads `{}` of block `{}` {read}", first.path, block.name);
    let leaf: Option<&Leaf> = layout.leaves.iter().find(|leaf| leaf.path == first.leaf);
    let place = Place::new(&shader.files, leaf.map_or(layout.span, |leaf| leaf.span));
    let about = format!("{}.{} in {who}", block.name, first.leaf);
    let mut finding = Finding::at(LINT.code, about, place, message);
    finding.listing = full_listing(shader, layout);
    if !layout.rules_declared {
        finding = finding
            .with_note("the block declares no layout rules: the driver chooses its offsets")
            .with_help(format!("declare `layout({})`", layout.rules.name()));
    }
    if backend.form == "naga" {
        finding = finding.with_note("the driver ran naga's translation of the shader");
    }
    if elsewhere.reads.len() > 1 {
        let (values, are) = match elsewhere.reads.len() - 1 {
            1 => ("1 further value".to_string(), "is"),
            n => (format!("{n} further values"), "are"),
        };
        finding = finding
            .with_note(format!("{values} of `{}` {are} read from other bytes too", first.leaf));
    }
    match backend.causes.iter().find(|cause| cause.leaf == first.leaf) {
        Some(cause) => finding.with_note(cause.cause.clone()),
        None => finding,
    }
}
