//! Handles: samplers, textures and images, as naga's global variables.
//!
//! `uniform sampler2D t` becomes a texture and a sampler; each element of an array, and each member
//! of a structure, becomes its own pair. A handle is found by its path: `materials[2].diffuse`.

use std::num::NonZeroU32;

use naga::{Expression, Handle, ImageClass, StorageAccess, StorageFormat, TypeInner};

use super::ast::Qualifiers;
use super::body::{Body, TypedValue};
use super::lvalue::HandlePath;
use super::types::{Image, Kind, Opaque, Ty};
use super::{Help, Lowerer, Lowering, refuse};
use crate::module::{HandleKind, ModuleHandle};
use landfall_layout::source::Span;

/// The most handles of a shader, elements of arrays counted each.
const MAX_HANDLES: usize = 4096;

/// The most handles of an array that are bound individually and selected by a `switch`; a larger
/// array is bound as one.
/// Devices without arrays of bindings (GLES, WebGPU) can run a `switch`; one of thousands of cases
/// would be slow to compile.
const MAX_SWITCHED: u32 = 64;

/// The size of an array of handles that is bound as one, if it has one.
#[derive(Clone, Copy)]
struct HandleArray {
    len: Option<u32>,
}

#[derive(Clone, Debug)]
pub struct HandlePair {
    pub opaque: Opaque,
    pub image: Option<Source>,
    pub sampler: Option<Source>,
}

#[derive(Clone, Copy, Debug)]
pub enum Source {
    Global(Handle<naga::GlobalVariable>),
    /// An array of handles that naga binds as one.
    Array(Handle<naga::GlobalVariable>),
    Element(Handle<naga::GlobalVariable>, Handle<Expression>),
    Argument(u32),
}

#[derive(Clone, Debug)]
pub enum HandleChoice {
    At(HandlePath, Ty),
    /// `sampler2D(texture, sampler)`.
    Joined(Opaque, Box<[HandleChoice; 2]>),
}

/// Returns every handle in a type, by its path.
pub fn handles_by_path(ty: &Ty) -> Vec<(String, Opaque)> {
    let mut found = Vec::new();
    collect(ty, String::new(), &mut found);
    found
}

fn collect(ty: &Ty, way: String, found: &mut Vec<(String, Opaque)>) {
    // Bounded while it is built: `sampler2D t[65536][65536]` is a short text.
    if found.len() > MAX_HANDLES {
        return;
    }
    match ty {
        Ty::Opaque(opaque) => found.push((way, opaque.clone())),
        Ty::Array(element, len) if element.has_opaque() => {
            for i in 0..len.unwrap_or(0) {
                collect(element, format!("{way}[{i}]"), found);
                if found.len() > MAX_HANDLES {
                    return;
                }
            }
        }
        Ty::Struct(s) if s.opaque => {
            for field in &s.members {
                collect(&field.ty, format!("{way}.{}", field.name), found);
            }
        }
        Ty::Void | Ty::Scalar(_) | Ty::Vector(..) | Ty::Matrix(..) => {}
        Ty::Array(..) | Ty::Struct(_) => {}
    }
}

