//! Seed form, robust form and every language against each other, on ordinary scenes in `f64`:
//! lights in front of the surface, because only the robust form has no highlight from behind.

use fastrand::Rng;

use super::scene::{Number, Scene, light, light_with};

const FRAGMENTS: usize = 64;

/// Fragments near the plane z = `z`, their normals up to 25 degrees from its own, of any length.
fn surface(scene: &mut Scene, rng: &mut Rng, z: f32, straight: bool) {
    for _ in 0..FRAGMENTS {
        let mut side = || 2.0 * rng.f32() - 1.0;
        scene.places.push([side(), side(), z + 0.2 * side()]);
        let [x, y] = [0.33 * side(), 0.33 * side()];
        let length = 1.25 + 0.75 * side();
        scene.normals.push(match straight {
            true => [0.0, 0.0, 1.0],
            false => [x * length, y * length, length],
        });
    }
}

fn within(rng: &mut Rng, low: f32, high: f32) -> f32 {
    low + (high - low) * rng.f32()
}

fn colour(rng: &mut Rng) -> Number {
    Number::Three([0.0; 3].map(|_: f32| within(rng, 0.1, 1.0)))
}

/// Over the plane, high enough that it lights every fragment from the front.
fn place(rng: &mut Rng, z: f32) -> Number {
    Number::Three([within(rng, -1.0, 1.0), within(rng, -1.0, 1.0), z + within(rng, 2.0, 3.5)])
}

fn down(rng: &mut Rng) -> [f32; 3] {
    [within(rng, -0.3, 0.3), within(rng, -0.3, 0.3), -1.0]
}

/// Whole and not, below 256 and above.
fn shininess(rng: &mut Rng) -> f32 {
    *rng.choice(&[1.0, 2.0, 10.0, 7.5, 32.0, 100.0, 256.0, 300.0, 1000.5]).expect("there are some")
}

fn weakening(scene: &mut Scene, rng: &mut Rng, at: &str) {
    for (name, most) in [("constant", 1.0), ("linear", 0.7), ("quadratic", 1.8)] {
        let value = if name == "constant" { 1.0 } else { within(rng, 0.001, most) };
        scene.set(&[&format!("{at}.{name}")], Number::One(value));
    }
}

fn terms(scene: &mut Scene, rng: &mut Rng, at: &str) {
    for name in ["ambient", "diffuse", "specular"] {
        scene.set(&[&format!("{at}.{name}")], colour(rng));
    }
}

fn cosines(scene: &mut Scene, rng: &mut Rng, at: &str) {
    let inner = within(rng, 5.0, 20.0);
    let outer = inner + within(rng, 1.0, 10.0);
    scene.set(&[&format!("{at}.cutOff")], Number::One(inner.to_radians().cos()));
    scene.set(&[&format!("{at}.outerCutOff")], Number::One(outer.to_radians().cos()));
}

const TEXTURES: [(&str, [f32; 4]); 3] = [
    ("diffuse", [0.75, 0.5, 0.25, 1.0]),
    ("specular", [0.5, 0.625, 1.0, 1.0]),
    ("flashlight", [1.0, 0.25, 0.5, 1.0]),
];

/// Runs all files over the scene and holds them against the first; how many colours.
fn same(files: &[&str], scene: &Scene) -> usize {
    let (expected, undefined) = light(files[0], scene);
    assert_eq!(undefined, Vec::<String>::new(), "{}", files[0]);
    for file in &files[1..] {
        let (got, undefined) = light(file, scene);
        assert_eq!(undefined, Vec::<String>::new(), "{file}");
        for (i, (got, expected)) in got.iter().zip(&expected).enumerate() {
            for (a, b) in got.iter().zip(expected) {
                let off = (a - b).abs() / b.abs().max(1e-6);
                assert!(off <= 1e-9, "{file}, fragment {i}: {a}, {b} by {}, {off:e}", files[0]);
            }
        }
    }
    let bright = expected.iter().flatten().filter(|x| **x > 1e-3).count();
    assert!(2 * bright > expected.len(), "{} is dark", files[0]);
    expected.len() * (files.len() - 1)
}

