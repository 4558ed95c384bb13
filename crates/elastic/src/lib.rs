//! Deformable solids by themselves, in two and three dimensions from one source.
//!
//! A body is a mesh of triangles or tetrahedra with its mass at the vertices ([`Elastic`], which never changes), the
//! positions and velocities of these ([`ElasticState`], plain data), and terms that pull at them ([`ForceTerm`]). 2D is
//! plane strain, per metre of depth; everything is SI.
//!
//! # One step
//!
//! The simulator is a leapfrog: positions first, `x ← x + h v`, then velocities from the forces at the new positions,
//!
//! ```text
//! A (v' − v) = h (f(x) − D v + g),        A = M + h D + h²/4 K,
//! ```
//!
//! with the lumped masses `M`, the damping `D`, the positive part `K` of the stiffness, and external forces `g`: a mode of
//! any frequency neither grows nor decays for any `h`. A little dissipation ([`Integrator`]) is added where strains are
//! large. [`System`] is the factorised `A` (of the largest meshes conjugate gradients); a liquid's pressure solve applies
//! `A⁻¹` once per iteration.
//!
//! # Elements
//!
//! Linear simplices are too stiff in bending: a plate of two layers 1.9 times at ν = 0.3, 2.7 times at 0.45. So elements are quadratic
//! ([`Order`]): each is `2^D` of the mesh's simplices together, which share its nodes. The vertices stay the only unknowns, and all that
//! meets the body meets the mesh.

mod body;
mod describe;
mod error;
mod incremental;
mod ledger;
mod linalg;
mod modes;
mod state;
mod step;
mod term;

pub use body::Elastic;
pub use describe::{Anchor, Description, Law, Motion};
pub use error::ElasticError;
pub use incremental::Incremental;
pub use linalg::{Assembly, BlockMatrix, Cliques, Reach, Solution, Structure};
pub use meniscus_numerics::mesh::volume::Order;
pub use modes::{Mode, lowest_modes, settled_modes};
pub use state::ElasticState;
pub use step::{Integrator, Linearisation, StiffnessBlock, System};
pub use term::continuum::Continuum;
pub use term::corotated::Corotated;
pub use term::crushed::{CRUSHED, Crushed};
pub use term::density::{Density, Lame, Principal};
pub use term::neo_hookean::NeoHookean;
pub use term::springs::Springs;
pub use term::tension::SurfaceTension;
pub use term::{ConservingTerm, ForceTerm, Weights};