impl<'a> Lowerer<'a> {
    /// Creates the global variables of all handles in a uniform.
    pub fn declare_handles(
        &mut self,
        name: &str,
        ty: &Ty,
        qualifiers: &Qualifiers<'a>,
        span: Span,
    ) -> Lowering<()> {
        // An array that is too long for a `switch`, or has no size, is bound as one.
        if let Ty::Array(element, len) = ty {
            let bound = len.is_none_or(|len| len > MAX_SWITCHED);
            if let (Ty::Opaque(opaque), true) = (&**element, bound) {
                let group = self.layout_number(qualifiers, "set").unwrap_or(0);
                let wanted = self.layout_number(qualifiers, "binding");
                let at = self.bindings.claim(group, wanted);
                let (opaque, many) = (opaque.clone(), Some(HandleArray { len: *len }));
                let pair = self.declare_handle(name, opaque, qualifiers, at, span, many)?;
                self.handles.insert(format!("{name}[?]"), pair);
                return Ok(());
            }
            if len.is_none() && element.has_opaque() {
                return Err(refuse(
                    span,
                    format!("`{name}` is an array of samplers or images without a size"),
                )
                .help("write the number of elements in the brackets"));
            }
        }
        let found = handles_by_path(ty);
        if self.handles.len() + found.len() > MAX_HANDLES {
            return Err(refuse(
                span,
                format!("the shader has more than {MAX_HANDLES} samplers and images"),
            ));
        }
        let group = self.layout_number(qualifiers, "set").unwrap_or(0);
        // The stated binding is that of the first handle; the others follow in free bindings.
        let mut binding = self.layout_number(qualifiers, "binding");
        for (way, opaque) in found {
            let path = format!("{name}{way}");
            let place = self.bindings.claim(group, binding.take());
            let pair = self.declare_handle(&path, opaque, qualifiers, place, span, None)?;
            self.handles.insert(path, pair);
        }
        Ok(())
    }

    fn declare_handle(
        &mut self,
        path: &str,
        opaque: Opaque,
        qualifiers: &Qualifiers<'a>,
        at: (u32, u32),
        span: Span,
        many: Option<HandleArray>,
    ) -> Lowering<HandlePair> {
        let mut pair = HandlePair { opaque: opaque.clone(), image: None, sampler: None };
        let global = |this: &mut Self, kind: HandleKind, at: (u32, u32), inner: TypeInner| {
            let naga_span = this.naga_span(span);
            let mut ty = this.nameless(inner);
            if let Some(HandleArray { len }) = many {
                let size = match len.and_then(NonZeroU32::new) {
                    Some(len) => naga::ArraySize::Constant(len),
                    None => naga::ArraySize::Dynamic,
                };
                ty = this.nameless(TypeInner::BindingArray { base: ty, size });
            }
            let name = match (kind, &opaque) {
                (HandleKind::Sampler, Opaque::Combined(_)) => format!("{path}_sampler"),
                _ => path.to_string(),
            };
            let variable = naga::GlobalVariable {
                // Paths have characters that no identifier has.
                name: Some(name.replace(['.', '[', ']'], "_")),
                space: naga::AddressSpace::Handle,
                binding: Some(naga::ResourceBinding { group: at.0, binding: at.1 }),
                ty,
                init: None,
                memory_decorations: naga::MemoryDecorations::empty(),
            };
            let variable = this.ir.global_variables.append(variable, naga_span);
            let path = path.to_string();
            let (group, binding) = at;
            this.module_handles.push(ModuleHandle { path, group, binding, kind, variable });
            match many {
                Some(_) => Source::Array(variable),
                None => Source::Global(variable),
            }
        };
        match &opaque {
            Opaque::Combined(image) => {
                let inner = image_type(image);
                pair.image = Some(global(self, HandleKind::Texture, at, inner));
                // The sampler of a combined one needs a binding of its own, which the text does
                // not state.
                let at = self.bindings.claim(at.0, None);
                let inner = TypeInner::Sampler { comparison: image.depth };
                pair.sampler = Some(global(self, HandleKind::Sampler, at, inner));
            }
            Opaque::Texture(image) => {
                pair.image = Some(global(self, HandleKind::Texture, at, image_type(image)));
            }
            Opaque::Sampler { comparison } => {
                let inner = TypeInner::Sampler { comparison: *comparison };
                pair.sampler = Some(global(self, HandleKind::Sampler, at, inner));
            }
            Opaque::Storage(image) => {
                let inner = self.storage_type(path, image, qualifiers, span)?;
                pair.image = Some(global(self, HandleKind::Image, at, inner));
            }
            Opaque::Foreign(name) => {
                let message = format!("`{path}` is a `{name}`, which naga does not support");
                return Err(refuse(span, message));
            }
        }
        Ok(pair)
    }

