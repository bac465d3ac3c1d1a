//! From patches to parts: join the two neighbours that people are least likely to tell apart, again and again.
//!
//! How likely people are to tell two regions apart is a logistic function of seven terms, fitted by logistic regression
//! to the share of pairs of faces that people put apart, over the pairs of regions met while joining, on the tuning
//! half of 38 household objects. At even odds joining costs as much Rand index as it gains, so the number of parts
//! needs no choice of its own.

use std::cmp::Ordering;
use std::collections::{BTreeMap, BinaryHeap};

use super::Vec3;
use super::elements::Elements;
use super::measure::Patches;

/// Weights of 1, invisibility, difference of thickness, seam's concavity, neck, size, seam's length, and invisibility
/// times concavity (a bend of a tube hides its ends from each other, but its seam is concave on one side only).
const WEIGHTS: [f64; 8] = [-0.58, 4.66, 1.14, 0.54, 0.66, 0.60, -0.67, 1.10];

/// Width of the strip beside a seam over which a neck is told, in diagonals.
const STRIP: f64 = 0.05;

/// Mean curvature of a seam counts up to this much, in turns of a radian per tenth of the diagonal.
const SHARPEST: f64 = 2.0;

/// Lengths below this share of the diagonal are no longer told apart.
const SHORTEST: f64 = 1e-4;

/// A region of less than this share of the area is a crumb, no part: it is joined before anything else.
const CRUMB: f64 = 0.004;

/// Taken from the log-odds of crumbs.
const SWEPT: f64 = 50.0;

/// Added to the log-odds of different components that each carry meaning: joined after everything else.
const APART: f64 = 100.0;

/// The border of two patches.
#[derive(Debug, Clone, Copy, Default)]
pub struct Seam {
    /// Length in diagonals.
    pub length: f64,
    /// Integral along it of how concave it is: radians per tenth of the diagonal.
    pub concave: f64,
}

/// Seams of patches p < q, in order.
pub type Seams = BTreeMap<(usize, usize), Seam>;

/// Measure the seams between patches.
#[must_use]
pub fn seams(elements: &Elements, normals: &[Vec3], patch: &[u32], diagonal: f64) -> Seams {
    let mut found = Seams::new();
    for i in 0..elements.len() {
        for edge in elements.edges_of(i) {
            let j = edge.to as usize;
            if patch[i] >= patch[j] {
                continue;
            }
            let seam = found.entry((patch[i] as usize, patch[j] as usize)).or_default();
            let length = edge.length / diagonal;
            let outward = (normals[j] - normals[i]).dot(&(elements.centers[j] - elements.centers[i])) >= 0.0;
            let angle = normals[i].angle(&normals[j]) * if outward { -1.0 } else { 1.0 };
            seam.length += length;
            seam.concave += length * angle / (10.0 * edge.distance / diagonal).max(f64::MIN_POSITIVE);
        }
    }
    found
}

/// One step of the hierarchy: region `gone` became part of region `kept`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Join {
    /// Region (called by its lowest patch) that remains.
    pub kept: usize,
    /// Region that is joined to it.
    pub gone: usize,
    /// Log-odds that people tell the two apart; positive: they would.
    pub apart: f64,
}

struct Region {
    members: Vec<usize>,
    share: f64,
    thickness: f64,
}

struct Border {
    seam: Seam,
    /// Patches of the lower and of the higher region that touch the other.
    touching: [Vec<usize>; 2],
}

struct State<'a> {
    patches: &'a Patches,
    /// (n, n) geodesic distances of patches.
    between: Vec<f64>,
    regions: Vec<Region>,
    visible: Vec<f64>,
    borders: BTreeMap<(usize, usize), Border>,
    groups: &'a [u32],
}

/// Join regions until none touch; the joins are in the order in which they were made.
///
/// `groups` says of each patch to which meaningful component it belongs; 0 is none.
#[must_use]
pub fn joins(patches: &Patches, seams: &Seams, groups: &[u32]) -> Vec<Join> {
    let mut state = State::new(patches, seams, groups);
    let mut costs: BTreeMap<(usize, usize), f64> =
        state.borders.iter().map(|(&pair, border)| (pair, state.apart(pair, border))).collect();
    let mut made = Vec::with_capacity(patches.count);
    // Of equal costs the first pair in order.
    while let Some(((kept, gone), apart)) =
        costs.iter().min_by(|x, y| x.1.total_cmp(y.1)).map(|(&pair, &cost)| (pair, cost))
    {
        made.push(Join { kept, gone, apart });
        state.join(kept, gone);
        costs.retain(|&(a, b), _| a != kept && b != kept && a != gone && b != gone);
        for (&pair, border) in state.borders.iter().filter(|((a, b), _)| *a == kept || *b == kept) {
            costs.insert(pair, state.apart(pair, border));
        }
    }
    made
}

impl<'a> State<'a> {
    fn new(patches: &'a Patches, seams: &Seams, groups: &'a [u32]) -> Self {
        let count = patches.count;
        let regions = (0..count)
            .map(|p| Region { members: vec![p], share: patches.share[p], thickness: patches.log_thickness[p] })
            .collect();
        let mut visible = patches.visible.clone();
        for p in 0..count {
            for q in 0..count {
                visible[p * count + q] *= patches.share[p] * patches.share[q];
            }
        }
        let borders =
            seams.iter().map(|(&(p, q), &seam)| ((p, q), Border { seam, touching: [vec![p], vec![q]] })).collect();
        Self { patches, between: distances(patches, seams), regions, visible, borders, groups }
    }

