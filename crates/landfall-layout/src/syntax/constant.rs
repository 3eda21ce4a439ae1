//! Values of constant expressions, with the operators and functions common to both languages. The
//! grammars are with each language.

use crate::shape::{Scalar, ScalarKind};

// Widths below 32 bits are values of 32 that `converted` wraps. Floats of all widths are computed
// as f64: a layout takes only integers that are converted from them.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    Bool(bool),
    /// WGSL's AbstractInt.
    Abstract(i64),
    Int(i32),
    Uint(u32),
    Long(i64),
    Ulong(u64),
    Float(f64),
    /// A vector or array, by components or elements.
    List(Vec<Value>),
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Fault {
    DivisionByZero,
    /// A result out of range of its type, where the language forbids wrapping.
    Overflow,
    Mismatch,
    /// An operator or function that is not implemented here.
    Unsupported,
}

/// The target of a conversion: the scalar constructors of both languages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Kind {
    Bool,
    Int,
    Uint,
    Long,
    Ulong,
    Float,
}

impl From<Scalar> for Kind {
    fn from(scalar: Scalar) -> Kind {
        match (scalar.kind, scalar.width) {
            (ScalarKind::Bool, _) => Kind::Bool,
            (ScalarKind::Sint, 8) => Kind::Long,
            (ScalarKind::Sint, _) => Kind::Int,
            (ScalarKind::Uint, 8) => Kind::Ulong,
            (ScalarKind::Uint, _) => Kind::Uint,
            (
                ScalarKind::Float
                | ScalarKind::Bfloat
                | ScalarKind::FloatE5m2
                | ScalarKind::FloatE4m3,
                _,
            ) => Kind::Float,
        }
    }
}

use Value::{Abstract, Bool, Float, Int, List, Long, Uint, Ulong};

impl Value {
    /// Returns the value as an integer, if it is one.
    pub fn integer(&self) -> Option<i128> {
        match *self {
            Abstract(v) | Long(v) => Some(v.into()),
            Int(v) => Some(v.into()),
            Uint(v) => Some(v.into()),
            Ulong(v) => Some(v.into()),
            Bool(_) | Float(_) | List(_) => None,
        }
    }

    /// Returns the value as a boolean, if it is one.
    pub fn truth(&self) -> Option<bool> {
        match *self {
            Bool(v) => Some(v),
            _ => None,
        }
    }

    fn float(&self) -> Option<f64> {
        match *self {
            Float(v) => Some(v),
            _ => self.integer().map(|v| v as f64),
        }
    }

    /// Converts the value as a constructor such as `uint(x)` does, lists component by component.
    pub fn convert(&self, kind: Kind) -> Result<Value, Fault> {
        if let List(items) = self {
            return items.iter().map(|v| v.convert(kind)).collect::<Result<_, _>>().map(List);
        }
        let integer = match *self {
            Bool(v) => i128::from(v),
            // GLSL 4.60 §5.4.1: a float is truncated towards zero.
            Float(v) => v as i128,
            _ => self.integer().ok_or(Fault::Mismatch)?,
        };
        Ok(match kind {
            Kind::Bool => Bool(match self {
                Float(v) => *v != 0.0,
                _ => integer != 0,
            }),
            Kind::Int => Int(integer as i32),
            Kind::Uint => Uint(integer as u32),
            Kind::Long => Long(integer as i64),
            Kind::Ulong => Ulong(integer as u64),
            Kind::Float => Float(self.float().unwrap_or(integer as f64)),
        })
    }
}

/// Evaluates a prefix operator: `-`, `+`, `!`, `~`.
// `-` of the least value is that value again in both languages, except for AbstractInt.
pub fn unary(op: &str, value: &Value) -> Result<Value, Fault> {
    if let List(items) = value {
        return items.iter().map(|v| unary(op, v)).collect::<Result<_, _>>().map(List);
    }
    match (op, value) {
        ("+", Bool(_)) => Err(Fault::Mismatch),
        ("+", v) => Ok(v.clone()),
        ("-", Abstract(v)) => v.checked_neg().map(Abstract).ok_or(Fault::Overflow),
        ("-", Int(v)) => Ok(Int(v.wrapping_neg())),
        ("-", Uint(v)) => Ok(Uint(v.wrapping_neg())),
        ("-", Long(v)) => Ok(Long(v.wrapping_neg())),
        ("-", Ulong(v)) => Ok(Ulong(v.wrapping_neg())),
        ("-", Float(v)) => Ok(Float(-v)),
        ("!", Bool(v)) => Ok(Bool(!v)),
        ("~", Abstract(v)) => Ok(Abstract(!v)),
        ("~", Int(v)) => Ok(Int(!v)),
        ("~", Uint(v)) => Ok(Uint(!v)),
        ("~", Long(v)) => Ok(Long(!v)),
        ("~", Ulong(v)) => Ok(Ulong(!v)),
        _ => Err(Fault::Mismatch),
    }
}

