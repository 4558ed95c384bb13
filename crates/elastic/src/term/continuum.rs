//! Continuum term: an energy density integrated over the quadrature points of the elements.

use super::discrete_gradient::DiscreteGradientDensity;
use super::energy_density::{EnergyDensity, Lame, Tangent, determinant};
use super::quadrature::QuadraturePoints;
use super::{DiscreteGradientTerm, ForceTerm, TangentWeights};
use crate::ElasticError;
use crate::linalg::{BlockMatrix, Cliques, PlacedBlock, SparsityPattern};
use meniscus_contact::inversion_free_fraction;
use meniscus_numerics::mesh::VolumeMesh;
use meniscus_numerics::mesh::volume::ElementOrder;
use meniscus_numerics::{Matrix, Vector, par};
use std::ops::Range;

/// Number of elements whose tangents are computed in parallel before they are added in order.
const ELEMENTS_PER_BATCH: usize = 4096;
/// Number of elements up to which the loop is serial.
const MAX_SERIAL_ELEMENTS: usize = 128;
/// Largest number of vertices of an element: two quadratic tetrahedra that share a facet.
const MAX_ELEMENT_VERTICES: usize = 14;
/// Largest number of quadrature points of an element.
const MAX_ELEMENT_POINTS: usize = 8;

/// A continuum of one energy density (finite elements, Sifakis & Barbič 2012).
#[derive(Clone, Debug)]
pub struct Continuum<P, const D: usize> {
    density: P,
    points: QuadraturePoints<D>,
}

/// A quantity at each quadrature point of an element.
type PerPoint<T> = [T; MAX_ELEMENT_POINTS];

impl<P: EnergyDensity<D>, const D: usize> Continuum<P, D> {
    /// Continuum on a mesh at rest; every simplex must have a positive volume.
    ///
    /// # Errors
    /// [`ElasticError::NotQuadratic`] and [`ElasticError::Folded`], of quadratic simplices.
    pub fn new(
        mesh: &VolumeMesh<D>,
        density: P,
        lame: Lame,
        order: ElementOrder,
    ) -> Result<Self, ElasticError> {
        Ok(Self { density, points: QuadraturePoints::new(mesh, lame, order)? })
    }

    /// Continuum of linear simplices, each with its own Lamé parameters.
    pub(crate) fn of_simplices(mesh: &VolumeMesh<D>, density: P, lame: Vec<Lame>) -> Self {
        Self { density, points: QuadraturePoints::linear(mesh, lame) }
    }

    /// Largest fraction, at most 1, of `displacements` for which the volume at every point keeps `kept_fraction` of itself.
    pub(crate) fn inversion_free_fraction(
        &self,
        from: &[Vector<D>],
        displacements: &[Vector<D>],
        kept_fraction: f64,
    ) -> f64 {
        let part = |k| {
            inversion_free_fraction(
                &self.points.deformation_gradient(k, from),
                &self.points.deformation_gradient(k, displacements),
                kept_fraction,
            )
        };
        par::reduce(self.points.len(), 256, 1.0, part, f64::min)
    }

    /// Deformation gradients at the quadrature points of an element.
    fn deformation_gradients(&self, element: usize, x: &[Vector<D>]) -> PerPoint<Matrix<D>> {
        let mut all = [Matrix::zeros(); MAX_ELEMENT_POINTS];
        all.iter_mut()
            .zip(self.points.points_of(element))
            .for_each(|(f, k)| *f = self.points.deformation_gradient(k, x));
        all
    }

    /// Projections `θ_q = Σ W_qr j_r` of the changes of volume at the quadrature points of an element.
    fn projected(&self, element: usize, changes: &PerPoint<f64>) -> PerPoint<f64> {
        let count = self.points.points_of(element).len();
        let mut all = [0.0; MAX_ELEMENT_POINTS];
        for (theta, row) in all.iter_mut().zip(self.points.projection(element).chunks_exact(count)) {
            *theta = row.iter().zip(changes).map(|(w, j)| w * j).sum();
        }
        all
    }

