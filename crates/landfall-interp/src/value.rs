//! Types and values in the interpreter's API, independent of naga and convertible from and to JSON.

use std::borrow::Cow;

use naga::{ScalarKind as Kind, TypeInner};

use super::flatten::Types;
use landfall_ir::Module;
use landfall_layout::shape::{Scalar, ScalarKind};

/// The type of an argument, a result or an input.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ValueType {
    Scalar(Scalar),
    Vector { scalar: Scalar, rows: u8 },
    Matrix { scalar: Scalar, columns: u8, rows: u8 },
    Array { element: Box<ValueType>, len: u32 },
    Struct { name: String, members: Vec<(String, ValueType)> },
}

/// What a value of a type is made of.
#[derive(Debug)]
pub enum ValueParts<'t> {
    Scalar(Scalar),
    /// The components of a vector, columns of a matrix, or elements of an array: their type and
    /// number.
    List(Cow<'t, ValueType>, usize),
    Struct(&'t [(String, ValueType)]),
}

/// A value. Its numbers are `f64`, which hold every 32-bit integer and float; a 64-bit integer is
/// exact up to 2^53.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    Bool(bool),
    Number(f64),
    /// The components of a vector, columns of a matrix, or elements of an array.
    List(Vec<Value>),
    Struct(Vec<(String, Value)>),
}

impl ValueType {
    pub fn parts(&self) -> ValueParts<'_> {
        match self {
            ValueType::Scalar(scalar) => ValueParts::Scalar(*scalar),
            ValueType::Vector { scalar, rows } => {
                ValueParts::List(Cow::Owned(ValueType::Scalar(*scalar)), usize::from(*rows))
            }
            ValueType::Matrix { scalar, columns, rows } => {
                let column = ValueType::Vector { scalar: *scalar, rows: *rows };
                ValueParts::List(Cow::Owned(column), usize::from(*columns))
            }
            ValueType::Array { element, len } => {
                ValueParts::List(Cow::Borrowed(element), *len as usize)
            }
            ValueType::Struct { members, .. } => ValueParts::Struct(members),
        }
    }

    /// Returns the scalars in order: matrices by column, members and elements one after the other.
    pub fn scalars(&self) -> Vec<Scalar> {
        let mut all = Vec::new();
        self.push_scalars(&mut all);
        all
    }

    fn push_scalars(&self, all: &mut Vec<Scalar>) {
        match self.parts() {
            ValueParts::Scalar(scalar) => all.push(scalar),
            ValueParts::List(element, len) => (0..len).for_each(|_| element.push_scalars(all)),
            ValueParts::Struct(members) => members.iter().for_each(|(_, ty)| ty.push_scalars(all)),
        }
    }

    /// Returns a value's numbers in the order of [`scalars`](ValueType::scalars); `None` if it is
    /// not of this type.
    pub fn flatten(&self, value: &Value) -> Option<Vec<f64>> {
        let mut numbers = Vec::new();
        self.push_numbers(value, &mut numbers).then_some(numbers)
    }

    fn push_numbers(&self, value: &Value, to: &mut Vec<f64>) -> bool {
        match (self.parts(), value) {
            (ValueParts::Scalar(_), Value::Number(number)) => to.push(*number),
            (ValueParts::Scalar(_), Value::Bool(bit)) => to.push(f64::from(u8::from(*bit))),
            (ValueParts::List(element, len), Value::List(list)) => {
                return list.len() == len
                    && list.iter().all(|value| element.push_numbers(value, to));
            }
            (ValueParts::Struct(members), Value::Struct(given)) => {
                return members.len() == given.len()
                    && members.iter().all(|(name, ty)| {
                        // By name, in whatever order they are given.
                        let value = given.iter().find(|(given, _)| given == name);
                        value.is_some_and(|(_, value)| ty.push_numbers(value, to))
                    });
            }
            _ => return false,
        }
        true
    }

    /// Returns the value of numbers, as many as there are [`scalars`](ValueType::scalars).
    pub fn build(&self, numbers: &mut impl Iterator<Item = f64>) -> Value {
        match self.parts() {
            ValueParts::Scalar(scalar) => {
                let number = numbers.next().unwrap_or(f64::NAN);
                match scalar.kind {
                    ScalarKind::Bool => Value::Bool(number != 0.0),
                    _ => Value::Number(number),
                }
            }
            ValueParts::List(element, len) => {
                Value::List((0..len).map(|_| element.build(numbers)).collect())
            }
            ValueParts::Struct(members) => Value::Struct(
                members.iter().map(|(name, ty)| (name.clone(), ty.build(numbers))).collect(),
            ),
        }
    }
}

impl ValueType {
    /// Returns the plain form of a module's type; `None` if it has none.
    pub fn new(module: &Module, ty: naga::Handle<naga::Type>) -> Option<ValueType> {
        // The values of overrides are unknown here.
        let pending = |_| None;
        let counted = Default::default();
        let before = Default::default();
        let types = Types { arena: &module.ir.types, pending: &pending, counted, before };
        value_type(&types, &module.ir.types[ty])
    }
}

/// Returns the plain form of naga's type; `None` if it has none.
pub(super) fn value_type(types: &Types, ty: &naga::Type) -> Option<ValueType> {
    // What is too large has none.
    types.leaf_count(&ty.inner).ok()?;
    Some(match &ty.inner {
        TypeInner::Scalar(scalar) | TypeInner::Atomic(scalar) => {
            ValueType::Scalar(supported_scalar(*scalar)?)
        }
        TypeInner::Vector { size, scalar } => {
            ValueType::Vector { scalar: supported_scalar(*scalar)?, rows: *size as u8 }
        }
        TypeInner::Matrix { columns, rows, scalar } => ValueType::Matrix {
            scalar: supported_scalar(*scalar)?,
            columns: *columns as u8,
            rows: *rows as u8,
        },
        TypeInner::Array { base, size, .. } => ValueType::Array {
            element: Box::new(value_type(types, &types.arena[*base])?),
            len: types.len(*size)?,
        },
        TypeInner::Struct { members, .. } => {
            let name = ty.name.clone().unwrap_or_default();
            let members: Option<Vec<(String, ValueType)>> = members
                .iter()
                .map(|member| {
                    let ty = value_type(types, &types.arena[member.ty])?;
                    Some((member.name.clone().unwrap_or_default(), ty))
                })
                .collect();
            ValueType::Struct { name, members: members? }
        }
        _ => return None,
    })
}

fn supported_scalar(scalar: naga::Scalar) -> Option<Scalar> {
    let kind = match scalar.kind {
        Kind::Sint => ScalarKind::Sint,
        Kind::Uint => ScalarKind::Uint,
        Kind::Float => ScalarKind::Float,
        Kind::Bool => return Some(Scalar::BOOL),
        Kind::AbstractInt | Kind::AbstractFloat => return None,
    };
    Some(Scalar { kind, width: scalar.width })
}
