//! `landfall diff`: compares layouts, classifies each change, and prints both listings.

mod side;

use std::path::{Path, PathBuf};

use landfall_layout::diff::{Class, VariantDiff, diff_variants, verdict};
use landfall_layout::file::Written;
use landfall_layout::format::diff::{Compared, Width, human, json, markdown, summary};
use landfall_layout::format::{Paint, escape_controls};
use landfall_layout::source::Files;
use landfall_layout::text::escape;
use landfall_layout::{Diagnostic, Error, ShaderLayout, lock};
use landfall_web::html::{Page, Part};

use crate::args::{DiffArgs, DiffFormat};
use crate::config;
use crate::output::{CommandFailure, FindingForm, Outcome, Streams};
use crate::{git, templates, watch, write};
use landfall_check::config::Config;
use landfall_check::policies::forbidden;
use landfall_check::templates::Templates;
use side::{DiffedSide, SideEntry, SideReading, nothing, with_variants_of};

/// Width in columns without a terminal.
const COLUMNS: usize = 100;

pub fn run(args: &DiffArgs, streams: &Streams) -> Result<Outcome, CommandFailure> {
    // Arguments may be revisions: use the configuration of the current directory.
    let config = config::load(&args.config, &[], streams)?;
    let reading = SideReading {
        args: &args.read,
        options: config.options(&args.read.flags()),
        config: &config,
        streams,
        style: streams.style(FindingForm::Human),
        templates: Templates::default(),
    };
    let sides = sides(args, &reading);
    // Sides that were not read to their ends would differ.
    if watch::is_stopped() {
        return Ok(Outcome::Interrupted);
    }
    let mut sides = sides?;
    // Before pairing: entries meet by their keys.
    sides.iter_mut().for_each(|(old, new)| agree(old, new));
    // A shader that could not be read does not stop the comparison of the others; the outcome
    // tells.
    let mut failed = sides.iter().any(|(old, new)| old.failed || new.failed);
    let is_any = sides.iter().any(|(old, new)| !old.entries.is_empty() || !new.entries.is_empty());
    failed |= templates::report(&reading.templates, !is_any && !failed, reading.style, streams);
    let mut pairs = Vec::new();
    for (old, new) in &sides {
        pairs.extend(pair(old, new)?);
    }
    // Each shader as it is, then the variants that show more.
    let found: Vec<(&DiffedPair, VariantDiff<'_>)> = pairs
        .iter()
        .flat_map(|pair| {
            diff_variants(&pair.old, &pair.new).into_iter().map(move |one| (pair, one))
        })
        .collect();
    let variants: Vec<Option<String>> = found.iter().map(|(_, one)| one.name()).collect();
    // `--breaking` asks about breaking changes alone, whatever the policy.
    let policy = |pair: &DiffedPair| {
        args.policy.or_else(|| config.policy_of(&pair.file)).filter(|_| !args.breaking)
    };
    let compared: Vec<Compared<'_>> = found
        .iter()
        .zip(&variants)
        .map(|((pair, one), variant)| Compared {
            name: &pair.name,
            variant: variant.as_deref(),
            old: one.old,
            new: one.new,
            blocks: &one.blocks,
            policy: policy(pair),
            rust_field: landfall_codegen::rust::field,
        })
        .collect();
    let protected = pairs.iter().flat_map(|pair| [&pair.old.files, &pair.new.files]);
    print(args, &config, &compared, failed, protected, streams)?;
    let judged = found.iter().filter_map(|(pair, one)| Some((pair, one, policy(pair)?)));
    let errors: Vec<Diagnostic> =
        judged.flat_map(|(pair, one, policy)| forbidden(&pair.file, policy, one)).collect();
    // A policy also forbids to accept what it forbids.
    if args.accept && !errors.is_empty() {
        streams.report(&reading.style.text(&errors, &Files::default()));
        streams.notes("no lock was updated\n");
        return Ok(Outcome::Findings);
    }
    if args.accept && !failed {
        for (old, new) in &sides {
            accept(old, new, &config, streams)?;
        }
        return Ok(Outcome::Clean);
    }
    // Without a policy any change is a finding, or any breaking one.
    let least = if args.breaking { Class::Breaking } else { Class::Cosmetic };
    let is_finding = |compared: &Compared<'_>| match compared.policy {
        Some(policy) => policy.forbidden(compared.blocks).next().is_some(),
        None => verdict(compared.blocks).is_some_and(|class| class >= least),
    };
    Ok(match failed {
        true => Outcome::CouldNot,
        false if compared.iter().any(is_finding) => Outcome::Findings,
        false => Outcome::Clean,
    })
}

