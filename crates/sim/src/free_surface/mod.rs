//! The free surface: its energy on dual cells, its curvature, its extension into solids, and the grid faces that it crosses.

pub mod curvature;
pub mod curvature_filter;
pub mod dual_cell;
pub mod energy;
pub mod extension;
pub mod interface_faces;
