//! Variants that light a scene: shaders on readers, and what is compiled into this program.

use std::cell::RefCell;
use std::path::PathBuf;
use std::rc::Rc;

use landfall::accuracy::bench::clock::Clock;
use landfall::accuracy::bench::compiled::Compiled;
use landfall::accuracy::bench::scene::Stage;
use landfall::accuracy::bench::shader::{Shader, Shared};
use landfall::accuracy::bench::{Bench, Failed, Runner, Size};
use landfall::light::compiled::{Form, Gates};
use landfall::light::reference::Model;
use landfall::light::render::{Renderer, truth};
use landfall::light::{Frame, Upload, skip};
use landfall::run::eval::Cpu;
use landfall::run::reader::{self, Reader};

use super::{About, Entry, measured, rust, wrong};
use crate::args::{BenchArgs, BenchFormat, ReaderName};
use crate::output::{Failure, FindingForm, Streams};
use crate::render::asked::{Asked, Wanted, asked};

/// What a variant is.
enum What {
    /// A shader's file, or the scene's own.
    Shader(Option<PathBuf>),
    /// Compiled in, without powers below that.
    Rust(Form, f64),
    /// Compiled in, by a plan.
    Plan(skip::Options),
}

pub fn bench(args: &BenchArgs, streams: &Streams) -> Result<Option<Bench>, Failure> {
    let style = streams.style(match args.format {
        BenchFormat::Human | BenchFormat::Csv => FindingForm::Human,
        BenchFormat::Json => FindingForm::Json,
    });
    let ask = |shader: Option<PathBuf>| {
        let wanted = Wanted {
            scene: &args.subject,
            shader,
            entry: None,
            size: args.size,
            model: args.model.clone(),
            bind: args.bind.clone(),
            read: &args.read,
        };
        asked(&wanted, streams, &style)
    };
    let Some(own) = ask(None)? else { return Ok(None) };
    let variants = variants(args, &own)?;
    let mut renderers: Vec<Option<Renderer>> = Vec::new();
    for (_, what) in &variants {
        renderers.push(match what {
            What::Shader(file) => {
                let Some(asked) = ask(file.clone())? else { return Ok(None) };
                match asked.renderer() {
                    Ok(renderer) => renderer,
                    Err(error) => {
                        let (found, files) = asked.findings(&error);
                        streams.report(&style.text(&found, files));
                        return Ok(None);
                    }
                }
            }
            What::Rust(..) | What::Plan(_) => None,
        });
    }
    let likely = || renderers.iter().flatten().next().map(|renderer| truth::likely(&renderer.map));
    let model: Model = own.model.or_else(likely).unwrap_or_default();
    let plans = variants.iter().any(|(_, what)| matches!(what, What::Plan(_)));
    let most = if plans { u64::MAX } else { args.most };
    let frame = Frame::new(&own.scene, &own.frame);
    let all = frame.fragments.len();
    let stage = Stage::new(model, Upload::new(&own.scene), frame, most);
    let taken = stage.frame.fragments.len();
    let mut subject = own.scene.name.clone();
    if taken < all {
        subject.push_str(&format!(", {taken} of {all} fragments"));
    }
    let about = About {
        subject,
        truth: "the f64 reference from the same upload".to_string(),
        size: Size { fragments: taken as u64, lights: stage.lights() },
    };
    let (entries, failed) = entries(args, &variants, &renderers, &stage);
    Ok(Some(measured(about, entries, failed, args, streams)))
}

/// What is said, or the scene's own shader and what is compiled in.
fn variants(args: &BenchArgs, own: &Asked) -> Result<Vec<(String, What)>, Failure> {
    let rust = |gates, least| What::Rust(Form::Robust(gates), least);
    if args.variants.is_empty() {
        let mut all = vec![
            ("seed".to_string(), What::Rust(Form::Seed, 0.0)),
            ("robust".to_string(), rust(Gates::NONE, 0.0)),
            ("robust, exact gates".to_string(), rust(Gates::ALL, 0.0)),
            ("robust, powers from 2^-24".to_string(), rust(Gates::ALL, 2f64.powi(-24))),
            ("robust, powers from 1/64 step".to_string(), rust(Gates::ALL, 1.0 / 64.0 / 255.0)),
            ("robust, powers from 1/8 step".to_string(), rust(Gates::ALL, 1.0 / 8.0 / 255.0)),
        ];
        if let Some(shader) = &own.shader {
            all.push((shader.path.clone(), What::Shader(None)));
        }
        return Ok(all);
    }
    let one = |(name, what): &(String, String)| {
        let what = match what.split_once(':') {
            Some(("rust", "seed")) => What::Rust(Form::Seed, 0.0),
            Some(("rust", "robust")) => rust(Gates::ALL, 0.0),
            Some(("rust", form)) => {
                let least = form.strip_prefix("robust=").and_then(|x| x.parse::<f64>().ok());
                let least = least.filter(|least| (0.0..1.0).contains(least)).ok_or_else(|| {
                    wrong(name, format!("`{form}` is no form that is compiled in"))
                        .with_help("forms are `seed`, `robust`, and `robust=POWER`, POWER below 1")
                })?;
                rust(Gates::ALL, least)
            }
            Some(("plan", options)) => {
                What::Plan(skip::parse(options).map_err(|error| wrong(name, error))?)
            }
            _ => What::Shader(Some(PathBuf::from(what))),
        };
        Ok((name.clone(), what))
    };
    args.variants.iter().map(one).collect()
}

