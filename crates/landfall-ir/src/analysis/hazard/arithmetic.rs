//! Hazards of plain arithmetic: lights and cameras play no part in them.

use landfall_layout::finding::Level;

use super::HazardInfo;
use super::threshold::LENGTH;

pub(super) static NOT_FINITE: HazardInfo = HazardInfo {
    code: "not-finite",
    name: "number that is not finite",
    label: None,
    aliases: &[],
    level: Level::Deny,
    what: "an uploaded number, or the sum, is not finite",
    why: "one NaN or infinity among the lights is the whole sum.",
    threshold: None,
    robust: "let the host refuse numbers that are not finite",
    citation: "WGSL 15.7.2: implementations may assume that there are no infinities and NaNs",
};

pub(super) static ZERO_VECTOR: HazardInfo = HazardInfo {
    code: "zero-vector",
    name: "vector of length zero",
    label: None,
    aliases: &[],
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
    label: None,
    aliases: &[],
    level: Level::Deny,
    what: "two opposite vectors add to zero, and the sum is normalised",
    why: "a half vector has no direction where the view is opposite to the light: 0 / 0.",
    threshold: Some(&LENGTH),
    robust: "guard it: `v * inversesqrt(max(dot(v, v), 1.0e-30))`",
    citation: "GLSL 4.60 8.5 (`normalize`); WGSL 17.5",
};

pub(super) static DIVISION_BY_ZERO: HazardInfo = HazardInfo {
    code: "division-by-zero",
    name: "division by zero",
    label: None,
    aliases: &[],
    level: Level::Deny,
    what: "it divides by zero",
    why: "the quotient is infinite or NaN by IEEE 754 and anything by the specifications.",
    threshold: None,
    robust: "keep the denominator away from zero with `max`",
    citation: "GLSL 4.60 4.7.1; WGSL 15.7.2",
};

pub(super) static UNDEFINED_OPERATION: HazardInfo = HazardInfo {
    code: "undefined-operation",
    name: "undefined operation",
    label: None,
    aliases: &[],
    level: Level::Deny,
    what: "no specification gives this operation a value here",
    why: "devices differ, and each may be right.",
    threshold: None,
    robust: "keep its operands where it is defined",
    citation: "GLSL 4.60, chapters 5 and 8: each operation says where it is undefined",
};

pub(super) static LARGE_VALUES: HazardInfo = HazardInfo {
    code: "large-values",
    name: "values too large",
    label: None,
    aliases: &[],
    level: Level::Warn,
    what: "the result is too large for a float of its kind",
    why: "beyond 3.4e38 an f32 is infinite, beyond 65504 a 16-bit float.",
    threshold: None,
    robust: "let the host refuse such values",
    citation: "IEEE 754 binary32 and binary16",
};

pub(super) static CANCELLATION: HazardInfo = HazardInfo {
    code: "cancellation",
    name: "cancellation",
    label: None,
    aliases: &[],
    level: Level::Warn,
    what: "nearly equal numbers are subtracted",
    why: "the leading digits go and the rounding errors of the operands stay.",
    threshold: None,
    robust: "rewrite the difference so that it is not of rounded numbers",
    citation: "Higham, Accuracy and Stability of Numerical Algorithms, 1.7",
};

pub(super) static ACCUMULATED_ERROR: HazardInfo = HazardInfo {
    code: "accumulated-error",
    name: "accumulated error",
    label: None,
    aliases: &[],
    level: Level::Warn,
    what: "rounding adds up to more than is allowed",
    why: "no single operation is at fault: the error of each is small, their sum is not.",
    threshold: None,
    robust: "compute this part in fewer or better conditioned operations",
    citation: "Higham, Accuracy and Stability of Numerical Algorithms, 3.1",
};

pub(super) static ENDLESS_LOOP: HazardInfo = HazardInfo {
    code: "endless-loop",
    name: "endless loop",
    label: None,
    aliases: &[],
    level: Level::Deny,
    what: "a loop does not end within the budget",
    why: "a driver ends such a shader by resetting the device.",
    threshold: None,
    robust: "bound it by a constant: `i < min(count, N)`",
    citation: "WGSL 2.1 (a shader whose loop does not end is a dynamic error)",
};

pub(super) static DRIVER_NOT_FINITE: HazardInfo = HazardInfo {
    code: "driver-not-finite",
    name: "driver without a finite number",
    label: None,
    aliases: &[],
    level: Level::Deny,
    what: "a driver gives no finite number where the evaluator does",
    why: "the operation overflows in this driver's expansion of it, or is less accurate than f32.",
    threshold: None,
    robust: "keep operands of division, `pow`, `log` and `exp` where every device is held to an error",
    citation: "Vulkan 1.3, appendix A; WGSL 15.7.4 (accuracy by range of operands)",
};

pub(super) static DRIVER_APART: HazardInfo = HazardInfo {
    code: "driver-apart",
    name: "driver less accurate than the interpreter",
    label: None,
    aliases: &[],
    level: Level::Warn,
    what: "a driver is off by more than the evaluator is",
    why: "specifications permit `pow`, `exp2` and division larger errors than f32 rounding.",
    threshold: None,
    robust: "use operations of smaller permitted error: multiplications for `pow`, `x * inversesqrt(d)` for a division by a length",
    citation: "Vulkan 1.3, appendix A; WGSL 15.7.4 (accuracy)",
};
