//! Overlaps of solids: where they start there may be none, and no step makes any.
//!
//! Rigid solids are held against each other by probes of their surfaces and the other's signed distance; the surfaces of solids that
//! deform by their points, facets and edges ([`clamped_radiance`]). The resolution is that of the probes, half a cell.

mod deformable;
mod rigid;
mod surfaces;

pub use rigid::overlaps;

/// Numbers of two solids that overlap, and how deep, m; no second one for a side of the domain, the same twice for a solid
/// that runs through itself.
pub type Overlap = (usize, Option<usize>, f64);
