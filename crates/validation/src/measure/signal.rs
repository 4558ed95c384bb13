//! Oscillations and growth in time series, roots.

use meniscus_numerics::fit::{least_squares, solve};

/// A damped oscillation `e^(−βt) (A cos ωt + B sin ωt) + C`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Oscillation {
    /// Angular frequency ω, rad/s.
    pub omega: f64,
    /// Decay rate β, 1/s.
    pub decay: f64,
    /// Root mean square residual of the fit, relative to the amplitude.
    pub residual: f64,
}

/// Least-squares fit of a damped oscillation with a frequency within a quarter of `guess` (rad/s): the best of a series of undamped ones,
/// refined by the Levenberg–Marquardt method.
pub fn fit_oscillation(times: &[f64], values: &[f64], guess: f64) -> Option<Oscillation> {
    let series = || times.iter().zip(values);
    let misfit = |p: &[f64; 5]| series().map(|(t, v)| (v - damped(p, *t).0).powi(2)).sum::<f64>();
    let mut best: Option<([f64; 5], f64)> = None;
    for k in 0..=50 {
        let omega = guess * (0.75 + 0.01 * f64::from(k));
        let linear = series().map(|(t, v)| (1.0, [(omega * t).cos(), (omega * t).sin(), 1.0], *v));
        let Some(fit) = least_squares(linear) else { continue };
        let p = [fit[0], fit[1], fit[2], 0.0, omega];
        let size = misfit(&p);
        if best.as_ref().is_none_or(|b| size < b.1) {
            best = Some((p, size));
        }
    }
    let (mut p, mut size) = best?;
    let mut damping = 1e-3;
    for _ in 0..200 {
        let mut a = vec![vec![0.0; 5]; 5];
        let mut b = vec![0.0; 5];
        for (t, v) in series() {
            let (value, slope) = damped(&p, *t);
            for i in 0..5 {
                (0..5).for_each(|j| a[i][j] += slope[i] * slope[j]);
                b[i] += slope[i] * (v - value);
            }
        }
        (0..5).for_each(|i| a[i][i] *= 1.0 + damping);
        let step = solve(a, b)?;
        let next = std::array::from_fn(|i| p[i] + step[i]);
        let new = misfit(&next);
        if new < size {
            let done = size - new < 1e-14 * size;
            (p, size, damping) = (next, new, damping * 0.2);
            if done {
                break;
            }
        } else {
            damping *= 5.0;
            if damping > 1e8 {
                break;
            }
        }
    }
    let amplitude = p[0].hypot(p[1]);
    let residual = (size / times.len() as f64).sqrt() / amplitude;
    Some(Oscillation { omega: p[4].abs(), decay: p[3], residual })
}

/// Value and derivatives with respect to A, B, C, β, ω.
fn damped(p: &[f64; 5], t: f64) -> (f64, [f64; 5]) {
    let fade = (-p[3] * t).exp();
    let (s, c) = (p[4] * t).sin_cos();
    let wave = p[0] * c + p[1] * s;
    let turn = t * (p[1] * c - p[0] * s);
    (fade * wave + p[2], [fade * c, fade * s, 1.0, -t * fade * wave, fade * turn])
}

/// The rate σ (1/s) of the best fit `A cosh σt + B sinh σt`, between half and twice `guess`, by golden section.
pub fn fit_growth(times: &[f64], values: &[f64], guess: f64) -> Option<f64> {
    let misfit = |sigma: f64| -> f64 {
        let basis = |t: f64| [(sigma * t).cosh(), (sigma * t).sinh()];
        let fit = least_squares(times.iter().zip(values).map(|(t, v)| (1.0, basis(*t), *v)));
        fit.map_or(f64::INFINITY, |f| {
            let miss = |(t, v): (&f64, &f64)| (v - f[0] * basis(*t)[0] - f[1] * basis(*t)[1]).powi(2);
            times.iter().zip(values).map(miss).sum()
        })
    };
    let (mut low, mut high) = (0.5 * guess, 2.0 * guess);
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    while high - low > 1e-8 * guess {
        let (left, right) = (high - golden * (high - low), low + golden * (high - low));
        if misfit(left) < misfit(right) { high = right } else { low = left }
    }
    (times.len() > 3).then_some(0.5 * (low + high))
}

/// Halves an interval a number of times; `is_low` tells whether what is sought lies above a point.
pub fn bisect([mut low, mut high]: [f64; 2], halvings: usize, is_low: impl Fn(f64) -> bool) -> [f64; 2] {
    for _ in 0..halvings {
        let middle = 0.5 * (low + high);
        if is_low(middle) { low = middle } else { high = middle }
    }
    [low, high]
}

/// The order `p` of errors `≈ C Δ^p`: the slope of the logarithms. Each entry is a cell size and an error.
pub fn convergence_order(errors: &[(f64, f64)]) -> f64 {
    let samples = errors.iter().map(|(dx, e)| (1.0, [1.0, dx.ln()], e.abs().max(1e-300).ln()));
    least_squares(samples).map_or(f64::NAN, |fit| fit[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_oscillation_is_recovered() {
        let times: Vec<f64> = (0..120).map(|i| 0.011 * f64::from(i)).collect();
        let value =
            |t: &f64| 0.02 * (-0.3 * t).exp() * (6.5 * t + 0.2).cos() + 1e-4 + 1e-6 * (91.0 * t).sin();
        let values: Vec<f64> = times.iter().map(value).collect();
        let fit = fit_oscillation(&times, &values, 7.0).unwrap();
        assert!((fit.omega - 6.5).abs() < 1e-3 && (fit.decay - 0.3).abs() < 1e-3, "{fit:?}");
        assert!(fit.residual < 1e-4);
    }

    #[test]
    fn a_growth_rate_is_recovered() {
        let times: Vec<f64> = (0..50).map(|i| 0.02 * f64::from(i)).collect();
        let values: Vec<f64> =
            times.iter().map(|t| 0.01 * (2.7 * t).cosh() - 2e-4 * (2.7 * t).sinh()).collect();
        assert!((fit_growth(&times, &values, 3.0).unwrap() - 2.7).abs() < 1e-6);
        assert!((convergence_order(&[(0.1, 0.02), (0.05, 0.005), (0.025, 0.00125)]) - 2.0).abs() < 1e-12);
    }
}
