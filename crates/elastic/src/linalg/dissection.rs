//! Nested dissection: an elimination order that keeps the factors of meshes sparse (George 1973).

use super::block_matrix::SparsityPattern;
use meniscus_numerics::Vector;

/// Number of vertices up to which a part is not divided further.
const MAX_LEAF_VERTICES: usize = 24;

/// Elimination order of the `kept` vertices: recursively both halves, then the separator between them. Halves are cut across the
/// longest side.
pub fn nested_dissection<const D: usize>(
    positions: &[Vector<D>],
    pattern: &SparsityPattern,
    kept: Vec<u32>,
) -> Vec<u32> {
    let mut neighbours: Vec<Vec<u32>> = vec![Vec::new(); positions.len()];
    for j in 0..positions.len() {
        for i in &pattern.column(j)[1..] {
            neighbours[j].push(*i);
            neighbours[*i as usize].push(j as u32);
        }
    }
    let mut dissection =
        Dissection { positions, neighbours, in_second_half: vec![false; positions.len()], order: Vec::new() };
    dissection.divide(kept);
    dissection.order
}

struct Dissection<'a, const D: usize> {
    positions: &'a [Vector<D>],
    neighbours: Vec<Vec<u32>>,
    /// Whether a vertex is in the second half of the part that is being divided.
    in_second_half: Vec<bool>,
    order: Vec<u32>,
}

impl<const D: usize> Dissection<'_, D> {
    fn divide(&mut self, mut part: Vec<u32>) {
        if part.len() <= MAX_LEAF_VERTICES {
            self.order.extend(part);
            return;
        }
        let axis = self.longest_axis(&part);
        let key = |v: &u32| self.positions[*v as usize][axis];
        part.sort_by(|a, b| key(a).total_cmp(&key(b)).then(a.cmp(b)));
        // Whole rows of a regular mesh stay on one side.
        let middle = key(&part[part.len() / 2]);
        let mut cut = part.partition_point(|v| key(v) < middle - 1e-9 * middle.abs());
        if cut == 0 {
            cut = part.len() / 2;
        }
        let right = part.split_off(cut);
        right.iter().for_each(|v| self.in_second_half[*v as usize] = true);
        let beside = |v: &u32| self.neighbours[*v as usize].iter().any(|n| self.in_second_half[*n as usize]);
        let (separator, left): (Vec<u32>, Vec<u32>) = part.into_iter().partition(beside);
        right.iter().for_each(|v| self.in_second_half[*v as usize] = false);
        self.divide(left);
        self.divide(right);
        self.order.extend(separator);
    }

    fn longest_axis(&self, part: &[u32]) -> usize {
        let extent = |a: usize| {
            let at = part.iter().map(|v| self.positions[*v as usize][a]);
            at.clone().fold(f64::NEG_INFINITY, f64::max) - at.fold(f64::INFINITY, f64::min)
        };
        (0..D).fold(0, |best, a| if extent(a) > extent(best) { a } else { best })
    }
}
