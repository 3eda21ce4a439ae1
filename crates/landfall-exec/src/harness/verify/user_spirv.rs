//! Runs SPIR-V of a third-party compiler unchanged, beside Landfall's module of the same text.
//!
//! Both run on one driver over the same buffers and inputs: their results differ if the compiler
//! put a member elsewhere, or the file belongs to another text. Takes a [`Subject`] and the words
//! of the file; returns a [`CompiledRun`].

use std::fmt::Write as _;
use std::sync::Arc;

use super::report::{CompiledRun, Outcome};
use super::{Subject, VerifyOptions};
use crate::backend::{Backend, Failure, Grid, Job, Resource, StageCode, Texel};
use crate::harness::access;
use crate::harness::bindings as bound;
use crate::harness::bindings::Data;
use crate::harness::coverage::fill;
use crate::harness::coverage::fill::Filling;
use landfall_interp::{Port, Program};
use landfall_ir::module::{EntryPoint, Module};
use landfall_layout::Options;
use landfall_layout::layout::BlockLayout;
use landfall_layout::source::{ExecutableStage, Files, Source, Stage};

/// Width and height of the image of a fragment stage, and number of workgroups of a compute stage.
const SIZE: u32 = 16;
const GROUPS: [u32; 3] = [2, 1, 1];

/// Maximum relative difference: compilers may order a sum differently; a member read from elsewhere
/// differs by far more.
const TOLERANCE: f32 = 1e-4;

/// Runs third-party SPIR-V on a driver and compares its results with those of Landfall's module.
pub fn run_compiled(
    subject: &Subject,
    options: &VerifyOptions,
    words: &[u32],
    backend: &mut dyn Backend,
) -> CompiledRun {
    let mut run = CompiledRun {
        backend: backend.device().backend,
        outcome: Outcome::Skipped,
        compared: 0,
        differing: 0,
        reason: None,
    };
    match compare(subject, options, words, backend) {
        Ok((compared, differing)) => {
            (run.compared, run.differing) = (compared, differing);
            run.outcome = match (compared, differing) {
                (0, _) => Outcome::Skipped,
                (_, 0) => Outcome::Confirmed,
                (_, _) => Outcome::Disagrees,
            };
            run.reason = (compared == 0).then(|| "it writes no output to compare".to_string());
        }
        Err(reason) => run.reason = Some(reason),
    }
    run
}

/// Returns how many words were compared, and how many of them differ.
fn compare(
    subject: &Subject,
    options: &VerifyOptions,
    words: &[u32],
    backend: &mut dyn Backend,
) -> Result<(usize, usize), String> {
    let source = &subject.run.source;
    let mut layout = options.layout.clone().with_gather(true).with_naga(false);
    layout.read = subject.run.read.clone();
    let module = Module::new(source, &layout).map_err(|found| found[0].message.clone())?;
    let entry = module.entry_points().into_iter().find(|entry| entry.name == "main");
    let Some(entry) = entry else {
        return Err("the shader has no entry point `main`".to_string());
    };
    let vertex = partner(&module, &entry)?;
    let grid = match ExecutableStage::from_stage(entry.stage) {
        Some(ExecutableStage::Compute) => Grid::Groups(GROUPS),
        Some(ExecutableStage::Vertex | ExecutableStage::Fragment) | None => {
            Grid::Image { width: SIZE, height: SIZE, texel: Texel::Float }
        }
    };
    let module = Arc::new(module);
    let code = |words: Option<Arc<[u32]>>| StageCode {
        stage: entry.stage,
        entry: entry.name.clone(),
        module: words.is_none().then(|| Arc::clone(&module)),
        text: None,
        spirv: words,
    };
    let words: Arc<[u32]> = Arc::from(words);
    let (mut compared, mut differing) = (0, 0);
    // Other contents may lead to other branches.
    for filling in Filling::ALL {
        let job = |stage: StageCode| -> Result<Job, String> {
            Ok(Job {
                stages: vertex.iter().cloned().chain([stage]).collect(),
                resources: resources(&module, filling, source)?,
                grid,
                limit: options.limit,
            })
        };
        let said = |failure: Failure| failure.to_string();
        let ours = backend.run(&job(code(None))?).map_err(said)?;
        let theirs = backend.run(&job(code(Some(Arc::clone(&words))))?).map_err(said)?;
        let pixels = ours.pixels.iter().flatten().zip(theirs.pixels.iter().flatten());
        let buffers = ours.buffers.iter().flatten().zip(theirs.buffers.iter().flatten());
        let left = buffers.flat_map(|(ours, theirs)| ours.chunks(4).zip(theirs.chunks(4)));
        let word =
            |bytes: &[u8]| bytes.iter().rev().fold(0u32, |word, byte| word << 8 | u32::from(*byte));
        let left = left.map(|(ours, theirs)| (word(ours), word(theirs)));
        for (ours, theirs) in pixels.map(|(ours, theirs)| (*ours, *theirs)).chain(left) {
            compared += 1;
            differing += usize::from(!alike(ours, theirs));
        }
    }
    Ok((compared, differing))
}

