//! φ on the surfaces of solids, from the liquid's side.

use meniscus_numerics::Vector;
use meniscus_numerics::grid::Sampler;

/// Height above a vertex, in cells, at which φ is looked at, and farther up for its bend. From 1.5 and 2.5 cells the foot of
/// a front that rolls over a dry solid is seen wet before it is (measured: off by 1.4 cells; by 0.2 from here).
const HEIGHT: f64 = 0.5;
pub const HIGHER: f64 = 1.5;
/// Bend of φ, 1/cell, that is a kink and not believed.
const KINK: f64 = 0.3;
/// Value of φ above a vertex, in cells, beyond which the line is not near.
pub const NEAR: f64 = 3.5;

/// φ at a point of a solid with the normal `n`, from above; `dx` is the size of a cell, m.
pub fn phi_on<const D: usize>(phi: &Sampler<'_, D>, x: &Vector<D>, n: &Vector<D>, dx: f64) -> f64 {
    let low = x + n * (HEIGHT * dx);
    let rough = phi.linear(&low);
    if rough.abs() > NEAR * dx {
        return rough;
    }
    let (value, slope) = phi.distance(&low);
    let (_, higher) = phi.distance(&(x + n * (HIGHER * dx)));
    let bend = ((higher - slope).dot(n) / (HIGHER - HEIGHT)).clamp(-KINK, KINK);
    // A distance changes by no more than the way: else there would be lines where φ jumps, within a thin solid.
    value - dx * HEIGHT * (slope.dot(n) - 0.5 * HEIGHT * bend).clamp(-1.0, 1.0)
}
