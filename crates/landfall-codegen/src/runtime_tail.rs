//! The size of a buffer whose runtime-sized tail is to have a number of elements, for all languages.

use landfall_layout::layout::BlockLayout;
use landfall_layout::shape::Rules;

/// The sizes that a buffer may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct TailSize {
    /// The least size in bytes that an API accepts.
    pub(super) least: u64,
    /// The size in bytes is a multiple of this.
    pub(super) multiple: u64,
}

/// The sizes for a block whose tail begins at `offset`.
///
/// A shader counts as many elements as fit behind `offset`, so a buffer must not be rounded up to
/// the alignment of the block. OpenGL demands room for one element (4.6 §7.3.1,
/// `BUFFER_DATA_SIZE`), and Vulkan nothing. WebGPU demands the size of the structure with one
/// element, which is rounded up (§ minimum buffer binding size), and a multiple of 4.
pub(super) fn tail_size(block: &BlockLayout, offset: u64, stride: u64) -> TailSize {
    match block.rules {
        Rules::Wgsl => TailSize { least: buffer_size(block).unwrap_or(0), multiple: 4 },
        Rules::Std140 | Rules::Std430 | Rules::Scalar | Rules::Explicit(_) => {
            TailSize { least: offset + stride, multiple: 1 }
        }
    }
}

/// The bytes of a buffer for a block, as a program allocates and writes them.
///
/// WebGPU writes in multiples of 4 bytes (§ `writeBuffer`, § `mappedAtCreation`), so a lone `f16`, of
/// 2 bytes for the shader, has 4 in the program.
pub(super) fn buffer_size(block: &BlockLayout) -> Option<u64> {
    match block.rules {
        Rules::Wgsl => block.size.map(|size| size.next_multiple_of(4)),
        Rules::Std140 | Rules::Std430 | Rules::Scalar | Rules::Explicit(_) => block.size,
    }
}

impl TailSize {
    /// Whether `offset + n * stride` may miss the multiple.
    pub(super) fn must_round(self, offset: u64, stride: u64) -> bool {
        !offset.is_multiple_of(self.multiple) || !stride.is_multiple_of(self.multiple)
    }
}

#[cfg(test)]
mod tests {
    use landfall_layout::{Options, Source, layout};

    use super::*;

    fn block(ty: &str) -> BlockLayout {
        let text =
            format!("enable f16;\n@group(0) @binding(0) var<storage, read_write> b: {ty};\n");
        let shader = layout(&Source::new("a.wgsl", text), &Options::default());
        assert!(!shader.has_errors(), "{:?}", shader.diagnostics);
        shader.blocks[0].clone()
    }

    /// WebGPU: `size` of `writeBuffer` and of a buffer that is mapped at creation is a multiple of 4.
    #[test]
    fn buffers_of_webgpu_are_written_in_multiples_of_4_bytes() {
        for (ty, shader, program) in [
            ("f16", 2, 4),
            ("vec3<f16>", 6, 8),
            ("array<f16, 3>", 6, 8),
            ("array<f16, 4>", 8, 8),
            ("f32", 4, 4),
        ] {
            let block = block(ty);
            assert_eq!(block.size, Some(shader), "{ty}");
            assert_eq!(buffer_size(&block), Some(program), "{ty}");
        }
        assert_eq!(tail_size(&block("array<f16>"), 0, 2), TailSize { least: 4, multiple: 4 });
        assert_eq!(tail_size(&block("array<f32>"), 0, 4), TailSize { least: 4, multiple: 4 });
    }
}
