//! Cases that WGSL defines and GLSL leaves open or has not: division by zero, shifts and
//! fields beyond the word, conversions out of range. For the backends that take modules.

use super::case::{Allowed, Case};
use super::draw::Draw;
use super::interval::Interval;

fn case(
    name: &'static str,
    operands: &'static str,
    results: &'static [&'static str],
    f: impl Fn(&[u32]) -> u32 + 'static,
) -> Case {
    let count = operands.split(' ').count();
    let draw = move |d: &mut Draw| (0..count).map(|_| d.word()).collect();
    Case::new(name, "exact", operands, results, draw, move |w| vec![Allowed::Word(f(w))])
}

fn s(word: u32) -> i32 {
    word as i32
}

/// Offset and count as WGSL §17.3 cuts them to the word.
fn cut(offset: u32, count: u32) -> (u32, u32) {
    let offset = offset.min(32);
    (offset, count.min(32 - offset))
}

fn float(low: f32, high: f32) -> impl Fn(&mut Draw) -> Vec<u32> {
    move |d| vec![d.float(low, high).to_bits()]
}

pub fn all() -> Vec<Case> {
    vec![
        // WGSL §8.7: x / 0 is x, x % 0 is 0; so is what overflows.
        case("i32 / by anything", "i i", &["i a / b"], |w| {
            s(w[0]).checked_div(s(w[1])).unwrap_or(s(w[0])) as u32
        }),
        case("i32 % by anything", "i i", &["i a % b"], |w| {
            s(w[0]).checked_rem(s(w[1])).unwrap_or(0) as u32
        }),
        case("u32 / by anything", "u u", &["u a / b"], |w| w[0].checked_div(w[1]).unwrap_or(w[0])),
        case("u32 % by anything", "u u", &["u a % b"], |w| w[0].checked_rem(w[1]).unwrap_or(0)),
        // WGSL §8.9: by the amount modulo 32.
        case("u32 << by anything", "u u", &["u a << b"], |w| w[0].wrapping_shl(w[1])),
        case("u32 >> by anything", "u u", &["u a >> b"], |w| w[0].wrapping_shr(w[1])),
        case("i32 >> by anything", "i u", &["i a >> b"], |w| s(w[0]).wrapping_shr(w[1]) as u32),
        case("countLeadingZeros", "u", &["u countLeadingZeros(a)"], |w| w[0].leading_zeros()),
        case("countTrailingZeros", "u", &["u countTrailingZeros(a)"], |w| w[0].trailing_zeros()),
        Case::new(
            "extractBits beyond",
            "exact",
            "u u u",
            &["u extractBits(a, b, c)"],
            field,
            |w| {
                let (offset, count) = cut(w[1], w[2]);
                let wide = u64::from(w[0]) >> offset & ((1u64 << count) - 1);
                vec![Allowed::Word(wide as u32)]
            },
        ),
        case("dot4U8Packed", "u u", &["u dot4U8Packed(a, b)"], |w| {
            w[0].to_le_bytes()
                .iter()
                .zip(w[1].to_le_bytes())
                .map(|(a, b)| u32::from(*a) * u32::from(b))
                .sum()
        }),
        case("dot4I8Packed", "u u", &["i dot4I8Packed(a, b)"], |w| {
            let (a, b) = (w[0].to_le_bytes(), w[1].to_le_bytes());
            let product = |(a, b): (u8, u8)| i32::from(a as i8) * i32::from(b as i8);
            a.into_iter().zip(b).map(product).sum::<i32>() as u32
        }),
        // Beyond the type's range Tint's devices give its last value, naga's the last that is
        // a float too; WGSL §15.7.6 has both readings.
        Case::new(
            "f32 to i32 beyond",
            "either of two",
            "f",
            &["i i32(a)"],
            float(-1e20, 1e20),
            |w| {
                let x = f32::from_bits(w[0]);
                let least = x.min(2_147_483_520.0);
                vec![Allowed::Either(x as i32 as u32, least as i32 as u32)]
            },
        ),
        Case::new(
            "f32 to u32 beyond",
            "either of two",
            "f",
            &["u u32(a)"],
            float(-1e20, 1e20),
            |w| {
                let x = f32::from_bits(w[0]);
                vec![Allowed::Either(x as u32, x.min(4_294_967_040.0) as u32)]
            },
        ),
        Case::new(
            "saturate",
            "correctly rounded",
            "f",
            &["f saturate(a)"],
            float(-3.0, 3.0),
            |w| {
                let x = f64::from(f32::from_bits(w[0]));
                let above = if x < 0.0 { 0.0 } else { x };
                vec![Allowed::Correct(if 1.0 < above { 1.0 } else { above })]
            },
        ),
        remainder(),
        fract_parts(),
    ]
}

fn field(d: &mut Draw) -> Vec<u32> {
    vec![d.word(), d.0.u32(0..40), d.0.u32(0..40)]
}

fn remainder() -> Case {
    let draw = |d: &mut Draw| {
        let sign = if d.0.bool() { 1.0 } else { -1.0 };
        [d.float(-1e4, 1e4), sign * d.float(0.1, 1e3)].map(f32::to_bits).to_vec()
    };
    let permitted = "from `a - b * trunc(a / b)`";
    Case::new("f32 %", permitted, "f f", &["f a % b"], draw, |w| {
        let [a, b] = [w[0], w[1]].map(f32::from_bits);
        let quotient = Interval::of(a).div(Interval::of(b)).whole(f64::trunc);
        let within = Interval::of(a).sub(quotient.mul(Interval::of(b)));
        Allowed::Within(f64::from(a) % f64::from(b), within).into()
    })
}

impl From<Allowed> for Vec<Allowed> {
    fn from(one: Allowed) -> Vec<Allowed> {
        vec![one]
    }
}

fn fract_parts() -> Case {
    let results = &["f modf(a).fract", "f modf(a).whole"];
    let draw = float(-f32::MAX, f32::MAX);
    Case::new("modf of WGSL", "correctly rounded", "f", results, draw, |w| {
        let x = f64::from(f32::from_bits(w[0]));
        vec![Allowed::Correct(x - x.trunc()), Allowed::Correct(x.trunc())]
    })
}
