//! Random programs on the interpreter, alone and in batches, against a tree walker in Rust.

use std::fmt::Write as _;

use super::support::{program, words};

/// An expression over two floats and an integer.
enum RandomTree {
    X,
    Y,
    Number(f32),
    Binary(char, Box<RandomTree>, Box<RandomTree>),
    Call(&'static str, Vec<RandomTree>),
    /// One of two values, by a bit of the integer.
    Pick(u32, Box<RandomTree>, Box<RandomTree>),
}

fn grow(rng: &mut fastrand::Rng, depth: u32) -> RandomTree {
    let mut next = || Box::new(grow_from(rng, depth));
    let (a, b) = (next(), next());
    match rng.u32(0..10) {
        0..=4 => RandomTree::Binary(rng.choice(['+', '-', '*', '/']).unwrap_or('+'), a, b),
        5 => RandomTree::Call("min", vec![*a, *b]),
        6 => RandomTree::Call("max", vec![*a, *b]),
        7 => RandomTree::Call("floor", vec![*a]),
        8 => RandomTree::Call("abs", vec![*a]),
        _ => RandomTree::Pick(rng.u32(0..6), a, b),
    }
}

fn grow_from(rng: &mut fastrand::Rng, depth: u32) -> RandomTree {
    if depth > 0 && rng.u32(0..4) > 0 {
        return grow(rng, depth - 1);
    }
    match rng.u32(0..3) {
        0 => RandomTree::X,
        1 => RandomTree::Y,
        _ => RandomTree::Number(f32::from(rng.i8(..)) / 8.0),
    }
}

/// Statements that leave the value in the last variable; its number.
fn write(tree: &RandomTree, text: &mut String, next: &mut u32) -> u32 {
    let value = match tree {
        RandomTree::X => "x".to_string(),
        RandomTree::Y => "y".to_string(),
        RandomTree::Number(n) => format!("f32({n:?})"),
        RandomTree::Binary(op, a, b) => {
            let (a, b) = (write(a, text, next), write(b, text, next));
            format!("t{a} {op} t{b}")
        }
        RandomTree::Call(name, arguments) => {
            let all: Vec<String> =
                arguments.iter().map(|a| format!("t{}", write(a, text, next))).collect();
            format!("{name}({})", all.join(", "))
        }
        RandomTree::Pick(bit, a, b) => {
            let to = *next;
            *next += 1;
            let _ = writeln!(text, "var t{to}: f32; if (k >> {bit}u & 1u) == 1u {{");
            let a = write(a, text, next);
            let _ = writeln!(text, "t{to} = t{a}; }} else {{");
            let b = write(b, text, next);
            let _ = writeln!(text, "t{to} = t{b}; }}");
            return to;
        }
    };
    let to = *next;
    *next += 1;
    let _ = writeln!(text, "let t{to} = {value};");
    to
}

fn value(tree: &RandomTree, x: f32, y: f32, k: u32) -> f32 {
    match tree {
        RandomTree::X => x,
        RandomTree::Y => y,
        RandomTree::Number(n) => *n,
        RandomTree::Binary(op, a, b) => {
            let (a, b) = (value(a, x, y, k), value(b, x, y, k));
            match op {
                '+' => a + b,
                '-' => a - b,
                '*' => a * b,
                _ => a / b,
            }
        }
        RandomTree::Call(name, arguments) => {
            let all: Vec<f32> = arguments.iter().map(|a| value(a, x, y, k)).collect();
            match *name {
                "min" => {
                    if all[1] < all[0] {
                        all[1]
                    } else {
                        all[0]
                    }
                }
                "max" => {
                    if all[0] < all[1] {
                        all[1]
                    } else {
                        all[0]
                    }
                }
                "floor" => all[0].floor(),
                _ => all[0].abs(),
            }
        }
        RandomTree::Pick(bit, a, b) => value(if k >> bit & 1 == 1 { a } else { b }, x, y, k),
    }
}

#[test]
fn random_programs_give_what_a_tree_walk_gives_alone_and_in_company() {
    let mut rng = fastrand::Rng::with_seed(42);
    for round in 0..60 {
        let tree = grow(&mut rng, 5);
        let (mut body, mut next) = (String::new(), 0);
        let last = write(&tree, &mut body, &mut next);
        let text = format!("fn f(x: f32, y: f32, k: u32) -> f32 {{\n{body}return t{last};\n}}");
        let p = program(&text);
        let lanes = 130;
        let xs: Vec<f32> = (0..lanes).map(|_| f32::from(rng.i16(..)) / 256.0).collect();
        let ys: Vec<f32> = (0..lanes).map(|_| f32::from(rng.i8(..))).collect();
        let ks: Vec<u32> = (0..lanes).map(|_| rng.u32(0..64)).collect();
        let bits = |list: &[f32]| list.iter().map(|x| x.to_bits()).collect::<Vec<u32>>();
        let all = words(&p, "f", &[&bits(&xs), &bits(&ys), &ks]);
        for lane in 0..lanes {
            let (x, y, k) = (xs[lane], ys[lane], ks[lane]);
            let (got, expected) = (f32::from_bits(all[lane]), value(&tree, x, y, k));
            let same = got.to_bits() == expected.to_bits() || got.is_nan() && expected.is_nan();
            assert!(same, "round {round}, {x}, {y}, {k}: {got}, not {expected}\n{text}");
            if lane % 13 == 0 {
                let alone = words(&p, "f", &[&[x.to_bits()], &[y.to_bits()], &[k]]);
                assert_eq!(alone, [all[lane]], "round {round}, lane {lane}\n{text}");
            }
        }
    }
}
