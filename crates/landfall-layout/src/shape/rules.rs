//! Layout rules by name; [`layout`](mod@crate::layout) applies them.

/// The layout rules of a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Rules {
    /// OpenGL 4.6 §7.6.2.2, std140.
    Std140,
    /// OpenGL 4.6 §7.6.2.2, std430: std140 without rounding arrays and structures up to 16.
    Std430,
    /// `GL_EXT_scalar_block_layout`.
    Scalar,
    /// WGSL §14.4.
    Wgsl,
    /// None of these: each offset and stride is as a SPIR-V module gives it.
    Explicit(Packing),
}

/// What offsets and strides of a SPIR-V module keep to that follow none of the rules of a text.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Packing {
    /// Relaxed block layout: Vulkan, Offset and Stride Assignment (`VK_KHR_relaxed_block_layout`). Vectors
    /// are aligned to their components, but do not straddle 16 bytes.
    Relaxed,
    /// Constant buffers of Direct3D: members fill registers of 16 bytes; arrays, matrices and
    /// structures begin with one.
    D3d,
    /// Nothing.
    Free,
}

impl Rules {
    /// The rules that a text may declare.
    pub const OF_TEXT: [Rules; 4] = [Rules::Std140, Rules::Std430, Rules::Scalar, Rules::Wgsl];

    /// Every value.
    pub const ALL: [Rules; 7] = [
        Rules::Std140,
        Rules::Std430,
        Rules::Scalar,
        Rules::Wgsl,
        Rules::Explicit(Packing::Relaxed),
        Rules::Explicit(Packing::D3d),
        Rules::Explicit(Packing::Free),
    ];

    /// Returns the name used in messages, JSON and `--rules`, which takes those of a text.
    pub fn name(self) -> &'static str {
        match self {
            Rules::Std140 => "std140",
            Rules::Std430 => "std430",
            Rules::Scalar => "scalar",
            Rules::Wgsl => "wgsl",
            Rules::Explicit(Packing::Relaxed) => "relaxed",
            Rules::Explicit(Packing::D3d) => "d3d",
            Rules::Explicit(Packing::Free) => "explicit",
        }
    }

    /// Returns the rules of a text with that name.
    pub fn from_name(name: &str) -> Option<Rules> {
        Rules::OF_TEXT.into_iter().find(|rules| rules.name() == name)
    }
}
