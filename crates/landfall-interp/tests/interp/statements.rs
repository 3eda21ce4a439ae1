//! Random functions of branches, loops, switches and calls, against a walk over their statements for
//! one invocation at a time: what is stored in some lanes, and in others not.

use std::fmt::Write as _;

use super::support::{program, words};

/// Values are whole numbers below this, which `f32` multiplies exactly.
const MODULUS: i64 = 4096;

/// Variables of each function, the first two of which are its arguments.
const VARIABLES: usize = 5;

#[derive(Debug)]
enum Value {
    Number(i64),
    Variable(usize),
    Binary(char, Box<Value>, Box<Value>),
    /// A call of a function with two values.
    Call(usize, Box<Value>, Box<Value>),
}

#[derive(Debug)]
enum RandomStatement {
    Set(usize, Value),
    /// Whether a value is below another decides.
    If(Value, Value, Vec<RandomStatement>, Vec<RandomStatement>),
    /// So many times at most; the counter of the nesting level is a variable.
    Loop(i64, Vec<RandomStatement>, Vec<RandomStatement>),
    /// By a value modulo 3: the cases 0 and 1, which may be left early, and the others.
    Switch(Value, [Vec<RandomStatement>; 3]),
    /// Calls a function that changes a variable through a pointer.
    Change(usize, usize, Value),
    Break,
    Continue,
    Return(Value),
}

/// A function of two values, or of a pointer and a value.
#[derive(Debug)]
struct StatementFunction {
    pointer: bool,
    body: Vec<RandomStatement>,
    result: Value,
}

struct StatementRandom {
    rng: fastrand::Rng,
    /// The functions so far: whether each takes a pointer.
    functions: Vec<bool>,
}

impl StatementRandom {
    fn callee(&mut self, pointer: bool) -> Option<usize> {
        let all = 0..self.functions.len();
        let fitting: Vec<usize> = all.filter(|&f| self.functions[f] == pointer).collect();
        self.rng.choice(fitting)
    }

    fn value(&mut self, depth: u32) -> Value {
        let kind = self.rng.u32(0..if depth == 0 { 4 } else { 10 });
        match kind {
            0 => Value::Number(self.rng.i64(0..MODULUS)),
            1..=3 => Value::Variable(self.rng.usize(0..VARIABLES)),
            9 if !self.functions.iter().all(|pointer| *pointer) => {
                let callee = self.callee(false).expect("there is one");
                let (a, b) = (self.value(depth - 1), self.value(depth - 1));
                Value::Call(callee, Box::new(a), Box::new(b))
            }
            _ => {
                let operator = self.rng.choice(['+', '-', '*']).expect("there are three");
                let (a, b) = (self.value(depth - 1), self.value(depth - 1));
                Value::Binary(operator, Box::new(a), Box::new(b))
            }
        }
    }

    /// Statements within so many loops; `exits` are allowed at their end.
    fn block(&mut self, depth: u32, loops: u32, exits: bool) -> Vec<RandomStatement> {
        let count = self.rng.usize(1..5);
        let mut all: Vec<RandomStatement> =
            (0..count).map(|_| self.statement(depth, loops)).collect();
        match self.rng.u32(0..9) {
            0 | 1 if exits && loops > 0 => all.push(RandomStatement::Break),
            2 | 3 if exits && loops > 0 => all.push(RandomStatement::Continue),
            4 if exits => all.push(RandomStatement::Return(self.value(1))),
            _ => {}
        }
        all
    }

    fn statement(&mut self, depth: u32, loops: u32) -> RandomStatement {
        // Not the first argument, which stays as it is in many functions.
        let variable = self.rng.usize(1..VARIABLES);
        match self.rng.u32(0..if depth == 0 { 5 } else { 10 }) {
            4 if self.functions.contains(&true) => {
                let callee = self.callee(true).expect("there is one");
                RandomStatement::Change(callee, variable, self.value(1))
            }
            0..=4 => RandomStatement::Set(variable, self.value(2)),
            5 | 6 => {
                let (a, b) = (self.value(1), self.value(1));
                let reject = self.rng.bool().then(|| self.block(depth - 1, loops, true));
                let accept = self.block(depth - 1, loops, true);
                RandomStatement::If(a, b, accept, reject.unwrap_or_default())
            }
            7 | 8 => {
                let body = self.block(depth - 1, loops + 1, false);
                let continuing = (0..2).map(|_| self.statement(0, 0)).collect();
                RandomStatement::Loop(self.rng.i64(1..5), body, continuing)
            }
            _ => {
                let of = self.value(1);
                let cases = [0, 1, 2].map(|_| self.block(depth - 1, 0, false));
                RandomStatement::Switch(of, cases)
            }
        }
    }
}

