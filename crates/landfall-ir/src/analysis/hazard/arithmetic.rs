//! Hazards of plain arithmetic, without lights or cameras.

use landfall_layout::finding::Level;

use super::HazardInfo;
use super::threshold::LENGTH;

pub(super) static NOT_FINITE: HazardInfo = HazardInfo {
    code: "not-finite",
    name: "number that is not finite",
    level: Level::Deny,
    what: "an uploaded number, or the sum, is not finite",
    why: "One NaN or infinity among the lights makes the whole sum NaN or infinite.",
    threshold: None,
    robust: "reject numbers that are not finite on the host",
    citation: "WGSL 15.7.2: implementations may assume that there are no infinities and NaNs",
};

pub(super) static ZERO_VECTOR: HazardInfo = HazardInfo {
    code: "zero-vector",
    name: "vector of length zero",
    level: Level::Deny,
    what: "a vector of length zero is normalised",
    why: "0 / 0 is NaN by the formula and on lavapipe, and undefined by the specifications.",
    threshold: Some(&LENGTH),
    robust: "guard it: `v * inversesqrt(max(dot(v, v), 1.0e-30))`",
    citation: "GLSL 4.60 8.5 (`normalize`); WGSL 17.5",
};

pub(super) static OPPOSITE_VECTORS: HazardInfo = HazardInfo {
    code: "opposite-vectors",
    name: "opposite vectors",
    level: Level::Deny,
    what: "two opposite vectors add up to zero, and the sum is normalised",
    why: "A half vector has no direction where the view is opposite to the light: 0 / 0.",
    threshold: Some(&LENGTH),
    robust: "guard it: `v * inversesqrt(max(dot(v, v), 1.0e-30))`",
    citation: "GLSL 4.60 8.5 (`normalize`); WGSL 17.5",
};

pub(super) static PARALLEL_VECTORS: HazardInfo = HazardInfo {
    code: "parallel-vectors",
    name: "parallel vectors",
    level: Level::Deny,
    what: "two vectors are parallel, and what one has beside the other is normalised",
    why: "`t - n * dot(n, t)` and `cross(n, t)` are zero, or only rounding errors, where the vectors \
          are parallel.",
    threshold: Some(&LENGTH),
    robust: "choose another second vector where they are parallel, or build the basis from one \
             vector alone",
    citation: "GLSL 4.60 8.5 (`normalize`); Duff et al., Building an Orthonormal Basis, Revisited \
               (JCGT 2017)",
};

pub(super) static NEGATIVE_REMAINDER: HazardInfo = HazardInfo {
    code: "negative-remainder",
    name: "remainder of a negative integer",
    level: Level::Deny,
    what: "the remainder of a negative integer is taken",
    why: "GLSL leaves it undefined; in WGSL it has the sign of the dividend, so that an index from \
          it is negative.",
    threshold: None,
    robust: "write `((i % n) + n) % n` in WGSL; in GLSL, where that is undefined too, `i & (n - 1)` \
             for a power of two, or unsigned integers",
    citation: "GLSL 4.60 5.9 (undefined if an operand is negative); WGSL 8.7",
};

pub(super) static INDEX_OUT_OF_BOUNDS: HazardInfo = HazardInfo {
    code: "index-out-of-bounds",
    name: "index out of bounds",
    level: Level::Deny,
    what: "an index is not in its array",
    why: "GLSL leaves the access undefined; WGSL returns another element, or zero.",
    threshold: None,
    robust: "clamp the index to the array: `clamp(i, 0, N - 1)`",
    citation: "GLSL 4.60 5.7 (indexing out of bounds is undefined); WGSL 15.6.1",
};

pub(super) static DIVISION_BY_ZERO: HazardInfo = HazardInfo {
    code: "division-by-zero",
    name: "division by zero",
    level: Level::Deny,
    what: "a division by zero",
    why: "The quotient is infinite or NaN by IEEE 754 and undefined by the specifications.",
    threshold: None,
    robust: "keep the denominator away from zero with `max`",
    citation: "GLSL 4.60 4.7.1; WGSL 15.7.2",
};

