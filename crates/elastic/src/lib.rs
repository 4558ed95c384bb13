//! Deformable solids by themselves, in two and three dimensions from one source.
//!
//! A body is a mesh of triangles or tetrahedra with its mass at the vertices ([`Elastic`], which never changes), the
//! positions and velocities of these ([`ElasticState`], plain data), and terms that pull at them ([`ForceTerm`]). 2D is
//! plane strain, per metre of depth; everything is SI.
//!
//! # One step
//!
//! Positions first, `x ← x + h v`; then the velocities at the end of the step, half a step ahead of the positions, make an incremental
//! potential least ([`IncrementalPotential`]), by Newton's method. Its forces do the work by which the elastic energy changes, so that energy and
//! both momenta are kept for any step (J. Simo & N. Tarnow 1992). About rest a mode of any frequency neither grows nor decays. The
//! matrices are factorised, those of the largest meshes solved by conjugate gradients. A solid by itself takes such steps by
//! [`Elastic::step`]; the simulator adds the potentials of contacts and the liquid's pressure.
//!
//! # Elements
//!
//! Linear simplices are too stiff in bending: a plate of two layers 1.9 times at ν = 0.3, 2.7 times at 0.45. So elements are quadratic
//! ([`ElementOrder`]): each is `2^D` of the mesh's simplices together, which share its nodes. The vertices stay the only unknowns, and all that
//! meets the body meets the mesh.

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

pub use elastic_solid::Elastic;
pub use error::ElasticError;
pub use incremental_potential::IncrementalPotential;
pub use linalg::{Assembly, AssemblyInverse, AssemblyStructure, BlockMatrix, Cliques, Reach};
pub use meniscus_numerics::mesh::volume::ElementOrder;
pub use modes::{Mode, lowest_modes, lowest_modes_to_tolerance};
pub use specification::{Anchor, AnchorMotion, ConstitutiveLaw, ElasticSpecification};
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