fn value_text(value: &Value) -> String {
    match value {
        Value::Number(n) => format!("{n}.0"),
        Value::Variable(v) => format!("v{v}"),
        Value::Binary(op, a, b) => format!("wrap({} {op} {})", value_text(a), value_text(b)),
        Value::Call(f, a, b) => format!("f{f}({}, {})", value_text(a), value_text(b)),
    }
}

fn block_text(block: &[RandomStatement], level: usize, text: &mut String) {
    for statement in block {
        let _ = match statement {
            RandomStatement::Set(v, value) => writeln!(text, "v{v} = {};", value_text(value)),
            RandomStatement::Change(f, v, value) => {
                writeln!(text, "f{f}(&v{v}, {});", value_text(value))
            }
            RandomStatement::Return(value) => writeln!(text, "return {};", value_text(value)),
            RandomStatement::Break => writeln!(text, "break;"),
            RandomStatement::Continue => writeln!(text, "continue;"),
            RandomStatement::If(a, b, accept, reject) => {
                let _ = writeln!(text, "if {} < {} {{", value_text(a), value_text(b));
                block_text(accept, level, text);
                let _ = writeln!(text, "}} else {{");
                block_text(reject, level, text);
                writeln!(text, "}}")
            }
            RandomStatement::Loop(times, body, continuing) => {
                let _ = writeln!(
                    text,
                    "{{ var n{level} = 0; loop {{ if n{level} == {times} {{ break; }}"
                );
                block_text(body, level + 1, text);
                let _ = writeln!(text, "continuing {{ n{level} = n{level} + 1;");
                block_text(continuing, level + 1, text);
                writeln!(text, "}} }} }}")
            }
            RandomStatement::Switch(of, [zero, one, others]) => {
                let _ = writeln!(text, "switch i32({}) % 3 {{ case 0: {{", value_text(of));
                block_text(zero, level, text);
                let _ = writeln!(text, "}} case 1: {{");
                block_text(one, level, text);
                let _ = writeln!(text, "}} default: {{");
                block_text(others, level, text);
                writeln!(text, "}} }}")
            }
        };
    }
}

fn function_text(number: usize, function: &StatementFunction, text: &mut String) {
    let (first, start) = match function.pointer {
        true => ("p: ptr<function, f32>", "*p"),
        false => ("a: f32", "a"),
    };
    let result = if function.pointer { "" } else { "-> f32 " };
    let _ = writeln!(text, "fn f{number}({first}, b: f32) {result}{{");
    let _ = writeln!(text, "var v0 = {start}; var v1 = b; var v2: f32; var v3 = b; var v4 = 7.0;");
    let mut body = String::new();
    block_text(&function.body, 0, &mut body);
    if function.pointer {
        // The loops and branches of a pointer's function have no returns.
        let _ = write!(text, "{body}*p = {};\n}}\n", value_text(&function.result));
    } else {
        let _ = write!(text, "{body}return {};\n}}\n", value_text(&function.result));
    }
}

/// Why a block ended.
#[derive(PartialEq)]
enum End {
    Whole,
    Break,
    Continue,
    Return(i64),
}

type Variables = [i64; VARIABLES];

fn evaluate(all: &[StatementFunction], value: &Value, v: &Variables) -> i64 {
    match value {
        Value::Number(n) => *n,
        Value::Variable(number) => v[*number],
        Value::Binary(op, a, b) => {
            let (a, b) = (evaluate(all, a, v), evaluate(all, b, v));
            let exact = match op {
                '+' => a + b,
                '-' => a - b,
                _ => a * b,
            };
            exact.rem_euclid(MODULUS)
        }
        Value::Call(f, a, b) => {
            let (a, b) = (evaluate(all, a, v), evaluate(all, b, v));
            call(all, *f, a, b)
        }
    }
}

