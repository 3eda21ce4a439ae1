//! The domain of a function's inputs: their ranges, and how values are distributed over them.
//!
//! Stated in JSON by path (`json`) and in comments of the shader; `sampler`
//! draws from it, and searches move their samples into it.

mod json;

use landfall_layout::shape::ScalarKind;

use super::distribution::Distribution;
use super::input::{Input, float};
use super::random::Random;

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ValueRange {
    /// Any finite value.
    Any,
    /// From a lower to an upper bound, for each scalar.
    Range(f64, f64),
    /// A vector of length one, up to rounding.
    Unit,
    /// A position in a scene: each coordinate up to 10 000.
    Position,
    /// From 0 to 1, for each scalar.
    Color,
    Cosine,
}

/// The largest coordinate of a position.
const FAR: f64 = 1.0e4;

/// The largest error of the length of a unit vector: rounding leaves a few units of the last place.
const UNIT: f64 = 2.5e-7;

impl ValueRange {
    fn from_word(word: &str) -> Option<ValueRange> {
        Some(match word {
            "any" => ValueRange::Any,
            "unit" => ValueRange::Unit,
            "position" => ValueRange::Position,
            "color" | "colour" => ValueRange::Color,
            "cos" | "cosine" => ValueRange::Cosine,
            _ => return None,
        })
    }

    /// The notation in comments and messages.
    fn text(self) -> String {
        match self {
            ValueRange::Any => "any".to_string(),
            ValueRange::Range(low, high) => format!("{}..{}", short(low), short(high)),
            ValueRange::Unit => "unit".to_string(),
            ValueRange::Position => "position".to_string(),
            ValueRange::Color => "color".to_string(),
            ValueRange::Cosine => "cos".to_string(),
        }
    }

    /// Returns the least and the greatest value of its scalars.
    pub fn bounds(self) -> (f64, f64) {
        match self {
            ValueRange::Any => (f64::from(f32::MIN), f64::from(f32::MAX)),
            ValueRange::Range(low, high) => (low, high),
            ValueRange::Unit | ValueRange::Cosine => (-1.0, 1.0),
            ValueRange::Position => (-FAR, FAR),
            ValueRange::Color => (0.0, 1.0),
        }
    }
}

/// What is stated of a scalar of a vector beside the range of the whole.
#[derive(Clone, Debug, PartialEq)]
pub struct Component {
    /// The index of the scalar in a sample.
    pub at: usize,
    pub bounds: (f64, f64),
    /// How values are distributed between them.
    pub distribution: Distribution,
}

/// Two inputs with a minimum distance.
#[derive(Clone, Debug, PartialEq)]
pub struct Apart {
    pub inputs: (usize, usize),
    /// The minimum distance.
    pub least: f64,
}

#[derive(Clone, Debug, Default, PartialEq)]
pub struct Domain {
    pub within: Vec<ValueRange>,
    /// How the values of each input are distributed over its range.
    pub distributions: Vec<Distribution>,
    /// The ranges of single components. That of a component of a unit vector holds beside its
    /// length, any other in place of the vector's.
    pub components: Vec<Component>,
    /// The pairs that do not coincide; of two scalars the first is the greater.
    pub apart: Vec<Apart>,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DomainError {
    pub message: String,
    /// The correct notation or value.
    pub help: Option<String>,
}

fn refused(message: String, help: impl Into<String>) -> DomainError {
    DomainError { message, help: Some(help.into()) }
}

impl Domain {
    /// The domain of all finite values.
    pub fn any(inputs: &[Input]) -> Domain {
        Domain {
            within: vec![ValueRange::Any; inputs.len()],
            distributions: vec![Distribution::Uniform; inputs.len()],
            ..Domain::default()
        }
    }

    /// Restricts one input.
    ///
    /// # Errors
    /// `unit` for an input that is not a vector; a range without a value of its type.
    pub fn put(&mut self, at: usize, within: ValueRange, input: &Input) -> Result<(), DomainError> {
        if within == ValueRange::Unit && !input.is_vector() {
            let message = format!("`{}` is not a vector and cannot be `unit`", input.path);
            return Err(refused(message, "write a range: `[-1, 1]`"));
        }
        self.within[at] = in_type(within, input)?;
        self.distributions[at] = Distribution::Uniform;
        // What was stated of components belonged to the former range.
        self.components.retain(|component| !input.range().contains(&component.at));
        Ok(())
    }

    /// Returns the bounds of a scalar of an input.
    pub fn bounds(&self, input: usize, at: usize) -> (f64, f64) {
        self.component(at).map_or(self.within[input].bounds(), |component| component.bounds)
    }

    /// Returns how a scalar of an input is distributed between its bounds.
    pub(super) fn distribution(&self, input: usize, at: usize) -> &Distribution {
        self.component(at).map_or(&self.distributions[input], |component| &component.distribution)
    }

    /// Whether anything is stated of a scalar of an input.
    pub(crate) fn states(&self, input: usize, at: usize) -> bool {
        self.within[input] != ValueRange::Any || self.component(at).is_some()
    }

