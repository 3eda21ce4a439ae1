//! A case: one builtin or operator, its inputs, and what may come out. Families of cases make
//! one shader, each case a branch of its switch. Fed by the lists of cases, feeds the runs.

use super::draw::{Draw, count};
use super::interval::{Interval, ulp};

/// What one word of the result may be.
#[derive(Clone, Copy, Debug)]
pub enum Allowed {
    /// That word.
    Word(u32),
    /// One of these.
    Either(u32, u32),
    /// The true value correctly rounded.
    Correct(f64),
    /// A number of an interval, and what is true.
    Within(f64, Interval),
    /// The specifications leave it open.
    Open,
}

/// How far off a word is.
#[derive(Clone, Copy, Debug, Default)]
pub struct Off {
    /// In ULP of the true value, where the true value is a float's.
    pub ulp: f64,
    /// Of what is permitted: 1 is all of it.
    pub share: f64,
}

impl Allowed {
    /// How far off it is; `None` when it is not allowed. Zeros are equal unless `strict`.
    pub fn judge(self, got: u32, strict: bool) -> Option<Off> {
        let x = f32::from_bits(got);
        match self {
            Allowed::Word(word) => (got == word).then(Off::default),
            Allowed::Either(a, b) => (got == a || got == b).then(Off::default),
            Allowed::Correct(truth) => {
                let right = truth as f32;
                let same = got == right.to_bits()
                    || x.is_nan() && right.is_nan()
                    || !strict && x == 0.0 && right == 0.0;
                same.then(|| Off { ulp: in_ulp(x, truth), share: 0.0 })
            }
            Allowed::Within(truth, interval) if interval.is_any() => {
                Some(Off { ulp: in_ulp(x, truth), share: 0.0 })
            }
            Allowed::Within(truth, interval) => {
                let x = f64::from(x);
                let room = if x < truth { truth - interval.low } else { interval.high - truth };
                let share = if room > 0.0 { (x - truth).abs() / room } else { 0.0 };
                interval.has(x).then(|| Off { ulp: in_ulp(x as f32, truth), share })
            }
            Allowed::Open => Some(Off::default()),
        }
    }
}

fn in_ulp(x: f32, truth: f64) -> f64 {
    if !x.is_finite() || truth.is_nan() || truth.abs() > f64::from(f32::MAX) {
        return 0.0;
    }
    (f64::from(x) - truth).abs() / ulp(truth)
}

/// What may come out for the words of the operands.
pub type Judge = Box<dyn Fn(&[u32]) -> Vec<Allowed>>;

/// One builtin or operator.
pub struct Case {
    pub name: &'static str,
    /// What the specifications permit, in words.
    pub permitted: &'static str,
    /// Types of the operands `a`, `b`, `c`, `d`: `f f3 m2 u i`.
    pub operands: &'static str,
    /// Statements before the results.
    pub before: &'static str,
    /// Types and expressions of the results, as `f sin(a)`.
    pub results: &'static [&'static str],
    pub inputs: Vec<Vec<u32>>,
    pub judge: Judge,
}

impl Case {
    /// A case whose inputs come one by one.
    pub fn new(
        name: &'static str,
        permitted: &'static str,
        operands: &'static str,
        results: &'static [&'static str],
        draw: impl Fn(&mut Draw) -> Vec<u32>,
        judge: impl Fn(&[u32]) -> Vec<Allowed> + 'static,
    ) -> Case {
        let mut random = Draw::new(name);
        let inputs = (0..count()).map(|_| draw(&mut random)).collect();
        Case { name, permitted, operands, before: "", results, inputs, judge: Box::new(judge) }
    }

    pub fn before(self, before: &'static str) -> Case {
        Case { before, ..self }
    }

    fn words(&self) -> usize {
        self.operands.split(' ').map(words_of).sum()
    }

    pub fn result_words(&self) -> usize {
        self.results.iter().map(|r| words_of(r.split(' ').next().unwrap_or(""))).sum()
    }
}

/// Which language a family's shader is in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dialect {
    Glsl,
    Wgsl,
}

/// Cases that share a shader.
pub struct Family {
    pub name: &'static str,
    pub dialect: Dialect,
    pub cases: Vec<Case>,
}

fn words_of(ty: &str) -> usize {
    let n = ty[1..].parse().unwrap_or(1);
    if ty.starts_with('m') { n * n } else { n }
}

impl Family {
    /// Words of the operands of each invocation.
    pub fn stride(&self) -> usize {
        self.cases.iter().map(Case::words).max().unwrap_or(0)
    }

    /// Words of the results of each invocation.
    pub fn result_stride(&self) -> usize {
        self.cases.iter().map(Case::result_words).max().unwrap_or(0)
    }

