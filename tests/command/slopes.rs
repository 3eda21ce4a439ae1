//! The processor time of commands against the size of inputs that repeat one construct.
//!
//! The size is quadrupled until the command takes long enough to be measured; eight times that size
//! must take less than 8 · log₂ 8 times as long, or be refused with a limit that the message names.
//! A quadratic loop takes 64 times as long. Where the slope is steeper, a limit must cut it off: the
//! largest size takes few seconds.

mod families;

use std::fs;
use std::process::{Command, Stdio};

use crate::support::command::Place;
use crate::support::sample::sampled;
use families::{Family, GLSL, INPUTS, WGSL};

/// What one run answered.
struct Measured {
    /// Processor time of the process in user mode, in seconds: the time that a file system takes
    /// to create a file differs tenfold between runs.
    seconds: f64,
    code: i32,
    said: String,
}

/// Seconds above those of an empty input from which a slope is measured.
const ENOUGH: f64 = 0.015;

/// Seconds that the largest size takes at most where a limit cuts a steeper slope off: naga without
/// optimisations takes up to 1.6 s on one machine and 4.8 s on another, and would take minutes without
/// a limit.
const CUT_OFF: f64 = 12.0;

/// No size is larger, however fast the command is.
const LARGEST: usize = 1 << 16;

fn measure(place: &Place, family: &Family, command: &str, size: usize) -> Measured {
    // Files of a larger size would be read, too.
    for folder in ["tree", "locks"] {
        let _ = fs::remove_dir_all(place.0.join(folder));
    }
    for (file, text) in (family.files)(size) {
        place.write(&file, text);
    }
    let script = "TIMEFORMAT='%U'; time \"$@\"";
    let landfall = env!("CARGO_BIN_EXE_landfall");
    let output = Command::new("bash")
        .args(["-c", script, "_", landfall])
        .args(command.split(' '))
        .current_dir(&place.0)
        .stdin(Stdio::null())
        .output()
        .expect("bash runs");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    let time = said.trim_end().lines().last().and_then(|time| time.parse().ok());
    let seconds = time.unwrap_or_else(|| panic!("{}, {command}: {said}", family.name));
    // `check` prints its findings to standard output.
    let said = String::from_utf8_lossy(&output.stdout).into_owned() + &said;
    Measured { seconds, code: output.status.code().unwrap_or(-1), said }
}

/// Whether a run was refused with a limit; any other failure is returned as what is wrong.
fn is_refused(run: &Measured, what: &str) -> Result<bool, String> {
    let limits =
        ["limit", "more than", "at most", "levels", "takes 128", "too long", "table holds"];
    match run.code {
        0 | 1 => Ok(false),
        2 if limits.iter().any(|limit| run.said.contains(limit)) => Ok(true),
        code => {
            let head: String = run.said.chars().take(600).collect();
            Err(format!("{what} ends with {code}: {head}"))
        }
    }
}

/// Returns what is wrong with the slope of a command over a family.
fn steep(place: &Place, family: &Family, command: &str) -> Result<(), String> {
    let base = measure(place, family, command, 1).seconds;
    let mut size = 256;
    let mut few;
    loop {
        few = measure(place, family, command, size);
        if is_refused(&few, &format!("{} {size}, {command}", family.name))? {
            return Ok(());
        }
        if few.seconds - base >= ENOUGH || size >= LARGEST {
            break;
        }
        size *= 4;
    }
    if few.seconds - base < ENOUGH {
        return Ok(());
    }
    let mut least = [few.seconds - base, f64::INFINITY];
    for _ in 0..4 {
        let many = measure(place, family, command, 8 * size);
        if is_refused(&many, &format!("{} {}, {command}", family.name, 8 * size))? {
            return Ok(());
        }
        least[1] = least[1].min(many.seconds - base);
        if least[1] < 24.0 * least[0] {
            return Ok(());
        }
        let few = measure(place, family, command, size);
        least[0] = least[0].min(few.seconds - base).max(ENOUGH / 2.0);
    }
    // naga takes quadratic time in some texts, up to the size that it is given.
    let largest = measure(place, family, &format!("{command} --max-time 60"), LARGEST);
    is_refused(&largest, &format!("{} {LARGEST}, {command}", family.name))?;
    if largest.seconds - base < CUT_OFF {
        return Ok(());
    }
    let [few, many] = least;
    Err(format!("{}, {command}: {few:.3} s for {size}, {many:.3} s for eight times", family.name))
}

fn assert_none_is_steep(name: &str, families: &[Family], commands: &[&str]) {
    let place = Place::new(&format!("slopes-{name}"));
    let pairs: Vec<_> = families
        .iter()
        .flat_map(|family| commands.iter().chain(family.commands).map(move |of| (family, *of)))
        .collect();
    let tried = sampled(&pairs, 10);
    let found: Vec<_> = tried.filter_map(|(family, of)| steep(&place, family, of).err()).collect();
    assert!(found.is_empty(), "{found:#?}");
}

const READERS: [&str; 3] = ["layout -f json", "check", "lights"];

#[test]
fn commands_take_time_linear_in_glsl() {
    let commands: Vec<String> = READERS
        .iter()
        .chain(&["emit --lang c", "emit --lang rust", "port --no-compiler"])
        .map(|command| format!("{command} a.frag"))
        .collect();
    let commands: Vec<&str> = commands.iter().map(String::as_str).collect();
    assert_none_is_steep("glsl", GLSL, &commands);
}

#[test]
fn commands_take_time_linear_in_wgsl() {
    let commands = READERS.map(|command| format!("{command} a.wgsl"));
    assert_none_is_steep("wgsl", WGSL, &commands.each_ref().map(String::as_str));
}

#[test]
fn commands_take_time_linear_in_their_other_inputs() {
    assert_none_is_steep("inputs", INPUTS, &[]);
}
