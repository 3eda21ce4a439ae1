//! Checks a ported text with naga, and translates it to WGSL. Every member must keep its offset,
//! both in naga's layout and under WGSL's rules.

use crate::diagnostic::Code;

use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};

use crate::naga_front::{caught, is_bounded};
use crate::source::{Language, Source, Span, Stage};
use crate::{BlockLayout, Diagnostic, Leaf, Options, layout};

/// Checks that naga accepts a GLSL text and reads the same offsets.
pub(super) fn check(source: &Source, options: &Options) -> Result<(), Vec<Diagnostic>> {
    let found = layout(source, &Options { naga: true, ..options.clone() });
    let elsewhere = |leaf: &&Leaf| leaf.naga.is_some();
    let leaves = found.blocks.iter().flat_map(|block| &block.leaves);
    let problems: Vec<Diagnostic> = leaves
        .filter(elsewhere)
        .map(|leaf| {
            let at = leaf.naga.as_ref().map_or(0, |place| place.offset);
            moved(&leaf.path, leaf.offset, at, "naga reads")
        })
        .collect();
    if !problems.is_empty() {
        return Err(problems);
    }
    module(source).map(|_| ())
}

/// Translates a text to WGSL.
pub(super) fn write(source: &Source, options: &Options) -> Result<Source, Vec<Diagnostic>> {
    let (module, info) = module(source)?;
    let flags = naga::back::wgsl::WriterFlags::empty();
    let text = naga::back::wgsl::write_string(&module, &info, flags)
        .map_err(|error| vec![refused(&error.to_string())])?;
    let path = std::path::Path::new(&source.path).with_extension("wgsl").display().to_string();
    let wgsl = Source { language: Language::Wgsl, stage: None, ..Source::new(path, text) };
    let problems = differences(&layout(source, options).blocks, &layout(&wgsl, options).blocks);
    if problems.is_empty() { Ok(wgsl) } else { Err(problems) }
}

/// Errors for members that WGSL's rules put elsewhere. naga may rename members, but keeps their
/// order.
fn differences(before: &[BlockLayout], after: &[BlockLayout]) -> Vec<Diagnostic> {
    let mut problems = Vec::new();
    for block in before {
        let same = after.iter().find(|b| b.group == block.group && b.binding == block.binding);
        let Some(same) = same.filter(|same| same.leaves.len() == block.leaves.len()) else {
            problems.push(refused(&format!(
                "naga's WGSL declares block `{}` with other members",
                block.name
            )));
            continue;
        };
        for (leaf, new) in block.leaves.iter().zip(&same.leaves) {
            if leaf.offset != new.offset || leaf.matrix_stride != new.matrix_stride {
                problems.push(moved(&leaf.path, leaf.offset, new.offset.unwrap_or(0), "WGSL puts"));
            } else if leaf.strides != new.strides || leaf.dims != new.dims {
                let message = format!(
                    "the array stride of `{}` is {} bytes, but {} in WGSL",
                    leaf.path,
                    strides(leaf),
                    strides(new)
                );
                problems.push(Diagnostic::error(Code::NotPortable, Span::default(), message));
            }
        }
    }
    problems
}

/// The array strides from the outer to the inner one: `64 and 16`.
fn strides(leaf: &Leaf) -> String {
    let strides: Vec<String> = leaf.strides.iter().map(u64::to_string).collect();
    strides.join(" and ")
}

fn moved(path: &str, ours: Option<u64>, theirs: u64, who: &str) -> Diagnostic {
    let ours = ours.unwrap_or(0);
    let message = format!("`{path}` is at offset {ours}, but {who} it at {theirs}");
    Diagnostic::error(Code::NotPortable, Span::default(), message)
        .with_help("reorder the uniforms, or pad the structure to a multiple of 16 bytes")
}

fn refused(reason: &str) -> Diagnostic {
    let reason = match reason.lines().next().unwrap_or("").trim() {
        // naga 30.0.1 checks functions in the order of their first mention.
        text if text.contains("has not been processed yet") => {
            "a function is called before its body; move it above its callers"
        }
        text => text,
    };
    let message = format!("naga rejects the ported shader: {reason}");
    Diagnostic::error(Code::NotPortable, Span::default(), message)
        .with_note("this is a limit of naga's GLSL front end")
}

fn module(source: &Source) -> Result<(naga::Module, ModuleInfo), Vec<Diagnostic>> {
    let stage = match source.stage {
        Some(Stage::Vertex) => naga::ShaderStage::Vertex,
        Some(Stage::Fragment) => naga::ShaderStage::Fragment,
        Some(Stage::Compute) => naga::ShaderStage::Compute,
        _ => return Err(vec![refused("it supports vertex, fragment and compute shaders only")]),
    };
    if !is_bounded(&source.text) {
        return Err(vec![refused("it is too long, or nested too deeply, for naga")]);
    }
    let read = || {
        let options = naga::front::glsl::Options::from(stage);
        let parsed = naga::front::glsl::Frontend::default().parse(&options, &source.text);
        let module = parsed.map_err(|errors| {
            errors.errors.iter().map(|e| e.kind.to_string()).collect::<Vec<_>>().join("; ")
        })?;
        let mut validator = Validator::new(ValidationFlags::all(), Capabilities::all());
        match validator.validate(&module) {
            Ok(info) => Ok((module, info)),
            Err(error) => Err(causes(error.as_inner())),
        }
    };
    // naga 30.0.1 panics on some texts.
    let result = caught(read).unwrap_or_else(|| Err("it panics".to_string()));
    result.map_err(|reason| vec![refused(&reason)])
}

fn causes(error: &dyn std::error::Error) -> String {
    match error.source() {
        Some(cause) => format!("{error}: {}", causes(cause)),
        None => error.to_string(),
    }
}
