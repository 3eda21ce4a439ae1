//! Variants of one function, called by the evaluator with random arguments.

use std::path::PathBuf;

use landfall::accuracy::bench::clock::Clock;
use landfall::accuracy::bench::function::{Calls, Function};
use landfall::accuracy::bench::{Bench, Failed, Runner, Size};
use landfall::run::eval::Cpu;
use landfall::run::reader::Reader;

use super::{About, Entry, measured, wrong};
use crate::args::{BenchArgs, BenchFormat};
use crate::output::{Failure, FindingForm, Streams};
use crate::read;

pub fn bench(args: &BenchArgs, name: &str, streams: &Streams) -> Result<Option<Bench>, Failure> {
    let style = streams.style(match args.format {
        BenchFormat::Human | BenchFormat::Csv => FindingForm::Human,
        BenchFormat::Json => FindingForm::Json,
    });
    let options = read::options(&args.read);
    let mut files = vec![("as it is".to_string(), args.subject.clone())];
    files.extend(args.variants.iter().map(|(name, file)| (name.clone(), PathBuf::from(file))));
    let mut functions = Vec::new();
    for (variant, file) in &files {
        let source = read::source(file, &args.read)?;
        match Function::new(&source, &options, name) {
            Ok(function) => functions.push((variant, function)),
            Err(found) => {
                let mut files = landfall::source::Files::default();
                files.add(source.path.clone(), source.text.clone());
                streams.report(&style.text(&found, &files));
                return Ok(None);
            }
        }
    }
    let calls =
        Calls::new(&functions[0].1, args.seed).map_err(|reason| wrong(functions[0].0, reason))?;
    let runner = Runner::of(Cpu::default().device(), Clock::Processor);
    let (mut entries, mut failed) = (Vec::new(), Vec::new());
    for (variant, function) in &functions {
        match calls.workload(function) {
            Ok((workload, errors, work)) => entries.push(Entry {
                variant: (*variant).clone(),
                runner: runner.clone(),
                workload: Box::new(workload),
                errors,
                work,
            }),
            Err(reason) => {
                let (variant, reader) = ((*variant).clone(), "cpu".to_string());
                failed.push(Failed { variant, reader, reason });
            }
        }
    }
    let about = About {
        subject: format!("{name} of {}, arguments of seed {}", args.subject.display(), args.seed),
        truth: "its own f64".to_string(),
        size: Size { fragments: calls.count() as u64, lights: 0 },
    };
    Ok(Some(measured(about, entries, failed, args, streams)))
}
