//! Guarded calls of naga's front ends: only bounded texts are parsed, and a panic yields `None`.

use std::cell::Cell;
use std::panic::{self, AssertUnwindSafe};
use std::sync::Once;

use naga::{ArraySize, Module, TypeInner};
use rustc_hash::FxHashMap;

use crate::source::{ExecutableStage, Stage};

/// The limit on nested brackets: naga recurses on them without a bound of its own.
const DEEPEST_BRACKETS: u64 = 64;

/// The limit on chained operators with nested operands: `1 + 1 + 1 + …`, `a ? b : c ? …`.
const LONGEST_CHAIN: u64 = 200;

/// The limit on declarations, which may depend on each other, and on functions, which naga compares
/// with all others of their name.
const MOST_STATEMENTS: u64 = 4_000;

/// The limit on members of nested structures: naga 30.0.1 visits every member of every member when
/// it lays out a GLSL structure, and when it validates one of either language.
const MOST_NESTED_MEMBERS: u64 = 1 << 16;

/// The limit on the words of a WGSL function, and on the root of the sum of their squares for all
/// functions: naga 30.0.1 walks over all expressions of a function for each of them. At the limit it
/// takes 0.12 s of processor time in a release build, and four times the words take 1.6 s.
const MOST_WORDS: u64 = 16_000;

/// The limit on line continuations in a row: naga's preprocessor recurses on them.
const MOST_CONTINUATIONS: u64 = 1_000;

/// The limit on the length of a text in bytes.
const LONGEST_TEXT: u64 = 1 << 20;

/// Returns the number of elements of the named array type in a WGSL text, if naga accepts the text.
pub fn array_length(text: &str, name: &str) -> Option<u32> {
    let module = wgsl_module(text)?;
    let mut types = module.types.iter().map(|(_, ty)| ty);
    match types.find(|ty| ty.name.as_deref() == Some(name))?.inner {
        TypeInner::Array { size: ArraySize::Constant(length), .. } => Some(length.get()),
        _ => None,
    }
}

/// Parses a WGSL text; `None` if naga rejects it.
pub(crate) fn wgsl_module(text: &str) -> Option<Module> {
    guarded(text, || naga::front::wgsl::parse_str(text).ok())
}

/// Parses a GLSL text; `None` if naga rejects it.
pub fn glsl_module(text: &str, stage: Option<Stage>) -> Option<Module> {
    glsl_whole(text, stage, &[])
}

/// Parses a GLSL text with defines; `None` if naga rejects it.
pub(crate) fn glsl_whole(
    text: &str,
    stage: Option<Stage>,
    defines: &[(String, String)],
) -> Option<Module> {
    let stage = match stage.map_or(Some(ExecutableStage::Vertex), ExecutableStage::of)? {
        ExecutableStage::Vertex => naga::ShaderStage::Vertex,
        ExecutableStage::Fragment => naga::ShaderStage::Fragment,
        ExecutableStage::Compute => naga::ShaderStage::Compute,
    };
    let mut options = naga::front::glsl::Options::from(stage);
    options.defines.extend(defines.iter().cloned());
    guarded(text, || naga::front::glsl::Frontend::default().parse(&options, text).ok())
}

/// Whether a text is within the limits for naga.
pub fn is_bounded(text: &str) -> bool {
    excess(text).is_none()
}

/// Returns what in a text is beyond a limit for naga, with the limit: `has functions of 20000 words,
/// more than the 16000 that naga is given`.
pub fn excess(text: &str) -> Option<String> {
    let beyond = |count: u64, most: u64, what: &str| {
        (count > most).then(|| format!("{what}, more than the {most} that naga is given"))
    };
    let statements = || text.bytes().filter(|byte| b";{".contains(byte)).count() as u64;
    let words = || squared_words(text).isqrt();
    let of =
        |count: u64, most: u64, what: &str| beyond(count, most, &format!("has {count} {what}"));
    of(text.len() as u64, LONGEST_TEXT, "bytes")
        .or_else(|| {
            of(nesting(text), DEEPEST_BRACKETS, "brackets or prefix operators in each other")
        })
        .or_else(|| of(longest_chain(text), LONGEST_CHAIN, "operators in one expression"))
        .or_else(|| of(statements(), MOST_STATEMENTS, "statements, members and bodies"))
        .or_else(|| of(nested_members(text), MOST_NESTED_MEMBERS, "members in nested structures"))
        .or_else(|| {
            let words = words();
            let what = format!("has a function of {words} words, or several of as much work");
            beyond(words, MOST_WORDS, &what)
        })
        .or_else(|| of(continuations(text), MOST_CONTINUATIONS, "joined lines in a row"))
}

