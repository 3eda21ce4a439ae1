//! Differences as two maps.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use crate::browser::Browser;
use crate::support::{Folder, output};

const OLD: &str = "#version 450
struct PointLight { vec3 pos; vec3 color; float intensity; };
layout(std140, binding = 1) uniform Lights { PointLight data[2]; vec4 ambient; mat3 turn; int count; };
void main() {}
";

const NEW: &str = "#version 450
struct PointLight { vec3 pos; float intensity; vec3 tint; float radius; };
layout(std140, binding = 1) uniform Lights { PointLight data[2]; mat3 turn; vec4 ambient; int number; };
void main() {}
";

/// The marks of the old and of the new map, by path.
fn marks(browser: &Browser, side: &str) -> BTreeMap<String, String> {
    let script = "return Object.fromEntries([...document.querySelectorAll(
        `.figure[data-side=${arguments[0]}] button.cell:not(.pad)`)].map(cell =>
        [cell.dataset.path, cell.querySelector('.mark')?.textContent ?? '']))";
    serde_json::from_value(browser.run(script, &[json!(side)])).unwrap()
}

/// Computed by hand: std140 places a `PointLight` of 32 bytes at 0 and 32 on both sides.
fn assert_marks(browser: &Browser) {
    let of = |pairs: &[(&str, &str)]| -> BTreeMap<String, String> {
        pairs.iter().map(|(path, mark)| (path.to_string(), mark.to_string())).collect()
    };
    let old = of(&[
        ("data[0].pos", ""),
        ("data[0].color", "→ tint"),
        ("data[0].intensity", "→ 12"),
        ("data[1].pos", ""),
        ("data[1].color", "→ tint"),
        ("data[1].intensity", "→ 44"),
        ("ambient", "→ 112"),
        ("turn[0]", "→ 64"),
        ("turn[1]", "→ 80"),
        ("turn[2]", "→ 96"),
        ("count", "→ number"),
    ]);
    let new = of(&[
        ("data[0].pos", ""),
        ("data[0].intensity", "← 28"),
        ("data[0].tint", "← color"),
        ("data[0].radius", "new"),
        ("data[1].pos", ""),
        ("data[1].intensity", "← 60"),
        ("data[1].tint", "← color"),
        ("data[1].radius", "new"),
        ("turn[0]", "← 80"),
        ("turn[1]", "← 96"),
        ("turn[2]", "← 112"),
        ("ambient", "← 64"),
        ("number", "← count"),
    ]);
    assert_eq!(marks(browser, "old"), old);
    assert_eq!(marks(browser, "new"), new);
}

/// The lines between the maps: where each begins and ends, as the paths of the cells there.
const LINES: &str = "
    const box = document.querySelector('.pair').getBoundingClientRect();
    const at = (side, x, y) => [...document.querySelectorAll(`.figure[data-side=${side}] button.cell`)]
        .find(cell => {
            const r = cell.getBoundingClientRect();
            const edge = side === 'old' ? r.left : r.right;
            return Math.abs(edge - box.left - x) < 1 && Math.abs(r.bottom - box.top - y) < 1;
        })?.dataset.path;
    return [...document.querySelectorAll('path.line')].map(line => {
        const [x1, y1] = line.getAttribute('d').match(/^M([\\d.]+),([\\d.]+)/).slice(1).map(Number);
        const [y2, x2] = line.getAttribute('d').match(/,([\\d.]+) H([\\d.]+)$/).slice(1).map(Number);
        return [at('old', x1, y1), at('new', x2, y2)];
    });";

