//! What each hazard is called where it is: the message, and the form that has it not.

use landfall_ir::analysis::hazard::{Hazard, Threshold};
use landfall_ir::analysis::hazards::{Certainty, Kind, Occurrence};
use landfall_layout::source::Language;

/// The words of one hazard.
pub(super) struct Words {
    pub message: String,
    /// A word at the place.
    pub text: String,
    pub notes: Vec<String>,
    pub help: String,
}

pub(super) fn of(hazard: &Occurrence, language: Language) -> Words {
    let glsl = language == Language::Glsl;
    let root = if glsl { "inversesqrt" } else { "inverseSqrt" };
    let about = match hazard.about.as_str() {
        "" => "it".to_string(),
        path => format!("`{path}`"),
    };
    let threshold = hazard.hazard.info().threshold;
    let least = threshold.map(Threshold::literal).unwrap_or_default();
    let least_square = threshold.map(Threshold::squared_literal).unwrap_or_default();
    let number = hazard.number.unwrap_or(0.0);
    let mut notes = Vec::new();
    let (message, text, help) = match hazard.kind {
        Kind::UnguardedNormalize => {
            let where_ = match hazard.hazard {
                Hazard::CameraAtFragment => format!("where {about}, the camera, is at the surface"),
                _ => format!("where a light's {about} is at the surface"),
            };
            (
                format!("a zero vector is normalised {where_}"),
                "0 / 0",
                format!("`v * {root}(max(dot(v, v), {least_square}))` keeps a zero vector zero"),
            )
        }
        Kind::AttenuationDivision if hazard.hazard == Hazard::AttenuationAtLight => (
            format!("the light is divided by its squared distance, 0 where {about} is the surface"),
            "may divide by 0",
            format!("divide by `max(dot(v, v), {least})`: a light of 1 cm in metres"),
        ),
        Kind::AttenuationDivision => (
            format!("the attenuation divides by 0 while {about} and the other coefficients are 0"),
            "may divide by 0",
            format!(
                "`1.0 / max(constant + d * (linear + quadratic * d), {least})` has always a value"
            ),
        ),
        Kind::ConeDivision if hazard.hazard == Hazard::ZeroWidthCone => (
            format!("the cone divides by 0 where the angle of {about} is 0"),
            "may divide by 0",
            format!("divide by `max(1.0 - cutoff, {least})`"),
        ),
        Kind::ConeDivision => (
            format!("the cone divides by 0 where the angle of {about} equals the other one"),
            "may divide by 0",
            format!("divide by `max(inner - outer, {least})`: equal angles are then a hard edge"),
        ),
        Kind::CosineCone => (
            format!(
                "the cone compares cosines with {about}, which lose their digits below 1 degree"
            ),
            "cosines near 1",
            "with `e = L - D` of the unit vectors, compare `0.5 * dot(e, e)` with `1.0 - cosine`"
                .to_string(),
        ),
        Kind::DegreesForCosine => {
            let than = match hazard.number {
                Some(number) => format!("`{number}`, which no cosine reaches or means"),
                None if hazard.certainty == Certainty::Possible => {
                    format!("{about}, which its name calls an angle")
                }
                None => format!("{about}, which is an angle by its name or comment"),
            };
            (
                format!("a cosine is compared with {than}"),
                "an angle for a cosine",
                "compare with the cosine: `cos(radians(angle))`, computed once by the program"
                    .to_string(),
            )
        }
        Kind::PowOfNegative => {
            let how = match hazard.certainty {
                Certainty::Possible => "may be negative, if only by rounding",
                Certainty::Likely | Certainty::Certain => "is negative for half of all directions",
            };
            (
                format!("the base of this power {how}: its value is undefined"),
                "negative base",
                "clamp the base: `pow(clamp(x, 0.0, 1.0), n)`".to_string(),
            )
        }
        Kind::PowOfZero => {
            let exponent = match hazard.about.as_str() {
                "" => "the exponent".to_string(),
                path => format!("`{path}`"),
            };
            (
                format!(
                    "the base of this power may be 0, and it is undefined where {exponent} is 0"
                ),
                "0 to the power of 0",
                match glsl {
                    true => "write `x > 0.0 ? pow(min(x, 1.0), n) : 0.0`".to_string(),
                    false => "write `select(0.0, pow(min(x, 1.0), n), x > 0.0)`".to_string(),
                },
            )
        }
        Kind::UninitialisedAccumulator => (
            format!("{about} is added to before it has a value"),
            "undefined here",
            "give it a value where it is declared: `= vec3(0.0)`".to_string(),
        ),
        Kind::UngatedSpecular => (
            "a light behind the surface still makes a highlight on it".to_string(),
            "not cut off at the horizon",
            "add it only where `dot(n, l) > 0.0`; whole lights can then be skipped there"
                .to_string(),
        ),
        Kind::UnnormalisedNormal => (
            format!("{about} is interpolated, and not normalised before it is used here"),
            "not of length 1",
            format!("use `normalize({})`", last(&hazard.about)),
        ),
        Kind::Vec4Normalise => (
            "the normal is normalised together with its fourth component".to_string(),
            "four components",
            "write `normalize(mat3(transpose(inverse(m))) * n)`, or take `.xyz` first".to_string(),
        ),
        Kind::LoopPastCount => {
            let (array, count) = pair(&hazard.about);
            notes
                .push("a slot of zeros is 1 / 0 times 0, and one NaN is the whole sum".to_string());
            (
                format!(
                    "this loop takes all {number} slots of `{array}`; `{count}` says how many are in use"
                ),
                "every slot",
                format!("loop to `min({count}, {number})`"),
            )
        }
        Kind::UnclampedCount => {
            let (array, count) = pair(&hazard.about);
            (
                format!("nothing keeps `{count}` at or below the {number} slots of `{array}`"),
                "may be past the end",
                format!("loop to `min({count}, {number})`"),
            )
        }
        Kind::KahanWithoutPrecise => (
            "this compensation is 0 in real numbers, and a compiler may make it so".to_string(),
            "may be cancelled",
            match glsl {
                true => "declare the sum, its parts and the compensation `precise`".to_string(),
                false => "sum in several lanes, or pairwise: WGSL has no `precise`".to_string(),
            },
        ),
        Kind::AmbientPerLight => (
            format!("{about} is ambient light counted once a light"),
            "added for every light",
            "keep one ambient light beside the array, and add it once".to_string(),
        ),
        Kind::MediumpPosition => (
            format!("{about} may be 16 bits wide: its squared distance overflows at 256"),
            "below highp",
            "declare positions, directions and distances `highp`".to_string(),
        ),
    };
    Words { message, text: text.to_string(), notes, help }
}

/// An array and its count.
fn pair(about: &str) -> (&str, &str) {
    about.split_once(' ').unwrap_or((about, "count"))
}

fn last(path: &str) -> &str {
    path.rsplit('.').next().unwrap_or(path)
}
