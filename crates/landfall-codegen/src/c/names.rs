//! C and C++ identifiers from shader names, deterministic and free of keywords, macros of system
//! headers and duplicates.

use rustc_hash::{FxHashMap, FxHashSet};

use landfall_layout::ShaderLayout;
use landfall_layout::layout::MemberLayout;
use landfall_layout::shape::Type;

/// Keywords of C11, C23, C++17 and C++20, and lower-case macros of common system headers.
const TAKEN: &str = "\
    alignas alignof and and_eq asm assert auto bitand bitor bool break case catch char char16_t \
    char32_t char8_t class co_await co_return co_yield compl complex concept const const_cast \
    consteval constexpr constinit continue decltype default delete do double dynamic_cast else \
    enum errno explicit export extern false far float for friend goto i386 if imaginary inline \
    int int16_t int32_t int64_t int8_t interface linux long main mutable namespace near new \
    noexcept noreturn not not_eq nullptr offsetof operator or or_eq private protected ptrdiff_t \
    public register reinterpret_cast requires restrict return short signed size_t sizeof small \
    static static_assert static_cast struct switch template this thread_local throw true try \
    typedef typeid typename typeof typeof_unqual uint16_t uint32_t uint64_t uint8_t union unix \
    unsigned using virtual void volatile wchar_t while xor xor_eq NULL EOF TRUE FALSE IN OUT \
    OPTIONAL CONST VOID";

/// Names of one namespace, each given once.
#[derive(Clone, Debug, Default)]
pub(crate) struct FreeNames {
    taken: FxHashSet<String>,
    /// The last suffix number used for each repeated name.
    numbers: FxHashMap<String, u32>,
}

impl FreeNames {
    pub fn contains(&self, name: &str) -> bool {
        self.taken.contains(name)
    }

    /// Claims `name`, or the first free one of `NAME_2`, `NAME_3`, …
    pub fn claim(&mut self, name: String) -> String {
        if self.taken.insert(name.clone()) {
            return name;
        }
        // Many structures may have one name: the search goes on behind the last number.
        let mut number = self.numbers.get(&name).copied().unwrap_or(1);
        let free = loop {
            number += 1;
            let free = format!("{name}_{number}");
            if self.taken.insert(free.clone()) {
                break free;
            }
        };
        self.numbers.insert(name, number);
        free
    }

    /// Claims `name` if it is free, and returns whether it was.
    pub fn claim_free(&mut self, name: &str) -> bool {
        self.taken.insert(name.to_string())
    }

    /// Releases a claimed name.
    pub fn release(&mut self, name: &str) {
        self.taken.remove(name);
        // The number of the released name is to be found again.
        self.numbers.clear();
    }
}

/// The names used so far in a header.
#[derive(Clone, Debug, Default)]
pub(super) struct Names {
    prefix: String,
    /// Types, macros and functions, which share the preprocessor's one namespace.
    pub global: FreeNames,
    /// Structures and blocks of all shaders, which no field may be named after: C++ forbids a name
    /// to change its meaning inside a class.
    types: FxHashSet<String>,
}

impl Names {
    /// The initial names of a header for `shaders`.
    pub fn new(prefix: &str, shaders: &[&ShaderLayout]) -> Names {
        let mut types = FxHashSet::default();
        for block in shaders.iter().flat_map(|shader| &shader.blocks) {
            types.insert(identifier(&block.name));
            structures(&block.members, &mut types);
        }
        Names { prefix: identifier_part(prefix), global: FreeNames::default(), types }
    }

    /// Claims a type name unique in the header.
    pub fn of_type(&mut self, shader_name: &str) -> String {
        let name = identifier(&format!("{}{}", self.prefix, identifier_part(shader_name)));
        self.global.claim(name)
    }

    /// Returns the macro name of a shader name without claiming it: `POINT_LIGHT_BLOCK`.
    pub fn upper(&self, shader_name: &str) -> String {
        let name = snake(&format!("{}{}", self.prefix, identifier_part(shader_name)));
        identifier(&name.to_ascii_uppercase())
    }

