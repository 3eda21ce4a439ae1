//! Names the values that led to a result that is NaN, infinite or undefined: arguments, inputs and
//! members of blocks.
//!
//! Goes back through a [`Trace`]. Used by [`call`](mod@super::call) for one call and one sample, and
//! by [`fragments`](super::fragments) for one pixel.

use std::fmt;

use landfall_interp::{
    NonFinite, Operand, Program, Source, SourceLocation, Trace, TracedOperation, UndefinedKind,
    ValueType,
};
use landfall_ir::Module;
use landfall_layout::layout::BlockLayout;
use landfall_layout::layout::byte::{ByteOwner, owner_of_byte};
use landfall_layout::source::Language;

/// A value that a run read.
#[derive(Clone, Debug)]
pub struct ReadValue {
    /// The path in the shader: `u.lights[2].range`.
    pub path: String,
    /// The number, or the components of a vector.
    pub values: Vec<f64>,
}

/// What made a number NaN or infinite.
#[derive(Clone, Debug, PartialEq)]
pub struct Cause {
    /// The operation; `None` if the number was read so.
    pub operation: Option<(UndefinedKind, SourceLocation)>,
    /// The values that led to it.
    pub from: Vec<ReadValue>,
}

/// The names of what a program reads.
#[derive(Debug)]
pub(super) struct Names<'m> {
    pub program: &'m Program,
    pub module: &'m Module,
    pub language: Language,
    /// The parameters of the called function.
    pub parameters: Vec<(String, ValueType)>,
}

/// A scalar of a vector, matrix or scalar of the shader.
struct NamedComponent {
    leaf: String,
    /// The number of components of the leaf.
    of: usize,
    index: usize,
    path: String,
}

/// NaN is the same as NaN.
impl PartialEq for ReadValue {
    fn eq(&self, other: &ReadValue) -> bool {
        let bits = |of: &ReadValue| of.values.iter().map(|x| x.to_bits()).collect::<Vec<u64>>();
        self.path == other.path && bits(self) == bits(other)
    }
}

impl fmt::Display for ReadValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let values: Vec<String> = self.values.iter().map(|x| number(*x)).collect();
        match &values[..] {
            [one] => write!(f, "{} = {one}", self.path),
            all => write!(f, "{} = ({})", self.path, all.join(", ")),
        }
    }
}

/// The most values that a text lists.
const MAX_LISTED: usize = 6;

/// Returns the text of the values that led to a result; `None` if there are none.
pub fn comes_from(from: &[ReadValue]) -> Option<String> {
    let mut each: Vec<String> = from.iter().take(MAX_LISTED).map(ReadValue::to_string).collect();
    if from.len() > MAX_LISTED {
        each.push(format!("{} more", from.len() - MAX_LISTED));
    }
    (!each.is_empty()).then(|| format!("comes from {}", each.join(", ")))
}

/// Formats a number with all its digits.
pub fn number(x: f64) -> String {
    if x.is_nan() {
        return "NaN".to_string();
    }
    if x.is_infinite() {
        return if x > 0.0 { "inf" } else { "-inf" }.to_string();
    }
    // The fewest digits that tell the number, as an `f32` if it is one.
    let single = x as f32;
    let plain = if f64::from(single) == x { format!("{single:?}") } else { format!("{x:?}") };
    plain.strip_suffix(".0").unwrap_or(&plain).to_string()
}

/// Returns what the members of a block are named by; `None` if by themselves.
pub(super) fn instance(layout: &BlockLayout, language: Language) -> Option<&str> {
    // A variable of WGSL that is no structure is its own member.
    let name = layout.instance.as_deref().unwrap_or(&layout.name);
    if matches!(&layout.members[..], [only] if *only.name == *name) {
        return None;
    }
    layout.instance.as_deref().or(match &*layout.name {
        _ if layout.gathered || language == Language::Glsl => None,
        "" => None,
        name => Some(name),
    })
}

