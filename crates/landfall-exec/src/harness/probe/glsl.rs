//! Adds a probe to a GLSL shader: the user's text, then a `main` with the reads.
//!
//! Implements a [`Plan`]; the text goes to the OpenGL driver, and through Landfall's front end to
//! the interpreter and wgpu.

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::fmt::Write as _;

use rustc_hash::FxHashMap;

use super::plan::{AccessMode, Plan, Read, members, top_name};
use super::sentinel::{self, Grain};
use landfall_layout::layout::{BlockLayout, Leaf, MemberLayout};
use landfall_layout::shape::{Scalar, ScalarKind, Type};
use landfall_layout::source::{ExecutableStage, Language, Source};
use landfall_layout::syntax;

/// The storage block that holds the indices and receives the words.
pub(crate) const RESULTS: &str = "LandfallWords";

/// Returns the user's text with its `main` replaced by the probe's.
pub(crate) fn text(
    source: &Source,
    block: &BlockLayout,
    element: &[u32],
    plan: &Plan,
    stage: ExecutableStage,
) -> String {
    let head = Head::from_text(&source.text);
    let mut text = with_main_renamed(source, &head);
    append(&mut text, source, block, element, plan, stage, &head);
    text
}

/// Returns the user's text with its `main` renamed.
pub(crate) fn with_main_renamed(source: &Source, head: &Head) -> String {
    let mut text = String::with_capacity(source.text.len() + 4096);
    text.push_str(&source.text[..head.end]);
    if head.end > 0 && !text.ends_with('\n') {
        text.push('\n');
    }
    if head.end == 0 {
        text.push_str("#version 450\n");
    }
    // Extensions that the probe needs beyond the shader's version.
    if !head.es && head.version < 430 && head.end > 0 {
        text.push_str("#extension GL_ARB_shader_storage_buffer_object : enable\n");
        text.push_str("#extension GL_ARB_shader_bit_encoding : enable\n");
    }
    // There are two functions `main`. The preprocessor renames the user's, so that the positions in
    // it stay.
    text.push_str("#define main landfall_users_main\n");
    let _ = writeln!(text, "#line {}", head.line);
    text.push_str(&source.text[head.end..]);
    text.push_str("\n#undef main\n");
    // What follows names members and functions, never macros: one may have the name of a member.
    for name in defined(&source.text) {
        let _ = writeln!(text, "#undef {name}");
    }
    text
}

/// Returns the names of the macros that a text defines. Compilers refuse `#undef` for those that
/// begin as their own do (GLSL 4.60 §3.3).
fn defined(text: &str) -> BTreeSet<&str> {
    let tokens = match text.contains("define") {
        true => syntax::tokens(text, Language::Glsl),
        false => Vec::new(),
    };
    let names = tokens.windows(3).filter(|at| at[..2] == ["#", "define"]).map(|at| at[2]);
    names.filter(|name| !name.starts_with("GL_") && !name.contains("__")).collect()
}

/// Appends the declarations before a generated `main`: the results' block, and a workgroup size if
/// there is none.
pub(crate) fn results(text: &mut String, source: &Source, stage: ExecutableStage, head: &Head) {
    // A lower precision could lose bits of a sentinel.
    if head.es {
        text.push_str("precision highp float;\nprecision highp int;\n");
    }
    let precision = if head.es { "highp " } else { "" };
    let _ =
        writeln!(text, "layout(std430) buffer {RESULTS} {{ {precision}uint landfall_words[]; }};");
    if stage == ExecutableStage::Compute && !is_sized(&source.text) {
        text.push_str("layout(local_size_x = 1) in;\n");
    }
}

/// Returns whether a text declares a workgroup size in any dimension.
pub(crate) fn is_sized(text: &str) -> bool {
    let is_size = |token: &str| token.starts_with("local_size_");
    text.contains("local_size_") && syntax::tokens(text, Language::Glsl).into_iter().any(is_size)
}

