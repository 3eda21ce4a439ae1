//! `landfall merge`: combines the reports of all shards of a check.

use std::collections::HashMap;
use std::path::Path;

use landfall_layout::Error;

use crate::args::{Form, MergeArgs};
use crate::check::baseline::{Baseline, Scope};
use crate::check::check_shader::Checked;
use crate::check::tree::{self, Memory};
use crate::check::{notes, reports, shard};
use crate::config::Root;
use crate::output::{Failure, Outcome, Streams};
use crate::write;

pub fn run(args: &MergeArgs, streams: &Streams) -> Result<Outcome, Failure> {
    if let Some(error) = reports::refused(&args.formats) {
        return Err(error);
    }
    if args.formats.iter().any(|report| report.format == Form::Html) {
        return Err(Error::new(
            "--format html",
            "shows layouts, which reports of shards do not hold",
        )
        .with_help("write the page with `landfall report`"));
    }
    let mut whole = shard::merge_reports(&args.reports)?;
    whole.basis.read_rust_files()?;
    let basis = &whole.basis;
    let root = Root::new(Path::new(&basis.root))?;
    // The shaders are stored without their findings, which follow separately.
    let over_all = tree::findings(&mut whole.pass, basis, &root, &mut Memory::default(), &[]);
    let findings = tree::sorted(over_all.into_iter().chain(whole.findings).collect());
    let texts = reports::Texts::new(HashMap::new());
    let scope = Scope { pass: &whole.pass, basis, root: &root, texts: &texts };
    let baseline = args.baseline.as_deref().map(Baseline::read).transpose()?;
    let (findings, permitted) = match baseline {
        Some(baseline) => {
            let divided = baseline.divide(findings, &scope);
            (divided.findings, Some(divided.permitted))
        }
        None => (findings, None),
    };
    let result = reports::Result {
        findings: &findings,
        shaders: whole.pass.checked.len(),
        failures: whole.pass.failures(),
        texts: &texts,
        permitted,
        shard: None,
        page: None,
    };
    let mut writer = write::writer();
    writer.protect(&args.reports);
    writer.protect(whole.pass.checked.iter().flat_map(Checked::files));
    let outcome = reports::write(&result, &args.formats, args.statistics, writer, streams)?;
    if whole.basis.locks.is_none() && whole.basis.against.is_none() {
        streams.notes(notes::NO_LOCKS);
    }
    Ok(outcome)
}
