//! Integers and conversions against Rust's and the tables of WGSL §8.7 and §17.

use super::support::{call, program, words};

const NUMBERS: [u32; 14] = [
    0,
    1,
    2,
    5,
    7,
    31,
    32,
    255,
    65536,
    0x7fff_ffff,
    0x8000_0000,
    0xdead_beef,
    0xffff_fff0,
    0xffff_ffff,
];

fn pairs() -> (Vec<u32>, Vec<u32>) {
    NUMBERS.iter().flat_map(|&a| NUMBERS.iter().map(move |&b| (a, b))).unzip()
}

fn check(ty: &str, expression: &str, reference: impl Fn(u32, u32) -> u32) {
    let p = program(&format!("fn f(a: {ty}, b: {ty}) -> {ty} {{ return {expression}; }}"));
    let (a, b) = pairs();
    for (i, got) in words(&p, "f", &[&a, &b]).into_iter().enumerate() {
        let expected = reference(a[i], b[i]);
        assert_eq!(got, expected, "{expression} of {ty} {:#x}, {:#x}", a[i], b[i]);
    }
}

fn signed(f: impl Fn(i32, i32) -> i32) -> impl Fn(u32, u32) -> u32 {
    move |a, b| f(a as i32, b as i32) as u32
}

#[test]
fn operators_wrap_and_division_by_zero_is_defined() {
    for ty in ["u32", "i32"] {
        check(ty, "a + b", u32::wrapping_add);
        check(ty, "a - b", u32::wrapping_sub);
        check(ty, "a * b", u32::wrapping_mul);
        check(ty, "a & b", |a, b| a & b);
        check(ty, "a | b", |a, b| a | b);
        check(ty, "a ^ b", |a, b| a ^ b);
        check(ty, "~a", |a, _| !a);
        check(ty, "a << (u32(b) % 32u)", |a, b| a << (b % 32));
    }
    check("u32", "a / b", |a, b| a.checked_div(b).unwrap_or(a));
    check("u32", "a % b", |a, b| a.checked_rem(b).unwrap_or(0));
    check("i32", "a / b", signed(|a, b| if b == 0 { a } else { a.wrapping_div(b) }));
    check("i32", "a % b", signed(|a, b| if b == 0 { 0 } else { a.wrapping_rem(b) }));
    check("u32", "a >> (b % 32u)", |a, b| a >> (b % 32));
    check("i32", "a >> (u32(b) % 32u)", |a, b| (a as i32 >> (b % 32)) as u32);
    check("i32", "-a", signed(|a, _| a.wrapping_neg()));
}

#[test]
fn functions_of_integers() {
    check("i32", "min(a, b)", signed(i32::min));
    check("u32", "min(a, b)", u32::min);
    check("i32", "max(a, b)", signed(i32::max));
    check("u32", "max(a, b)", u32::max);
    check("i32", "abs(a)", signed(|a, _| a.wrapping_abs()));
    check("i32", "sign(a)", signed(|a, _| a.signum()));
    check("i32", "clamp(a, -5, 5)", signed(|a, _| a.clamp(-5, 5)));
    check("u32", "countOneBits(a)", |a, _| a.count_ones());
    check("u32", "countLeadingZeros(a)", |a, _| a.leading_zeros());
    check("u32", "countTrailingZeros(a)", |a, _| a.trailing_zeros());
    check("u32", "reverseBits(a)", |a, _| a.reverse_bits());
    check("u32", "firstTrailingBit(a)", |a, _| (0..32).find(|i| a >> i & 1 == 1).unwrap_or(!0));
    let leading = |a: u32| (0..32).rev().find(|i| a >> i & 1 == 1).unwrap_or(!0);
    check("u32", "firstLeadingBit(a)", move |a, _| leading(a));
    check("i32", "firstLeadingBit(a)", move |a, _| leading(if (a as i32) < 0 { !a } else { a }));
    let field = |offset: u32, count: u32| {
        let offset = offset.min(32);
        (offset, count.min(32 - offset))
    };
    check("u32", "extractBits(a, b, 7u)", move |a, b| {
        let (offset, count) = field(b, 7);
        (0..count).map(|i| (a >> (offset + i) & 1) << i).sum()
    });
    check("i32", "extractBits(a, u32(b), 7u)", move |a, b| {
        let (offset, count) = field(b, 7);
        let bits: u32 = (0..count).map(|i| (a >> (offset + i) & 1) << i).sum();
        let negative = count > 0 && bits >> (count - 1) == 1;
        if negative { bits | u32::MAX.checked_shl(count).unwrap_or(0) } else { bits }
    });
    check("u32", "insertBits(a, b, 3u, 9u)", |a, b| a & !(0x1ff << 3) | (b & 0x1ff) << 3);
    check("u32", "insertBits(a, b, b, 9u)", move |a, b| {
        let (offset, count) = field(b, 9);
        (0..count).fold(a, |word, i| {
            let bit = 1 << (offset + i);
            if b >> i & 1 == 1 { word | bit } else { word & !bit }
        })
    });
    check("u32", "dot4U8Packed(a, b)", |a, b| {
        (0..4).map(|i| (a >> (8 * i) & 255) * (b >> (8 * i) & 255)).sum()
    });
    check("u32", "u32(dot4I8Packed(a, b))", |a, b| {
        let byte = |x: u32, i: u32| i32::from((x >> (8 * i)) as u8 as i8);
        (0..4).map(|i| byte(a, i) * byte(b, i)).sum::<i32>() as u32
    });
    check("u32", "dot(vec3<u32>(a, b, a), vec3<u32>(b, b, 3u))", |a, b| {
        a.wrapping_mul(b).wrapping_add(b.wrapping_mul(b)).wrapping_add(a.wrapping_mul(3))
    });
}

