//! Meshes from OBJ text, and textures from PNG files, as a scene names them.

use std::collections::HashMap;

use glam::{DVec3, dvec2, dvec3};
use landfall_layout::Error;
use landfall_light::scene::{Mesh, Reading, cube, plane, read, read_obj, sphere};

/// A scene of one mesh.
fn of_mesh(file: &str) -> String {
    format!(
        "{{\"size\": [8, 8], \"camera\": {{\"position\": [0, 0, 3], \"front\": [0, 0, -1], \"fov\": 45}},
  \"materials\": [{{\"name\": \"a\", \"diffuse\": 1}}],
  \"objects\": [{{\"mesh\": {{\"obj\": \"{file}\"}}}}]}}"
    )
}

fn read_with(text: &str, files: &[(&str, &[u8])]) -> Reading {
    let files: HashMap<&str, &[u8]> = files.iter().copied().collect();
    let open = |name: &str| match files.get(name) {
        Some(bytes) => Ok(bytes.to_vec()),
        None => Err(Error::new(name, "cannot be read: no such file")),
    };
    read("scenes/scene.json", text, &open)
}

/// Every triangle's own normal is on the side of its corners' normals.
fn faces_outwards(mesh: &Mesh) {
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|corner| mesh.vertices[corner as usize]);
        let across = (b.position - a.position).cross(c.position - a.position);
        assert!(across.length() > 1e-6, "{triangle:?} has an area");
        for corner in [a, b, c] {
            assert!(across.dot(corner.normal) > 0.0, "{triangle:?}");
        }
    }
}

/// Six times the volume inside a mesh that is closed.
fn volume(mesh: &Mesh) -> f64 {
    let part = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|corner| mesh.vertices[corner as usize].position);
        a.dot(b.cross(c))
    };
    mesh.triangles.iter().map(part).sum()
}

#[test]
fn a_cube_has_an_edge_of_1() {
    let cube = cube();
    assert_eq!((cube.vertices.len(), cube.triangles.len()), (24, 12));
    faces_outwards(&cube);
    assert!((volume(&cube) - 6.0).abs() < 1e-12);
    // Corners of a well-known array of 36: position, normal, coordinates.
    for (position, normal, uv) in [
        ([-0.5, -0.5, -0.5], -DVec3::Z, [0.0, 0.0]),
        ([0.5, 0.5, -0.5], -DVec3::Z, [1.0, 1.0]),
        ([0.5, -0.5, 0.5], DVec3::Z, [1.0, 0.0]),
        ([-0.5, 0.5, 0.5], -DVec3::X, [1.0, 0.0]),
        ([-0.5, -0.5, -0.5], -DVec3::X, [0.0, 1.0]),
        ([0.5, 0.5, -0.5], DVec3::X, [1.0, 1.0]),
        ([0.5, -0.5, -0.5], -DVec3::Y, [1.0, 1.0]),
        ([-0.5, 0.5, 0.5], DVec3::Y, [0.0, 0.0]),
    ] {
        let (position, uv) = (DVec3::from_array(position), dvec2(uv[0], uv[1]));
        let found = cube.vertices.iter().find(|v| v.position == position && v.normal == normal);
        assert_eq!(found.map(|vertex| vertex.uv), Some(uv), "{position} {normal}");
    }
}

#[test]
fn a_sphere_is_closed_and_round() {
    for (segments, rings) in [(3, 2), (8, 4), (64, 32)] {
        let sphere = sphere(segments, rings);
        assert_eq!(sphere.triangles.len() as u32, 2 * segments * (rings - 1));
        faces_outwards(&sphere);
        for vertex in &sphere.vertices {
            assert!((vertex.normal.length() - 1.0).abs() < 1e-15);
            assert!((vertex.position - vertex.normal * 0.5).length() < 1e-15);
        }
    }
    // Pi, of a diameter of 1 times six; a ball of flat triangles is a little smaller.
    let volume = volume(&sphere(256, 128));
    assert!((volume / std::f64::consts::PI - 1.0).abs() < 1e-3, "{volume}");
}

#[test]
fn a_plane_faces_up_and_repeats_its_texture() {
    let plane = plane(4.0);
    faces_outwards(&plane);
    assert!(
        plane.vertices.iter().all(|vertex| vertex.normal == DVec3::Y && vertex.position.y == 0.0)
    );
    let most = plane.vertices.iter().map(|vertex| vertex.uv.max_element()).fold(0.0, f64::max);
    assert_eq!(most, 4.0);
}

const QUAD: &str = "# a square
mtllib none.mtl
o square
v -1 -1 0
v 1 -1 0
v 1 1 0 1.0
v -1 1 0
vt 0 0
vt 1 0
vt 1 1
vt 0 1
vn 0 0 2
s off
f 1/1/1 2/2/1 3/3/1 4/4/1
";

