//! The printed report of a call, and the names of devices in every report.

pub mod device;
pub mod run;
