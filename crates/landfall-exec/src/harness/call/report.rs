//! The results of a call: plain data, as `landfall schema run` describes it.
//!
//! Made by [`call`](super::call()), printed by the report of `landfall run`.

use landfall_layout::diagnostic::Code;
use serde::{Serialize, Serializer};
use serde_json::Value;

use super::arguments::{held_as, paths, spelled};
use crate::backend::Device;
use crate::harness::origins::{Cause, ReadValue, comes_from};
use landfall_interp::{Numbers, Undefined, ValueParts, ValueType};
use landfall_ir::module::Direction;
use landfall_layout::Diagnostic;
use landfall_layout::buffer::ComponentBits;
pub use landfall_layout::buffer::float::last_place;
use landfall_layout::shape::{Scalar, ScalarKind};
use landfall_layout::source::{Files, Language, Target};

/// The report of one call.
#[derive(Clone, Debug)]
pub struct CallReport {
    /// The path of the shader as messages print it.
    pub path: String,
    /// The API assumed for a shader that names none, if its blocks depend on it.
    pub assumed_target: Option<Target>,
    /// The function with the types of its parameters: `phong(vec3, Light)`.
    pub function: String,
    /// The device that ran it.
    pub backend: Device,
    /// The returned value; `None` if the function returns nothing.
    pub result: Option<ReturnedValue>,
    /// The value of each `out` and `inout` parameter after the call, and of each global variable
    /// that a function without a result writes, such as the outputs of `main`.
    pub parameters: Vec<(String, Direction, ReturnedValue)>,
    /// Whether the call executed a `discard`.
    pub discarded: bool,
    /// Number of operations on the interpreter; `None` if it did not run.
    pub operations: Option<u64>,
    /// Operations without a defined value.
    pub undefined: Vec<UndefinedOperation>,
    /// What made results NaN or infinite.
    pub causes: Vec<ResultCause>,
    /// Notes on defaults taken for missing values, and the reason for a missing `f64`.
    pub notes: Vec<String>,
    /// The shader's files.
    pub files: Files,
}

/// An operation without a defined value, with the values that led to it.
#[derive(Clone, Debug, PartialEq)]
pub struct UndefinedOperation {
    pub seen: Undefined,
    /// The arguments, inputs and members of blocks whose values led to it, the first time.
    pub from: Vec<ReadValue>,
}

/// What made results NaN or infinite.
#[derive(Clone, Debug, PartialEq)]
pub struct ResultCause {
    /// The paths of the results; that of the whole value if it is all of it.
    pub results: Vec<String>,
    /// Whether they are NaN; infinite otherwise.
    pub is_nan: bool,
    /// The cause.
    pub cause: Cause,
}

/// A returned value.
#[derive(Clone, Debug, PartialEq)]
pub struct ReturnedValue {
    /// The type, as its language spells it.
    pub ty: String,
    /// The scalars in order.
    pub scalars: Vec<ReturnedScalar>,
    shape: ValueType,
}

/// A scalar in JSON, f32 beside f64.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema), schemars(rename = "ScalarObject"))]
pub struct ReturnedScalar {
    /// The path within the value.
    pub path: String,
    /// The f32 value.
    #[cfg_attr(
        feature = "schema",
        schemars(with = "Value", extend("type" = ["number", "boolean", "string"]))
    )]
    pub value: ComponentBits,
    /// The f64 value, for floats.
    #[cfg_attr(
        feature = "schema",
        schemars(with = "Value", extend("type" = ["number", "string", "null"]))
    )]
    #[serde(serialize_with = "optional_number")]
    pub double: Option<f64>,
    /// The difference of the two in ULPs of the f32.
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0)))]
    pub ulp: Option<f64>,
}

fn optional_number<S: Serializer>(double: &Option<f64>, to: S) -> Result<S::Ok, S::Error> {
    double.map(number).serialize(to)
}

