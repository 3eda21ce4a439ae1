//! The HTML page of `check` and `report`: layouts, findings, and what changed since the locks.
//!
//! A pass may come from a cache, without layouts: the shaders are laid out again.

use std::collections::BTreeMap;
use std::path::Path;

use landfall_check::files;
use landfall_check::pass::{CheckRun, Pass};
use landfall_check::texts::Texts;
use landfall_layout::diff::{Side, diff};
use landfall_layout::finding::Finding;
use landfall_layout::format::diff::Compared;
use landfall_layout::{Language, Rules, ShaderLayout, Source, lock};
use landfall_web::html::{Page, Part, RULES};

use super::lock_of;

/// The page, opened at the block of the first shader that `at` names.
pub fn page(
    title: &str,
    check: &CheckRun<'_>,
    pass: &Pass,
    findings: &[Finding],
    texts: &Texts,
    at: Option<&str>,
) -> String {
    // Findings of each shader; what is left at the end belongs to no shader.
    let mut by_path: BTreeMap<&str, Vec<&Finding>> = BTreeMap::new();
    for finding in findings {
        by_path.entry(&finding.place().path).or_default().push(finding);
    }
    let text = |path: &str| texts.of(path);
    let mut page = Page::opened_at(at);
    for checked in &pass.checked {
        if check.stop.is_set() {
            break;
        }
        let found = by_path.remove(checked.path.as_str()).unwrap_or_default();
        let source = check.source(&checked.path);
        let empty = || ShaderLayout::empty(checked.path.clone(), Language::Glsl, None);
        let shader = source
            .as_ref()
            .map_or_else(empty, |source| check.basis.settings.layout(source, &check.options()));
        let lock = lock_of(check, checked);
        // `--against` compares with a revision, otherwise the locks tell what was.
        let old = match check.against {
            Some(against) => against.layout(&checked.path, &check.config.root, check.basis),
            None => lock.and_then(|lock| locked(&lock)),
        };
        // A layout with errors lacks members: everything would seem to be removed.
        let old = old.filter(|_| !shader.has_errors());
        let blocks =
            old.as_ref().map(|old| diff(Side::from_shader(old), Side::from_shader(&shader)));
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
            Some(source) => check.basis.settings.divided(source, shader.clone()),
            None => vec![empty()],
        };
        for (number, part) in parts.iter().enumerate() {
            // Findings and changes are shown once, at the first of the parts that a file has.
            let is_first = number == 0;
            page.add(&Part {
                path: &part.path,
                shader: part,
                by_rules: &source.as_ref().map_or_else(Vec::new, |one| by_rules(check, one, part)),
                findings: if is_first { &found } else { &[] },
                text: &text,
                compared: compared.as_ref().filter(|_| is_first),
            });
        }
    }
    // Findings in includes, mirrors, locks and configurations.
    for (path, found) in by_path {
        let shader = ShaderLayout::empty(path.to_string(), Language::Glsl, None);
        page.add(&Part {
            path,
            shader: &shader,
            by_rules: &[],
            findings: &found,
            text: &text,
            compared: None,
        });
    }
    page.finish(title)
}

/// The layouts of a shader under all rules.
fn by_rules(
    check: &CheckRun<'_>,
    source: &Source,
    shader: &ShaderLayout,
) -> Vec<(Rules, ShaderLayout)> {
    if shader.blocks.is_empty() {
        return Vec::new();
    }
    let under = |rules| {
        let options = check.basis.settings.options_of(source, shader, &check.options());
        (rules, landfall_layout::layout(source, &options.with_rules(Some(rules))))
    };
    RULES.into_iter().map(under).collect()
}

/// The layout that a lock records; `None` for what is no lock, which is a finding.
fn locked(path: &Path) -> Option<ShaderLayout> {
    let text = String::from_utf8(files::file(path)?).ok()?;
    let locks = lock::read_all(&path.display().to_string(), &text).ok()?;
    let mut layout = locks.first()?.layout();
    layout.path = path.display().to_string();
    Some(layout)
}
