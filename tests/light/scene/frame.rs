//! Fragments against rays shot through the pixels' centres at every triangle (Möller and
//! Trumbore 1997), in the scene's own space; and against what can be computed by hand.

use glam::{DMat3, DMat4, DVec2, DVec3, dvec2, dvec3};
use landfall_light::scene::{Camera, Lights, Mesh, Object, Space, Vertex, plane, sphere};
use landfall_light::{Fragment, Frame, FrameOptions, Scene, VertexNormals};

use crate::scene::{names, of_repository};
use crate::support::sample::sampled;

fn frame(scene: &Scene) -> Frame {
    Frame::new(scene, &FrameOptions::default())
}

/// What a ray meets.
#[derive(Clone, Copy)]
struct Hit {
    depth: f64,
    object: usize,
    position: DVec3,
    normal: DVec3,
    uv: DVec2,
    /// The least weight of a corner: near zero at an edge.
    margin: f64,
}

/// What the camera is looking at through the middle of a pixel; and the least margin by which
/// any triangle before it was met or missed.
fn cast(scene: &Scene, triangles: &[Corners], column: u32, row: u32) -> (Option<Hit>, f64) {
    let camera = &scene.camera;
    let [width, height] = scene.size.map(f64::from);
    let right = camera.front.cross(camera.up).normalize();
    let up = right.cross(camera.front).normalize();
    let slope = (camera.fov / 2.0).to_radians().tan();
    let x = ((f64::from(column) + 0.5) / width * 2.0 - 1.0) * slope * width / height;
    let y = (1.0 - (f64::from(row) + 0.5) / height * 2.0) * slope;
    let ray = camera.front.normalize() + right * x + up * y;
    let mut best: Option<Hit> = None;
    let mut closest = f64::INFINITY;
    for triangle in triangles {
        let [a, b, c] = triangle.position;
        let (e1, e2) = (b - a, c - a);
        let p = ray.cross(e2);
        let determinant = e1.dot(p);
        if determinant == 0.0 {
            continue;
        }
        let t = camera.position - a;
        let u = t.dot(p) / determinant;
        let q = t.cross(e1);
        let v = ray.dot(q) / determinant;
        let depth = e2.dot(q) / determinant;
        let margin = u.min(v).min(1.0 - u - v);
        if depth > 0.0 && u.abs().max(v.abs()) < 1e6 {
            closest = closest.min(margin.abs());
        }
        let limits = (depth - camera.near).abs().min((depth - camera.far).abs());
        if margin < 0.0 || depth < camera.near || depth > camera.far {
            if margin > 0.0 {
                closest = closest.min(limits);
            }
            continue;
        }
        let mix = |k: [DVec3; 3]| k[0] * (1.0 - u - v) + k[1] * u + k[2] * v;
        let [ua, ub, uc] = triangle.uv;
        if best.is_none_or(|best| depth < best.depth) {
            best = Some(Hit {
                depth,
                object: triangle.object,
                position: mix(triangle.position),
                normal: mix(triangle.normal),
                uv: ua * (1.0 - u - v) + ub * u + uc * v,
                margin,
            });
        }
    }
    (best, closest)
}

struct Corners {
    object: usize,
    position: [DVec3; 3],
    normal: [DVec3; 3],
    uv: [DVec2; 3],
}

fn corners(scene: &Scene) -> Vec<Corners> {
    let mut all = Vec::new();
    for (number, object) in scene.objects.iter().enumerate() {
        let normals = object.transform.inverse().transpose();
        for triangle in &object.mesh.triangles {
            let vertices = triangle.map(|corner| object.mesh.vertices[corner as usize]);
            all.push(Corners {
                object: number,
                position: vertices.map(|v| object.transform.project_point3(v.position)),
                normal: vertices.map(|v| (normals * v.normal.extend(0.0)).truncate()),
                uv: vertices.map(|v| v.uv),
            });
        }
    }
    all
}

fn apart(found: [f32; 3], wanted: DVec3) -> f64 {
    (DVec3::from_array(found.map(f64::from)) - wanted).length() / wanted.length().max(1.0)
}

