//! A continuum: an energy density, integrated over the points of a body's elements.

use super::conserving::Conserving;
use super::density::{Density, Lame, Tangent, determinant};
use super::points::Points;
use super::{ConservingTerm, ForceTerm, Weights};
use crate::ElasticError;
use crate::linalg::{BlockMatrix, Cliques};
use meniscus_contact::upright_step;
use meniscus_numerics::mesh::VolumeMesh;
use meniscus_numerics::mesh::volume::Order;
use meniscus_numerics::{Matrix, Vector, par};
use rayon::prelude::*;
use std::ops::Range;

/// Elements whose tangents are worked out, in parallel, before they are added up in order.
const BATCH: usize = 4096;
/// Elements up to which threads are not worth their while.
const FEW: usize = 128;
/// Most vertices of an element: two quadratic tetrahedra with a facet in common.
const VERTICES: usize = 14;
/// Most points of an element.
const POINTS: usize = 8;

/// A solid of one density (finite elements, Sifakis & Barbič 2012).
#[derive(Clone, Debug)]
pub struct Continuum<P, const D: usize> {
    density: P,
    points: Points<D>,
}

/// A quantity at each of an element's points.
type Each<T> = [T; POINTS];

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

    /// The deformation gradients at an element's points.
    fn gradients(&self, element: usize, x: &[Vector<D>]) -> Each<Matrix<D>> {
        let mut all = [Matrix::zeros(); POINTS];
        all.iter_mut().zip(self.points.of(element)).for_each(|(f, k)| *f = self.points.gradient(k, x));
        all
    }

    /// The projections `θ_q = Σ W_qr j_r` of changes of volume at an element's points.
    fn projected(&self, element: usize, changes: &Each<f64>) -> Each<f64> {
        let count = self.points.of(element).len();
        let mut all = [0.0; POINTS];
        for (theta, row) in all.iter_mut().zip(self.points.means(element).chunks_exact(count)) {
            *theta = row.iter().zip(changes).map(|(w, j)| w * j).sum();
        }
        all
    }

    /// The pressures conjugate to the changes `j_r` of volume, `Σ_q v_q p_q W_qr / v_r`, and the second derivatives of `U`. As `v_q W_qr` is
    /// symmetric, these pressures are the projection of the pressures `p_q = U'(θ_q)`.
    fn pressures(&self, element: usize, fs: &Each<Matrix<D>>) -> Each<[f64; 2]> {
        let mut changes = [0.0; POINTS];
        let count = self.points.of(element).len();
        (0..count).for_each(|q| changes[q] = self.density.volume(&fs[q]));
        let thetas = self.projected(element, &changes);
        let (mut slopes, mut bends) = ([0.0; POINTS], [0.0; POINTS]);
        for q in 0..count {
            [_, slopes[q], bends[q]] = self.density.volumetric(self.points.lame(element), thetas[q]);
        }
        let slopes = self.projected(element, &slopes);
        std::array::from_fn(|q| [slopes[q], bends[q]])
    }

    /// Values of a function of elements in order, in parallel where there are many.
    fn gathered<T: Send>(range: Range<usize>, f: impl Fn(usize) -> T + Sync + Send) -> Vec<T> {
        if range.len() <= FEW { range.map(f).collect() } else { range.into_par_iter().map(f).collect() }
    }

    /// The stresses at an element's points; nothing where there are none.
    fn stresses(&self, element: usize, x: &[Vector<D>]) -> Option<Each<Matrix<D>>> {
        let (mut fs, lame) = (self.gradients(element, x), self.points.lame(element));
        let count = self.points.of(element).len();
        if fs[..count].iter().all(|f| self.density.is_slack(f)) {
            return None;
        }
        let pressures = if P::PROJECTED { self.pressures(element, &fs) } else { [[0.0; 2]; POINTS] };
        for (f, [pressure, _]) in fs[..count].iter_mut().zip(&pressures) {
            let volumetric =
                if P::PROJECTED { self.density.volume_slope(f) * *pressure } else { Matrix::zeros() };
            *f = self.density.stress(lame, f) + volumetric;
        }
        Some(fs)
    }

    /// Adds the forces of stresses at the points of elements; nothing where there are none.
    fn add_stresses(
        &self,
        stresses: impl Fn(usize) -> Option<Each<Matrix<D>>> + Sync + Send,
        forces: &mut [Vector<D>],
    ) {
        let of = |element: usize| {
            let stresses = stresses(element)?;
            let mut pulls = [Vector::<D>::zeros(); VERTICES];
            for (k, stress) in self.points.of(element).zip(&stresses) {
                let stress = stress * self.points.volumes[k];
                pulls.iter_mut().zip(self.points.part(k).1).for_each(|(pull, g)| *pull -= stress * g);
            }
            Some(pulls)
        };
        let pulls = Self::gathered(0..self.points.elements.len(), of);
        for (vertices, pulls) in self.points.elements.iter().zip(&pulls) {
            let pulls = pulls.iter().flatten();
            vertices.iter().zip(pulls).for_each(|(v, pull)| forces[*v as usize] += pull);
        }
    }

    /// The blocks of an element's tangent, for pairs of its vertices in the order of [`Self::add_blocks`]; none where all are zero.
    fn blocks(&self, element: usize, x: &[Vector<D>], weights: Weights) -> Vec<Matrix<D>> {
        let n = self.points.elements.get(element).len();
        let (fs, lame) = (self.gradients(element, x), self.points.lame(element));
        let count = self.points.of(element).len();
        if fs[..count].iter().all(|f| self.density.is_slack(f)) {
            return Vec::new();
        }
        let pressures = if P::PROJECTED { self.pressures(element, &fs) } else { [[0.0; 2]; POINTS] };
        let mut blocks = vec![Matrix::zeros(); n * (n + 1) / 2];
        for (k, (f, pressure)) in self.points.of(element).zip(fs.iter().zip(&pressures)) {
            let tangent = Tangent::new(&self.density, lame, f, pressure[0], weights);
            self.add_point(k, &tangent, &mut blocks);
        }
        if P::PROJECTED && weights.stiffness != 0.0 {
            let slopes = fs.map(|f| self.density.volume_slope(&f));
            let share =
                pressures.map(|p| weights.stiffness * if weights.positive { p[1].max(0.0) } else { p[1] });
            self.add_volumes(element, &slopes, &share, &mut blocks);
        }
        if weights.viscosity != 0.0 {
            self.add_volumes(element, &fs, &[weights.viscosity * lame.lambda; POINTS], &mut blocks);
        }
        blocks
    }

    /// Adds the tangent at a point.
    fn add_point(&self, k: usize, tangent: &Tangent<D>, blocks: &mut [Matrix<D>]) {
        let gradients = self.points.part(k).1;
        let n = gradients.len();
        let mut along = [[Matrix::<D>::zeros(); D]; VERTICES];
        let own = |g: &Vector<D>| g.norm_squared() > 0.0;
        along.iter_mut().zip(gradients).filter(|(_, g)| own(g)).for_each(|(a, g)| *a = tangent.along(g));
        let mut first = 0;
        for (i, g) in gradients.iter().enumerate() {
            if own(g) {
                let g = g * self.points.volumes[k];
                for (j, block) in (i..n).zip(&mut blocks[first..first + n - i]) {
                    if own(&gradients[j]) {
                        along[j].iter().zip(g.iter()).for_each(|(a, g)| *block += a * *g);
                    }
                }
            }
            first += n - i;
        }
    }

    /// Adds `Σ_q v_q s_q d_q d_qᵀ` with the derivatives `d_q = Σ_r W_qr S_r g_r` of projected changes of volume, of the slopes `S_r` by the
    /// deformation gradients.
    fn add_volumes(
        &self,
        element: usize,
        slopes: &Each<Matrix<D>>,
        shares: &Each<f64>,
        blocks: &mut [Matrix<D>],
    ) {
        let range = self.points.of(element);
        let count = range.len();
        let n = self.points.elements.get(element).len();
        let mut own = [[Vector::<D>::zeros(); VERTICES]; POINTS];
        for ((own, slope), k) in own.iter_mut().zip(slopes).zip(range.clone()) {
            own.iter_mut().zip(self.points.part(k).1).for_each(|(d, g)| *d = slope * g);
        }
        for (q, row) in self.points.means(element).chunks_exact(count).enumerate() {
            let mut slope = [Vector::<D>::zeros(); VERTICES];
            for (weight, own) in row.iter().zip(&own) {
                slope[..n].iter_mut().zip(own).for_each(|(d, own)| *d += own * *weight);
            }
            let share = shares[q] * self.points.volumes[range.start + q];
            let mut slots = blocks.iter_mut();
            for i in 0..n {
                let scaled = slope[i] * share;
                slope[i..n].iter().zip(&mut slots).for_each(|(d, block)| *block += scaled * d.transpose());
            }
        }
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
        let of = |element: usize| {
            let (fs, lame) = (self.gradients(element, x), self.points.lame(element));
            let points = || self.points.of(element).zip(&fs);
            let own: f64 = points().map(|(k, f)| self.points.volumes[k] * self.density.energy(lame, f)).sum();
            if !P::PROJECTED || own == f64::INFINITY {
                return own;
            }
            let mut changes = [0.0; POINTS];
            changes.iter_mut().zip(points()).for_each(|(j, (_, f))| *j = self.density.volume(f));
            let thetas = self.projected(element, &changes);
            let volumetric =
                |(k, theta): (usize, &f64)| self.points.volumes[k] * self.density.volumetric(lame, *theta)[0];
            own + self.points.of(element).zip(&thetas).map(volumetric).sum::<f64>()
        };
        par::sum(self.points.elements.len(), of)
    }

    fn add_forces(&self, x: &[Vector<D>], forces: &mut [Vector<D>]) {
        self.add_stresses(|element| self.stresses(element, x), forces);
    }

    /// Hooke's law for the rate of Green's strain (Kelvin and Voigt's solid).
    fn add_viscous_forces(&self, x: &[Vector<D>], v: &[Vector<D>], time: f64, forces: &mut [Vector<D>]) {
        let stresses = |element: usize| {
            let Lame { lambda, mu } = self.points.lame(element);
            let (fs, rates) = (self.gradients(element, x), self.gradients(element, v));
            let halves: Each<Matrix<D>> = std::array::from_fn(|q| fs[q].tr_mul(&rates[q]));
            // Projected twice, as pressures are, which is once.
            let volumes = self.projected(element, &halves.map(|half| half.trace()));
            Some(std::array::from_fn(|q| {
                let rate =
                    (halves[q] + halves[q].transpose()) * mu + Matrix::identity() * (lambda * volumes[q]);
                fs[q] * rate * time
            }))
        };
        self.add_stresses(stresses, forces);
    }

    fn add_tangent(&self, x: &[Vector<D>], weights: Weights, matrix: &mut BlockMatrix<D>) {
        let count = self.points.elements.len();
        for start in (0..count).step_by(BATCH) {
            let batch = start..(start + BATCH).min(count);
            let blocks = Self::gathered(batch.clone(), |k| self.blocks(k, x, weights));
            batch.zip(&blocks).for_each(|(k, blocks)| self.add_blocks(k, blocks, matrix));
        }
    }
}

