//! Barrier contact and friction of surface meshes in 2D and 3D from one source.
//!
//! Source: M. Li, Z. Ferguson, T. Schneider, T. Langlois, D. Zorin, D. Panozzo, C. Jiang, D. M. Kaufman, "Incremental Potential
//! Contact", ACM Trans. Graph. 39(4), 2020 (IPC).
//!
//! A point and a facet (in 3D also two edges) closer than the activation distance `d̂` have the energy
//!
//! ```text
//! a κ d̂ β(d/d̂),    β(t) = −(1 − t)² ln t,
//! ```
//!
//! with their distance `d`, the area `a` of the point (2D: length) and the stiffness `κ`, a pressure; the contact pressure is `−κ β'`.
//! [`Contact`] and [`Friction`] have values, gradients and Hessians; [`LocalDerivatives::projected_psd`] makes the latter positive
//! semidefinite. Surfaces that do not intersect stay free of intersections if no step of a minimisation exceeds
//! [`FeaturePairs::collision_free_fraction`].
//!
//! This crate knows points, facets and edges only; the caller moves the points and keeps elements from inverting.

mod barrier;
pub mod broad_phase;
mod ccd;
mod collision_mesh;
mod distance;
mod friction;
mod local_derivatives;
mod mollifier;
mod plane;

pub use barrier::{Barrier, Contact};
pub use ccd::{Clearance, collision_free_fraction, inversion_free_fraction};
pub use collision_mesh::{CollisionMesh, FeaturePairs};
pub use distance::{ClosestPair, Stencil, StencilKind};
pub use friction::{Friction, FrictionPair};
pub use local_derivatives::LocalDerivatives;
pub use plane::Plane;

#[cfg(test)]
mod tests;
