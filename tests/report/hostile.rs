//! A hundred injections in the texts that a page shows: all of them stay text.

use serde_json::{Value, json};

use crate::browser::Browser;
use crate::support::{DRAW_ALL, Folder, landfall, output};

/// What would set `window.hacked`, open a dialog, load something, or end the element it is in.
pub const INJECTIONS: [&str; 20] = [
    "<script>window.hacked = 1</script>",
    "</script><script>window.hacked = 1</script>",
    "</SCRIPT ><sCrIpT>hacked=1</ScRiPt>",
    "<!--<script>",
    "--><script>hacked=1</script>",
    "<img src=x onerror=hacked=1>",
    "<svg onload=hacked=1>",
    "<svg><animate onbegin=hacked=1 attributeName=x dur=1s>",
    "<iframe srcdoc='<script>parent.hacked=1</script>'></iframe>",
    "<link rel=stylesheet href=http://127.0.0.1:9/x.css>",
    "<base href=http://127.0.0.1:9/>",
    "<meta http-equiv=refresh content='0;url=http://127.0.0.1:9/'>",
    "<object data=javascript:hacked=1></object>",
    "<a href=javascript:hacked=1 id=main>x</a>",
    "\\\" onmouseover=\\\"hacked=1\\\" x=\\\"",
    "' autofocus onfocus='hacked=1",
    "</style><style>@import 'http://127.0.0.1:9/x.css';</style>",
    "${hacked=1}{{script}}{{data}}",
    "\\u003cscript\\u003ehacked=1\\u003c/script\\u003e",
    "<details open ontoggle=hacked=1><input autofocus onfocus=hacked=1>",
];

/// The places of a text that somebody else wrote: the file's name, an `#error`, an include that is
/// not there, what is no GLSL, and a name in a lock.
fn plant(folder: &Folder, number: usize, injection: &str) {
    let name = injection.replace('/', "\u{2215}");
    folder.file(
        &format!("a{number} {name}.frag"),
        "#version 450\nlayout(binding = 0) uniform B { vec3 a; float b; };\nvoid main() {}\n",
    );
    folder.file(&format!("b{number}.frag"), format!("#version 450\n#error {injection}\n"));
    let include = format!("#version 450\n#include \"{}\"\n", injection.replace('"', ""));
    folder.file(&format!("c{number}.frag"), include);
    folder.file(&format!("d{number}.frag"), format!("#version 450\nuniform {injection};\n"));
    folder.file(
        &format!("e{number}.frag"),
        "#version 450\nlayout(binding = 0) uniform B { vec3 victim; vec3 b; };\nvoid main() {}\n",
    );
}

/// The name of a member in the lock of a shader becomes an injection.
fn hostile_lock(folder: &Folder, number: usize, injection: &str) {
    let path = folder.path().join(format!("layouts/e{number}.frag.json"));
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(text.contains("\"victim\""), "{text}");
    std::fs::write(&path, text.replace("\"victim\"", &json!(injection).to_string())).unwrap();
}

