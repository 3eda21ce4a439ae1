//! Hazards of lighting code: each lint with a bad text and good ones that differ in one guard.
//!
//! What is bad and what is good follows from the formulas: a dot product of unit vectors lies in
//! [-1, 1], a difference of points may be zero, zero coefficients divide by zero.

#[cfg(feature = "cli")]
mod cost;
mod flow;
mod texts;

use landfall_layout::finding::{Finding, Level};
use landfall_layout::{Options, Source, layout};
use landfall_lint::{Settings, Subject, run};

/// `line code` of all hazards found when every lint is asked for.
fn found(path: &str, text: &str) -> Vec<String> {
    let findings = findings(path, text, Level::Warn);
    findings.iter().map(|finding| format!("{} {}", finding.place().line, finding.code)).collect()
}

/// What the lints of hazards find; those that are off unless asked for are at `off`.
fn findings(path: &str, text: &str, off: Level) -> Vec<Finding> {
    let source = Source::new(path, text);
    let options = Options::default();
    let shader = layout(&source, &options);
    assert!(!shader.has_errors(), "{:#?}", shader.diagnostics);
    let subject = Subject { source: &source, options: &options, shader: &shader };
    let all = texts::CODES.iter().filter(|code| {
        off == Level::Warn || landfall_lint::lint(code).expect("a lint").level > Level::Allow
    });
    let mut levels = vec![("all".to_string(), Level::Allow)];
    levels.extend(all.map(|code| (code.to_string(), Level::Warn)));
    run::shader(&subject, &Settings { levels, ..Settings::default() })
}

/// Whether a lint finds something.
fn has(code: &str, path: &str, text: &str) -> bool {
    assert!(texts::CODES.contains(&code), "{code}");
    findings(path, text, Level::Warn).iter().any(|finding| finding.code == code)
}

/// The text with `from` replaced, which has to be in it.
fn changed(text: &str, from: &str, to: &str) -> String {
    assert!(text.contains(from), "{from}\n{text}");
    text.replacen(from, to, 1)
}