/// Appends a `main` for a stage, whose body one invocation runs.
pub(crate) fn main(text: &mut String, stage: ExecutableStage, body: &str) {
    text.push_str("void main() {\n");
    match stage {
        ExecutableStage::Vertex => text.push_str("    gl_Position = vec4(0.0, 0.0, 0.0, 1.0);\n"),
        // The other invocations of a workgroup would write every word again.
        ExecutableStage::Compute => {
            text.push_str("    if (gl_GlobalInvocationID != uvec3(0u)) return;\n");
        }
        ExecutableStage::Fragment => {}
    }
    text.push_str(body);
    text.push_str("}\n");
}

/// The `#version` line: its contents and its end.
pub(crate) struct Head {
    /// The byte after its line break; 0 if there is no such line.
    pub(crate) end: usize,
    /// The number of the next line.
    line: usize,
    pub(crate) version: u32,
    pub(crate) es: bool,
}

impl Head {
    pub(crate) fn from_text(text: &str) -> Head {
        let (mut end, mut in_comment) = (0, false);
        for (number, line) in text.split_inclusive('\n').enumerate() {
            end += line.len();
            let code = without_comments(line, &mut in_comment);
            let words = code.trim_start().strip_prefix('#').map(str::trim_start);
            let Some(words) = words.and_then(|words| words.strip_prefix("version")) else {
                continue;
            };
            let mut words = words.split_whitespace();
            let version = words.next().and_then(|word| word.parse().ok()).unwrap_or(110);
            let es = version == 100 || words.next() == Some("es");
            return Head { end, line: number + 2, version, es };
        }
        // The version that `with_main_renamed` writes.
        Head { end: 0, line: 1, version: 450, es: false }
    }
}

/// Returns a line without its comments; `in_comment` is whether it begins in one, then whether the
/// next does.
fn without_comments<'t>(line: &'t str, in_comment: &mut bool) -> Cow<'t, str> {
    if !*in_comment && !line.contains('/') {
        return line.into();
    }
    let (mut code, mut rest) = (String::new(), line);
    loop {
        if *in_comment {
            let Some(end) = rest.find("*/") else { return code.into() };
            rest = &rest[end + 2..];
            *in_comment = false;
        }
        let Some(start) = ["//", "/*"].iter().filter_map(|mark| rest.find(mark)).min() else {
            return (code + rest).into();
        };
        code.push_str(&rest[..start]);
        // A comment stands for one space (GLSL 4.60 §3.4).
        code.push(' ');
        if rest[start..].starts_with("//") {
            return code.into();
        }
        rest = &rest[start + 2..];
        *in_comment = true;
    }
}

fn append(
    text: &mut String,
    source: &Source,
    block: &BlockLayout,
    element: &[u32],
    plan: &Plan,
    stage: ExecutableStage,
    head: &Head,
) {
    results(text, source, stage, head);
    let mut body = String::new();
    reads(text, &mut body, block, element, plan);
    if stage == ExecutableStage::Fragment {
        let _ = writeln!(body, "    if (landfall_words[0] == {NEVER}) discard;");
    }
    main(text, stage, &body);
}

/// The bits of no index and no value of a probe. A fragment shader that may discard is compiled once by
/// llvmpipe; others once more for tiles that are covered as a whole, of which a probe has none.
pub(super) const NEVER: &str = "4294967295u";

/// Appends the functions of a plan's copies to `text`, and its reads to the `body` of `main`.
pub(super) fn reads(
    text: &mut String,
    body: &mut String,
    block: &BlockLayout,
    element: &[u32],
    plan: &Plan,
) {
    let root = root(block, element);
    spelled_reads(&GLSL, &root, text, body, block, plan);
}