impl<P: Conserving<D>, const D: usize> Continuum<P, D> {
    /// The stresses between two configurations at an element's points; nothing where a point has no volume in one of both.
    fn stresses_between(&self, element: usize, ends: [&[Vector<D>]; 2]) -> Option<Each<Matrix<D>>> {
        let (all, lame) = (ends.map(|x| self.gradients(element, x)), self.points.lame(element));
        let count = self.points.of(element).len();
        if all.iter().flat_map(|fs| &fs[..count]).any(|f| determinant(f) <= 0.0) {
            return None;
        }
        let mut pressures = [0.0; POINTS];
        if P::PROJECTED {
            let thetas = all.map(|fs| {
                let mut changes = [0.0; POINTS];
                changes.iter_mut().zip(&fs[..count]).for_each(|(j, f)| *j = self.density.volume(f));
                self.projected(element, &changes)
            });
            let own = |q: usize| self.density.pressure_between(lame, thetas.map(|theta| theta[q]));
            pressures[..count].iter_mut().enumerate().for_each(|(q, p)| *p = own(q));
            pressures = self.projected(element, &pressures);
        }
        let mut stresses = [Matrix::zeros(); POINTS];
        for (q, stress) in stresses[..count].iter_mut().enumerate() {
            let ends = [&all[0][q], &all[1][q]];
            let volumetric = self.density.volume_slope_between(ends) * pressures[q];
            *stress = (ends[0] + ends[1]) * (self.density.stress_between(lame, ends) + volumetric) * 0.5;
        }
        Some(stresses)
    }
}

impl<P: Conserving<D>, const D: usize> ConservingTerm<D> for Continuum<P, D> {
    fn add_forces_between(&self, ends: [&[Vector<D>]; 2], forces: &mut [Vector<D>]) {
        let middle: Vec<Vector<D>> = ends[0].iter().zip(ends[1]).map(|(a, b)| (a + b) * 0.5).collect();
        let of =
            |element: usize| self.stresses_between(element, ends).or_else(|| self.stresses(element, &middle));
        self.add_stresses(of, forces);
    }
}
