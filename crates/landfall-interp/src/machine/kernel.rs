//! Loops over lanes: the same few lines for every operation, compiled separately for each so that
//! they are vectorised, in the registers of the function that they are inlined into.

use super::super::code::LANES;
use super::super::lanes::{Lanes, lane_numbers};
use super::super::real::Real;
use super::{Aligned, apart};

macro_rules! kernels {
    ($($name:ident $($a:ident: $t:ident),+;)*) => {$(
        #[inline(always)]
        #[allow(clippy::too_many_arguments, reason = "six columns are the factors of three products")]
        pub(super) fn $name<$($t: Lanes,)+ U: Lanes>(
            to: &mut U,
            $($a: &$t,)+
            f: impl Fn($($t::Item),+) -> U::Item,
        ) {
            to.set(|lane| f($($a.lane(lane)),+));
        }
    )*};
}

kernels! {
    map1 a: A;
    map2 a: A, b: B;
    map3 a: A, b: B, c: C;
    map4 a: A, b: B, c: C, d: D;
    map6 a: A, b: B, c: C, d: D, e: E, g: G;
}

macro_rules! group_kernels {
    ($($name:ident $size:literal, $($a:ident $at:literal),+;)*) => {$(
        /// Computes every group of operands, a result and its arguments.
        #[inline(always)]
        pub(super) fn $name<R: Real>(
            file: &mut [Aligned<R::Lanes>],
            operands: &[u32],
            f: impl Fn($(group_kernels!(@real $a)),+) -> R,
        ) {
            for group in operands.chunks_exact($size) {
                let (to, others) = apart(file, group[0]);
                $(let $a = others.column(group[$at]);)+
                to.set(|lane| f($($a.lane(lane)),+));
            }
        }
    )*};
    (@real $a:ident) => { R };
}

group_kernels! {
    groups1 2, a 1;
    groups2 3, a 1, b 2;
    groups3 4, a 1, b 2, c 3;
}

/// Runs an expensive operation once if all lanes agree, else for the active lanes.
pub(super) fn once_if_uniform<T: Copy, U: Lanes>(
    to: &mut U,
    active: u64,
    agree: bool,
    arguments: impl Fn(usize) -> T,
    f: impl Fn(T) -> U::Item,
) {
    if active == 0 {
        return;
    }
    // Any active lane stands for all.
    if agree {
        *to = U::filled(f(arguments(active.trailing_zeros() as usize)));
    } else if active == u64::MAX {
        for lane in 0..LANES {
            to.put(lane, f(arguments(lane)));
        }
    } else {
        for lane in lane_numbers(active) {
            to.put(lane, f(arguments(lane)));
        }
    }
}

/// Fills all lanes.
#[inline(always)]
pub(super) fn fill<L: Lanes>(to: &mut L, value: L::Item) {
    to.set(|_| value);
}

/// Writes the channels of texels each to its own lanes.
#[inline(always)]
pub(super) fn split<R: Real>(to: &mut [R::Lanes; 4], texels: &[[f32; 4]; LANES]) {
    let [r, g, b, a] = to;
    for (lane, texel) in texels.iter().enumerate() {
        r.put(lane, R::narrow(texel[0]));
        g.put(lane, R::narrow(texel[1]));
        b.put(lane, R::narrow(texel[2]));
        a.put(lane, R::narrow(texel[3]));
    }
}
