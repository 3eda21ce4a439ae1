//! The report of a binding map: a table for people, and JSON that `--bind` accepts.
//!
//! Formats a [`BindingMap`] of [`bind`](landfall_light::bind).

use std::fmt::Write as _;

use serde_json::{Map, Value};
use unicode_width::UnicodeWidthStr;

pub use landfall_layout::format::paint::{CAUTION, FAINT, HEADING, PLAIN, Paint};
use landfall_light::bind::{BindingMap, Decision, Member, Outcome, Source};

/// Returns a row for each member, texture and input.
pub fn text(map: &BindingMap, paint: Paint) -> String {
    let mut text = String::new();
    let members = map.members.iter().map(|member| (member.key(), &member.source));
    let bound = |all: &[landfall_light::bind::BoundValue]| -> Vec<(String, Source)> {
        all.iter().map(|bound| (bound.name.clone(), bound.source.clone())).collect()
    };
    let groups: [(&str, Vec<(String, Source)>); 3] = [
        ("members", members.map(|(key, source)| (key, source.clone())).collect()),
        ("textures", bound(&map.textures)),
        ("inputs", bound(&map.inputs)),
    ];
    let all = groups.iter().flat_map(|(_, rows)| rows.iter().map(|(key, _)| key.width()));
    let width = all.max().unwrap_or(0);
    for (title, rows) in &groups {
        if rows.is_empty() {
            continue;
        }
        let _ = writeln!(text, "{}", paint.text(HEADING, title));
        for (key, source) in rows {
            let pad = " ".repeat(width - key.width());
            let line = match source {
                Source::Unknown => paint.text(CAUTION, "unknown: filled with zero"),
                Source::Scene { .. } | Source::Number(_) => paint.text(PLAIN, &source.to_string()),
            };
            let _ = writeln!(text, "  {key}{pad}  {line}");
        }
    }
    if !map.decisions.is_empty() {
        let _ = writeln!(text, "{}", paint.text(HEADING, "decided by running the shader"));
    }
    let topics = map.decisions.iter().map(|decision| decision.topic.name().len());
    let width = topics.max().unwrap_or(0);
    for decision in &map.decisions {
        let keys: Vec<&str> = decision.members.iter().map(|(key, _)| key.as_str()).collect();
        // What a name alone decided is marked: the reference did not confirm it.
        let (certain, why) = reason(decision);
        let why = paint.text(if certain { FAINT } else { CAUTION }, &why);
        let topic = decision.topic.name();
        let _ = writeln!(text, "  {topic:<width$}  {}: {why}", keys.join(", "));
    }
    for note in &map.notes {
        let _ = writeln!(text, "{}", paint.text(FAINT, &format!("note: {note}")));
    }
    text
}

/// Returns whether a choice was made by the reference, and its reason.
fn reason(decision: &Decision) -> (bool, String) {
    let Decision { readings, probes, outcome, .. } = decision;
    match outcome {
        Outcome::Agrees => {
            let why = "interpretations matches the reference";
            (true, format!("1 of {readings} {why} on {probes} test fragments"))
        }
        Outcome::Same => {
            (true, format!("by name; all {readings} interpretations give the same light"))
        }
        Outcome::Named => {
            (false, format!("by name; none of {readings} interpretations matches the reference"))
        }
        Outcome::NotRun(why) => {
            (false, format!("by name; the interpreter cannot run the shader: {why}"))
        }
    }
}

/// Returns the object that `--bind` accepts: from members, textures and inputs to quantities;
/// `null` for an unknown source.
pub fn json(map: &BindingMap) -> Value {
    let members = map.members.iter().map(|member| (Member::key(member), &member.source));
    let bound = map.textures.iter().chain(&map.inputs).map(|b| (b.name.clone(), &b.source));
    let value = |source: &Source| match source {
        Source::Unknown => Value::Null,
        Source::Scene { .. } => Value::String(source.to_string()),
        Source::Number(numbers) => match &numbers[..] {
            [one] => Value::from(*one),
            all => Value::from(all.to_vec()),
        },
    };
    let rows = members.chain(bound).map(|(key, source)| (key, value(source)));
    Value::Object(rows.collect::<Map<String, Value>>())
}