    /// Pressures conjugate to the changes of volume `j_r`, `Σ_q v_q p_q W_qr / v_r` with `p_q = U'(θ_q)`, and the second
    /// derivatives of `U`. As `v_q W_qr` is symmetric, they are the projection of the `p_q`.
    fn pressures(&self, element: usize, fs: &PerPoint<Matrix<D>>) -> PerPoint<[f64; 2]> {
        let mut changes = [0.0; MAX_ELEMENT_POINTS];
        let count = self.points.points_of(element).len();
        (0..count).for_each(|q| changes[q] = self.density.volume_change(&fs[q]));
        let thetas = self.projected(element, &changes);
        let (mut slopes, mut bends) = ([0.0; MAX_ELEMENT_POINTS], [0.0; MAX_ELEMENT_POINTS]);
        for q in 0..count {
            [_, slopes[q], bends[q]] = self.density.volumetric_energy(self.points.lame(element), thetas[q]);
        }
        let slopes = self.projected(element, &slopes);
        std::array::from_fn(|q| [slopes[q], bends[q]])
    }

    /// Values of a function of the elements in order, computed in parallel where there are many.
    fn map_elements<T: Send>(range: Range<usize>, f: impl Fn(usize) -> T + Sync + Send) -> Vec<T> {
        if range.len() <= MAX_SERIAL_ELEMENTS {
            range.map(f).collect()
        } else {
            par::map(range.len(), 1, |i| f(range.start + i))
        }
    }

    /// Stresses at the quadrature points of an element; `None` where all are zero.
    fn stresses(&self, element: usize, x: &[Vector<D>]) -> Option<PerPoint<Matrix<D>>> {
        let (mut fs, lame) = (self.deformation_gradients(element, x), self.points.lame(element));
        let count = self.points.points_of(element).len();
        if fs[..count].iter().all(|f| self.density.is_inactive(f)) {
            return None;
        }
        let pressures =
            if P::HAS_VOLUMETRIC { self.pressures(element, &fs) } else { [[0.0; 2]; MAX_ELEMENT_POINTS] };
        for (f, [pressure, _]) in fs[..count].iter_mut().zip(&pressures) {
            let volumetric = if P::HAS_VOLUMETRIC {
                self.density.volume_change_gradient(f) * *pressure
            } else {
                Matrix::zeros()
            };
            *f = self.density.stress(lame, f) + volumetric;
        }
        Some(fs)
    }

    /// Adds the forces of stresses at the quadrature points; elements without stresses (`None`) are skipped.
    fn add_stress_forces(
        &self,
        stresses: impl Fn(usize) -> Option<PerPoint<Matrix<D>>> + Sync + Send,
        forces: &mut [Vector<D>],
    ) {
        let of = |element: usize| {
            let stresses = stresses(element)?;
            let mut pulls = [Vector::<D>::zeros(); MAX_ELEMENT_VERTICES];
            for (k, stress) in self.points.points_of(element).zip(&stresses) {
                let stress = stress * self.points.volumes[k];
                pulls
                    .iter_mut()
                    .zip(self.points.shape_gradients(k).1)
                    .for_each(|(pull, g)| *pull -= stress * g);
            }
            Some(pulls)
        };
        let pulls = Self::map_elements(0..self.points.elements.len(), of);
        for (vertices, pulls) in self.points.elements.iter().zip(&pulls) {
            let pulls = pulls.iter().flatten();
            vertices.iter().zip(pulls).for_each(|(v, pull)| forces[*v as usize] += pull);
        }
    }

    /// Blocks of an element's tangent for the pairs of vertices of [`Self::assemble_blocks`], in order; empty where all are zero.
    fn tangent_blocks(&self, element: usize, x: &[Vector<D>], weights: TangentWeights) -> Vec<Matrix<D>> {
        let n = self.points.elements.get(element).len();
        let (fs, lame) = (self.deformation_gradients(element, x), self.points.lame(element));
        let count = self.points.points_of(element).len();
        if fs[..count].iter().all(|f| self.density.is_inactive(f)) {
            return Vec::new();
        }
        let pressures =
            if P::HAS_VOLUMETRIC { self.pressures(element, &fs) } else { [[0.0; 2]; MAX_ELEMENT_POINTS] };
        let mut blocks = vec![Matrix::zeros(); n * (n + 1) / 2];
        for (k, (f, pressure)) in self.points.points_of(element).zip(fs.iter().zip(&pressures)) {
            let tangent = Tangent::new(&self.density, lame, f, pressure[0], weights);
            self.add_point_tangent(k, &tangent, &mut blocks);
        }
        if P::HAS_VOLUMETRIC && weights.stiffness != 0.0 {
            let slopes = fs.map(|f| self.density.volume_change_gradient(&f));
            let share =
                pressures.map(|p| weights.stiffness * if weights.project_psd { p[1].max(0.0) } else { p[1] });
            self.add_volumetric_tangent(element, &slopes, &share, &mut blocks);
        }
        if weights.viscosity != 0.0 {
            self.add_volumetric_tangent(
                element,
                &fs,
                &[weights.viscosity * lame.lambda; MAX_ELEMENT_POINTS],
                &mut blocks,
            );
        }
        blocks
    }

