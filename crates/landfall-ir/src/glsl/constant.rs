//! Constant expressions: array sizes, indices, `case` labels, constants that are whole numbers.
//!
//! Values of floating point are computed here only on the way to a whole number: where a
//! shader computes with a constant, its expression is lowered as it stands.

use super::ast::*;
use super::carrier::builtin;
use super::types::{Kind, Ty};

/// The value of a constant expression.
#[derive(Clone, Debug, PartialEq)]
pub enum Const {
    Bool(bool),
    Int(i32),
    Uint(u32),
    Float(f64),
    List(Vec<Const>),
}

/// A constant has at most this many elements.
const MOST_ELEMENTS: usize = 1 << 16;

/// Evaluates; `None` when it is no constant expression, or none that matters here.
pub fn evaluate(e: &Expr<'_>, look_up: &dyn Fn(&str) -> Option<Const>) -> Option<Const> {
    let of = |e: &Expr<'_>| evaluate(e, look_up);
    match &e.kind {
        ExprKind::Number(text) => literal(text).map(|(value, _)| value),
        ExprKind::Bool(value) => Some(Const::Bool(*value)),
        ExprKind::Name(name) => look_up(name),
        ExprKind::Unary(op, inner) => unary(*op, of(inner)?),
        ExprKind::Binary(op, a, b) => binary(*op, of(a)?, of(b)?),
        ExprKind::Choose(parts) => {
            let [condition, accept, reject] = &**parts;
            match of(condition)? {
                Const::Bool(true) => of(accept),
                Const::Bool(false) => of(reject),
                _ => None,
            }
        }
        ExprKind::Index(base, index) => {
            let Const::List(items) = of(base)? else { return None };
            items.get(usize::try_from(of(index)?.integer()?).ok()?).cloned()
        }
        ExprKind::Member(base, name) => {
            let Const::List(items) = of(base)? else { return None };
            let picks = super::place::selection(name.text, items.len())?;
            let mut picked: Vec<_> =
                picks.iter().map(|&i| items.get(i as usize).cloned()).collect::<Option<_>>()?;
            Some(if picked.len() == 1 { picked.swap_remove(0) } else { Const::List(picked) })
        }
        ExprKind::Length(base) => match of(base)? {
            Const::List(items) => i32::try_from(items.len()).ok().map(Const::Int),
            _ => None,
        },
        ExprKind::Construct(ty, arguments) => {
            let TypeBase::Name(name) = ty.base else { return None };
            let arguments: Vec<Const> = arguments.iter().map(of).collect::<Option<_>>()?;
            if !ty.dims.is_empty() {
                return (arguments.len() <= MOST_ELEMENTS).then_some(Const::List(arguments));
            }
            construct(&builtin(name)?, arguments)
        }
        ExprKind::Call(name, arguments) => {
            let arguments: Vec<Const> = arguments.iter().map(of).collect::<Option<_>>()?;
            call(name.text, &arguments)
        }
        ExprKind::Assign(..) | ExprKind::Step(..) | ExprKind::Comma(..) | ExprKind::List(_) => None,
    }
}

impl Const {
    pub fn integer(&self) -> Option<i64> {
        match self {
            Const::Int(value) => Some((*value).into()),
            Const::Uint(value) => Some((*value).into()),
            Const::Bool(_) | Const::Float(_) | Const::List(_) => None,
        }
    }

    fn float(&self) -> Option<f64> {
        match self {
            Const::Int(value) => Some((*value).into()),
            Const::Uint(value) => Some((*value).into()),
            Const::Float(value) => Some(*value),
            Const::Bool(_) | Const::List(_) => None,
        }
    }

    /// As a scalar of that kind.
    pub fn to(&self, kind: Kind) -> Option<Const> {
        Some(match (kind, self) {
            (Kind::Bool, Const::Bool(value)) => Const::Bool(*value),
            (Kind::Bool, _) => Const::Bool(self.float()? != 0.0),
            (_, Const::Bool(value)) => Const::Int(i32::from(*value)).to(kind)?,
            (Kind::Int, Const::Uint(value)) => Const::Int(*value as i32),
            (Kind::Uint, Const::Int(value)) => Const::Uint(*value as u32),
            (Kind::Int, Const::Int(_)) | (Kind::Uint, Const::Uint(_)) => self.clone(),
            (Kind::Int, _) => Const::Int(self.float()? as i32),
            (Kind::Uint, _) => Const::Uint(self.float()? as i64 as u32),
            (Kind::Float | Kind::Double | Kind::Half, _) => Const::Float(self.float()?),
            (Kind::Short | Kind::Ushort | Kind::Long | Kind::Ulong, _) => return None,
        })
    }
}

/// A literal's value and kind (GLSL 4.60 §4.1.3, §4.1.4). The value of a float is exact as f64.
pub fn literal(text: &str) -> Option<(Const, Kind)> {
    let lower = text.to_ascii_lowercase();
    let hex = lower.strip_prefix("0x");
    if hex.is_none() && (lower.contains(['.', 'e']) || lower.ends_with('f')) {
        let (digits, kind) = match (lower.strip_suffix("lf"), lower.strip_suffix("hf")) {
            (Some(digits), _) => (digits, Kind::Double),
            (_, Some(digits)) => (digits, Kind::Half),
            _ => (lower.trim_end_matches('f'), Kind::Float),
        };
        return Some((Const::Float(digits.parse().ok()?), kind));
    }
    let bare = hex.unwrap_or(&lower);
    let digits = bare.trim_end_matches(['u', 'l', 's']);
    let suffix = &bare[digits.len()..];
    let kind = match suffix {
        "" => Kind::Int,
        "u" => Kind::Uint,
        "l" => Kind::Long,
        "ul" => Kind::Ulong,
        "s" => Kind::Short,
        "us" => Kind::Ushort,
        _ => return None,
    };
    let radix = match hex {
        Some(_) => 16,
        None if digits.len() > 1 && digits.starts_with('0') => 8,
        None => 10,
    };
    let bits = u64::from_str_radix(digits, radix).ok()?;
    let small = u32::try_from(bits).ok()?;
    Some((if kind == Kind::Int { Const::Int(small as i32) } else { Const::Uint(small) }, kind))
}

