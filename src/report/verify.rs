//! What verifying found: a line a block for people, every element as JSON.
//!
//! Reads the plain data of [`run::verify::report`](landfall_exec::harness::verify::report).

use std::collections::BTreeMap;
use std::fmt::Write as _;

use anstyle::Style;
use serde::Serialize;
use unicode_width::UnicodeWidthStr;

use super::device::JsonAsked;
use landfall_exec::backend::Device;
use landfall_exec::harness::verify::report::{
    Attendance, BlockReport, CompiledRun, ElementReport, Form, Outcome, ReaderReport, ShaderReport,
};
use landfall_layout::format::SCHEMA_VERSION;
use landfall_layout::format::json::{Tool, to_lines};
pub use landfall_layout::format::paint::{CAUTION, FAINT, HEADING, PLAIN, Paint, STRONG};
pub use landfall_layout::format::words;
use landfall_layout::text::escape;

pub use crate::report::schema::VERIFY_SCHEMA;

/// Elements of one leaf that are shown where a reader disagrees.
const MOST_SHOWN: usize = 4;

/// Lines of a compiler's log that are shown.
const MOST_LOG: usize = 6;

/// Who read, and who could not and why.
pub fn readers(attendance: &[Attendance], paint: Paint) -> String {
    let mut text = paint.text(STRONG, "readers");
    text.push('\n');
    for reader in attendance {
        let (name, words) = match reader {
            Attendance::Here(device) => (device.reader, paint.text(PLAIN, &about(device))),
            Attendance::Missing { reader, failure } => {
                (*reader, paint.text(CAUTION, &format!("did not run: {}", failure.message)))
            }
        };
        let _ = writeln!(text, "  {} {words}", paint.text(HEADING, &format!("{name:<4}")));
    }
    text
}

pub(super) fn about(device: &Device) -> String {
    let mut words = device.adapter.clone();
    if !device.driver.is_empty() {
        let _ = write!(words, " · {}", device.driver);
    }
    if !device.version.is_empty() {
        let _ = write!(words, " {}", device.version);
    }
    words
}

/// One shader: a line for each block, and what disagrees or failed below it.
pub fn shader(report: &ShaderReport, paint: Paint) -> String {
    let mut text = paint.text(STRONG, &escape::name(&report.path));
    text.push('\n');
    if report.blocks.is_empty() {
        text.push_str(&paint.text(FAINT, "  no blocks\n"));
    }
    let names: Vec<String> = report.blocks.iter().map(name).collect();
    let width = names.iter().map(|name| name.width()).max().unwrap_or(0);
    let bytes: Vec<String> = report.blocks.iter().map(|b| words::bytes(b.size)).collect();
    let digits = bytes.iter().map(|bytes| bytes.width()).max().unwrap_or(0);
    for ((block, name), bytes) in report.blocks.iter().zip(&names).zip(&bytes) {
        let pad = " ".repeat(width - name.width());
        let _ = write!(
            text,
            "  {}{pad}  {:<6}  {}{bytes}  {:>4} {}",
            paint.text(HEADING, name),
            block.rules,
            " ".repeat(digits - bytes.width()),
            block.leaves,
            if block.leaves == 1 { "leaf  " } else { "leaves" },
        );
        for reader in &block.readers {
            text.push_str("  ");
            text.push_str(&verdict(reader, paint));
        }
        text.push('\n');
        for reader in &block.readers {
            details(reader, paint, &mut text);
        }
        if !block.unprobed.is_empty() {
            unprobed(block, paint, &mut text);
        }
        if let Some(coverage) = &block.coverage {
            text.push_str(&super::coverage::block(coverage, paint));
        }
    }
    if let Some(run) = &report.compiled {
        let (style, words) = compiled(run);
        let _ = writeln!(text, "  {} {}", paint.text(HEADING, "spirv"), paint.text(style, &words));
    }
    text
}

