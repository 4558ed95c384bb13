//! Stiffness of external forces on a solid.

use meniscus_numerics::{Matrix, Vector};

/// Stiffness of an external force, N/m (2D: N/m²): minus the derivative of the force on `first` with respect to the position of
/// `second`. For two different vertices the transposed block of the exchanged pair is implied.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StiffnessBlock<const D: usize> {
    /// Number of a vertex.
    pub first: u32,
    /// The same vertex, or one that shares an element with it.
    pub second: u32,
    /// Block, symmetric if the vertices are the same. All blocks together must be positive semidefinite.
    pub block: Matrix<D>,
}

/// Adds the impulses, N s, of the extra stiffness in a step of `h` s that changes the velocities by `w`, and the midpoint by `h w/4`.
pub(crate) fn add_stiffness_impulses<const D: usize>(
    extra_stiffness: &[StiffnessBlock<D>],
    h: f64,
    w: &[Vector<D>],
    impulses: &mut [Vector<D>],
) {
    for StiffnessBlock { first, second, block } in extra_stiffness {
        let (i, j, block) = (*first as usize, *second as usize, block * (0.25 * h * h));
        impulses[i] -= block * w[j];
        if i != j {
            impulses[j] -= block.tr_mul(&w[i]);
        }
    }
}
