//! Parsing of WGSL's numeric literals (§3.5.2).

use crate::syntax::constant::Value;

/// Returns the value of a literal with its suffix; `None` if it is malformed or out of range.
// decimal_int_literal: /0[iu]?|[1-9][0-9]*[iu]?/   hex_int_literal: /0[xX][0-9a-fA-F]+[iu]?/
// decimal_float_literal: digits with `.`, exponent or suffix [fh]
// hex_float_literal: /0[xX]/ digits with `.` or `p` exponent, suffix [fh]
// `li`, `lu` and `lf` are naga's suffixes for 64 bits.
pub(super) fn literal(text: &str) -> Option<Value> {
    if let Some(hex) = text.strip_prefix("0x").or_else(|| text.strip_prefix("0X")) {
        return if hex.contains(['.', 'p', 'P']) { hex_float(hex) } else { integer(hex, 16) };
    }
    let float = text.contains(['.', 'e', 'E']) || text.ends_with(['f', 'h']);
    if !float {
        // §3.5.2: no leading zeros, except in zero itself.
        let digits = text.bytes().take_while(u8::is_ascii_digit).count();
        return if digits > 1 && text.starts_with('0') { None } else { integer(text, 10) };
    }
    let digits = text.strip_suffix("lf").or_else(|| text.strip_suffix(['f', 'h'])).unwrap_or(text);
    digits.parse().ok().filter(|v: &f64| v.is_finite()).map(Value::Float)
}

fn integer(text: &str, radix: u32) -> Option<Value> {
    let digits = text.trim_end_matches(['i', 'u', 'l']);
    let wide = i128::from_str_radix(digits, radix).ok()?;
    Some(match &text[digits.len()..] {
        "" => Value::Abstract(wide.try_into().ok()?),
        "i" => Value::Int(wide.try_into().ok()?),
        "u" => Value::Uint(wide.try_into().ok()?),
        "li" => Value::Long(wide.try_into().ok()?),
        "lu" => Value::Ulong(wide.try_into().ok()?),
        // A hexadecimal float needs a point or exponent: otherwise `f` is a digit.
        _ => return None,
    })
}

// Up to 53 bits are exact; beyond them the last bit may differ from a correct rounding.
fn hex_float(text: &str) -> Option<Value> {
    let (mantissa, exponent) = match text.split_once(['p', 'P']) {
        Some((mantissa, exponent)) => {
            (mantissa, exponent.trim_end_matches(['f', 'h']).parse::<i32>().ok()?)
        }
        None => (text, 0),
    };
    let (whole, part) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    if whole.is_empty() && part.is_empty() {
        return None;
    }
    let mut value = 0.0f64;
    let mut scale = 1.0f64;
    for digit in whole.chars() {
        value = value * 16.0 + f64::from(digit.to_digit(16)?);
    }
    for digit in part.chars() {
        scale /= 16.0;
        value += scale * f64::from(digit.to_digit(16)?);
    }
    let value = value * f64::from(exponent).exp2();
    value.is_finite().then_some(Value::Float(value))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Value::{Abstract, Float, Int, Long, Uint, Ulong};

    #[test]
    fn literals_have_the_type_of_their_suffix() {
        let cases = [
            ("0", Abstract(0)),
            ("64u", Uint(64)),
            ("7i", Int(7)),
            ("3li", Long(3)),
            ("3lu", Ulong(3)),
            ("0x1F", Abstract(31)),
            ("0xffffffffu", Uint(u32::MAX)),
            ("1.5f", Float(1.5)),
            ("2e3h", Float(2000.0)),
            ("1f", Float(1.0)),
            ("0x1.8p3", Float(12.0)),
            ("0xAp-1f", Float(5.0)),
        ];
        for (text, value) in cases {
            assert_eq!(literal(text), Some(value), "{text}");
        }
    }

    #[test]
    fn what_is_no_literal_has_no_value() {
        for text in ["012", "4294967296u", "2147483648i", "0x", "1ul", "1.2.3", "0x.p1", "1a"] {
            assert_eq!(literal(text), None, "{text}");
        }
    }
}
