//! The domain of a function's inputs, from JSON by path and from comments in the shader.
//!
//! Requested by [`stress`](crate::accuracy::stress) and [`bench`](mod@crate::accuracy::bench);
//! every sample is fitted into it.

use serde_json::Value;

use super::input::{Input, float};
use super::random::Random;
use landfall_layout::shape::ScalarKind;

/// The range of an input.
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
    /// The cosine of an angle.
    Cosine,
}

/// The largest coordinate of a position.
const FAR: f64 = 1.0e4;

/// The default distance of two inputs that must not coincide.
const APART: f64 = 1.0e-3;

impl ValueRange {
    fn of(word: &str) -> Option<ValueRange> {
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
    pub fn text(self) -> String {
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

/// Two inputs with a minimum distance.
#[derive(Clone, Debug, PartialEq)]
pub struct Apart {
    /// The indices of the inputs.
    pub inputs: (usize, usize),
    /// The minimum distance.
    pub least: f64,
}

/// The domain of a function's inputs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Domain {
    /// The range of each input.
    pub within: Vec<ValueRange>,
    /// The pairs that do not coincide; of two scalars the first is the greater.
    pub apart: Vec<Apart>,
}

/// An error in a domain.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refused {
    /// The error.
    pub message: String,
    /// The correct notation or value.
    pub help: Option<String>,
}

fn refused(message: String, help: impl Into<String>) -> Refused {
    Refused { message, help: Some(help.into()) }
}

impl Domain {
    /// The domain of all finite values.
    pub fn any(inputs: &[Input]) -> Domain {
        Domain { within: vec![ValueRange::Any; inputs.len()], apart: Vec::new() }
    }

    /// Adds ranges from JSON: `{"light.linear": [0, 1], "normal": "unit", "no_coincidence":
    /// [["light.position", "fragPos"]]}`.
    ///
    /// # Errors
    /// A path that the function does not have; an empty or inverted range.
    pub fn add_json(&mut self, json: &Value, inputs: &[Input]) -> Result<(), Refused> {
        let Value::Object(map) = json else {
            let help = "write `{\"normal\": \"unit\", \"shininess\": [1, 256]}`";
            return Err(refused("the domain is not an object of inputs by path".to_string(), help));
        };
        for (path, value) in map {
            if path == "no_coincidence" {
                self.add_apart(value, inputs)?;
                continue;
            }
            let within = read(path, value)?;
            let mut found = false;
            for at in inputs_named(path, inputs) {
                self.put(at, within, &inputs[at])?;
                found = true;
            }
            if !found {
                return Err(unknown(path, inputs));
            }
        }
        Ok(())
    }

    /// Restricts one input.
    ///
    /// # Errors
    /// `unit` for an input that is not a vector.
    pub fn put(&mut self, at: usize, within: ValueRange, input: &Input) -> Result<(), Refused> {
        if within == ValueRange::Unit && !input.is_vector() {
            let message = format!("`{}` is not a vector and cannot be `unit`", input.path);
            return Err(refused(message, "write a range: `[-1, 1]`"));
        }
        self.within[at] = match (input.scalar.kind, within) {
            (_, ValueRange::Any) => within,
            (kind, _) if kind.is_float() => rounded_to_type(within, input)?,
            _ => integer_range(within, input)?,
        };
        Ok(())
    }

    fn add_apart(&mut self, value: &Value, inputs: &[Input]) -> Result<(), Refused> {
        let help = "write `[[\"light.position\", \"fragPos\"], …]`";
        let wrong =
            || refused("`no_coincidence` is not a list of pairs of paths".to_string(), help);
        let Value::Array(items) = value else { return Err(wrong()) };
        // A single pair needs no outer brackets.
        let flat = items.first().is_some_and(Value::is_string);
        let pairs: Vec<&[Value]> = match flat {
            true => vec![items.as_slice()],
            false => items.iter().map(|i| i.as_array().map_or(&[][..], Vec::as_slice)).collect(),
        };
        for pair in pairs {
            let (Some(a), Some(b)) =
                (pair.first().and_then(Value::as_str), pair.get(1).and_then(Value::as_str))
            else {
                return Err(wrong());
            };
            let least = match pair.get(2) {
                None => APART,
                Some(number) => {
                    let least = number.as_f64().filter(|x| *x > 0.0 && x.is_finite());
                    least.ok_or_else(|| {
                        let message = format!("`{a}` and `{b}`: {number} is not a distance");
                        refused(message, "write a number above 0")
                    })?
                }
            };
            let (first, second) = (inputs_named(a, inputs), inputs_named(b, inputs));
            if first.is_empty() {
                return Err(unknown(a, inputs));
            }
            if second.is_empty() {
                return Err(unknown(b, inputs));
            }
            for &one in &first {
                for &other in &second {
                    if one != other && inputs[one].len == inputs[other].len {
                        self.apart.push(Apart { inputs: (one, other), least });
                    }
                }
            }
        }
        Ok(())
    }

