//! `landfall schema`: prints the JSON Schema of an output format, of `landfall.toml`, or of scenes.

use landfall_layout::format as emit;

use crate::args::{Schema, SchemaArgs};
use crate::output::{CommandFailure, Outcome, Streams};

pub fn run(args: &SchemaArgs, streams: &Streams) -> Result<Outcome, CommandFailure> {
    streams.exactly(match args.of {
        Schema::Layout => emit::LAYOUT_SCHEMA,
        Schema::Explain => emit::EXPLAIN_SCHEMA,
        Schema::Check => landfall_lint::render::CHECK_SCHEMA,
        Schema::Render => landfall::report::schema::RENDER_SCHEMA,
        Schema::Plan => landfall::report::schema::PLAN_SCHEMA,
        Schema::Run => landfall::report::schema::RUN_SCHEMA,
        Schema::Stress => landfall::report::schema::STRESS_SCHEMA,
        Schema::Prove => landfall::report::schema::PROVE_SCHEMA,
        Schema::Verify => landfall::report::schema::VERIFY_SCHEMA,
        Schema::Bench => landfall::report::schema::BENCH_SCHEMA,
        Schema::Lights => landfall::report::schema::LIGHTS_SCHEMA,
        Schema::Devices => landfall::report::schema::DEVICES_SCHEMA,
        Schema::Diagnostic => emit::DIAGNOSTIC_SCHEMA,
        Schema::Lock => emit::LOCK_SCHEMA,
        Schema::Diff => emit::diff::DIFF_SCHEMA,
        Schema::Baseline => landfall::report::schema::BASELINE_SCHEMA,
        Schema::Config => landfall::report::schema::CONFIG_SCHEMA,
        Schema::Scene => landfall::report::schema::SCENE_SCHEMA,
    })?;
    Ok(Outcome::Clean)
}
