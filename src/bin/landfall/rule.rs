//! `landfall rule`: lists the lints and hazards, or explains them.

use landfall_layout::diagnostic::Code;
use std::fmt::Write as _;

use landfall_ir::analysis::hazard::Hazard;
use landfall_layout::format::Paint;
use landfall_layout::format::columns::{WIDTH, wrapped};
use landfall_layout::text::edit_distance::suggestion;
use landfall_layout::{Diagnostic, Severity};
use landfall_lint::{LINTS, Lint, lint};

use crate::args::{RuleArgs, RuleFormat};
use crate::output::{CommandFailure, FindingForm, Outcome, Streams};

/// A lint, which may share its code with a hazard, or a hazard without a lint of its code.
#[derive(Clone, Copy)]
enum ListedRule {
    Lint(&'static Lint),
    Hazard(Hazard),
}

impl ListedRule {
    /// Every rule, sorted by code.
    fn all() -> Vec<ListedRule> {
        // A hazard with a lint of its code is told with that lint.
        let hazards = Hazard::ALL.into_iter().filter(|hazard| lint(hazard.code()).is_none());
        let lints = LINTS.iter().map(|lint| ListedRule::Lint(lint));
        let mut all: Vec<ListedRule> = lints.chain(hazards.map(ListedRule::Hazard)).collect();
        all.sort_by_key(|rule| rule.code());
        all
    }

    /// The rule with this code, or that of a diagnostic that rejects what the rule is about.
    fn named(name: &str) -> Option<ListedRule> {
        let of = |hazard: Hazard| {
            lint(hazard.code()).map_or(ListedRule::Hazard(hazard), ListedRule::Lint)
        };
        lint(name).map(ListedRule::Lint).or_else(|| Hazard::named(name).map(of))
    }

    fn code(self) -> &'static str {
        match self {
            ListedRule::Lint(lint) => lint.code,
            ListedRule::Hazard(hazard) => hazard.code(),
        }
    }

    /// Whether this build can find it.
    fn is_built(self) -> bool {
        match self {
            ListedRule::Lint(lint) => lint.is_built(),
            ListedRule::Hazard(_) => true,
        }
    }

    fn level(self) -> &'static str {
        match self {
            ListedRule::Lint(lint) => lint.level.name(),
            ListedRule::Hazard(hazard) => hazard.info().level.name(),
        }
    }

    fn what(self) -> &'static str {
        match self {
            ListedRule::Lint(lint) => lint.what,
            ListedRule::Hazard(hazard) => hazard.info().what,
        }
    }

    /// The hazard with the same code, if any.
    fn hazard(self) -> Option<Hazard> {
        match self {
            ListedRule::Lint(lint) => {
                lint.hazards().iter().copied().find(|h| h.code() == lint.code)
            }
            ListedRule::Hazard(hazard) => Some(hazard),
        }
    }
}

pub fn run(args: &RuleArgs, streams: &Streams) -> Result<Outcome, CommandFailure> {
    let rules: Vec<ListedRule> = match &args.code {
        None => ListedRule::all(),
        Some(code) => match ListedRule::named(code) {
            Some(rule) => vec![rule],
            None if Code::from_name(code).is_some() => {
                streams.exactly(&of_code(code, args.format))?;
                return Ok(Outcome::Clean);
            }
            None => return Err(streams.style(FindingForm::Human).refused(unknown(code))),
        },
    };
    if let (Some(name), [rule]) = (&args.code, &rules[..]) {
        // The code given may be a diagnostic's.
        if name != rule.code() {
            streams.notes(&format!("note: `{name}` is called `{}`\n", rule.code()));
        }
    }
    let in_full = args.all || args.code.is_some();
    let text = match args.format {
        // One rule is an object, and all are an array.
        RuleFormat::Json => json(&rules, args.code.is_some()),
        RuleFormat::Md if in_full => join(&rules, markdown),
        RuleFormat::Md => markdown_tables(&rules),
        RuleFormat::Human if in_full => join(&rules, |rule| explanation(rule, streams.paint)),
        RuleFormat::Human => table(&rules, streams.paint),
    };
    // Built-in texts need no escaping.
    streams.exactly(&text)?;
    Ok(Outcome::Clean)
}