    /// Adds the tangent at a quadrature point.
    fn add_point_tangent(&self, k: usize, tangent: &Tangent<D>, blocks: &mut [Matrix<D>]) {
        let gradients = self.points.shape_gradients(k).1;
        let n = gradients.len();
        let mut along = [[Matrix::<D>::zeros(); D]; MAX_ELEMENT_VERTICES];
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

    /// Adds `Σ_q v_q s_q d_q d_qᵀ` with the shares `s_q`, the derivatives `d_q = Σ_r W_qr S_r g_r` of the projected changes of
    /// volume, and the derivatives `S_r` (`slopes`) of the changes of volume with respect to `F`.
    fn add_volumetric_tangent(
        &self,
        element: usize,
        slopes: &PerPoint<Matrix<D>>,
        shares: &PerPoint<f64>,
        blocks: &mut [Matrix<D>],
    ) {
        let range = self.points.points_of(element);
        let count = range.len();
        let n = self.points.elements.get(element).len();
        let mut own = [[Vector::<D>::zeros(); MAX_ELEMENT_VERTICES]; MAX_ELEMENT_POINTS];
        for ((own, slope), k) in own.iter_mut().zip(slopes).zip(range.clone()) {
            own.iter_mut().zip(self.points.shape_gradients(k).1).for_each(|(d, g)| *d = slope * g);
        }
        for (q, row) in self.points.projection(element).chunks_exact(count).enumerate() {
            let mut slope = [Vector::<D>::zeros(); MAX_ELEMENT_VERTICES];
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

    /// Places of the blocks of [`Self::tangent_blocks`] in a matrix of this pattern.
    fn placed_blocks(
        &self,
        element: usize,
        blocks: Vec<Matrix<D>>,
        pattern: &SparsityPattern,
    ) -> Vec<PlacedBlock<D>> {
        let vertices = self.points.elements.get(element);
        let pairs = (0..vertices.len()).flat_map(|i| (i..vertices.len()).map(move |j| (i, j)));
        let placed = |((i, j), block): ((usize, usize), Matrix<D>)| {
            let place = pattern.place(vertices[i], vertices[j], block);
            debug_assert!(place.is_some(), "an element without a block");
            place
        };
        pairs.zip(blocks).filter_map(placed).collect()
    }
}

impl<P: EnergyDensity<D>, const D: usize> ForceTerm<D> for Continuum<P, D> {
    fn couplings(&self) -> &Cliques {
        &self.points.elements
    }

    fn energy(&self, x: &[Vector<D>]) -> f64 {
        let of = |element: usize| {
            let (fs, lame) = (self.deformation_gradients(element, x), self.points.lame(element));
            let points = || self.points.points_of(element).zip(&fs);
            let own: f64 = points().map(|(k, f)| self.points.volumes[k] * self.density.energy(lame, f)).sum();
            if !P::HAS_VOLUMETRIC || own == f64::INFINITY {
                return own;
            }
            let mut changes = [0.0; MAX_ELEMENT_POINTS];
            changes.iter_mut().zip(points()).for_each(|(j, (_, f))| *j = self.density.volume_change(f));
            let thetas = self.projected(element, &changes);
            let volumetric = |(k, theta): (usize, &f64)| {
                self.points.volumes[k] * self.density.volumetric_energy(lame, *theta)[0]
            };
            own + self.points.points_of(element).zip(&thetas).map(volumetric).sum::<f64>()
        };
        par::sum(self.points.elements.len(), of)
    }

    fn add_forces(&self, x: &[Vector<D>], forces: &mut [Vector<D>]) {
        self.add_stress_forces(|element| self.stresses(element, x), forces);
    }

    /// Hooke's law for the rate of the Green strain (Kelvin–Voigt solid).
    fn add_viscous_forces(&self, x: &[Vector<D>], v: &[Vector<D>], time: f64, forces: &mut [Vector<D>]) {
        let stresses = |element: usize| {
            let Lame { lambda, mu } = self.points.lame(element);
            let (fs, rates) =
                (self.deformation_gradients(element, x), self.deformation_gradients(element, v));
            let halves: PerPoint<Matrix<D>> = std::array::from_fn(|q| fs[q].tr_mul(&rates[q]));
            // Strain rates and pressures are both projected; the projection is idempotent, so once suffices.
            let volumes = self.projected(element, &halves.map(|half| half.trace()));
            Some(std::array::from_fn(|q| {
                let rate =
                    (halves[q] + halves[q].transpose()) * mu + Matrix::identity() * (lambda * volumes[q]);
                fs[q] * rate * time
            }))
        };
        self.add_stress_forces(stresses, forces);
    }

    /// With the Cauchy stress `P Fᵀ / det F` of the Piola–Kirchhoff stress `P`, as a mean over the quadrature points.
    fn add_stress_sums(&self, x: &[Vector<D>], sums: &mut [(f64, Matrix<D>)]) {
        let of = |element: usize| {
            let (fs, stresses) = (self.deformation_gradients(element, x), self.stresses(element, x));
            let mut own = (0.0, Matrix::zeros());
            for (q, k) in self.points.points_of(element).enumerate() {
                let volume = self.points.volumes[k];
                let stress = stresses.map_or(Matrix::zeros(), |all| all[q] * fs[q].transpose());
                own = (own.0 + volume, own.1 + stress * (volume / determinant(&fs[q])));
            }
            own
        };
        let all = Self::map_elements(0..self.points.elements.len(), of);
        for (vertices, (volume, stress)) in self.points.elements.iter().zip(all) {
            for v in vertices {
                let sum = &mut sums[*v as usize];
                *sum = (sum.0 + volume, sum.1 + stress);
            }
        }
    }

    fn add_tangent(&self, x: &[Vector<D>], weights: TangentWeights, matrix: &mut BlockMatrix<D>) {
        let count = self.points.elements.len();
        for start in (0..count).step_by(ELEMENTS_PER_BATCH) {
            let batch = start..(start + ELEMENTS_PER_BATCH).min(count);
            let pattern = matrix.pattern.clone();
            let of = |k| self.placed_blocks(k, self.tangent_blocks(k, x, weights), &pattern);
            Self::map_elements(batch, of).iter().flatten().for_each(|placed| matrix.add_placed(placed));
        }
    }
}

impl<P: DiscreteGradientDensity<D>, const D: usize> Continuum<P, D> {
    /// Discrete-gradient stresses at the quadrature points of an element; `None` where a point has no positive volume at an end.
    fn stresses_between(&self, element: usize, ends: [&[Vector<D>]; 2]) -> Option<PerPoint<Matrix<D>>> {
        let (all, lame) = (ends.map(|x| self.deformation_gradients(element, x)), self.points.lame(element));
        let count = self.points.points_of(element).len();
        if all.iter().flat_map(|fs| &fs[..count]).any(|f| determinant(f) <= 0.0) {
            return None;
        }
        let mut pressures = [0.0; MAX_ELEMENT_POINTS];
        if P::HAS_VOLUMETRIC {
            let thetas = all.map(|fs| {
                let mut changes = [0.0; MAX_ELEMENT_POINTS];
                changes.iter_mut().zip(&fs[..count]).for_each(|(j, f)| *j = self.density.volume_change(f));
                self.projected(element, &changes)
            });
            let own = |q: usize| self.density.pressure_between(lame, thetas.map(|theta| theta[q]));
            pressures[..count].iter_mut().enumerate().for_each(|(q, p)| *p = own(q));
            pressures = self.projected(element, &pressures);
        }
        let mut stresses = [Matrix::zeros(); MAX_ELEMENT_POINTS];
        for (q, stress) in stresses[..count].iter_mut().enumerate() {
            let ends = [&all[0][q], &all[1][q]];
            let volumetric = self.density.volume_discrete_gradient(ends) * pressures[q];
            *stress = (ends[0] + ends[1]) * (self.density.stress_between(lame, ends) + volumetric) * 0.5;
        }
        Some(stresses)
    }
}

impl<P: DiscreteGradientDensity<D>, const D: usize> DiscreteGradientTerm<D> for Continuum<P, D> {
    fn add_forces_between(&self, ends: [&[Vector<D>]; 2], forces: &mut [Vector<D>]) {
        let middle: Vec<Vector<D>> = ends[0].iter().zip(ends[1]).map(|(a, b)| (a + b) * 0.5).collect();
        let of =
            |element: usize| self.stresses_between(element, ends).or_else(|| self.stresses(element, &middle));
        self.add_stress_forces(of, forces);
    }
}