    fn storage_type(
        &self,
        path: &str,
        image: &Image,
        qualifiers: &Qualifiers<'a>,
        span: Span,
    ) -> Lowering<TypeInner> {
        // `layout(rgba8)`; naga requires a format of each storage image.
        let written = qualifiers.layout.iter().find_map(|id| storage_format(id.name.text));
        let format = written.or(match (qualifiers.writeonly, image.kind) {
            // Without a declared format, the format of the bound image decides what a store writes.
            (true, Kind::Int) => Some(StorageFormat::Rgba32Sint),
            (true, Kind::Uint) => Some(StorageFormat::Rgba32Uint),
            (true, _) => Some(StorageFormat::Rgba32Float),
            (false, _) => None,
        });
        let Some(format) = format else {
            let message = format!("image `{path}` has no format that naga supports");
            return Err(refuse(span, message).help("declare a format: `layout(rgba32f)`"));
        };
        let mut access = StorageAccess::LOAD | StorageAccess::STORE;
        if qualifiers.readonly {
            access = StorageAccess::LOAD;
        } else if qualifiers.writeonly {
            access = StorageAccess::STORE;
        }
        if self.atomics.contains(path) {
            access = StorageAccess::LOAD | StorageAccess::STORE | StorageAccess::ATOMIC;
        }
        let class = ImageClass::Storage { format, access };
        Ok(TypeInner::Image { dim: image.dim, arrayed: image.arrayed, class })
    }
}

pub fn image_type(image: &Image) -> TypeInner {
    let class = if image.depth {
        ImageClass::Depth { multi: image.multi }
    } else {
        ImageClass::Sampled { kind: image.kind.scalar().kind, multi: image.multi }
    };
    TypeInner::Image { dim: image.dim, arrayed: image.arrayed, class }
}

impl Body<'_, '_> {
    /// Returns the handle of a path without a variable index.
    pub fn handle(&self, way: &str) -> Lowering<HandlePair> {
        let found = self.handles.get(way).or_else(|| self.cx.handles.get(way));
        match found.cloned() {
            Some(pair) => Ok(pair),
            None => self.refuse(format!(
                "`{}` is not a sampler or image of this shader",
                way.trim_start_matches('#')
            )),
        }
    }

    /// Returns the array, bound as one, that a path ends in: `textures[3]`.
    fn bound_array(&self, way: &str) -> Option<(HandlePair, u32)> {
        // `textures[3]` of an array bound as one is looked up by `textures[?]`.
        let (name, index) = way.strip_suffix(']')?.rsplit_once('[')?;
        let array = self.cx.handles.get(&format!("{name}[?]"))?.clone();
        Some((array, index.parse().ok()?))
    }

    pub fn source(&mut self, source: Option<Source>) -> Lowering<Handle<Expression>> {
        match source {
            Some(Source::Global(global)) => Ok(self.global_pointer(global)),
            Some(Source::Array(_)) => {
                self.refuse("an array of samplers or images is used without an index")
            }
            Some(Source::Element(global, index)) => {
                let base = self.global_pointer(global);
                Ok(self.add(Expression::Access { base, index }))
            }
            Some(Source::Argument(index)) => Ok(self.add(Expression::FunctionArgument(index))),
            None => self.refuse("expected a combined texture and sampler"),
        }
    }

    /// Calls `with` for the selected handle; with a variable index, in a `switch` over all of them.
    pub fn with_handle(
        &mut self,
        chosen: &HandleChoice,
        ty: &Ty,
        mut with: impl FnMut(&mut Self, &HandlePair) -> Lowering<TypedValue>,
    ) -> Lowering<TypedValue> {
        self.chosen_handle(chosen, ty, &mut with)
    }

