//! Checks of SPIR-V that is passed to a driver unchanged, since wgpu does none.
//!
//! Numbers are those of the SPIR-V specification, §3.

use crate::backend::Failure;

/// The header's length in words, and its first word.
const HEADER: usize = 5;
const MAGIC: u32 = 0x0723_0203;

const OP_EXECUTION_MODE: u32 = 16;
const LOCAL_SIZE: u32 = 17;
const OP_TYPE_SAMPLED_IMAGE: u32 = 27;
const OP_TYPE_POINTER: u32 = 32;
const UNIFORM_CONSTANT: u32 = 0;

/// Returns the workgroup size of a compute shader, `(1, 1, 1)` if it declares none.
///
/// # Errors
/// Fails if it is no SPIR-V, or uses resources that a job cannot bind.
pub(super) fn workgroup_size(words: &[u32]) -> Result<(u32, u32, u32), Failure> {
    if words.first() != Some(&MAGIC) || words.len() < HEADER {
        return Err(Failure::refused("the SPIR-V has an invalid header", ""));
    }
    let mut size = (1, 1, 1);
    let mut combined = Vec::new();
    let mut rest = &words[HEADER..];
    while let [first, ..] = rest {
        // The high half of an instruction's first word is its length in words: SPIR-V §2.3.
        let (length, op) = ((first >> 16) as usize, first & 0xFFFF);
        let whole = (length > 0).then(|| rest.split_at_checked(length)).flatten();
        let Some((instruction, after)) = whole else {
            return Err(Failure::refused("the SPIR-V ends within an instruction", ""));
        };
        rest = after;
        match (op, &instruction[1..]) {
            (OP_EXECUTION_MODE, [_, LOCAL_SIZE, x, y, z]) => size = (*x, *y, *z),
            (OP_TYPE_SAMPLED_IMAGE, [id, _]) => combined.push(*id),
            // Separate ones are joined to this type, too; a pointer to it is that of a combined
            // variable.
            (OP_TYPE_POINTER, [_, UNIFORM_CONSTANT, to]) if combined.contains(to) => {
                let message = "wgpu binds textures and samplers separately, but the SPIR-V has a \
                    combined one; declare `texture2D` and `sampler`";
                return Err(Failure::refused(message, ""));
            }
            _ => {}
        }
    }
    Ok(size)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_workgroup_is_found_among_the_instructions() {
        let words = [
            MAGIC,
            0x1_0000,
            0,
            9,
            0, // version, generator, bound, schema
            (2 << 16) | 17,
            1, // OpCapability Shader
            (6 << 16) | 16,
            4,
            17,
            8,
            4,
            2, // OpExecutionMode %4 LocalSize 8 4 2
        ];
        assert_eq!(workgroup_size(&words), Ok((8, 4, 2)));
        assert_eq!(workgroup_size(&words[..7]), Ok((1, 1, 1)));
    }

    #[test]
    fn what_is_no_spirv_never_gets_to_a_driver() {
        for words in [&[][..], &[MAGIC, 0, 0], &[1, 2, 3, 4, 5, 6], &[MAGIC, 0, 0, 0, 0, 0]] {
            assert!(workgroup_size(words).is_err(), "{words:?}");
        }
        assert!(workgroup_size(&[MAGIC, 0, 0, 0, 0, (4 << 16) | 17, 1]).is_err());
    }

    #[test]
    fn combined_samplers_are_refused() {
        let words = [
            MAGIC,
            0,
            0,
            0,
            0,
            (3 << 16) | 27,
            7,
            6, // %7 = OpTypeSampledImage %6
            (4 << 16) | 32,
            8,
            0,
            7, // %8 = OpTypePointer UniformConstant %7
        ];
        let failure = workgroup_size(&words).unwrap_err();
        assert!(failure.message.contains("combined"), "{failure}");
    }
}
