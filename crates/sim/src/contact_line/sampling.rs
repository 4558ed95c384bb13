//! Samples of φ on the surfaces of solids, from the liquid's side.

use meniscus_numerics::Vector;
use meniscus_numerics::grid::Sampler;

/// Heights above a vertex, in cells, at which φ is sampled; the upper one gives the second derivative. From 1.5 and 2.5
/// cells the foot of a front that rolls over a dry solid seems wetted too early (error of 1.4 cells, 0.2 from here).
const SAMPLE_HEIGHT_CELLS: f64 = 0.5;
pub const UPPER_SAMPLE_HEIGHT_CELLS: f64 = 1.5;
/// Bound of the second derivative of φ, 1/cell: a larger one comes from a kink.
const MAX_SECOND_DERIVATIVE: f64 = 0.3;
/// |φ| above a vertex, in cells, beyond which no contact line is near.
pub const MAX_LINE_PHI_CELLS: f64 = 3.5;

/// φ at a point of a solid with the normal `n`, m, extrapolated from above; `dx` is the cell size, m.
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
    // A distance has a slope of at most 1; a larger one would make lines where φ jumps within a thin solid.
    value - dx * SAMPLE_HEIGHT_CELLS * (slope.dot(n) - 0.5 * SAMPLE_HEIGHT_CELLS * bend).clamp(-1.0, 1.0)
}