#[test]
fn a_hundred_injections_stay_text() {
    let (browser, folder) = (Browser::start("hostile"), Folder::new("hostile"));
    for (number, injection) in INJECTIONS.iter().enumerate() {
        plant(&folder, number, injection);
    }
    landfall(folder.path(), &["lock", "."]);
    for (number, injection) in INJECTIONS.iter().enumerate() {
        hostile_lock(&folder, number, injection);
    }
    output(folder.path(), 2, &["report", ".", "-o", "page.html"]);
    browser.log("performance");
    browser.open(&folder.path().join("page.html"));
    browser.run(DRAW_ALL, &[]);
    // Everything that can be pressed or pointed at, twice, so that what opens is there, too.
    browser.run(
        "for (let round = 0; round < 2; round += 1) {
            for (const one of document.querySelectorAll('button, summary, a')) {
                one.dispatchEvent(new MouseEvent('mouseover', { bubbles: true }));
                one.focus();
                if (one.localName !== 'a') one.click();
            }
        }",
        &[],
    );
    let shown = browser.run(
        "return { hacked: window.hacked ?? null, scripts: document.scripts.length, styles: document.styleSheets.length,
            elements: document.querySelectorAll('img, svg:not(.lines), iframe, link, base, object, embed, style:not(head > style), main a:not([href^=\"#\"]), form').length,
            metas: document.querySelectorAll('meta').length, ids: document.querySelectorAll('#main').length,
            attributes: [...document.querySelectorAll('*')].flatMap(one => one.getAttributeNames()).filter(name => name.startsWith('on')),
            names: [...document.querySelectorAll('.figure[data-side=old] .cell b')].map(one => one.textContent),
            text: document.body.textContent, title: document.title, url: location.protocol }",
        &[],
    );
    assert_eq!(shown["hacked"], Value::Null);
    assert_eq!((&shown["scripts"], &shown["styles"]), (&json!(2), &json!(1)));
    assert_eq!((&shown["elements"], &shown["metas"]), (&json!(0), &json!(5)));
    assert_eq!((&shown["ids"], &shown["attributes"]), (&json!(1), &json!([])));
    assert_eq!((&shown["title"], &shown["url"]), (&json!("Landfall report"), &json!("file:")));
    let text = shown["text"].as_str().unwrap();
    for injection in INJECTIONS {
        // In the message of its `#error`; the data of the page has `<` escaped.
        assert!(text.contains(injection), "{injection} is shown");
    }
    // A lock whose member has such a name is shown beside the shader; a cell shows what follows the
    // last point of its path.
    let names = shown["names"].as_array().unwrap();
    for injection in INJECTIONS.iter().filter(|injection| !injection.contains(['.', '['])) {
        assert!(names.contains(&json!(injection)), "{injection}: {names:?}");
    }
    assert_eq!(requests(&browser), Vec::<String>::new());
    // Nothing was tried that the policy had to refuse.
    let console: Vec<Value> = browser.log("browser");
    assert_eq!(console, Vec::<Value>::new());
}

#[test]
fn the_policy_refuses_what_the_page_does_not_do_itself() {
    let (browser, folder) = (Browser::start("policy"), Folder::new("policy"));
    folder.file("a.frag", "uniform B { vec3 a; };\n");
    output(folder.path(), 0, &["report", "a.frag", "-o", "page.html"]);
    browser.log("performance");
    browser.open(&folder.path().join("page.html"));
    // As if an injection had become an element after all.
    let tried = browser.run(
        "const found = {};
        const script = document.createElement('script');
        try { script.textContent = 'window.hacked = 1'; document.body.append(script); } catch (error) { found.script = error.name; }
        try { document.body.innerHTML += '<b>x</b>'; } catch (error) { found.html = error.name; }
        const image = document.createElement('img');
        image.src = 'http://127.0.0.1:9/x.png';
        document.body.append(image);
        const style = document.createElement('style');
        style.textContent = 'body { margin: 77px }';
        document.body.append(style);
        found.hacked = window.hacked ?? null;
        found.margin = getComputedStyle(document.body).marginLeft;
        return found;",
        &[],
    );
    let wanted =
        json!({"script": "TypeError", "html": "TypeError", "hacked": null, "margin": "0px"});
    assert_eq!(tried, wanted);
    assert_eq!(requests(&browser), Vec::<String>::new());
    // Without the policy, the image is asked for: the log would show it.
    let address = "http://127.0.0.1:9/x.png";
    let open = format!(
        "<html data-ready=1><img src={address}><script>document.documentElement.dataset.ready = 1</script>"
    );
    browser.open(&folder.file("open.html", open));
    assert_eq!(requests(&browser), [address]);
}

/// The addresses that pages asked for and no policy refused, but for the pages themselves.
pub fn requests(browser: &Browser) -> Vec<String> {
    let mut found: Vec<(String, String)> = Vec::new();
    for entry in browser.log("performance") {
        let message: Value = serde_json::from_str(entry["message"].as_str().unwrap()).unwrap();
        let (event, of) = (&message["message"]["method"], &message["message"]["params"]);
        let id = of["requestId"].as_str().unwrap_or_default().to_string();
        if event == "Network.loadingFailed" && of["blockedReason"] == json!("csp") {
            found.retain(|(other, _)| *other != id);
        }
        // The tab that the browser opened first loads files of its own.
        let document = of["documentURL"].as_str().unwrap_or_default();
        if event == "Network.requestWillBeSent" && document.starts_with("file://") {
            let url = of["request"]["url"].as_str().unwrap();
            if url != document {
                found.push((id, url.to_string()));
            }
        }
    }
    found.into_iter().map(|(_, url)| url).collect()
}
