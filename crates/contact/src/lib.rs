//! Contact of surface meshes as a potential energy that grows without bound as the distance goes to zero, in two and three
//! dimensions from one source.
//!
//! Source: M. Li, Z. Ferguson, T. Schneider, T. Langlois, D. Zorin, D. Panozzo, C. Jiang, D. M. Kaufman, "Incremental Potential
//! Contact", ACM Trans. Graph. 39(4), 2020 (IPC).
//!
//! A point and a facet that are nearer to each other than the reach `d̂` (in 3D two edges as well) have the energy
//!
//! ```text
//! a κ d̂ β(d/d̂),    β(t) = −(1 − t)² ln t,
//! ```
//!
//! with their distance `d`, the area `a` of the point (2D: length) and the stiffness `κ`, a pressure: they press each other
//! with `−κ β'`. Energies have values, gradients and positive semidefinite Hessians ([`Barrier`], [`Friction`]). Whoever
//! minimises a sum of them takes no step longer than [`FeaturePairs::collision_free_fraction`]: then surfaces that do not intersect never will.
//!
//! This crate knows points, facets and edges only. What moves the points, and what keeps the elements behind them upright, is
//! not its concern.

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
