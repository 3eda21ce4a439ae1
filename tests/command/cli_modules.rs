//! Shaders of several modules in the commands: findings at the line of the module's file, locks,
//! revisions, generated code, and bodies that run.

use snapbox::str;

use crate::support::command::Place;

const MAIN: &str = "import package::lights::{Lights, shade};
@group(0) @binding(0) var<uniform> lights: Lights;
@fragment fn main(@location(0) at: vec3f) -> @location(0) vec4f {
    return vec4f(shade(lights, at), 1.0);
}
";

const LIGHTS: &str = "import super::constants_of_scene::COUNT;
struct Light { position: vec3f, range: f32, color: vec3f, @if(COOKIES) cookie: u32 }
struct Lights { all: array<Light, COUNT>, count: u32 }
fn shade(lights: Lights, at: vec3f) -> vec3f {
    var sum = vec3f(0.0);
    for (var i = 0u; i < lights.count; i++) {
        let path = lights.all[i].position - at;
        sum += lights.all[i].color * max(1.0 - length(path) / lights.all[i].range, 0.0);
    }
    return sum;
}
";

fn project(name: &str) -> Place {
    let place = Place::new(&format!("modules-{name}"));
    place.write("landfall.toml", "paths = [\"src\"]\npermutations = [[\"COOKIES\"]]\n");
    place.write("src/main.wesl", MAIN).write("src/lights.wesl", LIGHTS);
    place.write("src/constants_of_scene.wesl", "const COUNT = 4u;\n");
    place
}

