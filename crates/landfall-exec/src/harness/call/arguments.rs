//! Arguments in JSON, converted to the words that backends take.
//!
//! Numbers are numbers, bools `true` and `false`, vectors arrays, matrices arrays of columns,
//! structures objects by member; non-finite numbers are `"nan"`, `"inf"`, `"-inf"`.

use landfall_layout::diagnostic::Code;
use serde_json::Value;

use landfall_interp::{ValueParts, ValueType};
pub use landfall_layout::buffer::{ComponentError, bits, kind};
use landfall_layout::shape::{ArrayLen, Scalar, ScalarKind, Type};
use landfall_layout::source::Language;
use landfall_layout::text::edit_distance::suggestion;

/// A value that does not fit, and its path in the JSON: `args[1].color[2]`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct ArgumentError {
    pub code: Code,
    pub message: String,
    pub help: Option<String>,
}

impl ArgumentError {
    pub fn with_help(mut self, help: &str) -> ArgumentError {
        self.help = Some(help.to_string());
        self
    }
}

/// Returns an argument of a type whose numbers are one.
pub(super) fn ones(ty: &ValueType) -> Value {
    match ty.parts() {
        ValueParts::Scalar(scalar) if scalar.kind == ScalarKind::Bool => Value::Bool(true),
        ValueParts::Scalar(_) => Value::from(1),
        ValueParts::List(element, len) => Value::Array(vec![ones(&element); len]),
        ValueParts::Struct(members) => {
            Value::Object(members.iter().map(|(name, ty)| (name.clone(), ones(ty))).collect())
        }
    }
}

/// Appends the words of a value, one per scalar, each the bits of 32 or 64.
pub(super) fn append_words(
    ty: &ValueType,
    value: &Value,
    at: &str,
    language: Language,
    to: &mut Vec<u64>,
) -> Result<(), ArgumentError> {
    match ty.parts() {
        ValueParts::Scalar(scalar) => {
            to.push(word(scalar, value, at, language)?);
            Ok(())
        }
        ValueParts::List(element, len) => {
            let of = match ty {
                ValueType::Vector { .. } => " numbers".to_string(),
                ValueType::Matrix { rows, .. } => format!(" columns of {rows} numbers"),
                _ => String::new(),
            };
            let items = match value {
                Value::Array(items) if items.len() == len => items,
                _ => return Err(wrong(ty, &format!("an array of {len}{of}"), value, at, language)),
            };
            for (index, item) in items.iter().enumerate() {
                append_words(&element, item, &format!("{at}[{index}]"), language, to)?;
            }
            Ok(())
        }
        ValueParts::Struct(members) => {
            let Value::Object(map) = value else {
                return Err(wrong(
                    ty,
                    "an object with a value for each member",
                    value,
                    at,
                    language,
                ));
            };
            // In the order of the members, whatever the order of the keys.
            for (name, ty) in members {
                let Some(value) = map.get(name) else {
                    return Err(ArgumentError {
                        code: Code::MissingMember,
                        message: format!("`{at}.{name}` is not given"),
                        help: Some(format!("add a value of type `{}`", spelled(ty, language))),
                    });
                };
                append_words(ty, value, &format!("{at}.{name}"), language, to)?;
            }
            // A key that is no member is likely misspelt.
            let known = |key: &str| members.iter().any(|(name, _)| name == key);
            match map.keys().find(|key| !known(key)) {
                None => Ok(()),
                Some(key) => {
                    let names = || members.iter().map(|(name, _)| name.as_str());
                    let all: Vec<String> = names().map(|name| format!("`{name}`")).collect();
                    Err(ArgumentError {
                        code: Code::UnknownMember,
                        message: format!(
                            "`{at}.{key}`: `{}` has no member `{key}`",
                            spelled(ty, language)
                        ),
                        help: suggestion(key, names())
                            .or_else(|| Some(format!("its members are {}", all.join(", ")))),
                    })
                }
            }
        }
    }
}

fn wrong(
    ty: &ValueType,
    wanted: &str,
    value: &Value,
    at: &str,
    language: Language,
) -> ArgumentError {
    ArgumentError {
        code: Code::WrongValue,
        message: format!(
            "`{at}` is a `{}`: expected {wanted}, found {}",
            spelled(ty, language),
            kind(value)
        ),
        help: None,
    }
}

fn word(scalar: Scalar, value: &Value, at: &str, language: Language) -> Result<u64, ArgumentError> {
    bits(held_as(scalar), value).map_err(|unfit| match unfit {
        ComponentError::Kind(wanted) => {
            wrong(&ValueType::Scalar(scalar), wanted, value, at, language)
        }
        ComponentError::Range => ArgumentError {
            code: Code::ValueOutOfRange,
            message: format!(
                "`{at}`: {} does not fit `{}`",
                kind(value),
                spelled(&ValueType::Scalar(scalar), language)
            ),
            help: None,
        },
    })
}

