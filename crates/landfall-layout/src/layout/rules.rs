//! The layout rules: alignment, size and strides of every type under std140, std430, scalar and
//! WGSL.
//!
//! Each arm cites the rule it applies: OpenGL 4.6 §7.6.2.2 for std140 and std430,
//! `GL_EXT_scalar_block_layout` for scalar, and sections of the WGSL specification.

use crate::shape::{ArrayLen, MatrixLayout, Member, Rules, Type};

/// An alignment in bytes, a power of two.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Alignment(u64);

impl Alignment {
    /// One byte: no constraint.
    pub const ONE: Alignment = Alignment(1);
    /// Sixteen bytes: a `vec4`.
    pub const VEC4: Alignment = Alignment(16);

    /// Returns an alignment of `bytes`; `None` unless it is a power of two.
    pub fn new(bytes: u64) -> Option<Alignment> {
        bytes.is_power_of_two().then_some(Alignment(bytes))
    }

    /// The alignment in bytes.
    pub fn bytes(self) -> u64 {
        self.0
    }

    /// Rounds `offset` up to this alignment.
    pub fn round_up(self, offset: u64) -> Result<u64, TooLarge> {
        offset.checked_next_multiple_of(self.0).ok_or(TooLarge)
    }

    /// Whether `offset` is a multiple of this alignment.
    pub fn divides(self, offset: u64) -> bool {
        offset.is_multiple_of(self.0)
    }
}

/// A size or offset that overflows 64 bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooLarge;

/// The rule that a [`TypeLayout`] follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Rule {
    /// A scalar.
    Scalar,
    /// A vector of two or four components.
    Vector2Or4,
    /// A vector of three components.
    Vector3,
    /// An array of scalars or vectors.
    ArrayOfVectors,
    /// A column-major matrix.
    ColumnMajor,
    /// An array of column-major matrices.
    ArrayOfColumnMajor,
    /// A row-major matrix.
    RowMajor,
    /// An array of row-major matrices.
    ArrayOfRowMajor,
    /// A structure.
    Structure,
    /// An array of structures.
    ArrayOfStructures,
    /// A 64-bit address.
    Address,
}

impl Rule {
    /// Returns the rule's citation: `std140 rule 4`, `WGSL §14.4.1`.
    pub fn cite(self, rules: Rules) -> String {
        let number = match self {
            Rule::Scalar => 1,
            Rule::Vector2Or4 => 2,
            Rule::Vector3 => 3,
            Rule::ArrayOfVectors => 4,
            Rule::ColumnMajor => 5,
            Rule::ArrayOfColumnMajor => 6,
            Rule::RowMajor => 7,
            Rule::ArrayOfRowMajor => 8,
            Rule::Structure => 9,
            Rule::ArrayOfStructures => 10,
            Rule::Address => return "GL_EXT_buffer_reference".to_string(),
        };
        match rules {
            Rules::Std140 | Rules::Std430 => format!("{} rule {number}", rules.name()),
            Rules::Scalar => "GL_EXT_scalar_block_layout".to_string(),
            Rules::Explicit(_) => "the module's decorations".to_string(),
            Rules::Wgsl => match self {
                Rule::Structure => "WGSL §14.4.2".to_string(),
                Rule::ArrayOfVectors
                | Rule::ArrayOfColumnMajor
                | Rule::ArrayOfRowMajor
                | Rule::ArrayOfStructures => "WGSL §14.4.3".to_string(),
                _ => "WGSL §14.4.1".to_string(),
            },
        }
    }

    /// Returns the text of the rule, in one line.
    pub fn text(self, rules: Rules) -> &'static str {
        let packed = rules == Rules::Scalar;
        let rounded = rules == Rules::Std140;
        if let Rules::Explicit(_) = rules {
            return "SPIR-V gives the offset of each member and the stride of each array";
        }
        match self {
            Rule::Scalar => "a scalar is aligned to its size",
            Rule::Vector2Or4 | Rule::Vector3 if packed => "a vector is aligned to its component",
            Rule::Vector2Or4 => "a vector of 2 or 4 components is aligned to its size",
            Rule::Vector3 => "a vector of 3 components is aligned to 4 of them",
            Rule::ArrayOfVectors if rounded => {
                "an array's alignment and stride are its element's, rounded up to 16"
            }
            Rule::ArrayOfVectors => {
                "an array's stride is its element's size, rounded up to its alignment"
            }
            Rule::ColumnMajor => "a column-major matrix is an array of its columns",
            Rule::ArrayOfColumnMajor => {
                "an array of column-major matrices is an array of all columns"
            }
            Rule::RowMajor => "a row-major matrix is an array of its rows",
            Rule::ArrayOfRowMajor => "an array of row-major matrices is an array of all rows",
            Rule::Structure if rounded => {
                "a structure is aligned to its largest member, rounded up to 16, and padded to that"
            }
            Rule::Structure => "a structure is aligned to its largest member and padded to that",
            Rule::ArrayOfStructures => "an array of structures: each element is laid out in order",
            Rule::Address => "an address is 8 bytes, aligned to 8",
        }
    }
}

