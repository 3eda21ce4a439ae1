//! `landfall diff` as it is run: shaders, locks, directories and git revisions; the three forms;
//! the exit codes.

use std::fs;
use std::process::Command;

use snapbox::str;

use crate::support::command::{Place, Ran};

const OLD: &str = "#version 420 core
struct Light { vec3 pos; vec3 color; };
layout(std140) uniform Lights {
    Light all[2];
    float gamma;
};
void main() {}
";

/// Both sides of a change, compared.
fn change(tree: &Place, from: &str, to: &str) -> Ran {
    assert!(OLD.contains(from));
    tree.write("old.frag", OLD).write("new.frag", OLD.replacen(from, to, 1));
    let ran = tree.run(&["diff", "old.frag", "new.frag"]);
    assert_eq!(ran.err, "");
    ran
}

/// Offsets by hand from OpenGL 4.6 §7.6.2.2: `Light` is 32 bytes, `gamma` at 64, the block 80.
#[test]
fn each_change_has_a_line_of_its_own_and_a_class() {
    let tree = Place::new("diff-words");
    for (from, to, said) in [
        (
            "float gamma;",
            "vec4 first; float gamma;",
            str![[r#"
new.frag: Lights: breaking
  breaking   `gamma` moved from 64 to 80  [Lights::gamma]
  breaking   `first` (`vec4`) is inserted at 64, where old uploads have `gamma`
             [Lights::first]
  compatible grew from 80 to 96 bytes: make its buffer 96 bytes

     80  uniform Lights std140    |    96  uniform Lights std140
   0 64    Light all[2] stride 32    0 64    Light all[2] stride 32
   0 12      vec3 pos                0 12      vec3 pos
  …
  16 12      vec3 color             16 12      vec3 color
  28  4      -- tail padding        28  4      -- tail padding
                                  > 64 16    vec4 first
  64  4    float gamma            | 80  4    float gamma
  68 12    -- tail padding        | 84 12    -- tail padding

1 block changed: 1 breaking

"#]],
        ),
        (
            "float gamma;",
            "int gamma;",
            str![[r#"
new.frag: Lights: breaking
  breaking   `gamma` changed from `float` to `int`  [Lights::gamma]

  …
  16 12      vec3 color             16 12      vec3 color
  28  4      -- tail padding        28  4      -- tail padding
  64  4    float gamma            | 64  4    int gamma
  68 12    -- tail padding          68 12    -- tail padding

1 block changed: 1 breaking

"#]],
        ),
        (
            "float gamma;",
            "float gain;",
            str![[r#"
new.frag: Lights: cosmetic
  cosmetic   `gamma` was renamed to `gain`, in the same place  [Lights::gamma]

  …
  16 12      vec3 color             16 12      vec3 color
  28  4      -- tail padding        28  4      -- tail padding
  64  4    float gamma            | 64  4    float gain
  68 12    -- tail padding        | 68 12    -- tail padding

1 block changed: 1 cosmetic

"#]],
        ),
        (
            "vec3 pos;",
            "vec3 at;",
            str![[r#"
new.frag: Lights: cosmetic
  cosmetic   `all[].pos` was renamed to `at`, in the same place  [Light::pos]

     80  uniform Lights std140         80  uniform Lights std140
   0 64    Light all[2] stride 32    0 64    Light all[2] stride 32
   0 12      vec3 pos             |  0 12      vec3 at
  12  4      -- hole              | 12  4      -- hole
  16 12      vec3 color             16 12      vec3 color
  28  4      -- tail padding        28  4      -- tail padding

1 block changed: 1 cosmetic

"#]],
        ),
        (
            "vec3 pos;",
            "vec3 pos; float range;",
            str![[r#"
new.frag: Lights: compatible
  compatible `all[].range` (`float`) uses former padding at 12  [Light::range]

  …
   0 64    Light all[2] stride 32    0 64    Light all[2] stride 32
   0 12      vec3 pos                0 12      vec3 pos
  12  4      -- hole              | 12  4      float range
  16 12      vec3 color             16 12      vec3 color
  28  4      -- tail padding        28  4      -- tail padding

1 block changed: 1 compatible

"#]],
        ),
        (
            "float gamma;",
            "float gamma; vec4 more;",
            str![[r#"
new.frag: Lights: compatible
  compatible `more` (`vec4`) is appended at 80  [Lights::more]
  compatible grew from 80 to 96 bytes: make its buffer 96 bytes

     80  uniform Lights std140    |    96  uniform Lights std140
   0 64    Light all[2] stride 32    0 64    Light all[2] stride 32
   0 12      vec3 pos                0 12      vec3 pos
  …
  28  4      -- tail padding        28  4      -- tail padding
  64  4    float gamma              64  4    float gamma
  68 12    -- tail padding        | 68 12    -- hole
                                  > 80 16    vec4 more

1 block changed: 1 compatible

"#]],
        ),
        (
            "    float gamma;\n",
            "",
            str![[r#"
new.frag: Lights: breaking
  breaking   `gamma` (`float` at 64) was removed  [Lights::gamma]
  compatible shrank from 80 to 64 bytes

     80  uniform Lights std140    |    64  uniform Lights std140
   0 64    Light all[2] stride 32    0 64    Light all[2] stride 32
   0 12      vec3 pos                0 12      vec3 pos
  …
  16 12      vec3 color             16 12      vec3 color
  28  4      -- tail padding        28  4      -- tail padding
  64  4    float gamma            <
  68 12    -- tail padding        <

1 block changed: 1 breaking

"#]],
        ),
        (
            "Light all[2];",
            "Light all[3];",
            str![[r#"
new.frag: Lights: breaking
  breaking   `all` grew from 2 to 3 elements, the new ones where old uploads
             have `gamma`  [Lights::all]
  breaking   `gamma` moved from 64 to 96  [Lights::gamma]
  compatible grew from 80 to 112 bytes: make its buffer 112 bytes

       80  uniform Lights std140    |     112  uniform Lights std140
    0  64    Light all[2] stride 32 |   0  96    Light all[3] stride 32
    0  12      vec3 pos                 0  12      vec3 pos
   12   4      -- hole                 12   4      -- hole
   16  12      vec3 color              16  12      vec3 color
   28   4      -- tail padding         28   4      -- tail padding
   64   4    float gamma            |  96   4    float gamma
   68  12    -- tail padding        | 100  12    -- tail padding

1 block changed: 1 breaking

"#]],
        ),
        (
            "Light all[2];",
            "Light all[1];",
            str![[r#"
new.frag: Lights: breaking
  breaking   `all` shrank from 2 to 1 elements: the last were removed
             [Lights::all]
  breaking   `gamma` moved from 64 to 32  [Lights::gamma]
  compatible shrank from 80 to 48 bytes

     80  uniform Lights std140    |    48  uniform Lights std140
   0 64    Light all[2] stride 32 |  0 32    Light all[1] stride 32
   0 12      vec3 pos                0 12      vec3 pos
  12  4      -- hole                12  4      -- hole
  16 12      vec3 color             16 12      vec3 color
  28  4      -- tail padding        28  4      -- tail padding
  64  4    float gamma            | 32  4    float gamma
  68 12    -- tail padding        | 36 12    -- tail padding

1 block changed: 1 breaking

"#]],
        ),
        (
            "vec3 pos; vec3 color;",
            "vec3 pos; vec3 color; float a, b;",
            str![[r#"
new.frag: Lights: breaking
  breaking   `all` changed its array stride from 32 to 48  [Lights::all]
  breaking   `all[].b` (`float`) is inserted at 32, where old uploads have
             `all[1].pos`  [Light::b]
  breaking   `gamma` moved from 64 to 96  [Lights::gamma]
  compatible `all[].a` (`float`) uses former padding at 28  [Light::a]
  compatible grew from 80 to 112 bytes: make its buffer 112 bytes

       80  uniform Lights std140    |     112  uniform Lights std140
    0  64    Light all[2] stride 32 |   0  96    Light all[2] stride 48
    0  12      vec3 pos                 0  12      vec3 pos
   12   4      -- hole                 12   4      -- hole
   16  12      vec3 color              16  12      vec3 color
   28   4      -- tail padding      |  28   4      float a
                                    >  32   4      float b
                                    >  36  12      -- tail padding
   64   4    float gamma            |  96   4    float gamma
   68  12    -- tail padding        | 100  12    -- tail padding

1 block changed: 1 breaking

"#]],
        ),
        (
            "uniform Lights {",
            "uniform Lamps {",
            str![[r#"
new.frag: Lamps: cosmetic
  cosmetic   block `Lights` was renamed to `Lamps`

     80  uniform Lights std140    |    80  uniform Lamps std140
   0 64    Light all[2] stride 32    0 64    Light all[2] stride 32
   0 12      vec3 pos                0 12      vec3 pos

1 block changed: 1 cosmetic

"#]],
        ),
        (
            "float gamma;",
            "float gamma[1];",
            str![[r#"
new.frag: Lights: cosmetic
  cosmetic   `gamma` is now `float[1]`, was `float`: its elements stay in place
             [Lights::gamma]

  …
  16 12      vec3 color             16 12      vec3 color
  28  4      -- tail padding        28  4      -- tail padding
  64  4    float gamma            | 64 16    float gamma[1] stride 16
  68 12    -- tail padding        <

1 block changed: 1 cosmetic

"#]],
        ),
        (
            "layout(std140)",
            "layout(std140, binding = 3)",
            str![[r#"
new.frag: Lights: compatible
  compatible binding 3 is now declared; before, the host chose it

     80  uniform Lights std140    |    80  uniform Lights std140 binding 3
   0 64    Light all[2] stride 32    0 64    Light all[2] stride 32
   0 12      vec3 pos                0 12      vec3 pos

1 block changed: 1 compatible

"#]],
        ),
    ] {
        change(&tree, from, to).code(1).stdout_eq(said);
    }
    let same = change(&tree, "float gamma;", "float gamma; // comments are no layout");
    same.code(0).stdout_eq(str![[r#"
no layout changed

"#]]);
}

#[test]
fn std430_on_the_same_members_says_rules_and_what_moved() {
    let tree = Place::new("diff-rules");
    tree.write(
        "a.comp",
        "#version 450\nlayout(std140) buffer B { float w[4]; vec4 v; };\nvoid main() {}\n",
    );
    tree.write(
        "b.comp",
        "#version 450\nlayout(std430) buffer B { float w[4]; vec4 v; };\nvoid main() {}\n",
    );
    let ran = tree.run(&["diff", "a.comp", "b.comp"]);
    ran.code(1).stdout_eq(str![[r#"
b.comp: B: breaking
  breaking   `w` changed its array stride from 16 to 4  [B::w]
  breaking   `v` moved from 64 to 16  [B::v]
  compatible shrank from 80 to 32 bytes
  cosmetic   rules changed from std140 to std430

     80  storage B std140       |    32  storage B std430
   0 64    float w[4] stride 16 |  0 16    float w[4] stride 4
  64 16    vec4 v               | 16 16    vec4 v

1 block changed: 1 breaking

"#]]);
}

#[test]
fn majorness_and_matrix_stride_are_told_apart() {
    let tree = Place::new("diff-matrix");
    let text = |layout: &str, rules: &str| {
        format!(
            "#version 450\nlayout({rules}) buffer B {{ {layout} mat2x3 m; }};\nvoid main() {{}}\n"
        )
    };
    tree.write("a.comp", text("", "std430"));
    tree.write("b.comp", text("layout(row_major)", "std430"));
    let ran = tree.run(&["diff", "a.comp", "b.comp"]);
    ran.stdout_eq(str![[r#"
b.comp: B: breaking
  breaking   `m` is stored by rows, was by columns  [B::m]
  breaking   `m` changed its matrix stride from 16 to 8  [B::m]
  compatible shrank from 32 to 24 bytes

    32  storage B std430      |   24  storage B std430
  0 32    mat2x3 m columns 16 | 0 24    mat2x3 m rows 8

1 block changed: 1 breaking

"#]]);
}

#[test]
fn both_listings_stand_beside_each_other_if_there_is_room() {
    let tree = Place::new("diff-beside");
    let ran = change(&tree, "float gamma;", "vec4 first; float gamma;");
    assert!(ran.out.lines().all(|line| line.chars().count() <= 100));
    assert!(!ran.out.contains('\u{1b}'));
    let narrow = tree.run(&["diff", "old.frag", "new.frag", "--width", "40"]);
    narrow.code(1).stderr_eq("").stdout_eq(str![[r#"
new.frag: Lights: breaking
  breaking   `gamma` moved from 64 to 80  [Lights::gamma]
  breaking   `first` (`vec4`) is inserted at 64, where old uploads have `gamma`
             [Lights::first]
  compatible grew from 80 to 96 bytes: make its buffer 96 bytes

  -    80  uniform Lights std140
  +    96  uniform Lights std140
     0 64    Light all[2] stride 32
     0 12      vec3 pos
    …
    16 12      vec3 color
    28  4      -- tail padding
  - 64  4    float gamma
  - 68 12    -- tail padding
  + 64 16    vec4 first
  + 80  4    float gamma
  + 84 12    -- tail padding

1 block changed: 1 breaking

"#]]);
    let colour = tree.run(&["diff", "old.frag", "new.frag", "--color", "always"]).out;
    assert!(colour.contains("\u{1b}[31m"), "{colour}");
}

#[test]
fn only_breaking_changes_fail_when_asked() {
    let tree = Place::new("diff-exit");
    change(&tree, "float gamma;", "float gamma; vec4 more;");
    assert_eq!(tree.run(&["diff", "old.frag", "new.frag"]).code, 1);
    assert_eq!(tree.run(&["diff", "old.frag", "new.frag", "--breaking"]).code, 0);
    assert_eq!(tree.run(&["diff", "new.frag", "old.frag", "--breaking"]).code, 1);
    let ran = tree.run(&["diff", "old.frag"]);
    ran.code(2).stderr_eq(str![[r#"
error[cannot-run]: `landfall diff` needs 2 sides to compare, not 1
  |
  = help: `landfall diff OLD NEW`, or `landfall diff --rev HEAD~1 [PATH…]`


"#]]);
    let ran = tree.run(&["diff", "old.frag", "gone.frag"]);
    ran.code(2).stderr_eq(str![[r#"
error[cannot-run]: `gone.frag` does not exist
  |
  = help: name a shader, a lock, a directory or a git REVISION:PATH


"#]]);
    tree.write("bad.frag", "uniform B { float");
    assert_eq!(tree.run(&["diff", "old.frag", "bad.frag"]).code, 2);
}

#[test]
fn a_lock_is_compared_like_the_shader_it_was_written_from_and_renewed() {
    let tree = Place::new("diff-accept");
    tree.write("shaders/a.frag", OLD);
    assert_eq!(tree.run(&["lock", "shaders"]).code, 0);
    let lock = "layouts/shaders/a.frag.json";
    assert_eq!(tree.run(&["diff", lock, "shaders/a.frag"]).code, 0);
    assert_eq!(tree.run(&["diff", "layouts", "shaders"]).code, 0);
    tree.write("shaders/a.frag", OLD.replace("gamma", "gain"));
    let ran = tree.run(&["diff", lock, "shaders/a.frag"]);
    ran.code(1).stdout_eq(str![[r#"
shaders/a.frag: Lights: cosmetic
  cosmetic   `gamma` was renamed to `gain`, in the same place  [Lights::gamma]

  …
  16 12      vec3 color             16 12      vec3 color
  28  4      -- tail padding        28  4      -- tail padding
  64  4    float gamma            | 64  4    float gain
  68 12    -- tail padding        | 68 12    -- tail padding

1 block changed: 1 cosmetic

"#]]);
    // Either way round: the lock is what is renewed.
    for sides in [[lock, "shaders/a.frag"], ["shaders/a.frag", lock], ["layouts", "shaders"]] {
        tree.write(lock, tree.read(lock).replace("gain", "gamma"));
        let ran = tree.run(&["diff", sides[0], sides[1], "--accept"]);
        ran.code(0).stderr_eq(str![[r#"
updated layouts/shaders/a.frag.json

"#]]);
        assert_eq!(tree.run(&["lock", "shaders", "--check"]).code, 0);
    }
    // What was compared is told all the same.
    let ran = tree.run(&["diff", "shaders/a.frag", "shaders/a.frag", "--accept"]);
    ran.code(2).stdout_eq("no layout changed\n").stderr_eq(str![[r#"
error[cannot-run]: `--accept` has no lock to update: neither side is a lock
  |
  = help: write the locks of shaders with `landfall lock`


"#]]);
    // The output of `layout` is read as well.
    let json = tree.run(&["layout", "shaders", "--format", "json"]).out;
    tree.write("all.json", &json);
    assert_eq!(tree.run(&["diff", "all.json", "shaders/a.frag"]).code, 0);
}

#[test]
fn directories_are_compared_shader_by_shader() {
    let tree = Place::new("diff-folders");
    tree.write("one/a.frag", OLD);
    tree.write("one/gone.frag", OLD.replace("Lights", "Gone"));
    tree.write("two/a.frag", OLD);
    tree.write("two/new/b.frag", OLD.replace("Lights", "Fresh"));
    let ran = tree.run(&["diff", "one", "two"]);
    ran.code(1).stdout_eq(str![[r#"
two/new/b.frag: Fresh: compatible
  compatible block `Fresh` is new, 80 bytes

   >    80  uniform Fresh std140
   >  0 64    Light all[2] stride 32
   >  0 12      vec3 pos
   > 12  4      -- hole
   > 16 12      vec3 color
   > 28  4      -- tail padding
   > 64  4    float gamma
   > 68 12    -- tail padding

one/gone.frag: Gone: breaking
  breaking   block `Gone` was removed

     80  uniform Gone std140      <
   0 64    Light all[2] stride 32 <
   0 12      vec3 pos             <
  12  4      -- hole              <
  16 12      vec3 color           <
  28  4      -- tail padding      <
  64  4    float gamma            <
  68 12    -- tail padding        <

2 blocks changed: 1 breaking, 1 compatible

"#]]);
    let ran = tree.run(&["diff", "one", "two/a.frag"]);
    ran.code(2).stderr_eq(str![[r#"
error[cannot-run]: `two/a.frag` is one shader, but the other side is a directory
  |
  = help: compare a file with a file, a directory with a directory


"#]]);
}

#[test]
fn blocks_of_a_shader_that_cannot_be_read_are_not_removed_or_new() {
    let tree = Place::new("diff-broken");
    tree.write("old.frag", OLD);
    tree.write("new.frag", OLD.replace("float gamma;", "float gamma"));
    for sides in [["old.frag", "new.frag"], ["new.frag", "old.frag"]] {
        let ran = tree.run(&["diff", sides[0], sides[1]]);
        ran.code(2).stdout_eq("nothing was compared\n");
        assert!(ran.err.contains("`;`") && ran.err.contains("new.frag:6:1"), "{}", ran.err);
        let ran = tree.run(&["diff", sides[0], sides[1], "--format", "json"]);
        assert_eq!(ran.code(2).json()["shaders"], serde_json::json!([]));
    }
}

#[test]
fn revisions_are_read_as_git_spells_them_with_their_includes() {
    let tree = Place::new("diff-git");
    let shader = "#version 450\n#include \"common/light.glsl\"\n\
                  layout(std140) uniform Lights { Light all[2]; float gamma; };\nvoid main() {}\n";
    tree.write("shaders/a.frag", shader);
    tree.write("shaders/common/light.glsl", "struct Light { vec3 pos; };\n");
    tree.run(&["lock", "shaders"]);
    tree.commit();
    tree.write("shaders/common/light.glsl", "struct Light { vec3 pos; vec3 color; };\n");
    tree.write("shaders/b.frag", OLD);
    // The include of that revision, not the one in the work tree: the stride was 16.
    for arguments in [
        &["diff", "HEAD:shaders/a.frag", "shaders/a.frag"][..],
        &["diff", "HEAD:layouts/shaders/a.frag.json", "shaders/a.frag"],
        &["diff", "--rev", "HEAD", "shaders/a.frag"],
    ] {
        tree.run(arguments).code(1).stderr_eq("").stdout_eq(str![[r#"
shaders/a.frag: Lights: breaking
  breaking   `all` changed its array stride from 16 to 32  [Lights::all]
  breaking   `all[].color` (`vec3`) is inserted at 16, where old uploads have
             `all[1].pos`  [Light::color]
  breaking   `gamma` moved from 32 to 64  [Lights::gamma]
  compatible grew from 48 to 80 bytes: make its buffer 80 bytes

     48  uniform Lights std140    |    80  uniform Lights std140
   0 32    Light all[2] stride 16 |  0 64    Light all[2] stride 32
   0 12      vec3 pos                0 12      vec3 pos
  12  4      -- tail padding      | 12  4      -- hole
                                  > 16 12      vec3 color
                                  > 28  4      -- tail padding
  32  4    float gamma            | 64  4    float gamma
  36 12    -- tail padding        | 68 12    -- tail padding

1 block changed: 1 breaking

"#]]);
    }
    let mut all = String::new();
    for arguments in [
        &["diff", "HEAD:./shaders", "shaders"][..],
        &["diff", "HEAD:layouts", "shaders"],
        &["diff", "HEAD:layouts/shaders", "shaders"],
        &["diff", "layouts", "shaders"],
        &["diff", "--rev", "HEAD"],
        &["diff", "--rev", "HEAD", "shaders"],
    ] {
        let ran = tree.run(arguments);
        ran.code(1).stderr_eq("").stdout_eq(str![[r#"
shaders/a.frag: Lights: breaking
...
shaders/b.frag: Lights: compatible
  compatible block `Lights` is new, 80 bytes

   >    80  uniform Lights std140
   >  0 64    Light all[2] stride 32
   >  0 12      vec3 pos
   > 12  4      -- hole
   > 16 12      vec3 color
   > 28  4      -- tail padding
   > 64  4    float gamma
   > 68 12    -- tail padding

2 blocks changed: 1 breaking, 1 compatible

"#]]);
        all = ran.out;
    }
    tree.commit();
    assert_eq!(tree.run(&["diff", "--rev", "HEAD", "shaders"]).code, 0);
    let ran = tree.run(&["diff", "HEAD~1:shaders", "HEAD:shaders"]);
    assert_eq!(ran.code(1).out.replace("HEAD:", ""), all);
    let leftovers = fs::read_dir(std::env::temp_dir()).unwrap().flatten().filter(|entry| {
        let name = entry.file_name().to_string_lossy().into_owned();
        name.starts_with("landfall-") && entry.path().join("shaders/common/light.glsl").exists()
    });
    assert_eq!(leftovers.count(), 0);
}

#[test]
fn what_git_cannot_give_is_said_in_its_words() {
    let tree = Place::new("diff-git-bad");
    tree.write("a.frag", OLD);
    tree.commit();
    for (side, said) in [
        (
            "HEAD:b.frag",
            str![[r#"
error[cannot-run]: `HEAD:b.frag` does not exist at that revision
  |
  = help: `git ls-tree -r --name-only HEAD` lists its files


"#]],
        ),
        (
            "HEAD~7:a.frag",
            str![[r#"
error[cannot-run]: `HEAD~7:a.frag` cannot be read by git: not a valid object name HEAD~7


"#]],
        ),
        (
            "--help:a.frag",
            str![[r#"
error: unexpected argument '--help:a.frag' found

  tip: a similar argument exists: '--help'

Usage: landfall diff --help [A B]...

For more information, try '--help'.

"#]],
        ),
        (
            "HEAD:../../a.frag",
            str![[r#"
error[cannot-run]: `HEAD:../../a.frag` is outside the repository


"#]],
        ),
    ] {
        let ran = tree.run(&["diff", side, "a.frag"]);
        ran.code(2).stderr_eq(said);
    }
    tree.write("bad.frag", "#version 330\nuniform B { vec33 x; };\n");
    tree.commit();
    let ran = tree.run(&["diff", "HEAD:bad.frag", "a.frag"]);
    ran.code(2).stderr_eq(str![[r#"
error[unknown-type]: unknown type `vec33`
 --> HEAD:bad.frag:2:13
  |
2 | uniform B { vec33 x; };
  |             ^^^^^
  |
  = help: did you mean `vec3`?


"#]]);
}

#[test]
fn json_and_markdown_carry_the_same_changes() {
    let tree = Place::new("diff-forms");
    change(&tree, "float gamma;", "vec4 first; float gamma;");
    let ran = tree.run(&["diff", "old.frag", "new.frag", "--format", "json"]);
    let json = ran.code(1).json();
    assert_eq!(json["class"], "breaking");
    let change = &json["shaders"][0]["blocks"][0]["changes"][0];
    assert_eq!(change["kind"], "moved");
    assert_eq!((&change["old"], &change["new"]), (&"64".into(), &"80".into()));
    assert_eq!(change["rust"], "Lights::gamma");
    let ran = tree.run(&["diff", "old.frag", "new.frag", "--format", "md"]);
    ran.stdout_eq(str![[r#"
### Layouts: 1 block changed: 1 breaking

#### new.frag `Lights`: breaking

| class | change | Rust |
|---|---|---|
| breaking | `gamma` moved from 64 to 80 | `Lights::gamma` |
| breaking | `first` (`vec4`) is inserted at 64, where old uploads have `gamma` | `Lights::first` |
| compatible | grew from 80 to 96 bytes: make its buffer 96 bytes | `Lights` |

<details><summary>old and new listing</summary>

````diff
-    80  uniform Lights std140
+    96  uniform Lights std140
   0 64    Light all[2] stride 32
   0 12      vec3 pos
  …
  16 12      vec3 color
  28  4      -- tail padding
- 64  4    float gamma
- 68 12    -- tail padding
+ 64 16    vec4 first
+ 80  4    float gamma
+ 84 12    -- tail padding
````

</details>

"#]]);
}

#[test]
fn loose_uniforms_are_judged_by_their_names() {
    let tree = Place::new("diff-loose");
    let text = |uniforms: &str| format!("#version 330\n{uniforms}\nvoid main() {{}}\n");
    tree.write("a.frag", text("uniform vec3 eye; uniform float w[4]; uniform int n;"));
    tree.write("b.frag", text("uniform vec4 eye; uniform float w[2]; uniform int m;"));
    let ran = tree.run(&["diff", "a.frag", "b.frag"]);
    ran.code(1).stdout_eq(str![[r#"
b.frag: (loose uniforms): breaking
  breaking   `eye` changed from `vec3` to `vec4`
  breaking   `w[]` has fewer elements: `[2]`, was `[4]`
  breaking   `n` was removed: values set by that name have no effect
  compatible `m` (`int`) is new, and not set yet

  loose uniforms   loose uniforms
    vec3 eye     |   vec4 eye
    float w[4]   |   float w[2]
    int n        |   int m

1 block changed: 1 breaking

"#]]);
}

/// A killed process leaves the files of its revision; the next one removes them.
#[cfg(target_os = "linux")]
#[test]
fn files_of_killed_processes_are_removed() {
    let tree = Place::new("diff-swept");
    tree.write("a.frag", OLD);
    tree.commit();
    let mut ended = Command::new("true").spawn().expect("true runs");
    ended.wait().expect("it ends");
    let (dead, alive) = (ended.id(), std::process::id());
    let temporary = tree.0.join("tmp");
    let kept = [
        format!("landfall-diff-{alive}-0"),
        format!("landfall-diff-{dead}"),
        format!("landfall-diff-{dead}-x"),
        format!("my-landfall-diff-{dead}-0"),
    ];
    for name in kept.iter().chain([&format!("landfall-diff-{dead}-0")]) {
        tree.write(&format!("tmp/{name}/shaders/a.frag"), OLD);
    }
    let mut command = tree.command(&["diff", "--rev", "HEAD", "a.frag"]);
    Ran::of(command.env("TMPDIR", &temporary).output().unwrap()).code(0);
    let names = fs::read_dir(&temporary).unwrap().flatten();
    let mut names: Vec<String> =
        names.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    let mut kept = kept.to_vec();
    kept.sort();
    assert_eq!(names, kept);
}
