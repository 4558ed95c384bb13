//! Deformable solids, coupled to the liquid.
//!
//! Positions are advanced first, then velocities, as for the liquid: the new velocities minimise the incremental potential of
//! `meniscus_elastic::IncrementalPotential` together with contacts ([`crate::collision`]). The pressure system of the liquid contains
//! the inverse Hessian, so that softness and lightness of a solid do not limit the step.

use super::surface::{SolidSurface, SurfacePoint};
use meniscus_elastic::{Elastic, ElasticState};
use meniscus_numerics::Vector;
use meniscus_numerics::mesh::SurfaceMesh;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Time, s, of the difference that gives anchored vertices their initial velocity.
const INITIAL_DIFFERENCE_TIME: f64 = 1e-9;

/// A cell, and the degrees of freedom that flow into it with their weights.
pub type FluxRow = (u32, Vec<(u32, f64)>);

/// Position and velocity of a deformable solid.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Soft<const D: usize> {
    /// Positions and velocities of the mesh's vertices.
    pub state: ElasticState<D>,
    /// The surface at these positions. It follows from them: it is not written, and [`crate::Simulation::resume`] makes it anew.
    #[serde(skip, default = "no_surface")]
    pub surface: Arc<SolidSurface<D>>,
}

fn no_surface<const D: usize>() -> Arc<SolidSurface<D>> {
    Arc::new(SolidSurface::new(SurfaceMesh::default(), Vec::new()))
}

impl<const D: usize> PartialEq for Soft<D> {
    fn eq(&self, other: &Self) -> bool {
        self.state == other.state
    }
}

impl<const D: usize> Soft<D> {
    /// The solid at the start.
    pub fn initial(elastic: &Elastic<D>, velocity: &Vector<D>) -> Self {
        let mut body = elastic.rest_state(INITIAL_DIFFERENCE_TIME);
        let free = body.velocities.iter_mut().zip(elastic.anchored()).filter(|(_, held)| !**held);
        free.for_each(|(v, _)| *v = *velocity);
        Self::from_state(elastic, body)
    }

    /// The solid as stored in a checkpoint; [`crate::Simulation::resume`] adds its surface.
    pub fn without_surface(state: ElasticState<D>) -> Self {
        Self { state, surface: no_surface() }
    }

    /// The solid in a given state.
    pub fn from_state(elastic: &Elastic<D>, state: ElasticState<D>) -> Self {
        let (surface, vertices) = elastic.rest_mesh().surface();
        let skin = Arc::new(SolidSurface::new(surface, vertices).with_positions(&state.positions));
        Self { state, surface: skin }
    }

    /// The same solid with its surface.
    pub fn with_surface(self, elastic: &Elastic<D>) -> Self {
        Self::from_state(elastic, self.state)
    }

    /// Advances the positions by the velocities over `dt` (s).
    pub fn advance(&mut self, elastic: &Elastic<D>, dt: f64) {
        elastic.advance_positions(&mut self.state, dt);
        self.surface = Arc::new(self.surface.with_positions(&self.state.positions));
    }

    /// Reference position of the surface point closest to `x`, m, and the reference normal there.
    pub fn reference_point_and_normal(
        &self,
        elastic: &Elastic<D>,
        x: &Vector<D>,
    ) -> Option<(Vector<D>, Vector<D>)> {
        let rest = &elastic.rest_mesh().positions;
        let grip = self.surface.closest_point(x)?;
        let corners = grip.vertices.map(|v| rest[v as usize]);
        let normal = meniscus_numerics::mesh::surface::area_vector(&corners);
        Some((grip.interpolate(|k| rest[k]), normal.normalize()))
    }

    /// Centre of mass, m, and its velocity, m/s.
    pub fn center_of_mass_and_velocity(&self, elastic: &Elastic<D>) -> (Vector<D>, Vector<D>) {
        let masses = elastic.masses();
        let mass: f64 = masses.iter().sum();
        let mean = |of: &[Vector<D>]| of.iter().zip(masses).map(|(x, m)| x * (m / mass)).sum();
        (mean(&self.state.positions), mean(&self.state.velocities))
    }
}

/// Distributes impulses at surface points to the vertices of their facets.
pub fn distribute_to_vertices<const D: usize>(
    grips: &[(SurfacePoint<D>, Vector<D>)],
    vertices: &mut [Vector<D>],
) {
    for (grip, impulse) in grips {
        let corners = grip.vertices.iter().zip(grip.weights);
        corners.for_each(|(vertex, weight)| vertices[*vertex as usize] += impulse * weight);
    }
}
