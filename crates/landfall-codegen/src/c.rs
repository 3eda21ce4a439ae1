//! Layouts as a C11 and C++17 header: structures with explicit padding and static assertions
//! on their offsets, offset macros, and a table of names.
//!
//! `types` (with `plain`) maps members to C types and keeps each structure once, `structs`
//! writes them, `table` writes the macros and table of a block, `reachable` builds the access
//! expression of each leaf, `names` makes C identifiers, and `prelude` is the text all headers
//! share.

pub(super) mod comments;
pub(super) mod names;
mod plain;
mod prelude;
mod reachable;
mod structs;
mod table;
mod types;

use landfall_layout::layout::BlockLayout;
use landfall_layout::shape::{AddressSpace, ArrayLen};
use landfall_layout::{Diagnostic, ShaderLayout};
use names::Names;
use types::{Refusal, Types};

/// Options of the C header.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct COptions {
    /// The header's file name, from which its include guard is made: `lights.h`.
    pub file: String,
    /// The prefix of every type, macro and function: `engine_` gives `engine_PointLight`
    /// and `ENGINE_POINT_LIGHT_BLOCK_SIZE`.
    pub prefix: String,
}

/// A header, and the diagnostics of the blocks it leaves out.
#[derive(Clone, Debug)]
pub struct COutput {
    /// The text of the header.
    pub text: String,
    /// The access expression of each leaf of each block in the header.
    pub leaves: Vec<CLeaf>,
    /// One error for every block that no C structure can mirror; `text` holds the others.
    pub diagnostics: Vec<Diagnostic>,
}

/// The C names that access a leaf.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CLeaf {
    /// The block's name in the shader.
    pub block: String,
    /// The name its macros begin with: `POINT_LIGHT_BLOCK`.
    pub macros: String,
    /// The macro of its offset: `POINT_LIGHT_BLOCK_DATA_POS_OFFSET`; its parameters are the array
    /// indices, if any.
    pub offset: String,
    /// The block's function from a path to an offset: `point_light_block_lookup`.
    pub lookup: String,
    /// The structure of the block; `None` when the block holds only a runtime-sized array.
    pub structure: Option<String>,
    /// The leaf's path in the shader: `data[].pos`.
    pub path: String,
    /// The field access from the structure to the leaf, without indices: `.data[].pos`,
    /// `.weights[].value`. Starts at an element of the tail for a leaf of a runtime-sized tail.
    pub access: String,
    /// The function that returns the tail's elements, for a leaf of a runtime-sized tail.
    pub tail: Option<String>,
}

/// Writes one header for the blocks of `shaders`. Skips loose uniforms, which have no offsets;
/// lay the shader out with `gather` to include them.
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

/// Checks for blocks that C cannot mirror: no layout, override-sized arrays, too many dimensions.
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
