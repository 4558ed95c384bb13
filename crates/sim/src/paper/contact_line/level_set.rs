//! The level set of the contact line on the surface of a solid (Algorithm 1, Fig. 7).
//!
//! ```text
//! φ_ε = φ − ε   at the vertices
//! φ_ε → φ_c,ε   reinitialised along the surface, within 5 Δx
//! φ_c = φ_c,ε + ε
//! ```
//!
//! `φ` is the liquid's level set by linear interpolation, closed along solids, so that it is near zero on wetted vertices: the offset
//! `ε = Δx` makes its sign certain. `φ_c` is negative on the liquid–solid interface. The distance along the surface is that of
//! [`Geodesic`], whose fronts may be curved; the paper's are planar.
//!
//! On an open surface ([`Errata::exact_line`](crate::paper::Errata::exact_line)) `φ` changes its sign at the line, and `ε` is zero.
//!
//! Limit: the nearest liquid need not lie along the surface (E14). Of a flat solid and a flat surface that meet at the angle `θ`, `φ` at a
//! distance `s` from the line is `s` up to 90 degrees and `s sin θ` beyond, where the surface overhangs the dry solid: there the line lies
//! `ε (1/sin θ − 1)` too far out.

use meniscus_numerics::mesh::{Contour, Geodesic, SurfaceMesh};
use meniscus_numerics::{Vector, par};

/// Offset `ε`, in cells.
pub const OFFSET_CELLS: f64 = 1.0;
/// Half the width of the band in which the level set is a distance, in cells.
pub const BAND_CELLS: f64 = 5.0;

/// `φ_c` at the vertices of a surface, m, negative where it is wetted; beyond the band around the enlarged liquid's contour it is constant.
///
/// `phi` is the liquid's level set at the vertices, m, `geodesic` that of the mesh, `dx` the size of a cell and `offset` that of
/// [`OFFSET_CELLS`], m.
pub fn contact_line_level_set<const D: usize>(
    mesh: &SurfaceMesh<D>,
    geodesic: &Geodesic<D>,
    phi: &(dyn Fn(&Vector<D>) -> f64 + Sync),
    [dx, offset]: [f64; 2],
) -> Vec<f64> {
    let enlarged = par::map_slice(&mesh.positions, 256, |x| phi(x) - offset);
    let contour = Contour::of(&mesh.facets, &enlarged);
    let mut level_set = geodesic.distance(mesh, &contour, &enlarged, BAND_CELLS * dx);
    level_set.iter_mut().for_each(|value| *value += offset);
    level_set
}
