//! Loops over lanes: the same few lines for every operation, compiled separately for each so that
//! they are vectorised.

use super::super::code::LANES;

#[inline(never)]
pub(super) fn map1<T: Copy, U>(to: &mut [U; LANES], a: &[T; LANES], f: impl Fn(T) -> U) {
    for lane in 0..LANES {
        to[lane] = f(a[lane]);
    }
}

#[inline(never)]
pub(super) fn map2<S: Copy, T: Copy, U>(
    to: &mut [U; LANES],
    a: &[S; LANES],
    b: &[T; LANES],
    f: impl Fn(S, T) -> U,
) {
    for lane in 0..LANES {
        to[lane] = f(a[lane], b[lane]);
    }
}

#[inline(never)]
pub(super) fn map3<S: Copy, T: Copy, U>(
    to: &mut [U; LANES],
    a: &[S; LANES],
    b: &[T; LANES],
    c: &[T; LANES],
    f: impl Fn(S, T, T) -> U,
) {
    for lane in 0..LANES {
        to[lane] = f(a[lane], b[lane], c[lane]);
    }
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

/// Copies the lanes of a mask of all-ones words.
#[inline(never)]
pub(super) fn blend<T: Copy>(to: &mut [T; LANES], from: &[T; LANES], mask: &[u32; LANES]) {
    for lane in 0..LANES {
        to[lane] = if mask[lane] != 0 { from[lane] } else { to[lane] };
    }
}
