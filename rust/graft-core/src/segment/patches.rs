//! Patches: small regions with their borders in concave creases, from which parts are put together.

use std::collections::BinaryHeap;

use super::Vec3;
use super::elements::Elements;
use super::merge::Reach;

/// How much longer a way is across a concave crease, per radian.
const CREASE: f64 = 8.0;

/// How concave the surface is between two elements: the angle by which normals turn towards each other, radians.
#[must_use]
pub fn concavity(elements: &Elements, normals: &[Vec3], i: usize, j: usize) -> f64 {
    let along = elements.centers[j] - elements.centers[i];
    let turn = normals[j] - normals[i];
    if turn.dot(&along) < 0.0 { normals[i].angle(&normals[j]) } else { 0.0 }
}

/// Cut the surface into about `count` patches about points that are farthest from each other.
///
/// `groups` says of each element to which meaningful component it belongs (0: none); no patch spans two. Every
/// connected component gets a patch before any gets two, however many there are.
///
/// Returns the patch of each element and the number of patches.
#[must_use]
pub fn patches(elements: &Elements, normals: &[Vec3], groups: &[u32], count: usize) -> (Vec<u32>, usize) {
    let mut cost = vec![f64::INFINITY; elements.len()];
    let mut patch = vec![0_u32; elements.len()];
    let mut heap = BinaryHeap::new();
    let mut seed = 0;
    let mut made = 0;
    loop {
        cost[seed] = 0.0;
        patch[seed] = made as u32;
        made += 1;
        heap.push(Reach { cost: 0.0, place: seed });
        while let Some(Reach { cost: so_far, place: i }) = heap.pop() {
            if so_far > cost[i] {
                continue;
            }
            for edge in elements.edges_of(i) {
                let j = edge.to as usize;
                if groups[i] != groups[j] {
                    continue;
                }
                let way = so_far + edge.distance * (1.0 + CREASE * concavity(elements, normals, i, j));
                if way < cost[j] {
                    cost[j] = way;
                    patch[j] = patch[i];
                    heap.push(Reach { cost: way, place: j });
                }
            }
        }
        // The farthest; of equally far ones the first.
        seed = 0;
        for i in 1..elements.len() {
            if cost[i] > cost[seed] {
                seed = i;
            }
        }
        if cost[seed] <= 0.0 || (made >= count && cost[seed] < f64::INFINITY) {
            return (patch, made);
        }
    }
}
