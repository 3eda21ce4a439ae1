//! Modules from naga's own front ends: WGSL with Landfall's offsets, and both languages with
//! naga's.
//!
//! Feeds [`module`](super::module). naga 30.0.1 ignores `@align` on the members of a nested
//! structure (gfx-rs/wgpu#4377), so offsets, strides and sizes are always replaced.

use landfall_layout::diagnostic::Code;

use naga::{Handle, TypeInner};
use rustc_hash::FxHashMap;

use super::module::{Bases, Module, ModuleBlock};
use landfall_layout::layout::MemberLayout;
use landfall_layout::shape::Type;
use landfall_layout::source::{Files, Language, Source, Span, Stage};
use landfall_layout::{BlockLayout, Diagnostic, Options, Severity, ShaderLayout, layout};
use landfall_layout::{naga_compare::variable_of, naga_front};

/// Lowers a WGSL shader with naga's front end and Landfall's layout of its blocks.
pub(super) fn patched(source: &Source, options: &Options) -> Result<Module, Vec<Diagnostic>> {
    // Errors of the layout come first: their spans and texts are Landfall's.
    let laid_out = layout(source, &options.clone().with_naga(false));
    if laid_out.has_errors() {
        let errors = laid_out.diagnostics.into_iter().filter(|d| d.severity == Severity::Error);
        return Err(errors.collect());
    }
    let ir = parse(source, options)?;
    Ok(with_layout(ir, laid_out, options))
}

/// Gives naga's module the offsets, strides and sizes of Landfall's layout of the same text.
pub(super) fn with_layout(
    mut ir: naga::Module,
    laid_out: ShaderLayout,
    options: &Options,
) -> Module {
    // Offsets are collected for all blocks, then applied at once: blocks share types.
    let mut wanted = WantedLayout::default();
    let mut blocks = Vec::new();
    for block in laid_out.blocks {
        let Some(variable) = variable_of(&ir, &block) else { continue };
        let ty = ir.global_variables[variable].ty;
        collect_block(&ir, ty, &block, &mut wanted);
        blocks.push(module_block(&ir, block, variable));
    }
    apply(&mut ir, &wanted);
    set_overrides(&mut ir, &options.read.overrides);
    Module::unvalidated(ir, laid_out.files, blocks)
}

/// Returns the module as naga's front end makes it.
pub(super) fn by_naga(source: &Source, options: &Options) -> Result<Module, Vec<Diagnostic>> {
    let ir = parse(source, options)?;
    let laid_out = layout(source, &options.clone().with_naga(false));
    let mut blocks = Vec::new();
    for block in laid_out.blocks {
        let Some(variable) = variable_of(&ir, &block) else { continue };
        blocks.push(module_block(&ir, block, variable));
    }
    Ok(Module::unvalidated(ir, laid_out.files, blocks))
}

fn module_block(
    ir: &naga::Module,
    layout: BlockLayout,
    variable: Handle<naga::GlobalVariable>,
) -> ModuleBlock {
    let at = ir.global_variables[variable].binding;
    let (group, binding) = at.map_or((0, 0), |at| (at.group, at.binding));
    ModuleBlock { layout, group, binding, element: None, variable }
}

fn parse(source: &Source, options: &Options) -> Result<naga::Module, Vec<Diagnostic>> {
    let text = &*source.text;
    let files = Files::from_source(source);
    let bases = Bases::new(&files);
    let refused = |span: Option<naga::Span>, message: String| {
        let range = span.and_then(|span| span.to_range());
        let span = range.map(|range| Span {
            file: 0,
            start: range.start as u32 - bases.starts[0],
            end: range.end as u32 - bases.starts[0],
        });
        vec![Diagnostic::error(Code::CannotRun, span.unwrap_or_default(), message)]
    };
    // naga recurses without a limit: a text that nests too deeply would overflow the stack.
    if let Some(excess) = naga_front::excess(text, source.language) {
        return Err(refused(None, format!("the shader {excess}")));
    }
    if let Some(error) = source.without_text() {
        return Err(vec![error.into()]);
    }
    let result = naga_front::caught(|| match source.language {
        Language::Wgsl => naga::front::wgsl::parse_str(text).map_err(|error| {
            let span = error.labels().next().map(|(span, _)| span);
            refused(span, format!("naga: {}", error.message()))
        }),
        Language::Glsl | Language::SpirV => {
            let stage = match source.stage {
                Some(Stage::Fragment) => naga::ShaderStage::Fragment,
                Some(Stage::Compute) => naga::ShaderStage::Compute,
                _ => naga::ShaderStage::Vertex,
            };
            let mut given = naga::front::glsl::Options::from(stage);
            given.defines = options.read.defines.iter().cloned().collect();
            naga::front::glsl::Frontend::default().parse(&given, text).map_err(|errors| {
                let each = errors.errors.iter();
                each.flat_map(|e| refused(Some(e.meta), format!("naga: {}", e.kind))).collect()
            })
        }
    });
    // naga 30.0.1 panics on GLSL's `float a[1000000000][8]`.
    result.unwrap_or_else(|| Err(refused(None, "naga panicked on this shader".to_string())))
}

