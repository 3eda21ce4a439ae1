//! Every operator and builtin function of floats, integers and matrices, thousands of inputs
//! each: the evaluator, a Vulkan driver and an OpenGL driver against what WGSL and Vulkan
//! permit, and against the truth where they permit nothing else.
//!
//! `LANDFALL_WRITE_TABLES=1 cargo test --features full --test exec builtins` writes what was measured to
//! `crates/landfall-interp/src/accuracy.md`; without it no error may be larger than the one written there.
//!
//! Needs drivers (Debian packages `mesa-vulkan-drivers`, `libvulkan1`, `libegl1` and
//! `libgl1-mesa-dri`); a missing one fails.

mod angles;
mod case;
mod draw;
mod integers;
pub mod interval;
use crate::support::jobs;
mod known;
mod scalars;
mod table;
pub mod truth;
mod vectors;
mod wgsl;

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use case::{Allowed, Dialect, Family, Off};
use draw::count;
use jobs::{bound, bytes, output, words};
use known::known_faults;
use landfall_exec::backend::gl::Gl;
use landfall_exec::backend::wgpu::{AdapterChoice, Gpu};
use landfall_exec::backend::{Backend, Device, Grid, ResourceKind, StageCode};
use landfall_interp::{Cpu, Settings};
use landfall_ir::Module;
use landfall_layout::{Options, Source, Stage};
use table::Measured;

/// Words of a message about one case.
const SHOWN: usize = 3;

fn families() -> Vec<Family> {
    let glsl = |name, cases| Family { name, dialect: Dialect::Glsl, cases };
    vec![
        glsl("rounding", scalars::exact()),
        glsl("powers", scalars::inexact()),
        glsl("angles", angles::all()),
        glsl("vectors", vectors::all()),
        glsl("integers", integers::operators()),
        glsl("conversions", integers::conversions()),
        Family { name: "wgsl", dialect: Dialect::Wgsl, cases: wgsl::all() },
    ]
}

fn module(family: &Family) -> Arc<Module> {
    let extension = if family.dialect == Dialect::Glsl { "comp" } else { "wgsl" };
    let source = Source::new(format!("{}.{extension}", family.name), family.text());
    let module = Module::new(&source, &Options::default());
    Arc::new(module.unwrap_or_else(|found| panic!("{found:?}\n{}", family.text())))
}

/// The results of all cases by one backend; none where it does not take the family's language.
fn run(backend: &mut dyn Backend, family: &Family, module: &Arc<Module>) -> Option<Vec<u32>> {
    let glsl = (family.dialect == Dialect::Glsl).then(|| family.text());
    if backend.device().backend.name() == "gl" && glsl.is_none() {
        return None;
    }
    let stage =
        StageCode { text: glsl, ..StageCode::of_module(Stage::Compute, "main", module.clone()) };
    let given = ResourceKind::Storage { bytes: bytes(&family.given()), writable: false };
    let invocations = family.cases.len() * count();
    let got = output("Got", 1, invocations * family.result_stride());
    let grid = Grid::Groups([(invocations / 64) as u32, 1, 1]);
    let job = jobs::job(vec![stage], vec![bound("Given", 0, given), got], grid);
    let answer = backend.run(&job).unwrap_or_else(|failure| panic!("{}: {failure}", family.name));
    Some(words(answer.buffers[1].as_ref().expect("the buffer is writable")))
}

/// The largest errors by case; and what is not permitted, by case.
#[derive(Default)]
struct Verdict {
    largest: BTreeMap<String, Off>,
    wrong: BTreeMap<String, Vec<String>>,
}

fn judge(verdict: &mut Verdict, family: &Family, got: &[u32], strict: bool) {
    let stride = family.result_stride();
    for (i, case) in family.cases.iter().enumerate() {
        let mut largest = Off::default();
        for (k, input) in case.inputs.iter().enumerate() {
            let at = (i * count() + k) * stride;
            let got = &got[at..at + case.result_words()];
            for (part, (allowed, got)) in (case.judge)(input).into_iter().zip(got).enumerate() {
                match allowed.judge(*got, strict) {
                    Some(off) => {
                        largest.ulp = largest.ulp.max(off.ulp);
                        largest.share = largest.share.max(off.share);
                    }
                    None => {
                        let given: Vec<f32> = input.iter().map(|w| f32::from_bits(*w)).collect();
                        let f = f32::from_bits(*got);
                        verdict.wrong.entry(case.name.into()).or_default().push(format!(
                            "of {given:?} ({input:x?}), word {part}: {f:e} ({got:x}), not {allowed:?}"
                        ));
                    }
                }
            }
        }
        verdict.largest.insert(case.name.into(), largest);
    }
}

