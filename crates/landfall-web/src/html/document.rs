//! A shader as JSON for the page: its blocks under every set of rules, its findings, and what
//! changed since its lock or its other side.

use std::collections::HashMap;
use std::sync::Arc;

use landfall_layout::diff::Kind;
use landfall_layout::finding::{Finding, Place};
use landfall_layout::format::diff::Compared;
use landfall_layout::format::phrases;
use landfall_layout::layout::padding::summary;
use landfall_layout::layout::targets;
use landfall_layout::source::{Files, Language};
use landfall_layout::{AddressSpace, BlockLayout, Rules, ShaderLayout};
use serde::Serialize;

use super::member::{Context, Member, members};
use super::texts::Texts;

/// The rules that the page compares, in the order of its switches.
pub const RULES: [Rules; 4] = Rules::OF_TEXT;

/// The most leaves of a block that is shown under other rules than its own; bounds the file.
pub const MAX_UNDER_ALL_RULES: usize = 4096;

/// The most lines of a place that a finding shows.
const MAX_LINES: u32 = 3;

/// The most characters of a line that a finding shows.
const MAX_CHARACTERS: usize = 300;

/// A shader of the page.
#[derive(Clone, Copy)]
pub struct Part<'a> {
    /// The shader's path as the page shows it.
    pub path: &'a str,
    /// Its layout; empty where only changes are shown.
    pub shader: &'a ShaderLayout,
    /// Its layouts by [`RULES`]; may be empty.
    pub by_rules: &'a [(Rules, ShaderLayout)],
    /// What was found in it.
    pub findings: &'a [&'a Finding],
    /// The text of a file by its path in findings, of which they show lines.
    pub text: &'a dyn Fn(&str) -> Option<Arc<str>>,
    /// How its layout differs from the other side.
    pub compared: Option<&'a Compared<'a>>,
}

#[derive(Serialize)]
struct PageShader<'a> {
    path: &'a str,
    /// What tells the variants that have these blocks, if not all have them.
    #[serde(skip_serializing_if = "Option::is_none")]
    variant: Option<&'a str>,
    language: &'static str,
    stage: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    assumed: Option<String>,
    blocks: Vec<PageBlock<'a>>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    findings: Vec<PageFinding<'a>>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    changes: Vec<PageChange<'a>>,
}

/// A finding with the lines of the text that it is about.
#[derive(Serialize)]
struct PageFinding<'a> {
    #[serde(flatten)]
    finding: &'a Finding,
    /// The lines of each place, from its first.
    lines: Vec<Vec<String>>,
}

/// Returns the findings of a shader with their lines.
fn findings<'a>(part: &Part<'a>) -> Vec<PageFinding<'a>> {
    // By path, each file as the only one of its `Files`, which know where its lines are.
    let mut read: HashMap<&str, Files> = HashMap::new();
    let mut lines = |place: &'a Place| -> Vec<String> {
        let files = read.entry(&place.path).or_insert_with(|| {
            let mut files = Files::default();
            if let Some(text) = (part.text)(&place.path) {
                files.add(&*place.path, text);
            }
            files
        });
        let Some(file) = files.get(0) else { return Vec::new() };
        let count = 1 + place.end_line.saturating_sub(place.line);
        let shown = (place.line..).take(count.min(MAX_LINES) as usize);
        let shown = shown.map_while(|number| file.line(number));
        shown.map(|line| line.chars().take(MAX_CHARACTERS).collect()).collect()
    };
    let with_lines = |finding: &&'a Finding| {
        let lines = finding.labels.iter().map(|label| lines(&label.at)).collect();
        PageFinding { finding, lines }
    };
    part.findings.iter().map(with_lines).collect()
}

#[derive(Serialize)]
struct PageBlock<'a> {
    name: &'a str,
    instance: Option<&'a str>,
    space: &'static str,
    slot: String,
    /// Number of buffers of an array of blocks.
    #[serde(skip_serializing_if = "Option::is_none")]
    buffers: Option<u64>,
    /// The block's own rules; `None` for loose uniforms.
    rules: Option<&'static str>,
    rules_declared: bool,
    line: u32,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    opaque: Vec<String>,
    layouts: Vec<PageLayout<'a>>,
}

