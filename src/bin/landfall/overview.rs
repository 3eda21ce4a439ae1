//! `landfall` alone: what the folder has, and what to do next.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::thread;
use std::time::{Duration, Instant};

use landfall_check::baseline::Permitted;
use landfall_check::basis::{Basis, CheckScope};
use landfall_check::check_shader::Known;
use landfall_check::config::Config;
use landfall_check::given_names::GivenNames;
use landfall_check::inputs::Inputs;
use landfall_check::pass::CheckRun;
use landfall_check::stop::StopFlag;
use landfall_check::tree;
use landfall_layout::format::paint::STRONG;
use landfall_layout::format::phrases::{counted, number};
use landfall_layout::source::kind_of_path;
use landfall_lint::render::severities;

use crate::args::{Color, ConfigArgs};
use crate::config;
use crate::output::{CommandFailure, Outcome, Streams};

/// Time after which a check of many shaders ends; what it found by then is told.
const CHECK: Duration = Duration::from_millis(12);

/// Shaders that are checked however long it takes.
const FEW: usize = 32;

/// Time after which a search ends, as in the directory of a user.
const SEARCH: Duration = Duration::from_secs(1);

/// Prints the overview; `None` in a folder without shaders.
pub fn run() -> Option<Outcome> {
    let streams = Streams::new(Color::Auto, false);
    let printed = overview(&streams).and_then(|text| match text {
        Some(text) => {
            streams.product(&text)?;
            streams.finish()?;
            Ok(true)
        }
        None => Ok(false),
    });
    match printed {
        Ok(true) => Some(Outcome::Clean),
        Ok(false) => None,
        Err(failure) => {
            // Of a configuration with errors the usage is told, too.
            let is_usage = matches!(failure, CommandFailure::Findings(_));
            streams.failure(failure);
            (!is_usage).then_some(Outcome::CouldNot)
        }
    }
}

fn overview(streams: &Streams) -> Result<Option<String>, CommandFailure> {
    let config = config::load(&ConfigArgs::default(), &[], streams)?;
    let stop = stop_after(SEARCH);
    let inputs = Inputs::new(config.paths(&[]), stop.clone());
    // Files that were removed since they were listed, and what cannot be read, are no shaders
    // here.
    let inputs = inputs.filter(|input| config.takes(input, &[])).filter_map(Result::ok);
    let paths = inputs.map(|input| input.path).filter(|path| path.is_file());
    let paths: Vec<PathBuf> = paths.collect();
    let mut languages: BTreeMap<&str, usize> = BTreeMap::new();
    for path in &paths {
        // Templates and other files without a known ending are counted as `other`.
        let (language, _) = kind_of_path(path).unzip();
        *languages.entry(language.map_or("other", |language| language.name())).or_default() += 1;
    }
    if paths.is_empty() {
        return Ok(None);
    }
    // A search that was cut short has counted only some.
    let at_least = if stop.is_set() { "at least " } else { "" };
    let languages: Vec<String> = languages
        .iter()
        .map(|(name, count)| format!("{} {}", number(*count as u64), name.to_uppercase()))
        .collect();
    let locks = locks(&config, &paths);
    let (findings, is_to_check) = findings(&config)?;
    let next = match (locks.1, is_to_check) {
        // Findings come first, then locks, which make sense only of layouts that are right.
        (_, true) => [
            ("landfall check", "lists the findings, each with what to do"),
            ("landfall layout PATH", "prints the bytes of every block"),
        ],
        (false, false) => [
            ("landfall lock", "records the layouts, so that `check` tells when one changes"),
            ("landfall layout PATH", "prints the bytes of every block"),
        ],
        (true, false) => [
            ("landfall layout PATH", "prints the bytes of every block"),
            ("landfall --help", "lists all commands"),
        ],
    };
    let [first, second] = next.map(|(command, does)| {
        let room = " ".repeat("landfall layout PATH".len() - command.len());
        format!("{}{room}  {does}", streams.paint.text(STRONG, command))
    });
    Ok(Some(format!(
        "{at_least}{}: {}\n{}\n{findings}\n\n{first}\n{second}\n",
        counted(paths.len(), "shader"),
        languages.join(", "),
        locks.0,
    )))
}

/// How many shaders have locks, and whether all have.
fn locks(config: &Config, paths: &[PathBuf]) -> (String, bool) {
    let folder = config.locks(None);
    let is_locked =
        |path: &&PathBuf| config.lock_of(&folder, path).is_ok_and(|lock| lock.is_file());
    let locked = paths.iter().filter(is_locked).count();
    let text = match locked {
        0 => "no layouts are locked".to_string(),
        all if all == paths.len() => "all layouts are locked".to_string(),
        some => {
            let [some, rest] = [some, paths.len() - some].map(|count| number(count as u64));
            format!("the layouts of {some} are locked, those of {rest} not")
        }
    };
    (text, locked == paths.len())
}

/// What `check` finds until its time is over, and whether there is or may be anything.
fn findings(config: &Config) -> Result<(String, bool), CommandFailure> {
    let permitted = Permitted::open(None, false, config)?;
    let settings = config.settings.clone();
    let scope = CheckScope::new(config, &[], None, None);
    let basis = Basis::new(scope, config.options(&Default::default()), None, None, settings);
    let names = GivenNames::new();
    let (began, stop) = (Instant::now(), StopFlag::default());
    // Small folders are checked in full; in large ones the first shaders tell enough.
    let progress = |checked: usize| {
        if checked >= FEW && began.elapsed() > CHECK {
            stop.set();
        }
    };
    let check = CheckRun {
        stop: stop.clone(),
        progress: Some(&progress),
        ..CheckRun::new(&basis, config, config.paths(&[]), &names)
    };
    let mut pass = check.pass(Known::new(), &Default::default(), false);
    // Findings across shaders, such as two that disagree, are only told of a whole folder.
    let (findings, of) = match check.stop.is_set() {
        true => {
            let first = counted(pass.checked.len(), "shader");
            (tree::findings_in_shaders(&pass), format!(" in the first {first}"))
        }
        false => (tree::findings(&check, &mut pass, &mut None, &[]), String::new()),
    };
    let findings = permitted.new_of(findings, &pass, &check);
    let is_to_check = !findings.is_empty() || check.stop.is_set();
    Ok((format!("{}{of}", severities(&findings)), is_to_check))
}

fn stop_after(time: Duration) -> StopFlag {
    let stop = StopFlag::default();
    let flag = stop.clone();
    thread::spawn(move || {
        thread::sleep(time);
        flag.set();
    });
    stop
}
