//! Who else reads a page: people with a keyboard or a screen reader, in both colour schemes, on
//! paper; and pages of a thousand blocks.

use std::fmt::Write as _;

use serde_json::{Value, json};

use crate::browser::Browser;
use crate::hostile::requests;
use crate::support::{DRAW_ALL, Folder, output, repository};

pub const TAB: &str = "\u{e004}";
const RIGHT: &str = "\u{e014}";
const DOWN: &str = "\u{e015}";
const SPACE: &str = " ";

const SHADER: &str = "#version 450
struct Lamp { vec3 pos; float power; mat2 turn; };
layout(std140, binding = 0) uniform Lamps { Lamp lamps[9]; vec3 ambient; int count; };
layout(std430, binding = 1) buffer Sums { uint sums[]; };
uniform vec3 loose;
void main() {}
";

const OLDER: &str = "#version 450
struct Lamp { vec3 pos; mat2 turn; float power; };
layout(std140, binding = 0) uniform Lamps { Lamp lamps[9]; int count; };
layout(std430, binding = 1) buffer Sums { uint sums[]; };
uniform vec3 loose;
void main() {}
";

/// A page with blocks, findings and changes.
fn page(folder: &Folder) -> std::path::PathBuf {
    folder.file("lamps.frag", OLDER);
    output(folder.path(), 0, &["lock", "lamps.frag"]);
    folder.file("lamps.frag", SHADER);
    output(folder.path(), 0, &["report", "lamps.frag", "-o", "page.html"]);
    folder.path().join("page.html")
}

/// What axe-core finds in a page: the rules that it breaks, and where.
pub fn violations(browser: &Browser) -> Value {
    let axe = repository().join("target/axe/node_modules/axe-core/axe.min.js");
    let axe = std::fs::read_to_string(axe)
        .expect("axe-core is missing: npm install --prefix target/axe axe-core");
    let done = browser.devtools("Runtime.evaluate", json!({"expression": axe}));
    assert!(done["exceptionDetails"].is_null(), "{done:#}");
    let mut found = browser.run_async(
        "const done = arguments[0];
         axe.run(document, { resultTypes: ['violations'] }).then(
             result => done({ checked: result.passes.length, violations: result.violations.map(one =>
                 [one.id, one.help, one.nodes.slice(0, 3).map(node => node.html + ' ' + node.failureSummary)]) }),
             error => done({ error: String(error) }));",
        &[],
    );
    assert!(found["checked"].as_u64().is_some_and(|checked| checked > 20), "{found:#}");
    found["violations"].take()
}

#[test]
fn axe_finds_no_violation_in_either_scheme() {
    let (browser, folder) = (Browser::start("axe"), Folder::new("axe"));
    let page = page(&folder);
    for (width, scheme) in [(1400, "light"), (1400, "dark"), (400, "light"), (400, "dark")] {
        browser.show_as(width, scheme);
        browser.open(&page);
        browser.run(DRAW_ALL, &[]);
        // A cell is chosen, a byte is asked for, all rules are shown.
        browser.run(
            "document.querySelectorAll('.rules button[aria-pressed=false]').forEach(one => one.click());
             const field = document.querySelector('input.byte');
             field.value = '40';
             field.dispatchEvent(new Event('input'));
             document.querySelector('.cell').focus();",
            &[],
        );
        browser.run(DRAW_ALL, &[]);
        assert_eq!(violations(&browser), json!([]), "{width} {scheme}");
    }
}

/// Numbers everything that can be operated.
pub const NUMBER: &str = "
    window.reached = new Set();
    document.addEventListener('focusin', event => window.reached.add(event.target), true);
    document.body.focus();
    window.operable = () => [...document.querySelectorAll('a[href], button, input, select, textarea, summary, [tabindex=\"0\"]')]
        .filter(one => one.checkVisibility() && !one.closest('[hidden]') && !one.disabled);";

