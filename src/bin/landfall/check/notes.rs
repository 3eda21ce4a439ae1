//! What a check says on standard error when it is done.

use std::hash::{DefaultHasher, Hash as _, Hasher as _};
use std::time::Duration;
use std::{env, fs};

use landfall_check::baseline::JudgedFindings;
use landfall_check::config::Config;
use landfall_check::fix::{self, AppliedFixes};
use landfall_check::pass::{CheckRun, Pass};
use landfall_check::texts::Texts;
use landfall_check::{add_allow, tree};
use landfall_layout::finding::Finding;
use landfall_layout::format::phrases::counted;
use landfall_lint::LINTS;
use landfall_lint::render::ReportFormat;

use super::cache_dir;
use crate::args::CheckArgs;
use crate::output::Streams;

/// The note without any locks, instead of a finding per shader.
pub const NO_LOCKS: &str = "no layouts are locked: `landfall lock` records them, so that check \
                            can tell when one changes\n";

/// What a check did beside its findings.
pub fn closing(
    check: &CheckRun<'_>,
    pass: &Pass,
    args: &CheckArgs,
    applied: &AppliedFixes,
    streams: &Streams,
) {
    if args.is_report {
        // The findings are in the page, but for what is missing from it.
        return streams.report(&of_failures(check, pass).unwrap_or_default());
    }
    if cache_dir(args, check.config).is_some() {
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
    let scope = &check.basis.scope;
    let is_without_locks = scope.locks.is_none() && scope.against.is_none();
    let is_set_up = check.config.file.is_some() || !is_without_locks;
    if is_set_up || streams.is_quiet() || !streams.is_terminal() || is_hinted_today() {
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

/// Whether hints were given in this folder within a day; if not, records that they are now.
fn is_hinted_today() -> bool {
    const DAY: Duration = Duration::from_secs(24 * 60 * 60);
    let Ok(folder) = env::current_dir() else { return false };
    let mut hasher = DefaultHasher::new();
    folder.hash(&mut hasher);
    let stamp = env::temp_dir().join(format!("landfall-hints-{:016x}", hasher.finish()));
    let is_of_today = |found: fs::Metadata| {
        found.modified().is_ok_and(|time| time.elapsed().is_ok_and(|age| age < DAY))
    };
    if fs::symlink_metadata(&stamp).is_ok_and(is_of_today) {
        return true;
    }
    // Where no file can be made, hints come again.
    let _ = fs::remove_file(&stamp);
    let _ = fs::File::create_new(&stamp);
    false
}

/// What became of a baseline that was to be written.
pub fn of_baseline(judged: &JudgedFindings, args: &CheckArgs, config: &Config, streams: &Streams) {
    let Some((path, count)) = &judged.written else { return };
    let Some(count) = count else {
        return streams.notes(&format!("{path} is not written: not every shader was checked\n"));
    };
    streams.notes(&format!("recorded {} in {path}\n", counted(*count, "finding")));
    if args.baseline.is_none() && config.baseline.is_none() {
        streams.notes(&format!(
            "permit them with `--baseline {path}`, or `baseline` in `landfall.toml`\n"
        ));
    }
}

/// What is wrong with shaders that could not be checked; `None` if all could.
pub fn of_failures(check: &CheckRun<'_>, pass: &Pass) -> Option<String> {
    if pass.failures() == 0 {
        return None;
    }
    let is_failure = |finding: &Finding| landfall_lint::lint(&finding.code).is_none();
    let failed: Vec<Finding> =
        tree::findings_in_shaders(pass).into_iter().filter(is_failure).collect();
    let texts = Texts::new(check.stdin.clone());
    let options = landfall_lint::render::ReportOptions {
        paint: landfall_layout::format::Paint::Plain,
        text: &|path| texts.of(path),
        shaders: failed.len(),
    };
    Some(landfall_lint::render::report(&failed, ReportFormat::Human, &options))
}
