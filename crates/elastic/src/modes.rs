//! Lowest elastic modes of vibration about rest, by subspace iteration (Bathe & Wilson 1972).
//!
//! The stiffness is `K̂`, that of linear elasticity, to which damping is proportional. The tension of the surface is left out: once
//! the solid has relaxed, the stress that it causes within balances it, and to first order the frequencies of a beam are those
//! without tension (Gurtin, Markenscoff & Thurston 1976). The tangent at the rest mesh, which has not relaxed, would contain the
//! tension alone and act like that of a taut string.

use crate::linalg::Inverse;
use crate::term::TangentWeights;
use crate::{BlockMatrix, Elastic, ElasticError};
use meniscus_numerics::{Vector, rotation_planes};
use nalgebra::{DMatrix, DVector};

/// Largest number of iterations.
const MAX_ITERATIONS: usize = 100;
/// Relative change of the squared frequencies at which the iteration ends.
const FREQUENCY_TOLERANCE: f64 = 1e-6;
/// Tolerance of iterative solves where there is no factor; the subspace iteration reduces their error.
const SOLVE_TOLERANCE: f64 = 1e-2;
/// Additional vectors, which reduce the number of iterations.
const GUARD_VECTORS: usize = 4;

/// An undamped mode of vibration about rest.
#[derive(Clone, Debug, PartialEq)]
pub struct Mode<const D: usize> {
    /// Angular frequency, rad/s.
    pub frequency: f64,
    /// Displacements, normalised to a unit modal mass of 1 kg (2D: 1 kg/m).
    pub shape: Vec<Vector<D>>,
}

/// The `count` lowest elastic modes; rigid motions are left out.
///
/// # Errors
/// [`ElasticError::NotPositiveDefinite`].
pub fn lowest_modes<const D: usize>(body: &Elastic<D>, count: usize) -> Result<Vec<Mode<D>>, ElasticError> {
    lowest_modes_to_tolerance(body, count, FREQUENCY_TOLERANCE)
}

/// [`lowest_modes`] with a tolerance for the relative change of the squared frequencies.
///
/// # Errors
/// [`ElasticError::NotPositiveDefinite`].
pub fn lowest_modes_to_tolerance<const D: usize>(
    body: &Elastic<D>,
    count: usize,
    tolerance: f64,
) -> Result<Vec<Mode<D>>, ElasticError> {
    let elastic = TangentWeights { stiffness: 0.0, project_psd: true, viscosity: 1.0 };
    let stiffness = body.tangent(&body.rest_mesh.positions, elastic);
    let rigid = rigid_motions(body);
    let inverse = shifted_inverse(body, &stiffness, !rigid.is_empty())?;
    let wanted = (count + GUARD_VECTORS).min(body.masses.len() * D);
    let mut vectors = mass_orthonormalised(body, initial_vectors(body, wanted), &rigid);
    let mut squares: Vec<f64> = Vec::new();
    for _ in 0..MAX_ITERATIONS {
        inverse_iteration(body, &inverse, &mut vectors);
        vectors = mass_orthonormalised(body, vectors, &rigid);
        let last = std::mem::replace(&mut squares, rayleigh_ritz(&stiffness, &mut vectors));
        let settled = |k: usize| (squares[k] - last[k]).abs() <= tolerance * squares[k];
        if !last.is_empty() && last.len() == squares.len() && (0..count.min(squares.len())).all(settled) {
            break;
        }
    }
    let modes = squares.iter().zip(vectors).take(count);
    Ok(modes.map(|(square, shape)| Mode { frequency: square.max(0.0).sqrt(), shape }).collect())
}