/// The alignment, size and strides of a type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct TypeLayout {
    /// The alignment.
    pub align: Alignment,
    /// Size in bytes: a `vec3` is 12, an array stride × count, a structure is rounded up to its
    /// alignment. `None` if it ends in a runtime-sized array.
    pub size: Option<u64>,
    /// Distance between elements of an array.
    pub array_stride: Option<u64>,
    /// Distance between columns (rows, if row-major) of a matrix or an array of matrices.
    pub matrix_stride: Option<u64>,
    /// The rule that determines it.
    pub rule: Rule,
}

/// Returns the layout of a type under `rules`; matrices are stored by `matrix_layout`. Under
/// [`Rules::Explicit`], whose numbers no type has, it is that of scalar.
pub fn type_layout(
    ty: &Type,
    rules: Rules,
    matrix_layout: MatrixLayout,
) -> Result<TypeLayout, TooLarge> {
    match ty {
        // Rule 1; WGSL §14.4.1: a scalar is aligned to its size.
        Type::Scalar(scalar) | Type::Atomic(scalar) => {
            Ok(vector_layout(scalar.width.into(), 1, rules))
        }
        // GL_EXT_buffer_reference: a reference is laid out as a 64-bit integer.
        Type::Address(_) => Ok(TypeLayout { rule: Rule::Address, ..vector_layout(8, 1, rules) }),
        // Rules 2 and 3; WGSL §14.4.1.
        Type::Vector { scalar, rows } => Ok(vector_layout(scalar.width.into(), *rows, rules)),
        // Rules 5 and 7: a matrix is an array of its columns (or rows); WGSL §14.4.1 likewise.
        Type::Matrix { scalar, columns, rows } => {
            let (count, length, rule) = match matrix_layout {
                MatrixLayout::Column => (*columns, *rows, Rule::ColumnMajor),
                MatrixLayout::Row => (*rows, *columns, Rule::RowMajor),
            };
            let vector = vector_layout(scalar.width.into(), length, rules);
            let array = array_of(vector, &ArrayLen::Fixed(count.into()), rules, rule)?;
            Ok(TypeLayout { array_stride: None, matrix_stride: array.array_stride, ..array })
        }
        // Rules 4, 6, 8 and 10; WGSL §14.4.3.
        // The rule cited is that of the innermost element, which an array of arrays is an array of.
        Type::Array { element, len } => {
            let rule = match (element.innermost(), matrix_layout) {
                (Type::Matrix { .. }, MatrixLayout::Column) => Rule::ArrayOfColumnMajor,
                (Type::Matrix { .. }, MatrixLayout::Row) => Rule::ArrayOfRowMajor,
                (Type::Struct(_), _) => Rule::ArrayOfStructures,
                _ => Rule::ArrayOfVectors,
            };
            array_of(type_layout(element, rules, matrix_layout)?, len, rules, rule)
        }
        // Rule 9; WGSL §14.4.2.
        Type::Struct(s) => {
            let mut cursor = Cursor::new(rules);
            for member in &s.members {
                cursor.place(member, matrix_layout)?;
            }
            cursor.structure()
        }
    }
}

/// Returns the layout of a vector, or of a scalar if `components` is 1.
fn vector_layout(width: u64, components: u8, rules: Rules) -> TypeLayout {
    let (align, rule) = match (rules, components) {
        (_, 1) => (width, Rule::Scalar),
        // GL_EXT_scalar_block_layout: a vector is aligned like its component.
        (Rules::Scalar | Rules::Explicit(_), 3) => (width, Rule::Vector3),
        (Rules::Scalar | Rules::Explicit(_), _) => (width, Rule::Vector2Or4),
        // Rule 3: three components are aligned like four.
        (_, 3) => (4 * width, Rule::Vector3),
        // Rule 2.
        (_, n) => (u64::from(n) * width, Rule::Vector2Or4),
    };
    TypeLayout {
        align: Alignment::new(align).expect("1, 2 or 4 components of 1, 2, 4 or 8 bytes"),
        size: Some(width * u64::from(components)),
        array_stride: None,
        matrix_stride: None,
        rule,
    }
}

