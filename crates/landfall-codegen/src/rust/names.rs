//! Rust names from shader names: case, keywords, clashes.
//!
//! Used by [`super::plan`] for fields and by [`super::naming`] for the rest.

use rustc_hash::{FxHashMap, FxHashSet};

/// Keywords of any edition that are identifiers with `r#`.
const KEYWORDS: &[&str] = &[
    "abstract", "as", "async", "await", "become", "box", "break", "const", "continue", "do", "dyn",
    "else", "enum", "extern", "false", "final", "fn", "for", "gen", "if", "impl", "in", "let",
    "loop", "macro", "match", "mod", "move", "mut", "override", "priv", "pub", "ref", "return",
    "static", "struct", "trait", "true", "try", "type", "typeof", "unsafe", "unsized", "use",
    "virtual", "where", "while", "yield",
];

/// Keywords that cannot be raw identifiers.
const NEVER_NAMES: &[&str] = &["self", "super", "crate", "Self"];

/// Prelude items that the output uses by their short names.
const PRELUDE: &[&str] = &[
    "Clone",
    "Copy",
    "Debug",
    "Default",
    "Err",
    "From",
    "Into",
    "Iterator",
    "None",
    "Ok",
    "Option",
    "PartialEq",
    "Result",
    "Some",
];

/// Crates that the output uses.
const CRATES: &[&str] = &["alloc", "bytemuck", "core", "glam", "std"];

/// The words of a shader name, split at `_` and at changes from lower to upper case.
fn words(name: &str) -> Vec<String> {
    let mut words: Vec<String> = Vec::new();
    let mut word = String::new();
    let letters: Vec<char> = name.chars().collect();
    for (at, &letter) in letters.iter().enumerate() {
        if letter == '_' {
            words.push(std::mem::take(&mut word));
            continue;
        }
        let before = at.checked_sub(1).map(|i| letters[i]);
        let after = letters.get(at + 1);
        // `lightPos` has two words, and so has `HTTPServer`: the last capital of a run begins the
        // next one.
        let begins = letter.is_ascii_uppercase()
            && (before.is_some_and(|b| b.is_ascii_lowercase() || b.is_ascii_digit())
                || before.is_some_and(|b| b.is_ascii_uppercase())
                    && after.is_some_and(|a| a.is_ascii_lowercase()));
        if begins {
            words.push(std::mem::take(&mut word));
        }
        if letter.is_ascii() {
            word.push(letter.to_ascii_lowercase());
        } else {
            // rustc warns of confusable letters (`confusable_idents`), so write their code points.
            word.push_str(&format!("u{:x}", u32::from(letter)));
        }
    }
    words.push(word);
    words.retain(|word| !word.is_empty());
    words
}

/// A field, function or module name: `light_pos`, `r#type`.
pub(crate) fn snake(name: &str) -> String {
    escape(plain_snake(name))
}

/// [`snake`] without keywords escaped.
fn plain_snake(name: &str) -> String {
    let name = words(name).join("_");
    match name.as_bytes().first() {
        None => "unnamed".to_string(),
        // A name of digits cannot begin a Rust name.
        Some(b'0'..=b'9') => format!("n{name}"),
        Some(_) => name,
    }
}

fn escape(name: String) -> String {
    if KEYWORDS.contains(&name.as_str()) {
        format!("r#{name}")
    } else if NEVER_NAMES.contains(&name.as_str()) {
        format!("{name}_")
    } else {
        name
    }
}

/// Whether Rust takes a text as a name, as it stands.
pub(super) fn is_identifier(name: &str) -> bool {
    let letters = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let first = name.starts_with(|c: char| c.is_ascii_alphabetic());
    first
        && name.chars().all(letters)
        && !KEYWORDS.contains(&name)
        && !NEVER_NAMES.contains(&name)
        && !PRELUDE.contains(&name)
        && !CRATES.contains(&name)
}

/// A module name: [`snake`], with an underscore after the names of crates in use.
pub(super) fn module(name: &str) -> String {
    let name = snake(name);
    if CRATES.contains(&name.as_str()) { format!("{name}_") } else { name }
}

/// A constant's name: `LIGHT_POS`.
pub(super) fn screaming(name: &str) -> String {
    plain_snake(name).to_ascii_uppercase()
}