#[test]
fn six_lights_agree() {
    let mut rng = Rng::with_seed(1);
    for _ in 0..12 {
        let mut scene = Scene { textures: TEXTURES.to_vec(), ..Scene::default() };
        surface(&mut scene, &mut rng, 0.0, false);
        scene.set(&["viewPos"], place(&mut rng, 0.0));
        scene.set(&["material.shininess", "shininess"], Number::One(shininess(&mut rng)));
        scene.set(&["dirLight.direction"], Number::Three(down(&mut rng)));
        terms(&mut scene, &mut rng, "dirLight");
        for light in
            ["pointLights[0]", "pointLights[1]", "pointLights[2]", "pointLights[3]", "spotLight"]
        {
            scene.set(&[&format!("{light}.position")], place(&mut rng, 0.0));
            terms(&mut scene, &mut rng, light);
            weakening(&mut scene, &mut rng, light);
        }
        scene.set(&["spotLight.direction"], Number::Three(down(&mut rng)));
        cosines(&mut scene, &mut rng, "spotLight");
        let files = [
            "shaders/seed/six_lights_450.frag",
            "shaders/seed/six_lights_330.frag",
            "shaders/seed/six_lights.wgsl",
            "shaders/six_lights/phong_450.frag",
            "shaders/six_lights/phong_330.frag",
            "shaders/six_lights/phong.wgsl",
        ];
        assert_eq!(same(&files, &scene), 5 * FRAGMENTS);
        // OpenGL ES takes the flashlight's highlight from the specular texture.
        scene.textures.retain(|(name, _)| *name != "flashlight");
        scene.textures.push(("flashlight", TEXTURES[1].1));
        same(&["shaders/seed/six_lights_450.frag", "shaders/six_lights/phong_300es.frag"], &scene);
    }
}

#[test]
fn squarings_are_the_power_they_stand_for() {
    let mut rng = Rng::with_seed(6);
    let mut scene = Scene { textures: TEXTURES.to_vec(), ..Scene::default() };
    surface(&mut scene, &mut rng, 0.0, false);
    scene.set(&["viewPos"], place(&mut rng, 0.0));
    scene.set(&["material.shininess", "shininess"], Number::One(32.0));
    terms(&mut scene, &mut rng, "light");
    scene.set(&["light.direction"], Number::Three(down(&mut rng)));
    for file in ["directional_450.frag", "directional_330.frag", "directional.wgsl"] {
        let file = format!("shaders/casters/{file}");
        let (any, _) = light(&file, &scene);
        let colours = |count| light_with(&file, &scene, &[("SQUARINGS", count)]).0;
        let off = |a: &[[f64; 3]]| {
            let pairs = a.iter().flatten().zip(any.iter().flatten());
            pairs.map(|(a, b)| (a - b).abs() / b).fold(0.0, f64::max)
        };
        assert!(off(&colours(5)) < 1e-9, "{file}");
        assert!(off(&colours(4)) > 1e-3, "{file}: it makes a difference");
    }
}

const LIGHT_ARRAYS: [&str; 6] = [
    "shaders/seed/light_arrays_450.frag",
    "shaders/seed/light_arrays_330.frag",
    "shaders/seed/light_arrays.wgsl",
    "shaders/light_arrays/all_lights_450.frag",
    "shaders/light_arrays/all_lights_330.frag",
    "shaders/light_arrays/lights.wgsl",
];

/// The seed form has another model: it knows no highlight of directional lights, and of a point
/// light one that has no intensity, the colour of the diffuse texture, and the normal as it is
/// interpolated. They agree where these make no difference.
#[test]
fn light_arrays_agree() {
    let mut rng = Rng::with_seed(2);
    for round in 0..12 {
        let suns = round % 2 == 0;
        let gloss = if suns { 0.0 } else { 0.625 };
        let mut scene = Scene {
            textures: vec![("diffuse", [1.0; 4]), ("specular", [gloss, gloss, gloss, 1.0])],
            ..Scene::default()
        };
        surface(&mut scene, &mut rng, 0.0, true);
        scene.set(&["u_view_pos", "view_pos"], place(&mut rng, 0.0));
        let power = Number::One(shininess(&mut rng));
        scene.set(&["u_specular_highlight_shininess", "specular_highlight_shininess"], power);
        scene.put(Some("AmbientBlock"), &["data.color"], colour(&mut rng));
        scene.put(Some("AmbientBlock"), &["data.intensity"], Number::One(0.2));
        let directional = Some("DirectionalLightBlock");
        scene.put(directional, &["actually_used_count"], Number::Count(if suns { 2 } else { 0 }));
        for i in 0..2 {
            scene.put(directional, &[&format!("data[{i}].dir")], Number::Three(down(&mut rng)));
            scene.put(directional, &[&format!("data[{i}].color")], colour(&mut rng));
            scene.put(directional, &[&format!("data[{i}].intensity")], Number::One(0.7));
        }
        let point = Some("PointLightBlock");
        scene.put(point, &["actually_used_count"], Number::Count(3));
        for i in 0..3 {
            scene.put(point, &[&format!("data[{i}].pos")], place(&mut rng, 0.0));
            scene.put(point, &[&format!("data[{i}].color")], colour(&mut rng));
            scene.put(point, &[&format!("data[{i}].intensity")], Number::One(1.0));
            for (name, value) in [("constant", 1.0), ("linear", 0.35), ("quadratic", 0.44)] {
                scene.put(point, &[&format!("data[{i}].{name}")], Number::One(value));
            }
        }
        assert_eq!(same(&LIGHT_ARRAYS, &scene), 5 * FRAGMENTS);
    }
}