/// Evaluates `a op b` for the operators both languages share, and GLSL's `^^`.
// Operators apply by component; a scalar is paired with every component (GLSL 4.60 §5.9, WGSL §8.7).
pub fn binary(op: &str, a: &Value, b: &Value) -> Result<Value, Fault> {
    match (a, b) {
        (List(x), List(y)) if x.len() == y.len() => {
            x.iter().zip(y).map(|(a, b)| binary(op, a, b)).collect::<Result<_, _>>().map(List)
        }
        (List(_), List(_)) => Err(Fault::Mismatch),
        (List(x), _) => x.iter().map(|a| binary(op, a, b)).collect::<Result<_, _>>().map(List),
        (_, List(y)) => y.iter().map(|b| binary(op, a, b)).collect::<Result<_, _>>().map(List),
        (Bool(x), Bool(y)) => match op {
            "&&" | "&" => Ok(Bool(*x && *y)),
            "||" | "|" => Ok(Bool(*x || *y)),
            "^^" | "!=" => Ok(Bool(x != y)),
            "==" => Ok(Bool(x == y)),
            _ => Err(Fault::Mismatch),
        },
        (Float(_), _) | (_, Float(_)) => {
            let (Some(x), Some(y)) = (a.float(), b.float()) else { return Err(Fault::Mismatch) };
            floats(op, x, y)
        }
        _ => integers(op, a, b),
    }
}

fn floats(op: &str, x: f64, y: f64) -> Result<Value, Fault> {
    Ok(match op {
        "+" => Float(x + y),
        "-" => Float(x - y),
        "*" => Float(x * y),
        "/" if y == 0.0 => return Err(Fault::DivisionByZero),
        "/" => Float(x / y),
        // WGSL's remainder, with the sign of the dividend; GLSL has `%` on integers alone.
        "%" => Float(x % y),
        _ => return compare(op, &x, &y),
    })
}

fn compare<T: PartialOrd>(op: &str, x: &T, y: &T) -> Result<Value, Fault> {
    Ok(Bool(match op {
        "==" => x == y,
        "!=" => x != y,
        "<" => x < y,
        ">" => x > y,
        "<=" => x <= y,
        ">=" => x >= y,
        _ => return Err(Fault::Unsupported),
    }))
}

/// Computes in a wide type, then converts the result to the wider type of the operands.
// Sums and products of two 64-bit operands fit 128 bits, except a product of two unsigned ones near
// 2^64.
fn integers(op: &str, a: &Value, b: &Value) -> Result<Value, Fault> {
    let (Some(x), Some(y)) = (a.integer(), b.integer()) else { return Err(Fault::Mismatch) };
    let shift = matches!(op, "<<" | ">>");
    let wide = match op {
        "+" => x + y,
        "-" => x - y,
        "*" => x.checked_mul(y).ok_or(Fault::Overflow)?,
        "/" | "%" if y == 0 => return Err(Fault::DivisionByZero),
        "/" => x / y,
        "%" => x % y,
        "&" => x & y,
        "|" => x | y,
        "^" => x ^ y,
        // From the width of the type on the result is undefined in GLSL (§5.9) and an error in
        // WGSL; here only from the widest on, so that `i128` holds every result.
        "<<" | ">>" if !(0..64).contains(&y) => return Err(Fault::Overflow),
        "<<" => x << y,
        ">>" => x >> y,
        _ => return compare(op, &x, &y),
    };
    // GLSL 4.60 §4.1.10: int converts to uint, 32 bits to 64; a shift keeps its left type.
    match (a, b) {
        _ if shift => narrow(a, wide),
        (Ulong(_), _) | (_, Ulong(_)) => Ok(Ulong(wide as u64)),
        (Long(_), _) | (_, Long(_)) => Ok(Long(wide as i64)),
        (Uint(_), _) | (_, Uint(_)) => Ok(Uint(wide as u32)),
        (Int(_), _) | (_, Int(_)) => Ok(Int(wide as i32)),
        _ => narrow(&Abstract(0), wide),
    }
}

fn narrow(like: &Value, wide: i128) -> Result<Value, Fault> {
    Ok(match like {
        Int(_) => Int(wide as i32),
        Uint(_) => Uint(wide as u32),
        Long(_) => Long(wide as i64),
        Ulong(_) => Ulong(wide as u64),
        // WGSL §8.1: an AbstractInt that overflows is an error.
        _ => Abstract(i64::try_from(wide).map_err(|_| Fault::Overflow)?),
    })
}

