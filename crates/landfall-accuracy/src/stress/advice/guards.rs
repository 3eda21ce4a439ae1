//! Forms of an expression that are defined where it is not, and equal to it where it is.
//!
//! Which of them are is measured by `advice`.

use super::catalogue::Form;
use super::formula::Formula::{self, Binary, Call};
use super::formula::{binary, call, number};
use landfall_interp::UndefinedKind;
use landfall_layout::source::Language;

/// The longest operand that a form repeats, in characters.
/// `normalize` of a longer one would be computed twice, and be hard to read.
const LONGEST: usize = 60;

/// An expression without a defined value.
pub(super) struct Broken<'t> {
    pub text: &'t str,
    pub kind: UndefinedKind,
    pub operands: Vec<f64>,
    /// What a divisor is kept at or above.
    pub least: f64,
    /// Whether rounding alone takes an operand out of the range.
    pub is_rounding: bool,
    pub language: Language,
}

/// Returns the forms of an expression to try, the preferred first.
pub(super) fn guards(broken: &Broken<'_>) -> Vec<Form> {
    // Guards for calls by function, for divisions and shifts by operator, for accesses by index.
    use UndefinedKind as K;
    let formula = Formula::read(broken.text);
    let codes = match (broken.kind, formula) {
        (K::IndexOutOfBounds, _) => indices(broken),
        (K::ShiftTooFar, _) => shifts(broken),
        (_, Some(Call(name, of))) => calls(broken, &name, &of),
        (K::DivisionByZero, Some(Binary('/', a, b))) => {
            vec![binary('/', *a, call("max", vec![*b, number(broken.least)])).to_string()]
        }
        (K::IntegerDivisionByZero, Some(Binary(operator @ ('/' | '%'), a, b))) => {
            // Signed or unsigned: the one that compiles is taken.
            ["1", "1u"].map(|one| format!("{a} {operator} max({b}, {one})")).to_vec()
        }
        (K::RemainderOfNegative, Some(Binary('%', i, n))) => remainders(&i, &n),
        _ => Vec::new(),
    };
    let form = |code: String| Form { name: "guard", code, is_fused: false };
    codes.into_iter().map(form).collect()
}

/// Returns the angle of two unit vectors without the cosine, which is 1 up to rounding for all
/// small angles (Kahan, How Futile are Mindless Assessments of Roundoff, 2006, section 12).
pub(super) fn angle(broken: &Broken<'_>) -> Option<Form> {
    let Call(name, of) = Formula::read(broken.text)? else { return None };
    let [Call(dot, vectors)] = &of[..] else { return None };
    let [a, b] = &vectors[..] else { return None };
    if broken.kind != UndefinedKind::ArcOutOfRange || name != "acos" || dot != "dot" {
        return None;
    }
    let length = |sign: char| call("length", vec![binary(sign, a.clone(), b.clone())]);
    let atan = match broken.language {
        Language::Wgsl => "atan2",
        Language::Glsl | Language::SpirV => "atan",
    };
    let code = binary('*', number(2.0), call(atan, vec![length('-'), length('+')])).to_string();
    Some(Form { name: "angle of unit vectors", code, is_fused: false })
}

fn calls(broken: &Broken<'_>, name: &str, of: &[Formula]) -> Vec<String> {
    use UndefinedKind as K;
    let replaced = |at: usize, with: Formula| {
        let mut all = of.to_vec();
        all[at] = with;
        call(name, all).to_string()
    };
    let at_least =
        |at: usize, least: f64| replaced(at, call("max", vec![of[at].clone(), number(least)]));
    let clamped = |low: f64, high: f64| {
        replaced(0, call("clamp", vec![of[0].clone(), number(low), number(high)]))
    };
    let is_zero = broken.operands.first() == Some(&0.0);
    match (broken.kind, name, of.len()) {
        // A discriminant that is negative by more than rounding is a case of its own.
        (K::RootOfNegative, "sqrt", 1) if broken.is_rounding => vec![at_least(0, 0.0)],
        // 1e-36 is a normal number of `f32`, and its inverse root can be squared.
        (K::RootOfNegative, "inversesqrt" | "inverseSqrt", 1) if is_zero || broken.is_rounding => {
            vec![at_least(0, 1.0e-36)]
        }
        (K::LogOfNonPositive, "log" | "log2", 1) if is_zero || broken.is_rounding => {
            vec![at_least(0, 1.0e-36)]
        }
        (K::ArcOutOfRange, "acos" | "asin", 1) => vec![clamped(-1.0, 1.0)],
        (K::ArcOutOfRange, "acosh", 1) => vec![at_least(0, 1.0)],
        (K::PowOfNegative | K::PowOfZero, "pow", 2) => powers(broken, of, at_least(0, 0.0)),
        (K::NormalizeOfZero, "normalize", 1) if of[0].to_string().len() <= LONGEST => {
            let root = match broken.language {
                Language::Wgsl => "inverseSqrt",
                Language::Glsl | Language::SpirV => "inversesqrt",
            };
            let square = call("dot", vec![of[0].clone(), of[0].clone()]);
            let square = call("max", vec![square, number(1.0e-36)]);
            vec![binary('*', of[0].clone(), call(root, vec![square])).to_string()]
        }
        (K::SmoothStepEdges, "smoothstep", 3) => {
            // A second edge above the first by at least 1e-6, which keeps the divisor away from
            // zero.
            let above = binary('+', of[0].clone(), number(1.0e-6));
            vec![replaced(1, call("max", vec![of[1].clone(), above]))]
        }
        (K::ClampBounds, "clamp", 3) => {
            let ends = vec![of[1].clone(), of[2].clone()];
            let ends = [call("min", ends.clone()), call("max", ends)];
            let [low, high] = ends;
            vec![call(name, vec![of[0].clone(), low, high]).to_string()]
        }
        // ln(FLT_MAX) = 88.72.
        (K::BornInfinite, "exp", 1) => {
            vec![replaced(0, call("min", vec![of[0].clone(), number(88.7)]))]
        }
        // FLT_MAX is just below 2^128.
        (K::BornInfinite, "exp2", 1) => {
            vec![replaced(0, call("min", vec![of[0].clone(), number(127.99)]))]
        }
        _ => Vec::new(),
    }
}

