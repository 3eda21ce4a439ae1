//! Who places a structure's fields in a buffer: its bytes in memory are copied, or a library writes
//! them by rules of its own.
//!
//! encase (0.13, `#[derive(ShaderType)]`, also Bevy's) places fields by WGSL §14.4. crevice (0.20,
//! `#[derive(AsStd140, AsStd430)]`) places them by std140 or std430 and has no arrays. Used by
//! [`types`](super::types).

use super::file::{Field, Structure};
use super::rust_type::{RustType, Shape, TypeArgument, UnknownLayout};
use landfall_layout::layout::BlockLayout;
use landfall_layout::shape::{AddressSpace, Rules, ScalarKind};

/// What places the fields of a structure in a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum MirrorWriter {
    /// rustc, where the bytes in memory are copied.
    Memory,
    Encase,
    /// crevice's `AsStd140` and `AsStd430`.
    Std140,
    Std430,
}

impl MirrorWriter {
    /// Returns what writes a structure to a block, by the traits that it derives.
    pub fn new(structure: &Structure, block: &BlockLayout) -> MirrorWriter {
        let derives = |name: &str| structure.derives.iter().any(|derived| derived == name);
        if derives("ShaderType") {
            return MirrorWriter::Encase;
        }
        // Where both traits are derived, the rules of the block choose.
        let packed = match block.rules {
            Rules::Std140 => false,
            Rules::Std430 | Rules::Scalar | Rules::Explicit(_) => true,
            Rules::Wgsl => block.space != AddressSpace::Uniform,
        };
        match (derives("AsStd140"), derives("AsStd430")) {
            (true, true) if packed => MirrorWriter::Std430,
            (true, _) => MirrorWriter::Std140,
            (false, true) => MirrorWriter::Std430,
            (false, false) => MirrorWriter::Memory,
        }
    }