/// Everything that can be measured, judged once; and what cannot.
fn entries<'a>(
    args: &BenchArgs,
    variants: &'a [(String, What)],
    renderers: &'a [Option<Renderer>],
    stage: &'a Stage,
) -> (Vec<Entry<'a>>, Vec<Failed>) {
    let (mut entries, mut failed) = (Vec::new(), Vec::new());
    let fail = |variant: &str, reader: &str, reason: String| Failed {
        variant: variant.to_string(),
        reader: reader.to_string(),
        reason,
    };
    for (name, what) in variants {
        let made = match what {
            What::Shader(_) => continue,
            What::Rust(form, least) => Compiled::new(stage, *form, *least),
            What::Plan(options) => Compiled::new(stage, Form::Robust(Gates::ALL), 0.0)
                .map(|compiled| compiled.by_plan(options)),
        };
        match made {
            Ok(compiled) => {
                let (errors, work) = compiled.judged();
                let (variant, workload) = (name.clone(), Box::new(compiled));
                entries.push(Entry { variant, runner: rust(), workload, errors, work });
            }
            Err(reason) => failed.push(fail(name, "rust", reason)),
        }
    }
    if renderers.iter().all(Option::is_none) {
        return (entries, failed);
    }
    let names = if args.reader.is_empty() { &ReaderName::ALL[..] } else { &args.reader };
    for reader in names {
        let shared: Shared = match open(*reader, args.adapter.as_deref()) {
            Ok(opened) => Rc::new(RefCell::new(opened)),
            Err(failure) => {
                failed.push(fail("every shader", reader.name(), failure.message));
                continue;
            }
        };
        let runner = Runner::of(shared.borrow().device(), Clock::Processor);
        for ((name, _), renderer) in variants.iter().zip(renderers) {
            let Some(renderer) = renderer else { continue };
            let made = Shader::new(stage, renderer, Rc::clone(&shared), args.limit)
                .map_err(|error| error.to_string())
                .and_then(|mut shader| shader.judged().map(|judged| (shader, judged)));
            match made {
                Ok((shader, (errors, work))) => {
                    let (variant, runner) = (name.clone(), runner.clone());
                    let workload = Box::new(shader);
                    entries.push(Entry { variant, runner, workload, errors, work });
                }
                Err(reason) => failed.push(fail(name, reader.name(), reason)),
            }
        }
    }
    (entries, failed)
}

/// A reader in this process, whose processor time is then this process's.
fn open(name: ReaderName, adapter: Option<&str>) -> Result<Box<dyn Reader>, reader::Failure> {
    match name {
        ReaderName::Cpu => Ok(Box::new(Cpu::default())),
        ReaderName::Gl => gl(),
        ReaderName::Gpu => gpu(adapter),
    }
}

#[cfg(feature = "gl")]
fn gl() -> Result<Box<dyn Reader>, reader::Failure> {
    Ok(Box::new(landfall::run::gl::Gl::open()?))
}

#[cfg(not(feature = "gl"))]
fn gl() -> Result<Box<dyn Reader>, reader::Failure> {
    Err(reader::Failure::missing("this landfall was built without the feature `gl`", ""))
}

#[cfg(feature = "gpu")]
fn gpu(adapter: Option<&str>) -> Result<Box<dyn Reader>, reader::Failure> {
    use landfall::run::gpu::{Choice, Gpu};

    let gpu = Gpu::open(&Choice { adapter: adapter.map(str::to_string) })?;
    Ok(Box::new(gpu.timed()))
}

#[cfg(not(feature = "gpu"))]
fn gpu(_adapter: Option<&str>) -> Result<Box<dyn Reader>, reader::Failure> {
    Err(reader::Failure::missing("this landfall was built without the feature `gpu`", ""))
}
