//! Faults of `run` and `stress`: the operands they name, and calls as deep as a text may nest them.

use std::path::{Path, PathBuf};

use crate::support::command;

fn written(name: &str, text: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("cli_run_faults");
    std::fs::create_dir_all(&folder).expect("a folder");
    let path = folder.join(name);
    std::fs::write(&path, text).expect("it is written");
    path
}

/// The `f64` that is computed beside has other operands, where both have the same fault.
#[test]
fn a_fault_of_f32_names_the_operands_of_f32() {
    let text = "#version 330\nfloat h(float x, float cut) { return (x * x - 1.0) / (1.0 - cut); }\n\
                out vec4 c;\nvoid main() { c = vec4(h(1.0, 2.0)); }\n";
    let path = written("operands.frag", text);
    let path = path.to_str().expect("it is text");
    let ran = command::run(&["run", path, "--fn", "h", "--args", "[1.0000001, 1.0]"]);
    let x = 1.000_000_1_f32;
    let (single, double) = (f64::from(x * x - 1.0), f64::from(x) * f64::from(x) - 1.0);
    let told = ran.err;
    assert!(told.contains(&format!("infinity from finite operands: {single:?}, 0.0")), "{told}");
    assert!(told.contains(&format!("division by zero: {single:?}, 0.0")), "{told}");
    assert!(!told.contains(&format!("{double:?}")), "{told}");
}

#[test]
fn stress_calls_as_deep_as_the_text_nests() {
    let mut text = "#version 450\nlayout(location = 0) out vec4 c;\n\
                    float f0(float x) { return x; }\n"
        .to_string();
    let deepest = 6_000;
    for nth in 1..=deepest {
        let last = nth - 1;
        text += &format!("float f{nth}(float x) {{ if (x > 0.0) return f{last}(x); return x; }}\n");
    }
    text += &format!("void main() {{ c = vec4(f{deepest}(1.0)); }}\n");
    let path = written("deep.frag", &text);
    let function = format!("f{deepest}");
    let few = ["--samples", "64", "--time", "2"];
    let named = ["stress", path.to_str().expect("it is text"), "--fn", &function];
    let ran = command::run(&[&named[..], &few].concat());
    assert!(matches!(ran.code, 0 | 1), "{}: {}", ran.code, ran.err);
}
