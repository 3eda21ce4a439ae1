//! The catalogue of rewrites: other forms of an expression, equal in exact arithmetic.
//!
//! After Higham, Accuracy and Stability of Numerical Algorithms (2002), 1.7 to 1.13, and Panchekha
//! et al., Herbie (PLDI 2015). Whether a form is better at all is measured by
//! `advice`.

use super::formula::Formula::{self, Call, Neg};
use super::formula::{binary, call, number};
use super::names::Names;
use super::terms::{Term, collected, negative, sum, terms};
use landfall_layout::source::Language;

/// Another form of an expression.
#[derive(Clone, Debug)]
pub(super) struct Form {
    pub name: &'static str,
    pub code: String,
    /// Whether it gains only where a device rounds a product and a sum once.
    pub is_fused: bool,
}

/// Returns the other forms of an expression that loses digits.
pub(super) fn forms(formula: &Formula, names: &Names, language: Language) -> Vec<Form> {
    // Each rewrite looks for its pattern in the terms of a sum and gives no form where it does not
    // fit.
    let mut all: Vec<Form> = Vec::new();
    let mut push = |name: &'static str, form: Formula| {
        all.push(Form { name, code: form.to_string(), is_fused: false })
    };
    let written = terms(formula, None);
    conjugates(&written, names).into_iter().for_each(|form| push("conjugate", form));
    squares(formula, names).into_iter().for_each(|form| push("factored difference", form));
    chords(&written, names).into_iter().for_each(|form| push("difference of the vectors", form));
    angles(&written, names).into_iter().for_each(|form| push("sine of half the angle", form));
    horner(formula, names).into_iter().for_each(|form| push("Horner's form", form));
    interpolations(&written, names)
        .into_iter()
        .for_each(|form| push("weights that add up to 1", form));
    for (name, form) in series(formula, &written, names) {
        let NearZeroSeries { x, near, close } = form;
        let near = near.to_string();
        let code = match language {
            Language::Wgsl => format!("select({formula}, {close}, abs({x}) < {near})"),
            _ => format!("(abs({x}) < {near} ? {close} : {formula})"),
        };
        all.push(Form { name, code, is_fused: false });
    }
    let single = fused(&written).into_iter().map(|form| Form {
        name: "fused, where the device fuses",
        code: form.to_string(),
        is_fused: true,
    });
    all.extend(single);
    let own = formula.to_string();
    all.retain(|form| form.code != own);
    all
}

/// `a + b` as `(a * a - b * b) / (a - b)`, if the squares cancel: one of them is a root.
fn conjugates(written: &[Term], names: &Names) -> Vec<Formula> {
    // `sqrt(x * x + 1) - x` = `1 / (sqrt(x * x + 1) + x)`: the difference of the squares is
    // computed symbolically, so nothing is left to cancel.
    let root = |term: &Term| match names.read(&term.absolute()) {
        Call(name, of) if name == "sqrt" && of.len() == 1 => Some(of[0].clone()),
        _ => None,
    };
    let mut all = Vec::new();
    for (at, term) in written.iter().enumerate() {
        let Some(under) = root(term) else { continue };
        let rest: Vec<Term> = written
            .iter()
            .enumerate()
            .filter(|(nth, _)| *nth != at)
            .map(|(_, t)| t.clone())
            .collect();
        if rest.is_empty() {
            continue;
        }
        let other = sum(&rest);
        let square = match &rest[..] {
            [one] if root(one).is_some() => root(one).unwrap_or(number(0.0)),
            _ => binary('*', other.clone(), other.clone()),
        };
        let mut squares = terms(&under, Some(names));
        let before = squares.len();
        // Both squares as terms; those that cancel make the form worth while.
        let minus = terms(&square, Some(names));
        let count = before + minus.len();
        squares.extend(negative(&minus));
        let squares = collected(squares);
        // Nothing cancelled: the quotient would be no better.
        if squares.len() >= count {
            continue;
        }
        // s * root + rest = (root² - rest²) / (s * root - rest), with the sign s.
        let mut apart = negative(written);
        apart[at] = term.clone();
        all.push(binary('/', sum(&squares), sum(&apart)));
        // All signs turned, where that takes a sign away.
        let turned = binary('/', sum(&negative(&squares)), sum(&negative(&apart)));
        all.push(turned);
    }
    all
}

