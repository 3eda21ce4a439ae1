//! Cases of integers, bits and conversions: every result is exact. Fed by the specifications'
//! formulas in Rust's integers, feeds the families.

use super::case::{Allowed, Case};
use super::draw::Draw;

const EXACT: &str = "exact";

fn words(count: usize) -> impl Fn(&mut Draw) -> Vec<u32> {
    move |d| (0..count).map(|_| d.word()).collect()
}

fn case(
    name: &'static str,
    operands: &'static str,
    results: &'static [&'static str],
    f: impl Fn(&[u32]) -> u32 + 'static,
) -> Case {
    let count = operands.split(' ').count();
    Case::new(name, EXACT, operands, results, words(count), move |w| vec![Allowed::Word(f(w))])
}

/// With the right operand from the left one, where not every word will do.
fn with(
    name: &'static str,
    operands: &'static str,
    results: &'static [&'static str],
    right: impl Fn(&mut Draw, u32) -> Vec<u32>,
    f: impl Fn(&[u32]) -> u32 + 'static,
) -> Case {
    let draw = move |d: &mut Draw| {
        let mut words = vec![d.word()];
        words.extend(right(d, words[0]));
        words
    };
    Case::new(name, EXACT, operands, results, draw, move |w| vec![Allowed::Word(f(w))])
}

fn s(word: u32) -> i32 {
    word as i32
}

/// Not zero, and not what overflows.
fn divisor(d: &mut Draw, left: u32) -> Vec<u32> {
    let word = d.word();
    let fits = word != 0 && !(word == u32::MAX && left == 1 << 31);
    vec![if fits { word } else { 3 }]
}

fn amount(d: &mut Draw, _left: u32) -> Vec<u32> {
    vec![d.0.u32(0..32)]
}

fn field(d: &mut Draw) -> [u32; 2] {
    let offset = d.0.u32(0..32);
    [offset, d.0.u32(0..=32 - offset)]
}

fn mask(offset: u32, count: u32) -> u32 {
    if count == 0 { 0 } else { (u32::MAX >> (32 - count)) << offset }
}

fn extract(w: &[u32]) -> u32 {
    (w[0] & mask(w[1], w[2])).checked_shr(w[1]).unwrap_or(0)
}

fn extract_signed(w: &[u32]) -> u32 {
    if w[2] == 0 {
        return 0;
    }
    ((extract(w) << (32 - w[2])) as i32 >> (32 - w[2])) as u32
}

fn insert(w: &[u32]) -> u32 {
    let mask = mask(w[2], w[3]);
    w[0] & !mask | w[1].checked_shl(w[2]).unwrap_or(0) & mask
}

fn highest(word: u32) -> u32 {
    31u32.wrapping_sub(word.leading_zeros())
}

