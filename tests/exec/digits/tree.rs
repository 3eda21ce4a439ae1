//! Random expressions of WGSL's float operators and functions, and what they are worth.

use super::number::{Digits, Number, smooth};

/// An expression of three floats.
#[derive(Clone, Debug)]
pub enum Tree {
    Input(usize),
    Number(f32),
    Call(&'static str, Vec<Tree>),
}

/// Each with how many floats it takes. Vectors are made of three and seen by one component.
const CALLS: [(&str, usize); 52] = [
    ("+", 2),
    ("-", 2),
    ("*", 2),
    ("/", 2),
    ("%", 2),
    ("neg", 1),
    ("abs", 1),
    ("sign", 1),
    ("floor", 1),
    ("ceil", 1),
    ("trunc", 1),
    ("round", 1),
    ("fract", 1),
    ("saturate", 1),
    ("min", 2),
    ("max", 2),
    ("step", 2),
    ("select", 4),
    ("clamp", 3),
    ("mix", 3),
    ("fma", 3),
    ("smoothstep", 3),
    ("sqrt", 1),
    ("inverseSqrt", 1),
    ("exp", 1),
    ("exp2", 1),
    ("log", 1),
    ("log2", 1),
    ("pow", 2),
    ("sin", 1),
    ("cos", 1),
    ("tan", 1),
    ("asin", 1),
    ("acos", 1),
    ("atan", 1),
    ("atan2", 2),
    ("sinh", 1),
    ("cosh", 1),
    ("tanh", 1),
    ("asinh", 1),
    ("acosh", 1),
    ("atanh", 1),
    ("radians", 1),
    ("degrees", 1),
    ("frexp", 1),
    ("ldexp", 1),
    ("dot", 6),
    ("length", 3),
    ("distance", 6),
    ("normalize", 3),
    ("reflect", 6),
    ("cross", 6),
];

/// The names of everything that is drawn.
pub fn names() -> impl Iterator<Item = &'static str> {
    CALLS.iter().map(|(name, _)| *name)
}

pub fn grow(random: &mut fastrand::Rng, depth: u32) -> Tree {
    if depth == 0 || random.u32(0..8) == 0 {
        return match random.u32(0..4) {
            0 => Tree::Number(f32::from(random.i8(..)) / 16.0),
            _ => Tree::Input(random.usize(0..3)),
        };
    }
    let (name, count) = CALLS[random.usize(0..CALLS.len())];
    let mut operands: Vec<Tree> = (0..count).map(|_| grow(random, depth - 1)).collect();
    // A constant expression would be computed by naga.
    if operands.iter().all(|operand| matches!(operand, Tree::Number(_))) {
        operands[0] = Tree::Input(random.usize(0..3));
    }
    let call = |name, operands: &[Tree]| Tree::Call(name, operands.to_vec());
    let first = operands[0].clone();
    let absolute = call("abs", &operands[..1]);
    let number = Tree::Number;
    // Mostly from where the function is defined.
    if random.u32(0..8) > 0 {
        operands[0] = match name {
            "sqrt" | "inverseSqrt" | "log" | "log2" | "pow" => absolute,
            "acosh" => call("+", &[absolute, number(1.0)]),
            "asin" | "acos" | "atanh" => {
                let more = call("+", &[absolute, number(1.0)]);
                call("/", &[first, more])
            }
            "exp" | "exp2" | "sinh" | "cosh" => {
                call("clamp", &[first, number(-20.0), number(20.0)])
            }
            _ => first,
        };
    }
    Tree::Call(name, operands)
}

impl Tree {
    /// As WGSL.
    pub fn text(&self) -> String {
        let (name, operands) = match self {
            Tree::Input(i) => return ["x", "y", "z"][*i].into(),
            Tree::Number(n) => return format!("f32({n:?})"),
            Tree::Call(name, operands) => (*name, operands),
        };
        let all: Vec<String> = operands.iter().map(Tree::text).collect();
        let vector = |from: usize| format!("vec3<f32>({})", all[from..from + 3].join(", "));
        match name {
            "+" | "-" | "*" | "/" | "%" => format!("({} {name} {})", all[0], all[1]),
            "neg" => format!("(-{})", all[0]),
            "select" => format!("select({}, {}, {} < {})", all[0], all[1], all[2], all[3]),
            "frexp" => format!("frexp({}).fract", all[0]),
            "ldexp" => format!("ldexp({}, 3)", all[0]),
            "dot" | "distance" => format!("{name}({}, {})", vector(0), vector(3)),
            "length" => format!("length({})", vector(0)),
            "normalize" => format!("normalize({}).y", vector(0)),
            "reflect" | "cross" => format!("{name}({}, {}).y", vector(0), vector(3)),
            _ => format!("{name}({})", all.join(", ")),
        }
    }

    /// Names of the functions in it.
    pub fn calls(&self, to: &mut Vec<&'static str>) {
        if let Tree::Call(name, operands) = self {
            to.push(name);
            operands.iter().for_each(|operand| operand.calls(to));
        }
    }

