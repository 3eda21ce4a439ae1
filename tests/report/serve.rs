//! `landfall serve`: whom it answers and what, and its page in a browser.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use crate::browser::Browser;
use crate::playground::WRITE;
use crate::support::{Folder, landfall, output};

/// A server, which ends with the value.
pub struct Server {
    process: Child,
    pub url: String,
}

impl Server {
    pub fn start(folder: &Path, arguments: &[&str]) -> Server {
        let mut process = Command::new(env!("CARGO_BIN_EXE_landfall"))
            .arg("serve")
            .args(arguments)
            .current_dir(folder)
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut url = String::new();
        BufReader::new(process.stdout.as_mut().unwrap()).read_line(&mut url).unwrap();
        Server { process, url: url.trim_end().to_string() }
    }

    /// Host with port, and the token.
    fn parts(&self) -> (&str, &str) {
        let rest = self.url.strip_prefix("http://").unwrap();
        let (host, token) = rest.split_once('/').unwrap();
        (host, token.strip_suffix('/').unwrap())
    }

    /// Sends a request as it is written; the status and the body of the answer.
    fn send(&self, request: &str) -> (u16, String) {
        let mut stream = TcpStream::connect(self.parts().0).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(10))).unwrap();
        stream.write_all(request.as_bytes()).unwrap();
        let mut answer = Vec::new();
        let _ = stream.read_to_end(&mut answer);
        let answer = String::from_utf8_lossy(&answer).into_owned();
        let status = answer.split(' ').nth(1).and_then(|status| status.parse().ok()).unwrap_or(0);
        (
            status,
            answer.split_once("\r\n\r\n").map_or_else(String::new, |(_, body)| body.to_string()),
        )
    }

    /// A GET of a path with headers beside `Host`.
    fn get(&self, path: &str, host: &str, headers: &str) -> (u16, String) {
        self.send(&format!(
            "GET {path} HTTP/1.1\r\nHost: {host}\r\n{headers}Connection: close\r\n\r\n"
        ))
    }

    /// Asks the engine.
    fn ask(&self, request: &Value) -> Value {
        let (host, token) = self.parts();
        let body = request.to_string();
        let (status, answer) = self.send(&format!(
            "POST /{token}/answer HTTP/1.1\r\nHost: {host}\r\nContent-Type: application/json\r\n\
             Content-Length: {}\r\nConnection: close\r\n\r\n{body}",
            body.len()
        ));
        assert_eq!(status, 200);
        serde_json::from_str(&answer).unwrap()
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

#[test]
fn only_the_page_itself_is_answered() {
    let folder = Folder::new("serve-guard");
    folder.file("a.frag", "uniform B { vec3 a; } b;\n");
    folder.file("secret.txt", "secret");
    let server = Server::start(folder.path(), &["a.frag"]);
    let (host, token) = server.parts();
    assert!(host.starts_with("127.0.0.1:"), "{host}");
    assert!(token.len() == 32 && token.bytes().all(|byte| byte.is_ascii_hexdigit()), "{token}");
    let page = format!("/{token}/");
    let (status, body) = server.get(&page, host, "");
    assert!(status == 200 && body.contains("Landfall playground"), "{status}");
    assert_eq!(server.get(&page, host, &format!("Origin: http://{host}\r\n")).0, 200);
    // Another host, as after the name of a page was bound to this address, or none.
    for other in ["localhost", "127.0.0.1", "evil.example", "127.0.0.1:1", "localhost:80"] {
        assert_eq!(server.get(&page, other, "").0, 403, "{other}");
    }
    let port = host.split_once(':').unwrap().1;
    assert_eq!(server.get(&page, &format!("localhost:{port}"), "").0, 403);
    assert_ne!(server.send(&format!("GET {page} HTTP/1.1\r\nConnection: close\r\n\r\n")).0, 200);
    // Other origins and sites, even with the token.
    for header in [
        "Origin: http://evil.example\r\n",
        "Origin: null\r\n",
        "Origin: https://127.0.0.1\r\n",
        "Sec-Fetch-Site: cross-site\r\n",
        "Sec-Fetch-Site: same-site\r\n",
    ] {
        assert_eq!(server.get(&page, host, header).0, 403, "{header}");
    }
    // Without the token, or a wrong one, or one that begins like it.
    let wrong = token.replace(|c: char| c.is_ascii_digit(), "a");
    for path in [
        "/".to_string(),
        "/files".to_string(),
        "/a.frag".to_string(),
        format!("/{wrong}x/"),
        format!("/{}/", &token[..31]),
        format!("/{token}0/"),
        format!("//{token}/"),
        format!("/{token}"),
    ] {
        assert_eq!(server.get(&path, host, "").0, 404, "{path}");
    }
    // With it, nothing but the page, the named files and the engine.
    for path in [
        "a.frag",
        "secret.txt",
        "../secret.txt",
        "..%2fsecret.txt",
        "/etc/passwd",
        "files/",
        "page",
    ] {
        let (status, body) = server.get(&format!("/{token}/{path}"), host, "");
        assert_eq!((status, body.contains("secret")), (404, false), "{path}");
    }
    let post = |kind: &str, path: &str| {
        let text = format!(
            "POST /{token}/{path} HTTP/1.1\r\nHost: {host}\r\n{kind}Content-Length: 2\r\nConnection: close\r\n\r\n{{}}"
        );
        server.send(&text).0
    };
    assert_eq!(post("Content-Type: application/json\r\n", "answer"), 200);
    assert_eq!(post("Content-Type: text/plain\r\n", "answer"), 415);
    assert_eq!(post("", "answer"), 415);
    assert_eq!(post("Content-Type: application/json\r\n", ""), 405);
    assert_eq!(post("Content-Type: application/json\r\n", "files"), 405);
    assert_eq!(server.get(&format!("/{token}/answer"), host, "").0, 405);
    // Rubbish.
    assert_ne!(server.send("\u{0}\u{1}\r\n\r\n").0, 200);
    assert_ne!(server.send(&format!("GET {page} HTTP/9.9\r\nHost: {host}\r\n\r\n")).0, 200);
    // It is still there.
    assert_eq!(server.get(&page, host, "Connection: close\r\n").0, 200);
}

#[test]
fn the_engine_reads_no_file() {
    let folder = Folder::new("serve-include");
    folder.file("secret.glsl", "#error the secret\n");
    folder.file(
        "a.frag",
        "#version 450\n#extension GL_GOOGLE_include_directive : require\n#include \"b.glsl\"\n",
    );
    folder.file("b.glsl", "uniform B { vec3 b; };\n");
    let server = Server::start(folder.path(), &["a.frag"]);
    let absolute = folder.path().join("secret.glsl").display().to_string();
    for path in ["secret.glsl", "../secret.glsl", &absolute, "/etc/passwd", "b.glsl"] {
        let text = format!("#version 450\n#include \"{path}\"\n#include <{path}>\n");
        let answer = server.ask(&json!({"path": "a.frag", "text": text, "include_dirs": ["/", "."], "want": [{"kind": "layout", "format": "table"}]}));
        let stderr = answer["answers"][0]["stderr"].as_str().unwrap();
        assert!(stderr.contains("not found") && !stderr.contains("the secret"), "{stderr}");
    }
    // What the named file includes comes with it.
    let (host, token) = server.parts();
    let (_, files) = server.get(&format!("/{token}/files"), host, "");
    let files: Value = serde_json::from_str(&files).unwrap();
    assert_eq!(files["files"][0]["includes"], json!([["b.glsl", "uniform B { vec3 b; };\n"]]));
    let file = &files["files"][0];
    let answer = server.ask(&json!({"path": "a.frag", "text": file["text"], "files": file["includes"], "want": [{"kind": "layout", "format": "table"}]}));
    assert_eq!(
        answer["answers"][0]["stdout"],
        json!(output(folder.path(), 0, &["layout", "a.frag"]))
    );
}

#[test]
fn requests_that_are_none_get_an_error() {
    let folder = Folder::new("serve-errors");
    let server = Server::start(folder.path(), &[]);
    let layout = json!([{"kind": "layout", "format": "table"}]);
    for (request, message) in [
        (json!(7), "cannot be read"),
        (json!({"text": 3}), "cannot be read"),
        (json!({"unknown": 3}), "unknown field"),
        (json!({"want": [{"kind": "files"}]}), "unknown variant"),
        (json!({"want": [{"kind": "layout", "format": "x"}]}), "--format has no value `x`"),
        (json!({"want": [{"kind": "emit", "lang": "x"}]}), "--lang has no value `x`"),
        (json!({"rules": "x", "want": layout}), "--rules has no value `x`"),
        (json!({"targets": ["x"], "want": layout}), "--target has no value `x`"),
        (json!({"stage": "x", "want": layout}), "--stage has no value `x`"),
        (json!({"language": "x", "want": layout}), "--language has no value `x`"),
        (json!({"defines": ["3=x"], "want": layout}), "a macro is NAME or NAME=TEXT"),
    ] {
        let answer = server.ask(&request);
        assert!(answer["error"].as_str().unwrap().contains(message), "{request}: {answer}");
    }
}

/// A connection that stays open would get the error 500 after ten seconds, as the answer to whatever
/// the browser asks next.
#[test]
fn an_answer_ends_its_connection() {
    let folder = Folder::new("serve-connection");
    let server = Server::start(folder.path(), &[]);
    let (host, token) = server.parts();
    let mut stream = TcpStream::connect(host).unwrap();
    let request = format!("GET /{token}/files HTTP/1.1\r\nHost: {host}\r\n\r\n");
    stream.write_all(request.as_bytes()).unwrap();
    let mut answers = String::new();
    stream.read_to_string(&mut answers).unwrap();
    let lines = answers.lines().filter(|line| line.starts_with("HTTP/1.1 "));
    assert_eq!(lines.collect::<Vec<_>>(), ["HTTP/1.1 200 OK"]);
}

#[test]
fn ctrl_c_ends_it_and_closes_the_port() {
    let folder = Folder::new("serve-end");
    let mut server = Server::start(folder.path(), &[]);
    let host = server.parts().0.to_string();
    assert!(TcpStream::connect(&host).is_ok());
    let done = Command::new("kill").args(["-INT", &server.process.id().to_string()]).status();
    assert!(done.unwrap().success());
    let asked = Instant::now();
    let status = loop {
        if let Some(status) = server.process.try_wait().unwrap() {
            break status;
        }
        assert!(asked.elapsed() < Duration::from_secs(20), "it ends");
        std::thread::sleep(Duration::from_millis(20));
    };
    assert_eq!(status.code(), Some(0));
    assert!(TcpStream::connect(&host).is_err());
}

#[test]
fn what_cannot_be_served_is_an_error() {
    let folder = Folder::new("serve-refuse");
    folder.file("a.hlsl", "cbuffer B { float3 a; };\n");
    folder.file("nul.frag", "a\0b");
    for (arguments, message) in [
        (&["gone.frag"][..], "gone.frag"),
        (&["."], "is a directory"),
        (&["a.hlsl"], "is HLSL by its extension"),
        (&["nul.frag"], "nul.frag"),
        (&["--port", "70000"], "70000"),
    ] {
        let done = landfall(folder.path(), &[&["serve"], arguments].concat());
        let stderr = String::from_utf8(done.stderr).unwrap();
        assert_eq!((done.status.code(), done.stdout.len()), (Some(2), 0), "{stderr}");
        assert!(stderr.contains(message), "{stderr}");
    }
    let server = Server::start(folder.path(), &[]);
    let port = server.parts().0.split_once(':').unwrap().1.to_string();
    let done = landfall(folder.path(), &["serve", "--port", &port]);
    let stderr = String::from_utf8(done.stderr).unwrap();
    assert_eq!(done.status.code(), Some(2));
    assert!(stderr.contains("cannot be listened at") && stderr.contains("--port"), "{stderr}");
}

#[test]
fn the_page_follows_its_file_and_keeps_what_was_chosen() {
    let (browser, folder) = (Browser::start("serve"), Folder::new("serve-page"));
    let first = "layout(std140) uniform B { vec3 a; float b; } b;\n";
    folder.file("a.frag", first);
    folder.file("other.wgsl", "@group(0) @binding(0) var<uniform> w: vec4f;\n");
    let server = Server::start(folder.path(), &["a.frag", "other.wgsl", "-D", "N=3"]);
    browser.open_url(&server.url);
    let state = "return { text: document.getElementById('editor').editor.text, file: document.getElementById('file').value,
        cells: [...document.querySelectorAll('.cell:not(.pad) b')].map(one => one.textContent), maps: document.querySelectorAll('.map').length,
        defines: document.getElementById('defines').value }";
    let wait = |until: &dyn Fn(&Value) -> bool| {
        let asked = Instant::now();
        loop {
            let now = browser.run(state, &[]);
            if until(&now) {
                return now;
            }
            assert!(asked.elapsed() < Duration::from_secs(20), "{now:#}");
            std::thread::sleep(Duration::from_millis(50));
        }
    };
    let shown = wait(&|now| now["cells"] == json!(["a", "b"]));
    assert_eq!((&shown["text"], &shown["file"]), (&json!(first), &json!("a.frag")));
    assert_eq!(shown["defines"], json!("N=3"));
    // Other rules are chosen, then the file changes.
    browser.run("document.querySelector('[data-rules=std430]').click()", &[]);
    wait(&|now| now["maps"] == json!(2));
    folder.file("a.frag", "layout(std140) uniform B { vec3 a; float b; vec4 c[N]; } b;\n");
    let shown = wait(&|now| now["cells"].as_array().unwrap().contains(&json!("[2]")));
    assert_eq!(shown["maps"], json!(2));
    // What is written here stays here, until the file changes once more.
    browser.run(WRITE, &[json!("layout(std140) uniform B { vec3 mine; } b;\n")]);
    wait(&|now| now["cells"].as_array().unwrap().contains(&json!("mine")));
    folder.file("other.wgsl", "@group(0) @binding(0) var<uniform> w: vec3f;\n");
    std::thread::sleep(Duration::from_millis(1200));
    wait(&|now| now["cells"].as_array().unwrap().contains(&json!("mine")));
    folder.file("a.frag", first);
    wait(&|now| now["text"] == json!(first));
    // The other file.
    browser.run("const file = document.getElementById('file'); file.value = 'other.wgsl'; file.dispatchEvent(new Event('change'));", &[]);
    wait(&|now| now["text"].as_str().unwrap().contains("vec3f") && now["cells"] == json!(["w"]));
    assert_eq!(browser.log("browser"), Vec::<Value>::new());
}

