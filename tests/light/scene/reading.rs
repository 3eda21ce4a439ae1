//! What a scene says is what is read.

use glam::{DMat4, DVec3, dvec3};
use landfall_light::scene::{Space, Surface};

use crate::scene::{RIGHT, folder, names, of_repository, read_alone, scene};

#[test]
fn everything_of_a_scene_is_read() {
    let reading = read_alone(RIGHT);
    assert!(reading.diagnostics.is_empty(), "{:#?}", reading.diagnostics);
    let scene = reading.scene.expect("nothing is wrong with it");
    assert_eq!(scene.name, "right");
    assert_eq!(scene.size, [64, 36]);
    assert_eq!(scene.background, dvec3(0.1, 0.2, 0.3));
    assert_eq!(scene.space, Space::View);
    let camera = scene.camera;
    assert_eq!(camera.position, dvec3(0.0, 1.0, 5.0));
    assert_eq!((camera.front, camera.up), (-DVec3::Z, DVec3::Y));
    assert_eq!([camera.fov, camera.near, camera.far], [45.0, 0.1, 50.0]);
    assert_eq!(scene.shader, Some(serde_json::json!({"glsl": "lights.frag"})));
    assert_eq!(scene.model, Some("phong".into()));
    let bind = scene.bind.expect("it binds");
    assert_eq!(bind["point"], "pointLights[]");
}

#[test]
fn a_light_gives_a_colour_and_intensity_or_a_colour_for_each_term() {
    let lights = scene(RIGHT).lights;
    let ambient = lights.ambient.expect("there is one");
    assert_eq!((ambient.color, ambient.intensity), (dvec3(1.0, 0.9, 0.8), 0.3));

    let [one, terms] = [lights.directional[0].emission, lights.directional[1].emission];
    assert_eq!((one.color, one.intensity), (DVec3::splat(0.5), 2.0));
    assert_eq!((one.ambient, one.diffuse, one.specular), (DVec3::ZERO, DVec3::ONE, DVec3::ONE));
    assert_eq!((terms.color, terms.intensity), (DVec3::splat(0.4), 1.0));
    assert_eq!(terms.ambient, DVec3::splat(0.05));
    assert_eq!((terms.diffuse, terms.specular), (DVec3::splat(0.4), DVec3::splat(0.6)));

    let both = lights.point[1].emission;
    assert_eq!((both.ambient, both.diffuse), (DVec3::splat(0.125), DVec3::ONE));
    let diffuse = lights.spot[0].point.emission;
    assert_eq!(diffuse.specular, dvec3(0.7, 0.8, 0.9));
}

#[test]
fn directions_are_of_unit_length_unless_told_otherwise() {
    let lights = scene(RIGHT).lights;
    assert_eq!(lights.directional[0].direction, dvec3(0.0, -1.0, 0.0));
    assert_eq!(lights.directional[1].direction, dvec3(0.0, -4.0, 0.0));
    // Of a length whose square is no number.
    let tiny = RIGHT.replace("\"front\": [0, 0, -2]", "\"front\": [0, 3e-30, -4e-30]");
    assert!((scene(&tiny).camera.front - dvec3(0.0, 0.6, -0.8)).length() < 1e-15);
    let target = RIGHT.replace("\"front\": [0, 0, -2]", "\"target\": [3, 1, 1]");
    assert!((scene(&target).camera.front - dvec3(0.6, 0.0, -0.8)).length() < 1e-15);
}

#[test]
fn attenuation_is_given_or_a_row_of_the_table_or_none() {
    let lights = scene(RIGHT).lights;
    let given = lights.point[0].attenuation;
    assert_eq!([given.constant, given.linear, given.quadratic], [1.0, 0.09, 0.032]);
    assert_eq!(given.range, Some(9.0));
    let row = lights.point[1].attenuation;
    assert_eq!([row.constant, row.linear, row.quadratic], [1.0, 0.35, 0.44]);
    assert_eq!(row.range, None);
    let none = lights.spot[0].point.attenuation;
    assert_eq!([none.constant, none.linear, none.quadratic], [1.0, 0.0, 0.0]);
}

#[test]
fn cones_are_angles_or_cosines() {
    let lights = scene(RIGHT).lights;
    let degrees = lights.spot[0].cone;
    assert_eq!(degrees.degrees, Some([12.5, 17.5]));
    // cos 12.5 and cos 17.5 degrees, from a table.
    assert!((degrees.inner_cos - 0.976_296_007_119_933_4).abs() < 1e-15);
    assert!((degrees.outer_cos - 0.953_716_950_748_226_9).abs() < 1e-15);
    let cosines = lights.spot[1].cone;
    assert_eq!((cosines.inner_cos, cosines.outer_cos, cosines.degrees), (0.75, 0.5, None));
    let hard = lights.spot[2].cone;
    assert_eq!(hard.degrees, Some([60.0, 60.0]));
    assert_eq!(hard.inner_cos, hard.outer_cos);
    assert!((hard.outer_cos - 0.5).abs() < 1e-15);
}