/// `… + a * a - b * b` as `… + (a - b) * (a + b)`.
fn squares(formula: &Formula, names: &Names) -> Vec<Formula> {
    let mut all = Vec::new();
    // As written, and with the names of local variables replaced by their expressions.
    for read in [None, Some(names)] {
        let terms = collected(terms(formula, read));
        for (i, plus) in terms.iter().enumerate().filter(|(_, term)| term.by > 0.0) {
            for (j, minus) in terms.iter().enumerate().filter(|(_, term)| term.by < 0.0) {
                let (Some(a), Some(b)) = (plus.root(), minus.root()) else { continue };
                let difference = binary('-', a.clone(), b.clone());
                let product = binary('*', difference, binary('+', a, b));
                let rest = terms.iter().enumerate().filter(|(nth, _)| *nth != i && *nth != j);
                let rest: Vec<Term> = rest.map(|(_, term)| term.clone()).collect();
                all.push(match rest.is_empty() {
                    true => product,
                    false => match sum(&rest) {
                        Neg(inner) => binary('-', product, *inner),
                        rest => binary('+', product, rest),
                    },
                });
            }
        }
    }
    all
}

/// `a - t * (a - b)` as `a * (1 - t) + b * t`, which does not cancel where both have one sign.
fn interpolations(written: &[Term], names: &Names) -> Vec<Formula> {
    let [a, b] = written else { return Vec::new() };
    let mut all = Vec::new();
    for (end, product) in [(a, b), (b, a)] {
        // The end point stands alone, the other term is a product with a factor `a - b`.
        if end.by != 1.0 || product.by.abs() != 1.0 || product.factors.len() < 2 {
            continue;
        }
        let from = end.absolute();
        for at in 0..product.factors.len() {
            let Formula::Binary('-', p, q) = names.read(&product.factors[at]) else { continue };
            let (start, to) = if product.by < 0.0 { (*p, *q) } else { (*q, *p) };
            if start != from {
                continue;
            }
            let mut weight = product.factors.clone();
            weight.remove(at);
            let weight = Term { by: 1.0, factors: weight }.absolute();
            let rest = binary('-', number(1.0), weight.clone());
            all.push(binary('+', binary('*', from.clone(), rest), binary('*', to, weight)));
        }
    }
    all
}

/// `1 - dot(a, b)` of unit vectors as half the square of their difference.
fn chords(written: &[Term], names: &Names) -> Vec<Formula> {
    // |a - b|^2 = 2 - 2 dot(a, b): subtracts components, which differ, instead of cosines, which
    // do not.
    let [a, b] = written else { return Vec::new() };
    let mut all = Vec::new();
    for (dot, other) in [(a, b), (b, a)] {
        let vectors = match names.read(&dot.absolute()) {
            Call(name, of) if name == "dot" && of.len() == 2 => of,
            Call(name, of) if name == "max" || name == "clamp" => match names.read(&of[0]) {
                Call(name, of) if name == "dot" && of.len() == 2 => of,
                _ => continue,
            },
            _ => continue,
        };
        // A difference: the signs are opposite.
        if dot.by * other.by >= 0.0 || dot.by.abs() != 1.0 {
            continue;
        }
        let apart = binary('-', vectors[0].clone(), vectors[1].clone());
        let half = binary('*', number(0.5), call("dot", vec![apart.clone(), apart]));
        let rest = Term { by: other.by.abs(), ..other.clone() }.absolute();
        // `outer - dot(l, d)` = `chord - (1 - outer)`, where a host may upload `1 - outer`
        // exactly.
        let less = binary('-', number(1.0), rest);
        let is_one = other.factors.is_empty() && other.by.abs() == 1.0;
        all.push(match (is_one, dot.by > 0.0) {
            (true, false) => half,
            (true, true) => Neg(Box::new(half)),
            (false, false) => binary('-', half, less),
            (false, true) => binary('-', less, half),
        });
    }
    all
}

