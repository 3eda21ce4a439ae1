//! Chromium without a window, driven over WebDriver, with the commands of the DevTools protocol
//! that chromedriver passes on.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::{Mutex, MutexGuard, PoisonError};

use serde_json::{Value, json};

/// A browser, and the folder of its profile.
pub struct Browser {
    driver: Child,
    session: String,
    profile: PathBuf,
    _only: MutexGuard<'static, ()>,
}

/// One browser at a time: each keeps several processors busy.
static ONLY: Mutex<()> = Mutex::new(());

impl Browser {
    /// Starts chromedriver and a browser.
    ///
    /// # Panics
    /// The Debian packages chromium and chromium-driver are missing.
    pub fn start(name: &str) -> Browser {
        Browser::start_with(name, &["--disable-gpu"])
    }

    /// The same with WebGPU and WebGL on the processor, by SwiftShader.
    pub fn start_with_webgpu(name: &str) -> Browser {
        let flags =
            ["--ignore-gpu-blocklist", "--enable-unsafe-swiftshader", "--enable-unsafe-webgpu"];
        Browser::start_with(name, &flags)
    }

    fn start_with(name: &str, more: &[&str]) -> Browser {
        let _only = ONLY.lock().unwrap_or_else(PoisonError::into_inner);
        let profile = std::env::temp_dir().join(format!("landfall-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&profile).unwrap();
        let mut driver = Command::new("chromedriver")
            .arg("--port=0")
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("chromedriver is missing: install the packages chromium and chromium-driver");
        let mut lines = BufReader::new(driver.stdout.take().unwrap()).lines();
        let port = lines
            .by_ref()
            .map_while(Result::ok)
            .find_map(|line| {
                Some(line.rsplit_once("successfully on port ")?.1.trim_end_matches('.').to_string())
            })
            .expect("chromedriver prints its port");
        // Its pipe stays open, or it would end.
        std::thread::spawn(move || lines.for_each(drop));
        let session = format!("http://127.0.0.1:{port}/session");
        let mut browser = Browser { driver, session, profile, _only };
        let mut flags: Vec<String> = [
            "--headless",
            "--no-sandbox",
            "--disable-quic",
            "--no-first-run",
            "--disable-background-networking",
            "--disable-component-update",
            "--disable-sync",
        ]
        .map(str::to_string)
        .into();
        flags.extend(more.iter().map(|flag| flag.to_string()));
        flags.push(format!("--user-data-dir={}", browser.profile.display()));
        let wanted = json!({"capabilities": {"alwaysMatch": {
            // A busy machine takes its time.
            "timeouts": {"script": 300_000},
            "goog:loggingPrefs": {"browser": "ALL", "performance": "ALL"},
            "goog:chromeOptions": {"args": flags},
        }}});
        let session = browser.post("", &wanted)["sessionId"].as_str().unwrap().to_string();
        browser.session = format!("{}/{session}", browser.session);
        browser
    }

    fn post(&self, path: &str, body: &Value) -> Value {
        let request = minreq::post(format!("{}{path}", self.session)).with_body(body.to_string());
        let answer = request.send().unwrap_or_else(|error| panic!("{path}: {error}"));
        let mut value: Value = serde_json::from_slice(answer.as_bytes()).unwrap();
        assert_eq!(answer.status_code, 200, "{path}: {value:#}");
        value["value"].take()
    }

    /// Opens a file and waits until its script has run.
    pub fn open(&self, file: &Path) {
        self.open_url(&format!("file://{}", std::fs::canonicalize(file).unwrap().display()));
    }

    /// Opens a page and waits until it says that it is ready, at most a minute.
    pub fn open_url(&self, url: &str) {
        self.post("/url", &json!({"url": url}));
        let asked = std::time::Instant::now();
        let is_ready =
            || self.run("return document.documentElement.dataset.ready", &[]).is_string();
        while !is_ready() && asked.elapsed().as_secs() < 60 {
            std::thread::sleep(std::time::Duration::from_millis(20));
        }
        let ready = self.run("return document.documentElement.dataset.ready", &[]);
        assert!(ready.is_string(), "the script of the page has run: {:#?}", self.log("browser"));
    }

    /// Runs the body of a function in the page and returns its result.
    pub fn run(&self, script: &str, arguments: &[Value]) -> Value {
        self.post("/execute/sync", &json!({"script": script, "args": arguments}))
    }

    /// The same for one that calls its last argument when it is done.
    pub fn run_async(&self, script: &str, arguments: &[Value]) -> Value {
        self.post("/execute/async", &json!({"script": script, "args": arguments}))
    }

    /// Sends a command of the DevTools protocol.
    pub fn devtools(&self, command: &str, parameters: Value) -> Value {
        self.post("/goog/cdp/execute", &json!({"cmd": command, "params": parameters}))
    }

    /// What was logged since the last call: `browser` for the console, `performance` for events of
    /// the DevTools protocol.
    pub fn log(&self, kind: &str) -> Vec<Value> {
        match self.post("/se/log", &json!({"type": kind})) {
            Value::Array(entries) => entries,
            other => panic!("{other}"),
        }
    }

    /// Presses and releases keys, as WebDriver spells them.
    pub fn press(&self, keys: &[&str]) {
        let one = |key: &&str| {
            [json!({"type": "keyDown", "value": key}), json!({"type": "keyUp", "value": key})]
        };
        let actions: Vec<Value> = keys.iter().flat_map(one).collect();
        let body = json!({"actions": [{"type": "key", "id": "keys", "actions": actions}]});
        self.post("/actions", &body);
    }

    /// Sets the size of the window and the colour scheme.
    pub fn show_as(&self, width: u32, scheme: &str) {
        let feature = json!([{"name": "prefers-color-scheme", "value": scheme}]);
        self.devtools("Emulation.setEmulatedMedia", json!({"features": feature}));
        let size = json!({"width": width, "height": 1000, "deviceScaleFactor": 1, "mobile": false});
        self.devtools("Emulation.setDeviceMetricsOverride", size);
    }

    /// Sets the file of the first file input below a selector.
    pub fn choose_file(&self, selector: &str, file: &Path) {
        let root = self.devtools("DOM.getDocument", json!({}));
        let query = json!({"nodeId": root["root"]["nodeId"], "selector": selector});
        let node = self.devtools("DOM.querySelector", query);
        let path = std::fs::canonicalize(file).unwrap().display().to_string();
        let files = json!({"nodeId": node["nodeId"], "files": [path]});
        self.devtools("DOM.setFileInputFiles", files);
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        // Ends the browser, too.
        let _ = minreq::delete(&self.session).send();
        let _ = self.driver.kill();
        let _ = self.driver.wait();
        let _ = std::fs::remove_dir_all(&self.profile);
    }
}
