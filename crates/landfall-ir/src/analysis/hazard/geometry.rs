//! Hazards of distances, attenuation and cones.

use landfall_layout::finding::Level;

use super::HazardInfo;
use super::threshold::{
    ATTENUATION, CONE_WIDTH, COORDINATE, COSINE, EDGE, HALF_DISTANCE, LENGTH, NARROW, ORIGIN,
};

pub(super) static LIGHT_AT_FRAGMENT: HazardInfo = HazardInfo {
    code: "light-at-fragment",
    name: "light at the fragment",
    label: Some("H1"),
    aliases: &[],
    level: Level::Deny,
    what: "the light is where the fragment is, and a vector of length zero is normalised",
    why: "`normalize(vec3(0))` is 0 / 0: three NaNs by the formula and on lavapipe. Where `max` \
          hides them the light is silently black.",
    threshold: Some(&LENGTH),
    robust: "guard it: `v * inversesqrt(max(dot(v, v), 1.0e-30))`",
    citation: "GLSL 4.60 8.5 (`normalize`); WGSL 17.5 (`normalize` of a zero vector is an error \
               or indeterminate)",
};

pub(super) static ATTENUATION_AT_LIGHT: HazardInfo = HazardInfo {
    code: "attenuation-at-light",
    name: "attenuation at the light",
    label: Some("H1b"),
    aliases: &[],
    level: Level::Deny,
    what: "without a constant term the attenuation divides by zero at the light",
    why: "1 / 0 is infinite, and infinity times a colour of 0 is NaN, even where `max` and `min` \
          hide NaNs.",
    threshold: Some(&ATTENUATION),
    robust: "keep the denominator away from zero: `1.0 / max(c + d * (l + q * d), 1.0e-4)`",
    citation: "Filament's documentation, 5.2.2: `1 / max(d^2, 1e-4)`; Lagarde and de Rousiers, \
               Moving Frostbite to PBR (2014), a lamp of 1 cm",
};

pub(super) static CAMERA_AT_FRAGMENT: HazardInfo = HazardInfo {
    code: "camera-at-fragment",
    name: "camera at the fragment",
    label: Some("H2"),
    aliases: &[],
    level: Level::Deny,
    what: "the eye is where the fragment is, and a vector of length zero is normalised",
    why: "`normalize(vec3(0))` is NaN by the formula: the highlight of the fragment is NaN, or \
          silently missing where `max` hides it.",
    threshold: Some(&LENGTH),
    robust: "guard it: `v * inversesqrt(max(dot(v, v), 1.0e-30))`",
    citation: "GLSL 4.60 8.5 (`normalize`); WGSL 17.5",
};

pub(super) static ATTENUATION_UNSET: HazardInfo = HazardInfo {
    code: "attenuation-unset",
    name: "attenuation that was never set",
    label: Some("H3"),
    aliases: &["zero-attenuation"],
    level: Level::Deny,
    what: "a light whose attenuation was never set divides by zero",
    why: "1 / (0 + 0 + 0) is infinite: white where the light has a colour, and NaN where its \
          colour is 0 as well.",
    threshold: Some(&ATTENUATION),
    robust: "keep the denominator away from zero: `1.0 / max(c + d * (l + q * d), 1.0e-4)`; loop over the lights in use only",
    citation: "measured on lavapipe and by the interpreter; the limit is that of \
               `attenuation-at-light`",
};

pub(super) static OVERFLOW: HazardInfo = HazardInfo {
    code: "overflow",
    name: "overflow of a square",
    label: Some("H4"),
    aliases: &[],
    level: Level::Warn,
    what: "a square is too large for an `f32`",
    why: "from a distance of 1.85e19 `dot(v, v)` is infinite: the direction is 0 and the light \
          silently off. In 16-bit floats that happens at 256 (`mediump-position`).",
    threshold: Some(&COORDINATE),
    robust: "scale before squaring, or by Horner's rule: `c + d * (l + q * d)`; let the host refuse coordinates above 1e18",
    citation: "IEEE 754 binary32; measured: right at 1.8e19, zero at 1.9e19",
};

