//! What is looked at in a browser: the HTML pages of reports, the playground with its engine, and its
//! server.
//!
//! Public signatures name no type of another crate but those of Landfall's.

pub mod html;
#[cfg(feature = "playground")]
pub mod playground;
#[cfg(feature = "serve")]
pub mod serve;
#[cfg(all(feature = "playground", any(target_arch = "wasm32", test)))]
mod wasm;
