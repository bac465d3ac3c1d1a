#![allow(clippy::unwrap_used, clippy::float_cmp)]

use super::*;

const RED: [u8; 3] = [200, 0, 0];
const BLUE: [u8; 3] = [0, 0, 200];

/// A camera that sees x to the right and y down at `scale` pixels a unit, the origin in the middle.
fn camera(size: usize, scale: f64) -> Camera {
    let half = size as f64 / 2.0;
    Camera { matrix: [scale, 0.0, 0.0, half, 0.0, scale, 0.0, half, 0.0, 0.0, scale, 0.0], width: size, height: size }
}

/// A square of half side `half` at depth `z`, as two triangles.
fn square(half: f64, z: f64) -> (Vec<f64>, Vec<i64>) {
    (vec![-half, -half, z, half, -half, z, half, half, z, -half, half, z], vec![0, 1, 2, 0, 2, 3])
}

fn two_squares() -> (Vec<f64>, Vec<i64>, Vec<i64>) {
    let (mut vertices, mut faces) = square(0.2, 5.0);
    let (behind, _) = square(0.8, 9.0);
    vertices.extend(behind);
    faces.extend([4, 5, 6, 4, 6, 7]);
    (vertices, faces, vec![0, 0, 1, 1])
}

fn spheres<'a>(centers: &'a [f64], radii: &'a [f64], groups: &'a [i64], colors: &'a [u8]) -> Scene<'a> {
    Scene { vertices: &[], faces: &[], face_groups: &[], centers, radii, center_groups: groups, colors }
}

#[test]
fn a_spheres_silhouette_has_the_area_of_its_disc() {
    let picture = render(&spheres(&[0.0; 3], &[0.7], &[0], &RED), &camera(400, 200.0)).unwrap();
    let covered: f64 = picture.chunks(4).map(|p| f64::from(p[3]) / 255.0).sum();
    let disc = std::f64::consts::PI * 140.0 * 140.0;
    assert!((covered / disc - 1.0).abs() < 1e-3, "{covered} of {disc}");
}

#[test]
fn the_nearer_of_two_squares_hides_the_other_whatever_their_order() {
    let (vertices, mut faces, mut face_groups) = two_squares();
    let colors = [RED, BLUE].concat();
    for _ in 0..2 {
        let scene =
            Scene { vertices: &vertices, faces: &faces, face_groups: &face_groups, ..spheres(&[], &[], &[], &colors) };
        let picture = render(&scene, &camera(100, 50.0)).unwrap();
        let pixel = |x: usize, y: usize| &picture[4 * (100 * y + x)..][..4];
        assert!(pixel(50, 50)[0] > 100 && pixel(50, 50)[2] < 60, "red in the middle: {:?}", pixel(50, 50));
        assert!(pixel(20, 50)[2] > 100 && pixel(20, 50)[0] < 60, "blue beside it: {:?}", pixel(20, 50));
        assert_eq!(pixel(2, 2), [0; 4], "nothing outside");
        faces.rotate_left(6);
        face_groups.rotate_left(2);
    }
}

#[test]
fn pictures_do_not_depend_on_the_number_of_threads() {
    let centers: Vec<f64> = (0..300).map(|i| f64::from(i * 7919 % 613) / 400.0 - 0.75).collect();
    let (radii, groups) = (vec![0.1; 100], vec![0; 100]);
    let scene = spheres(&centers, &radii, &groups, &BLUE);
    let draw = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| render(&scene, &camera(120, 60.0)).unwrap())
    };
    let alone = draw(1);
    assert!(alone.iter().any(|&byte| byte > 0));
    assert_eq!(alone, draw(2));
    assert_eq!(alone, draw(5));
}

#[test]
fn the_tree_finds_what_trying_every_primitive_finds() {
    let mut state = 1_u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as f64 / f64::from(1_u32 << 31) * 2.0 - 1.0
    };
    let mut vector = || Vector3::new(random(), random(), random());
    let primitives: Vec<Primitive> = (0..200)
        .map(|i| {
            let center = vector();
            if i % 2 == 0 {
                Primitive::Triangle([center, center + vector() * 0.3, center + vector() * 0.3])
            } else {
                Primitive::Sphere(center, 0.1)
            }
        })
        .collect();
    let tree = Bvh::new(primitives.clone());
    let mut hits = 0;
    for _ in 0..500 {
        let ray = Ray { origin: vector() * 2.0, direction: vector() };
        let alone = primitives
            .iter()
            .enumerate()
            .filter_map(|(i, p)| Bvh::new(vec![*p]).nearest(&ray).map(|h| Hit { primitive: i, ..h }))
            .min_by(|a, b| a.distance.total_cmp(&b.distance));
        assert_eq!(tree.nearest(&ray), alone);
        hits += usize::from(alone.is_some());
    }
    assert!((50..450).contains(&hits), "{hits} of 500 rays hit");
}

#[test]
fn rays_know_their_distance_and_their_misses() {
    let (vertices, faces) = square(1.0, 2.0);
    // The last two run in the square's plane and along the edge that the triangles share.
    let origins = [0.0, 0.5, 0.0, 0.0, 0.5, 3.0, 0.5, 0.0, 0.0, -3.0, 0.0, 2.0, 0.3, 0.3, 0.0];
    let directions = [0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.5, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    let distances = cast_rays(&vertices, &faces, &origins, &directions).unwrap();
    assert_eq!(distances, [2.0, f64::INFINITY, 4.0, f64::INFINITY, 2.0]);
}

#[test]
fn smooth_surfaces_share_normals_and_creases_do_not() {
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.1]]
        .map(|[x, y, z]| Vector3::new(x, y, z));
    let normals = normals::corner_normals(&corners, &[[0, 1, 2], [1, 0, 3], [1, 0, 4]]);
    let flat = Vector3::z();
    assert_eq!(normals[0][2], flat);
    assert!(normals[0][0].dot(&flat) < 0.9999, "bent towards the gentle neighbour");
    assert!(normals[0][0].dot(&flat) > 0.99, "not towards the one behind the crease");
    assert_eq!(normals[0][0], normals[2][1]);
}

#[test]
fn bad_input_is_named() {
    let (vertices, faces) = square(1.0, 0.0);
    let scene = Scene { vertices: &vertices, faces: &faces, face_groups: &[0, 0], ..spheres(&[], &[], &[], &RED) };
    let view = camera(10, 5.0);
    let message = |scene: Scene<'_>, view: Camera| render(&scene, &view).unwrap_err().to_string();
    assert!(message(scene, Camera { width: 0, ..view }).contains("width"));
    assert!(message(scene, Camera { height: MAX_SIZE + 1, ..view }).contains("height"));
    assert!(message(scene, Camera { matrix: [0.0; 12], ..view }).contains("camera"));
    assert!(message(Scene { faces: &[0, 1, 4], face_groups: &[0], ..scene }, view).contains("faces"));
    assert!(message(Scene { face_groups: &[0, 1], ..scene }, view).contains("face_groups"));
    assert!(message(Scene { face_groups: &[0], ..scene }, view).contains("face_groups"));
    let sphere = spheres(&[0.0; 3], &[-1.0], &[0], &RED);
    assert!(message(sphere, view).contains("radii"));
    assert!(cast_rays(&vertices, &faces, &[0.0; 3], &[0.0; 3]).is_err());
}