pub(super) static UNDERFLOW: HazardInfo = HazardInfo {
    code: "underflow",
    name: "underflow of a square",
    label: Some("H5"),
    aliases: &[],
    level: Level::Warn,
    what: "a square is too small for an `f32`",
    why: "at a distance of 1e-22 a highlight is 1.36 times too bright, at 1e-23 it is NaN; \
          devices that flush subnormals lose distances below 1.1e-19.",
    threshold: Some(&LENGTH),
    robust: "guard a direction: `v * inversesqrt(max(dot(v, v), 1.0e-30))`; \
             nearer than 1e-15 means at the same place",
    citation: "IEEE 754 binary32; Vulkan 1.3, appendix A (subnormals may be flushed)",
};

pub(super) static EQUAL_CUT_OFFS: HazardInfo = HazardInfo {
    code: "equal-cut-offs",
    name: "equal cut-offs",
    label: Some("H6"),
    aliases: &["hard-cone"],
    level: Level::Deny,
    what: "inner and outer cone are the same, and their difference is divided by",
    why: "the factor is infinite inside and 0 / 0 at the edge itself: NaN by the formula, 0 where \
          `clamp` hides it.",
    threshold: Some(&CONE_WIDTH),
    robust: "`clamp((theta - outer) / max(inner - outer, 1.0e-4), 0.0, 1.0)`",
    citation: "GLSL 4.60 4.7.1 (division by zero is undefined); glTF's KHR_lights_punctual \
               guards the same difference with 0.001",
};

pub(super) static SWAPPED_CUT_OFFS: HazardInfo = HazardInfo {
    code: "swapped-cut-offs",
    name: "swapped cut-offs",
    label: Some("H6b"),
    aliases: &["swapped-cone"],
    level: Level::Warn,
    what: "the inner cone is the wider one, which turns the edge inside out",
    why: "with cosines 0.90 and 0.95 everything outside the cone is lit and its centre is black.",
    threshold: None,
    robust: "let the host sort the two, or refuse them",
    citation: "follows from the formula; GLSL 4.60 8.3 (`smoothstep` is undefined for such edges)",
};

pub(super) static CONE_OUT_OF_RANGE: HazardInfo = HazardInfo {
    code: "cone-out-of-range",
    name: "angle for a cosine",
    label: Some("H7"),
    aliases: &["wrong-unit"],
    level: Level::Warn,
    what: "a cut-off that is an angle, not its cosine, is taken as it comes",
    why: "12.5 and 17.5 degrees make a soft cone light everything, and a hard one nothing; in \
          radians the centre is black.",
    threshold: Some(&COSINE),
    robust: "upload the cosine, or refuse a cut-off outside -1 to 1",
    citation: "measured by the interpreter: (1 - 17.5) / (12.5 - 17.5) = 3.3",
};

pub(super) static ZERO_WIDTH_CONE: HazardInfo = HazardInfo {
    code: "zero-width-cone",
    name: "cone of no width",
    label: Some("H8"),
    aliases: &["empty-cone"],
    level: Level::Deny,
    what: "a cone of no width divides by zero; rounding puts its axis inside now and then",
    why: "on the axis the rounded cosine is above 1 in 14 of 100 fragments: fully lit sparkles \
          of a cone that lights nothing.",
    threshold: Some(&CONE_WIDTH),
    robust: "divide by `max(1.0 - cutoff, 1.0e-4)`",
    citation: "measured: 14.27 % of the fragments on the axis, cosines up to 1.0000002",
};

pub(super) static FAR_FROM_ORIGIN: HazardInfo = HazardInfo {
    code: "far-from-origin",
    name: "far from the origin",
    label: Some("H16"),
    aliases: &[],
    level: Level::Warn,
    what: "coordinates far from the origin cancel",
    why: "the error grows with the distance: 2.9 of 255 steps at 1e4, 24 at 1e5, a destroyed \
          picture at 1e6; matrices to view space in f32 are twice as bad.",
    threshold: Some(&ORIGIN),
    robust: "upload positions relative to the camera, subtracted in `f64`",
    citation: "measured of a scene of 3 m; relative to the camera it is 0.0035 steps anywhere",
};