#[test]
fn materials_are_colours_and_textures() {
    let materials = scene(RIGHT).materials;
    let plain = &materials[0];
    assert_eq!(plain.diffuse, Surface::Constant(dvec3(0.8, 0.7, 0.6)));
    assert_eq!(plain.ambient, plain.diffuse);
    assert_eq!(plain.specular, Surface::Constant(DVec3::ZERO));
    assert_eq!((plain.shininess, plain.reflectance), (32.0, 1.0));
    let drawn = &materials[1];
    assert_eq!((drawn.shininess, drawn.reflectance), (64.0, 0.5));
    let Surface::Texture(rows) = &drawn.diffuse else { panic!("{:?}", drawn.diffuse) };
    let (a, b) = ([255, 0, 7], [1, 2, 3]);
    assert_eq!((rows.width, rows.height, rows.srgb), (2, 3, true));
    assert_eq!(rows.texels, [a, b, b, a, a, a]);
    let Surface::Texture(checker) = &drawn.specular else { panic!("{:?}", drawn.specular) };
    let (x, o) = ([0, 0, 0], [9, 9, 9]);
    assert_eq!((checker.width, checker.height, checker.srgb), (3, 3, false));
    assert_eq!(checker.texels, [x, o, x, o, x, o, x, o, x]);
}

#[test]
fn objects_are_scaled_then_turned_then_moved() {
    let objects = scene(RIGHT).objects;
    // A quarter turn about z takes x to y, exactly.
    let turned = objects[0].transform;
    assert_eq!(turned.transform_point3(DVec3::X), dvec3(0.0, 1.5, 0.0));
    assert_eq!(turned.transform_point3(DVec3::Y), dvec3(-1.0, 0.5, 0.0));
    let stretched = objects[1].transform;
    assert_eq!(stretched.transform_point3(dvec3(0.5, 0.5, 0.0)), dvec3(2.5, 1.0, 0.0));
    assert_eq!(objects.iter().map(|object| object.material).collect::<Vec<_>>()[..3], [0, 1, 1]);
}

/// Against the rotation of another implementation.
#[test]
fn cubes_are_turned_about_their_axis() {
    let scene = of_repository("six_lights");
    for (i, object) in scene.objects.iter().enumerate() {
        let angle = (20.0 * i as f64).to_radians();
        let turn = DMat4::from_axis_angle(dvec3(1.0, 0.3, 0.5).normalize(), angle);
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            let (found, wanted) =
                (object.transform.transform_vector3(axis), turn.transform_vector3(axis));
            assert!((found - wanted).length() < 1e-15, "{i}: {found} {wanted}");
        }
    }
}

#[test]
fn the_only_material_need_not_be_named() {
    for object in of_repository("six_lights").objects {
        assert_eq!(object.material, 0);
    }
}

#[test]
fn the_scenes_of_the_repository_are_right() {
    let names = names();
    assert!(names.len() >= 9, "{names:?}");
    for name in names {
        let scene = of_repository(&name);
        assert!(!scene.objects.is_empty(), "{name}");
    }
}

#[test]
fn the_scenes_of_the_repository_are_as_published() {
    let six = of_repository("six_lights");
    assert_eq!(six.size, [800, 600]);
    assert_eq!((six.objects.len(), six.lights.point.len(), six.lights.spot.len()), (10, 4, 1));
    assert_eq!(six.lights.directional[0].direction, dvec3(-0.2, -1.0, -0.3));
    assert_eq!(six.lights.spot[0].cone.degrees, Some([12.5, 15.0]));

    let two = of_repository("two_of_128");
    let colors: Vec<DVec3> = two.lights.point.iter().map(|lamp| lamp.emission.color).collect();
    assert_eq!(colors, [DVec3::X, DVec3::Y]);
    // -z turned by (0, 60, 0) and by (240, 0, 0) degrees.
    let turned =
        [DMat4::from_rotation_y(60_f64.to_radians()), DMat4::from_rotation_x(240_f64.to_radians())];
    for (sun, turn) in two.lights.directional.iter().zip(turned) {
        assert!((sun.direction - turn.transform_vector3(-DVec3::Z)).length() < 1e-15);
    }

    let view = of_repository("view_space");
    assert_eq!(view.space, Space::View);
    assert_eq!(view.lights.spot[0].cone.degrees, Some([60.0, 60.0]));
    assert_eq!(view.lights.directional[0].direction, -DVec3::Y);
}

/// Members that only a renderer understands have places too.
#[test]
fn the_place_of_a_value_can_be_asked_for() {
    let reading = read_alone(RIGHT);
    let place = reading.place("bind.point").expect("it is there");
    assert_eq!(reading.files.text(place), "\"pointLights[]\"");
    let place = reading.place("lights.point[1].position").expect("it is there");
    assert_eq!(reading.files.text(place), "[3, 2, 1]");
    assert_eq!(reading.place("bind.spot"), None);
}

#[test]
fn a_byte_order_mark_is_no_part_of_a_scene() {
    assert!(read_alone(&format!("\u{feff}{RIGHT}")).scene.is_some());
}

#[test]
fn a_scene_that_is_no_file_is_an_error() {
    let error = landfall_light::scene::read_file(folder().join("gone.json")).unwrap_err();
    assert!(error.message.starts_with("cannot be read"), "{error}");
}
