//! `landfall run`: one function called, its results in f32 beside f64.

use landfall::report::run as print;
use landfall_exec::harness::call::{Request, call};
use landfall_exec::interp::Floats;
use landfall_layout::Error;
use landfall_layout::source::Files;
use serde_json::Value;

use crate::args::{ReaderName, RunArgs, RunFormat};
use crate::output::{Failure, FindingForm, Outcome, Streams, asked_wrongly};
use crate::{data, given, read, readers, write};

pub fn run(args: &RunArgs, streams: &Streams) -> Result<Outcome, Failure> {
    // In JSON, what was found is part of the product.
    let form = match args.format {
        RunFormat::Human => FindingForm::Human,
        RunFormat::Json => FindingForm::Json,
    };
    let style = streams.style(form);
    let made = (|| Ok((read::source(&args.file, &args.read)?, request(args)?)))();
    let (source, request) = match made {
        Ok(made) => made,
        Err(error) => {
            streams.report(&style.text(&[asked_wrongly(error)], &Files::default()));
            return Ok(Outcome::CouldNot);
        }
    };
    let mut reader = match args.reader {
        // The evaluator runs in any case.
        ReaderName::Cpu => None,
        ReaderName::Gl | ReaderName::Gpu => {
            let opened = readers::one(args.reader, args.adapter.as_deref());
            Some(opened.map_err(|failure| {
                let message = format!("cannot run it: {}", failure.message);
                Error::new(args.reader.name(), message).with_help(
                    "`landfall devices` lists what is here; `--reader cpu` needs nothing",
                )
            })?)
        }
    };
    let options = read::options(&args.read);
    given::saw(&write::files_of(&source, &options));
    let called = match &mut reader {
        Some(reader) => call(&source, &options, &request, Some(reader.as_mut())),
        None => call(&source, &options, &request, None),
    };
    match called {
        Ok(report) => {
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
        Err(refusal) => {
            streams.report(&style.text(&refusal.found, &refusal.files));
            Ok(Outcome::CouldNot)
        }
    }
}

fn request(args: &RunArgs) -> Result<Request, Error> {
    let Value::Array(arguments) = data::value("--args", &args.arguments)? else {
        return Err(Error::new("--args", "is no array of arguments").with_help("write `[1, 2]`"));
    };
    let floats = args.floats.floats();
    if floats != Floats::AsWritten && args.reader != ReaderName::Cpu {
        let reader = format!("--reader {}", args.reader.name());
        return Err(Error::new(reader, "runs the text as it is written")
            .with_help("leave out --half and --mediump, or let `cpu` round"));
    }
    let inputs =
        args.inputs.iter().map(|(name, text)| Ok((name.clone(), data::value("--input", text)?)));
    Ok(Request {
        function: args.function.clone(),
        arguments,
        data: data::blocks(args.data.as_deref())?,
        textures: textures(&args.textures)?,
        inputs: inputs.collect::<Result<_, Error>>()?,
        floats,
        limit: args.limit,
    })
}

/// Colours of textures by name.
pub fn textures(given: &[(String, String)]) -> Result<Vec<(String, [f32; 4])>, Error> {
    let colours = given
        .iter()
        .map(|(name, text)| Ok((name.clone(), colour(&data::value("--texture", text)?, name)?)));
    colours.collect()
}

/// Four numbers.
fn colour(value: &Value, name: &str) -> Result<[f32; 4], Error> {
    let numbers: Option<Vec<f32>> = value
        .as_array()
        .and_then(|items| items.iter().map(|item| item.as_f64().map(|x| x as f32)).collect());
    numbers.and_then(|numbers| numbers.try_into().ok()).ok_or_else(|| {
        Error::new("--texture", format!("gives `{name}` no colour of four numbers"))
            .with_help(format!("write `{name}=[1, 1, 1, 1]`"))
    })
}