/// The explanation of a code that is neither a lint's nor a hazard's.
fn of_code(code: &str, format: RuleFormat) -> String {
    let what = "found where a shader or another input is read";
    let why = "As an error it is the reason why there is no result, and no level changes that. As a \
               warning its level is `warn`, which `-A` and `-D` change.";
    match format {
        RuleFormat::Json => {
            let object =
                serde_json::json!({ "code": code, "level": "warn", "what": what, "why": why });
            format!("{object}\n")
        }
        RuleFormat::Md => format!("## `{code}`\n\nLevel: warn.\n\n{what}\n\n**Why.** {why}\n"),
        RuleFormat::Human => {
            let mut text = format!("{code}  (warn by default; no lint)\n");
            sections(&mut text, &[("what", what), ("why", why)], Paint::Plain);
            text
        }
    }
}

fn unknown(code: &str) -> Diagnostic {
    let help = suggestion(code, ListedRule::all().iter().map(|rule| rule.code()))
        .unwrap_or_else(|| "`landfall rule` lists the lints and hazards".to_string());
    let message = format!("there is no lint or hazard `{code}`");
    Diagnostic::without_place(Code::UnknownLint, Severity::Error, message).with_help(help)
}

fn join(rules: &[ListedRule], text: impl Fn(ListedRule) -> String) -> String {
    rules.iter().map(|rule| text(*rule)).collect::<Vec<_>>().join("\n")
}

/// A line per rule: code, level and description.
fn table(rules: &[ListedRule], paint: Paint) -> String {
    let width = rules.iter().map(|rule| rule.code().len()).max().unwrap_or(0);
    let mut text = String::new();
    for rule in rules {
        let indent = " ".repeat(width + 9);
        let lines = wrapped(rule.what(), WIDTH.saturating_sub(width + 9));
        let what = lines.join(&format!("\n{indent}"));
        let code = format!("{:<width$}", rule.code());
        // Lints of a feature that this build lacks are listed, too, with a note below.
        let mark = if rule.is_built() { ' ' } else { '*' };
        let _ = writeln!(text, "{}  {:<5}{mark} {what}", strong(&code, paint), rule.level());
    }
    if rules.iter().any(|rule| !rule.is_built()) {
        let _ = writeln!(text, "\n* not in this build: cargo install landfall --features analysis");
    }
    text
}

fn explanation(rule: ListedRule, paint: Paint) -> String {
    match rule {
        ListedRule::Lint(lint) => lint_explanation(lint, paint),
        ListedRule::Hazard(hazard) => {
            let info = hazard.info();
            let head = strong(info.code, paint);
            let level = info.level.name();
            let mut text = format!("{head}  (hazard: {}; {level} in `stress`)\n", info.name);
            sections(&mut text, &[("what", info.what), ("why", info.why)], paint);
            text.push_str(&hazard_sections(hazard, paint));
            text
        }
    }
}

fn lint_explanation(lint: &'static Lint, paint: Paint) -> String {
    let head = strong(lint.code, paint);
    let mut text = format!("{head}  ({} by default)\n", lint.level.name());
    if !lint.is_built() {
        text.push_str("\nnot in this build: cargo install landfall --features analysis\n");
    }
    sections(&mut text, &[("what", lint.what), ("why", lint.why), ("fix", lint.fix)], paint);
    let _ = write!(text, "\n{}\n", strong("example", paint));
    for line in lint.example.trim_end().lines() {
        let _ = writeln!(text, "{}", format!("  {line}").trim_end());
    }
    match ListedRule::Lint(lint).hazard() {
        Some(hazard) => text.push_str(&hazard_sections(hazard, paint)),
        None if lint.hazards().is_empty() => {}
        None => {
            let codes: Vec<&str> = lint.hazards().iter().map(|hazard| hazard.code()).collect();
            sections(&mut text, &[("hazards", &codes.join(", "))], paint);
        }
    }
    let _ = write!(
        text,
        "\nallow it for one line with `// landfall: allow({})`, or set its level:\n  \
         landfall.toml  [levels]  {} = \"allow\"\n  command line   -A {}\n",
        lint.code, lint.code, lint.code
    );
    text
}

/// The sections of a hazard after `what` and `why`.
fn hazard_sections(hazard: Hazard, paint: Paint) -> String {
    let info = hazard.info();
    let mut text = String::new();
    if let Some(threshold) = info.threshold {
        let words = format!("{} ({}): {}", threshold.value, threshold.of, threshold.why);
        sections(&mut text, &[("threshold", &words)], paint);
    }
    sections(&mut text, &[("robust form", info.robust), ("source", info.citation)], paint);
    let lints: Vec<&str> = lints_of(hazard).map(|lint| lint.code).collect();
    if !lints.is_empty() {
        sections(&mut text, &[("lints", &lints.join(", "))], paint);
    }
    if let Some(name) = hazard.rejection() {
        sections(&mut text, &[("other names", name)], paint);
    }
    text
}

