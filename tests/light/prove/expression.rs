//! Random expressions of `a`, `b` and `c`.

use super::soundness::Random;

/// An expression.
#[derive(Clone, Debug)]
pub enum Tree {
    /// An input, by number.
    Input(usize),
    Constant(f32),
    /// A function or operator, by its text with `x`, `y` and `z` for the operands.
    Call(&'static str, Vec<Tree>),
}

/// The operations, some of them several times.
const CALLS: [&str; 25] = [
    "(x + y)",
    "(x + y)",
    "(x + y)",
    "(x + y)",
    "(x - y)",
    "(x - y)",
    "(x - y)",
    "(x * y)",
    "(x * y)",
    "(x * y)",
    "(x * y)",
    "(x / y)",
    "sqrt(x)",
    "min(x, y)",
    "max(x, y)",
    "abs(x)",
    "sin(x)",
    "exp(x)",
    "clamp(x, -1.0, 1.0)",
    "mix(x, y, z)",
    "(x < y ? z : x)",
    "dot(vec2(x, y), vec2(y, z))",
    "length(vec2(x, y))",
    "smoothstep(-1.0, 2.0, x)",
    "floor(x)",
];

/// A random expression.
pub fn grow(random: &mut Random, depth: u32) -> Tree {
    if depth == 0 {
        return match random.below(7) {
            n @ 0..=2 => Tree::Input(n as usize),
            n => Tree::Constant([0.5, 2.0, -1.5, 3.25][n as usize - 3]),
        };
    }
    let operands = (0..3).map(|_| grow(random, depth - 1)).collect();
    Tree::Call(CALLS[random.below(25) as usize], operands)
}

impl Tree {
    pub fn text(&self) -> String {
        match self {
            Tree::Input(n) => ["a", "b", "c"][*n].to_string(),
            Tree::Constant(x) => format!("{x:?}"),
            Tree::Call(form, operands) => {
                let mut text = String::new();
                let mut before = ' ';
                for (at, c) in form.char_indices() {
                    let after = form[at + 1..].chars().next().unwrap_or(' ');
                    let alone = !before.is_alphanumeric() && !after.is_alphanumeric();
                    match c {
                        'x' | 'y' | 'z' if alone => {
                            text.push_str(&operands[c as usize - 'x' as usize].text());
                        }
                        _ => text.push(c),
                    }
                    before = c;
                }
                text
            }
        }
    }
}
