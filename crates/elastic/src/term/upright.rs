//! What keeps elements of springs from turning inside out.

use super::density::{Lame, cofactor, determinant};
use super::smoothing::{Smoothing, Strains};
use super::{ForceTerm, Weights};
use crate::linalg::{BlockMatrix, Cliques};
use meniscus_numerics::mesh::{Simplex, VolumeMesh};
use meniscus_numerics::{Matrix, Vector, par};
use rayon::prelude::*;

/// Volume over that at rest below which an element pushes back: milder strains are the springs' alone.
const CRUSHED: f64 = 0.5;
/// Its stiffness against that, `κ V/k l²`. Pressed flat it stores `κ V/8 = 0.25 k l²` then, as much as its springs: a regular
/// triangle's, its apex pressed onto its base, `0.25 k l²`, a regular tetrahedron's `0.27 k l²`.
const STIFFNESS: f64 = 2.0;

/// Energy `κ V/2 (J − 1/2)²` of every element whose volume `J V` is less than half of its own. A simplex and its mirror image
/// have the same edges: springs alone let one that a blow presses flat come out as the other. `κ V` is proportional to the
/// springs' `k l²`, with the mean square of the element's edges, so that flat elements resist as well.
#[derive(Clone, Debug)]
pub struct Upright<const D: usize> {
    strains: Strains<D>,
    /// `κ V` of each element, J (2D: J/m).
    stiffness: Vec<f64>,
}

/// An element that is pressed: the derivative of its energy by `J`, that of `J` by the position of each vertex, 1/m.
type Pressed<const D: usize> = (f64, Vec<Vector<D>>);

impl<const D: usize> Upright<D> {
    /// Of a mesh of springs of a stiffness, N/m (2D: N/m²).
    pub fn new(mesh: &VolumeMesh<D>, stiffness: f64) -> Self {
        let square = |s: &Simplex<D>| {
            let at: Vec<Vector<D>> = s.vertices().map(|v| mesh.positions[v as usize]).collect();
            let all: f64 = at.iter().flat_map(|a| at.iter().map(move |b| (a - b).norm_squared())).sum();
            all / (D * (D + 1)) as f64
        };
        let stiffness = mesh.simplices.iter().map(|s| STIFFNESS * stiffness * square(s)).collect();
        let none = Lame { lambda: 0.0, mu: 0.0 };
        Self { strains: Strains::new(mesh, none, Smoothing::None), stiffness }
    }

    /// How much less than half of its volume an element has, as a part of that at rest, and its deformation gradient.
    fn lack(&self, k: usize, x: &[Vector<D>]) -> (f64, Matrix<D>) {
        let f = self.strains.gradient(k, x);
        ((CRUSHED - determinant(&f)).max(0.0), f)
    }

    /// An element, if it is pressed.
    fn pressed(&self, k: usize, x: &[Vector<D>]) -> Option<Pressed<D>> {
        let (lack, f) = self.lack(k, x);
        let slopes = || {
            let cofactor = cofactor(&f);
            self.strains.part(k).1.iter().map(|g| cofactor * g).collect()
        };
        (lack > 0.0).then(|| (-self.stiffness[k] * lack, slopes()))
    }
}

impl<const D: usize> ForceTerm<D> for Upright<D> {
    fn couplings(&self) -> &Cliques {
        &self.strains.vertices
    }

    fn energy(&self, x: &[Vector<D>]) -> f64 {
        0.5 * par::sum(self.stiffness.len(), |k| self.stiffness[k] * self.lack(k, x).0.powi(2))
    }

    fn crushed_elements(&self, x: &[Vector<D>]) -> usize {
        (0..self.stiffness.len()).into_par_iter().filter(|k| self.lack(*k, x).0 > 0.0).count()
    }

    fn add_forces(&self, x: &[Vector<D>], forces: &mut [Vector<D>]) {
        for k in 0..self.stiffness.len() {
            let Some((slope, along)) = self.pressed(k, x) else { continue };
            for (v, along) in self.strains.vertices.get(k).iter().zip(along) {
                forces[*v as usize] -= along * slope;
            }
        }
    }

    /// None: it acts where something goes wrong only.
    fn add_viscous_forces(&self, _: &[Vector<D>], _: &[Vector<D>], _: f64, _: &mut [Vector<D>]) {}

    /// That of the change of volume; what pressure does to its curvature is indefinite and left out. Twice that: with the `h²/4` of
    /// the stiffness that a step's matrix has, what is stiff goes by `4 d` in answer to a lack `d`, thrice as far beyond; a spring
    /// throws it back, this, on one side only, does not. With twice as much it goes by `2 d`, as far beyond as it lacked. (Four
    /// times would end a step where nothing lacks, with the speed of the way there: elements then settle later.)
    fn add_tangent(&self, x: &[Vector<D>], weights: Weights, matrix: &mut BlockMatrix<D>) {
        for k in 0..self.stiffness.len() {
            let Some((_, along)) = self.pressed(k, x) else { continue };
            let vertices = self.strains.vertices.get(k);
            for (i, a) in along.iter().enumerate() {
                for (j, b) in along.iter().enumerate().skip(i) {
                    let block = a * b.transpose() * (2.0 * weights.stiffness * self.stiffness[k]);
                    let there = matrix.add(vertices[i], vertices[j], &block);
                    debug_assert!(there, "an element without a block");
                }
            }
        }
    }
}
