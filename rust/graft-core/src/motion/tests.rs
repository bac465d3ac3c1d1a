//! Laws of the spaces, and the planner in a plane with a wall.

#![allow(clippy::unwrap_used)]

use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::*;
use crate::geometry::{OrientedBox, Vec3};
use crate::grasp::Collider;
use edges::edge_free;

/// A disc in the unit square with a wall along x = 0.5 that has a gap.
struct Plane {
    wall: f64,
    gap: (f64, f64),
}

impl Space for Plane {
    type State = [f64; 2];

    fn distance(&self, a: &[f64; 2], b: &[f64; 2]) -> f64 {
        (a[0] - b[0]).hypot(a[1] - b[1])
    }

    fn between(&self, a: &[f64; 2], b: &[f64; 2], t: f64) -> [f64; 2] {
        [a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t]
    }

    fn sample(&self, random: &mut Pcg64) -> [f64; 2] {
        [random.random(), random.random()]
    }

    fn clear(&self, p: &[f64; 2], slack: f64) -> bool {
        let off = (p[0] - 0.5).abs() > 0.5 * self.wall + slack;
        off || (p[1] > self.gap.0 + slack && p[1] < self.gap.1 - slack)
    }
}

fn options(seed: u64) -> Options {
    Options {
        clearance: 0.001,
        step: 0.2,
        goal_bias: 0.05,
        max_iterations: 2000,
        time_limit: None,
        shortcuts: 50,
        seed,
    }
}

const ROOM: Plane = Plane { wall: 1e-6, gap: (0.9, 0.96) };

#[test]
fn finds_the_gap_and_leaves_little_detour() {
    for seed in 0..20 {
        let found = plan(&ROOM, &[0.1, 0.1], &[0.9, 0.1], &options(seed));
        assert_eq!(found.outcome, Outcome::Found);
        assert_eq!((found.path[0], found.path[found.path.len() - 1]), ([0.1, 0.1], [0.9, 0.1]));
        let length: f64 = found.path.windows(2).map(|p| ROOM.distance(&p[0], &p[1])).sum();
        // Straight to the gap and back is 1.79 long; random trees alone give 2.5 and more.
        assert!(length < 2.1, "seed {seed}: {length}");
        for pair in found.path.windows(2) {
            for k in 0..=1000 {
                assert!(ROOM.clear(&ROOM.between(&pair[0], &pair[1], f64::from(k) / 1000.0), 0.0));
            }
        }
    }
}

#[test]
fn the_same_seed_gives_the_same_path() {
    let run = |seed| plan(&ROOM, &[0.1, 0.1], &[0.9, 0.1], &options(seed)).path;
    assert_eq!(run(3), run(3));
    assert_ne!(run(3), run(4));
}

#[test]
fn says_why_there_is_no_path() {
    let closed = Plane { wall: 0.01, gap: (2.0, 2.0) };
    let limits = Options { max_iterations: 50, ..options(0) };
    let ended = |a, b, o: &Options| plan(&closed, &a, &b, o).outcome;
    assert_eq!(ended([0.5, 0.5], [0.9, 0.1], &limits), Outcome::StartBlocked);
    assert_eq!(ended([0.1, 0.1], [0.5, 0.5], &limits), Outcome::GoalBlocked);
    assert_eq!(ended([0.1, 0.1], [0.9, 0.1], &limits), Outcome::OutOfIterations);
    let hurried =
        Options { time_limit: Some(std::time::Duration::from_millis(5)), max_iterations: usize::MAX, ..limits };
    assert_eq!(ended([0.1, 0.1], [0.9, 0.1], &hurried), Outcome::OutOfTime);
}

#[test]
fn no_wall_is_too_thin() {
    for wall in [1e-3, 1e-6, 1e-12] {
        let closed = Plane { wall, gap: (2.0, 2.0) };
        for k in 0..200 {
            // Walls at every fraction of the edge, none of them a dyadic one.
            let left = 0.4 * f64::from(k) / 200.0 + 0.013;
            assert!(!edge_free(&closed, &[left, 0.3], &[0.93, 0.31], 0.001, &mut 0));
        }
    }
}

#[test]
fn open_space_costs_one_query() {
    let open = Plane { wall: 0.1, gap: (-9.0, 9.0) };
    let mut checks = 0;
    assert!(edge_free(&open, &[0.0, 0.0], &[1.0, 0.0], 0.001, &mut checks));
    assert_eq!(checks, 1);
}

