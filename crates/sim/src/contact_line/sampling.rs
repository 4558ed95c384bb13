//! φ on the surfaces of solids, from the liquid's side.

use meniscus_numerics::Vector;
use meniscus_numerics::grid::Sampler;

/// Height above a vertex, in cells, at which φ is looked at, and farther up for its bend. From 1.5 and 2.5 cells the foot of
/// a front that rolls over a dry solid is seen wet before it is (measured: off by 1.4 cells; by 0.2 from here).
const SAMPLE_HEIGHT_CELLS: f64 = 0.5;
pub const UPPER_SAMPLE_HEIGHT_CELLS: f64 = 1.5;
/// Bend of φ, 1/cell, that is a kink and not believed.
const MAX_SECOND_DERIVATIVE: f64 = 0.3;
/// Value of φ above a vertex, in cells, beyond which the line is not near.
pub const MAX_LINE_PHI_CELLS: f64 = 3.5;

/// φ at a point of a solid with the normal `n`, from above; `dx` is the size of a cell, m.
pub fn phi_at_solid<const D: usize>(phi: &Sampler<'_, D>, x: &Vector<D>, n: &Vector<D>, dx: f64) -> f64 {
    let low = x + n * (SAMPLE_HEIGHT_CELLS * dx);
    let rough = phi.linear(&low);
    if rough.abs() > MAX_LINE_PHI_CELLS * dx {
        return rough;
    }
    let (value, slope) = phi.distance_with_gradient(&low);
    let (_, higher) = phi.distance_with_gradient(&(x + n * (UPPER_SAMPLE_HEIGHT_CELLS * dx)));
    let bend = ((higher - slope).dot(n) / (UPPER_SAMPLE_HEIGHT_CELLS - SAMPLE_HEIGHT_CELLS))
        .clamp(-MAX_SECOND_DERIVATIVE, MAX_SECOND_DERIVATIVE);
    // A distance changes by no more than the way: else there would be lines where φ jumps, within a thin solid.
    value - dx * SAMPLE_HEIGHT_CELLS * (slope.dot(n) - 0.5 * SAMPLE_HEIGHT_CELLS * bend).clamp(-1.0, 1.0)
}
