//! Lints on waste, traps, mirrors and other backends: what each reports, where,
//! with which numbers, and what it must leave alone.
//!
//! Every lint has a bad text and a good one that differs in nothing else.

mod advice;
mod driver;
#[cfg(feature = "cli")]
mod mirror;
#[cfg(feature = "cli")]
mod mirror_helps;
#[cfg(feature = "cli")]
mod mirror_libraries;
mod naga;
mod reorder;
#[cfg(feature = "cli")]
use crate::support::rustc;
mod used;
mod variants;

use landfall_layout::Options;
use landfall_layout::finding::{Finding, Level};
use landfall_lint::{Settings, lint};

use crate::asked::{asked, help, said};

/// What a lint finds in one shader.
fn found(code: &str, path: &str, text: &str) -> Vec<Finding> {
    found_with(code, path, text, &Settings::default())
}

fn found_with(code: &str, path: &str, text: &str, settings: &Settings) -> Vec<Finding> {
    asked(code, &[(path, text)], &Options::default().with_naga(true), settings)
}

/// The one finding of a lint.
fn one(code: &str, path: &str, text: &str) -> Finding {
    let mut found = found(code, path, text);
    assert_eq!(found.len(), 1, "{found:#?}");
    found.remove(0)
}

/// A std140 block of those members, the first of them on line 3.
fn std140(members: &str) -> String {
    format!("#version 330 core\nlayout(std140) uniform B {{\n{members}\n}};\nvoid main() {{}}\n")
}

#[test]
fn advice_is_given_only_when_asked_for() {
    let levels = [
        ("array-stride-waste", Level::Allow),
        ("bool-in-block", Level::Allow),
        ("define-changes-layout", Level::Warn),
        ("driver-disagrees", Level::Deny),
        ("mat3-padding", Level::Allow),
        ("naga-disagrees", Level::Warn),
        ("reorder-saves", Level::Allow),
        ("rust-mirror", Level::Deny),
        ("scalar-after-vec3", Level::Allow),
        ("unused-block", Level::Allow),
        ("unused-member", Level::Allow),
        ("vec3-array", Level::Allow),
    ];
    for (code, level) in levels {
        assert_eq!(lint(code).expect("it is listed").level, level, "{code}");
    }
}
