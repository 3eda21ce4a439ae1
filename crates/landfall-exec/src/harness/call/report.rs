//! What calling a function gave: plain data, as `landfall schema run` describes it.
//!
//! Made by [`call`](super::call()), printed by the report of `landfall run`.

use landfall_layout::diagnostic::Code;
use serde::Serialize;
use serde_json::Value;

use super::arguments::{held_as, paths, spelled};
use crate::backend::Device;
use crate::interp::{Numbers, Undefined, ValueType};
use landfall_ir::module::Direction;
use landfall_layout::Diagnostic;
use landfall_layout::buffer::Datum;
pub use landfall_layout::buffer::float::last_place;
use landfall_layout::shape::{Scalar, ScalarKind};
use landfall_layout::source::{Files, Language};

/// What one call gave.
#[derive(Clone, Debug)]
pub struct CallReport {
    /// The path of the shader as messages print it.
    pub path: String,
    /// The function with the types of its parameters: `phong(vec3, Light)`.
    pub function: String,
    /// Who ran it.
    pub reader: Device,
    /// What it returned; none where it returns nothing.
    pub result: Option<Given>,
    /// What is left in each `out` and `inout` parameter.
    pub parameters: Vec<(String, Direction, Given)>,
    /// Whether it met a `discard`.
    pub discarded: bool,
    /// Operations of the evaluator; none where it did not run.
    pub operations: Option<u64>,
    /// Operations without a defined value.
    pub undefined: Vec<Undefined>,
    /// What was taken for what was not given, and why there is no `f64`.
    pub notes: Vec<String>,
    /// The files the shader is made of.
    pub files: Files,
}

/// A value that came back.
#[derive(Clone, Debug, PartialEq)]
pub struct Given {
    /// Its type, as its language spells it.
    pub ty: String,
    /// Its scalars in order.
    pub scalars: Vec<GivenScalar>,
    shape: ValueType,
}

/// One scalar that came back.
#[derive(Clone, Debug, PartialEq)]
pub struct GivenScalar {
    /// The way to it: `.color.x`; empty for a plain scalar.
    pub path: String,
    /// What the reader gave.
    pub value: Datum,
    /// The same in double precision, by the evaluator; none for what is no `f32`.
    pub double: Option<f64>,
    /// How far the two are apart, in units of the last place of an `f32`; none where one is not
    /// a number, or infinite, and the other is not.
    pub ulp: Option<f64>,
}

impl CallReport {
    /// The undefined operations as findings, each with its place.
    pub fn findings(&self) -> Vec<Diagnostic> {
        let found = self.undefined.iter().map(|seen| {
            let operands: Vec<String> = seen.operands.iter().map(|x| plain(*x)).collect();
            let mut message = seen.kind.text().to_string();
            if !operands.is_empty() {
                message.push_str(&format!(": of {}", operands.join(", ")));
            }
            let mut found = Diagnostic::warning(Code::UndefinedOperation, seen.place.span, message)
                .with_text(format!("in `{}`", function_name(&seen.place.function)));
            if seen.place.shown.is_empty() {
                found.labels.clear();
                found.path = Some(self.path.clone());
            }
            if seen.count > 1 {
                found.notes.push(format!("{} times in this call", seen.count));
            }
            found
        });
        found.collect()
    }
}

/// The function of the shader's that an operation is in.
pub fn function_name(name: &str) -> &str {
    if name == super::caller::NAME { "main" } else { name }
}

fn plain(number: f64) -> String {
    Datum { scalar: Scalar::F64, bits: number.to_bits() }.to_string()
}

impl Given {
    pub(super) fn new(
        ty: &ValueType,
        language: Language,
        words: &[u64],
        doubles: Option<&Numbers>,
    ) -> Given {
        let scalars = ty.scalars();
        let paths = paths(ty);
        let given = scalars.iter().zip(paths).zip(words).enumerate().map(|(at, it)| {
            let ((scalar, path), word) = it;
            let value = Datum { scalar: held_as(*scalar), bits: *word };
            let is_single = scalar.kind == ScalarKind::Float && scalar.width < 8;
            let double = doubles.filter(|_| is_single).and_then(|numbers| {
                numbers.doubles.get(at).and_then(|lanes| lanes.first()).copied()
            });
            let ulp = double.and_then(|double| ulps(f32::from_bits(*word as u32), double));
            GivenScalar { path, value, double, ulp }
        });
        Given { ty: spelled(ty, language), scalars: given.collect(), shape: ty.clone() }
    }

