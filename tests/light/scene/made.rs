//! Scenes by seed, held against the rules they are made by.

use glam::{DVec3, dvec3};
use landfall_light::scene::{Generate, RandomCubes, RandomLights, Scene, generate};
use landfall_light::{Frame, FrameOptions};

use crate::scene::of_repository;

/// The published generator, written once more.
struct SplitMix(u64);

impl SplitMix {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(11_400_714_819_323_198_485);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(13_787_848_793_156_543_929);
        let z = (z ^ (z >> 27)).wrapping_mul(10_723_151_780_598_845_931);
        z ^ (z >> 31)
    }

    fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * 2_f64.powi(-53)
    }
}

#[test]
fn lamps_are_drawn_in_the_order_that_is_documented() {
    let scene = of_repository("lights_1024");
    let mut random = SplitMix(42);
    // Linear and quadratic coefficients of 7, 13, 20 and 32 m.
    let rows = [[0.7, 1.8], [0.35, 0.44], [0.22, 0.2], [0.14, 0.07]];
    assert_eq!(scene.lights.point.len(), 1024);
    for lamp in &scene.lights.point {
        let (x, z) = ((random.unit() - 0.5) * 100.0, (random.unit() - 0.5) * 100.0);
        let y = 0.5 + 3.5 * random.unit();
        assert_eq!(lamp.position, dvec3(x, y, z));
        let color = dvec3(random.unit(), random.unit(), random.unit());
        assert_eq!((lamp.emission.color, lamp.emission.intensity), (color, 0.6));
        assert_eq!(lamp.emission.diffuse, color * 0.6);
        let row = rows[(random.bits() % 4) as usize];
        assert_eq!([lamp.attenuation.linear, lamp.attenuation.quadratic], row);
        assert_eq!((lamp.attenuation.constant, lamp.attenuation.range), (1.0, None));
    }
}

#[test]
fn windowed_lamps_end_where_they_have_sunk() {
    let (open, windowed) = (of_repository("lights_1024"), of_repository("lights_1024_windowed"));
    assert_eq!(open.objects, windowed.objects);
    for (open, windowed) in open.lights.point.iter().zip(&windowed.lights.point) {
        assert_eq!((open.position, open.emission), (windowed.position, windowed.emission));
        let brightest = open.emission.diffuse.max_element();
        let a = windowed.attenuation;
        match a.range {
            Some(d) => {
                let sunk = brightest / (a.constant + d * (a.linear + d * a.quadratic));
                assert!((sunk * 256.0 / 5.0 - 1.0).abs() < 1e-12, "{a:?}");
            }
            None => assert!(brightest <= 5.0 / 256.0),
        }
    }
}

#[test]
fn cubes_stand_on_the_floor() {
    let scene = of_repository("lights_1024");
    assert_eq!(scene.objects.len(), 201);
    for object in &scene.objects[1..] {
        let corners = object.mesh.vertices.iter();
        let at: Vec<DVec3> =
            corners.map(|vertex| object.transform.transform_point3(vertex.position)).collect();
        let low = at.iter().map(|at| at.y).fold(f64::INFINITY, f64::min);
        let high = at.iter().map(|at| at.y).fold(0.0, f64::max);
        assert!(low.abs() < 1e-12 && (0.5..=3.0).contains(&high), "{low} {high}");
        // All three edges are as long: it is turned, not stretched.
        for axis in [object.transform.x_axis, object.transform.y_axis, object.transform.z_axis] {
            assert!((axis.length() - high).abs() < 1e-12);
        }
    }
    // The floor is seen, and so are most of the cubes.
    let frame = Frame::new(&scene, &FrameOptions::default());
    let mut seen: Vec<u32> = frame.fragments.iter().map(|fragment| fragment.object).collect();
    seen.sort_unstable();
    seen.dedup();
    assert!(seen[0] == 0 && seen.len() > 120, "{}", seen.len());
}

#[test]
fn another_seed_is_another_scene_and_the_same_seed_the_same() {
    let made = |seed, omit| {
        generate(&Generate {
            seed,
            area: [10.0, 20.0],
            lights: Some(RandomLights {
                count: 9,
                height: [1.0, 2.0],
                attenuations: Vec::new(),
                gain: 1.0,
                window: None,
                omit,
            }),
            cubes: Some(RandomCubes { count: 4, edge: [1.0, 1.0], material: 0 }),
            floor: None,
        })
    };
    assert_eq!(made(1, false), made(1, false));
    let ((a, cubes), (b, _)) = (made(1, false), made(2, false));
    assert_eq!(made(1, true), (Vec::new(), cubes.clone()), "the cubes stand as with lights");
    assert_eq!((a.len(), cubes.len()), (9, 4));
    assert!(a.iter().zip(&b).all(|(a, b)| a.position != b.position));
}

/// How far the windows let through: the limit of culling that scene.
#[test]
fn a_fragment_of_the_windowed_scene_is_in_range_of_few_lamps() {
    let mut scene: Scene = of_repository("lights_1024_windowed");
    scene.size = [160, 90];
    let fragments = Frame::new(&scene, &FrameOptions::default()).fragments;
    let near = |at: DVec3| {
        let lamps = scene.lights.point.iter();
        lamps.filter(|l| l.attenuation.range.is_some_and(|r| l.position.distance(at) < r)).count()
    };
    let all: usize =
        fragments.iter().map(|f| near(DVec3::from_array(f.position.map(f64::from)))).sum();
    let mean = all as f64 / fragments.len() as f64;
    // One in thirty and more: 1.5 times that is still 20 times fewer than all.
    assert!((20.0..34.2).contains(&mean), "{mean}");
}
