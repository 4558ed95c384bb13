//! The scheme of the paper, for comparison with that of Meniscus.
//!
//! J. Liu, M. Wang, F. Feng, A. Tang, Q. Le, B. Zhu, "Hydrophobic and Hydrophilic Solid-Fluid Interaction", ACM Trans. Graph. 41, 6
//! (SIGGRAPH Asia 2022). A folder or file a section: [`fluid`] is 4.1, [`solid`] 4.2, [`contact_line`] 4.3, [`coupling`] 5,
//! [`time`] 6. Corrections that are more than a misprint are switches ([`Errata`]); `book/paper/scheme.md` lists them all, and what the
//! paper leaves open.
//!
//! Grid, meshes, geodesic distances and linear solvers are those of the rest of Meniscus. A scene chooses this scheme by
//! [`Scheme::Paper`](crate::Scheme::Paper), the method as printed by [`Scheme::PaperAsPrinted`](crate::Scheme::PaperAsPrinted).

pub mod contact_line;
pub mod coupling;
pub mod errata;
pub mod fluid;
pub mod solid;
pub mod tensions;
pub mod time;

pub use errata::{Errata, LineImpulse, LiquidMass};
pub use tensions::Tensions;
