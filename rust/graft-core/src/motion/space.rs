//! What a planner needs to know of a configuration space.

use rand_pcg::Pcg64;

/// A space of configurations with obstacles in it.
///
/// Distances are in metres: between `a` and `b` no point of what moves travels further than `distance(a, b)`, and along
/// `between` it travels evenly. Edges are certified with that, see [`super::edges`].
pub trait Space {
    /// One configuration.
    type State: Clone;

    /// An upper bound of how far any point of what moves travels from `a` to `b`, metres; a metric.
    fn distance(&self, a: &Self::State, b: &Self::State) -> f64;

    /// The configuration at `t` in [0, 1] of the way from `a` to `b`; its distance from `a` is `t * distance(a, b)`.
    fn between(&self, a: &Self::State, b: &Self::State, t: f64) -> Self::State;

    /// A random configuration, not necessarily a free one.
    fn sample(&self, random: &mut Pcg64) -> Self::State;

    /// Whether nothing touches when what moves is grown by `slack` metres on every side.
    fn clear(&self, state: &Self::State, slack: f64) -> bool;
}
