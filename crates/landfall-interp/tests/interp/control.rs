//! Control flow: the path of an invocation does not depend on those that run beside it.

use super::support::{floats, program, words};

#[test]
fn a_loop_ends_for_each_invocation_by_itself() {
    let p = program(
        "fn collatz(start: u32) -> u32 {
            var n = start;
            var steps = 0u;
            loop {
                if n <= 1u { break; }
                if n % 2u == 0u { n = n / 2u; steps++; continue; }
                n = 3u * n + 1u;
                steps++;
            }
            return steps;
        }",
    );
    let reference = |mut n: u32| {
        let mut steps = 0;
        while n > 1 {
            n = if n & 1 == 0 { n / 2 } else { 3 * n + 1 };
            steps += 1;
        }
        steps
    };
    let inputs: Vec<u32> = (0..200).collect();
    let expected: Vec<u32> = inputs.iter().map(|&n| reference(n)).collect();
    assert_eq!(words(&p, "collatz", &[&inputs]), expected);
    for &n in &inputs {
        assert_eq!(words(&p, "collatz", &[&[n]]), [reference(n)], "alone, from {n}");
    }
}

#[test]
fn return_break_and_continue_leave_nested_loops_and_calls() {
    let p = program(
        "fn inner(x: i32, limit: i32) -> i32 {
            for (var i = 0; i < 10; i++) {
                if i == limit { return x * 100 + i; }
                if i == 7 { break; }
            }
            return -x;
        }
        fn outer(x: i32) -> i32 {
            var sum = 0;
            for (var i = 0; i < x; i++) {
                if i % 3 == 1 { continue; }
                for (var j = 0; ; j++) {
                    if j > i { break; }
                    if i + j == 9 { return sum; }
                    sum += inner(i, j);
                }
                if sum > 5000 { break; }
            }
            return sum + 1;
        }",
    );
    fn inner(x: i32, limit: i32) -> i32 {
        for i in 0..10 {
            if i == limit {
                return x * 100 + i;
            }
            if i == 7 {
                break;
            }
        }
        -x
    }
    fn outer(x: i32) -> i32 {
        let mut sum = 0;
        for i in 0..x {
            if i % 3 == 1 {
                continue;
            }
            for j in 0.. {
                if j > i {
                    break;
                }
                if i + j == 9 {
                    return sum;
                }
                sum += inner(i, j);
            }
            if sum > 5000 {
                break;
            }
        }
        sum + 1
    }
    let inputs: Vec<u32> = (0..100).map(|n| n % 17).collect();
    let expected: Vec<u32> = inputs.iter().map(|&x| outer(x as i32) as u32).collect();
    assert_eq!(words(&p, "outer", &[&inputs]), expected);
}

#[test]
fn a_switch_takes_one_case_and_falls_through_none() {
    let p = program(
        "fn pick(x: i32) -> i32 {
            var r = 0;
            switch x {
                case 1: { r = 10; }
                case 2, 3: { r = 20; if x == 3 { break; } r = 21; }
                default: { r = 99; }
                case -4: { return -1; }
            }
            return r + 1;
        }",
    );
    let inputs = [1, 2, 3, 4, -4i32 as u32, 0];
    let expected = [11, 22, 21, 100, -1i32 as u32, 100];
    assert_eq!(words(&p, "pick", &[&inputs]), expected);
}

#[test]
fn a_continue_inside_a_switch_goes_on_with_the_loop() {
    let p = program(
        "fn f(n: u32) -> u32 {
            var sum = 0u;
            for (var i = 0u; i < n; i++) {
                switch i % 4u {
                    case 0u: { continue; }
                    case 1u: { sum += 10u; break; }
                    default: { sum += 1u; }
                }
                sum += 100u;
            }
            return sum;
        }",
    );
    let reference = |n: u32| {
        (0..n)
            .map(|i| match i % 4 {
                0 => 0,
                1 => 110,
                _ => 101,
            })
            .sum::<u32>()
    };
    let inputs: Vec<u32> = (0..70).collect();
    let expected: Vec<u32> = inputs.iter().map(|&n| reference(n)).collect();
    assert_eq!(words(&p, "f", &[&inputs]), expected);
}

#[test]
fn pointers_to_variables_and_their_parts_are_written_through() {
    let p = program(
        "struct S { a: array<f32, 4>, b: vec3<f32> }
        var<private> kept: f32 = 3.0;
        fn twice(x: ptr<function, f32>) { *x = *x * 2.0; }
        fn keep(x: ptr<private, f32>, by: f32) { *x += by; }
        fn f(i: f32) -> f32 {
            var s: S;
            let k = u32(i) % 4u;
            s.a[k] = i;
            s.b.y = 1.0;
            s.b[k % 3u] += 5.0;
            twice(&s.a[k]);
            var whole = s.b.y;
            twice(&whole);
            keep(&kept, i);
            return s.a[0] + s.a[1] + s.a[2] + s.a[3] + whole + kept;
        }",
    );
    let inputs: Vec<f32> = (0..70u16).map(f32::from).collect();
    let expected: Vec<f32> = inputs
        .iter()
        .map(|&i| {
            let y = 1.0 + if (i as u32 % 4) % 3 == 1 { 5.0 } else { 0.0 };
            2.0 * i + 2.0 * y + 3.0 + i
        })
        .collect();
    assert_eq!(floats(&p, "f", &[&inputs]), expected);
}

// GLSL 4.60 §6.1.1: arguments are evaluated once, from left to right.
#[test]
fn a_later_argument_does_not_change_an_earlier_one() {
    let text = "#version 450\n\
                layout(location = 0) out vec4 color;\n\
                int pair(int a, int b) { return 10 * a + b; }\n\
                int both(int a) { return pair(a, a++); }\n\
                int next(inout int a) { a += 1; return a; }\n\
                int through(int a) { return pair(a, next(a)); }\n\
                void main() { color = vec4(both(1), through(1), 0.0, 1.0); }\n";
    let source = landfall_layout::Source::new("test.frag", text);
    let module = landfall_ir::Module::for_calls(&source, &landfall_layout::Options::default());
    let p = landfall_interp::Program::new(&module.expect("it lowers"), &[]);
    assert_eq!(words(&p, "both", &[&[1, 2]]), [11, 22]);
    assert_eq!(words(&p, "through", &[&[1, 2]]), [12, 23]);
}
