//! Claims about the evaluator, on modules that naga's own front end reads.

mod support;

mod control;
