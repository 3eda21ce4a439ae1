//! Policies of `diff`, `lock` and `check --accept`.

use snapbox::str;

use crate::support::command::Place;

const OLD: &str = "#version 430 core
struct Light { vec3 pos; vec3 color; };
layout(std140, binding = 0) uniform Lights {
    Light all[2];
    float gamma;
    vec4 low;
    vec4 high;
} u_lights;
void main() {}
";

const POLICIES: [&str; 5] = ["none", "superset", "bytes", "names", "code"];

/// A change, and the first of the policies that forbids it. Offsets by hand from OpenGL 4.6
/// §7.6.2.2: `gamma` at 64, `low` at 80, the block 112.
const CHANGES: &[(&str, &str, Option<usize>)] = &[
    // No change of a declaration.
    ("float gamma;", "float gamma; // display", None),
    // `gamma` stays, `low` moves to 96.
    ("vec4 low;", "vec4 first; vec4 low;", Some(1)),
    ("float gamma;", "int gamma;", Some(1)),
    ("    vec4 high;\n", "", Some(1)),
    ("binding = 0", "binding = 1", Some(1)),
    // In the padding behind `gamma`, and at the end: old uploads land.
    ("float gamma;", "float gamma; float bias;", Some(2)),
    ("vec4 high;", "vec4 high; vec4 more;", Some(2)),
    ("float gamma;", "float gain;", Some(3)),
    ("Light", "Lamp", Some(3)),
    ("} u_lights", "} u_lamps", Some(3)),
    // A new block is nobody's old bytes.
    ("void main", "layout(std140, binding = 5) uniform Fog { vec4 fog; } u_fog;\nvoid main", None),
];

/// The lines of the generated code, without comments.
fn code(tree: &Place, path: &str) -> Vec<String> {
    let ran = tree.run(&["emit", path, "--lang", "rust"]);
    assert_eq!(ran.code, 0, "{}", ran.err);
    // Assertions name the file.
    let text = ran.out.replace(path, "light.frag");
    let lines = text.lines().map(str::trim);
    lines.filter(|line| !line.starts_with("//")).map(String::from).collect()
}

#[test]
fn each_policy_forbids_what_the_one_before_it_does_and_more() {
    let tree = Place::new("policy-table");
    tree.write("old/light.frag", OLD);
    for (from, to, least) in CHANGES {
        assert!(OLD.contains(from), "{from}");
        let new = match *from {
            "Light" => OLD.replace("Light ", "Lamp "),
            _ => OLD.replacen(from, to, 1),
        };
        tree.write("new/light.frag", new);
        for (at, policy) in POLICIES.iter().enumerate() {
            let ran = tree.run(&["diff", "old/light.frag", "new/light.frag", "--policy", policy]);
            let forbidden = least.is_some_and(|least| least <= at);
            assert_eq!(ran.code, i32::from(forbidden), "{from}: {to}: {policy}\n{}", ran.out);
            assert_eq!(ran.out.contains("forbids"), forbidden, "{}", ran.out);
        }
        // Code that uses the mirrors of the old layout has to change only where `code` says so.
        let (was, is) = (code(&tree, "old/light.frag"), code(&tree, "new/light.frag"));
        let gone = was.iter().any(|line| !is.contains(line));
        assert!(!gone || least.is_some(), "{from}: {to}: the generated code changes");
    }
}

