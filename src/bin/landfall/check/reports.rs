//! Writes reports to files and stdout, and a summary line to stderr.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::{self, IsTerminal as _};
use std::path::Path;

use landfall_layout::Error;
use landfall_layout::file::FileWriter;
use landfall_layout::finding::{Finding, Level};
use landfall_layout::format::Paint;
use landfall_layout::format::phrases::number;
use landfall_lint::render::{ReportFormat, ReportOptions, github_summary, report, totals};

use landfall_check::baseline::STALE_BASELINE;
use landfall_check::texts::Texts;

use super::report_root::ReportRoot;
use crate::args::{Form, Report};
use crate::output::{Outcome, Streams};

pub struct Result<'a> {
    pub findings: &'a [Finding],
    pub shaders: usize,
    /// Number of shaders and inputs that could not be checked.
    pub failures: usize,
    pub texts: &'a Texts,
    /// Number of findings that the baseline permits; `None` without a baseline.
    pub permitted: Option<usize>,
    /// Renders the HTML page; `None` without layouts.
    pub page: Option<&'a dyn Fn() -> String>,
}

/// Fails if two reports have the same destination.
pub fn refuse_twice(formats: &[Report]) -> std::result::Result<(), Error> {
    let twice =
        formats.iter().enumerate().find(|(i, a)| formats[..*i].iter().any(|b| a.file == b.file));
    match twice.map(|(_, report)| &report.file) {
        None => Ok(()),
        Some(None) => Err(Error::new("<stdout>", "cannot take two reports")
            .with_help("write all but one to a file: `--format sarif=check.sarif`")),
        Some(Some(file)) => Err(Error::new(file.display().to_string(), "cannot take two reports")),
    }
}

/// Writes every report and the summary line.
pub fn write(
    result: &Result<'_>,
    formats: &[Report],
    statistics: bool,
    mut writer: FileWriter,
    streams: &Streams,
) -> std::result::Result<Outcome, Error> {
    let human = [Report { format: Form::Findings(ReportFormat::Human), file: None }];
    let formats = if formats.is_empty() { &human[..] } else { formats };
    let text = |path: &str| result.texts.of(path);
    let options = |paint| ReportOptions { paint, text: &text, shaders: result.shaders };
    let from_root =
        // Nothing is rebased where the command runs in the root of the repository.
        ReportRoot::find().map(|root| root.findings(result.findings, &result.texts.given));
    let from_root = from_root.as_deref().unwrap_or(result.findings);
    // Those for people and editors keep paths that can be opened from here.
    // Other programs know the repository, not the directory that the command ran in.
    let findings_of = |format| match format {
        ReportFormat::Human | ReportFormat::Short | ReportFormat::Json => result.findings,
        ReportFormat::Github | ReportFormat::Sarif | ReportFormat::Junit => from_root,
    };
    for requested in formats {
        if let Some(file) = &requested.file {
            let text = match requested.format {
                Form::Findings(format) => {
                    let text = report(findings_of(format), format, &options(Paint::Plain));
                    let gap = if text.is_empty() { "" } else { "\n" };
                    match format {
                        ReportFormat::Human => text + gap + &summary(result),
                        ReportFormat::Short
                        | ReportFormat::Json
                        | ReportFormat::Github
                        | ReportFormat::Sarif
                        | ReportFormat::Junit => text,
                    }
                }
                Form::Html => page(result),
            };
            writer.write(file, text)?;
            // No report overwrites another, even through links.
            writer.protect([file]);
        }
    }
    let github = Form::Findings(ReportFormat::Github);
    if formats.iter().any(|requested| requested.format == github) {
        if let Some(path) = std::env::var_os("GITHUB_STEP_SUMMARY").filter(|path| !path.is_empty())
        {
            // Earlier commands of the step may have written to the file.
            let text = github_summary(from_root, &options(Paint::Plain));
            writer.append(Path::new(&path), text)?;
        }
    }
    // At most one report goes to stdout, as `refused` ensures.
    let to_stdout = formats.iter().find(|requested| requested.file.is_none());
    match to_stdout.map(|requested| requested.format) {
        Some(Form::Findings(format)) => {
            print(result, format, findings_of(format), &options, streams)?;
        }
        Some(Form::Html) => streams.source(&page(result))?,
        None => {}
    }
    streams.finish()?;
    if statistics {
        streams.notes(&counts(result.findings));
    }
    streams.notes(&summary(result));
    Ok(outcome(result))
}

fn print<'a>(
    result: &Result<'_>,
    format: ReportFormat,
    findings: &[Finding],
    options: &dyn Fn(Paint) -> ReportOptions<'a>,
    streams: &Streams,
) -> std::result::Result<(), Error> {
    let for_people = match format {
        ReportFormat::Human | ReportFormat::Short => true,
        ReportFormat::Json | ReportFormat::Github | ReportFormat::Sarif | ReportFormat::Junit => {
            false
        }
    };
    let paint = if for_people { streams.paint } else { Paint::Plain };
    let denied: Vec<Finding>;
    // `--quiet` leaves the errors.
    let findings = if for_people && streams.is_quiet() {
        let loud = result.findings.iter().filter(|finding| finding.level() == Level::Deny);
        denied = loud.cloned().collect();
        &denied
    } else {
        findings
    };
    let mut text = report(findings, format, &options(paint));
    if format == ReportFormat::Human && !text.is_empty() && io::stdout().is_terminal() {
        text.push('\n'); // before the summary
    }
    match format {
        ReportFormat::Human | ReportFormat::Short | ReportFormat::Junit => streams.product(&text),
        ReportFormat::Json | ReportFormat::Sarif => streams.json(&text),
        // Workflow commands, already escaped.
        ReportFormat::Github => streams.exactly(&text),
    }
}

fn page(result: &Result<'_>) -> String {
    result.page.map(|page| page()).unwrap_or_default()
}

fn outcome(result: &Result<'_>) -> Outcome {
    // With a baseline, every finding that it lacks fails.
    let fails = |finding: &Finding| match result.permitted {
        Some(_) => finding.code != STALE_BASELINE,
        None => finding.level() == Level::Deny,
    };
    match result.findings.iter().any(fails) {
        // What could not be checked outweighs what was found.
        _ if result.failures > 0 => Outcome::CouldNot,
        true => Outcome::Findings,
        false => Outcome::Clean,
    }
}

/// The summary line: `checked 73 shaders: 2 errors, 5 warnings; 3 fixable with --fix`.
fn summary(result: &Result<'_>) -> String {
    let fixable = result.findings.iter().filter(|finding| !finding.fix.is_empty()).count();
    let mut text = format!("checked {}", totals(result.findings, result.shaders));
    if fixable > 0 {
        let _ = write!(text, "; {} fixable with --fix", number(fixable as u64));
    }
    if let Some(permitted) = result.permitted.filter(|permitted| *permitted > 0) {
        let _ = write!(text, "; {} in the baseline", number(permitted as u64));
    }
    text.push('\n');
    text
}

/// The number of findings per lint, in descending order.
fn counts(findings: &[Finding]) -> String {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for finding in findings {
        *counts.entry(&finding.code).or_default() += 1;
    }
    let mut rows: Vec<(&str, usize)> = counts.into_iter().collect();
    rows.sort_by_key(|(code, count)| (usize::MAX - count, *code));
    rows.into_iter().fold(String::new(), |mut text, (code, count)| {
        let _ = writeln!(text, "{count:>6}  {code}");
        text
    })
}