/// Differences of cosines and sines as products.
fn angles(written: &[Term], names: &Names) -> Vec<Formula> {
    let [a, b] = written else { return Vec::new() };
    // Only differences with equal factors have the product form.
    if a.by * b.by >= 0.0 || a.by.abs() != b.by.abs() {
        return Vec::new();
    }
    let (plus, minus) = if a.by > 0.0 { (a, b) } else { (b, a) };
    let of = |term: &Term| match names.read(&Term { by: 1.0, ..term.clone() }.absolute()) {
        Call(name, of) if of.len() == 1 && (name == "cos" || name == "sin") => {
            Some((name, of[0].clone()))
        }
        // The cosine of nothing.
        // `1 - cos(x)`: one is the cosine of 0.
        _ if term.factors.is_empty() => Some(("cos".to_string(), number(0.0))),
        _ => None,
    };
    let (Some((first, x)), Some((second, y))) = (of(plus), of(minus)) else { return Vec::new() };
    if first != second {
        return Vec::new();
    }
    let is_zero = |formula: &Formula| formula.value() == Some(0.0);
    let half = |of: Formula| binary('*', number(0.5), of);
    let twice = number(2.0 * plus.by);
    let sine = |of: Formula| call("sin", vec![of]);
    let product = |a: Formula, b: Formula| binary('*', binary('*', twice.clone(), a), b);
    // cos x - cos y = 2 sin((y + x) / 2) sin((y - x) / 2), sin x - sin y = 2 cos((x + y) / 2)
    // sin((x - y) / 2); 1 - cos y = 2 sin(y / 2)^2.
    vec![match (is_zero(&x), is_zero(&y)) {
        (true, _) => product(sine(half(y.clone())), sine(half(y))),
        (_, true) => Neg(Box::new(product(sine(half(x.clone())), sine(half(x))))),
        _ if first == "cos" => {
            let sum = half(binary('+', y.clone(), x.clone()));
            product(sine(sum), sine(half(binary('-', y, x))))
        }
        _ => {
            let sum = half(binary('+', x.clone(), y.clone()));
            product(call("cos", vec![sum]), sine(half(binary('-', x, y))))
        }
    }]
}

/// `a * b + c` in one rounding; `a * b - c * d` with the second product's error added.
fn fused(written: &[Term]) -> Vec<Formula> {
    // With fused operations `a b - c d` is within two units of the last place (Kahan): `fma(-c, d,
    // cd)` is the exact error of the second product.
    let [a, b] = written else { return Vec::new() };
    let halves = |term: &Term| match &term.factors[..] {
        [x, rest @ ..] if !rest.is_empty() || term.by.abs() != 1.0 => {
            let rest = Term { by: term.by, factors: rest.to_vec() };
            let rest = if rest.by < 0.0 { Neg(Box::new(rest.absolute())) } else { rest.absolute() };
            Some((x.clone(), rest))
        }
        _ => None,
    };
    let fma = |x: Formula, y: Formula, z: Formula| call("fma", vec![x, y, z]);
    match (halves(a), halves(b)) {
        (Some((x, y)), Some((z, w))) => {
            let product = binary('*', z.clone(), w.clone());
            let lost = fma(z, w, Neg(Box::new(product.clone())));
            vec![binary('+', fma(x, y, product), lost)]
        }
        (Some((x, y)), None) => vec![fma(x, y, sum(std::slice::from_ref(b)))],
        (None, Some((x, y))) => vec![fma(x, y, sum(std::slice::from_ref(a)))],
        (None, None) => Vec::new(),
    }
}

/// A polynomial of one name by Horner's rule.
fn horner(formula: &Formula, names: &Names) -> Option<Formula> {
    let all = collected(terms(formula, Some(names)));
    // All factors must be one name: a polynomial of one variable with constant coefficients.
    let x = all.iter().find_map(|term| term.factors.first())?.clone();
    let degree = |term: &Term| term.factors.len();
    let same = |term: &Term| term.factors.iter().all(|factor| *factor == x);
    let most = all.iter().map(degree).max()?;
    if most < 2 || all.len() < 2 || !all.iter().all(same) {
        return None;
    }
    let by = |n: usize| all.iter().find(|term| degree(term) == n).map_or(0.0, |term| term.by);
    let mut value = number(by(most));
    // From the highest power down: a0 + x (a1 + x (a2 ...)).
    for n in (0..most).rev() {
        let product = binary('*', x.clone(), value);
        value = match by(n) {
            0.0 => product,
            below if below < 0.0 => binary('-', product, number(-below)),
            more => binary('+', product, number(more)),
        };
    }
    Some(value)
}

struct NearZeroSeries {
    x: Formula,
    near: f64,
    close: Formula,
}

