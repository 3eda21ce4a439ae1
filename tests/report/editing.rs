//! What stands around the text of the playground: the divider, wrapped lines, coloured code, and what
//! a link holds.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use crate::access::violations;
use crate::browser::Browser;
use crate::playground::WRITE;
use crate::serve::Server;
use crate::support::Folder;

/// A browser with the page of a server without files, and both.
fn opened(name: &str) -> (Browser, Server, Folder) {
    let (browser, folder) = (Browser::start(name), Folder::new(name));
    let server = Server::start(folder.path(), &[]);
    browser.show_as(1400, "light");
    browser.open_url(&server.url);
    (browser, server, folder)
}

/// Waits until a script returns what is wanted, at most 20 s, and returns it.
#[track_caller]
fn wait(browser: &Browser, script: &str, wanted: &dyn Fn(&Value) -> bool) -> Value {
    let asked = Instant::now();
    loop {
        let now = browser.run(script, &[]);
        if wanted(&now) {
            return now;
        }
        assert!(asked.elapsed() < Duration::from_secs(20), "{now:#}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// Where the divider says it is, and the boxes of the editor, the divider and the results.
const PLACES: &str = "const divider = document.getElementById('divider');
    const box = one => { const { left, top, right, bottom } = one.getBoundingClientRect(); return { left, top, right, bottom }; };
    return { now: Number(divider.getAttribute('aria-valuenow')), orientation: divider.getAttribute('aria-orientation'),
        editor: box(document.querySelector('.text')), divider: box(divider), results: box(document.getElementById('results')) }";

#[test]
fn the_divider_moves_by_keys_and_pointer_and_stays_for_the_session() {
    let (browser, server, _folder) = opened("divider");
    let edge = |places: &Value, of: &str, side: &str| {
        places[of][side].as_f64().unwrap_or_else(|| panic!("{places}"))
    };
    let holds = |now: u64, orientation: &str| {
        let places = browser.run(PLACES, &[]);
        assert_eq!((&places["now"], &places["orientation"]), (&json!(now), &json!(orientation)));
        // What it says is where it is, and the three neither overlap nor leave a gap.
        let (near, far, whole) = match orientation {
            "vertical" => ("left", "right", 1400.0),
            _ => ("top", "bottom", 1000.0),
        };
        let share = (edge(&places, "divider", far) - edge(&places, "editor", near)) / whole;
        assert!((share - now as f64 / 100.0).abs() < 0.006, "{share} {places}");
        assert_eq!(edge(&places, "editor", far), edge(&places, "divider", near), "{places}");
        assert_eq!(edge(&places, "divider", far), edge(&places, "results", near), "{places}");
        places
    };
    let press = |key: &str| browser.press(&[key]);
    let focus = || browser.run("document.getElementById('divider').focus()", &[]);
    let [left, up, right, down] = ["\u{e012}", "\u{e013}", "\u{e014}", "\u{e015}"];
    let [home, end, enter] = ["\u{e011}", "\u{e010}", "\u{e007}"];
    holds(42, "vertical");
    focus();
    for (key, now) in [
        (right, 44),
        (right, 46),
        (left, 44),
        (down, 44),
        (end, 85),
        (right, 85),
        (home, 15),
        (left, 15),
        (enter, 42),
    ] {
        press(key);
        holds(now, "vertical");
    }
    // By the pointer: pressed in its middle, moved, released, and moved on without effect.
    let mouse = |kind: &str, x: f64, y: f64| {
        let event = json!({"type": kind, "x": x, "y": y, "button": "left", "clickCount": 1});
        browser.devtools("Input.dispatchMouseEvent", event);
    };
    let places = browser.run(PLACES, &[]);
    let x = f64::midpoint(edge(&places, "divider", "left"), edge(&places, "divider", "right"));
    mouse("mousePressed", x, 500.0);
    mouse("mouseMoved", 900.0, 510.0);
    mouse("mouseMoved", 980.0, 520.0);
    mouse("mouseReleased", 980.0, 520.0);
    mouse("mouseMoved", 300.0, 500.0);
    holds(70, "vertical");
    // Narrow results stack what stood beside the maps.
    let below = "const [list, aside] = [document.querySelector('#panel-maps > div'), document.querySelector('#panel-maps aside')];
        document.querySelector('#panel-maps .cell').focus();
        return [list, aside].map(one => { const { left, right, top, bottom } = one.getBoundingClientRect(); return { left, right, top, bottom }; })";
    let boxes = browser.run(below, &[]);
    assert_eq!(boxes[0]["left"], boxes[1]["left"], "{boxes}");
    assert_eq!(violations(&browser), json!([]));
    // The session has it, another load of the page, too.
    browser.open_url(&server.url);
    holds(70, "vertical");
    // On a narrow screen it divides the height, by the other arrows.
    browser.show_as(400, "dark");
    wait(&browser, PLACES, &|places| places["orientation"] == json!("horizontal"));
    holds(45, "horizontal");
    focus();
    for (key, now) in [(down, 47), (up, 45), (up, 43), (right, 43)] {
        press(key);
        holds(now, "horizontal");
    }
    assert_eq!(violations(&browser), json!([]));
    browser.show_as(1400, "light");
    wait(&browser, PLACES, &|places| places["now"] == json!(70));
    assert_eq!(browser.log("browser"), Vec::<Value>::new());
}

#[test]
fn long_lines_wrap_where_that_is_chosen_and_the_choice_is_kept() {
    let (browser, server, _folder) = opened("wrap");
    let long = format!("#version 330 core\n// {}\n", "a long line ".repeat(60));
    // How far the lines stand out of the editor, and how many rows of text the long one has.
    let script = "const { view } = document.getElementById('editor').editor;
        const { scrollWidth, clientWidth } = view.scrollDOM;
        const line = view.contentDOM.querySelectorAll('.cm-line')[1];
        return [scrollWidth - clientWidth, Math.round(line.getBoundingClientRect().height / view.defaultLineHeight), document.getElementById('wrap').checked]";
    browser.run(WRITE, &[json!(long)]);
    let now = wait(&browser, script, &|now| now[0].as_f64().unwrap() > 1000.0);
    assert_eq!((&now[1], &now[2]), (&json!(1), &json!(false)));
    browser.run("document.getElementById('wrap').click()", &[]);
    wait(&browser, script, &|now| now[0] == json!(0) && now[1].as_u64().unwrap() > 5);
    browser.open_url(&server.url);
    browser.run(WRITE, &[json!(long)]);
    let now = wait(&browser, script, &|now| now[0] == json!(0) && now[1].as_u64().unwrap() > 5);
    assert_eq!(now[2], json!(true));
    browser.run("document.getElementById('wrap').click()", &[]);
    wait(&browser, script, &|now| now[0].as_f64().unwrap() > 1000.0);
}

/// The words of a shown text: class and text of each, and the text without them.
const WORDS: &str = "const pre = document.querySelector(`#panel-${arguments[0]} pre`);
    const rest = pre.cloneNode(true);
    rest.querySelectorAll('span').forEach(one => one.replaceWith(' '));
    return { all: pre.textContent, rest: rest.textContent, words: [...pre.querySelectorAll('span')].map(one => [one.className, one.textContent]) }";

/// Chooses a value of the first select of a panel, and waits until the panel shows it.
fn choose(browser: &Browser, panel: &str, value: &str) -> Value {
    let script = "const [panel, value, done] = arguments;
        const { page } = document.getElementById('results');
        document.getElementById(`tab-${panel}`).click();
        const select = document.querySelector(`#panel-${panel} select`);
        select.value = value;
        select.dispatchEvent(new Event('change'));
        (function wait() { page.running || page.again ? setTimeout(wait, 5) : done(page.answers.at(-1).stdout); })();";
    browser.run_async(script, &[json!(panel), json!(value)])
}

/// The keys of all objects of a value, the texts, the numbers, and what is `true`, `false` or `null`.
fn counted(value: &Value, keys: &mut BTreeMap<String, usize>, others: &mut [usize; 3]) {
    match value {
        Value::Object(members) => {
            for (key, value) in members {
                *keys.entry(key.clone()).or_default() += 1;
                counted(value, keys, others);
            }
        }
        Value::Array(elements) => elements.iter().for_each(|one| counted(one, keys, others)),
        Value::String(_) => others[0] += 1,
        Value::Number(_) => others[1] += 1,
        Value::Bool(_) | Value::Null => others[2] += 1,
    }
}

#[test]
fn printed_code_has_colours_and_stays_the_text_of_the_command() {
    let (browser, _server, _folder) = opened("colours");
    for (panel, value, keyword, comment) in [
        ("code", "rust", "struct", "//"),
        ("code", "c", "struct", "/"),
        ("code", "csharp", "struct", "//"),
        ("code", "python", "def", "#"),
        ("code", "typescript", "export", "/"),
        ("code", "zig", "const", "//"),
        ("code", "gdscript", "func", "#"),
        ("code", "renderdoc", "struct", "//"),
        ("layout", "listing", "struct", "/"),
        ("layout", "json", "", ""),
    ] {
        let wanted = choose(&browser, panel, value);
        let shown = browser.run(WORDS, &[json!(panel)]);
        assert_eq!(shown["all"], wanted, "{value}");
        let words: Vec<(String, String)> = serde_json::from_value(shown["words"].clone()).unwrap();
        let of = |kind: &str| -> Vec<&str> {
            words.iter().filter(|(class, _)| class == kind).map(|(_, text)| text.as_str()).collect()
        };
        assert!(keyword.is_empty() || of("is-keyword").contains(&keyword), "{value}: {words:?}");
        if value == "json" {
            // Against another reader of JSON.
            let (mut keys, mut others) = (BTreeMap::new(), [0; 3]);
            let read = serde_json::from_str(wanted.as_str().unwrap()).unwrap();
            counted(&read, &mut keys, &mut others);
            let mut found = BTreeMap::new();
            for key in of("is-type") {
                *found.entry(serde_json::from_str::<String>(key).unwrap()).or_default() += 1;
            }
            let coloured = ["is-text", "is-number", "is-keyword"].map(|kind| of(kind).len());
            assert_eq!((found, coloured), (keys, others));
            continue;
        }
        assert!(of("is-comment").len() > 1 && !of("is-number").is_empty(), "{value}: {words:?}");
        assert!(
            of("is-comment").iter().all(|text| text.starts_with(comment)),
            "{value}: {words:?}"
        );
        // What is left holds neither comments nor digits that begin a number.
        let rest = shown["rest"].as_str().unwrap();
        assert!(!rest.contains(if comment == "#" { "#" } else { "//" }), "{value}: {rest}");
        let begins = rest.split(|c: char| !c.is_ascii_alphanumeric() && c != '_');
        let numbers: Vec<&str> =
            begins.filter(|word| word.starts_with(|c: char| c.is_ascii_digit())).collect();
        assert_eq!(numbers, Vec::<&str>::new(), "{value}");
    }
    for (scheme, panel, value) in [
        ("light", "layout", "json"),
        ("dark", "layout", "listing"),
        ("light", "code", "c"),
        ("dark", "code", "python"),
    ] {
        browser.show_as(1400, scheme);
        choose(&browser, panel, value);
        assert_eq!(violations(&browser), json!([]), "{scheme} {value}");
    }
    assert_eq!(browser.log("browser"), Vec::<Value>::new());
}

#[test]
fn a_link_holds_the_inputs_of_a_stage() {
    let (browser, server, folder) = opened("link-inputs");
    browser.run(
        WRITE,
        &[json!("#version 330 core\nin vec2 where;\nout vec4 color;\nvoid main() { color = vec4(where.y, where.x + 0.5, 0.0, 1.0); }\n")],
    );
    browser.run("document.getElementById('tab-run').click()", &[]);
    wait(&browser, "return document.querySelectorAll('.inputs input').length", &|now| {
        *now == json!(1)
    });
    browser.run(
        "const field = document.querySelector('.inputs input'); field.value = '[0.25, 7]'; field.dispatchEvent(new Event('input'));",
        &[],
    );
    let result = "return document.querySelector('#panel-run pre').textContent";
    let before = wait(&browser, result, &|now| now.as_str().unwrap().contains("0.75"));
    browser.run("document.getElementById('link').click()", &[]);
    let url = wait(&browser, "return location.href", &|now| now.as_str().unwrap().contains("#s="));
    browser.open(&folder.file("blank.html", "<html data-ready=1>"));
    browser.open_url(url.as_str().unwrap());
    let asked = browser.run("return document.querySelector('.inputs input')?.value ?? null", &[]);
    assert!(asked.is_null() || asked == json!("[0.25, 7]"), "{asked}");
    wait(&browser, result, &|now| *now == before);
    assert_eq!(
        browser.run("return document.querySelector('.inputs input').value", &[]),
        json!("[0.25, 7]")
    );
    // One that is damaged in that part alone is read without it.
    browser.open(&folder.file("blank.html", "<html data-ready=1>"));
    browser.open_url(&server.url);
    let fragment = browser.run_async(
        "const done = arguments[0];
         const text = JSON.stringify({ text: '#version 330\\nin vec2 where; out vec4 color; void main() { color = where.xyxy; }', kind: 'frag', tab: 'Run', inputs: '[[1, 2], \"ab\", [\"a\", \"b\", \"c\"], {}]' });
         const stream = new Blob([text]).stream().pipeThrough(new CompressionStream('deflate-raw'));
         new Response(stream).arrayBuffer().then(bytes => done(btoa(String.fromCharCode(...new Uint8Array(bytes))).replaceAll('+', '-').replaceAll('/', '_').replaceAll('=', '')));",
        &[],
    );
    browser.run("location.hash = `s=${arguments[0]}`", &[fragment]);
    wait(
        &browser,
        "return [...document.querySelectorAll('.inputs input')].map(one => one.value)",
        &|now| *now == json!([""]),
    );
}
