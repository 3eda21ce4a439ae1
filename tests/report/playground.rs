//! The playground from a file: its WebAssembly against the command, byte for byte, and its page.
//!
//! `crates/landfall-web/build target/playground/page.html` builds it, as `tests/run` does.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::SystemTime;

use serde_json::{Value, json};

use crate::access::{NUMBER, TAB, violations};
use crate::browser::Browser;
use crate::hostile::{INJECTIONS, requests};
use crate::support::{Folder, landfall, repository};

/// The page, built from the sources as they are.
fn page() -> PathBuf {
    let page = repository().join("target/playground/page.html");
    let build = "build it with crates/landfall-web/build target/playground/page.html";
    let built = std::fs::metadata(&page).unwrap_or_else(|_| panic!("{build}")).modified().unwrap();
    let mut newest = (SystemTime::UNIX_EPOCH, PathBuf::new());
    for folder in ["src", "crates"] {
        look(&repository().join(folder), &mut newest);
    }
    assert!(newest.0 <= built, "the page is older than {}: {build}", newest.1.display());
    page
}

/// The newest source below a folder, without those of the command and of tests.
fn look(folder: &Path, newest: &mut (SystemTime, PathBuf)) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            if !["tests", "bin", "editor"].iter().any(|name| path.ends_with(name)) {
                look(&path, newest);
            }
            continue;
        }
        let changed = std::fs::metadata(&path).unwrap().modified().unwrap();
        let is_source = path.extension().is_some_and(|end| end != "md");
        if is_source && changed > newest.0 {
            *newest = (changed, path);
        }
    }
}

#[test]
#[ignore = "needs the page as it is shipped: ./tests/run pages"]
fn the_editor_is_what_its_sources_bundle_to() {
    let folder = Folder::new("editor");
    let built = folder.path().join("editor.js");
    let done = Command::new(repository().join("crates/landfall-web/editor/build"))
        .arg(&built)
        .output()
        .expect("bash is there");
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let checked_in = repository().join("crates/landfall-web/src/playground/page/editor.js");
    let same = std::fs::read(built).unwrap() == std::fs::read(checked_in).unwrap();
    assert!(
        same,
        "run crates/landfall-web/editor/build crates/landfall-web/src/playground/page/editor.js"
    );
}

/// Asks the engine of the page: a path, a text and what is wanted, each with the options of the page.
const ASK: &str = "
    const [all, done] = arguments;
    const { page } = document.getElementById('results');
    (async () => {
        const found = [];
        for (const given of all) {
            try {
                found.push(JSON.parse(await page.engine.answer({ ...page.request(), ...given })));
            } catch (error) {
                found.push({ error: String(error) });
            }
        }
        done(found);
    })();";

fn wanted() -> Value {
    json!([
        {"kind": "layout", "format": "json"}, {"kind": "check", "format": "json"},
        {"kind": "emit", "lang": "rust"}, {"kind": "layout", "format": "table"},
    ])
}

/// The same of the command, in a folder where the text is the file of that path.
fn of_command(folder: &Folder, path: &str, text: &str) -> Value {
    folder.file(path, text);
    let run = |arguments: &[&str], with_findings: bool| {
        let done = landfall(folder.path(), arguments);
        let text = |bytes| String::from_utf8(bytes).unwrap();
        // `check` counts on standard error what its report holds.
        let stderr = if with_findings { text(done.stderr) } else { String::new() };
        json!({"stdout": text(done.stdout), "stderr": stderr, "code": done.status.code()})
    };
    json!([
        run(&["layout", path, "--format", "json"], true),
        run(&["check", path, "--format", "json"], false),
        run(&["emit", path, "--lang", "rust"], true),
        run(&["layout", path], true),
    ])
}

