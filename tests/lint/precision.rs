//! Precision and recall of lints that have to guess what belongs together, or what a comment means.
//!
//! Each fixture is a set of shaders as people write them, with the lines on which the lint has to
//! report. Which numbers are wrong follows from std140 and from the rules of WGSL, worked out by
//! hand. Precision is the share of the findings that stand on such a line; recall the share of
//! such lines with a finding. Forms that are known to be missed are among the fixtures.

mod comments;
mod copies;
mod hazards;
mod inferred;
mod layouts;
mod macros;
mod mirrors;
mod stages;

use landfall_layout::Options;
use landfall_layout::finding::Finding;
use landfall_lint::Settings;

use crate::asked::asked;

/// Shaders that are checked together.
struct Fixture {
    /// What it shows, for messages.
    name: String,
    files: Vec<(String, String)>,
    settings: Settings,
    /// File and line of each finding there has to be.
    expected: Vec<(String, u32)>,
}

impl Fixture {
    fn of(name: impl Into<String>, files: &[(&str, &str)], expected: &[(&str, u32)]) -> Fixture {
        let files = files.iter().map(|(path, text)| (path.to_string(), text.to_string()));
        let expected = expected.iter().map(|(path, line)| (path.to_string(), *line));
        Fixture {
            name: name.into(),
            files: files.collect(),
            settings: Settings::default(),
            expected: expected.collect(),
        }
    }

    /// One shader. A finding is expected on each line that ends with `//<`, and on each that ends
    /// with `//?`, where the lint is known to miss it.
    fn marked(name: &str, text: &str) -> Fixture {
        let marked = text
            .lines()
            .zip(1..)
            .filter(|(line, _)| line.ends_with("//<") || line.ends_with("//?"));
        let expected: Vec<(&str, u32)> = marked.map(|(_, line)| ("a.frag", line)).collect();
        Fixture::of(name, &[("a.frag", text)], &expected)
    }

    fn with(self, settings: Settings) -> Fixture {
        Fixture { settings, ..self }
    }

    fn found(&self, code: &str) -> Vec<Finding> {
        asked(code, &self.files, &Options::default(), &self.settings)
    }
}

/// How a lint does over its fixtures.
#[derive(Debug, Default)]
struct Score {
    right: usize,
    false_words: Vec<String>,
    missed: Vec<String>,
}

impl Score {
    fn of(code: &str, fixtures: &[Fixture]) -> Score {
        let mut score = Score::default();
        for fixture in fixtures {
            let mut left = fixture.expected.clone();
            for finding in fixture.found(code) {
                let at = finding.place();
                match left.iter().position(|(path, line)| *path == at.path && *line == at.line) {
                    Some(known) => {
                        left.remove(known);
                        score.right += 1;
                    }
                    None => {
                        let text = format!("{}: {}: {}", fixture.name, at.line, finding.message);
                        score.false_words.push(text);
                    }
                }
            }
            let line_of = |path: &str, line: u32| {
                let (_, text) = fixture.files.iter().find(|(other, _)| other == path)?;
                text.lines().nth(line as usize - 1)
            };
            score.missed.extend(left.iter().map(|(path, line)| {
                format!("{}: {line}: {}", fixture.name, line_of(path, *line).unwrap_or_default())
            }));
        }
        score
    }

    /// What differs from the marks of the texts, for messages; nothing if a finding stands on each
    /// `//<` and on no other line, none of them on a `//?`.
    fn differences(&self, code: &str, texts: &[&str]) -> String {
        let Score { right, false_words, missed } = self;
        let marked = |mark| texts.iter().map(|text| text.matches(mark).count()).sum::<usize>();
        assert!(marked("//<") > 0, "{code} has nothing to report");
        let are_known = missed.iter().all(|line| line.ends_with("//?"));
        let counts = (*right, missed.len(), false_words.len());
        if are_known && counts == (marked("//<"), marked("//?"), 0) {
            return String::new();
        }
        format!("{code}: missed {missed:#?}, falsely {false_words:#?}\n")
    }

    fn precision(&self) -> f64 {
        self.right as f64 / (self.right + self.false_words.len()) as f64
    }

    fn recall(&self) -> f64 {
        self.right as f64 / (self.right + self.missed.len()) as f64
    }

    /// Fails where either number falls below its limit, and names what is wrong.
    fn at_least(&self, precision: f64, recall: f64) {
        let (p, r) = (self.precision(), self.recall());
        assert!(p >= precision, "precision {p:.3}: {:#?}", self.false_words);
        assert!(r >= recall, "recall {r:.3}: {:#?}", self.missed);
    }
}

/// Lints that compare numbers which are given, and guess nothing: their own tests hold each number.
const GIVEN: &[&str] = &[
    "buffer-too-small",
    "compiled-differs",
    "driver-disagrees",
    "invalid-shader",
    "layout-drift",
    "length-from-use",
    "lock-missing",
    "lock-orphan",
    "naga-disagrees",
    "not-analysed",
    "not-proved",
    "over-limit",
    "rust-mirror-unknown",
    "specialised-length",
    "stale-assertions",
    "target-changes-layout",
    "undefined-macro",
    "uniform-constraints",
    "unknown-block",
    "unreached-block",
    "unused-allow",
];

/// Lints with a test of their own below this module.
const ALONE: &[&str] =
    &["block-mismatch", "define-changes-layout", "rust-mirror", "stale-comment", "webgl2-size"];

#[test]
fn every_lint_that_guesses_has_fixtures() {
    let tables = [hazards::BODIES, hazards::SHADERS, layouts::CORPUS, layouts::USES];
    let tables = tables.into_iter().flatten().map(|(code, _)| code);
    let mut known: Vec<&str> = tables.chain(GIVEN).chain(ALONE).copied().collect();
    known.sort_unstable();
    let mut all: Vec<&str> = landfall_lint::LINTS.iter().map(|lint| lint.code).collect();
    all.sort_unstable();
    assert_eq!(known, all);
}
