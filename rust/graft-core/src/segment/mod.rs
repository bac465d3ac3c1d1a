//! Automatic parts of a surface: from a mesh or a point cloud to a label for each face or point.
//!
//! Elements (faces, points) are gathered into small patches; neighbours among them that people would hardly tell
//! apart are joined until only parts are left ([`merge`]), judged by what the closed solid looks like from inside
//! ([`voxels`], [`measure`]); last, the borders are drawn along creases ([`borders`]). One thread, no state: the same
//! input and seed give the same parts.

mod borders;
mod coarse;
pub mod elements;
mod flow;
mod groups;
mod measure;
mod merge;
mod patches;
#[cfg(test)]
mod tests;
mod voxels;

pub use coarse::MOST_FACES;
pub use elements::Repairs;

use crate::Error;
use crate::geometry::{OrientedBox, Vec3, minimal_box, points_of};
use borders::Borders;
use elements::Elements;
use measure::Patches;
use merge::Join;
use voxels::Voxels;

/// Patches that parts are put together from; each is some 6 % of the diagonal wide.
const PATCHES: usize = 300;

/// Normals are averaged over this share of the diagonal: scans are rough below, creases of household objects not.
const SMOOTHING: f64 = 0.02;

/// Fewer elements than this have no parts.
const FEWEST: usize = 16;

/// Log-odds above which regions stay apart. Even odds are 0; a little on the finer side the Rand-index error on the
/// tuning half is less (.093 rather than .099), and a border too many costs a transfer less than one that is missing.
const EVEN: f64 = -0.2;

/// Parts at most in the finest level of a hierarchy.
pub const FINEST: usize = 24;

/// Which cuts are wanted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Levels {
    /// As many parts as people would make.
    Chosen,
    /// So many.
    Count(usize),
    /// From the coarsest to twice as many as people would make, at most [`FINEST`]; each is made of parts of the
    /// next.
    All,
}

/// Labels for each level, and what was met.
#[derive(Debug, Clone)]
pub struct Segmentation {
    /// Labels per element, the part of largest area being 0; one list per level, coarse to fine.
    pub levels: Vec<Vec<u32>>,
    /// Which of the levels people would make.
    pub chosen: usize,
    /// Log-odds of the least clear of the chosen borders and of the clearest that was dropped.
    pub certainty: [f64; 2],
    /// What was met.
    pub repairs: Repairs,
}

/// Segment a mesh: (v, 3) finite `vertices` and (f, 3) `faces`, row-major.
///
/// # Errors
/// No faces, faces that name vertices which do not exist, coordinates that all coincide, or no parts wanted.
pub fn segment_mesh(vertices: &[f64], faces: &[i64], levels: Levels, seed: u64) -> Result<Segmentation, Error> {
    let points = points_of(vertices);
    let vertices = points.as_slice();
    if let Some(wrong) = faces.iter().find(|&&v| v < 0 || v >= vertices.len() as i64) {
        return Err(Error::value("faces", format!("indices below {}", vertices.len()), wrong));
    }
    let faces: Vec<[usize; 3]> = faces.chunks_exact(3).map(|f| [f[0], f[1], f[2]].map(|v| v as usize)).collect();
    let faces = faces.as_slice();
    if faces.is_empty() {
        return Err(Error::shape("faces", "at least one", 0));
    }
    let bounds = extent("vertices", vertices, levels)?;
    if faces.len() <= MOST_FACES {
        let mut repairs = Repairs::default();
        let elements = Elements::of_mesh(vertices, faces, bounds.diagonal(), &mut repairs);
        return Ok(segment(elements, &bounds, 0.0, levels, seed, repairs));
    }
    let low = vertices.iter().fold(vertices[0], |low, v| low.inf(v));
    let copy = coarse::coarse(vertices, faces, &low, bounds.diagonal());
    let mut repairs = Repairs { coarse: copy.faces.len(), ..Repairs::default() };
    if copy.faces.is_empty() {
        return Ok(single(faces.len(), repairs));
    }
    let elements = Elements::of_mesh(&copy.vertices, &copy.faces, bounds.diagonal(), &mut repairs);
    let mut found = segment(elements, &bounds, 0.0, levels, seed, repairs);
    for labels in &mut found.levels {
        *labels = copy.stands_for.iter().map(|&n| labels[n as usize]).collect();
    }
    Ok(found)
}

/// Segment a cloud: (p, 3) finite `points`, (p, 3) unit `normals` of either sign, (p, k) indices of `neighbours`.
///
/// # Errors
/// Arrays of different lengths, indices of points that do not exist, points that all coincide, or no parts wanted.
pub fn segment_cloud(
    points: &[f64],
    normals: &[f64],
    neighbours: &[i64],
    levels: Levels,
    seed: u64,
) -> Result<Segmentation, Error> {
    let (points, normals) = (points_of(points), points_of(normals));
    if normals.len() != points.len() {
        return Err(Error::shape("normals", format!("{} rows", points.len()), normals.len()));
    }
    if let Some(wrong) = neighbours.iter().find(|&&p| p < 0 || p >= points.len() as i64) {
        return Err(Error::value("neighbours", format!("indices below {}", points.len()), wrong));
    }
    let bounds = extent("points", &points, levels)?;
    let width = neighbours.len() / points.len();
    if width == 0 || width * points.len() != neighbours.len() {
        return Err(Error::shape("neighbours", format!("{} rows of at least one", points.len()), neighbours.len()));
    }
    let near: Vec<Vec<u32>> =
        neighbours.chunks_exact(width).map(|row| row.iter().map(|&p| p as u32).collect()).collect();
    let elements = Elements::of_cloud(&points, normals, &near);
    let spacing = elements.edges.iter().map(|e| e.distance).sum::<f64>() / elements.edges.len().max(1) as f64;
    Ok(segment(elements, &bounds, spacing, levels, seed, Repairs::default()))
}