/// The pairs of sides to compare, old first.
fn sides(
    args: &DiffArgs,
    reading: &SideReading<'_>,
) -> Result<Vec<(DiffedSide, DiffedSide)>, Error> {
    match (&args.rev, args.sides.as_slice()) {
        // OLD NEW, or paths at a revision against the work tree.
        (None, [old, new]) => {
            crate::read::only_one_stdin(old, new)?;
            Ok(vec![(reading.side(old)?, reading.side(new)?)])
        }
        (None, given) => {
            let message = format!("needs 2 sides to compare, not {}", given.len());
            Err(Error::new("landfall diff", message)
                .with_help("`landfall diff OLD NEW`, or `landfall diff --rev HEAD~1 [PATH…]`"))
        }
        (Some(rev), paths) => {
            let here = [PathBuf::from(".")];
            let paths = if paths.is_empty() { &here[..] } else { paths };
            let at = |path: &PathBuf| {
                let revision = git::in_repository(rev, path)?;
                let mut old = reading.revision(&revision)?;
                // A removed file has no new side.
                let new = match path.exists() {
                    true => reading.side(path)?,
                    false => {
                        DiffedSide { entries: vec![], single: true, locks: None, failed: false }
                    }
                };
                // Files on both sides are compared with each other; a directory on one makes it
                // two directories.
                old.single &= new.single;
                Ok((old, new))
            };
            paths.iter().map(at).collect()
        }
    }
}

/// One shader on both sides.
struct DiffedPair {
    name: String,
    /// The path of the shader from the configuration's directory, which has the policy.
    file: String,
    old: ShaderLayout,
    new: ShaderLayout,
}

impl DiffedPair {
    fn new(old: Option<&SideEntry>, new: Option<&SideEntry>) -> Option<DiffedPair> {
        // A shader that one side lacks is compared with one without blocks.
        let like = new.or(old)?;
        // Prefer the path of a shader to that of its lock.
        let shader = [new, old].into_iter().flatten().find(|entry| entry.lock.is_none());
        let layout_of = |entry: Option<&SideEntry>| match entry {
            Some(entry) => entry.layout.clone(),
            None => nothing(&like.layout),
        };
        let (mut before, mut after) = (layout_of(old), layout_of(new));
        // Output of `layout` has no variants, so the other side's would all seem new.
        if [old, new].into_iter().flatten().any(|entry| entry.is_output) {
            before.variants.clear();
            after.variants.clear();
        }
        // A lock has only the variants whose blocks are others.
        if new.is_some_and(|entry| entry.lock.is_some()) {
            with_variants_of(&mut after, &before);
        }
        Some(DiffedPair {
            name: shader.unwrap_or(like).layout.path.clone(),
            file: [new, old]
                .into_iter()
                .flatten()
                .find_map(|entry| entry.shader.clone())
                .unwrap_or_else(|| like.layout.path.clone()),
            old: before,
            new: after,
        })
    }
}

