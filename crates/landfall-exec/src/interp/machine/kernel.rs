//! Loops over lanes: the same few lines for every operation, compiled separately for each so that
//! they are vectorised, in the widest registers that the processor has.

use pulp::{Arch, NullaryFnOnce};

use super::super::code::LANES;
use super::super::real::Real;
use super::{Column, column, take};

macro_rules! kernels {
    ($($name:ident $work:ident, $($a:ident: $t:ident),+;)*) => {$(
        struct $work<'c, $($t,)+ U, F> {
            to: &'c mut [U; LANES],
            from: ($(&'c [$t; LANES],)+),
            f: F,
        }

        impl<$($t: Copy,)+ U, F: Fn($($t),+) -> U> NullaryFnOnce for $work<'_, $($t,)+ U, F> {
            type Output = ();

            #[inline(always)]
            fn call(self) {
                let ($($a,)+) = self.from;
                for lane in 0..LANES {
                    self.to[lane] = (self.f)($($a[lane]),+);
                }
            }
        }

        #[inline(never)]
        #[allow(clippy::too_many_arguments, reason = "six columns are the factors of three products")]
        pub(super) fn $name<$($t: Copy,)+ U>(
            arch: Arch,
            to: &mut [U; LANES],
            $($a: &[$t; LANES],)+
            f: impl Fn($($t),+) -> U,
        ) {
            arch.dispatch($work { to, from: ($($a,)+), f });
        }
    )*};
}

kernels! {
    map1 Map1, a: A;
    map2 Map2, a: A, b: B;
    map3 Map3, a: A, b: B, c: C;
    map4 Map4, a: A, b: B, c: C, d: D;
    map6 Map6, a: A, b: B, c: C, d: D, e: E, g: G;
}

macro_rules! group_kernels {
    ($($name:ident $work:ident $size:literal, $($a:ident $at:literal),+;)*) => {$(
        struct $work<'c, R, F> {
            file: &'c mut [Option<Column<R>>],
            operands: &'c [u32],
            f: F,
        }

        impl<R: Real, F: Fn($(group_kernels!(@real $a)),+) -> R> NullaryFnOnce for $work<'_, R, F> {
            type Output = ();

            #[inline(always)]
            fn call(self) {
                for group in self.operands.chunks_exact($size) {
                    let mut to = take(self.file, group[0]);
                    $(let $a = column(self.file, group[$at]);)+
                    for lane in 0..LANES {
                        to[lane] = (self.f)($($a[lane]),+);
                    }
                    self.file[group[0] as usize] = Some(to);
                }
            }
        }

        /// Computes every group of operands, a result and its arguments.
        #[inline(never)]
        pub(super) fn $name<R: Real>(
            arch: Arch,
            file: &mut [Option<Column<R>>],
            operands: &[u32],
            f: impl Fn($(group_kernels!(@real $a)),+) -> R,
        ) {
            arch.dispatch($work { file, operands, f });
        }
    )*};
    (@real $a:ident) => { R };
}

group_kernels! {
    groups1 Groups1 2, a 1;
    groups2 Groups2 3, a 1, b 2;
    groups3 Groups3 4, a 1, b 2, c 3;
}

/// Runs an expensive operation once if all lanes agree, else for the active lanes.
pub(super) fn dear<T: Copy, U: Copy>(
    to: &mut [U; LANES],
    active: u64,
    agree: bool,
    arguments: impl Fn(usize) -> T,
    f: impl Fn(T) -> U,
) {
    if active == 0 {
        return;
    }
    if agree {
        *to = [f(arguments(active.trailing_zeros() as usize)); LANES];
    } else if active == u64::MAX {
        for (lane, to) in to.iter_mut().enumerate() {
            *to = f(arguments(lane));
        }
    } else {
        let mut rest = active;
        while rest != 0 {
            let lane = rest.trailing_zeros() as usize;
            to[lane] = f(arguments(lane));
            rest &= rest - 1;
        }
    }
}

/// Fills all lanes.
#[inline(never)]
pub(super) fn fill<T: Copy>(arch: Arch, to: &mut [T; LANES], value: T) {
    arch.dispatch(Fill { to, value });
}

struct Fill<'c, T> {
    to: &'c mut [T; LANES],
    value: T,
}

impl<T: Copy> NullaryFnOnce for Fill<'_, T> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for to in self.to.iter_mut() {
            *to = self.value;
        }
    }
}

/// Writes the channels of texels each to its own lanes.
#[inline(never)]
pub(super) fn split<R: Real>(arch: Arch, to: [&mut [R; LANES]; 4], texels: &[[f32; 4]; LANES]) {
    arch.dispatch(Split { to, texels });
}

struct Split<'c, R> {
    to: [&'c mut [R; LANES]; 4],
    texels: &'c [[f32; 4]; LANES],
}

impl<R: Real> NullaryFnOnce for Split<'_, R> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Split { to: [r, g, b, a], texels } = self;
        for lane in 0..LANES {
            r[lane] = R::narrow(texels[lane][0]);
            g[lane] = R::narrow(texels[lane][1]);
            b[lane] = R::narrow(texels[lane][2]);
            a[lane] = R::narrow(texels[lane][3]);
        }
    }
}

/// Copies the lanes of a mask of all-ones words.
#[inline(never)]
pub(super) fn blend<T: Copy>(
    arch: Arch,
    to: &mut [T; LANES],
    from: &[T; LANES],
    mask: &[u32; LANES],
) {
    arch.dispatch(Blend { to, from, mask });
}

struct Blend<'c, T> {
    to: &'c mut [T; LANES],
    from: &'c [T; LANES],
    mask: &'c [u32; LANES],
}

impl<T: Copy> NullaryFnOnce for Blend<'_, T> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for lane in 0..LANES {
            self.to[lane] = if self.mask[lane] != 0 { self.from[lane] } else { self.to[lane] };
        }
    }
}
