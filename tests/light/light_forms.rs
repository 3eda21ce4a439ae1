//! The light shaders in the form tutorials print and in the form that holds: they agree where
//! both are defined, in every language, and the form that holds is no less accurate.

mod agree;
mod error;
mod scene;