    /// Returns a member's part of a macro name: `ACTUALLY_USED_COUNT`.
    pub fn upper_part(&self, member: &str) -> String {
        snake(&identifier_part(member)).to_ascii_uppercase()
    }

    /// The include guard, from the file name, or from the shaders' paths if there is none.
    pub fn guard(&self, file: &str, shaders: &[&ShaderLayout]) -> String {
        let paths: Vec<&str> = shaders.iter().map(|shader| shader.path.as_str()).collect();
        let name = if file.is_empty() { paths.join("_") } else { file.to_string() };
        let name: String =
            name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
        format!("LANDFALL_{}{name}_", self.prefix).to_ascii_uppercase()
    }

    /// A field's name, distinct from the names in `others`.
    pub fn field(&self, shader_name: &str, others: &FxHashSet<String>) -> String {
        let mut name = identifier(shader_name);
        while self.types.contains(&name) || others.contains(&name) {
            name.push('_');
        }
        name
    }
}

fn structures(members: &[MemberLayout], types: &mut FxHashSet<String>) {
    for member in members {
        if let Type::Struct(s) = member.ty.innermost() {
            // A nameless structure is never known from before, but it may contain named ones.
            if types.insert(identifier(&s.name)) || s.name.is_empty() {
                structures(&member.members, types);
            }
        }
    }
}

/// Turns a name into a valid C and C++ identifier.
fn identifier(name: &str) -> String {
    let mut name = identifier_part(name);
    if name.is_empty() || name.starts_with(|c: char| c.is_ascii_digit()) {
        name.insert(0, '_');
    }
    // The header's own functions and types begin with `landfall_`.
    if TAKEN.split_whitespace().any(|word| word == name) || name.starts_with("landfall_") {
        name.push('_');
    }
    name
}

/// Keeps ASCII letters, digits and underscores; writes other characters as `uHEX`.
pub(crate) fn identifier_part(name: &str) -> String {
    let mut result = String::with_capacity(name.len());
    for c in name.chars() {
        if c.is_ascii_alphanumeric() || c == '_' {
            result.push(c);
        } else {
            result.push_str(&format!("u{:x}", u32::from(c)));
        }
    }
    result
}

/// Puts underscores between words: `PointLightBlock` becomes `Point_Light_Block`.
pub(crate) fn snake(name: &str) -> String {
    let chars: Vec<char> = name.chars().collect();
    let mut result = String::with_capacity(name.len() + 4);
    for (i, &c) in chars.iter().enumerate() {
        if i > 0 && c.is_ascii_uppercase() {
            let before = chars[i - 1];
            let lower_next = chars.get(i + 1).is_some_and(char::is_ascii_lowercase);
            // A word begins after a small letter, `pointLight`, and with the last capital of
            // several, `GPULight`, or after digits, if a small letter follows.
            let word = before.is_ascii_lowercase()
                || (lower_next && (before.is_ascii_uppercase() || before.is_ascii_digit()));
            if word {
                result.push('_');
            }
        }
        result.push(c);
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_begin_at_capitals() {
        for (name, want) in [
            ("PointLightBlock", "Point_Light_Block"),
            ("u_light", "u_light"),
            ("HTTPServer", "HTTP_Server"),
            ("Light2D", "Light2D"),
            ("Light2Block", "Light2_Block"),
            ("MVP", "MVP"),
        ] {
            assert_eq!(snake(name), want);
        }
    }

    #[test]
    fn keywords_and_system_macros_get_an_underscore() {
        for name in ["near", "class", "register", "linux"] {
            assert_eq!(identifier(name), format!("{name}_"));
        }
        assert_eq!(identifier("größe"), "gruf6udfe");
        assert_eq!(identifier("nearest"), "nearest");
    }

    #[test]
    fn a_name_that_is_taken_gets_a_number() {
        let mut names = FreeNames::default();
        assert_eq!(names.claim("A".to_string()), "A");
        assert_eq!(names.claim("A".to_string()), "A_2");
        names.release("A");
        assert_eq!(names.claim("A".to_string()), "A");
    }
}