/// Operators and bits.
pub fn operators() -> Vec<Case> {
    vec![
        case("i32 + - *", "i i", &["i (a + b) ^ (a - b) ^ (a * b)"], |w| {
            w[0].wrapping_add(w[1]) ^ w[0].wrapping_sub(w[1]) ^ w[0].wrapping_mul(w[1])
        }),
        case("u32 + - *", "u u", &["u (a + b) ^ (a - b) ^ (a * b)"], |w| {
            w[0].wrapping_add(w[1]) ^ w[0].wrapping_sub(w[1]) ^ w[0].wrapping_mul(w[1])
        }),
        with("i32 /", "i i", &["i a / b"], divisor, |w| (s(w[0]) / s(w[1])) as u32),
        with("u32 /", "u u", &["u a / b"], divisor, |w| w[0] / w[1]),
        with("u32 %", "u u", &["u a % b"], divisor, |w| w[0] % w[1]),
        case("& | ^ ~", "u u", &["u (a & b) + (a | b) * 3u + (a ^ ~b) * 5u"], |w| {
            let (and, or, xor) = (w[0] & w[1], w[0] | w[1], w[0] ^ !w[1]);
            and.wrapping_add(or.wrapping_mul(3)).wrapping_add(xor.wrapping_mul(5))
        }),
        with("u32 <<", "u u", &["u a << b"], amount, |w| w[0] << w[1]),
        with("u32 >>", "u u", &["u a >> b"], amount, |w| w[0] >> w[1]),
        with("i32 >>", "i u", &["i a >> b"], amount, |w| (s(w[0]) >> w[1]) as u32),
        case("i32 -a", "i", &["i -a"], |w| w[0].wrapping_neg()),
        case("i32 abs", "i", &["i abs(a)"], |w| s(w[0]).wrapping_abs() as u32),
        case("i32 sign", "i", &["i sign(a)"], |w| s(w[0]).signum() as u32),
        case("i32 min", "i i", &["i min(a, b)"], |w| s(w[0]).min(s(w[1])) as u32),
        case("i32 max", "i i", &["i max(a, b)"], |w| s(w[0]).max(s(w[1])) as u32),
        case("u32 min", "u u", &["u min(a, b)"], |w| w[0].min(w[1])),
        case("u32 max", "u u", &["u max(a, b)"], |w| w[0].max(w[1])),
        case("i32 clamp", "i i i", &["i clamp(a, min(b, c), max(b, c))"], |w| {
            let (b, c) = (s(w[1]), s(w[2]));
            s(w[0]).clamp(b.min(c), b.max(c)) as u32
        }),
        case(
            "i32 comparisons",
            "i i",
            &["u uint(a < b) | uint(a <= b) << 1 | uint(a == b) << 2"],
            |w| {
                let (a, b) = (s(w[0]), s(w[1]));
                u32::from(a < b) | u32::from(a <= b) << 1 | u32::from(a == b) << 2
            },
        ),
        case(
            "u32 comparisons",
            "u u",
            &["u uint(a < b) | uint(a <= b) << 1 | uint(a == b) << 2"],
            |w| {
                u32::from(w[0] < w[1]) | u32::from(w[0] <= w[1]) << 1 | u32::from(w[0] == w[1]) << 2
            },
        ),
        case("countOneBits", "u", &["u uint(bitCount(a))"], |w| w[0].count_ones()),
        case("reverseBits", "u", &["u bitfieldReverse(a)"], |w| w[0].reverse_bits()),
        case("firstLeadingBit", "u", &["i findMSB(a)"], |w| highest(w[0])),
        case("firstLeadingBit of i32", "i", &["i findMSB(a)"], |w| {
            highest(if s(w[0]) < 0 { !w[0] } else { w[0] })
        }),
        case("firstTrailingBit", "u", &["i findLSB(a)"], |w| {
            if w[0] == 0 { u32::MAX } else { w[0].trailing_zeros() }
        }),
        with(
            "extractBits",
            "u i i",
            &["u bitfieldExtract(a, b, c)"],
            |d, _| field(d).to_vec(),
            extract,
        ),
        with(
            "extractBits of i32",
            "i i i",
            &["i bitfieldExtract(a, b, c)"],
            |d, _| field(d).to_vec(),
            extract_signed,
        ),
        with(
            "insertBits",
            "u u i i",
            &["u bitfieldInsert(a, b, c, d)"],
            |d, _| {
                let [offset, count] = field(d);
                vec![d.word(), offset, count]
            },
            insert,
        ),
    ]
}

fn float(low: f32, high: f32) -> impl Fn(&mut Draw) -> Vec<u32> {
    move |d| vec![d.float(low, high).to_bits()]
}

fn f(word: u32) -> f32 {
    f32::from_bits(word)
}

/// Conversions, and numbers packed in words.
pub fn conversions() -> Vec<Case> {
    let rounded = |x: f64| Allowed::Correct(x);
    let below_2_31 = 2_147_483_520.0;
    vec![
        Case::new("f32 to i32", EXACT, "f", &["i int(a)"], float(-below_2_31, below_2_31), |w| {
            vec![Allowed::Word(f(w[0]) as i32 as u32)]
        }),
        Case::new("f32 to u32", EXACT, "f", &["u uint(a)"], float(0.0, 4_294_967_040.0), |w| {
            vec![Allowed::Word(f(w[0]) as u32)]
        }),
        Case::new("i32 to f32", "correctly rounded", "i", &["f float(a)"], words(1), move |w| {
            vec![rounded(f64::from(s(w[0])))]
        }),
        Case::new("u32 to f32", "correctly rounded", "u", &["f float(a)"], words(1), move |w| {
            vec![rounded(f64::from(w[0]))]
        }),
        Case::new("bitcast", EXACT, "f", &["i floatBitsToInt(a)"], words(1), |w| {
            // A device may change which NaN it is.
            vec![if f(w[0]).is_nan() { Allowed::Open } else { Allowed::Word(w[0]) }]
        }),
        pack("pack4x8snorm", "f4", &["u packSnorm4x8(a)"], 8, -1.0, 127.0),
        pack("pack4x8unorm", "f4", &["u packUnorm4x8(a)"], 8, 0.0, 255.0),
        pack("pack2x16snorm", "f2", &["u packSnorm2x16(a)"], 16, -1.0, 32767.0),
        pack("pack2x16unorm", "f2", &["u packUnorm2x16(a)"], 16, 0.0, 65535.0),
        unpack("unpack4x8snorm", &["f4 unpackSnorm4x8(a)"], 8, true),
        unpack("unpack4x8unorm", &["f4 unpackUnorm4x8(a)"], 8, false),
        unpack("unpack2x16snorm", &["f2 unpackSnorm2x16(a)"], 16, true),
        unpack("unpack2x16unorm", &["f2 unpackUnorm2x16(a)"], 16, false),
        unpack_half(),
        pack_half(),
    ]
}

