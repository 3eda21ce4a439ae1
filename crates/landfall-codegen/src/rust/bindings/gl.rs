//! Bindings for OpenGL: names, bindings and locations as constants.

use landfall_layout::diagnostic::Diagnostic;
use landfall_layout::interface::ResourceKind;
use landfall_layout::shape::AddressSpace;
use landfall_layout::source::Language;
use landfall_layout::text::escape;

use super::super::names::{Scope, screaming};
use super::program::{Binding, Program};
use super::text::Module;
use super::{BindingOptions, source};

/// Prints a program of GLSL shaders.
pub(super) fn program(
    program: &Program<'_>,
    options: &BindingOptions,
    out: &mut Module,
) -> Vec<Diagnostic> {
    let mut scope = Scope::default();
    if program.shaders.iter().any(|shader| shader.layout.language == Language::Wgsl) {
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
    Vec::new()
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
