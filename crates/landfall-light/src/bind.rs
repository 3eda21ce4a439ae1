//! The binding map: the source in a scene of each member of a shader.
//!
//! `infer` derives it from the names, types and nesting of any shader with lights in its blocks;
//! `read` applies the overrides of a scene or a file; `decide` settles signs and units by running
//! the shader; `fill` writes an [`Upload`](super::Upload) by
//! it. Sources have the names of [`quantity`]. Used by [`render`](super::render).

mod decide;
mod fill;
mod infer;
pub mod quantity;
mod read;

use landfall_layout::diagnostic::Code;
use std::fmt;

pub use decide::{Decision, Outcome, Topic, decide};
pub(crate) use fill::FragmentInputs;
pub use fill::{BlockWriter, OverflowPolicy};
pub use infer::{infer, members};
pub use quantity::{Kind, LightPart, MaterialPart, Quantity, Slot};

/// Examples of each group of names of a scene's properties.
const PROPERTIES: &str = "the name of a property, such as `camera.position`, `ambient.color`, \
                          `point.count`, `point[].color`, `spot[0].outer_cos` or \
                          `material.shininess`; of a fragment `position`, `normal`, `uv` or `pixel`";
pub use read::overridden;

/// The sources of a shader's members, textures and inputs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BindingMap {
    /// The members of blocks, and loose uniforms, that the shader may read.
    pub members: Vec<Member>,
    /// The textures, in the order of the shader.
    pub textures: Vec<BoundValue>,
    /// The inputs, in the order of the shader.
    pub inputs: Vec<BoundValue>,
    pub notes: Vec<String>,
    /// The signs and units settled by running the shader.
    pub decisions: Vec<Decision>,
    /// Whether the shader assumes that the camera is at the origin, as in view space.
    pub camera_at_origin: bool,
}

/// A member of a block and its source.
#[derive(Clone, Debug, PartialEq)]
pub struct Member {
    /// The index of the block in the shader.
    pub block: usize,
    pub name: String,
    /// Whether the block holds the loose uniforms.
    pub gathered: bool,
    /// The path of the leaf, arrays as patterns: `data[].pos`.
    pub path: String,
    pub source: Source,
}

#[derive(Clone, Debug, PartialEq)]
pub struct BoundValue {
    pub name: String,
    pub source: Source,
}

#[derive(Clone, Debug, PartialEq)]
pub enum Source {
    Scene {
        quantity: Quantity,
        /// Whether its negative is used: towards a light instead of the direction it travels in.
        negated: bool,
    },
    Number(Vec<f64>),
    /// Unknown; filled with zero.
    Unknown,
}

impl Source {
    /// A quantity of the scene, not negated.
    pub fn scene(quantity: Quantity) -> Source {
        Source::Scene { quantity, negated: false }
    }

    /// Returns the quantity of the scene, if it is one.
    pub fn quantity(&self) -> Option<Quantity> {
        match self {
            Source::Scene { quantity, .. } => Some(*quantity),
            Source::Number(_) | Source::Unknown => None,
        }
    }
}

impl fmt::Display for Source {
    /// Writes the notation of a scene's `bind`; `unknown` for an unknown source.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Source::Scene { quantity, negated } => {
                write!(f, "{}{quantity}", if *negated { "-" } else { "" })
            }
            Source::Number(numbers) => match &numbers[..] {
                [one] => write!(f, "{one}"),
                all => write!(f, "{all:?}"),
            },
            Source::Unknown => f.write_str("unknown"),
        }
    }
}

impl BindingMap {
    /// Whether any light of a kind is bound.
    pub fn has(&self, kind: Kind) -> bool {
        // Members alone: textures and inputs hold no lights.
        self.members.iter().any(|member| {
            matches!(member.source.quantity(), Some(Quantity::Light { kind: k, .. }) if k == kind)
        })
    }

    /// Whether any light is bound, the ambient one included.
    pub fn lights(&self) -> bool {
        let ambient = |m: &Member| matches!(m.source.quantity(), Some(Quantity::Ambient(_)));
        Kind::ALL.into_iter().any(|kind| self.has(kind)) || self.members.iter().any(ambient)
    }

    /// Returns the names with an unknown source: members with their blocks, textures and inputs.
    pub fn unknown(&self) -> Vec<String> {
        let unknown = |source: &Source| *source == Source::Unknown;
        let members = self.members.iter().filter(|m| unknown(&m.source));
        let bound = self.textures.iter().chain(&self.inputs).filter(|b| unknown(&b.source));
        members.map(Member::key).chain(bound.map(|b| b.name.clone())).collect()
    }
}

