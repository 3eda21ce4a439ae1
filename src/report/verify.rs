//! The report of `landfall verify`: a line for each block as text, every element as JSON.
//!
//! Formats the data of [`harness::verify::report`](landfall_exec::harness::verify::report).

use std::collections::BTreeMap;
use std::fmt::Write as _;

use anstyle::Style;
use serde::Serialize;
use unicode_width::UnicodeWidthStr;

use landfall_exec::harness::verify::report::{
    BackendReport, BackendStatus, BlockReport, CompiledRun, ElementReport, Outcome, ShaderReport,
};
use landfall_exec::report::device::{JsonBackend, about};
use landfall_layout::format::SCHEMA_VERSION;
use landfall_layout::format::columns::cells_behind;
use landfall_layout::format::json::{Tool, to_lines};
pub use landfall_layout::format::paint::{CAUTION, FAINT, HEADING, PLAIN, Paint, STRONG};
pub use landfall_layout::format::phrases;
use landfall_layout::layout::targets;
use landfall_layout::text::escape;

pub use crate::report::schema::VERIFY_SCHEMA;

/// The most elements of one leaf shown where a backend disagrees.
const MAX_SHOWN: usize = 4;

/// The most lines shown of a compiler's log.
const MAX_LOG: usize = 6;

/// Returns the backends that ran, and the missing ones with the reason.
pub fn backends(statuses: &[BackendStatus], paint: Paint) -> String {
    let mut text = paint.text(STRONG, "backends");
    text.push('\n');
    let kind = |status: &BackendStatus| match status {
        BackendStatus::Here(device) => device.backend,
        BackendStatus::Missing { backend, .. } => *backend,
    };
    let width = statuses.iter().map(|status| kind(status).name().len()).max().unwrap_or(0).max(4);
    for backend in statuses {
        let (name, line) = match backend {
            BackendStatus::Here(device) => (device.backend, paint.text(PLAIN, &about(device))),
            BackendStatus::Missing { backend, failure } => {
                (*backend, paint.text(CAUTION, &format!("did not run: {}", failure.message)))
            }
        };
        let _ = writeln!(text, "  {} {line}", paint.text(HEADING, &format!("{name:<width$}")));
    }
    text
}

/// The columns of a block's line beside its name and its size.
const FACTS: usize = 25;

/// Returns the text of one shader: a line for each block, with mismatches and failures below it.
pub fn shader(report: &ShaderReport, paint: Paint) -> String {
    let mut text = paint.text(STRONG, &escape::name(&report.path));
    text.push('\n');
    if let Some(note) = targets::note(report.assumed_target) {
        text.push_str(&paint.text(CAUTION, &format!("  {note}\n")));
    }
    if report.blocks.is_empty() {
        text.push_str(&paint.text(FAINT, "  no blocks\n"));
    }
    let names: Vec<String> = report.blocks.iter().map(name).collect();
    let width = names.iter().map(|name| name.width()).max().unwrap_or(0);
    let bytes: Vec<String> =
        report.blocks.iter().map(|b| phrases::numbered(b.size, "byte")).collect();
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
        let verdicts = block
            .backends
            .iter()
            // The width is that without colours.
            .map(|backend| (verdict(backend, paint), verdict(backend, Paint::Plain).width()));
        let verdicts: Vec<(String, usize)> = verdicts.collect();
        text.push_str(&cells_behind(&verdicts, width + digits + FACTS, 6));
        text.push('\n');
        for backend in &block.backends {
            details(backend, paint, &mut text);
        }
        if !block.unprobed.is_empty() {
            unprobed(block, paint, &mut text);
        }
        if let Some(coverage) = &block.coverage {
            text.push_str(&super::coverage::block(coverage, paint));
        }
    }
    if let Some(run) = &report.compiled {
        let (style, line) = compiled(run);
        let _ = writeln!(text, "  {} {}", paint.text(HEADING, "spirv"), paint.text(style, &line));
    }
    text
}

/// Returns the comparison of a user's SPIR-V with Landfall's module.
fn compiled(run: &CompiledRun) -> (Style, String) {
    let CompiledRun { backend, outcome, compared, differing, reason } = run;
    let compared = phrases::number(*compared as u64);
    let reason = reason.as_deref().unwrap_or("no reason given");
    match outcome {
        Outcome::Confirmed => {
            (PLAIN, format!("✓ run on {backend}: {compared} 32-bit words match landfall's module"))
        }
        Outcome::Disagrees => {
            let message =
                format!("✗ run on {backend}: {differing} of {compared} 32-bit words differ");
            (CAUTION, format!("{message} from landfall's module"))
        }
        Outcome::Failed | Outcome::Skipped => (FAINT, format!("not run on {backend}: {reason}")),
    }
}

