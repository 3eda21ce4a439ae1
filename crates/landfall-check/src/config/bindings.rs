//! `[bindings]` of the configuration: what `landfall emit` adds to Rust mirrors.

use landfall_codegen::rust::{Api, BindingOptions, Sources};
use landfall_layout::Diagnostic;
use landfall_layout::diagnostic::Code;

use super::toml::Keys;

/// Reads the table. Its names are those of a project: one command need not have all of them.
pub fn read(keys: &Keys<'_>) -> BindingOptions {
    keys.table("bindings", "{ api = [\"wgpu\"] }", table).unwrap_or_default()
}

fn table(keys: &Keys<'_>) -> BindingOptions {
    let mut options = BindingOptions::default();
    let list = |key| keys.texts(key).unwrap_or_default();
    for text in list("api") {
        match Api::from_name(&text.value) {
            Some(api) => options.apis.push(api),
            None => {
                let known: Vec<&str> = Api::NAMES.iter().map(|(name, _)| *name).collect();
                keys.unknown(Code::WrongValue, "API", &text, &known);
            }
        }
    }
    let names = |key| list(key).into_iter().map(|text| text.value).collect();
    options.dynamic_offsets = names("dynamic-offsets");
    options.unfilterable = names("unfilterable");
    for (name, row) in keys.rows("counts", "{ textures = 64 }") {
        let digits = row.integer().filter(|(_, radix)| *radix == 10);
        match digits.and_then(|(digits, _)| digits.parse().ok()).filter(|count| *count > 0) {
            Some(count) => options.counts.push((name.value, count)),
            None => {
                let message = format!("the number of elements of `{}` is no count", name.value);
                let found = Diagnostic::error(Code::WrongValue, row.span(), message);
                keys.add(found.with_help("write a number from 1"));
            }
        }
    }
    for (name, files) in keys.text_rows("programs", "{ scene = [\"a.vert\", \"b.frag\"] }") {
        let files = files.into_iter().map(|file| file.value).collect();
        options.programs.push((name.value, files));
    }
    if keys.bool("embed-sources") == Some(true) {
        options.sources = Sources::Embedded;
    }
    let programs = options.programs.iter().map(|(name, _)| name);
    let counts = options.counts.iter().map(|(name, _)| name);
    let named = options.dynamic_offsets.iter().chain(&options.unfilterable);
    // Names of a project may be missing from a single command.
    options.project_names = programs.chain(counts).chain(named).cloned().collect();
    options
}
