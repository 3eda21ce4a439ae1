//! A GLSL value as the scalars that are loaded from words or stored to them.
//!
//! Built from a plain type, or from a member of a block whose carrier differs from its GLSL type:
//! rows of a matrix, integers for bools. Used by [`text`](super::text).

use std::fmt::Write as _;

use super::packing::width;
use landfall_interp::ValueType;
use landfall_layout::layout::MemberLayout;
use landfall_layout::shape::{ArrayLen, Scalar, ScalarKind, Type};

/// The scalars of a value; word positions are relative to the value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Piece {
    /// A scalar: its access path, its type in the text, its word.
    Scalar { path: String, scalar: Scalar, word: u32 },
    /// An array: its access path, and the pieces of its first element.
    Array { path: String, len: u32, step: u32, word: u32, element: Vec<Piece> },
}

/// A 1 that compilers cannot fold: Mesa unrolls loops of hundreds of iterations, and LLVM compiles
/// those for minutes (22.3.6).
pub(super) const ONE: &str = "landfall_one";

const ROWS: [&str; 4] = ["x", "y", "z", "w"];

/// Returns the pieces of a value of a plain type.
pub(super) fn value_pieces(ty: &ValueType, new: &dyn Fn(&str) -> String) -> Vec<Piece> {
    pieces(ty, None, new).expect("a call of more words has no places")
}

/// Returns the pieces of a member of a block, whose words are those of `carried`; `None` if the two
/// do not correspond.
pub(super) fn member(
    layout: &MemberLayout,
    carried: &ValueType,
    new: &dyn Fn(&str) -> String,
) -> Option<Vec<Piece>> {
    pieces(carried, Some((layout, &layout.ty)), new)
}

/// The block member that a value is, and its type in the text; `None` if the type is that of its
/// carrier.
type OwnMember<'a> = Option<(&'a MemberLayout, &'a Type)>;

fn pieces(
    carried: &ValueType,
    own: OwnMember<'_>,
    new: &dyn Fn(&str) -> String,
) -> Option<Vec<Piece>> {
    let mut pieces = Vec::new();
    push(carried, own, String::new(), new, &mut 0, &mut pieces)?;
    Some(pieces)
}

fn push(
    carried: &ValueType,
    own: OwnMember<'_>,
    path: String,
    new: &dyn Fn(&str) -> String,
    word: &mut u32,
    to: &mut Vec<Piece>,
) -> Option<()> {
    let mut scalar = |path: String, scalar: Scalar| {
        to.push(Piece::Scalar { path, scalar, word: *word });
        *word += width(scalar.width);
    };
    // `carried` is the type in the module and `own` that in the text: a bool of a block is carried
    // as an integer, a row-major matrix as the array of its rows.
    match (carried, own) {
        (ValueType::Scalar(one), None) | (ValueType::Scalar(_), Some((_, Type::Scalar(one)))) => {
            scalar(path, *one)
        }
        (ValueType::Vector { rows: held, .. }, Some((_, Type::Vector { rows, .. })))
            if rows != held =>
        {
            return None;
        }
        (ValueType::Vector { scalar: one, rows }, None)
        | (ValueType::Vector { .. }, Some((_, Type::Vector { scalar: one, rows }))) => {
            ROWS[..usize::from(*rows).min(4)]
                .iter()
                .for_each(|row| scalar(format!("{path}.{row}"), *one));
        }
        (ValueType::Matrix { scalar: one, columns, rows }, None)
        | (ValueType::Matrix { .. }, Some((_, Type::Matrix { scalar: one, columns, rows }))) => {
            for column in 0..*columns {
                (0..*rows).for_each(|row| scalar(format!("{path}[{column}][{row}]"), *one));
            }
        }
        (
            ValueType::Array { element, len },
            Some((layout, Type::Matrix { scalar: one, columns, rows })),
        ) => {
            let (outer, inner) =
                if layout.row_major { (*rows, *columns) } else { (*columns, *rows) };
            let ValueType::Vector { rows: held, .. } = **element else { return None };
            if (*len, held) != (u32::from(outer), inner) {
                return None;
            }
            for i in 0..outer {
                for j in 0..inner {
                    let (column, row) = if layout.row_major { (j, i) } else { (i, j) };
                    scalar(format!("{path}[{column}][{row}]"), *one);
                }
            }
        }
        (ValueType::Array { element, len }, _) => {
            let own = match own {
                None => None,
                Some((layout, Type::Array { element, len: ArrayLen::Fixed(own) }))
                    if own == len =>
                {
                    Some((layout, &**element))
                }
                Some(_) => return None,
            };
            let mut pieces = Vec::new();
            let mut step = 0;
            // The words of an element count from its beginning.
            push(element, own, String::new(), new, &mut step, &mut pieces)?;
            to.push(Piece::Array { path, len: *len, step, word: *word, element: pieces });
            *word = word.checked_add(step.checked_mul(*len)?)?;
        }
        (ValueType::Struct { members, .. }, None | Some((_, Type::Struct(_)))) => {
            for (name, carried) in members {
                let own = match own {
                    None => None,
                    Some((layout, _)) => {
                        let member = layout.members.iter().find(|m| *m.name == **name)?;
                        Some((member, &member.ty))
                    }
                };
                push(carried, own, format!("{path}.{}", new(name)), new, word, to)?;
            }
        }
        (
            ValueType::Scalar(_)
            | ValueType::Vector { .. }
            | ValueType::Matrix { .. }
            | ValueType::Struct { .. },
            Some(_),
        ) => return None,
    }
    Some(())
}

