//! Solids that deform, as the liquid meets them.
//!
//! Their positions go first, then their velocities, as the liquid's do: the new velocities make the incremental potential of
//! `meniscus_elastic::IncrementalPotential` least, together with contacts ([`crate::collision`]). The liquid's pressure is solved for with the
//! inverse of its second derivatives in its system, so that how soft or light a solid is sets no limit to the step (design,
//! numerics §1).

use super::surface::{SolidSurface, SurfacePoint};
use meniscus_elastic::{Elastic, ElasticState};
use meniscus_numerics::Vector;
use meniscus_numerics::mesh::SurfaceMesh;
use std::sync::Arc;

/// Time, s, over which held vertices have their velocity at the start.
const INITIAL_DIFFERENCE_TIME: f64 = 1e-9;

/// A cell, and which degrees of freedom flow into it, how much.
pub type FluxRow = (u32, Vec<(u32, f64)>);

/// Where a solid that deforms is, and how it moves.
#[derive(Clone, Debug)]
pub struct Soft<const D: usize> {
    /// Positions and velocities of its mesh's vertices.
    pub state: ElasticState<D>,
    /// Its surface there.
    pub surface: Arc<SolidSurface<D>>,
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

    /// The solid as a checkpoint has it: [`crate::Simulation::resume`] gives it its surface.
    pub fn without_surface(state: ElasticState<D>) -> Self {
        Self { state, surface: Arc::new(SolidSurface::new(SurfaceMesh::default(), Vec::new())) }
    }

    /// The solid in a state of its own.
    pub fn from_state(elastic: &Elastic<D>, state: ElasticState<D>) -> Self {
        let (surface, vertices) = elastic.rest_mesh().surface();
        let skin = Arc::new(SolidSurface::new(surface, vertices).with_positions(&state.positions));
        Self { state, surface: skin }
    }

    /// The same with its surface.
    pub fn with_surface(self, elastic: &Elastic<D>) -> Self {
        Self::from_state(elastic, self.state)
    }

    /// Moves it by its velocity.
    pub fn advance(&mut self, elastic: &Elastic<D>, dt: f64) {
        elastic.advance_positions(&mut self.state, dt);
        self.surface = Arc::new(self.surface.with_positions(&self.state.positions));
    }

    /// Where the point of its surface nearest to `x` was at the start, m, and its normal there.
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

/// Adds impulses where a solid is gripped to those of its vertices.
pub fn distribute_to_vertices<const D: usize>(
    grips: &[(SurfacePoint<D>, Vector<D>)],
    vertices: &mut [Vector<D>],
) {
    for (grip, impulse) in grips {
        let corners = grip.vertices.iter().zip(grip.weights);
        corners.for_each(|(vertex, weight)| vertices[*vertex as usize] += impulse * weight);
    }
}
