//! What a program binds to a shader: entry points, resources, vertex inputs and constants.
//!
//! Read by [`syntax`](mod@crate::syntax) on request ([`Options::interface`](crate::Options)), and
//! which `RustOptions::bindings` of `landfall-codegen` writes as code.

use std::sync::Arc;

use crate::shape::{AddressSpace, ArrayLen, Scalar, Type};
use crate::source::{Span, Stage};

/// The interface of one shader.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct Interface {
    /// The entry points in declaration order; `main` for GLSL.
    pub entry_points: Vec<EntryPoint>,
    /// The buffers, textures, samplers and images in declaration order, used or not.
    pub resources: Vec<Resource>,
    /// The specialisation constants and overrides in declaration order.
    pub constants: Vec<SpecConstant>,
    /// The `#include` directives that opened a file, in the order of their execution.
    pub includes: Vec<Include>,
}

impl Interface {
    /// Notes that a texture is sampled with a sampler. A binding has to say whether a sampler filters;
    /// with a texture of integers it cannot.
    pub(crate) fn pair(&mut self, texture: usize, sampler: usize) {
        let integers = match &self.resources[texture].kind {
            ResourceKind::Texture(texture) => {
                matches!(texture.sampled, Sampled::Sint | Sampled::Uint)
            }
            _ => false,
        };
        if let ResourceKind::Sampler { filtering, .. } = &mut self.resources[sampler].kind {
            *filtering &= !integers;
        }
    }
}

/// An executed `#include`.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Include {
    /// The directive, after its `#`.
    pub span: Span,
    /// The index of the file that it opened.
    pub file: u32,
    /// The number of files that were open: 1 in the shader's own file.
    pub depth: usize,
}

/// A function that a pipeline starts.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct EntryPoint {
    /// The name.
    pub name: Arc<str>,
    /// The stage; `None` for GLSL whose file does not tell.
    pub stage: Option<Stage>,
    /// The workgroup size; `None` for a dimension that depends on a constant without a value, and
    /// for other stages.
    pub workgroup_size: Option<[Option<u32>; 3]>,
    /// Inputs of a vertex shader, by location.
    pub inputs: Vec<Input>,
    /// Indices of the resources that it or a function it calls uses.
    pub uses: Vec<usize>,
    /// The span of the name.
    pub span: Span,
}

/// A vertex attribute.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Input {
    /// The name.
    pub name: Arc<str>,
    /// The location, if written.
    pub location: Option<u32>,
    /// The type; a matrix or array occupies one location for each column and element.
    pub ty: Type,
    /// The span of the name.
    pub span: Span,
}

/// A resource that a program binds.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Resource {
    /// The name of the variable, or of a GLSL block without an instance.
    pub name: Arc<str>,
    /// The descriptor set or bind group, if written.
    pub group: Option<u32>,
    /// The binding, if written.
    pub binding: Option<u32>,
    /// The location of a GLSL uniform, if written.
    pub location: Option<u32>,
    /// What it is.
    pub kind: ResourceKind,
    /// Dimensions of an array of resources, outermost first.
    pub count: Vec<ArrayLen>,
    /// The span of the name; that of its block, if it is a buffer.
    pub span: Span,
}

/// The kind of a resource.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ResourceKind {
    /// A block.
    Buffer(AddressSpace, Access),
    /// A sampler of its own.
    Sampler {
        /// Whether it compares with a reference value.
        comparison: bool,
        /// Whether it may filter: no texture of integers is sampled with it.
        filtering: bool,
    },
    /// A texture of its own.
    Texture(Texture),
    /// GLSL's `sampler2D`: a texture with its sampler.
    Combined(Texture, Comparison),
    /// An image that is read and written without a sampler.
    StorageTexture {
        /// Dimensions and component.
        texture: Texture,
        /// The format in GLSL's spelling, if written.
        format: Option<&'static str>,
        /// How it may be accessed.
        access: Access,
    },
    /// `texture_external`.
    ExternalTexture,
    /// An acceleration structure for rays.
    AccelerationStructure,
    /// `textureBuffer`, `samplerBuffer` and `imageBuffer`.
    TexelBuffer {
        /// Whether it is an image.
        storage: bool,
    },
    /// `subpassInput`.
    InputAttachment,
    /// `atomic_uint`.
    AtomicCounter,
    /// A type that landfall knows only as a handle.
    Other,
}

/// Whether a combined sampler compares with a reference value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
#[non_exhaustive]
pub enum Comparison {
    Without,
    With,
}

/// How a shader may access a buffer or image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs)]
pub enum Access {
    Read,
    Write,
    ReadWrite,
    /// Atomic operations as well.
    Atomic,
}

/// The type of a texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Texture {
    /// What sampling returns.
    pub sampled: Sampled,
    /// The dimensions.
    pub dimension: Dimension,
    /// Whether it has layers.
    pub arrayed: bool,
    /// Whether it has several samples.
    pub multisampled: bool,
}

/// The component that sampling returns.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs)]
pub enum Sampled {
    Float,
    Sint,
    Uint,
    Depth,
}

/// The dimensions of a texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs)]
#[non_exhaustive]
pub enum Dimension {
    D1,
    D2,
    D3,
    Cube,
    Rectangle,
}

/// A specialisation constant or override.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct SpecConstant {
    /// The name.
    pub name: Arc<str>,
    /// The number: `constant_id = N`, `@id(N)`.
    pub id: Option<u32>,
    /// The type; `None` where only the initialiser tells and it is not a constant.
    pub scalar: Option<Scalar>,
    /// Whether it has a default.
    pub has_default: bool,
    /// The span of the name.
    pub span: Span,
}