#[test]
fn one_bad_file_leaves_the_others_served_and_an_idle_page_asks_seldom() {
    let (browser, folder) = (Browser::start("serve-bad"), Folder::new("serve-bad"));
    folder.file("a.frag", "layout(std140) uniform B { vec3 a; } b;\n");
    folder.file("bad.json", "{\"lights\": 3}");
    let server = Server::start(folder.path(), &["bad.json", "a.frag"]);
    browser.open_url(&server.url);
    let choose = |path: &str| {
        browser.run(
            "const file = document.getElementById('file'); file.value = arguments[0]; file.dispatchEvent(new Event('change'));",
            &[json!(path)],
        );
    };
    let wait = |script: &str, wanted: &dyn Fn(&Value) -> bool| {
        let asked = Instant::now();
        loop {
            let now = browser.run(script, &[]);
            if wanted(&now) {
                return;
            }
            assert!(asked.elapsed() < Duration::from_secs(20), "{now:#}");
            std::thread::sleep(Duration::from_millis(20));
        }
    };
    let problem = "return [document.getElementById('problem').textContent, document.getElementById('results').page.running]";
    wait(problem, &|now| now[0].as_str().unwrap().contains("bad.json") && now[1] == json!(false));
    choose("a.frag");
    let cells = "return [...document.querySelectorAll('.cell b')].map(one => one.textContent)";
    wait(cells, &|now| *now == json!(["a"]));
    assert_eq!(browser.run(problem, &[])[0], json!(""));
    // A question waits at the server: of three seconds none is spent on asking again.
    let asked = "return performance.getEntriesByType('resource').filter(one => one.name.includes('files')).length";
    let before = browser.run(asked, &[]).as_u64().unwrap();
    std::thread::sleep(Duration::from_secs(3));
    let after = browser.run(asked, &[]).as_u64().unwrap();
    assert!(after <= before + 1, "{before} {after}");
    folder.file("a.frag", "layout(std140) uniform B { vec3 a; vec3 late; } b;\n");
    wait(cells, &|now| *now == json!(["a", "late"]));
    assert_eq!(browser.log("browser"), Vec::<Value>::new());
}