#[test]
fn polygons_become_triangles() {
    let read = read_obj(QUAD).expect("it is right");
    assert_eq!((read.flat, read.triangles), (0, 2));
    let mesh = read.mesh;
    // Corners that are the same are made once.
    assert_eq!(mesh.vertices.len(), 4);
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(mesh.vertices[2].position, dvec3(1.0, 1.0, 0.0));
    assert_eq!(mesh.vertices[2].uv, dvec2(1.0, 1.0));
    // The length of a normal is kept.
    assert_eq!(mesh.vertices[2].normal, dvec3(0.0, 0.0, 2.0));
}

#[test]
fn negative_indices_count_back_from_the_last() {
    let back = QUAD.replace("f 1/1/1 2/2/1 3/3/1 4/4/1", "f -4/-4/-1 -3/-3/-1 -2/-2/-1 -1/-1/-1");
    assert_eq!(read_obj(&back), read_obj(QUAD));
    let later = format!("{back}v 9 9 9\n");
    assert_eq!(read_obj(&later), read_obj(QUAD));
}

#[test]
fn faces_without_normals_are_flat_and_it_is_said() {
    let text = "v 0 0 0\nv 2 0 0\nv 0 2 0\nv 0 0 2\nf 1 2 3\nf 1 3 4\nf 1 1 2\n";
    let read = read_obj(text).expect("it is right");
    // The third has no area and is not drawn.
    assert_eq!((read.flat, read.triangles, read.mesh.triangles.len()), (3, 3, 2));
    let normals: Vec<DVec3> = read.mesh.vertices.iter().map(|vertex| vertex.normal).collect();
    assert_eq!(normals, [DVec3::Z, DVec3::Z, DVec3::Z, DVec3::X, DVec3::X, DVec3::X]);

    let reading = read_with(&of_mesh("corner.obj"), &[("corner.obj", text.as_bytes())]);
    let scene = reading.scene.expect("it can be drawn");
    assert_eq!(scene.objects[0].mesh, read.mesh);
    let [found] = &reading.diagnostics[..] else { panic!("{:#?}", reading.diagnostics) };
    assert_eq!(found.code.name(), "mesh-without-normals");
    assert_eq!(
        found.message,
        "`corner.obj` has no normals for 3 of its 3 triangles: they are drawn flat"
    );
    let place = reading.files.locate(found.labels[0].at);
    assert_eq!((place.path.as_str(), place.line, place.column), ("scenes/corner.obj", 5, 1));
}

#[test]
fn what_is_wrong_with_a_mesh_is_named_by_line() {
    for (change, line, column, says) in [
        (["v 1 -1 0", "v 1 one 0"], 5, 5, "`one` is not a number"),
        (["v 1 -1 0", "v 1 -1"], 5, 1, "`v` has 3 numbers, not 2"),
        (["v 1 -1 0", "v 1 nan 0"], 5, 5, "`nan` is not a finite number up to 1e18"),
        (["v 1 -1 0", "v 1 1e19 0"], 5, 5, "`1e19` is not a finite number up to 1e18"),
        (["s off", "sx off"], 13, 1, "`sx` is not an OBJ statement"),
        (["vn 0 0 2", "vn 0 0 0"], 12, 1, "a normal without a direction"),
        (["2/2/1", "5/2/1"], 14, 9, "`5` is outside the 4 `v` lines so far"),
        (["2/2/1", "-5/2/1"], 14, 9, "`-5` is outside the 4 `v` lines so far"),
        (["2/2/1", "0/2/1"], 14, 9, "`0` is outside the 4 `v` lines so far"),
        (["2/2/1", "2/9/1"], 14, 9, "`9` is outside the 4 `vt` lines so far"),
        (["2/2/1", "2/2/2"], 14, 9, "`2` is outside the 1 `vn` lines so far"),
        (["2/2/1", "2/2/1/1"], 14, 9, "has more than two `/`"),
        (["2/2/1", "9223372036854775808"], 14, 9, "is not an index of a `v` line"),
        ([" 2/2/1 3/3/1 4/4/1", " 2/2/1"], 14, 1, "a face has 3 corners or more, not 2"),
        (["f 1/1/1", "# f 1/1/1"], 1, 1, "has no faces"),
    ] {
        let text = QUAD.replace(change[0], change[1]);
        assert_ne!(text, QUAD);
        let reading = read_with(&of_mesh("quad.obj"), &[("quad.obj", text.as_bytes())]);
        assert!(reading.scene.is_none());
        let [found] = &reading.diagnostics[..] else { panic!("{:#?}", reading.diagnostics) };
        assert!(found.message.contains(says), "{} {says}", found.message);
        let place = reading.files.locate(found.labels[0].at);
        assert_eq!(
            (place.path.as_str(), place.line, place.column),
            ("scenes/quad.obj", line, column),
            "{says}"
        );
    }
}

#[test]
fn a_file_read_for_two_objects_is_read_and_told_of_once() {
    let text =
        of_mesh("bad.obj").replace("[{\"mesh\"", "[{\"mesh\": {\"obj\": \"bad.obj\"}}, {\"mesh\"");
    let reading = read_with(&text, &[("bad.obj", b"v 1 2\n")]);
    let codes: Vec<&str> = reading.diagnostics.iter().map(|found| found.code.name()).collect();
    assert_eq!(codes, ["wrong-mesh"]);
    assert_eq!(reading.files.iter().count(), 2);
}

