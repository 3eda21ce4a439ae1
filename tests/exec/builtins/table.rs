//! The committed table of what was measured: written on request, and held against what is
//! measured now. Fed by the runs.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::case::Off;

/// Largest errors by case, in the order of the cases, for one backend.
pub struct Measured {
    /// As the table's head says it.
    pub backend: &'static str,
    pub device: String,
    pub cases: BTreeMap<String, Off>,
}

/// Two digits, never less than it is.
fn number(x: f64) -> String {
    match x {
        0.0 => "0".into(),
        x if x < 100.0 => format!("{:.2}", (x * 100.0).ceil() / 100.0),
        x if x < 1e6 => format!("{:.0}", x.ceil()),
        x => {
            let step = 10f64.powi(x.log10().floor() as i32 - 2);
            format!("{:.2e}", (x / step).ceil() * step)
        }
    }
}

fn cell(off: Option<&Off>) -> String {
    match off {
        None => "–".into(),
        Some(off) if off.share == 0.0 => number(off.ulp),
        Some(off) => format!("{} ({:.1} %)", number(off.ulp), (off.share * 1000.0).ceil() / 10.0),
    }
}

/// The table as it is committed.
pub fn written(rows: &[(String, String)], measured: &[Measured], count: usize) -> String {
    let mut text = format!(
        "# How accurate the backends are\n\n\
         The largest error over {count} inputs each, edges among them, in units in the last place\n\
         (ULP) of the true value, and in brackets the part of the permitted error that it takes\n\
         where WGSL §15.7.4 and Vulkan permit one. A dash: that backend does not take it.\n\
         Errors near a zero of the function, or where terms cancel, are many ULP and yet small.\n\n"
    );
    for m in measured {
        let _ = writeln!(text, "- `{}`: {}", m.backend, m.device);
    }
    text += "\n| builtin | permitted |";
    for m in measured {
        let _ = write!(text, " `{}` |", m.backend);
    }
    text += "\n|---|---|";
    text += &"---|".repeat(measured.len());
    text.push('\n');
    for (name, permitted) in rows {
        let name = name.replace('|', "\\|");
        let _ = write!(text, "| {name} | {permitted} |");
        for m in measured {
            let _ = write!(text, " {} |", cell(m.cases.get(&name.replace("\\|", "|"))));
        }
        text.push('\n');
    }
    text
}

/// What is measured now and is not as committed: larger errors, and rows that are missing.
/// A driver of another version is not held to figures that are not its own.
pub fn rotten(
    committed: &str,
    rows: &[(String, String)],
    measured: &[Measured],
    count: usize,
) -> Vec<String> {
    let now = written(rows, measured, count);
    let mut found = Vec::new();
    let same: Vec<bool> = measured
        .iter()
        .map(|m| committed.contains(&format!("- `{}`: {}\n", m.backend, m.device)))
        .collect();
    let line_of = |text: &str, name: &str| -> Option<Vec<String>> {
        let start = format!("| {name} |");
        let line = text.lines().find(|line| line.starts_with(&start))?;
        // A bar of a name or of |a| is written `\|`.
        let parts = line.replace("\\|", "\u{1}");
        Some(parts.split('|').map(|part| part.trim().to_string()).collect())
    };
    for (name, _) in rows {
        let name = name.replace('|', "\\|");
        let (Some(was), Some(is)) = (line_of(committed, &name), line_of(&now, &name)) else {
            found.push(format!("{name}: not in the table"));
            continue;
        };
        for (i, m) in measured.iter().enumerate() {
            let (was, is) = (was.get(i + 3).map_or("", |c| c), &is[i + 3]);
            if same[i] && value(is) > value(was) {
                found.push(format!("{name} by {}: {is} ULP, {was} in the table", m.backend));
            }
        }
    }
    found
}

fn value(cell: &str) -> f64 {
    cell.split(' ').next().and_then(|x| x.parse().ok()).unwrap_or(-1.0)
}

#[test]
fn a_larger_error_than_the_committed_one_is_found() {
    let of = |ulp: f64, device: &str| {
        let cases = [("sin".to_string(), Off { ulp, share: 0.5 })].into();
        vec![Measured { backend: "gl", device: device.into(), cases }]
    };
    let rows = [("sin".to_string(), "2^-11".to_string())];
    let committed = written(&rows, &of(1.5, "one"), 10);
    let row = committed.lines().find(|line| line.starts_with("| sin "));
    assert_eq!(row, Some("| sin | 2^-11 | 1.50 (50.0 %) |"), "{committed}");
    assert_eq!(rotten(&committed, &rows, &of(1.5, "one"), 10), [""; 0]);
    assert_eq!(rotten(&committed, &rows, &of(1.6, "one"), 10).len(), 1);
    assert_eq!(rotten(&committed, &rows, &of(1.6, "two"), 10), [""; 0]);
    let more = [rows[0].clone(), ("cos".to_string(), String::new())];
    assert_eq!(rotten(&committed, &more, &of(1.5, "one"), 10), ["cos: not in the table"]);
}