    fn component(&self, at: usize) -> Option<&Component> {
        self.components.iter().find(|component| component.at == at)
    }

    /// Returns the range of an input and of its components as messages print it, without their
    /// distributions.
    pub fn text(&self, at: usize, input: &Input) -> String {
        let whole = self.within[at].text();
        let of = |c: &Component| {
            let (low, high) = c.bounds;
            let name = input.component_name(c.at);
            format!(", {name} in {}..{}", short(low), short(high))
        };
        self.components_of(input).fold(whole, |text, component| text + &of(component))
    }

    /// Returns how an input is distributed, as reports print it; `None` if nothing is stated.
    pub fn distribution_text(&self, at: usize, input: &Input) -> Option<String> {
        let of = |(low, high): (f64, f64), distribution: &Distribution| match low == high {
            true => format!("fixed at {}", short(low)),
            false => format!("{} in {}..{}", distribution.text(), short(low), short(high)),
        };
        let whole = match self.within[at] {
            ValueRange::Any => None,
            ValueRange::Unit => Some("unit, uniform over directions".to_string()),
            within => Some(of(within.bounds(), &self.distributions[at])),
        };
        let components = self.components_of(input).map(|component| {
            let stated = of(component.bounds, &component.distribution);
            format!("{} {stated}", input.component_name(component.at))
        });
        whole.into_iter().chain(components).reduce(|all, one| format!("{all}, {one}"))
    }

    pub(super) fn components_of(&self, input: &Input) -> impl Iterator<Item = &Component> {
        let range = input.range();
        self.components.iter().filter(move |component| range.contains(&component.at))
    }

    /// Moves a sample of a search to the nearest one in the domain; returns false if that is
    /// impossible.
    pub(crate) fn fit(&self, sample: &mut [u64], inputs: &[Input], random: &mut Random) -> bool {
        for (nth, input) in inputs.iter().enumerate() {
            if self.within[nth] == ValueRange::Unit {
                let mut v: Vec<f64> = input.numbers(sample).collect();
                if !(self.is_unit(&v, input) || self.to_unit(&mut v, input, random)) {
                    return false;
                }
                input.put(sample, &v);
                continue;
            }
            for at in input.range().filter(|at| self.states(nth, *at)) {
                let (low, high) = self.bounds(nth, at);
                let x = input.number(sample[at]);
                if x.is_nan() {
                    sample[at] = input.word(random.between(low, high));
                } else if x < low || x > high {
                    sample[at] = input.word(x.clamp(low, high));
                }
            }
        }
        self.keeps_apart(sample, inputs)
    }

    pub fn holds(&self, sample: &[u64], inputs: &[Input]) -> bool {
        let each = inputs.iter().enumerate().all(|(nth, input)| {
            if self.within[nth] == ValueRange::Unit {
                return self.is_unit(&input.numbers(sample).collect::<Vec<f64>>(), input);
            }
            input.range().filter(|at| self.states(nth, *at)).all(|at| {
                let (low, high) = self.bounds(nth, at);
                (low..=high).contains(&input.number(sample[at]))
            })
        });
        each && self.keeps_apart(sample, inputs)
    }

    /// Whether inputs that must not coincide do not.
    pub(super) fn keeps_apart(&self, sample: &[u64], inputs: &[Input]) -> bool {
        self.apart.iter().all(|apart| is_apart(apart, sample, inputs))
    }

    /// Whether a vector has length one, and its components the ranges stated for them.
    pub(super) fn is_unit(&self, v: &[f64], input: &Input) -> bool {
        let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
        let inside = |c: &Component| (c.bounds.0..=c.bounds.1).contains(&v[c.at - input.first]);
        (length - 1.0).abs() < UNIT && self.components_of(input).all(inside)
    }

    /// Scales a vector to length one; components with a range of their own are moved into it if
    /// they are outside then. Returns false if that is impossible.
    fn to_unit(&self, v: &mut [f64], input: &Input, random: &mut Random) -> bool {
        let largest = v.iter().fold(0.0f64, |most, x| most.max(x.abs()));
        if !(largest > 0.0 && largest.is_finite()) || v.iter().any(|x| x.is_nan()) {
            v.copy_from_slice(&random.unit_vector(v.len()));
        }
        scale(v, 1.0, |_| true);
        let inside = |c: &Component| (c.bounds.0..=c.bounds.1).contains(&v[c.at - input.first]);
        self.components_of(input).all(inside) || self.scale_others(v, input, random)
    }