fn name(block: &BlockReport) -> String {
    match (&*block.name, &block.instance) {
        ("", Some(instance)) => instance.clone(),
        (name, _) => name.to_string(),
    }
}

fn verdict(backend: &BackendReport, paint: Paint) -> String {
    let wrong = backend.reads.iter().filter(|read| !lands(read)).count();
    let all = backend.reads.len();
    let (style, line) = match backend.outcome {
        Outcome::Confirmed => (PLAIN, format!("✓ {} reads", phrases::number(all as u64))),
        Outcome::Disagrees => (
            CAUTION,
            format!("✗ {wrong} of {} reads returned another byte", phrases::number(all as u64)),
        ),
        Outcome::Failed => (CAUTION, "failed to run".to_string()),
        Outcome::Skipped => (FAINT, "–".to_string()),
    };
    format!("{} {}", paint.text(FAINT, backend.backend.name()), paint.text(style, &line))
}

fn details(backend: &BackendReport, paint: Paint, text: &mut String) {
    match backend.outcome {
        Outcome::Confirmed => {}
        Outcome::Skipped | Outcome::Failed => {
            let reason = backend.reason.as_deref().unwrap_or("no reason given");
            let _ = writeln!(text, "    {}: {reason}", backend.backend.name());
            for line in backend.log.lines().filter(|l| !l.trim().is_empty()).take(MAX_LOG) {
                let _ = writeln!(text, "    {}", paint.text(FAINT, &format!("| {line}")));
            }
        }
        Outcome::Disagrees => {
            // By leaf, since all elements of one leaf usually go wrong alike.
            let mut leaves: BTreeMap<&str, Vec<&ElementReport>> = BTreeMap::new();
            for read in backend.reads.iter().filter(|read| !lands(read)) {
                leaves.entry(&read.leaf).or_default().push(read);
            }
            for (leaf, reads) in leaves {
                elsewhere(backend, leaf, &reads, paint, text);
            }
        }
    }
}

