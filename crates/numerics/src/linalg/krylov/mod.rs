//! Krylov methods: conjugate gradients and MINRES.

mod conjugate_gradient;
mod minres;
mod restart;
#[cfg(test)]
mod tests;

pub use conjugate_gradient::{
    conjugate_gradient, conjugate_gradient_in_single_precision, conjugate_gradient_with_workspace,
};
pub use minres::{minres, minres_with_workspace};