#[test]
fn the_keyboard_alone_reaches_everything() {
    let (browser, folder) = (Browser::start("keyboard"), Folder::new("keyboard"));
    let page = page(&folder);
    browser.show_as(1400, "light");
    browser.open(&page);
    browser.run(DRAW_ALL, &[]);
    browser.run(NUMBER, &[]);
    // Tab stops: once around the page.
    browser.press(&[TAB; 70]);
    let missed = browser.run(
        "return operable().filter(one => !reached.has(one) && one.tabIndex >= 0).map(one => one.outerHTML.slice(0, 200))",
        &[],
    );
    assert_eq!(missed, json!([]));
    // The stops within each map, by arrows alone.
    let maps =
        browser.run("return document.querySelectorAll('.map').length", &[]).as_u64().unwrap();
    assert!(maps >= 4, "{maps}");
    for map in 0..maps {
        let stops = browser.run(
            "const map = document.querySelectorAll('.map')[arguments[0]];
             map.querySelector('button').focus();
             return map.querySelectorAll('button').length",
            &[json!(map)],
        );
        browser.press(&vec![RIGHT; stops.as_u64().unwrap() as usize]);
        browser.press(&[DOWN]);
        let missed = browser.run(
            "const map = document.querySelectorAll('.map')[arguments[0]];
             return [...map.querySelectorAll('button')].filter(one => !reached.has(one)).map(one => one.outerHTML)",
            &[json!(map)],
        );
        assert_eq!(missed, json!([]), "map {map}");
    }
    // What has the focus is what the panel shows.
    let shown = browser.run(
        "const cell = document.querySelector('article:not(.change) .cell');
         cell.focus();
         return [cell.dataset.path, document.querySelector('#detail h2').textContent]",
        &[],
    );
    assert_eq!(shown[0], shown[1]);
    // Rules are switched with the space bar, a fold is opened with it.
    let pressed = |rules: &str| {
        browser.run("document.querySelector(`article:not(.change) .rules [data-rules=${arguments[0]}]`).focus()", &[json!(rules)]);
        browser.press(&[SPACE]);
        browser.run("return document.querySelectorAll('article:not(.change)')[0].querySelectorAll('.map').length", &[])
    };
    assert_eq!(pressed("std430"), json!(2));
    assert_eq!(pressed("std430"), json!(1));
    let cells = "return document.querySelectorAll('article:not(.change) .cell').length";
    let before = browser.run(cells, &[]).as_u64().unwrap();
    browser.run("document.querySelector('article:not(.change) button.fold').focus()", &[]);
    browser.press(&[SPACE]);
    assert!(browser.run(cells, &[]).as_u64().unwrap() > before);
}

#[test]
#[ignore = "draws for long in a browser: ./tests/run pages"]
fn every_map_has_a_table_of_the_same_cells() {
    let (browser, folder) = (Browser::start("tables"), Folder::new("tables"));
    browser.open(&page(&folder));
    browser.run(DRAW_ALL, &[]);
    let pairs = browser.run(
        "return [...document.querySelectorAll('.figure')].map(figure => [
            [...figure.querySelectorAll('.cell[data-offset]')].map(cell => [cell.dataset.offset, cell.dataset.size].join(' ')),
            [...figure.querySelectorAll('tbody tr')].map(row => [...row.children].map(cell => cell.textContent))
                .filter(row => row[2] !== '').map(row => [row[0], row[2], row[3], row[4]]),
        ])",
        &[],
    );
    let pairs = pairs.as_array().unwrap();
    assert!(pairs.len() >= 4);
    for pair in pairs {
        let rows: Vec<[String; 4]> = serde_json::from_value(pair[1].clone()).unwrap();
        for cell in pair[0].as_array().unwrap() {
            let (offset, size) = cell.as_str().unwrap().split_once(' ').unwrap();
            let row = rows.iter().find(|row| row[1] == offset && row[3] == size);
            let row = row.unwrap_or_else(|| panic!("{cell}: {rows:?}"));
            assert_eq!(row[2], format!("{:#x}", offset.parse::<u64>().unwrap()));
        }
    }
}

