//! Domains in JSON: ranges, distributions and pairs of inputs that do not coincide, by path.

use std::sync::Arc;

use serde_json::{Map, Value};

use super::{Apart, Component, Domain, DomainError, Input, ValueRange, in_type, range, refused};
use crate::inputs::distribution::{Distribution, Histogram};
use landfall_layout::text::edit_distance::suggestion;

/// The default distance of two inputs that must not coincide.
const APART: f64 = 1.0e-3;

/// The standard deviations within which a normal distribution without a range lies.
const DEVIATIONS: f64 = 4.0;

/// The key of pairs of inputs that must not coincide.
const NO_COINCIDENCE: &str = "no_coincidence";

/// What JSON states of a path.
struct Stated {
    within: ValueRange,
    distribution: Distribution,
}

impl Domain {
    /// Adds ranges from JSON: `{"light.linear": [0, 1], "normal": "unit", "normal.z": [0, 1],
    /// "roughness": {"log": [0.01, 1]}, "no_coincidence": [["light.position", "fragPos"]]}`.
    ///
    /// # Errors
    /// A path that the function does not have; an empty or inverted range; a distribution that does
    /// not fit its range.
    pub fn add_json(&mut self, json: &Value, inputs: &[Input]) -> Result<(), DomainError> {
        let Value::Object(map) = json else {
            let help = "write `{\"normal\": \"unit\", \"shininess\": [1, 256]}`";
            return Err(refused("the domain is not an object of inputs by path".to_string(), help));
        };
        // Whole inputs first: their components are stated beside them, in any order.
        let ranges = || map.iter().filter(|(path, _)| *path != NO_COINCIDENCE);
        for (path, value) in ranges() {
            let stated = read(path, value)?;
            for at in inputs_named(path, inputs) {
                self.put(at, stated.within, &inputs[at])?;
                self.distributions[at] = stated.distribution.clone();
            }
        }
        for (path, value) in ranges().filter(|(path, _)| inputs_named(path, inputs).is_empty()) {
            let stated = read(path, value)?;
            let scalars = components_named(path, inputs);
            if scalars.is_empty() {
                return Err(unknown(path, inputs));
            }
            for (input, at) in scalars {
                self.put_component(path, (&inputs[input], at), &stated)?;
            }
        }
        map.get(NO_COINCIDENCE).map_or(Ok(()), |value| self.add_apart(value, inputs))
    }

    fn put_component(
        &mut self,
        path: &str,
        (input, at): (&Input, usize),
        stated: &Stated,
    ) -> Result<(), DomainError> {
        if stated.within == ValueRange::Unit {
            let message = format!("`{path}` is not a vector and cannot be `unit`");
            return Err(refused(message, "write a range: `[-1, 1]`"));
        }
        let bounds = in_type(stated.within, input)?.bounds();
        self.components.retain(|component| component.at != at);
        self.components.push(Component { at, bounds, distribution: stated.distribution.clone() });
        Ok(())
    }

    fn add_apart(&mut self, value: &Value, inputs: &[Input]) -> Result<(), DomainError> {
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
                    // A path may name several inputs, as all elements of an array; each pair of one
                    // size is kept apart.
                    if one != other && inputs[one].len == inputs[other].len {
                        self.apart.push(Apart { inputs: (one, other), least });
                    }
                }
            }
        }
        Ok(())
    }
}

/// Parses the range and the distribution of a path.
fn read(path: &str, value: &Value) -> Result<Stated, DomainError> {
    let uniform = |within| Stated { within, distribution: Distribution::Uniform };
    let help = "write `[lo, hi]`, \"unit\", \"position\", \"color\" or \"cos\"";
    match value {
        Value::String(word) => ValueRange::from_word(word)
            .map(uniform)
            .ok_or_else(|| refused(format!("`{path}`: unknown domain \"{word}\""), help)),
        Value::Array(_) => {
            let (low, high) = pair(path, value)?;
            range(path, low, high).map(uniform)
        }
        Value::Object(map) => distributed(path, map),
        other => Err(refused(format!("`{path}`: {other} is not a domain"), help)),
    }
}

