//! `landfall run`: calls a function of a shader in f32 and f64.

use landfall_exec::harness::call::{Request, call};
use landfall_exec::report::run as print;
use landfall_interp::Floats;
use landfall_layout::Error;
use serde_json::Value;

use crate::args::{BackendName, RunArgs, RunFormat};
use crate::output::{CommandFailure, FindingForm, Outcome, Streams};
use crate::{backends, data, read, shader};

pub fn run(args: &RunArgs, streams: &Streams) -> Result<Outcome, CommandFailure> {
    // In JSON, findings are part of the result.
    let style = streams.style(FindingForm::json_if(args.format == RunFormat::Json));
    let source = read::shader_text(&args.file, &args.read);
    let source = source.map_err(|error| style.request(error))?;
    let request = request(args).map_err(|error| style.request(error))?;
    let mut backend = match args.backend {
        // The interpreter always runs.
        BackendName::Cpu => None,
        BackendName::Gl | BackendName::Gpu => {
            let opened = backends::open_one(args.backend, args.adapter.as_deref());
            Some(opened.map_err(|failure| {
                let message = format!("cannot run the function: {}", failure.message);
                Error::new(args.backend.name(), message).with_help(
                    "`landfall devices` lists the backends; `--backend cpu` needs no driver",
                )
            })?)
        }
    };
    let options = read::options(&args.read);
    shader::record_function(&source, &options, streams, style);
    let called = match &mut backend {
        Some(backend) => call(&source, &options, &request, Some(backend.as_mut())),
        None => call(&source, &options, &request, None),
    };
    let report = called.map_err(|refusal| style.failure(&refusal.found, &refusal.files))?;
    match args.format {
        RunFormat::Human => {
            streams.product(&print::text(&report, streams.paint))?;
            streams.finish()?;
            streams.report(&style.text(&report.findings(), &report.files));
        }
        RunFormat::Json => streams.json(&print::json(&report))?,
    }
    Ok(Outcome::Clean)
}

fn request(args: &RunArgs) -> Result<Request, Error> {
    let Value::Array(arguments) = data::value("--args", &args.arguments)? else {
        return Err(
            Error::new("--args", "is not an array of arguments").with_help("write `[1, 2]`")
        );
    };
    let floats = args.floats.floats();
    // Rounding to f16 is simulated, which only the interpreter does.
    if floats != Floats::AsWritten && args.backend != BackendName::Cpu {
        let backend = format!("--backend {}", args.backend.name());
        return Err(Error::new(backend, "cannot round to f16: drivers run the source as written")
            .with_help("remove --half and --mediump, or use `--backend cpu`"));
    }
    let inputs =
        args.inputs.iter().map(|(name, text)| Ok((name.clone(), data::value("--input", text)?)));
    Ok(Request {
        function: args.function.clone(),
        arguments,
        data: data::blocks(args.data.as_deref())?,
        textures: data::textures(&args.textures)?,
        inputs: inputs.collect::<Result<_, Error>>()?,
        floats,
        limit: args.limit,
    })
}
