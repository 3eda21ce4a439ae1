//! `landfall rule` explains every code of a lint or hazard that any command can print.
//! `SNAPSHOTS=overwrite` writes the page of the book below its introduction.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use landfall_ir::analysis::hazard::Hazard;
use landfall_ir::analysis::occurrence::Kind;
use landfall_light::reference::UndefinedReason;
use landfall_lint::LINTS;
use landfall_lint::hazard_findings::lint_of;
use snapbox::{Data, str};

use crate::support::command::{self, Ran};

fn rule(arguments: &[&str]) -> Ran {
    command::run(&[&["rule"], arguments].concat())
}

/// The codes of all places that print one.
fn printed() -> BTreeSet<&'static str> {
    let mut codes = BTreeSet::new();
    // `check`.
    codes.extend(LINTS.iter().map(|lint| lint.code));
    // `lights`: the lint, and the hazard below it.
    for &kind in Kind::ALL {
        codes.insert(lint_of(kind).code);
        assert!(!kind.hazards().is_empty(), "{kind:?}");
        codes.extend(kind.hazards().iter().map(|hazard| hazard.code()));
    }
    // `stress`.
    codes.extend(Hazard::ALL.into_iter().map(Hazard::code));
    // `render` against the reference: fragments without a value, and those at an edge.
    codes.extend(UndefinedReason::ALL.into_iter().map(|undef| undef.hazard().code()));
    codes.insert(Hazard::ConeEdge.code());
    codes
}

#[test]
fn every_printed_code_is_listed_and_explained() {
    let list = rule(&[]).out;
    let json = rule(&["--format", "json"]).json();
    let listed: BTreeSet<&str> = json
        .as_array()
        .expect("an array")
        .iter()
        .map(|rule| rule["code"].as_str().expect("a code"))
        .collect();
    for code in printed() {
        assert!(listed.contains(code), "{code} is not in the JSON");
        assert!(list.lines().any(|line| line.split(' ').next() == Some(code)), "{code} in {list}");
        let one = rule(&[code]);
        let out = &one.out;
        assert_eq!((one.code, one.err.as_str()), (0, ""), "{code}");
        assert!(out.starts_with(&format!("{code}  (")), "{out}");
        for section in ["\nwhat\n  ", "\nwhy\n  "] {
            assert!(out.contains(section), "{code} has no {section:?} in\n{out}");
        }
    }
}

#[test]
fn a_hazard_is_explained_with_its_threshold_robust_form_and_source() {
    for hazard in Hazard::ALL {
        let info = hazard.info();
        let out = rule(&[info.code]).out.split_whitespace().collect::<Vec<_>>().join(" ");
        let flat = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
        for said in [info.robust, info.citation] {
            assert!(out.contains(&flat(said)), "{said:?} is not in {out}");
        }
        if let Some(threshold) = info.threshold {
            let said = format!("threshold {} ({})", threshold.value, threshold.of);
            assert!(out.contains(&said), "{said:?} is not in {out}");
        }
    }
}

#[test]
fn the_code_of_a_rejection_is_found_with_a_note() {
    let mut found = 0;
    for hazard in Hazard::ALL {
        let Some(name) = hazard.rejection() else { continue };
        let one = rule(&[name]);
        assert!(one.out.starts_with(&format!("{}  (", hazard.code())), "{name}");
        assert_eq!(one.err, format!("note: `{name}` is called `{}`\n", hazard.code()));
        found += 1;
    }
    assert!(found >= 8, "{found}");
}

/// A guard in the fix of a lint is the threshold of one of its hazards, or the square of it.
#[test]
fn lints_and_hazards_give_the_same_guards() {
    let mut guards = 0;
    for lint in LINTS {
        let thresholds = lint.hazards().iter().filter_map(|hazard| hazard.info().threshold);
        let known: Vec<String> =
            thresholds.flat_map(|t| [t.literal(), t.squared_literal()]).collect();
        for (at, _) in lint.fix.match_indices("1.0e-") {
            let end = lint.fix[at..].find([')', ',', ' ']).map_or(lint.fix.len(), |n| at + n);
            let guard = &lint.fix[at..end];
            assert!(known.iter().any(|k| k == guard), "{}: {guard}, not {known:?}", lint.code);
            guards += 1;
        }
    }
    assert!(guards >= 3, "{guards}");
}

#[test]
fn a_code_of_nothing_is_refused_with_the_nearest() {
    let one = rule(&["narow-cone"]);
    one.code(2).stdout_eq("").stderr_eq(str![[r#"
error[unknown-lint]: there is no lint or hazard `narow-cone`
  |
  = help: did you mean `narrow-cone`?


"#]]);
}

#[test]
fn the_book_lists_and_explains_every_lint_and_hazard() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/src/lints.md");
    let page = fs::read_to_string(&file).expect("the page is there");
    let introduction = &page[..page.find("| code |").expect("the page has a table of lints")];
    let tables = rule(&["--format", "md"]).out;
    let explanations = rule(&["--all", "--format", "md"]).out;
    let printed = format!("{introduction}{tables}\n{explanations}");
    let book = snapbox::Assert::new().action_env("SNAPSHOTS");
    book.eq(Data::text(printed).raw(), Data::read_from(&file, None).raw());
}

#[test]
fn lights_gives_each_hazard_the_default_level_of_its_lint() {
    let report = command::run(&["lights", "shaders", "--format", "json"]).json();
    let shaders = report["shaders"].as_array().expect("shaders");
    let hazards = shaders.iter().flat_map(|shader| shader["hazards"].as_array().expect("hazards"));
    let mut levels = BTreeSet::new();
    for hazard in hazards {
        let code = hazard["code"].as_str().expect("a code");
        let lint = LINTS.iter().find(|lint| lint.code == code).expect("a lint's code");
        assert_eq!(hazard["level"], lint.level.name(), "{code}");
        levels.insert(lint.level.name());
    }
    assert_eq!(levels, BTreeSet::from(["allow", "warn"]), "both are among the shaders");
}