#[test]
fn comparisons_know_the_sign() {
    check("i32", "i32(a < b)", signed(|a, b| i32::from(a < b)));
    check("i32", "i32(a >= b)", signed(|a, b| i32::from(a >= b)));
    check("u32", "u32(a < b)", |a, b| u32::from(a < b));
    check("u32", "u32(a <= b)", |a, b| u32::from(a <= b));
    check("u32", "u32(a > b)", |a, b| u32::from(a > b));
    check("u32", "u32(a == b)", |a, b| u32::from(a == b));
    check("u32", "u32(a != b)", |a, b| u32::from(a != b));
    check("u32", "select(0u, 1u, !(a == b) && a > 4u || b == 0u)", |a, b| {
        u32::from(a != b && a > 4 || b == 0)
    });
    check("u32", "u32(all(vec2<u32>(a, b) > vec2<u32>(1u)))", |a, b| u32::from(a > 1 && b > 1));
    check("u32", "u32(any(vec2<u32>(a, b) > vec2<u32>(1u)))", |a, b| u32::from(a > 1 || b > 1));
}

#[test]
fn floats_become_the_nearest_integer_towards_zero() {
    let p = program(
        "fn i(a: f32) -> i32 { return i32(a); }
        fn u(a: f32) -> u32 { return u32(a); }
        fn fi(a: i32) -> f32 { return f32(a); }
        fn fu(a: u32) -> f32 { return f32(a); }
        fn b(a: f32) -> u32 { return u32(bool(a)); }",
    );
    let numbers = [0.0f32, 0.9, -0.9, -3.99, 1e9, 3e9, -3e9, 1e20, f32::INFINITY, f32::NAN, -0.0];
    let bits: Vec<u32> = numbers.iter().map(|x| x.to_bits()).collect();
    let int: Vec<u32> = numbers.iter().map(|&x| x as i32 as u32).collect();
    let uint: Vec<u32> = numbers.iter().map(|&x| x as u32).collect();
    assert_eq!(words(&p, "i", &[&bits]), int);
    assert_eq!(words(&p, "u", &[&bits]), uint);
    let bools: Vec<u32> = numbers.iter().map(|&x| u32::from(x != 0.0)).collect();
    assert_eq!(words(&p, "b", &[&bits]), bools);
    let from: Vec<u32> = NUMBERS.iter().map(|&x| (x as i32 as f32).to_bits()).collect();
    assert_eq!(words(&p, "fi", &[&NUMBERS]), from);
    let from: Vec<u32> = NUMBERS.iter().map(|&x| (x as f32).to_bits()).collect();
    assert_eq!(words(&p, "fu", &[&NUMBERS]), from);
}