/// Holds every pixel of a scene in world space against its ray. Pixels within a billionth of an
/// edge may go either way and are few; how many pixels were compared.
fn against_rays(scene: &Scene) -> usize {
    let corners = corners(scene);
    let frame = frame(scene);
    assert_eq!([frame.width, frame.height], scene.size);
    assert!(frame.fragments.windows(2).all(|pair| pair[0].pixel < pair[1].pixel));
    let mut fragments = frame.fragments.iter().peekable();
    let (mut compared, mut doubtful) = (0, 0);
    for pixel in 0..frame.width * frame.height {
        let found = fragments.next_if(|fragment| fragment.pixel == pixel);
        let (hit, closest) = cast(scene, &corners, pixel % frame.width, pixel / frame.width);
        if closest < 1e-9 {
            doubtful += 1;
            continue;
        }
        compared += 1;
        match (found, hit) {
            (None, None) => {}
            (Some(found), Some(hit)) => same(found, &hit, scene),
            (found, hit) => panic!("{pixel}: {found:?}, {:?}", hit.map(|hit| hit.depth)),
        }
    }
    assert!(doubtful * 200 < compared, "{doubtful} of {compared}");
    compared
}

/// Rounded once: half of the last digit of an `f32`, and what `f64` leaves.
fn same(found: &Fragment, hit: &Hit, scene: &Scene) {
    assert_eq!(found.object as usize, hit.object, "{found:?} {} {}", hit.depth, hit.margin);
    assert_eq!(found.material as usize, scene.objects[hit.object].material);
    assert!(apart(found.position, hit.position) < 7e-8, "{found:?} {}", hit.position);
    assert!(apart(found.normal, hit.normal) < 7e-8, "{found:?} {}", hit.normal);
    let [u, v] = found.uv.map(f64::from);
    assert!(
        (dvec2(u, v) - hit.uv).length() < 1e-7 * hit.uv.length().max(1.0),
        "{found:?} {}",
        hit.uv
    );
}

#[test]
fn the_scenes_of_the_repository_are_what_rays_see() {
    let names = names();
    for name in sampled(&names, 4) {
        let mut scene = of_repository(name);
        scene.space = Space::World;
        // Of 200 cubes and 2 balls each ray is held against each triangle.
        let many: usize = scene.objects.iter().map(|object| object.mesh.triangles.len()).sum();
        scene.size = if many > 500 { [97, 55] } else { [240, 180] };
        let compared = against_rays(&scene);
        assert!(compared > 5000, "{name}: {compared}");
    }
}

/// The number of fragments that an independent rasteriser published for this scene.
#[test]
fn the_six_light_scene_has_243_037_fragments() {
    assert_eq!(frame(&of_repository("six_lights")).fragments.len(), 243_037);
}

fn camera() -> Camera {
    Camera {
        position: DVec3::ZERO,
        front: -DVec3::Z,
        up: DVec3::Y,
        fov: 60.0,
        near: 0.25,
        far: 8.0,
    }
}

fn scene_of(objects: Vec<Object>, camera: Camera, size: [u32; 2]) -> Scene {
    Scene {
        name: String::new(),
        size,
        background: DVec3::ZERO,
        camera,
        lights: Lights::default(),
        materials: Vec::new(),
        objects,
        space: Space::World,
        shader: None,
        model: None,
        bind: None,
    }
}

fn triangle(positions: [DVec3; 3], random: &mut fastrand::Rng) -> Object {
    let mut number = || random.f64() * 2.0 - 1.0;
    let vertices = positions.map(|position| Vertex {
        position,
        normal: dvec3(number(), number(), number()),
        uv: dvec2(number(), number()),
    });
    let mesh = Mesh { vertices: vertices.to_vec(), triangles: vec![[0, 1, 2]] };
    Object { mesh, material: 0, transform: DMat4::IDENTITY }
}

/// Before, behind and through the camera and both planes, of either side.
#[test]
fn random_triangles_are_what_rays_see() {
    for seed in 0..40 {
        let mut random = fastrand::Rng::with_seed(seed);
        let mut objects = Vec::new();
        for _ in 0..random.usize(1..30) {
            let spread = 10_f64.powf(random.f64() * 3.0 - 1.0);
            let middle = dvec3(random.f64() - 0.5, random.f64() - 0.5, random.f64() - 0.7) * 8.0;
            let mut corner = || {
                middle + dvec3(random.f64() - 0.5, random.f64() - 0.5, random.f64() - 0.5) * spread
            };
            let positions = [corner(), corner(), corner()];
            objects.push(triangle(positions, &mut random));
        }
        let mut direction = || dvec3(random.f64() - 0.5, random.f64() - 0.5, random.f64() - 0.5);
        let camera = Camera {
            position: direction(),
            front: (direction() - DVec3::Z).normalize(),
            up: (direction() + DVec3::Y).normalize(),
            ..camera()
        };
        against_rays(&scene_of(objects, camera, [83, 61]));
    }
}

