//! The real compiler, clippy and rustfmt, and the crates that mirrors need.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

/// glam and bytemuck, built.
pub struct Crates {
    glam: PathBuf,
    bytemuck: PathBuf,
    deps: PathBuf,
}

/// Whether glam uses SIMD: that decides what its types are aligned to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Math {
    Simd,
    Scalar,
}

/// The crates, built by cargo from the fixture's own lock file when first asked for.
pub fn crates(math: Math) -> &'static Crates {
    static SIMD: OnceLock<Crates> = OnceLock::new();
    static SCALAR: OnceLock<Crates> = OnceLock::new();
    match math {
        Math::Simd => SIMD.get_or_init(|| build(math)),
        Math::Scalar => SCALAR.get_or_init(|| build(math)),
    }
}

/// A directory of this test's own.
pub fn scratch(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("mirrors").join(name);
    std::fs::create_dir_all(&path).expect("target/tmp can be written to");
    path
}

fn build(math: Math) -> Crates {
    let fixture = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/mirrors/fixture");
    let mut cargo = Command::new(env!("CARGO"));
    // `tests/run` sets it for libtest.
    cargo.env_remove("RUSTC_BOOTSTRAP");
    cargo.args(["build", "--locked", "--quiet", "--message-format", "json"]);
    cargo.arg("--manifest-path").arg(fixture.join("Cargo.toml"));
    // One directory for both would let them take turns in it.
    cargo.arg("--target-dir").arg(scratch(&format!("{math:?}")));
    if math == Math::Scalar {
        cargo.args(["--features", "scalar-math"]);
    }
    let out = cargo.output().expect("cargo runs this test");
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    let messages = String::from_utf8_lossy(&out.stdout);
    let artifacts: Vec<serde_json::Value> =
        messages.lines().filter_map(|line| serde_json::from_str(line).ok()).collect();
    let library = |name: &str| {
        artifacts
            .iter()
            .filter(|artifact| artifact["target"]["name"] == name)
            .filter_map(|artifact| artifact["filenames"].as_array())
            .flatten()
            .filter_map(|file| file.as_str())
            .find(|file| file.ends_with(".rlib"))
            .map(PathBuf::from)
            .unwrap_or_else(|| panic!("cargo built no {name}:\n{messages}"))
    };
    let glam = library("glam");
    let deps = glam.parent().expect("a library lies in a directory").to_path_buf();
    Crates { bytemuck: library("bytemuck"), glam, deps }
}

/// What a text is compiled to.
#[derive(Clone, Copy, Debug)]
pub enum Target {
    /// Checked as the root of a library, assertions included; nothing is written.
    Library,
    /// Checked as the root of a program that uses none of it.
    Program,
}

/// Checks a root file with warnings denied. `compiler` is `rustc` or `clippy-driver`.
pub fn check(
    compiler: &str,
    crates: &Crates,
    root: &Path,
    edition: &str,
    target: Target,
) -> Output {
    let mut command = command(compiler, crates, root, edition);
    let out = root.with_extension(format!("{compiler}.{edition}.rmeta"));
    command.args(["--emit", "metadata", "--crate-type"]);
    command.arg(match target {
        Target::Library => "lib",
        Target::Program => "bin",
    });
    command.arg("-o").arg(out);
    command.output().unwrap_or_else(|e| panic!("cannot run {compiler} ({e})"))
}

/// Compiles a program with warnings denied, runs it, and returns what it writes.
pub fn run(crates: &Crates, root: &Path, edition: &str) -> Vec<u8> {
    let program = root.with_extension("program");
    let mut command = command("rustc", crates, root, edition);
    command.arg("-o").arg(&program);
    let built = command.output().expect("rustc compiled this test");
    assert!(built.status.success(), "{}", shown(&built.stderr));
    let ran = Command::new(&program).output().expect("the program was just built");
    assert!(ran.status.success(), "{}:\n{}", root.display(), shown(&ran.stderr));
    ran.stdout
}

fn command(compiler: &str, crates: &Crates, root: &Path, edition: &str) -> Command {
    let mut command = Command::new(compiler);
    command.env_remove("RUSTC_BOOTSTRAP");
    command.arg(root).args(["--edition", edition, "--crate-name", "generated"]);
    command.args(["-D", "warnings"]);
    if compiler == "clippy-driver" {
        command.args(["-D", "clippy::all"]);
    }
    let external = |name: &str, path: &Path| format!("{name}={}", path.display());
    command.arg("--extern").arg(external("glam", &crates.glam));
    command.arg("--extern").arg(external("bytemuck", &crates.bytemuck));
    command.arg("-L").arg(format!("dependency={}", crates.deps.display()));
    command
}

/// Panics with the difference where rustfmt would change a file.
pub fn assert_formatted(file: &Path, edition: &str) {
    // Its defaults, not this project's.
    let defaults = scratch("rustfmt").join("rustfmt.toml");
    std::fs::write(&defaults, "").expect("scratch can be written to");
    let out = Command::new("rustfmt")
        .args(["--check", "--edition", edition, "--config-path"])
        .arg(defaults)
        .arg(file)
        .output()
        .expect("rustfmt is part of the toolchain");
    let said = [out.stdout, out.stderr].concat();
    assert!(out.status.success(), "{}", shown(&said));
}

/// The beginning of what a tool says.
pub fn shown(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).lines().take(60).collect::<Vec<_>>().join("\n")
}