#[test]
fn a_lock_is_kept_until_its_policy_is_put_aside() {
    let tree = Place::new("policy-lock");
    tree.write("landfall.toml", "policy = \"bytes\"\n").write("shaders/light.frag", OLD);
    assert_eq!(tree.run(&["lock"]).code, 0);
    let lock = "layouts/shaders/light.frag.json";
    let old = tree.read(lock);
    tree.write("old.frag.json", &old);
    tree.write("shaders/light.frag", OLD.replace("float gamma;", "float gamma; float bias;"));
    tree.run(&["lock"]).code(1).stdout_eq("").stderr_eq(str![[r#"
error[policy-forbids]: `shaders/light.frag` has a change of block `Lights` that policy `bytes` forbids: `bias` (`float`) uses former padding at 68
  |
  = help: undo it, or write the lock with `landfall lock --policy none`

0 locks written, 0 unchanged, 1 kept by policy

"#]]);
    assert_eq!(tree.read(lock), old);
    let ran = tree.run(&["diff", "old.frag.json", "shaders/light.frag", "-f", "json"]);
    assert_eq!(ran.code, 1);
    let json: serde_json::Value = serde_json::from_str(&ran.out).unwrap();
    let shader = &json["shaders"][0];
    assert_eq!(shader["policy"], "bytes");
    assert_eq!(shader["blocks"][0]["changes"][0]["verdict"], "forbidden");
    let ran = tree.run(&["diff", "old.frag.json", "shaders/light.frag"]);
    assert!(ran.out.ends_with("1 compatible\npolicy `bytes` forbids 1 change\n"), "{}", ran.out);
    tree.run(&["lock", "--policy", "none"]).code(0).stderr_eq(str![[r#"
1 lock written, 0 unchanged

"#]]);
    assert_ne!(tree.read(lock), old);
    let ran = tree.run(&[
        "diff",
        "old.frag.json",
        "shaders/light.frag",
        "--policy",
        "none",
        "-f",
        "json",
    ]);
    assert_eq!(ran.code, 0);
    let json: serde_json::Value = serde_json::from_str(&ran.out).unwrap();
    assert_eq!(json["shaders"][0]["blocks"][0]["changes"][0]["verdict"], "allowed");
}

/// `--accept` of `check` and `diff` obeys the policies that `lock` obeys.
#[test]
fn no_command_accepts_what_a_policy_forbids() {
    let tree = Place::new("policy-accept");
    tree.write("landfall.toml", "policy = \"bytes\"\n").write("shaders/light.frag", OLD);
    assert_eq!(tree.run(&["lock"]).code, 0);
    let lock = "layouts/shaders/light.frag.json";
    let old = tree.read(lock);
    tree.write("shaders/light.frag", OLD.replace("float gamma;", "float gamma; float bias;"));
    tree.run(&["check", "--accept", "-f", "short"]).code(1).stdout_eq(str![[r#"
shaders/light.frag:3:37: error[layout-drift] `Lights` differs from its lock: `bias` (`float`) uses former padding at 68; buffers filled for it are still read correctly, but the lock is out of date

"#]]).stderr_eq(str![[r#"
checked 1 shader: 1 error
kept 1 lock: a policy forbids the changes; `landfall lock --policy none` writes them

"#]]);
    assert_eq!(tree.read(lock), old);
    tree.run(&["diff", lock, "shaders/light.frag", "--accept"]).code(1).stderr_eq(str![[r#"
error[policy-forbids]: `shaders/light.frag` has a change of block `Lights` that policy `bytes` forbids: `bias` (`float`) uses former padding at 68
  |
  = help: undo it, or write the lock with `landfall lock --policy none`

no lock was updated

"#]]);
    assert_eq!(tree.read(lock), old);
    // What the policy allows is accepted.
    tree.write("shaders/light.frag", OLD.replace("float gamma;", "float gain;"));
    assert_eq!(tree.run(&["check", "--accept"]).code, 0);
    assert_ne!(tree.read(lock), old);
}

#[test]
fn policies_are_chosen_for_a_path() {
    let tree = Place::new("policy-path");
    tree.write(
        "landfall.toml",
        "policy = \"names\"\n[[path-policy]]\nfile = \"shaders/tools/**\"\npolicy = \"superset\"\n\
         [[path-policy]]\nfile = \"shaders/tools/free.frag\"\npolicy = \"none\"\n",
    );
    let renamed = OLD.replace("float gamma", "float gain");
    let free = "shaders/tools/free.frag";
    for path in ["shaders/light.frag", "shaders/tools/light.frag", free] {
        tree.write(path, OLD);
    }
    assert_eq!(tree.run(&["lock"]).code, 0);
    for path in ["shaders/light.frag", "shaders/tools/light.frag"] {
        tree.write(path, &renamed);
    }
    tree.write(free, OLD.replace("vec4 low;", "vec4 first; vec4 low;"));
    let ran = tree.run(&["lock"]);
    ran.code(1).stderr_eq(str![[r#"
error[policy-forbids]: `shaders/light.frag` has a change of block `Lights` that policy `names` forbids: `gamma` was renamed to `gain`, in the same place
  |
  = help: undo it, or write the lock with `landfall lock --policy none`

2 locks written, 0 unchanged, 1 kept by policy

"#]]);
    assert!(tree.read("layouts/shaders/tools/light.frag.json").contains("gain"));
    assert!(!tree.read("layouts/shaders/light.frag.json").contains("gain"));
    // The command line takes precedence.
    assert_eq!(tree.run(&["lock", "--policy", "superset"]).code, 0);
}

#[test]
fn what_is_no_policy_is_refused() {
    let tree = Place::new("policy-wrong");
    tree.write("a.frag", OLD);
    for arguments in [
        &["diff", "a.frag", "a.frag", "--policy", "wire"][..],
        &["lock", "--policy", "strict"],
        &["diff", "a.frag", "a.frag", "--policy", "code", "--breaking"],
    ] {
        assert_eq!(tree.run(arguments).code, 2, "{arguments:?}");
    }
    assert!(!tree.has("layouts"), "nothing is written");
    tree.write("landfall.toml", "policy = \"wire\"\n");
    tree.run(&["lock"]).code(2).stderr_eq(str![[r#"
error[wrong-value]: unknown policy `wire`
 --> landfall.toml:1:10
  |
1 | policy = "wire"
  |          ^^^^^^
  |
  = help: known are `none`, `superset`, `bytes`, `names`, `code`


"#]]);
}