/// The shaders of this repository that are complete in one file, under the name that the page gives.
fn shaders() -> Vec<(String, String)> {
    let mut found = Vec::new();
    let mut folders = vec![repository().join("shaders")];
    while let Some(folder) = folders.pop() {
        let mut entries: Vec<PathBuf> =
            std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
        entries.sort();
        for path in entries {
            let ending = path.extension().unwrap_or_default().to_string_lossy().into_owned();
            if path.is_dir() {
                folders.push(path);
            } else if ["frag", "vert", "comp", "glsl", "wgsl"].contains(&ending.as_str()) {
                found.push((format!("shader.{ending}"), std::fs::read_to_string(path).unwrap()));
            }
        }
    }
    found
}

/// Cuts, doubles or replaces a part of a text.
fn mutant(random: &mut fastrand::Rng, text: &str) -> String {
    let place = |random: &mut fastrand::Rng| {
        let mut at = random.usize(..=text.len());
        while !text.is_char_boundary(at) {
            at -= 1;
        }
        at
    };
    let from = place(random);
    let to = text.len().min(from + random.usize(0..24));
    let to = (from..=to).rev().find(|at| text.is_char_boundary(*at)).unwrap();
    let parts = [
        "",
        "{",
        "}",
        ";",
        "[3]",
        "[0]",
        "mat3 m;",
        "vec3",
        "double",
        "/*",
        "#if 1\n",
        "\u{e9}",
        "@align(16)",
        "row_major ",
        "99999999999",
    ];
    let new = match random.u8(0..3) {
        0 => String::new(),
        1 => text[from..to].repeat(2),
        _ => random.choice(parts).unwrap().to_string(),
    };
    format!("{}{new}{}", &text[..from], &text[to..])
}

#[test]
#[ignore = "needs the page as it is shipped: ./tests/run pages"]
fn results_are_those_of_the_command_byte_for_byte() {
    let browser = Browser::start("playground");
    browser.open(&page());
    let shaders = shaders();
    assert!(shaders.len() >= 60, "{}", shaders.len());
    let mut random = fastrand::Rng::with_seed(20);
    let mutants: Vec<(String, String)> = (0..200)
        .map(|_| {
            let (path, text) = random.choice(&shaders).unwrap();
            (path.clone(), mutant(&mut random, text))
        })
        .collect();
    let all: Vec<&(String, String)> = shaders.iter().chain(&mutants).collect();
    let ask = |part: &[&(String, String)]| {
        let given: Vec<Value> = part
            .iter()
            .map(|(path, text)| json!({"path": path, "text": text, "want": wanted()}))
            .collect();
        browser.run_async(ASK, &[json!(given)])
    };
    let answers: Vec<Value> =
        all.chunks(20).flat_map(|part| ask(part).as_array().unwrap().clone()).collect();
    let threads = std::thread::available_parallelism().map_or(2, usize::from);
    let numbers: Vec<usize> = (0..all.len()).collect();
    std::thread::scope(|scope| {
        for part in numbers.chunks(all.len().div_ceil(threads)) {
            let (all, answers) = (&all, &answers);
            scope.spawn(move || {
                let folder = Folder::new(&format!("playground-{}", part[0]));
                for number in part {
                    let (path, text) = all[*number];
                    let wanted = of_command(&folder, path, text);
                    let found = &answers[*number]["answers"];
                    assert_eq!(*found, wanted, "{number} {path}:\n{text}");
                }
            });
        }
    });
    // Mutants are of use only where they are told apart from what they were made of.
    let failed =
        answers[shaders.len()..].iter().filter(|one| one["answers"][0]["code"] != json!(0));
    assert!(failed.count() > 50);
}