pub(super) static UNDEFINED_OPERATION: HazardInfo = HazardInfo {
    code: "undefined-operation",
    name: "undefined operation",
    level: Level::Deny,
    what: "the specifications define no value for this operation here",
    why: "Devices return different values, each of them conforming.",
    threshold: None,
    robust: "keep the operands in the range where the operation is defined",
    citation: "GLSL 4.60, chapters 5 and 8: each operation lists where it is undefined",
};

pub(super) static LARGE_VALUES: HazardInfo = HazardInfo {
    code: "large-values",
    name: "values too large",
    level: Level::Warn,
    what: "the result is above the range of its float type",
    why: "Above 3.4e38 an f32 is infinite, above 65504 a 16-bit float.",
    threshold: None,
    robust: "bound the operands, or compute with the logarithm; reject such values on the host",
    citation: "IEEE 754 binary32 and binary16",
};

pub(super) static CANCELLATION: HazardInfo = HazardInfo {
    code: "cancellation",
    name: "cancellation",
    level: Level::Warn,
    what: "nearly equal numbers are subtracted",
    why: "The leading digits cancel and the rounding errors of the operands remain.",
    threshold: None,
    robust: "rewrite the difference so that its operands are exact",
    citation: "Higham, Accuracy and Stability of Numerical Algorithms, 1.7",
};

pub(super) static ACCUMULATED_ERROR: HazardInfo = HazardInfo {
    code: "accumulated-error",
    name: "accumulated error",
    level: Level::Warn,
    what: "rounding errors add up to more than is permitted",
    why: "No single operation is at fault: the error of each is small, their sum is not.",
    threshold: None,
    robust: "compute this part in fewer or better conditioned operations",
    citation: "Higham, Accuracy and Stability of Numerical Algorithms, 3.1",
};

pub(super) static BRANCH_DIVERGENCE: HazardInfo = HazardInfo {
    code: "branch-divergence",
    name: "branch that rounding decides",
    level: Level::Warn,
    what: "rounding decides a comparison, and the branches give different results",
    why: "Devices round differently, so that neighbouring pixels or devices take different sides \
          of the branch.",
    threshold: None,
    robust: "make the result continuous across the comparison, for example with `smoothstep` or \
             `mix`",
    citation: "Vulkan 1.3, appendix A; WGSL 15.7.4 (accuracy): operands may differ between devices",
};

pub(super) static ENDLESS_LOOP: HazardInfo = HazardInfo {
    code: "endless-loop",
    name: "endless loop",
    level: Level::Deny,
    what: "a loop exceeds the limit of iterations",
    why: "A driver ends such a shader by resetting the device.",
    threshold: None,
    robust: "bound the loop by a constant: `i < min(count, N)`",
    citation: "WGSL 2.1 (a shader whose loop does not end is a dynamic error)",
};

pub(super) static DRIVER_NOT_FINITE: HazardInfo = HazardInfo {
    code: "driver-not-finite",
    name: "result not finite on a driver",
    level: Level::Deny,
    what: "a driver returns no finite number where the interpreter does",
    why: "The operation overflows in this driver's expansion of it, or is less accurate than f32.",
    threshold: None,
    robust: "keep the operands of division, `pow`, `log` and `exp` in the range for which the \
             specifications bound the error",
    citation: "Vulkan 1.3, appendix A; WGSL 15.7.4 (accuracy by range of operands)",
};

pub(super) static DRIVER_APART: HazardInfo = HazardInfo {
    code: "driver-apart",
    name: "driver less accurate than the interpreter",
    level: Level::Warn,
    what: "a driver is less accurate than the interpreter",
    why: "The specifications permit larger errors than f32 rounding for `pow`, `exp2` and \
          division.",
    threshold: None,
    robust: "use operations with a smaller permitted error: multiplications for `pow`, `x * \
             inversesqrt(d)` for a division by a length",
    citation: "Vulkan 1.3, appendix A; WGSL 15.7.4 (accuracy)",
};
