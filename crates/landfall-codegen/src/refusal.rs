//! What an output leaves out of shaders: blocks that its language cannot mirror, and constants of two
//! values.

use landfall_layout::diagnostic::{Code, Diagnostic};
use landfall_layout::layout::{BlockLayout, MemberLayout};
use landfall_layout::shape::{ArrayLen, Type};
use landfall_layout::source::{Language, Span};
use landfall_layout::{AddressSpace, ShaderLayout};

/// Why a block is left out.
pub(super) struct Refusal {
    pub span: Span,
    pub why: String,
}

impl Refusal {
    /// Refuses a block without a layout, or with a size that a constant without a value decides.
    pub fn check(block: &BlockLayout) -> Result<(), Refusal> {
        if block.size.is_none() {
            return Err(Refusal { span: block.span, why: "it has no layout".to_string() });
        }
        for leaf in &block.leaves {
            let unknown = leaf.dims.iter().find_map(|len| match len {
                ArrayLen::Fixed(_) | ArrayLen::Runtime => None,
                ArrayLen::Override(name) => Some(name),
            });
            if let Some(name) = unknown {
                let why =
                    format!("the size of `{}` depends on `{name}`, which has no value", leaf.path);
                return Err(Refusal { span: leaf.span, why });
            }
        }
        Ok(())
    }

    /// The error for a block that is left out of an output, "C header".
    pub fn diagnostic(
        self,
        code: Code,
        output: &str,
        block: &BlockLayout,
        shader: &ShaderLayout,
    ) -> Diagnostic {
        let message = format!("block `{}` is left out of the {output}: {}", block.name, self.why);
        of_shader(Diagnostic::error(code, self.span, message), shader)
    }
}

/// A diagnostic about a shader, whose text may be no text.
pub(super) fn of_shader(found: Diagnostic, shader: &ShaderLayout) -> Diagnostic {
    match shader.language {
        Language::SpirV => found.of_binary(&shader.path),
        Language::Glsl | Language::Wgsl => Diagnostic { path: Some(shader.path.clone()), ..found },
    }
}

/// The blocks of shaders, each with its shader, without loose uniforms, which have no bytes.
pub(super) fn blocks<'s>(
    shaders: &[&'s ShaderLayout],
) -> impl Iterator<Item = (&'s ShaderLayout, &'s BlockLayout)> {
    let all = shaders.iter().flat_map(|shader| shader.blocks.iter().map(|block| (*shader, block)));
    all.filter(|(_, block)| block.space != AddressSpace::Default)
}

/// The constants of shaders that lengths are written with, by their names in a language; one that
/// has several values is left out.
pub(super) fn length_constants(
    shaders: &[&ShaderLayout],
    name: impl Fn(&str) -> String,
) -> Vec<(String, u32)> {
    let mut values: Vec<(String, Option<u32>)> = Vec::new();
    for constant in shaders.iter().flat_map(|shader| &shader.constants) {
        let name = name(&constant.name);
        match values.iter_mut().find(|(known, _)| *known == name) {
            // A name with two values has none.
            Some((_, value)) => *value = value.filter(|value| *value == constant.value),
            None => values.push((name, Some(constant.value))),
        }
    }
    values.into_iter().filter_map(|(name, value)| Some((name, value?))).collect()
}

/// The names of all blocks and of the structures in them, for suggestions.
pub(super) fn declared_names<'s>(shaders: &[&'s ShaderLayout]) -> Vec<&'s str> {
    fn structures<'s>(members: &'s [MemberLayout], names: &mut Vec<&'s str>) {
        for member in members {
            if let Type::Struct(structure) = member.ty.innermost() {
                names.push(&structure.name);
                structures(&member.members, names);
            }
        }
    }
    let mut names: Vec<&str> = Vec::new();
    for block in shaders.iter().flat_map(|shader| &shader.blocks) {
        names.push(&block.name);
        structures(&block.members, &mut names);
    }
    names
}
