//! Variants that light a scene: shaders on readers, and what is compiled into this program.

use std::cell::RefCell;
use std::path::PathBuf;
use std::rc::Rc;

use landfall::accuracy::bench::clock::Clock;
use landfall::accuracy::bench::compiled::Compiled;
use landfall::accuracy::bench::scene::Stage;
use landfall::accuracy::bench::shader::{Shader, Shared};
use landfall::accuracy::bench::{Bench, Runner, Size, Unit};
use landfall::light::compiled::{Form, Gates};
use landfall::light::reference::Model;
use landfall::light::render::{Renderer, truth};
use landfall::light::{Frame, Upload, skip};

use super::{About, Entries, Entry, measured, rust, wrong};
use crate::args::{BenchArgs, BenchFormat, ReaderName};
use crate::output::{Failure, FindingForm, Streams};
use crate::readers;
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
    let ask = |shader: Option<PathBuf>, model: Option<&String>| {
        let wanted = Wanted {
            scene: &args.subject,
            shader,
            entry: None,
            size: args.size,
            model: model.or(args.model.as_ref()).cloned(),
            bind: args.bind.clone(),
            read: &args.read,
        };
        asked(&wanted, streams, &style)
    };
    let Some(own) = ask(None, None)? else { return Ok(None) };
    let variants = variants(args, &own)?;
    let unknown = args.model_of.iter().find(|(of, _)| variants.iter().all(|(name, _)| name != of));
    if let Some((name, _)) = unknown {
        return Err(wrong(name, "is no variant, and `--model-of` gives it a model").into());
    }
    let mut renderers: Vec<Option<Renderer>> = Vec::new();
    let mut models: Vec<Option<Model>> = Vec::new();
    for (name, what) in &variants {
        let said = args.model_of.iter().find(|(of, _)| of == name).map(|(_, model)| model);
        models.push(match said {
            Some(model) => {
                let Some(asked) = ask(None, Some(model))? else { return Ok(None) };
                asked.model
            }
            None => None,
        });
        renderers.push(match what {
            What::Shader(file) => {
                let Some(asked) = ask(file.clone(), None)? else { return Ok(None) };
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
    let upload = Upload::new(&own.scene);
    let stage = Stage::new(model, upload.clone(), frame.clone(), most);
    let others: Vec<Option<Stage>> = models
        .into_iter()
        .map(|model| model.map(|model| Stage::new(model, upload.clone(), frame.clone(), most)))
        .collect();
    let stages: Vec<&Stage> = others.iter().map(|other| other.as_ref().unwrap_or(&stage)).collect();
    let taken = stage.frame.fragments.len();
    let mut subject = own.scene.name.clone();
    if taken < all {
        subject.push_str(&format!(", {taken} of {all} fragments"));
    }
    let mut truth = "the f64 reference from the same upload".to_string();
    for (name, model) in &args.model_of {
        truth.push_str(&format!(", {name} by the model {model}"));
    }
    let size = Size { fragments: taken as u64, lights: stage.lights() };
    let about = About { subject, truth, unit: Unit::Fragment, size };
    let entries = entries(args, &variants, &renderers, &stages);
    Ok(Some(measured(about, entries, args, streams)))
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
    stages: &[&'a Stage],
) -> Entries<'a> {
    let mut entries = Entries::default();
    for ((name, what), stage) in variants.iter().zip(stages) {
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
                let (runner, permitted) = (rust(), None);
                let entry = Entry { variant, runner, workload, errors, permitted, work };
                entries.measured.push(entry);
            }
            Err(reason) => entries.fail(name, "rust", reason),
        }
    }
    if renderers.iter().all(Option::is_none) {
        return entries;
    }
    let names = if args.reader.is_empty() { &ReaderName::ALL[..] } else { &args.reader };
    for reader in names {
        let shared: Shared = match readers::timed(*reader, args.adapter.as_deref()) {
            Ok(opened) => Rc::new(RefCell::new(opened)),
            Err(failure) => {
                entries.fail("every shader", reader.name(), failure.message);
                continue;
            }
        };
        let runner = Runner::of(shared.borrow().device(), Clock::Processor);
        for (((name, _), renderer), stage) in variants.iter().zip(renderers).zip(stages) {
            let Some(renderer) = renderer else { continue };
            let made = Shader::new(stage, renderer, Rc::clone(&shared), args.limit)
                .map_err(|error| error.to_string())
                .and_then(|mut shader| shader.judged().map(|judged| (shader, judged)));
            match made {
                Ok((shader, (errors, work))) => {
                    let (variant, runner) = (name.clone(), runner.clone());
                    let workload = Box::new(shader);
                    let permitted = None;
                    let entry = Entry { variant, runner, workload, errors, permitted, work };
                    entries.measured.push(entry);
                }
                Err(reason) => entries.fail(name, reader.name(), reason),
            }
        }
    }
    entries
}
