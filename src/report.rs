//! The printed reports of the commands: text for people, JSON, CSV and SARIF for programs.

#[cfg(feature = "exec")]
pub mod bench;
#[cfg(feature = "exec")]
pub mod bind;
#[cfg(feature = "exec")]
mod brief;
#[cfg(feature = "exec")]
pub mod compare;
#[cfg(feature = "exec")]
pub mod coverage;
#[cfg(feature = "exec")]
pub mod devices;
#[cfg(feature = "analysis")]
pub mod lights;
#[cfg(feature = "exec")]
pub mod plan;
#[cfg(feature = "exec")]
pub mod prove;
#[cfg(feature = "exec")]
pub mod render;
pub mod schema;
#[cfg(feature = "exec")]
pub mod stress;
#[cfg(feature = "cli")]
pub mod unified;
#[cfg(feature = "exec")]
pub mod verify;
