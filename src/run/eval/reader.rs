//! The evaluator as a reader of jobs.
pub struct Cpu;
