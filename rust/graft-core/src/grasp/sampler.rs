//! The antipodal sampler: from a surface to ranked grasps that a parallel gripper can reach.

use std::f64::consts::TAU;

use nalgebra::Matrix3;
use rand::SeedableRng;
use rand_pcg::Pcg64;
use rayon::prelude::*;

use super::boxes::{HalfSpace, Hand, Pose};
use super::collision::Collider;
use super::pads::{GIVE, Pad};
use super::pairs::{Pair, Sheet, pairs};
use super::reach::{Comer, Reason, closes};
use super::samples::draw;
use super::score::{Facts, Judge, TERMS};
use super::thin::{Nearness, thin};
use crate::geometry::Vec3;
use crate::geometry::search::plane_axes;

/// Pairs are tried apart when they differ by more than this in place or direction; finer differences the pads, which
/// are centimetres wide, do not feel.
const PAIR_NEARNESS: Nearness = Nearness { distance: 0.003, angle: 0.15 };

/// Likewise of candidates whose pads are looked at.
const CANDIDATE_NEARNESS: Nearness = Nearness { distance: 0.004, angle: 0.2 };

/// Of these times as many candidates as grasps are wanted the pads are looked at.
const CANDIDATES_PER_GRASP: usize = 8;

/// Parameters of the sampler; lengths in metres, angles in radians.
#[derive(Debug, Clone)]
pub struct Settings {
    /// Places on the surface.
    pub samples: usize,
    /// Rays from each, within the friction cone.
    pub rays: usize,
    /// Pairs of which approaches are tried.
    pub pairs: usize,
    /// Approach directions about each closing axis.
    pub approaches: usize,
    /// Offsets of the pads along the approach from the pair's line.
    pub depths: Vec<f64>,
    /// Half angle of the friction cone.
    pub cone: f64,
    /// Room on either side between an open pad and the surface.
    pub clearance: f64,
    /// Every box keeps this far from the object and the support.
    pub margin: f64,
    /// Length of the straight way in.
    pub travel: f64,
    /// Grasps nearer than this are the same.
    pub nearness: Nearness,
    /// Grasps wanted.
    pub count: usize,
    /// Seed.
    pub seed: u64,
}

/// Where on the object.
#[derive(Debug, Clone)]
pub struct Place {
    /// Only pads at +y or -y on this part; None for all.
    pub part: Option<usize>,
    /// A point and the radius around it.
    pub near: Option<(Vec3, f64)>,
}

/// A grasp.
#[derive(Debug, Clone, Copy)]
pub struct Proposal {
    /// What is known of it.
    pub facts: Facts,
    /// From the contact that was asked for to the nearest place between the pads; 0 where none was.
    pub distance: f64,
    /// What its score is made of.
    pub terms: [f64; TERMS],
    /// Higher is better.
    pub score: f64,
}

/// Grasps, best first, and how many candidates fell for each [`Reason`].
#[derive(Debug, Clone, Default)]
pub struct Answer {
    /// At most as many as wanted.
    pub grasps: Vec<Proposal>,
    /// In the order of [`Reason::ALL`].
    pub rejected: [u64; Reason::ALL.len()],
}

/// What stays the same for all candidates.
#[derive(Debug)]
pub struct Scene<'a> {
    /// The mesh.
    pub sheet: Sheet<'a>,
    /// The same, to collide with.
    pub collider: &'a Collider,
    /// What closes.
    pub hand: &'a Hand,
    /// What it stands on.
    pub support: Option<HalfSpace>,
    /// What is wanted.
    pub judge: Judge,
}

