//! What people read: messages within the width of their terminal, brief reports of ten lines, counts
//! with separators.

use std::process::Stdio;

use crate::support::command::{self, Place};

const SCENE: &str = "shaders/scenes/six_lights.json";
const SEED: &str = "shaders/seed/six_lights_450.frag";
const LIGHTS: &str = "shaders/light_arrays/all_lights_450.frag";

/// What a terminal of so many columns shows, without colours.
fn shown(columns: usize, arguments: &str) -> String {
    let landfall = env!("CARGO_BIN_EXE_landfall");
    let line = format!("stty cols {columns} rows 40; {landfall} {arguments}");
    let mut terminal = std::process::Command::new("script");
    terminal.args(["-qec", &line, "/dev/null"]).stdin(Stdio::null()).env("NO_COLOR", "1");
    let output = terminal.output().expect("Debian's `script` runs");
    String::from_utf8_lossy(&output.stdout).replace('\r', "")
}

#[cfg(target_os = "linux")]
#[test]
fn messages_fit_the_terminal_and_are_a_line_each_elsewhere() {
    let place = Place::new("people-width");
    // Bytes that are no number, no 0 or 1, and padding that is not zero.
    place.write("dump.bin", (0..6160u32).map(|n| (n * 37 % 251) as u8).collect::<Vec<u8>>());
    let decode = format!("decode {LIGHTS} -b PointLightBlock {}", place.path("dump.bin"));
    let piped = command::run(&decode.split(' ').collect::<Vec<&str>>());
    let titles = piped.err.lines().filter(|line| line.starts_with("warning[")).count();
    assert_eq!(titles, 100);
    assert!(piped.err.lines().any(|line| line.len() > 100), "{}", piped.err);
    for columns in [80, 120] {
        let text = shown(columns, &decode);
        // But for the rows of the table.
        let is_row = |line: &str| line.trim_start().starts_with(|c: char| c.is_ascii_digit());
        let wide = |line: &&str| line.chars().count() > columns && !is_row(line);
        let wide: Vec<&str> = text.lines().filter(wide).collect();
        assert!(wide.is_empty(), "{columns}: {wide:#?}");
        // The same words.
        let words = |text: &str| text.split_whitespace().map(str::to_string).collect::<Vec<_>>();
        let both = format!("{}{}", piped.err, piped.out);
        assert_eq!(words(&text), words(&both));
    }
}

/// The lines of a report that has at most ten.
fn brief(arguments: &str, code: i32) -> String {
    let ran = command::run(&arguments.split(' ').collect::<Vec<&str>>());
    ran.code(code);
    let lines = ran.out.lines().count();
    assert!((1..=10).contains(&lines), "{arguments}: {lines} lines\n{}", ran.out);
    let wide = |line: &&str| line.chars().count() > 80;
    assert_eq!(ran.out.lines().find(wide), None, "{arguments}");
    ran.out
}

#[test]
fn a_brief_report_has_ten_lines_with_the_answer_first() {
    let small = "--size 40x30 --rounds 3";
    let variants = "--variant a=rust:seed --variant b=rust:robust";
    let text = brief(&format!("bench {SCENE} {small} --backend cpu {variants}"), 0);
    let answer = text.lines().nth(1).unwrap();
    assert!(answer.starts_with("rust: `") || answer.starts_with("rust: no variant wins"), "{text}");
    assert!(text.contains("off by at most ") && text.contains(" of the time of `"), "{text}");
    // Each mark has its legend.
    assert_eq!(text.lines().any(|line| line.starts_with('*')), text.contains("* no other variant"));
    let all = format!("bench {SCENE} {small} --backend cpu");
    let text = brief(&all, 0);
    assert!(text.contains("--details"), "{text}");
    let shaders = "--variant full=shaders/six_lights/phong_450.frag \
        --variant half=shaders/six_lights/phong_450.frag:half --variant r=rust:robust";
    let text = brief(&format!("bench {SCENE} {small} --backend cpu,gl {shaders}"), 0);
    assert!(text.contains("half on gl: only backend cpu rounds floats to f16"), "{text}");
    let function = format!("stress {SEED} --fn CalcSpotLight --samples 4000");
    let text = brief(&function, 1);
    assert!(text.contains("error[light-at-fragment]") && text.contains("--details"), "{text}");
    brief(&format!("{function} --backend gl,gpu"), 1);
    brief("stress shaders/six_lights/phong_450.frag --fn attenuation --samples 4000", 0);
    let text = brief(&format!("render {SCENE} --size 40x30 --backend cpu --compare reference"), 0);
    assert!(text.contains("against reference"), "{text}");
}