fn elsewhere(
    backend: &BackendReport,
    leaf: &str,
    reads: &[&ElementReport],
    paint: Paint,
    text: &mut String,
) {
    let _ = writeln!(text, "    {}", paint.text(STRONG, leaf));
    let width = reads.iter().take(MAX_SHOWN).map(|read| read.path.width()).max().unwrap_or(0);
    for read in reads.iter().take(MAX_SHOWN) {
        let pad = " ".repeat(width - read.path.width());
        let saw = match read.byte_read {
            Some(byte) => format!("reads byte {byte}"),
            None => "reads none of the uploaded bytes".to_string(),
        };
        let _ = writeln!(
            text,
            "      {} {}{pad}  {saw}, expected {}  {}",
            backend.backend.name(),
            read.path,
            read.expected_byte,
            paint.text(FAINT, read.way),
        );
    }
    if reads.len() > MAX_SHOWN {
        let _ = writeln!(text, "      … and {} more", reads.len() - MAX_SHOWN);
    }
    if let Some(cause) = backend.causes.iter().find(|cause| cause.leaf == leaf) {
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
        let shown = paths.iter().take(MAX_SHOWN).map(|path| format!("`{path}`"));
        let shown = shown.collect::<Vec<_>>().join(", ");
        let more = match paths.len().checked_sub(MAX_SHOWN) {
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

/// Returns the summary of a run in one line.
pub fn summary(reports: &Counts) -> String {
    let Counts { shaders, blocks, unread, unprobed, reads, elsewhere, failed } = *reports;
    let counted = phrases::counted;
    let mut text = format!(
        "{}, {}, {}: ",
        counted(shaders, "shader"),
        counted(blocks, "block"),
        counted(reads, "read"),
    );
    let faults = [
        (elsewhere > 0).then(|| format!("{} from other bytes", counted(elsewhere, "read"))),
        (failed > 0).then(|| format!("{} could not be run", counted(failed, "probe"))),
    ];
    let faults: Vec<String> = faults.into_iter().flatten().collect();
    text.push_str(&match (faults.is_empty(), reads) {
        (true, 0) => "nothing is verified".to_string(),
        (true, _) => "every byte lands where the shader reads it".to_string(),
        (false, _) => faults.join(", "),
    });
    if unprobed > 0 && reads > 0 {
        let leaves = match unprobed {
            1 => "1 leaf".to_string(),
            n => format!("{} leaves", phrases::number(n as u64)),
        };
        let _ = write!(text, "; no probe reads {leaves}");
    }
    if unread > 0 && reads > 0 {
        let _ = write!(text, "; no backend read {}", counted(unread, "block"));
    }
    text.push('\n');
    text
}

/// The totals of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Shaders verified.
    pub shaders: usize,
    /// Blocks of those shaders.
    pub blocks: usize,
    /// Blocks that no backend read a member of.
    pub unread: usize,
    /// Leaves that no probe reads.
    pub unprobed: usize,
    /// Elements read, over all backends.
    pub reads: usize,
    /// Reads from other bytes than expected.
    pub elsewhere: usize,
    /// Probes that could not be run.
    pub failed: usize,
}

impl Counts {
    /// Adds the counts of a shader.
    pub fn add(&mut self, report: &ShaderReport) {
        self.shaders += 1;
        self.blocks += report.blocks.len();
        // Leaves of a block that no backend read are not told one by one.
        let unread = |block: &&BlockReport| block.backends.iter().all(|b| b.reads.is_empty());
        self.unread += report.blocks.iter().filter(unread).count();
        for block in report.blocks.iter().filter(|block| !unread(block)) {
            let paths = block.unprobed.iter().map(|leaf| &leaf.path);
            self.unprobed += paths.collect::<std::collections::BTreeSet<_>>().len();
        }
        for backend in report.blocks.iter().flat_map(|block| &block.backends) {
            self.reads += backend.reads.len();
            self.elsewhere += backend.reads.iter().filter(|read| !lands(read)).count();
            self.failed += usize::from(backend.outcome == Outcome::Failed);
        }
        if let Some(run) = &report.compiled {
            // The words of a user's SPIR-V count as reads.
            self.reads += run.compared;
            self.elsewhere += run.differing;
        }
    }
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct VerifyBackendObject<'a> {
    #[serde(flatten)]
    asked: JsonBackend<'a>,
    /// The reason it did not run; null if it did.
    missing: Option<&'a str>,
}

impl<'a> VerifyBackendObject<'a> {
    fn new(statuses: &'a BackendStatus) -> VerifyBackendObject<'a> {
        let (asked, missing) = match statuses {
            BackendStatus::Here(device) => (JsonBackend::new(device.backend, Some(device)), None),
            BackendStatus::Missing { backend, failure } => {
                (JsonBackend::new(*backend, None), Some(failure.message.as_str()))
            }
        };
        VerifyBackendObject { asked, missing }
    }
}

/// The byte that each backend reads for every element of every block. Bytes count from the start of
/// the block.
#[cfg(feature = "schema")]
#[derive(schemars::JsonSchema)]
#[expect(dead_code, reason = "never more than a shader is in memory")]
struct VerifyDocument<'a> {
    #[schemars(extend("const" = SCHEMA_VERSION))]
    schema_version: u32,
    tool: Tool,
    backends: Vec<VerifyBackendObject<'a>>,
    shaders: Vec<ShaderReport>,
}

/// The schema of [`VERIFY_SCHEMA`].
#[cfg(feature = "schema")]
#[doc(hidden)]
pub fn schema() -> String {
    landfall_layout::schema::text::<VerifyDocument<'_>>("landfall verify --format json")
}

/// Returns the document up to the first shader.
pub fn json_opening(statuses: &[BackendStatus]) -> String {
    let tool = to_lines(&Tool::LANDFALL);
    let backends: Vec<VerifyBackendObject<'_>> =
        statuses.iter().map(VerifyBackendObject::new).collect();
    let backends = to_lines(&backends);
    format!(
        "{{\"schema_version\":{SCHEMA_VERSION},\"tool\":{tool},\"backends\":{backends},\
         \"shaders\":[\n"
    )
}

/// One shader, without a newline at the end.
pub fn json_shader(report: &ShaderReport) -> String {
    format!("  {}", to_lines(report))
}

/// Returns the end of the document, given the number of shaders.
pub fn json_closing(shaders: usize) -> &'static str {
    if shaders == 0 { "]}\n" } else { "\n]}\n" }
}
