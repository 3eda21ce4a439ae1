//! Drawings of measurements, as SVG text that is the same for the same numbers.
//!
//! [`scatter`](scatter()) draws run time against error; [`heat_map`](heat_map()) an error over
//! two inputs. [`axis`] has their scales, `labels` puts text where nothing is, `svg` spells
//! elements. Nothing here is told by colour alone, and each drawing brings a background with it,
//! light or dark as the reader's screen is.

pub mod axis;
mod heat_map;
mod labels;
mod scatter;
mod svg;

pub use axis::Axis;
pub use heat_map::{Cell, HeatMap, heat_map};
pub use scatter::{Mark, Scatter, scatter};