/// What a user's SPIR-V gave beside our module.
fn compiled(run: &CompiledRun) -> (Style, String) {
    let CompiledRun { reader, outcome, compared, differing, reason } = run;
    let compared = words::number(*compared as u64);
    let reason = reason.as_deref().unwrap_or("no reason given");
    match outcome {
        Outcome::Confirmed => {
            (PLAIN, format!("✓ run on {reader}: {compared} words as landfall's module gives them"))
        }
        Outcome::Disagrees => {
            let message = format!("✗ run on {reader}: {differing} of {compared} words differ");
            (CAUTION, format!("{message} from what landfall's module gives"))
        }
        Outcome::Failed | Outcome::Skipped => (FAINT, format!("not run on {reader}: {reason}")),
    }
}

fn name(block: &BlockReport) -> String {
    match (&*block.name, &block.instance) {
        ("", Some(instance)) => instance.clone(),
        (name, _) => name.to_string(),
    }
}

fn verdict(reader: &ReaderReport, paint: Paint) -> String {
    let wrong = reader.reads.iter().filter(|read| !lands(read)).count();
    let all = reader.reads.len();
    let (style, words) = match reader.outcome {
        Outcome::Confirmed => (PLAIN, format!("✓ {all} reads")),
        Outcome::Disagrees => (CAUTION, format!("✗ {wrong} of {all} reads elsewhere")),
        Outcome::Failed => (CAUTION, "could not run it".to_string()),
        Outcome::Skipped => (FAINT, "–".to_string()),
    };
    format!("{} {}", paint.text(FAINT, reader.reader.name()), paint.text(style, &words))
}

fn details(reader: &ReaderReport, paint: Paint, text: &mut String) {
    match reader.outcome {
        Outcome::Confirmed => {}
        Outcome::Skipped | Outcome::Failed => {
            let reason = reader.reason.as_deref().unwrap_or("no reason given");
            let _ = writeln!(text, "    {}: {reason}", reader.reader.name());
            for line in reader.log.lines().filter(|l| !l.trim().is_empty()).take(MOST_LOG) {
                let _ = writeln!(text, "    {}", paint.text(FAINT, &format!("| {line}")));
            }
        }
        Outcome::Disagrees => {
            let mut leaves: BTreeMap<&str, Vec<&ElementReport>> = BTreeMap::new();
            for read in reader.reads.iter().filter(|read| !lands(read)) {
                leaves.entry(&read.leaf).or_default().push(read);
            }
            for (leaf, reads) in leaves {
                elsewhere(reader, leaf, &reads, paint, text);
            }
        }
    }
}

fn elsewhere(
    reader: &ReaderReport,
    leaf: &str,
    reads: &[&ElementReport],
    paint: Paint,
    text: &mut String,
) {
    let _ = writeln!(text, "    {}", paint.text(STRONG, leaf));
    let width = reads.iter().take(MOST_SHOWN).map(|read| read.path.width()).max().unwrap_or(0);
    for read in reads.iter().take(MOST_SHOWN) {
        let pad = " ".repeat(width - read.path.width());
        let saw = match read.byte_read {
            Some(byte) => format!("reads byte {byte}"),
            None => "reads nothing of the upload".to_string(),
        };
        let _ = writeln!(
            text,
            "      {} {}{pad}  {saw}, expected {}  {}",
            reader.reader.name(),
            read.path,
            read.expected_byte,
            paint.text(FAINT, read.way),
        );
    }
    if reads.len() > MOST_SHOWN {
        let _ = writeln!(text, "      … and {} more", reads.len() - MOST_SHOWN);
    }
    if let Some(cause) = reader.causes.iter().find(|cause| cause.leaf == leaf) {
        let _ = writeln!(text, "      {}", paint.text(CAUTION, &cause.cause));
    }
}

fn unprobed(block: &BlockReport, paint: Paint, text: &mut String) {
    let mut reasons: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for leaf in &block.unprobed {
        let paths = reasons.entry(&leaf.reason).or_default();
        if !paths.contains(&leaf.path.as_str()) {
            paths.push(&leaf.path);
        }
    }
    for (reason, paths) in reasons {
        let shown = paths.iter().take(MOST_SHOWN).map(|path| format!("`{path}`"));
        let shown = shown.collect::<Vec<_>>().join(", ");
        let more = match paths.len().checked_sub(MOST_SHOWN) {
            Some(more) if more > 0 => format!(" and {more} more"),
            Some(_) | None => String::new(),
        };
        let line = format!("    not probed: {shown}{more}: {reason}");
        let _ = writeln!(text, "{}", paint.text(CAUTION, &line));
    }
}