/// As a table says who it was; llvmpipe's adapter names its LLVM.
fn name(device: &Device) -> String {
    format!("{}, {} {}", device.adapter, device.driver, device.version)
}

#[test]
fn every_builtin_is_within_what_is_permitted() {
    let families = families();
    let modules: Vec<Arc<Module>> = families.iter().map(module).collect();
    let mut backends: Vec<Box<dyn Backend>> = vec![
        Box::new(Cpu::new(Settings::default())),
        Box::new(
            Gpu::open(&AdapterChoice::default()).unwrap_or_else(|failure| panic!("{failure}")),
        ),
        Box::new(Gl::open().unwrap_or_else(|failure| panic!("{failure}"))),
    ];
    let mut measured = Vec::new();
    let mut found = Vec::new();
    for backend in &mut backends {
        let device = backend.device().clone();
        let mut verdict = Verdict::default();
        for (family, module) in families.iter().zip(&modules) {
            if let Some(got) = run(&mut **backend, family, module) {
                judge(&mut verdict, family, &got, device.backend.name() == "cpu");
            }
        }
        let known = known_faults(&device);
        for (case, wrong) in &verdict.wrong {
            if !known.contains(&&**case) {
                let shown = wrong[..wrong.len().min(SHOWN)].join("\n    ");
                found.push(format!(
                    "{} {case}, {} words:\n    {shown}",
                    device.backend,
                    wrong.len()
                ));
            }
        }
        for case in known.iter().filter(|case| !verdict.wrong.contains_key(**case)) {
            found.push(format!("{} {case}: mended, no longer a known fault", name(&device)));
        }
        measured.push(Measured {
            backend: device.backend.name(),
            device: name(&device),
            cases: verdict.largest,
        });
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
    hold(&families, &measured);
}

fn hold(families: &[Family], measured: &[Measured]) {
    let rows: Vec<(String, String)> = families
        .iter()
        .flat_map(|family| &family.cases)
        .map(|case| (case.name.to_string(), case.permitted.to_string()))
        .collect();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("crates/landfall-interp/src/accuracy.md");
    if std::env::var_os("LANDFALL_WRITE_TABLES").is_some() {
        let text = table::written(&rows, measured, count());
        std::fs::write(&path, text).expect("the repository is writable");
        return;
    }
    let committed = std::fs::read_to_string(&path).unwrap_or_default();
    let rotten = table::rotten(&committed, &rows, measured, count());
    assert!(
        rotten.is_empty(),
        "{}\n(`LANDFALL_WRITE_TABLES=1 cargo test --features full --test exec builtins` writes the table anew)",
        rotten.join("\n"),
    );
}

#[test]
fn a_result_beside_the_permitted_is_not_taken() {
    for case in families().iter().flat_map(|family| &family.cases) {
        let mut held = 0;
        for input in &case.inputs {
            let mut any = false;
            for allowed in (case.judge)(input) {
                let Some(beside) = beside(allowed) else { continue };
                assert!(
                    allowed.judge(beside, false).is_none(),
                    "{} of {input:x?}: {beside:x} is taken for {allowed:?}",
                    case.name,
                );
                any = true;
            }
            held += usize::from(any);
        }
        let part = held as f64 / case.inputs.len() as f64;
        // Of a determinant only that of whole numbers is bounded.
        let least = if case.name.starts_with("determinant") { 0.45 } else { 0.6 };
        assert!(part >= least, "{}: only {part:.2} of the inputs are held to a bound", case.name);
    }
}

/// The nearest word that is not permitted; none where every word is.
fn beside(allowed: Allowed) -> Option<u32> {
    match allowed {
        Allowed::Word(word) => Some(word ^ 1),
        Allowed::Either(a, b) => [a ^ 1, b ^ 2, a ^ 4].into_iter().find(|w| *w != a && *w != b),
        Allowed::Correct(0.0) => Some(1),
        Allowed::Correct(truth) => Some((truth as f32).to_bits() ^ 1),
        Allowed::Within(_, interval) if interval.high == f64::INFINITY => None,
        Allowed::Within(_, interval) => {
            let mut x = (interval.high as f32).next_up();
            if interval.has(f64::from(x)) {
                x = x.next_up();
            }
            Some(x.to_bits())
        }
        Allowed::Open => None,
    }
}