/// Sets the overrides to the values of `-O`, as their initialisers.
fn set_overrides(ir: &mut naga::Module, given: &[(String, String)]) {
    let handles: Vec<_> = ir.overrides.iter().map(|(handle, _)| handle).collect();
    for handle in handles {
        let known = &ir.overrides[handle];
        let id = known.id.map(|id| id.to_string());
        let named = |key: &String| Some(key) == known.name.as_ref() || Some(key) == id.as_ref();
        let Some((_, text)) = given.iter().rev().find(|(key, _)| named(key)) else { continue };
        let TypeInner::Scalar(scalar) = ir.types[known.ty].inner else { continue };
        // `-O count=4u` is as WGSL writes it.
        let text = text.trim().trim_end_matches(['u', 'i', 'f', 'h']);
        let literal = match (scalar.kind, scalar.width) {
            (naga::ScalarKind::Bool, _) => text.parse().ok().map(naga::Literal::Bool),
            (naga::ScalarKind::Sint, 4) => text.parse().ok().map(naga::Literal::I32),
            (naga::ScalarKind::Uint, 4) => text.parse().ok().map(naga::Literal::U32),
            (naga::ScalarKind::Float, 4) => text.parse().ok().map(naga::Literal::F32),
            (naga::ScalarKind::Float, 8) => text.parse().ok().map(naga::Literal::F64),
            _ => None,
        };
        let Some(literal) = literal else { continue };
        let expression = naga::Expression::Literal(literal);
        let value = ir.global_expressions.append(expression, naga::Span::UNDEFINED);
        ir.overrides[handle].init = Some(value);
    }
}

/// The offsets, strides and sizes for types.
#[derive(Default)]
struct WantedLayout {
    offsets: FxHashMap<Handle<naga::Type>, (Vec<u32>, Option<u32>)>,
    strides: FxHashMap<Handle<naga::Type>, u32>,
}

fn collect_block(
    ir: &naga::Module,
    ty: Handle<naga::Type>,
    block: &BlockLayout,
    wanted: &mut WantedLayout,
) {
    match &ir.types[ty].inner {
        // naga has as many members as the layout where the variable is the structure.
        TypeInner::Struct { members, .. } if members.len() == block.members.len() => {
            let size = block.size.and_then(|size| u32::try_from(size).ok());
            collect_members(ir, ty, &block.members, size, wanted);
        }
        // A variable that is no structure: its one member is the variable.
        _ => {
            if let [member] = &block.members[..] {
                collect(ir, ty, &member.ty, member, 0, wanted);
            }
        }
    }
}

fn collect_members(
    ir: &naga::Module,
    ty: Handle<naga::Type>,
    layouts: &[MemberLayout],
    size: Option<u32>,
    wanted: &mut WantedLayout,
) {
    let TypeInner::Struct { members, .. } = &ir.types[ty].inner else { return };
    let offsets: Option<Vec<u32>> =
        layouts.iter().map(|l| l.offset.and_then(|o| u32::try_from(o).ok())).collect();
    let Some(offsets) = offsets.filter(|offsets| offsets.len() == members.len()) else { return };
    for (member, layout) in members.iter().zip(layouts) {
        collect(ir, member.ty, &layout.ty, layout, 0, wanted);
    }
    wanted.offsets.insert(ty, (offsets, size));
}

fn collect(
    ir: &naga::Module,
    ty: Handle<naga::Type>,
    shape: &Type,
    layout: &MemberLayout,
    dim: usize,
    wanted: &mut WantedLayout,
) {
    match (&ir.types[ty].inner, shape) {
        (TypeInner::Array { base, .. }, Type::Array { element, .. }) => {
            collect(ir, *base, element, layout, dim + 1, wanted);
            if let Some(stride) = layout.strides.get(dim).and_then(|s| u32::try_from(*s).ok()) {
                wanted.strides.insert(ty, stride);
            }
        }
        (TypeInner::Struct { .. }, Type::Struct(_)) => {
            // An element of an array ends where the next begins.
            let size = layout.strides.last().copied().or(layout.size);
            let size = size.and_then(|size| u32::try_from(size).ok());
            collect_members(ir, ty, &layout.members, size, wanted);
        }
        _ => {}
    }
}

/// Replaces the offsets, strides and sizes of types in place, so that handles stay valid.
fn apply(ir: &mut naga::Module, wanted: &WantedLayout) {
    let handles: Vec<Handle<naga::Type>> = ir.types.iter().map(|(handle, _)| handle).collect();
    for handle in handles {
        let mut ty = ir.types[handle].clone();
        match &mut ty.inner {
            TypeInner::Struct { members, span } => {
                let Some((offsets, size)) = wanted.offsets.get(&handle) else { continue };
                for (member, offset) in members.iter_mut().zip(offsets) {
                    member.offset = *offset;
                }
                *span = size.unwrap_or(*span);
            }
            TypeInner::Array { stride, .. } => {
                let Some(wants) = wanted.strides.get(&handle) else { continue };
                *stride = *wants;
            }
            _ => continue,
        }
        if ir.types[handle] == ty {
            continue;
        }
        // naga merges two types of the same content: a name keeps them apart.
        // A name that no other type of this content has.
        while ir.types.get(&ty).is_some() {
            ty.name = Some(format!("{}_", ty.name.unwrap_or_default()));
        }
        ir.types.replace(handle, ty);
    }
}
