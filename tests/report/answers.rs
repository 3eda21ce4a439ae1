//! What a person asks of a page first, answered from what its first screen shows: each answer is on
//! the screen after at most two interactions. The time of each is printed.

use std::path::Path;
use std::time::Instant;

use serde_json::{Value, json};

use crate::browser::Browser;
use crate::serve::Server;
use crate::support::{Folder, landfall, output, repository};

/// A page that is asked; it counts what a person does.
struct Asked<'a> {
    browser: &'a Browser,
    began: Instant,
    interactions: usize,
}

/// Finds an element by a selector and a part of its text, and keeps it as `one`.
const FIND: &str = "const one = [...document.querySelectorAll(arguments[0])]
    .find(each => each.checkVisibility() && each.textContent.includes(arguments[1]));
    if (!one) throw new Error(`no ${arguments[0]} with ${arguments[1]}`);";

impl<'a> Asked<'a> {
    fn open(browser: &'a Browser, page: &Path) -> Asked<'a> {
        browser.open(page);
        Asked { browser, began: Instant::now(), interactions: 0 }
    }

    /// Clicks the first element that is on the screen and has a text.
    fn click(&mut self, selector: &str, text: &str) {
        let script = format!(
            "{FIND} const box = one.getBoundingClientRect();
            if (box.bottom < 0 || box.top > innerHeight) throw new Error('not on the screen');
            one.click();"
        );
        self.browser.run(&script, &[json!(selector), json!(text)]);
        self.interactions += 1;
    }

    /// Writes into the first field that is on the screen.
    fn write(&mut self, selector: &str, value: &str) {
        let script = "const one = [...document.querySelectorAll(arguments[0])].find(each => {
                const box = each.getBoundingClientRect();
                return each.checkVisibility() && box.top >= 0 && box.bottom <= innerHeight;
            });
            one.focus();
            one.value = arguments[1];
            one.dispatchEvent(new Event('input', { bubbles: true }));";
        self.browser.run(script, &[json!(selector), json!(value)]);
        self.interactions += 1;
    }

    /// The whole text of the first element with a part of it, which is on the screen.
    fn read(&self, question: &str, selector: &str, text: &str) -> String {
        let script = format!(
            "{FIND} const box = one.getBoundingClientRect();
            return [one.textContent, box.bottom > 0 && box.top < innerHeight];"
        );
        let found = self.browser.run(&script, &[json!(selector), json!(text)]);
        assert_eq!(found[1], json!(true), "{question}: on the screen");
        assert!(self.interactions <= 2, "{question}: {} interactions", self.interactions);
        let seconds = self.began.elapsed().as_secs_f64();
        println!("{question}: {} interactions, {seconds:.2} s", self.interactions);
        found[0].as_str().unwrap().to_string()
    }
}

const BROKEN: &str = "shaders/casters/point_450.frag";
const MOVED: &str = "shaders/light_arrays/all_lights_450.frag";

/// The shaders of the repository with locks; since these, one lost a semicolon, and one got a member.
fn project() -> Folder {
    let folder = Folder::new("answers");
    let list = std::process::Command::new("cp")
        .args(["-r", repository().join("shaders").to_str().unwrap(), "."])
        .current_dir(folder.path())
        .status();
    assert!(list.unwrap().success());
    folder.file("landfall.toml", "");
    output(folder.path(), 0, &["lock", "shaders"]);
    let read = |path: &str| std::fs::read_to_string(folder.path().join(path)).unwrap();
    let text = read(BROKEN);
    let line =
        text.lines().find(|line| line.trim_end().ends_with(';') && line.contains("vec3")).unwrap();
    folder.file(BROKEN, text.replacen(line, line.trim_end().trim_end_matches(';'), 1));
    let text = read(MOVED);
    let first = "struct PointLight";
    let (before, after) = text.split_once(first).expect(first);
    folder.file(MOVED, format!("{before}{first}{}", after.replacen('{', "{\n    vec4 cookie;", 1)));
    folder
}