impl Member {
    /// Returns the key in a scene's `bind`: loose uniforms by their path alone.
    pub fn key(&self) -> String {
        match self.gathered {
            true => self.path.clone(),
            false => format!("{}.{}", self.name, self.path),
        }
    }
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub enum BindError {
    /// The shader has no member of a light.
    NoLights { shader: String },
    /// A scene has more lights than the shader has slots.
    TooManyLights {
        kind: Kind,
        lights: usize,
        slots: usize,
        /// The member that holds them, if any.
        member: Option<String>,
    },
    /// A key of a binding map that the shader does not have.
    UnknownTarget { key: String, help: Option<String> },
    /// A value of a binding map that is not a quantity of a scene.
    UnknownQuantity { key: String, word: String, help: Option<String> },
    /// A shader that assumes the camera at the origin, and a scene whose camera is elsewhere.
    CameraElsewhere,
    /// Members whose sign or unit running the shader did not settle.
    Undecided {
        keys: Vec<String>,
        /// The property that cannot be inferred.
        topic: Topic,
        /// The readings that agree with the reference and differ from each other: none or several.
        agreed: usize,
        readings: usize,
        /// The fragments that each was run on.
        probes: usize,
        /// Readings to choose from, as objects for `--bind`.
        offered: Vec<String>,
    },
    /// A value that does not fit its member.
    Misfit { key: String, why: String },
}

impl BindError {
    pub fn code(&self) -> Code {
        match self {
            BindError::NoLights { .. } => Code::NoLights,
            BindError::TooManyLights { .. } => Code::TooManyLights,
            BindError::UnknownTarget { .. } => Code::UnknownMember,
            BindError::UnknownQuantity { .. } => Code::UnknownQuantity,
            BindError::Undecided { .. } | BindError::CameraElsewhere => Code::Bind,
            BindError::Misfit { .. } => Code::WrongType,
        }
    }

    /// Returns the path of the cause in the scene, for
    /// [`Reading::place`](crate::scene::Reading::place): the first light without a slot, or the
    /// entry of the binding.
    pub fn at(&self) -> Option<String> {
        match self {
            BindError::NoLights { .. }
            | BindError::Undecided { .. }
            | BindError::CameraElsewhere => None,
            BindError::TooManyLights { kind, slots, .. } => {
                Some(format!("lights.{}[{slots}]", kind.name()))
            }
            BindError::UnknownTarget { key, .. }
            | BindError::UnknownQuantity { key, .. }
            | BindError::Misfit { key, .. } => Some(format!("bind.{key}")),
        }
    }

    pub fn help(&self) -> Option<String> {
        match self {
            BindError::NoLights { .. } => Some(
                "bind the members with `--bind`: {\"Block.place\": \"point[0].position\"}"
                    .to_string(),
            ),
            BindError::TooManyLights { .. } => {
                Some("leave out the lights without a slot with `--leave-out`".to_string())
            }
            BindError::UnknownTarget { help, .. } => help.clone(),
            BindError::UnknownQuantity { help, .. } => {
                help.clone().or_else(|| Some(format!("write {PROPERTIES}")))
            }
            BindError::CameraElsewhere => Some(
                "light the scene in view space with `\"space\": \"view\"`, or bind the member that \
                 holds the camera: `--bind '{\"eye\": \"camera.position\"}'`"
                    .to_string(),
            ),
            BindError::Undecided { offered, .. } => {
                let offered: Vec<String> =
                    offered.iter().map(|bind| format!("`--bind '{bind}'`")).collect();
                Some(format!("say what they hold, with {}", offered.join(" or ")))
            }
            BindError::Misfit { .. } => None,
        }
    }
}

impl fmt::Display for BindError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            BindError::NoLights { shader } => {
                write!(f, "no block or uniform of `{shader}` holds a light")
            }
            BindError::TooManyLights { kind, lights, slots, member } => {
                let kind = kind.name();
                match member {
                    Some(member) => write!(
                        f,
                        "the scene has {lights} {kind} lights, but `{member}` has slots for {slots}"
                    ),
                    None => write!(
                        f,
                        "the scene has {lights} {kind} lights, but the shader has slots for {slots}"
                    ),
                }
            }
            BindError::UnknownTarget { key, .. } => {
                write!(f, "the shader has no member, texture or input `{key}`")
            }
            BindError::UnknownQuantity { key, word, .. } => {
                write!(
                    f,
                    "`{key}` is bound to `{word}`, which is not a property of a scene"
                )
            }
            BindError::CameraElsewhere => f.write_str(
                "the shader assumes that the camera is at the origin, but the scene's camera is elsewhere",
            ),
            BindError::Undecided { keys, topic, agreed, readings, probes, .. } => {
                let names: Vec<String> = keys.iter().map(|key| format!("`{key}`")).collect();
                let many = if *agreed == 0 { "none matches" } else { "several match" };
                write!(
                    f,
                    "the {} of {} cannot be inferred: of {readings} interpretations, {many} \
                     the reference on {probes} test fragments",
                    topic.name(),
                    names.join(", ")
                )
            }
            BindError::Misfit { key, why } => write!(f, "`{key}` {why}"),
        }
    }
}

impl std::error::Error for BindError {}
