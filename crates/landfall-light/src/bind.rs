//! The binding map: which number of a scene goes to which member of a shader.
//!
//! `guess` finds it from the names, types and nesting of any shader with lights in its blocks,
//! `read` lets a scene or a file say otherwise, `fill` writes an
//! [`Upload`](super::Upload) by it. Numbers have the names of [`quantity`]. Feeds
//! [`render`](super::render).

mod fill;
mod guess;
pub mod quantity;
mod read;

use landfall_layout::diagnostic::Code;
use std::fmt;

pub use fill::{Excess, Filler, Lit, Tiles};
pub use guess::{guess, members};
pub use quantity::{Kind, LightPart, MaterialPart, Quantity, Slot};
pub use read::overridden;

/// Which number goes where.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BindingMap {
    /// Members of blocks and loose uniforms that the shader may read.
    pub members: Vec<Member>,
    /// Textures, in the order of the shader.
    pub textures: Vec<Bound>,
    /// Inputs, in the order of the shader.
    pub inputs: Vec<Bound>,
    /// What is worth knowing of the guess.
    pub notes: Vec<String>,
}

/// A member of a block and what it is given.
#[derive(Clone, Debug, PartialEq)]
pub struct Member {
    /// Number of the block in the shader.
    pub block: usize,
    /// The block's name.
    pub name: String,
    /// Whether the block is the loose uniforms.
    pub gathered: bool,
    /// The way to the leaf, arrays as patterns: `data[].pos`.
    pub path: String,
    /// What it is given.
    pub source: Source,
}

/// A texture or input and what it is given.
#[derive(Clone, Debug, PartialEq)]
pub struct Bound {
    /// Its name in the shader.
    pub name: String,
    /// What it is given.
    pub source: Source,
}

/// What something is given.
#[derive(Clone, Debug, PartialEq)]
pub enum Source {
    /// A number of the scene, negated or not.
    Scene {
        /// Which.
        quantity: Quantity,
        /// Whether its negative is given: the way towards a light for the way it travels.
        negated: bool,
    },
    /// These numbers.
    Number(Vec<f64>),
    /// Zero, since nothing is known of it.
    Unknown,
}

impl Source {
    /// A number of the scene as it is.
    pub fn plain(quantity: Quantity) -> Source {
        Source::Scene { quantity, negated: false }
    }

    /// The number of the scene it is given, if any.
    pub fn quantity(&self) -> Option<Quantity> {
        match self {
            Source::Scene { quantity, .. } => Some(*quantity),
            Source::Number(_) | Source::Unknown => None,
        }
    }
}

impl fmt::Display for Source {
    /// As it is written in a scene's `bind`; `unknown` for what is zero.
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
    /// Whether any light of a kind is given somewhere.
    pub fn has(&self, kind: Kind) -> bool {
        self.members.iter().any(|member| {
            matches!(member.source.quantity(), Some(Quantity::Light { kind: k, .. }) if k == kind)
        })
    }

    /// Whether any light is given somewhere, the one from everywhere counted.
    pub fn lights(&self) -> bool {
        let ambient = |m: &Member| matches!(m.source.quantity(), Some(Quantity::Ambient(_)));
        Kind::ALL.into_iter().any(|kind| self.has(kind)) || self.members.iter().any(ambient)
    }

    /// What nothing is known of: paths of members with their blocks, textures and inputs.
    pub fn unknown(&self) -> Vec<String> {
        let unknown = |source: &Source| *source == Source::Unknown;
        let members = self.members.iter().filter(|m| unknown(&m.source));
        let bound = self.textures.iter().chain(&self.inputs).filter(|b| unknown(&b.source));
        members.map(Member::key).chain(bound.map(|b| b.name.clone())).collect()
    }
}

impl Member {
    /// As it is written in a scene's `bind`: loose uniforms by their own path.
    pub fn key(&self) -> String {
        match self.gathered {
            true => self.path.clone(),
            false => format!("{}.{}", self.name, self.path),
        }
    }
}

/// Why nothing can be bound.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum BindError {
    /// The shader has no member that is a light's.
    NoLights {
        /// The shader.
        shader: String,
    },
    /// A scene has more lights than the shader has slots.
    TooManyLights {
        /// Of which kind.
        kind: Kind,
        /// Lights of the scene.
        lights: usize,
        /// Slots of the shader.
        slots: usize,
        /// The member that holds them, if any.
        member: Option<String>,
    },
    /// A name in a binding map that is nothing of the shader's.
    UnknownTarget {
        /// It.
        key: String,
        /// One that is near.
        nearest: Option<String>,
    },
    /// A word in a binding map that is no number of a scene.
    UnknownQuantity {
        /// What was to be given it.
        key: String,
        /// The word.
        word: String,
        /// One that is near.
        nearest: Option<String>,
    },
    /// A number that does not fit where it is to go.
    Misfit {
        /// Where.
        key: String,
        /// Why.
        why: String,
    },
}

impl BindError {
    /// The code of the finding.
    pub fn code(&self) -> Code {
        match self {
            BindError::NoLights { .. } => Code::NoLights,
            BindError::TooManyLights { .. } => Code::TooManyLights,
            BindError::UnknownTarget { .. } => Code::UnknownMember,
            BindError::UnknownQuantity { .. } => Code::UnknownQuantity,
            BindError::Misfit { .. } => Code::WrongType,
        }
    }

    /// Where in the scene it is, as [`Reading::place`](crate::scene::Reading::place) takes
    /// it: the first light without a slot, or the entry of the binding.
    pub fn at(&self) -> Option<String> {
        match self {
            BindError::NoLights { .. } => None,
            BindError::TooManyLights { kind, slots, .. } => {
                Some(format!("lights.{}[{slots}]", kind.name()))
            }
            BindError::UnknownTarget { key, .. }
            | BindError::UnknownQuantity { key, .. }
            | BindError::Misfit { key, .. } => Some(format!("bind.{key}")),
        }
    }

    /// What mends it.
    pub fn help(&self) -> Option<String> {
        match self {
            BindError::NoLights { .. } => Some(
                "say which member is what with `--bind`: {\"Block.place\": \"point[0].position\"}"
                    .to_string(),
            ),
            BindError::TooManyLights { .. } => {
                Some("`--leave-out` lights by those that fit".to_string())
            }
            BindError::UnknownTarget { nearest, .. }
            | BindError::UnknownQuantity { nearest, .. } => {
                nearest.as_ref().map(|nearest| format!("did you mean `{nearest}`?"))
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
                        "the scene has {lights} {kind} lights, and `{member}` has slots for {slots}"
                    ),
                    None => write!(
                        f,
                        "the scene has {lights} {kind} lights, and the shader has slots for {slots}"
                    ),
                }
            }
            BindError::UnknownTarget { key, .. } => {
                write!(f, "the shader has no member, texture or input `{key}`")
            }
            BindError::UnknownQuantity { key, word, .. } => {
                write!(f, "`{key}` is to be `{word}`, which is no number of a scene")
            }
            BindError::Misfit { key, why } => write!(f, "`{key}` {why}"),
        }
    }
}

impl std::error::Error for BindError {}
