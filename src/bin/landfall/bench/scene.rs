//! Benches variants that light a scene: shaders on backends, and compiled kernels.

use std::cell::RefCell;
use std::path::PathBuf;
use std::rc::Rc;

use landfall_accuracy::bench::clock::Clock;
use landfall_accuracy::bench::counted;
use landfall_accuracy::bench::native::Compiled;
use landfall_accuracy::bench::scene::BenchScene;
use landfall_accuracy::bench::shader::Shader;
use landfall_accuracy::bench::uploaded::Uploaded;
use landfall_accuracy::bench::{Permitted, Runner, Size, Unit, Work};
use landfall_exec::backend::Backend;
use landfall_interp::{Cpu, Floats};
use landfall_layout::Error;
use landfall_layout::source::kind_of_path;
use landfall_light::reference::Model;
use landfall_light::render::{Renderer, truth};
use landfall_light::shading_f32::{Form, Gates};
use landfall_light::{Frame, Upload, culling};

use super::{
    About, BenchEntry, Entries, FinishedBench, NO_HALF, ShaderSources, distinct, measured,
    print_notes, recorded, rounded, rust, wrong,
};
use crate::args::{BackendName, BenchArgs};
use crate::output::{CommandFailure, FindingStyle, Streams};
use crate::render::request::{RenderArguments, RenderRequest, load, model, model_json};
use crate::{backends, read, write};

enum VariantKind {
    /// A shader file or the scene's shader, its precision, and a plan.
    Shader(Option<PathBuf>, Floats, Option<culling::Options>),
    /// A compiled kernel, with the specular threshold.
    Rust(Form, f64),
    /// The compiled kernel with a plan.
    Plan(culling::Options),
}

impl VariantKind {
    fn is_planned(&self) -> bool {
        match self {
            VariantKind::Plan(_) | VariantKind::Shader(_, _, Some(_)) => true,
            VariantKind::Rust(..) | VariantKind::Shader(_, _, None) => false,
        }
    }
}

pub fn bench(
    args: &BenchArgs,
    streams: &Streams,
    style: &FindingStyle,
) -> Result<FinishedBench, CommandFailure> {
    distinct("--variant", &args.variants, None)?;
    distinct("--model-of", &args.model_of, None)?;
    if kind_of_path(&args.subject).is_some() {
        let shown = args.subject.display().to_string();
        return Err(Error::new(shown, "is a shader, not a scene")
            .with_help("measure a function of a shader with `--fn NAME`")
            .into());
    }
    let wanted = RenderArguments {
        scene: &args.subject,
        shader: None,
        entry: None,
        size: args.size,
        model: args.model.clone(),
        bind: args.bind.clone(),
        read: &args.read,
    };
    let own = load(&wanted, streams, style)?;
    let variants = variants(args, &own)?;
    let unknown = args.model_of.iter().find(|(of, _)| variants.iter().all(|(name, _)| name != of));
    if let Some((name, _)) = unknown {
        let message = format!("sets the model of `{name}`, which is not a variant");
        return Err(Error::new("--model-of", message).into());
    }
    let mut sources = ShaderSources::default();
    let mut renderers: Vec<Option<Renderer>> = Vec::new();
    let mut models: Vec<Option<Model>> = Vec::new();
    for (name, what) in &variants {
        let own_model = args.model_of.iter().find(|(of, _)| of == name);
        let json = own_model.map(|(_, text)| model_json("--model-of", text)).transpose()?;
        models.push(json.map(|json| model("--model-of", json)).transpose()?);
        renderers.push(match what {
            VariantKind::Shader(file, ..) => {
                let request = match file {
                    Some(file) => &own.with_shader(sources.read(file, &args.read)?),
                    None => &own,
                };
                let renderer =
                    request.renderer().map_err(|error| request.failure(&error, style))?;
                let what = "needs the scene's shader, but the scene names none";
                Some(renderer.ok_or_else(|| wrong(name, what))?)
            }
            VariantKind::Rust(..) | VariantKind::Plan(_) => None,
        });
    }
    let likely =
        || renderers.iter().flatten().next().map(|renderer| truth::likely_model(&renderer.map));
    let model: Model = own.model.or_else(likely).unwrap_or_default();
    let plans = variants.iter().any(|(_, what)| what.is_planned());
    let most = if plans { u64::MAX } else { args.most };
    let frame = Frame::new(&own.scene, &own.frame);
    let all = frame.fragments.len();
    shows_an_object(args, all)?;
    let upload = Upload::new(&own.scene);
    let stage = BenchScene::new(model, upload.clone(), frame.clone(), most);
    let others: Vec<Option<BenchScene>> = models
        .into_iter()
        .map(|model| model.map(|model| BenchScene::new(model, upload.clone(), frame.clone(), most)))
        .collect();
    let stages: Vec<&BenchScene> =
        others.iter().map(|other| other.as_ref().unwrap_or(&stage)).collect();
    let taken = stage.frame.fragments.len();
    let mut subject = own.scene.name.clone();
    if taken < all {
        subject.push_str(&format!(", {taken} of {all} fragments"));
    }
    let size = Size { fragments: taken as u64, lights: stage.lights() };
    let options = read::options(&args.read);
    let mut files = own.files_read();
    let notes = variants.iter().filter_map(|(_, what)| match what {
        VariantKind::Shader(_, floats, _) => floats.note(),
        VariantKind::Rust(..) | VariantKind::Plan(_) => None,
    });
    print_notes(notes, streams);
    let shaders = variants.iter().filter_map(|(name, what)| match what {
        VariantKind::Shader(Some(file), ..) => Some((name.as_str(), sources.of(file)?)),
        VariantKind::Shader(None, ..) => Some((name.as_str(), own.shader.as_ref()?)),
        VariantKind::Rust(..) | VariantKind::Plan(_) => None,
    });
    let assumed = recorded(shaders, &options, streams, *style);
    files.extend(sources.all().map(|source| write::files_of(source, &options)));
    let truth = truth_text(args);
    let about = About { subject, truth, unit: Unit::Fragment, size, inputs: None, assumed, files };
    let requested = backends::requested(&args.backend);
    let uploads = uploads(args, &requested, &variants, &renderers, &stages);
    let entries = entries(args, &variants, &uploads, &stages);
    Ok(measured(about, entries, args, streams))
}