#[test]
fn what_does_not_compile_is_said_where_one_looks_and_its_block_stays() {
    let (browser, folder) = (Browser::start("serve-broken"), Folder::new("serve-broken"));
    let server = Server::start(folder.path(), &[]);
    // Of a damaged link.
    browser.open_url(&format!("{}#s=AAAA", server.url));
    let told = browser.run("return document.getElementById('problem').textContent", &[]);
    assert!(told.as_str().unwrap().starts_with("The link is damaged"), "{told}");
    let state = "return { tab: document.getElementById('tab-findings').textContent,
        level: [...document.querySelectorAll('#tab-findings .badge')].map(one => one.className),
        broken: document.querySelector('.broken')?.textContent ?? null,
        blocks: [...document.querySelectorAll('#panel-maps article')].map(one => [one.querySelector('h3').textContent, one.inert]) }";
    let wait = |wanted: &dyn Fn(&Value) -> bool| {
        let asked = Instant::now();
        loop {
            let now = browser.run(state, &[]);
            if wanted(&now) {
                return now;
            }
            assert!(asked.elapsed() < Duration::from_secs(20), "{now:#}");
            std::thread::sleep(Duration::from_millis(20));
        }
    };
    let good = "#version 330 core\nlayout(std140) uniform A { vec3 a; } x;\nlayout(std140) uniform B { vec3 b; } y;\nin vec3 n;\nout vec4 color;\nvoid main() { color = vec4(n, x.a.x); }\n";
    browser.run(WRITE, &[json!(good)]);
    let both = json!([["A x", false], ["B y", false]]);
    wait(&|now| now["blocks"] == both && now["broken"] == Value::Null);
    assert_eq!(
        browser.run("return document.getElementById('problem').textContent", &[]),
        json!("")
    );
    browser.run(WRITE, &[json!(good.replace("vec3 a;", "vec3 a"))]);
    let now = wait(&|now| now["broken"] != Value::Null);
    assert_eq!((&now["tab"], &now["level"]), (&json!("Findings 1 error"), &json!(["badge error"])));
    let broken = now["broken"].as_str().unwrap();
    assert!(broken.contains("shader.frag:2:") && broken.contains("expected ;"), "{broken}");
    assert_eq!(now["blocks"][0], json!(["A x", true]));
    browser.run(WRITE, &[json!(good)]);
    wait(&|now| now["blocks"] == both && now["tab"] == json!("Findings"));
    // The inputs of the stage have fields, and messages name the fields of the page.
    browser.run("document.getElementById('tab-run').click()", &[]);
    let result = "return [[...document.querySelectorAll('.inputs input')].map(one => one.name), document.querySelector('#panel-run pre').textContent]";
    let results = |wanted: &str| {
        let asked = Instant::now();
        loop {
            let now = browser.run(result, &[]);
            if now[1].as_str().unwrap().contains(wanted) {
                assert_eq!(now[0], json!(["n"]));
                return now[1].as_str().unwrap().to_string();
            }
            assert!(asked.elapsed() < Duration::from_secs(20), "{now:#}");
            std::thread::sleep(Duration::from_millis(20));
        }
    };
    let text = results("Contents of blocks");
    assert!(!text.contains("--"), "{text}");
    browser.run(
        "const field = document.querySelector('.inputs input'); field.value = '[0.25, 0.5, 7]'; field.dispatchEvent(new Event('input'));",
        &[],
    );
    let text = results("7.0");
    assert!(text.contains("color.x") && text.contains("0.25"), "{text}");
}
