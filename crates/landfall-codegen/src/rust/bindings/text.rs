//! Printing of modules as rustfmt formats them.

use std::fmt::Write as _;

pub(super) use crate::rust::print::indented;

/// Stands for the visibility; no name or path has it, as names are escaped.
pub(super) const PUB: &str = "\u{1}";

/// The inside of a module.
pub(super) struct Module {
    text: String,
    /// `pub` or `pub(crate)`.
    pub public: String,
}

impl Module {
    pub(super) fn new(public: &str) -> Module {
        Module { text: String::new(), public: public.to_string() }
    }

    pub(super) fn finished(self) -> String {
        self.text
    }

    pub(super) fn is_empty(&self) -> bool {
        self.text.is_empty()
    }

    /// Appends an item with its documentation; [`PUB`] in it stands for the visibility.
    pub(super) fn item(&mut self, about: &str, item: &str) {
        if !self.text.is_empty() {
            self.text.push('\n');
        }
        for line in about.lines() {
            let _ = writeln!(self.text, "{}", format!("/// {line}").trim_end());
        }
        self.text.push_str(&item.replace(PUB, &self.public));
        if !self.text.ends_with('\n') {
            self.text.push('\n');
        }
    }

    /// Appends `const HEAD = VALUE;`, which rustfmt leaves alone where it is too long.
    pub(super) fn constant(&mut self, about: &str, head: &str, value: &str) {
        let line = format!("{} const {head} = {value};", self.public);
        // A macro in a macro is broken earlier.
        let skip = line.chars().count() > WIDTH || value.contains("concat!");
        self.item(about, &if skip { format!("#[rustfmt::skip]\n{line}") } else { line });
    }

    /// Appends a module of items that a program need not use; one without items is left out.
    pub(super) fn module_of_any(&mut self, about: &str, name: &str, inside: Module) {
        self.attributed_module(about, "#[allow(dead_code)]\n", name, inside);
    }

    /// Appends a module; one without items is left out.
    pub(super) fn module(&mut self, about: &str, name: &str, inside: Module) {
        self.attributed_module(about, "", name, inside);
    }

    fn attributed_module(&mut self, about: &str, attribute: &str, name: &str, inside: Module) {
        if !inside.is_empty() {
            let inside = indented(&inside.text, 1);
            self.item(about, &format!("{attribute}{PUB} mod {name} {{\n{inside}}}\n"));
        }
    }
}

/// The columns that an item of a program has: its module stands in that of the API, and this in
/// that of the file's bindings.
pub(super) const WIDTH: usize = 100 - 12;

/// `[items]` over several lines, one each; a single structure keeps the brackets on its own lines.
pub(super) fn lines(items: &[String]) -> String {
    if let [one] = items {
        return format!("[{one}]");
    }
    let inside: String = items.iter().map(|item| format!("{item},\n")).collect();
    format!("[\n{}]", indented(&inside, 1))
}
