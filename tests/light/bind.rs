//! Which number of a scene goes to which member: guessed for our shaders and for texts in other
//! people's fashions, said otherwise, and refused.

use std::path::{Path, PathBuf};

use glam::DVec3;
use landfall_exec::harness::fragments::FragmentShader;
use landfall_layout::{Buffer, Options, Source};
use landfall_light::bind::{
    BindError, BindingMap, BlockWriter, Kind, OverflowPolicy, infer, overridden,
};
use landfall_light::culling::LightSet;
use landfall_light::scene::{
    Ambient, Attenuation, Cone, DirectionalLight, Emission, Lights, Material, PointLight, Space,
    SpotLight, Surface, Texture,
};
use landfall_light::{Chosen, Fragment, Upload};
use snapbox::str;

use crate::support::command::golden;

fn shader(source: &Source) -> FragmentShader {
    FragmentShader::new(source, &Options::default(), None)
        .unwrap_or_else(|found| panic!("{}: {found:?}", source.path))
}

fn guessed(source: &Source) -> BindingMap {
    infer(&shader(source), &source.path, &source.text).unwrap_or_else(|error| panic!("{error}"))
}

fn ours(path: &str) -> Source {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders").join(path);
    Source::read(path).unwrap_or_else(|error| panic!("{error}"))
}

/// `member = quantity`, a line each.
fn rows(map: &BindingMap) -> Vec<String> {
    let members = map.members.iter().map(|m| format!("{} = {}", m.key(), m.source));
    let bound = map.textures.iter().chain(&map.inputs);
    members.chain(bound.map(|b| format!("{} = {}", b.name, b.source))).collect()
}

fn check(source: &Source, expected: &[&str]) {
    let rows = rows(&guessed(source));
    for line in expected {
        assert!(rows.iter().any(|row| row == line), "{}: {line}\n{rows:#?}", source.path);
    }
}

/// Members that a fragment stage has in its blocks and does not light with.
const NOT_OF_LIGHTING: [&str; 3] = ["projection_view", "normal_matrix", "model"];

#[test]
fn nothing_of_our_shaders_is_unknown() {
    let mut seen = 0;
    for folder in ["six_lights", "light_arrays", "casters", "view_space", "many_lights", "seed"] {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders").join(folder);
        let files = std::fs::read_dir(&folder).unwrap_or_else(|e| panic!("{folder:?}: {e}"));
        let mut files: Vec<PathBuf> = files.map(|entry| entry.expect("a file").path()).collect();
        files.retain(|path| path.extension().is_some_and(|e| e == "frag" || e == "wgsl"));
        files.sort();
        for path in files {
            let source = Source::read(&path).expect("it is there");
            let unknown: Vec<String> = guessed(&source)
                .unknown()
                .into_iter()
                .filter(|name| !NOT_OF_LIGHTING.iter().any(|other| name.ends_with(other)))
                .collect();
            assert!(unknown.is_empty(), "{}: {unknown:?}", source.path);
            seen += 1;
        }
    }
    assert!(seen > 40, "{seen}");
}

#[test]
fn arrays_of_lights_with_their_counts() {
    for name in ["all_lights_330.frag", "all_lights_450.frag", "lights.wgsl"] {
        let source = ours(&format!("light_arrays/{name}"));
        check(
            &source,
            &[
                "AmbientBlock.data.color = ambient.color",
                "AmbientBlock.data.intensity = ambient.intensity",
                "DirectionalLightBlock.data[].dir = directional[].direction",
                "DirectionalLightBlock.actually_used_count = directional.count",
                "PointLightBlock.data[].pos = point[].position",
                "PointLightBlock.data[].color = point[].color",
                "PointLightBlock.data[].intensity = point[].intensity",
                "PointLightBlock.data[].quadratic = point[].quadratic",
                "PointLightBlock.actually_used_count = point.count",
                "u_diffuse_texture = material.diffuse",
                "u_specular_texture = material.specular",
            ],
        );
    }
    check(
        &ours("light_arrays/all_lights_330.frag"),
        &[
            "u_view_pos = camera.position",
            "u_specular_highlight_shininess = material.shininess",
            "v_frag_pos = position",
            "v_normal = normal",
            "v_uv = uv",
        ],
    );
}

