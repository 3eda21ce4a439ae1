//! Lints about copies, rules, comments, limits and tables: each reports its bad twin, with both
//! numbers in the right place, and says nothing of the good one.
//!
//! Numbers are computed by hand from the rules of std140 and std430 (OpenGL 4.6 §7.6.2.2), or
//! stand in the specifications' tables of limits; what does not link is glslang's word.

mod comments;
mod copies;
mod limits;
mod rules;
mod tables;

use landfall_layout::finding::Finding;
use landfall_layout::{Options, Source};
use landfall_lint::settings::Target;
use landfall_lint::{Settings, lint};

use crate::asked::asked;

/// What a lint finds in those files, asked the way `landfall check` asks.
fn found(code: &str, files: &[(&str, &str)], settings: &Settings) -> Vec<Finding> {
    asked(code, files, &Options::default(), settings)
}

/// What a lint finds in one file.
fn found_in(code: &str, path: &str, text: &str) -> Vec<Finding> {
    found(code, &[(path, text)], &Settings::default())
}

fn with_targets(targets: &[Target]) -> Settings {
    Settings { targets: targets.to_vec(), ..Settings::default() }
}

fn messages(findings: &[Finding]) -> Vec<&str> {
    findings.iter().map(|finding| finding.message.as_str()).collect()
}

/// The only finding there is.
fn only(findings: Vec<Finding>) -> Finding {
    let [finding] = findings.as_slice() else { panic!("not one finding: {findings:#?}") };
    finding.clone()
}

/// `3:5`.
fn place(finding: &Finding) -> String {
    format!("{}:{}", finding.place().line, finding.place().column)
}

/// A file with every edit made.
fn edited(text: &str, findings: &[Finding]) -> String {
    let mut edits: Vec<_> = findings.iter().flat_map(|finding| &finding.fix).collect();
    edits.sort_by_key(|edit| std::cmp::Reverse(edit.at.start));
    let mut text = text.to_string();
    for edit in edits {
        text.replace_range(edit.at.start as usize..edit.at.end as usize, &edit.new);
    }
    text
}

#[test]
fn every_lint_says_what_why_and_how_it_is_mended() {
    for code in [
        "block-mismatch",
        "rules-undeclared",
        "stale-comment",
        "over-limit",
        "webgl2-size",
        "push-constant-limit",
        "buffer-too-small",
    ] {
        let lint = lint(code).expect(code);
        for text in [lint.what, lint.why, lint.fix] {
            assert!(text.len() > 20, "{code}");
            assert!(!text.contains("  "), "{code}: a line break left its indent in {text:?}");
        }
        let shader =
            landfall_layout::layout(&Source::new("a.frag", lint.example), &Options::default());
        assert!(!shader.has_errors(), "{code}: {:#?}", shader.diagnostics);
    }
}