/// `exp(x) - 1` and `log(1 + x)` near zero.
fn series(
    formula: &Formula,
    written: &[Term],
    names: &Names,
) -> Vec<(&'static str, NearZeroSeries)> {
    // x (b0 + x (b1 + ...)): the series without a constant term, which has cancelled.
    let polynomial = |x: &Formula, by: &[f64]| {
        let mut value = number(by[by.len() - 1]);
        for &by in by[..by.len() - 1].iter().rev() {
            value = binary('+', number(by), binary('*', x.clone(), value));
        }
        binary('*', x.clone(), value)
    };
    let mut all = Vec::new();
    if let [a, b] = written {
        for (power, one) in [(a, b), (b, a)] {
            let exponential = names.read(&Term { by: 1.0, ..power.clone() }.absolute());
            let is_one = one.factors.is_empty() && one.by == -power.by && one.by.abs() == 1.0;
            if let (Call(name, of), true) = (exponential, is_one) {
                // The series to x^5 is off by x^6 / 720, below 2^-24 relative to x for |x| < 0.1.
                if name == "exp" && of.len() == 1 {
                    let x = of[0].clone();
                    let close = polynomial(&x, &[1.0, 0.5, 1.0 / 6.0, 1.0 / 24.0, 1.0 / 120.0]);
                    let close = if power.by < 0.0 { Neg(Box::new(close)) } else { close };
                    all.push(("series near zero", NearZeroSeries { x, near: 0.1, close }));
                }
            }
        }
    }
    // log(1 + x) to x^6: off by x^7 / 7, for |x| < 0.05.
    if let Call(name, of) = formula {
        if name == "log" && of.len() == 1 {
            let inside = terms(&names.read(&of[0]), None);
            let (one, rest): (Vec<Term>, Vec<Term>) =
                inside.into_iter().partition(|term| term.factors.is_empty() && term.by == 1.0);
            if one.len() == 1 && !rest.is_empty() {
                let x = sum(&rest);
                let by = [1.0, -0.5, 1.0 / 3.0, -0.25, 0.2, -1.0 / 6.0];
                let close = polynomial(&x, &by);
                all.push(("series near zero", NearZeroSeries { x, near: 0.05, close }));
            }
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    fn codes(text: &str) -> Vec<String> {
        let (before, last) = text.rsplit_once("return ").expect("a statement returns");
        let names = Names::before(text, before.len());
        let formula = Formula::read(last).expect("it is an expression");
        forms(&formula, &names, Language::Glsl).into_iter().map(|form| form.code).collect()
    }

    /// Forms by hand, from the books.
    #[test]
    fn known_forms_are_among_those_tried() {
        let cases = [
            ("return x - sqrt(x * x - 1.0)", "1.0 / (x + sqrt(x * x - 1.0))"),
            ("return sqrt(x + 1.0) - sqrt(x)", "1.0 / (sqrt(x + 1.0) + sqrt(x))"),
            (
                "float d = b * b - 4.0 * a * c; return -b + sqrt(d)",
                "-(4.0 * a * c) / (b + sqrt(d))",
            ),
            ("return a * a - b * b", "(a - b) * (a + b)"),
            ("return 1.0 - x * x", "(1.0 - x) * (1.0 + x)"),
            (
                "float a2 = a * a; return n * n * (a2 - 1.0) + 1.0",
                "(1.0 - n) * (1.0 + n) + n * n * a * a",
            ),
            ("return 1.0 - dot(a, b)", "0.5 * dot(a - b, a - b)"),
            ("return dot(l, d) - outer", "1.0 - outer - 0.5 * dot(l - d, l - d)"),
            ("return f - d * (f - n)", "f * (1.0 - d) + n * d"),
            ("return a + (b - a) * t", "a * (1.0 - t) + b * t"),
            ("return 1.0 - cos(x)", "2.0 * sin(0.5 * x) * sin(0.5 * x)"),
            ("return a * b - c * d", "fma(a, b, c * -d) + fma(c, -d, -(c * -d))"),
            ("return x * x * x - 3.0 * x * x + 2.0", "x * (x * (x * 1.0 - 3.0)) + 2.0"),
        ];
        for (text, form) in cases {
            let found = codes(text);
            assert!(found.iter().any(|code| code == form), "{text}: {form} is not in {found:#?}");
        }
    }
}
