//! Drawings of measurements, as deterministic SVG text.
//!
//! [`scatter`](scatter()) draws run time against error; [`heat_map`](heat_map()) an error over two
//! inputs. [`axis`] holds their scales, `labels` places text, `svg` writes elements. No information
//! is in colour alone, and each drawing has a background of its own, light or dark by the viewer's
//! preference.

pub mod axis;
mod heat_map;
mod labels;
mod scatter;
mod svg;

pub use axis::Axis;
pub use heat_map::{Cell, HeatMap, MapMark, heat_map};
pub use scatter::{Mark, Scatter, scatter};