#[test]
#[ignore = "needs the page as it is shipped: ./tests/run pages"]
fn calls_are_those_of_run() {
    let (browser, folder) = (Browser::start("calls"), Folder::new("calls"));
    browser.open(&page());
    let text = "#version 330 core
struct Light { vec3 pos; float power; };
layout(std140) uniform Lights { Light lights[6]; int count; };
float fade(Light light, float d) { return light.power / (1.0 + 0.3 * d + 0.07 * d * d); }
vec3 lit(vec3 n, vec3 v) { return normalize(n) * pow(max(dot(n, v), 0.0), 32.0); }
float sum() { float s = 0.0; for (int i = 0; i < count; i++) s += lights[i].power; return s; }
void main() {}
";
    folder.file("shader.frag", text);
    let data = r#"{"Lights": {"count": 2, "lights": [{"power": 0.1}, {"power": 3}]}}"#;
    let calls = [
        ("fade", r#"[{"pos": [1, 2, 3], "power": 2}, 7.3]"#, "", "human"),
        ("fade", r#"[{"pos": [1, 2, 3], "power": 2}, 7.3]"#, "", "json"),
        ("lit(vec3, vec3)", "[[0, 0.6, 0.8], [0, 1, 0]]", "", "human"),
        ("lit", "[[0, 0, 0], [0, 1, 0]]", "", "json"),
        ("sum", "[]", data, "human"),
        ("sum", "[]", "{", "human"),
        ("none", "[]", "", "human"),
        ("fade", "7", "", "json"),
    ];
    let given: Vec<Value> = calls
        .iter()
        .map(|(function, args, data, format)| {
            let call = json!({"kind": "run", "function": function, "args": args, "data": data, "format": format});
            json!({"path": "shader.frag", "text": text, "want": [{"kind": "functions"}, call]})
        })
        .collect();
    let answers = browser.run_async(ASK, &[json!(given)]);
    for (number, (function, args, data, format)) in calls.iter().enumerate() {
        let mut arguments =
            vec!["run", "shader.frag", "--fn", function, "--args", args, "--format", format];
        if !data.is_empty() {
            arguments.extend(["--data", data]);
        }
        let done = landfall(folder.path(), &arguments);
        let text = |bytes| String::from_utf8(bytes).unwrap();
        let wanted = json!({"stdout": text(done.stdout), "stderr": text(done.stderr), "code": done.status.code()});
        let answer = &answers[number]["answers"];
        assert_eq!(answer[1], wanted, "{arguments:?}: {}", answers[number]);
        let names: Vec<&str> =
            answer[0].as_array().unwrap().iter().map(|one| one[0].as_str().unwrap()).collect();
        assert_eq!(names, ["fade(Light, float)", "lit(vec3, vec3)", "sum()", "main()"]);
        // What the page proposes as arguments is taken.
        let proposed = json!({"kind": "run", "function": names[number % 3], "args": answer[0][number % 3][1], "data": "", "format": "json"});
        let given = json!([{"path": "shader.frag", "text": given[0]["text"], "want": [proposed]}]);
        assert_eq!(
            browser.run_async(ASK, &[given])[0]["answers"][0]["code"],
            json!(0),
            "{proposed}"
        );
    }
}

/// Writes a text into the editor.
pub const WRITE: &str = "document.getElementById('editor').editor.text = arguments[0];";

/// The processor time of the thread of the page, in milliseconds.
fn thread_time(browser: &Browser) -> f64 {
    let metrics = browser.devtools("Performance.getMetrics", json!({}));
    let mut metrics = metrics["metrics"].as_array().unwrap().iter();
    let time = metrics.find(|metric| metric["name"] == "ThreadTime").unwrap();
    1000.0 * time["value"].as_f64().unwrap()
}

/// The elapsed time, which a busy machine stretches, is printed.
#[test]
#[ignore = "needs the page as it is shipped: ./tests/run pages"]
fn the_map_follows_a_key_within_two_frames_of_processor_time() {
    let browser = Browser::start("keys");
    browser.open(&page());
    browser.show_as(1400, "light");
    browser.devtools("Performance.enable", json!({}));
    let before = thread_time(&browser);
    // A member of the structure of six lights is written letter by letter, and taken away again.
    let times = browser.run(
        "const { view } = document.getElementById('editor').editor;
         const at = view.state.doc.toString().indexOf('    float constant;');
         const { page } = document.getElementById('results');
         const times = [];
         for (let round = 0; round < 12; round += 1) {
             const member = '    float extra;\\n';
             for (let n = 0; n < member.length; n += 1) {
                 // Where an update took long, by a busy machine, the next one would wait.
                 page.took = 0;
                 const began = performance.now();
                 view.dispatch({ changes: { from: at + n, insert: member[n] } });
                 document.querySelector('.maps').offsetHeight;
                 times.push(performance.now() - began);
             }
             const shown = [...document.querySelectorAll('.cell b')].filter(one => one.textContent === 'extra').length;
             if (shown !== 3) throw new Error(`${shown} cells`);
             view.dispatch({ changes: { from: at, to: at + member.length } });
         }
         return times;",
        &[],
    );
    let mut times: Vec<f64> =
        times.as_array().unwrap().iter().map(|time| time.as_f64().unwrap()).collect();
    times.sort_by(f64::total_cmp);
    let share = |part: f64| times[(times.len() as f64 * part) as usize];
    let worked = (thread_time(&browser) - before) / times.len() as f64;
    println!(
        "key to map: median {:.1} ms, 9 of 10 within {:.1} ms; {worked:.1} ms of processor time",
        share(0.5),
        share(0.9)
    );
    assert!(worked > 0.5 && worked < 2.0 * 1000.0 / 60.0, "{worked} ms: {times:?}");
}

#[test]
#[ignore = "needs the page as it is shipped: ./tests/run pages"]
fn the_page_can_be_used_without_a_mouse_and_has_no_barriers() {
    let browser = Browser::start("playground-access");
    browser.open(&page());
    for (width, scheme) in [(1400, "light"), (1400, "dark"), (400, "light"), (400, "dark")] {
        browser.show_as(width, scheme);
        for tab in ["maps", "findings", "layout", "code", "run", "lights"] {
            browser.run("document.getElementById(`tab-${arguments[0]}`).click()", &[json!(tab)]);
            // With findings.
            browser.run(WRITE, &[json!("#version 450\nlayout(std140, binding = 0) uniform B { vec3 a[2]; float b; mat3 m; } b;\nfloat f(float x) { return 1.0 / x; }\nvoid main() { b.c; }\n")]);
            assert_eq!(violations(&browser), json!([]), "{width} {scheme} {tab}");
        }
    }
    browser.show_as(1400, "light");
    browser.run("document.getElementById('tab-maps').click()", &[]);
    // Maps of a text with an error are inert.
    browser.run(WRITE, &[json!("#version 450\nlayout(std140, binding = 0) uniform B { vec3 a[2]; float b; mat3 m; } b;\nvoid main() {}\n")]);
    browser.run(NUMBER, &[]);
    // Once around the page, out of the editor by Escape.
    for _ in 0..160 {
        browser.press(&[TAB]);
        if browser.run("return document.activeElement.id === 'editor'", &[]) == json!(true) {
            browser.press(&["\u{e00c}"]);
        }
    }
    let missed = browser.run(
        "return operable().filter(one => !reached.has(one) && one.tabIndex >= 0).map(one => one.outerHTML.slice(0, 200))",
        &[],
    );
    assert_eq!(missed, json!([]));
    let in_editor = browser.run("return [...reached].some(one => one.id === 'editor')", &[]);
    assert_eq!(in_editor, json!(true));
    // Tabs are changed by arrows.
    browser.run("document.getElementById('tab-maps').focus()", &[]);
    for tab in ["findings", "layout", "code", "run", "lights", "maps"] {
        browser.press(&["\u{e014}"]);
        let shown = browser.run("return [document.activeElement.id, [...document.querySelectorAll('[role=tabpanel]')].filter(one => !one.hidden).map(one => one.id)]", &[]);
        assert_eq!(shown, json!([format!("tab-{tab}"), [format!("panel-{tab}")]]));
    }
}

#[test]
#[ignore = "needs the page as it is shipped: ./tests/run pages"]
fn a_link_holds_the_state() {
    let browser = Browser::start("link");
    browser.open(&page());
    let text = "struct A { v: vec3f, w: f32 }\n// \u{e9}\u{1f4a1}\n@group(0) @binding(0) var<uniform> a: array<A, 3>;\n";
    browser.run(
        "document.getElementById('kind').value = 'wgsl';
         document.getElementById('target').value = 'webgpu';
         document.getElementById('defines').value = 'X=2';
         document.getElementById('tab-layout').click();
         document.getElementById('editor').editor.text = arguments[0];",
        &[json!(text)],
    );
    let shown = "return { text: document.getElementById('editor').editor.text, target: document.getElementById('target').value,
        defines: document.getElementById('defines').value, layout: document.querySelector('#panel-layout pre').textContent }";
    let before = browser.run(shown, &[]);
    assert_eq!(before["text"], json!(text));
    std::thread::sleep(std::time::Duration::from_secs(1));
    let url = browser.run("return location.href", &[]);
    let url = url.as_str().unwrap();
    assert!(url.contains("#s="), "{url}");
    // By way of another page: a change of the fragment alone opens nothing.
    let folder = Folder::new("link");
    browser.open(&folder.file("blank.html", "<html data-ready=1>"));
    browser.open_url(url);
    assert_eq!(browser.run(shown, &[]), before);
    assert!(before["layout"].as_str().unwrap().contains("a[3]"), "{before}");
}

#[test]
#[ignore = "needs the page as it is shipped: ./tests/run pages"]
fn injections_in_texts_and_links_stay_text_and_nothing_is_loaded() {
    let browser = Browser::start("playground-hostile");
    browser.log("performance");
    browser.open(&page());
    let elements = "return [document.scripts.length, document.querySelectorAll('*').length]";
    for tab in ["maps", "findings", "layout", "code", "run", "lights"] {
        browser.run("document.getElementById(`tab-${arguments[0]}`).click()", &[json!(tab)]);
        browser.run(WRITE, &[json!("#version 450\n#error harmless\n")]);
        let before = browser.run(elements, &[]);
        for injection in INJECTIONS {
            browser.run(WRITE, &[json!(format!("#version 450\n#error {injection}\n"))]);
            browser.run("const field = document.getElementById('defines'); field.value = arguments[0]; field.dispatchEvent(new Event('input'));", &[json!(injection)]);
            browser.run("const field = document.getElementById('defines'); field.value = ''; field.dispatchEvent(new Event('input'));", &[]);
            // The evaluator answers later than the others.
            browser.run_async(
                "const done = arguments[0]; const { page } = document.getElementById('results');
                 (function wait() { page.running || page.again ? setTimeout(wait, 5) : done(); })();",
                &[],
            );
            let now = browser.run("return [window.hacked ?? null, document.scripts.length, document.querySelectorAll('#results img, #results svg, #results iframe, #results script, #results link, #results style, #results form, #results object, #results a').length, document.getElementById('results').page.answers[0].shaders[0].findings[0].message]", &[]);
            assert_eq!(
                (&now[0], &now[1], &now[2]),
                (&Value::Null, &before[0], &json!(0)),
                "{injection}"
            );
            assert!(now[3].as_str().unwrap().contains(injection.trim_end()), "{now} {injection}");
        }
    }
    // States that are none, and one with texts where options are expected.
    for fragment in [
        "#s=",
        "#s=AAAA",
        "#s=%3Cscript%3E",
        "#<script>hacked=1</script>",
        "#s=q1YqzkgtylGyUipJrShRqgUA",
    ] {
        browser.run("location.hash = arguments[0]", &[json!(fragment)]);
        std::thread::sleep(std::time::Duration::from_millis(200));
        assert_eq!(browser.run("return window.hacked ?? null", &[]), Value::Null);
    }
    assert_eq!(requests(&browser), Vec::<String>::new());
    let console: Vec<Value> = browser.log("browser");
    assert_eq!(console, Vec::<Value>::new());
}
