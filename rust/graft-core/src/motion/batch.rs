//! Many plans in one world: its tree is built once.

use super::arm::Arm;
use super::chain::Chain;
use super::hand::{Hand, reach};
use super::obstacles::Obstacles;
use super::pose::Pose;
use super::rrt::{Options, Plan, plan};
use super::space::Space;
use crate::Error;
use crate::geometry::{OrientedBox, Vec3};

/// Plan from each start to the goal of the same index with a hand made of `boxes`, whose origin
/// is sampled in the bounds of the same index.
///
/// # Errors
/// Options out of range, or as many starts as goals there are not.
pub fn plan_hands(
    obstacles: &Obstacles,
    boxes: &[OrientedBox],
    bounds: &[[Vec3; 2]],
    starts: &[Pose],
    goals: &[Pose],
    options: &Options,
) -> Result<Vec<Plan<Pose>>, Error> {
    check(starts.len(), goals.len(), options)?;
    if bounds.len() != starts.len() {
        return Err(Error::shape("bounds", format!("one for each of {} starts", starts.len()), bounds.len()));
    }
    let radius = reach(boxes);
    let run = |((start, goal), bounds): ((&Pose, &Pose), &[Vec3; 2])| {
        let hand = Hand { boxes, obstacles, bounds: *bounds, ends: [*start, *goal], radius };
        plan(&hand, start, goal, options)
    };
    Ok(starts.iter().zip(goals).zip(bounds).map(run).collect())
}

/// What an arm may not do: touch obstacles with some boxes, or some pairs of its boxes with each other.
#[derive(Debug, Clone, Default)]
pub struct Contacts {
    /// Indices of the boxes that keep away from the obstacles.
    pub movers: Vec<usize>,
    /// Pairs of boxes that keep away from each other.
    pub pairs: Vec<(usize, usize)>,
}

impl Contacts {
    fn check(&self, boxes: usize) -> Result<(), Error> {
        let named = self.movers.iter().chain(self.pairs.iter().flat_map(|(i, j)| [i, j]));
        match named.copied().find(|&i| i >= boxes) {
            Some(i) => Err(Error::value("movers, pairs", format!("indices of {boxes} boxes"), i)),
            None => Ok(()),
        }
    }
}

/// Plan from each start to the goal of the same index with an arm.
///
/// # Errors
/// Options out of range, joint values that do not fit the arm, contacts between boxes it has not.
pub fn plan_arms(
    obstacles: &Obstacles,
    chain: &Chain,
    contacts: &Contacts,
    starts: &[Vec<f64>],
    goals: &[Vec<f64>],
    options: &Options,
) -> Result<Vec<Plan<Vec<f64>>>, Error> {
    check(starts.len(), goals.len(), options)?;
    let arm = arm_among(obstacles, chain, contacts, starts.iter().chain(goals))?;
    Ok(starts.iter().zip(goals).map(|(start, goal)| plan(&arm, start, goal, options)).collect())
}

/// Which joint values keep `slack` metres from every contact.
///
/// # Errors
/// Joint values that do not fit the arm, contacts between boxes it has not.
pub fn clear_arms(
    obstacles: &Obstacles,
    chain: &Chain,
    contacts: &Contacts,
    values: &[Vec<f64>],
    slack: f64,
) -> Result<Vec<bool>, Error> {
    let arm = arm_among(obstacles, chain, contacts, values.iter())?;
    Ok(values.iter().map(|q| arm.clear(q, slack)).collect())
}

fn arm_among<'a, 'q>(
    obstacles: &'a Obstacles,
    chain: &'a Chain,
    contacts: &'a Contacts,
    mut values: impl Iterator<Item = &'q Vec<f64>>,
) -> Result<Arm<'a>, Error> {
    contacts.check(chain.boxes().len())?;
    let joints = chain.limits().len();
    if let Some(q) = values.find(|q| q.len() != joints) {
        return Err(Error::shape("joint values", format!("{joints} joints"), q.len()));
    }
    Ok(Arm { chain, obstacles, movers: &contacts.movers, pairs: &contacts.pairs })
}

fn check(starts: usize, goals: usize, options: &Options) -> Result<(), Error> {
    if starts != goals {
        return Err(Error::shape("goals", format!("one for each of {starts} starts"), goals));
    }
    options.check()
}