#[test]
fn view_space_scenes_agree() {
    let mut rng = Rng::with_seed(3);
    for _ in 0..12 {
        let mut scene =
            Scene { textures: vec![("txtsampler", [0.75, 0.5, 0.25, 1.0])], ..Scene::default() };
        surface(&mut scene, &mut rng, -4.0, false);
        let four = |rng: &mut Rng| Number::Four([0.0; 4].map(|_: f32| within(rng, 0.1, 1.0)));
        for name in ["ambient", "diffuse", "specular"] {
            scene.set(&[&format!("material.{name}"), name], four(&mut rng));
        }
        scene.set(&["material.reflectance", "reflectance"], Number::One(1.0));
        scene.set(&["ambientLight.color"], colour(&mut rng));
        scene.set(&["ambientLight.intensity"], Number::One(0.3));
        scene.set(&["dirLight.color"], colour(&mut rng));
        scene.set(&["dirLight.direction"], Number::Three(down(&mut rng).map(|x| -x)));
        scene.set(&["dirLight.intensity"], Number::One(0.8));
        for light in ["pointLights[0]", "pointLights[3]", "spotLights[0].pl", "spotLights[4].pl"] {
            scene.set(&[&format!("{light}.position")], place(&mut rng, -4.0));
            scene.set(&[&format!("{light}.color")], colour(&mut rng));
            let intensity = within(&mut rng, 0.2, 2.0);
            scene.set(&[&format!("{light}.intensity")], Number::One(intensity));
            for (name, value) in [("constant", 1.0), ("linear", 0.1), ("exponent", 0.3)] {
                scene.set(&[&format!("{light}.att.{name}")], Number::One(value));
            }
        }
        for light in ["spotLights[0]", "spotLights[4]"] {
            scene.set(&[&format!("{light}.conedir")], Number::Three(down(&mut rng)));
            let cutoff = within(&mut rng, 10.0, 60.0).to_radians().cos();
            scene.set(&[&format!("{light}.cutoff")], Number::One(cutoff));
        }
        let files = [
            "shaders/seed/view_space_450.frag",
            "shaders/seed/view_space_330.frag",
            "shaders/seed/view_space.wgsl",
            "shaders/view_space/scene_450.frag",
            "shaders/view_space/scene_330.frag",
            "shaders/view_space/scene.wgsl",
        ];
        assert_eq!(same(&files, &scene), 5 * FRAGMENTS);
    }
}

#[test]
fn casters_agree() {
    let mut rng = Rng::with_seed(4);
    for kind in ["directional", "point", "spot_hard", "spot_soft"] {
        for _ in 0..6 {
            let mut scene = Scene { textures: TEXTURES.to_vec(), ..Scene::default() };
            surface(&mut scene, &mut rng, 0.0, false);
            scene.set(&["viewPos"], place(&mut rng, 0.0));
            scene.set(&["material.shininess", "shininess"], Number::One(shininess(&mut rng)));
            terms(&mut scene, &mut rng, "light");
            if kind != "point" {
                scene.set(&["light.direction"], Number::Three(down(&mut rng)));
            }
            if kind != "directional" {
                scene.set(&["light.position"], place(&mut rng, 0.0));
                weakening(&mut scene, &mut rng, "light");
            }
            match kind {
                "spot_soft" => cosines(&mut scene, &mut rng, "light"),
                "spot_hard" => scene.set(&["light.cutOff"], Number::One(0.95)),
                _ => {}
            }
            let files = ["seed/caster_", "casters/"]
                .iter()
                .flat_map(|at| ["_450.frag", "_330.frag", ".wgsl"].map(|e| (at, e)))
                .map(|(at, extension)| format!("shaders/{at}{kind}{extension}"))
                .collect::<Vec<_>>();
            let files: Vec<&str> = files.iter().map(String::as_str).collect();
            assert_eq!(same(&files, &scene), 5 * FRAGMENTS);
        }
    }
}