/// Pairs the shaders of both sides by their paths below their directories.
fn pair(old: &DiffedSide, new: &DiffedSide) -> Result<Vec<DiffedPair>, Error> {
    // Two files are a pair, whatever their names.
    if old.single && new.single {
        // What was not read is not removed or new.
        if old.failed || new.failed {
            return Ok(Vec::new());
        }
        return Ok(DiffedPair::new(old.entries.first(), new.entries.first()).into_iter().collect());
    }
    if old.single != new.single && !old.failed && !new.failed {
        let one = if old.single { old } else { new };
        let path = one.entries.first().map(|entry| entry.layout.path.clone());
        let message = "is one shader, but the other side is a directory";
        return Err(Error::new(path.unwrap_or_default(), message)
            .with_help("compare a file with a file, a directory with a directory"));
    }
    let (a, b) = (keys(old), keys(new));
    let partner = |key: &str, keys: &[String], side: &'_ DiffedSide| -> Option<usize> {
        keys.iter().position(|other| other == key).filter(|at| *at < side.entries.len())
    };
    let mut pairs = Vec::new();
    for (key, entry) in b.iter().zip(&new.entries) {
        let before = partner(key, &a, old).map(|at| &old.entries[at]);
        // A shader that failed on one side is not new on the other.
        if before.is_some() || !old.failed {
            // In the order of the new side; what is only in the old one comes last.
            pairs.extend(DiffedPair::new(before, Some(entry)));
        }
    }
    for (key, entry) in a.iter().zip(&old.entries) {
        if partner(key, &b, new).is_none() && !new.failed {
            pairs.extend(DiffedPair::new(Some(entry), None));
        }
    }
    Ok(pairs)
}

/// Locks are keyed from the configuration's directory, so shaders compared with them are too.
fn agree(old: &mut DiffedSide, new: &mut DiffedSide) {
    let all_locks = |side: &DiffedSide| side.entries.iter().all(|entry| entry.lock.is_some());
    let no_locks = |side: &DiffedSide| side.entries.iter().all(|entry| entry.lock.is_none());
    // Only where one side is all locks and the other all shaders.
    if !(all_locks(old) && no_locks(new) || no_locks(old) && all_locks(new)) {
        return;
    }
    // A directory of locks elsewhere, with other paths, keeps its own keys.
    let meet = old.entries.iter().any(|entry| {
        entry.shader.is_some() && new.entries.iter().any(|other| other.shader == entry.shader)
    });
    if !meet {
        return;
    }
    for entry in old.entries.iter_mut().chain(&mut new.entries) {
        if let Some(shader) = &entry.shader {
            entry.key = shader.clone();
        }
    }
}

/// The keys of a side; those of output of `layout` without their common directory.
fn keys(side: &DiffedSide) -> Vec<String> {
    let keys: Vec<String> = side.entries.iter().map(|entry| entry.key.clone()).collect();
    let from_output = side.entries.iter().all(|entry| entry.lock.is_none())
        && side.entries.iter().all(|entry| entry.layout.path.ends_with(".json"));
    // `landfall layout --out DIR` puts paths below a directory of its own.
    let common = keys.first().and_then(|key| key.split_once('/')).map(|(dir, _)| format!("{dir}/"));
    match common {
        Some(common) if from_output && keys.iter().all(|key| key.starts_with(&common)) => {
            keys.iter().map(|key| key[common.len()..].to_string()).collect()
        }
        Some(_) | None => keys,
    }
}

