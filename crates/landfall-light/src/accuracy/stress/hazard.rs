//! The hazards that are known by name: what triggers them, and the form that does not break.
//!
//! Numbers are those of the table of lighting hazards; what has none is only arithmetic. Used by
//! `classify` and the report.

use landfall_layout::finding::Level;

/// A way in which code of lighting breaks.
#[derive(Debug, PartialEq, Eq)]
pub struct Hazard {
    /// Its number in the table of lighting hazards; empty of plain arithmetic.
    pub id: &'static str,
    /// Kebab-case, as a lint's code.
    pub code: &'static str,
    /// What happens, in a clause.
    pub what: &'static str,
    /// The form that does not break.
    pub rewrite: &'static str,
    /// How much it matters where the inputs are those of a scene.
    pub level: Level,
}

macro_rules! hazards {
    ($($name:ident = $id:literal $code:literal $level:ident $what:literal $rewrite:literal;)*) => {
        $(
            #[doc = $what]
            pub static $name: Hazard = Hazard {
                id: $id,
                code: $code,
                what: $what,
                rewrite: $rewrite,
                level: Level::$level,
            };
        )*
        /// Every hazard.
        pub static HAZARDS: &[&Hazard] = &[$(&$name),*];
    };
}

hazards! {
    LIGHT_AT_FRAGMENT = "H1" "light-at-fragment" Deny
        "the light is where the fragment is, and a vector of length zero is normalised"
        "guard it: `v * inversesqrt(max(dot(v, v), 1.0e-30))`";
    ATTENUATION_AT_LIGHT = "H1b" "attenuation-at-light" Deny
        "without a constant term the attenuation divides by zero at the light"
        "keep the denominator away from zero: `1.0 / max(c + d * (l + q * d), 1.0e-4)`";
    CAMERA_AT_FRAGMENT = "H2" "camera-at-fragment" Deny
        "the eye is where the fragment is, and a vector of length zero is normalised"
        "guard it: `v * inversesqrt(max(dot(v, v), 1.0e-30))`";
    ATTENUATION_UNSET = "H3" "attenuation-unset" Deny
        "a light whose attenuation was never set divides by zero"
        "keep the denominator away from zero: `1.0 / max(c + d * (l + q * d), 1.0e-4)`; loop over the lights in use only";
    OVERFLOW = "H4" "overflow" Warn
        "a square is too large for an `f32`"
        "scale before squaring, or by Horner's rule: `c + d * (l + q * d)`; let the host refuse coordinates above 1e18";
    UNDERFLOW = "H5" "underflow" Warn
        "a square is too small for an `f32`"
        "guard a direction: `v * inversesqrt(max(dot(v, v), 1.0e-30))`, and a divisor: `max(x, 1.0e-4)`; \
         nearer than 1e-15 means at the same place";
    EQUAL_CUT_OFFS = "H6" "equal-cut-offs" Deny
        "inner and outer cone are the same, and their difference is divided by"
        "`clamp((theta - outer) / max(inner - outer, 1.0e-4), 0.0, 1.0)`";
    SWAPPED_CUT_OFFS = "H6b" "swapped-cut-offs" Warn
        "the inner cone is the wider one, which turns the edge inside out"
        "let the host sort the two, or refuse them";
    CONE_OUT_OF_RANGE = "H7" "cone-out-of-range" Warn
        "a cut-off that is an angle, not its cosine, is taken as it comes"
        "upload the cosine, or refuse a cut-off outside -1 to 1";
    ZERO_WIDTH_CONE = "H8" "zero-width-cone" Deny
        "a cone of no width divides by zero; rounding puts its axis inside now and then"
        "divide by `max(1.0 - cutoff, 1.0e-7)`";
    POWER_OF_ZERO = "H9" "power-of-zero" Deny
        "zero to the power of zero or less is undefined"
        "`x > 0.0 ? pow(x, n) : 0.0`";
    POWER_OF_NEGATIVE = "H10" "power-of-negative" Deny
        "a power of a negative number is undefined"
        "`x > 0.0 ? pow(x, n) : 0.0`";
    BASE_ABOVE_ONE = "H11" "base-above-one" Warn
        "rounding puts a cosine above one, and the power makes much of it"
        "`pow(clamp(x, 0.0, 1.0), n)`";
    UNINITIALISED = "H12" "uninitialised" Deny
        "a variable is read before anything is put into it"
        "initialise it: `vec3 total = vec3(0.0);`";
    HIGHLIGHT_FROM_BEHIND = "H13" "highlight-from-behind" Warn
        "a light below the horizon has a highlight"
        "take the highlight only where `dot(n, l) > 0.0`";
    NORMAL_NOT_NORMALISED = "H14" "normal-not-normalised" Warn
        "the result depends on how long the normal is"
        "normalise it in the fragment stage: `normalize(v_normal)`";
    FAR_FROM_ORIGIN = "H16" "far-from-origin" Warn
        "coordinates far from the origin cancel"
        "upload positions relative to the camera, subtracted in `f64`";
    NARROW_CONE = "H17" "narrow-cone" Warn
        "two cosines near one are subtracted, and nothing of a narrow cone is left"
        "by the chord: `vec3 e = l - axis; clamp((mo - 0.5 * dot(e, e)) / (mo - mi), 0.0, 1.0)` with `mo = 1 - outer`, `mi = 1 - inner`";
    LARGE_EXPONENT = "H19" "large-exponent" Warn
        "the power multiplies the relative error of its base by the exponent"
        "above 256 by the chord: `m = 0.5 * dot(v - r, v - r); exp2(n * log2(1.0 - m))`, by a series for small `m`";
    COUNT_PAST_ARRAY = "H23" "count-past-array" Deny
        "an index is past the end of its array"
        "clamp the count: `min(count, N)`";
    ZERO_DIRECTION = "H24" "zero-direction" Warn
        "a direction that is zero is normalised"
        "guard it: `v * inversesqrt(max(dot(v, v), 1.0e-30))`, or refuse it on the host";
    NEGATIVE_ATTENUATION = "H26" "negative-attenuation" Warn
        "with a negative coefficient the attenuation has a pole"
        "refuse negative coefficients on the host";
    ZERO_VECTOR = "" "zero-vector" Deny
        "a vector of length zero is normalised"
        "guard it: `v * inversesqrt(max(dot(v, v), 1.0e-30))`";
    OPPOSITE_VECTORS = "" "opposite-vectors" Deny
        "two opposite vectors add to zero, and the sum is normalised"
        "guard it: `v * inversesqrt(max(dot(v, v), 1.0e-30))`";
    DIVISION_BY_ZERO = "" "division-by-zero" Deny
        "it divides by zero"
        "keep the denominator away from zero with `max`";
    UNDEFINED_OPERATION = "" "undefined-operation" Deny
        "no specification gives this operation a value here"
        "keep its operands where it is defined";
    LARGE_VALUES = "" "large-values" Warn
        "the result is too large for a float of its kind"
        "let the host refuse such values";
    CANCELLATION = "" "cancellation" Warn
        "nearly equal numbers are subtracted"
        "rewrite the difference so that it is not of rounded numbers";
    ACCUMULATED_ERROR = "" "accumulated-error" Warn
        "rounding adds up to more than is allowed"
        "compute this part in fewer or better conditioned operations";
    ENDLESS_LOOP = "" "endless-loop" Deny
        "a loop does not end within the budget"
        "bound it by a constant: `i < min(count, N)`";
    DRIVER_NOT_FINITE = "" "driver-not-finite" Deny
        "a driver gives no finite number where the evaluator does"
        "keep operands of division, `pow`, `log` and `exp` where every device is held to an error";
    DRIVER_APART = "" "driver-apart" Warn
        "a driver is off by more than the evaluator is"
        "use operations of smaller permitted error: multiplications for `pow`, `x * inversesqrt(d)` for a division by a length";
}