impl Names<'_> {
    /// Returns what made a result NaN or infinite.
    pub fn cause(&self, trace: &Trace, result: Operand) -> Cause {
        match trace.non_finite(result) {
            NonFinite::Operation(step) => Cause {
                operation: step.fault().map(|kind| (kind, self.program.place_of(step))),
                from: self.values(&trace.led_to(step)),
            },
            NonFinite::Read(read) => Cause { operation: None, from: self.values(&[read]) },
        }
    }

    /// Returns the values that led to an operation without a defined value, for the first time; `None`
    /// if it is not met.
    pub fn led_to(
        &self,
        trace: &Trace,
        kind: UndefinedKind,
        place: &SourceLocation,
    ) -> Option<Vec<ReadValue>> {
        // No operation made it: it is the operand of one.
        if kind == UndefinedKind::NanFromBuffer {
            let is_loaded = |o: &&Operand| matches!(o.source, Source::Buffer { .. });
            let is_nan = |o: &&Operand| o.number.single.is_nan() && is_loaded(o);
            let loads = trace.steps.iter().flat_map(|step| &step.operands).filter(is_nan);
            let loads: Vec<Operand> = loads.copied().collect();
            return (!loads.is_empty()).then(|| self.values(&loads));
        }
        let is_it = |step: &&TracedOperation| {
            (step.undefined == Some(kind) || step.fault() == Some(kind))
                && self.program.place_of(step) == *place
        };
        let found = trace.steps.iter().find(is_it);
        found.map(|step| self.values(&trace.led_to(step)))
    }

    /// Returns inputs and loads by their paths; a vector that was read whole is one value.
    pub fn values(&self, operands: &[Operand]) -> Vec<ReadValue> {
        let mut leaves: Vec<Vec<(NamedComponent, f64)>> = Vec::new();
        for operand in operands {
            let Some(component) = self.component(operand.source) else { continue };
            let value = operand.number.double;
            match leaves.iter_mut().find(|leaf| leaf[0].0.leaf == component.leaf) {
                Some(leaf) => leaf.push((component, value)),
                None => leaves.push(vec![(component, value)]),
            }
        }
        let mut all = Vec::new();
        for mut leaf in leaves {
            // Operations may read components in any order.
            leaf.sort_by_key(|(component, _)| component.index);
            // A component may have been read more than once.
            leaf.dedup_by_key(|(component, _)| component.index);
            // More than a vector has are shown one by one.
            if leaf.len() == leaf[0].0.of && leaf.len() <= 4 {
                let values = leaf.iter().map(|(_, value)| *value).collect();
                all.push(ReadValue { path: leaf.swap_remove(0).0.leaf, values });
            } else {
                let each = leaf.into_iter();
                all.extend(each.map(|(c, value)| ReadValue { path: c.path, values: vec![value] }));
            }
        }
        all
    }

    fn component(&self, source: Source) -> Option<NamedComponent> {
        match source {
            Source::Input { parameter, scalar } => {
                let (name, ty) = self.parameters.get(parameter as usize)?;
                component_of(name, ty, scalar as usize)
            }
            Source::Buffer { buffer, byte } => {
                let variable = self.program.variable_of(buffer)?;
                let blocks = self.module.blocks().iter();
                let layout = &blocks.clone().find(|block| block.variable == variable)?.layout;
                let owner = owner_of_byte(layout, u64::from(byte));
                let ByteOwner::Component {
                    leaf, leaf_offset, leaf_size, path, offset, size, ..
                } = owner
                else {
                    return None;
                };
                let named = |path: String| match instance(layout, self.language) {
                    Some(instance) => format!("{instance}.{path}"),
                    None => path,
                };
                // Components are counted from the beginning of the leaf.
                let index = ((offset - leaf_offset) / size.max(1)) as usize;
                let of = (leaf_size / size.max(1)) as usize;
                Some(NamedComponent { leaf: named(leaf), of, index, path: named(path) })
            }
            Source::Constant | Source::Step { .. } | Source::Unknown => None,
        }
    }
}

/// Returns a scalar of a value, by its number.
fn component_of(path: &str, ty: &ValueType, nth: usize) -> Option<NamedComponent> {
    const ROWS: [&str; 4] = ["x", "y", "z", "w"];
    match ty {
        ValueType::Scalar(_) => {
            let path = path.to_string();
            Some(NamedComponent { leaf: path.clone(), of: 1, index: 0, path })
        }
        ValueType::Vector { rows, .. } => Some(NamedComponent {
            leaf: path.to_string(),
            of: usize::from(*rows),
            index: nth,
            path: format!("{path}.{}", ROWS.get(nth)?),
        }),
        ValueType::Matrix { scalar, rows, .. } => {
            let column = ValueType::Vector { scalar: *scalar, rows: *rows };
            let rows = usize::from(*rows).max(1);
            component_of(&format!("{path}[{}]", nth / rows), &column, nth % rows)
        }
        ValueType::Array { element, .. } => {
            let each = element.scalars().len().max(1);
            component_of(&format!("{path}[{}]", nth / each), element, nth % each)
        }
        ValueType::Struct { members, .. } => {
            let mut nth = nth;
            for (name, ty) in members {
                let scalars = ty.scalars().len();
                if nth < scalars {
                    return component_of(&format!("{path}.{name}"), ty, nth);
                }
                nth -= scalars;
            }
            None
        }
    }
}
