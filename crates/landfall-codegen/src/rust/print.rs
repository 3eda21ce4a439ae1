//! Helpers of the printers: spelling types, and breaking lines as rustfmt does.

use std::fmt::Write as _;

use super::RustOptions;
use super::naming::Names;
use super::plan::Plan;
use super::types::{
    Component, GeneratedType, GeneratedTypeId, Mirror, Module, RustType, component,
};

/// rustfmt's `max_width`.
const WIDTH: usize = 100;
/// The indentation of what stands in a module.
const INDENT: usize = 4;
/// rustfmt's width for the body of a structure literal on one line.
const LITERAL: usize = 18;

/// rustfmt's width for the arguments of a call, and the elements of an array, on one line.
const CALL: usize = 60;

/// The derives of every generated type.
pub(super) const DERIVES: &str =
    "#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]";

/// The input of the printers of one module.
#[derive(Clone, Copy)]
pub(super) struct Printer<'a> {
    pub(super) plan: &'a Plan<'a>,
    /// The names as they are spelled in this module.
    pub(super) names: &'a Names,
    pub(super) options: &'a RustOptions,
    pub(super) module: Module,
    /// Whether this module is the file itself.
    pub(super) root: bool,
}

/// Rust text that is broken at `width`.
pub(super) struct Text {
    pub(super) text: String,
    pub(super) width: usize,
}

impl Text {
    pub(super) fn push_str(&mut self, text: &str) {
        self.text.push_str(text);
    }

    pub(super) fn push(&mut self, letter: char) {
        self.text.push(letter);
    }

    /// An empty text of the same width.
    pub(super) fn same(&self) -> Text {
        Text { text: String::new(), width: self.width }
    }
}

/// A text with each line indented.
pub(super) fn indented(text: &str, levels: usize) -> String {
    let mut inside = String::with_capacity(text.len() * 5 / 4);
    for line in text.lines() {
        if !line.is_empty() {
            inside.push_str(&"    ".repeat(levels));
        }
        inside.push_str(line);
        inside.push('\n');
    }
    inside
}

impl std::fmt::Write for Text {
    fn write_str(&mut self, text: &str) -> std::fmt::Result {
        self.text.push_str(text);
        Ok(())
    }
}

impl Printer<'_> {
    /// An empty text for this module.
    pub(super) fn text(&self) -> Text {
        Text { text: String::new(), width: if self.root { WIDTH } else { WIDTH - INDENT } }
    }

    /// The generated types of this module, each after those it contains.
    pub(super) fn generated_types(
        &self,
    ) -> impl Iterator<Item = (GeneratedTypeId, &GeneratedType)> {
        let all = self.plan.types_in(self.module).into_iter();
        all.filter(|id| self.plan.module_of(*id) == self.module).map(|id| (id, self.plan.get(id)))
    }

    /// The mirrors of this module.
    pub(super) fn mirrors(&self) -> impl Iterator<Item = (GeneratedTypeId, &Mirror)> {
        let all = self.plan.mirrors_in(self.module).into_iter();
        all.filter(|(id, _)| self.plan.module_of(*id) == self.module)
    }

    /// The line of the derives that the program adds, which stands before another attribute, or
    /// nothing.
    pub(super) fn derives(&self) -> String {
        // A trait that all types derive anyway would be implemented twice.
        let known =
            |derive: &&String| !DERIVES.split(&['(', ')', ',', ' '][..]).any(|d| d == *derive);
        let more: Vec<&str> =
            self.options.derives.iter().filter(known).map(String::as_str).collect();
        if more.is_empty() { String::new() } else { format!("#[derive({})]\n", more.join(", ")) }
    }

    /// `pub` or `pub(crate)`.
    pub(super) fn visibility(&self) -> &'static str {
        self.options.visibility.keyword()
    }

    /// The spelling of a type.
    pub(super) fn ty(&self, ty: &RustType) -> String {
        match ty {
            RustType::Named(name) => name.to_string(),
            RustType::User(user) => user.path.to_string(),
            RustType::Array(element, len) => format!("[{}; {len}]", self.ty(element)),
            RustType::GeneratedType(id) => self.name(*id).to_string(),
        }
    }

    pub(super) fn name(&self, id: GeneratedTypeId) -> &str {
        &self.names.made[id.0]
    }

    /// The Rust type of a component.
    pub(super) fn component(&self, scalar: landfall_layout::shape::Scalar) -> &str {
        match component(scalar) {
            Component::Plain(name) => name,
            Component::Bits(bits) => {
                let id = self.plan.id(&GeneratedType::Bits(bits));
                self.name(id.expect("a component is planned with the type made of it"))
            }
        }
    }
}

pub(super) fn doc(text: &mut Text, indent: &str, lines: &[impl AsRef<str>]) {
    for line in lines {
        let line = line.as_ref();
        let space = if line.is_empty() { "" } else { " " };
        let _ = writeln!(text, "{indent}///{space}{line}");
    }
}

/// Prints `head(parameters) tail`, one parameter per line if it is too long.
pub(super) fn signature(
    text: &mut Text,
    indent: &str,
    head: &str,
    parameters: &[String],
    tail: &str,
) {
    let line = format!("{indent}{head}({}){tail}", parameters.join(", "));
    if line.chars().count() <= text.width {
        let _ = writeln!(text, "{line}");
        return;
    }
    let _ = writeln!(text, "{indent}{head}(");
    for parameter in parameters {
        let _ = writeln!(text, "{indent}    {parameter},");
    }
    let _ = writeln!(text, "{indent}){tail}");
}

