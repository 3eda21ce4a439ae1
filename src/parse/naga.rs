//! naga's answer beside ours: where a wgpu program would read each leaf.
//!
//! naga's numbers are never taken: they are noted on a leaf where they differ.
//! Its faults as of 30.0.1 are held by the tests below, which fail once one is mended.

use std::panic::{self, AssertUnwindSafe};

use naga::{AddressSpace as Space, ArraySize, Handle, Module, TypeInner};
use rustc_hash::FxHashMap;

use super::wgsl;
use crate::layout::{BlockLayout, Leaf, MOST_LEAVES, NagaPlace};
use crate::shape::{AddressSpace, ArrayLen};
use crate::source::{Language, Source, Span, Stage};

/// naga recurses on nested brackets without a bound of its own; deeper text is not handed to it.
const DEEPEST_BRACKETS: u32 = 64;

/// Longer text is not handed to naga.
const LONGEST_TEXT: usize = 1 << 20;

/// Notes on every leaf what naga says of it, where it has an answer that differs.
/// `bodies` are the insides of functions in the text: naga need not understand them.
pub(crate) fn ask(source: &Source, bodies: &[Span], blocks: &mut [BlockLayout]) {
    if blocks.is_empty() {
        return;
    }
    let module = match source.language {
        // A whole function goes: what it takes and returns does not concern any block.
        Language::Wgsl => wgsl_module(&blanked(&source.text, &wgsl::functions(&source.text))),
        Language::Glsl => glsl_module(&blanked(&source.text, bodies), source.stage),
    };
    let Some(module) = module else { return };
    for block in blocks {
        let Some(variable) = variable_of(&module, block) else { continue };
        let Some(places) = places(&module, variable, block, source.language) else { continue };
        for leaf in &mut block.leaves {
            leaf.naga = places.get(&leaf.path).filter(|place| differs(leaf, place)).cloned();
        }
    }
}

/// The number of elements of the array type of that name in a WGSL text, if naga takes the text.
pub(crate) fn array_length(text: &str, name: &str) -> Option<u32> {
    let module = wgsl_module(text)?;
    let mut types = module.types.iter().map(|(_, ty)| ty);
    match types.find(|ty| ty.name.as_deref() == Some(name))?.inner {
        TypeInner::Array { size: ArraySize::Constant(length), .. } => Some(length.get()),
        _ => None,
    }
}

/// The text with spaces for everything in those spans but line breaks.
fn blanked(text: &str, spans: &[Span]) -> String {
    let mut result = String::with_capacity(text.len());
    let mut at = 0;
    for span in spans.iter().filter(|span| span.file == 0) {
        let (start, end) = (span.start as usize, span.end as usize);
        let (Some(before), Some(inside)) = (text.get(at..start), text.get(start..end)) else {
            continue;
        };
        result.push_str(before);
        result.extend(inside.bytes().map(|b| if b == b'\n' { '\n' } else { ' ' }));
        at = end;
    }
    result.push_str(&text[at..]);
    result
}

fn wgsl_module(text: &str) -> Option<Module> {
    guarded(text, || naga::front::wgsl::parse_str(text).ok())
}

fn glsl_module(text: &str, stage: Option<Stage>) -> Option<Module> {
    let stage = match stage {
        Some(Stage::Vertex) | None => naga::ShaderStage::Vertex,
        Some(Stage::Fragment) => naga::ShaderStage::Fragment,
        Some(Stage::Compute) => naga::ShaderStage::Compute,
        Some(
            Stage::TessellationControl
            | Stage::TessellationEvaluation
            | Stage::Geometry
            | Stage::Task
            | Stage::Mesh
            | Stage::RayGeneration
            | Stage::Intersection
            | Stage::AnyHit
            | Stage::ClosestHit
            | Stage::Miss
            | Stage::Callable,
        ) => return None,
    };
    let options = naga::front::glsl::Options::from(stage);
    guarded(text, || naga::front::glsl::Frontend::default().parse(&options, text).ok())
}