/// A light is 28 bytes, by its alignment 32; the count follows four of them.
#[test]
fn a_block_of_modules_is_laid_out_and_generated() {
    let place = project("layout");
    place.run(&["layout", "src/main.wesl"]).code(0).stdout_eq(str![[r#"
src/main.wesl without COOKIES

uniform Lights lights · wgsl · @group(0) @binding(0) · 144 bytes
  offset  size  align  stride  type       name
       0   128     16      32  Light      all[4]
       0    12     16      32  vec3<f32>    position
      12     4      4      32  f32          range
      16    12     16      32  vec3<f32>    color
      28     4             32               -- tail padding of Light
     128     4      4          u32        count
     132    12                            -- tail padding
  144 bytes: 116 used, 28 padding (19.4 %)
  offsets are those of element 0; element i lies i × stride further

src/main.wesl with COOKIES

uniform Lights lights · wgsl · @group(0) @binding(0) · 144 bytes
  offset  size  align  stride  type       name
       0   128     16      32  Light      all[4]
       0    12     16      32  vec3<f32>    position
      12     4      4      32  f32          range
      16    12     16      32  vec3<f32>    color
      28     4      4      32  u32          cookie
     128     4      4          u32        count
     132    12                            -- tail padding
  144 bytes: 132 used, 12 padding (8.3 %)
  offsets are those of element 0; element i lies i × stride further

"#]]);
    let places = |define| {
        place
            .run(&["layout", "src/main.wesl", "--no-config", "--define", define])
            .code(0)
            .out
            .contains("cookie")
    };
    assert_eq!(["COOKIES", "COOKIES=false"].map(places), [true, false]);
    let rust = place.run(&["emit", "--lang", "rust", "src/main.wesl"]);
    assert!(rust.code == 0 && rust.out.contains("pub struct Light {"), "{}", rust.err);
}

#[test]
fn a_module_that_changes_is_found_by_the_lock_and_at_a_revision() {
    let place = project("lock");
    assert_eq!(place.run(&["lock"]).code, 0);
    place.commit();
    assert_eq!(place.run(&["check"]).code, 0);
    place.write("src/constants_of_scene.wesl", "const COUNT = 8u;\n");
    let ran = place.run(&["check"]);
    assert!(ran.code == 1 && ran.out.contains("grew from 4 to 8 elements"), "{}", ran.out);
    let ran = place.run(&["diff", "--rev", "HEAD", "src/main.wesl"]);
    assert!(ran.out.contains("grew from 4 to 8 elements"), "{} {}", ran.out, ran.err);
}

#[test]
fn what_is_wrong_stands_in_the_file_of_its_module() {
    let place = project("wrong");
    place.write("src/lights.wesl", LIGHTS.replace("range: f32", "range: f23"));
    place.run(&["layout", "src/main.wesl"]).code(2).stderr_eq(str![[r#"
error[unknown-type]: unknown type `f23`
 --> src/lights.wesl:2:40
  |
2 | struct Light { position: vec3f, range: f23, color: vec3f, @if(COOKIES) cookie: u32 }
  |                                        ^^^


"#]]);
    place.write("src/lights.wesl", LIGHTS.replace("sum +=", "sun +="));
    let quiet = ["-A", "lock-missing", "-A", "define-changes-layout"];
    place.run(&[&["check", "src/main.wesl"][..], &quiet].concat()).code(1).stdout_eq(str![[r#"
error[invalid-shader]: `sun` is not declared
 --> src/lights.wesl:8:9
  |
8 |         sun += lights.all[i].color * max(1.0 - length(path) / lights.all[i].range, 0.0);
  |         ^^^
  |
  = help: did you mean `sum`?

"#]]);
}

#[test]
fn bodies_of_modules_run_and_their_reads_are_verified() {
    let place = project("run");
    let ran = place.run(&["verify", "--backend", "cpu,gpu", "src/main.wesl"]);
    assert!(ran.code == 0 && ran.err.contains("every byte lands"), "{} {}", ran.out, ran.err);
    let light = r#"{"position": [0, 0, 0], "range": 4, "color": [1, 0, 0.5]}"#;
    let data = format!(r#"{{"lights": {{"count": 1, "all": [{light}]}}}}"#);
    let arguments = ["--fn", "main", "--args", "[[1, 0, 0]]", "--data", &data];
    let ran = place.run(&[&["run", "src/main.wesl"][..], &arguments].concat());
    // At a quarter of the range, three quarters of the colour are left.
    assert!(ran.code == 0 && ran.out.contains("result.z  0.375  0.375"), "{} {}", ran.out, ran.err);
}

/// Names in functions mean what they mean in their own module, whatever the others are called: a local
/// name beside the constant of an import, a function that hides a predeclared one, and one with an
/// entry's name.
#[test]
fn names_of_functions_mean_what_their_module_says() {
    let place = Place::new("modules-names");
    let main = "import package::a::SIZE as N;
        fn size() -> f32 { let SIZE = 3.0; return SIZE * 100.0 + N; }
        fn path() -> f32 { let other = 1.0; let SIZE = 2.0; return package::a::other() + other + SIZE; }
        fn shown() -> f32 { return saturate(7.0) + package::a::own(); }
        fn helper() -> f32 { return 1000.0; }
        fn both() -> f32 { return helper() + package::a::helped(); }
        fn sign(x: f32) -> f32 { return 50.0 * x; }
        fn mixed() -> f32 { return sign(2.0) + package::a::negative(); }
";
    let a = "const SIZE = 4.0;
        fn other() -> f32 { return 40.0; }
        fn saturate(x: f32) -> f32 { return 10.0 * x; }
        fn own() -> f32 { return saturate(7.0); }
        fn helper() -> f32 { return 5.0; }
        fn helped() -> f32 { return helper(); }
        fn negative() -> f32 { return sign(-9.0); }
";
    place.write("main.wesl", main).write("a.wesl", a);
    for (function, value) in [
        ("size", "304.0"),
        ("path", "43.0"),
        ("shown", "71.0"),
        ("both", "1005.0"),
        ("mixed", "99.0"),
    ] {
        let ran = place.run(&["run", "main.wesl", "--fn", function, "--args", "[]"]);
        let row = format!("  result  {value}");
        assert!(ran.code == 0 && ran.out.contains(&row), "{function} {} {}", ran.out, ran.err);
    }
}
