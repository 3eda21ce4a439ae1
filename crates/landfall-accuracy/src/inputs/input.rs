//! The inputs of a function, flattened: vectors and scalars with their paths and roles.
//!
//! Derived from a [`PureFunction`]; the unit of samples and findings.

use super::role::{InputRole, role};
use landfall_exec::harness::call::pure::PureFunction;
use landfall_interp::ValueType;
use landfall_layout::shape::{Scalar, ScalarKind};

/// A scalar, vector or matrix that a function reads.
#[derive(Clone, Debug, PartialEq)]
pub struct Input {
    /// The path: `light.position`.
    pub path: String,
    /// The names of the structure and the member; `None` for a plain parameter.
    pub member: Option<(String, String)>,
    /// The index of its first scalar.
    pub first: usize,
    /// The number of its scalars.
    pub len: usize,
    /// The rows of a vector or of a matrix column; 1 for a scalar.
    pub rows: usize,
    pub scalar: Scalar,
    pub role: InputRole,
    /// The path of the enclosing structure, which the inputs of one light share.
    pub owner: String,
}

impl Input {
    /// Whether its scalars are `f32`.
    pub fn is_float(&self) -> bool {
        self.scalar.kind == ScalarKind::Float && self.scalar.width <= 4
    }

    /// Whether it is a float vector, not a matrix.
    pub fn is_vector(&self) -> bool {
        self.is_float() && self.len > 1 && self.len == self.rows
    }

    /// Whether it is a single float.
    pub fn is_number(&self) -> bool {
        self.is_float() && self.len == 1
    }

    /// Converts the word of one of its scalars to a number.
    pub fn number(&self, word: u64) -> f64 {
        match (self.scalar.kind, self.scalar.width) {
            (ScalarKind::Float, 8) => f64::from_bits(word),
            (ScalarKind::Sint, 8) => word as i64 as f64,
            (ScalarKind::Uint, 8) => word as f64,
            (ScalarKind::Sint, _) => f64::from(word as u32 as i32),
            (ScalarKind::Uint | ScalarKind::Bool, _) => f64::from(word as u32),
            _ => f64::from(f32::from_bits(word as u32)),
        }
    }

    /// Converts a number to the word of one of its scalars, rounded into their type.
    pub fn word(&self, x: f64) -> u64 {
        match (self.scalar.kind, self.scalar.width) {
            (ScalarKind::Float, 8) => x.to_bits(),
            (ScalarKind::Sint, 8) => x as i64 as u64,
            (ScalarKind::Uint, 8) => x as u64,
            (ScalarKind::Sint, _) => u64::from(x as i32 as u32),
            (ScalarKind::Uint | ScalarKind::Bool, _) => u64::from(x as u32),
            _ => u64::from((x as f32).to_bits()),
        }
    }

    /// Returns the numbers of its scalars in a sample.
    pub fn numbers<'s>(&'s self, sample: &'s [u64]) -> impl Iterator<Item = f64> + 's {
        self.range().map(|at| self.number(sample[at]))
    }

    /// Writes the numbers of its scalars into a sample.
    pub fn put(&self, sample: &mut [u64], numbers: &[f64]) {
        self.range().zip(numbers).for_each(|(at, x)| sample[at] = self.word(*x));
    }

    /// Returns the name of one of its scalars: `x`, `y`, `z` or `w`.
    pub fn component_name(&self, at: usize) -> &'static str {
        ["x", "y", "z", "w"].get(at - self.first).copied().unwrap_or("?")
    }

    pub fn range(&self) -> std::ops::Range<usize> {
        self.first..self.first + self.len
    }
}

/// The words of one sample, one for each scalar.
pub type Sample = Vec<u64>;

/// Returns a scalar of a sample as a float.
pub fn float(sample: &[u64], at: usize) -> f32 {
    f32::from_bits(sample[at] as u32)
}

/// The inputs of a function; bindings beside them stay zero.
#[derive(Clone, Debug)]
pub struct Inputs {
    read: Vec<Input>,
    /// The number of scalars of a sample, including unread ones.
    pub scalars: usize,
}

impl Inputs {
    /// Returns the places of the scalars that are floats.
    pub fn float_scalars(&self) -> impl Iterator<Item = usize> {
        self.read.iter().filter(|input| input.is_float()).flat_map(Input::range)
    }

    /// Returns a sample with each float changed.
    pub fn with_floats(&self, sample: &Sample, mut change: impl FnMut(f64) -> f64) -> Sample {
        let mut next = sample.clone();
        for at in self.float_scalars() {
            next[at] = u64::from((change(f64::from(float(sample, at))) as f32).to_bits());
        }
        next
    }
}

impl std::ops::Deref for Inputs {
    type Target = [Input];

    fn deref(&self) -> &[Input] {
        &self.read
    }
}

/// Returns the inputs among the sampled parameters, in the order of their scalars.
pub(super) fn inputs_of(pure: &PureFunction, sampled: &[bool]) -> Inputs {
    let mut all = Vec::new();
    let mut first = 0;
    for (parameter, sampled) in pure.parameters.iter().zip(sampled) {
        let before = all.len();
        push(&parameter.ty, parameter.path.clone(), None, &mut first, &mut all);
        if !sampled {
            all.truncate(before);
        }
    }
    // A cut-off is an inner one only beside an outer one.
    let outer: Vec<String> = all
        .iter()
        .filter(|input: &&Input| input.role == InputRole::OuterCosine)
        .map(|input| input.owner.clone())
        .collect();
    for input in &mut all {
        if input.role == InputRole::ConeCosine && outer.contains(&input.owner) {
            input.role = InputRole::InnerCosine;
        }
    }
    Inputs { read: all, scalars: first }
}

fn push(
    ty: &ValueType,
    path: String,
    member: Option<(String, String)>,
    first: &mut usize,
    all: &mut Vec<Input>,
) {
    let mut leaf = |scalar: Scalar, len: usize, rows: usize| {
        let integer = scalar.kind != ScalarKind::Float;
        let owner = path.rsplit_once('.').map_or("", |(owner, _)| owner).to_string();
        let role = if len == rows { role(&path, rows, integer) } else { InputRole::Other };
        let (path, member) = (path.clone(), member.clone());
        all.push(Input { path, member, first: *first, len, rows, scalar, role, owner });
        *first += len;
    };
    match ty {
        ValueType::Scalar(scalar) => leaf(*scalar, 1, 1),
        ValueType::Vector { scalar, rows } => leaf(*scalar, usize::from(*rows), usize::from(*rows)),
        ValueType::Matrix { scalar, columns, rows } => {
            let rows = usize::from(*rows);
            leaf(*scalar, usize::from(*columns) * rows, rows);
        }
        ValueType::Array { element, len } => {
            for index in 0..*len {
                push(element, format!("{path}[{index}]"), member.clone(), first, all);
            }
        }
        ValueType::Struct { name, members } => {
            for (member, ty) in members {
                let of = Some((name.clone(), member.clone()));
                push(ty, format!("{path}.{member}"), of, first, all);
            }
        }
    }
}
