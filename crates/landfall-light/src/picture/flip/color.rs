//! The colour spaces of FLIP: sRGB codes, XYZ, the linear opponent space YCxCz, CIE L*a*b*.
//!
//! Used by [`flip`](super::flip) for opponent colours before the blur and distances after it.

use std::sync::LazyLock;

use crate::picture::Transfer;

/// Linear sRGB to XYZ, from the primaries and D65 white of BT.709 as exact fractions.
const XYZ: [[f64; 3]; 3] = [
    [10_135_552.0 / 24_577_794.0, 8_788_810.0 / 24_577_794.0, 4_435_075.0 / 24_577_794.0],
    [2_613_072.0 / 12_288_897.0, 8_788_810.0 / 12_288_897.0, 887_015.0 / 12_288_897.0],
    [1_425_312.0 / 73_733_382.0, 8_788_810.0 / 73_733_382.0, 70_074_185.0 / 73_733_382.0],
];

/// The exponent, knee and height of the knee of the colour difference (q_c, p_c, p_t).
const EXPONENT: f64 = 0.7;
const KNEE: f64 = 0.4;
const KNEE_HEIGHT: f64 = 0.95;

/// Converts codes to YCxCz.
pub fn opponent(pixels: &[[u8; 4]]) -> Vec<[f32; 3]> {
    let linear: Vec<f64> =
        (0..=255u8).map(|code| Transfer::Srgb.decode(f64::from(code) / 255.0)).collect();
    pixels
        .iter()
        .map(|&[r, g, b, _]| {
            let [x, y, z] = relative([r, g, b].map(|code| linear[usize::from(code)]));
            [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)].map(|value| value as f32)
        })
        .collect()
}

/// Converts a blurred YCxCz to L*, a*, b*: clamped to the screen's gamut, then a* and b* scaled by
/// lightness (Hunt).
pub fn adjusted([y, cx, cz]: [f64; 3]) -> [f64; 3] {
    let y = (y + 16.0) / 116.0;
    let white = white();
    let xyz = [(y + cx / 500.0) * white[0], y * white[1], (y - cz / 200.0) * white[2]];
    lab(times(&INVERSE, xyz).map(|value| value.clamp(0.0, 1.0)))
}

/// Returns the distance of two adjusted colours: of lightness plus of hue and chroma (HyAB).
pub fn distance(a: [f32; 3], b: [f32; 3]) -> f64 {
    let [l, a, b] = [0, 1, 2].map(|i| f64::from(a[i]) - f64::from(b[i]));
    l.abs() + a.hypot(b)
}

/// The map from distances to colour differences: 0 to 1, small ones stretched.
pub struct Redistribution {
    /// The largest possible distance, between green and blue.
    most: f64,
}

impl Redistribution {
    pub fn new() -> Redistribution {
        let [green, blue] =
            [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|rgb| lab(rgb).map(|value| value as f32));
        Redistribution { most: distance(green, blue).powf(EXPONENT) }
    }

    pub fn value_at(&self, distance: f64) -> f64 {
        // Linear up to a knee at 0.95, then flatter.
        let difference = distance.powf(EXPONENT);
        let knee = KNEE * self.most;
        match difference < knee {
            true => KNEE_HEIGHT / knee * difference,
            false => KNEE_HEIGHT + (difference - knee) / (self.most - knee) * (1.0 - KNEE_HEIGHT),
        }
    }
}

/// Returns the adjusted L*, a*, b* of linear sRGB.
fn lab(rgb: [f64; 3]) -> [f64; 3] {
    const DELTA: f64 = 6.0 / 29.0;
    let [x, y, z] = relative(rgb).map(|t| match t > DELTA * DELTA * DELTA {
        true => t.cbrt(),
        false => t / (3.0 * DELTA * DELTA) + 4.0 / 29.0,
    });
    let lightness = 116.0 * y - 16.0;
    let bright = 0.01 * lightness;
    [lightness, bright * 500.0 * (x - y), bright * 200.0 * (y - z)]
}

/// Returns XYZ relative to white.
fn relative(rgb: [f64; 3]) -> [f64; 3] {
    let (xyz, white) = (times(&XYZ, rgb), white());
    [0, 1, 2].map(|i| xyz[i] / white[i])
}

fn white() -> [f64; 3] {
    XYZ.map(|row| row.iter().sum())
}

fn times(matrix: &[[f64; 3]; 3], by: [f64; 3]) -> [f64; 3] {
    matrix.map(|row| row[0] * by[0] + row[1] * by[1] + row[2] * by[2])
}

/// XYZ to linear sRGB.
/// By cofactors, so that the inverse is that of the exact fractions above and not of rounded
/// digits.
static INVERSE: LazyLock<[[f64; 3]; 3]> = LazyLock::new(|| {
    let minor = |r: usize, c: usize| {
        let [r1, r2] = [(r + 1) % 3, (r + 2) % 3];
        let [c1, c2] = [(c + 1) % 3, (c + 2) % 3];
        XYZ[r1][c1] * XYZ[r2][c2] - XYZ[r1][c2] * XYZ[r2][c1]
    };
    let determinant: f64 = (0..3).map(|c| XYZ[0][c] * minor(0, c)).sum();
    [0, 1, 2].map(|r| [0, 1, 2].map(|c| minor(c, r) / determinant))
});
