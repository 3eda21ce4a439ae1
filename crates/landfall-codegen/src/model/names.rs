//! Identifiers from the names in shaders: of ASCII letters, no reserved words, no duplicates.

use rustc_hash::FxHashSet;

use crate::c::names::{FreeNames, identifier_part, snake};

/// The words that names of a language may not be.
#[derive(Clone, Copy)]
pub(crate) struct Naming {
    /// Keywords and the generated file's own names, separated by spaces.
    pub reserved: &'static str,
    /// Names that no type may have in addition: what members and parameters are called.
    pub types: &'static str,
    /// Names that no member may have in addition.
    pub members: &'static str,
    /// Whether a name is reserved by its form.
    pub is_reserved: fn(&str) -> bool,
}

/// The names of a file.
pub(super) struct Names {
    naming: Naming,
    prefix: String,
    types: FreeNames,
}

impl Names {
    pub fn new(naming: Naming, prefix: &str) -> Names {
        Names { naming, prefix: identifier_part(prefix), types: FreeNames::default() }
    }

    /// Claims a name of a type: the shader's, or the first free one of `NAME_2`, `NAME_3`, …
    /// Returns the first choice and the name.
    pub fn of_type(&mut self, shader_name: &str) -> (String, String) {
        let mut name = identifier(&format!("{}{shader_name}", self.prefix), &self.naming);
        if self.naming.types.split_whitespace().any(|word| word == name) {
            name.push('_');
        }
        let free = self.types.claim(name.clone());
        (name, free)
    }

    /// The name of a constant, without claiming it: `MAX_LIGHTS`, in capitals in every language.
    pub fn of_constant(&self, shader_name: &str) -> String {
        let name = format!("{}{}", self.prefix, identifier_part(shader_name));
        identifier(&snake(&name).to_ascii_uppercase(), &self.naming)
    }

    /// Claims a name as it stands; returns whether it was free.
    pub fn claim(&mut self, name: &str) -> bool {
        let is_taken = self.naming.types.split_whitespace().any(|word| word == name);
        !is_taken && self.types.claim_free(name)
    }

    pub fn release(&mut self, name: &str) {
        self.types.release(name);
    }

    /// Claims a name of a member of the type `owner`.
    pub fn of_member(
        &self,
        shader_name: &str,
        owner: &str,
        taken: &mut FxHashSet<String>,
    ) -> String {
        let mut name = identifier(shader_name, &self.naming);
        // Some languages take no member that is called like its class.
        while name == owner
            || self.naming.members.split_whitespace().any(|word| word == name)
            || taken.contains(&name)
        {
            name.push('_');
        }
        taken.insert(name.clone());
        name
    }
}

/// A shader's name as an identifier; reserved words get an underscore, other characters than ASCII
/// letters, digits and underscores become `uHEX`.
fn identifier(name: &str, naming: &Naming) -> String {
    let mut name = identifier_part(name);
    if name.is_empty() || name.starts_with(|c: char| c.is_ascii_digit()) {
        name.insert(0, '_');
    }
    if name.bytes().all(|byte| byte == b'_') {
        // `_` alone discards a value in most languages.
        name.push('0');
    }
    if naming.reserved.split_whitespace().any(|word| word == name) || (naming.is_reserved)(&name) {
        name.push('_');
    }
    name
}

/// Returns `name` or a name from it that is not among `taken`, and adds that.
pub(crate) fn free(name: String, taken: &mut FxHashSet<String>) -> String {
    let mut name = name;
    while !taken.insert(name.clone()) {
        name.push('_');
    }
    name
}