/// Prints `function(arguments).method()` as a macro argument, without a trailing comma.
pub(super) fn call(
    text: &mut Text,
    indent: &str,
    function: &str,
    arguments: &[String],
    method: &str,
) {
    let inside = arguments.join(", ");
    let line = format!("{indent}{function}({inside}){method}");
    if inside.chars().count() <= CALL && line.chars().count() <= text.width {
        let _ = writeln!(text, "{line}");
        return;
    }
    let line = format!("{indent}{function}({inside})");
    // rustfmt keeps a column for what follows the method.
    if inside.chars().count() <= CALL && line.chars().count() < text.width {
        let _ = writeln!(text, "{line}\n{indent}    {method}");
        return;
    }
    let _ = writeln!(text, "{indent}{function}(");
    for (at, argument) in arguments.iter().enumerate() {
        let comma = if at + 1 < arguments.len() { "," } else { "" };
        let _ = writeln!(text, "{indent}    {argument}{comma}");
    }
    let _ = writeln!(text, "{indent})\n{indent}{method}");
}

/// The text of an array of these elements, the argument of a call: on one line, or one each.
pub(super) fn list(indent: &str, items: &[String]) -> String {
    let line = format!("[{}]", items.join(", "));
    if line.len() <= CALL {
        return line;
    }
    let items: String = items.iter().map(|item| format!("{indent}    {item},\n")).collect();
    format!("[\n{items}{indent}]")
}

/// Prints `impl TRAIT for TYPE {`, on two lines if it is too long.
pub(super) fn implement(text: &mut Text, of: &str, ty: &str) {
    let line = format!("impl {of} for {ty} {{");
    if line.chars().count() <= text.width {
        let _ = writeln!(text, "{line}");
    } else {
        let _ = writeln!(text, "impl {of}\n    for {ty}\n{{");
    }
}

/// A field of a structure literal: `NAME`, or `NAME: VALUE`.
pub(super) struct FieldValue {
    pub(super) name: String,
    /// May have several lines.
    pub(super) value: String,
}

/// Prints `Self { fields }`.
pub(super) fn literal(text: &mut Text, indent: &str, fields: &[FieldValue]) {
    let lines: Vec<String> = fields
        .iter()
        .map(|FieldValue { name, value }| match name == value {
            true => name.clone(),
            false => format!("{name}: {value}"),
        })
        .collect();
    let body = lines.join(", ");
    if body.chars().count() <= LITERAL {
        let _ = writeln!(text, "{indent}Self {{ {body} }}");
        return;
    }
    let _ = writeln!(text, "{indent}Self {{");
    for (line, FieldValue { name, value }) in lines.iter().zip(fields) {
        // Of a value of several lines only the first one stands beside the name.
        let head = line.split('\n').next().unwrap_or(line);
        // rustfmt breaks after the name of a field that is too long.
        let line = match indent.len() + 4 + head.chars().count() < text.width {
            true => format!("{indent}    {line}"),
            false => format!("{indent}    {name}:\n{indent}        {value}"),
        };
        let _ = writeln!(text, "{line},");
    }
    let _ = writeln!(text, "{indent}}}");
}

/// Prints `head separator tail`, the tail on its own line if it is too long.
pub(super) fn assignment(text: &mut Text, indent: &str, head: &str, separator: &str, tail: &str) {
    let line = format!("{indent}{head}{separator} {tail}");
    if line.chars().count() <= text.width {
        let _ = writeln!(text, "{line}");
    } else {
        let _ = writeln!(text, "{indent}{head}{separator}\n{indent}    {tail}");
    }
}

/// The line breaks of a slice that is too long for one line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Items {
    OneALine,
    /// As many per line as fit, as rustfmt does for numbers.
    Filled,
}

/// The text of `&[items]`.
pub(super) fn slice(items: &[String], indent: &str, how: Items, width: usize) -> String {
    let line = items.join(", ");
    if line.len() <= CALL {
        return format!("&[{line}]");
    }
    let mut text = "&[".to_string();
    // The first item begins a line.
    let mut column = width;
    for item in items {
        let fits = column + 1 + item.len() < width;
        if how == Items::Filled && fits {
            let _ = write!(text, " {item},");
            column += item.len() + 2;
        } else {
            let _ = write!(text, "\n{indent}    {item},");
            column = indent.len() + 4 + item.len() + 1;
        }
    }
    let _ = write!(text, "\n{indent}]");
    text
}

/// Prints a [`Default`] of zeroes.
pub(super) fn default(text: &mut Text, name: &str) {
    implement(text, "Default", name);
    text.push_str(
        "    /// All bytes zero.\n    fn default() -> Self {\n        \
         bytemuck::Zeroable::zeroed()\n    }\n}\n\n",
    );
}

/// The names of index parameters: `i`, `j`, `k`, or `i0` and so on.
pub(super) fn indices(count: usize) -> Vec<String> {
    match count {
        0..=3 => ["i", "j", "k"][..count].iter().map(|name| name.to_string()).collect(),
        _ => (0..count).map(|at| format!("i{at}")).collect(),
    }
}

/// Prints `impl From<FROM> for TO` with a body of one expression.
pub(super) fn conversion(text: &mut Text, from: &str, to: &str, value: &str, body: &str) {
    implement(text, &format!("From<{from}>"), to);
    signature(text, "    ", "fn from", &[format!("{value}: {from}")], " -> Self {");
    let _ = write!(text, "        {body}\n    }}\n}}\n\n");
}