    fn chosen_handle(
        &mut self,
        chosen: &HandleChoice,
        ty: &Ty,
        with: &mut dyn FnMut(&mut Self, &HandlePair) -> Lowering<TypedValue>,
    ) -> Lowering<TypedValue> {
        let (way, index, len) = match chosen {
            // A texture and a sampler, each of which may have a variable index: nested.
            HandleChoice::Joined(opaque, parts) => {
                let [texture, sampler] = &**parts;
                return self.chosen_handle(texture, ty, &mut |this, texture| {
                    let image = texture.image;
                    this.chosen_handle(sampler, ty, &mut |this, sampler| {
                        let (opaque, sampler) = (opaque.clone(), sampler.sampler);
                        with(this, &HandlePair { opaque, image, sampler })
                    })
                });
            }
            HandleChoice::At(HandlePath { text, dynamic: None }, _) => {
                let pair = match self.bound_array(text) {
                    Some((array, index)) => {
                        let index = self.u32(index);
                        element(&array, index)
                    }
                    None => self.handle(text)?,
                };
                return with(self, &pair);
            }
            HandleChoice::At(HandlePath { text, dynamic: Some((index, len)) }, _) => {
                // An array bound as one is indexed at run time.
                if let Some(array) = self.cx.handles.get(text).cloned() {
                    return with(self, &element(&array, *index));
                }
                (text, *index, *len)
            }
        };
        // Otherwise one case for each element; its result goes through a local variable.
        let local = if *ty == Ty::Void { None } else { Some(self.local("", ty)?) };
        self.switch_over(index, len, |this, i| {
            let pair = this.handle(&way.replace("[?]", &format!("[{i}]")))?;
            let value = with(this, &pair)?;
            if let Some(local) = local {
                let pointer = this.local_pointer(local);
                this.statement(naga::Statement::Store { pointer, value: value.expr });
            }
            Ok(())
        })?;
        match local {
            Some(local) => {
                let place = self.local_place(local, ty);
                self.load(&place)
            }
            None => Ok(TypedValue { expr: index, ty: Ty::Void }),
        }
    }
}

fn element(array: &HandlePair, index: Handle<Expression>) -> HandlePair {
    let of = |source: Option<Source>| match source {
        Some(Source::Array(global)) => Some(Source::Element(global, index)),
        other => other,
    };
    let (image, sampler) = (of(array.image), of(array.sampler));
    HandlePair { opaque: array.opaque.clone(), image, sampler }
}

fn storage_format(name: &str) -> Option<StorageFormat> {
    use StorageFormat as F;
    Some(match name {
        "r8" => F::R8Unorm,
        "r8_snorm" => F::R8Snorm,
        "r8ui" => F::R8Uint,
        "r8i" => F::R8Sint,
        "r16ui" => F::R16Uint,
        "r16i" => F::R16Sint,
        "r16f" => F::R16Float,
        "rg8" => F::Rg8Unorm,
        "rg8_snorm" => F::Rg8Snorm,
        "rg8ui" => F::Rg8Uint,
        "rg8i" => F::Rg8Sint,
        "r32ui" => F::R32Uint,
        "r32i" => F::R32Sint,
        "r32f" => F::R32Float,
        "rg16ui" => F::Rg16Uint,
        "rg16i" => F::Rg16Sint,
        "rg16f" => F::Rg16Float,
        "rgba8" => F::Rgba8Unorm,
        "rgba8_snorm" => F::Rgba8Snorm,
        "rgba8ui" => F::Rgba8Uint,
        "rgba8i" => F::Rgba8Sint,
        "rgb10_a2ui" => F::Rgb10a2Uint,
        "rgb10_a2" => F::Rgb10a2Unorm,
        "r11f_g11f_b10f" => F::Rg11b10Ufloat,
        "r64ui" => F::R64Uint,
        "rg32ui" => F::Rg32Uint,
        "rg32i" => F::Rg32Sint,
        "rg32f" => F::Rg32Float,
        "rgba16ui" => F::Rgba16Uint,
        "rgba16i" => F::Rgba16Sint,
        "rgba16f" => F::Rgba16Float,
        "rgba32ui" => F::Rgba32Uint,
        "rgba32i" => F::Rgba32Sint,
        "rgba32f" => F::Rgba32Float,
        "r16" => F::R16Unorm,
        "r16_snorm" => F::R16Snorm,
        "rg16" => F::Rg16Unorm,
        "rg16_snorm" => F::Rg16Snorm,
        "rgba16" => F::Rgba16Unorm,
        "rgba16_snorm" => F::Rgba16Snorm,
        _ => return None,
    })
}