fn extent(name: &'static str, points: &[Vec3], levels: Levels) -> Result<OrientedBox, Error> {
    if levels == Levels::Count(0) {
        return Err(Error::value("parts", "at least 1", 0));
    }
    if points.is_empty() {
        return Err(Error::shape(name, "at least one", 0));
    }
    let bounds = minimal_box(points);
    if bounds.diagonal() > 0.0 {
        return Ok(bounds);
    }
    Err(Error::value(name, "an extent", "coordinates that all coincide"))
}

fn single(count: usize, repairs: Repairs) -> Segmentation {
    Segmentation { levels: vec![vec![0; count]], chosen: 0, certainty: [0.0; 2], repairs }
}

fn segment(
    mut elements: Elements,
    bounds: &OrientedBox,
    radius: f64,
    levels: Levels,
    seed: u64,
    mut repairs: Repairs,
) -> Segmentation {
    if elements.len() < FEWEST {
        return single(elements.len(), repairs);
    }
    let diagonal = bounds.diagonal();
    let grid = Voxels::of(&elements, bounds, radius);
    repairs.flipped = grid.turn_outward(&mut elements);
    let groups = groups::groups(&mut elements, &grid, &mut repairs);
    let normals = elements.smoothed_normals(SMOOTHING * diagonal);
    let (patch, count) = patches::patches(&elements, &normals, &groups, PATCHES);
    let patches = Patches::of(&elements, &patch, count, &grid, diagonal, seed);
    let mut patch_group = vec![0; count];
    for (i, &p) in patch.iter().enumerate() {
        patch_group[p as usize] = groups[i];
    }
    let joins = merge::joins(&patches, &merge::seams(&elements, &normals, &patch, diagonal), &patch_group);
    let chosen = count - joins.iter().position(|j| j.apart > EVEN).unwrap_or(joins.len());
    let coarsest = count - joins.len();
    let wanted = match levels {
        Levels::Chosen => chosen,
        Levels::Count(parts) => parts.clamp(coarsest, count),
        Levels::All => (2 * chosen).min(FINEST).max(chosen).min(count),
    };
    let borders = Borders { elements: &elements, normals: &normals, grid: &grid, diagonal, groups: &groups };
    let region = regions(&joins, count, wanted);
    let labels: Vec<u32> = patch.iter().map(|&p| region[p as usize]).collect();
    let (numbered, parts) = by_area(&labels, &elements.areas);
    let finest = borders.refined(&numbered, parts);
    let cut =
        |parts: usize| by_area(&coarser(&finest, &numbered, &patch, &regions(&joins, count, parts)), &elements.areas).0;
    let made = match levels {
        Levels::All => (coarsest..=wanted).map(cut).collect(),
        _ => vec![cut(wanted)],
    };
    Segmentation {
        chosen: if levels == Levels::All { chosen - coarsest } else { 0 },
        levels: made,
        certainty: certainty(&joins, count - chosen),
        repairs,
    }
}

/// Log-odds of the first join that was not made and of the last that was.
fn certainty(joins: &[Join], made: usize) -> [f64; 2] {
    let kept = joins.get(made).map_or(0.0, |j| j.apart);
    let dropped = made.checked_sub(1).map_or(0.0, |last| joins[last].apart);
    [kept, dropped]
}

/// The region of each patch when `parts` regions are left; a region is called by its first patch.
fn regions(joins: &[Join], count: usize, parts: usize) -> Vec<u32> {
    let mut region: Vec<u32> = (0..count as u32).collect();
    for join in &joins[..count - parts] {
        for r in &mut region {
            if *r as usize == join.gone {
                *r = join.kept as u32;
            }
        }
    }
    region
}

/// Carry refined labels of a finer cut to a coarser one.
fn coarser(finest: &[u32], numbered: &[u32], patch: &[u32], region: &[u32]) -> Vec<u32> {
    let mut home = vec![0; numbered.iter().max().map_or(0, |&n| n as usize + 1)];
    for (&part, &p) in numbered.iter().zip(patch) {
        home[part as usize] = region[p as usize];
    }
    finest.iter().map(|&part| home[part as usize]).collect()
}

/// Number labels by falling area, ties by the lower label; returns how many there are.
fn by_area(labels: &[u32], areas: &[f64]) -> (Vec<u32>, usize) {
    let mut area = vec![-1.0; labels.iter().max().map_or(0, |&l| l as usize + 1)];
    for (&label, a) in labels.iter().zip(areas) {
        area[label as usize] = f64::max(area[label as usize], 0.0) + a;
    }
    let mut order: Vec<usize> = (0..area.len()).filter(|&l| area[l] >= 0.0).collect();
    order.sort_by(|&a, &b| area[b].total_cmp(&area[a]).then(a.cmp(&b)));
    let mut number = vec![0; area.len()];
    for (n, &label) in order.iter().enumerate() {
        number[label] = n as u32;
    }
    (labels.iter().map(|&l| number[l as usize]).collect(), order.len())
}
