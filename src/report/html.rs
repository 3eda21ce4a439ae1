//! The HTML page of `report`, `check --format html` and `diff --format html`: one file with its
//! style, its script and the layouts as JSON, which opens from disk and loads nothing.
//!
//! `document` turns a shader into that JSON, `member` its members; the script draws it.

mod document;
mod member;
mod texts;

use data_encoding::BASE64;
use landfall_layout::text::escape;

pub use document::{MOST_UNDER_ALL_RULES, Part, RULES};
use texts::Texts;

const TEMPLATE: &str = include_str!("html/page.html");
const STYLE: &str = concat!(include_str!("html/page.css"), include_str!("html/map.css"));

/// The parts of the script, which share one scope.
const SCRIPT: &str = concat!(
    "'use strict';\n(() => {\n",
    include_str!("html/model.js"),
    include_str!("html/decode.js"),
    include_str!("html/dom.js"),
    include_str!("html/map.js"),
    include_str!("html/block.js"),
    include_str!("html/changes.js"),
    include_str!("html/page.js"),
    "})();\n"
);

/// A page under construction.
#[derive(Debug, Default)]
pub struct Page {
    texts: Texts,
    shaders: Vec<String>,
}

impl Page {
    /// Adds a shader.
    pub fn add(&mut self, part: &Part<'_>) {
        self.shaders.push(document::shader(part, &mut self.texts));
    }

    /// The page; `title` says what it shows.
    pub fn finish(self, title: &str) -> String {
        // In the order of the template, so that no text is searched for the slots behind it.
        let slots = [
            ("{{policy}}", policy()),
            ("{{style}}", STYLE.to_string()),
            ("{{data}}", self.data(title)),
            ("{{script}}", SCRIPT.to_string()),
        ];
        let mut page = String::with_capacity(slots.iter().map(|(_, text)| text.len()).sum());
        let mut rest = TEMPLATE;
        for (slot, text) in slots {
            let (before, after) = rest.split_once(slot).expect("the template has every slot");
            page.push_str(before);
            page.push_str(&text);
            rest = after;
        }
        page + rest
    }

    /// The JSON that the page holds; without `<`, which could end its element.
    fn data(&self, title: &str) -> String {
        let tool = landfall_layout::format::json::Tool::LANDFALL;
        let text = format!(
            "{{\"tool\":{},\"title\":{},\"texts\":{},\"shaders\":[\n{}\n]}}",
            json(&tool),
            json(&title),
            json(&self.texts.all),
            self.shaders.join(",\n"),
        );
        escape::json(&text).replace('<', "\\u003c")
    }
}

fn json<T: serde::Serialize + ?Sized>(value: &T) -> String {
    serde_json::to_string(value).expect("keys are strings")
}

/// The content security policy: the one style and the one script, by their hashes, and nothing else.
fn policy() -> String {
    let hash = |text: &str| BASE64.encode(&hmac_sha256::Hash::hash(text.as_bytes()));
    format!(
        "default-src 'none'; style-src 'sha256-{}'; script-src 'sha256-{}'; base-uri 'none'; \
         form-action 'none'; require-trusted-types-for 'script'; trusted-types 'none'",
        hash(STYLE),
        hash(SCRIPT),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_script_and_the_style_cannot_end_their_elements() {
        assert!(!SCRIPT.contains("</script") && !SCRIPT.contains("<!--"));
        assert!(!STYLE.contains("</style"));
    }

    #[test]
    fn slots_within_texts_stay_as_they_are() {
        let page = Page::default().finish("{{script}} </script><script>alert(1)</script>");
        assert!(page.contains("{{script}} \\u003c/script>"));
        assert_eq!(page.matches("<script").count(), 2);
    }
}
