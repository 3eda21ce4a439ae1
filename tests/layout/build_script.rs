//! A real user of the build script: the crate under `tests/example`, built and run, and what it
//! sees when its shaders break.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use landfall_codegen::Build;
use snapbox::str;

use crate::support::command::golden;

const EXAMPLE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/example");

/// Runs a cargo command in a copy of the example; all copies share what they depend on.
fn cargo(dir: &Path, command: &str) -> Output {
    Command::new(env!("CARGO"))
        .args([command, "--quiet", "--locked"])
        .current_dir(dir)
        .env("CARGO_TARGET_DIR", concat!(env!("CARGO_MANIFEST_DIR"), "/target/example"))
        // Cargo's own variables for this test are not the example's.
        .env_remove("CARGO_MANIFEST_DIR")
        .env_remove("OUT_DIR")
        .env_remove("RUSTC_BOOTSTRAP")
        .output()
        .expect("cargo runs this test")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// A copy of the example in a directory of its own, removed at the end.
struct Copy(PathBuf);

impl Copy {
    fn new(name: &str) -> Copy {
        let dir = std::env::temp_dir().join(format!("landfall-{name}-{}", std::process::id()));
        for file in [
            "Cargo.toml",
            "Cargo.lock",
            "build.rs",
            "src/main.rs",
            "shaders/lights.frag",
            "shaders/particles.comp",
            "shaders/include/light.glsl",
        ] {
            let to = dir.join(file);
            fs::create_dir_all(to.parent().expect("below the copy")).expect("a directory");
            fs::copy(Path::new(EXAMPLE).join(file), to).expect("a file of the example");
        }
        let manifest = fs::read_to_string(dir.join("Cargo.toml")).expect("the manifest");
        let here = env!("CARGO_MANIFEST_DIR");
        let manifest = manifest.replace("path = \"../..\"", &format!("path = \"{here}\""));
        fs::write(dir.join("Cargo.toml"), manifest).expect("the manifest");
        Copy(dir)
    }

    fn edit(&self, file: &str, from: &str, to: &str) {
        let path = self.0.join(file);
        let text = fs::read_to_string(&path).expect("a file of the copy");
        assert!(text.contains(from), "{file} has no `{from}`");
        fs::write(path, text.replace(from, to)).expect("a file of the copy");
    }
}

impl Drop for Copy {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// One test, since the copies share a target directory that Cargo locks anyhow.
#[test]
fn the_example_follows_its_shaders() {
    let run = cargo(Path::new(EXAMPLE), "run");
    assert!(run.status.success(), "{}", text(&run.stderr));
    // PointLight is 48 bytes in std140: 128 of them and an int, rounded up to 16.
    // mat4, mat3 of 3 × 16, vec3 and bool, float[3] of 16 each; then 16 and 5 × 32.
    golden().eq(
        text(&run.stdout),
        str![[r#"
lights: 6160 bytes
lights[0].position: bytes 0 to 11
lights[1].position: bytes 48 to 59
lights[2].position: bytes 96 to 107
camera: 176 bytes
particles: 176 bytes for 5

"#]],
    );
    assert_eq!(text(&run.stderr), "", "no warning of rustc's in the mirrors");

    members_that_change_places_keep_their_values();
    an_include_that_another_shadows_is_read_again();
    a_grown_structure_no_longer_compiles_with_the_old_call();
    a_broken_shader_is_shown_with_its_line();
    a_body_that_no_compiler_takes_is_shown_with_its_line();
    a_vanished_include_is_named();
}

/// The shader swaps two members of one type: the program, which finds every value at the place that
/// the table gives, runs as it is.
fn members_that_change_places_keep_their_values() {
    let copy = Copy::new("swapped");
    let light = "shaders/include/light.glsl";
    copy.edit(light, "vec3 position;", "vec3 first;");
    copy.edit(light, "vec3 color;", "vec3 position;");
    copy.edit(light, "vec3 first;", "vec3 color;");
    let run = cargo(&copy.0, "run");
    assert!(run.status.success(), "{}", text(&run.stderr));
    golden().eq(
        text(&run.stdout),
        str![[r#"
lights: 6160 bytes
lights[0].position: bytes 16 to 27
lights[1].position: bytes 64 to 75
lights[2].position: bytes 112 to 123
camera: 176 bytes
particles: 176 bytes for 5

"#]],
    );
}

/// A new file is found before the one that was included: the mirrors follow it.
fn an_include_that_another_shadows_is_read_again() {
    let copy = Copy::new("shadowed");
    // The shader itself uses the member as well.
    copy.edit("build.rs", ".define(", ".unchecked_bodies([\"lights.frag\"])\n        .define(");
    assert!(cargo(&copy.0, "build").status.success());
    let light = copy.0.join("shaders/include/light.glsl");
    let text =
        fs::read_to_string(light).expect("the include").replace("float range", "float reach");
    fs::write(copy.0.join("shaders/light.glsl"), text).expect("a file of the copy");
    let told = text_of_failure(&copy);
    assert!(told.contains("has no field named `range`"), "{told}");
}

/// What the compiler says to a copy that no longer compiles.
fn text_of_failure(copy: &Copy) -> String {
    let build = cargo(&copy.0, "build");
    assert!(!build.status.success());
    text(&build.stderr)
}

/// The shader's structure gains a member: the Rust code that builds it is told at compile time.
fn a_grown_structure_no_longer_compiles_with_the_old_call() {
    let copy = Copy::new("grown");
    copy.edit("shaders/include/light.glsl", "float range;", "float range; vec2 spot;");
    let build = cargo(&copy.0, "build");
    let told = text(&build.stderr);
    assert!(!build.status.success());
    assert!(
        told.contains("missing field `spot` in initializer of `lights_frag::PointLightInit`"),
        "{told}"
    );
}

/// What landfall says in the output of a build that failed, the last of it.
fn landfalls(told: &str) -> &str {
    told.find("landfall failed").map_or(told, |at| &told[at..])
}

fn a_broken_shader_is_shown_with_its_line() {
    let copy = Copy::new("broken");
    copy.edit("shaders/include/light.glsl", "vec3 color;", "vec5 color;");
    copy.edit("shaders/particles.comp", "uint alive;", "uint alive[0];");
    let build = cargo(&copy.0, "build");
    let told = text(&build.stderr);
    assert!(!build.status.success());
    golden().eq(
        landfalls(&told),
        str![[r#"
landfall failed

  error[unknown-type]: unknown type `vec5`
   --> shaders/include/light.glsl:4:5
    |
  4 |     vec5 color;    // linear
    |     ^^^^
    |
    = help: did you mean `vec2`?

  error[array-size]: array `alive` has size 0, but an array has at least 1 element
    --> shaders/particles.comp:12:16
     |
  12 |     uint alive[0];
     |                ^

"#]],
    );
    for part in [
        // A new file in either folder may be found before the included one.
        "cargo::rerun-if-changed=shaders\n",
        "cargo::rerun-if-changed=shaders/include\n",
        "cargo::rerun-if-changed=shaders/include/light.glsl",
        "cargo::rerun-if-changed=shaders/lights.frag",
    ] {
        assert!(told.contains(part), "`{part}` is missing from\n{told}");
    }
    assert!(!told.contains("panicked"), "{told}");
}

fn a_body_that_no_compiler_takes_is_shown_with_its_line() {
    let copy = Copy::new("body");
    copy.edit("shaders/lights.frag", "lights[i].color *", "lights[i].colour *");
    copy.edit("shaders/lights.frag", "camera.normals * sum", "camera.normals * total");
    copy.edit("shaders/particles.comp", "void main() {", "void main() {\n    alive + ;");
    let build = cargo(&copy.0, "build");
    assert!(!build.status.success());
    golden().eq(
        landfalls(&text(&build.stderr)),
        str![[r#"
landfall failed

  error[unknown-member]: `PointLight` has no member `colour`
    --> shaders/lights.frag:31:32
     |
  31 |         sum += scene.lights[i].colour * scene.lights[i].intensity * window * window;
     |                                ^^^^^^
     |
     = note: `Build::unchecked_bodies(["shaders/lights.frag"])` takes the shader as it is
     = help: did you mean `color`?

  error[unknown-name]: `total` is not declared
    --> shaders/lights.frag:33:35
     |
  33 |     color = vec4(camera.normals * total + camera.eye * camera.fog_density[0], 1.0);
     |                                   ^^^^^
     |
     = note: `Build::unchecked_bodies(["shaders/lights.frag"])` takes the shader as it is

  error[syntax]: expected an expression, found `;`
    --> shaders/particles.comp:17:13
     |
  17 |     alive + ;
     |             ^
     |
     = note: `Build::unchecked_bodies(["shaders/particles.comp"])` takes the shader as it is

"#]],
    );
    // Named, they are taken as they are.
    let both = ".unchecked_bodies([\"lights.frag\", \"shaders/particles.comp\"])";
    copy.edit("build.rs", ".define(", &format!("{both}\n        .define("));
    let build = cargo(&copy.0, "build");
    assert!(build.status.success(), "{}", text(&build.stderr));
}

fn a_vanished_include_is_named() {
    let copy = Copy::new("vanished");
    fs::remove_file(copy.0.join("shaders/include/light.glsl")).expect("the include");
    fs::remove_file(copy.0.join("shaders/particles.comp")).expect("a shader");
    let told = text(&cargo(&copy.0, "build").stderr);
    golden().eq(
        landfalls(&told),
        str![[r#"
landfall failed

  error[missing-include]: `light.glsl` not found
   --> shaders/lights.frag:3:2
    |
  3 | #include "light.glsl"
    |  ^^^^^^^^^^^^^^^^^^^^
    |
    = note: looked for `shaders/light.glsl`
    = note: looked for `shaders/include/light.glsl`
    = help: pass its directory with `Build::include("DIR")`

  error[unknown-type]: unknown type `PointLight`
    --> shaders/lights.frag:10:5
     |
  10 |     PointLight lights[MAX_LIGHTS];
     |     ^^^^^^^^^^
     |
     = help: an include that is not found may declare it

  error[unreadable-file]: `shaders/particles.comp` cannot be read: no such file or directory

"#]],
    );
}

/// Shaders in a directory of its own, removed at the end.
struct Shaders(PathBuf);

impl Drop for Shaders {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

impl Shaders {
    fn new(name: &str, files: &[&str]) -> Shaders {
        let dir =
            std::env::temp_dir().join(format!("landfall-found-{name}-{}", std::process::id()));
        for (number, file) in files.iter().enumerate() {
            let path = dir.join(file);
            fs::create_dir_all(path.parent().expect("below it")).expect("a directory");
            let text = format!(
                "#version 450\nlayout(std140, binding = 0) uniform Block{number} {{ vec4 a; }};\n\
                 void main() {{}}\n"
            );
            fs::write(path, text).expect("a shader");
        }
        Shaders(dir)
    }

    fn generated(&self, named: &[&str]) -> Result<String, String> {
        let build = named.iter().fold(Build::new(), |build, name| build.shader(self.0.join(name)));
        build.generate_string().map_err(|error| error.to_string())
    }
}

#[test]
fn a_directory_or_a_glob_stands_for_its_shaders() {
    let files =
        ["s/b.frag", "s/a.vert", "s/deep/c.frag", "s/.hidden/d.frag", "s/.e.frag", "s/notes.txt"];
    let place = Shaders::new("all", &files);
    std::os::unix::fs::symlink(&place.0, place.0.join("s/deep/back")).expect("a link");
    let all = place.generated(&["s"]).expect("generated");
    assert_eq!(Ok(&all), place.generated(&["s/a.vert", "s/b.frag", "s/deep/c.frag"]).as_ref());
    for block in ["Block0", "Block1", "Block2"] {
        assert!(all.contains(&format!("pub struct {block}")), "{all}");
    }
    assert_eq!(place.generated(&["s/*.frag"]), place.generated(&["s/b.frag"]));
    assert_eq!(
        place.generated(&["s/**/*.{frag,vert}"]),
        place.generated(&["s/a.vert", "s/b.frag", "s/deep/c.frag"])
    );
    // A file that a search finds beside shaders, and that is none.
    fs::write(place.0.join("s/Program.cs"), "using System;\nclass Program { }\n").expect("a file");
    fs::write(place.0.join("s/t.frag"), "#version 450\nfloat a[{{ count }}];\n").expect("a file");
    assert_eq!(place.generated(&["s"]).as_ref(), Ok(&all));
    assert!(place.generated(&["s/t.frag"]).is_err_and(|error| error.contains("template")));
}

#[test]
fn a_search_that_finds_nothing_is_an_error() {
    let place = Shaders::new("none", &["s/notes.txt"]);
    for (named, said) in [
        ("s", "contains no shader file"),
        ("s/*.frag", "matches no shader file"),
        ("t/*.frag", "cannot be searched"),
        ("s/[a", "is not a glob"),
    ] {
        let error = place.generated(&[named]).expect_err(named);
        assert!(error.contains(said), "{named}: {error}");
    }
}
