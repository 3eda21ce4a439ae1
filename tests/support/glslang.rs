//! The first oracle: the Khronos reference front end, `glslangValidator`
//! (Debian package `glslang-tools`), or where that is the same, `glslang_server`.
//! Its SPIR-V binary is read by `spirv`; its reflection listing gives the one
//! number SPIR-V does not hold, the end of a block's last member.

use std::collections::HashMap;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};

use super::leaf::OracleBlock;
use super::{glslang_server, spirv};

/// Which semantics the text is written for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Client {
    Vulkan,
    OpenGl,
}

/// How `glslangValidator` is called.
#[derive(Clone, Debug)]
pub struct Options {
    pub client: Client,
    /// Give blocks and inputs the bindings and locations they lack.
    pub auto_map: bool,
    /// `-R`: Vulkan with loose uniforms gathered into a block.
    pub relaxed: bool,
    /// `vulkan1.3`, `spirv1.5`, …
    pub target_env: Option<&'static str>,
    /// `NAME` or `NAME=VALUE`.
    pub defines: Vec<String>,
    pub include_dirs: Vec<PathBuf>,
    /// Ask the reflection listing for `data_size` as well. It covers the
    /// blocks that live code touches, no others.
    pub reflect: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            client: Client::Vulkan,
            auto_map: true,
            relaxed: false,
            target_env: None,
            defines: Vec::new(),
            include_dirs: Vec::new(),
            reflect: true,
        }
    }
}

impl Options {
    /// Those of `glslang_server`: without the reflection listing.
    pub fn unlisted() -> Options {
        Options { reflect: false, ..Options::default() }
    }

    /// Whether these are the settings of `glslang_server`.
    fn are_those_of_the_server(&self) -> bool {
        let Options { client, auto_map, relaxed, target_env, defines, include_dirs, reflect } =
            self;
        let is_plain = *client == Client::Vulkan && *auto_map && !relaxed && !reflect;
        is_plain && target_env.is_none() && defines.is_empty() && include_dirs.is_empty()
    }
}

/// The blocks of one stage, used or not, in order of declaration. `stage` is
/// glslang's word: `comp`, `vert`, `frag`. An error is glslang's own report.
pub fn blocks(text: &str, stage: &str, options: &Options) -> Result<Vec<OracleBlock>, String> {
    let (words, listing) = compiled(text, stage, options)?;
    let mut blocks = spirv::blocks(&words)?;
    if options.reflect {
        let sizes = block_sizes(&listing);
        for block in &mut blocks {
            block.data_size = sizes.get(block.name.as_str()).copied();
        }
    }
    Ok(blocks)
}

/// The words of the module that glslang makes of one stage, and its listing. An error is glslang's own
/// report.
pub fn compiled(text: &str, stage: &str, options: &Options) -> Result<(Vec<u32>, String), String> {
    if options.are_those_of_the_server() {
        let words = glslang_server::compiled(text, stage, options.client)?;
        return Ok((words, String::new()));
    }
    let output = Scratch::new();
    let listing = compile(text, stage, options, &output.0)?;
    let bytes = std::fs::read(&output.0)
        .map_err(|e| format!("glslangValidator wrote no {}: {e}\n{listing}", output.0.display()))?;
    let words = bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    Ok((words.collect(), listing))
}

/// Whether a shader for OpenGL is accepted. Nothing is made of it: SPIR-V has no version before
/// 1.40, or 3.10 of ES.
pub fn accepts(text: &str, stage: &str) -> bool {
    glslang_server::compiled(text, stage, Client::OpenGl).is_ok()
}

fn compile(text: &str, stage: &str, options: &Options, output: &Path) -> Result<String, String> {
    let mut command = Command::new("glslangValidator");
    command.args(["--stdin", "-S", stage, "-o"]).arg(output);
    command.arg(match options.client {
        Client::Vulkan => "-V",
        Client::OpenGl => "-G",
    });
    if options.auto_map {
        command.args(["--aml", "--amb"]);
    }
    if options.relaxed {
        command.arg("-R");
    }
    if options.reflect {
        command.args(["-l", "-q"]);
    }
    if let Some(env) = options.target_env {
        command.args(["--target-env", env]);
    }
    command.args(options.defines.iter().map(|d| format!("-D{d}")));
    command.args(options.include_dirs.iter().map(|d| format!("-I{}", d.display())));
    command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap_or_else(|e| {
        panic!("cannot run glslangValidator ({e}): install the Debian package `glslang-tools`")
    });
    let mut stdin = child.stdin.take().expect("stdin is piped above");
    let written = stdin.write_all(text.as_bytes());
    drop(stdin);
    let out = child.wait_with_output().map_err(|e| format!("glslangValidator: {e}"))?;
    let listing = String::from_utf8_lossy(&out.stdout).into_owned();
    if !out.status.success() {
        return Err(listing);
    }
    written.map_err(|e| format!("glslangValidator's stdin: {e}"))?;
    Ok(listing)
}

/// `C[0]: offset -1, type ffffffff, size 64, index 1, …` under the heading
/// `Uniform block reflection:`, by the block's name without indices.
fn block_sizes(listing: &str) -> HashMap<&str, u64> {
    listing
        .lines()
        .skip_while(|line| *line != "Uniform block reflection:")
        .skip(1)
        .take_while(|line| !line.is_empty())
        .filter_map(|line| {
            let (name, facts) = line.split_once(": ")?;
            let name = name.split('[').next()?;
            let size = facts.split(", ").find_map(|fact| fact.strip_prefix("size "))?;
            Some((name, size.parse().ok()?))
        })
        .collect()
}

/// A file of this process's own, removed when done.
struct Scratch(PathBuf);

impl Scratch {
    fn new() -> Self {
        static NEXT: AtomicU32 = AtomicU32::new(0);
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        let name = format!("glslang-{}-{number}.spv", std::process::id());
        Self(Path::new(env!("CARGO_TARGET_TMPDIR")).join(name))
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        // It may never have been written; a leftover in target/tmp is harmless.
        let _ = std::fs::remove_file(&self.0);
    }
}