/// A floor that begins behind the camera and ends behind the far plane.
#[test]
fn what_passes_through_the_camera_is_cut_off_at_both_planes() {
    let floor = |height: f64| Object {
        mesh: plane(3.0),
        material: 0,
        transform: DMat4::from_translation(dvec3(0.0, height, 0.0))
            * DMat4::from_scale(dvec3(100.0, 1.0, 100.0)),
    };
    let scene = scene_of(vec![floor(-0.5), floor(0.125)], camera(), [160, 120]);
    against_rays(&scene);
    let frame = frame(&scene);
    // The floor half a unit below is at depth 8 where the slope is 1/16.
    let rows: Vec<u32> =
        frame.fragments.iter().filter(|f| f.object == 0).map(|f| f.pixel / 160).collect();
    let slope = |row: u32| (2.0 * f64::from(row) + 1.0 - 120.0) / 120.0 * 30_f64.to_radians().tan();
    let first = rows.iter().min().copied().expect("the floor is seen");
    assert!(slope(first) >= 1.0 / 16.0 && slope(first - 1) < 1.0 / 16.0, "{first}");
    // The ceiling is cut off by the near plane where the slope is 1/2.
    let top = frame.fragments.iter().filter(|f| f.object == 1).map(|f| f.pixel / 160).min();
    let top = top.expect("the ceiling is seen");
    assert!(-slope(top) <= 0.5 && -slope(top - 1) > 0.5, "{top}");
}

/// Of any number of triangles about a corner, each pixel is one's: corners are where pixels'
/// centres are, so that many are exactly on edges.
#[test]
fn triangles_that_share_edges_neither_share_pixels_nor_lose_them() {
    let size = [33, 33];
    let mut random = fastrand::Rng::with_seed(3);
    for _ in 0..200 {
        let slope = 30_f64.to_radians().tan();
        let mut at = |column: i32, row: i32| {
            let depth = 1.0 + random.f64() * 3.0;
            let x = f64::from(2 * column + 1 - 33) / 33.0 * slope;
            let y = f64::from(33 - 2 * row - 1) / 33.0 * slope;
            dvec3(x * depth, y * depth, -depth)
        };
        // A ring of pixels' centres round a middle.
        let ring = [(2, 2), (16, 1), (30, 2), (31, 16), (30, 30), (16, 31), (2, 30), (1, 16)];
        let ring = ring.map(|(column, row)| at(column, row));
        let middle = at(16, 16);
        let mut count = [0; 33 * 33];
        let mut other = fastrand::Rng::with_seed(1);
        for i in 0..ring.len() {
            let mut corners = [middle, ring[i], ring[(i + 1) % ring.len()]];
            corners.rotate_left(other.usize(..3));
            let one = scene_of(vec![triangle(corners, &mut other)], camera(), size);
            for fragment in frame(&one).fragments {
                count[fragment.pixel as usize] += 1;
            }
        }
        assert!(count.iter().all(|&count| count <= 1));
        // All that is well inside the ring.
        for (row, column) in (3..30).flat_map(|row| (3..30).map(move |column| (row, column))) {
            assert_eq!(count[row * 33 + column], 1, "{row} {column}");
        }
    }
}

/// The diagonal of a square goes through the centres exactly: it is the left edge of the upper
/// right half.
#[test]
fn centres_on_an_edge_are_of_the_triangle_to_its_right() {
    let far = |x: f64, y: f64| dvec3(x, y, -1.0);
    let (a, b, c, d) = (far(-1.0, 1.0), far(1.0, 1.0), far(1.0, -1.0), far(-1.0, -1.0));
    let mut random = fastrand::Rng::with_seed(1);
    let camera = Camera { fov: 90.0, ..camera() };
    for turn in 0..3 {
        let (mut upper, mut lower) = ([a, c, b], [a, d, c]);
        upper.rotate_left(turn);
        lower.rotate_left(turn);
        for backwards in [false, true] {
            if backwards {
                upper.reverse();
                lower.reverse();
            }
            // The lower left one is drawn first, and would win if it had them too.
            let objects = vec![triangle(lower, &mut random), triangle(upper, &mut random)];
            let frame = frame(&scene_of(objects, camera, [8, 8]));
            assert_eq!(frame.fragments.len(), 64);
            for fragment in frame.fragments {
                let (row, column) = (fragment.pixel / 8, fragment.pixel % 8);
                assert_eq!(fragment.object, u32::from(column >= row), "{row} {column}");
            }
        }
    }
}

