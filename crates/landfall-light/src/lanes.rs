//! Numbers in the registers of the processor at hand, with operators.

use std::ops::{Add, Div, Mul, Sub};

use pulp::Simd;

/// The most lanes of any processor.
pub(crate) const MOST: usize = 16;

/// Numbers, as many as a register holds.
pub(crate) struct Lanes<S: Simd> {
    simd: S,
    values: S::f32s,
}

/// A condition of each number.
pub(crate) struct Mask<S: Simd> {
    simd: S,
    values: S::m32s,
}

impl<S: Simd> Clone for Lanes<S> {
    #[inline(always)]
    fn clone(&self) -> Lanes<S> {
        *self
    }
}

impl<S: Simd> Copy for Lanes<S> {}

impl<S: Simd> Clone for Mask<S> {
    #[inline(always)]
    fn clone(&self) -> Mask<S> {
        *self
    }
}

impl<S: Simd> Copy for Mask<S> {}

macro_rules! operation {
    ($operation:ident, $function:ident, $instruction:ident) => {
        impl<S: Simd> $operation for Lanes<S> {
            type Output = Lanes<S>;

            #[inline(always)]
            fn $function(self, other: Lanes<S>) -> Lanes<S> {
                let values = self.simd.$instruction(self.values, other.values);
                Lanes { values, ..self }
            }
        }

        impl<S: Simd> $operation<f32> for Lanes<S> {
            type Output = Lanes<S>;

            #[inline(always)]
            fn $function(self, other: f32) -> Lanes<S> {
                self.$function(self.splat(other))
            }
        }

        impl<S: Simd> $operation<Lanes<S>> for f32 {
            type Output = Lanes<S>;

            #[inline(always)]
            fn $function(self, other: Lanes<S>) -> Lanes<S> {
                other.splat(self).$function(other)
            }
        }
    };
}

operation!(Add, add, add_f32s);
operation!(Sub, sub, sub_f32s);
operation!(Mul, mul, mul_f32s);
operation!(Div, div, div_f32s);

impl<S: Simd> Lanes<S> {
    #[inline(always)]
    pub fn zero(simd: S) -> Lanes<S> {
        Lanes { simd, values: simd.splat_f32s(0.0) }
    }

    /// Reads numbers, no more than a register holds.
    #[inline(always)]
    pub fn load(simd: S, values: &[f32]) -> Lanes<S> {
        // A part of a register is loaded by a jump for its length.
        let values = match S::as_simd_f32s(values).0 {
            [whole] => *whole,
            _ => simd.partial_load_f32s(values),
        };
        Lanes { simd, values }
    }

    /// Writes as many of the numbers as there is room for.
    #[inline(always)]
    pub fn store(self, into: &mut [f32]) {
        match S::as_mut_simd_f32s(into).0 {
            [whole] => *whole = self.values,
            _ => self.simd.partial_store_f32s(into, self.values),
        }
    }

    /// Returns registers of one number.
    #[inline(always)]
    pub fn splat(self, x: f32) -> Lanes<S> {
        Lanes { values: self.simd.splat_f32s(x), ..self }
    }

    /// Returns `self * by + to`, fused where the processor does that.
    #[inline(always)]
    pub fn mul_add(self, by: Lanes<S>, to: Lanes<S>) -> Lanes<S> {
        Lanes { values: self.simd.mul_add_e_f32s(self.values, by.values, to.values), ..self }
    }

    #[inline(always)]
    pub fn abs(self) -> Lanes<S> {
        Lanes { values: self.simd.abs_f32s(self.values), ..self }
    }

    #[inline(always)]
    pub fn sqrt(self) -> Lanes<S> {
        Lanes { values: self.simd.sqrt_f32s(self.values), ..self }
    }

    /// Returns the larger; `other` where this is NaN.
    #[inline(always)]
    pub fn max(self, other: Lanes<S>) -> Lanes<S> {
        other.less(self).select(self, other)
    }

    /// Returns the smaller; `other` where this is NaN.
    #[inline(always)]
    pub fn min(self, other: Lanes<S>) -> Lanes<S> {
        self.less(other).select(self, other)
    }

    /// Returns the larger; where one is NaN, either.
    #[inline(always)]
    pub fn larger(self, other: Lanes<S>) -> Lanes<S> {
        Lanes { values: self.simd.max_f32s(self.values, other.values), ..self }
    }

    /// Returns the smaller; where one is NaN, either.
    #[inline(always)]
    pub fn smaller(self, other: Lanes<S>) -> Lanes<S> {
        Lanes { values: self.simd.min_f32s(self.values, other.values), ..self }
    }

    /// Returns the power of `2^TIMES`.
    #[inline(always)]
    pub fn squared<const TIMES: u32>(self) -> Lanes<S> {
        let mut power = self;
        for _ in 0..TIMES {
            power = power * power;
        }
        power
    }

    #[inline(always)]
    pub fn powi(self, exponent: u32) -> Lanes<S> {
        if exponent == 0 {
            return self.splat(1.0);
        }
        let mut square = self;
        for _ in 0..exponent.trailing_zeros() {
            square = square * square;
        }
        let mut power = square;
        let mut left = exponent >> exponent.trailing_zeros() >> 1;
        while left > 0 {
            square = square * square;
            if left & 1 == 1 {
                power = power * square;
            }
            left >>= 1;
        }
        power
    }

    #[inline(always)]
    pub fn sum(self) -> f32 {
        self.simd.reduce_sum_f32s(self.values)
    }

    #[inline(always)]
    pub fn less(self, other: Lanes<S>) -> Mask<S> {
        Mask { simd: self.simd, values: self.simd.less_than_f32s(self.values, other.values) }
    }
}

impl<S: Simd> Mask<S> {
    #[inline(always)]
    pub fn and(self, other: Mask<S>) -> Mask<S> {
        Mask { values: self.simd.and_m32s(self.values, other.values), ..self }
    }

    #[inline(always)]
    pub fn or(self, other: Mask<S>) -> Mask<S> {
        Mask { values: self.simd.or_m32s(self.values, other.values), ..self }
    }

    /// Returns `then` where the condition holds.
    #[inline(always)]
    pub fn select(self, then: Lanes<S>, otherwise: Lanes<S>) -> Lanes<S> {
        let values = self.simd.select_f32s(self.values, then.values, otherwise.values);
        Lanes { values, ..then }
    }

    #[inline(always)]
    pub fn any(self) -> bool {
        self.simd.first_true_m32s(self.values) < S::F32_LANES
    }
}
