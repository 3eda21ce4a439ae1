//! A scale of colours from dark to light: more is lighter, for every eye and in print.
//!
//! For the maps of [`difference`](super::difference) and of [`accuracy`](crate::accuracy).

/// sRGB codes at equal distances, ever lighter: the course of matplotlib's `magma`.
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

/// The sRGB codes of a part of the scale; what is outside 0 to 1 has the colour of the end,
/// NaN that of 0.
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
