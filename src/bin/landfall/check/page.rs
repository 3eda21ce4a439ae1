//! The HTML page of `check` and `report`: layouts, findings, and what changed since the locks.
//!
//! A pass may come from a cache, without layouts: the shaders are laid out again.

use std::collections::BTreeMap;
use std::path::Path;

use landfall::report::html::{Page, Part, RULES};
use landfall_layout::diff::{Side, diff};
use landfall_layout::finding::Finding;
use landfall_layout::format::diff::Compared;
use landfall_layout::source;
use landfall_layout::{Language, Rules, ShaderLayout, Source, lock};

use super::pass::{Pass, Run};
use super::{lock_of, watch};
use crate::args::CheckArgs;
use crate::read;

/// The page.
pub fn page(args: &CheckArgs, run: &Run<'_>, pass: &Pass, findings: &[Finding]) -> String {
    let mut by_path: BTreeMap<&str, Vec<&Finding>> = BTreeMap::new();
    for finding in findings {
        by_path.entry(&finding.place().path).or_default().push(finding);
    }
    let mut page = Page::default();
    for checked in &pass.checked {
        if watch::is_stopped() {
            break;
        }
        let found = by_path.remove(checked.path.as_str()).unwrap_or_default();
        let source = source(run, &checked.path);
        let empty = || ShaderLayout::empty(checked.path.clone(), Language::Glsl, None);
        let shader = source
            .as_ref()
            .map_or_else(empty, |source| run.basis.settings.layout(source, &run.basis.options()));
        let lock = lock_of(run, checked);
        let old = match run.against {
            Some(against) => against.layout(&checked.path, run.root, run.basis),
            None => lock.and_then(|lock| locked(&lock)),
        };
        let old = old.filter(|_| !shader.has_errors());
        let blocks = old.as_ref().map(|old| diff(Side::of(old), Side::of(&shader)));
        let compared = old.as_ref().zip(blocks.as_deref()).map(|(old, blocks)| Compared {
            name: &checked.path,
            variant: None,
            old,
            new: &shader,
            blocks,
            policy: None,
            rust_field: landfall_codegen::rust::field,
        });
        let parts = match &source {
            Some(source) => run.basis.settings.divided(source, shader.clone()),
            None => vec![empty()],
        };
        for (number, part) in parts.iter().enumerate() {
            let is_first = number == 0;
            page.add(&Part {
                path: &part.title(),
                shader: part,
                by_rules: &source.as_ref().map_or_else(Vec::new, |one| by_rules(run, one, part)),
                findings: if is_first { &found } else { &[] },
                compared: compared.as_ref().filter(|_| is_first),
            });
        }
    }
    // Findings in includes, mirrors, locks and configurations.
    for (path, found) in by_path {
        let shader = ShaderLayout::empty(path.to_string(), Language::Glsl, None);
        page.add(&Part { path, shader: &shader, by_rules: &[], findings: &found, compared: None });
    }
    page.finish(if args.is_report { "Landfall report" } else { "Landfall check" })
}

fn source(run: &Run<'_>, path: &str) -> Option<Source> {
    let bytes = match run.stdin.get(path) {
        Some(text) => text.clone().into_bytes(),
        None => source::read_bytes(Path::new(path), run.basis.max_bytes()).ok()?,
    };
    run.basis.source(path, bytes).ok()
}

/// The layouts of a shader under all rules.
fn by_rules(run: &Run<'_>, source: &Source, shader: &ShaderLayout) -> Vec<(Rules, ShaderLayout)> {
    if shader.blocks.is_empty() {
        return Vec::new();
    }
    let under = |rules| {
        let options = run.basis.settings.options_of(source, shader, &run.basis.options());
        (rules, landfall_layout::layout(source, &options.with_rules(Some(rules))))
    };
    RULES.into_iter().map(under).collect()
}

/// The layout that a lock records; `None` for what is no lock, which is a finding.
fn locked(path: &Path) -> Option<ShaderLayout> {
    let text = String::from_utf8(read::file(path)?).ok()?;
    let locks = lock::read_all(&path.display().to_string(), &text).ok()?;
    let mut layout = locks.first()?.layout();
    layout.path = path.display().to_string();
    Some(layout)
}