    /// Moves the components of a vector that have a range of their own into it, and scales the
    /// others so that its length is one. Returns false if that is impossible.
    pub(super) fn scale_others(&self, v: &mut [f64], input: &Input, random: &mut Random) -> bool {
        let stated: Vec<usize> = self.components_of(input).map(|c| c.at - input.first).collect();
        let mut left = 1.0;
        for (i, c) in stated.iter().zip(self.components_of(input)) {
            v[*i] = v[*i].clamp(c.bounds.0, c.bounds.1);
            left -= v[*i] * v[*i];
        }
        for (i, x) in v.iter_mut().enumerate() {
            // A zero cannot be scaled: some direction is needed for the rest of the length.
            if *x == 0.0 && !stated.contains(&i) {
                *x = random.normal() * 1e-3;
            }
        }
        scale(v, left.max(0.0).sqrt(), |i| !stated.contains(&i));
        // Checked as the function gets it, in `f32`.
        let rounded: Vec<f64> = v.iter().map(|x| f64::from(*x as f32)).collect();
        self.is_unit(&rounded, input)
    }
}

/// Scales some components of a vector to a length together.
fn scale(v: &mut [f64], length: f64, is: impl Fn(usize) -> bool) {
    let some = || (0..v.len()).filter(|i| is(*i));
    let most = some().fold(0.0f64, |most, i| most.max(v[i].abs()));
    // Divided by the largest first, so that no square overflows.
    let by = length / some().map(|i| (v[i] / most).powi(2)).sum::<f64>().sqrt();
    for (_, x) in v.iter_mut().enumerate().filter(|(i, _)| is(*i)) {
        *x = *x / most * by;
    }
}

fn is_apart(apart: &Apart, sample: &[u64], inputs: &[Input]) -> bool {
    let (a, b) = (&inputs[apart.inputs.0], &inputs[apart.inputs.1]);
    let off = |(i, j)| f64::from(float(sample, i)) - f64::from(float(sample, j));
    let mut offs = a.range().zip(b.range()).map(off);
    if a.len == 1 {
        return offs.next().is_some_and(|off| off >= apart.least);
    }
    let d2: f64 = offs.map(|off| off * off).sum();
    d2.sqrt() >= apart.least
}

/// Returns a non-empty range.
pub(crate) fn range(path: &str, low: f64, high: f64) -> Result<ValueRange, DomainError> {
    let (least, most) = (short(low), short(high));
    if low > high {
        let message = format!("`{path}`: the range from {least} to {most} is inverted");
        return Err(refused(message, format!("write `[{most}, {least}]`")));
    }
    if !low.is_finite() || !high.is_finite() {
        let message = format!("`{path}`: the range from {least} to {most} is infinite");
        return Err(refused(message, "write two finite numbers"));
    }
    Ok(ValueRange::Range(low, high))
}

/// Returns a range with the bounds as values of an input's type.
fn in_type(within: ValueRange, input: &Input) -> Result<ValueRange, DomainError> {
    match (input.scalar.kind, within) {
        (_, ValueRange::Any) => Ok(within),
        (kind, _) if kind.is_float() => rounded_to_type(within, input),
        _ => integer_range(within, input),
    }
}

/// Returns the range of an input with the bounds as the `f32` that the same numbers are in a
/// shader; wider floats keep theirs.
fn rounded_to_type(within: ValueRange, input: &Input) -> Result<ValueRange, DomainError> {
    let ValueRange::Range(low, high) = within else { return Ok(within) };
    if !input.is_float() {
        return Ok(within);
    }
    // The least `f32` that is not below the lower bound.
    let up = if f64::from(low as f32) < low { (low as f32).next_up() } else { low as f32 };
    if low < high && f64::from(up) > high {
        let (path, low, high) = (&input.path, short(low), short(high));
        let message = format!("`{path}`: the range is empty: no `f32` is from {low} to {high}");
        return Err(refused(message, "widen it"));
    }
    let [low, high] = [low, high].map(|x| {
        let most = f64::from(f32::MAX);
        f64::from(x.clamp(-most, most) as f32)
    });
    Ok(ValueRange::Range(low, high))
}

/// Formats a number in its fewest digits: `1`, `0.5`, `1e-320`.
fn short(x: f64) -> String {
    let single = x as f32;
    let text = if f64::from(single) == x { format!("{single:?}") } else { format!("{x:?}") };
    text.strip_suffix(".0").unwrap_or(&text).to_string()
}

/// Returns the range of integers of an input's type within the bounds.
fn integer_range(within: ValueRange, input: &Input) -> Result<ValueRange, DomainError> {
    let (least, most, name) = match (input.scalar.kind, input.scalar.width) {
        (ScalarKind::Bool, _) => (0.0, 1.0, "bool"),
        (ScalarKind::Sint, 8) => (i64::MIN as f64, i64::MAX as f64, "i64"),
        (ScalarKind::Sint, _) => (f64::from(i32::MIN), f64::from(i32::MAX), "int"),
        (_, 8) => (0.0, u64::MAX as f64, "u64"),
        (_, _) => (0.0, f64::from(u32::MAX), "uint"),
    };
    let (low, high) = within.bounds();
    let (first, last) = (low.ceil().max(least), high.floor().min(most));
    if first > last {
        let message =
            format!("`{}`: no `{name}` is from {} to {}", input.path, short(low), short(high));
        return Err(refused(message, "widen it"));
    }
    Ok(ValueRange::Range(first, last))
}
