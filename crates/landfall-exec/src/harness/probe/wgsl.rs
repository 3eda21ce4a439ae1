//! Adds a probe to a WGSL shader: the user's text unchanged, then an entry point with the reads.
//!
//! Implements a [`Plan`]; the text goes through naga, its offsets replaced by Landfall's, to the
//! interpreter and wgpu.

use std::fmt::Write as _;

use super::glsl::{Kind, NEVER, ProbeSpelling, half, kind, spelled_reads};
use super::plan::{Plan, Read};
use super::sentinel::{self, Grain};
use landfall_layout::layout::{BlockLayout, MemberLayout};
use landfall_layout::shape::{AddressSpace, ScalarKind, Type};
use landfall_layout::source::{ExecutableStage, Language, Source};

/// The name of the added entry point.
pub(crate) const ENTRY: &str = "landfall_probe";

const WGSL: ProbeSpelling = ProbeSpelling { result, value, loaded, copy };

/// Returns the user's text followed by a probe.
pub(crate) fn text(
    source: &Source,
    block: &BlockLayout,
    plan: &Plan,
    stage: ExecutableStage,
) -> String {
    let mut text = source.text.to_string();
    let binding = free_binding(&text);
    let _ = write!(
        text,
        "\n@group(0) @binding({binding}) var<storage, read_write> landfall_words: array<u32>;\n"
    );
    // A plain store type is named as the variable, which its path begins with.
    let root = block.instance.as_ref().map_or(String::new(), |instance| format!("{instance}."));
    let mut body = String::new();
    spelled_reads(&WGSL, &root, &mut text, &mut body, block, plan);
    if stage == ExecutableStage::Fragment {
        let _ = writeln!(body, "    if landfall_words[0] == {NEVER} {{ discard; }}");
    }
    entry(&mut text, ENTRY, stage, &body);
    text
}

/// Appends an entry point of a stage, whose body one invocation runs.
pub(crate) fn entry(text: &mut String, name: &str, stage: ExecutableStage, body: &str) {
    let _ = match stage {
        ExecutableStage::Vertex => writeln!(
            text,
            "@vertex fn {name}() -> @builtin(position) vec4<f32> {{\n{body}    \
             return vec4<f32>(0.0, 0.0, 0.0, 1.0);\n}}"
        ),
        ExecutableStage::Fragment => writeln!(
            text,
            "@fragment fn {name}() -> @location(0) vec4<u32> {{\n{body}    \
             return vec4<u32>(0u);\n}}"
        ),
        ExecutableStage::Compute => {
            writeln!(text, "@compute @workgroup_size(1) fn {name}() {{\n{body}}}")
        }
    };
}

/// Returns a binding of group 0 that no `@binding(` of the text uses.
pub(crate) fn free_binding(text: &str) -> u32 {
    let after = text.split("@binding").skip(1);
    let numbers = after.filter_map(|rest| {
        let rest = rest.trim_start().strip_prefix('(')?.trim_start();
        let end = rest.find(|c: char| !c.is_ascii_digit()).unwrap_or(rest.len());
        rest[..end].parse::<u32>().ok()
    });
    numbers.max().map_or(0, |most| most.saturating_add(1))
}

fn copy(name: &str, member: &MemberLayout, from: Option<&str>, inside: &str) -> String {
    match from {
        Some(from) => format!("fn {name}() {{\n    var landfall_copy = {from};\n{inside}}}"),
        None => {
            let ty = member.ty.innermost().spelled(Language::Wgsl);
            format!("fn {name}(landfall_copy: {ty}) {{\n{inside}}}")
        }
    }
}

/// Returns the read of a value, through `atomicLoad` if it is an atomic.
fn loaded(block: &BlockLayout, read: &Read, from: String) -> String {
    match &block.leaves[read.leaf].ty {
        Type::Atomic(_) if block.space == AddressSpace::Storage => format!("atomicLoad(&{from})"),
        _ => from,
    }
}

fn result(text: &mut String, read: &Read, from: &str) {
    let slot = read.slot;
    let _ = match kind(read.scalar) {
        Kind::Whole if read.scalar.kind == ScalarKind::Uint => {
            writeln!(text, "    landfall_words[{slot}] = {from};")
        }
        Kind::Float | Kind::Whole => {
            writeln!(text, "    landfall_words[{slot}] = bitcast<u32>({from});")
        }
        // The values are exact in 32 bits.
        Kind::Half | Kind::Double => {
            writeln!(text, "    landfall_words[{slot}] = bitcast<u32>(f32({from}));")
        }
        Kind::Narrow => {
            let mask = (1u32 << (u32::from(read.scalar.width) * 8)) - 1;
            writeln!(text, "    landfall_words[{slot}] = u32({from}) & {mask}u;")
        }
        Kind::Long => writeln!(
            text,
            "    landfall_words[{slot}] = u32(u64({from}) & 0xFFFFFFFFlu); \
             landfall_words[{}] = u32(u64({from}) >> 32u);",
            slot + 1
        ),
        // No buffer of WGSL holds one.
        Kind::Bool => writeln!(text, "    landfall_words[{slot}] = select(0u, 1u, {from});"),
    };
}

fn value(read: &Read, grain: Grain) -> String {
    let (low, high) = (sentinel::written(read.slot), sentinel::written(read.slot + 1));
    let signed = read.scalar.kind == ScalarKind::Sint;
    let ty = Type::Scalar(read.scalar).spelled(Language::Wgsl).to_string();
    match kind(read.scalar) {
        Kind::Whole if !signed => format!("{low}u"),
        Kind::Whole => format!("bitcast<i32>({low}u)"),
        Kind::Float => format!("bitcast<f32>({low}u)"),
        Kind::Half => format!("f16(bitcast<f32>({}u))", half(read.slot)),
        Kind::Narrow => format!("{ty}({}u)", sentinel::grain_written(read.slot, grain)),
        Kind::Long => format!("{ty}({}lu)", u64::from(high) << 32 | u64::from(low)),
        // All digits of the `f32`, which the double equals.
        Kind::Double => format!("{:?}lf", f32::from_bits(low)),
        Kind::Bool => "false".to_string(),
    }
}
