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

use landfall_layout::finding::Level;

pub use threshold::Threshold;

/// A way in which lighting code computes wrong or undefined numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Hazard {
    LightAtFragment,
    /// Attenuation without a constant term at the light itself.
    AttenuationAtLight,
    CameraAtFragment,
    /// Attenuation whose coefficients are all zero.
    AttenuationUnset,
    /// A loop over slots that hold no light.
    LoopPastCount,
    /// A square above the range of `f32`.
    Overflow,
    /// A square below the range of `f32`.
    Underflow,
    /// A soft cone whose two angles are equal.
    EqualCutOffs,
    /// A soft cone whose inner angle is the wider one.
    SwappedCutOffs,
    /// An angle where a cosine is expected.
    ConeOutOfRange,
    /// A cone of angle zero.
    ZeroWidthCone,
    /// Zero to a power of zero or less.
    PowOfZero,
    PowOfNegative,
    /// A cosine rounded above one.
    BaseAboveOne,
    /// A variable read before it is written.
    Uninitialised,
    /// A highlight of a light below the horizon.
    HighlightFromBehind,
    /// A normal whose length is not one.
    UnnormalisedNormal,
    /// A normal normalised with its fourth component.
    Vec4Normalise,
    FarFromOrigin,
    /// A cone too narrow for cosines.
    NarrowCone,
    /// A fragment at the edge of a cone without a ramp.
    ConeEdge,
    LargeExponent,
    AmbientPerLight,
    /// A compensated sum that a compiler may simplify.
    KahanWithoutPrecise,
    /// Positions in 16 bits.
    MediumpPosition,
    /// An index past the end of an array.
    CountPastArray,
    ZeroDirection,
    NegativeAttenuation,
    /// An attenuation with only a constant term.
    LoneConstant,
    /// An uploaded number or a sum that is not finite.
    NotFinite,
    /// A zero vector of any kind normalised.
    ZeroVector,
    /// The sum of opposite vectors normalised.
    OppositeVectors,
    /// A vector parallel to the one that is taken out of it.
    ParallelVectors,
    DivisionByZero,
    NegativeRemainder,
    /// An index that its array does not have.
    IndexOutOfBounds,
    UndefinedOperation,
    /// A result above the range of its type.
    LargeValues,
    /// A difference of nearly equal numbers.
    Cancellation,
    AccumulatedError,
    /// A comparison that rounding decides.
    BranchDivergence,
    /// A loop without an end.
    EndlessLoop,
    DriverNotFinite,
    /// A driver less accurate than the interpreter.
    DriverApart,
}

