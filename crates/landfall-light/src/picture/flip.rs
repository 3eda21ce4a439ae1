//! FLIP: the visibility of the difference between two alternating pictures.
//!
//! LDR-FLIP of Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström and Fairchild, "FLIP: A
//! Difference Evaluator for Alternating Images" (HPG 2020), implemented from its formulas. `color`
//! holds its colour spaces and distance, `filter` the blur and the detection of edges and points.
//! Takes 8-bit codes; [`compare`](mod@super::compare) reports its mean and maximum,
//! [`difference`](super::difference) draws it.

mod color;
mod filter;

use super::code::Codes;
use super::error::PictureError;
use filter::{Plane, features};

/// Pixels per degree of vision: a 0.7 m wide screen of 3840 pixels at 0.7 m.
pub const PIXELS_PER_DEGREE: f64 = 67.0;

/// The exponent of the feature difference (the paper's q_f).
const FEATURE_EXPONENT: f64 = 0.5;

/// The visibility of the difference at each pixel, from 0 to 1.
#[derive(Clone, Debug, PartialEq)]
pub struct FlipMap {
    /// The width in pixels.
    pub width: u32,
    /// The height in pixels.
    pub height: u32,
    /// The values from 0 to 1, from the top left.
    pub errors: Vec<f32>,
}

/// Returns the map of two pictures; codes are taken as sRGB and alpha is ignored.
///
/// # Errors
/// Different sizes, or an incomplete picture.
pub fn flip(reference: &Codes, test: &Codes, per_degree: f64) -> Result<FlipMap, PictureError> {
    let Codes { width, height, .. } = *reference;
    if (width, height) != (test.width, test.height) {
        let (a, b) = ([width, height], [test.width, test.height]);
        return Err(PictureError::SizesDiffer { a, b });
    }
    let wanted = super::size(width, height)?;
    for codes in [reference, test] {
        if codes.pixels.len() != wanted {
            let (wanted, given) = (wanted as u64, codes.pixels.len() as u64);
            return Err(PictureError::WrongCount { wanted, given });
        }
    }
    let [a, b] = [reference, test].map(|codes| perceived(codes, per_degree));
    let redistribute = color::Redistribution::new();
    let errors = (0..wanted)
        .map(|i| {
            let color = redistribute.value_at(color::distance(a.lab[i], b.lab[i]));
            let edge = (a.features[i][0] - b.features[i][0]).abs();
            let point = (a.features[i][1] - b.features[i][1]).abs();
            // Features that differ raise the error: their strength lowers the exponent of the
            // colour difference, which stays as it is without them.
            let feature = f64::from(edge.max(point)) * std::f64::consts::FRAC_1_SQRT_2;
            color.powf(1.0 - feature.powf(FEATURE_EXPONENT)) as f32
        })
        .collect();
    Ok(FlipMap { width, height, errors })
}

struct PerceivedImage {
    /// L*, a*, b* after blurring, a* and b* adjusted for lightness (Hunt).
    lab: Vec<[f32; 3]>,
    features: Vec<[f32; 2]>,
}

fn perceived(codes: &Codes, per_degree: f64) -> PerceivedImage {
    let (width, height) = (codes.width as usize, codes.height as usize);
    let opponent = color::opponent(&codes.pixels);
    let plane =
        |i: usize| Plane { width, height, values: opponent.iter().map(|color| color[i]).collect() };
    let luminance = plane(0);
    let features = features(&luminance, per_degree);
    let blurred = [
        filter::blur(&luminance, &filter::ACHROMATIC, per_degree),
        filter::blur(&plane(1), &filter::RED_GREEN, per_degree),
        filter::blur(&plane(2), &filter::BLUE_YELLOW, per_degree),
    ];
    let lab = (0..codes.pixels.len())
        .map(|i| color::adjusted([0, 1, 2].map(|c| f64::from(blurred[c][i]))).map(|v| v as f32))
        .collect();
    PerceivedImage { lab, features }
}