/// The inverse of `K + σ M` with a small shift `σ`, zero where no rigid motion is possible and `K` is positive definite.
fn shifted_inverse<const D: usize>(
    body: &Elastic<D>,
    stiffness: &BlockMatrix<D>,
    free: bool,
) -> Result<Inverse<D>, ElasticError> {
    let scale = stiffness.trace() / (D as f64 * body.masses.iter().sum::<f64>());
    let shifts = [0.0, 1e-13, 1e-11, 1e-9, 1e-7];
    for shift in &shifts[usize::from(free)..] {
        let mut matrix = stiffness.clone();
        body.masses.iter().enumerate().for_each(|(v, m)| matrix.add_diagonal(v, m * shift * scale));
        if let Some(inverse) = body.solver.invert(&matrix, &body.anchored, SOLVE_TOLERANCE) {
            return Ok(inverse);
        }
    }
    Err(ElasticError::NotPositiveDefinite { step: f64::INFINITY })
}

/// Rigid motions of each connected part that leave anchored vertices in place, orthonormal in the mass.
fn rigid_motions<const D: usize>(body: &Elastic<D>) -> Vec<Vec<Vector<D>>> {
    let components = body.rest_mesh.vertex_components();
    let count = components.iter().max().map_or(0, |last| *last as usize + 1);
    (0..count).flat_map(|piece| rigid_motions_of(body, &|v| components[v] as usize == piece)).collect()
}

/// Rigid motions of the part whose vertices fulfil `own`.
fn rigid_motions_of<const D: usize>(body: &Elastic<D>, own: &dyn Fn(usize) -> bool) -> Vec<Vec<Vector<D>>> {
    let positions = &body.rest_mesh.positions;
    let vertices: Vec<usize> = (0..positions.len()).filter(|v| own(*v)).collect();
    let first = positions[vertices[0]];
    let ends = |(l, h): (Vector<D>, Vector<D>), v: &usize| (l.inf(&positions[*v]), h.sup(&positions[*v]));
    let (low, high) = vertices.iter().fold((first, first), ends);
    let (center, size) = ((low + high) * 0.5, (high - low).norm());
    let motion = |of: &dyn Fn(&Vector<D>) -> Vector<D>| {
        let mut all = vec![Vector::<D>::zeros(); positions.len()];
        vertices.iter().for_each(|v| all[*v] = of(&positions[*v]));
        all
    };
    let shift = |a: usize| motion(&|_| Vector::from_fn(|r, _| f64::from(r == a)));
    let turn = |&(a, b, _): &(usize, usize, usize)| {
        motion(&|x| {
            let y = (x - center) / size;
            let along = |r| if r == a { -y[b] } else { y[a] };
            Vector::from_fn(|r, _| if r == a || r == b { along(r) } else { 0.0 })
        })
    };
    let motions: Vec<Vec<Vector<D>>> =
        (0..D).map(shift).chain(rotation_planes::<D>().iter().map(turn)).collect();
    // The combinations that move no anchored vertex.
    let product = |a: usize, b: usize| -> f64 {
        let held = vertices.iter().filter(|v| body.anchored[**v]);
        held.map(|v| motions[a][*v].dot(&motions[b][*v])).sum()
    };
    let gram = DMatrix::from_fn(motions.len(), motions.len(), product).symmetric_eigen();
    let free = (0..motions.len()).filter(|k| gram.eigenvalues[*k] < 1e-9);
    let mixed =
        free.map(|k| linear_combination(&motions, &gram.eigenvectors.column(k).into_owned())).collect();
    mass_orthonormalised(body, mixed, &[])
}

fn linear_combination<const D: usize>(vectors: &[Vec<Vector<D>>], weights: &DVector<f64>) -> Vec<Vector<D>> {
    let mut sum = vec![Vector::zeros(); vectors[0].len()];
    for (vector, weight) in vectors.iter().zip(weights.iter()) {
        sum.iter_mut().zip(vector).for_each(|(s, v)| *s += v * *weight);
    }
    sum
}

