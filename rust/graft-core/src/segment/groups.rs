//! Which connected components carry meaning, and links between those that do not.

use std::collections::HashMap;

use super::elements::{Elements, Repairs};
use super::voxels::Voxels;

/// A component of less than this share of the area is no part of its own.
const SMALLEST: f64 = 0.01;

/// More components than this, and none of them was meant as a part: a soup.
const MOST: usize = 32;

/// A component of which more than this share lies within the solid is the lining of another one.
const HIDDEN: f64 = 0.9;

/// Elements of one cell that are compared with those of the next; more would make dense soups quadratic.
const PER_CELL: usize = 8;

/// Return the group of each element: 1 and up for meaningful components, 0 for the rest, which gets linked to what
/// lies nearest.
pub fn groups(elements: &mut Elements, grid: &Voxels, repairs: &mut Repairs) -> Vec<u32> {
    let count = elements.component.iter().max().map_or(0, |&c| c as usize + 1);
    repairs.components = count;
    if count < 2 {
        return vec![0; elements.len()];
    }
    let total: f64 = elements.areas.iter().sum();
    let mut area = vec![0.0; count];
    let mut hidden = vec![0.0; count];
    for i in 0..elements.len() {
        let c = elements.component[i] as usize;
        area[c] += elements.areas[i];
        let (center, off) = (elements.centers[i], elements.normals[i] * (2.0 * grid.size));
        if grid.filled(&(center + off)) && grid.filled(&(center - off)) {
            hidden[c] += elements.areas[i];
        }
    }
    let mut meant: Vec<bool> =
        (0..count).map(|c| area[c] >= SMALLEST * total && hidden[c] <= HIDDEN * area[c]).collect();
    if meant.iter().filter(|&&m| m).count() > MOST {
        meant.fill(false);
    }
    let mut next = 0;
    let number: Vec<u32> = meant
        .iter()
        .map(|&m| {
            next += u32::from(m);
            if m { next } else { 0 }
        })
        .collect();
    repairs.joined = meant.iter().filter(|&&m| !m).count();
    let links = links(elements, grid, &meant);
    elements.link(&links);
    elements.component.iter().map(|&c| number[c as usize]).collect()
}

/// Link elements of different components that lie in the same or neighbouring voxels, and loose components to the
/// one before them in the order of their places.
fn links(elements: &Elements, grid: &Voxels, meant: &[bool]) -> Vec<(u32, u32, f64)> {
    let mut cells: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
    let mut keys = Vec::with_capacity(elements.len());
    for (i, center) in elements.centers.iter().enumerate() {
        let key = [0, 1, 2].map(|k| (center[k] / (2.0 * grid.size)).floor() as i64);
        keys.push(key);
        let held = cells.entry(key).or_default();
        if held.len() < PER_CELL {
            held.push(i as u32);
        }
    }
    let mut links = Vec::new();
    for (i, key) in keys.iter().enumerate() {
        // The nearest element of another component in the cells around.
        let mut best: Option<(f64, u32)> = None;
        for step in 0..27 {
            let near = [key[0] + step / 9 - 1, key[1] + step / 3 % 3 - 1, key[2] + step % 3 - 1];
            for &j in cells.get(&near).map_or(&[][..], Vec::as_slice) {
                if elements.component[j as usize] == elements.component[i] {
                    continue;
                }
                let far = (elements.centers[j as usize] - elements.centers[i]).norm();
                if best.is_none_or(|(least, first)| far < least || (far <= least && j < first)) {
                    best = Some((far, j));
                }
            }
        }
        if let Some((_, j)) = best {
            links.push((i as u32, j, grid.size));
        }
    }
    let mut firsts: Vec<usize> = Vec::new();
    let mut seen = vec![false; meant.len()];
    for i in 0..elements.len() {
        let c = elements.component[i] as usize;
        if !seen[c] {
            seen[c] = true;
            firsts.push(i);
        }
    }
    firsts.sort_by(|&a, &b| {
        let (p, q) = (keys[a], keys[b]);
        p.cmp(&q).then(a.cmp(&b))
    });
    for two in firsts.windows(2) {
        let loose = two.iter().any(|&i| !meant[elements.component[i] as usize]);
        if loose {
            links.push((two[0] as u32, two[1] as u32, grid.size));
        }
    }
    links
}
