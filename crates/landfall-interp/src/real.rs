//! The precisions in which a shader's floats can be computed.
//!
//! The [`machine`](super::machine) is generic over them: `f32` as on a device, rounded at each
//! operation; `f64` as the reference; [`Shadow`](super::shadow::Shadow) as both;
//! [`Permitted`](super::permitted::Permitted) with the results of all conformant devices.

use pulp::Arch;

use super::code::{Cmp, LANES, RealBinary, RealUnary};
use super::elementary::{function1, function2};
use super::lanes::Lanes;
use landfall_layout::source::Language;

/// Work on columns in any precision: a result and so many operands.
pub(super) trait ColumnWork<const N: usize> {
    fn run<R: Real>(&self, to: &mut R::Lanes, from: [&R::Lanes; N]);
}

/// A number that represents a shader's `f32`.
pub(super) trait Real: Copy + Default + Send + Sync + std::fmt::Debug + 'static {
    /// Whether it holds the values that other devices may have.
    const PERMITTED: bool = false;
    /// Whether it holds more than one value, so that comparisons of them may differ.
    const MANY: bool = Self::PERMITTED;
    /// The numbers of all lanes.
    type Lanes: Lanes<Item = Self>;
    /// Converts a shader's value exactly.
    fn narrow(x: f32) -> Self;
    /// Converts a number with more digits than an `f32`.
    fn wide(x: f64) -> Self;
    /// Returns the nearest `f32`.
    fn single(self) -> f32;
    /// Returns the most precise value.
    fn double(self) -> f64;
    /// Returns the value that branches follow, which decides whether an operation is defined.
    fn followed(self) -> f64 {
        self.double()
    }
    /// Applies an operation, rounded once for an `f32`.
    fn lift1(self, f: impl Fn(f64) -> f64) -> Self;
    /// Applies an operation of two operands, rounded once for an `f32`.
    fn lift2(self, b: Self, f: impl Fn(f64, f64) -> f64) -> Self;
    fn add(self, b: Self) -> Self;
    fn sub(self, b: Self) -> Self;
    fn mul(self, b: Self) -> Self;
    fn div(self, b: Self) -> Self;
    fn rem(self, b: Self) -> Self;
    fn neg(self) -> Self;
    fn abs(self) -> Self;
    fn sqrt(self) -> Self;
    fn fma(self, b: Self, c: Self) -> Self;
    fn floor(self) -> Self;
    fn ceil(self) -> Self;
    fn trunc(self) -> Self;
    fn round(self) -> Self;
    /// Returns `b` if it is smaller, else `self`: GLSL 4.60 §8.3.
    fn min(self, b: Self) -> Self;
    /// Returns `b` if it is larger, else `self`.
    fn max(self, b: Self) -> Self;
    /// Returns the number to convert to an integer, which comparisons use too.
    fn whole(self) -> f64;
    /// Converts a 64-bit integer, rounded once.
    fn sint(x: i64) -> Self;
    fn uint(x: u64) -> Self;
    /// The type that comparisons use.
    type By: Copy + PartialOrd;
    fn by(self) -> Self::By;
    fn is_infinite(self) -> bool;
    /// Returns whether all bits are equal.
    fn same(self, b: Self) -> bool;
    /// Rounds an `f32` to an `f16`.
    fn half(self) -> Self;
    /// Applies a named function, which has an accuracy of its own.
    #[inline(always)]
    fn function1(self, _: RealUnary, exact: impl Fn(f64) -> f64) -> Self {
        self.lift1(exact)
    }
    /// Applies a named function of two operands.
    #[inline(always)]
    fn function2(self, _: RealBinary, b: Self, exact: impl Fn(f64, f64) -> f64) -> Self {
        self.lift2(b, exact)
    }
    /// Computes a named function in many lanes at once; returns the lanes it leaves to
    /// [`function1`](Real::function1).
    #[inline(always)]
    fn column1(_: Arch, _: RealUnary, _to: &mut Self::Lanes, _: &Self::Lanes) -> u64 {
        u64::MAX
    }
    /// The same for two operands.
    #[inline(always)]
    fn column2(
        _: Arch,
        _: RealBinary,
        _to: &mut Self::Lanes,
        _: &Self::Lanes,
        _: &Self::Lanes,
    ) -> u64 {
        u64::MAX
    }
    /// Does work on columns of these numbers, on each of their parts if they are of several.
    fn on_parts<const N: usize>(
        to: &mut Self::Lanes,
        from: [&Self::Lanes; N],
        work: &impl ColumnWork<N>,
    ) {
        work.run::<Self>(to, from);
    }
    /// Returns the square.
    #[inline(always)]
    fn squared(self) -> Self {
        self.mul(self)
    }
    /// Returns the sum of one to four terms, in order or in any order.
    fn total(terms: &[Self]) -> Self {
        terms[1..].iter().fold(terms[0], |sum, term| sum.add(*term))
    }
    /// Returns a component divided by its vector's length, the root of the sum of squares, by the
    /// formula of a language.
    #[inline(always)]
    fn over_length(self, length: Self, _squares: Self, _: Language) -> Self {
        self.div(length)
    }
    /// Returns the least and greatest number a device may have in its place.
    fn span(self) -> Option<[f64; 2]> {
        None
    }
    /// Returns whether a comparison of the other values it holds may differ.
    fn unsure(self, _: Cmp, _: Self) -> bool {
        false
    }
    /// Returns whether devices may differ in the conversion to an integer.
    fn unsure_whole(self) -> bool {
        false
    }
}

