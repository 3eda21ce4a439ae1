//! The reference of lighting: what a fragment's light is, in `f64`, from the bits uploaded.
//!
//! A [`Model`] says which lighting; [`shade`] lights a fragment of a
//! [`Frame`](super::Frame) by the lights of an [`Upload`](super::Upload), [`see`] lets one ask
//! light by light, [`view_normal`] gives a vertex's normal. What is undefined is an [`Undef`] with the hazard's id, never a number.
//!
//! Directions of an upload are those in which light travels, also for shaders that take the
//! opposite; a scene's lights are all counted, whatever a shader's arrays hold; normals are as
//! the fragment has them, which is where a model's normal transform was.

mod form;
mod light;
mod model;
mod normal;
mod undef;

pub use light::{Contribution, LightId, Seen, Shaded, see, shade};
pub use model::{
    AmbientTerm, ArraySpecular, CasterAttenuation, ConeEdge, ConeNumbers, Family, Highlight, Model,
    Normal, NormalTransform, Power, Reflectance, SpecularGate, Window,
};
pub use normal::view_normal;
pub use undef::Undef;
