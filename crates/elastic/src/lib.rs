//! Deformable solids without liquid and contacts, in 2D and 3D from one source.
//!
//! A solid consists of a mesh of triangles or tetrahedra with masses at the vertices ([`Elastic`], constant in time), the positions
//! and velocities of the vertices ([`ElasticState`]), and force terms ([`ForceTerm`]). 2D is plane strain, per metre of depth.
//! Units are SI.
//!
//! # One step
//!
//! Positions advance first, `x ← x + h v`. The new velocities, half a step ahead of the positions, minimise an incremental
//! potential ([`IncrementalPotential`]) by Newton's method. Its forces do the work by which the elastic energy changes, so the step
//! conserves energy and both momenta for any step length (J. Simo & N. Tarnow 1992). Modes of any frequency about rest neither grow
//! nor decay. Matrices are factorised; those of the largest meshes are solved by conjugate gradients. [`Elastic::step`] takes such
//! steps of a solid alone; the simulator adds the potentials of contacts and the liquid's pressure.
//!
//! # Elements
//!
//! Linear simplices are too stiff in bending: a plate of two layers by a factor of 1.9 at ν = 0.3 and 2.7 at 0.45. Elements are
//! therefore quadratic ([`ElementOrder`]): each consists of `2^D` simplices of the mesh and uses their vertices as nodes. The
//! vertices remain the only unknowns, and contacts and liquid see the mesh.

mod construct;
mod diagnostics;
mod elastic_solid;
mod error;
mod incremental_potential;
mod linalg;
mod modes;
mod specification;
mod state;
mod step;
mod term;

pub use construct::ElasticParts;
pub use elastic_solid::Elastic;
pub use error::ElasticError;
pub use incremental_potential::IncrementalPotential;
pub use linalg::{Assembly, AssemblyInverse, AssemblyStructure, BlockMatrix, Cliques, Reach};
pub use meniscus_numerics::mesh::volume::ElementOrder;
pub use modes::{Mode, lowest_modes, lowest_modes_to_tolerance};
pub use specification::{Anchor, AnchorMotion, ConstitutiveLaw, ElasticSpecification, Isotropic};
pub use state::ElasticState;
pub use step::{KEPT_FRACTION, MAX_LINE_SEARCH_HALVINGS, MAX_NEWTON_ITERATIONS};
pub use term::continuum::Continuum;
pub use term::corotated::Corotated;
pub use term::energy_density::{EnergyDensity, Lame, PrincipalHessian};
pub use term::extra_stiffness::StiffnessBlock;
pub use term::inversion_barrier::{CRUSHED_VOLUME_RATIO, InversionBarrier};
pub use term::neo_hookean::NeoHookean;
pub use term::springs::Springs;
pub use term::surface_tension::SurfaceTension;
pub use term::{DiscreteGradientTerm, ForceTerm, TangentWeights};