#[test]
#[ignore = "draws for long in a browser: ./tests/run pages"]
fn a_page_prints_with_all_its_maps() {
    let (browser, folder) = (Browser::start("print"), Folder::new("print"));
    let blocks = 40;
    let mut text = String::from("#version 450\n");
    for block in 0..blocks {
        let _ =
            writeln!(text, "layout(std140) uniform B{block} {{ vec4 a[3]; vec3 b; }} b{block};");
    }
    folder.file("many.frag", text);
    output(folder.path(), 0, &["report", "many.frag", "-o", "page.html"]);
    browser.open(&folder.path().join("page.html"));
    let drawn = "return document.querySelectorAll('.map').length";
    assert!(browser.run(drawn, &[]).as_u64().unwrap() < blocks, "only what is seen is drawn");
    let pdf = browser.devtools("Page.printToPDF", json!({"printBackground": true}));
    assert!(pdf["data"].as_str().unwrap().len() > 10_000);
    assert_eq!(browser.run(drawn, &[]), json!(blocks));
}

#[test]
#[ignore = "draws for long in a browser: ./tests/run pages"]
fn a_thousand_blocks_open_at_once_and_load_nothing() {
    let (browser, folder) = (Browser::start("thousand"), Folder::new("thousand"));
    for shader in 0..100 {
        let mut text = String::from(
            "#version 450\nstruct Light { vec3 pos; float power; vec3 color; mat3 turn; };\n",
        );
        for block in 0..10 {
            let _ = writeln!(
                text,
                "layout(std140) uniform B{block} {{ Light lights[16]; mat4 view; vec3 at; int count; float fade[4]; }} b{block};"
            );
        }
        folder.file(&format!("shader{shader}.frag"), text);
    }
    output(folder.path(), 0, &["report", ".", "-o", "page.html"]);
    browser.devtools("Performance.enable", json!({}));
    browser.log("performance");
    browser.open(&folder.path().join("page.html"));
    assert_eq!(browser.run("return document.querySelectorAll('article').length", &[]), json!(1000));
    // A frame with maps.
    browser.run_async(
        "const done = arguments[0]; (function wait() {
            document.querySelector('.map') ? requestAnimationFrame(() => requestAnimationFrame(done))
                : setTimeout(wait, 5); })();",
        &[],
    );
    let timing = browser.run(
        "const [page] = performance.getEntriesByType('navigation');
         return { paint: performance.getEntriesByName('first-contentful-paint')[0]?.startTime ?? 0,
             script: Number(document.documentElement.dataset.ready), now: performance.now(), load: page.loadEventEnd }",
        &[],
    );
    let metrics = browser.devtools("Performance.getMetrics", json!({}));
    let seconds = |name: &str| {
        let all = metrics["metrics"].as_array().unwrap();
        all.iter().find(|one| one["name"] == json!(name)).unwrap()["value"].as_f64().unwrap()
    };
    let size = std::fs::metadata(folder.path().join("page.html")).unwrap().len();
    println!(
        "1,000 blocks, {size} bytes: {timing}, main thread {:.3} s, script {:.3} s, layout {:.3} s",
        seconds("TaskDuration"),
        seconds("ScriptDuration"),
        seconds("LayoutDuration"),
    );
    // Processor time of the page's thread, with room for a slow machine.
    assert!(seconds("TaskDuration") < 5.0, "{metrics:#}");
    let maps = browser.run("return document.querySelectorAll('.map').length", &[]);
    assert!(maps.as_u64().unwrap() < 20, "{maps}");
    assert_eq!(requests(&browser), Vec::<String>::new());
    let console: Vec<Value> = browser.log("browser");
    assert_eq!(console, Vec::<Value>::new());
}
