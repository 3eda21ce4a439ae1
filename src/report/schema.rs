//! JSON Schemas (draft 2020-12) of what the commands print and read, in every build.

/// JSON Schema of the baselines that `check --write-baseline` writes.
pub const BASELINE_SCHEMA: &str = include_str!("schema/baseline.json");

/// JSON Schema of the JSON output of `bench`.
pub const BENCH_SCHEMA: &str = include_str!("schema/bench.json");

/// JSON Schema of `landfall.toml`.
pub const CONFIG_SCHEMA: &str = include_str!("schema/config.json");

/// JSON Schema of the JSON output of `devices`.
pub const DEVICES_SCHEMA: &str = include_str!("schema/devices.json");

/// JSON Schema of the JSON output of `lights`.
pub const LIGHTS_SCHEMA: &str = include_str!("schema/lights.json");

/// JSON Schema of the plan in the JSON output of `render --skip PARTS`.
pub const PLAN_SCHEMA: &str = include_str!("schema/plan.json");

/// JSON Schema of the JSON output of `prove`.
pub const PROVE_SCHEMA: &str = include_str!("schema/prove.json");

/// JSON Schema of the JSON output of `render`.
pub const RENDER_SCHEMA: &str = include_str!("schema/render.json");

/// JSON Schema of the JSON output of `run`.
pub const RUN_SCHEMA: &str = include_str!("schema/run.json");

/// JSON Schema of a scene of lights, as `render` reads it.
pub const SCENE_SCHEMA: &str = include_str!("schema/scene.json");

/// JSON Schema of the JSON output of `stress`.
pub const STRESS_SCHEMA: &str = include_str!("schema/stress.json");

/// JSON Schema of the JSON output of `verify`.
pub const VERIFY_SCHEMA: &str = include_str!("schema/verify.json");