fn lands(read: &ElementReport) -> bool {
    read.byte_read == Some(read.expected_byte)
}

/// What a run came to, in one line.
pub fn summary(reports: &Counts) -> String {
    let Counts { shaders, blocks, reads, elsewhere, failed } = *reports;
    let counted = |count: usize, one: &str, many: &str| {
        format!("{} {}", words::number(count as u64), if count == 1 { one } else { many })
    };
    let mut text = format!(
        "{}, {}, {}: ",
        counted(shaders, "shader", "shaders"),
        counted(blocks, "block", "blocks"),
        counted(reads, "read", "reads"),
    );
    match (elsewhere, failed) {
        (0, 0) => text.push_str("every byte lands where the shader reads it"),
        (0, failed) => {
            let _ = write!(text, "{} could not be run", counted(failed, "probe", "probes"));
        }
        (elsewhere, 0) => {
            let _ = write!(text, "{} from other bytes", counted(elsewhere, "read", "reads"));
        }
        (elsewhere, failed) => {
            let _ = write!(
                text,
                "{} from other bytes, {} could not be run",
                counted(elsewhere, "read", "reads"),
                counted(failed, "probe", "probes"),
            );
        }
    }
    text.push('\n');
    text
}

/// What a run came to, in numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Shaders that were verified.
    pub shaders: usize,
    /// Their blocks.
    pub blocks: usize,
    /// Elements read, by all readers.
    pub reads: usize,
    /// Of them, from other bytes than expected.
    pub elsewhere: usize,
    /// Probes that could not be run.
    pub failed: usize,
}

impl Counts {
    /// Counts a shader in.
    pub fn add(&mut self, report: &ShaderReport) {
        self.shaders += 1;
        self.blocks += report.blocks.len();
        for reader in report.blocks.iter().flat_map(|block| &block.readers) {
            self.reads += reader.reads.len();
            self.elsewhere += reader.reads.iter().filter(|read| !lands(read)).count();
            self.failed += usize::from(reader.outcome == Outcome::Failed);
        }
        if let Some(run) = &report.compiled {
            self.reads += run.compared;
            self.elsewhere += run.differing;
        }
    }
}

#[derive(Serialize)]
struct ReaderObject<'a> {
    #[serde(flatten)]
    asked: JsonAsked<'a>,
    missing: Option<&'a str>,
}

impl<'a> ReaderObject<'a> {
    fn of(attendance: &'a Attendance) -> ReaderObject<'a> {
        let (asked, missing) = match attendance {
            Attendance::Here(device) => (JsonAsked::new(device.reader, Some(device)), None),
            Attendance::Missing { reader, failure } => {
                (JsonAsked::new(*reader, None), Some(failure.message.as_str()))
            }
        };
        ReaderObject { asked, missing }
    }
}

/// Everything before the first shader.
pub fn json_opening(attendance: &[Attendance]) -> String {
    let tool = to_lines(&Tool::LANDFALL, 0);
    let readers: Vec<ReaderObject<'_>> = attendance.iter().map(ReaderObject::of).collect();
    let readers = to_lines(&readers, 0);
    format!(
        "{{\"schema_version\":{SCHEMA_VERSION},\"tool\":{tool},\"readers\":{readers},\
         \"shaders\":[\n"
    )
}

/// One shader, without a newline at the end.
pub fn json_shader(report: &ShaderReport) -> String {
    format!("  {}", to_lines(report, 0))
}

/// Everything after the last shader.
pub fn json_closing(shaders: usize) -> &'static str {
    if shaders == 0 { "]}\n" } else { "\n]}\n" }
}

/// What was run, in words.
pub fn form_name(form: Form) -> &'static str {
    match form {
        Form::Original => "the text as it is",
        Form::Ported => "the text ported, its loose uniforms in a block",
        Form::Module => "a module with landfall's offsets",
        Form::Naga => "a module as naga makes it",
        Form::Spirv => "a module of the user's own compiler",
    }
}
