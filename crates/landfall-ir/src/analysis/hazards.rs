//! Where a shader's lighting may leave the numbers: found by following values through its IR.
//!
//! `walk` runs a [`Module`] on names instead of numbers, from its entry points, calls inlined:
//! every value is a node of a `graph`, what is known of it is `facts`, and `judge` looks at each
//! operation when it is met, under the conditions that hold there. What it says are [`Occurrence`]s
//! with places in the user's text; `landfall_lint::hazards` makes findings of them.

mod assume;
mod control;
mod expression;
mod facts;
mod graph;
mod judge;
mod memory;
mod specular;
mod verdict;
mod walk;

use crate::analysis::hazard::Hazard;
use crate::analysis::roles::Held;
use landfall_layout::source::{Language, Source, Span, Stage};
use landfall_layout::{Diagnostic, Options};

use crate::module::Module;

/// A kind of hazard: each is a lint.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Kind {
    /// A difference of two points is normalised, which may be zero.
    UnguardedNormalize,
    /// Attenuation whose denominator may be zero.
    AttenuationDivision,
    /// A cone's factor divided by a difference that may be zero.
    ConeDivision,
    /// A cone as a difference of cosines.
    CosineCone,
    /// A cosine compared with degrees or radians.
    DegreesForCosine,
    /// A power of what may be negative.
    PowOfNegative,
    /// A power of what may be zero, to what may be zero.
    PowOfZero,
    /// A sum that begins with no value.
    UninitialisedAccumulator,
    /// A highlight on the far side of the surface.
    UngatedSpecular,
    /// An interpolated normal used as it is.
    UnnormalisedNormal,
    /// A normal normalised with its fourth component.
    Vec4Normalise,
    /// A loop over all slots of an array that has a count.
    LoopPastCount,
    /// A count that nothing keeps inside the array.
    UnclampedCount,
    /// A compensated sum that a compiler may undo.
    KahanWithoutPrecise,
    /// An ambient term counted once a light.
    AmbientPerLight,
    /// Positions in 16 bits.
    MediumpPosition,
}

impl Kind {
    /// Every kind.
    pub const ALL: [Kind; 16] = [
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
    ];

    /// Returns the hazards that code of this kind may meet.
    pub fn hazards(self) -> &'static [Hazard] {
        match self {
            Kind::UnguardedNormalize => &[Hazard::LightAtFragment, Hazard::CameraAtFragment],
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
        }
    }
}

/// How sure it is that some input meets the hazard.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Certainty {
    /// Only inputs the program may never give do.
    Possible,
    /// Ordinary inputs do.
    Likely,
    /// The text alone shows it.
    Certain,
}

impl Certainty {
    /// The word messages and JSON use.
    pub fn name(self) -> &'static str {
        match self {
            Certainty::Possible => "possible",
            Certainty::Likely => "likely",
            Certainty::Certain => "certain",
        }
    }
}

/// A place in a shader where a hazard may be met.
#[derive(Clone, Debug, PartialEq)]
pub struct Occurrence {
    /// The lint that reports it.
    pub kind: Kind,
    /// What may happen.
    pub hazard: Hazard,
    /// How sure it is.
    pub certainty: Certainty,
    /// The operation.
    pub span: Span,
    /// What it is done to, as far as that has a name: `pointLights[].position`.
    pub about: String,
    /// A number the message needs: slots, or the constant compared with.
    pub number: Option<f64>,
}

/// What keeps the index of an access to an array of lights in bounds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bound {
    /// The index is a constant.
    Fixed(u64),
    /// A loop up to a constant.
    Constant(u64),
    /// A loop up to the count, and to a constant besides.
    ClampedCount,
    /// A loop up to the count.
    Count,
    /// A loop up to the length of a runtime-sized array.
    Length,
    /// Something else.
    Unknown,
}

/// An access to an array of lights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Access {
    /// The array: its number among the lights that were asked about.
    pub light: usize,
    /// What bounds the index.
    pub bound: Bound,
    /// Where.
    pub span: Span,
}

/// What was found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Found {
    /// Hazards in the order of the text, each place once.
    pub hazards: Vec<Occurrence>,
    /// Accesses to arrays of lights in the order they were met, each place once.
    pub accesses: Vec<Access>,
    /// Whether the shader was too long to be followed to its end.
    pub cut_short: bool,
}

/// Follows the values of a shader whose lights are those.
///
/// # Errors
/// Why the shader cannot be followed: what is wrong with it, or what in it cannot run.
pub fn find(
    source: &Source,
    options: &Options,
    lights: &[Held<'_>],
) -> Result<Found, Vec<Diagnostic>> {
    let module = Module::unchecked(source, options)?;
    let precise = source.language == Language::Glsl
        && source.text.split(|c: char| !c.is_alphanumeric() && c != '_').any(|w| w == "precise");
    let setting = Setting {
        language: source.language,
        fragment: source.stage.is_none_or(|stage| stage == Stage::Fragment),
        precise,
    };
    crate::stack::on_a_large_stack(|| Ok(walk::follow(&module, lights, setting)))
}

/// What holds for the shader as a whole.
#[derive(Clone, Copy, Debug)]
struct Setting {
    language: Language,
    /// Whether inputs may be interpolated.
    fragment: bool,
    /// Whether some of its sums are declared `precise`.
    precise: bool,
}