/// Products for small whole exponents, else a base that is not negative.
fn powers(broken: &Broken<'_>, of: &[Formula], clamped: String) -> Vec<String> {
    // A product needs no condition. Then the clamp, the choice, and a base that is never zero,
    // which keeps the result for a base above 1e-30.
    let [base, exponent] = of else { return Vec::new() };
    let mut all = Vec::new();
    if let Some(n) = exponent.value().filter(|n| (2.0..=4.0).contains(n) && n.fract() == 0.0) {
        let factors = std::iter::repeat_n(base.clone(), n as usize);
        all.extend(factors.reduce(|a, b| binary('*', a, b)).map(|product| product.to_string()));
    }
    if broken.kind == UndefinedKind::PowOfNegative {
        all.push(clamped);
    }
    // WGSL has no `?:`; `select` evaluates both.
    if broken.language == Language::Glsl {
        all.push(format!("({base} > 0.0 ? pow({base}, {exponent}) : 0.0)"));
    }
    let above = call("max", vec![base.clone(), number(1.0e-30)]);
    all.push(call("pow", vec![above, exponent.clone()]).to_string());
    all
}

/// Remainders that are not negative: GLSL leaves `i % n` of a negative `i` undefined.
fn remainders(i: &Formula, n: &Formula) -> Vec<String> {
    // `i & (n - 1)` for a power of two; else by floor, in floats, which hold integers to 2^24.
    let bits = n.value().filter(|n| *n >= 1.0 && (*n as u64).is_power_of_two());
    let mask = bits.map(|n| format!("{} & {}", operand(i), n as u64 - 1));
    let floor = format!("{} - {} * int(floor(float({i}) / float({n})))", operand(i), operand(n));
    mask.into_iter().chain([floor]).collect()
}

/// Returns an operand of an operator that binds at least as tightly as products.
fn operand(formula: &Formula) -> String {
    match formula {
        Binary(..) => format!("({formula})"),
        _ => formula.to_string(),
    }
}

/// Returns an access with its index in the range of the array.
fn indices(broken: &Broken<'_>) -> Vec<String> {
    let [index, len] = broken.operands[..] else { return Vec::new() };
    let text = broken.text.trim_end();
    let Some(inside) = text.strip_suffix(']') else { return Vec::new() };
    // The bracket that belongs to the last `]`, counted backwards.
    let mut depth = 0;
    let open = inside.char_indices().rev().find(|(_, c)| {
        depth += i32::from(*c == ']') - i32::from(*c == '[');
        depth < 0
    });
    let Some((open, _)) = open else { return Vec::new() };
    let (array, inside) = (&inside[..open], &inside[open + 1..]);
    let last = len - 1.0;
    let mut all = Vec::new();
    // A negative remainder: the usual repair gives the element that was meant.
    if let (true, Some(Binary('%', i, n))) = (index < 0.0, Formula::read(inside)) {
        all.push(format!("(({i} % {n}) + {n}) % {n}"));
    }
    if index > last {
        all.push(format!("min({inside}, {last})"));
        all.push(format!("min({inside}, {last}u)"));
    }
    all.push(format!("clamp({inside}, 0, {last})"));
    all.into_iter().map(|index| format!("{array}[{index}]")).collect()
}

/// Returns a shift by the count modulo the width.
fn shifts(broken: &Broken<'_>) -> Vec<String> {
    let both = ["<<", ">>"].iter().find_map(|sign| Some((*sign, broken.text.split_once(sign)?)));
    let Some((sign, (value, count))) = both else { return Vec::new() };
    let [value, count] = [value, count].map(str::trim);
    let is_plain = |text: &str| Formula::read(text).is_some();
    if !is_plain(value) || !is_plain(count) {
        return Vec::new();
    }
    let of = Formula::read(count).map_or(String::new(), |count| operand(&count));
    ["31", "31u"].map(|most| format!("{value} {sign} ({of} & {most})")).to_vec()
}
