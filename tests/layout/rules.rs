//! What `landfall rule` says of each lint holds: it reports its own example.

use landfall_accuracy::demand::{Demand, DemandVerdict, ProveRequest, prove};
use landfall_codegen::CodeOptions;
use landfall_codegen::languages::C;
use landfall_exec::harness::call::pure::PureRequest;
use landfall_layout::finding::{Finding, Level, Place};
use landfall_layout::lock;
use landfall_layout::{Options, ShaderLayout, Source, layout};
use landfall_lint::settings::{CompiledShader, Figure, RustFile, Table, Target};
use landfall_lint::{
    Check, LINTS, Lint, Settings, Subject, allow, compiled_differs, driver_disagrees, not_proved,
    run, stale_assertions,
};

use crate::support::glslang::Client;
use crate::support::glslang_server::compiled;

/// What an example needs besides its text; nearly all need nothing.
#[derive(Default)]
struct Beside {
    settings: Settings,
    /// Another shader of the run.
    other: Option<(&'static str, String)>,
}

fn laid_out(path: &str, text: &str) -> (Source, ShaderLayout) {
    let source = Source::new(path, text);
    let shader = layout(&source, &Options::default().with_naga(true));
    assert!(!shader.has_errors(), "{path}: {:?}", shader.diagnostics);
    (source, shader)
}

/// The text with `from` replaced, which has to be in it.
fn changed(text: &str, from: &str, to: &str) -> String {
    assert!(text.contains(from), "{from}\n{text}");
    text.replacen(from, to, 1)
}

fn beside(lint: &Lint) -> Beside {
    let mut beside = Beside::default();
    let settings = &mut beside.settings;
    match lint.code {
        "block-mismatch" => {
            let other =
                changed(lint.example, "vec3 position; vec3 color;", "vec3 color; vec3 position;");
            beside.other = Some(("shaders/a.vert", other));
        }
        "buffer-too-small" => {
            let size = Figure { bytes: 6148, written: "48 * 128 + 4".into(), ..Figure::default() };
            let block = "PointLightBlock".to_string();
            settings.tables = vec![Table { block, size: Some(size), ..Table::default() }];
        }
        "unknown-block" => {
            let block = "Lihgts".to_string();
            settings.tables = vec![Table { block, ..Table::default() }];
        }
        // FOG is not among them.
        "define-changes-layout" | "unreached-block" => {
            settings.permutations = vec![vec![("SHADOWS".to_string(), "1".to_string())]];
        }
        "over-limit" => settings.targets = vec![Target::Gl33],
        "push-constant-limit" => settings.targets = vec![Target::Vulkan],
        "webgl2-size" => settings.targets = vec![Target::WebGl2],
        "rust-mirror" | "rust-mirror-unknown" => {
            let text = lint.example.into();
            settings.rust_files = vec![RustFile { path: "src/light.rs".to_string(), text }];
            let shader = "layout(std140) uniform Light { vec3 direction; vec3 color; };\n";
            beside.other = Some(("shaders/light.frag", shader.to_string()));
        }
        _ => {}
    }
    settings.levels = vec![(lint.code.to_string(), Level::Deny)];
    beside
}

fn path(text: &str) -> &'static str {
    if text.contains("var<") {
        "shaders/a.wgsl"
    } else if text.contains("gl_Position") {
        "shaders/a.vert"
    } else {
        "shaders/a.frag"
    }
}

/// What a run over the example finds. A lint of one shader reports its own code, with help.
fn found(lint: &Lint) -> Vec<Finding> {
    let Beside { settings, other } = beside(lint);
    let is_rust = lint.code.starts_with("rust-mirror");
    let own = (!is_rust).then(|| laid_out(path(lint.example), lint.example));
    let other = other.map(|(path, text)| laid_out(path, &text));
    let options = Options::default().with_naga(true);
    let all: Vec<(Source, ShaderLayout)> = own.into_iter().chain(other).collect();
    let subjects: Vec<Subject<'_>> =
        all.iter().map(|(source, shader)| Subject { source, options: &options, shader }).collect();
    if let Check::Shader(check) | Check::Naga(check) = lint.check {
        for finding in subjects.iter().flat_map(|subject| check(subject, &settings)) {
            assert_eq!(finding.code, lint.code, "{finding:#?}");
            assert!(finding.help.is_some(), "{finding:#?}");
        }
    }
    let mut found: Vec<Finding> =
        subjects.iter().flat_map(|subject| run::shader(subject, &settings)).collect();
    found.extend(run::tree(&subjects, &settings));
    found
}

