//! Prints the constants of the shaders that lengths of arrays are written with.

use std::fmt::Write as _;

use super::names::{is_identifier, screaming};
use super::print::{Printer, Text, doc};

/// Prints the constants of a shader's module, or of all shaders in a file without modules. One
/// whose name has several values there, or is that of another item, is left out.
pub(super) fn constants(out: &Printer<'_>, text: &mut Text) {
    let all = out.plan.constants_in(out.module);
    let names: Vec<String> = all.iter().map(|constant| rust_name(&constant.name)).collect();
    for (at, (constant, name)) in all.iter().zip(&names).enumerate() {
        // The first constant of a name is printed, unless another one has another value.
        let has_name = |other: &usize| names[*other] == *name;
        let is_known = (0..at).any(|other| has_name(&other));
        let is_one = (0..all.len()).filter(has_name).all(|o| all[o].value == constant.value);
        let items = out.names.made.iter().chain(out.names.inits.values());
        let mut items = items.chain(out.names.elements.values()).chain(&out.names.tables);
        if is_known || !is_one || items.any(|item| item == name) {
            continue;
        }
        let about = format!("`{}` of the shader, by which it gives lengths.", constant.name);
        doc(text, "", &[about]);
        let (public, value) = (out.visibility(), constant.value);
        let _ = writeln!(text, "#[allow(dead_code)]\n{public} const {name}: usize = {value};\n");
    }
}

/// `MAX_LIGHTS`; `maxLights` becomes that.
fn rust_name(name: &str) -> String {
    let is_constant = is_identifier(name) && !name.contains(|c: char| c.is_ascii_lowercase());
    if is_constant { name.to_string() } else { screaming(name) }
}
