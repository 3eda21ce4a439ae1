//! The functions, textures and samplers of a naga module, with their names in the text.

use landfall_layout::source::Span;
use naga::{ArraySize, Handle, TypeInner};

use super::{Direction, FunctionInfo, HandleKind, ModuleHandle, Parameter};

/// Returns the functions of a module, with their types in WGSL.
pub(super) fn functions(ir: &naga::Module) -> Vec<FunctionInfo> {
    let bases = ir.functions.iter().map(|(handle, function)| {
        let parameters = function.arguments.iter().map(|argument| {
            let (ty, direction) = match ir.types[argument.ty].inner {
                TypeInner::Pointer { base, .. } => (base, Direction::InOut),
                _ => (argument.ty, Direction::In),
            };
            let name = argument.name.clone().unwrap_or_default();
            Parameter { name, ty: spelled(ir, ty), direction }
        });
        let range = ir.functions.get_span(handle).to_range().unwrap_or_default();
        FunctionInfo {
            name: function.name.clone().unwrap_or_default(),
            parameters: parameters.collect(),
            returns: function.result.as_ref().map(|result| spelled(ir, result.ty)),
            span: Span { file: 0, start: range.start as u32, end: range.end as u32 },
            handle,
        }
    });
    bases.collect()
}

/// Returns the textures and samplers of a module.
pub(super) fn handles(ir: &naga::Module) -> Vec<ModuleHandle> {
    let all = ir.global_variables.iter().filter_map(|(variable, global)| {
        let kind = match ir.types[global.ty].inner {
            TypeInner::Image { class: naga::ImageClass::Storage { .. }, .. } => HandleKind::Image,
            TypeInner::Image { .. } => HandleKind::Texture,
            TypeInner::Sampler { .. } => HandleKind::Sampler,
            _ => return None,
        };
        let at = global.binding?;
        let path = global.name.clone().unwrap_or_default();
        Some(ModuleHandle { path, group: at.group, binding: at.binding, kind, variable })
    });
    all.collect()
}

/// Returns a type in WGSL.
fn spelled(ir: &naga::Module, ty: Handle<naga::Type>) -> String {
    let scalar = |scalar: &naga::Scalar| {
        let kind = match scalar.kind {
            naga::ScalarKind::Sint => "i",
            naga::ScalarKind::Uint => "u",
            naga::ScalarKind::Float => "f",
            naga::ScalarKind::Bool => return "bool".to_string(),
            naga::ScalarKind::AbstractInt | naga::ScalarKind::AbstractFloat => "abstract",
        };
        format!("{kind}{}", u32::from(scalar.width) * 8)
    };
    let ty = &ir.types[ty];
    match &ty.inner {
        TypeInner::Scalar(s) => scalar(s),
        TypeInner::Atomic(s) => format!("atomic<{}>", scalar(s)),
        TypeInner::Vector { size, scalar: s } => format!("vec{}<{}>", *size as u8, scalar(s)),
        TypeInner::Matrix { columns, rows, scalar: s } => {
            format!("mat{}x{}<{}>", *columns as u8, *rows as u8, scalar(s))
        }
        TypeInner::Array { base, size: ArraySize::Constant(len), .. } => {
            format!("array<{}, {len}>", spelled(ir, *base))
        }
        TypeInner::Array { base, .. } => format!("array<{}>", spelled(ir, *base)),
        _ => ty.name.clone().unwrap_or_else(|| "a sampler or image".to_string()),
    }
}