/// `floor(0.5 + scale * clamp(x, low, 1))` in WGSL, `round` in GLSL: each component's field may
/// be either whole number that lies within a half and the rounding of the product.
fn pack(
    name: &'static str,
    operands: &'static str,
    results: &'static [&'static str],
    bits: u32,
    low: f32,
    scale: f64,
) -> Case {
    let count = (32 / bits) as usize;
    // One component varies; the other fields are known, so that two words are allowed at most.
    let draw = move |d: &mut Draw| {
        let mut words = vec![1f32.to_bits(); count];
        let at = d.0.usize(0..count);
        words[at] = d.float(-1.5, 1.5).to_bits();
        words
    };
    Case::new(name, "either of two at a half", operands, results, draw, move |w| {
        let mut allowed = [0u32; 2];
        for (i, word) in w.iter().enumerate() {
            let exact = scale * f64::from(f(*word).clamp(low, 1.0));
            let slack = 0.5 + scale * 2f64.powi(-23);
            for (k, sign) in [-1.0, 1.0].into_iter().enumerate() {
                let ends = [(exact - slack).ceil(), (exact + slack).floor()];
                let end = if sign < 0.0 { ends[0].min(ends[1]) } else { ends[1].max(ends[0]) };
                let kept = end.clamp(f64::from(low) * scale, scale);
                allowed[k] |= (kept as i32 as u32 & (u32::MAX >> (32 - bits))) << (i as u32 * bits);
            }
        }
        vec![Allowed::Either(allowed[0], allowed[1])]
    })
}

fn unpack(name: &'static str, results: &'static [&'static str], bits: u32, signed: bool) -> Case {
    Case::new(name, "3 ULP", "u", results, words(1), move |w| {
        let each = |i: u32| {
            let field = w[0] << (32 - bits - i * bits);
            let truth = match signed {
                true => {
                    let most = f64::from((1u32 << (bits - 1)) - 1);
                    (f64::from(field as i32 >> (32 - bits)) / most).max(-1.0)
                }
                false => f64::from(field >> (32 - bits)) / f64::from(u32::MAX >> (32 - bits)),
            };
            let exact = super::interval::Interval { low: truth, high: truth };
            Allowed::Within(truth, exact.ulps(3.0))
        };
        (0..32 / bits).map(each).collect()
    })
}

/// The value of 16 bits as IEEE 754 has them.
fn half_value(bits: u32) -> f64 {
    let sign = if bits & 0x8000 == 0 { 1.0 } else { -1.0 };
    let (exponent, fraction) = ((bits >> 10 & 31) as i32, f64::from(bits & 0x3ff));
    match exponent {
        0 => sign * fraction * 2f64.powi(-24),
        _ => sign * (1.0 + fraction / 1024.0) * 2f64.powi(exponent - 15),
    }
}

fn unpack_half() -> Case {
    let draw = |d: &mut Draw| {
        let word = d.word();
        // Neither infinite nor NaN: what becomes of those is not defined.
        let finite = |h: u32| if h & 0x7c00 == 0x7c00 { h & 0xbfff } else { h };
        vec![finite(word >> 16) << 16 | finite(word & 0xffff)]
    };
    Case::new("unpack2x16float", EXACT, "u", &["f2 unpackHalf2x16(a)"], draw, |w| {
        let each = |half: u32| {
            let value = half_value(half);
            match value != 0.0 && value.abs() < 2f64.powi(-14) {
                true => Allowed::Within(
                    value,
                    super::interval::Interval { low: value.min(0.0), high: value.max(0.0) },
                ),
                false => Allowed::Correct(value),
            }
        };
        vec![each(w[0] & 0xffff), each(w[0] >> 16)]
    })
}

/// Correctly rounded, in either direction.
fn pack_half() -> Case {
    let draw = |d: &mut Draw| vec![d.float(-65504.0, 65504.0).to_bits(), 1f32.to_bits()];
    let results = &["u packHalf2x16(a)"];
    Case::new("pack2x16float", "correctly rounded", "f2", results, draw, |w| {
        let x = f64::from(f(w[0]));
        let sign = if f(w[0]).is_sign_negative() { 0x8000 } else { 0 };
        // Halves of one sign are in order as their bits are.
        let (mut low, mut high) = (0u32, 0x7bff_u32);
        while high - low > 1 {
            let middle = u32::midpoint(low, high);
            if half_value(middle) <= x.abs() { low = middle } else { high = middle }
        }
        if half_value(high) == x.abs() {
            low = high;
        }
        if half_value(low) == x.abs() {
            high = low;
        }
        let one = 0x3c00_0000;
        vec![Allowed::Either(one | sign | low, one | sign | high)]
    })
}
