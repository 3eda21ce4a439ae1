//! Our own evaluator of naga IR: many invocations at a time, f32 and f64.