#[test]
fn six_lights_set_one_by_one_or_in_blocks() {
    check(
        &ours("six_lights/phong_330.frag"),
        &[
            "viewPos = camera.position",
            "material.shininess = material.shininess",
            "dirLight.direction = directional[0].direction",
            "dirLight.ambient = directional[0].ambient",
            "pointLights[].position = point[].position",
            "pointLights[].linear = point[].linear",
            "spotLight.direction = spot[0].direction",
            "spotLight.cutOff = spot[0].inner_cos",
            "spotLight.outerCutOff = spot[0].outer_cos",
            "material.diffuse = material.diffuse",
            "material.flashlight = material.specular",
            "FragPos = position",
            "TexCoords = uv",
        ],
    );
    check(
        &ours("six_lights/phong.wgsl"),
        &[
            "ViewBlock.viewPos = camera.position",
            "LightBlock.dirLight.direction = directional[0].direction",
            "LightBlock.pointLights[].specular = point[].specular",
            "LightBlock.spotLight.outerCutOff = spot[0].outer_cos",
            "MaterialBlock.shininess = material.shininess",
            "materialFlashlight = material.specular",
            "fragPos = position",
        ],
    );
}

#[test]
fn view_space_names_a_direction_towards_the_light_and_one_cone() {
    for name in ["scene_330.frag", "scene_450.frag", "scene.wgsl"] {
        let source = ours(&format!("view_space/{name}"));
        let block = if name == "scene_330.frag" { "" } else { "LightBlock." };
        let rows = rows(&guessed(&source));
        for (member, quantity) in [
            ("ambientLight.color", "ambient.color"),
            ("dirLight.direction", "-directional[0].direction"),
            ("pointLights[].att.exponent", "point[].quadratic"),
            ("spotLights[].pl.position", "spot[].position"),
            ("spotLights[].pl.att.linear", "spot[].linear"),
            ("spotLights[].conedir", "spot[].direction"),
            ("spotLights[].cutoff", "spot[].outer_cos"),
            ("cameraPosition", "camera.position"),
        ] {
            let line = format!("{block}{member} = {quantity}");
            assert!(rows.contains(&line), "{name}: {line}\n{rows:#?}");
        }
        let has = |end: &str| rows.iter().any(|row| row.ends_with(end));
        assert!(has("reflectance = material.reflectance") && has("txtSampler = material.diffuse"));
    }
}

#[test]
fn ranges_counts_and_tiles_of_many_lights() {
    check(
        &ours("many_lights/windowed_listed_450.frag"),
        &[
            "SceneBlock.viewPos = camera.position",
            "SceneBlock.directionalCount = directional.count",
            "SceneBlock.ambient.color = ambient.color",
            "PointLightBlock.pointLights[].range = point[].range",
            "PointLightBlock.pointCount = point.count",
            "SpotLightBlock.spotLights[].cutOff = spot[].inner_cos",
            "TileBlock.tileSize = tiles.size",
            "TileBlock.tilesAcross = tiles.columns",
            "TileBlock.tiles[].first = tiles[].first",
            "TileBlock.tiles[].count = tiles[].count",
            "IndexBlock.indices[] = tiles.index[]",
            "MaterialBlock.diffuse = material.diffuse",
            "gl_FragCoord = pixel",
        ],
    );
}