#[test]
fn files_that_cannot_be_read_are_pointed_at_in_the_scene() {
    for (bytes, says) in [
        (None, "`objects[0].mesh.obj` cannot be read: no such file"),
        (Some(&b"\xff\xfe"[..]), "`objects[0].mesh.obj` is UTF-16"),
        (Some(b"v \xf0"), "`objects[0].mesh.obj` is not UTF-8: byte 0xf0 at line 1, column 3"),
    ] {
        let files: Vec<(&str, &[u8])> = bytes.iter().map(|bytes| ("a.obj", *bytes)).collect();
        let reading = read_with(&of_mesh("a.obj"), &files);
        let [found] = &reading.diagnostics[..] else { panic!("{:#?}", reading.diagnostics) };
        assert!(found.message.starts_with(says), "{}", found.message);
        assert_eq!(reading.files.text(found.labels[0].at), "\"a.obj\"");
    }
}

#[test]
fn a_mutated_mesh_never_panics() {
    let mut random = fastrand::Rng::with_seed(8);
    let (mut right, mut wrong) = (0, 0);
    for _ in 0..5000 {
        let mut bytes = QUAD.as_bytes().to_vec();
        for _ in 0..random.usize(1..4) {
            let at = random.usize(..bytes.len());
            match random.u8(..3) {
                0 => bytes[at] = *random.choice(b"0123456789-/. vfn\n\t#e").expect("some"),
                1 => drop(bytes.remove(at)),
                _ => bytes.insert(at, *random.choice(b"0123456789-/. vfn\n\t#e").expect("some")),
            }
        }
        match read_obj(&String::from_utf8(bytes).expect("all of it is ASCII")) {
            Ok(read) => {
                right += 1;
                let len = read.mesh.vertices.len() as u32;
                assert!(read.mesh.triangles.iter().flatten().all(|corner| *corner < len));
            }
            Err(faults) => {
                wrong += 1;
                assert!(!faults.is_empty());
            }
        }
    }
    assert!(right > 500 && wrong > 500, "{right} {wrong}");
}

#[cfg(feature = "cli")]
mod textures {
    use landfall_light::scene::Surface;

    use super::{of_mesh, read_with};

    fn png(color: png::ColorType, depth: png::BitDepth, size: [u32; 2], data: &[u8]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, size[0], size[1]);
        encoder.set_color(color);
        encoder.set_depth(depth);
        let mut writer = encoder.write_header().expect("it can be written");
        writer.write_image_data(data).expect("it can be written");
        writer.finish().expect("it can be written");
        bytes
    }

    fn scene() -> String {
        of_mesh("")
            .replace("{\"obj\": \"\"}", "\"cube\"")
            .replace("\"diffuse\": 1", "\"diffuse\": {\"png\": \"a.png\", \"srgb\": true}")
    }

    #[test]
    fn a_png_becomes_texels_from_its_upper_row() {
        use png::BitDepth::{Eight, Sixteen};
        use png::ColorType::{Grayscale, Rgb, Rgba};
        let (red, blue) = ([255, 0, 0], [1, 2, 3]);
        for (bytes, wanted) in [
            (png(Rgb, Eight, [1, 2], &[255, 0, 0, 1, 2, 3]), [red, blue]),
            (png(Rgba, Eight, [1, 2], &[255, 0, 0, 9, 1, 2, 3, 0]), [red, blue]),
            (png(Grayscale, Eight, [1, 2], &[7, 200]), [[7; 3], [200; 3]]),
            (png(Grayscale, Sixteen, [1, 2], &[7, 255, 200, 0]), [[7; 3], [200; 3]]),
        ] {
            let reading = read_with(&scene(), &[("a.png", &bytes)]);
            let scene = reading.scene.unwrap_or_else(|| panic!("{:#?}", reading.diagnostics));
            let Surface::Texture(texture) = &scene.materials[0].diffuse else { panic!("a colour") };
            assert_eq!((texture.width, texture.height, texture.srgb), (1, 2, true));
            assert_eq!(texture.texels, wanted);
        }
    }

    #[test]
    fn what_is_no_png_is_pointed_at() {
        let whole = png(png::ColorType::Rgb, png::BitDepth::Eight, [1, 2], &[255, 0, 0, 1, 2, 3]);
        let mut broken = whole.clone();
        broken[20] ^= 0x55;
        for bytes in [&b""[..], b"P6 1 1 255\n", &whole[..whole.len() / 2], &broken] {
            let reading = read_with(&scene(), &[("a.png", bytes)]);
            assert!(reading.scene.is_none());
            let [found] = &reading.diagnostics[..] else { panic!("{:#?}", reading.diagnostics) };
            assert!(
                found.message.starts_with("`materials[0].diffuse.png` is not a readable PNG"),
                "{}",
                found.message
            );
            assert_eq!(reading.files.text(found.labels[0].at), "\"a.png\"");
        }
    }
}