/// What is found by comparing with something that is no shader.
fn found_elsewhere(lint: &Lint) -> Vec<Finding> {
    match lint.code {
        "lock-orphan" => vec![landfall_lint::drift::orphan("layouts/shaders/lights/old.frag.json")],
        "lock-missing" => {
            let (_, shader) = laid_out("shaders/a.frag", lint.example);
            landfall_lint::drift::drift(&shader, "layouts/shaders/a.frag.json", None)
        }
        "layout-drift" => {
            // Its comment says what the lock has: a lone `vec3` before `count`.
            let old = changed(lint.example, "    vec3 color;\n", "");
            let (_, old) = laid_out("shaders/a.frag", &old);
            assert_eq!(old.blocks[0].leaves[1].offset, Some(12));
            let (_, new) = laid_out("shaders/a.frag", lint.example);
            let text = lock::write(&old);
            let lock = lock::read("layouts/shaders/a.frag.json", &text).expect("a lock");
            landfall_lint::drift::drift(&new, "layouts/shaders/a.frag.json", Some(&lock))
        }
        "driver-disagrees" => {
            let (_, shader) = laid_out("shaders/a.frag", lint.example);
            let report = r#"{"schema_version":1,"shaders":[{"path":"shaders/a.frag","blocks":[
                {"name":"Light","backends":[{"backend":"gl","form":"original","causes":[],"reads":[
                {"path":"intensity","leaf":"intensity","expected_byte":12,"byte_read":16}]}]}]}]}"#;
            let report = driver_disagrees::read("seen.json", report).expect("a report");
            report.findings(&|_| Some(&shader))
        }
        "compiled-differs" => {
            let (_, text) = laid_out("shaders/a.frag", lint.example);
            let mut words = compiled(lint.example, "frag", Client::Vulkan)
                .unwrap_or_else(|log| panic!("{log}"));
            // The Offset of `range`, the only 16 that is one.
            let offset = words.windows(2).position(|pair| pair == [35, 16]).expect("it is there");
            words[offset + 1] = 20;
            let bytes = words.into_iter().flat_map(u32::to_le_bytes).collect();
            let module = Source::from_bytes("shaders/a.frag.spv", bytes).expect("a module");
            let module = layout(&module, &Options::default());
            let row = CompiledShader {
                source: "shaders/a.frag".to_string(),
                spirv: "shaders/a.frag.spv".to_string(),
                ..CompiledShader::default()
            };
            compiled_differs::findings(&row, &text, &module)
        }
        "target-changes-layout" | "undefined-macro" | "uniform-constraints" => {
            let (_, shader) = laid_out(path(lint.example), lint.example);
            let found = shader.diagnostics.iter().filter(|found| found.code == lint.code);
            let finding = |found: &landfall_layout::Diagnostic| {
                let place = Place::new(&shader.files, found.labels[0].at);
                let finding = Finding::at(found.code.name(), "Light", place, found.message.clone());
                Finding { help: found.help.clone(), ..finding }
            };
            found.map(finding).collect()
        }
        "not-proved" => {
            let source = Source::new("shaders/a.frag", lint.example);
            let request = ProveRequest {
                pure: PureRequest { function: "falloff".to_string(), ..PureRequest::default() },
                domain: Some(serde_json::json!({ "d": [0, 100] })),
                demands: vec![Demand::NoNan],
                ..ProveRequest::default()
            };
            let report = prove(&source, &Options::default(), &request).expect("a function");
            let (_, DemandVerdict::Broken(case)) = &report.demands[0] else { return Vec::new() };
            let row = Place { path: "landfall.toml".to_string(), line: 1, ..Place::default() };
            let finding = not_proved::finding("falloff", None, &row, case.shown());
            vec![finding.with_help("guard the division")]
        }
        "stale-assertions" => {
            let (_, shader) = laid_out("shaders/a.frag", lint.example);
            let mut options = CodeOptions::default();
            options.assertions.structures = vec![("Light".to_string(), "Light".to_string())];
            let before = C.assertions(&[&shader], &options).text;
            let (_, shader) = laid_out("shaders/a.frag", &lint.example.replace(" vec4 color;", ""));
            let row = Place { path: "landfall.toml".to_string(), line: 1, ..Place::default() };
            let is_stale = C.assertions(&[&shader], &options).text != before;
            is_stale
                .then(|| stale_assertions::finding("light.hpp", &row, "is old"))
                .into_iter()
                .collect()
        }
        "unused-allow" => {
            let (_, shader) = laid_out("shaders/a.frag", lint.example);
            let allows = allow::allows(&shader.files, shader.language);
            allow::unused(&allows, &Settings::default(), |_| true)
        }
        _ => Vec::new(),
    }
}

#[test]
fn every_lint_reports_its_own_example() {
    for lint in LINTS {
        let mut all = found_elsewhere(lint);
        if all.is_empty() {
            all = found(lint);
        }
        let codes: Vec<&str> = all.iter().map(|f| f.code.as_str()).collect();
        assert!(codes.contains(&lint.code), "{}: {codes:?}", lint.code);
        for finding in all.iter().filter(|f| f.code == lint.code) {
            assert!(!finding.about.is_empty() && !finding.message.is_empty(), "{}", lint.code);
            let help = finding.help.is_some() || !finding.notes.is_empty();
            assert!(help, "{} says neither why nor what to do: {finding:?}", lint.code);
        }
    }
}

#[test]
fn every_lint_has_a_kebab_case_code_of_its_own_and_says_what_why_and_how_to_mend() {
    for lint in LINTS {
        let words = lint.code.split('-');
        let is_word = |word: &str| {
            !word.is_empty() && word.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit())
        };
        assert!(words.clone().count() > 1 && words.clone().all(is_word), "{}", lint.code);
        for text in [lint.what, lint.why, lint.example, lint.fix] {
            assert!(text.len() > 20 && !text.contains("  ") || text == lint.example, "{text}");
        }
        // One sentence, as it stands in a list.
        assert!(!lint.what.ends_with('.') && !lint.what.contains(". "), "{}", lint.what);
        assert!(!lint.what.starts_with("reports"), "{}", lint.what);
    }
    let mut codes: Vec<&str> = LINTS.iter().map(|lint| lint.code).collect();
    let listed = codes.clone();
    codes.sort_unstable();
    codes.dedup();
    assert_eq!(codes, listed, "by code, each once");
}