#[test]
fn other_fashions_of_naming() {
    let text = "#version 330
        struct Lamp { vec4 colour; vec3 where_; };
        struct SpotLightSource { vec3 location; vec3 dir; float innerAngle; float outerAngle;
            vec3 attenuation; vec3 rgb; float power; };
        uniform SpotLightSource torch[3];
        uniform int torchCount;
        uniform vec3 sunDirection; uniform vec3 sunColor;
        uniform vec3 eyePosition; uniform vec3 objectColor; uniform float glossiness;
        uniform sampler2D shadowMap;
        in vec3 worldPos; in vec3 n; in vec4 tint;
        out vec4 c;
        void main() {
            vec3 sum = sunColor * max(dot(n, sunDirection), 0.0) * objectColor;
            for (int i = 0; i < torchCount; i++) {
                vec3 l = torch[i].location - worldPos;
                float inside = dot(normalize(-torch[i].dir), normalize(l));
                inside = clamp((inside - cos(radians(torch[i].outerAngle)))
                    / (cos(radians(torch[i].innerAngle)) - cos(radians(torch[i].outerAngle))), 0.0, 1.0);
                vec3 a = torch[i].attenuation;
                sum += torch[i].rgb * torch[i].power * inside / (a.x + a.y * length(l) + a.z * dot(l, l));
            }
            c = vec4(sum, 1.0) * tint * texture(shadowMap, n.xy)
                + vec4(eyePosition, 1.0) * glossiness * 0.0;
        }";
    let source = Source::new("other.frag", text);
    check(
        &source,
        &[
            "torch[].location = spot[].position",
            "torch[].innerAngle = spot[].inner_degrees",
            "torch[].outerAngle = spot[].outer_degrees",
            "torch[].attenuation = spot[].attenuation",
            "torch[].rgb = spot[].color",
            "torch[].power = spot[].intensity",
            "eyePosition = camera.position",
            "objectColor = material.diffuse",
            "glossiness = material.shininess",
            "worldPos = position",
            "n = normal",
        ],
    );
    let map = guessed(&source);
    assert!(map.unknown().contains(&"tint".to_string()), "{:?}", map.unknown());
    assert!(map.unknown().contains(&"shadowMap".to_string()), "{:?}", map.unknown());
}

#[test]
fn a_shader_without_lights_is_refused_by_name() {
    let source = Source::new(
        "flat.frag",
        "#version 330\nuniform vec4 tint; out vec4 c;\nvoid main() { c = tint; }",
    );
    let error = infer(&shader(&source), &source.path, &source.text).expect_err("it has none");
    assert_eq!(error.to_string(), "no block or uniform of `flat.frag` holds a light");
    assert!(error.help().is_some());
}

#[test]
fn what_is_said_stands_over_what_is_guessed() {
    let source = ours("six_lights/phong_330.frag");
    let map = guessed(&source);
    let said = |json: &str| {
        let value: serde_json::Value = serde_json::from_str(json).expect("it is JSON");
        overridden(map.clone(), value.as_object().expect("an object"))
    };
    let changed = said(
        r#"{"dirLight.direction": "-directional[2].direction", "viewPos": [1, 2, 3],
            "material.shininess": null, "pointLights[1].position": "point[0].position",
            "Normal": "-normal"}"#,
    )
    .expect("all of it is the shader's");
    let rows = rows(&changed);
    for line in [
        "dirLight.direction = -directional[2].direction",
        "viewPos = [1.0, 2.0, 3.0]",
        "material.shininess = 0",
        "pointLights[].position = point[].position",
        "pointLights[1].position = point[0].position",
        "Normal = -normal",
    ] {
        assert!(rows.iter().any(|row| row == line), "{line}\n{rows:#?}");
    }
    for (json, message, help) in [
        (
            r#"{"viewPoz": 1}"#,
            "the shader has no member, texture or input `viewPoz`",
            "did you mean `viewPos`?",
        ),
        (
            r#"{"viewPos": "camera.postion"}"#,
            "`viewPos` is bound to `camera.postion`, which is not a property of a scene",
            "did you mean `camera.position`?",
        ),
    ] {
        let error = said(json).expect_err(json);
        assert_eq!((error.to_string().as_str(), error.help().as_deref()), (message, Some(help)));
    }
    for json in [
        r#"{"viewPos": "normal"}"#,
        r#"{"Normal": "camera.position"}"#,
        r#"{"viewPos": {}}"#,
        r#"{"viewPos": [1, 2, 3, 4, 5]}"#,
    ] {
        let error = said(json).expect_err(json);
        assert_eq!(error.code(), "wrong-type", "{json}: {error}");
    }
    let one = said(r#"{"viewPos": "point[].position"}"#).expect("it is a quantity");
    let error = BlockWriter::new(&shader(&source), &one).expect_err("one member, many lights");
    golden().eq(
        error.to_string(),
        str!["`viewPos` is not in an array, but `point[].position` has a value for each element"],
    );
}