/// Returns the format of a scalar's word: the interpreter holds every small float as an `f32`.
pub(super) fn held_as(scalar: Scalar) -> Scalar {
    match (scalar.kind, scalar.width) {
        (ScalarKind::Float, 8) => Scalar::F64,
        (kind, _) if kind.is_float() => Scalar::F32,
        _ => scalar,
    }
}

/// Returns a type as its language spells it.
pub(super) fn spelled(ty: &ValueType, language: Language) -> String {
    match ty {
        ValueType::Struct { name, .. } => name.clone(),
        ValueType::Scalar(_)
        | ValueType::Vector { .. }
        | ValueType::Matrix { .. }
        | ValueType::Array { .. } => match (non_struct_type(ty), ty, language) {
            (Some(plain), _, _) => plain.spelled(language).to_string(),
            (None, ValueType::Array { element, len }, Language::Wgsl) => {
                format!("array<{}, {len}>", spelled(element, language))
            }
            (None, ValueType::Array { element, len }, Language::Glsl | Language::SpirV) => {
                let element = spelled(element, language);
                // GLSL names the outer dimension first: `float[2][3]` is two of `float[3]`.
                let at = element.find('[').unwrap_or(element.len());
                format!("{}[{len}]{}", &element[..at], &element[at..])
            }
            // Not reached: all but arrays of structures have such a type.
            (None, _, _) => String::new(),
        },
    }
}

/// Returns the shape of a type without structures.
fn non_struct_type(ty: &ValueType) -> Option<Type> {
    Some(match ty {
        ValueType::Scalar(scalar) => Type::Scalar(*scalar),
        ValueType::Vector { scalar, rows } => Type::Vector { scalar: *scalar, rows: *rows },
        ValueType::Matrix { scalar, columns, rows } => {
            Type::Matrix { scalar: *scalar, columns: *columns, rows: *rows }
        }
        ValueType::Array { element, len } => {
            Type::Array { element: non_struct_type(element)?.into(), len: ArrayLen::Fixed(*len) }
        }
        ValueType::Struct { .. } => return None,
    })
}

/// Returns the path of each scalar of a type, in the order of its words: `.color.x`, `[1].y`.
pub(super) fn paths(ty: &ValueType) -> Vec<String> {
    let mut all = Vec::new();
    push_paths(ty, String::new(), &mut all);
    all
}

fn push_paths(ty: &ValueType, at: String, all: &mut Vec<String>) {
    const ROWS: [&str; 4] = ["x", "y", "z", "w"];
    match ty.parts() {
        ValueParts::Scalar(_) => all.push(at),
        ValueParts::List(_, rows) if matches!(ty, ValueType::Vector { .. }) => {
            all.extend(ROWS[..rows.min(4)].iter().map(|row| format!("{at}.{row}")));
        }
        ValueParts::List(element, len) => {
            (0..len).for_each(|index| push_paths(&element, format!("{at}[{index}]"), all));
        }
        ValueParts::Struct(members) => {
            members.iter().for_each(|(name, ty)| push_paths(ty, format!("{at}.{name}"), all));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn light() -> ValueType {
        let vec3 = ValueType::Vector { scalar: Scalar::F32, rows: 3 };
        ValueType::Struct {
            name: "Light".to_string(),
            members: vec![
                ("color".to_string(), vec3),
                ("on".to_string(), ValueType::Scalar(Scalar::BOOL)),
            ],
        }
    }

    fn read(json: &str) -> Result<Vec<u64>, String> {
        let mut to = Vec::new();
        let value = landfall_layout::buffer::read_json(json).expect("it is JSON");
        let read = append_words(&light(), &value, "args[1]", Language::Glsl, &mut to);
        read.map(|()| to).map_err(|misfit| misfit.message)
    }

    #[test]
    fn a_structure_is_an_object_of_its_members() {
        let inf = u64::from(f32::INFINITY.to_bits());
        let one = u64::from(1f32.to_bits());
        let quiet = 0x7fc0_0000;
        let read = read(r#"{"on": true, "color": [1, "-inf", "nan"]}"#);
        assert_eq!(read, Ok(vec![one, inf | 1 << 31, quiet, 1]));
    }

    #[test]
    fn what_does_not_fit_is_said_with_its_place() {
        for (json, message) in [
            (
                r#"{"color": [1, 2, "x"], "on": true}"#,
                "`args[1].color[2]` is a `float`: expected a number",
            ),
            (r#"{"color": [1, 2, 1e39], "on": true}"#, "`args[1].color[2]`: 1e+39 does not fit"),
            (
                r#"{"color": [1, 2], "on": true}"#,
                "`args[1].color` is a `vec3`: expected an array of 3",
            ),
            (r#"{"color": [1, 2, 3]}"#, "`args[1].on` is not given"),
            (r#"{"color": [1, 2, 3], "on": 1, "off": 2}"#, "`args[1].off`: `Light` has no member"),
            (
                "7",
                "`args[1]` is a `Light`: expected an object with a value for each member, found 7",
            ),
        ] {
            let found = read(json).expect_err(json);
            assert!(found.starts_with(message), "{found}");
        }
    }
}