#[derive(Serialize)]
struct PageLayout<'a> {
    rules: &'static str,
    size: Option<u64>,
    data_size: Option<u64>,
    align: Option<u64>,
    /// Bytes of padding.
    padding: Option<u64>,
    members: Vec<Member<'a>>,
}

#[derive(Serialize)]
struct PageChange<'a> {
    name: &'a str,
    class: &'static str,
    old: Option<PageBlock<'a>>,
    new: Option<PageBlock<'a>>,
    list: Vec<ChangeLine<'a>>,
}

#[derive(Serialize)]
struct ChangeLine<'a> {
    kind: Kind,
    class: &'static str,
    path: &'a str,
    old: Option<&'a str>,
    new: Option<&'a str>,
    message: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    verdict: Option<&'static str>,
}

/// The JSON of a shader.
pub(super) fn shader(part: &Part<'_>, texts: &mut Texts) -> String {
    let shader = part.shader;
    let blocks = shader.blocks.iter().map(|own| {
        let same = |other: &&BlockLayout| {
            (&other.name, &other.instance, other.span) == (&own.name, &own.instance, own.span)
        };
        let others = part
            .by_rules
            .iter()
            .filter(|(rules, _)| *rules != own.rules && own.leaves.len() <= MAX_UNDER_ALL_RULES);
        let mut all: Vec<&BlockLayout> =
            others.filter_map(|(_, other)| other.blocks.iter().find(same)).collect();
        all.push(own);
        all.sort_by_key(|block| RULES.iter().position(|rules| *rules == block.rules));
        let all = if own.space == AddressSpace::Default { vec![own] } else { all };
        block(own, &all, shader, texts)
    });
    let object = PageShader {
        path: part.path,
        variant: shader.condition.as_ref().map(|condition| condition.text.as_str()),
        language: shader.language.name(),
        stage: shader.stage.map(|stage| stage.name()),
        assumed: targets::note(shader.assumed_target),
        blocks: blocks.collect(),
        findings: findings(part),
        changes: part.compared.map_or_else(Vec::new, |compared| changes(compared, texts)),
    };
    super::json(&object)
}

fn block<'a>(
    own: &'a BlockLayout,
    all: &[&'a BlockLayout],
    shader: &'a ShaderLayout,
    texts: &mut Texts,
) -> PageBlock<'a> {
    PageBlock {
        name: &own.name,
        instance: own.instance.as_deref(),
        space: own.space.name(),
        slot: phrases::slot(own, shader.language),
        buffers: phrases::buffers(own).filter(|_| !own.count.is_empty()),
        rules: (own.space != AddressSpace::Default).then(|| own.rules.name()),
        rules_declared: own.rules_declared,
        line: shader.files.locate(own.span).line,
        opaque: phrases::opaque(own),
        layouts: all.iter().map(|block| layout(block, shader, texts)).collect(),
    }
}

fn layout<'a>(
    block: &'a BlockLayout,
    shader: &'a ShaderLayout,
    texts: &mut Texts,
) -> PageLayout<'a> {
    let language: Language = shader.language;
    let mut context = Context { rules: block.rules, language, files: &shader.files, texts };
    PageLayout {
        rules: block.rules.name(),
        size: block.size,
        data_size: block.data_size,
        align: block.align,
        padding: summary(block).map(|summary| summary.padding),
        members: members(&block.members, &mut context),
    }
}

fn changes<'a>(compared: &'a Compared<'a>, texts: &mut Texts) -> Vec<PageChange<'a>> {
    let mut found = Vec::with_capacity(compared.blocks.len());
    for diff in compared.blocks {
        let mut side = |shader: &'a ShaderLayout, at: Option<usize>| {
            at.map(|at| block(&shader.blocks[at], &[&shader.blocks[at]], shader, texts))
        };
        found.push(PageChange {
            name: &diff.name,
            class: diff.class().name(),
            old: side(compared.old, diff.old),
            new: side(compared.new, diff.new),
            list: diff
                .changes
                .iter()
                .map(|change| ChangeLine {
                    kind: change.kind,
                    class: change.class.name(),
                    path: &change.path,
                    old: change.old.as_deref(),
                    new: change.new.as_deref(),
                    message: &change.message,
                    verdict: compared.verdict(change),
                })
                .collect(),
        });
    }
    found
}