/// A type's name: `PointLight`.
pub(super) fn camel(name: &str) -> String {
    let mut result = String::new();
    for word in words(name) {
        // `Light_2_4` keeps its numbers separate.
        if word.starts_with(|c: char| c.is_ascii_digit())
            && result.ends_with(|c: char| c.is_ascii_digit())
        {
            result.push('_');
        }
        let mut letters = word.chars();
        result.extend(letters.next().map(|first| first.to_ascii_uppercase()));
        result.push_str(letters.as_str());
    }
    if result.is_empty() {
        result.push_str("Unnamed");
    } else if result.starts_with(|c: char| c.is_ascii_digit()) {
        result.insert(0, 'N');
    }
    if PRELUDE.contains(&result.as_str()) || NEVER_NAMES.contains(&result.as_str()) {
        result.push('_');
    }
    result
}

/// The names used so far in one Rust namespace.
#[derive(Default)]
pub(super) struct Scope {
    taken: FxHashSet<String>,
    /// The next suffix number of each name, so that many equal names stay cheap.
    next: FxHashMap<String, u32>,
}

impl Scope {
    /// Claims `wanted`, with a number appended if it is taken.
    pub(super) fn take(&mut self, wanted: &str) -> String {
        if self.taken.insert(wanted.to_string()) {
            return wanted.to_string();
        }
        // `type` taken becomes `type2`, which is no keyword and needs no `r#`.
        let bare = wanted.strip_prefix("r#").unwrap_or(wanted).trim_end_matches('_');
        let next = self.next.entry(wanted.to_string()).or_insert(2);
        loop {
            // `light2` becomes `light2_2`, not `light22`.
            let digit = bare.ends_with(|c: char| c.is_ascii_digit());
            let camel = bare.starts_with(|c: char| c.is_ascii_uppercase())
                && bare.contains(|c: char| c.is_ascii_lowercase());
            // `Light` becomes `Light2`, `light` and `LIGHT` become `light_2` and `LIGHT_2`.
            let join = if digit || !camel { "_" } else { "" };
            let name = format!("{bare}{join}{next}");
            *next += 1;
            if self.taken.insert(name.clone()) {
                return name;
            }
        }
    }

    pub(super) fn is_free(&self, name: &str) -> bool {
        !self.taken.contains(name)
    }

    pub(super) fn reserve(&mut self, names: &[&str]) {
        self.taken.extend(names.iter().map(|name| name.to_string()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shader_names_become_rust_style() {
        for (name, field, ty) in [
            ("lightPos", "light_pos", "LightPos"),
            ("MVP", "mvp", "Mvp"),
            ("PointLight", "point_light", "PointLight"),
            ("u_point_light_array", "u_point_light_array", "UPointLightArray"),
            ("HTTPServer2D", "http_server2_d", "HttpServer2D"),
            ("a__b", "a_b", "AB"),
            ("_padding", "padding", "Padding"),
            ("_1", "n1", "N1"),
            ("__", "unnamed", "Unnamed"),
            ("type", "r#type", "Type"),
            ("gen", "r#gen", "Gen"),
            ("self", "self_", "Self_"),
            ("Option", "option", "Option_"),
            ("größe", "gruf6udfe", "Gruf6udfe"),
        ] {
            assert_eq!(snake(name), field, "{name}");
            assert_eq!(camel(name), ty, "{name}");
        }
        assert_eq!(screaming("lightPos"), "LIGHT_POS");
        assert_eq!(module("core"), "core_");
    }

    #[test]
    fn a_taken_name_gets_a_number() {
        let mut scope = Scope::default();
        assert_eq!(scope.take("light"), "light");
        assert_eq!(scope.take("light"), "light_2");
        assert_eq!(scope.take("r#type"), "r#type");
        assert_eq!(scope.take("r#type"), "type_2");
        assert_eq!(scope.take("Light2"), "Light2");
        assert_eq!(scope.take("Light2"), "Light2_2");
        assert_eq!(scope.take("Light"), "Light");
        assert_eq!(scope.take("Light"), "Light3");
        assert_eq!(scope.take("SIZE"), "SIZE");
        assert_eq!(scope.take("SIZE"), "SIZE_2");
    }
}