/// Returns the layout of an array of elements with layout `element`.
fn array_of(
    element: TypeLayout,
    len: &ArrayLen,
    rules: Rules,
    rule: Rule,
) -> Result<TypeLayout, TooLarge> {
    // Rule 4: std140 rounds the alignment of every array up to that of a vec4; the others do not.
    let align = match rules {
        Rules::Std140 => element.align.max(Alignment::VEC4),
        Rules::Std430 | Rules::Scalar | Rules::Wgsl | Rules::Explicit(_) => element.align,
    };
    // The parsers reject arrays whose elements have no size.
    let element_size = element.size.unwrap_or(0);
    let stride = align.round_up(element_size)?;
    let size = match len {
        ArrayLen::Fixed(n) => {
            let whole = stride.checked_mul((*n).into()).ok_or(TooLarge)?;
            Some(match rules {
                Rules::Std140 | Rules::Std430 | Rules::Wgsl => whole,
                // GL_EXT_scalar_block_layout: the next member follows the last byte consumed, so
                // the padding after the last element is not part of the array.
                Rules::Scalar | Rules::Explicit(_) => whole - (stride - element_size),
            })
        }
        ArrayLen::Runtime | ArrayLen::Override(_) => None,
    };
    // The matrix stride passes through: an array of matrices is an array of all their columns.
    Ok(TypeLayout {
        align,
        size,
        array_stride: Some(stride),
        matrix_stride: element.matrix_stride,
        rule,
    })
}

/// The placement of a member.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Placed {
    /// Offset from the start of the enclosing structure or block.
    pub offset: u64,
    /// The layout of its type, with `align` and `size` after attributes.
    pub type_layout: TypeLayout,
    /// The matrix storage in effect.
    pub matrix_layout: MatrixLayout,
}

/// Places the members of a structure or block one after another.
#[derive(Clone, Copy, Debug)]
pub struct Cursor {
    rules: Rules,
    /// End of the last member placed; `None` after a runtime-sized one.
    end: Option<u64>,
    /// The furthest end of any member; a runtime-sized one counts as one element.
    furthest: u64,
    align: Alignment,
}

impl Cursor {
    /// Starts at offset 0 of a structure or block.
    pub fn new(rules: Rules) -> Cursor {
        Cursor { rules, end: Some(0), furthest: 0, align: Alignment::ONE }
    }

    /// Places the next member. Matrices without a majorness of their own are stored by `inherited`.
    pub fn place(&mut self, member: &Member, inherited: MatrixLayout) -> Result<Placed, TooLarge> {
        let matrix_layout = member.matrix_layout.unwrap_or(inherited);
        let mut type_layout = type_layout(&member.ty, self.rules, matrix_layout)?;
        // GLSL 4.60 §4.4.5 `align`: the greater of it and the type's alignment; WGSL §14.4.2
        // `@align`.
        // No power of two: reported where attributes are checked, and without effect here.
        if let Some(align) = member.align.and_then(|written| Alignment::new(written.value)) {
            type_layout.align = type_layout.align.max(align);
        }
        // WGSL §14.4.2 `@size`.
        if let Some(size) = member.size {
            type_layout.size = type_layout.size.map(|own| own.max(size.value));
        }
        // GLSL 4.60 §4.4.5 `offset`: start there instead of after the preceding member; `align`
        // rounds the start up afterwards.
        let start = match member.offset {
            Some(written) => written.value,
            None => self.end.unwrap_or(self.furthest),
        };
        let offset = type_layout.align.round_up(start)?;
        let end = match type_layout.size {
            Some(size) => Some(offset.checked_add(size).ok_or(TooLarge)?),
            None => None,
        };
        // A runtime-sized array reserves one element, the least that a buffer must hold.
        let one_element = type_layout.array_stride.unwrap_or(0);
        let reach = end.map_or_else(|| offset.checked_add(one_element).ok_or(TooLarge), Ok)?;
        self.end = end;
        self.furthest = self.furthest.max(reach);
        self.align = self.align.max(type_layout.align);
        Ok(Placed { offset, type_layout, matrix_layout })
    }

    /// The end of the last member placed; `None` after a runtime-sized one.
    pub fn end(&self) -> Option<u64> {
        self.end
    }

    /// The furthest end of any member placed so far; a runtime-sized one counts as one element.
    pub fn furthest(&self) -> u64 {
        self.furthest
    }

    /// Returns the layout of the structure with the members placed so far.
    pub fn structure(self) -> Result<TypeLayout, TooLarge> {
        // Rule 9: std140 rounds a structure's alignment up to that of a vec4.
        let align = match self.rules {
            Rules::Std140 => self.align.max(Alignment::VEC4),
            Rules::Std430 | Rules::Scalar | Rules::Wgsl | Rules::Explicit(_) => self.align,
        };
        let size = match (self.end, self.rules) {
            (None, _) => None,
            // GL_EXT_scalar_block_layout: a structure ends with its last member.
            (Some(_), Rules::Scalar | Rules::Explicit(_)) => Some(self.furthest),
            (Some(_), Rules::Std140 | Rules::Std430 | Rules::Wgsl) => {
                Some(align.round_up(self.furthest)?)
            }
        };
        Ok(TypeLayout {
            align,
            size,
            array_stride: None,
            matrix_stride: None,
            rule: Rule::Structure,
        })
    }
}
