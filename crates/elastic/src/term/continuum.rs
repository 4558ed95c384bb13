//! A continuum: an energy density, integrated over a body's strains.

use super::density::{Density, Lame, Modes};
use super::smoothing::{Smoothing, Strains};
use super::{ForceTerm, Weights};
use crate::linalg::{BlockMatrix, Cliques};
use meniscus_numerics::mesh::VolumeMesh;
use meniscus_numerics::{Matrix, Vector, par};
use rayon::prelude::*;
use std::ops::Range;

/// Strains whose tangents are worked out, in parallel, before they are added up in order.
const BATCH: usize = 8192;

/// Strains up to which threads are not worth their while.
const FEW: usize = 512;

/// Values of a function in order, in parallel where there are many.
fn gathered<T: Send>(range: Range<usize>, f: impl Fn(usize) -> T + Sync + Send) -> Vec<T> {
    if range.len() <= FEW { range.map(f).collect() } else { range.into_par_iter().map(f).collect() }
}

/// A solid of one density, constant strains over groups of elements (finite elements, Sifakis & Barbič 2012).
#[derive(Clone, Debug)]
pub struct Continuum<P, const D: usize> {
    density: P,
    strains: Strains<D>,
}

impl<P: Density<D>, const D: usize> Continuum<P, D> {
    /// At rest on a mesh, every simplex of which must have a positive volume.
    pub fn new(mesh: &VolumeMesh<D>, density: P, lame: Lame, smoothing: Smoothing) -> Self {
        Self { density, strains: Strains::new(mesh, lame, smoothing) }
    }

    /// The same without smoothing, with an elasticity of each simplex.
    pub(crate) fn of_elements(mesh: &VolumeMesh<D>, density: P, lame: Vec<Lame>) -> Self {
        let none = Lame { lambda: 0.0, mu: 0.0 };
        let strains = Strains { lame, ..Strains::new(mesh, none, Smoothing::None) };
        Self { density, strains }
    }

    /// Adds the forces of stresses.
    fn add_stresses(&self, stress: impl Fn(usize) -> Matrix<D> + Sync + Send, forces: &mut [Vector<D>]) {
        let stresses: Vec<Matrix<D>> = gathered(0..self.strains.volumes.len(), stress);
        for (k, stress) in stresses.iter().enumerate() {
            let (vertices, gradients) = self.strains.part(k);
            for (v, g) in vertices.iter().zip(gradients) {
                forces[*v as usize] -= stress * g * self.strains.volumes[k];
            }
        }
    }

    /// The blocks of a strain's tangent, for pairs of its vertices in the order of [`Self::add_blocks`].
    fn blocks(&self, k: usize, x: &[Vector<D>], weights: Weights) -> Vec<Matrix<D>> {
        let (vertices, gradients) = self.strains.part(k);
        let n = vertices.len();
        let f = self.strains.gradient(k, x);
        let mut blocks = vec![Matrix::zeros(); n * (n + 1) / 2];
        let mut along = vec![Vector::zeros(); n];
        for (weight, direction) in Modes::new(&self.density, self.strains.lame[k], &f, weights).iter() {
            along.iter_mut().zip(gradients).for_each(|(a, g)| *a = direction * g);
            let mut slots = blocks.iter_mut();
            for (i, a) in along.iter().enumerate() {
                let a = a * (weight * self.strains.volumes[k]);
                for (b, block) in along[i..].iter().zip(&mut slots) {
                    *block += a * b.transpose();
                }
            }
        }
        blocks
    }

    fn add_blocks(&self, k: usize, blocks: &[Matrix<D>], matrix: &mut BlockMatrix<D>) {
        let vertices = self.strains.part(k).0;
        let pairs = (0..vertices.len()).flat_map(|i| (i..vertices.len()).map(move |j| (i, j)));
        for ((i, j), block) in pairs.zip(blocks) {
            let there = matrix.add(vertices[i], vertices[j], block);
            debug_assert!(there, "an element without a block");
        }
    }
}

impl<P: Density<D>, const D: usize> ForceTerm<D> for Continuum<P, D> {
    fn couplings(&self) -> &Cliques {
        &self.strains.vertices
    }

    fn energy(&self, x: &[Vector<D>]) -> f64 {
        let energy = |k| {
            self.strains.volumes[k] * self.density.energy(self.strains.lame[k], &self.strains.gradient(k, x))
        };
        par::sum(self.strains.volumes.len(), energy)
    }

    fn add_forces(&self, x: &[Vector<D>], forces: &mut [Vector<D>]) {
        self.add_stresses(
            |k| self.density.stress(self.strains.lame[k], &self.strains.gradient(k, x)),
            forces,
        );
    }

    /// Hooke's law for the rate of Green's strain (Kelvin and Voigt's solid).
    fn add_viscous_forces(&self, x: &[Vector<D>], v: &[Vector<D>], time: f64, forces: &mut [Vector<D>]) {
        let stress = |k: usize| {
            let (f, Lame { lambda, mu }) = (self.strains.gradient(k, x), self.strains.lame[k]);
            let half = f.tr_mul(&self.strains.gradient(k, v));
            f * ((half + half.transpose()) * mu + Matrix::identity() * (lambda * half.trace())) * time
        };
        self.add_stresses(stress, forces);
    }

    fn add_tangent(&self, x: &[Vector<D>], weights: Weights, matrix: &mut BlockMatrix<D>) {
        let count = self.strains.volumes.len();
        for start in (0..count).step_by(BATCH) {
            let batch = start..(start + BATCH).min(count);
            let blocks = gathered(batch.clone(), |k| self.blocks(k, x, weights));
            batch.zip(&blocks).for_each(|(k, blocks)| self.add_blocks(k, blocks, matrix));
        }
    }
}
