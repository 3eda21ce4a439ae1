//! Numbers in JSON, which has none for NaN and the infinities.

use serde::{Serialize, Serializer};

/// A number, or `nan`, `inf`, `-inf`.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged)]
pub enum JsonNumber {
    Finite(f64),
    #[cfg_attr(feature = "schema", schemars(extend("enum" = ["nan", "inf", "-inf"])))]
    NonFinite(&'static str),
}

impl From<f64> for JsonNumber {
    fn from(x: f64) -> JsonNumber {
        match x {
            _ if x.is_nan() => JsonNumber::NonFinite("nan"),
            f64::INFINITY => JsonNumber::NonFinite("inf"),
            f64::NEG_INFINITY => JsonNumber::NonFinite("-inf"),
            _ => JsonNumber::Finite(x),
        }
    }
}

impl From<f32> for JsonNumber {
    fn from(x: f32) -> JsonNumber {
        match x.is_finite() {
            // The shortest digits that round to this f32.
            true => JsonNumber::from(format!("{x:?}").parse().unwrap_or(f64::from(x))),
            false => JsonNumber::from(f64::from(x)),
        }
    }
}

/// Serialises a number, of which an option may be absent, as a [`JsonNumber`].
pub(crate) fn json_number<T, S: Serializer>(number: &T, serializer: S) -> Result<S::Ok, S::Error>
where
    T: Copy + Into<Option<f64>>,
{
    let number: Option<f64> = (*number).into();
    number.map(JsonNumber::from).serialize(serializer)
}
