//! `landfall rule`: the lints there are, and what one of them is about.

use std::fmt::Write as _;

use landfall_layout::format::Paint;
use landfall_layout::source::Files;
use landfall_lint::{LINTS, Lint, lint};

use crate::args::{RuleArgs, RuleFormat};
use crate::config;
use crate::output::{Failure, FindingForm, Outcome, Streams};

/// Columns of running text.
const WIDTH: usize = 96;

pub fn run(args: &RuleArgs, streams: &Streams) -> Result<Outcome, Failure> {
    let lints: Vec<&Lint> = match &args.code {
        None => LINTS.to_vec(),
        Some(code) => match lint(code) {
            Some(lint) => vec![lint],
            None => {
                let found = config::unknown_code(code);
                let style = streams.style(FindingForm::Human);
                streams.report(&style.text(&[found], &Files::default()));
                return Ok(Outcome::CouldNot);
            }
        },
    };
    let in_full = args.all || args.code.is_some();
    let text = match args.format {
        RuleFormat::Json => json(&lints, args.code.is_some()),
        RuleFormat::Md if in_full => join(&lints, markdown),
        RuleFormat::Md => markdown_table(&lints),
        RuleFormat::Human if in_full => join(&lints, |lint| explanation(lint, streams.paint)),
        RuleFormat::Human => table(&lints, streams.paint),
    };
    // Texts of ours alone.
    streams.exactly(&text)?;
    Ok(Outcome::Clean)
}

fn join(lints: &[&Lint], text: impl Fn(&Lint) -> String) -> String {
    lints.iter().map(|lint| text(lint)).collect::<Vec<_>>().join("\n")
}

/// Code, level and the first sentence of each.
fn table(lints: &[&Lint], paint: Paint) -> String {
    let width = lints.iter().map(|lint| lint.code.len()).max().unwrap_or(0);
    let mut text = String::new();
    for lint in lints {
        let indent = " ".repeat(width + 9);
        let what = wrapped(lint.what, WIDTH.saturating_sub(width + 9)).join(&format!("\n{indent}"));
        let code = format!("{:<width$}", lint.code);
        let _ = writeln!(text, "{}  {:<5}  {what}", strong(&code, paint), lint.level.name());
    }
    text
}

fn explanation(lint: &Lint, paint: Paint) -> String {
    let head = strong(lint.code, paint);
    let mut text = format!("{head}  ({} unless you say otherwise)\n", lint.level.name());
    for (title, words) in [("what", lint.what), ("why", lint.why), ("fix", lint.fix)] {
        let _ = write!(text, "\n{}\n", strong(title, paint));
        for line in wrapped(words, WIDTH - 2) {
            let _ = writeln!(text, "  {line}");
        }
    }
    let _ = write!(text, "\n{}\n", strong("example", paint));
    for line in lint.example.trim_end().lines() {
        let _ = writeln!(text, "{}", format!("  {line}").trim_end());
    }
    let _ = write!(
        text,
        "\nallow it for one line with `// landfall: allow({})`, or set its level:\n  \
         landfall.toml  [levels]  {} = \"allow\"\n  command line   -A {}\n",
        lint.code, lint.code, lint.code
    );
    text
}

fn markdown(lint: &Lint) -> String {
    format!(
        "## `{}`\n\nLevel: {}.\n\n{}\n\n**Why.** {}\n\n**Fix.** {}\n\n```\n{}\n```\n",
        lint.code,
        lint.level.name(),
        lint.what,
        lint.why,
        lint.fix,
        lint.example.trim_end()
    )
}

fn markdown_table(lints: &[&Lint]) -> String {
    let mut text = "| code | level | what |\n|---|---|---|\n".to_string();
    for lint in lints {
        let what = lint.what.replace('|', "\\|");
        let _ = writeln!(text, "| `{}` | {} | {what} |", lint.code, lint.level.name());
    }
    text
}

/// One object, or an array of all.
fn json(lints: &[&Lint], one: bool) -> String {
    #[derive(serde::Serialize)]
    struct Object {
        code: &'static str,
        level: &'static str,
        what: &'static str,
        why: &'static str,
        example: &'static str,
        fix: &'static str,
    }
    let object = |lint: &&Lint| Object {
        code: lint.code,
        level: lint.level.name(),
        what: lint.what,
        why: lint.why,
        example: lint.example,
        fix: lint.fix,
    };
    let line = |lint| serde_json::to_string(&object(lint)).expect("keys are strings");
    let lines: Vec<String> = lints.iter().map(line).collect();
    if one { format!("{}\n", lines.join("")) } else { format!("[\n{}\n]\n", lines.join(",\n")) }
}

fn strong(text: &str, paint: Paint) -> String {
    match paint {
        Paint::Plain => text.to_string(),
        Paint::Ansi => format!("\x1b[1m{text}\x1b[0m"),
    }
}

/// Running text in lines of at most so many characters.
fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let line = lines.last_mut().expect("never empty");
        if !line.is_empty() && line.chars().count() + 1 + word.chars().count() > width {
            lines.push(word.to_string());
            continue;
        }
        if !line.is_empty() {
            line.push(' ');
        }
        line.push_str(word);
    }
    lines
}
