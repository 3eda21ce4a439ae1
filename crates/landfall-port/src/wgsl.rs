//! Checks a ported text with naga, and translates it to WGSL. Every member must keep its offset,
//! both in naga's layout and under WGSL's rules.

use landfall_layout::diagnostic::Code;
use naga::Statement;
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};

use super::shader::{self, Shader, refusal};
use super::uniformity::{Operation, non_uniform};
use landfall_layout::naga_front::{caught, causes, excess};
use landfall_layout::shape::Type;
use landfall_layout::source::{Language, Source, Span, Stage};
use landfall_layout::syntax::glsl::types::{Builtin, builtin};
use landfall_layout::{BlockLayout, Diagnostic, Leaf, Options, layout};

/// Checks that naga accepts a GLSL text and reads the same offsets.
pub(super) fn check(source: &Source, options: &Options) -> Result<(), Vec<Diagnostic>> {
    // Leaves that naga places elsewhere have its place beside theirs.
    let found = layout(source, &options.clone().with_naga(true));
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

/// Refuses types that WGSL lacks; naga writes those of its own extensions.
pub(super) fn refuse(shader: &Shader<'_>) -> Result<(), Vec<Diagnostic>> {
    let wide = |word: &str| match builtin(word) {
        Some(Builtin::Data(
            Type::Scalar(scalar) | Type::Vector { scalar, .. } | Type::Matrix { scalar, .. },
        )) => scalar.width == 8,
        _ => false,
    };
    let Some(at) = shader.code.iter().position(|token| wide(token.text)) else { return Ok(()) };
    let message = format!("WGSL has no `{}`", shader.code[at].text);
    let problem = refusal(shader.span(at), message);
    Err(vec![problem.with_help("use `float`, `int` or `uint`")])
}

/// Translates a text to WGSL.
pub(super) fn write(
    source: &Source,
    options: &Options,
    warnings: &mut Vec<Diagnostic>,
) -> Result<Source, Vec<Diagnostic>> {
    let (mut module, info) = module(source)?;
    // Before naga writes them: wgpu refuses the shader otherwise, at places of a text that nobody
    // wrote.
    let apart = non_uniform(&module);
    let barriers: Vec<Diagnostic> = apart
        .iter()
        .filter(|(operation, _)| *operation == Operation::Barrier)
        .map(|(_, span)| {
            let message = "only some invocations of a workgroup may arrive at this barrier";
            refusal(place(*span), message)
                .with_note("WGSL refuses a barrier in non-uniform control flow")
                .with_help("move it out of the branch, or branch on uniforms and constants only")
        })
        .collect();
    if !barriers.is_empty() {
        return Err(barriers);
    }
    let sampled = apart.iter().map(|(_, span)| {
        let message = "the derivatives of this operation are undefined where only some fragments \
                       of a quad arrive";
        Diagnostic::warning(Code::NotPortable, place(*span), message)
            .with_note("WGSL refuses that unless `diagnostic(off, derivative_uniformity)` is set")
            .with_help("move it out of the branch, or give the level by `textureLod`")
    });
    warnings.extend(sampled);
    for (_, function) in module.functions.iter_mut() {
        plain_barriers(&mut function.body);
    }
    let flags = naga::back::wgsl::WriterFlags::empty();
    let mut text = naga::back::wgsl::write_string(&module, &info, flags)
        .map_err(|error| vec![refused(&error.to_string(), falls_through(&module))])?;
    // The warnings were given: the directive lets WGSL's compilers accept the operations as GLSL
    // does.
    if !warnings.is_empty() {
        text.insert_str(0, "diagnostic(off, derivative_uniformity);\n\n");
    }
    let path = std::path::Path::new(&source.path).with_extension("wgsl").display().to_string();
    let wgsl = Source { language: Language::Wgsl, stage: None, ..Source::new(path, text) };
    // naga writes structures with its own offsets, which WGSL's rules have to give again.
    let problems = differences(&layout(source, options).blocks, &layout(&wgsl, options).blocks);
    if problems.is_empty() { Ok(wgsl) } else { Err(problems) }
}

/// Restricts barriers to buffers and shared variables: naga 30.0.1 reads `barrier()` as one of
/// subgroups and textures, too, and WGSL has neither without extensions.
fn plain_barriers(block: &mut naga::Block) {
    for (statement, _) in block.span_iter_mut() {
        match statement {
            Statement::ControlBarrier(kinds) | Statement::MemoryBarrier(kinds) => {
                *kinds &= naga::Barrier::STORAGE | naga::Barrier::WORK_GROUP;
            }
            Statement::Block(block) => plain_barriers(block),
            Statement::If { accept, reject, .. } => {
                plain_barriers(accept);
                plain_barriers(reject);
            }
            Statement::Switch { cases, .. } => {
                cases.iter_mut().for_each(|case| plain_barriers(&mut case.body));
            }
            Statement::Loop { body, continuing, .. } => {
                plain_barriers(body);
                plain_barriers(continuing);
            }
            _ => {}
        }
    }
}

/// Returns the place of the first `switch` with a case that goes on to the next, which naga does
/// not write.
fn falls_through(module: &naga::Module) -> Span {
    fn inside(block: &naga::Block) -> Option<naga::Span> {
        block.span_iter().find_map(|(statement, span)| match statement {
            Statement::Switch { cases, .. } => {
                let falls = |case: &naga::SwitchCase| case.fall_through && !case.body.is_empty();
                let within = || cases.iter().find_map(|case| inside(&case.body));
                if cases.iter().any(falls) { Some(*span) } else { within() }
            }
            Statement::Block(block) => inside(block),
            Statement::If { accept, reject, .. } => inside(accept).or_else(|| inside(reject)),
            Statement::Loop { body, continuing, .. } => inside(body).or_else(|| inside(continuing)),
            _ => None,
        })
    }
    let found = module.functions.iter().find_map(|(_, function)| inside(&function.body));
    found.map_or(Span::default(), place)
}

fn place(span: naga::Span) -> Span {
    shader::span(span.to_range().unwrap_or(0..0))
}

/// Errors for members that WGSL's rules put elsewhere. naga may rename members, but keeps their
/// order.
fn differences(before: &[BlockLayout], after: &[BlockLayout]) -> Vec<Diagnostic> {
    let mut problems = Vec::new();
    for block in before {
        let same = after.iter().find(|b| b.group == block.group && b.binding == block.binding);
        let Some(same) = same.filter(|same| same.leaves.len() == block.leaves.len()) else {
            let message = format!("naga's WGSL declares block `{}` with other members", block.name);
            problems.push(refused(&message, Span::default()));
            continue;
        };
        for (leaf, new) in block.leaves.iter().zip(&same.leaves) {
            if leaf.offset != new.offset || leaf.matrix_stride != new.matrix_stride {
                problems.push(moved(&leaf.path, leaf.offset, new.offset.unwrap_or(0), "WGSL puts"));
            } else if leaf.strides != new.strides || leaf.dims != new.dims {
                let (path, ours, wgsl) = (&leaf.path, strides(leaf), strides(new));
                let message = match (ours.as_str(), wgsl.as_str()) {
                    ("", _) => format!("`{path}` is no array, but one in naga's WGSL"),
                    (_, "") => format!("`{path}` is an array, but none in naga's WGSL"),
                    _ => {
                        format!("the array stride of `{path}` is {ours} bytes, but {wgsl} in WGSL")
                    }
                };
                problems.push(about(path, message));
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
    about(path, message)
        .with_help("reorder the uniforms, or pad the structure to a multiple of 16 bytes")
}

/// An error about a member, whose declaration is looked up later.
fn about(path: &str, message: String) -> Diagnostic {
    Diagnostic { about: path.to_string(), ..refusal(Span::default(), message) }
}

fn refused(reason: &str, at: Span) -> Diagnostic {
    let reason = match reason.lines().next().unwrap_or("").trim() {
        // naga 30.0.1 checks functions in the order of their first mention.
        text if text.contains("has not been processed yet") => {
            "a function is called before its body; move it above its callers"
        }
        text => text,
    };
    let message = format!("naga rejects the ported shader: {reason}");
    refusal(at, message).with_note("this is a limit of naga's GLSL front end")
}

fn module(source: &Source) -> Result<(naga::Module, ModuleInfo), Vec<Diagnostic>> {
    let stage = match source.stage {
        Some(Stage::Vertex) => naga::ShaderStage::Vertex,
        Some(Stage::Fragment) => naga::ShaderStage::Fragment,
        Some(Stage::Compute) => naga::ShaderStage::Compute,
        _ => {
            let reason = "it supports vertex, fragment and compute shaders only";
            return Err(vec![refused(reason, Span::default())]);
        }
    };
    // Nesting that would overflow naga's stack.
    if let Some(excess) = excess(&source.text, Language::Glsl) {
        return Err(vec![refused(&format!("it {excess}"), Span::default())]);
    }
    let read = || {
        let options = naga::front::glsl::Options::from(stage);
        let parsed = naga::front::glsl::Frontend::default().parse(&options, &source.text);
        let module = parsed.map_err(|errors| {
            let each = errors.errors.iter().map(|e| refused(&e.kind.to_string(), place(e.meta)));
            let mut all: Vec<Diagnostic> = each.collect();
            all.dedup();
            all
        })?;
        let mut validator = Validator::new(ValidationFlags::all(), Capabilities::all());
        match validator.validate(&module) {
            Ok(info) => Ok((module, info)),
            Err(error) => {
                let at = error.spans().next().map_or(Span::default(), |(span, _)| place(*span));
                Err(vec![refused(&causes(error.as_inner()), at)])
            }
        }
    };
    // naga 30.0.1 panics on some texts.
    caught(read).unwrap_or_else(|| Err(vec![refused("it panics", Span::default())]))
}