/// Halfway across the picture of a triangle is not halfway along it.
#[test]
fn interpolation_is_of_perspective() {
    // From depth 1 at the left edge to depth 3 at the right one.
    let corners = [dvec3(-1.0, -9.0, -1.0), dvec3(3.0, -9.0, -3.0), dvec3(1.0, 90.0, -2.0)];
    let mut object = triangle(corners, &mut fastrand::Rng::with_seed(1));
    for vertex in &mut object.mesh.vertices {
        vertex.uv = dvec2((vertex.position.x + 1.0) / 4.0, 0.0);
    }
    let camera = Camera { fov: 90.0, ..camera() };
    let frame = frame(&scene_of(vec![object], camera, [9, 9]));
    let middle = frame.fragments.iter().find(|fragment| fragment.pixel == 4 * 9 + 4);
    let middle = middle.expect("the triangle is there");
    // On the ray through the middle x is 0: a quarter of the way, at depth 1.5.
    assert_eq!(middle.uv[0], 0.25);
    assert!(middle.position[0].abs() < 1e-15);
    assert_eq!(middle.position[2], -1.5);
}

#[test]
fn the_first_drawn_of_two_as_near_is_seen() {
    let mut random = fastrand::Rng::with_seed(1);
    let corners = [dvec3(-9.0, -9.0, -2.0), dvec3(9.0, -9.0, -2.0), dvec3(0.0, 9.0, -2.0)];
    let objects = vec![triangle(corners, &mut random), triangle(corners, &mut random)];
    let frame = frame(&scene_of(objects, camera(), [16, 16]));
    assert!(frame.fragments.len() > 100);
    assert!(frame.fragments.iter().all(|fragment| fragment.object == 0));
}

/// An object with normals along x and along z, whose middle is 2 before the camera.
fn bent(scale: DVec3) -> Object {
    let corner =
        |x: f64, y: f64, normal| Vertex { position: dvec3(x, y, 0.0), normal, uv: DVec2::ZERO };
    let vertices = vec![
        corner(-1.0, -9.0, DVec3::X),
        corner(1.0, -9.0, DVec3::Z),
        corner(-1.0, 9.0, DVec3::X),
        corner(1.0, 9.0, DVec3::Z),
    ];
    Object {
        mesh: Mesh { vertices, triangles: vec![[0, 1, 2], [1, 3, 2]] },
        material: 0,
        transform: DMat4::from_translation(dvec3(0.0, 0.0, -2.0)) * DMat4::from_scale(scale),
    }
}

fn middle(scene: &Scene, normals: VertexNormals) -> DVec3 {
    let frame = Frame::new(scene, &FrameOptions { normals });
    let middle = frame.fragments.iter().find(|fragment| fragment.pixel == 4 * 9 + 4);
    DVec3::from_array(middle.expect("the object is there").normal.map(f64::from))
}

#[test]
fn normals_are_turned_by_the_inverse_transpose_and_stay_of_any_length() {
    let scene = scene_of(vec![bent(dvec3(4.0, 1.0, 0.5))], camera(), [9, 9]);
    // (1, 0, 0) / 4 and (0, 0, 1) / 0.5, in the middle of both.
    assert_eq!(middle(&scene, VertexNormals::Transformed), dvec3(0.125, 0.0, 1.0));
    assert_eq!(middle(&scene, VertexNormals::Unit), dvec3(0.5, 0.0, 0.5));
}

/// With a fourth component, the normal along z counts for 1 / sqrt(5): the inverse of moving by
/// -2 along z gives it a fourth component of 2.
#[test]
fn the_published_bug_of_four_components_bends_normals() {
    let mut scene = scene_of(vec![bent(DVec3::ONE)], camera(), [9, 9]);
    scene.space = Space::View;
    let right = middle(&scene, VertexNormals::Unit);
    assert_eq!(right, dvec3(0.5, 0.0, 0.5));
    let bent = middle(&scene, VertexNormals::UnitOfFour);
    assert!((bent - dvec3(0.5, 0.0, 0.5 / 5_f64.sqrt())).length() < 1e-7, "{bent}");
}

