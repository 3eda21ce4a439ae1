//! The names of scalars in a language.

use landfall_layout::shape::{Scalar, ScalarKind};

/// What a language calls numbers of 1, 2, 4 and 8 bytes.
pub(crate) struct ScalarNames {
    pub sint: [&'static str; 4],
    pub uint: [&'static str; 4],
    /// Empty where the language has none.
    pub float: [&'static str; 4],
}

impl ScalarNames {
    /// As Rust and Zig have them.
    pub const NUMBERED: ScalarNames = ScalarNames {
        sint: ["i8", "i16", "i32", "i64"],
        uint: ["u8", "u16", "u32", "u64"],
        float: ["", "f16", "f32", "f64"],
    };

    /// The name of a scalar; of one that the language lacks, that of its bits. A `bool` of a buffer
    /// is a 32-bit integer.
    pub fn of(&self, scalar: Scalar) -> &'static str {
        let at = match scalar.width {
            1 => 0,
            2 => 1,
            8 => 3,
            _ => 2,
        };
        match scalar.kind {
            ScalarKind::Sint => self.sint[at],
            ScalarKind::Float if !self.float[at].is_empty() => self.float[at],
            _ => self.uint[at],
        }
    }
}