/// Prints the changes, or writes them to `--out`.
fn print<'a>(
    args: &'a DiffArgs,
    config: &'a Config,
    all: &[Compared<'_>],
    failed: bool,
    shaders: impl IntoIterator<Item = &'a Files>,
    streams: &Streams,
) -> Result<(), Error> {
    // A file gets no colours.
    let paint = if args.out.is_some() { Paint::Plain } else { streams.paint };
    let text = match args.format {
        DiffFormat::Json => json(all),
        DiffFormat::Md => markdown(all),
        DiffFormat::Html => page(all),
        DiffFormat::Human => {
            let terminal = || terminal_size::terminal_size().map(|(width, _)| width.0.into());
            let width = Width::Columns(args.width.or_else(terminal).unwrap_or(COLUMNS));
            let changed = all.iter().filter(|compared| !compared.blocks.is_empty());
            let texts = changed.map(|compared| human(compared, width, paint) + "\n");
            let summary = if failed && all.is_empty() {
                "nothing was compared\n".to_string()
            } else {
                summary(all)
            };
            texts.collect::<String>() + &summary
        }
    };
    let Some(out) = &args.out else {
        return match args.format {
            DiffFormat::Json => streams.json(&text),
            DiffFormat::Html => streams.source(&text),
            DiffFormat::Md | DiffFormat::Human => streams.product(&text),
        };
    };
    let text = match args.format {
        DiffFormat::Json => escape::json(&text).into_owned(),
        DiffFormat::Html => text,
        DiffFormat::Md | DiffFormat::Human => escape_controls(text, paint),
    };
    let named = args.sides.iter().chain(&config.file).map(PathBuf::as_path);
    write::to(out, &text, &write::protecting(named, shaders), streams)
}

/// The page with the old and the new map of each changed block.
fn page(all: &[Compared<'_>]) -> String {
    let mut page = Page::default();
    for compared in all.iter().filter(|compared| !compared.blocks.is_empty()) {
        let new = compared.new;
        let shader = ShaderLayout::empty(new.path.clone(), new.language, new.stage);
        page.add(&Part {
            path: compared.name,
            shader: &shader,
            by_rules: &[],
            findings: &[],
            text: &|_| None,
            compared: Some(compared),
        });
    }
    page.finish("Landfall diff")
}

/// Updates the locks of the side that has them; of the new side if both have.
fn accept(
    old: &DiffedSide,
    new: &DiffedSide,
    config: &Config,
    streams: &Streams,
) -> Result<(), Error> {
    let has_locks = |side: &DiffedSide| {
        side.locks.is_some() || side.entries.iter().any(|entry| place(entry).is_some())
    };
    // The side with locks is updated from the other one; with locks on both sides, the new from
    // the old.
    let (locked, truth) = match (has_locks(old), has_locks(new)) {
        (_, true) => (new, old),
        (true, false) => (old, new),
        (false, false) => {
            return Err(Error::new("--accept", "has no lock to update: neither side is a lock")
                .with_help("write the locks of shaders with `landfall lock`"));
        }
    };
    for entry in &truth.entries {
        // A single shader belongs to a single lock, whatever its name.
        let known = locked.entries.iter().find(|other| truth.single || other.key == entry.key);
        let target = known.and_then(place).map(Path::to_path_buf);
        let target = target.or_else(|| new_lock(locked, truth, entry));
        let Some(target) = target else { continue };
        let before = known.and_then(|entry| entry.lock.as_ref()).map(|(_, lock)| lock);
        let text = lock::renew(&entry.layout, before);
        let folder = target.parent().unwrap_or(Path::new(""));
        if config.writer(folder, false).write(&target, &text)? == Written::Unchanged {
            continue;
        }
        streams.notes(&format!("updated {}\n", target.display()));
    }
    Ok(())
}

/// The path of the lock of a shader without one: beside the others.
fn new_lock(locked: &DiffedSide, truth: &DiffedSide, entry: &SideEntry) -> Option<PathBuf> {
    let dir = locked.locks.as_ref()?;
    // From a known pair of lock and key follows the directory that the others belong to.
    let other = locked.entries.iter().find_map(|other| {
        let place = place(other)?;
        let known = truth.entries.iter().any(|entry| entry.key == other.key);
        let tail = lock::path_of(Path::new(""), Path::new(&other.key));
        known.then(|| place.ancestors().nth(tail.components().count())).flatten()
    });
    Some(lock::path_of(other.unwrap_or(dir), Path::new(&entry.key)))
}

/// The path of an entry's lock in the work tree.
fn place(entry: &SideEntry) -> Option<&Path> {
    entry.lock.as_ref().and_then(|(place, _)| place.as_deref())
}
