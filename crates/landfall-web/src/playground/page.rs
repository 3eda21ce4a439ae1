//! The page of the playground: its style, its scripts, and the engine, which is WebAssembly in the
//! page itself or the server that it came from.

use data_encoding::BASE64;
use landfall_codegen::languages::LANGUAGES;
use landfall_layout::format::json::Tool;
use serde::Serialize;

use super::json;
use crate::html::{BLOCKS, MAP_STYLE, embedded, filled, head, policy};

const TEMPLATE: &str = include_str!("page/playground.html");
const STYLE: &str = include_str!("page/playground.css");

/// CodeMirror as one script, which `crates/landfall-web/editor/build` writes.
pub const EDITOR: &str = include_str!("page/editor.js");

/// The parts of the script, which share one scope with those of `report`.
const PARTS: &str = concat!(
    include_str!("page/engine.js"),
    include_str!("page/state.js"),
    include_str!("page/picture.js"),
    include_str!("page/picture_gpu.js"),
    include_str!("page/json_edit.js"),
    include_str!("page/attenuation.js"),
    include_str!("page/lights.js"),
    include_str!("page/divider.js"),
    include_str!("page/tokens.js"),
    include_str!("page/playground.js"),
);

/// What answers the questions of a page.
#[derive(Clone, Copy, Debug)]
pub enum Engine<'a> {
    /// The server that the page came from.
    Server(&'a Opened<'a>),
    /// WebAssembly, compressed by gzip: for layouts, and with the interpreter.
    Wasm([&'a [u8]; 2]),
}

/// What a page of a server shows at first.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Opened<'a> {
    /// The paths of the shaders.
    pub files: Vec<String>,
    /// Macros, as `NAME=TEXT`.
    pub defines: Vec<String>,
    /// The directories of `#include`.
    pub include_dirs: &'a [String],
}

#[derive(Serialize)]
struct Data<'a> {
    tool: Tool,
    languages: Vec<[&'static str; 2]>,
    server: Option<&'a Opened<'a>>,
}

/// The page, and its content security policy for the header of a server.
pub fn page(engine: Engine<'_>) -> (String, String) {
    let script = format!("'use strict';\n(() => {{\n{BLOCKS}{PARTS}}})();\n");
    let style = format!("{MAP_STYLE}{STYLE}");
    let connect = match engine {
        Engine::Server(_) => "; connect-src 'self'",
        Engine::Wasm(_) => "",
    };
    // WebAssembly is compiled, and no other text.
    // The icon is empty, in the page itself: a browser asks the server for none.
    let more = format!(" 'wasm-unsafe-eval'{connect}; img-src data:");
    let policy = policy(&style, &[EDITOR, &script], &more);
    let data = Data {
        tool: Tool::LANDFALL,
        languages: LANGUAGES.iter().map(|language| [language.name, language.title]).collect(),
        server: match engine {
            Engine::Server(opened) => Some(opened),
            Engine::Wasm(_) => None,
        },
    };
    let wasm = match engine {
        Engine::Server(_) => ["", ""].map(String::from),
        Engine::Wasm(all) => all.map(|bytes| BASE64.encode(bytes)),
    };
    let [layout, evaluator] = wasm;
    let slots = [
        ("{{head}}", head("Landfall playground", &policy, &style)),
        ("{{data}}", embedded(&json(&data))),
        ("{{layout}}", layout),
        ("{{evaluator}}", evaluator),
        ("{{editor}}", EDITOR.to_string()),
        ("{{script}}", script),
    ];
    (filled(TEMPLATE, &slots), policy)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scripts_cannot_end_their_elements() {
        for script in [EDITOR, PARTS] {
            assert!(!script.contains("</script") && !script.contains("<!--"));
        }
        assert!(!STYLE.contains("</style"));
    }
}