/// Find grasps. The same for any number of threads; equal scores keep the order of their samples.
#[must_use]
pub fn sample_grasps(scene: &Scene<'_>, place: &Place, settings: &Settings) -> Answer {
    let mut rng = Pcg64::seed_from_u64(settings.seed);
    let mut rejected = [0; Reason::ALL.len()];
    let is_on_part = |face: usize| place.part.is_none_or(|part| scene.sheet.face_parts[face] == part);
    let sheet = &scene.sheet;
    let samples = draw(sheet.vertices, sheet.faces, is_on_part, place.near, settings.samples, &mut rng);
    let widest = scene.judge.stroke - 2.0 * settings.margin;
    let found = pairs(sheet, scene.collider, &samples, widest, settings.cone.cos(), settings.rays, &mut rng);
    let mut all: Vec<(f64, Pair)> = Vec::new();
    for one in found {
        match (one.pairs.is_empty(), one.too_wide) {
            (true, 0) => rejected[Reason::NoAntipode as usize] += 1,
            (true, _) => rejected[Reason::TooWide as usize] += 1,
            _ => {}
        }
        all.extend(one.pairs.into_iter().map(|pair| (promise(scene, &pair, &is_on_part), pair)));
    }
    let chosen = best_pairs(&mut all, settings.pairs);
    let tried: Vec<Tried> = chosen
        .par_iter()
        .map(|pair| try_pair(scene, settings, pair, pair.faces.iter().all(|&face| is_on_part(face))))
        .collect();
    let mut candidates: Vec<Proposal> = Vec::new();
    for one in tried {
        candidates.extend(one.arrived);
        for (sum, count) in rejected.iter_mut().zip(one.rejected) {
            *sum += count;
        }
    }
    let candidates = ranked(candidates, CANDIDATE_NEARNESS, settings.count.saturating_mul(CANDIDATES_PER_GRASP));
    let closed: Vec<Result<Proposal, Reason>> =
        candidates.par_iter().with_min_len(4).map(|candidate| close(scene, settings, candidate)).collect();
    let mut grasps = Vec::new();
    for outcome in closed {
        match outcome {
            Ok(grasp) => grasps.push(grasp),
            Err(reason) => rejected[reason as usize] += 1,
        }
    }
    Answer { grasps: ranked(grasps, settings.nearness, settings.count), rejected }
}

/// Sort by score, equal ones as they come, and thin.
fn ranked(mut proposals: Vec<Proposal>, near: Nearness, limit: usize) -> Vec<Proposal> {
    proposals.sort_by(|a, b| b.score.total_cmp(&a.score));
    let kept = thin(proposals.iter().map(|p| p.facts.pose), near, limit);
    kept.into_iter().map(|index| proposals[index]).collect()
}

/// The score of a pair, as far as it does not depend on the approach.
fn promise(scene: &Scene<'_>, pair: &Pair, is_on_part: impl Fn(usize) -> bool) -> f64 {
    let judge = Judge { approach: None, is_supported: false, ..scene.judge.clone() };
    judge.score(&judge.terms(&facts(pair, Pose::identity(), pair.faces.iter().all(|&face| is_on_part(face)))))
}

fn facts(pair: &Pair, pose: Pose, is_on_part: bool) -> Facts {
    let angle = pair.aligned.min(1.0).acos();
    Facts { pose, contacts: pair.points, width: pair.width, angle, share: None, is_on_part }
}

/// The most promising pairs that differ.
fn best_pairs(all: &mut [(f64, Pair)], limit: usize) -> Vec<Pair> {
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    let frame = |pair: &Pair| {
        let (u, v) = plane_axes(&pair.axis);
        // Only the axis matters: it takes the place of z, and is made to point into one half of space.
        let flip = if pair.axis.iter().find(|x| **x != 0.0).is_some_and(|x| *x < 0.0) { -1.0 } else { 1.0 };
        Pose {
            rotation: Matrix3::from_columns(&[u, v, pair.axis * flip]),
            translation: (pair.points[0] + pair.points[1]) / 2.0,
        }
    };
    let kept = thin(all.iter().map(|(_, pair)| frame(pair)), PAIR_NEARNESS, limit);
    kept.into_iter().map(|index| all[index].1).collect()
}

/// What became of a pair.
struct Tried {
    arrived: Vec<Proposal>,
    rejected: [u64; Reason::ALL.len()],
}