    /// What it is worth, if that can be bounded.
    pub fn value(&self, d: &mut Digits, inputs: [f32; 3]) -> Option<Number> {
        let (name, operands) = match self {
            Tree::Input(i) => return Some(Number::exact(f64::from(inputs[*i]))),
            Tree::Number(n) => return Some(Number::exact(f64::from(*n))),
            Tree::Call(name, operands) => (*name, operands),
        };
        let mut all = Vec::with_capacity(operands.len());
        for operand in operands {
            all.push(operand.value(d, inputs)?);
        }
        call(name, &all, d)
    }
}

fn dot(d: &Digits, a: &[Number], b: &[Number]) -> Option<Number> {
    let mut sum = d.mul(&a[0], &b[0])?;
    for (a, b) in a.iter().zip(b).skip(1) {
        sum = d.add(&sum, &d.mul(a, b)?)?;
    }
    Some(sum)
}

fn length(d: &mut Digits, a: &[Number]) -> Option<Number> {
    let squares = dot(d, a, a)?;
    d.smooth(&squares, &smooth("sqrt")?)
}

/// By WGSL §17.5: what it defines by a formula is that formula.
fn call(name: &str, a: &[Number], d: &mut Digits) -> Option<Number> {
    let (zero, one) = (Number::exact(0.0), Number::exact(1.0));
    let clamp = |d: &Digits, x: &Number, low: &Number, high: &Number| {
        // One above the other has no defined result.
        let in_order = low.less(high).is_some_and(|less| less);
        in_order.then(|| d.min(&d.max(x, low), high))
    };
    if let Some(f) = smooth(name) {
        return d.smooth(&a[0], &f);
    }
    match name {
        "+" => d.add(&a[0], &a[1]),
        "-" => d.sub(&a[0], &a[1]),
        "*" => d.mul(&a[0], &a[1]),
        "/" => d.div(&a[0], &a[1]),
        "%" => d.rem(&a[0], &a[1]),
        "neg" => Some(d.neg(&a[0])),
        "abs" => Some(d.abs(&a[0])),
        "sign" => {
            let sign = match (a[0].less(&zero)?, zero.less(&a[0])?) {
                (true, _) => -1.0,
                (_, true) => 1.0,
                (false, false) => 0.0,
            };
            Some(Number::exact(sign))
        }
        "floor" => d.floor(&a[0]),
        "ceil" => d.ceil(&a[0]),
        "trunc" => d.trunc(&a[0]),
        "round" => d.round(&a[0]),
        "fract" => {
            let floor = d.floor(&a[0])?;
            d.sub(&a[0], &floor)
        }
        "saturate" => clamp(d, &a[0], &zero, &one),
        "min" => Some(d.min(&a[0], &a[1])),
        "max" => Some(d.max(&a[0], &a[1])),
        "step" => Some(Number::exact(f64::from(u8::from(!a[1].less(&a[0])?)))),
        "select" => Some(if a[2].less(&a[3])? { a[1].clone() } else { a[0].clone() }),
        "clamp" => clamp(d, &a[0], &a[1], &a[2]),
        "mix" => {
            let left = d.mul(&a[0], &d.sub(&one, &a[2])?)?;
            d.add(&left, &d.mul(&a[1], &a[2])?)
        }
        "fma" => d.add(&d.product(&a[0], &a[1], 0.0)?, &a[2]),
        "smoothstep" => {
            if !a[0].less(&a[1])? {
                return None;
            }
            let t = d.div(&d.sub(&a[2], &a[0])?, &d.sub(&a[1], &a[0])?)?;
            let t = clamp(d, &t, &zero, &one)?;
            let twice = d.mul(&Number::exact(2.0), &t)?;
            d.mul(&d.mul(&t, &t)?, &d.sub(&Number::exact(3.0), &twice)?)
        }
        "pow" => d.pow(&a[0], &a[1]),
        "atan2" => d.atan2(&a[0], &a[1]),
        "radians" => {
            let by = d.pi_over(180.0);
            d.scaled(&a[0], by)
        }
        "degrees" => {
            let by = d.pi_over(180.0);
            let by = d.div(&one, &Number { value: by, off: 0.0 })?.value;
            d.scaled(&a[0], by)
        }
        "frexp" => d.fraction(&a[0]),
        "ldexp" => d.product(&a[0], &Number::exact(8.0), 0.0),
        "dot" => dot(d, &a[..3], &a[3..]),
        "length" => length(d, a),
        "distance" => {
            let mut between = Vec::new();
            for i in 0..3 {
                between.push(d.sub(&a[i], &a[3 + i])?);
            }
            length(d, &between)
        }
        "normalize" => {
            let length = length(d, a)?;
            d.div(&a[1], &length)
        }
        "reflect" => {
            let along = d.mul(&Number::exact(2.0), &dot(d, &a[3..], &a[..3])?)?;
            d.sub(&a[1], &d.mul(&along, &a[4])?)
        }
        "cross" => d.sub(&d.mul(&a[2], &a[3])?, &d.mul(&a[0], &a[5])?),
        _ => unreachable!("`{name}` is not drawn"),
    }
}
