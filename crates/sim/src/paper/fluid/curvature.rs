//! The mean curvature of level sets (Section 4.1): `κ = ∇·n`, `n = ∇φ/|∇φ|`.

use meniscus_numerics::Vector;
use meniscus_numerics::grid::Sampler;

/// Curvature `∇·(∇φ/|∇φ|)`, 1/m, of the level set through the centre of a cell, by central differences; at most that of a ball with the
/// radius of a cell, and zero where the gradient vanishes. The cell may lie beyond the grid by one.
pub fn curvature<const D: usize>(phi: &Sampler<'_, D>, dx: f64, at: [isize; D]) -> f64 {
    let value = |steps: [(usize, isize); 2]| {
        let mut cell = at;
        steps.iter().for_each(|(a, step)| cell[*a] += step);
        phi.value(cell) / dx
    };
    let slope: Vector<D> = Vector::from_fn(|a, _| 0.5 * (value([(a, 1), (a, 0)]) - value([(a, -1), (a, 0)])));
    let second = |a: usize, b: usize| {
        if a == b {
            return value([(a, 1), (a, 0)]) - 2.0 * phi.value(at) / dx + value([(a, -1), (a, 0)]);
        }
        let along = |i: isize| value([(a, i), (b, 1)]) - value([(a, i), (b, -1)]);
        0.25 * (along(1) - along(-1))
    };
    let square = slope.norm_squared();
    if square == 0.0 {
        return 0.0;
    }
    let bent: f64 = (0..D).map(|a| (0..D).map(|b| slope[a] * second(a, b) * slope[b]).sum::<f64>()).sum();
    let trace: f64 = (0..D).map(|a| second(a, a)).sum();
    let most = (D - 1) as f64;
    ((trace * square - bent) / (square * square.sqrt())).clamp(-most, most) / dx
}
