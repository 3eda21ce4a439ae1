//! Seeded mutation of the shaders of this repository: whatever the text, no
//! panic, no hang, no memory without bound.
//!
//! A failure names the mutant, and `LANDFALL_MUTANT=N` runs that one alone.

use std::collections::HashMap;
use std::fs;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use fastrand::Rng;
use landfall_layout::{Language, Options, Rules, Source, Stage, layout};

use crate::support::files::shaders;
use crate::support::sample::sample;

/// How many mutants there are.
const MUTANTS: u64 = 100_000;

/// A mutant that takes this long hangs; the slowest legitimate one takes milliseconds.
const HANG: Duration = Duration::from_secs(60);

/// Peak memory of the whole run, in kilobytes: far above the largest mutant, far below a leak.
pub const MAX_MEMORY_KB: u64 = 2_000_000;

/// Fragments that mutants are given: the words of both languages and what breaks parsers.
const WORDS: &[&str] = &[
    "layout(std140) uniform B {",
    "layout(std430) buffer",
    "struct S {",
    "}",
    "};",
    "{",
    "(",
    ")",
    "[",
    "]",
    "[]",
    "[4294967295]",
    "[-1]",
    "[0]",
    "layout(offset = 4294967295)",
    "layout(align = 0)",
    "row_major",
    "uniform",
    "#define A A A",
    "#define F(x) x F(x)",
    "F(",
    "#if",
    "#else",
    "#endif",
    "#ifdef GL_ES",
    "#include \"a.glsl\"",
    "#version 300 es",
    "##",
    "\\\n",
    "/*",
    "*/",
    "//",
    "\"",
    "'",
    "\u{feff}",
    "é",
    "\r\n",
    "\0",
    "0x",
    "1e9",
    "?",
    ":",
    "array<",
    ">",
    ">>",
    "@size(",
    "@align(3)",
    "var<uniform>",
    "var<storage, read_write> x: array<",
    "fn f() {",
    "override N: u32;",
    "const N = 1 / 0;",
    "alias A = A;",
    "struct A { a: A }",
    "vec3<f32>",
    "mat4x2",
    "dmat3x4",
    ";",
    ",",
];

#[test]
fn mutants_neither_panic_nor_hang() {
    let read = |path| Source::read(path).expect("a readable shader");
    let corpus: Vec<Source> = shaders().iter().map(read).collect();
    assert!(corpus.len() > 50, "the shaders of this repository are the corpus");
    let alone = std::env::var("LANDFALL_MUTANT").ok().and_then(|text| text.parse().ok());
    if let Some(seed) = alone {
        let source = mutant(&corpus, seed);
        println!("{:?}\n{}", source.language, source.text);
        return lay_out(&source, seed);
    }
    let mutants: Vec<u64> = sample(0..MUTANTS, 10).collect();
    let next = AtomicUsize::new(0);
    let running: Mutex<HashMap<u64, Instant>> = Mutex::default();
    std::thread::scope(|scope| {
        let workers: Vec<_> = (0..2)
            .map(|_| {
                scope.spawn(|| {
                    loop {
                        let at = next.fetch_add(1, Ordering::Relaxed);
                        let Some(&seed) = mutants.get(at) else { return };
                        running.lock().expect("no worker panics here").insert(seed, Instant::now());
                        let done =
                            std::panic::catch_unwind(|| lay_out(&mutant(&corpus, seed), seed));
                        assert!(done.is_ok(), "mutant {seed} panics: LANDFALL_MUTANT={seed}");
                        running.lock().expect("no worker panics here").remove(&seed);
                    }
                })
            })
            .collect();
        while workers.iter().any(|worker| !worker.is_finished()) {
            std::thread::sleep(Duration::from_millis(50));
            let running = running.lock().expect("no worker panics here");
            if let Some((seed, _)) = running.iter().find(|(_, since)| since.elapsed() > HANG) {
                eprintln!("mutant {seed} hangs: LANDFALL_MUTANT={seed}");
                std::process::abort(); // a hanging thread cannot be joined
            }
        }
    });
    assert!(next.load(Ordering::Relaxed) >= mutants.len());
    if let Some(peak) = peak_memory_kb() {
        assert!(peak < MAX_MEMORY_KB, "the run took {peak} KB at its peak");
    }
}

/// Lays a mutant out in one of several ways.
fn lay_out(source: &Source, seed: u64) {
    let rules = [None, Some(Rules::Std140), Some(Rules::Std430), Some(Rules::Scalar)];
    let options = Options::default()
        .with_gather(seed.is_multiple_of(3))
        .with_rules(rules[(seed % 4) as usize]);
    let shader = layout(source, &options);
    for diagnostic in &shader.diagnostics {
        for label in &diagnostic.labels {
            shader.files.locate(label.at);
        }
    }
    for block in &shader.blocks {
        for leaf in block.leaves.iter().filter(|leaf| leaf.dims.is_empty()) {
            let end = leaf.offset.zip(leaf.size).map(|(offset, size)| offset + size);
            assert!(end <= block.size, "{} ends past its block: LANDFALL_MUTANT={seed}", leaf.path);
        }
    }
}

/// A shader of the corpus with a few things done to it.
fn mutant(corpus: &[Source], seed: u64) -> Source {
    let mut rng = Rng::with_seed(seed);
    let pick = |rng: &mut Rng| &corpus[rng.usize(..corpus.len())];
    let base = pick(&mut rng);
    let mut text: Vec<char> = base.text.chars().collect();
    for _ in 0..rng.usize(1..6) {
        let at = rng.usize(..=text.len());
        let to = (at + rng.usize(..64)).min(text.len());
        match rng.u8(..9) {
            0 => drop(text.drain(at..to)),
            1 => {
                let piece: Vec<char> = text[at..to].to_vec();
                let copies = if rng.u8(..20) == 0 { 500 } else { 1 };
                for _ in 0..copies {
                    text.splice(at..at, piece.iter().copied());
                }
            }
            2 => text.truncate(at),
            3 => {
                let other: Vec<char> = pick(&mut rng).text.chars().collect();
                let from = rng.usize(..=other.len());
                text.splice(at..at, other[from..].iter().copied());
            }
            4 => {
                if let Some(c) = text.get_mut(at) {
                    *c = char::from(rng.u8(1..127));
                }
            }
            5 => {
                if let Some(c) = text[at..].iter_mut().find(|c| c.is_ascii_digit()) {
                    *c = char::from(b'0' + rng.u8(..10));
                }
            }
            _ => {
                let word = WORDS[rng.usize(..WORDS.len())];
                let copies = if rng.u8(..30) == 0 { 2_000 } else { 1 };
                for _ in 0..copies {
                    text.splice(at..at, word.chars());
                }
            }
        }
    }
    let text: String = text.into_iter().collect();
    Source { text: text.into(), ..base.clone() }
}

/// Peak memory of this process in kilobytes, where the system tells.
pub fn peak_memory_kb() -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    line.split_whitespace().nth(1)?.parse().ok()
}

#[test]
fn binary_junk_is_laid_out_or_refused() {
    for seed in 0..2_000 {
        let mut rng = Rng::with_seed(seed);
        let text: String = (0..rng.usize(..400)).map(|_| rng.char(..)).collect();
        for language in [Language::Glsl, Language::Wgsl] {
            let source = Source {
                path: "junk".into(),
                text: text.clone().into(),
                language,
                stage: Some(Stage::Fragment),
                foreign: None,
                byte_order_mark: false,
                linked: None,
                words: None,
            };
            lay_out(&source, seed);
        }
    }
}
