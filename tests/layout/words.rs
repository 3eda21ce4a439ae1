//! Attributes and words: the declarations of the repository's shaders with one qualifier or keyword
//! changed, removed, doubled or misspelt. What glslang takes is not refused; most of what it refuses
//! for a reason that stands in a declaration is told.
//!
//! At length:
//! `cargo test --features full --test layout words -- --ignored --nocapture`; `LANDFALL_WORD_MUTANTS` is
//! the number of mutants.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use landfall_layout::{Options, Source, layout};

use crate::support::files;
use crate::support::glslang::Client;
use crate::support::glslang_server;

/// Words of one class, which replace one another.
const CLASSES: &[&[&str]] = &[
    &["uniform", "buffer", "in", "out", "const", "shared", "inout", "attribute", "varying"],
    &["flat", "smooth", "noperspective", "centroid", "sample", "invariant", "precise", "patch"],
    &["lowp", "mediump", "highp"],
    &["readonly", "writeonly", "coherent", "volatile", "restrict"],
    &[
        "std140",
        "std430",
        "scalar",
        "shared",
        "packed",
        "row_major",
        "column_major",
        "push_constant",
    ],
    &["binding", "set", "location", "component", "index", "offset", "align", "constant_id"],
    &["local_size_x", "local_size_y", "local_size_z", "early_fragment_tests", "origin_upper_left"],
    &["float", "int", "uint", "bool", "double", "void"],
    &["vec2", "vec3", "vec4", "ivec4", "uvec2", "bvec3", "dvec2", "mat2", "mat3", "mat4", "mat4x3"],
    &["sampler2D", "samplerCube", "isampler2D", "sampler2DArray", "sampler2DShadow", "image2D"],
    &["struct", "layout", "precision"],
];

/// A word of a declaration at global scope: its bytes.
type Word = std::ops::Range<usize>;

/// Returns the words at global scope, outside comments, directives and function bodies.
fn words(text: &str) -> Vec<Word> {
    let bytes = text.as_bytes();
    let (mut found, mut at, mut body) = (Vec::new(), 0, 0u32);
    let mut before = b';';
    let mut line_begins = true;
    while at < bytes.len() {
        let rest = &text[at..];
        let byte = bytes[at];
        if rest.starts_with("//") || line_begins && byte == b'#' {
            at += rest.find('\n').unwrap_or(rest.len());
        } else if rest.starts_with("/*") {
            at += rest.find("*/").map_or(rest.len(), |end| end + 2);
        } else if byte.is_ascii_alphabetic() || byte == b'_' {
            let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_';
            let end = rest.find(|c| !is_part(c)).unwrap_or(rest.len());
            let word = &rest[..end];
            if body == 0 && CLASSES.iter().any(|class| class.contains(&word)) {
                found.push(at..at + end);
            }
            (at, before, line_begins) = (at + end, b'a', false);
        } else {
            match byte {
                b'{' if body > 0 || before == b')' => body += 1,
                b'}' if body > 0 => body -= 1,
                _ => {}
            }
            line_begins = byte == b'\n' || line_begins && byte.is_ascii_whitespace();
            if !byte.is_ascii_whitespace() {
                before = byte;
            }
            at += rest.chars().next().map_or(1, char::len_utf8);
        }
    }
    found
}

/// Returns the lines with anything at global scope.
fn declaration_lines(text: &str) -> Vec<usize> {
    let line = |word: &Word| text[..word.start].matches('\n').count() + 1;
    words(text).iter().map(line).collect()
}

