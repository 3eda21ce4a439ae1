//! FLIP: how visible the difference of two pictures is when one flips between them.
//!
//! LDR-FLIP of Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström and Fairchild, "FLIP: A
//! Difference Evaluator for Alternating Images" (HPG 2020), computed here from its formulas.
//! `color` has its spaces and the distance of colours, `filter` what the eye blurs and the
//! edges and points it sees. Given the codes a screen gets; [`compare`](mod@super::compare) reports
//! its mean and maximum, [`difference`](super::difference) draws it.

mod color;
mod filter;

use super::code::Codes;
use super::error::PictureError;
use filter::{Plane, features};

/// Pixels a degree of the eye: a 0.7 m wide screen of 3840 pixels seen from 0.7 m.
pub const PIXELS_PER_DEGREE: f64 = 67.0;

/// Exponent of the feature difference (the paper's q_f).
const FEATURE_EXPONENT: f64 = 0.5;

/// How visible the difference is, pixel by pixel: 0 not at all, 1 most.
#[derive(Clone, Debug, PartialEq)]
pub struct FlipMap {
    /// Pixels in a row.
    pub width: u32,
    /// Rows, from the top.
    pub height: u32,
    /// 0 to 1, from the top left.
    pub errors: Vec<f32>,
}

/// The map of two pictures as a screen shows them: codes are taken as sRGB and alpha is ignored.
///
/// # Errors
/// The sizes differ, or a picture is not whole.
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
    let [a, b] = [reference, test].map(|codes| seen(codes, per_degree));
    let redistribute = color::Redistribution::new();
    let errors = (0..wanted)
        .map(|i| {
            let color = redistribute.of(color::distance(a.lab[i], b.lab[i]));
            let edge = (a.features[i][0] - b.features[i][0]).abs();
            let point = (a.features[i][1] - b.features[i][1]).abs();
            let feature = f64::from(edge.max(point)) * std::f64::consts::FRAC_1_SQRT_2;
            color.powf(1.0 - feature.powf(FEATURE_EXPONENT)) as f32
        })
        .collect();
    Ok(FlipMap { width, height, errors })
}

/// What is seen of one picture.
struct Seen {
    /// L*, a*, b* after the eye's blur, a* and b* adjusted for how bright they are (Hunt).
    lab: Vec<[f32; 3]>,
    /// How much of an edge and of a point there is.
    features: Vec<[f32; 2]>,
}

fn seen(codes: &Codes, per_degree: f64) -> Seen {
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
    Seen { lab, features }
}
