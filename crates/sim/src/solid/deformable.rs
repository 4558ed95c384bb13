//! Solids that deform, as the liquid meets them.
//!
//! Their positions go first, then their velocities, as the liquid's do: the new velocities make the incremental potential of
//! `meniscus_elastic::Incremental` least, together with contacts ([`crate::collision`]). The liquid's pressure is solved for with the
//! inverse of its second derivatives in its system, so that how soft or light a solid is sets no limit to the step (design,
//! numerics §1).

use super::surface::{Grip, Skin};
use meniscus_elastic::{Elastic, ElasticState};
use meniscus_numerics::Vector;
use meniscus_numerics::mesh::SurfaceMesh;
use std::sync::Arc;

/// Time, s, over which held vertices have their velocity at the start.
const INSTANT: f64 = 1e-9;

/// A cell, and which degrees of freedom flow into it, how much.
pub type Flow = (u32, Vec<(u32, f64)>);

/// Where a solid that deforms is, and how it moves.
#[derive(Clone, Debug)]
pub struct Soft<const D: usize> {
    /// Positions and velocities of its mesh's vertices.
    pub body: ElasticState<D>,
    /// Its surface there.
    pub skin: Arc<Skin<D>>,
}

impl<const D: usize> PartialEq for Soft<D> {
    fn eq(&self, other: &Self) -> bool {
        self.body == other.body
    }
}

impl<const D: usize> Soft<D> {
    /// The solid at the start.
    pub fn start(elastic: &Elastic<D>, velocity: &Vector<D>) -> Self {
        let mut body = elastic.at_rest(INSTANT);
        let free = body.velocities.iter_mut().zip(elastic.held()).filter(|(_, held)| !**held);
        free.for_each(|(v, _)| *v = *velocity);
        Self::of(elastic, body)
    }

    /// The solid as a checkpoint has it: [`crate::Simulation::resume`] gives it its surface.
    pub fn bare(body: ElasticState<D>) -> Self {
        Self { body, skin: Arc::new(Skin::new(SurfaceMesh::default(), Vec::new())) }
    }

    /// The solid in a state of its own.
    pub fn of(elastic: &Elastic<D>, body: ElasticState<D>) -> Self {
        let (surface, vertices) = elastic.mesh().surface();
        let skin = Arc::new(Skin::new(surface, vertices).at(&body.positions));
        Self { body, skin }
    }

    /// The same with its surface.
    pub fn dressed(self, elastic: &Elastic<D>) -> Self {
        Self::of(elastic, self.body)
    }

    /// Moves it by its velocity.
    pub fn advance(&mut self, elastic: &Elastic<D>, dt: f64) {
        elastic.advance_positions(&mut self.body, dt);
        self.skin = Arc::new(self.skin.at(&self.body.positions));
    }

    /// Where the point of its surface nearest to `x` was at the start, m, and its normal there.
    pub fn at_start(&self, elastic: &Elastic<D>, x: &Vector<D>) -> Option<(Vector<D>, Vector<D>)> {
        let rest = &elastic.mesh().positions;
        let grip = self.skin.grip(x)?;
        let corners = grip.vertices.map(|v| rest[v as usize]);
        let normal = meniscus_numerics::mesh::surface::area_vector(&corners);
        Some((grip.mean(|k| rest[k]), normal.normalize()))
    }

    /// Centre of mass, m, and its velocity, m/s.
    pub fn means(&self, elastic: &Elastic<D>) -> (Vector<D>, Vector<D>) {
        let masses = elastic.masses();
        let mass: f64 = masses.iter().sum();
        let mean = |of: &[Vector<D>]| of.iter().zip(masses).map(|(x, m)| x * (m / mass)).sum();
        (mean(&self.body.positions), mean(&self.body.velocities))
    }
}

/// Adds impulses where a solid is gripped to those of its vertices.
pub fn spread<const D: usize>(grips: &[(Grip<D>, Vector<D>)], vertices: &mut [Vector<D>]) {
    for (grip, impulse) in grips {
        let corners = grip.vertices.iter().zip(grip.weights);
        corners.for_each(|(vertex, weight)| vertices[*vertex as usize] += impulse * weight);
    }
}
