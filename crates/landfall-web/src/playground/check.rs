//! What `landfall check` finds in one shader, without locks and configuration.

use landfall_layout::finding::{Finding, Level};
use landfall_layout::format::Paint;
use landfall_layout::{Error, Severity, Source, layout};
use landfall_lint::allow::{allows, suppress, unused};
use landfall_lint::digest::{digest, shaders_to_compare};
use landfall_lint::render::{ReportFormat, ReportOptions, report};
use landfall_lint::run::{MAX_ERRORS, has_run, shader_unsuppressed, sorted, tree_unsuppressed};
use landfall_lint::{Settings, Subject, levels, naga_disagrees};

use super::{Output, Request, unknown};

/// The findings of all lints in a shader, in their order; of one with errors, those.
pub(super) fn findings(request: &Request, source: &Source) -> Result<Vec<Finding>, Error> {
    Ok(all(request, source)?.0)
}

/// The findings, and whether the shader has errors.
fn all(request: &Request, source: &Source) -> Result<(Vec<Finding>, bool), Error> {
    let settings = Settings { targets: request.limits(), ..Settings::default() };
    let plain = request.options()?;
    let options = plain.clone().with_naga(naga_disagrees::applies_to(source.language, &settings));
    let shader = layout(source, &options);
    let (errors, warnings): (Vec<_>, Vec<_>) =
        shader.diagnostics.iter().partition(|found| found.severity == Severity::Error);
    let located = warnings.into_iter().map(|found| found.located(&shader.files)).collect();
    let mut found = levels::at_levels(located, &settings);
    let mut over_all = Vec::new();
    if errors.is_empty() {
        let subject = Subject { source, options: &options, shader: &shader };
        found.extend(shader_unsuppressed(&subject, &settings));
        let digest = digest(&shader);
        if !shaders_to_compare(&[(source.path.as_str(), &digest)], &settings).is_empty() {
            let subject = Subject { options: &plain, ..subject };
            over_all = tree_unsuppressed(&[subject], &settings);
        }
    }
    let mut allowed = allows(&shader.files, shader.language);
    suppress(&mut found, &mut allowed);
    let failed = !errors.is_empty();
    found.extend(errors.iter().take(MAX_ERRORS).map(|error| error.located(&shader.files)));
    if let (Some(last), true) = (found.last_mut(), errors.len() > MAX_ERRORS) {
        last.notes.push(format!("and {} more errors", errors.len() - MAX_ERRORS));
    }
    suppress(&mut over_all, &mut allowed);
    over_all.extend(unused(&allowed, &settings, |code| has_run(code, false, false)));
    over_all.extend(found);
    Ok((sorted(over_all), failed))
}

/// What `landfall check --format FORMAT` prints.
pub(super) fn output(request: &Request, source: &Source, name: &str) -> Result<Output, Error> {
    // The others are not part of the page.
    let format = match name {
        "human" => ReportFormat::Human,
        "json" => ReportFormat::Json,
        other => return Err(unknown("--format", other)),
    };
    let (findings, failed) = all(request, source)?;
    let text = |path: &str| request.text_of(source, path);
    let options = ReportOptions { paint: Paint::Plain, text: &text, shaders: 1 };
    let denied = findings.iter().any(|finding| finding.level() == Level::Deny);
    Ok(Output {
        stdout: report(&findings, format, &options),
        stderr: String::new(),
        code: if failed { 2 } else { u8::from(denied) },
    })
}
