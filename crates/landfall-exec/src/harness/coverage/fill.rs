//! Generates contents for blocks and inputs without values: zeros, then small positive numbers with
//! integers that let every loop over an array run to its end.

use super::{spots, starts};
use crate::harness::bindings::zeros;
use landfall_interp::{Port, Words};
use landfall_ir::module::Module;
use landfall_layout::layout::BlockLayout;
use landfall_layout::named;
use landfall_layout::shape::{ArrayLen, Scalar, ScalarKind, Type};

named! {
    /// The generated contents of buffers.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub(crate) enum Filling {
        /// Zeros.
        Zeros = "zeros",
        /// Small positive floats; integers are the length of the longest array.
        Counts = "small numbers and the lengths of arrays",
        /// Small positive floats; integers are one.
        Ones = "small numbers and ones",
    }

    const ALL;
}

/// Returns the length of the longest array in any block.
pub(crate) fn longest(module: &Module) -> u32 {
    let leaves = module.blocks().iter().flat_map(|block| &block.layout.leaves);
    let lengths = leaves.flat_map(|leaf| &leaf.dims).filter_map(|len| match len {
        ArrayLen::Fixed(length) => Some(*length),
        ArrayLen::Runtime | ArrayLen::Override(_) => None,
    });
    lengths.max().unwrap_or(1)
}

/// Returns the bytes of a block.
pub(crate) fn fill(block: &BlockLayout, filling: Filling, longest: u32) -> Vec<u8> {
    let mut bytes = zeros(block);
    let whole = match filling {
        Filling::Zeros => return bytes,
        Filling::Counts => longest,
        Filling::Ones => 1,
    };
    for leaf in &block.leaves {
        let scalar = match &leaf.ty {
            Type::Scalar(scalar) | Type::Atomic(scalar) => *scalar,
            Type::Vector { scalar, .. } | Type::Matrix { scalar, .. } => *scalar,
            Type::Address(_) | Type::Struct(_) | Type::Array { .. } => continue,
        };
        let width = usize::from(scalar.width);
        let mut number = 0;
        for start in starts(leaf, bytes.len() as u64) {
            for at in spots(leaf).into_iter().flat_map(|spot| spot.step_by(width)) {
                number += 1;
                let at = (start + at) as usize;
                // The last element may be cut off.
                let Some(to) = bytes.get_mut(at..at + width) else { continue };
                to.copy_from_slice(&component(scalar, whole, number)[..width]);
            }
        }
    }
    bytes
}

/// Returns a component's bytes, in the first of eight.
fn component(scalar: Scalar, whole: u32, number: u32) -> [u8; 8] {
    // Seven numbers from 0.25 to 1.
    let float = 0.25 + f64::from(number % 7) * 0.125;
    let bits = match (scalar.kind, scalar.width) {
        (ScalarKind::Bool, _) => 1,
        // Within an `i8`.
        (ScalarKind::Sint | ScalarKind::Uint, 1) => u64::from(whole.min(100)),
        (ScalarKind::Sint | ScalarKind::Uint, _) => u64::from(whole),
        (ScalarKind::Float, 8) => float.to_bits(),
        (ScalarKind::Float, 4) => u64::from((float as f32).to_bits()),
        // 0.5 in half precision; zero for the other small formats.
        (ScalarKind::Float, _) => 0x3800,
        _ => 0,
    };
    bits.to_le_bytes()
}

/// Returns inputs for a number of invocations: zeros, or small numbers of both signs.
pub(super) fn inputs(
    ports: &[(Port, Vec<bool>)],
    filling: Filling,
    count: usize,
) -> Vec<(Port, Words)> {
    let numbers = |floats: bool, port: Port, nth: usize| -> Vec<u64> {
        let word = |lane: usize| match (port, floats) {
            (Port::VertexIndex | Port::InstanceIndex, _) => lane as u64,
            // Pixels of a square of eight by eight.
            (Port::Position, _) => {
                let pixel = if nth == 0 { lane % 8 } else { lane / 8 };
                let at = if nth < 2 { pixel as f32 + 0.5 } else { 1.0 };
                u64::from(at.to_bits())
            }
            (_, true) if filling != Filling::Zeros => {
                let number = ((lane * 5 + nth * 3) % 16) as f32 / 8.0 - 0.875;
                u64::from(number.to_bits())
            }
            (_, false) if filling != Filling::Zeros => 1,
            (_, _) => 0,
        };
        (0..count).map(word).collect()
    };
    let each = ports.iter().map(|(port, floats)| {
        let words = floats.iter().enumerate().map(|(nth, float)| numbers(*float, *port, nth));
        (*port, words.collect())
    });
    each.collect()
}
