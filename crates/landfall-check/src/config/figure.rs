//! Arithmetic for sizes, as written beside `glBufferData`: `48 * 128 + 4`, `0x20`, `(3 + 1) * 16`.

use std::ops::Range;

/// Maximum nesting of parentheses.
const DEEPEST: usize = 64;

/// The range of an error in the text, and its message.
pub type FigureError = (Range<usize>, String);

/// Evaluates an expression.
pub fn value(text: &str) -> Result<u64, FigureError> {
    let mut reader = FigureReader { text, at: 0, depth: 0 };
    let value = reader.sum()?;
    reader.skip();
    if reader.at < text.len() {
        return Err(reader.wrong_here("is unexpected here"));
    }
    Ok(value)
}

struct FigureReader<'a> {
    text: &'a str,
    at: usize,
    depth: usize,
}

impl FigureReader<'_> {
    fn skip(&mut self) {
        let rest = &self.text[self.at..];
        self.at += rest.len() - rest.trim_start().len();
    }

    fn peek(&mut self) -> Option<char> {
        self.skip();
        self.text[self.at..].chars().next()
    }

    fn wrong_here(&mut self, what: &str) -> FigureError {
        match self.peek() {
            Some(c) => (self.at..self.at + c.len_utf8(), format!("`{c}` {what}")),
            None => (self.at..self.at, "ends where a number is expected".to_string()),
        }
    }

    // sum: product { ( "+" | "-" ) product }
    fn sum(&mut self) -> Result<u64, FigureError> {
        let start = self.at;
        let mut sum = self.product()?;
        while let Some(sign @ ('+' | '-')) = self.peek() {
            self.at += 1;
            let more = self.product()?;
            let next = if sign == '+' { sum.checked_add(more) } else { sum.checked_sub(more) };
            sum = next.ok_or_else(|| {
                let what = if sign == '+' { "exceeds 64 bits" } else { "is negative" };
                (start..self.at, format!("`{}` {what}", self.text[start..self.at].trim()))
            })?;
        }
        Ok(sum)
    }

    // product: factor { "*" factor }
    fn product(&mut self) -> Result<u64, FigureError> {
        let start = self.at;
        let mut product = self.factor()?;
        while self.peek() == Some('*') {
            self.at += 1;
            let more = self.factor()?;
            product = product.checked_mul(more).ok_or_else(|| {
                (start..self.at, format!("`{}` exceeds 64 bits", self.text[start..self.at].trim()))
            })?;
        }
        Ok(product)
    }

    // factor: "(" sum ")" | number
    fn factor(&mut self) -> Result<u64, FigureError> {
        match self.peek() {
            Some('(') => {
                let open = self.at;
                self.at += 1;
                self.depth += 1;
                if self.depth > DEEPEST {
                    return Err((open..open + 1, format!("nests more than {DEEPEST} parentheses")));
                }
                let value = self.sum()?;
                if self.peek() != Some(')') {
                    return Err((open..open + 1, "`(` is not closed".to_string()));
                }
                self.at += 1;
                self.depth -= 1;
                Ok(value)
            }
            Some(c) if c.is_ascii_digit() => self.number(),
            _ => Err(self.wrong_here("is not a number")),
        }
    }

    // number: decimal digits, or hexadecimal ones after `0x`, with `_` anywhere between them
    fn number(&mut self) -> Result<u64, FigureError> {
        let rest = &self.text[self.at..];
        let len = rest.find(|c: char| c != '_' && !c.is_ascii_alphanumeric()).unwrap_or(rest.len());
        let range = self.at..self.at + len;
        self.at += len;
        let word = &rest[..len];
        let digits = word.replace('_', "");
        let value = match digits.strip_prefix("0x").or(digits.strip_prefix("0X")) {
            Some(digits) => u64::from_str_radix(digits, 16),
            None => digits.parse(),
        };
        value.map_err(|cause| {
            let past = *cause.kind() == std::num::IntErrorKind::PosOverflow;
            (
                range,
                format!(
                    "`{word}` is {}",
                    if past { "too large for 64 bits" } else { "not a number" }
                ),
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_come_before_sums_and_parentheses_before_both() {
        for (text, expected) in [
            ("48 * 128 + 4", 6148),
            ("6160", 6160),
            ("0x20", 32),
            ("(3+1)*0x10", 64),
            ("4 + 48*128", 6148),
            ("10 - 2 - 3", 5),
            ("1_024", 1024),
        ] {
            assert_eq!(value(text), Ok(expected), "{text}");
        }
    }

    #[test]
    fn what_is_no_figure_is_told_with_its_place() {
        for (text, place, words) in [
            ("48 *", 4..4, "ends where"),
            ("", 0..0, "ends where"),
            ("48 x 128", 3..4, "`x` is unexpected"),
            ("(4", 0..1, "not closed"),
            ("4 - 8", 0..5, "`4 - 8` is negative"),
            ("0x", 0..2, "`0x` is not a number"),
            ("99999999999999999999", 0..20, "too large for 64 bits"),
            ("4294967296 * 4294967296", 0..23, "exceeds 64 bits"),
            ("4 + é", 4..6, "`é` is not a number"),
        ] {
            let (range, message) = value(text).unwrap_err();
            assert_eq!(range, place, "{text}");
            assert!(message.contains(words), "{text}: {message}");
        }
        assert!(value(&"(".repeat(100_000)).unwrap_err().1.contains("nests"));
    }
}
