//! Edits of findings: made where they do not touch one another, nothing else changed.

use std::sync::Arc;

use fastrand::Rng;
use landfall_layout::finding::{Edit, Finding, Place};
use landfall_layout::{Files, Span};
use landfall_lint::fix::{Fixed, apply};

const PATH: &str = "a.frag";

fn edit(text: &str, start: usize, end: usize, new: &str) -> Edit {
    let mut files = Files::default();
    let file = files.add(PATH, text.into());
    let place = Place::new(&files, Span { file, start: start as u32, end: end as u32 });
    Edit { at: place, new: new.to_string() }
}

fn finding(edits: &[Edit]) -> Finding {
    let mut finding = Finding::at("x", "", Place::file(PATH), "");
    finding.fix = edits.to_vec();
    finding
}

fn fixed(text: &str, findings: &[Finding]) -> Option<Fixed> {
    let shared: Arc<str> = text.into();
    let mut all = apply(findings, &|path| (path == PATH).then(|| Arc::clone(&shared)));
    assert!(all.len() <= 1);
    all.pop()
}

/// The text after the edits of findings with one edit each.
fn after(text: &str, edits: &[(usize, usize, &str)]) -> String {
    let findings: Vec<Finding> =
        edits.iter().map(|(start, end, new)| finding(&[edit(text, *start, *end, new)])).collect();
    fixed(text, &findings).map_or(text.to_string(), |fixed| fixed.new)
}

#[test]
fn edits_side_by_side_are_made_and_those_that_touch_wait() {
    assert_eq!(after("abcdef", &[(0, 2, "X"), (2, 4, "Y")]), "XYef");
    assert_eq!(after("abcdef", &[(2, 4, "Y"), (0, 2, "X")]), "XYef");
    assert_eq!(after("abcdef", &[(0, 3, "X"), (2, 4, "Y")]), "Xdef");
    assert_eq!(after("abcdef", &[(1, 5, "X"), (2, 4, "Y")]), "aXf");
    assert_eq!(after("abcdef", &[(2, 4, "Y"), (1, 5, "X")]), "abYef");
    // An insertion where something else begins or ends has no order with it.
    assert_eq!(after("abcdef", &[(2, 4, "Y"), (4, 4, "X")]), "abYef");
    assert_eq!(after("abcdef", &[(2, 4, "Y"), (2, 2, "X")]), "abYef");
    assert_eq!(after("abcdef", &[(2, 2, "X"), (2, 2, "Y")]), "abXcdef");
    assert_eq!(after("abcdef", &[(0, 0, "X"), (6, 6, "Y")]), "XabcdefY");
    assert_eq!(after("", &[(0, 0, "X")]), "X");
}

#[test]
fn one_edit_of_two_findings_is_made_once() {
    let text = "abc";
    let same = || finding(&[edit(text, 1, 1, "X")]);
    let fixed = fixed(text, &[same(), same()]).expect("it changes");
    assert_eq!((fixed.new.as_str(), fixed.edits), ("aXbc", 1));
}

#[test]
fn a_finding_is_mended_whole_or_not_at_all() {
    let text = "abcdef";
    let first = finding(&[edit(text, 0, 2, "X")]);
    let both = finding(&[edit(text, 4, 5, "Y"), edit(text, 1, 3, "Z")]);
    assert_eq!(fixed(text, &[first, both]).map(|f| f.new), Some("Xcdef".to_string()));
    let torn = finding(&[edit(text, 0, 3, "X"), edit(text, 1, 2, "Y")]);
    assert_eq!(fixed(text, &[torn]), None);
    let mut elsewhere = edit(text, 0, 1, "X");
    elsewhere.at.path = "gone.frag".to_string();
    assert_eq!(fixed(text, &[finding(&[edit(text, 0, 1, "Y"), elsewhere])]), None);
}

#[test]
fn edits_that_do_not_mean_this_text_are_refused() {
    let text = "a漢b\nc\n";
    let moved = edit("\na漢b\nc\n", 7, 8, "X");
    let past = edit("a漢b\nc\nlonger", 8, 12, "X");
    let mut inside = edit(text, 1, 4, "X");
    inside.at.start = 2;
    let mut backwards = edit(text, 1, 4, "X");
    (backwards.at.start, backwards.at.end) = (4, 1);
    let whole = Edit { at: Place::file(PATH), new: "X".to_string() };
    let mut huge = edit(text, 1, 4, "X");
    huge.at.end = u32::MAX;
    for bad in [moved, past, inside, backwards, whole, huge] {
        assert_eq!(fixed(text, &[finding(std::slice::from_ref(&bad))]), None, "{bad:?}");
    }
}

#[test]
fn nothing_to_change_is_no_change() {
    assert_eq!(fixed("abc", &[]), None);
    assert_eq!(fixed("abc", &[finding(&[])]), None);
    assert_eq!(fixed("abc", &[finding(&[edit("abc", 1, 2, "b")])]), None);
}

