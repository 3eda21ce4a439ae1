//! Writes a lock: JSON that changes only with the layout, one member per line.
//!
//! [`super::read`] reads it back. The keys are those of the layout's JSON, without lines, tools
//! and paths.

mod variants;

use std::fmt::Write as _;

use super::{FIRST_SCHEMA_VERSION, Lock, SCHEMA_VERSION, Verified};
use crate::ShaderLayout;
use crate::layout::{BlockLayout, MemberLayout, targets};
use crate::shape::{AddressSpace, ArrayLen, Type};
use crate::source::Language;
use variants::AllBlocks;

/// The text of a shader's lock, without verified devices.
pub fn write(shader: &ShaderLayout) -> String {
    document(shader, &[])
}

/// The text of a shader's lock that replaces `old`, keeping its verified devices if the layout is
/// unchanged.
pub fn renew(shader: &ShaderLayout, old: Option<&Lock>) -> String {
    // Verified bytes were those of the layout: another layout has not been verified.
    let text = write(shader);
    match old {
        Some(old) if !old.verified.is_empty() && old.text_without_devices() == text => {
            document(shader, &old.verified)
        }
        Some(_) | None => text,
    }
}

pub(super) fn document(shader: &ShaderLayout, verified: &[Verified]) -> String {
    let (all, language) = (AllBlocks::of(shader), shader.language);
    let mut out = Text { text: String::new(), language };
    let name = language.name();
    // A lock without variants is readable by every landfall.
    let version = if all.sets.is_empty() { FIRST_SCHEMA_VERSION } else { SCHEMA_VERSION };
    let _ = write!(out.text, "{{\n  \"schema_version\": {version},\n  \"language\": \"{name}\",\n");
    if let Some(target) = shader.assumed_target {
        let _ = writeln!(out.text, "  \"assumed_target\": \"{}\",", targets::key(target));
    }
    if !all.sets.is_empty() {
        let sets = all.sets.iter().map(|macros| format!("    {}", variants::set(macros)));
        let sets = sets.collect::<Vec<_>>().join(",\n");
        let _ = write!(out.text, "  \"variants\": [\n{sets}\n  ],\n");
    }
    out.text.push_str("  \"blocks\": [");
    for (i, shared) in all.blocks.iter().enumerate() {
        out.text.push_str(if i == 0 { "\n" } else { ",\n" });
        out.block(shared.block, all.having(shared));
    }
    out.text.push_str(if all.blocks.is_empty() { "]" } else { "\n  ]" });
    if !verified.is_empty() {
        out.verified(verified);
    }
    out.text.push_str("\n}\n");
    out.text
}

struct Text {
    text: String,
    language: Language,
}

fn quoted(text: &str) -> String {
    serde_json::to_string(text).expect("a string is always JSON")
}

impl Text {
    /// Writes a block; `having` are the variants that have it, in JSON, unless all have it.
    fn block(&mut self, block: &BlockLayout, having: Option<String>) {
        let mut lines = vec![("name", quoted(&block.name))];
        lines.extend(having.map(|variants| ("variants", variants)));
        lines.extend(block.instance.as_ref().map(|name| ("instance", quoted(name))));
        lines.push(("address_space", quoted(block.space.name())));
        if block.space != AddressSpace::Default {
            lines.push(("rules", quoted(block.rules.name())));
            lines.push(("rules_declared", block.rules_declared.to_string()));
        }
        let numbers =
            [("group", block.group.map(u64::from)), ("binding", block.binding.map(u64::from))];
        lines.extend(numbers.into_iter().filter_map(|(key, n)| Some((key, n?.to_string()))));
        let count = count(&block.count);
        // Most blocks are no arrays, and have no line for it.
        if count != "1" {
            lines.push(("count", count));
        }
        let numbers =
            [("size", block.size), ("data_size", block.data_size), ("align", block.align)];
        lines.extend(numbers.into_iter().filter_map(|(key, n)| Some((key, n?.to_string()))));
        // Each number on a line of its own, each member on one, so that a diff of versions shows
        // what changed.
        self.text.push_str("    {\n");
        for (key, value) in lines {
            let _ = writeln!(self.text, "      \"{key}\": {value},");
        }
        self.text.push_str("      \"members\": ");
        self.members(&block.members, 4);
        self.text.push_str("\n    }");
    }

    fn members(&mut self, members: &[MemberLayout], depth: usize) {
        if members.is_empty() {
            self.text.push_str("[]");
            return;
        }
        self.text.push('[');
        for (i, member) in members.iter().enumerate() {
            self.text.push_str(if i == 0 { "\n" } else { ",\n" });
            self.text.push_str(&"  ".repeat(depth));
            self.member(member, depth);
        }
        self.text.push('\n');
        self.text.push_str(&"  ".repeat(depth - 1));
        self.text.push(']');
    }

    fn member(&mut self, member: &MemberLayout, depth: usize) {
        let ty = quoted(&member.ty.spelled(self.language).to_string());
        let _ = write!(self.text, "{{\"name\": {}, \"type\": {ty}", quoted(&member.name));
        let numbers = [("offset", member.offset), ("size", member.size), ("align", member.align)];
        for (key, number) in numbers {
            if let Some(number) = number {
                let _ = write!(self.text, ", \"{key}\": {number}");
            }
        }
        if !member.strides.is_empty() {
            let strides: Vec<String> = member.strides.iter().map(u64::to_string).collect();
            let _ = write!(self.text, ", \"strides\": [{}]", strides.join(", "));
        }
        if let Some(stride) = member.matrix_stride {
            let _ = write!(self.text, ", \"matrix_stride\": {stride}");
        }
        match member.ty.innermost() {
            Type::Matrix { .. } => {
                let _ = write!(self.text, ", \"row_major\": {}", member.row_major);
            }
            Type::Struct(_) => {
                self.text.push_str(", \"members\": ");
                self.members(&member.members, depth + 1);
            }
            Type::Scalar(_)
            | Type::Atomic(_)
            | Type::Vector { .. }
            | Type::Address(_)
            | Type::Array { .. } => {}
        }
        self.text.push('}');
    }

    fn verified(&mut self, verified: &[Verified]) {
        self.text.push_str(",\n  \"verified\": [");
        for (i, one) in verified.iter().enumerate() {
            self.text.push_str(if i == 0 { "\n" } else { ",\n" });
            let _ = write!(self.text, "    {{\"backend\": {}", quoted(&one.backend));
            let rest =
                [("adapter", &one.adapter), ("driver", &one.driver), ("version", &one.version)];
            for (key, value) in rest {
                let _ = write!(self.text, ", \"{key}\": {}", quoted(value));
            }
            self.text.push('}');
        }
        self.text.push_str("\n  ]");
    }
}

/// The number of buffers of an array of blocks; null if the shader does not specify it.
fn count(dims: &[ArrayLen]) -> String {
    let product = dims.iter().try_fold(1u64, |product, len| match len {
        ArrayLen::Fixed(n) => Some(product.saturating_mul(u64::from(*n))),
        ArrayLen::Runtime | ArrayLen::Override(_) => None,
    });
    product.map_or("null".to_string(), |n| n.to_string())
}