/// Returns a text with one of its words changed, and what was done.
fn mutate(text: &str, random: &mut fastrand::Rng) -> Option<(String, String)> {
    let words = words(text);
    let word = words.get(random.usize(0..words.len().max(1)))?.clone();
    let old = &text[word.clone()];
    let (kind, new) = match random.u8(0..4) {
        0 => {
            let classes: Vec<_> = CLASSES.iter().filter(|class| class.contains(&old)).collect();
            let class = classes[random.usize(0..classes.len())];
            ("changed", class[random.usize(0..class.len())].to_string())
        }
        1 => ("removed", String::new()),
        2 => ("doubled", format!("{old} {old}")),
        _ => {
            let mut letters: Vec<char> = old.chars().collect();
            let at = random.usize(0..letters.len());
            match random.u8(0..3) {
                0 if at > 0 => letters.swap(at - 1, at),
                1 => drop(letters.remove(at)),
                _ => letters.insert(at, letters[at]),
            }
            ("misspelt", letters.into_iter().collect())
        }
    };
    if new == *old {
        return None;
    }
    let done = format!("`{old}` {kind} to `{new}`");
    Some((format!("{}{new}{}", &text[..word.start], &text[word.end..]), done))
}

struct Shader {
    path: PathBuf,
    text: String,
    /// For what glslang takes it.
    clients: Vec<Client>,
}

impl Shader {
    fn stage(&self) -> &str {
        self.path.extension().and_then(|end| end.to_str()).unwrap_or_default()
    }
}

/// Tells whether glslang takes a text of a stage; if not, its log.
fn verdict(text: &str, stage: &str, client: Client) -> Result<(), String> {
    glslang_server::compiled(text, stage, client).map(drop)
}

/// The repository's shaders that glslang takes, at most so many.
fn corpus(most: usize) -> Vec<Shader> {
    let is_wanted = |path: &Path| {
        ["vert", "frag", "comp"].iter().any(|end| path.extension() == Some(end.as_ref()))
    };
    let files = files::below(["shaders", "examples", "tests"], is_wanted);
    let step = (files.len() / most).max(1);
    let mut found = Vec::new();
    for path in files.into_iter().step_by(step) {
        let Ok(text) = fs::read_to_string(&path) else { continue };
        let mut shader = Shader { path, text, clients: Vec::new() };
        for client in [Client::OpenGl, Client::Vulkan] {
            if verdict(&shader.text, shader.stage(), client).is_ok() {
                shader.clients.push(client);
            }
        }
        if !shader.clients.is_empty() && !words(&shader.text).is_empty() {
            found.push(shader);
        }
    }
    found
}

/// What is told of a text: the messages of errors and warnings, and whether there is an error.
fn told(path: &Path, text: &str) -> (Vec<String>, bool) {
    let source = Source::new(path.display().to_string(), text);
    let shader = layout(&source, &Options::default());
    let messages = shader.diagnostics.iter().map(|found| found.message.clone()).collect();
    (messages, shader.has_errors())
}

/// Returns the line and the text of the first error of a log, the text without names.
fn reason(log: &str) -> (usize, String) {
    let first = log.lines().find(|line| line.starts_with("ERROR:")).unwrap_or("");
    let rest = first.trim_start_matches("ERROR: ").split_once(':').map_or(first, |(_, rest)| rest);
    let (line, said) = rest.split_once(": ").unwrap_or(("", rest));
    let said = match said.rsplit_once("' : ") {
        Some((_, said)) => said.to_string(),
        None => said.to_string(),
    };
    (line.trim().parse().unwrap_or(0), said.trim().to_string())
}

#[derive(Default)]
struct Score {
    mutants: u64,
    taken: u64,
    /// Refused for a reason in a declaration, and told.
    refused: BTreeMap<String, (u64, u64)>,
    /// An untold mutant of each reason.
    untold: BTreeMap<String, Vec<String>>,
    falsely: Vec<String>,
}

impl Score {
    fn share(&self) -> f64 {
        let (all, told) =
            self.refused.values().fold((0, 0), |sum, row| (sum.0 + row.0, sum.1 + row.1));
        told as f64 / (all as f64).max(1.0)
    }

