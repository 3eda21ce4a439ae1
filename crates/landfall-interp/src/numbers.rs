//! The values of an expression in all invocations, read from the machine's registers.
//!
//! Used by [`call`](super::call) and [`stage`](super::stage) for arguments and results.

use super::code::{Class, Reg};
use super::lanes::Lanes;
use super::machine::Machine;
use super::real::Real;
use super::value::{Value, ValueType};
use landfall_layout::shape::{Scalar, ScalarKind};

/// The words of a value, by scalar in the order of [`ValueType::scalars`], then by invocation: the
/// bits of an `f32` (for `f16` too) or of an integer, 0 or 1 for a bool; 64 bits for 64-bit types.
pub type Words = Vec<Vec<u64>>;

/// The values of an expression in all invocations.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Numbers {
    /// As [`Words`], floats rounded to `f32`.
    pub words: Words,
    /// As numbers, floats in `f64` where that was computed.
    pub doubles: Vec<Vec<f64>>,
    /// With [`Precision::Permitted`](super::Precision::Permitted): the least and greatest number
    /// that a conformant device may give for each float; both infinite if any value is permitted.
    /// Other scalars have their own value twice.
    pub permitted: Option<Vec<Vec<[f64; 2]>>>,
}

impl Numbers {
    pub(super) fn read<R: Real>(m: &mut Machine<R>, regs: &[Reg], lanes: usize) -> Numbers {
        let mut numbers = Numbers::default();
        if R::PERMITTED {
            numbers.permitted = Some(Vec::with_capacity(regs.len()));
        }
        for &reg in regs {
            let (words, doubles): (Vec<u64>, Vec<f64>) = match reg.class() {
                Class::Real => m
                    .reals_of(reg)
                    .each()
                    .take(lanes)
                    .map(|x| (u64::from(x.single().to_bits()), x.double()))
                    .unzip(),
                Class::Word => {
                    let words = &m.words_of(reg)[..lanes];
                    words.iter().map(|&x| (u64::from(x), f64::from(x))).unzip()
                }
                Class::Wide => {
                    m.wides_of(reg)[..lanes].iter().map(|&x| (x, f64::from_bits(x))).unzip()
                }
            };
            if let Some(permitted) = &mut numbers.permitted {
                let spans = match reg.class() {
                    Class::Real => {
                        let reals = m.reals_of(reg).each().take(lanes);
                        reals.map(|x| x.span().expect("it has one")).collect()
                    }
                    Class::Word | Class::Wide => doubles.iter().map(|x| [*x; 2]).collect(),
                };
                permitted.push(spans);
            }
            numbers.words.push(words);
            numbers.doubles.push(doubles);
        }
        numbers
    }

    pub(super) fn append(&mut self, more: Numbers) {
        if self.words.is_empty() {
            // The first batch.
            *self = more;
            return;
        }
        for (all, more) in self.words.iter_mut().zip(more.words) {
            all.extend(more);
        }
        for (all, more) in self.doubles.iter_mut().zip(more.doubles) {
            all.extend(more);
        }
        let permitted = self.permitted.iter_mut().flatten();
        for (all, more) in permitted.zip(more.permitted.into_iter().flatten()) {
            all.extend(more);
        }
    }

    /// Returns the value of one invocation, floats with all their digits.
    pub fn value(&self, ty: &ValueType, lane: usize) -> Value {
        let scalars = ty.scalars();
        let mut numbers = scalars.iter().enumerate().map(|(i, scalar)| {
            let word = self.words[i][lane];
            match (scalar.kind, scalar.width) {
                (ScalarKind::Sint, 8) => word as i64 as f64,
                (ScalarKind::Uint, 8) => word as f64,
                (ScalarKind::Sint, _) => f64::from(word as u32 as i32),
                (ScalarKind::Uint | ScalarKind::Bool, _) => f64::from(word as u32),
                _ => self.doubles[i][lane],
            }
        });
        ty.build(&mut numbers)
    }
}

impl ValueType {
    /// Returns the words of values, one value per invocation; `None` if one is not of this type.
    pub fn words(&self, values: &[Value]) -> Option<Words> {
        let scalars = self.scalars();
        let mut words: Words = vec![Vec::with_capacity(values.len()); scalars.len()];
        for value in values {
            for ((number, scalar), to) in
                self.flatten(value)?.into_iter().zip(&scalars).zip(&mut words)
            {
                to.push(word(*scalar, number));
            }
        }
        Some(words)
    }
}

/// Returns the word of a scalar for a number.
fn word(scalar: Scalar, number: f64) -> u64 {
    match (scalar.kind, scalar.width) {
        (ScalarKind::Bool, _) => u64::from(number != 0.0),
        (ScalarKind::Sint, 8) => number as i64 as u64,
        (ScalarKind::Uint, 8) => number as u64,
        (ScalarKind::Sint, _) => u64::from(number as i32 as u32),
        (ScalarKind::Uint, _) => u64::from(number as u32),
        (ScalarKind::Float, 8) => number.to_bits(),
        _ => u64::from((number as f32).to_bits()),
    }
}
