//! JUnit's XML as Jenkins and GitLab read it: a suite for each file, a case for each finding.
//!
//! Findings that fail the run are failures and warnings are skipped cases. One more case stands for
//! all shaders, so that the report of a clean run is not empty.

use super::{severity, short, stable};
use landfall_layout::finding::{Finding, Level};
use landfall_layout::text::escape::xml;

pub(super) fn report(findings: &[&Finding], shaders: usize) -> String {
    let numbers = stable::numbers(findings);
    let mut suites: Vec<(&str, Vec<(&Finding, u32)>)> = Vec::new();
    for (finding, number) in findings.iter().zip(numbers) {
        let path = finding.place().path.as_str();
        match suites.iter_mut().find(|(name, _)| *name == path) {
            Some((_, cases)) => cases.push((finding, number)),
            None => suites.push((path, vec![(finding, number)])),
        }
    }
    let counts = Counts::from_findings(findings);
    // With the case that stands for all shaders.
    let all = Counts { tests: counts.tests + 1, ..counts };
    let mut text = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    text.push_str(&format!("<testsuites name=\"landfall\"{}>\n", all.attributes()));
    let one = Counts { tests: 1, failures: 0, skipped: 0 };
    text.push_str(&format!("  <testsuite name=\"landfall\"{}>\n", one.attributes()));
    text.push_str(&format!(
        "    <properties>\n      <property name=\"shaders\" value=\"{shaders}\"/>\n    </properties>\n"
    ));
    text.push_str("    <testcase classname=\"landfall\" name=\"all shaders were checked\"/>\n");
    text.push_str("  </testsuite>\n");
    for (path, cases) in suites {
        let of_suite: Vec<&Finding> = cases.iter().map(|(finding, _)| *finding).collect();
        let attributes = Counts::from_findings(&of_suite).attributes();
        text.push_str(&format!("  <testsuite name=\"{}\"{attributes}>\n", xml(path)));
        text.extend(cases.iter().map(|(finding, number)| case(finding, *number)));
        text.push_str("  </testsuite>\n");
    }
    text.push_str("</testsuites>\n");
    text
}

struct Counts {
    tests: usize,
    failures: usize,
    skipped: usize,
}

impl Counts {
    fn from_findings(findings: &[&Finding]) -> Counts {
        let failures = findings.iter().filter(|finding| finding.level() == Level::Deny).count();
        Counts { tests: findings.len(), failures, skipped: findings.len() - failures }
    }

    fn attributes(&self) -> String {
        let Counts { tests, failures, skipped } = self;
        format!(" tests=\"{tests}\" failures=\"{failures}\" errors=\"0\" skipped=\"{skipped}\"")
    }
}

fn case(finding: &Finding, number: u32) -> String {
    let mut name = format!("{} {}", finding.code, finding.about);
    if number > 1 {
        name.push_str(&format!(" ({number})"));
    }
    let path = xml(&finding.place().path);
    let line = match finding.place().line {
        0 => String::new(),
        line => format!(" line=\"{line}\""),
    };
    let message = xml(&finding.message);
    let outcome = match finding.level() {
        Level::Deny => format!(
            "<failure type=\"{}\" message=\"{message}\">{}</failure>",
            xml(&finding.code),
            xml(&details(finding))
        ),
        Level::Allow | Level::Warn => {
            format!("<skipped message=\"{}: {message}\"/>", severity(finding.level()))
        }
    };
    let name = xml(name.trim_end());
    format!(
        "    <testcase classname=\"{path}\" name=\"{name}\" file=\"{path}\"{line}>\n      {outcome}\n    </testcase>\n"
    )
}

/// Formats a finding with its places, notes and help.
fn details(finding: &Finding) -> String {
    let mut lines = vec![short::line(finding)];
    for related in finding.related() {
        let text = if related.text.is_empty() { "see" } else { &related.text };
        lines.push(format!("{text}: {}", short::at(&related.at)));
    }
    lines.extend(finding.notes.iter().map(|note| format!("note: {note}")));
    lines.extend(finding.listing.iter().map(|listing| listing.trim_end().to_string()));
    lines.extend(finding.help.iter().map(|help| format!("help: {help}")));
    lines.join("\n")
}
