//! Reasons a fragment's light is undefined.
//!
//! Returned by [`light`](super::light); comparisons skip such fragments and count them by hazard.

use std::fmt;

use landfall_ir::analysis::hazard::Hazard;
use landfall_layout::named;

named! {
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
    pub enum UndefinedReason {
        LightAtFragment = "the light is at the fragment",
        /// The light is at the fragment, and its attenuation has no constant coefficient.
        LightAtFragmentUnattenuated =
            "the light is at the fragment and its attenuation divides by zero there",
        /// The camera is at the fragment, or closer than 1e-15.
        CameraAtFragment = "the camera is at the fragment",
        /// The divisor of the attenuation is zero, negative or not finite.
        Attenuation = "the attenuation divides by zero, a negative number or NaN",
        /// The light or the camera is farther than 1e18: squares overflow an `f32`.
        TooFar = "the light or the camera is farther than 1e18 from the fragment",
        /// The light is closer than 1e-15, but not at the fragment: squares underflow an `f32`.
        TooNear = "the light is closer than 1e-15 to the fragment",
        /// Both angles of a soft cone are equal, and the fragment is at its edge.
        EqualCones = "the fragment is at the edge of a cone whose angles are equal",
        /// A cone with a single angle of zero.
        ZeroCone = "the cone's only angle is zero",
        ZeroToZero = "the highlight is zero to the power of zero",
        ZeroToNegative = "the highlight is zero to a negative power",
        /// The view is opposite to the light, so that there is no half vector.
        NoHalfVector = "the view is opposite to the light",
        /// A normal or a direction is zero.
        ZeroVector = "a normal or direction is zero",
        /// An uploaded number, or the sum, is not finite.
        NotFinite = "an uploaded number, or the sum, is not finite",
    }

    const ALL;
}

impl UndefinedReason {
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
        write!(f, "{}: {}", self.hazard().code(), self.name())
    }
}