#[test]
fn a_difference_is_two_maps_with_what_moved_drawn_between_them() {
    let (browser, folder) = (Browser::start("diff"), Folder::new("diff"));
    folder.file("old.frag", OLD);
    folder.file("new.frag", NEW);
    output(
        folder.path(),
        1,
        &["diff", "old.frag", "new.frag", "--format", "html", "-o", "page.html"],
    );
    browser.show_as(1400, "light");
    browser.open(&folder.path().join("page.html"));
    assert_marks(&browser);
    let mut lines: Vec<(String, String)> = serde_json::from_value(browser.run(LINES, &[])).unwrap();
    lines.sort();
    let moved =
        ["ambient", "data[0].intensity", "data[1].intensity", "turn[0]", "turn[1]", "turn[2]"];
    assert_eq!(lines, moved.map(|path| (path.to_string(), path.to_string())));
    // Below each other there is no room between them.
    browser.show_as(400, "light");
    let drawn = "const done = arguments[0]; requestAnimationFrame(() => setTimeout(() =>
        done(document.querySelectorAll('path.line').length), 100))";
    assert_eq!(browser.run_async(drawn, &[]), json!(0));
    // The list of changes is that of the JSON.
    let arguments = ["diff", "old.frag", "new.frag", "--format", "json"];
    let wanted: Value = serde_json::from_str(&output(folder.path(), 1, &arguments)).unwrap();
    let wanted = wanted["shaders"][0]["blocks"][0]["changes"].as_array().unwrap().iter();
    let wanted: Vec<String> = wanted
        .map(|change| {
            let message = change["message"].as_str().unwrap().replace('`', "");
            format!("{} {message}", change["class"].as_str().unwrap())
        })
        .collect();
    let list = "return [...document.querySelectorAll('.changes li')].map(li => li.textContent)";
    assert_eq!(browser.run(list, &[]), json!(wanted));
}

#[test]
fn check_and_report_show_what_changed_since_the_lock() {
    let (browser, folder) = (Browser::start("lock"), Folder::new("lock"));
    folder.file("lights.frag", OLD);
    output(folder.path(), 0, &["lock", "lights.frag"]);
    folder.file("lights.frag", NEW);
    // The layout has changed, which `check` denies and `report` shows.
    output(folder.path(), 1, &["check", "lights.frag", "--format", "html=check.html"]);
    output(folder.path(), 0, &["report", "lights.frag", "-o", "report.html"]);
    for name in ["check.html", "report.html"] {
        browser.open(&folder.path().join(name));
        browser.run(crate::support::DRAW_ALL, &[]);
        assert_marks(&browser);
        let codes = "return [...document.querySelectorAll('.finding code:first-of-type')].map(code => code.textContent)";
        let codes = browser.run(codes, &[]);
        assert!(codes.as_array().unwrap().contains(&json!("layout-drift")), "{name}: {codes}");
    }
    let title = browser.run("return document.title", &[]);
    assert_eq!(title, json!("Landfall report"));
}

#[test]
fn pages_go_through_the_one_writer_and_overwrite_no_input() {
    let folder = Folder::new("writer");
    let old = folder.file("old.frag", OLD);
    folder.file("new.frag", NEW);
    for arguments in [
        &["report", "old.frag", "-o", "old.frag"][..],
        &["check", "old.frag", "--format", "html=old.frag"],
        &["diff", "old.frag", "new.frag", "--format", "html", "-o", "old.frag"],
        &["diff", "old.frag", "new.frag", "-o", "old.frag"],
    ] {
        output(folder.path(), 2, arguments);
        assert_eq!(std::fs::read_to_string(&old).unwrap(), OLD, "{arguments:?}");
    }
    // Without a file, the page goes to standard output, the same one.
    let page = output(folder.path(), 0, &["report", "old.frag"]);
    output(folder.path(), 0, &["report", "old.frag", "-o", "page.html"]);
    assert_eq!(std::fs::read_to_string(folder.path().join("page.html")).unwrap(), page);
    assert!(page.starts_with("<!DOCTYPE html>"));
    // Text of `diff` in a file is that of standard output.
    for format in ["human", "json", "md"] {
        let arguments = ["diff", "old.frag", "new.frag", "--format", format, "--width", "80"];
        let text = output(folder.path(), 1, &arguments);
        output(folder.path(), 1, &[&arguments[..], &["-o", "diff.txt"]].concat());
        assert_eq!(std::fs::read_to_string(folder.path().join("diff.txt")).unwrap(), text);
    }
    // A shader with an error: the page of the others, the error on stderr, exit code 2.
    folder.file("bad.frag", "#version 450\nuniform Bad { vec3 a; \n");
    let done = crate::support::landfall(
        folder.path(),
        &["report", "bad.frag", "old.frag", "-o", "page.html"],
    );
    assert_eq!(done.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&done.stderr).contains("bad.frag:2"));
    assert!(std::fs::read_to_string(folder.path().join("page.html")).unwrap().contains("Lights"));
}
