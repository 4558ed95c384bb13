//! The closest point of a ball with one surface mode.
//!
//! Both dimensions reduce to a plane curve $r(\theta)$ in polar coordinates: in 3D in the plane through the vertical axis
//! and the point, with $\theta$ from the axis. The closest point minimises $f(\theta) = \tfrac12 |c(\theta) - p|^2$. The
//! angles at which it can lie are sampled, and the best sample is refined by Newton's iteration.

use crate::Vector;
use std::f64::consts::PI;

/// Maximum number of Newton iterations.
const MAX_NEWTON_ITERATIONS: usize = 40;
/// Maximum number of halvings of a Newton step: it is below rounding after so many.
const MAX_STEP_HALVINGS: usize = 60;

/// A point of the curve, near the point sought.
#[derive(Clone, Copy)]
struct Sample {
    /// Its angle $\theta$.
    angle: f64,
    /// Half its squared distance $f(\theta)$, m².
    value: f64,
}

/// The curve $r(\theta) = R (1 + \varepsilon\, m(\theta))$.
pub(super) struct PolarCurve {
    radius: f64,
    mode: u32,
    amplitude: f64,
    legendre: bool,
}

impl PolarCurve {
    /// The curve of `Shape::PerturbedBall`.
    pub fn new<const D: usize>(radius: f64, mode: u32, amplitude: f64) -> Self {
        Self { radius, mode, amplitude, legendre: D == 3 }
    }

    /// Distance from `d`, measured from the centre, to the surface, negative inside, m.
    pub fn signed_distance<const D: usize>(&self, d: &Vector<D>) -> f64 {
        let p = if D == 2 { [d[0], d[1].abs()] } else { [d[D - 1], d[0].hypot(d[1])] };
        let (angle, reach) = (p[1].atan2(p[0]), p[0].hypot(p[1]));
        let gap = reach - self.r(angle);
        let distance = self.distance(p, angle, gap.abs());
        if gap < 0.0 { -distance } else { distance }
    }

    /// Distance from a point to the curve, whose point at `angle` is `gap` away.
    fn distance(&self, p: [f64; 2], angle: f64, gap: f64) -> f64 {
        let norm = p[0].hypot(p[1]);
        // All points nearer than `gap` lie within this angle of the ray through p.
        let window = if gap < norm { (gap / norm).asin() } else { PI };
        let samples = (window * f64::from(8 * self.mode.max(2)) / PI).ceil().clamp(1.0, 4096.0);
        let h = window / samples;
        let mut best = Sample { angle, value: 0.5 * gap * gap };
        for k in 1..=samples as usize {
            for t in [angle - k as f64 * h, angle + k as f64 * h] {
                let r = self.r(t);
                let value = 0.5 * ((r * t.cos() - p[0]).powi(2) + (r * t.sin() - p[1]).powi(2));
                if value < best.value {
                    best = Sample { angle: t, value };
                }
            }
        }
        (2.0 * self.refine(p, best, h.max(1e-9))).sqrt()
    }

    /// Minimum of `f` near a sample by Newton's iteration, with steps halved until `f` descends.
    fn refine(&self, p: [f64; 2], start: Sample, h: f64) -> f64 {
        let Sample { angle: mut t, mut value } = start;
        for _ in 0..MAX_NEWTON_ITERATIONS {
            let [r, r1, r2] = self.derivatives(t);
            let (s, c) = t.sin_cos();
            let gap = [r * c - p[0], r * s - p[1]];
            let tangent = [r1 * c - r * s, r1 * s + r * c];
            let bend = [(r2 - r) * c - 2.0 * r1 * s, (r2 - r) * s + 2.0 * r1 * c];
            let slope = gap[0] * tangent[0] + gap[1] * tangent[1];
            let length = tangent[0] * tangent[0] + tangent[1] * tangent[1];
            let curvature = length + gap[0] * bend[0] + gap[1] * bend[1];
            let newton = if curvature > 1e-3 * length { slope / curvature } else { slope / length };
            let mut step = newton.clamp(-h, h);
            let mut next = self.value(p, t - step);
            for _ in 0..MAX_STEP_HALVINGS {
                if next <= value || step.abs() <= 1e-12 {
                    break;
                }
                step *= 0.5;
                next = self.value(p, t - step);
            }
            if next > value {
                break;
            }
            (value, t) = (next, t - step);
            if step.abs() < 1e-11 {
                break;
            }
        }
        value
    }

    /// Half the squared distance to the curve's point at an angle.
    fn value(&self, p: [f64; 2], t: f64) -> f64 {
        let r = self.r(t);
        0.5 * ((r * t.cos() - p[0]).powi(2) + (r * t.sin() - p[1]).powi(2))
    }

    /// The radius at an angle, m.
    fn r(&self, t: f64) -> f64 {
        if self.legendre {
            self.derivatives(t)[0]
        } else {
            self.radius * (1.0 + self.amplitude * self.mode_cosine(t))
        }
    }

    fn mode_cosine(&self, t: f64) -> f64 {
        (f64::from(self.mode) * t).cos()
    }

    /// The radius and its first and second derivative with respect to the angle, m.
    fn derivatives(&self, t: f64) -> [f64; 3] {
        let m = if self.legendre {
            let (s, c) = t.sin_cos();
            let [p, p1, p2] = legendre(self.mode, c);
            [p, -s * p1, s * s * p2 - c * p1]
        } else {
            let n = f64::from(self.mode);
            [self.mode_cosine(t), -n * (n * t).sin(), -n * n * self.mode_cosine(t)]
        };
        let scale = self.radius * self.amplitude;
        [self.radius + scale * m[0], scale * m[1], scale * m[2]]
    }
}

/// The Legendre polynomial $P_n$ and its first and second derivative.
fn legendre(n: u32, x: f64) -> [f64; 3] {
    let (mut last, mut now) = ([0.0; 3], [1.0, 0.0, 0.0]);
    for k in 0..n {
        let k = f64::from(k);
        let term = |j: usize, lower: f64| {
            ((2.0 * k + 1.0) * (x * now[j] + j as f64 * lower) - k * last[j]) / (k + 1.0)
        };
        let next = [term(0, 0.0), term(1, now[0]), term(2, now[1])];
        (last, now) = (now, next);
    }
    now
}

/// Volume over that of the unperturbed ball. In 3D, with the integral of $P_n^3$ from the Wigner 3j symbol (n
/// n n; 0 0 0): $1 + 3\varepsilon^2/(2n+1) + \varepsilon^3 \tfrac12\int P_n^3$.
pub(super) fn relative_volume<const D: usize>(mode: u32, amplitude: f64) -> f64 {
    if mode == 0 {
        return (1.0 + amplitude).powi(D as i32);
    }
    let square = amplitude * amplitude;
    if D == 2 {
        return 1.0 + 0.5 * square;
    }
    1.0 + 3.0 * square / f64::from(2 * mode + 1) + square * amplitude * cube_mean(mode)
}

/// $\tfrac12 \int_{-1}^{1} P_n^3\,dx$: zero for odd n, else the squared 3j symbol.
fn cube_mean(n: u32) -> f64 {
    if n % 2 == 1 {
        return 0.0;
    }
    let ln = |k: u32| (2..=k).map(|i| f64::from(i).ln()).sum::<f64>();
    (3.0 * ln(n) - ln(3 * n + 1) + 2.0 * (ln(3 * n / 2) - 3.0 * ln(n / 2))).exp()
}
