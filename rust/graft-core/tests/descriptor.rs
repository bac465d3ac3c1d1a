//! Laws and closed forms of the part descriptors.
#![allow(clippy::unwrap_used, clippy::cast_possible_wrap)]

use graft_core::descriptor::{Family, Options, Parts, describe, raw_features};
use proptest::prelude::*;
use std::f64::consts::{PI, TAU};

type Mesh = (Vec<[f64; 3]>, Vec<[i64; 3]>);

fn options(families: &[Family], samples: usize) -> Options {
    Options { families: families.to_vec(), samples, seed: 0 }
}

fn with<T>((vertices, faces): &Mesh, call: impl FnOnce(Parts<'_>) -> T) -> T {
    let (v, f) = ([0, vertices.len() as i64], [0, faces.len() as i64]);
    call(Parts { vertices, faces, vertex_offsets: &v, face_offsets: &f })
}

fn raw(mesh: &Mesh, family: Family) -> Vec<f64> {
    with(mesh, |parts| raw_features(parts, &options(&[family], 4096))).unwrap()
}

fn row(mesh: &Mesh) -> Vec<f64> {
    with(mesh, |parts| describe(parts, &options(&Family::ALL, 1024))).unwrap()
}

fn cosine(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// Features at their indices against closed forms.
fn assert_close(features: &[f64], expected: &[(usize, f64)], tolerance: f64) {
    for &(k, value) in expected {
        assert!((features[k] - value).abs() < tolerance, "feature {k}: {} for {value}", features[k]);
    }
}

/// A surface of revolution about z: `profile` gives (radius, height) at 0 to 1, poles where the radius is 0.
fn revolved(profile: impl Fn(f64) -> (f64, f64), along: usize, around: usize) -> Mesh {
    let mut vertices = Vec::new();
    let mut faces = Vec::new();
    for i in 0..=along {
        let (radius, height) = profile(i as f64 / along as f64);
        for j in 0..around {
            let angle = TAU * j as f64 / around as f64;
            vertices.push([radius * angle.cos(), radius * angle.sin(), height]);
        }
    }
    for i in 0..along {
        for j in 0..around {
            let [a, b] = [i * around + j, i * around + (j + 1) % around].map(|k| k as i64);
            let [c, d] = [a, b].map(|k| k + around as i64);
            faces.extend([[a, b, d], [a, d, c]]);
        }
    }
    (vertices, faces)
}

fn sphere(along: usize) -> Mesh {
    revolved(|t| ((PI * t).sin(), -(PI * t).cos()), along, 2 * along)
}

fn tube(radius: f64, along: usize) -> Mesh {
    revolved(|t| (radius, 2.0 * t), along, 24)
}

fn block(x: f64, y: f64, z: f64) -> Mesh {
    let vertices = (0..8).map(|k| [x * f64::from(k & 1), y * f64::from(k >> 1 & 1), z * f64::from(k >> 2)]);
    let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let faces = sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
    (vertices.collect(), faces.collect())
}

#[test]
fn a_block_has_the_closed_form_of_its_hull() {
    let isoperimetric = (36.0 * PI * 64.0 / 28.0_f64.powi(3)).ln();
    let full = [(4, 0.0), (5, 0.0), (6, 0.0), (8, 1.0), (9, 0.0)];
    let hull = raw(&block(4.0, 2.0, 1.0), Family::Hull);
    assert_close(&hull, &[(0, 0.5_f64.ln()), (1, 0.5_f64.ln()), (2, isoperimetric), (3, 1.0)], 1e-9);
    assert_close(&hull, &full, 1e-9);
}

#[test]
fn a_sphere_has_no_radial_spread_and_no_harmonics() {
    let inertia = raw(&sphere(40), Family::Inertia);
    assert_close(&inertia, &[(0, 0.0), (1, 0.0), (2, 0.0), (3, 1.0), (4, 1.0), (5, 1.8), (6, 0.0)], 0.06);
    let harmonics = raw(&sphere(40), Family::Harmonics);
    let shells: Vec<&[f64]> = harmonics.chunks(7).collect();
    assert!((shells.iter().map(|shell| shell[0]).sum::<f64>() - 1.0).abs() < 1e-12, "the samples weigh 1");
    assert!(shells.iter().flat_map(|shell| &shell[1..]).all(|energy| *energy < 0.05));
}

#[test]
fn a_thin_rod_is_a_segment() {
    // Uniform on a segment: E r^4 / (E r^2)^2 = 9/5 and E |r| / sqrt(E r^2) = sqrt(3) / 2.
    let inertia = raw(&tube(0.02, 80), Family::Inertia);
    assert_close(&inertia, &[(3, 1.8), (4, 0.75_f64.sqrt()), (5, 1.8), (6, 0.0)], 0.03);
    let curve = raw(&tube(0.1, 80), Family::Curve);
    assert!(curve[1] < 0.2 && curve[2] < 0.2, "even along its length: {curve:?}");
}

#[test]
fn an_open_tube_encloses_the_volume_of_the_closed_one() {
    let hull = raw(&tube(0.5, 20), Family::Hull);
    // The holes are closed by fans to their centres, so that the tube is as full as its hull.
    assert!((hull[8] - 1.0).abs() < 1e-6, "{}", hull[8]);
    let (vertices, faces) = tube(0.5, 20);
    let corners: Vec<[f64; 3]> = faces.iter().flatten().map(|&k| vertices[k as usize]).collect();
    let triangles = (0..faces.len() as i64).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
    assert!((raw(&(corners, triangles), Family::Hull)[8] - 1.0).abs() < 1e-6, "repeated corners are one vertex");
}

#[test]
fn bending_a_rod_hardly_changes_the_tube() {
    let (vertices, faces) = tube(0.08, 60);
    let bend = |&[x, y, z]: &[f64; 3]| [(1.0 + x) * (1.5 * z).cos(), y, (1.0 + x) * (1.5 * z).sin()];
    let bent = raw(&(vertices.iter().map(bend).collect(), faces.clone()), Family::Curve);
    let straight = raw(&(vertices, faces), Family::Curve);
    let ball = raw(&sphere(30), Family::Curve);
    let distance = |u: &[f64], v: &[f64]| u.iter().zip(v).map(|(x, y)| (x - y).powi(2)).sum::<f64>().sqrt();
    assert!(distance(&straight, &bent) < 0.2 * distance(&straight, &ball), "{straight:?} {bent:?} {ball:?}");
}

#[test]
fn tessellation_matters_less_than_shape() {
    let rows = [(sphere(16), sphere(50)), (tube(0.1, 20), tube(0.1, 200)), (tube(0.7, 5), tube(0.7, 100))]
        .map(|(coarse, fine)| (row(&coarse), row(&fine)));
    for (i, (coarse, fine)) in rows.iter().enumerate() {
        assert!(cosine(coarse, fine) > 0.98, "shape {i}: {}", cosine(coarse, fine));
        for (j, (other, _)) in rows.iter().enumerate().filter(|&(j, _)| j != i) {
            assert!(cosine(coarse, other) < 0.9, "shapes {i} and {j}: {}", cosine(coarse, other));
        }
    }
}

#[test]
fn a_row_does_not_depend_on_the_threads_or_the_neighbours() {
    let meshes = [sphere(12), tube(0.1, 10), block(1.0, 2.0, 3.0)];
    let (mut vertices, mut faces, mut v, mut f) = (Vec::new(), Vec::new(), vec![0], vec![0]);
    for (points, triangles) in &meshes {
        vertices.extend_from_slice(points);
        faces.extend_from_slice(triangles);
        v.push(vertices.len() as i64);
        f.push(faces.len() as i64);
    }
    let parts = Parts { vertices: &vertices, faces: &faces, vertex_offsets: &v, face_offsets: &f };
    let together = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| describe(parts, &options(&Family::ALL, 1024)).unwrap())
    };
    let one = together(1);
    assert_eq!(one, together(3));
    assert_eq!(one, meshes.iter().flat_map(row).collect::<Vec<_>>());
}