/// A shader variant with its bindings on some backends.
struct ShaderUpload<'a> {
    variant: &'a str,
    floats: Floats,
    backends: &'a [BackendName],
    uploaded: Result<Uploaded<'a>, String>,
}

/// Binds the shader variants.
fn uploads<'a>(
    args: &BenchArgs,
    requested: &'a [BackendName],
    variants: &'a [(String, VariantKind)],
    renderers: &'a [Option<Renderer>],
    stages: &[&'a BenchScene],
) -> Vec<ShaderUpload<'a>> {
    let mut uploads = Vec::new();
    for (((variant, what), renderer), stage) in variants.iter().zip(renderers).zip(stages) {
        let (VariantKind::Shader(_, floats, plan), Some(renderer)) = (what, renderer) else {
            continue;
        };
        // A plan has several sets of lights, and a block for each.
        let uploaded = match plan {
            Some(plan) => Uploaded::by_plan(stage, renderer, args.limit, plan),
            None => Uploaded::new(stage, renderer, args.limit),
        };
        uploads.push(ShaderUpload { variant, floats: *floats, backends: requested, uploaded });
    }
    uploads
}

/// Refuses a scene without fragments, of which nothing can be measured.
fn shows_an_object(args: &BenchArgs, fragments: usize) -> Result<(), Error> {
    if fragments > 0 {
        return Ok(());
    }
    let what = "shows no object in any pixel: there is nothing to measure";
    Err(Error::new(args.subject.display().to_string(), what)
        .with_help("turn its camera, or enlarge it with `--size`"))
}

/// The text that names the reference of the errors.
fn truth_text(args: &BenchArgs) -> String {
    let mut truth = "the f64 reference from the same upload".to_string();
    for (name, model) in &args.model_of {
        truth.push_str(&format!(", for {name} with the model {model}"));
    }
    truth
}

/// The given variants, or by default the scene's shader and the compiled kernels.
fn variants(args: &BenchArgs, own: &RenderRequest) -> Result<Vec<(String, VariantKind)>, Error> {
    let rust = |gates, least| VariantKind::Rust(Form::Robust(gates), least);
    if args.variants.is_empty() {
        let mut all = vec![
            ("seed".to_string(), VariantKind::Rust(Form::Seed, 0.0)),
            ("ungated".to_string(), rust(Gates::NONE, 0.0)),
            ("robust".to_string(), rust(Gates::ALL, 0.0)),
            ("robust, highlights from 2^-24".to_string(), rust(Gates::ALL, 2f64.powi(-24))),
            ("robust, highlights from 1/64 step".to_string(), rust(Gates::ALL, 1.0 / 64.0 / 255.0)),
            ("robust, highlights from 1/8 step".to_string(), rust(Gates::ALL, 1.0 / 8.0 / 255.0)),
        ];
        if let Some(shader) = &own.shader {
            all.push((shader.path.clone(), VariantKind::Shader(None, Floats::AsWritten, None)));
        }
        return Ok(all);
    }
    let one = |(name, what): &(String, String)| {
        let plan = |options| {
            culling::parse(options).map_err(|error| wrong(name, format!("is not a plan: {error}")))
        };
        // variant = "rust:" kernel | "plan:" options | [FILE] [":half" | ":mediump"] ["+plan:"
        // options].
        let what = match what.split_once(':') {
            Some(("rust", "seed")) => VariantKind::Rust(Form::Seed, 0.0),
            Some(("rust", "ungated")) => rust(Gates::NONE, 0.0),
            Some(("rust", "robust")) => rust(Gates::ALL, 0.0),
            Some(("rust", form)) => {
                let least = form.strip_prefix("robust=").and_then(|x| x.parse::<f64>().ok());
                let least = least.filter(|least| (0.0..1.0).contains(least)).ok_or_else(|| {
                    wrong(name, format!("is not a compiled kernel: `{form}`")).with_help(
                        "the kernels are `seed`, `robust`, `ungated` and `robust=POWER`, POWER < 1",
                    )
                })?;
                rust(Gates::ALL, least)
            }
            Some(("plan", options)) => VariantKind::Plan(plan(options)?),
            _ => {
                // The suffix of the precision comes last of all, behind a plan.
                let (what, floats) = rounded(what);
                let (file, plan) = match what.split_once("+plan:") {
                    Some((file, options)) => (file, Some(plan(options)?)),
                    None => (what, None),
                };
                // The scene's shader, rounded.
                let file = (!file.is_empty()).then(|| PathBuf::from(file));
                VariantKind::Shader(file, floats, plan)
            }
        };
        Ok((name.clone(), what))
    };
    args.variants.iter().map(one).collect()
}

