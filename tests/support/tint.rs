//! Tint, the WGSL compiler of Dawn: `tint` on the path, or Dawn's package for Node.js, which
//! `tests/run` installs into `target/tint`.

use std::path::Path;
use std::process::Command;
use std::sync::atomic::{AtomicU32, Ordering};

/// Tint's errors in a WGSL text; empty if it accepts it.
pub fn errors(text: &str) -> String {
    static NEXT: AtomicU32 = AtomicU32::new(0);
    let number = NEXT.fetch_add(1, Ordering::Relaxed);
    let name = format!("landfall_tint_{}_{number}.wgsl", std::process::id());
    let path = std::env::temp_dir().join(name);
    std::fs::write(&path, text).expect("a temporary file can be written");
    let output = match Command::new("tint").args(["--format", "wgsl"]).arg(&path).output() {
        Ok(output) => output,
        Err(_) => {
            let root = Path::new(env!("CARGO_MANIFEST_DIR"));
            let script = root.join("tests/support/tint.mjs");
            let mut node = Command::new("node");
            node.arg(script).arg(root.join("target/tint")).arg(&path);
            node.output().expect("`tint` or `node`: tests/run installs it")
        }
    };
    let _ = std::fs::remove_file(&path);
    match output.status.code() {
        Some(0) => String::new(),
        // Anything else than a refusal of the text is a failure of the oracle.
        _ => {
            let said = String::from_utf8_lossy(&output.stderr).into_owned();
            let said = format!("{said}{}", String::from_utf8_lossy(&output.stdout));
            assert!(said.contains("error:"), "tint: {said}");
            said
        }
    }
}
