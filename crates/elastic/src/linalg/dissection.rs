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
        Dissection { positions, neighbours, in_other_half: vec![false; positions.len()], order: Vec::new() };
    dissection.divide(kept);
    dissection.order
}

/// A part without its separator, and the separator.
struct Dissected {
    separator: Vec<u32>,
    halves: [Vec<u32>; 2],
}

struct Dissection<'a, const D: usize> {
    positions: &'a [Vector<D>],
    neighbours: Vec<Vec<u32>>,
    /// Whether a vertex is in the other half of the part that is being divided.
    in_other_half: Vec<bool>,
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
        // Whole rows of a regular mesh stay on one side: the cut is below or above the middle one.
        let middle = key(&part[part.len() / 2]);
        let tolerance = 1e-9 * middle.abs();
        let below = part.partition_point(|v| key(v) < middle - tolerance);
        let above = part.partition_point(|v| key(v) <= middle + tolerance);
        let inside = |cut: &usize| (1..part.len()).contains(cut);
        let mut cuts: Vec<usize> = [below, above].into_iter().filter(inside).collect();
        if cuts.is_empty() {
            cuts.push(part.len() / 2);
        }
        let dissected = cuts.into_iter().flat_map(|cut| self.dissections(&part, cut)).collect::<Vec<_>>();
        let Some(Dissected { separator, halves: [left, right] }) =
            dissected.into_iter().min_by_key(|dissected| dissected.separator.len())
        else {
            return;
        };
        self.divide(left);
        self.divide(right);
        self.order.extend(separator);
    }

    /// The two dissections at a cut of a part: the separator is the boundary layer of either half. Quadratic elements reach over two rows
    /// of vertices, and the layer on the side where the cut leaves them whole is half as thick as the other.
    fn dissections(&mut self, part: &[u32], cut: usize) -> [Dissected; 2] {
        let (left, right) = part.split_at(cut);
        let mut peel = |half: &[u32], other: &[u32]| -> [Vec<u32>; 2] {
            other.iter().for_each(|v| self.in_other_half[*v as usize] = true);
            let beside =
                |v: &u32| self.neighbours[*v as usize].iter().any(|n| self.in_other_half[*n as usize]);
            let (separator, rest) = half.iter().partition(|v| beside(v));
            other.iter().for_each(|v| self.in_other_half[*v as usize] = false);
            [separator, rest]
        };
        let ([from_left, left_rest], [from_right, right_rest]) = (peel(left, right), peel(right, left));
        [
            Dissected { separator: from_left, halves: [left_rest, right.to_vec()] },
            Dissected { separator: from_right, halves: [left.to_vec(), right_rest] },
        ]
    }

    fn longest_axis(&self, part: &[u32]) -> usize {
        let extent = |a: usize| {
            let at = part.iter().map(|v| self.positions[*v as usize][a]);
            at.clone().fold(f64::NEG_INFINITY, f64::max) - at.fold(f64::INFINITY, f64::min)
        };
        (0..D).fold(0, |best, a| if extent(a) > extent(best) { a } else { best })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::Cliques;

    /// Quadratic elements on three by three vertices of a square: the last separator is one row of vertices between elements. The boundary
    /// layer of the lower half alone would be two rows.
    #[test]
    fn a_separator_of_quadratic_elements_is_one_row() {
        let n = 17;
        let positions: Vec<Vector<2>> =
            (0..n * n).map(|v| Vector::from([(v % n) as f64, 0.9 * (v / n) as f64])).collect();
        let mut elements = Cliques::default();
        for (i, j) in (0..n - 1).step_by(2).flat_map(|i| (0..n - 1).step_by(2).map(move |j| (i, j))) {
            elements.push((0..9).map(|k| ((j + k / 3) * n + i + k % 3) as u32));
        }
        let pattern = SparsityPattern::new(n * n, [&elements]);
        let order = nested_dissection(&positions, &pattern, (0..(n * n) as u32).collect());
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert!(sorted.iter().enumerate().all(|(k, v)| k == *v as usize), "every vertex once");
        let last = &order[order.len() - n..];
        let middle = last[0] as usize % n;
        assert!(last.iter().all(|v| *v as usize % n == middle) && middle.is_multiple_of(2), "{last:?}");
        let side = |v: &u32| (*v as usize % n).cmp(&middle);
        let apart = |element: &[u32]| {
            !element.iter().any(|a| element.iter().any(|b| side(a) == side(b).reverse() && side(a).is_ne()))
        };
        assert!(elements.iter().all(apart));
    }
}