/// The direction in which words move.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum WordDirection {
    Load,
    Store,
}

/// Appends statements that move the words of `pieces` between `name` and the words of `buffer` from
/// index `from` on.
pub(super) fn moves(
    text: &mut String,
    pieces: &[Piece],
    way: WordDirection,
    (name, buffer, from): (&str, &str, &str),
) {
    nested(text, pieces, way, (name, buffer, from), 1);
}

fn nested(
    text: &mut String,
    pieces: &[Piece],
    way: WordDirection,
    (name, buffer, from): (&str, &str, &str),
    depth: usize,
) {
    let space = "    ".repeat(depth);
    for piece in pieces {
        match piece {
            Piece::Scalar { path, scalar, word } => {
                let at = |more: u32| format!("{buffer}[{from} + {}u]", word + more);
                let place = format!("{name}{path}");
                let line = match way {
                    WordDirection::Load => format!("{place} = {};", loaded(*scalar, at)),
                    WordDirection::Store => stored(*scalar, &place, at),
                };
                let _ = writeln!(text, "{space}{line}");
            }
            Piece::Array { path, len, step, word, element } => {
                // Loops may be nested, so that each depth has a counter of its own.
                let i = format!("landfall_i{depth}");
                let _ = writeln!(text, "{space}for (uint {i} = 0u; {i} < {len}u; {i} += {ONE}) {{");
                let from = format!("{from} + {word}u + {i} * {step}u");
                let name = format!("{name}{path}[{i}]");
                nested(text, element, way, (&name, buffer, &from), depth + 1);
                let _ = writeln!(text, "{space}}}");
            }
        }
    }
}

/// Returns an expression that assembles a scalar from its words.
fn loaded(scalar: Scalar, at: impl Fn(u32) -> String) -> String {
    let (low, both) = (at(0), || format!("uvec2({}, {})", at(0), at(1)));
    match (scalar.kind, scalar.width) {
        (ScalarKind::Bool, _) => format!("{low} != 0u"),
        (ScalarKind::Uint, 8) => format!("packUint2x32({})", both()),
        (ScalarKind::Sint, 8) => format!("int64_t(packUint2x32({}))", both()),
        (ScalarKind::Float, 8) => format!("packDouble2x32({})", both()),
        (ScalarKind::Uint, 4) => low,
        (ScalarKind::Sint, 4) => format!("int({low})"),
        (ScalarKind::Float, 4) => format!("uintBitsToFloat({low})"),
        (ScalarKind::Uint, width) => format!("uint{}_t({low})", width * 8),
        (ScalarKind::Sint, width) => format!("int{}_t(int({low}))", width * 8),
        // No other kind is lowered.
        _ => {
            format!("float16_t(uintBitsToFloat({low}))")
        }
    }
}

/// Returns a statement that stores a scalar's words.
fn stored(scalar: Scalar, place: &str, at: impl Fn(u32) -> String) -> String {
    let low = at(0);
    let both = |halves: &str| {
        let high = at(1);
        format!(
            "{{ uvec2 landfall_halves = {halves}; {low} = landfall_halves.x; \
             {high} = landfall_halves.y; }}"
        )
    };
    match (scalar.kind, scalar.width) {
        (ScalarKind::Bool, _) => format!("{low} = {place} ? 1u : 0u;"),
        (ScalarKind::Uint | ScalarKind::Sint, 8) => {
            both(&format!("unpackUint2x32(uint64_t({place}))"))
        }
        (ScalarKind::Float, 8) => both(&format!("unpackDouble2x32({place})")),
        (ScalarKind::Sint, width) if width < 4 => format!("{low} = uint(int({place}));"),
        (ScalarKind::Uint | ScalarKind::Sint, _) => format!("{low} = uint({place});"),
        // No other kind is lowered.
        _ => {
            format!("{low} = floatBitsToUint(float({place}));")
        }
    }
}
