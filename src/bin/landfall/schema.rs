//! `landfall schema`: the JSON Schemas the outputs keep to.

use landfall::emit;

use crate::args::{Schema, SchemaArgs};
use crate::output::{Failure, Outcome, Streams};

pub fn run(args: &SchemaArgs, streams: &Streams) -> Result<Outcome, Failure> {
    streams.product(match args.of {
        Schema::Layout => emit::LAYOUT_SCHEMA,
        Schema::Explain => emit::EXPLAIN_SCHEMA,
        Schema::Check => emit::CHECK_SCHEMA,
        Schema::Render => emit::render::RENDER_SCHEMA,
        Schema::Run => emit::run::RUN_SCHEMA,
        Schema::Verify => emit::verify::VERIFY_SCHEMA,
        Schema::Lights => emit::lights::LIGHTS_SCHEMA,
        Schema::Devices => emit::DEVICES_SCHEMA,
        Schema::Diagnostic => emit::DIAGNOSTIC_SCHEMA,
        Schema::Lock => emit::LOCK_SCHEMA,
        Schema::Diff => emit::diff::DIFF_SCHEMA,
    })?;
    Ok(Outcome::Clean)
}
