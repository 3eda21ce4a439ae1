//! What a check says on standard error when it is done.

use landfall_layout::finding::Finding;
use landfall_layout::format::phrases::counted;
use landfall_lint::LINTS;
use landfall_lint::render::ReportFormat;

use super::fix::{self, AppliedFixes};
use super::pass::{Pass, Run};
use super::{add_allow, cache, reports, tree};
use crate::args::CheckArgs;
use crate::config::Config;
use crate::output::Streams;

/// The note without any locks, instead of a finding per shader.
pub const NO_LOCKS: &str = "no layouts are locked: `landfall lock` records them, so that check \
                            can tell when one changes\n";

/// What a check did beside its findings.
pub fn closing(
    run: &Run<'_>,
    pass: &Pass,
    (args, config): (&CheckArgs, &Config),
    applied: &AppliedFixes,
    streams: &Streams,
) {
    if args.is_report {
        // The findings are in the page, but for what is missing from it.
        return streams.report(&of_failures(run, pass).unwrap_or_default());
    }
    if cache::folder(args, config).is_some() {
        let all = counted(pass.checked.len(), "shader");
        streams.notes(&format!("laid out {} of {all}, the rest is unchanged\n", pass.fresh));
    }
    if args.fix {
        streams.notes(&fix::summary(applied));
    }
    if args.add_allow {
        streams.notes(&add_allow::summary(applied));
    }
    if pass.accepted > 0 {
        streams.notes(&format!("accepted {}\n", counted(pass.accepted, "layout")));
    }
    if pass.kept_locks > 0 {
        let kept = counted(pass.kept_locks, "lock");
        streams.notes(&format!(
            "kept {kept}: a policy forbids the changes; `landfall lock --policy none` writes them\n"
        ));
    }
    let is_without_locks = run.basis.locks.is_none() && run.basis.against.is_none();
    if config.file.is_some() || !is_without_locks || !streams.is_terminal() {
        return;
    }
    // For people, in a folder that is not set up.
    streams.notes(NO_LOCKS);
    let missing = LINTS.iter().filter(|lint| !lint.is_built()).count();
    if missing > 0 {
        streams.notes(&format!(
            "{missing} lints that follow code are not in this build: they need the feature `analysis`\n"
        ));
    }
}

/// What is wrong with shaders that could not be checked; `None` if all could.
pub fn of_failures(run: &Run<'_>, pass: &Pass) -> Option<String> {
    if pass.failures() == 0 {
        return None;
    }
    let is_failure = |finding: &Finding| landfall_lint::lint(&finding.code).is_none();
    let failed: Vec<Finding> =
        tree::findings_in_shaders(pass).into_iter().filter(is_failure).collect();
    let texts = reports::Texts::new(run.stdin.clone());
    let options = landfall_lint::render::ReportOptions {
        paint: landfall_layout::format::Paint::Plain,
        text: &|path| texts.of(path),
        shaders: failed.len(),
    };
    Some(landfall_lint::render::report(&failed, ReportFormat::Human, &options))
}