/// Lints see a text without its byte order mark.
#[test]
fn a_byte_order_mark_stays() {
    let finding = finding(&[edit("abc\r\n", 1, 2, "X")]);
    let fixed = fixed("\u{feff}abc\r\n", &[finding]).expect("it changes");
    assert_eq!(fixed.new, "\u{feff}aXc\r\n");
    assert_eq!(&*fixed.old, "\u{feff}abc\r\n");
}

#[test]
fn files_come_back_by_path() {
    let one = |path: &str| {
        let mut edit = edit("abc", 0, 1, "X");
        edit.at.path = path.to_string();
        finding(&[edit])
    };
    let all = apply(&[one("b"), one("a"), one("c")], &|path| (path != "c").then(|| "abc".into()));
    let paths: Vec<&str> = all.iter().map(|fixed| fixed.path.as_str()).collect();
    assert_eq!(paths, ["a", "b"]);
    assert_eq!(&*all[0].old, "abc");
}

const LETTERS: &[&str] = &["a", "b", "0", " ", "\n", "\r\n", "\t", "é", "漢", "🙂", "//", "{"];

fn random(rng: &mut Rng, most: usize) -> String {
    (0..rng.usize(..=most)).map(|_| *rng.choice(LETTERS).expect("there are letters")).collect()
}

/// The same, slowly: every pair of edits compared, the last edit of the text made first.
fn naive(text: &str, findings: &[Finding]) -> (String, usize) {
    let apart = |a: &Edit, b: &Edit| {
        let ((a, b), (c, d)) = ((a.at.start, a.at.end), (b.at.start, b.at.end));
        match a == b || c == d {
            true => b < c || d < a,
            false => b <= c || d <= a,
        }
    };
    let mut made: Vec<&Edit> = Vec::new();
    for finding in findings {
        let own: Vec<&Edit> = finding.fix.iter().collect();
        let fits = own.iter().enumerate().all(|(i, edit)| {
            let free = made.iter().all(|other| other == edit || apart(other, edit));
            free && own[..i].iter().all(|other| other == edit || apart(other, edit))
        });
        if fits {
            for edit in own {
                let (start, end) = (edit.at.start as usize, edit.at.end as usize);
                if !made.contains(&edit) && text[start..end] != edit.new {
                    made.push(edit);
                }
            }
        }
    }
    made.sort_by_key(|edit| std::cmp::Reverse((edit.at.start, edit.at.end)));
    let mut result = text.to_string();
    for edit in &made {
        result.replace_range(edit.at.start as usize..edit.at.end as usize, &edit.new);
    }
    (result, made.len())
}

#[test]
fn five_thousand_random_sets_of_edits_agree_with_a_naive_model() {
    let mut rng = Rng::with_seed(4);
    let (mut changed, mut waited) = (0, 0);
    for round in 0..5000 {
        let text = random(&mut rng, 30);
        let ends: Vec<usize> = (0..=text.len()).filter(|&i| text.is_char_boundary(i)).collect();
        let findings: Vec<Finding> = (0..rng.usize(..8))
            .map(|_| {
                let edits: Vec<Edit> = (0..rng.usize(..3))
                    .map(|_| {
                        let start = rng.usize(..ends.len());
                        let end = (start + rng.usize(..4)).min(ends.len() - 1);
                        edit(&text, ends[start], ends[end], &random(&mut rng, 2))
                    })
                    .collect();
                finding(&edits)
            })
            .collect();
        let (expected, edits) = naive(&text, &findings);
        let all: usize = findings.iter().map(|finding| finding.fix.len()).sum();
        waited += usize::from(edits < all);
        match fixed(&text, &findings) {
            Some(fixed) => {
                changed += 1;
                assert_eq!(fixed.new, expected, "round {round}: {text:?} {findings:?}");
                assert_eq!((&*fixed.old, fixed.edits), (text.as_str(), edits));
            }
            None => assert_eq!(text, expected, "round {round}: {findings:?}"),
        }
    }
    assert!(changed > 3000 && waited > 1000, "{changed} changed, {waited} waited");
}

/// A lint for the test: every number is to be 16 bytes further, unless it is marked.
fn numbers(text: &str) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (start, _) in text.match_indices('0') {
        if !text[..start].ends_with('!') {
            findings.push(finding(&[edit(text, start, start + 1, "!0")]));
            // A second finding on the same bytes waits for the next round and is gone then.
            findings.push(finding(&[edit(text, start, start + 1, "lost")]));
        }
    }
    findings
}

#[test]
fn mending_what_is_mended_changes_nothing() {
    let mut rng = Rng::with_seed(5);
    for _ in 0..500 {
        let text = random(&mut rng, 60);
        let Some(first) = fixed(&text, &numbers(&text)) else { continue };
        assert_eq!(first.new, text.replace('0', "!0").replace("!!0", "!0"));
        assert_eq!(numbers(&first.new), []);
        assert_eq!(fixed(&first.new, &numbers(&first.new)), None);
    }
}
