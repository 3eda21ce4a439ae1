//! `landfall render` names what made pixels NaN or infinite.

use serde_json::{Value, from_str, json};

use super::cli_render::SCENE;
use crate::support::command::Place;

/// The red channel of a picture of 20 by 15: three little-endian floats a pixel, the last row first.
fn red(pfm: &[u8], x: usize, y: usize) -> f32 {
    let at = pfm.len() - 20 * 15 * 12 + ((14 - y) * 20 + x) * 12;
    f32::from_le_bytes(pfm[at..at + 4].try_into().expect("four bytes"))
}

/// One lamp divides by zero, and another one multiplies that by zero on the left of the picture:
/// shares and the first pixel are those of the picture that is written.
#[test]
fn pixels_that_are_not_finite_are_told_with_the_members_that_led_there() {
    let folder = Place::new("render-causes");
    let shader = "#version 330 core
in vec3 FragPos; in vec3 Normal; in vec2 TexCoords;
out vec4 FragColor;
struct PointLight { vec3 position; float constant; float linear; float quadratic; vec3 diffuse; };
uniform PointLight pointLights[4];
uniform vec3 viewPos;
void main() {
    vec3 sum = vec3(0.0);
    for (int i = 0; i < 4; i++) {
        float d = length(pointLights[i].position - FragPos);
        float fade = pointLights[i].constant / (pointLights[i].quadratic * d * d);
        sum += pointLights[i].diffuse * fade;
    }
    FragColor = vec4(FragPos.x < 0.0 ? sum - sum : sum, 1.0);
}
";
    let mut scene: Value =
        from_str(&std::fs::read_to_string(SCENE).expect("a scene")).expect("JSON");
    scene["shader"] = "causes.frag".into();
    scene.as_object_mut().expect("an object").remove("$schema");
    scene["lights"]["spot"] = json!([]);
    scene["lights"]["directional"] = json!([]);
    for lamp in scene["lights"]["point"].as_array_mut().expect("lamps") {
        lamp["attenuation"] = json!({"constant": 1, "linear": 0, "quadratic": 0.1});
    }
    scene["lights"]["point"][2]["attenuation"]["quadratic"] = 0.into();
    folder.write("causes.frag", shader);
    folder.write("scene.json", scene.to_string());
    let small = ["render", "scene.json", "--size", "20x15", "-o", "out.pfm"];
    let ran = folder.run(&[&small[..], &["--format", "json"]].concat());
    assert_eq!(ran.code, 1, "{}", ran.err);
    let report = ran.json();
    let bytes = std::fs::read(folder.0.join("out.pfm")).expect("a picture");
    let red = |x: usize, y: usize| red(&bytes, x, y);
    let all = || (0..15).flat_map(|y| (0..20).map(move |x| (x, y)));
    let odd = all().filter(|&(x, y)| !red(x, y).is_finite()).count();
    assert!((50..=256).contains(&odd), "{odd}");
    assert_eq!(report["non_finite"], odd);
    let causes = report["causes"].as_array().expect("causes");
    assert_eq!(causes.len(), 2, "{causes:#?}");
    for (value, is) in [("nan", f32::is_nan as fn(f32) -> bool), ("inf", f32::is_infinite)] {
        let cause = causes.iter().find(|cause| cause["value"] == value).expect("both are there");
        let own: Vec<(usize, usize)> = all().filter(|&(x, y)| is(red(x, y))).collect();
        assert_eq!(cause["share"], own.len() as f64 / odd as f64);
        assert_eq!(cause["first"], json!([own[0].0, own[0].1]));
        assert_eq!(cause["what"], "division by zero");
        let from = json!([{"path": "pointLights[2].quadratic", "values": [0.0]}]);
        assert_eq!(cause["from"], from);
    }
    let ran = folder.run(&small);
    assert!(ran.out.contains("comes from pointLights[2].quadratic = 0\n"), "{}", ran.out);
    let causes = ran.out.lines().skip_while(|line| !line.contains("non-finite"));
    let mut causes = causes.take_while(|line| !line.contains("operations"));
    assert!(causes.all(|line| line.len() <= 80), "{}", ran.out);
    // Where a bound hides the infinity, the operation and the member are told by --watch.
    let hidden =
        shader.replace("sum += pointLights", "fade = min(fade, 1.0);\n        sum += pointLights");
    folder.write("causes.frag", &hidden);
    let ran = folder.run(&[&small[..], &["--watch", "--format", "json"]].concat());
    assert_eq!(ran.code, 0, "{}", ran.err);
    let report = ran.json();
    assert_eq!((&report["non_finite"], &report["causes"]), (&json!(0), &json!([])));
    let undefined = report["operations"]["undefined"].as_array().expect("operations");
    let division = undefined.iter().find(|one| one["what"] == "division by zero");
    let from = json!([{"path": "pointLights[2].quadratic", "values": [0.0]}]);
    let division = division.expect("it is there");
    assert_eq!((&division["from"], &division["share"]), (&from, &json!(1.0)));
    let ran = folder.run(&[&small[..], &["--watch"]].concat());
    assert!(ran.out.contains("  comes from pointLights[2].quadratic = 0\n"), "{}", ran.out);
    // On the left alone, which the picture shows in white.
    let left = hidden.replace("float d =", "if (FragPos.x >= 0.0) continue;\n        float d =");
    let left = left.replace("sum - sum : sum", "vec3(1.0) : vec3(0.0)");
    folder.write(
        "causes.frag",
        left.replace("vec4(FragPos", "vec4(sum * 0.0 + (FragPos")
            .replace("vec3(0.0), 1.0);", "vec3(0.0)), 1.0);"),
    );
    let ran = folder.run(&[&small[..], &["--watch", "--format", "json"]].concat());
    let report = ran.json();
    let bytes = std::fs::read(folder.0.join("out.pfm")).expect("a picture");
    let white: Vec<_> = all().filter(|&(x, y)| self::red(&bytes, x, y) == 1.0).collect();
    let undefined = report["operations"]["undefined"].as_array().expect("operations");
    let division = undefined.iter().find(|one| one["what"] == "division by zero");
    let division = division.expect("it is there");
    assert_eq!(report["fragments"], odd);
    assert!((1..odd).contains(&white.len()), "{} of {odd}", white.len());
    assert_eq!(division["share"], white.len() as f64 / odd as f64);
    assert_eq!(division["first"], json!([white[0].0, white[0].1]));
    let ran = folder.run(&[&small[..], &["--watch"]].concat());
    let first = format!("% of the pixels, first at pixel ({}, {})\n", white[0].0, white[0].1);
    assert!(ran.out.contains(&first), "{}", ran.out);
}
