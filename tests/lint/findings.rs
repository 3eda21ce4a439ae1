//! Reports of findings: each format says what the findings say, in a form its backends take,
//! whatever the strings in them are like.

mod github;
mod human;
mod json;
mod junit;
mod sample;
mod sarif;
mod short;

use fastrand::Rng;
use landfall_layout::format::Paint;
use landfall_lint::render::{ReportFormat, github_summary, report};

use landfall_layout::finding::Place;

/// A report of the sample, or of what else there is, without colours.
fn plain(findings: &[landfall_layout::finding::Finding], format: ReportFormat) -> String {
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

/// A report that is read back may be anybody's.
#[test]
fn places_that_make_no_sense_do_no_harm() {
    let mut rng = Rng::with_seed(7);
    for _ in 0..300 {
        let mut findings = sample::findings();
        for finding in &mut findings {
            let edited = finding.fix.iter_mut().map(|edit| &mut edit.at);
            let shown = finding.labels.iter_mut().map(|label| &mut label.at);
            for place in edited.chain(shown) {
                scatter(place, &mut rng);
            }
        }
        for format in ReportFormat::ALL {
            assert!(plain(&findings, format).ends_with('\n'));
        }
        landfall_lint::fix::apply(&findings, &sample::text);
    }
}

fn scatter(place: &mut Place, rng: &mut Rng) {
    let Place { line, column, end_line, end_column, start, end, .. } = place;
    for number in [line, column, end_line, end_column, start, end] {
        *number = match rng.u8(..8) {
            0 => 0,
            1 => u32::MAX,
            2 => number.saturating_sub(1),
            3 => rng.u32(..200),
            _ => *number,
        };
    }
}