/// The entries to measure with their errors, and the failures.
fn entries<'a>(
    args: &BenchArgs,
    variants: &'a [(String, VariantKind)],
    uploads: &'a [ShaderUpload<'a>],
    stages: &[&'a BenchScene],
) -> Entries<'a> {
    let mut entries = Entries::default();
    for ((name, what), stage) in variants.iter().zip(stages) {
        let made = match what {
            VariantKind::Shader(..) => continue,
            VariantKind::Rust(form, least) => Compiled::new(stage, *form, *least),
            VariantKind::Plan(options) => Compiled::new(stage, Form::Robust(Gates::ALL), 0.0)
                .map(|compiled| compiled.by_plan(options)),
        };
        match made {
            Ok(compiled) => {
                let (errors, work) = compiled.measure_errors();
                let (variant, workload) = (name.clone(), Box::new(compiled));
                let (runner, permitted) = (rust(), None);
                let (ends, worst) = (None, Vec::new());
                let entry =
                    BenchEntry { variant, runner, workload, errors, ends, worst, permitted, work };
                entries.measured.push(entry);
            }
            Err(reason) => entries.fail(name, "rust", reason),
        }
    }
    if uploads.is_empty() {
        return entries;
    }
    // Work and permitted errors are counted once for all backends.
    let mut lit = Vec::new();
    for ShaderUpload { variant, floats, backends, uploaded } in uploads {
        match uploaded {
            Ok(uploaded) => lit.push(Counted {
                name: variant,
                uploaded,
                floats: *floats,
                backends,
                work: counted::work(uploaded, *floats),
                permitted: counted::permitted(uploaded, *floats),
            }),
            Err(reason) => {
                let names: Vec<&str> = backends.iter().map(|name| name.name()).collect();
                entries.fail(variant, &names.join(", "), reason.as_str());
            }
        }
    }
    for backend in backends::requested(&args.backend) {
        on_backend(args, backend, &lit, &mut entries);
    }
    entries
}

/// A shader with the data that is independent of backends.
struct Counted<'a> {
    name: &'a str,
    uploaded: &'a Uploaded<'a>,
    floats: Floats,
    backends: &'a [BackendName],
    work: Work,
    permitted: Option<Permitted>,
}

/// Adds the shaders on a backend, which they share.
fn on_backend<'a>(
    args: &BenchArgs,
    name: BackendName,
    lit: &[Counted<'a>],
    entries: &mut Entries<'a>,
) {
    let Some(shared) = entries.open(args, name, "every shader") else { return };
    let runner = Runner::new(shared.borrow().device(), Clock::Processor);
    let here = lit.iter().filter(|counted| counted.backends.contains(&name));
    for Counted { name: variant, uploaded, floats, work, permitted, .. } in here {
        // Rounding needs an interpreter of its own.
        let shared = match (name, floats) {
            (_, Floats::AsWritten) => Rc::clone(&shared),
            (BackendName::Cpu, Floats::Half | Floats::Mediump) => {
                let cpu = Cpu::rounded(Default::default(), *floats);
                Rc::new(RefCell::new(Box::new(cpu) as Box<dyn Backend>))
            }
            (BackendName::Gl | BackendName::Gpu, Floats::Half | Floats::Mediump) => {
                entries.fail(variant, name.name(), NO_HALF);
                continue;
            }
        };
        let mut shader = Shader::new(uploaded, shared);
        match shader.measure_errors() {
            Ok(errors) => entries.measured.push(BenchEntry {
                variant: (*variant).to_string(),
                runner: runner.clone(),
                workload: Box::new(shader),
                errors,
                ends: None,
                worst: Vec::new(),
                permitted: *permitted,
                work: *work,
            }),
            Err(reason) => entries.fail(variant, name.name(), reason),
        }
    }
}
