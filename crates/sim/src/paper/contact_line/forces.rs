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
//! A plane through samples within `R` has the direction of a curved surface in the middle of the samples, at the distance `s` from the
//! line. With [`Errata::tangent_at_line`](crate::paper::Errata::tangent_at_line) (E25) the tangent `t_la` is turned back by the curvature
//! `k` of the surface along it, `t_la + k s n`.
//!
//! Divided by directions ([`LineForce::by_directions`], E22), with the solid's normal `n_s`, the tangent `m` of its surface towards the
//! air, and `P` the projection along the solid, liquid and solid get
//!
//! ```text
//! f_l = ℓ_c (P Υ_la t_la + (Υ_sa − Υ_ls) m),    f_s = ℓ_c ((Υ_la t_la · n_s) n_s − (Υ_sa − Υ_ls) m)
//! ```
//!
//! Liquid and solid together get the pull of the surface, `Υ_la t_la`; what pulls the liquid along the solid, the solid gives (E12). In
//! balance `f_l = 0` is Young's equation.
//!
//! Limit: samples on the other side of a thin solid count as well.

use super::line_mesh::{LineMesh, LineParticle};
use super::plane_fit::FittedPlane;
use crate::paper::Tensions;
use crate::paper::fluid::cells::{CellTypes, FaceType};
use crate::paper::fluid::fractions::phi_at_face;
use crate::paper::fluid::surface_shape::SurfaceShape;
use meniscus_numerics::grid::Sampler;
use meniscus_numerics::mesh::SurfaceMesh;
use meniscus_numerics::{Vector, par};

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

impl<const D: usize> LineForce<D> {
    /// The parts of the force on liquid and solid, N (2D: N/m), for a particle of a length (m; 2D: 1) on a solid with a unit normal; nothing
    /// where the surface's tangent is degenerate, or those of the solid are.
    pub fn by_directions(&self, normal: &Vector<D>, length: f64, tensions: &Tensions) -> [Vector<D>; 2] {
        let along = |t: Vector<D>| t - normal * t.dot(normal);
        let [surface, wetted, dry] = self.tangents;
        let outwards = along(dry.unwrap_or(Vector::zeros()) - wetted.unwrap_or(Vector::zeros()));
        let (Some(surface), Some(outwards)) = (surface, outwards.try_normalize(0.0)) else {
            return [Vector::zeros(); 2];
        };
        let pull = surface * (tensions.liquid_air * length);
        let of_solid = outwards * ((tensions.solid_air - tensions.liquid_solid) * length);
        [along(pull) + of_solid, normal * pull.dot(normal) - of_solid]
    }
}

/// The unit tangent of a surface at the line from that in the middle of samples, which lie at `offset` (m) from the line, with its normal and
/// its curvature along the tangent, 1/m.
fn turned_back<const D: usize>(
    tangent: &Vector<D>,
    offset: &Vector<D>,
    (normal, bend): &(Vector<D>, f64),
) -> Vector<D> {
    let across = (normal - tangent * normal.dot(tangent)).try_normalize(0.0).unwrap_or(Vector::zeros());
    (tangent + across * (bend * offset.dot(tangent))).normalize()
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
            liquid_air: par::filter_map(faces.len(), 1, |i| closest(faces[i])),
            liquid_solid: of_side(&|phi| phi < 0.0),
            solid_air: of_side(&|phi| phi > 0.0),
        }
    }

    /// The force on a particle from samples within a radius, m; with a `shape` of the surface its tangent is that at the line.
    pub fn force(
        &self,
        particle: &LineParticle<D>,
        radius: f64,
        tensions: &Tensions,
        shape: Option<&SurfaceShape<'_, D>>,
    ) -> LineForce<D> {
        let tangent = |samples: &Vec<Vector<D>>| {
            let near = samples.iter().filter(|x| (*x - particle.at).norm() <= radius);
            let plane = FittedPlane::new(&near.copied().collect::<Vec<_>>())?;
            Some((plane.tangent(&particle.at, &particle.tangent)?, plane.center))
        };
        let fitted = [&self.liquid_air, &self.liquid_solid, &self.solid_air].map(tangent);
        let mut tangents = fitted.map(|fit| fit.map(|(t, _)| t));
        if let (Some((t, center)), Some(shape)) = (fitted[0], shape) {
            tangents[0] = Some(turned_back(&t, &(center - particle.at), &shape.bend(&particle.at, &t)));
        }
        let sizes = [tensions.liquid_air, tensions.liquid_solid, tensions.solid_air];
        let pull = |(t, size): (&Option<Vector<D>>, f64)| t.unwrap_or(Vector::zeros()) * size;
        let per_length: Vector<D> = tangents.iter().zip(sizes).map(pull).sum();
        LineForce { tangents, force: per_length * particle.length }
    }

    /// The forces on all particles of a line with the tensions at each place (m), and the number of degenerate interfaces.
    pub fn forces(
        &self,
        line: &LineMesh<D>,
        radius: f64,
        tensions: &(dyn Fn(&Vector<D>) -> Tensions + Sync),
        shape: Option<&SurfaceShape<'_, D>>,
    ) -> (Vec<LineForce<D>>, u64) {
        let force = |p: &LineParticle<D>| self.force(p, radius, &tensions(&p.at), shape);
        let forces = par::map_slice(&line.particles, 1, force);
        let degenerate = forces.iter().flat_map(|f| &f.tangents).filter(|t| t.is_none()).count();
        (forces, degenerate as u64)
    }
}
