//! Reasons a fragment's light is undefined.
//!
//! Returned by [`light`](super::light); comparisons skip such fragments and count them by hazard.

use std::fmt;

use landfall_ir::analysis::hazard::Hazard;

/// The reason a result is undefined.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Undef {
    /// The light is at the fragment.
    LightAtFragment,
    /// The light is at the fragment, and its attenuation has no constant coefficient.
    LightAtFragmentUnattenuated,
    /// The camera is at the fragment, or closer than 1e-15.
    CameraAtFragment,
    /// The divisor of the attenuation is zero, negative or not finite.
    Attenuation,
    /// The light or the camera is farther than 1e18: squares overflow an `f32`.
    TooFar,
    /// The light is closer than 1e-15, but not at the fragment: squares underflow an `f32`.
    TooNear,
    /// Both angles of a soft cone are equal, and the fragment is at its edge.
    EqualCones,
    /// A cone with a single angle of zero.
    ZeroCone,
    /// Zero to the power of zero.
    ZeroToZero,
    /// Zero to a negative power.
    ZeroToNegative,
    /// The view is opposite to the light, so that there is no half vector.
    NoHalfVector,
    /// A normal or a direction is zero.
    ZeroVector,
    /// An uploaded number, or the sum, is not finite.
    NotFinite,
}

impl Undef {
    /// All reasons.
    pub const ALL: [Undef; 13] = [
        Undef::LightAtFragment,
        Undef::LightAtFragmentUnattenuated,
        Undef::CameraAtFragment,
        Undef::Attenuation,
        Undef::TooFar,
        Undef::TooNear,
        Undef::EqualCones,
        Undef::ZeroCone,
        Undef::ZeroToZero,
        Undef::ZeroToNegative,
        Undef::NoHalfVector,
        Undef::ZeroVector,
        Undef::NotFinite,
    ];

    /// Returns the hazard that leaves the fragment without a value.
    pub fn hazard(self) -> Hazard {
        match self {
            Undef::LightAtFragment => Hazard::LightAtFragment,
            Undef::NoHalfVector => Hazard::OppositeVectors,
            Undef::LightAtFragmentUnattenuated => Hazard::AttenuationAtLight,
            Undef::CameraAtFragment => Hazard::CameraAtFragment,
            Undef::Attenuation => Hazard::AttenuationUnset,
            Undef::TooFar => Hazard::Overflow,
            Undef::TooNear => Hazard::Underflow,
            Undef::EqualCones => Hazard::EqualCutOffs,
            Undef::ZeroCone => Hazard::ZeroWidthCone,
            Undef::ZeroToZero | Undef::ZeroToNegative => Hazard::PowOfZero,
            Undef::ZeroVector => Hazard::ZeroDirection,
            Undef::NotFinite => Hazard::NotFinite,
        }
    }
}

impl fmt::Display for Undef {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let what = match self {
            Undef::LightAtFragment => "the light is at the fragment",
            Undef::LightAtFragmentUnattenuated => {
                "the light is at the fragment and its attenuation divides by zero there"
            }
            Undef::CameraAtFragment => "the camera is at the fragment",
            Undef::Attenuation => "the attenuation divides by zero, a negative number or NaN",
            Undef::TooFar => "the distance is above 1e18",
            Undef::TooNear => "the distance is below 1e-15",
            Undef::EqualCones => "the fragment is at the edge of a cone whose angles are equal",
            Undef::ZeroCone => "the cone's only angle is zero",
            Undef::ZeroToZero => "the highlight is zero to the power of zero",
            Undef::ZeroToNegative => "the highlight is zero to a negative power",
            Undef::NoHalfVector => "the view is opposite to the light",
            Undef::ZeroVector => "a normal or direction is zero",
            Undef::NotFinite => "an uploaded number, or the sum, is not finite",
        };
        write!(f, "{}: {what}", self.hazard().code())
    }
}
