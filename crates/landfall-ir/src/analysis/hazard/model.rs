//! Hazards of highlights, normals, loops over lights and sums.

use landfall_layout::finding::Level;

use super::HazardInfo;
use super::threshold::{ABOVE_ONE, CHANGE, EXPONENT};

pub(super) static LOOP_PAST_COUNT: HazardInfo = HazardInfo {
    code: "loop-past-count",
    name: "loop past the count",
    level: Level::Warn,
    what: "slots that hold no light are evaluated",
    why: "A slot of zeros is 1 / 0 times 0, which is NaN, and so is the whole sum: with 2 of 128 \
          slots in use every fragment was NaN on lavapipe.",
    threshold: None,
    robust: "loop to `min(count, N)`",
    citation: "measured on lavapipe",
};

pub(super) static POW_OF_ZERO: HazardInfo = HazardInfo {
    code: "pow-of-zero",
    name: "zero to the power of zero",
    level: Level::Deny,
    what: "zero to the power of zero or less is undefined",
    why: "`pow(0, 0)` is 1 in the C library, NaN by exp2(0 * log2(0)) and 0 on lavapipe. A clamped \
          highlight has base 0, a material that was never set has exponent 0.",
    threshold: None,
    robust: "guard the base: `x > 0.0 ? pow(x, n) : 0.0`",
    citation: "GLSL 4.60 8.2: `pow` is undefined for x = 0 and y <= 0",
};

pub(super) static POW_OF_NEGATIVE: HazardInfo = HazardInfo {
    code: "pow-of-negative",
    name: "power of a negative number",
    level: Level::Deny,
    what: "a power of a negative number is undefined",
    why: "`pow(-0.25, 2.0)` is 0.0625 in the C library, and NaN by exp2(n * log2(x)) and on lavapipe.",
    threshold: None,
    robust: "guard the base: `x > 0.0 ? pow(x, n) : 0.0`",
    citation: "GLSL 4.60 8.2: `pow` is undefined for x < 0",
};

pub(super) static BASE_ABOVE_ONE: HazardInfo = HazardInfo {
    code: "base-above-one",
    name: "base above one",
    level: Level::Warn,
    what: "rounding lifts a cosine above 1, and the power amplifies the excess",
    why: "Half of all normalised vectors are longer than 1; 1 + 2^-23 to the power of 1e7 is 3.3.",
    threshold: Some(&ABOVE_ONE),
    robust: "clamp the base: `pow(clamp(x, 0.0, 1.0), n)`",
    citation: "measured on 1,000,000 vectors divided by their length in f32",
};

pub(super) static UNINITIALISED: HazardInfo = HazardInfo {
    code: "uninitialised",
    name: "uninitialised variable",
    level: Level::Deny,
    what: "a variable is read before it is initialised",
    why: "The sum starts from whatever the register held: a NaN stays NaN, and 8388608 swallows \
          the light.",
    threshold: None,
    robust: "initialise it: `vec3 total = vec3(0.0);`",
    citation: "GLSL 4.60 4.3 (reading an uninitialised variable is undefined)",
};

pub(super) static HIGHLIGHT_FROM_BEHIND: HazardInfo = HazardInfo {
    code: "highlight-from-behind",
    name: "highlight from behind",
    level: Level::Warn,
    what: "a light behind the surface still produces a highlight",
    why: "With dot(n, l) = -0.2 a highlight of exponent 32 is 0.52 bright at a grazing view; and \
          lights behind a surface cannot be skipped.",
    threshold: Some(&CHANGE),
    robust: "add the highlight only where `dot(n, l) > 0.0`",
    citation: "measured with the interpreter",
};

pub(super) static UNNORMALISED_NORMAL: HazardInfo = HazardInfo {
    code: "unnormalised-normal",
    name: "normal not of unit length",
    level: Level::Warn,
    what: "the result depends on the length of the normal",
    why: "Between vertices whose normals are 20 degrees apart a highlight of exponent 32 falls to \
          0.38 of its peak; a normal 10 % too long makes it 446 times too bright.",
    threshold: Some(&CHANGE),
    robust: "normalise it in the fragment stage: `normalize(v_normal)`",
    citation: "measured with the interpreter",
};

pub(super) static VEC4_NORMALISE: HazardInfo = HazardInfo {
    code: "vec4-normalise",
    name: "normal normalised with its fourth component",
    level: Level::Warn,
    what: "a normal is normalised together with its fourth component",
    why: "The inverse transpose of a matrix with a translation leaves a fourth component, which \
          shortens each vertex's normal by a different factor: the interpolated normals bend by \
          3.3 degrees at a camera distance of 2 and by 14.4 at 100.",
    threshold: None,
    robust: "normalise three components: `normalize(mat3(transpose(inverse(m))) * n)`, or take \
             `.xyz` first",
    citation: "measured with the interpreter, for vertex normals 30 degrees apart",
};

pub(super) static LARGE_EXPONENT: HazardInfo = HazardInfo {
    code: "large-exponent",
    name: "large exponent",
    level: Level::Warn,
    what: "the power multiplies the relative error of its base by the exponent",
    why: "A highlight computed from f32 vectors is up to 0.04 steps of 1/255 off at exponent 256, \
          0.65 at 4096, 10 at 65536, however exact `pow` is.",
    threshold: Some(&EXPONENT),
    robust: "above 256 use the difference of the unit vectors `v` (to the eye) and `r` (reflected): \
             `m = 0.5 * dot(v - r, v - r); exp2(n * log2(1.0 - m))`, with a series for small `m`",
    citation: "measured; WGSL 15.7.4 and Vulkan 1.3, appendix A (accuracy of `pow`)",
};

pub(super) static AMBIENT_PER_LIGHT: HazardInfo = HazardInfo {
    code: "ambient-per-light",
    name: "ambient light per light",
    level: Level::Warn,
    what: "ambient light is added for every light",
    why: "128 such terms of 0.05 add up to 6.4: white.",
    threshold: None,
    robust: "keep one ambient light beside the array, and add it once",
    citation: "follows from the sum",
};

pub(super) static KAHAN_WITHOUT_PRECISE: HazardInfo = HazardInfo {
    code: "kahan-without-precise",
    name: "compensated sum without `precise`",
    level: Level::Warn,
    what: "a compiler may optimise the compensation term of a sum away",
    why: "(t - s) - y is 0 in real numbers; Mesa adds 2^-24 to 1 five hundred times and returns 1.0 \
          instead of 1.0000298 where the operations are not marked `precise`.",
    threshold: None,
    robust: "declare the variables `precise`; in WGSL, sum in several lanes, or pairwise",
    citation: "GLSL 4.60 4.9 (`precise`); WGSL 15.7.3 (reassociation is permitted)",
};

pub(super) static COUNT_PAST_ARRAY: HazardInfo = HazardInfo {
    code: "count-past-array",
    name: "count past the array",
    level: Level::Deny,
    what: "an index is past the end of its array",
    why: "The 129th of 128 lights has the bits of the count as its position, or what the driver \
          returns for a read out of bounds.",
    threshold: None,
    robust: "clamp the count: `min(count, N)`",
    citation: "GLSL 4.60 5.7 (indexing out of bounds is undefined)",
};
