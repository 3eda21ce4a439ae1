//! The filters of FLIP: blur, and detection of edges and points.
//!
//! All filters are separable sums of Gaussians and repeat the border outwards. Used by
//! [`flip`](super::flip).

use std::f64::consts::PI;

/// A plane with one number per pixel.
pub struct Plane {
    /// The width in pixels.
    pub width: usize,
    /// The height in pixels.
    pub height: usize,
    /// The values from the top left.
    pub values: Vec<f32>,
}

/// A contrast sensitivity, as the sum of `a sqrt(pi / b) exp(-pi² x² / b)`, x in degrees.
pub type Sensitivity = [[f64; 2]];

pub const ACHROMATIC: [[f64; 2]; 1] = [[1.0, 0.0047]];
pub const RED_GREEN: [[f64; 2]; 1] = [[1.0, 0.0053]];
pub const BLUE_YELLOW: [[f64; 2]; 2] = [[34.1, 0.04], [13.5, 0.025]];

/// The widest of them: all are cut off at three times its standard deviation.
const WIDEST: f64 = 0.04;
/// The width in degrees of the detected edges and points (the paper's w).
const FEATURE_WIDTH: f64 = 0.082;

/// Returns a plane as perceived at this distance.
pub fn blur(plane: &Plane, sensitivity: &Sensitivity, per_degree: f64) -> Vec<f32> {
    let radius = (3.0 * (WIDEST / (2.0 * PI * PI)).sqrt() * per_degree).ceil() as usize;
    let terms: Vec<(f64, Vec<f64>)> = sensitivity
        .iter()
        .map(|[a, b]| {
            let at = |i: f64| (-PI * PI * (i / per_degree).powi(2) / b).exp();
            (a * (PI / b).sqrt(), taps(radius, at))
        })
        .collect();
    // The taps of all terms add up to 1 in both directions together.
    let total: f64 = terms.iter().map(|(by, taps)| by * taps.iter().sum::<f64>().powi(2)).sum();
    let mut sum = vec![0f32; plane.values.len()];
    for (by, taps) in &terms {
        let down: Vec<f64> = taps.iter().map(|tap| tap * by / total).collect();
        let across = Plane { values: rows(plane, taps), ..*plane };
        for (sum, value) in sum.iter_mut().zip(columns(&across, &down)) {
            *sum += value;
        }
    }
    sum
}

/// Returns the strength of edge and point at each pixel of a luminance (Y of YCxCz).
pub fn features(luminance: &Plane, per_degree: f64) -> Vec<[f32; 2]> {
    let deviation = 0.5 * FEATURE_WIDTH * per_degree;
    let radius = (3.0 * deviation).ceil() as usize;
    let bell = |i: f64| (-i * i / (2.0 * deviation * deviation)).exp();
    let smooth = balanced(taps(radius, bell));
    // An edge is the first derivative of a Gaussian, and a point the second.
    let edge = balanced(taps(radius, |i| -i * bell(i)));
    let point = balanced(taps(radius, |i| (i * i / (deviation * deviation) - 1.0) * bell(i)));
    let plane = Plane {
        values: luminance.values.iter().map(|y| (y + 16.0) / 116.0).collect(),
        ..*luminance
    };
    let smooth_rows = Plane { values: rows(&plane, &smooth), ..plane };
    let strength = |taps: &[f64]| -> Vec<f32> {
        let across = columns(&Plane { values: rows(&plane, taps), ..plane }, &smooth);
        let down = columns(&smooth_rows, taps);
        across.iter().zip(&down).map(|(x, y)| x.hypot(*y)).collect()
    };
    strength(&edge).into_iter().zip(strength(&point)).map(<[f32; 2]>::from).collect()
}

/// Returns the values of a filter from `-radius` to `radius`.
fn taps(radius: usize, at: impl Fn(f64) -> f64) -> Vec<f64> {
    (0..=2 * radius).map(|i| at(i as f64 - radius as f64)).collect()
}

/// Scales positive values to a sum of 1 and negative ones to −1.
fn balanced(taps: Vec<f64>) -> Vec<f64> {
    let positive: f64 = taps.iter().filter(|tap| **tap > 0.0).sum();
    let negative: f64 = -taps.iter().filter(|tap| **tap < 0.0).sum::<f64>();
    let scaled = |tap: f64| match tap {
        tap if tap > 0.0 => tap / positive,
        tap if tap < 0.0 => tap / negative,
        tap => tap,
    };
    taps.into_iter().map(scaled).collect()
}

fn rows(plane: &Plane, taps: &[f64]) -> Vec<f32> {
    let (width, radius) = (plane.width, taps.len() / 2);
    let mut padded = vec![0f32; width + 2 * radius];
    let mut filtered = Vec::with_capacity(plane.values.len());
    for row in plane.values.chunks_exact(width) {
        padded[..radius].fill(row[0]);
        padded[radius..radius + width].copy_from_slice(row);
        padded[radius + width..].fill(row[width - 1]);
        filtered.extend(padded.windows(taps.len()).map(|seen| {
            seen.iter().zip(taps).map(|(value, tap)| f64::from(*value) * tap).sum::<f64>() as f32
        }));
    }
    filtered
}

/// Filters along each column, row by row in memory order.
fn columns(plane: &Plane, taps: &[f64]) -> Vec<f32> {
    let (width, height, radius) = (plane.width, plane.height, taps.len() / 2);
    let mut sums = vec![0f64; width];
    let mut filtered = Vec::with_capacity(plane.values.len());
    for y in 0..height {
        // By rows, since a column steps through memory by a whole row.
        sums.fill(0.0);
        for (i, tap) in taps.iter().enumerate() {
            let from = (y + i).saturating_sub(radius).min(height - 1) * width;
            for (sum, value) in sums.iter_mut().zip(&plane.values[from..from + width]) {
                *sum += f64::from(*value) * tap;
            }
        }
        filtered.extend(sums.iter().map(|sum| *sum as f32));
    }
    filtered
}
