//! What is wrong with a scene is named at its place, and refused by its schema too where a
//! schema can see it.

use landfall::report::schema::SCENE_SCHEMA;
use landfall_layout::Severity::{Error, Warning};
use landfall_layout::{Diagnostic, Severity};
use serde_json::Value;

use crate::scene::{RIGHT, names, read_alone};
use crate::support::schema;

/// A change to the right scene and what is found then.
struct Wrong {
    /// What is replaced, and by what.
    change: [&'static str; 2],
    code: &'static str,
    severity: Severity,
    /// What the finding points at; the text says it once, or this is all of what was written
    /// instead. `{` behind a key: the brace that opens its object.
    at: &'static str,
    says: &'static str,
    /// Whether the schema sees it.
    schema: bool,
}

const fn wrong(
    change: [&'static str; 2],
    code: &'static str,
    at: &'static str,
    says: &'static str,
) -> Wrong {
    Wrong { change, code, severity: Error, at, says, schema: true }
}

impl Wrong {
    /// What takes comparing two values, or knowing what they are of.
    const fn beyond_schema(self) -> Wrong {
        Wrong { schema: false, ..self }
    }

    const fn warned(self) -> Wrong {
        Wrong { severity: Warning, schema: false, ..self }
    }
}

const WRONG: &[Wrong] = &[
    // Members.
    wrong(
        [r#""fov": 45"#, r#""fow": 45, "fov": 45"#],
        "unknown-member",
        r#""fow""#,
        "`fow` is not a member of `camera`; did you mean `fov`?",
    ),
    wrong(
        [r#""name": "right""#, r#""lihgts": {}"#],
        "unknown-member",
        r#""lihgts""#,
        "not a member of the scene; did you mean `lights`?",
    ),
    wrong(
        [r#""half_degrees""#, r#""fullness""#],
        "unknown-member",
        r#""fullness""#,
        "its members are `inner_degrees`, `outer_degrees`",
    ),
    wrong(
        [r#""size": [64, 36],"#, ""],
        "missing-member",
        "{",
        "the scene has no `size`",
    ),
    wrong(
        [r#""position": [0, 1, 5],"#, ""],
        "missing-member",
        r#""camera": {"#,
        "`camera` has no `position`",
    ),
    wrong(
        [r#""front": [0, 0, -2],"#, ""],
        "missing-member",
        r#""camera": {"#,
        "has no direction",
    ),
    wrong(
        [r#""color": [0.25, 0.5, 0.75],"#, ""],
        "missing-member",
        "\"point\": [\n      {",
        "`lights.point[0]` has no emission; add `color` and `intensity`",
    ),
    wrong(
        [r#""color": [0.25, 0.5, 0.75],"#, r#""diffuse": 1, "intensity": 3,"#],
        "wrong-value",
        "3",
        "`lights.point[0].intensity` has no effect without `color`",
    ),
    wrong(
        [r#""axis": [0, 0, 3], "#, ""],
        "missing-member",
        r#"{"degrees": 90}"#,
        "`objects[0].rotation` has no `axis`",
    ),
    wrong(
        [r#""front": [0, 0, -2]"#, r#""front": [0, 0, -2], "target": [0, 0, 1]"#],
        "given-twice",
        "[0, 0, 1]",
        "`camera.target` repeats `front`",
    ),
    wrong(
        [r#""near": 0.1"#, r#""near": 0.1, "near": 0.1"#],
        "given-twice",
        r#""near""#,
        "`near` occurs twice in one object",
    ).beyond_schema(),
    // Kinds and counts.
    wrong(
        ["[64, 36]", r#""large""#],
        "wrong-value",
        r#""large""#,
        r#"`size` is "large", but must be a list"#,
    ),
    wrong(
        ["[64, 36]", "[64, 36, 1]"],
        "wrong-count",
        "[64, 36, 1]",
        "`size` is a list of 3, but must be one of 2",
    ),
    wrong(
        ["[64, 36]", "[64.5, 36]"],
        "value-out-of-range",
        "64.5",
        "`size[0]` is 64.5, but must be a whole number from 1 to 32768",
    ),
    wrong(
        ["[64, 36]", "[64, 0]"],
        "value-out-of-range",
        "0",
        "`size[1]` is 0",
    ),
    wrong(
        ["[64, 36]", "[30000, 30000]"],
        "too-large",
        "[30000, 30000]",
        "is 900000000 pixels, but a picture has at most 16777216",
    ).beyond_schema(),
    wrong(
        [r#""space": "view""#, r#""space": "veiw""#],
        "wrong-value",
        r#""veiw""#,
        "did you mean `view`?",
    ),
    wrong(
        ["[1, 2, 3],\n", "[1, null, 3],\n"],
        "wrong-value",
        "null",
        "`lights.point[0].position[1]` is null, but must be a number",
    ),
    wrong(
        [r#""shader": {"glsl": "lights.frag"}"#, r#""shader": 3"#],
        "wrong-value",
        "3",
        "`shader` is 3, but must be a path or an object",
    ),
    wrong(
        [r#""bind": {"point": "pointLights[]"}"#, r#""bind": "point""#],
        "wrong-value",
        r#""point""#,
        r#"`bind` is "point", but must be an object"#,
    ),
    // Numbers that are none, and too large ones.
    wrong(
        ["[1, 2, 3],\n", "[1, \"NaN\", 3],\n"],
        "not-finite",
        r#""NaN""#,
        r#"`lights.point[0].position[1]` is "NaN", not a finite number"#,
    ),
    wrong(
        ["0.25, 0.5", r#""-inf", 0.5"#],
        "not-finite",
        r#""-inf""#,
        "`lights.point[0].color[0]`",
    ),
    wrong(
        ["0.25, 0.5", "NaN, 0.5"],
        "not-finite",
        "NaN",
        "`NaN` is not finite",
    ).beyond_schema(),
    wrong(
        ["0.25, 0.5", "-Infinity, 0.5"],
        "not-finite",
        "-Infinity",
        "`-Infinity` is not finite",
    ).beyond_schema(),
    wrong(
        ["0.25, 0.5", "1e999, 0.5"],
        "not-finite",
        "1e999",
        "`1e999` is not finite",
    ).beyond_schema(),
    wrong(
        ["0.25, 0.5", "1e39, 0.5"],
        "value-out-of-range",
        "1e39",
        "`lights.point[0].color[0]` is 1e39, which does not fit an `f32`",
    ),
    wrong(
        ["[1, 2, 3],\n", "[1, 2e18, 3],\n"],
        "value-out-of-range",
        "2e18",
        "`lights.point[0].position[1]`",
    ),
    wrong(
        [r#""color": 0.5, "intensity": 2"#, r#""color": 1e30, "intensity": 2e30"#],
        "value-out-of-range",
        r#"{"direction": [0, -2, 0], "color": 1e30, "intensity": 2e30}"#,
        "is brighter than any `f32`",
    ).beyond_schema(),
    wrong(
        [
            r#""position": [2, 0, 0], "scale": [1, 2, 1]"#,
            r#""position": [1e18, 0, 0], "scale": [1e18, 2, 1]"#,
        ],
        "too-large",
        r#"{"mesh": {"sphere": {"segments": 8, "rings": 4}}, "material": "drawn", "position": [1e18, 0, 0], "scale": [1e18, 2, 1]}"#,
        "has corners beyond 1e18",
    ).beyond_schema(),
    // Colours.
    wrong(
        ["0.25, 0.5", "0.25, -0.2"],
        "negative-color",
        "-0.2",
        "`lights.point[0].color[1]` is -0.2: a colour is 0 or more",
    ),
    wrong(
        [r#""specular": 0.6"#, r#""specular": -0.6"#],
        "negative-color",
        "-0.6",
        "`lights.directional[1].specular` is -0.6",
    ),
    wrong(
        [r#""intensity": 0.3"#, r#""intensity": -0.3"#],
        "negative-color",
        "-0.3",
        "`lights.ambient.intensity` is -0.3",
    ),
    wrong(
        ["[0.8, 0.7, 0.6]", "[0.8, 0.7, -0.6]"],
        "negative-color",
        "-0.6",
        "`materials[0].diffuse[2]` is -0.6",
    ),
    wrong(
        ["[0.8, 0.7, 0.6]", r#""red""#],
        "wrong-value",
        r#""red""#,
        r#"`materials[0].diffuse` is "red", but must be a colour"#,
    ),
    wrong(
        ["[0.8, 0.7, 0.6]", "[0.8, 0.7]"],
        "wrong-count",
        "[0.8, 0.7]",
        "is a list of 2, but must be one of 3",
    ),
    // Directions.
    wrong(
        ["[0, -2, 0]", "[0, 0, 0]"],
        "zero-direction",
        "[0, 0, 0]",
        "`lights.directional[0].direction` has no length",
    ),
    wrong(
        ["[0, -4, 0]", "[0, 0.0, 0]"],
        "zero-direction",
        "[0, 0.0, 0]",
        "`lights.directional[1].direction` has no length",
    ),
    wrong(
        ["[0, 0, 3]", "[0, 0, 1e-50]"],
        "zero-direction",
        "[0, 0, 1e-50]",
        "`objects[0].rotation.axis` has no length",
    ).beyond_schema(),
    wrong(
        [r#""front": [0, 0, -2]"#, r#""target": [0, 1, 5]"#],
        "zero-direction",
        "[0, 1, 5]",
        "`camera.target` is the position of the camera",
    ).beyond_schema(),
    // The camera.
    wrong(
        [r#""up": [0, 1, 0]"#, r#""up": [0, 0, 9]"#],
        "up-along-front",
        "[0, 0, 9]",
        "`camera.up` is parallel to the direction of the camera",
    ).beyond_schema(),
    wrong(
        [r#""near": 0.1"#, r#""near": 90"#],
        "bad-planes",
        "50",
        "the near plane is at 90, the far one at 50; swap them",
    ).beyond_schema(),
    wrong(
        [r#""near": 0.1"#, r#""near": 0"#],
        "value-out-of-range",
        "0",
        "`camera.near` is 0, but must be above 0",
    ),
    wrong(
        [r#""fov": 45"#, r#""fov": 180"#],
        "value-out-of-range",
        "180",
        "`camera.fov` is 180 degrees",
    ),
    wrong(
        [r#""fov": 45"#, r#""fov": 0.7853981"#],
        "suspicious-unit",
        "0.7853981",
        "if that is in radians, write 45",
    ).warned(),
    // Attenuation.
    wrong(
        [r#""linear": 0.09"#, r#""linear": -0.09"#],
        "negative-attenuation",
        "-0.09",
        "`lights.point[0].attenuation.linear` is -0.09",
    ),
    wrong(
        [r#""constant": 1, "linear": 0.09, "quadratic": 0.032"#, r#""constant": 0, "linear": 0"#],
        "zero-attenuation",
        r#"{"constant": 0, "linear": 0}"#,
        "divides by zero at every distance",
    ),
    wrong(
        [r#"{"distance": 13}"#, r#"{"distance": 14}"#],
        "wrong-value",
        "14",
        "has no row; its rows are 7, 13, 20",
    ),
    wrong(
        [r#"{"distance": 13}"#, r#"{"constant": 0.032}"#],
        "lone-constant",
        "0.032",
        "at every distance the light is 31.25 times as bright; add `linear` and `quadratic`",
    ).warned(),
    wrong(
        [r#"{"distance": 13}"#, r#"{"distance": 13, "linear": 1}"#],
        "given-twice",
        "13",
        "sets all three coefficients",
    ),
    wrong(
        [r#""range": 9"#, r#""range": 0"#],
        "value-out-of-range",
        "0",
        "`lights.point[0].range` is 0",
    ),
    // Cones.
    wrong(
        [
            r#""inner_degrees": 12.5, "outer_degrees": 17.5"#,
            r#""inner_degrees": 17.5, "outer_degrees": 12.5"#,
        ],
        "swapped-cone",
        r#"{"inner_degrees": 17.5, "outer_degrees": 12.5}"#,
        r#"inside 17.5 degrees, outside 12.5; write `"inner_degrees": 12.5, "outer_degrees": 17.5`"#,
    ).beyond_schema(),
    wrong(
        [
            r#""inner_degrees": 12.5, "outer_degrees": 17.5"#,
            r#""inner_degrees": 0.976, "outer_degrees": 0.954"#,
        ],
        "swapped-cone",
        r#"{"inner_degrees": 0.976, "outer_degrees": 0.954}"#,
        r#"if these are cosines, write `"inner_cos": 0.976, "outer_cos": 0.954`"#,
    ).beyond_schema(),
    wrong(
        [r#""inner_cos": 0.75, "outer_cos": 0.5"#, r#""inner_cos": 0.5, "outer_cos": 0.75"#],
        "swapped-cone",
        r#"{"inner_cos": 0.5, "outer_cos": 0.75}"#,
        "has its cosines swapped",
    ).beyond_schema(),
    // 12.5 and 17.5 degrees in radians.
    wrong(
        [r#""inner_cos": 0.75, "outer_cos": 0.5"#, r#""inner_cos": 0.2182, "outer_cos": 0.3054"#],
        "swapped-cone",
        r#"{"inner_cos": 0.2182, "outer_cos": 0.3054}"#,
        r#"if these are radians, write `"inner_degrees": 12.5, "outer_degrees": 17.5`"#,
    ).beyond_schema(),
    wrong(
        [
            r#""inner_degrees": 12.5, "outer_degrees": 17.5"#,
            r#""inner_degrees": 0.2182, "outer_degrees": 0.3054"#,
        ],
        "narrow-cone",
        "0.3054",
        r#"if these are radians, write `"inner_degrees": 12.5, "outer_degrees": 17.5`"#,
    ).warned(),
    wrong(
        [r#""inner_cos": 0.75, "outer_cos": 0.5"#, r#""inner_cos": 0.9, "outer_cos": 17.5"#],
        "wrong-unit",
        "17.5",
        r#"`lights.spot[1].cone.outer_cos` is 17.5: a cosine is from -1 to 1; if that is an angle, write `"outer_degrees": 17.5`, or its cosine, 0.9537"#,
    ),
    wrong(
        [r#""half_degrees": 60"#, r#""half_degrees": 0.9763"#],
        "narrow-cone",
        "0.9763",
        r#"if that is a cosine, write `"half_degrees": 12.5`"#,
    ).warned(),
    wrong(
        [r#""half_degrees": 60"#, r#""half_degrees": 0"#],
        "empty-cone",
        "0",
        "a cone of zero width",
    ),
    wrong(
        [r#""half_degrees": 60"#, r#""half_degrees": 190"#],
        "value-out-of-range",
        "190",
        "from 0 to 180 degrees",
    ),
    wrong(
        [r#""inner_cos": 0.75, "outer_cos": 0.5"#, r#""inner_cos": 1, "outer_cos": 1"#],
        "empty-cone",
        "1",
        "`lights.spot[1].cone.outer_cos` is 1",
    ),
    wrong(
        [r#""inner_cos": 0.75, "outer_cos": 0.5"#, r#""inner_cos": 0.75, "outer_degrees": 30"#],
        "wrong-cone",
        r#"{"inner_cos": 0.75, "outer_degrees": 30}"#,
        "has more than one kind of angle",
    ),
    wrong(
        [r#""inner_cos": 0.75, "outer_cos": 0.5"#, ""],
        "wrong-cone",
        "{}",
        "has no angle",
    ),
    wrong(
        [r#""inner_cos": 0.75, "outer_cos": 0.5"#, r#""inner_cos": 0.75"#],
        "missing-member",
        r#"{"inner_cos": 0.75}"#,
        "has no `outer_cos`",
    ),
    wrong(
        [r#""inner_cos": 0.75, "outer_cos": 0.5"#, r#""inner_cos": 0.75, "outer_cos": 0.75"#],
        "hard-cone",
        r#"{"inner_cos": 0.75, "outer_cos": 0.75}"#,
        "a soft cone divides by its width, which is 0",
    ).warned(),
    wrong(
        [
            r#""inner_degrees": 12.5, "outer_degrees": 17.5"#,
            r#""inner_degrees": 9, "outer_degrees": 9"#,
        ],
        "hard-cone",
        r#"{"inner_degrees": 9, "outer_degrees": 9}"#,
        r#"write `"half_degrees": 9`"#,
    ).warned(),
    // Materials and textures.
    wrong(
        [r#"{"name": "plain", "#, "{"],
        "missing-member",
        r#"{"diffuse": [0.8, 0.7, 0.6]}"#,
        "`materials[0]` has no `name`",
    ),
    wrong(
        [r#""name": "drawn""#, r#""name": "plain""#],
        "given-twice",
        "\"diffuse\": [0.8, 0.7, 0.6]},\n    {",
        "`materials[1]` has the same name as `materials[0]`",
    ).beyond_schema(),
    wrong(
        [r#""shininess": 64"#, r#""shininess": -1"#],
        "value-out-of-range",
        "-1",
        "`materials[1].shininess` is -1",
    ),
    wrong(
        [r#""shininess": 64"#, r#""shininess": 0"#],
        "zero-shininess",
        "0",
        "the base of the highlight is 0, `pow(0, 0)` is undefined",
    ).warned(),
    wrong(
        [r#"["ab", "ba", "aa"]"#, r#"["ab", "baa", "aa"]"#],
        "wrong-count",
        r#""baa""#,
        "`materials[1].diffuse.rows[1]` is 3 texels long, but the first row 2",
    ).beyond_schema(),
    wrong(
        [r#"["ab", "ba", "aa"]"#, r#"["ab", "bx", "aa"]"#],
        "wrong-texture",
        r#""bx""#,
        "has 'x', which `palette` lacks",
    ).beyond_schema(),
    wrong(
        ["[255, 0, 7]", "[256, 0, 7]"],
        "value-out-of-range",
        "256",
        "must be a whole number from 0 to 255",
    ),
    wrong(
        ["[255, 0, 7]", "[0.5, 0, 7]"],
        "value-out-of-range",
        "0.5",
        "must be a whole number from 0 to 255",
    ),
    wrong(
        [r#""cells": 3"#, r#""cells": 3, "png": "a.png""#],
        "wrong-texture",
        r#"{"checker": [[0, 0, 0], [9, 9, 9]], "cells": 3, "png": "a.png"}"#,
        "has more than one image",
    ),
    wrong(
        [r#""cells": 3"#, r#""palette": {}"#],
        "wrong-texture",
        "{}",
        "`materials[1].specular.palette` belongs to `rows`, not to `checker`",
    ),
    wrong(
        [r#""checker": [[0, 0, 0], [9, 9, 9]], "cells": 3"#, r#""srgb": true"#],
        "wrong-texture",
        r#"{"srgb": true}"#,
        "has no image",
    ),
    // Objects.
    wrong(
        [r#""material": "plain", "position""#, r#""material": "plane", "position""#],
        "missing-material",
        r#""plane""#,
        "which is not a material of the scene; did you mean `plain`?",
    ).beyond_schema(),
    wrong(
        [r#""material": "plain", "position""#, r#""position""#],
        "missing-material",
        r#"{"mesh": "cube", "position": [0, 0.5, 0], "rotation": {"axis": [0, 0, 3], "degrees": 90}}"#,
        "has no `material`, and the scene has 2 to choose from",
    ).beyond_schema(),
    wrong(
        [r#""mesh": "cube""#, r#""mesh": "cub""#],
        "wrong-value",
        r#""cub""#,
        "did you mean `cube`?",
    ),
    wrong(
        [r#""mesh": "cube""#, r#""mesh": "a.obj""#],
        "wrong-value",
        r#""a.obj""#,
        r#"which is a file; write `{"obj": "a.obj"}`"#,
    ),
    wrong(
        [r#""mesh": "cube""#, r#""mesh": {"obj": "a.obj"}"#],
        "unreadable-file",
        r#""a.obj""#,
        "there are no files",
    ).beyond_schema(),
    wrong(
        [r#""mesh": "cube""#, r#""mesh": {"plane": {}, "obj": "a.obj"}"#],
        "wrong-value",
        r#"{"plane": {}, "obj": "a.obj"}"#,
        "is not exactly one of",
    ),
    wrong(
        [r#""segments": 8"#, r#""segments": 2"#],
        "value-out-of-range",
        "2",
        "from 3 to 1024",
    ),
    wrong(
        [r#""scale": 10"#, r#""scale": 0"#],
        "value-out-of-range",
        "0",
        "`objects[2].scale` flattens the mesh",
    ),
    wrong(
        [r#""scale": [1, 2, 1]"#, r#""scale": [1, 0, 1]"#],
        "value-out-of-range",
        "[1, 0, 1]",
        "`objects[1].scale` flattens the mesh",
    ),
    // What is generated.
    wrong(
        [r#""seed": 7"#, r#""seed": -7"#],
        "value-out-of-range",
        "-7",
        "from 0 to 4294967295",
    ),
    wrong(
        [r#""height": [0.5, 2]"#, r#""height": [2, 0.5]"#],
        "value-out-of-range",
        "[2, 0.5]",
        "is an inverted range: from 2 to 0.5; write `[0.5, 2]`",
    ).beyond_schema(),
    wrong(
        [r#""distances": [7, 13]"#, r#""distances": [7, 12]"#],
        "wrong-value",
        "12",
        "`generate.lights.distances[1]` is 12",
    ),
    wrong(
        [r#""distances": [7, 13]"#, r#""distances": []"#],
        "wrong-count",
        "[]",
        "lists no row",
    ),
    wrong(
        [r#""count": 5"#, r#""count": 1000000"#],
        "value-out-of-range",
        "1000000",
        "from 0 to 65536",
    ),
    wrong(
        [r#""floor": {"material": "drawn"}"#, r#""floor": {"material": "x"}"#],
        "missing-material",
        r#""x""#,
        "add a material of that name",
    ).beyond_schema(),
];

/// Message and advice in one.
fn words(found: &Diagnostic) -> String {
    match &found.help {
        Some(help) => format!("{}; {help}", found.message),
        None => found.message.clone(),
    }
}

/// Where a case points: inside what was changed if it is there, else at the one place in all of
/// the text.
fn expected(text: &str, case: &Wrong) -> usize {
    if let Some(key) = case.at.strip_suffix('{') {
        return text.find(case.at).expect("the key is there") + key.len();
    }
    let [from, to] = case.change;
    let changed = RIGHT.find(from).expect("the case is of the right scene");
    match to.rfind(case.at) {
        Some(inside) => changed + inside,
        None => {
            assert_eq!(text.matches(case.at).count(), 1, "{}", case.at);
            text.find(case.at).expect("it is there once")
        }
    }
}

#[test]
fn what_is_wrong_is_named_at_its_place() {
    let schema = schema::validator(SCENE_SCHEMA);
    for case in WRONG {
        let [from, to] = case.change;
        assert_eq!(RIGHT.matches(from).count(), 1, "{from}");
        let text = RIGHT.replace(from, to);
        let reading = read_alone(&text);
        let all: Vec<String> = reading.diagnostics.iter().map(words).collect();
        let [found] = &reading.diagnostics[..] else { panic!("{to}: {all:#?}") };
        assert_eq!(found.code.name(), case.code, "{to}: {all:#?}");
        assert_eq!(found.severity, case.severity, "{to}: {all:#?}");
        assert!(words(found).contains(case.says), "{to}: {all:#?}");
        assert_eq!(reading.scene.is_none(), case.severity == Error, "{to}");

        let start = expected(&text, case);
        let span = found.labels[0].at;
        let at = if case.at.ends_with('{') { "{" } else { case.at };
        assert_eq!((span.start as usize, reading.files.text(span)), (start, at), "{all:#?}");
        let before = &text[..start];
        let line = before.matches('\n').count() + 1;
        let column = start - before.rfind('\n').map_or(0, |end| end + 1) + 1;
        let place = reading.files.locate(span);
        assert_eq!((place.line as usize, place.column as usize), (line, column), "{all:#?}");

        let valid = serde_json::from_str(&text).is_ok_and(|value: Value| schema.is_valid(&value));
        let no_json = serde_json::from_str::<Value>(&text).is_err();
        if !no_json {
            assert_eq!(!valid, case.schema, "the schema on {to}");
        }
    }
}

/// A few places counted by hand.
#[test]
fn lines_and_columns_are_those_of_an_editor() {
    for ([from, to], line, column) in [
        (["[64, 36]", "[64, -36]"], 4, 16),
        (["0.25, 0.5", "0.25, -0.2"], 24, 25),
        (["\"seed\": 7", "\"sead\": 7"], 58, 5),
    ] {
        let reading = read_alone(&RIGHT.replace(from, to));
        let place = reading.files.locate(reading.diagnostics[0].labels[0].at);
        assert_eq!((place.path.as_str(), place.line, place.column), ("scene.json", line, column));
    }
}

#[test]
fn everything_wrong_is_told_at_once() {
    let text = RIGHT
        .replace("\"up\": [0, 1, 0]", "\"up\": [0, 0, 9]")
        .replace("\"fov\": 45", "\"fov\": 200")
        .replace("0.25, 0.5", "-0.25, \"nan\"")
        .replace("\"linear\": 0.09", "\"linear\": -0.09")
        .replace("\"shininess\": 64", "\"shinyness\": 64")
        .replace("\"seed\": 7,", "");
    let codes: Vec<&str> =
        read_alone(&text).diagnostics.iter().map(|found| found.code.name()).collect();
    assert_eq!(
        codes,
        [
            "up-along-front",
            "value-out-of-range",
            "negative-color",
            "not-finite",
            "negative-attenuation",
            "unknown-member",
            "missing-member",
        ]
    );
}

#[test]
fn the_schema_takes_every_scene_that_is_right() {
    let schema = schema::validator(SCENE_SCHEMA);
    let takes = |name: &str, text: &str| {
        let value: Value = serde_json::from_str(text).expect("a scene is JSON");
        let wrong: Vec<String> =
            schema.iter_errors(&value).map(|e| format!("{}: {e}", e.instance_path())).collect();
        assert!(wrong.is_empty(), "{name}: {wrong:#?}");
    };
    takes("right", RIGHT);
    for name in names() {
        let path = crate::scene::folder().join(&name).with_extension("json");
        takes(&name, &std::fs::read_to_string(path).expect("it is there"));
    }
}
