//! The interfacial forces on line particles (Eq. 4; Section 4.3.2, Fig. 9).
//!
//! ```text
//! f_c = ℓ_c (Υ_la t_la + Υ_ls t_ls + Υ_sa t_sa)
//! ```
//!
//! Each tangent is that of a plane through samples of its interface within the radius `R` of the particle: vertices of the solid with
//! `φ_c < 0` and `φ_c > 0`, and the points of the liquid's surface closest to liquid–air dual cells, `x − φ n`. It points from the
//! particle towards its samples. The length `ℓ_c` is missing in the paper (E11).
//!
//! Interfaces with fewer than three samples are degenerate: their force is left out, and counted (Section 5.2). So are those whose
//! samples span no plane.
//!
//! Limit: a plane through samples within `R` has the direction of a curved surface in the middle of the samples, not at the line.
//! Samples on the other side of a thin solid count as well.

use super::line_mesh::{LineMesh, LineParticle};
use super::plane_fit::FittedPlane;
use crate::paper::Tensions;
use crate::paper::fluid::cells::{CellTypes, FaceType};
use crate::paper::fluid::fractions::phi_at_face;
use meniscus_numerics::Vector;
use meniscus_numerics::grid::Sampler;
use meniscus_numerics::mesh::SurfaceMesh;
use rayon::prelude::*;

/// Points of the three interfaces, m.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InterfaceSamples<const D: usize> {
    /// Of the liquid–air interface.
    pub liquid_air: Vec<Vector<D>>,
    /// Of the liquid–solid interface.
    pub liquid_solid: Vec<Vector<D>>,
    /// Of the solid–air interface.
    pub solid_air: Vec<Vector<D>>,
}

/// The tangents at a particle, and the force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineForce<const D: usize> {
    /// Unit tangents `t_la`, `t_ls` and `t_sa` out of the line; `None` where degenerate.
    pub tangents: [Option<Vector<D>>; 3],
    /// The force `f_c`, N (2D: N/m).
    pub force: Vector<D>,
}

impl<const D: usize> InterfaceSamples<D> {
    /// Samples of a level set of the liquid, m, and of a surface with its `φ_c`, m.
    pub fn new(types: &CellTypes<D>, phi: &Sampler<'_, D>, surface: &SurfaceMesh<D>, phi_c: &[f64]) -> Self {
        let closest = |face| {
            let (value, differences) = phi_at_face(phi, types.grid(), face);
            let normal = Vector::from(differences).try_normalize(0.0)?;
            Some(types.center(face) - normal * value)
        };
        let faces = types.faces_of(FaceType::LiquidAir);
        let of_side = |keep: &dyn Fn(f64) -> bool| {
            let vertices = surface.positions.iter().zip(phi_c);
            vertices.filter(|(_, phi)| keep(**phi)).map(|(x, _)| *x).collect()
        };
        Self {
            liquid_air: faces.into_par_iter().filter_map(closest).collect(),
            liquid_solid: of_side(&|phi| phi < 0.0),
            solid_air: of_side(&|phi| phi > 0.0),
        }
    }

    /// The force on a particle from samples within a radius, m.
    pub fn force(&self, particle: &LineParticle<D>, radius: f64, tensions: &Tensions) -> LineForce<D> {
        let tangent = |samples: &Vec<Vector<D>>| {
            let near = samples.iter().filter(|x| (*x - particle.at).norm() <= radius);
            let plane = FittedPlane::new(&near.copied().collect::<Vec<_>>())?;
            plane.tangent(&particle.at, &particle.tangent)
        };
        let tangents = [&self.liquid_air, &self.liquid_solid, &self.solid_air].map(tangent);
        let sizes = [tensions.liquid_air, tensions.liquid_solid, tensions.solid_air];
        let pull = |(t, size): (&Option<Vector<D>>, f64)| t.unwrap_or(Vector::zeros()) * size;
        let per_length: Vector<D> = tangents.iter().zip(sizes).map(pull).sum();
        LineForce { tangents, force: per_length * particle.length }
    }

    /// The forces on all particles of a line, and the number of degenerate interfaces.
    pub fn forces(&self, line: &LineMesh<D>, radius: f64, tensions: &Tensions) -> (Vec<LineForce<D>>, u64) {
        let particles = line.particles.par_iter();
        let forces: Vec<LineForce<D>> = particles.map(|p| self.force(p, radius, tensions)).collect();
        let degenerate = forces.iter().flat_map(|f| &f.tangents).filter(|t| t.is_none()).count();
        (forces, degenerate as u64)
    }
}
