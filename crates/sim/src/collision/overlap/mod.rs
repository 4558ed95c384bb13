//! Overlaps of solids. There may be none at the start, and no step creates any.
//!
//! Rigid solids are tested with sample points of one surface and the signed distance of the other. Surfaces of deformable solids are
//! tested with their points, facets and edges ([`surfaces`]). The resolution is the spacing of the sample points, half a cell.

mod deformable;
mod rigid;
mod surfaces;

pub use rigid::{initial_overlaps, overlaps};

/// Numbers of two overlapping solids, and the depth, m. `None` is a side of the domain; equal numbers are a self-intersection.
pub type Overlap = (usize, Option<usize>, f64);