    /// The operands of all cases in one buffer.
    pub fn given(&self) -> Vec<u32> {
        let mut given = Vec::new();
        for input in self.cases.iter().flat_map(|case| &case.inputs) {
            given.extend_from_slice(input);
            given.resize(given.len() + self.stride() - input.len(), 0);
        }
        given
    }

    pub fn text(&self) -> String {
        let glsl = self.dialect == Dialect::Glsl;
        let mut text = String::from(if glsl {
            "#version 450
layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer Given { uint given[]; };
layout(std430, binding = 1) buffer Got { uint got[]; };
void main() {
  uint id = gl_GlobalInvocationID.x;\n"
        } else {
            "@group(0) @binding(0) var<storage, read> given: array<u32>;
@group(0) @binding(1) var<storage, read_write> got: array<u32>;
@compute @workgroup_size(64) fn main(@builtin(global_invocation_id) at: vec3u) {
  let id = at.x;\n"
        });
        let (let_, u) = if glsl { ("uint ", "") } else { ("let ", ": u32") };
        text += &format!("  {let_}first{u} = id * {}u;\n", self.stride());
        text += &format!("  {let_}into{u} = id * {}u;\n", self.result_stride());
        text += &format!("  switch (id / {}u) {{\n", count());
        for (i, case) in self.cases.iter().enumerate() {
            text += &format!("  case {i}u: {{\n");
            let mut at = 0;
            for (name, ty) in ["a", "b", "c", "d"].iter().zip(case.operands.split(' ')) {
                text += &declared(self.dialect, ty, name, &operand(self.dialect, ty, at));
                at += words_of(ty);
            }
            text += case.before;
            let mut at = 0;
            for (k, result) in case.results.iter().enumerate() {
                let (ty, expression) = result.split_once(' ').expect("a type and an expression");
                let name = format!("r{k}");
                text += &declared(self.dialect, ty, &name, expression);
                for part in parts(ty, &name) {
                    let bits = match (&ty[..1], self.dialect) {
                        ("u", _) => part,
                        ("i", Dialect::Glsl) => format!("uint({part})"),
                        (_, Dialect::Glsl) => format!("floatBitsToUint({part})"),
                        (_, Dialect::Wgsl) => format!("bitcast<u32>({part})"),
                    };
                    text += &format!("    got[into + {at}u] = {bits};\n");
                    at += 1;
                }
            }
            text += if glsl { "    break; }\n" } else { "  }\n" };
        }
        text + if glsl { "  }\n}\n" } else { "  default: {}\n  }\n}\n" }
    }
}

/// The words of a value one by one.
fn parts(ty: &str, name: &str) -> Vec<String> {
    let n = ty[1..].parse().unwrap_or(1);
    match (ty.starts_with('m'), n) {
        (true, _) => (0..n * n).map(|i| format!("{name}[{}][{}]", i / n, i % n)).collect(),
        (false, 1) => vec![name.to_string()],
        (false, _) => (0..n).map(|i| format!("{name}[{i}]")).collect(),
    }
}

fn type_name(dialect: Dialect, ty: &str) -> String {
    let n = &ty[1..];
    match (dialect, &ty[..1], n) {
        (Dialect::Glsl, "f", "") => "float".into(),
        (Dialect::Glsl, "i", "") => "int".into(),
        (Dialect::Glsl, "u", "") => "uint".into(),
        (Dialect::Glsl, "m", _) => format!("mat{n}"),
        (Dialect::Glsl, "f", _) => format!("vec{n}"),
        (Dialect::Glsl, kind, _) => format!("{kind}vec{n}"),
        (Dialect::Wgsl, kind, "") => format!("{kind}32"),
        (Dialect::Wgsl, "m", _) => format!("mat{n}x{n}f"),
        (Dialect::Wgsl, kind, _) => format!("vec{n}{kind}"),
    }
}

fn declared(dialect: Dialect, ty: &str, name: &str, value: &str) -> String {
    let ty = type_name(dialect, ty);
    match dialect {
        Dialect::Glsl => format!("    {ty} {name} = {value};\n"),
        Dialect::Wgsl => format!("    let {name}: {ty} = {value};\n"),
    }
}

fn operand(dialect: Dialect, ty: &str, at: usize) -> String {
    let read = |i: usize| {
        let word = format!("given[first + {}u]", at + i);
        match (dialect, &ty[..1]) {
            (_, "u") => word,
            (Dialect::Glsl, "i") => format!("int({word})"),
            (Dialect::Glsl, _) => format!("uintBitsToFloat({word})"),
            (Dialect::Wgsl, "i") => format!("bitcast<i32>({word})"),
            (Dialect::Wgsl, _) => format!("bitcast<f32>({word})"),
        }
    };
    let words: Vec<String> = (0..words_of(ty)).map(read).collect();
    match words.len() {
        1 => words[0].clone(),
        _ => format!("{}({})", type_name(dialect, ty), words.join(", ")),
    }
}