/// How a language spells the parts of reads and writes.
pub(super) struct ProbeSpelling {
    /// Appends statements that store a component's bits into its words.
    pub result: fn(&mut String, &Read, &str),
    /// Returns the value that a write assigns.
    pub value: fn(&Read, Grain) -> String,
    /// Returns the read of a place.
    pub loaded: fn(&BlockLayout, &Read, String) -> String,
    /// Returns a function of a name: the copy of a member, from a place or passed, then statements.
    pub copy: fn(&str, &MemberLayout, Option<&str>, &str) -> String,
}

const GLSL: ProbeSpelling = ProbeSpelling { result, value, loaded: |_, _, from| from, copy };

/// Appends the functions and reads of a plan in either language; paths begin with `root`.
pub(super) fn spelled_reads(
    spelling: &ProbeSpelling,
    root: &str,
    text: &mut String,
    body: &mut String,
    block: &BlockLayout,
    plan: &Plan,
) {
    let &ProbeSpelling { result, value, loaded, copy } = spelling;
    for (number, group) in groups(block, plan).into_iter().enumerate() {
        let Group { way, member, start, reads } = group;
        match way {
            AccessMode::Constant | AccessMode::Dynamic => {
                for read in reads {
                    let from = format!("{root}{}", path(block, read, 0, way, plan));
                    let from = component(from, read, way, plan);
                    result(body, read, &loaded(block, read, from));
                }
            }
            AccessMode::Written => {
                for (nth, read) in reads.into_iter().enumerate() {
                    // Every other write uses dynamic indices.
                    let way = if nth % 2 == 0 { AccessMode::Constant } else { AccessMode::Dynamic };
                    let to = format!("{root}{}", path(block, read, 0, way, plan));
                    let to = component(to, read, way, plan);
                    let _ = writeln!(body, "    {to} = {};", value(read, plan.grain));
                }
            }
            AccessMode::Copied | AccessMode::Passed => {
                let Some(member) = member else { continue };
                let from = format!("{root}{}{}", member.name, subscripts(&start));
                let skipped = if is_structure(member) { member.dims.len() } else { 0 };
                let mut inside = String::new();
                for read in reads {
                    let rest = path(block, read, skipped, AccessMode::Constant, plan);
                    let from = component(format!("landfall_copy{rest}"), read, way, plan);
                    result(&mut inside, read, &from);
                }
                let name = format!("landfall_{}_{number}", way.name());
                let (copied, passed) = match way {
                    AccessMode::Passed => (None, from.as_str()),
                    _ => (Some(from.as_str()), ""),
                };
                let _ = writeln!(text, "{}", copy(&name, member, copied, &inside));
                let _ = writeln!(body, "    {name}({passed});");
            }
        }
    }
}

/// Returns the prefix of a member's path: `block[1].`, or nothing.
fn root(block: &BlockLayout, element: &[u32]) -> String {
    match &block.instance {
        Some(instance) => format!("{instance}{}.", subscripts(element)),
        None => String::new(),
    }
}

fn subscripts(indices: &[u32]) -> String {
    indices.iter().fold(String::new(), |mut text, index| {
        let _ = write!(text, "[{index}]");
        text
    })
}

/// Reads that share a copy, or that need none.
pub(super) struct Group<'a> {
    pub way: AccessMode,
    pub member: Option<&'a MemberLayout>,
    /// Indices of the member's own dimensions, if its elements are structures.
    pub start: Vec<u32>,
    pub reads: Vec<&'a Read>,
}

