//! Reasons a fragment's light is undefined.
//!
//! Returned by [`light`](super::light); comparisons skip such fragments and count them by hazard.

use std::fmt;

use landfall_ir::analysis::hazard::Hazard;

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum UndefinedReason {
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
    ZeroToZero,
    ZeroToNegative,
    /// The view is opposite to the light, so that there is no half vector.
    NoHalfVector,
    /// A normal or a direction is zero.
    ZeroVector,
    /// An uploaded number, or the sum, is not finite.
    NotFinite,
}

impl UndefinedReason {
    pub const ALL: [UndefinedReason; 13] = [
        UndefinedReason::LightAtFragment,
        UndefinedReason::LightAtFragmentUnattenuated,
        UndefinedReason::CameraAtFragment,
        UndefinedReason::Attenuation,
        UndefinedReason::TooFar,
        UndefinedReason::TooNear,
        UndefinedReason::EqualCones,
        UndefinedReason::ZeroCone,
        UndefinedReason::ZeroToZero,
        UndefinedReason::ZeroToNegative,
        UndefinedReason::NoHalfVector,
        UndefinedReason::ZeroVector,
        UndefinedReason::NotFinite,
    ];

    /// Returns the hazard that leaves the fragment without a value.
    pub fn hazard(self) -> Hazard {
        match self {
            UndefinedReason::LightAtFragment => Hazard::LightAtFragment,
            UndefinedReason::NoHalfVector => Hazard::OppositeVectors,
            UndefinedReason::LightAtFragmentUnattenuated => Hazard::AttenuationAtLight,
            UndefinedReason::CameraAtFragment => Hazard::CameraAtFragment,
            UndefinedReason::Attenuation => Hazard::AttenuationUnset,
            UndefinedReason::TooFar => Hazard::Overflow,
            UndefinedReason::TooNear => Hazard::Underflow,
            UndefinedReason::EqualCones => Hazard::EqualCutOffs,
            UndefinedReason::ZeroCone => Hazard::ZeroWidthCone,
            UndefinedReason::ZeroToZero | UndefinedReason::ZeroToNegative => Hazard::PowOfZero,
            UndefinedReason::ZeroVector => Hazard::ZeroDirection,
            UndefinedReason::NotFinite => Hazard::NotFinite,
        }
    }
}

impl fmt::Display for UndefinedReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let what = match self {
            UndefinedReason::LightAtFragment => "the light is at the fragment",
            UndefinedReason::LightAtFragmentUnattenuated => {
                "the light is at the fragment and its attenuation divides by zero there"
            }
            UndefinedReason::CameraAtFragment => "the camera is at the fragment",
            UndefinedReason::Attenuation => {
                "the attenuation divides by zero, a negative number or NaN"
            }
            UndefinedReason::TooFar => {
                "the light or the camera is farther than 1e18 from the fragment"
            }
            UndefinedReason::TooNear => "the light is closer than 1e-15 to the fragment",
            UndefinedReason::EqualCones => {
                "the fragment is at the edge of a cone whose angles are equal"
            }
            UndefinedReason::ZeroCone => "the cone's only angle is zero",
            UndefinedReason::ZeroToZero => "the highlight is zero to the power of zero",
            UndefinedReason::ZeroToNegative => "the highlight is zero to a negative power",
            UndefinedReason::NoHalfVector => "the view is opposite to the light",
            UndefinedReason::ZeroVector => "a normal or direction is zero",
            UndefinedReason::NotFinite => "an uploaded number, or the sum, is not finite",
        };
        write!(f, "{}: {what}", self.hazard().code())
    }
}