/// Parses `{"log": [lo, hi]}`, `{"normal": [mean, deviation], "in": [lo, hi]}` and
/// `{"histogram": {"edges": […], "counts": […]}}`.
fn distributed(path: &str, map: &Map<String, Value>) -> Result<Stated, DomainError> {
    let help = "write `{\"log\": [lo, hi]}`, `{\"normal\": [mean, deviation], \"in\": [lo, hi]}` \
                or `{\"histogram\": FILE}`";
    let wrong = |what: String| refused(format!("`{path}`: {what}"), help);
    let limits = map.get("in").map(|limits| pair(path, limits)).transpose()?;
    let mut kinds = map.iter().filter(|(key, _)| *key != "in");
    let (Some((kind, value)), None) = (kinds.next(), kinds.next()) else {
        return Err(wrong("not one distribution".to_string()));
    };
    let (distribution, own) = match kind.as_str() {
        "uniform" => (Distribution::Uniform, pair(path, value)?),
        "log" => (Distribution::Log, pair(path, value)?),
        "normal" => {
            let (mean, deviation) = pair(path, value)?;
            if deviation.is_nan() || deviation <= 0.0 {
                return Err(wrong(format!("{deviation} is not a standard deviation")));
            }
            let reach = DEVIATIONS * deviation;
            (Distribution::Normal { mean, deviation }, (mean - reach, mean + reach))
        }
        "histogram" => {
            let histogram = histogram(value).ok_or_else(|| {
                let what = "a histogram is `{\"edges\": [0, 1, 4], \"counts\": [5, 2]}`, with \
                            ascending edges, one more than counts";
                wrong(what.to_string())
            })?;
            let bounds = histogram.bounds();
            (Distribution::Histogram(Arc::new(histogram)), bounds)
        }
        other => return Err(wrong(format!("unknown distribution \"{other}\""))),
    };
    let (low, high) = match (&distribution, limits) {
        (Distribution::Normal { .. }, Some(limits)) => limits,
        (_, Some(_)) => return Err(wrong(format!("\"in\" has no meaning beside \"{kind}\""))),
        (_, None) => own,
    };
    let within = range(path, low, high)?;
    distribution.fits(low, high).map_err(wrong)?;
    Ok(Stated { within, distribution })
}

fn histogram(value: &Value) -> Option<Histogram> {
    let numbers = |key: &str| -> Option<Vec<f64>> {
        value.get(key)?.as_array()?.iter().map(Value::as_f64).collect()
    };
    Histogram::new(numbers("edges")?, &numbers("counts")?)
}

fn pair(path: &str, value: &Value) -> Result<(f64, f64), DomainError> {
    let numbers = value.as_array().map(|all| all.iter().map(Value::as_f64).collect());
    match numbers {
        Some(Some::<Vec<f64>>(all)) if all.len() == 2 => Ok((all[0], all[1])),
        _ => Err(refused(
            format!("`{path}`: a range is two numbers, not {value}"),
            "write `[lo, hi]`, \"unit\", \"position\", \"color\" or \"cos\"",
        )),
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

/// Returns the scalars that a path such as `d.x` names, each with its input.
fn components_named(path: &str, inputs: &[Input]) -> Vec<(usize, usize)> {
    let Some((vector, name)) = path.rsplit_once('.') else { return Vec::new() };
    let number = ["xyzw", "rgba"].iter().find_map(|all| all.find(name).filter(|_| name.len() == 1));
    let Some(number) = number else { return Vec::new() };
    let is = |input: &Input| {
        input.len == input.rows
            && number < input.len
            && input.len > 1
            && (input.path == vector || pattern(&input.path) == vector)
    };
    let all = inputs.iter().enumerate().filter(|(_, input)| is(input));
    all.map(|(nth, input)| (nth, input.first + number)).collect()
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

fn unknown(path: &str, inputs: &[Input]) -> DomainError {
    let names = || inputs.iter().map(|input| input.path.as_str());
    let help = suggestion(path, names()).unwrap_or_else(|| {
        let all: Vec<String> = names().take(12).map(|name| format!("`{name}`")).collect();
        format!("its inputs are {}", all.join(", "))
    });
    DomainError { message: format!("the function has no input `{path}`"), help: Some(help) }
}
