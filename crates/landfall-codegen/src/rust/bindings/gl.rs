//! Bindings for OpenGL: names, bindings and locations as constants, and a check of the blocks that a
//! driver reports.

use landfall_layout::diagnostic::Diagnostic;
use landfall_layout::interface::ResourceKind;
use landfall_layout::layout::measure::fixed;
use landfall_layout::layout::{BlockLayout, Leaf};
use landfall_layout::shape::{AddressSpace, Scalar, ScalarKind, Type};
use landfall_layout::source::Language;
use landfall_layout::text::escape;

use super::super::names::{Scope, screaming};
use super::program::{Binding, Program};
use super::text::{Module, PUB, indented};
use super::{BindingOptions, source};

/// The functions that hold what a driver reports to the constants; no part of this crate, but text
/// of the module of the API.
const DRIVER: &str = include_str!("gl/driver.rs");

/// Prints the module that `check` of the programs calls, if one has blocks.
pub(super) fn driver(programs: &[Program<'_>], name: &str, out: &mut Module) {
    // Without blocks nothing calls it, and an unused item is a warning.
    if programs.iter().all(|program| is_wgsl(program) || blocks(program).next().is_none()) {
        return;
    }
    out.item(
        "What a driver reports of a program.",
        &format!("#[allow(unsafe_code)]\nmod {name} {{\n{}}}", indented(DRIVER, 1)),
    );
}

/// Prints a program of GLSL shaders; `driver` is the module of [`driver`].
pub(super) fn program(
    program: &Program<'_>,
    options: &BindingOptions,
    driver: &str,
    out: &mut Module,
) -> Vec<Diagnostic> {
    let mut scope = Scope::default();
    // OpenGL takes no WGSL.
    if is_wgsl(program) {
        return Vec::new();
    }
    for shader in &program.shaders {
        source::source(program, shader, options, &mut scope, out);
    }
    for one in &program.bindings {
        resource(one, &mut scope, out);
    }
    for entry in program.shaders.iter().flat_map(|shader| &shader.entries) {
        for input in &entry.inputs {
            let shown = escape::name(&input.name);
            let upper = screaming(&input.name);
            let name = scope.take(&format!("{upper}_ATTRIBUTE"));
            let about = format!("The name of the vertex attribute `{shown}`.");
            out.constant(&about, &format!("{name}: &str"), &format!("{:?}", &*input.name));
            if let Some(location) = input.location {
                let name = scope.take(&format!("{upper}_LOCATION"));
                let about = format!("The location of the vertex attribute `{shown}`.");
                out.constant(&about, &format!("{name}: u32"), &location.to_string());
            }
        }
        if let Some([Some(x), Some(y), Some(z)]) = entry.workgroup_size {
            let about = "The invocations of a workgroup along each axis.";
            out.constant(about, "WORKGROUP_SIZE: [u32; 3]", &format!("[{x}, {y}, {z}]"));
        }
    }
    check(program, driver, out);
    Vec::new()
}

fn is_wgsl(program: &Program<'_>) -> bool {
    program.shaders.iter().any(|shader| shader.layout.language == Language::Wgsl)
}

/// The blocks that OpenGL has.
fn blocks<'p>(program: &'p Program<'_>) -> impl Iterator<Item = &'p BlockLayout> {
    let all = program.bindings.iter().filter_map(|one| one.block);
    all.filter(|block| matches!(block.space, AddressSpace::Uniform | AddressSpace::Storage))
}

/// Prints the table of the program's blocks, and the function that holds a driver's report to it.
fn check(program: &Program<'_>, driver: &str, out: &mut Module) {
    let blocks: String = blocks(program).map(|block| expected_block(block, driver)).collect();
    if blocks.is_empty() {
        return;
    }
    out.item(
        "The blocks that [`check`] holds the driver to.",
        &format!(
            "#[rustfmt::skip]\nconst BLOCKS: &[super::{driver}::Block] = &[\n{}];",
            indented(&blocks, 1)
        ),
    );
    out.item(
        "Holds the offsets, sizes and strides that the driver reports of a linked program to those \
         of the\nmirrors; the error lists all differences. `load` returns an entry point of OpenGL, \
         3.1 (ES 3.0)\nor for storage blocks 4.3 (ES 3.1), by its name.\n\n# Safety\nThe context of \
         the program is current, and `load` returns its entry points.",
        &format!(
            "#[allow(unsafe_code)]\n{PUB} unsafe fn check(\n    program: u32,\n    \
             mut load: impl FnMut(&str) -> *const core::ffi::c_void,\n) -> Result<(), String> {{\n    \
             // SAFETY: the caller promises the same.\n    \
             unsafe {{ super::{driver}::check(program, &mut load, BLOCKS) }}\n}}"
        ),
    );
}

/// A block as a row of the table.
fn expected_block(block: &BlockLayout, driver: &str) -> String {
    let is_storage = block.space == AddressSpace::Storage;
    // Members of a block with an instance are reported as `Block.member` (OpenGL 4.6 §7.3.1).
    let prefix = block.instance.as_ref().map_or("", |_| &*block.name);
    let sizes = (block.data_size.unwrap_or(0), block.size.unwrap_or(0));
    let members: String = block.leaves.iter().map(|leaf| expected_member(leaf, driver)).collect();
    format!(
        "super::{driver}::Block {{\n    name: {:?},\n    prefix: {prefix:?},\n    is_storage: \
         {is_storage},\n    is_packed: {},\n    sizes: {sizes:?},\n    members: &[\n{}    ],\n}},\n",
        &*block.name,
        !block.rules_declared,
        indented(&members, 2),
    )
}

/// A member as a row of the table.
fn expected_member(leaf: &Leaf, driver: &str) -> String {
    // A runtime-sized array has no elements, as drivers report it.
    let lengths = leaf.dims.iter().map(|len| fixed(len).unwrap_or(0));
    let arrays: Vec<(u64, u64)> = lengths.zip(leaf.strides.iter().copied()).collect();
    let matrix = leaf.matrix_stride.map(|stride| (stride, leaf.row_major));
    let ty = (number(&leaf.ty), leaf.ty.spelled(Language::Glsl).to_string());
    format!(
        "super::{driver}::Member {{ path: {:?}, ty: {ty:?}, offset: {}, arrays: &{arrays:?}, matrix: \
         {matrix:?} }},\n",
        leaf.path,
        leaf.offset.unwrap_or(0),
    )
}

/// The number that `glGetActiveUniform` gives for a type (OpenGL 4.6, table 7.3); 0 for types of
/// extensions.
fn number(ty: &Type) -> u32 {
    // The number of a scalar, and of its vector of two components; those of three and four follow.
    let first_of = |scalar: &Scalar| match (scalar.kind, scalar.width) {
        (ScalarKind::Float, 4) => Some((0x1406, 0x8B50)),
        (ScalarKind::Float, 8) => Some((0x140A, 0x8FFC)),
        (ScalarKind::Sint, 4) => Some((0x1404, 0x8B53)),
        (ScalarKind::Uint, 4) => Some((0x1405, 0x8DC6)),
        (ScalarKind::Bool, _) => Some((0x8B56, 0x8B57)),
        _ => None,
    };
    let number = match ty {
        Type::Scalar(scalar) => first_of(scalar).map(|(number, _)| number),
        Type::Vector { scalar, rows } => {
            first_of(scalar).map(|(_, number)| number + u32::from(*rows) - 2)
        }
        Type::Matrix { scalar, columns, rows } => {
            // Numbers of square matrices are consecutive, and so are those of the others.
            let (square, others) = match scalar.width {
                4 => (0x8B5A, 0x8B65),
                _ => (0x8F46, 0x8F49),
            };
            let (columns, rows) = (u32::from(*columns) - 2, u32::from(*rows) - 2);
            // In the order 2x3, 2x4, 3x2, 3x4, 4x2, 4x3.
            let at = columns * 2 + if rows > columns { rows - 1 } else { rows };
            Some(if columns == rows { square + rows } else { others + at })
        }
        Type::Atomic(_) | Type::Address(_) | Type::Struct(_) | Type::Array { .. } => None,
    };
    number.unwrap_or(0)
}

fn resource(one: &Binding<'_>, scope: &mut Scope, out: &mut Module) {
    let (what, suffix, name) = match (&one.resource.kind, one.block) {
        (ResourceKind::Buffer(AddressSpace::Uniform, _), Some(block)) => {
            ("uniform block", "BLOCK", &*block.name)
        }
        (ResourceKind::Buffer(AddressSpace::Storage, _), Some(block)) => {
            ("storage block", "BLOCK", &*block.name)
        }
        // OpenGL has no push constants.
        (ResourceKind::Buffer(..), _) => return,
        (ResourceKind::StorageTexture { .. }, _) => ("image", "UNIFORM", &*one.resource.name),
        (ResourceKind::AtomicCounter, _) => ("atomic counter", "UNIFORM", &*one.resource.name),
        _ => ("sampler", "UNIFORM", &*one.resource.name),
    };
    let shown = escape::name(name);
    // The dot of a handle in a structure, `light.shadow`.
    let upper = screaming(&name.replace('.', "_"));
    let text = format!("{name:?}");
    let of = scope.take(&format!("{upper}_{suffix}"));
    let array = match one.resource.count.is_empty() {
        true => "",
        false => ", an array: its elements are named with `[0]` and so on",
    };
    out.constant(
        &format!("The name of the {what} `{shown}`{array}."),
        &format!("{of}: &str"),
        &text,
    );
    if let Some(size) = one.block.and_then(|block| block.size) {
        let of = scope.take(&format!("{upper}_SIZE"));
        let about = format!("The bytes that a buffer of `{shown}` holds at least.");
        out.constant(&about, &format!("{of}: usize"), &size.to_string());
    }
    if let Some(binding) = one.resource.binding {
        let of = scope.take(&format!("{upper}_BINDING"));
        let about = format!("The binding of the {what} `{shown}`.");
        out.constant(&about, &format!("{of}: u32"), &binding.to_string());
    }
    if let Some(location) = one.resource.location {
        let of = scope.take(&format!("{upper}_LOCATION"));
        let about = format!("The location of the uniform `{shown}`.");
        out.constant(&about, &format!("{of}: i32"), &location.to_string());
    }
}
