//! The reference of lighting: the light of a fragment in `f64`, from the uploaded bits.
//!
//! A [`Model`] selects the lighting; [`shade`] lights a fragment of a [`Frame`](super::Frame) with
//! the lights of an [`Upload`](super::Upload), [`see`] gives the contribution of each light,
//! [`view_normal`] a vertex's normal. An undefined result is an [`UndefinedReason`] with the hazard's id,
//! never a number.
//!
//! Directions of an upload are those in which light travels, also for shaders that take the
//! opposite; all lights of a scene count, whatever the length of a shader's arrays; normals are
//! those of the fragment, after the model's normal transform.

mod form;
mod light;
mod model;
mod normal;
mod undef;

pub use light::{Contribution, FragmentContext, Shaded, see, shade};
pub use model::{
    AmbientTerm, ArraySpecular, CasterAttenuation, ConeEdge, ConeNumbers, Family, Highlight, Model,
    Normal, NormalTransform, Power, Reflectance, SpecularGate, Window,
};
pub use normal::view_normal;
pub use undef::UndefinedReason;
