//! Reports of findings: each format says what the findings say, in a form its readers take,
//! whatever the strings in them are like.

mod github;
mod human;
mod json;
mod junit;
mod sample;
mod sarif;
mod short;

use landfall::emit::Paint;
use landfall::emit::findings::{ReportFormat, github_summary, report};

/// A report of the sample, or of what else there is, without colours.
fn plain(findings: &[landfall::lint::Finding], format: ReportFormat) -> String {
    report(findings, format, &sample::options(Paint::Plain))
}

#[test]
fn a_finding_told_twice_is_reported_once() {
    let once = sample::findings();
    let twice: Vec<_> = once.iter().chain(&once).cloned().collect();
    for format in ReportFormat::ALL {
        assert_eq!(plain(&twice, format), plain(&once, format), "{}", format.name());
    }
}

#[test]
fn every_format_ends_in_a_newline_or_is_empty() {
    for findings in [sample::findings(), sample::hostile(), Vec::new()] {
        for format in ReportFormat::ALL {
            let text = plain(&findings, format);
            assert!(text.is_empty() || text.ends_with('\n'), "{}", format.name());
            assert!(!text.ends_with("\n\n"), "{}", format.name());
        }
        assert!(github_summary(&findings, &sample::options(Paint::Plain)).ends_with('\n'));
    }
}

#[test]
fn no_string_of_anybody_moves_the_cursor_or_colours_a_terminal() {
    let moves = |c: char| (c.is_ascii_control() && c != '\n' && c != '\t') || c == '\u{9b}';
    for format in ReportFormat::ALL {
        let text = plain(&sample::hostile(), format);
        // Legal in JSON and XML, and nothing to a terminal.
        let found = text.chars().find(|c| moves(*c) && *c != '\u{7f}');
        assert_eq!(found, None, "{}", format.name());
    }
}