#[test]
fn bad_arguments_are_named() {
    let mesh = block(1.0, 1.0, 1.0);
    let refusal = |options: Options| with(&mesh, |parts| describe(parts, &options)).unwrap_err().to_string();
    assert!(refusal(options(&[Family::Hull, Family::Hull], 64)).contains("hull twice"));
    assert!(refusal(options(&[], 64)).starts_with("families"));
    assert!(refusal(options(&Family::ALL, 8)).starts_with("samples"));
    let outside = (mesh.0.clone(), vec![[0, 1, 8]]);
    let error = with(&outside, |parts| describe(parts, &options(&Family::ALL, 64))).unwrap_err();
    assert!(error.to_string().starts_with("faces"));
    let offsets = Parts { vertices: &mesh.0, faces: &mesh.1, vertex_offsets: &[0, 9], face_offsets: &[0, 12] };
    assert!(describe(offsets, &options(&Family::ALL, 64)).unwrap_err().to_string().starts_with("vertex_offsets"));
    assert!(Family::named("colour").unwrap_err().to_string().contains("harmonics"));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Whatever the triangles and however they lie, the row is finite and of length 1.
    #[test]
    fn any_soup_has_a_finite_row(
        points in prop::collection::vec(prop::array::uniform3(prop_oneof![-1.0..1.0, Just(0.0), -1e200..1e200]), 1..20),
        corners in prop::collection::vec(prop::array::uniform3(0_usize..20), 0..12),
    ) {
        let n = points.len();
        let faces = corners.iter().map(|face| face.map(|k| (k % n) as i64)).collect();
        let row = row(&(points, faces));
        prop_assert!(row.iter().all(|x| x.is_finite()));
        prop_assert!((cosine(&row, &row) - 1.0).abs() < 1e-9);
    }
}