fn alike(ours: u32, theirs: u32) -> bool {
    // Two NaN agree whatever their bits; zeros and subnormal numbers by their bits alone.
    let (a, b) = (f32::from_bits(ours), f32::from_bits(theirs));
    ours == theirs
        || a.is_nan() && b.is_nan()
        || (a - b).abs() <= TOLERANCE * a.abs().max(b.abs()) && a.is_normal() && b.is_normal()
}

fn resources(module: &Module, filling: Filling, source: &Source) -> Result<Vec<Resource>, String> {
    let longest = fill::longest(module);
    let fill = |block: &BlockLayout| fill::fill(block, filling, longest);
    let bytes = bound::blocks(module, &Data::new(), fill).map_err(|found| found.message)?;
    let files: &Files = module.files();
    let writable = |block: &BlockLayout| access::writable(block, files, source.language);
    Ok(bound::resources(module, bytes, writable, &[]))
}

/// Returns a vertex stage with outputs for a fragment stage: small numbers that vary over the
/// image.
fn partner(module: &Module, entry: &EntryPoint) -> Result<Option<StageCode>, String> {
    match ExecutableStage::from_stage(entry.stage) {
        Some(ExecutableStage::Compute) => return Ok(None),
        Some(ExecutableStage::Fragment) => {}
        Some(ExecutableStage::Vertex) | None => {
            return Err(format!("a {} stage is not run", entry.stage.name()));
        }
    }
    let mut fields = String::new();
    let mut values = String::new();
    for (port, floats) in Program::new(module, &[]).inputs(&entry.name) {
        // Built-in inputs need no output of the vertex stage.
        let Port::Location(location) = port else { continue };
        if floats.contains(&false) {
            return Err("its inputs are integers, which are not generated".to_string());
        }
        let ty = match floats.len() {
            1 => "f32".to_string(),
            count => format!("vec{count}f"),
        };
        let component = |nth: usize| {
            // Each component and location differs, so that one taken for another shows.
            let (base, step) = (0.25 + 0.125 * nth as f32, 0.5 + 0.0625 * location as f32);
            format!("{base} + x * {step}")
        };
        let components: Vec<String> = (0..floats.len()).map(component).collect();
        let _ = writeln!(fields, "@location({location}) l{location}: {ty},");
        let _ = write!(values, ", {ty}({})", components.join(", "));
    }
    if fields.is_empty() {
        return Ok(None);
    }
    let text = format!(
        "struct Out {{ @builtin(position) at: vec4f,\n{fields} }}\n\
         @vertex fn main(@builtin(vertex_index) i: u32) -> Out {{\n\
         let x = f32(i);\n\
         return Out(vec4f(f32(i & 1u) * 4.0 - 1.0, f32(i >> 1u) * 4.0 - 1.0, 0.0, 1.0){values});\n}}"
    );
    let source = Source::new("inputs.wgsl", text);
    let module = Module::new(&source, &Options::default());
    let module =
        module.map_err(|found| format!("its inputs cannot be generated: {}", found[0].message))?;
    Ok(Some(StageCode::of_module(Stage::Vertex, "main", module)))
}
