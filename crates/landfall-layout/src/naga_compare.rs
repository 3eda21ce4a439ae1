//! Comparison of naga's layout with landfall's: where a wgpu program would read each leaf.
//!
//! naga's numbers are never used as the layout; they are recorded on a leaf where they differ. The
//! tests below pin the faults of naga 30.0.1 and fail once one is fixed.

pub mod used;

use naga::{AddressSpace as Space, ArraySize, GlobalVariable, Handle, Module, TypeInner};
use rustc_hash::FxHashMap;

use crate::layout::measure::fixed;
use crate::layout::{BlockLayout, Leaf, MAX_LEAVES, NagaPlace};
use crate::naga_front::{glsl_module, wgsl_module};
use crate::shape::AddressSpace;
use crate::source::{Language, Source, Span};
use crate::syntax::wgsl;

/// Records naga's placement on every leaf where it differs. `bodies` are the insides of functions
/// in the text, which naga need not parse.
pub(crate) fn compare(source: &Source, bodies: &[Span], blocks: &mut [BlockLayout]) {
    if blocks.is_empty() {
        return;
    }
    let module = match source.language {
        // Whole functions are blanked: their parameters and results do not concern any block.
        Language::Wgsl => wgsl_module(&blanked(&source.text, &wgsl::functions(&source.text))),
        Language::Glsl => glsl_module(&blanked(&source.text, bodies), source.stage),
        // wgpu passes a module on, with the offsets that it has.
        Language::SpirV => None,
    };
    let Some(module) = module else { return };
    // A block that naga has no variable for, an unused one, has no second opinion.
    for block in blocks {
        let Some(variable) = variable_of(&module, block) else { continue };
        let ty = module.global_variables[variable].ty;
        let Some(places) = places(&module, ty, block, source.language) else { continue };
        for leaf in &mut block.leaves {
            leaf.naga = places.get(&leaf.path).filter(|place| differs(leaf, place)).cloned();
        }
    }
}

/// Replaces the text in spans by spaces, except for line breaks.
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

/// Returns the variable of a block: by its own name, by its type's, or by its binding.
pub fn variable_of(module: &Module, block: &BlockLayout) -> Option<Handle<GlobalVariable>> {
    let space = |space: &Space| match block.space {
        AddressSpace::Uniform => matches!(space, Space::Uniform),
        AddressSpace::Storage => matches!(space, Space::Storage { .. }),
        AddressSpace::PushConstant => matches!(space, Space::Immediate),
        AddressSpace::BufferReference
        | AddressSpace::ShaderRecord
        | AddressSpace::TaskPayload
        | AddressSpace::Default
        | AddressSpace::Structure => false,
    };
    // In the order of certainty: names are unique, types may be shared, bindings by several blocks.
    let variable = block.instance.as_deref().unwrap_or(&block.name);
    let candidates = || module.global_variables.iter().filter(|(_, v)| space(&v.space));
    let named = candidates().find(|(_, v)| v.name.as_deref() == Some(variable));
    let typed =
        || candidates().find(|(_, v)| module.types[v.ty].name.as_deref() == Some(&*block.name));
    let bound = || {
        let (group, binding) = (block.group.unwrap_or(0), block.binding?);
        candidates()
            .find(|(_, v)| v.binding.is_some_and(|at| (at.group, at.binding) == (group, binding)))
    };
    named.or_else(typed).or_else(bound).map(|(variable, _)| variable)
}

type Places = FxHashMap<String, NagaPlace>;

/// Returns naga's placement of a variable's leaves; `None` if it depends on an override.
fn places(
    module: &Module,
    variable: Handle<naga::Type>,
    block: &BlockLayout,
    language: Language,
) -> Option<Places> {
    let mut ty = variable;
    // naga represents GLSL's array of blocks as one buffer, but not WGSL's `binding_array`.
    for _ in &block.count {
        match module.types[ty].inner {
            TypeInner::Array { base, .. } | TypeInner::BindingArray { base, .. } => ty = base,
            _ => return None,
        }
    }
    let mut places = Places::default();
    let start = NagaPlace { offset: 0, dims: Vec::new(), strides: Vec::new() };
    let path = match (language, &block.instance) {
        // A store type that is not a structure: its one member has the variable's name.
        (Language::Wgsl, None) => block.name.to_string(),
        (Language::Wgsl, Some(_)) | (Language::Glsl | Language::SpirV, _) => String::new(),
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
        // Structures that hold two of the one before have 2^depth leaves.
        _ => {
            if places.len() as u64 >= MAX_LEAVES {
                return None;
            }
            places.insert(path, at);
        }
    }
    Some(())
}