/// Try every approach and depth.
fn try_pair(scene: &Scene<'_>, settings: &Settings, pair: &Pair, is_on_part: bool) -> Tried {
    let opening = (pair.width + 2.0 * settings.clearance).min(scene.judge.stroke);
    let comer = Comer::new(scene.hand, opening, settings.travel);
    let middle = (pair.points[0] + pair.points[1]) / 2.0;
    let (u, v) = approach_axes(scene, &pair.axis);
    let mut tried = Tried { arrived: Vec::new(), rejected: [0; Reason::ALL.len()] };
    for turn in 0..settings.approaches {
        let (s, c) = (TAU * turn as f64 / settings.approaches as f64).sin_cos();
        let come = u * c + v * s;
        let rotation = Matrix3::from_columns(&[pair.axis.cross(&come), pair.axis, come]);
        for depth in &settings.depths {
            let pose = Pose { rotation, translation: middle + come * *depth };
            match comer.arrives(scene.collider, scene.support.as_ref(), &pose, settings.margin) {
                Ok(()) => {
                    tried.arrived.push(propose(&scene.judge, facts(pair, pose, is_on_part)));
                }
                Err(reason) => tried.rejected[reason as usize] += 1,
            }
        }
    }
    tried
}

/// Two unit vectors across a closing axis; the first is the approach that would be best: the demonstrated one, or
/// straight down, as far as the axis lets it.
fn approach_axes(scene: &Scene<'_>, axis: &Vec3) -> (Vec3, Vec3) {
    let wanted = scene.judge.approach.or(scene.judge.up.map(|up| -up));
    let across = wanted.and_then(|w| (w - axis * w.dot(axis)).try_normalize(1e-3));
    let first = across.unwrap_or_else(|| plane_axes(axis).0);
    (first, axis.cross(&first))
}

/// Close the pads: find where they really touch, centre the hand there, check it once more and score it.
fn close(scene: &Scene<'_>, settings: &Settings, candidate: &Proposal) -> Result<Proposal, Reason> {
    let Some(first) = scene.hand.finger.first() else { return Err(Reason::Pads) };
    let pad = Pad::of(first);
    let Facts { pose, width, .. } = candidate.facts;
    let from = (width / 2.0 + settings.clearance).min(scene.judge.stroke / 2.0);
    let touch = |side| pad.touch(scene.collider, &pose, side, from, width / 2.0).ok_or(Reason::Pads);
    let (right, left) = (touch(1.0)?, touch(-1.0)?);
    let width = (right.height + left.height).max(0.0);
    if width + 2.0 * settings.margin > scene.judge.stroke {
        return Err(Reason::TooWide);
    }
    let line = right.middle - left.middle;
    let tilt = line.x.hypot(line.z).atan2(width.max(2.0 * GIVE));
    let angle = candidate.facts.angle.max(tilt);
    if angle >= settings.cone {
        return Err(Reason::Pads);
    }
    let shift = pose.rotation.column(1) * ((right.height - left.height) / 2.0);
    let centred = Pose { translation: pose.translation + shift, ..pose };
    let opening = (width + 2.0 * settings.clearance).min(scene.judge.stroke);
    let comer = Comer::new(scene.hand, opening, settings.travel);
    comer.arrives(scene.collider, scene.support.as_ref(), &centred, settings.margin)?;
    if !closes(scene.collider, scene.hand, opening, width + 2.0 * GIVE, &centred) {
        return Err(Reason::Closing);
    }
    let contacts = [pose.apply(&right.middle), pose.apply(&left.middle)];
    let share = Some(right.share.min(left.share));
    let facts = Facts { pose: centred, contacts, width, angle, share, ..candidate.facts };
    Ok(propose(&scene.judge, facts))
}

fn propose(judge: &Judge, facts: Facts) -> Proposal {
    let terms = judge.terms(&facts);
    Proposal { facts, distance: judge.distance(&facts.contacts), terms, score: judge.score(&terms) }
}
