//! Guarded calls of naga's front ends: bounded texts only, and a panic counts as no answer.

use std::panic::{self, AssertUnwindSafe};

use naga::{ArraySize, Module, TypeInner};
use rustc_hash::FxHashMap;

use crate::source::{ExecutableStage, Stage};

/// naga recurses on nested brackets without a bound of its own; deeper text is not handed to it.
const DEEPEST_BRACKETS: u32 = 64;

/// The same for operators whose operands nest: `1 + 1 + 1 + …`, `a ? b : c ? …`.
const LONGEST_CHAIN: u32 = 200;

/// The same for declarations that may hang on each other.
const MOST_STATEMENTS: usize = 4_000;

/// The same for structures that hold structures several times over: naga 30.0.1 walks every
/// member of every member when it lays a structure of GLSL out.
const MOST_NESTED_MEMBERS: u64 = 1 << 16;

/// Longer text is not handed to naga.
const LONGEST_TEXT: usize = 1 << 20;

/// The number of elements of the array type of that name in a WGSL text, if naga takes the text.
pub fn array_length(text: &str, name: &str) -> Option<u32> {
    let module = wgsl_module(text)?;
    let mut types = module.types.iter().map(|(_, ty)| ty);
    match types.find(|ty| ty.name.as_deref() == Some(name))?.inner {
        TypeInner::Array { size: ArraySize::Constant(length), .. } => Some(length.get()),
        _ => None,
    }
}

/// A WGSL text as a module, if naga takes it.
pub fn wgsl_module(text: &str) -> Option<Module> {
    guarded(text, || naga::front::wgsl::parse_str(text).ok())
}

/// A GLSL text as a module, if naga takes it.
pub fn glsl_module(text: &str, stage: Option<Stage>) -> Option<Module> {
    glsl_whole(text, stage, &[])
}

/// The same with defines.
pub fn glsl_whole(
    text: &str,
    stage: Option<Stage>,
    defines: &[(String, String)],
) -> Option<Module> {
    if !is_bounded_glsl(text) {
        return None;
    }
    let stage = match stage.map_or(Some(ExecutableStage::Vertex), ExecutableStage::of)? {
        ExecutableStage::Vertex => naga::ShaderStage::Vertex,
        ExecutableStage::Fragment => naga::ShaderStage::Fragment,
        ExecutableStage::Compute => naga::ShaderStage::Compute,
    };
    let mut options = naga::front::glsl::Options::from(stage);
    options.defines.extend(defines.iter().cloned());
    guarded(text, || naga::front::glsl::Frontend::default().parse(&options, text).ok())
}

/// Whether a text is one that naga can be trusted with.
pub fn is_bounded(text: &str) -> bool {
    text.len() <= LONGEST_TEXT
        && nesting(text) <= DEEPEST_BRACKETS
        && longest_chain(text) <= LONGEST_CHAIN
        && text.bytes().filter(|&byte| byte == b';').count() <= MOST_STATEMENTS
}

/// Whether a GLSL text is one that naga can be trusted with.
pub fn is_bounded_glsl(text: &str) -> bool {
    is_bounded(text) && nested_members(text) <= MOST_NESTED_MEMBERS
}

/// About how many members the structures of a text have, those of their members counted again
/// with each: a word inside the braces of a structure that names an earlier one stands for all
/// of its members.
fn nested_members(text: &str) -> u64 {
    let mut sizes: FxHashMap<&str, u64> = FxHashMap::default();
    let mut all = 0u64;
    let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let mut rest = text;
    while let Some(at) = rest.find("struct") {
        let after = rest[at + "struct".len()..].trim_start();
        let name = &after[..after.find(|c| !is_word(c)).unwrap_or(after.len())];
        rest = &after[name.len()..];
        let Some(body) = rest.trim_start().strip_prefix('{') else { continue };
        let body = &body[..body.find('}').unwrap_or(body.len())];
        let words = body.split(|c| !is_word(c)).filter(|word| !word.is_empty());
        let size =
            words.fold(0u64, |sum, word| sum.saturating_add(sizes.get(word).copied().unwrap_or(1)));
        all = all.saturating_add(size);
        sizes.insert(name, size);
    }
    all
}

/// Runs a front end on text it can be trusted with; a panic in it counts as no answer.
fn guarded(text: &str, parse: impl FnOnce() -> Option<Module>) -> Option<Module> {
    if !is_bounded(text) {
        return None;
    }
    // naga 30.0.1 panics on GLSL's `float a[1000000000][8]`.
    panic::catch_unwind(AssertUnwindSafe(parse)).ok().flatten()
}

/// Runs the validator; a panic in it counts as no answer.
pub fn guarded_validation<T>(validate: impl FnOnce() -> Option<T>) -> Option<T> {
    panic::catch_unwind(AssertUnwindSafe(validate)).ok().flatten()
}

/// How deep brackets nest at most; a run of prefix operators nests as well.
fn nesting(text: &str) -> u32 {
    let (mut open, mut deepest, mut prefixes) = (0u32, 0u32, 0u32);
    for byte in text.bytes() {
        match byte {
            b'(' | b'[' | b'{' | b'<' => open += 1,
            b')' | b']' | b'}' | b'>' => open = open.saturating_sub(1),
            // `<` may be a comparison: no template list goes past this.
            b';' => open = 0,
            b'-' | b'!' | b'~' | b'&' | b'*' => prefixes += 1,
            b' ' | b'\t' | b'\n' | b'\r' => {}
            _ => prefixes = 0,
        }
        deepest = deepest.max(open).max(prefixes);
    }
    deepest
}

/// Operators in a row at most, no comma or semicolon between: naga recurses on their operands.
fn longest_chain(text: &str) -> u32 {
    let (mut chain, mut longest) = (0u32, 0u32);
    for line in text.lines() {
        // Banners in comments are no operators.
        let code = line.split("//").next().unwrap_or(line);
        for byte in code.bytes() {
            match byte {
                b',' | b';' | b'{' | b'}' => chain = 0,
                b'+' | b'-' | b'*' | b'/' | b'%' | b'?' | b'&' | b'|' | b'^' | b'=' | b'<'
                | b'>' => chain += 1,
                _ => {}
            }
            longest = longest.max(chain);
        }
    }
    longest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_that_naga_could_overflow_on_is_not_handed_to_it() {
        for text in ["(".repeat(10_000), "-".repeat(10_000), "array<".repeat(10_000)] {
            assert!(wgsl_module(&format!("const x = {text}")).is_none());
        }
        assert_eq!(nesting("a < b; c < d; e < f;"), 1);
        let mut nested = "struct S0 { float a; };".to_string();
        for i in 1..40 {
            nested += &format!("struct S{i} {{ S{0} a; S{0} b; }};", i - 1);
        }
        assert!(glsl_module(&nested, None).is_none());
        assert_eq!(
            nested_members("struct A { float x; float y; }; struct B { A a; A b[2]; };"),
            15
        );
    }
}
