//! Hazards of distances, attenuation and cones.

use landfall_layout::finding::Level;

use super::HazardInfo;
use super::threshold::{
    ATTENUATION, CONE_WIDTH, COORDINATE, COSINE, EDGE, HALF_DISTANCE, LENGTH, NARROW, ORIGIN,
};

pub(super) static LIGHT_AT_FRAGMENT: HazardInfo = HazardInfo {
    code: "light-at-fragment",
    name: "light at the fragment",
    level: Level::Deny,
    what: "the light is at the fragment, and a vector of length zero is normalised",
    why: "`normalize(vec3(0))` is 0 / 0: three NaNs by the formula and on lavapipe. Where `max` \
          hides them the light is silently black.",
    threshold: Some(&LENGTH),
    robust: "guard it: `v * inversesqrt(max(dot(v, v), 1.0e-30))`",
    citation: "GLSL 4.60 8.5 (`normalize`); WGSL 17.5 (`normalize` of a zero vector is an error or \
               indeterminate)",
};

pub(super) static ATTENUATION_AT_LIGHT: HazardInfo = HazardInfo {
    code: "attenuation-at-light",
    name: "attenuation at the light",
    level: Level::Deny,
    what: "an attenuation without a constant term divides by zero at the light",
    why: "1 / 0 is infinite, and infinity times a colour of 0 is NaN, even where `max` and `min` \
          hide NaNs.",
    threshold: Some(&ATTENUATION),
    robust: "keep the denominator away from zero: `1.0 / max(c + d * (l + q * d), 1.0e-4)`",
    citation: "Filament's documentation, 5.2.2: `1 / max(d^2, 1e-4)`; Lagarde and de Rousiers, \
               Moving Frostbite to PBR (2014), a light of 1 cm",
};

pub(super) static CAMERA_AT_FRAGMENT: HazardInfo = HazardInfo {
    code: "camera-at-fragment",
    name: "camera at the fragment",
    level: Level::Deny,
    what: "the camera is at the fragment, and a vector of length zero is normalised",
    why: "`normalize(vec3(0))` is NaN by the formula: the highlight of the fragment is NaN, or \
          silently missing where `max` hides it.",
    threshold: Some(&LENGTH),
    robust: "guard it: `v * inversesqrt(max(dot(v, v), 1.0e-30))`",
    citation: "GLSL 4.60 8.5 (`normalize`); WGSL 17.5",
};

pub(super) static ATTENUATION_UNSET: HazardInfo = HazardInfo {
    code: "attenuation-unset",
    name: "attenuation that was never set",
    level: Level::Deny,
    what: "an attenuation whose coefficients were never set divides by zero",
    why: "1 / (0 + 0 + 0) is infinite: white where the light has a colour, and NaN where its \
          colour is 0 as well.",
    threshold: Some(&ATTENUATION),
    robust: "keep the denominator away from zero: `1.0 / max(c + d * (l + q * d), 1.0e-4)`; loop \
             over the lights in use only",
    citation: "measured on lavapipe and with the interpreter; the limit is that of \
               `attenuation-at-light`",
};

pub(super) static OVERFLOW: HazardInfo = HazardInfo {
    code: "overflow",
    name: "overflow of a square",
    level: Level::Warn,
    what: "a square is too large for an `f32`",
    why: "From a distance of 1.85e19 `dot(v, v)` is infinite: the direction is 0 and the light \
          silently off. In 16-bit floats the limit is a distance of 256 (`mediump-position`).",
    threshold: Some(&COORDINATE),
    robust: "scale before squaring, or use Horner's rule: `c + d * (l + q * d)`; reject \
             coordinates above 1e18 on the host",
    citation: "IEEE 754 binary32; measured: right at 1.8e19, zero at 1.9e19",
};

pub(super) static UNDERFLOW: HazardInfo = HazardInfo {
    code: "underflow",
    name: "underflow of a square",
    level: Level::Warn,
    what: "a square is too small for an `f32`",
    why: "At a distance of 1e-22 a highlight is 1.36 times too bright, at 1e-23 it is NaN; devices \
          that flush subnormals lose distances below 1.1e-19.",
    threshold: Some(&LENGTH),
    robust: "guard a direction: `v * inversesqrt(max(dot(v, v), 1.0e-30))`, which treats distances \
             below 1e-15 as zero",
    citation: "IEEE 754 binary32; Vulkan 1.3, appendix A (subnormals may be flushed)",
};

pub(super) static EQUAL_CUT_OFFS: HazardInfo = HazardInfo {
    code: "equal-cut-offs",
    name: "equal cut-offs",
    level: Level::Deny,
    what: "the inner and outer cone are equal, and their difference is a divisor",
    why: "The factor is infinite inside the cone and 0 / 0 exactly on its edge: NaN by the \
          formula, 0 where `clamp` hides it.",
    threshold: Some(&CONE_WIDTH),
    robust: "guard the divisor: `clamp((theta - outer) / max(inner - outer, 1.0e-4), 0.0, 1.0)`, \
             which changes cones below 1 degree: those need the form of `narrow-cone`",
    citation: "GLSL 4.60 4.7.1 (division by zero is undefined); glTF's KHR_lights_punctual \
               guards the same difference with 0.001",
};

pub(super) static SWAPPED_CUT_OFFS: HazardInfo = HazardInfo {
    code: "swapped-cut-offs",
    name: "swapped cut-offs",
    level: Level::Warn,
    what: "the inner cone is wider than the outer one, which inverts the edge",
    why: "With cosines 0.90 and 0.95 everything outside the cone is lit and its centre is black.",
    threshold: None,
    robust: "sort the two cut-offs on the host, or reject them",
    citation: "follows from the formula; GLSL 4.60 8.3 (`smoothstep` is undefined for such edges)",
};