pub(super) static NARROW_CONE: HazardInfo = HazardInfo {
    code: "narrow-cone",
    name: "narrow cone",
    label: Some("H17"),
    aliases: &[],
    level: Level::Warn,
    what: "two cosines near one are subtracted, and nothing of a narrow cone is left",
    why: "the cosine of a small angle is 1 less half its square, of which f32 keeps no digits \
          below 0.02 degrees: 0.53 of 255 steps off at 0.5 degrees, 16 at 0.1, all 255 at 0.05.",
    threshold: Some(&NARROW),
    robust: "by the chord: `vec3 e = l - axis; clamp((mo - 0.5 * dot(e, e)) / (mo - mi), 0.0, 1.0)` with `mo = 1 - outer`, `mi = 1 - inner`",
    citation: "measured; 1 - cos(a) = |L - D|^2 / 2 for unit vectors",
};

pub(super) static CONE_EDGE: HazardInfo = HazardInfo {
    code: "cone-edge",
    name: "edge of a cone without a ramp",
    label: None,
    aliases: &[],
    level: Level::Warn,
    what: "the fragment is within rounding of the edge of a cone without a ramp",
    why: "on one side it is lit and on the other it is not, and rounding decides: comparing it \
          with another device's says nothing. Such fragments are left out and counted.",
    threshold: Some(&EDGE),
    robust: "give the cone a ramp, an outer angle above the inner one",
    citation: "measured: of a hard cone the band is 4.7e-5 degrees wide at 12.5 degrees, 6e-4 at 1",
};

pub(super) static MEDIUMP_POSITION: HazardInfo = HazardInfo {
    code: "mediump-position",
    name: "positions in 16 bits",
    label: Some("H22"),
    aliases: &[],
    level: Level::Warn,
    what: "a position is below `highp`, and its squared distance overflows",
    why: "where `mediump` has 16 bits, squares overflow at 256 and positions have 11 bits.",
    threshold: Some(&HALF_DISTANCE),
    robust: "declare positions, directions and distances `highp`",
    citation: "GLSL ES 3.00 4.5.1 (the least range of `mediump` is 2^14)",
};

pub(super) static ZERO_DIRECTION: HazardInfo = HazardInfo {
    code: "zero-direction",
    name: "direction of length zero",
    label: Some("H24"),
    aliases: &[],
    level: Level::Warn,
    what: "a direction that is zero is normalised",
    why: "normalised by the shader or the host it is NaN, and so is every light it takes part in.",
    threshold: Some(&LENGTH),
    robust: "guard it: `v * inversesqrt(max(dot(v, v), 1.0e-30))`, or refuse it on the host",
    citation: "GLSL 4.60 8.5 (`normalize`); WGSL 17.5",
};

pub(super) static NEGATIVE_ATTENUATION: HazardInfo = HazardInfo {
    code: "negative-attenuation",
    name: "negative attenuation",
    label: Some("H26"),
    aliases: &["negative-color"],
    level: Level::Warn,
    what: "with a negative coefficient the attenuation has a pole",
    why: "at some distance the denominator is 0, beyond it the light is negative; no range bounds \
          such a light, so that it cannot be culled.",
    threshold: None,
    robust: "refuse negative coefficients on the host",
    citation: "follows from the formula",
};

pub(super) static LONE_CONSTANT: HazardInfo = HazardInfo {
    code: "lone-constant",
    name: "constant attenuation set for another coefficient",
    label: Some("H27"),
    aliases: &[],
    level: Level::Warn,
    what: "only the constant term is set, to what looks like another coefficient",
    why: "setting `constant` three times, to 1, 0.09 and 0.032, leaves 0.032 and zeros: the light \
          is 31 times too bright at every distance.",
    threshold: None,
    robust: "set `constant`, `linear` and `quadratic`, each once",
    citation: "seen in a public program that copied the line and changed only the value",
};
