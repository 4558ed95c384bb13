//! The free surface: its energy on the cubes between cell centres, its curvature, its continuation into solids, and where it cuts the grid.

pub mod curvature;
pub mod curvature_filter;
pub mod dual_cell;
pub mod energy;
pub mod extension;
pub mod interface_faces;
