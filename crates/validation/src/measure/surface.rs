//! Points of the free surface, and measures of drops from them.

use super::bisect;
use meniscus_numerics::Vector;
use meniscus_numerics::fit::least_squares;
use meniscus_numerics::grid::{CellField, Sampler};
use meniscus_sim::{LineTracker, Model, Simulation};

/// Crossing of the surface with a line between the centres of neighbouring cells.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint<const D: usize> {
    /// Position, m.
    pub at: Vector<D>,
    /// Outward unit normal.
    pub normal: Vector<D>,
    /// Area that the point represents, m² (2D: m).
    pub area: f64,
}

/// The points where φ, cubic along the lattice lines, vanishes.
///
/// Lines along axis `a` cut a surface of normal `n` with the density `|n_a|/Δ^(D−1)`. The weights `Δ^(D−1) |n_a|³/Σ n⁴` sum to one over
/// all axes and vanish where the lines are tangent.
pub fn surface_points<const D: usize>(model: &Model<D>, phi: &CellField<D>) -> Vec<SurfacePoint<D>> {
    let grid = &model.grid;
    let lattice = grid.lattice();
    let sampler = Sampler::cells(grid, &phi.data, model.scalar_boundary());
    let mut points = Vec::new();
    for (i, &here) in phi.data.iter().enumerate() {
        if here.abs() > 2.0 * grid.dx {
            continue;
        }
        let at = lattice.coordinates(i);
        for a in 0..D {
            if at[a] + 1 == grid.cells[a] || (here < 0.0) == (phi.data[i + lattice.stride[a]] < 0.0) {
                continue;
            }
            let values: [f64; 4] = std::array::from_fn(|k| {
                let mut cell = at.map(|c| c as isize);
                cell[a] += k as isize - 1;
                sampler.value(cell)
            });
            let mut x = grid.center(at);
            x[a] += root(&values) * grid.dx;
            let gradient = sampler.cubic_with_gradient(&x).1;
            let normal = gradient / gradient.norm().max(1e-300);
            let fourth: f64 = normal.iter().map(|n| n.powi(4)).sum();
            let area = grid.face_area() * normal[a].abs().powi(3) / fourth.max(1e-300);
            points.push(SurfacePoint { at: x, normal, area });
        }
    }
    points
}

/// Root in [0, 1] of the cubic through values at −1, 0, 1, 2, which has opposite signs at 0 and 1.
fn root(v: &[f64; 4]) -> f64 {
    let cubic = |t: f64| {
        v[0] * (-t * (t - 1.0) * (t - 2.0) / 6.0)
            + v[1] * ((t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0)
            + v[2] * (-(t + 1.0) * t * (t - 2.0) / 2.0)
            + v[3] * ((t + 1.0) * t * (t - 1.0) / 6.0)
    };
    let [low, high] = bisect([0.0, 1.0], 50, |t| (cubic(t) < 0.0) == (v[1] < 0.0));
    0.5 * (low + high)
}

/// Volume (m³, 2D: m²) and centre of mass (m) of the liquid, by four points per axis in the cells near the surface. φ is cubic between
/// the centres; the fraction of each point follows from its distance.
///
/// Independent of the simulator's own sums. Sums over [`surface_points`] are worse: just after drops merge their volume is off by 2 % and
/// their centre by 0.3 Δ.
pub fn volume_and_centroid<const D: usize>(model: &Model<D>, phi: &CellField<D>) -> (f64, Vector<D>) {
    sampled_volume_and_centroid(model, phi, |_| f64::INFINITY)
}

/// The same of the liquid outside the solids.
pub fn volume_and_centroid_outside<const D: usize>(sim: &Simulation<D>) -> (f64, Vector<D>) {
    sampled_volume_and_centroid(&sim.model, &sim.state.phi, |x| sim.distance_to_solids(x))
}

/// Volume and centre of mass of the liquid where the distance `solids` is positive.
fn sampled_volume_and_centroid<const D: usize>(
    model: &Model<D>,
    phi: &CellField<D>,
    solids: impl Fn(&Vector<D>) -> f64,
) -> (f64, Vector<D>) {
    const FINE: usize = 4;
    let (grid, lattice) = (&model.grid, model.grid.lattice());
    let sampler = Sampler::cells(grid, &phi.data, model.scalar_boundary());
    let width = grid.dx / FINE as f64;
    let (mut volume, mut moment) = (0.0, Vector::zeros());
    let mut add = |x: &Vector<D>, share: f64| {
        volume += share;
        moment += x * share;
    };
    let far = 1.5 * grid.dx;
    for (i, &here) in phi.data.iter().enumerate() {
        if here > far {
            continue;
        }
        let center = grid.center(lattice.coordinates(i));
        let open = solids(&center);
        if here < -far && open.abs() > far {
            add(&center, if open > 0.0 { 1.0 } else { 0.0 });
            continue;
        }
        for k in 0..FINE.pow(D as u32) {
            let place = |a: usize| (k / FINE.pow(a as u32) % FINE) as f64 - 0.5 * (FINE - 1) as f64;
            let x = center + Vector::from_fn(|a, _| width * place(a));
            let full = (0.5 - sampler.cubic(&x) / width).clamp(0.0, 1.0);
            let free = (0.5 + solids(&x) / width).clamp(0.0, 1.0);
            add(&x, full * free / FINE.pow(D as u32) as f64);
        }
    }
    (volume * grid.cell_volume(), moment / volume)
}

/// A tracker of the contact lines on solids with the mesh that the program gives them.
pub fn line_tracker<const D: usize>(sim: &Simulation<D>) -> LineTracker<D> {
    LineTracker::new(&sim.model, &[sim.model.grid.dx / 1.5])
}

/// A mode of a drop as a function of the direction from its centre: `cos nθ`, θ from the first axis, in 2D and the
/// Legendre polynomial `P_n(cos ϑ)`, ϑ from the last axis, in 3D.
pub fn mode_shape<const D: usize>(mode: u32, direction: &Vector<D>) -> f64 {
    if D == 2 {
        return (f64::from(mode) * direction[1].atan2(direction[0])).cos();
    }
    let x = direction[D - 1];
    let (mut before, mut value) = (1.0, x);
    if mode == 0 {
        return before;
    }
    for n in 1..mode {
        let n = f64::from(n);
        (before, value) = (value, ((2.0 * n + 1.0) * x * value - n * before) / (n + 1.0));
    }
    value
}

/// Decomposition of a drop's shape into radius, centre and one mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Roundness {
    /// Mean radius, m.
    pub radius: f64,
    /// Amplitude of the mode, m.
    pub amplitude: f64,
    /// Largest deviation of a point from radius, shift and mode, m.
    pub deviation: f64,
}

