//! Probes: shaders that read every leaf of a block and say which bytes they saw.
//!
//! [`plan`] chooses the reads and knows the byte each must see, `glsl` and
//! `wgsl` append them to the user's own text, [`words`] fills a buffer in
//! which every word is another, and [`judge`] tells from the words that came
//! back which bytes were read. [`cause`] says what a wrong reader took for the layout.

pub mod cause;
pub(crate) mod glsl;
pub mod judge;
pub mod plan;
pub(crate) mod wgsl;
pub mod words;

pub use judge::{Got, Sighting};
pub use plan::{Plan, Read, Way, plans};
