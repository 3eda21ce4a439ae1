//! Lights and materials in the space of their lighting, against numbers computed by hand.

use glam::{DVec3, dvec3};
use landfall_light::Upload;
use landfall_light::scene::{Space, Surface};

use crate::scene::{RIGHT, of_repository, scene};

/// The camera at (1, 2, 3) looks along x: its right is z, its up is y, behind it is -x.
fn looking_along_x(space: Space) -> Upload {
    let mut scene = scene(
        &RIGHT
            .replace("[0, 1, 5]", "[1, 2, 3]")
            .replace("\"front\": [0, 0, -2]", "\"front\": [4, 0, 0]")
            .replace(
                "\"position\": [1, 2, 3],\n        \"color\"",
                "\"position\": [4, 2.5, 5],\n        \"color\"",
            ),
    );
    scene.space = space;
    Upload::new(&scene)
}

#[test]
fn in_world_space_everything_stays_where_it_is() {
    let upload = looking_along_x(Space::World);
    assert_eq!(upload.camera, dvec3(1.0, 2.0, 3.0));
    assert_eq!(upload.lights.point[0].position, dvec3(4.0, 2.5, 5.0));
    assert_eq!(upload.lights.directional[1].direction, dvec3(0.0, -4.0, 0.0));
}

#[test]
fn in_view_space_the_camera_looks_along_minus_z() {
    let upload = looking_along_x(Space::View);
    assert_eq!(upload.camera, DVec3::ZERO);
    // (3, 0.5, 2) from the camera: 2 to the right, 0.5 up, 3 ahead.
    assert_eq!(upload.lights.point[0].position, dvec3(2.0, 0.5, -3.0));
    assert_eq!(upload.lights.spot[0].direction, dvec3(0.0, -1.0, 0.0));
    // (1, 0, -2) from the camera: along x is ahead.
    assert_eq!(upload.lights.spot[2].point.position, dvec3(-3.0, 2.0, -1.0));
}

#[test]
fn relative_to_the_camera_only_places_change() {
    let upload = looking_along_x(Space::CameraRelative);
    assert_eq!(upload.camera, DVec3::ZERO);
    assert_eq!(upload.lights.point[0].position, dvec3(3.0, 0.5, 2.0));
    assert_eq!(upload.lights.directional[1].direction, dvec3(0.0, -4.0, 0.0));
}

#[test]
fn every_number_is_that_of_an_f32() {
    let upload = Upload::new(&of_repository("six_lights"));
    let point = &upload.lights.point[1];
    assert_eq!(point.position, dvec3(f64::from(2.3_f32), f64::from(-3.3_f32), -4.0));
    assert_eq!(point.attenuation.linear, f64::from(0.09_f32));
    assert_eq!(point.attenuation.quadratic, f64::from(0.032_f32));
    assert_eq!(point.emission.diffuse, DVec3::splat(f64::from(0.8_f32)));
    let sun = &upload.lights.directional[0];
    assert_eq!(sun.direction, dvec3(f64::from(-0.2_f32), -1.0, f64::from(-0.3_f32)));
    // The nearest floats to cos 12.5 and cos 15 degrees; the angles stay as they are written.
    let cone = upload.lights.spot[0].cone;
    assert_eq!(cone.inner_cos, f64::from(0.976_296_007_119_933_4_f64 as f32));
    assert_eq!(cone.outer_cos, f64::from(0.965_925_826_289_068_3_f64 as f32));
    assert_eq!(cone.degrees, Some([12.5, 15.0]));

    let materials = Upload::new(&scene(RIGHT)).materials;
    let color =
        Surface::Constant(dvec3(f64::from(0.8_f32), f64::from(0.7_f32), f64::from(0.6_f32)));
    assert_eq!(materials[0].diffuse, color);
    assert_eq!(materials[1].diffuse, scene(RIGHT).materials[1].diffuse);
}

/// What a subtraction in `f32` would round away: at a million, its numbers are 1/16 apart.
#[test]
fn far_from_the_origin_nothing_is_lost_relative_to_the_camera() {
    let mut scene = scene(RIGHT);
    let away = dvec3(1_000_000.0, 0.0, -1_000_000.0);
    scene.camera.position = away;
    scene.lights.point[0].position = away + dvec3(0.01, 0.0, 0.0);
    scene.space = Space::CameraRelative;
    let found = Upload::new(&scene).lights.point[0].position;
    assert!((found - dvec3(0.01, 0.0, 0.0)).length() < 1e-9, "{found}");
}