fn pose() -> impl Strategy<Value = Pose> {
    (proptest::array::uniform3(-1.0..1.0), any::<u64>()).prop_map(|(p, seed): ([f64; 3], u64)| Pose {
        position: Vec3::from(p),
        rotation: pose::random_rotation(&mut Pcg64::seed_from_u64(seed)),
    })
}

fn corners(b: &OrientedBox) -> [Vec3; 8] {
    std::array::from_fn(|k| {
        (0..3)
            .fold(b.center, |p, i| p + b.axes[i] * if k >> i & 1 == 1 { b.half_extents[i] } else { -b.half_extents[i] })
    })
}

fn nothing() -> Obstacles {
    Obstacles { object: Collider::new(&[], &[]), support: None }
}

/// Two hinges and a slide, anchors off the links' origins.
fn chain() -> Chain {
    let rest = |x: f64, y: f64, z: f64| Pose {
        position: Vec3::new(x, y, z),
        rotation: nalgebra::UnitQuaternion::from_euler_angles(x, 2.0 * y, 3.0 * z),
    };
    let hinge = |axis: Vec3, x: f64| Motion::Hinge { axis, anchor: Vec3::new(x, 0.02, -x) };
    let links = vec![
        Link { parent: None, rest: rest(0.1, 0.0, 0.2), motion: hinge(Vec3::z(), 0.05) },
        Link { parent: Some(0), rest: rest(0.0, 0.3, 0.1), motion: Motion::Slide { axis: Vec3::x() } },
        Link { parent: Some(1), rest: rest(0.3, 0.0, 0.0), motion: hinge(Vec3::y(), -0.1) },
        Link { parent: Some(2), rest: rest(0.0, 0.1, 0.1), motion: Motion::Fixed },
    ];
    let shape = OrientedBox {
        center: Vec3::new(0.05, 0.0, 0.1),
        axes: [Vec3::x(), Vec3::y(), Vec3::z()],
        half_extents: [0.02, 0.1, 0.05],
    };
    let boxes = (0..4).map(|link| LinkBox { link, shape }).collect();
    Chain::new(links, boxes, vec![(-2.0, 2.0), (-0.2, 0.4), (-3.0, 3.0)]).unwrap()
}

proptest! {
    #[test]
    fn the_way_between_poses_is_even(a in pose(), b in pose(), t in 0.0..1.0) {
        let hand = |p: &Pose, q: &Pose| (p.position - q.position).norm() + 0.15 * p.angle_to(q);
        let middle = a.between(&b, t);
        prop_assert!((hand(&a, &middle) - t * hand(&a, &b)).abs() < 1e-7);
        prop_assert!((hand(&middle, &b) - (1.0 - t) * hand(&a, &b)).abs() < 1e-7);
    }

    #[test]
    fn rows_and_back(a in pose()) {
        let back = Pose::from_rows(&a.to_rows());
        prop_assert!(a.angle_to(&back) < 1e-7 && (a.position - back.position).norm() < 1e-12);
    }

    #[test]
    fn no_corner_of_an_arm_outruns_the_distance(
        a in (-2.0..2.0, -0.2..0.4, -3.0..3.0), b in (-2.0..2.0, -0.2..0.4, -3.0..3.0),
    ) {
        let chain = chain();
        let obstacles = nothing();
        let arm = Arm { chain: &chain, obstacles: &obstacles, movers: &[], pairs: &[] };
        let (a, b): ([f64; 3], [f64; 3]) = (a.into(), b.into());
        let (a, b) = (a.to_vec(), b.to_vec());
        for (p, q) in chain.placed(&a, 0.0).iter().zip(&chain.placed(&b, 0.0)) {
            for (c, d) in corners(p).iter().zip(&corners(q)) {
                prop_assert!((c - d).norm() <= arm.distance(&a, &b) + 1e-12);
            }
        }
    }

    #[test]
    fn no_corner_of_a_hand_outruns_the_distance(a in pose(), b in pose()) {
        let boxes = [OrientedBox {
            center: Vec3::new(0.0, 0.05, -0.1),
            axes: [Vec3::x(), Vec3::y(), Vec3::z()],
            half_extents: [0.02, 0.1, 0.05],
        }];
        let obstacles = nothing();
        let bounds = [Vec3::zeros(); 2];
        let hand = Hand { boxes: &boxes, obstacles: &obstacles, bounds, ends: [a, b], radius: reach(&boxes) };
        for c in corners(&boxes[0]) {
            let moved = (a.position + a.rotation * c) - (b.position + b.rotation * c);
            prop_assert!(moved.norm() <= hand.distance(&a, &b) + 1e-12);
        }
    }
}