fn unary(op: Unary, value: Const) -> Option<Const> {
    if let Const::List(items) = value {
        return items.into_iter().map(|v| unary(op, v)).collect::<Option<_>>().map(Const::List);
    }
    Some(match (op, value) {
        (Unary::Plus, value) => value,
        (Unary::Minus, Const::Int(value)) => Const::Int(value.wrapping_neg()),
        (Unary::Minus, Const::Uint(value)) => Const::Uint(value.wrapping_neg()),
        (Unary::Minus, Const::Float(value)) => Const::Float(-value),
        (Unary::Not, Const::Bool(value)) => Const::Bool(!value),
        (Unary::Complement, Const::Int(value)) => Const::Int(!value),
        (Unary::Complement, Const::Uint(value)) => Const::Uint(!value),
        (Unary::Minus | Unary::Not | Unary::Complement, _) => return None,
    })
}

fn binary(op: Binary, a: Const, b: Const) -> Option<Const> {
    if matches!(a, Const::List(_)) || matches!(b, Const::List(_)) {
        return None; // sums of vectors are no sizes
    }
    if let (Const::Bool(a), Const::Bool(b)) = (&a, &b) {
        let (a, b) = (*a, *b);
        return Some(Const::Bool(match op {
            Binary::And => a && b,
            Binary::Or => a || b,
            Binary::Xor | Binary::NotEqual => a != b,
            Binary::Equal => a == b,
            _ => return None,
        }));
    }
    if let (Some(x), Some(y)) = (a.integer(), b.integer()) {
        let unsigned = matches!(a, Const::Uint(_)) || matches!(b, Const::Uint(_));
        return integers(op, x, y, unsigned);
    }
    let (x, y) = (a.float()?, b.float()?);
    Some(match op {
        Binary::Add => Const::Float(x + y),
        Binary::Subtract => Const::Float(x - y),
        Binary::Multiply => Const::Float(x * y),
        Binary::Divide => Const::Float(x / y),
        Binary::Less => Const::Bool(x < y),
        Binary::LessEqual => Const::Bool(x <= y),
        Binary::Greater => Const::Bool(x > y),
        Binary::GreaterEqual => Const::Bool(x >= y),
        Binary::Equal => Const::Bool(x == y),
        Binary::NotEqual => Const::Bool(x != y),
        _ => return None,
    })
}

fn integers(op: Binary, x: i64, y: i64, unsigned: bool) -> Option<Const> {
    let whole = |value: i64| {
        Some(if unsigned { Const::Uint(value as u32) } else { Const::Int(value as i32) })
    };
    match op {
        Binary::Add => whole(x.wrapping_add(y)),
        Binary::Subtract => whole(x.wrapping_sub(y)),
        Binary::Multiply => whole(x.wrapping_mul(y)),
        Binary::Divide => whole(x.checked_div(y)?),
        Binary::Modulo => whole(x.checked_rem(y)?),
        Binary::ShiftLeft => whole(x.checked_shl(u32::try_from(y).ok().filter(|&s| s < 32)?)?),
        Binary::ShiftRight => whole(x.checked_shr(u32::try_from(y).ok().filter(|&s| s < 32)?)?),
        Binary::BitAnd => whole(x & y),
        Binary::BitOr => whole(x | y),
        Binary::BitXor => whole(x ^ y),
        Binary::Less => Some(Const::Bool(x < y)),
        Binary::LessEqual => Some(Const::Bool(x <= y)),
        Binary::Greater => Some(Const::Bool(x > y)),
        Binary::GreaterEqual => Some(Const::Bool(x >= y)),
        Binary::Equal => Some(Const::Bool(x == y)),
        Binary::NotEqual => Some(Const::Bool(x != y)),
        Binary::And | Binary::Or | Binary::Xor => None,
    }
}

fn construct(ty: &Ty, arguments: Vec<Const>) -> Option<Const> {
    let (kind, size) = ty.components()?;
    let mut components = Vec::new();
    for argument in arguments {
        match argument {
            Const::List(items) => components.extend(items),
            single => components.push(single),
        }
    }
    let converted: Vec<Const> = components.iter().map(|c| c.to(kind)).collect::<Option<_>>()?;
    match (size as usize, converted.len()) {
        (1, count) if count > 0 => converted.into_iter().next(),
        (size, 1) => Some(Const::List(vec![converted[0].clone(); size])),
        (size, count) if count >= size => Some(Const::List(converted[..size].to_vec())),
        _ => None,
    }
}

fn call(name: &str, arguments: &[Const]) -> Option<Const> {
    match (name, arguments) {
        ("min" | "max", [a, b]) => {
            let less = match binary(Binary::Less, a.clone(), b.clone())? {
                Const::Bool(less) => less,
                _ => return None,
            };
            Some(if less == (name == "min") { a.clone() } else { b.clone() })
        }
        ("abs", [Const::Int(a)]) => Some(Const::Int(a.wrapping_abs())),
        ("floor", [Const::Float(a)]) => Some(Const::Float(a.floor())),
        ("ceil", [Const::Float(a)]) => Some(Const::Float(a.ceil())),
        ("sqrt", [Const::Float(a)]) => Some(Const::Float(a.sqrt())),
        _ => None,
    }
}