    /// Moves a sample into the domain; returns false if that is impossible.
    pub(in crate::accuracy) fn fit(
        &self,
        sample: &mut [u64],
        inputs: &[Input],
        random: &mut Random,
    ) -> bool {
        for (within, input) in self.within.iter().zip(inputs) {
            if *within == ValueRange::Any {
                continue;
            }
            if !input.is_float() {
                fit_others(*within, sample, input, random);
                continue;
            }
            if *within == ValueRange::Unit {
                fit_unit(sample, input, random);
                continue;
            }
            let (low, high) = within.bounds();
            for at in input.range() {
                let x = float(sample, at);
                let wide = f64::from(x);
                if x.is_nan() {
                    sample[at] = bits(random.between(low, high), low, high);
                } else if wide < low || wide > high {
                    sample[at] = bits(wide, low, high);
                }
            }
        }
        self.apart.iter().all(|apart| is_apart(apart, sample, inputs))
    }

    /// Whether a sample is in the domain.
    pub fn holds(&self, sample: &[u64], inputs: &[Input]) -> bool {
        let each = self.within.iter().zip(inputs).all(|(within, input)| {
            if *within == ValueRange::Any || !input.is_float() {
                return true;
            }
            let (low, high) = within.bounds();
            if *within == ValueRange::Unit {
                let d2: f64 = input.range().map(|at| f64::from(float(sample, at)).powi(2)).sum();
                return (d2.sqrt() - 1.0).abs() < 2.5e-7;
            }
            let inside = |at| (low..=high).contains(&f64::from(float(sample, at)));
            input.range().all(inside)
        });
        each && self.apart.iter().all(|apart| is_apart(apart, sample, inputs))
    }
}

/// Moves a scalar that is not an `f32` into a range; the bounds of integers are integers.
fn fit_others(within: ValueRange, sample: &mut [u64], input: &Input, random: &mut Random) {
    let (low, high) = within.bounds();
    for at in input.range() {
        let word = sample[at];
        // A cast saturates at the bounds of the type.
        sample[at] = match (input.scalar.kind, input.scalar.width) {
            (ScalarKind::Sint, 8) => (word as i64).clamp(low as i64, high as i64) as u64,
            (ScalarKind::Sint, _) => {
                let x = (word as u32 as i32).clamp(low as i32, high as i32);
                u64::from(x as u32)
            }
            (ScalarKind::Uint, 8) => word.clamp(low as u64, high as u64),
            (ScalarKind::Bool | ScalarKind::Uint, _) => {
                u64::from((word as u32).clamp(low as u32, high as u32))
            }
            _ => {
                let x = f64::from_bits(word);
                let x = if x.is_nan() { random.between(low, high) } else { x };
                x.clamp(low, high).to_bits()
            }
        };
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

/// Returns the nearest `f32` within the bounds.
fn bits(x: f64, low: f64, high: f64) -> u64 {
    let mut single = x.clamp(low, high) as f32;
    if f64::from(single) < low {
        single = single.next_up();
    }
    if f64::from(single) > high {
        single = single.next_down();
    }
    u64::from(single.to_bits())
}

fn fit_unit(sample: &mut [u64], input: &Input, random: &mut Random) {
    let v: Vec<f64> = input.range().map(|at| f64::from(float(sample, at))).collect();
    let largest = v.iter().fold(0.0f64, |most, x| most.max(x.abs()));
    let d2: f64 = v.iter().map(|x| x * x).sum();
    // Rounding leaves the length off by a few units of the last place.
    if (d2.sqrt() - 1.0).abs() < 2.0e-7 {
        return;
    }
    let unit: Vec<f64> = if largest > 0.0 && largest.is_finite() {
        let scaled: Vec<f64> = v.iter().map(|x| x / largest).collect();
        let length = scaled.iter().map(|x| x * x).sum::<f64>().sqrt();
        scaled.iter().map(|x| x / length).collect()
    } else {
        let d = random.direction();
        let mut unit: Vec<f64> = d.to_vec();
        unit.resize(input.len.max(3), 0.0);
        unit.truncate(input.len);
        let length = unit.iter().map(|x| x * x).sum::<f64>().sqrt();
        unit.iter().map(|x| x / length).collect()
    };
    for (at, x) in input.range().zip(unit) {
        sample[at] = u64::from((x as f32).to_bits());
    }
}

/// Returns the inputs that a path names: one, or all below it.
fn inputs_named(path: &str, inputs: &[Input]) -> Vec<usize> {
    let is = |input: &Input| {
        input.path == path
            || input.path.strip_prefix(path).is_some_and(|rest| rest.starts_with(['.', '[']))
            || pattern(&input.path) == path
            || pattern(&input.path).strip_prefix(path).is_some_and(|rest| rest.starts_with('.'))
    };
    (0..inputs.len()).filter(|&at| is(&inputs[at])).collect()
}

/// Replaces indices: `data[3].color` becomes `data[].color`.
fn pattern(path: &str) -> String {
    let mut text = String::new();
    let mut inside = false;
    for c in path.chars() {
        inside &= c != ']';
        if !inside {
            text.push(c);
        }
        inside |= c == '[';
    }
    text
}

/// Parses the range of a path.
fn read(path: &str, value: &Value) -> Result<ValueRange, Refused> {
    let help = "write `[lo, hi]`, \"unit\", \"position\", \"color\" or \"cos\"";
    match value {
        Value::String(word) => ValueRange::of(word)
            .ok_or_else(|| refused(format!("`{path}`: unknown domain \"{word}\""), help)),
        Value::Array(bounds) => {
            let numbers: Vec<f64> = bounds.iter().filter_map(Value::as_f64).collect();
            match numbers[..] {
                [low, high] if bounds.len() == 2 => range(path, low, high),
                _ => Err(refused(format!("`{path}`: a range is two numbers, not {value}"), help)),
            }
        }
        other => Err(refused(format!("`{path}`: {other} is not a domain"), help)),
    }
}

/// Returns a non-empty range.
pub(in crate::accuracy) fn range(path: &str, low: f64, high: f64) -> Result<ValueRange, Refused> {
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

/// Returns the range of an input that some `f32` lies in, with the bounds as the `f32` that the same
/// numbers are in a shader; wider floats keep theirs.
fn rounded_to_type(within: ValueRange, input: &Input) -> Result<ValueRange, Refused> {
    let (low, high) = within.bounds();
    let up = if f64::from(low as f32) < low { (low as f32).next_up() } else { low as f32 };
    if input.is_float() && f64::from(up) > high {
        let (path, low, high) = (&input.path, short(low), short(high));
        let message = format!("`{path}`: the range is empty: no `f32` is from {low} to {high}");
        return Err(refused(message, "widen it"));
    }
    Ok(match within {
        ValueRange::Range(low, high) if input.is_float() => {
            let [low, high] = [low, high].map(|x| {
                let most = f64::from(f32::MAX);
                f64::from(x.clamp(-most, most) as f32)
            });
            ValueRange::Range(low, high)
        }
        _ => within,
    })
}

/// Formats a number in its fewest digits: `1`, `0.5`, `1e-320`.
fn short(x: f64) -> String {
    let single = x as f32;
    let text = if f64::from(single) == x { format!("{single:?}") } else { format!("{x:?}") };
    text.strip_suffix(".0").unwrap_or(&text).to_string()
}

/// Returns the range of integers of an input's type within the bounds.
fn integer_range(within: ValueRange, input: &Input) -> Result<ValueRange, Refused> {
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

fn unknown(path: &str, inputs: &[Input]) -> Refused {
    let names = || inputs.iter().map(|input| input.path.as_str());
    let help = match landfall_layout::text::edit_distance::nearest(path, names()) {
        Some(near) => format!("did you mean `{near}`?"),
        None => {
            let all: Vec<String> = names().take(12).map(|name| format!("`{name}`")).collect();
            format!("its inputs are {}", all.join(", "))
        }
    };
    Refused { message: format!("the function has no input `{path}`"), help: Some(help) }
}
