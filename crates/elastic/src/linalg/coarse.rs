//! Coarse correction of the preconditioner: the Galerkin matrix on a lattice around a mesh.
//!
//! Fields on the lattice are interpolated multilinearly to the mesh, so translations, rotations and uniform strains are represented
//! exactly. The coarse solve reduces errors that are smooth over several edges, on which the block-Jacobi part of the
//! preconditioner is inefficient.

use super::{BlockMatrix, CholeskyFactor, Cliques, SparsityPattern, SymbolicFactor};
use meniscus_numerics::{Matrix, Vector};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Lattice spacing over the mean distance of coupled vertices.
const SPACING_EDGES: f64 = 4.0;
/// Shift of each diagonal block over its trace: where a cell has few vertices the coarse matrix can be singular.
const DIAGONAL_SHIFT: f64 = 1e-6;

/// Lattice nodes around the vertices of a mesh.
#[derive(Debug)]
pub struct CoarseLattice {
    /// Nodes around each vertex with their weights; empty for anchored vertices.
    weights: Vec<Vec<(u32, f64)>>,
    pattern: Arc<SparsityPattern>,
    symbolic: Arc<SymbolicFactor>,
}

/// Factorised matrix on the lattice.
#[derive(Clone, Debug)]
pub struct CoarseFactor {
    lattice: Arc<CoarseLattice>,
    factor: CholeskyFactor,
}

impl CoarseLattice {
    /// Lattice around vertices at `positions` with the couplings of the pattern `fine`. `None` where there is not enough memory.
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

    /// Factorises the coarse matrix of a matrix on the mesh, which is given by the rows of both triangles: the start of each row
    /// among the blocks, the columns, and the blocks. `None` where the coarse matrix is not positive definite.
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
    /// Adds the coarse solution for the residual `r` to `z`.
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
