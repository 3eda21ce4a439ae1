//! Loops over lanes: the same few lines for every operation, compiled separately for each so that
//! they are vectorised, in the widest registers that the processor has.

use pulp::{Arch, NullaryFnOnce};

use super::super::code::LANES;
use super::super::lanes::Lanes;
use super::super::real::Real;
use super::{Column, column, take};

macro_rules! kernels {
    ($($name:ident $work:ident, $($a:ident: $t:ident),+;)*) => {$(
        struct $work<'c, $($t,)+ U, F> {
            to: &'c mut U,
            from: ($(&'c $t,)+),
            f: F,
        }

        impl<$($t: Lanes,)+ U: Lanes, F: Fn($($t::Item),+) -> U::Item> NullaryFnOnce
            for $work<'_, $($t,)+ U, F>
        {
            type Output = ();

            #[inline(always)]
            fn call(self) {
                let ($($a,)+) = self.from;
                self.to.set(|lane| (self.f)($($a.lane(lane)),+));
            }
        }

        #[inline(never)]
        #[allow(clippy::too_many_arguments, reason = "six columns are the factors of three products")]
        pub(super) fn $name<$($t: Lanes,)+ U: Lanes>(
            arch: Arch,
            to: &mut U,
            $($a: &$t,)+
            f: impl Fn($($t::Item),+) -> U::Item,
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
        struct $work<'c, R: Real, F> {
            file: &'c mut [Option<Column<R::Lanes>>],
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
                    to.set(|lane| (self.f)($($a.lane(lane)),+));
                    self.file[group[0] as usize] = Some(to);
                }
            }
        }

        /// Computes every group of operands, a result and its arguments.
        #[inline(never)]
        pub(super) fn $name<R: Real>(
            arch: Arch,
            file: &mut [Option<Column<R::Lanes>>],
            operands: &[u32],
            f: impl Fn($(group_kernels!(@real $a)),+) -> R,
        ) {
            arch.dispatch($work::<R, _> { file, operands, f });
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
pub(super) fn dear<T: Copy, U: Lanes>(
    to: &mut U,
    active: u64,
    agree: bool,
    arguments: impl Fn(usize) -> T,
    f: impl Fn(T) -> U::Item,
) {
    if active == 0 {
        return;
    }
    if agree {
        *to = U::filled(f(arguments(active.trailing_zeros() as usize)));
    } else if active == u64::MAX {
        for lane in 0..LANES {
            to.put(lane, f(arguments(lane)));
        }
    } else {
        let mut rest = active;
        while rest != 0 {
            let lane = rest.trailing_zeros() as usize;
            to.put(lane, f(arguments(lane)));
            rest &= rest - 1;
        }
    }
}

/// Fills all lanes.
#[inline(never)]
pub(super) fn fill<L: Lanes>(arch: Arch, to: &mut L, value: L::Item) {
    arch.dispatch(Fill { to, value });
}

struct Fill<'c, L: Lanes> {
    to: &'c mut L,
    value: L::Item,
}

impl<L: Lanes> NullaryFnOnce for Fill<'_, L> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        self.to.set(|_| self.value);
    }
}

/// Writes the channels of texels each to its own lanes.
#[inline(never)]
pub(super) fn split<R: Real>(arch: Arch, to: [&mut R::Lanes; 4], texels: &[[f32; 4]; LANES]) {
    arch.dispatch(Split::<R> { to, texels });
}

struct Split<'c, R: Real> {
    to: [&'c mut R::Lanes; 4],
    texels: &'c [[f32; 4]; LANES],
}

impl<R: Real> NullaryFnOnce for Split<'_, R> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Split { to: [r, g, b, a], texels } = self;
        for (lane, texel) in texels.iter().enumerate() {
            r.put(lane, R::narrow(texel[0]));
            g.put(lane, R::narrow(texel[1]));
            b.put(lane, R::narrow(texel[2]));
            a.put(lane, R::narrow(texel[3]));
        }
    }
}

/// Copies the lanes of a mask of all-ones words.
#[inline(never)]
pub(super) fn blend<L: Lanes>(arch: Arch, to: &mut L, from: &L, mask: &[u32; LANES]) {
    arch.dispatch(Blend { to, from, mask });
}

struct Blend<'c, L> {
    to: &'c mut L,
    from: &'c L,
    mask: &'c [u32; LANES],
}

impl<L: Lanes> NullaryFnOnce for Blend<'_, L> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        self.to.blend(self.from, self.mask);
    }
}