/// Evaluates a builtin function that either language allows in constant expressions.
// Functions of components apply to each; scalars among the arguments serve every component
// (`clamp(v, 0.0, 1.0)`, GLSL 4.60 §8). The others take vectors as they are.
pub fn call(name: &str, args: &[Value]) -> Result<Value, Fault> {
    let reduces = matches!(name, "dot" | "any" | "all");
    let components = args.iter().find_map(|arg| match arg {
        List(items) => Some(items.len()),
        _ => None,
    });
    if let (Some(components), false) = (components, reduces) {
        let part = |arg: &Value, i: usize| match arg {
            List(items) => items.get(i).cloned().ok_or(Fault::Mismatch),
            scalar => Ok(scalar.clone()),
        };
        return (0..components)
            .map(|i| {
                let row = args.iter().map(|arg| part(arg, i)).collect::<Result<Vec<_>, _>>()?;
                call(name, &row)
            })
            .collect::<Result<_, _>>()
            .map(List);
    }
    match (name, args) {
        // Chooses as the formulas of GLSL 4.60 §8.3: `min` is y if y < x, else x.
        ("min", [a, b]) => Ok(if truth("<", b, a)? { b.clone() } else { a.clone() }),
        ("max", [a, b]) => Ok(if truth("<", a, b)? { b.clone() } else { a.clone() }),
        ("clamp", [x, low, high]) => {
            call("min", &[call("max", &[x.clone(), low.clone()])?, high.clone()])
        }
        // WGSL §17.3: `select(if_false, if_true, condition)`.
        ("select", [no, yes, Bool(condition)]) => Ok(if *condition { yes } else { no }.clone()),
        ("abs", [Float(x)]) => Ok(Float(x.abs())),
        ("abs", [x]) => {
            if x.integer().ok_or(Fault::Mismatch)? < 0 {
                unary("-", x)
            } else {
                Ok(x.clone())
            }
        }
        ("sign", [Float(x)]) => Ok(Float(if *x == 0.0 { 0.0 } else { x.signum() })),
        ("sign", [x]) => narrow(x, x.integer().ok_or(Fault::Mismatch)?.signum()),
        ("any", [List(items)]) => Ok(Bool(items.contains(&Bool(true)))),
        ("all", [List(items)]) => Ok(Bool(!items.contains(&Bool(false)))),
        ("dot", [List(a), List(b)]) if a.len() == b.len() && !a.is_empty() => {
            let products = a.iter().zip(b).map(|(a, b)| binary("*", a, b));
            products.reduce(|sum, p| binary("+", &sum?, &p?)).expect("at least one component")
        }
        ("bitCount" | "countOneBits", [x]) => bits(x, |v| v.count_ones()),
        // Left out for 0 and negative numbers, of which no length is made.
        ("findMSB" | "firstLeadingBit", [Uint(x)]) if *x != 0 => Ok(Uint(31 - x.leading_zeros())),
        ("findMSB" | "firstLeadingBit", [Int(x)]) if *x > 0 => {
            Ok(Int(31 - x.leading_zeros() as i32))
        }
        ("findLSB" | "firstTrailingBit", [x]) if x.integer() != Some(0) => {
            bits(x, u32::trailing_zeros)
        }
        ("countLeadingZeros", [x]) => bits(x, u32::leading_zeros),
        ("countTrailingZeros", [x]) => bits(x, u32::trailing_zeros),
        (_, [x]) => rounding(name, x.float().ok_or(Fault::Mismatch)?),
        (_, [x, y]) => {
            let (Some(x), Some(y)) = (x.float(), y.float()) else { return Err(Fault::Mismatch) };
            match name {
                "pow" => Ok(Float(x.powf(y))),
                // GLSL's `mod`, with the sign of the divisor (§8.3).
                "mod" => Ok(Float(x - y * (x / y).floor())),
                "step" => Ok(Float(if y < x { 0.0 } else { 1.0 })),
                _ => Err(Fault::Unsupported),
            }
        }
        _ => Err(Fault::Unsupported),
    }
}

fn truth(op: &str, a: &Value, b: &Value) -> Result<bool, Fault> {
    binary(op, a, b)?.truth().ok_or(Fault::Mismatch)
}

fn bits(value: &Value, count: impl Fn(u32) -> u32) -> Result<Value, Fault> {
    match value {
        Int(v) => Ok(Int(count(*v as u32) as i32)),
        Uint(v) => Ok(Uint(count(*v))),
        Abstract(v) => {
            Ok(Abstract(count(i32::try_from(*v).map_err(|_| Fault::Overflow)? as u32).into()))
        }
        _ => Err(Fault::Mismatch),
    }
}

fn rounding(name: &str, x: f64) -> Result<Value, Fault> {
    Ok(Float(match name {
        "floor" => x.floor(),
        "ceil" => x.ceil(),
        "trunc" => x.trunc(),
        // WGSL rounds ties to even; GLSL's `round` leaves ties to the implementation (§8.3).
        "round" | "roundEven" => x.round_ties_even(),
        "fract" => x - x.floor(),
        "sqrt" => x.sqrt(),
        "inversesqrt" | "inverseSqrt" => 1.0 / x.sqrt(),
        "exp" => x.exp(),
        "exp2" => x.exp2(),
        "log" => x.ln(),
        "log2" => x.log2(),
        "radians" => x.to_radians(),
        "degrees" => x.to_degrees(),
        "sin" => x.sin(),
        "cos" => x.cos(),
        _ => return Err(Fault::Unsupported),
    }))
}