fn differs(leaf: &Leaf, place: &NagaPlace) -> bool {
    let dims = leaf.dims.iter().map(fixed);
    leaf.offset.is_some_and(|offset| {
        offset != place.offset || leaf.strides != place.strides || !dims.eq(place.dims.clone())
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::examples::{array, declared, float, member, structure, vec};
    use crate::layout::lay_out;
    use crate::shape::{Block, Member, Rules};

    /// Returns the leaves of block `B` in a GLSL text that naga places elsewhere than `members`.
    fn asked(text: &str, space: AddressSpace, rules: Rules, members: Vec<Member>) -> Vec<Leaf> {
        let block = Block { space, ..declared("B", rules, members) };
        let mut blocks = [lay_out(&block).expect("the block has a layout")];
        let body = text.find("broken").expect("a body") as u32;
        let body = Span { file: 0, start: body, end: body + 6 };
        compare(&Source::new("a.frag", format!("#version 450\n{text}").as_str()), &[], &mut blocks);
        assert!(blocks[0].leaves.iter().all(|leaf| leaf.naga.is_none()), "a body naga refuses");
        compare(&Source::new("a.frag", text), &[body], &mut blocks);
        let [block] = blocks;
        block.leaves.into_iter().filter(|leaf| leaf.naga.is_some()).collect()
    }

    /// Seen in naga 30.0.1; when this fails, take it out of the list of faults.
    #[test]
    fn naga_swaps_the_dimensions_of_arrays_of_arrays() {
        let differing = asked(
            "layout(std140, binding = 0) uniform B { float f[2][3]; }; void main() { broken }",
            AddressSpace::Uniform,
            Rules::Std140,
            vec![member("f", array(array(float(), 3), 2))],
        );
        assert_eq!((differing.len(), &differing[0].strides[..]), (1, &[48, 16][..]));
        let naga = differing[0].naga.as_ref().expect("it differs");
        assert_eq!((&naga.dims[..], &naga.strides[..]), (&[Some(3), Some(2)][..], &[32, 16][..]));
    }

    /// Seen in naga 30.0.1; when this fails, take it out of the list of faults.
    #[test]
    fn naga_does_not_round_small_structures_in_std140() {
        let inner = structure("S", vec![member("a", float())]);
        let differing = asked(
            "struct S { float a; };
             layout(std140, binding = 0) uniform B { float x; S s; float y; };
             void main() { broken }",
            AddressSpace::Uniform,
            Rules::Std140,
            vec![member("x", float()), member("s", inner), member("y", float())],
        );
        let numbers: Vec<_> = differing
            .iter()
            .map(|leaf| (leaf.offset, leaf.naga.as_ref().map(|place| place.offset)))
            .collect();
        assert_eq!(numbers, [(Some(16), Some(4)), (Some(32), Some(8))]);
    }

    /// Seen in naga 30.0.1; when this fails, take it out of the list of faults.
    #[test]
    fn naga_lays_push_constants_out_in_std140() {
        let differing = asked(
            "layout(push_constant) uniform B { vec2 g; float a[2]; }; void main() { broken }",
            AddressSpace::PushConstant,
            Rules::Std430,
            vec![member("g", vec(2)), member("a", array(float(), 2))],
        );
        assert_eq!((differing[0].offset, &differing[0].strides[..]), (Some(8), &[4][..]));
        let naga = differing[0].naga.as_ref().expect("it differs");
        assert_eq!((naga.offset, &naga.strides[..]), (16, &[16][..]));
    }
}