    /// Log-odds that people tell two regions apart.
    fn apart(&self, (a, b): (usize, usize), border: &Border) -> f64 {
        let (first, second) = (&self.regions[a], &self.regions[b]);
        let seen = self.visible[a * self.patches.count + b] / (first.share * second.share);
        let length = border.seam.length.max(SHORTEST);
        let neck = [(first, &border.touching[0]), (second, &border.touching[1])]
            .map(|(region, touching)| (length / self.perimeter(region, touching)).ln());
        let hidden = 1.0 - seen;
        let concave = (border.seam.concave / border.seam.length.max(f64::MIN_POSITIVE)).clamp(-SHARPEST, SHARPEST);
        let measures = [
            1.0,
            hidden,
            (first.thickness - second.thickness).abs(),
            concave,
            neck[0].max(neck[1]),
            first.share.min(second.share).ln(),
            length.ln(),
            hidden * concave,
        ];
        let own = WEIGHTS.iter().zip(measures).map(|(w, x)| w * x).sum::<f64>();
        let (g, h) = (self.groups[first.members[0]], self.groups[second.members[0]]);
        let meant = g != h && g != 0 && h != 0;
        let crumb = first.share.min(second.share) < CRUMB;
        own + if meant { APART } else { 0.0 } - if crumb { SWEPT } else { 0.0 }
    }

    /// How long the lines around a region beside a seam are: the area of a strip over its width.
    fn perimeter(&self, region: &Region, touching: &[usize]) -> f64 {
        let area: f64 = region
            .members
            .iter()
            .map(|&p| {
                let away =
                    touching.iter().map(|&q| self.between[p * self.patches.count + q]).fold(f64::INFINITY, f64::min);
                // A patch counts by how much of it lies in the strip; half a strip for its own extent.
                self.patches.areas[p] * (1.5 - away / STRIP).clamp(0.0, 1.0)
            })
            .sum();
        (area / STRIP).max(SHORTEST)
    }

    fn join(&mut self, kept: usize, gone: usize) {
        let count = self.patches.count;
        for p in 0..count {
            self.visible[kept * count + p] += self.visible[gone * count + p];
        }
        for p in 0..count {
            self.visible[p * count + kept] += self.visible[p * count + gone];
        }
        let old =
            std::mem::replace(&mut self.regions[gone], Region { members: Vec::new(), share: 0.0, thickness: 0.0 });
        let region = &mut self.regions[kept];
        let share = region.share + old.share;
        region.thickness = (region.thickness * region.share + old.thickness * old.share) / share;
        region.share = share;
        region.members.extend(old.members);
        self.borders.remove(&(kept, gone));
        let moved: Vec<(usize, usize)> =
            self.borders.keys().copied().filter(|&(a, b)| a == gone || b == gone).collect();
        for (a, b) in moved {
            let Some(mut border) = self.borders.remove(&(a, b)) else { continue };
            let other = if a == gone { b } else { a };
            if (a == gone) != (kept < other) {
                border.touching.swap(0, 1);
            }
            let Border { seam, touching: [low, high] } = border;
            let into = self
                .borders
                .entry((kept.min(other), kept.max(other)))
                .or_insert_with(|| Border { seam: Seam::default(), touching: [Vec::new(), Vec::new()] });
            into.seam.length += seam.length;
            into.seam.concave += seam.concave;
            for (mine, theirs) in into.touching.iter_mut().zip([low, high]) {
                mine.extend(theirs);
                mine.sort_unstable();
                mine.dedup();
            }
        }
    }
}

/// Distances between all patches along the graph of their seams (Dijkstra), in diagonals.
fn distances(patches: &Patches, seams: &Seams) -> Vec<f64> {
    let count = patches.count;
    let mut near = vec![Vec::new(); count];
    for &(p, q) in seams.keys() {
        let far = (patches.centers[p] - patches.centers[q]).norm();
        near[p].push((q, far));
        near[q].push((p, far));
    }
    let mut between = vec![f64::INFINITY; count * count];
    for (start, row) in between.chunks_exact_mut(count.max(1)).enumerate() {
        row[start] = 0.0;
        let mut heap = BinaryHeap::from([Reach { cost: 0.0, place: start }]);
        while let Some(Reach { cost, place }) = heap.pop() {
            if cost > row[place] {
                continue;
            }
            for &(next, far) in &near[place] {
                if cost + far < row[next] {
                    row[next] = cost + far;
                    heap.push(Reach { cost: cost + far, place: next });
                }
            }
        }
    }
    between
}

/// A place reached at a cost; the nearest is the greatest, ties by the lower place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reach {
    /// What it costs to get there.
    pub cost: f64,
    /// The place.
    pub place: usize,
}

impl Eq for Reach {}

impl PartialOrd for Reach {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Reach {
    fn cmp(&self, other: &Self) -> Ordering {
        other.cost.total_cmp(&self.cost).then(other.place.cmp(&self.place))
    }
}
