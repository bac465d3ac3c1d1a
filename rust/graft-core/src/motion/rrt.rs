//! RRT-Connect: two trees that grow towards each other (Kuffner and `LaValle`, ICRA 2000), in any [`Space`].

use std::time::{Duration, Instant};

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::edges::edge_free;
use super::shortcut::{prune, shortcut};
use super::space::Space;
use crate::Error;

/// What a planner is told.
#[derive(Debug, Clone)]
pub struct Options {
    /// Edges that come nearer than this to an obstacle may be refused, metres, positive.
    pub clearance: f64,
    /// A tree grows by at most this in one step, metres, positive.
    pub step: f64,
    /// Probability of growing towards the root of the other tree rather than towards a random configuration.
    pub goal_bias: f64,
    /// Growths of a tree before giving up; with none only the direct edge is tried.
    pub max_iterations: usize,
    /// Wall time before giving up; the outcome then depends on the machine.
    pub time_limit: Option<Duration>,
    /// Random shortcuts that are tried on a path.
    pub shortcuts: usize,
    /// Of the random numbers.
    pub seed: u64,
}

impl Options {
    /// Whether every number is in its range.
    ///
    /// # Errors
    /// Names the first that is not.
    pub fn check(&self) -> Result<(), Error> {
        for (name, value) in [("clearance", self.clearance), ("step", self.step)] {
            if !(value.is_finite() && value > 0.0) {
                return Err(Error::value(name, "a positive number", value));
            }
        }
        if !(0.0..=1.0).contains(&self.goal_bias) {
            return Err(Error::value("goal_bias", "a number in [0, 1]", self.goal_bias));
        }
        Ok(())
    }
}

/// How planning ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// With a path.
    Found,
    /// The start is nearer than the clearance to an obstacle.
    StartBlocked,
    /// The goal is nearer than the clearance to an obstacle.
    GoalBlocked,
    /// No path within the iterations.
    OutOfIterations,
    /// No path within the time.
    OutOfTime,
}

/// A path, or why there is none.
#[derive(Debug, Clone)]
pub struct Plan<State> {
    /// How planning ended.
    pub outcome: Outcome,
    /// From start to goal; empty where none was found.
    pub path: Vec<State>,
    /// Growths of a tree; 0 where the direct edge was free.
    pub iterations: usize,
    /// Configurations in both trees.
    pub nodes: usize,
    /// Configurations that were tested for collisions.
    pub checks: usize,
}

struct Tree<State> {
    states: Vec<State>,
    /// Of the root: itself.
    parents: Vec<usize>,
}

impl<State: Clone> Tree<State> {
    fn new(root: State) -> Self {
        Self { states: vec![root], parents: vec![0] }
    }

    /// The nearest node; of equally near ones the oldest. A scan: trees have some hundreds of nodes.
    fn nearest<S: Space<State = State>>(&self, space: &S, to: &State) -> (usize, f64) {
        let mut best = (0, f64::INFINITY);
        for (i, state) in self.states.iter().enumerate() {
            let distance = space.distance(state, to);
            if distance < best.1 {
                best = (i, distance);
            }
        }
        best
    }

    fn push(&mut self, state: State, parent: usize) -> usize {
        self.states.push(state);
        self.parents.push(parent);
        self.states.len() - 1
    }

    /// From a node to the root.
    fn branch(&self, mut node: usize) -> Vec<State> {
        let mut states = vec![self.states[node].clone()];
        while self.parents[node] != node {
            node = self.parents[node];
            states.push(self.states[node].clone());
        }
        states
    }
}

/// How far a tree came towards a configuration.
enum Growth {
    Reached(usize),
    Advanced(usize),
    Trapped,
}

struct Search<'a, S: Space> {
    space: &'a S,
    options: &'a Options,
    checks: usize,
}

