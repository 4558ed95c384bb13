//! Stiffness of forces that are not the solid's own.

use meniscus_numerics::{Matrix, Vector};

/// Stiffness that other forces add, N/m (2D: N/m²): minus the derivative of the force on `first` by the position of
/// `second`. For two different vertices the transpose counts for the exchanged pair by itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StiffnessBlock<const D: usize> {
    /// A vertex.
    pub first: u32,
    /// The same, or one that shares an element with it.
    pub second: u32,
    /// The block; symmetric if the vertices are the same. All blocks together must be positive semidefinite.
    pub block: Matrix<D>,
}

/// Adds the impulses, N s, of other forces' stiffness in a step of `h` s that changes the velocities by `w`.
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