    fn add(&mut self, shader: &Shader, text: &str, done: &str) {
        self.mutants += 1;
        let mut logs = Vec::new();
        for client in &shader.clients {
            match verdict(text, shader.stage(), *client) {
                Ok(()) => {
                    self.taken += 1;
                    let (messages, error) = told(&shader.path, text);
                    // glslang reads `set = N` for OpenGL and on inputs and outputs, which the table of
                    // GLSL 4.60 §4.4 gives to blocks and opaque variables of Vulkan alone, and lengths
                    // by variables with constant initialisers; no other compiler does.
                    let lenient = [
                        "not allowed in GLSL for Vulkan",
                        "`set` is not allowed on a variable like this",
                        "is not a constant of this",
                    ];
                    let is_lenient =
                        |message: &String| lenient.iter().any(|part| message.contains(part));
                    if error && !messages.iter().any(is_lenient) {
                        let path = shader.path.display();
                        self.falsely.push(format!("{path}: {done} for {client:?}: {messages:?}"));
                    }
                    return;
                }
                Err(log) => logs.push(log),
            }
        }
        let (line, said) = reason(&logs[0]);
        if line > 0 && !declaration_lines(text).contains(&line) {
            return;
        }
        let before = told(&shader.path, &shader.text).0;
        let (after, error) = told(&shader.path, text);
        let is_told = error || after.iter().any(|message| !before.contains(message));
        let row = self.refused.entry(said.clone()).or_default();
        row.0 += 1;
        row.1 += u64::from(is_told);
        if !is_told {
            let name = shader.path.file_name().unwrap_or_default().to_string_lossy();
            self.untold.entry(said).or_default().push(format!("{name}:{line} {done}"));
        }
    }

    fn merge(&mut self, other: Score) {
        self.mutants += other.mutants;
        self.taken += other.taken;
        for (said, row) in other.refused {
            let sum = self.refused.entry(said).or_default();
            (sum.0, sum.1) = (sum.0 + row.0, sum.1 + row.1);
        }
        for (said, all) in other.untold {
            self.untold.entry(said).or_default().extend(all);
        }
        self.falsely.extend(other.falsely);
    }
}

fn run(shaders: &[Shader], seeds: impl Iterator<Item = u64>) -> Score {
    let mut score = Score::default();
    for seed in seeds {
        let mut random = fastrand::Rng::with_seed(seed);
        let shader = &shaders[random.usize(0..shaders.len())];
        let Some((text, done)) = mutate(&shader.text, &mut random) else { continue };
        score.add(shader, &text, &done);
    }
    score
}

#[test]
fn words_that_glslang_refuses_in_declarations_are_told() {
    let shaders = corpus(12);
    let score = run(&shaders, 0..120);
    assert_eq!(score.falsely, Vec::<String>::new());
    assert!(score.taken > 5 && score.share() > 0.8, "{} {:#?}", score.share(), score.untold);
}

#[test]
#[ignore = "at length"]
fn words_that_glslang_refuses_in_declarations_are_told_at_length() {
    let count = std::env::var("LANDFALL_WORD_MUTANTS").ok().and_then(|n| n.parse().ok());
    let count: u64 = count.unwrap_or(50_000);
    let halves = |first: u64| {
        let shaders = corpus(usize::MAX);
        run(&shaders, (first..count).step_by(2))
    };
    let mut score = Score::default();
    std::thread::scope(|scope| {
        let threads = [0, 1].map(|first| scope.spawn(move || halves(first)));
        for thread in threads {
            score.merge(thread.join().expect("the campaign ends"));
        }
    });
    println!("{} mutants, {} taken, share told {:.4}", score.mutants, score.taken, score.share());
    let mut rows: Vec<_> = score.refused.iter().collect();
    rows.sort_by_key(|(_, (all, told))| std::cmp::Reverse(all - told));
    for (said, (all, told)) in rows {
        println!("{told:6} of {all:6}  {said}");
        for line in score.untold.get(said).into_iter().flatten().take(12) {
            println!("                    {line}");
        }
    }
    score.falsely.iter().take(60).for_each(|line| println!("falsely: {line}"));
    assert_eq!(score.falsely.len(), 0, "nothing that glslang takes is refused");
    assert!(score.share() > 0.95, "{}", score.share());
}