#[test]
fn packing_rounds_half_up_and_unpacking_undoes_it() {
    let p = program(
        "fn f(a: f32, b: f32) -> array<u32, 5> {
            let v = vec4<f32>(a, b, -a, 1.0);
            return array<u32, 5>(pack4x8unorm(v), pack4x8snorm(v), pack2x16unorm(v.xy),
                pack2x16snorm(v.xy), pack2x16float(v.xy));
        }
        fn g(x: u32) -> array<f32, 10> {
            let a = unpack4x8unorm(x); let b = unpack4x8snorm(x); let c = unpack2x16float(x);
            return array<f32, 10>(a.x, a.y, a.z, a.w, b.x, b.y, b.z, b.w, c.x, c.y);
        }",
    );
    let (a, b) = (0.3f32, -0.6f32);
    let called = call(&p, "f", &[&[a.to_bits()], &[b.to_bits()]]);
    let unorm = |x: f32, n: f32| (0.5 + n * x.clamp(0.0, 1.0)).floor() as u32;
    let snorm = |x: f32, n: f32, bits: u32| {
        ((0.5 + n * x.clamp(-1.0, 1.0)).floor() as i32 as u32) & (u32::MAX >> (32 - bits))
    };
    let four = |f: &dyn Fn(f32) -> u32| f(a) | f(b) << 8 | f(-a) << 16 | f(1.0) << 24;
    let half = |x: f32| u32::from(half::f16::from_f32(x).to_bits());
    let expected = [
        four(&|x| unorm(x, 255.0)),
        four(&|x| snorm(x, 127.0, 8)),
        unorm(a, 65535.0) | unorm(b, 65535.0) << 16,
        snorm(a, 32767.0, 16) | snorm(b, 32767.0, 16) << 16,
        half(a) | half(b) << 16,
    ];
    let got: Vec<u32> = called.result.words.iter().map(|w| w[0] as u32).collect();
    assert_eq!(got, expected);
    let x = 0x3c80_7fffu32;
    let got: Vec<f32> =
        call(&p, "g", &[&[x]]).result.words.iter().map(|w| f32::from_bits(w[0] as u32)).collect();
    let byte = |i: u32| (x >> (8 * i)) as u8;
    let mut expected: Vec<f32> = (0..4).map(|i| f32::from(byte(i)) / 255.0).collect();
    expected.extend((0..4).map(|i| (f32::from(byte(i) as i8) / 127.0).max(-1.0)));
    let halves = [x as u16, (x >> 16) as u16].map(|h| half::f16::from_bits(h).to_f32());
    expected.extend(halves);
    assert!(
        got.iter().zip(&expected).all(|(a, b)| a.to_bits() == b.to_bits() || a.is_nan()),
        "{got:?}, not {expected:?}"
    );
}

#[test]
fn doubles_and_64_bit_integers_have_all_their_bits() {
    let p = program(
        "fn f(a: f64, b: f64) -> array<f64, 4> {
            return array<f64, 4>(a * b + 1.0lf, sqrt(a), min(a, b), dot(vec2<f64>(a, b), vec2<f64>(b, b)));
        }
        fn g(a: i64, b: i64) -> array<i64, 4> { return array<i64, 4>(a * b, a / b, a - b, max(a, b)); }
        fn h(a: u64) -> f32 { return f32(a); }",
    );
    let (a, b) = (0.1f64, 3.7f64);
    let words = |x: u64| vec![vec![x]];
    let run = |function: &str, arguments: Vec<Vec<Vec<u64>>>| -> Vec<u64> {
        let call = landfall_interp::Call { function, lanes: 1, arguments, resources: &[] };
        let called = p.call(&call, &super::support::single());
        called.expect("it runs").result.words.iter().map(|w| w[0]).collect()
    };
    let got = run("f", vec![words(a.to_bits()), words(b.to_bits())]);
    let expected = [a * b + 1.0, a.sqrt(), a, a * b + b * b].map(f64::to_bits);
    assert_eq!(got, expected);
    let (a, b) = (0x1234_5678_9abc_def0i64, -77i64);
    let got = run("g", vec![words(a as u64), words(b as u64)]);
    assert_eq!(got, [a.wrapping_mul(b), a / b, a - b, a].map(|x| x as u64));
    let big = u64::MAX - 12345;
    assert_eq!(run("h", vec![words(big)]), [u64::from((big as f32).to_bits())]);
}