fn call(all: &[StatementFunction], number: usize, a: i64, b: i64) -> i64 {
    let function = &all[number];
    let mut v = [a, b, 0, b, 7];
    match walk(all, &function.body, &mut v) {
        End::Return(value) => value,
        _ => evaluate(all, &function.result, &v),
    }
}

fn walk(all: &[StatementFunction], block: &[RandomStatement], v: &mut Variables) -> End {
    for statement in block {
        let end = match statement {
            RandomStatement::Set(to, value) => {
                v[*to] = evaluate(all, value, v);
                End::Whole
            }
            RandomStatement::Change(f, to, value) => {
                v[*to] = call(all, *f, v[*to], evaluate(all, value, v));
                End::Whole
            }
            RandomStatement::Break => End::Break,
            RandomStatement::Continue => End::Continue,
            RandomStatement::Return(value) => End::Return(evaluate(all, value, v)),
            RandomStatement::If(a, b, accept, reject) => {
                let accepts = evaluate(all, a, v) < evaluate(all, b, v);
                walk(all, if accepts { accept } else { reject }, v)
            }
            RandomStatement::Switch(of, cases) => {
                let case = evaluate(all, of, v) as usize % 3;
                walk(all, &cases[case], v)
            }
            RandomStatement::Loop(times, body, continuing) => {
                let mut ended = End::Whole;
                for _ in 0..*times {
                    match walk(all, body, v) {
                        End::Whole | End::Continue => {}
                        End::Break => break,
                        End::Return(value) => {
                            ended = End::Return(value);
                            break;
                        }
                    }
                    walk(all, continuing, v);
                }
                ended
            }
        };
        if end != End::Whole {
            return end;
        }
    }
    End::Whole
}

/// Whether a function returns before its end.
fn has_return(block: &[RandomStatement]) -> bool {
    block.iter().any(|statement| match statement {
        RandomStatement::Return(_) => true,
        RandomStatement::If(_, _, a, b) | RandomStatement::Loop(_, a, b) => {
            has_return(a) || has_return(b)
        }
        RandomStatement::Switch(_, cases) => cases.iter().any(|case| has_return(case)),
        _ => false,
    })
}

#[test]
fn random_statements_do_what_they_do_for_one_invocation() {
    let mut inlined = [0; 2];
    for seed in 0..40 {
        let rng = fastrand::Rng::with_seed(seed);
        let mut random = StatementRandom { rng, functions: Vec::new() };
        let mut functions: Vec<StatementFunction> = Vec::new();
        let mut text =
            String::from("fn wrap(x: f32) -> f32 { return x - 4096.0 * floor(x / 4096.0); }\n");
        while functions.len() < 5 {
            let number = functions.len();
            let depth = if number == 4 { 3 } else { 2 };
            let body = random.block(depth, 0, false);
            let pointer = number < 4 && !has_return(&body) && random.rng.bool();
            let function = StatementFunction { pointer, body, result: random.value(2) };
            inlined[usize::from(has_return(&function.body))] += 1;
            function_text(number, &function, &mut text);
            random.functions.push(pointer);
            functions.push(function);
        }
        let p = program(&text);
        let lanes = 70;
        let [a, b] =
            [0, 1].map(|_| (0..lanes).map(|_| random.rng.i64(0..MODULUS)).collect::<Vec<i64>>());
        let bits = |list: &[i64]| list.iter().map(|x| (*x as f32).to_bits()).collect::<Vec<u32>>();
        let found = words(&p, "f4", &[&bits(&a), &bits(&b)]);
        for lane in 0..lanes {
            let expected = call(&functions, 4, a[lane], b[lane]);
            let found = f32::from_bits(found[lane]);
            assert_eq!(found, expected as f32, "seed {seed}, lane {lane}:\n{text}");
        }
    }
    // Both are tested: functions whose code stands in place of calls, and others.
    assert!(inlined.iter().all(|count| *count > 25), "{inlined:?}");
}
