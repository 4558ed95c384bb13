//! Gradient and Hessian of an energy of up to four points.

use meniscus_numerics::{Matrix, Vector};
use nalgebra::{SMatrix, SymmetricEigen};

/// First and second derivatives of an energy with respect to the positions of up to four points.
#[derive(Clone, Copy, Debug)]
pub struct LocalDerivatives<const D: usize> {
    /// Number of points.
    pub point_count: usize,
    /// Gradient of each point, N (2D: N/m).
    pub gradient: [Vector<D>; 4],
    /// Hessian of each pair of points, N/m (2D: N/m²).
    pub hessian: [[Matrix<D>; 4]; 4],
}

impl<const D: usize> LocalDerivatives<D> {
    /// Zero derivatives of `point_count` points.
    pub fn zeros(point_count: usize) -> Self {
        Self { point_count, gradient: [Vector::zeros(); 4], hessian: [[Matrix::zeros(); 4]; 4] }
    }

    /// The same with the Hessian projected to its positive semidefinite part.
    pub fn projected_psd(mut self) -> Self {
        // Matrix sizes are constants: three points in 2D, four in 3D.
        if D == 2 && self.point_count <= 3 {
            self.project::<6>()
        } else {
            self.project::<12>()
        }
        self
    }

    fn project<const N: usize>(&mut self)
    where
        SMatrix<f64, N, N>: Projected,
    {
        let whole = SMatrix::<f64, N, N>::from_fn(|i, j| {
            if i / D < self.point_count && j / D < self.point_count {
                self.hessian[i / D][j / D][(i % D, j % D)]
            } else {
                0.0
            }
        });
        let whole = whole.projected();
        for k in 0..self.point_count {
            for l in 0..self.point_count {
                self.hessian[k][l] = Matrix::from_fn(|a, b| whole[(k * D + a, l * D + b)]);
            }
        }
    }
}

/// Projection of symmetric matrices to their positive semidefinite part.
trait Projected {
    fn projected(&self) -> Self;
}

macro_rules! projected {
    ($n:literal) => {
        impl Projected for SMatrix<f64, $n, $n> {
            fn projected(&self) -> Self {
                let SymmetricEigen { eigenvectors, eigenvalues } = self.symmetric_eigen();
                let values = eigenvalues.map(|v| v.max(0.0));
                eigenvectors * Self::from_diagonal(&values) * eigenvectors.transpose()
            }
        }
    };
}

projected!(6);
projected!(12);
