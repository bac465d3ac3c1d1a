//! What a match costs: its transport, and how well the demonstrated part is placed.

use crate::transport::feature::FeatureCost;
use crate::transport::{Options, Solution};

/// Shares and claims below this count as this in the terms about the demonstrated part.
const SMALLEST_SHARE: f64 = 1e-9;

/// What a match costs.
#[derive(Debug, Clone, Copy)]
pub struct Ranking {
    /// Of the transport.
    pub options: Options,
    /// Of the features.
    pub feature: FeatureCost,
    /// Weight of the demonstrated part's own feature cost.
    pub part_weight: f64,
    /// Weight of -log of its share.
    pub doubt_weight: f64,
    /// Weight of -log of its claim, its share of what the part that it goes to receives.
    pub rival_weight: f64,
}

impl Ranking {
    /// The sharp transport cost plus the terms of the demonstrated part.
    #[must_use]
    pub fn cost(&self, solution: &Solution, features: &[f64], part: usize) -> f64 {
        let m = solution.target_mass.len();
        let terms = &solution.terms;
        let sharp = terms.structure + terms.feature + terms.marginal_source + terms.marginal_target;
        let row = &solution.plan[part * m..(part + 1) * m];
        let weigh = |(t, nu): (&f64, &f64)| if *nu > 0.0 { t / nu.sqrt() } else { 0.0 };
        let mut shares: Vec<f64> = row.iter().zip(&solution.target_mass).map(weigh).collect();
        let total: f64 = shares.iter().sum();
        if total > 0.0 {
            for share in &mut shares {
                *share /= total;
            }
        }
        // Where the part sends nothing: the part that receives most, with no share.
        let received = |j: usize| solution.plan.iter().skip(j).step_by(m).sum::<f64>();
        let value = |j: usize| if total > 0.0 { shares[j] } else { received(j) };
        let goal = (1..m).fold(0, |goal, j| if value(j) > value(goal) { j } else { goal });
        let all = received(goal);
        let claim = if all > 0.0 { row[goal] / all } else { 0.0 };
        let own = self.part_weight * features[part * m + goal];
        let doubt = -self.doubt_weight * shares[goal].max(SMALLEST_SHARE).ln();
        let rivals = -self.rival_weight * claim.max(SMALLEST_SHARE).ln();
        sharp + own + doubt + rivals
    }
}