/// Words behind a number that counts.
const COUNTED: [&str; 19] = [
    "bytes",
    "elements",
    "used",
    "padding",
    "samples",
    "fragments",
    "reads",
    "lights",
    "calls",
    "times",
    "pixels",
    "channels",
    "more",
    "findings",
    "buffers",
    "shaders",
    "values",
    "texels",
    "arithmetic",
];

/// Words before a number that is a place.
const PLACES: [&str; 8] = ["byte", "offset", "stride", "line", "column", "seed", "at", "every"];

/// The counts of a text that have separators; panics at a count without, or a place with some.
fn counts(what: &str, text: &str) -> usize {
    let outside: String = text.split('`').step_by(2).collect::<Vec<&str>>().join("``");
    let words: Vec<&str> = outside.split_whitespace().collect();
    let plain = |word: &str| word.trim_matches(['(', ')', ',', ';', ':', '.']).to_string();
    let mut found = 0;
    for (at, word) in words.iter().enumerate() {
        let word = plain(word);
        let before = at.checked_sub(1).map(|before| plain(words[before])).unwrap_or_default();
        let after = words.get(at + 1).map(|after| plain(after)).unwrap_or_default();
        let digits = word.replace(',', "");
        if digits.len() < 4 || !digits.bytes().all(|digit| digit.is_ascii_digit()) {
            continue;
        }
        let is_separated = word.contains(',');
        let is_place = PLACES.contains(&before.as_str());
        if is_separated {
            assert!(!is_place, "{what}: `{before} {word}`");
            let groups: Vec<&str> = word.split(',').collect();
            assert!(groups[1..].iter().all(|group| group.len() == 3), "{what}: {word}");
            found += 1;
        }
        // `every 48 bytes` is a stride.
        let counts = COUNTED.contains(&after.as_str()) && !is_place;
        assert!(is_separated || !counts, "{what}: `{before} {word} {after}`");
    }
    found
}

#[test]
fn counts_have_separators_and_places_have_none() {
    let place = Place::new("people-numbers");
    let shader = |rows: u32| {
        format!(
            "#version 450\nlayout(std430, binding = 0) buffer Big {{ vec3 head; vec4 rows[{rows}]; vec3 tail; }};\n\
             layout(std140, binding = 1) uniform Wide {{ float each[30000]; }};\n\
             layout(location = 0) out vec4 color;\nvoid main() {{ color = rows[0] * each[0]; }}\n"
        )
    };
    place.write("a.frag", shader(70_000)).write("b.frag", shader(80_000));
    // 16 + 16 × 70,000 + 12, rounded up to 16.
    place.write("all.bin", vec![0xff; 1_120_032]).write("few.bin", vec![0; 20_000]);
    let mut found = 0;
    for (arguments, least) in [
        ("layout a.frag", 4),
        ("layout a.frag -f listing", 4),
        ("layout a.frag -f md", 4),
        ("explain a.frag rows[60000].x", 0),
        ("explain a.frag @1120004", 0),
        ("explain a.frag @9999999", 2),
        ("diff a.frag b.frag", 2),
        ("decode a.frag -b Big few.bin", 2),
        ("decode a.frag -b Big all.bin --only rows[60000]", 0),
        ("check a.frag -W all", 2),
        ("check a.frag -W all -f short", 1),
        ("lights a.frag", 0),
    ] {
        let ran = place.run(&arguments.split(' ').collect::<Vec<&str>>());
        let here = counts(arguments, &ran.out) + counts(arguments, &ran.err);
        assert!(here >= least, "{arguments}: {here} counts\n{}{}", ran.out, ran.err);
        found += here;
    }
    for arguments in [
        format!("render {SCENE} --size 200x150 --backend cpu --details"),
        format!(
            "bench {SCENE} --size 200x150 --rounds 3 --backend cpu --variant a=rust:seed --details"
        ),
        format!("stress {SEED} --fn CalcSpotLight --samples 20000 --details"),
        "verify shaders/six_lights --backend cpu".to_string(),
        format!("lights {LIGHTS}"),
    ] {
        let ran = command::run(&arguments.split(' ').collect::<Vec<&str>>());
        let here = counts(&arguments, &ran.out) + counts(&arguments, &ran.err);
        assert!(here > 0, "{arguments}\n{}{}", ran.out, ran.err);
        found += here;
    }
    assert!(found > 30, "{found}");
    // What programs read has none.
    for format in ["json", "csv"] {
        let ran = place.run(&["layout", "a.frag", "-f", format]);
        assert!(ran.out.contains("1120032") && !ran.out.contains("1,120,032"), "{format}");
    }
}