    /// The library's name in a message; `None` for bytes in memory.
    pub fn library(self) -> Option<&'static str> {
        match self {
            MirrorWriter::Memory => None,
            MirrorWriter::Encase => Some("encase"),
            MirrorWriter::Std140 => Some("crevice's `AsStd140`"),
            MirrorWriter::Std430 => Some("crevice's `AsStd430`"),
        }
    }

    /// The trait that every structure inside has to derive.
    fn derived(self) -> Option<&'static str> {
        match self {
            MirrorWriter::Memory => None,
            MirrorWriter::Encase => Some("ShaderType"),
            MirrorWriter::Std140 => Some("AsStd140"),
            MirrorWriter::Std430 => Some("AsStd430"),
        }
    }

    /// Returns why the library does not compile for a structure.
    pub fn refuses(self, structure: &Structure) -> Option<String> {
        let (library, derived) = (self.library()?, self.derived()?);
        let name = &structure.name;
        if !structure.derives.iter().any(|one| one == derived) {
            return Some(format!("`{name}` does not derive `{derived}`"));
        }
        if structure.tuple || structure.fields.is_empty() {
            return Some(format!("{library} takes structures with named fields only"));
        }
        None
    }

    /// The least alignment of a structure: GLSL §7.6.2.2 rule 9 in std140.
    pub fn least_align(self, structure: &Structure) -> u64 {
        match self {
            MirrorWriter::Memory => structure.repr.align.unwrap_or(1),
            MirrorWriter::Encase | MirrorWriter::Std430 => 1,
            MirrorWriter::Std140 => 16,
        }
    }

    pub fn field_align(self, structure: &Structure, field: &Field, ty: &RustType) -> u64 {
        match self {
            MirrorWriter::Memory => ty.align.min(structure.repr.packed.unwrap_or(u64::MAX)).max(1),
            MirrorWriter::Encase => field.align.unwrap_or(ty.align),
            MirrorWriter::Std140 | MirrorWriter::Std430 => ty.align,
        }
    }

    pub fn field_size(self, field: &Field, ty: &RustType) -> u64 {
        match self {
            MirrorWriter::Encase => field.size.map_or(ty.size, |size| size.max(ty.size)),
            MirrorWriter::Memory | MirrorWriter::Std140 | MirrorWriter::Std430 => ty.size,
        }
    }

    /// Returns a field that pads: `` `_pad_12: [u8; 4]` ``.
    pub fn padding(self, at: u64, size: u64) -> String {
        match self {
            MirrorWriter::Memory => format!("`_pad_{at}: [u8; {size}]`"),
            MirrorWriter::Encase => format!("`#[shader(size({size}))] _pad_{at}: f32`"),
            // crevice has neither bytes nor arrays.
            MirrorWriter::Std140 | MirrorWriter::Std430 => {
                let words = (0..size / 4).map(|word| format!("`_pad_{}: f32`", at + word * 4));
                words.collect::<Vec<_>>().join(", ")
            }
        }
    }

    /// An array of the text.
    pub fn array(self, element: RustType, len: u64) -> Result<RustType, UnknownLayout> {
        let too_large = || UnknownLayout("its type is too large".to_string());
        let element = match self {
            MirrorWriter::Memory => element,
            MirrorWriter::Encase if len == 0 => {
                return Err(UnknownLayout("encase has no arrays without elements".to_string()));
            }
            // WGSL §14.4.1: the stride is the element's size rounded up to its alignment.
            MirrorWriter::Encase => {
                let size = element.size.checked_next_multiple_of(element.align);
                RustType { size: size.ok_or_else(too_large)?, ..element }
            }
            MirrorWriter::Std140 | MirrorWriter::Std430 => {
                return Err(UnknownLayout("crevice has no arrays".to_string()));
            }
        };
        let array = RustType::array(element, len).ok_or_else(too_large)?;
        Ok(RustType { composite: true, ..array })
    }

    /// Returns a scalar, vector or matrix type of a math crate as the library places it.
    pub fn known(self, path: &[String], ty: RustType) -> Result<RustType, UnknownLayout> {
        let Some(library) = self.library() else { return Ok(ty) };
        let refused = || UnknownLayout(format!("{library} does not write `{}`", path.join("::")));
        let name = path.last().map_or("", String::as_str);
        // Quaternions and the types that glam aligns to 16 have no counterpart in shaders.
        if name.contains("Quat") || name.ends_with("3A") || name.starts_with("Affine") {
            return Err(refused());
        }
        if name == "Srgba" {
            return Err(refused());
        }
        self.placed(ty).ok_or_else(refused)
    }

    fn placed(self, ty: RustType) -> Option<RustType> {
        let Shape::Array { element, len } = &ty.shape else { return self.scalar(ty) };
        let vector = |element: &RustType, len: u64| {
            let scalar = self.scalar(element.clone())?;
            let size = scalar.size * len;
            // GLSL §7.6.2.2 rules 2 and 3, WGSL §14.4.1: three components are aligned as four.
            let align = size.checked_next_power_of_two()?;
            let array = RustType::array(scalar, len).filter(|_| (2..=4).contains(&len))?;
            Some(RustType { align, ..array })
        };
        match &element.shape {
            Shape::Scalar { .. } => vector(element, *len),
            Shape::Array { element: component, len: rows } => {
                let column = vector(component, *rows)?;
                // GLSL §7.6.2.2 rule 5: a matrix is an array of its columns.
                let align = match self {
                    MirrorWriter::Std140 => column.align.max(16),
                    MirrorWriter::Memory | MirrorWriter::Encase | MirrorWriter::Std430 => {
                        column.align
                    }
                };
                let column = RustType { align, ..column }.aligned(align);
                RustType::array(column, *len).filter(|_| (2..=4).contains(len))
            }
            Shape::Struct(_) => None,
        }
    }

    fn scalar(self, ty: RustType) -> Option<RustType> {
        let Shape::Scalar { kind, .. } = ty.shape else { return None };
        match (self, kind, ty.size) {
            (_, ScalarKind::Float | ScalarKind::Sint | ScalarKind::Uint, 4) => Some(ty),
            (MirrorWriter::Std140 | MirrorWriter::Std430, ScalarKind::Float, 8) => Some(ty),
            // crevice writes `bool` as 32 bits.
            (MirrorWriter::Std140 | MirrorWriter::Std430, ScalarKind::Bool, 1) => {
                Some(RustType::scalar(kind, "bool", 4))
            }
            (_, _, _) => None,
        }
    }
}

/// A type that encase writes as what it holds.
pub(super) enum Wrapped {
    Same(RustType),
    /// A runtime-sized array of that type.
    Elements(RustType),
}

/// Returns what encase writes for a pointer or collection; `None` for other types.
pub(super) fn wrapped(path: &[String], arguments: &[TypeArgument]) -> Option<Wrapped> {
    let name = path.last()?.as_str();
    match (name, arguments) {
        ("ArrayLength", []) => Some(Wrapped::Same(RustType::scalar(ScalarKind::Uint, "u32", 4))),
        ("Vec" | "VecDeque" | "LinkedList", [TypeArgument::Type(ty)]) => {
            Some(Wrapped::Elements(ty.clone()))
        }
        ("Box" | "Rc" | "Arc" | "Cow", [TypeArgument::Type(ty)]) => Some(Wrapped::Same(ty.clone())),
        // `Option<NonZeroU32>`: `None` is written as 0.
        ("Option", [TypeArgument::Type(ty)]) if ty.size == 4 && !ty.composite => {
            Some(Wrapped::Same(ty.clone()))
        }
        (_, _) => None,
    }
}
