//! Signed distance to an interface: keeping it one, moving it.

mod redistance;

pub use redistance::{redistance, slope};
