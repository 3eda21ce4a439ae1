//! Sums as lists of terms with their factors, so that equal terms cancel.

use super::formula::Formula::{Binary, Call, Leaf, Neg};
use super::formula::{Formula, binary, number};
use super::names::Names;

/// A term of a sum: a number times factors.
#[derive(Clone, Debug)]
pub(super) struct Term {
    pub by: f64,
    pub factors: Vec<Formula>,
}

/// How deep products are multiplied out.
const DEEPEST: u32 = 4;

/// Returns the terms of an expression; with `names`, as they are with all names read and products
/// of sums multiplied out.
pub(super) fn terms(formula: &Formula, names: Option<&Names>) -> Vec<Term> {
    let mut all = Vec::new();
    add(formula, 1.0, names, DEEPEST, &mut all);
    all
}

fn add(formula: &Formula, by: f64, names: Option<&Names>, depth: u32, into: &mut Vec<Term>) {
    // With names read, a local variable contributes the terms of its expression.
    let formula = &names.map_or_else(|| formula.clone(), |names| names.read(formula));
    match formula {
        Neg(inner) => return add(inner, -by, names, depth, into),
        Binary('+', a, b) => {
            add(a, by, names, depth, into);
            return add(b, by, names, depth, into);
        }
        Binary('-', a, b) => {
            add(a, by, names, depth, into);
            return add(b, -by, names, depth, into);
        }
        _ => {}
    }
    let mut term = Term { by, factors: Vec::new() };
    term.multiply(formula, names);
    // `a * (b + c)` becomes two terms, to a depth of four, since terms grow exponentially.
    // A factor that is a sum.
    let sum = term
        .factors
        .iter()
        .position(|factor| depth > 0 && names.is_some() && matches!(factor, Binary('+' | '-', ..)));
    let Some(at) = sum else { return into.push(term) };
    let factor = term.factors.remove(at);
    for part in terms(&factor, names) {
        let by = term.by * part.by;
        let factors = term.factors.iter().chain(&part.factors).cloned();
        let product = factors.reduce(|a, b| binary('*', a, b)).unwrap_or_else(|| number(1.0));
        add(&product, by, names, depth - 1, into);
    }
}

impl Term {
    fn multiply(&mut self, formula: &Formula, names: Option<&Names>) {
        let formula = &names.map_or_else(|| formula.clone(), |names| names.read(formula));
        if let Some(value) = formula.value() {
            self.by *= value;
            return;
        }
        match formula {
            Neg(inner) => {
                self.by = -self.by;
                self.multiply(inner, names);
            }
            Binary('*', a, b) => {
                self.multiply(a, names);
                self.multiply(b, names);
            }
            Call(name, of) if name == "pow" && of.len() == 2 && of[1].value() == Some(2.0) => {
                self.multiply(&of[0], names);
                self.multiply(&of[0], names);
            }
            Binary('/', a, b) if b.value().is_some_and(|value| value != 0.0) => {
                self.by /= b.value().unwrap_or(1.0);
                self.multiply(a, names);
            }
            other => self.factors.push(other.clone()),
        }
    }

    /// Returns what two terms have in common if they cancel or add up.
    fn key(&self) -> Vec<String> {
        // Factors are compared as text, in order: `a * b` and `b * a` cancel.
        let mut all: Vec<String> = self.factors.iter().map(Formula::to_string).collect();
        all.sort();
        all
    }

    /// Returns a root of its absolute value, if it is a square.
    pub fn root(&self) -> Option<Formula> {
        let root = self.by.abs().sqrt();
        // 4.0 has the root 2.0, exactly; 2.0 has none.
        let whole = root * root == self.by.abs();
        let mut factors: Vec<(String, &Formula)> =
            self.factors.iter().map(|factor| (factor.to_string(), factor)).collect();
        factors.sort_by(|a, b| a.0.cmp(&b.0));
        // Sorted factors of a square come in equal pairs.
        let pairs = factors.chunks(2);
        let is_square = pairs.clone().all(|pair| pair.len() == 2 && pair[0].0 == pair[1].0);
        let factors = pairs.map(|pair| pair[0].1.clone()).collect();
        (whole && is_square).then(|| Term { by: root, factors }.absolute())
    }

    /// Returns it as an expression, without its sign.
    pub fn absolute(&self) -> Formula {
        let by = self.by.abs();
        let number = (by != 1.0 || self.factors.is_empty()).then(|| number(by));
        let all = number.into_iter().chain(self.factors.iter().cloned());
        all.reduce(|a, b| binary('*', a, b)).unwrap_or_else(|| Leaf("1.0".to_string()))
    }
}

/// Adds up terms with the same factors.
pub(super) fn collected(all: Vec<Term>) -> Vec<Term> {
    let mut sums: Vec<(Vec<String>, Term)> = Vec::new();
    for term in all {
        let key = term.key();
        match sums.iter_mut().find(|(known, _)| *known == key) {
            Some((_, sum)) => sum.by += term.by,
            None => sums.push((key, term)),
        }
    }
    sums.into_iter().map(|(_, term)| term).filter(|term| term.by != 0.0).collect()
}

/// Returns terms as an expression, one that is added first.
pub(super) fn sum(all: &[Term]) -> Formula {
    // A positive term first, so that the text does not begin with a minus.
    let mut ordered: Vec<&Term> = all.iter().collect();
    ordered.sort_by_key(|term| term.by < 0.0);
    let mut sum: Option<Formula> = None;
    for term in ordered {
        sum = Some(match (sum, term.by < 0.0) {
            (None, false) => term.absolute(),
            (None, true) => Neg(Box::new(term.absolute())),
            (Some(before), negative) => {
                binary(if negative { '-' } else { '+' }, before, term.absolute())
            }
        });
    }
    sum.unwrap_or_else(|| number(0.0))
}

/// Returns terms with the other sign.
pub(super) fn negative(all: &[Term]) -> Vec<Term> {
    all.iter().map(|term| Term { by: -term.by, ..term.clone() }).collect()
}