fn emission(base: f64) -> Emission {
    let color = |n: f64| DVec3::new(base + n, base + n + 0.25, base + n + 0.5);
    let (ambient, diffuse, specular) = (color(0.0), color(1.0), color(2.0));
    Emission { ambient, diffuse, specular, color: color(3.0), intensity: base + 4.0 }
}

fn lamp(base: f64) -> PointLight {
    let attenuation =
        Attenuation { constant: base, linear: base + 0.5, quadratic: base + 0.75, range: None };
    PointLight { position: DVec3::new(base, 2.0, 3.0), emission: emission(base), attenuation }
}

fn upload(points: usize) -> Upload {
    let surface = |texel: [u8; 3]| {
        Surface::Texture(Texture { width: 1, height: 1, texels: vec![texel], srgb: false })
    };
    Upload {
        space: Space::World,
        camera: DVec3::new(7.0, 8.0, 9.0),
        lights: Lights {
            ambient: Some(Ambient { color: DVec3::new(0.5, 0.25, 0.125), intensity: 2.0 }),
            directional: vec![DirectionalLight {
                direction: DVec3::new(-1.0, -2.0, -3.0),
                emission: emission(10.0),
            }],
            point: (0..points).map(|n| lamp(n as f64)).collect(),
            spot: vec![SpotLight {
                point: lamp(20.0),
                direction: DVec3::new(0.0, 0.0, -1.0),
                cone: Cone { inner_cos: 0.75, outer_cos: 0.5, degrees: Some([41.4, 60.0]) },
            }],
        },
        materials: vec![Material {
            name: "m".to_string(),
            ambient: surface([0, 0, 0]),
            diffuse: surface([255, 0, 51]),
            specular: Surface::Constant(DVec3::new(0.25, 0.5, 0.75)),
            shininess: 32.0,
            reflectance: 1.0,
        }],
    }
}

#[test]
fn members_hold_what_the_map_says_and_unused_slots_are_zero() {
    let source = ours("view_space/scene_450.frag");
    let shader = shader(&source);
    let filler = BlockWriter::new(&shader, &guessed(&source)).expect("it fits");
    let upload = upload(3);
    // Two of the three, in another order.
    let lit = LightSet { ambient: true, numbers: [vec![0], vec![2, 0], vec![0]] };
    let blocks = filler.blocks(&upload, &lit, &upload.materials[0], None).expect("there is room");
    let at = |name: &str| {
        let number = shader.blocks().iter().position(|b| &*b.layout.name == name);
        let number = number.unwrap_or_else(|| panic!("no `{name}`"));
        Buffer::from_bytes(&shader.blocks()[number].layout, &blocks[number]).expect("its bytes")
    };
    let lights = at("LightBlock");
    let vector = |path: &str| lights.get::<[f32; 3]>(path).unwrap_or_else(|e| panic!("{e}"));
    let number = |path: &str| lights.get::<f32>(path).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(vector("cameraPosition"), [7.0, 8.0, 9.0]);
    assert_eq!(vector("ambientLight.color"), [0.5, 0.25, 0.125]);
    assert_eq!(vector("dirLight.direction"), [1.0, 2.0, 3.0], "towards the light");
    assert_eq!(vector("pointLights[0].position"), [2.0, 2.0, 3.0]);
    assert_eq!(vector("pointLights[1].position"), [0.0, 2.0, 3.0]);
    assert_eq!(number("pointLights[0].att.exponent"), 2.75);
    assert_eq!(number("pointLights[2].intensity"), 0.0);
    assert_eq!(number("spotLights[0].cutoff"), 0.5);
    assert_eq!(vector("spotLights[0].conedir"), [0.0, 0.0, -1.0], "the way the light travels");
    let material = at("MaterialBlock");
    let four = |path: &str| material.get::<[f32; 4]>(path).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(four("material.diffuse"), [1.0; 4], "the texture has the colour");
    assert_eq!(four("material.specular"), [0.25, 0.5, 0.75, 1.0]);
    let textures = filler.textures(&upload.materials[0]);
    assert_eq!(textures[0].texels, [[1.0, 0.0, 0.2, 1.0]]);
}