/// Fits radius, shift and the amplitude of a mode (≥ 2) to the points of a drop's surface.
pub fn fit_mode<const D: usize>(
    points: &[SurfacePoint<D>],
    center: &Vector<D>,
    mode: u32,
) -> Option<Roundness> {
    let sample = |p: &SurfacePoint<D>| {
        let d = p.at - center;
        let r = d.norm();
        let direction = d / r;
        let mut basis = [0.0; 5];
        basis[0] = 1.0;
        basis[1] = mode_shape(mode, &direction);
        (0..D).for_each(|a| basis[2 + a] = direction[a]);
        (p.area, basis, r)
    };
    // In 2D the last entry of the basis is undetermined; a tiny weight sets it to zero.
    let pin = (1e-12, [0.0, 0.0, 0.0, 0.0, 1.0], 0.0);
    let fit = least_squares(points.iter().map(sample).chain([pin]))?;
    let miss = |p: &SurfacePoint<D>| {
        let (_, basis, r) = sample(p);
        (r - (0..5).map(|i| fit[i] * basis[i]).sum::<f64>()).abs()
    };
    let deviation = points.iter().map(miss).fold(0.0, f64::max);
    Some(Roundness { radius: fit[0], amplitude: fit[1], deviation })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::setup::model;
    use meniscus_numerics::grid::Grid;
    use meniscus_numerics::shape::Shape;
    use meniscus_sim::Wall;
    use std::f64::consts::PI;

    fn measured<const D: usize>() -> (f64, Vector<D>, Roundness, Vector<D>) {
        let grid = Grid::<D>::new([28; D], 1.0 / 12.0);
        let center = Vector::from_fn(|a, _| 1.13 + 0.071 * a as f64);
        let shape = Shape::PerturbedBall { center, radius: 0.8, mode: 3, amplitude: 0.05 };
        let lattice = grid.lattice();
        let mut phi = CellField::new(grid, 0.0);
        for (i, value) in phi.data.iter_mut().enumerate() {
            *value = shape.signed_distance(&grid.center(lattice.coordinates(i)));
        }
        let model = model(grid, [[Wall::Open; 2]; D]);
        let points = surface_points(&model, &phi);
        let (volume, centroid) = volume_and_centroid(&model, &phi);
        (volume, centroid, fit_mode(&points, &center, 3).unwrap(), center)
    }

    #[test]
    fn a_mode_is_recovered() {
        let (volume, centroid, fit, center) = measured::<2>();
        assert!((fit.radius - 0.8).abs() < 2e-5 && (fit.amplitude - 0.04).abs() < 2e-5, "{fit:?}");
        assert!((volume - PI * 0.64 * (1.0 + 0.5 * 0.0025)).abs() < 1e-3, "{volume}");
        assert!((centroid - center).norm() < 2e-4, "{centroid} {center}");
        let (_, _, fit, _) = measured::<3>();
        assert!((fit.radius - 0.8).abs() < 1e-4 && (fit.amplitude - 0.04).abs() < 1e-4, "{fit:?}");
    }
}