/// The lints that report code with this hazard.
fn lints_of(hazard: Hazard) -> impl Iterator<Item = &'static Lint> {
    LINTS.iter().copied().filter(move |lint| lint.hazards().contains(&hazard))
}

fn sections(text: &mut String, sections: &[(&str, &str)], paint: Paint) {
    for (title, words) in sections {
        let _ = write!(text, "\n{}\n", strong(title, paint));
        for line in wrapped(words, WIDTH - 2) {
            let _ = writeln!(text, "  {line}");
        }
    }
}

fn markdown(rule: ListedRule) -> String {
    let (code, level, what) = (rule.code(), rule.level(), rule.what());
    match rule {
        ListedRule::Lint(lint) => format!(
            "## `{code}`\n\nLevel: {level}.\n\n{what}\n\n**Why.** {}\n\n**Fix.** {}\n\n```\n{}\n```\n",
            lint.why,
            lint.fix,
            lint.example.trim_end()
        ),
        ListedRule::Hazard(hazard) => {
            let info = hazard.info();
            let threshold = info.threshold.map_or(String::new(), |threshold| {
                format!(
                    "**Threshold.** {} ({}): {}\n\n",
                    threshold.value, threshold.of, threshold.why
                )
            });
            format!(
                "## `{code}`\n\nHazard, level: {level}.\n\n{what}\n\n**Why.** {}\n\n{threshold}\
                 **Fix.** {}\n\n**Source.** {}\n",
                info.why, info.robust, info.citation
            )
        }
    }
}

/// A Markdown table of lints and one of hazards.
fn markdown_tables(rules: &[ListedRule]) -> String {
    let (mut lints, mut hazards) = (
        "| code | level | what |\n|---|---|---|\n".to_string(),
        "\n| hazard | level | what |\n|---|---|---|\n".to_string(),
    );
    for rule in rules {
        let what = rule.what().replace('|', "\\|");
        let text = match rule {
            ListedRule::Lint(_) => &mut lints,
            ListedRule::Hazard(_) => &mut hazards,
        };
        let _ = writeln!(text, "| `{}` | {} | {what} |", rule.code(), rule.level());
    }
    lints + &hazards
}

/// A lint or hazard in JSON. `example` and `hazards` are of lints only; `hazard` is present if a
/// hazard has the code.
#[derive(serde::Serialize)]
struct Object {
    code: &'static str,
    level: &'static str,
    what: &'static str,
    why: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    example: Option<&'static str>,
    fix: &'static str,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    hazards: Vec<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    hazard: Option<RuleHazard>,
}

#[derive(serde::Serialize)]
struct RuleHazard {
    name: &'static str,
    other_names: Vec<&'static str>,
    threshold: Option<ThresholdObject>,
    robust: &'static str,
    source: &'static str,
    lints: Vec<&'static str>,
}

#[derive(serde::Serialize)]
struct ThresholdObject {
    value: f64,
    of: &'static str,
    why: &'static str,
}

impl RuleHazard {
    fn from_hazard(hazard: Hazard) -> RuleHazard {
        let info = hazard.info();
        RuleHazard {
            name: info.name,
            other_names: hazard.rejection().into_iter().collect(),
            threshold: info.threshold.map(|threshold| ThresholdObject {
                value: threshold.value,
                of: threshold.of,
                why: threshold.why,
            }),
            robust: info.robust,
            source: info.citation,
            lints: lints_of(hazard).map(|lint| lint.code).collect(),
        }
    }
}

/// A single object, or an array.
fn json(rules: &[ListedRule], one: bool) -> String {
    let object = |rule: ListedRule| {
        let (why, example, fix, hazards) = match rule {
            ListedRule::Lint(lint) => (lint.why, Some(lint.example), lint.fix, lint.hazards()),
            ListedRule::Hazard(hazard) => (hazard.info().why, None, hazard.info().robust, &[][..]),
        };
        Object {
            code: rule.code(),
            level: rule.level(),
            what: rule.what(),
            why,
            example,
            fix,
            hazards: hazards.iter().map(|hazard| hazard.code()).collect(),
            hazard: rule.hazard().map(RuleHazard::from_hazard),
        }
    };
    let line = |rule: &ListedRule| serde_json::to_string(&object(*rule)).expect("keys are strings");
    let lines: Vec<String> = rules.iter().map(line).collect();
    if one { format!("{}\n", lines.join("")) } else { format!("[\n{}\n]\n", lines.join(",\n")) }
}

fn strong(text: &str, paint: Paint) -> String {
    match paint {
        Paint::Plain => text.to_string(),
        Paint::Ansi => format!("\x1b[1m{text}\x1b[0m"),
    }
}
