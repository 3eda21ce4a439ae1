//! JUnit's XML, read back by a parser of XML.

use crate::support::command::golden;
use landfall_layout::finding::{Finding, Level};
use landfall_lint::render::ReportFormat;
use roxmltree::{Document, Node};
use snapbox::str;

use crate::findings::{plain, sample};

fn named<'a>(of: Node<'a, 'a>, name: &'static str) -> impl Iterator<Item = Node<'a, 'a>> {
    of.descendants().filter(move |node| node.has_tag_name(name))
}

fn number(node: Node<'_, '_>, name: &str) -> usize {
    node.attribute(name).expect("it is counted").parse().expect("a count is a number")
}

/// The counts of a suite, or of all, are those of its cases.
fn counts_hold(node: Node<'_, '_>) {
    for (attribute, name) in
        [("tests", "testcase"), ("failures", "failure"), ("skipped", "skipped")]
    {
        let found = node.descendants().filter(|inner| inner.has_tag_name(name)).count();
        assert_eq!(number(node, attribute), found, "{attribute}");
    }
}

#[test]
fn each_finding_is_a_case_of_its_file() {
    let text = plain(&sample::findings(), ReportFormat::Junit);
    let document = Document::parse(&text).expect("XML");
    let root = document.root_element();
    assert_eq!(root.tag_name().name(), "testsuites");
    counts_hold(root);
    named(root, "testsuite").for_each(counts_hold);
    let suites: Vec<_> = named(root, "testsuite").filter_map(|s| s.attribute("name")).collect();
    assert_eq!(suites, ["landfall", "shaders/lights.frag", "layouts/gone.frag.json"]);
    let cases: Vec<_> = named(root, "testcase").filter_map(|c| c.attribute("name")).collect();
    let expected = [
        "all shaders were checked",
        "stale-comment PointLight.color",
        "block-mismatch PointLightBlock",
        "lock-orphan layouts/gone.frag.json",
    ];
    assert_eq!(cases, expected);
    let failure = named(root, "failure").next().expect("the one at deny");
    assert_eq!(failure.attribute("type"), Some("block-mismatch"));
    let text = failure.text().expect("all there is to say");
    golden().eq(text, str![[r#"
shaders/lights.frag:7:24: error[block-mismatch] `PointLightBlock` has 6160 bytes here and 4112 bytes in `shaders/copy.vert`
4112 bytes: shaders/copy.vert:2:24
stride 16, not 48: shaders/copy.vert:3:5
help: declare `data` as `PointLight data[128]` in `shaders/copy.vert`
"#]]);
}

#[test]
fn a_clean_run_has_a_case_that_passed() {
    let text = plain(&[], ReportFormat::Junit);
    let document = Document::parse(&text).expect("XML");
    counts_hold(document.root_element());
    assert_eq!(named(document.root(), "testcase").count(), 1);
    let property = named(document.root(), "property").next().expect("how many there were");
    assert_eq!(property.attribute("value"), Some("65"));
}

/// XML 1.0 has no such character (production 2), escaped or not, or a viewer obeys it: controls of
/// terminals (ECMA-48), marks of direction (UAX #9, §2) and Unicode's ends of lines.
fn kept(text: &str) -> String {
    let illegal = |c: char| {
        (c.is_control() && !"\t\n\r".contains(c))
            || matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}')
            || matches!(c, '\u{2066}'..='\u{2069}' | '\u{fffe}' | '\u{ffff}')
    };
    text.chars().map(|c| if illegal(c) { '\u{fffd}' } else { c }).collect()
}

#[test]
fn hostile_strings_come_back() {
    let findings = sample::hostile();
    let text = plain(&findings, ReportFormat::Junit);
    let document = Document::parse(&text).expect("XML");
    let cases: Vec<_> = named(document.root(), "testcase").skip(1).collect();
    assert_eq!(cases.len(), findings.len());
    for (case, finding) in cases.iter().zip(&findings) {
        assert_eq!(case.attribute("file"), Some(kept(&finding.place().path).as_str()));
        let inner = case.children().find(Node::is_element).expect("what became of it");
        let message = inner.attribute("message").expect("a message");
        match finding.level() {
            Level::Deny => assert_eq!(message, kept(&finding.message)),
            Level::Allow | Level::Warn => {
                assert_eq!(message, format!("warning: {}", kept(&finding.message)));
            }
        }
    }
}

#[test]
fn cases_of_one_name_are_numbered() {
    let mut other: Finding = sample::findings().remove(0);
    other.message.push('!');
    let text = plain(&[sample::findings().remove(0), other], ReportFormat::Junit);
    let document = Document::parse(&text).expect("XML");
    let last = named(document.root(), "testcase").last().and_then(|c| c.attribute("name"));
    assert_eq!(last, Some("stale-comment PointLight.color (2)"));
}