impl<S: Space> Search<'_, S> {
    /// Grow by one step from `from`, which is `distance` away from `to`.
    fn step(&mut self, tree: &mut Tree<S::State>, from: usize, distance: f64, to: &S::State) -> Growth {
        let arrives = distance <= self.options.step;
        let state =
            if arrives { to.clone() } else { self.space.between(&tree.states[from], to, self.options.step / distance) };
        self.checks += 1;
        let clearance = self.options.clearance;
        let free = self.space.clear(&state, clearance)
            && edge_free(self.space, &tree.states[from], &state, clearance, &mut self.checks);
        if !free {
            return Growth::Trapped;
        }
        let node = tree.push(state, from);
        if arrives { Growth::Reached(node) } else { Growth::Advanced(node) }
    }

    fn extend(&mut self, tree: &mut Tree<S::State>, to: &S::State) -> Growth {
        let (from, distance) = tree.nearest(self.space, to);
        self.step(tree, from, distance, to)
    }

    /// Grow step by step until `to` is reached or something is in the way.
    fn connect(&mut self, tree: &mut Tree<S::State>, to: &S::State) -> Option<usize> {
        let (mut from, mut distance) = tree.nearest(self.space, to);
        loop {
            match self.step(tree, from, distance, to) {
                Growth::Reached(node) => return Some(node),
                Growth::Trapped => return None,
                Growth::Advanced(node) => {
                    from = node;
                    distance = self.space.distance(&tree.states[node], to);
                }
            }
        }
    }
}

/// Plan from `start` to `goal`. The same seed gives the same path unless a time limit ends the search.
#[must_use]
pub fn plan<S: Space>(space: &S, start: &S::State, goal: &S::State, options: &Options) -> Plan<S::State> {
    let mut plan = Plan { outcome: Outcome::StartBlocked, path: Vec::new(), iterations: 0, nodes: 0, checks: 2 };
    if !space.clear(start, options.clearance) {
        return plan;
    }
    if !space.clear(goal, options.clearance) {
        plan.outcome = Outcome::GoalBlocked;
        return plan;
    }
    let begun = Instant::now();
    let mut random = Pcg64::seed_from_u64(options.seed);
    let mut search = Search { space, options, checks: plan.checks };
    if edge_free(space, start, goal, options.clearance, &mut search.checks) {
        return Plan {
            outcome: Outcome::Found,
            path: vec![start.clone(), goal.clone()],
            nodes: 2,
            checks: search.checks,
            ..plan
        };
    }
    let mut trees = [Tree::new(start.clone()), Tree::new(goal.clone())];
    plan.outcome = Outcome::OutOfIterations;
    while plan.iterations < options.max_iterations {
        if options.time_limit.is_some_and(|limit| begun.elapsed() >= limit) {
            plan.outcome = Outcome::OutOfTime;
            break;
        }
        let from_goal = plan.iterations % 2 == 1;
        plan.iterations += 1;
        let [first, second] = &mut trees;
        let (growing, other) = if from_goal { (second, first) } else { (first, second) };
        let target =
            if random.random_bool(options.goal_bias) { other.states[0].clone() } else { space.sample(&mut random) };
        let (Growth::Reached(node) | Growth::Advanced(node)) = search.extend(growing, &target) else {
            continue;
        };
        let met = growing.states[node].clone();
        if let Some(there) = search.connect(other, &met) {
            let (on_start, on_goal) = if from_goal { (there, node) } else { (node, there) };
            plan.path = trees[0].branch(on_start);
            plan.path.reverse();
            // Both branches end where the trees met.
            plan.path.extend(trees[1].branch(on_goal).into_iter().skip(1));
            if options.shortcuts > 0 {
                let (path, checks) = (&mut plan.path, &mut search.checks);
                prune(space, path, options.clearance, checks);
                shortcut(space, path, options.shortcuts, options.clearance, &mut random, checks);
                prune(space, path, options.clearance, checks);
            }
            plan.outcome = Outcome::Found;
            break;
        }
    }
    plan.nodes = trees.iter().map(|tree| tree.states.len()).sum();
    plan.checks = search.checks;
    plan
}
