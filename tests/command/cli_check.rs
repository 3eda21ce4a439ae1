//! `landfall check` and `rule` as a user meets them.

mod against;
mod asserted;
mod baseline;
mod below;
mod cache;
mod config;
mod levels;
mod locks;
mod mend;
mod outside;
pub mod place;
mod proved;
mod report;
mod watch;
