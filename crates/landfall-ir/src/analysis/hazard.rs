//! The catalogue of hazards: the known ways in which lighting code computes wrong numbers.
//!
//! A hazard occurs for some inputs: a zero vector is normalised, two cosines cancel. Lints
//! ([`Kind`](super::occurrence::Kind)) report code in which one may occur, `stress` reports inputs
//! for which it does, the reference reports fragments that have no value because of one, and the
//! scene parser rejects some of those inputs. All of them use the code, texts, [`Threshold`] and
//! robust form of this catalogue; `landfall rule CODE` prints an entry.

mod arithmetic;
mod geometry;
mod model;
pub mod threshold;

use landfall_layout::diagnostic::Code;
use landfall_layout::finding::Level;

pub use threshold::Threshold;

macro_rules! hazards {
    ($($(#[$doc:meta])* $hazard:ident = $module:ident::$info:ident,)*) => {
        /// A way in which lighting code computes wrong or undefined numbers.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        #[non_exhaustive]
        pub enum Hazard {
            $($(#[$doc])* $hazard,)*
        }

        impl Hazard {
            /// Every hazard; those of lighting before those of plain arithmetic.
            pub const ALL: [Hazard; [$(stringify!($hazard)),*].len()] = [$(Hazard::$hazard),*];

            pub fn info(self) -> &'static HazardInfo {
                match self {
                    $(Hazard::$hazard => &$module::$info,)*
                }
            }
        }
    };
}

hazards! {
    LightAtFragment = geometry::LIGHT_AT_FRAGMENT,
    /// Attenuation without a constant term at the light itself.
    AttenuationAtLight = geometry::ATTENUATION_AT_LIGHT,
    CameraAtFragment = geometry::CAMERA_AT_FRAGMENT,
    /// Attenuation whose coefficients are all zero.
    AttenuationUnset = geometry::ATTENUATION_UNSET,
    /// A loop over slots that hold no light.
    LoopPastCount = model::LOOP_PAST_COUNT,
    /// A square above the range of `f32`.
    Overflow = geometry::OVERFLOW,
    /// A square below the range of `f32`.
    Underflow = geometry::UNDERFLOW,
    /// A soft cone whose two angles are equal.
    EqualCutOffs = geometry::EQUAL_CUT_OFFS,
    /// A soft cone whose inner angle is the wider one.
    SwappedCutOffs = geometry::SWAPPED_CUT_OFFS,
    /// An angle where a cosine is expected.
    ConeOutOfRange = geometry::CONE_OUT_OF_RANGE,
    /// A cone of angle zero.
    ZeroWidthCone = geometry::ZERO_WIDTH_CONE,
    /// Zero to a power of zero or less.
    PowOfZero = model::POW_OF_ZERO,
    PowOfNegative = model::POW_OF_NEGATIVE,
    /// A cosine rounded above one.
    BaseAboveOne = model::BASE_ABOVE_ONE,
    /// A variable read before it is written.
    Uninitialised = model::UNINITIALISED,
    /// A highlight of a light below the horizon.
    HighlightFromBehind = model::HIGHLIGHT_FROM_BEHIND,
    /// A normal whose length is not one.
    UnnormalisedNormal = model::UNNORMALISED_NORMAL,
    /// A normal normalised with its fourth component.
    Vec4Normalise = model::VEC4_NORMALISE,
    FarFromOrigin = geometry::FAR_FROM_ORIGIN,
    /// A cone too narrow for cosines.
    NarrowCone = geometry::NARROW_CONE,
    /// A fragment at the edge of a cone without a ramp.
    ConeEdge = geometry::CONE_EDGE,
    LargeExponent = model::LARGE_EXPONENT,
    AmbientPerLight = model::AMBIENT_PER_LIGHT,
    /// A compensated sum that a compiler may simplify.
    KahanWithoutPrecise = model::KAHAN_WITHOUT_PRECISE,
    /// Positions in 16 bits.
    MediumpPosition = geometry::MEDIUMP_POSITION,
    /// An index past the end of an array.
    CountPastArray = model::COUNT_PAST_ARRAY,
    ZeroDirection = geometry::ZERO_DIRECTION,
    NegativeAttenuation = geometry::NEGATIVE_ATTENUATION,
    /// An attenuation with only a constant term.
    LoneConstant = geometry::LONE_CONSTANT,
    /// An uploaded number or a sum that is not finite.
    NotFinite = arithmetic::NOT_FINITE,
    /// A zero vector of any kind normalised.
    ZeroVector = arithmetic::ZERO_VECTOR,
    /// The sum of opposite vectors normalised.
    OppositeVectors = arithmetic::OPPOSITE_VECTORS,
    /// A vector parallel to the one that is taken out of it.
    ParallelVectors = arithmetic::PARALLEL_VECTORS,
    DivisionByZero = arithmetic::DIVISION_BY_ZERO,
    NegativeRemainder = arithmetic::NEGATIVE_REMAINDER,
    /// An index that its array does not have.
    IndexOutOfBounds = arithmetic::INDEX_OUT_OF_BOUNDS,
    UndefinedOperation = arithmetic::UNDEFINED_OPERATION,
    /// A result above the range of its type.
    LargeValues = arithmetic::LARGE_VALUES,
    /// A difference of nearly equal numbers.
    Cancellation = arithmetic::CANCELLATION,
    AccumulatedError = arithmetic::ACCUMULATED_ERROR,
    /// A comparison that rounding decides.
    BranchDivergence = arithmetic::BRANCH_DIVERGENCE,
    /// A loop without an end.
    EndlessLoop = arithmetic::ENDLESS_LOOP,
    DriverNotFinite = arithmetic::DRIVER_NOT_FINITE,
    /// A driver less accurate than the interpreter.
    DriverApart = arithmetic::DRIVER_APART,
}

/// The catalogue entry of a [`Hazard`].
#[derive(Debug, PartialEq)]
#[non_exhaustive]
pub struct HazardInfo {
    /// Kebab-case name: `narrow-cone`.
    pub code: &'static str,
    /// The name for people: `narrow cone`.
    pub name: &'static str,
    /// The level of a finding about inputs that occur in scenes.
    pub level: Level,
    /// The hazard's effect, as a clause without a full stop.
    pub what: &'static str,
    /// The effect on the picture, with measured numbers.
    pub why: &'static str,
    /// The number that separates inputs for which it occurs from the others, if there is one.
    pub threshold: Option<&'static Threshold>,
    /// The form of the code, or the check on the host, that avoids it.
    pub robust: &'static str,
    /// The source of the facts.
    pub citation: &'static str,
}

impl Hazard {
    /// Returns its code: `narrow-cone`.
    pub fn code(self) -> &'static str {
        self.info().code
    }

    /// Returns whether it concerns arithmetic alone, without lights or cameras.
    pub fn is_arithmetic(self) -> bool {
        // By the order of the declarations: everything from `NotFinite` on is arithmetic.
        self >= Hazard::NotFinite
    }

    /// Returns the code of the diagnostic that rejects its inputs, if they are rejected.
    pub fn rejection(self) -> Option<&'static str> {
        let code = match self {
            Hazard::AttenuationUnset => Code::ZeroAttenuation,
            Hazard::EqualCutOffs => Code::HardCone,
            Hazard::SwappedCutOffs => Code::SwappedCone,
            Hazard::ConeOutOfRange => Code::WrongUnit,
            Hazard::ZeroWidthCone => Code::EmptyCone,
            Hazard::PowOfZero => Code::ZeroShininess,
            Hazard::CountPastArray => Code::TooManyLights,
            Hazard::NegativeAttenuation => Code::NegativeColor,
            _ => return None,
        };
        Some(code.name())
    }

    /// Returns the hazard of that code, or the one whose inputs a diagnostic of that code rejects.
    pub fn named(code: &str) -> Option<Hazard> {
        let is_named = |hazard: &Hazard| hazard.code() == code || hazard.rejection() == Some(code);
        Hazard::ALL.into_iter().find(is_named)
    }
}
