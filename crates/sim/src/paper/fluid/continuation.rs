//! The liquid's surface continued into solids (erratum E23).
//!
//! ```text
//! φ(x) = φ_1 + (φ_1 − φ_2) (d + h_1)/(h_2 − h_1),    φ_k = φ(x + (d + h_k) n_s)   at the depth d below a solid with the normal n_s
//! ```
//!
//! With the continuation the surface ends nowhere: it is carried and made a distance as if the solid were not there, and no corner at
//! the line is rounded. It is linear, so that it imposes no contact angle: a flat surface goes on flat, whatever its angle.
//!
//! Limit: a curved surface is not bent within the solid. So curvatures are taken from above it
//! ([`SurfaceShape`](super::surface_shape::SurfaceShape)).

use meniscus_numerics::Vector;
use meniscus_numerics::grid::{CellField, Sampler};
use rayon::prelude::*;

/// Heights above the solid, in cells, of the two samples; beside a flat solid along the grid no sample's cells are solid.
const SAMPLE_HEIGHTS_CELLS: [f64; 2] = [1.0, 2.0];
/// Depth, in cells, down to which the surface is continued; below there is no liquid.
const MAX_DEPTH_CELLS: f64 = 6.0;

/// Signed distance to the nearest solid, m, negative inside, and its normal out of the solid.
pub type SolidSide<'a, const D: usize> = &'a (dyn Fn(&Vector<D>) -> (f64, Vector<D>) + Sync);

/// Continues a level set, m, into solids. `phi` samples it, `depth` is the distance to the solids alone, and `limit` (m) bounds φ.
pub fn continue_into_solids<const D: usize>(
    field: &CellField<D>,
    phi: &Sampler<'_, D>,
    distance: &(dyn Fn(&Vector<D>) -> f64 + Sync),
    side: SolidSide<'_, D>,
    limit: f64,
) -> CellField<D> {
    let (grid, lattice) = (field.grid, field.grid.lattice());
    let of = |(cell, old): (usize, &f64)| {
        let x = grid.center(lattice.coordinates(cell));
        let depth = -distance(&x);
        if depth <= 0.0 {
            return *old;
        }
        if depth > MAX_DEPTH_CELLS * grid.dx {
            return limit;
        }
        let normal = side(&x).1;
        let [low, high] = SAMPLE_HEIGHTS_CELLS.map(|h| phi.linear(&(x + normal * (depth + h * grid.dx))));
        let [first, second] = SAMPLE_HEIGHTS_CELLS;
        let way = (depth / grid.dx + first) / (second - first);
        (low + (low - high) * way).clamp(-limit, limit)
    };
    let data = field.data.par_iter().enumerate().with_min_len(256).map(of).collect();
    CellField { grid, data }
}