pub(super) static CONE_OUT_OF_RANGE: HazardInfo = HazardInfo {
    code: "cone-out-of-range",
    name: "angle in place of a cosine",
    level: Level::Warn,
    what: "a cut-off is an angle where its cosine is expected",
    why: "12.5 and 17.5 degrees make a soft cone light everything, and a hard one nothing; in \
          radians the centre is black.",
    threshold: Some(&COSINE),
    robust: "upload the cosine, or reject a cut-off outside -1 to 1",
    citation: "measured with the interpreter: (1 - 17.5) / (12.5 - 17.5) = 3.3",
};

pub(super) static ZERO_WIDTH_CONE: HazardInfo = HazardInfo {
    code: "zero-width-cone",
    name: "cone of zero width",
    level: Level::Deny,
    what: "a cone of zero width divides by zero, and rounding lights some fragments on its axis",
    why: "On the axis the rounded cosine is above 1 in 14 of 100 fragments: fully lit sparkles of \
          a cone that lights nothing.",
    threshold: Some(&CONE_WIDTH),
    robust: "divide by `max(1.0 - cutoff, 1.0e-4)`, which changes cones below 1 degree: those need \
             the form of `narrow-cone`",
    citation: "measured on random axes and distances, with cosines up to 1.0000002",
};

pub(super) static FAR_FROM_ORIGIN: HazardInfo = HazardInfo {
    code: "far-from-origin",
    name: "far from the origin",
    level: Level::Warn,
    what: "differences of coordinates far from the origin lose their digits",
    why: "The error grows with the distance: 1 step of 1/255 at 1e4, 9 at 1e5, 80 at 1e6, in a room \
          of 3 m; positions relative to the camera keep it below 0.01.",
    threshold: Some(&ORIGIN),
    robust: "upload positions relative to the camera, subtracted in `f64`",
    citation: "measured on random surfaces with highlights of exponent 32",
};

pub(super) static NARROW_CONE: HazardInfo = HazardInfo {
    code: "narrow-cone",
    name: "narrow cone",
    level: Level::Warn,
    what: "two cosines near 1 are subtracted, which leaves no digits of a narrow cone",
    why: "The cosine of a small angle is 1 minus half its square, of which f32 keeps no digits \
          below 0.02 degrees: 0.7 steps of 1/255 off from 0.5 to 1 degree, 19 from 0.1 to 0.2, all 255 from 0.05 to 0.06.",
    threshold: Some(&NARROW),
    robust: "use the difference of the unit vectors: `vec3 e = l - axis; clamp((mo - 0.5 * dot(e, e)) / (mo - mi), \
             0.0, 1.0)` with `mo = 1 - outer`, `mi = 1 - inner`",
    citation: "measured; 1 - cos(a) = |l - axis|^2 / 2 for unit vectors",
};

pub(super) static CONE_EDGE: HazardInfo = HazardInfo {
    code: "cone-edge",
    name: "edge of a cone without a ramp",
    level: Level::Warn,
    what: "the fragment is within rounding error of the edge of a spotlight without a ramp",
    why: "One side of the edge is lit and the other is not, and rounding decides, so that devices \
          may differ. Comparisons of pictures exclude such fragments and print their number.",
    threshold: Some(&EDGE),
    robust: "give the cone a ramp: an outer angle above the inner one",
    citation: "three units of 2^-24 in the cosine move the edge by 4.7e-5 degrees at 12.5 degrees, by \
               5.9e-4 at 1",
};

pub(super) static MEDIUMP_POSITION: HazardInfo = HazardInfo {
    code: "mediump-position",
    name: "positions in 16 bits",
    level: Level::Warn,
    what: "a position is below `highp`, and its squared distance may overflow",
    why: "Where `mediump` has 16 bits, squares overflow at a distance of 256 and positions have 11 \
          bits.",
    threshold: Some(&HALF_DISTANCE),
    robust: "declare positions, directions and distances `highp`",
    citation: "GLSL ES 3.00 4.5.1 (the minimum range of `mediump` is 2^14)",
};

pub(super) static ZERO_DIRECTION: HazardInfo = HazardInfo {
    code: "zero-direction",
    name: "direction of length zero",
    level: Level::Warn,
    what: "a zero direction is normalised",
    why: "Normalised by the shader or the host it is NaN, and so is every light computed from it.",
    threshold: Some(&LENGTH),
    robust: "guard it: `v * inversesqrt(max(dot(v, v), 1.0e-30))`, or reject it on the host",
    citation: "GLSL 4.60 8.5 (`normalize`); WGSL 17.5",
};

pub(super) static NEGATIVE_ATTENUATION: HazardInfo = HazardInfo {
    code: "negative-attenuation",
    name: "negative attenuation",
    level: Level::Warn,
    what: "an attenuation with a negative coefficient has a pole",
    why: "At some distance the denominator is 0, and beyond it the light is negative; no range \
          bounds such a light, so that it cannot be culled.",
    threshold: None,
    robust: "reject negative coefficients on the host",
    citation: "follows from the formula",
};

pub(super) static LONE_CONSTANT: HazardInfo = HazardInfo {
    code: "lone-constant",
    name: "constant attenuation set for another coefficient",
    level: Level::Warn,
    what: "only the constant term is set, to a value that looks like another coefficient",
    why: "Setting `constant` three times, to 1, 0.09 and 0.032, leaves 0.032 and zeros: the light \
          is 31 times too bright at every distance.",
    threshold: None,
    robust: "set each of `constant`, `linear` and `quadratic` once",
    citation: "found in a public program that copied the line and changed only the value",
};
