//! Places in shaders at which hazards may occur, and the kinds of code that lints report for them.
//!
//! Found by `hazards`; `landfall_lint::hazard_findings` turns them into findings.

use super::hazard::Hazard;
use super::undefined::UndefinedKind;
use landfall_layout::named;
use landfall_layout::source::Span;

macro_rules! kinds {
    ($($(#[$doc:meta])* $kind:ident: $($hazard:ident)+;)*) => {
        /// A kind of code that a lint reports because of a hazard.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub enum Kind {
            $($(#[$doc])* $kind,)*
        }

        impl Kind {
            pub const ALL: &[Kind] = &[$(Kind::$kind),*];

            pub fn hazards(self) -> &'static [Hazard] {
                match self {
                    $(Kind::$kind => &[$(Hazard::$hazard),+],)*
                }
            }
        }
    };
}

kinds! {
    /// A difference of two points that is normalised and may be zero.
    UnguardedNormalize: LightAtFragment CameraAtFragment OppositeVectors;
    AttenuationDivision: AttenuationAtLight AttenuationUnset;
    /// A cone factor divided by a difference that may be zero.
    ConeDivision: EqualCutOffs ZeroWidthCone;
    CosineCone: NarrowCone;
    /// A cosine compared with degrees or radians.
    DegreesForCosine: ConeOutOfRange;
    PowOfNegative: PowOfNegative;
    /// A power whose base and exponent may be zero.
    PowOfZero: PowOfZero;
    UninitialisedAccumulator: Uninitialised;
    /// A highlight that is not cut off at the horizon.
    UngatedSpecular: HighlightFromBehind;
    /// An interpolated normal used without normalising it.
    UnnormalisedNormal: UnnormalisedNormal;
    /// A normal normalised with its fourth component.
    Vec4Normalise: Vec4Normalise;
    /// A loop over all slots of an array that has a count.
    LoopPastCount: LoopPastCount;
    /// A count that is not clamped to the array's length.
    UnclampedCount: CountPastArray;
    /// A compensated sum that a compiler may simplify.
    KahanWithoutPrecise: KahanWithoutPrecise;
    /// An ambient term added for every light.
    AmbientPerLight: AmbientPerLight;
    /// Positions in 16 bits.
    MediumpPosition: MediumpPosition;
    /// Another operation that is undefined for some of its operands.
    UnguardedOperation: UndefinedOperation DivisionByZero ZeroVector;
}

named! {
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
    pub enum Certainty {
        /// It occurs only for inputs that the program may never produce.
        Possible = "possible",
        /// It occurs for ordinary inputs.
        Likely = "likely",
        /// It follows from the text alone.
        Certain = "certain",
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

impl Occurrence {
    /// Creates the report of a hazard, by the lint whose kind of code has it.
    pub fn new(hazard: Hazard, certainty: Certainty, span: Span, about: String) -> Occurrence {
        let mut kinds = Kind::ALL.iter().copied();
        let kind = kinds.find(|kind| kind.hazards().contains(&hazard));
        let kind = kind.unwrap_or(Kind::UnguardedOperation);
        Occurrence { kind, hazard, certainty, span, about, number: None, undefined: None }
    }
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
