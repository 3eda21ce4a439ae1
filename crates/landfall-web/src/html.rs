//! The HTML page of `report`, `check --format html` and `diff --format html`: one file with its
//! style, its script and the layouts as JSON, which opens from disk and loads nothing.
//!
//! `document` turns a shader into that JSON, `member` its members; the script draws it.

mod document;
mod member;
mod texts;

use data_encoding::BASE64;
use landfall_layout::text::escape;

pub use document::{MAX_UNDER_ALL_RULES, Part, RULES};
use texts::Texts;

const HEAD: &str = include_str!("html/head.html");
const TEMPLATE: &str = include_str!("html/page.html");

/// The style of the page and of its maps.
pub const MAP_STYLE: &str = concat!(include_str!("html/page.css"), include_str!("html/map.css"));

macro_rules! blocks {
    () => {
        concat!(
            include_str!("html/model.js"),
            include_str!("html/decode.js"),
            include_str!("html/dom.js"),
            include_str!("html/map.js"),
            include_str!("html/block.js"),
            include_str!("html/detail.js"),
        )
    };
}

/// The parts of the script that draw blocks, which the playground has, too.
#[cfg(feature = "playground")]
pub const BLOCKS: &str = blocks!();

/// The script: its parts share one scope.
const SCRIPT: &str = concat!(
    "'use strict';\n(() => {\n",
    blocks!(),
    include_str!("html/changes.js"),
    include_str!("html/page.js"),
    "})();\n"
);

/// A page under construction.
#[derive(Debug, Default)]
pub struct Page {
    at: Option<String>,
    texts: Texts,
    shaders: Vec<String>,
}

impl Page {
    /// A page that opens at the block of that name.
    pub fn opened_at(block: Option<&str>) -> Page {
        Page { at: block.map(str::to_string), ..Page::default() }
    }

    /// Adds a shader.
    pub fn add(&mut self, part: &Part<'_>) {
        self.shaders.push(document::shader(part, &mut self.texts));
    }

    /// The page; `title` says what it shows.
    pub fn finish(self, title: &str) -> String {
        let policy = policy(MAP_STYLE, &[SCRIPT], "");
        let slots = [
            ("{{head}}", head("Landfall report", &policy, MAP_STYLE)),
            ("{{data}}", self.data(title)),
            ("{{script}}", SCRIPT.to_string()),
        ];
        filled(TEMPLATE, &slots)
    }

    /// The JSON that the page holds.
    pub fn data(&self, title: &str) -> String {
        let tool = landfall_layout::format::json::Tool::LANDFALL;
        let text = format!(
            "{{\"tool\":{},\"title\":{},\"at\":{},\"texts\":{},\"shaders\":[\n{}\n]}}",
            json(&tool),
            json(&title),
            json(&self.at),
            json(&self.texts.all),
            self.shaders.join(",\n"),
        );
        embedded(&text)
    }
}

/// JSON as an element of a page holds it; without `<`, which could end that element.
pub fn embedded(json: &str) -> String {
    escape::json(json).replace('<', "\\u003c")
}

/// The start of a page, up to its body.
pub fn head(title: &str, policy: &str, style: &str) -> String {
    let slots = [("{{policy}}", policy), ("{{title}}", title), ("{{style}}", style)];
    filled(HEAD, &slots.map(|(slot, text)| (slot, text.to_string())))
}

/// Fills the slots of a template, in its order, so that no text is searched for the slots behind it.
pub fn filled(template: &str, slots: &[(&str, String)]) -> String {
    let mut page = String::with_capacity(slots.iter().map(|(_, text)| text.len()).sum());
    let mut rest = template;
    for (slot, text) in slots {
        let (before, after) = rest.split_once(slot).expect("the template has every slot");
        page.push_str(before);
        page.push_str(text);
        rest = after;
    }
    page + rest
}

fn json<T: serde::Serialize + ?Sized>(value: &T) -> String {
    serde_json::to_string(value).expect("keys are strings")
}

/// The content security policy: the one style and the scripts, by their hashes, what `more` allows,
/// and nothing else.
pub fn policy(style: &str, scripts: &[&str], more: &str) -> String {
    let hash = |text: &str| {
        format!("'sha256-{}'", BASE64.encode(&hmac_sha256::Hash::hash(text.as_bytes())))
    };
    let scripts: Vec<String> = scripts.iter().map(|script| hash(script)).collect();
    format!(
        "default-src 'none'; style-src {}; script-src {}{more}; base-uri 'none'; \
         form-action 'none'; require-trusted-types-for 'script'; trusted-types 'none'",
        hash(style),
        scripts.join(" "),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_script_and_the_style_cannot_end_their_elements() {
        assert!(!SCRIPT.contains("</script") && !SCRIPT.contains("<!--"));
        assert!(!MAP_STYLE.contains("</style"));
    }

    #[test]
    fn slots_within_texts_stay_as_they_are() {
        let page = Page::default().finish("{{script}} </script><script>alert(1)</script>");
        assert!(page.contains("{{script}} \\u003c/script>"));
        assert_eq!(page.matches("<script").count(), 2);
    }
}
