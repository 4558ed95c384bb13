//! Deformable solids, coupled to the liquid.
//!
//! Positions are advanced first, then velocities, as for the liquid: the new velocities minimise the incremental potential of
//! `meniscus_elastic::IncrementalPotential` together with contacts ([`crate::collision`]). The pressure system of the liquid contains
//! the inverse Hessian, so that softness and lightness of a solid do not limit the step.

use super::surface::SurfacePoint;
use meniscus_numerics::Vector;

/// A cell, and the degrees of freedom that flow into it with their weights.
pub type FluxRow = (u32, Vec<(u32, f64)>);

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