macro_rules! plain {
    ($t:ty) => {
        type Lanes = [$t; LANES];
        type By = $t;
        #[inline(always)]
        fn whole(self) -> f64 {
            f64::from(self)
        }
        fn sint(x: i64) -> $t {
            x as $t
        }
        fn uint(x: u64) -> $t {
            x as $t
        }
        #[inline(always)]
        fn by(self) -> $t {
            self
        }
        fn is_infinite(self) -> bool {
            <$t>::is_infinite(self)
        }
        #[inline(always)]
        fn add(self, b: $t) -> $t {
            self + b
        }
        #[inline(always)]
        fn sub(self, b: $t) -> $t {
            self - b
        }
        #[inline(always)]
        fn mul(self, b: $t) -> $t {
            self * b
        }
        #[inline(always)]
        fn div(self, b: $t) -> $t {
            self / b
        }
        #[inline(always)]
        fn rem(self, b: $t) -> $t {
            // Truncated: the sign is that of the dividend.
            self % b
        }
        #[inline(always)]
        fn neg(self) -> $t {
            -self
        }
        #[inline(always)]
        fn abs(self) -> $t {
            <$t>::abs(self)
        }
        #[inline(always)]
        fn sqrt(self) -> $t {
            <$t>::sqrt(self)
        }
        #[inline(always)]
        fn fma(self, b: $t, c: $t) -> $t {
            // Rounded once; a device may round twice.
            self.mul_add(b, c)
        }
        #[inline(always)]
        fn floor(self) -> $t {
            <$t>::floor(self)
        }
        #[inline(always)]
        fn ceil(self) -> $t {
            <$t>::ceil(self)
        }
        #[inline(always)]
        fn trunc(self) -> $t {
            <$t>::trunc(self)
        }
        #[inline(always)]
        fn round(self) -> $t {
            // Ties to even by WGSL §17.5; GLSL leaves the direction open.
            self.round_ties_even()
        }
        #[inline(always)]
        fn min(self, b: $t) -> $t {
            // No comparison with NaN holds.
            if b < self { b } else { self }
        }
        #[inline(always)]
        fn max(self, b: $t) -> $t {
            if self < b { b } else { self }
        }
        #[inline(always)]
        fn same(self, b: $t) -> bool {
            self.to_bits() == b.to_bits()
        }
    };
}

impl Real for f32 {
    #[inline(always)]
    fn narrow(x: f32) -> f32 {
        x
    }
    #[inline(always)]
    fn wide(x: f64) -> f32 {
        x as f32
    }
    #[inline(always)]
    fn single(self) -> f32 {
        self
    }
    #[inline(always)]
    fn double(self) -> f64 {
        f64::from(self)
    }
    #[inline(always)]
    fn lift1(self, f: impl Fn(f64) -> f64) -> f32 {
        f(f64::from(self)) as f32
    }
    #[inline(always)]
    fn lift2(self, b: f32, f: impl Fn(f64, f64) -> f64) -> f32 {
        f(f64::from(self), f64::from(b)) as f32
    }
    fn half(self) -> f32 {
        half::f16::from_f32(self).to_f32()
    }
    fn column1(arch: Arch, f: RealUnary, to: &mut [f32; LANES], a: &[f32; LANES]) -> u64 {
        function1(arch, f, to, a)
    }
    fn column2(
        arch: Arch,
        f: RealBinary,
        to: &mut [f32; LANES],
        a: &[f32; LANES],
        b: &[f32; LANES],
    ) -> u64 {
        function2(arch, f, to, a, b)
    }
    plain!(f32);
}

impl Real for f64 {
    #[inline(always)]
    fn narrow(x: f32) -> f64 {
        f64::from(x)
    }
    #[inline(always)]
    fn wide(x: f64) -> f64 {
        x
    }
    #[inline(always)]
    fn single(self) -> f32 {
        self as f32
    }
    #[inline(always)]
    fn double(self) -> f64 {
        self
    }
    #[inline(always)]
    fn lift1(self, f: impl Fn(f64) -> f64) -> f64 {
        f(self)
    }
    #[inline(always)]
    fn lift2(self, b: f64, f: impl Fn(f64, f64) -> f64) -> f64 {
        f(self, b)
    }
    fn half(self) -> f64 {
        // The reference is not rounded.
        self
    }
    plain!(f64);
}