/// The catalogue entry of a [`Hazard`].
#[derive(Debug, PartialEq)]
#[non_exhaustive]
pub struct HazardInfo {
    /// Kebab-case name: `narrow-cone`.
    pub code: &'static str,
    /// The name for people: `narrow cone`.
    pub name: &'static str,
    /// The label that earlier reports printed instead of the name: `H17`. Hazards of plain
    /// arithmetic, and newer ones, have none.
    pub label: Option<&'static str>,
    /// Other codes: earlier spellings, and the codes of diagnostics that reject its inputs.
    pub aliases: &'static [&'static str],
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
    /// Every hazard; those of lighting before those of plain arithmetic.
    pub const ALL: [Hazard; 44] = [
        Hazard::LightAtFragment,
        Hazard::AttenuationAtLight,
        Hazard::CameraAtFragment,
        Hazard::AttenuationUnset,
        Hazard::LoopPastCount,
        Hazard::Overflow,
        Hazard::Underflow,
        Hazard::EqualCutOffs,
        Hazard::SwappedCutOffs,
        Hazard::ConeOutOfRange,
        Hazard::ZeroWidthCone,
        Hazard::PowOfZero,
        Hazard::PowOfNegative,
        Hazard::BaseAboveOne,
        Hazard::Uninitialised,
        Hazard::HighlightFromBehind,
        Hazard::UnnormalisedNormal,
        Hazard::Vec4Normalise,
        Hazard::FarFromOrigin,
        Hazard::NarrowCone,
        Hazard::ConeEdge,
        Hazard::LargeExponent,
        Hazard::AmbientPerLight,
        Hazard::KahanWithoutPrecise,
        Hazard::MediumpPosition,
        Hazard::CountPastArray,
        Hazard::ZeroDirection,
        Hazard::NegativeAttenuation,
        Hazard::LoneConstant,
        Hazard::NotFinite,
        Hazard::ZeroVector,
        Hazard::OppositeVectors,
        Hazard::ParallelVectors,
        Hazard::DivisionByZero,
        Hazard::NegativeRemainder,
        Hazard::IndexOutOfBounds,
        Hazard::UndefinedOperation,
        Hazard::LargeValues,
        Hazard::Cancellation,
        Hazard::AccumulatedError,
        Hazard::BranchDivergence,
        Hazard::EndlessLoop,
        Hazard::DriverNotFinite,
        Hazard::DriverApart,
    ];

    pub fn info(self) -> &'static HazardInfo {
        match self {
            Hazard::LightAtFragment => &geometry::LIGHT_AT_FRAGMENT,
            Hazard::AttenuationAtLight => &geometry::ATTENUATION_AT_LIGHT,
            Hazard::CameraAtFragment => &geometry::CAMERA_AT_FRAGMENT,
            Hazard::AttenuationUnset => &geometry::ATTENUATION_UNSET,
            Hazard::LoopPastCount => &model::LOOP_PAST_COUNT,
            Hazard::Overflow => &geometry::OVERFLOW,
            Hazard::Underflow => &geometry::UNDERFLOW,
            Hazard::EqualCutOffs => &geometry::EQUAL_CUT_OFFS,
            Hazard::SwappedCutOffs => &geometry::SWAPPED_CUT_OFFS,
            Hazard::ConeOutOfRange => &geometry::CONE_OUT_OF_RANGE,
            Hazard::ZeroWidthCone => &geometry::ZERO_WIDTH_CONE,
            Hazard::PowOfZero => &model::POW_OF_ZERO,
            Hazard::PowOfNegative => &model::POW_OF_NEGATIVE,
            Hazard::BaseAboveOne => &model::BASE_ABOVE_ONE,
            Hazard::Uninitialised => &model::UNINITIALISED,
            Hazard::HighlightFromBehind => &model::HIGHLIGHT_FROM_BEHIND,
            Hazard::UnnormalisedNormal => &model::UNNORMALISED_NORMAL,
            Hazard::Vec4Normalise => &model::VEC4_NORMALISE,
            Hazard::FarFromOrigin => &geometry::FAR_FROM_ORIGIN,
            Hazard::NarrowCone => &geometry::NARROW_CONE,
            Hazard::ConeEdge => &geometry::CONE_EDGE,
            Hazard::LargeExponent => &model::LARGE_EXPONENT,
            Hazard::AmbientPerLight => &model::AMBIENT_PER_LIGHT,
            Hazard::KahanWithoutPrecise => &model::KAHAN_WITHOUT_PRECISE,
            Hazard::MediumpPosition => &geometry::MEDIUMP_POSITION,
            Hazard::CountPastArray => &model::COUNT_PAST_ARRAY,
            Hazard::ZeroDirection => &geometry::ZERO_DIRECTION,
            Hazard::NegativeAttenuation => &geometry::NEGATIVE_ATTENUATION,
            Hazard::LoneConstant => &geometry::LONE_CONSTANT,
            Hazard::NotFinite => &arithmetic::NOT_FINITE,
            Hazard::ZeroVector => &arithmetic::ZERO_VECTOR,
            Hazard::OppositeVectors => &arithmetic::OPPOSITE_VECTORS,
            Hazard::ParallelVectors => &arithmetic::PARALLEL_VECTORS,
            Hazard::DivisionByZero => &arithmetic::DIVISION_BY_ZERO,
            Hazard::NegativeRemainder => &arithmetic::NEGATIVE_REMAINDER,
            Hazard::IndexOutOfBounds => &arithmetic::INDEX_OUT_OF_BOUNDS,
            Hazard::UndefinedOperation => &arithmetic::UNDEFINED_OPERATION,
            Hazard::LargeValues => &arithmetic::LARGE_VALUES,
            Hazard::Cancellation => &arithmetic::CANCELLATION,
            Hazard::AccumulatedError => &arithmetic::ACCUMULATED_ERROR,
            Hazard::BranchDivergence => &arithmetic::BRANCH_DIVERGENCE,
            Hazard::EndlessLoop => &arithmetic::ENDLESS_LOOP,
            Hazard::DriverNotFinite => &arithmetic::DRIVER_NOT_FINITE,
            Hazard::DriverApart => &arithmetic::DRIVER_APART,
        }
    }

    /// Returns its code: `narrow-cone`.
    pub fn code(self) -> &'static str {
        self.info().code
    }

    /// Returns whether it concerns arithmetic alone, without lights or cameras.
    pub fn is_arithmetic(self) -> bool {
        // By the order of the declarations: everything from `NotFinite` on is arithmetic.
        self >= Hazard::NotFinite
    }

    /// Returns the hazard of that code, alias or label.
    pub fn named(name: &str) -> Option<Hazard> {
        let by = |is: &dyn Fn(&HazardInfo) -> bool| Hazard::ALL.into_iter().find(|h| is(h.info()));
        // A code wins over an alias of another hazard: earlier spellings may have been given away
        // since.
        by(&|info| info.code == name)
            .or_else(|| by(&|info| info.aliases.contains(&name)))
            .or_else(|| by(&|info| info.label == Some(name)))
    }
}
