//! Leaves whose type is known at run time only, written as numbers.

use super::error::BufferError;
use super::float::narrow;
use super::grid::{ByteExtent, ComponentGrid, Dim};
use super::resolve::resolve_leaf;
use super::value::put_bits;
use crate::layout::BlockLayout;
use crate::shape::{Scalar, ScalarKind};

/// The components of a leaf, or of that leaf in each element of an array.
///
/// Unlike a [`Handle`](super::Handle), it has no Rust type, and writes into bytes of the block
/// wherever they are.
#[derive(Clone, Debug)]
pub struct Components {
    offset: usize,
    grid: ComponentGrid,
    /// The array whose index the path leaves open.
    array: Option<Dim>,
}

impl Components {
    /// Resolves a path; `[]` leaves the index of one array open: `data[].color`.
    ///
    /// # Errors
    /// A path that does not exist, does not end at a leaf, has an index out of range or two open
    /// indices; a block of unknown size.
    pub fn new(block: &BlockLayout, path: &str) -> Result<Components, BufferError> {
        // Only for its errors: a block without fixed offsets has no components to write.
        ByteExtent::from_block(block)?;
        let mut dims = Vec::new();
        let (offset, grid) = resolve_leaf(block, 0, path, Some(&mut |dim| dims.push(dim)))?;
        // Of the open indices, outermost first, one is left to `write`.
        if let [_, inner, ..] = dims[..] {
            let len = inner.len.unwrap_or(0) as u64;
            return Err(BufferError::MissingIndex { path: path.to_string(), len });
        }
        Ok(Components { offset, grid, array: dims.first().copied() })
    }

    /// The type of a component.
    pub fn scalar(&self) -> Scalar {
        self.grid.scalar
    }

    /// Number of columns and rows; a scalar and a vector have one column.
    pub fn shape(&self) -> (usize, usize) {
        (self.grid.columns.into(), self.grid.rows.into())
    }

    /// Whether the path leaves an index open.
    pub fn is_array(&self) -> bool {
        self.array.is_some()
    }

    /// Number of elements of the open array; 1 if there is none, `None` if it is runtime-sized.
    pub fn elements(&self) -> Option<usize> {
        self.array.map_or(Some(1), |array| array.len)
    }

    /// Number of elements of the open array in that many bytes of the block.
    pub fn elements_in(&self, bytes: usize) -> usize {
        self.elements().unwrap_or_else(|| {
            let stride = self.array.map_or(0, |array| array.stride);
            // The leaf may start inside its element, so the last stride may be incomplete.
            bytes.saturating_sub(self.offset).div_ceil(stride.max(1))
        })
    }

    /// Writes an element's components, column by column: floats rounded to the nearest of their
    /// type, integers towards zero and clamped to the range of theirs. Returns how many lie inside
    /// `bytes`; the others are not written.
    pub fn write(&self, bytes: &mut [u8], element: usize, numbers: &[f64]) -> usize {
        let stride = self.array.map_or(0, |array| array.stride);
        let width = usize::from(self.grid.scalar.width);
        let mut written = 0;
        for (number, (column, row)) in numbers.iter().zip(self.grid.cells()) {
            let at = self.offset + element * stride + self.grid.component(column, row);
            if let Some(to) = bytes.get_mut(at..at + width) {
                put_bits(bits_of(self.grid.scalar, *number), to);
                written += 1;
            }
        }
        written
    }
}

/// Returns the bits of the float nearest to a number, or of the integer towards zero, clamped to
/// the range of its type; NaN is 0 as an integer, true as a bool.
fn bits_of(scalar: Scalar, number: f64) -> u64 {
    let unused = 64 - 8 * u32::from(scalar.width);
    match scalar.kind {
        ScalarKind::Bool => u64::from(number != 0.0),
        ScalarKind::Sint => {
            let (least, most) = (i64::MIN >> unused, i64::MAX >> unused);
            // `as` truncates towards zero, saturates at 64 bits and turns NaN to 0.
            (number as i64).clamp(least, most) as u64
        }
        ScalarKind::Uint => (number as u64).min(u64::MAX >> unused),
        ScalarKind::Float | ScalarKind::Bfloat | ScalarKind::FloatE5m2 | ScalarKind::FloatE4m3 => {
            narrow(scalar, number)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Options, Source, layout};

    const TEXT: &str = "#version 430
struct Light { vec3 color; int kind; };
layout(std430) buffer B { float scale; mat2x3 m; bool on; Light lights[2]; Light tail[]; };";

    fn block() -> BlockLayout {
        layout(&Source::new("a.frag", TEXT), &Options::default()).blocks.remove(0)
    }

    #[test]
    fn numbers_are_written_where_the_rules_of_std430_have_the_member() {
        // scale 0, m 16 (columns of 16 bytes), on 48, lights 64 (stride 16), tail 96 (stride 16).
        let (block, mut bytes) = (block(), vec![0; 96 + 3 * 16]);
        let mut write = |path, element, numbers: &[f64]| {
            Components::new(&block, path).unwrap().write(&mut bytes, element, numbers)
        };
        assert_eq!(write("scale", 0, &[0.5]), 1);
        assert_eq!(write("m", 0, &[1.0, 2.0, 3.0, 4.0]), 4);
        assert_eq!(write("on", 0, &[7.0]), 1);
        assert_eq!(write("lights[1].color", 0, &[5.0, 6.0, 7.0]), 3);
        assert_eq!(write("lights[].kind", 0, &[-3e9]), 1);
        assert_eq!(write("tail[].color", 2, &[8.0]), 1);
        assert_eq!(write("tail[].color", 3, &[9.0]), 0, "past the end");
        let float = |at: usize| f32::from_ne_bytes(bytes[at..at + 4].try_into().unwrap());
        assert_eq!(float(0), 0.5);
        assert_eq!([16, 20, 24, 32].map(float), [1.0, 2.0, 3.0, 4.0]);
        assert_eq!(bytes[48..52], 1u32.to_ne_bytes());
        assert_eq!([80, 84, 88].map(float), [5.0, 6.0, 7.0]);
        assert_eq!(bytes[76..80], i32::MIN.to_ne_bytes());
        assert_eq!(float(128), 8.0);
    }

    #[test]
    fn an_open_array_has_its_elements_and_a_path_without_one_has_one() {
        let block = block();
        let of = |path| Components::new(&block, path).unwrap();
        assert_eq!((of("scale").is_array(), of("scale").elements()), (false, Some(1)));
        assert_eq!(
            (of("lights[].kind").is_array(), of("lights[].kind").elements()),
            (true, Some(2))
        );
        assert_eq!(
            (of("tail[].kind").elements(), of("tail[].kind").elements_in(96 + 29)),
            (None, 2)
        );
        assert!(matches!(
            Components::new(&block, "lights[2].kind"),
            Err(BufferError::OutOfRange { index: 2, len: 2, .. })
        ));
        assert!(matches!(Components::new(&block, "lights"), Err(BufferError::NotALeaf { .. })));
    }
}