/// Returns the reads of a plan grouped by the copy they need.
pub(super) fn groups<'a>(block: &'a BlockLayout, plan: &'a Plan) -> Vec<Group<'a>> {
    let mut groups: Vec<Group<'a>> = Vec::new();
    let members = members(block);
    let mut known: FxHashMap<(AccessMode, Option<&str>, Vec<u32>), usize> = FxHashMap::default();
    for read in &plan.reads {
        let (member, start) = match read.way {
            AccessMode::Copied | AccessMode::Passed => {
                let name = top_name(&block.leaves[read.leaf]);
                let member = name.and_then(|name| members.get(name).copied());
                // Of an array of structures one element is copied.
                let structure = member.is_some_and(is_structure);
                let own = if structure { member.map_or(0, |m| m.dims.len()) } else { 0 };
                (member, read.element[..own].to_vec())
            }
            AccessMode::Constant | AccessMode::Dynamic | AccessMode::Written => (None, Vec::new()),
        };
        let key = (read.way, member.map(|member| &*member.name), start.clone());
        let at = *known.entry(key).or_insert(groups.len());
        match groups.get_mut(at) {
            Some(group) => group.reads.push(read),
            None => groups.push(Group { way: read.way, member, start, reads: vec![read] }),
        }
    }
    groups
}

pub(super) fn is_structure(member: &MemberLayout) -> bool {
    matches!(member.ty.innermost(), Type::Struct(_))
}

/// Returns a function that reads a copy of a member, from a place or passed.
fn copy(name: &str, member: &MemberLayout, from: Option<&str>, inside: &str) -> String {
    let declared = declared(member, "landfall_copy");
    match from {
        Some(from) => format!("void {name}() {{\n    {declared} = {from};\n{inside}}}"),
        None => format!("void {name}({declared}) {{\n{inside}}}"),
    }
}

/// Returns the declaration `T name`, or `T name[4]` for a copy of a whole array.
fn declared(member: &MemberLayout, name: &str) -> String {
    let inner = member.ty.innermost().spelled(Language::Glsl).to_string();
    let all = member.ty.spelled(Language::Glsl).to_string();
    let dims = if is_structure(member) { "" } else { &all[inner.len()..] };
    format!("{inner} {name}{dims}")
}

/// Returns the leaf's path with its indices, without the first `skipped` of them and their member
/// if a copy replaces those.
pub(super) fn path(
    block: &BlockLayout,
    read: &Read,
    skipped: usize,
    way: AccessMode,
    plan: &Plan,
) -> String {
    let leaf: &Leaf = &block.leaves[read.leaf];
    let copied = matches!(read.way, AccessMode::Copied | AccessMode::Passed);
    let mut rest = leaf.path.as_str();
    let mut elements = read.element.iter();
    // The copy is named instead of the member.
    if copied {
        let name = rest.find(['.', '[']).unwrap_or(rest.len());
        rest = &rest[name..];
        for _ in 0..skipped {
            rest = rest.strip_prefix("[]").unwrap_or(rest);
            elements.next();
        }
    }
    let mut text = String::new();
    for (nth, part) in rest.split("[]").enumerate() {
        if nth > 0 {
            let index = elements.next().copied().unwrap_or(0);
            let _ = write!(text, "[{}]", subscript(index, way, plan));
        }
        text.push_str(part);
    }
    text
}

/// Returns an index as a literal, or as a read of the words the results begin with.
pub(super) fn subscript(index: u32, way: AccessMode, plan: &Plan) -> String {
    // The results begin with the indices.
    let slot = plan.indices.binary_search(&index).ok();
    match (way, slot) {
        (AccessMode::Dynamic, Some(slot)) => format!("landfall_words[{slot}]"),
        (
            AccessMode::Dynamic
            | AccessMode::Constant
            | AccessMode::Copied
            | AccessMode::Passed
            | AccessMode::Written,
            _,
        ) => index.to_string(),
    }
}

/// Returns the access to a component: by name, or by index if the way is dynamic.
pub(super) fn component(from: String, read: &Read, way: AccessMode, plan: &Plan) -> String {
    let column = read.column.map(u32::from).map(|column| subscript(column, way, plan));
    let row = read.row.map(|row| match way {
        AccessMode::Dynamic => format!("[{}]", subscript(u32::from(row), way, plan)),
        AccessMode::Constant | AccessMode::Copied | AccessMode::Passed | AccessMode::Written => {
            format!(".{}", ["x", "y", "z", "w"][usize::from(row)])
        }
    });
    match (column, row) {
        (Some(column), Some(row)) => format!("{from}[{column}]{row}"),
        (None, Some(row)) => format!("{from}{row}"),
        (_, None) => from,
    }
}

