//! Layouts as a C11 and C++17 header: structures with explicit padding that the
//! compiler holds to the shader's offsets, offset macros, and a table of names.
//!
//! `types` (with `plain`) says what C declares a member as and keeps each
//! structure once, `structs` writes them, `table` writes macros and the
//! table of a block, `reach` knows the way to each leaf, `names` makes
//! identifiers of shader names, and `prelude` is what all headers share.

mod comments;
mod names;
mod plain;
mod prelude;
mod reach;
mod structs;
mod table;
mod types;

use crate::layout::BlockLayout;
use crate::shape::{AddressSpace, ArrayLen};
use crate::{Diagnostic, ShaderLayout};
use names::Names;
use types::{Refusal, Types};

/// How a header is written.
#[derive(Clone, Debug, Default)]
pub struct COptions {
    /// The header's file name, from which its include guard is made: `lights.h`.
    pub file: String,
    /// Put before every type, macro and function: `engine_` gives `engine_PointLight`
    /// and `ENGINE_POINT_LIGHT_BLOCK_SIZE`.
    pub prefix: String,
}

/// A header, and what it lacks.
#[derive(Clone, Debug)]
pub struct COutput {
    /// The text of the header.
    pub text: String,
    /// How C reaches each leaf of each block in the header.
    pub leaves: Vec<CLeaf>,
    /// One finding for every block that no C structure can mirror; the rest is in the text.
    pub diagnostics: Vec<Diagnostic>,
}

/// How C reaches a leaf.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CLeaf {
    /// The block's name in the shader.
    pub block: String,
    /// The name its macros begin with: `POINT_LIGHT_BLOCK`.
    pub macros: String,
    /// The macro of its offset: `POINT_LIGHT_BLOCK_DATA_POS_OFFSET`; takes the indices, if any.
    pub offset: String,
    /// The block's function from a path to an offset: `point_light_block_lookup`.
    pub lookup: String,
    /// The structure of the block; `None` when the block is a runtime-sized array only.
    pub structure: Option<String>,
    /// The leaf's path in the shader: `data[].pos`.
    pub path: String,
    /// From a structure to the leaf, indices left out: `.data[].pos`, `.weights[].value`.
    /// Below a runtime-sized tail: from an element of the tail.
    pub access: String,
    /// For a leaf of a runtime-sized tail, the function that finds the tail's elements.
    pub tail: Option<String>,
}

/// Writes one header for the blocks of some shaders. Loose uniforms have no offsets and are
/// passed over; lay the shader out with `gather` to have them.
pub fn c(shaders: &[&ShaderLayout], options: &COptions) -> COutput {
    let mut names = Names::new(&options.prefix, shaders);
    let mut types = Types::default();
    let mut sections: Vec<table::Section> = Vec::new();
    let mut earlier = table::Earlier::default();
    let mut leaves = Vec::new();
    let mut diagnostics = Vec::new();
    for shader in shaders {
        for block in shader.blocks.iter().filter(|b| b.space != AddressSpace::Default) {
            let mark = types.mark();
            let mirror = check(block).and_then(|()| types.block(block, shader, &mut names));
            match mirror {
                Ok(mirror) => {
                    if let Some(section) =
                        table::section(block, shader, &mirror, &mut earlier, &mut names)
                    {
                        leaves.extend(mirror.c_leaves(block, &section, &types));
                        sections.push(section);
                    }
                }
                Err(refusal) => {
                    types.roll_back(mark, &mut names);
                    let diagnostic = refusal.diagnostic(block, shader);
                    diagnostics.push(Diagnostic { path: Some(shader.path.clone()), ..diagnostic });
                }
            }
        }
    }
    let text = structs::header(shaders, options, &types, &sections, &names);
    COutput { text, leaves, diagnostics }
}

/// What no C structure can be, seen from the block alone.
fn check(block: &BlockLayout) -> Result<(), Refusal> {
    if block.size.is_none() {
        return Err(Refusal { span: block.span, why: "it has no layout".to_string() });
    }
    for leaf in &block.leaves {
        let open = leaf.dims.iter().find_map(|len| match len {
            ArrayLen::Fixed(_) | ArrayLen::Runtime => None,
            ArrayLen::Override(name) => Some(name),
        });
        if let Some(name) = open {
            let why =
                format!("the size of `{}` depends on `{name}`, which has no value", leaf.path);
            return Err(Refusal { span: leaf.span, why });
        }
        if leaf.dims.len() > table::MOST_DIMS {
            let why = format!(
                "`{}` has {} array dimensions, the header's table holds {}",
                leaf.path,
                leaf.dims.len(),
                table::MOST_DIMS
            );
            return Err(Refusal { span: leaf.span, why });
        }
    }
    Ok(())
}