/// Estimates the number of members of a text's structures, counting the members of nested
/// structures each time: a word inside the braces of a structure that names an earlier one stands
/// for all of its members.
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

/// Returns the sum of the squares of the numbers of words between `fn` and the next one.
fn squared_words(text: &str) -> u64 {
    let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let (mut sum, mut words, mut is_function) = (0u64, 0u64, false);
    for word in text.split(|c| !is_word(c)).filter(|word| !word.is_empty()).chain(["fn"]) {
        match word {
            "fn" if is_function => {
                sum = sum.saturating_add(words * words);
                words = 0;
            }
            "fn" => is_function = true,
            _ => words += u64::from(is_function),
        }
    }
    sum
}

/// Runs a front end on a text within the limits; a panic yields `None`.
fn guarded(text: &str, parse: impl FnOnce() -> Option<Module>) -> Option<Module> {
    if !is_bounded(text) {
        return None;
    }
    // naga 30.0.1 panics on GLSL's `float a[1000000000][8]`.
    caught(parse).flatten()
}

/// Runs the validator; a panic yields `None`.
pub(crate) fn guarded_validation<T>(validate: impl FnOnce() -> Option<T>) -> Option<T> {
    caught(validate).flatten()
}

thread_local! {
    /// The number of calls of naga on this thread, one inside the other.
    static CALLS: Cell<u32> = const { Cell::new(0) };
}

/// Calls naga; `None` if it panics, of which nothing is printed.
pub fn caught<T>(call: impl FnOnce() -> T) -> Option<T> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let print = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            // A panic that ends the process is printed.
            if CALLS.get() == 0 || cfg!(panic = "abort") {
                print(info);
            }
        }));
    });
    CALLS.set(CALLS.get() + 1);
    let result = panic::catch_unwind(AssertUnwindSafe(call));
    CALLS.set(CALLS.get() - 1);
    result.ok()
}

/// Returns the greatest nesting of brackets; a run of prefix operators counts as nesting.
fn nesting(text: &str) -> u64 {
    let (mut open, mut deepest, mut prefixes) = (0u64, 0u64, 0u64);
    for byte in text.bytes() {
        match byte {
            b'(' | b'[' | b'{' | b'<' => open += 1,
            b')' | b']' | b'}' | b'>' => open = open.saturating_sub(1),
            // `<` may be a comparison: no template list extends past this.
            b';' => open = 0,
            b'-' | b'!' | b'~' | b'&' | b'*' => prefixes += 1,
            b' ' | b'\t' | b'\n' | b'\r' => {}
            _ => prefixes = 0,
        }
        deepest = deepest.max(open).max(prefixes);
    }
    deepest
}

/// Returns the longest run of backslashes and line breaks, counted in backslashes.
fn continuations(text: &str) -> u64 {
    let (mut run, mut longest) = (0, 0);
    for byte in text.bytes() {
        match byte {
            b'\\' => run += 1,
            b'\r' | b'\n' => {}
            _ => run = 0,
        }
        longest = longest.max(run);
    }
    longest
}

/// Returns the longest run of operators without a comma or semicolon; naga recurses on their
/// operands.
fn longest_chain(text: &str) -> u64 {
    let (mut chain, mut longest) = (0u64, 0u64);
    for line in text.lines() {
        // Lines of symbols in comments are not operators.
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
        let function = format!("fn f() {{ var x = u.y; {} }}", "x = x + u.y;".repeat(3_900));
        assert_eq!(squared_words(&function.repeat(2)), 2 * (5 + 4 * 3_900u64).pow(2));
        assert!(wgsl_module(&format!("var<private> u: vec2f; {function}")).is_some());
        let longer = function.replace("x + u.y;", "x + u.y + u.y + u.y;");
        let longer = format!("var<private> u: vec2f; {longer}");
        assert!(wgsl_module(&longer).is_none());
        let said = "has a function of 31205 words, or several of as much work, more than the 16000 \
                    that naga is given";
        assert_eq!(excess(&longer).as_deref(), Some(said));
        for line in ["\\\n", "\\\r\n"] {
            let continued = format!("{}void main() {{}}", line.repeat(400_000));
            assert!(glsl_module(&continued, Some(Stage::Fragment)).is_none());
        }
        assert_eq!(
            nested_members("struct A { float x; float y; }; struct B { A a; A b[2]; };"),
            15
        );
    }
}
