//! Places in shaders at which hazards may occur, and the kinds of code that lints report for them.
//!
//! Found by `hazards`; `landfall_lint::hazards` turns them into findings.

use super::hazard::Hazard;
use super::undefined::UndefinedKind;
use landfall_layout::source::Span;

/// A kind of code that a lint reports because of a hazard.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Kind {
    /// A difference of two points that is normalised and may be zero.
    UnguardedNormalize,
    AttenuationDivision,
    /// A cone factor divided by a difference that may be zero.
    ConeDivision,
    CosineCone,
    /// A cosine compared with degrees or radians.
    DegreesForCosine,
    PowOfNegative,
    /// A power whose base and exponent may be zero.
    PowOfZero,
    UninitialisedAccumulator,
    /// A highlight that is not cut off at the horizon.
    UngatedSpecular,
    /// An interpolated normal used without normalising it.
    UnnormalisedNormal,
    /// A normal normalised with its fourth component.
    Vec4Normalise,
    /// A loop over all slots of an array that has a count.
    LoopPastCount,
    /// A count that is not clamped to the array's length.
    UnclampedCount,
    /// A compensated sum that a compiler may simplify.
    KahanWithoutPrecise,
    /// An ambient term added for every light.
    AmbientPerLight,
    /// Positions in 16 bits.
    MediumpPosition,
    /// Another operation that is undefined for some of its operands.
    UnguardedOperation,
}

impl Kind {
    pub const ALL: [Kind; 17] = [
        Kind::UnguardedNormalize,
        Kind::AttenuationDivision,
        Kind::ConeDivision,
        Kind::CosineCone,
        Kind::DegreesForCosine,
        Kind::PowOfNegative,
        Kind::PowOfZero,
        Kind::UninitialisedAccumulator,
        Kind::UngatedSpecular,
        Kind::UnnormalisedNormal,
        Kind::Vec4Normalise,
        Kind::LoopPastCount,
        Kind::UnclampedCount,
        Kind::KahanWithoutPrecise,
        Kind::AmbientPerLight,
        Kind::MediumpPosition,
        Kind::UnguardedOperation,
    ];

    pub fn hazards(self) -> &'static [Hazard] {
        match self {
            Kind::UnguardedNormalize => {
                &[Hazard::LightAtFragment, Hazard::CameraAtFragment, Hazard::OppositeVectors]
            }
            Kind::AttenuationDivision => &[Hazard::AttenuationAtLight, Hazard::AttenuationUnset],
            Kind::ConeDivision => &[Hazard::EqualCutOffs, Hazard::ZeroWidthCone],
            Kind::CosineCone => &[Hazard::NarrowCone],
            Kind::DegreesForCosine => &[Hazard::ConeOutOfRange],
            Kind::PowOfNegative => &[Hazard::PowOfNegative],
            Kind::PowOfZero => &[Hazard::PowOfZero],
            Kind::UninitialisedAccumulator => &[Hazard::Uninitialised],
            Kind::UngatedSpecular => &[Hazard::HighlightFromBehind],
            Kind::UnnormalisedNormal => &[Hazard::UnnormalisedNormal],
            Kind::Vec4Normalise => &[Hazard::Vec4Normalise],
            Kind::LoopPastCount => &[Hazard::LoopPastCount],
            Kind::UnclampedCount => &[Hazard::CountPastArray],
            Kind::KahanWithoutPrecise => &[Hazard::KahanWithoutPrecise],
            Kind::AmbientPerLight => &[Hazard::AmbientPerLight],
            Kind::MediumpPosition => &[Hazard::MediumpPosition],
            Kind::UnguardedOperation => {
                &[Hazard::UndefinedOperation, Hazard::DivisionByZero, Hazard::ZeroVector]
            }
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Certainty {
    /// It occurs only for inputs that the program may never produce.
    Possible,
    /// It occurs for ordinary inputs.
    Likely,
    /// It follows from the text alone.
    Certain,
}

impl Certainty {
    pub fn name(self) -> &'static str {
        match self {
            Certainty::Possible => "possible",
            Certainty::Likely => "likely",
            Certainty::Certain => "certain",
        }
    }
}

/// A place in a shader where a hazard may occur.
#[derive(Clone, Debug, PartialEq)]
pub struct Occurrence {
    /// The lint that reports it.
    pub kind: Kind,
    pub hazard: Hazard,
    pub certainty: Certainty,
    pub span: Span,
    /// The path of the operand, or an empty string if it has no name: `pointLights[].position`.
    pub about: String,
    /// A number for the message: the number of slots, or the constant in a comparison.
    pub number: Option<f64>,
    /// Why the operation is undefined, where it is a single one.
    pub undefined: Option<UndefinedKind>,
}

/// The bound of the index in an access to an array of lights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum IndexBound {
    Fixed(u64),
    /// A loop up to a constant.
    Constant(u64),
    /// A loop up to the count, clamped to a constant.
    ClampedCount,
    /// A loop up to the count.
    Count,
    /// A loop up to the length of a runtime-sized array.
    Length,
    Unknown,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Access {
    /// The index of the array among the lights of the analysis.
    pub light: usize,
    pub bound: IndexBound,
    pub span: Span,
}

#[derive(Clone, Debug, Default, PartialEq)]
pub struct HazardReport {
    /// Hazards in the order of the text, each place once.
    pub hazards: Vec<Occurrence>,
    /// Accesses to arrays of lights in the order of evaluation, each place once.
    pub accesses: Vec<Access>,
    /// Whether the analysis stopped early because the shader is too long.
    pub cut_short: bool,
}