/// Appends statements that store a component's bits into its words; a 16-bit float's value.
fn result(text: &mut String, read: &Read, from: &str) {
    let slot = read.slot;
    let _ = match kind(read.scalar) {
        Kind::Float => writeln!(text, "    landfall_words[{slot}] = floatBitsToUint({from});"),
        Kind::Half => {
            writeln!(text, "    landfall_words[{slot}] = floatBitsToUint(float({from}));")
        }
        Kind::Narrow => {
            let mask = (1u32 << (u32::from(read.scalar.width) * 8)) - 1;
            writeln!(text, "    landfall_words[{slot}] = uint({from}) & {mask}u;")
        }
        Kind::Whole => writeln!(text, "    landfall_words[{slot}] = uint({from});"),
        Kind::Bool => writeln!(text, "    landfall_words[{slot}] = {from} ? 1u : 0u;"),
        Kind::Long => writeln!(
            text,
            "    landfall_words[{slot}] = uint({from}); \
             landfall_words[{}] = uint({from} >> 32);",
            slot + 1
        ),
        Kind::Double => writeln!(
            text,
            "    {{ uvec2 landfall_halves = unpackDouble2x32({from}); \
             landfall_words[{slot}] = landfall_halves.x; \
             landfall_words[{}] = landfall_halves.y; }}",
            slot + 1
        ),
    };
}

/// Returns the value that a write assigns.
fn value(read: &Read, grain: Grain) -> String {
    let low = sentinel::written(read.slot);
    let high = sentinel::written(read.slot + 1);
    let signed = read.scalar.kind == ScalarKind::Sint;
    let ty = Type::Scalar(read.scalar).spelled(Language::Glsl).to_string();
    match kind(read.scalar) {
        Kind::Float => format!("uintBitsToFloat({low}u)"),
        Kind::Half => format!("{ty}(uintBitsToFloat({}u))", half(read.slot)),
        Kind::Narrow => format!("{ty}({}u)", sentinel::grain_written(read.slot, grain)),
        Kind::Whole if signed => format!("int({low}u)"),
        Kind::Whole => format!("{low}u"),
        Kind::Bool => "false".to_string(),
        Kind::Long => format!("{ty}((uint64_t({high}u) << 32) | uint64_t({low}u))"),
        Kind::Double => format!("packDouble2x32(uvec2({low}u, {high}u))"),
    }
}

/// Returns the bits of the 32-bit float with the value that a write assigns to a 16-bit one.
pub(super) fn half(slot: u32) -> u32 {
    let bits = sentinel::grain_written(slot, Grain::Half) as u32;
    // Both are normal; the exponents are biased by 15 and 127.
    (bits & 0x8000) << 16 | (((bits & 0x7FFF) << 13) + ((127 - 15) << 23))
}

/// The category of a component, which determines how its bits are compared.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Float,
    /// A 16-bit float.
    Half,
    /// A 32-bit integer.
    Whole,
    /// An integer of 8 or 16 bits.
    Narrow,
    /// A 64-bit integer.
    Long,
    Bool,
    Double,
}

pub(super) fn kind(scalar: Scalar) -> Kind {
    match (scalar.kind, scalar.width) {
        (ScalarKind::Bool, _) => Kind::Bool,
        (ScalarKind::Sint | ScalarKind::Uint, 8) => Kind::Long,
        (ScalarKind::Sint | ScalarKind::Uint, 1 | 2) => Kind::Narrow,
        (ScalarKind::Sint | ScalarKind::Uint, _) => Kind::Whole,
        (ScalarKind::Float, 8) => Kind::Double,
        (ScalarKind::Float, 2) => Kind::Half,
        _ => Kind::Float,
    }
}
