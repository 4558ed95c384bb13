//! A continuum: an energy density, integrated over the points of a body's elements.

use super::density::{Density, Lame, Tangent};
use super::points::Points;
use super::{ForceTerm, Weights};
use crate::ElasticError;
use crate::linalg::{BlockMatrix, Cliques};
use meniscus_contact::upright_step;
use meniscus_numerics::mesh::VolumeMesh;
use meniscus_numerics::mesh::volume::Order;
use meniscus_numerics::{Matrix, Vector, par};
use rayon::prelude::*;
use std::ops::Range;

/// Elements whose tangents are worked out, in parallel, before they are added up in order.
const BATCH: usize = 8192;

/// Points up to which threads are not worth their while.
const FEW: usize = 512;

/// Most vertices of an element.
const MOST: usize = 10;

/// A solid of one density (finite elements, Sifakis & Barbič 2012).
#[derive(Clone, Debug)]
pub struct Continuum<P, const D: usize> {
    density: P,
    points: Points<D>,
}

impl<P: Density<D>, const D: usize> Continuum<P, D> {
    /// At rest on a mesh, every simplex of which must have a positive volume.
    ///
    /// # Errors
    /// [`ElasticError::NotDivided`] and [`ElasticError::Folded`], of quadratic simplices.
    pub fn new(mesh: &VolumeMesh<D>, density: P, lame: Lame, order: Order) -> Result<Self, ElasticError> {
        Ok(Self { density, points: Points::new(mesh, lame, order)? })
    }

    /// Of linear simplices, each with an elasticity.
    pub(crate) fn of_simplices(mesh: &VolumeMesh<D>, density: P, lame: Vec<Lame>) -> Self {
        Self { density, points: Points::linear(mesh, lame) }
    }

    /// The largest part of a way of the vertices, up to all of it, on which the volume at every point keeps a part `keep` of itself.
    pub(crate) fn upright_step(&self, from: &[Vector<D>], ways: &[Vector<D>], keep: f64) -> f64 {
        let part = |k| upright_step(&self.points.gradient(k, from), &self.points.gradient(k, ways), keep);
        (0..self.points.len()).into_par_iter().with_min_len(256).map(part).reduce(|| 1.0, f64::min)
    }

    /// Values of a function of elements in order, in parallel where there are many.
    fn gathered<T: Send>(&self, range: Range<usize>, f: impl Fn(usize) -> T + Sync + Send) -> Vec<T> {
        if range.len() * self.points.per <= FEW {
            range.map(f).collect()
        } else {
            range.into_par_iter().map(f).collect()
        }
    }

    /// The points of an element.
    fn points_of(&self, element: usize) -> Range<usize> {
        element * self.points.per..(element + 1) * self.points.per
    }

    /// Adds the forces of stresses at points; nothing where there is none.
    fn add_stresses(
        &self,
        stress: impl Fn(usize) -> Option<Matrix<D>> + Sync + Send,
        forces: &mut [Vector<D>],
    ) {
        let of = |element: usize| {
            let mut pulls = [Vector::<D>::zeros(); MOST];
            for k in self.points_of(element) {
                let Some(stress) = stress(k) else { continue };
                let stress = stress * self.points.volumes[k];
                let gradients = self.points.part(k).1;
                pulls.iter_mut().zip(gradients).for_each(|(pull, g)| *pull -= stress * g);
            }
            pulls
        };
        let pulls = self.gathered(0..self.points.elements.len(), of);
        for (vertices, pulls) in self.points.elements.iter().zip(&pulls) {
            vertices.iter().zip(pulls).for_each(|(v, pull)| forces[*v as usize] += pull);
        }
    }

    /// The blocks of an element's tangent, for pairs of its vertices in the order of [`Self::add_blocks`]; none where all are zero.
    fn blocks(&self, element: usize, x: &[Vector<D>], weights: Weights) -> Vec<Matrix<D>> {
        let n = self.points.elements.get(element).len();
        let mut blocks = Vec::new();
        for k in self.points_of(element) {
            let (gradients, f) = (self.points.part(k).1, self.points.gradient(k, x));
            if self.density.is_slack(&f) {
                continue;
            }
            blocks.resize(n * (n + 1) / 2, Matrix::zeros());
            let tangent = Tangent::new(&self.density, self.points.lame(k), &f, weights);
            let mut along = [[Matrix::<D>::zeros(); D]; MOST];
            along.iter_mut().zip(gradients).for_each(|(a, g)| *a = tangent.along(g));
            let mut slots = blocks.iter_mut();
            for (i, g) in gradients.iter().enumerate() {
                let g = g * self.points.volumes[k];
                for (along, block) in along[i..n].iter().zip(&mut slots) {
                    along.iter().zip(g.iter()).for_each(|(a, g)| *block += a * *g);
                }
            }
        }
        blocks
    }

    fn add_blocks(&self, element: usize, blocks: &[Matrix<D>], matrix: &mut BlockMatrix<D>) {
        let vertices = self.points.elements.get(element);
        let pairs = (0..vertices.len()).flat_map(|i| (i..vertices.len()).map(move |j| (i, j)));
        for ((i, j), block) in pairs.zip(blocks) {
            let there = matrix.add(vertices[i], vertices[j], block);
            debug_assert!(there, "an element without a block");
        }
    }
}

impl<P: Density<D>, const D: usize> ForceTerm<D> for Continuum<P, D> {
    fn couplings(&self) -> &Cliques {
        &self.points.elements
    }

    fn energy(&self, x: &[Vector<D>]) -> f64 {
        let energy = |k| {
            self.points.volumes[k] * self.density.energy(self.points.lame(k), &self.points.gradient(k, x))
        };
        par::sum(self.points.len(), energy)
    }

    fn add_forces(&self, x: &[Vector<D>], forces: &mut [Vector<D>]) {
        let stress = |k| {
            let f = self.points.gradient(k, x);
            (!self.density.is_slack(&f)).then(|| self.density.stress(self.points.lame(k), &f))
        };
        self.add_stresses(stress, forces);
    }

    /// Hooke's law for the rate of Green's strain (Kelvin and Voigt's solid).
    fn add_viscous_forces(&self, x: &[Vector<D>], v: &[Vector<D>], time: f64, forces: &mut [Vector<D>]) {
        let stress = |k: usize| {
            let (f, Lame { lambda, mu }) = (self.points.gradient(k, x), self.points.lame(k));
            let half = f.tr_mul(&self.points.gradient(k, v));
            let rate = (half + half.transpose()) * mu + Matrix::identity() * (lambda * half.trace());
            Some(f * rate * time)
        };
        self.add_stresses(stress, forces);
    }

    fn add_tangent(&self, x: &[Vector<D>], weights: Weights, matrix: &mut BlockMatrix<D>) {
        let count = self.points.elements.len();
        for start in (0..count).step_by(BATCH) {
            let batch = start..(start + BATCH).min(count);
            let blocks = self.gathered(batch.clone(), |k| self.blocks(k, x, weights));
            batch.zip(&blocks).for_each(|(k, blocks)| self.add_blocks(k, blocks, matrix));
        }
    }
}
