//! Expressions of GLSL and WGSL as far as rewrites need them: sums, products, calls, members.
//!
//! Text that is anything else has no formula, and no advice.

use std::fmt;

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Formula {
    /// A literal, or a name with its members and indices.
    Leaf(String),
    Call(String, Vec<Formula>),
    Neg(Box<Formula>),
    /// `+`, `-`, `*`, `/` or `%`.
    Binary(char, Box<Formula>, Box<Formula>),
}

use Formula::{Binary, Call, Leaf, Neg};

/// The deepest expression that is read.
const DEEPEST: u32 = 64;

pub(super) fn binary(operator: char, a: Formula, b: Formula) -> Formula {
    Binary(operator, Box::new(a), Box::new(b))
}

pub(super) fn call(name: &str, arguments: Vec<Formula>) -> Formula {
    Call(name.to_string(), arguments)
}

/// A number as a literal of both languages.
pub(super) fn number(x: f64) -> Formula {
    match x < 0.0 {
        true => Neg(Box::new(number(-x))),
        false => Leaf(format!("{x:?}")),
    }
}

impl Formula {
    /// Reads an expression; `None` if it has other syntax.
    pub fn read(text: &str) -> Option<Formula> {
        let mut reader = Reader { rest: text.trim(), depth: 0 };
        let formula = reader.sum()?;
        reader.rest.trim().is_empty().then_some(formula)
    }

    pub fn value(&self) -> Option<f64> {
        match self {
            Leaf(text) => text.trim_end_matches(['f', 'F']).parse().ok(),
            Neg(inner) => Some(-inner.value()?),
            Call(..) | Binary(..) => None,
        }
    }

    // Higher binds more tightly.
    fn precedence(&self) -> u8 {
        match self {
            Binary('+' | '-', ..) => 0,
            Binary(..) => 1,
            Neg(_) => 2,
            Leaf(_) | Call(..) => 3,
        }
    }
}

impl fmt::Display for Formula {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let inside =
            |inner: &Formula, least: u8, f: &mut fmt::Formatter<'_>| match inner.precedence() {
                own if own < least => write!(f, "({inner})"),
                _ => write!(f, "{inner}"),
            };
        match self {
            Leaf(text) => f.write_str(text),
            Call(name, arguments) => {
                write!(f, "{name}(")?;
                for (nth, argument) in arguments.iter().enumerate() {
                    write!(f, "{}{argument}", if nth == 0 { "" } else { ", " })?;
                }
                f.write_str(")")
            }
            Neg(inner) => {
                f.write_str("-")?;
                inside(inner, 3, f)
            }
            Binary(operator, a, b) => {
                let own = self.precedence();
                inside(a, own, f)?;
                write!(f, " {operator} ")?;
                // The right operand of `-` and `/` needs parentheses at equal precedence.
                inside(b, own + 1, f)
            }
        }
    }
}

struct Reader<'t> {
    rest: &'t str,
    depth: u32,
}

impl Reader<'_> {
    fn take(&mut self, symbol: char) -> bool {
        let rest = self.rest.trim_start();
        let found = rest.strip_prefix(symbol);
        self.rest = found.unwrap_or(rest);
        found.is_some()
    }

    /// Takes one of some operators that is not part of a longer one.
    fn operator(&mut self, of: &[char]) -> Option<char> {
        let rest = self.rest.trim_start();
        let found = rest.chars().next().filter(|c| of.contains(c))?;
        // `++`, `+=` and the like are no operators of an expression without effects.
        let longer = rest[1..].starts_with([found, '=']);
        (!longer).then(|| {
            self.rest = &rest[1..];
            found
        })
    }

    // sum = product { ("+" | "-") product } (GLSL 4.60 §9, additive_expression).
    fn sum(&mut self) -> Option<Formula> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return None;
        }
        let mut all = self.product()?;
        while let Some(operator) = self.operator(&['+', '-']) {
            all = binary(operator, all, self.product()?);
        }
        self.depth -= 1;
        Some(all)
    }

    // product = unary { ("*" | "/" | "%") unary } (multiplicative_expression).
    fn product(&mut self) -> Option<Formula> {
        let mut all = self.unary()?;
        while let Some(operator) = self.operator(&['*', '/', '%']) {
            all = binary(operator, all, self.unary()?);
        }
        Some(all)
    }

    // unary = { "+" | "-" } primary (unary_expression, without `++`, `--`, `!`, `~`).
    fn unary(&mut self) -> Option<Formula> {
        let mut negative = false;
        while let Some(sign) = self.operator(&['+', '-']) {
            negative ^= sign == '-';
        }
        let inner = self.primary()?;
        Some(if negative { Neg(Box::new(inner)) } else { inner })
    }

    // primary = "(" sum ")" | number | name { "." member | "[" index "]" } [ "(" [ sum { "," sum }
    // ] ")" ] (primary_expression, postfix_expression).
    fn primary(&mut self) -> Option<Formula> {
        if self.take('(') {
            let inner = self.sum()?;
            // Members of an expression in parentheses are not read.
            let closed = self.take(')') && !self.rest.starts_with(['.', '[']);
            return closed.then_some(inner);
        }
        let rest = self.rest.trim_start();
        let mut end = 0;
        let is_number = rest.starts_with(|c: char| c.is_ascii_digit() || c == '.');
        // One token of letters, digits, dots and the sign of an exponent: `1.0e-3`,
        // `light.position.x`.
        for (at, c) in rest.char_indices() {
            let exponent = is_number && matches!(c, '+' | '-') && rest[..at].ends_with(['e', 'E']);
            if !(c.is_alphanumeric() || c == '_' || c == '.' || exponent) {
                break;
            }
            end = at + c.len_utf8();
        }
        // Indices of names, without expressions in them.
        while rest[end..].starts_with('[') {
            let close = end + rest[end..].find(']')?;
            let index = &rest[end + 1..close];
            if !index.chars().all(|c| c.is_alphanumeric() || c == '_') {
                return None;
            }
            end = close + 1;
            let member = rest[end..].find(|c: char| !(c.is_alphanumeric() || c == '_' || c == '.'));
            end += member.unwrap_or(rest.len() - end);
        }
        if end == 0 {
            return None;
        }
        let name = rest[..end].to_string();
        self.rest = &rest[end..];
        // A name with parentheses after it is a call.
        if !self.take('(') {
            return Some(Leaf(name));
        }
        let mut arguments = Vec::new();
        if !self.take(')') {
            loop {
                arguments.push(self.sum()?);
                if self.take(')') {
                    break;
                }
                if !self.take(',') {
                    return None;
                }
            }
        }
        (!self.rest.starts_with(['.', '['])).then_some(Call(name, arguments))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_expression_is_printed_as_it_is_read() {
        let same = [
            "a - b * (c + d) / e",
            "a - (b - c)",
            "-(a + b) * -c",
            "dot(a.xyz, b[2].v) + 1.0e-5",
            "x - sqrt(x * x - 1.0)",
        ];
        for text in same {
            assert_eq!(Formula::read(text).expect(text).to_string(), text);
        }
        for other in ["a < b", "a ? b : c", "(a + b).x", "a[i + 1]", "a +", "", "a += b", "a--"] {
            assert_eq!(Formula::read(other), None, "{other}");
        }
    }
}