impl CallReport {
    /// Returns the undefined operations as findings, each with its place.
    pub fn findings(&self) -> Vec<Diagnostic> {
        // What is born of an operation that is undefined is said once.
        let all = || self.undefined.iter().map(|operation| &operation.seen);
        let each = self.undefined.iter().filter(|operation| !operation.seen.follows(all()));
        let found = each.map(|UndefinedOperation { seen, from }| {
            let operands: Vec<String> = seen.operands.iter().map(|x| number_text(*x)).collect();
            let mut message = seen.kind.name().to_string();
            if !operands.is_empty() {
                message.push_str(&format!(": {}", operands.join(", ")));
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
            found.notes.extend(comes_from(from));
            found
        });
        found.collect()
    }
}

/// Returns the name of the shader's function that an operation belongs to.
pub fn function_name(name: &str) -> &str {
    if name == super::caller::NAME { "main" } else { name }
}

fn number_text(number: f64) -> String {
    ComponentBits { scalar: Scalar::F64, bits: number.to_bits() }.to_string()
}

impl ReturnedValue {
    pub(super) fn new(
        ty: &ValueType,
        language: Language,
        words: &[u64],
        doubles: Option<&Numbers>,
    ) -> ReturnedValue {
        let scalars = ty.scalars();
        let paths = paths(ty);
        let given = scalars.iter().zip(paths).zip(words).enumerate().map(|(at, it)| {
            let ((scalar, path), word) = it;
            let value = ComponentBits { scalar: held_as(*scalar), bits: *word };
            // Smaller floats are computed as `f32`.
            let is_single = scalar.kind == ScalarKind::Float && scalar.width < 8;
            let double = doubles.filter(|_| is_single).and_then(|numbers| {
                numbers.doubles.get(at).and_then(|lanes| lanes.first()).copied()
            });
            let ulp = double.and_then(|double| ulps(f32::from_bits(*word as u32), double));
            ReturnedScalar { path, value, double, ulp }
        });
        ReturnedValue { ty: spelled(ty, language), scalars: given.collect(), shape: ty.clone() }
    }

    /// Returns the value as JSON, in the form of arguments.
    pub fn json(&self) -> Value {
        let mut each = self
            .scalars
            .iter()
            .map(|scalar| serde_json::to_value(scalar.value).unwrap_or(Value::Null));
        nested(&self.shape, &mut each)
    }

    /// Returns the value in `f64` as JSON; null where there is none.
    pub fn json_double(&self) -> Value {
        let mut each = self.scalars.iter().map(|scalar| scalar.double.map_or(Value::Null, number));
        nested(&self.shape, &mut each)
    }
}

/// Returns a double as JSON.
pub fn number(double: f64) -> Value {
    if double.is_nan() {
        // The sign and payload of a NaN depend on the machine.
        return Value::from("nan");
    }
    serde_json::to_value(ComponentBits { scalar: Scalar::F64, bits: double.to_bits() })
        .unwrap_or(Value::Null)
}

fn nested(ty: &ValueType, each: &mut dyn Iterator<Item = Value>) -> Value {
    match ty.parts() {
        ValueParts::Scalar(_) => each.next().unwrap_or(Value::Null),
        ValueParts::List(element, len) => {
            Value::Array((0..len).map(|_| nested(&element, each)).collect())
        }
        ValueParts::Struct(members) => {
            let members = members.iter();
            Value::Object(members.map(|(name, ty)| (name.clone(), nested(ty, each))).collect())
        }
    }
}

/// Returns the distance of an `f32` from a number in ULPs of the `f32` at that number.
pub(super) fn ulps(single: f32, double: f64) -> Option<f64> {
    if single.is_nan() && double.is_nan() {
        return Some(0.0);
    }
    if single.is_infinite() || double.is_infinite() {
        // Numbers beyond the largest `f32` round to infinity.
        return (single == double as f32).then_some(0.0);
    }
    if single.is_nan() || double.is_nan() {
        return None;
    }
    Some((f64::from(single) - double).abs() / last_place(double))
}

/// A value in JSON with all its details.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ValueObject {
    /// The type as the shader spells it.
    #[serde(rename = "type")]
    pub ty: String,
    /// The value in f32.
    pub value: Value,
    /// The value in f64.
    pub double: Value,
    /// Each scalar, in both precisions.
    pub scalars: Vec<ReturnedScalar>,
}

impl ValueObject {
    /// Returns the JSON form of a returned value.
    pub fn new(given: &ReturnedValue) -> ValueObject {
        ValueObject {
            ty: given.ty.clone(),
            value: given.json(),
            double: given.json_double(),
            scalars: given.scalars.clone(),
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