/// Runs a front end on text it can be trusted with; a panic in it counts as no answer.
fn guarded(text: &str, parse: impl FnOnce() -> Option<Module>) -> Option<Module> {
    if text.len() > LONGEST_TEXT || nesting(text) > DEEPEST_BRACKETS {
        return None;
    }
    // naga 30.0.1 panics on GLSL's `float a[1000000000][8]`.
    panic::catch_unwind(AssertUnwindSafe(parse)).ok().flatten()
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

/// The variable of a block: by its own name, by its type's, or by where it is bound.
fn variable_of(module: &Module, block: &BlockLayout) -> Option<Handle<naga::Type>> {
    let space = |space: &Space| match block.space {
        AddressSpace::Uniform => matches!(space, Space::Uniform),
        AddressSpace::Storage => matches!(space, Space::Storage { .. }),
        AddressSpace::PushConstant => matches!(space, Space::Immediate),
        AddressSpace::BufferReference | AddressSpace::ShaderRecord | AddressSpace::Default => false,
    };
    let variable = block.instance.as_deref().unwrap_or(&block.name);
    let candidates = || module.global_variables.iter().map(|(_, v)| v).filter(|v| space(&v.space));
    let named = candidates().find(|v| v.name.as_deref() == Some(variable));
    let typed = || candidates().find(|v| module.types[v.ty].name.as_deref() == Some(&*block.name));
    let bound = || {
        let (group, binding) = (block.group.unwrap_or(0), block.binding?);
        candidates()
            .find(|v| v.binding.is_some_and(|at| (at.group, at.binding) == (group, binding)))
    };
    named.or_else(typed).or_else(bound).map(|variable| variable.ty)
}

type Places = FxHashMap<String, NagaPlace>;

/// Where naga puts the leaves of a variable; `None` where it waits for an override.
fn places(
    module: &Module,
    variable: Handle<naga::Type>,
    block: &BlockLayout,
    language: Language,
) -> Option<Places> {
    let mut ty = variable;
    // GLSL's array of blocks is one buffer to naga; WGSL's `binding_array` is none.
    for _ in &block.count {
        match module.types[ty].inner {
            TypeInner::Array { base, .. } | TypeInner::BindingArray { base, .. } => ty = base,
            _ => return None,
        }
    }
    let mut places = Places::default();
    let start = NagaPlace { offset: 0, dims: Vec::new(), strides: Vec::new() };
    let path = match (language, &block.instance) {
        // A store type that is no structure: its one member is named as the variable.
        (Language::Wgsl, None) => block.name.to_string(),
        (Language::Wgsl, Some(_)) | (Language::Glsl, _) => String::new(),
    };
    walk(module, ty, path, start, &mut places)?;
    Some(places)
}

fn walk(
    module: &Module,
    ty: Handle<naga::Type>,
    mut path: String,
    mut at: NagaPlace,
    places: &mut Places,
) -> Option<()> {
    match &module.types[ty].inner {
        TypeInner::Struct { members, .. } => {
            for member in members {
                let dot = if path.is_empty() { "" } else { "." };
                let path = format!("{path}{dot}{}", member.name.as_deref().unwrap_or(""));
                let at = NagaPlace { offset: at.offset + u64::from(member.offset), ..at.clone() };
                walk(module, member.ty, path, at, places)?;
            }
        }
        TypeInner::Array { base, size, stride } => {
            path.push_str("[]");
            at.dims.push(match size {
                ArraySize::Constant(length) => Some(u64::from(length.get())),
                ArraySize::Dynamic => None,
                // Its length, and every offset after it, are known only to a pipeline.
                ArraySize::Pending(_) => return None,
            });
            at.strides.push(u64::from(*stride));
            walk(module, *base, path, at, places)?;
        }
        _ => {
            if places.len() as u64 >= MOST_LEAVES {
                return None;
            }
            places.insert(path, at);
        }
    }
    Some(())
}

fn differs(leaf: &Leaf, place: &NagaPlace) -> bool {
    let dims = leaf.dims.iter().map(|len| match len {
        ArrayLen::Fixed(length) => Some(u64::from(*length)),
        ArrayLen::Runtime | ArrayLen::Override(_) => None,
    });
    leaf.offset.is_some_and(|offset| {
        offset != place.offset || leaf.strides != place.strides || !dims.eq(place.dims.clone())
    })
}