    /// The value as JSON, as arguments are given.
    pub fn json(&self) -> Value {
        let mut each = self
            .scalars
            .iter()
            .map(|scalar| serde_json::to_value(scalar.value).unwrap_or(Value::Null));
        nested(&self.shape, &mut each)
    }

    /// The same in double precision; what has none is null.
    pub fn json_double(&self) -> Value {
        let mut each = self.scalars.iter().map(|scalar| scalar.double.map_or(Value::Null, number));
        nested(&self.shape, &mut each)
    }
}

/// A double as JSON.
pub fn number(double: f64) -> Value {
    if double.is_nan() {
        // Which NaN a machine makes is its own affair.
        return Value::from("nan");
    }
    serde_json::to_value(Datum { scalar: Scalar::F64, bits: double.to_bits() })
        .unwrap_or(Value::Null)
}

fn nested(ty: &ValueType, each: &mut dyn Iterator<Item = Value>) -> Value {
    let mut many =
        |ty: &ValueType, len: usize| Value::Array((0..len).map(|_| nested(ty, each)).collect());
    match ty {
        ValueType::Scalar(_) => each.next().unwrap_or(Value::Null),
        ValueType::Vector { scalar, rows } => many(&ValueType::Scalar(*scalar), usize::from(*rows)),
        ValueType::Matrix { scalar, columns, rows } => {
            let column = ValueType::Vector { scalar: *scalar, rows: *rows };
            many(&column, usize::from(*columns))
        }
        ValueType::Array { element, len } => many(element, *len as usize),
        ValueType::Struct { members, .. } => {
            let members = members.iter();
            Value::Object(members.map(|(name, ty)| (name.clone(), nested(ty, each))).collect())
        }
    }
}

/// How far an `f32` is from a number, in units of the `f32`s' last place there.
pub(super) fn ulps(single: f32, double: f64) -> Option<f64> {
    if single.is_nan() && double.is_nan() {
        return Some(0.0);
    }
    if single.is_infinite() || double.is_infinite() {
        // What is past the largest f32 is infinity in it.
        return (single == double as f32).then_some(0.0);
    }
    if single.is_nan() || double.is_nan() {
        return None;
    }
    Some((f64::from(single) - double).abs() / last_place(double))
}

/// A value's JSON, in full.
#[derive(Serialize)]
pub struct GivenObject {
    /// The type as the shader spells it.
    #[serde(rename = "type")]
    pub ty: String,
    /// The value in f32.
    pub value: Value,
    /// The value in f64.
    pub double: Value,
    /// Each scalar of it, in both precisions.
    pub scalars: Vec<ScalarObject>,
}

/// One scalar of a value, in f32 beside f64.
#[derive(Serialize)]
pub struct ScalarObject {
    /// Its path in the value.
    pub path: String,
    /// Its f32 value.
    pub value: Datum,
    /// Its f64 value, for floats.
    pub double: Option<Value>,
    /// How far apart they are, in units in the last place of the f32.
    pub ulp: Option<f64>,
}

impl GivenObject {
    /// The JSON form of a returned value.
    pub fn of(given: &Given) -> GivenObject {
        let scalars = given.scalars.iter().map(|scalar| ScalarObject {
            path: scalar.path.clone(),
            value: scalar.value,
            double: scalar.double.map(number),
            ulp: scalar.ulp,
        });
        GivenObject {
            ty: given.ty.clone(),
            value: given.json(),
            double: given.json_double(),
            scalars: scalars.collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::ulps;

    #[test]
    fn a_third_is_a_third_of_a_unit_off() {
        // 1/3 in f32 is 11184811 / 2^25: (11184811 - 2^25 / 3) = 1/3 of 2^-25, its last place.
        let off = ulps(1.0 / 3.0, 1.0 / 3.0).expect("both are numbers");
        assert!((off - 1.0 / 3.0).abs() < 1e-6, "{off}");
        assert_eq!(ulps(1.0, 1.0), Some(0.0));
        assert_eq!(ulps(f32::from_bits(1.0f32.to_bits() + 3), 1.0), Some(3.0));
        assert_eq!((ulps(f32::NAN, 1.0), ulps(f32::INFINITY, 1.0)), (None, None));
        assert_eq!((ulps(f32::NAN, f64::NAN), ulps(f32::INFINITY, 1e39)), (Some(0.0), Some(0.0)));
    }
}