/// Smooth initial vectors, each with different wave numbers along the axes.
fn initial_vectors<const D: usize>(body: &Elastic<D>, count: usize) -> Vec<Vec<Vector<D>>> {
    let positions = &body.rest_mesh.positions;
    let (low, high) = positions.iter().fold((positions[0], positions[0]), |(l, h), x| (l.inf(x), h.sup(x)));
    let longest = (high - low).max();
    let wave = |k: usize, x: &Vector<D>| {
        Vector::<D>::from_fn(|r, _| {
            let phase: f64 = (0..D)
                .map(|a| (x[a] - low[a]) / longest * (1.0 + ((k * (D + a) + 2 * r + 3 * a) % 7) as f64))
                .sum();
            (2.0 * phase + (k * D + r) as f64).sin()
        })
    };
    (0..count).map(|k| positions.iter().map(|x| wave(k, x)).collect()).collect()
}

/// `y ← (K + σ M)⁻¹ M y`.
fn inverse_iteration<const D: usize>(
    body: &Elastic<D>,
    inverse: &Inverse<D>,
    vectors: &mut [Vec<Vector<D>>],
) {
    let weighted = |y: &Vec<Vector<D>>| {
        let pairs = y.iter().zip(&body.masses);
        pairs.flat_map(|(v, m)| (v * *m).iter().copied().collect::<Vec<_>>()).collect::<Vec<f64>>()
    };
    let mut flat: Vec<f64> = vectors.iter().flat_map(weighted).collect();
    inverse.solve(None, &mut flat, vectors.len());
    let solved = flat.chunks_exact(D);
    vectors.iter_mut().flatten().zip(solved).for_each(|(v, x)| v.copy_from_slice(x));
}

/// Makes vectors orthonormal in the mass and orthogonal to the orthonormal `others`; drops linearly dependent ones.
fn mass_orthonormalised<const D: usize>(
    body: &Elastic<D>,
    vectors: Vec<Vec<Vector<D>>>,
    others: &[Vec<Vector<D>>],
) -> Vec<Vec<Vector<D>>> {
    let dot = |a: &[Vector<D>], b: &[Vector<D>]| -> f64 {
        a.iter().zip(b).zip(&body.masses).map(|((a, b), m)| a.dot(b) * m).sum()
    };
    let mut done: Vec<Vec<Vector<D>>> = Vec::new();
    for mut vector in vectors {
        let before = dot(&vector, &vector).sqrt();
        // A second pass removes rounding errors.
        for _ in 0..2 {
            for other in others.iter().chain(&done) {
                let part = dot(&vector, other);
                vector.iter_mut().zip(other).for_each(|(v, o)| *v -= o * part);
            }
        }
        let size = dot(&vector, &vector).sqrt();
        if size > 1e-12 * before {
            vector.iter_mut().for_each(|v| *v /= size);
            done.push(vector);
        }
    }
    done
}

/// Rotates mass-orthonormal vectors so that they diagonalise the stiffness; returns their squared frequencies in ascending order.
fn rayleigh_ritz<const D: usize>(stiffness: &BlockMatrix<D>, vectors: &mut Vec<Vec<Vector<D>>>) -> Vec<f64> {
    let product = |v: &Vec<Vector<D>>| {
        let mut pulled = vec![Vector::zeros(); v.len()];
        stiffness.add_product(v, &mut pulled);
        pulled
    };
    let pulled: Vec<Vec<Vector<D>>> = vectors.iter().map(product).collect();
    let entry =
        |a: usize, b: usize| -> f64 { vectors[a].iter().zip(&pulled[b]).map(|(x, y)| x.dot(y)).sum() };
    let small = DMatrix::from_fn(vectors.len(), vectors.len(), |a, b| 0.5 * (entry(a, b) + entry(b, a)));
    let small = small.symmetric_eigen();
    let mut order: Vec<usize> = (0..vectors.len()).collect();
    order.sort_by(|a, b| small.eigenvalues[*a].total_cmp(&small.eigenvalues[*b]));
    *vectors = order
        .iter()
        .map(|k| linear_combination(vectors, &small.eigenvectors.column(*k).into_owned()))
        .collect();
    order.iter().map(|k| small.eigenvalues[*k]).collect()
}
