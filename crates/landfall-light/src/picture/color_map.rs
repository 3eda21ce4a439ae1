//! A scale of colours of increasing lightness, readable with any colour vision and in print.
//!
//! Used by the maps of [`difference`](super::difference) and of `landfall-accuracy`.

/// sRGB codes at equal distances, in increasing lightness, after matplotlib's `magma`.
const STOPS: [[u8; 3]; 9] = [
    [0, 0, 4],
    [28, 16, 68],
    [79, 18, 123],
    [129, 37, 129],
    [181, 54, 122],
    [229, 80, 100],
    [251, 135, 97],
    [254, 194, 135],
    [252, 253, 191],
];

/// Returns the sRGB codes at a position from 0 to 1; clamped to the ends, NaN to 0.
pub fn color(part: f64) -> [u8; 3] {
    let part = if part.is_nan() { 0.0 } else { part.clamp(0.0, 1.0) };
    let at = part * (STOPS.len() - 1) as f64;
    let stop = (at as usize).min(STOPS.len() - 2);
    let share = at - stop as f64;
    std::array::from_fn(|i| {
        let [from, to] = [STOPS[stop][i], STOPS[stop + 1][i]].map(f64::from);
        (from + share * (to - from)).round() as u8
    })
}