/// The bug as its shader computes it, for any transform.
#[test]
fn four_components_are_those_of_the_whole_inverse_transpose() {
    let mut scene = of_repository("view_space");
    scene.size = [64, 48];
    let turn = DMat4::from_axis_angle(dvec3(1.0, 2.0, -1.0).normalize(), 0.7);
    scene.objects[0].mesh = sphere(16, 8);
    scene.objects[0].transform = DMat4::from_translation(dvec3(0.3, -0.2, -2.5))
        * turn
        * DMat4::from_scale(dvec3(1.0, 1.5, 0.75));
    let found = Frame::new(&scene, &FrameOptions { normals: VertexNormals::UnitOfFour });
    // The same mesh with the normals that shader makes, then left as they are.
    let all = scene.objects[0].transform.inverse().transpose();
    let back = DMat3::from_mat4(scene.objects[0].transform).transpose();
    for vertex in &mut scene.objects[0].mesh.vertices {
        let four = all * vertex.normal.extend(0.0);
        vertex.normal = back * (four / four.length()).truncate();
    }
    let wanted = Frame::new(&scene, &FrameOptions { normals: VertexNormals::Transformed });
    assert_eq!(found.fragments.len(), wanted.fragments.len());
    for (found, wanted) in found.fragments.iter().zip(&wanted.fragments) {
        let wanted = DVec3::from_array(wanted.normal.map(f64::from));
        assert!(apart(found.normal, wanted) < 2e-7, "{found:?} {wanted}");
    }
}

#[test]
fn fragments_are_in_the_space_of_the_lighting() {
    let mut scene = of_repository("two_of_128");
    scene.size = [80, 60];
    let world = frame(&scene);
    let camera = scene.camera;
    scene.space = Space::View;
    let view = frame(&scene);
    scene.space = Space::CameraRelative;
    let relative = frame(&scene);
    assert_eq!(
        (world.fragments.len(), world.fragments.len()),
        (view.fragments.len(), relative.fragments.len())
    );
    // The camera looks from (0, 3, 12) to (0, 0.5, 0): right is x.
    let right = DVec3::X;
    let up = right.cross(camera.front);
    for ((world, view), relative) in
        world.fragments.iter().zip(&view.fragments).zip(&relative.fragments)
    {
        assert_eq!((world.pixel, world.uv), (view.pixel, view.uv));
        let at = DVec3::from_array(world.position.map(f64::from)) - camera.position;
        let turned = |v: DVec3| dvec3(v.dot(right), v.dot(up), -v.dot(camera.front));
        assert!((DVec3::from_array(relative.position.map(f64::from)) - at).length() < 1e-5);
        assert!((DVec3::from_array(view.position.map(f64::from)) - turned(at)).length() < 1e-5);
        let normal = DVec3::from_array(world.normal.map(f64::from));
        assert_eq!(world.normal, relative.normal);
        assert!((DVec3::from_array(view.normal.map(f64::from)) - turned(normal)).length() < 1e-6);
    }
}

/// Places that are sums of powers of two move by another exactly.
#[test]
fn eight_million_units_away_nothing_changes_relative_to_the_camera() {
    for space in [Space::View, Space::CameraRelative] {
        let mut scene =
            scene_of(vec![bent(DVec3::ONE), bent(dvec3(0.5, 0.25, 2.0))], camera(), [40, 30]);
        scene.objects[1].transform.w_axis.x = 0.375;
        scene.objects[1].transform.w_axis.z = -1.5;
        scene.space = space;
        let here = frame(&scene);
        let away = dvec3(8_388_608.0, -4_194_304.5, 1_048_576.25);
        scene.camera.position += away;
        for object in &mut scene.objects {
            object.transform.w_axis += away.extend(0.0);
        }
        assert!(here.fragments.len() > 500);
        assert_eq!(frame(&scene), here, "{space:?}");
    }
}

#[test]
fn a_picture_or_a_mesh_of_nothing_has_no_fragments() {
    assert!(frame(&scene_of(Vec::new(), camera(), [8, 8])).fragments.is_empty());
    let mut scene = scene_of(vec![bent(DVec3::ONE)], camera(), [0, 8]);
    assert!(frame(&scene).fragments.is_empty());
    scene.size = [u32::MAX, u32::MAX];
    assert!(frame(&scene).fragments.is_empty());
    // Corners that are not there, and corners in a line.
    scene.size = [8, 8];
    scene.objects[0].mesh.triangles = vec![[0, 1, 99], [0, 0, 1]];
    assert!(frame(&scene).fragments.is_empty());
}

#[test]
fn what_runs_beside_rasterizing_runs_once_and_its_error_is_returned() {
    for size in [[0, 8], [8, 8], [8, 1000], [u32::MAX, u32::MAX]] {
        let scene = scene_of(vec![bent(DVec3::ONE)], camera(), size);
        let mut runs = 0;
        let beside = Frame::beside(&scene, &FrameOptions::default(), || {
            runs += 1;
            Ok::<_, &str>("done")
        });
        assert_eq!((beside, runs), (Ok((frame(&scene), "done")), 1), "{size:?}");
        let failed = Frame::beside(&scene, &FrameOptions::default(), || Err::<(), _>("failed"));
        assert_eq!(failed, Err("failed"), "{size:?}");
    }
}