/// Size less the bytes of all scalars, by the JSON of `layout`: the largest of all blocks.
fn most_padding(folder: &Folder) -> (String, u64) {
    let layouts = landfall(folder.path(), &["layout", "shaders", "-f", "json"]).stdout;
    let layouts: Value = serde_json::from_slice(&layouts).unwrap();
    let blocks = layouts["shaders"]
        .as_array()
        .unwrap()
        .iter()
        .flat_map(|one| one["blocks"].as_array().unwrap());
    let of = |block: &Value| {
        let used: u64 = block["leaves"]
            .as_array()?
            .iter()
            .map(|leaf| {
                let dims =
                    leaf["dims"].as_array().unwrap().iter().map(|dim| dim.as_u64().unwrap_or(1));
                let [width, columns, rows] =
                    ["width", "columns", "rows"].map(|key| leaf[key].as_u64().unwrap());
                width * columns * rows * dims.product::<u64>()
            })
            .sum();
        Some((block["name"].as_str()?.to_string(), block["size"].as_u64()? - used))
    };
    blocks.filter_map(of).max_by_key(|(_, padding)| *padding).unwrap()
}

#[test]
fn questions_of_a_report_take_two_interactions_at_most() {
    let (browser, folder) = (Browser::start("answers"), project());
    let page = folder.path().join("page.html");
    landfall(folder.path(), &["report", "shaders", "-o", "page.html"]);
    browser.show_as(1400, "light");

    let asked = Asked::open(&browser, &page);
    let told = asked.read("which shader is broken, at which line", "#overview li", "error");
    let short = landfall(folder.path(), &["check", "shaders", "-f", "short"]).stdout;
    let short = String::from_utf8(short).unwrap();
    let at = short
        .lines()
        .find(|line| line.contains(": error[syntax]"))
        .unwrap_or_else(|| panic!("{short}"));
    let at = at.split_once(": error").unwrap().0;
    assert!(at.starts_with(BROKEN) && told.ends_with(at), "{told} {at}");

    let asked = Asked::open(&browser, &page);
    let told = asked.read("which block wastes most", "#summary", "most padding");
    let (name, padding) = most_padding(&folder);
    assert!(told.contains(&format!("most padding: {name}")), "{told} {name}");
    let bytes = landfall_layout::format::phrases::bytes(padding);
    assert!(told.contains(&bytes), "{told} {bytes}");

    let mut asked = Asked::open(&browser, &page);
    asked.click("#summary a", &name);
    asked.write("input.byte", "172");
    let told = asked.read("who is at byte 172", "output.who", "byte 172");
    assert!(told.starts_with("byte 172 is "), "{told}");

    let mut asked = Asked::open(&browser, &page);
    asked.click("#overview li a", "layout-drift");
    let told = asked.read("what moved between two versions", ".finding", "layout-drift");
    assert!(told.contains(MOVED) && told.contains("cookie"), "{told}");
}

/// Of 0.8 of full scale, 1/256 is left where 1 + 0.09 d + 0.032 d² is 0.8 × 256: at d = 78.4.
#[test]
fn how_far_a_light_reaches_is_told_beside_it() {
    let (browser, folder) = (Browser::start_with_webgpu("reach"), Folder::new("reach"));
    let scene = repository().join("shaders/scenes/six_lights.json");
    let server = Server::start(folder.path(), &[scene.to_str().unwrap()]);
    browser.show_as(1400, "light");
    browser.open_url(&server.url);
    let waited = Instant::now();
    let shown = "return [...document.querySelectorAll('.lights button')].some(one => one.textContent === 'point 3')";
    while browser.run(shown, &[]) != json!(true) && waited.elapsed().as_secs() < 30 {
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    // Which lights end at their range, and which fade out before, the list tells at once.
    let ends =
        "return Object.fromEntries([...document.querySelectorAll('.lights button[data-ends]')]
        .map(one => [one.textContent, one.dataset.ends]))";
    let ends = browser.run(ends, &[]);
    assert_eq!(ends["point 3"], "to 78.4");
    let mut asked = Asked { browser: &browser, began: Instant::now(), interactions: 0 };
    asked.click(".lights button", "point 3");
    let told = asked.read("how far a light reaches", ".controls .note", "full scale");
    assert_eq!(told, "below 1/256 of full scale from distance 78.4 on");
}