#[test]
fn many_lights_agree() {
    let mut rng = Rng::with_seed(5);
    for model in ["windowed", "plain"] {
        for _ in 0..6 {
            let mut scene = Scene::default();
            surface(&mut scene, &mut rng, 0.0, false);
            scene.set(&["viewPos"], place(&mut rng, 0.0));
            scene.set(&["ambient.color"], colour(&mut rng));
            scene.set(&["ambient.intensity"], Number::One(0.2));
            scene.put(Some("MaterialBlock"), &["diffuse"], colour(&mut rng));
            scene.put(Some("MaterialBlock"), &["specular"], colour(&mut rng));
            scene.set(&["shininess"], Number::One(shininess(&mut rng)));
            scene.set(&["directionalCount"], Number::Count(1));
            let sun = "directionalLights[0]";
            scene.set(&[&format!("{sun}.direction")], Number::Three(down(&mut rng)));
            scene.set(&[&format!("{sun}.color")], colour(&mut rng));
            scene.set(&[&format!("{sun}.intensity")], Number::One(0.5));
            scene.set(&["pointCount"], Number::Count(7));
            scene.set(&["spotCount"], Number::Count(1));
            for i in 0..8 {
                let light = match i {
                    7 => "spotLights[0]".to_string(),
                    _ => format!("pointLights[{i}]"),
                };
                scene.set(&[&format!("{light}.position")], place(&mut rng, 0.0));
                // Some end before the surface.
                let range = if i == 7 { 9.0 } else { within(&mut rng, 1.0, 6.0) };
                scene.set(&[&format!("{light}.range")], Number::One(range));
                scene.set(&[&format!("{light}.color")], colour(&mut rng));
                scene.set(&[&format!("{light}.intensity")], Number::One(0.9));
                weakening(&mut scene, &mut rng, &light);
            }
            scene.set(&["spotLights[0].direction"], Number::Three(down(&mut rng)));
            cosines(&mut scene, &mut rng, "spotLights[0]");
            let whole = ["_450.frag", "_330.frag", ".wgsl"];
            let files = whole.map(|extension| format!("shaders/many_lights/{model}{extension}"));
            let files: Vec<&str> = files.iter().map(String::as_str).collect();
            assert_eq!(same(&files, &scene), 2 * FRAGMENTS);

            // A type left out is a type with none of its lights.
            for extension in [".wgsl", "_330.frag", "_450.frag"] {
                let file = format!("shaders/many_lights/{model}{extension}");
                for (flag, count) in [
                    ("HAS_DIRECTIONAL_LIGHTS", "directionalCount"),
                    ("HAS_POINT_LIGHTS", "pointCount"),
                    ("HAS_SPOT_LIGHTS", "spotCount"),
                ] {
                    let mut none = scene.clone();
                    none.members.retain(|member| member.paths[0] != count);
                    let without = light_with(&file, &scene, &[(flag, 0)]);
                    assert_eq!(without, light(&file, &none), "{file}, {flag}");
                    assert_ne!(without, light(&file, &scene), "{file}, {flag}");
                }
            }

            // One tile, with a list of all of them.
            scene.set(&["tileSize"], Number::Count(16));
            scene.set(&["tilesAcross"], Number::Count(1));
            scene.set(&["tiles[0].count"], Number::Count(7));
            for i in 0..7 {
                scene.set(&[&format!("indices[{i}]")], Number::Count(i));
            }
            let mut all = scene.clone();
            all.members
                .retain(|m| !m.paths[0].starts_with("til") && !m.paths[0].starts_with("ind"));
            for extension in ["_450.frag", ".wgsl"] {
                let file = |listed| format!("shaders/many_lights/{model}{listed}{extension}");
                // In the order of the list, every light is computed as before.
                assert_eq!(light(&file("_listed"), &scene), light(&file(""), &all), "{extension}");
            }
        }
    }
}
