//! A coarse lattice around a mesh, on which systems of the whole are solved roughly.
//!
//! A field on the lattice is one on the mesh by interpolation, which shifts, turns and even strains are exactly. What is smooth
//! over some edges is solved for there; it is all that keeps the blocks of a matrix's diagonal from telling what the rest does.

use super::{BlockMatrix, CholeskyFactor, Cliques, SparsityPattern, SymbolicFactor};
use meniscus_numerics::{Matrix, Vector};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Spacing of the lattice, over the mean way between neighbours.
const SPACING_EDGES: f64 = 4.0;
/// Part of itself that is added to its matrix's diagonal: where few vertices are, they do not tell all nodes apart.
const DIAGONAL_SHIFT: f64 = 1e-6;

/// The nodes around the vertices of a mesh.
#[derive(Debug)]
pub struct CoarseLattice {
    /// For each vertex the nodes around it and their weights; a held one has none.
    weights: Vec<Vec<(u32, f64)>>,
    pattern: Arc<SparsityPattern>,
    symbolic: Arc<SymbolicFactor>,
}

/// A matrix on the lattice, factorised.
#[derive(Clone, Debug)]
pub struct CoarseFactor {
    lattice: Arc<CoarseLattice>,
    factor: CholeskyFactor,
}

impl CoarseLattice {
    /// Around vertices at these positions, coupled as the pattern says, of which some are held. Nothing where memory does not
    /// suffice.
    pub fn new<const D: usize>(
        positions: &[Vector<D>],
        fine: &SparsityPattern,
        anchored: &[bool],
    ) -> Option<Self> {
        let pairs =
            (0..anchored.len()).flat_map(|j| fine.column(j)[1..].iter().map(move |i| (*i as usize, j)));
        let count = fine.rows.len().saturating_sub(anchored.len()).max(1) as f64;
        let mean_edge = pairs.clone().map(|(i, j)| (positions[i] - positions[j]).norm()).sum::<f64>() / count;
        let spacing = if mean_edge > 0.0 { SPACING_EDGES * mean_edge } else { 1.0 };
        let mut numbers: BTreeMap<[i64; D], u32> = BTreeMap::new();
        let mut around = |x: &Vector<D>| {
            let at = x / spacing;
            let corner = |bits: usize| {
                let up = |a: usize| bits >> a & 1;
                let place: [i64; D] = std::array::from_fn(|a| at[a].floor() as i64 + up(a) as i64);
                let along =
                    |a: usize| if up(a) == 1 { at[a] - at[a].floor() } else { 1.0 - at[a] + at[a].floor() };
                let next = numbers.len() as u32;
                (*numbers.entry(place).or_insert(next), (0..D).map(along).product())
            };
            (0..1 << D).map(corner).collect::<Vec<_>>()
        };
        let of = |(x, anchored): (&Vector<D>, &bool)| if *anchored { Vec::new() } else { around(x) };
        let weights: Vec<Vec<(u32, f64)>> = positions.iter().zip(anchored).map(of).collect();
        let nodes = |v: usize| weights[v].iter().map(|w| w.0);
        let union = |(i, j): (usize, usize)| nodes(i).chain(nodes(j)).collect::<BTreeSet<u32>>();
        let free = |(i, j): &(usize, usize)| !anchored[*i] && !anchored[*j];
        let own = (0..anchored.len()).map(|i| (i, i));
        let groups: BTreeSet<BTreeSet<u32>> = own.chain(pairs).filter(free).map(union).collect();
        let mut cliques = Cliques::default();
        groups.into_iter().for_each(|group| cliques.push(group));
        let pattern = Arc::new(SparsityPattern::new(numbers.len(), [&cliques]));
        let mut places = vec![Vector::zeros(); numbers.len()];
        numbers.iter().for_each(|(place, n)| places[*n as usize] = Vector::from(place.map(|i| i as f64)));
        let symbolic = Arc::new(SymbolicFactor::new(&places, &pattern, &vec![false; places.len()])?);
        Some(Self { weights, pattern, symbolic })
    }

    /// The matrix that one of the mesh's vertices is on the lattice, factorised; of that its rows are given, both triangles of
    /// them: where each starts among the blocks, their columns, and the blocks. Nothing where it is not positive definite.
    pub fn factorised<const D: usize>(
        self: &Arc<Self>,
        starts: &[usize],
        columns: &[u32],
        blocks: &[Matrix<D>],
    ) -> Option<CoarseFactor> {
        let mut matrix = BlockMatrix::<D>::new(self.pattern.clone());
        let mut row: Vec<(u32, Matrix<D>)> = Vec::new();
        for (i, weights) in self.weights.iter().enumerate() {
            row.clear();
            for k in starts[i]..starts[i + 1] {
                for (node, weight) in &self.weights[columns[k] as usize] {
                    match row.iter_mut().find(|r| r.0 == *node) {
                        Some(r) => r.1 += blocks[k] * *weight,
                        None => row.push((*node, blocks[k] * *weight)),
                    }
                }
            }
            for (node, weight) in weights {
                for (other, block) in row.iter().filter(|r| r.0 <= *node) {
                    let slot = self.pattern.slot(*node, *other)?;
                    matrix.blocks[slot] += block * *weight;
                }
            }
        }
        for v in 0..self.pattern.starts.len() - 1 {
            let own = &mut matrix.blocks[self.pattern.starts[v]];
            *own += Matrix::identity() * (DIAGONAL_SHIFT * own.trace());
        }
        let held = vec![false; self.pattern.starts.len() - 1];
        let factor = CholeskyFactor::new(self.symbolic.clone(), &matrix, &held)?;
        Some(CoarseFactor { lattice: self.clone(), factor })
    }
}

impl CoarseFactor {
    /// Adds to `z` what solves for `r` on the lattice.
    pub fn add_correction<const D: usize>(&self, r: &[Vector<D>], z: &mut [Vector<D>]) {
        let lattice = &self.lattice;
        let mut coarse = vec![0.0; D * (lattice.pattern.starts.len() - 1)];
        for (r, weights) in r.iter().zip(&lattice.weights) {
            for (node, weight) in weights {
                (0..D).for_each(|a| coarse[*node as usize * D + a] += weight * r[a]);
            }
        }
        self.factor.solve::<D>(None, &mut coarse, 1);
        for (z, weights) in z.iter_mut().zip(&lattice.weights) {
            for (node, weight) in weights {
                (0..D).for_each(|a| z[a] += weight * coarse[*node as usize * D + a]);
            }
        }
    }
}