#[test]
fn more_lights_than_slots_are_refused_with_both_numbers_or_left_out() {
    let source = ours("six_lights/phong_330.frag");
    let filler = BlockWriter::new(&shader(&source), &guessed(&source)).expect("it fits");
    let upload = upload(6);
    let error = filler.lights(&upload.lights, OverflowPolicy::Refuse).expect_err("four slots");
    let BindError::TooManyLights { lights: 6, slots: 4, .. } = error else { panic!("{error}") };
    golden().eq(
        error.to_string(),
        str!["the scene has 6 point lights, but `pointLights[].position` has slots for 4"],
    );
    let kept = filler.lights(&upload.lights, OverflowPolicy::LeaveOut).expect("left out");
    assert_eq!(kept.of(Kind::Point), [0, 1, 2, 3]);
    let lit = LightSet::first([0, 5, 0]);
    assert!(filler.blocks(&upload, &lit, &upload.materials[0], None).is_err());
}

#[test]
fn storage_arrays_are_as_long_as_the_lights() {
    let source = ours("many_lights/windowed_listed_450.frag");
    let shader = shader(&source);
    let filler = BlockWriter::new(&shader, &guessed(&source)).expect("it fits");
    let upload = upload(4);
    let lit = LightSet::first([1, 4, 0]);
    let blocks = filler.blocks(&upload, &lit, &upload.materials[0], None).expect("there is room");
    let at = |name: &str| {
        let number = shader.blocks().iter().position(|b| &*b.layout.name == name);
        let number = number.unwrap_or_else(|| panic!("no `{name}`"));
        Buffer::from_bytes(&shader.blocks()[number].layout, &blocks[number]).expect("its bytes")
    };
    let points = at("PointLightBlock");
    assert_eq!(points.tail_len(), 4);
    assert_eq!(points.get::<u32>("pointCount"), Ok(4));
    assert_eq!(points.get::<f32>("pointLights[3].range"), Ok(1e18), "it ends nowhere");
    // Without lists all lights are in one tile.
    assert_eq!(at("TileBlock").get::<u32>("tiles[0].count"), Ok(4));
    assert_eq!(at("IndexBlock").tail_len(), 4);
}

#[test]
fn the_pixel_is_counted_as_the_language_does() {
    let lit = "uniform vec3 lightPos; uniform vec3 lightColor;";
    let fragment = Fragment {
        pixel: 11,
        material: 0,
        object: 0,
        position: [0.0; 3],
        normal: [0.0, 0.0, 1.0],
        uv: [0.0; 2],
    };
    let one = Chosen { all: &[fragment], numbers: &[0] };
    let gl = format!(
        "#version 330\n{lit}\nout vec4 c;\nvoid main() {{ c = gl_FragCoord + vec4(lightPos * lightColor, 0.0); }}"
    );
    let wgsl = "struct Lamp { position: vec3f, color: vec3f, constant: f32 }
        @group(0) @binding(0) var<uniform> lamp: Lamp;
        @fragment fn main(@builtin(position) at: vec4f) -> @location(0) vec4f {
            return at + vec4f(lamp.position * lamp.color * lamp.constant, 0.0);
        }";
    // A picture of 4 by 5: pixel 11 is the last of the third row from the top.
    for (name, text, row) in [("p.frag", gl.as_str(), 2.5), ("p.wgsl", wgsl, 2.5)] {
        let source = Source::new(name, text);
        let shader = shader(&source);
        let filler = BlockWriter::new(&shader, &guessed(&source)).expect("it fits");
        let inputs = filler.inputs(one, [4, 5]);
        assert_eq!(inputs, [vec![[3.5, row, 0.0, 1.0]]], "{name}");
        let inputs = filler.inputs(one, [4, 8]);
        let row = if name == "p.frag" { 5.5 } else { 2.5 };
        assert_eq!(inputs, [vec![[3.5, row, 0.0, 1.0]]], "{name}");
    }
}
