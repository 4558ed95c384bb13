//! Theory of a sheet bent by a drop: an inextensible elastica under pressure and contact-line forces, in 2D without gravity.
//!
//! The equation is `B κ' = −p T·(U − O)`, with the tangent `T` and the curvature `κ` of the sheet, the position `U` of its wetted side,
//! half a thickness above the middle line, the pressure `p`, and the centre `O` of the free surface, an arc of radius `γ/p`. The sheet is
//! symmetric about its middle. γ = 1. Without thickness it becomes `κ = (r² − ρ²)/2rL²` with the distances `r` and `ρ` from `O`.

use meniscus_numerics::{Matrix, Vector};

/// Integration steps of half a sheet.
const SEGMENTS: usize = 400;
/// Most Newton iterations.
const MAX_NEWTON_ITERATIONS: usize = 60;
/// Increment of an unknown for finite differences.
const DIFFERENCE_STEP: f64 = 1e-6;
/// Continuation steps in the thickness.
const CONTINUATION_STEPS: usize = 5;

/// A sheet with a drop on it.
#[derive(Clone, Copy, Debug)]
pub struct Sheet {
    /// Bending stiffness over γ.
    pub bending: f64,
    /// Thickness.
    pub thickness: f64,
    /// Area of the drop.
    pub area: f64,
    /// Contact angle, degrees.
    pub angle: f64,
    /// Half the sheet's length if the line is pinned at its ends; otherwise the line has the contact angle.
    pub pinned_half_length: Option<f64>,
}

/// The unknowns of the boundary value problem.
#[derive(Clone, Copy, Debug)]
pub struct Unknowns {
    /// Pressure over γ.
    pub pressure: f64,
    /// Pressure times the height of the free surface's centre over the sheet's middle, over γ.
    pub scaled_center_height: f64,
    /// Curvature in the middle.
    pub curvature: f64,
    /// Half the length of the middle line from contact line to contact line.
    pub half_length: f64,
}

/// Shape of a sheet.
#[derive(Clone, Copy, Debug)]
pub struct Shape {
    /// End of the middle line at the contact line, relative to its middle.
    pub end: [f64; 2],
    /// Slope there, rad.
    pub slope: f64,
    /// Length of the wetted side.
    pub wetted: f64,
    /// Angle of the liquid with the wetted side, degrees.
    pub apparent: f64,
    /// The unknowns.
    pub unknowns: Unknowns,
    residuals: [f64; 4],
}

impl Sheet {
    /// The equilibrium near a guess; none if there is none. The guess is for a sheet without thickness.
    pub fn shape(&self, guess: &Unknowns) -> Option<Shape> {
        let mut shape = None;
        let mut unknowns = *guess;
        for k in 0..=CONTINUATION_STEPS {
            let part = k as f64 / CONTINUATION_STEPS as f64;
            let found = Self { thickness: part * self.thickness, ..*self }.solve(&unknowns)?;
            unknowns = found.unknowns;
            shape = Some(found);
        }
        shape
    }

    /// Solves by Newton's method with a line search.
    fn solve(&self, guess: &Unknowns) -> Option<Shape> {
        let of = |x: &[f64; 4]| {
            self.integrate(&Unknowns {
                pressure: x[0],
                scaled_center_height: x[1],
                curvature: x[2],
                half_length: x[3],
            })
        };
        let mut x = [guess.pressure, guess.scaled_center_height, guess.curvature, guess.half_length];
        let size = |s: &Shape| s.residuals.iter().map(|m| m.abs()).fold(0.0, f64::max);
        let mut shape = of(&x);
        for _ in 0..MAX_NEWTON_ITERATIONS {
            if size(&shape) < 1e-10 {
                return Some(shape);
            }
            let mut slope = Matrix::<4>::zeros();
            for j in 0..4 {
                let mut moved = x;
                moved[j] += DIFFERENCE_STEP;
                let misses = of(&moved).residuals;
                (0..4).for_each(|i| slope[(i, j)] = (misses[i] - shape.residuals[i]) / DIFFERENCE_STEP);
            }
            let step = slope.lu().solve(&Vector::<4>::from(shape.residuals))?;
            let mut part = 1.0;
            let next = loop {
                let moved = std::array::from_fn(|k| x[k] - part * step[k]);
                let next = of(&moved);
                if size(&next) < size(&shape) || part < 1e-3 {
                    x = moved;
                    break next;
                }
                part *= 0.5;
            };
            shape = next;
        }
        (size(&shape) < 1e-8).then_some(shape)
    }

    /// Integrates the shape for given unknowns (Runge–Kutta of fourth order) and evaluates the residuals.
    fn integrate(&self, u: &Unknowns) -> Shape {
        let up = 0.5 * self.thickness;
        let side = |s: &[f64; 4]| [s[0] - up * s[2].sin(), s[1] + up * s[2].cos()];
        // p (U − O): the internal force over γ, turned by a right angle.
        let arm = |s: &[f64; 4]| {
            let at = side(s);
            [u.pressure * at[0], u.pressure * at[1] - u.scaled_center_height]
        };
        let rate = |s: &[f64; 4]| {
            let (sin, cos) = s[2].sin_cos();
            let [along, over] = arm(s);
            [cos, sin, s[3], -(cos * along + sin * over) / self.bending]
        };
        let h = u.half_length / SEGMENTS as f64;
        let step = |s: &[f64; 4], k: &[f64; 4], part: f64| std::array::from_fn(|i| s[i] + part * h * k[i]);
        let (mut s, mut below, mut wetted) = ([0.0, 0.0, 0.0, u.curvature], 0.0, 0.0);
        for _ in 0..SEGMENTS {
            let k1 = rate(&s);
            let k2 = rate(&step(&s, &k1, 0.5));
            let k3 = rate(&step(&s, &k2, 0.5));
            let k4 = rate(&step(&s, &k3, 1.0));
            let k = std::array::from_fn(|i| (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]) / 6.0);
            let next = step(&s, &k, 1.0);
            let (a, b) = (side(&s), side(&next));
            below += 0.5 * (a[1] + b[1]) * (b[0] - a[0]);
            wetted += (b[0] - a[0]).hypot(b[1] - a[1]);
            s = next;
        }
        let (end, radial) = (side(&s), arm(&s));
        let apparent = radial[1] * s[2].cos() - radial[0] * s[2].sin();
        let opening = radial[0].atan2(radial[1]);
        let (sin, cos) = opening.sin_cos();
        let cap = if sin.abs() > 1e-4 { (opening - sin * cos) / (sin * sin) } else { 2.0 / 3.0 * opening };
        let area = 2.0 * (end[0] * end[1] - below) + end[0] * end[0] * cap;
        let young = self.angle.to_radians().cos();
        let line = match self.pinned_half_length {
            Some(half) => u.half_length - half,
            None => apparent - young,
        };
        let moment = self.bending * s[3] - up * (apparent - young);
        let residuals = [radial[0].hypot(radial[1]) - 1.0, moment, line, area - self.area];
        let apparent = apparent.clamp(-1.0, 1.0).acos().to_degrees();
        Shape { end: [s[0], s[1]], slope: s[2], wetted: 2.0 * wetted, apparent, unknowns: *u, residuals }
    }
}

impl Unknowns {
    /// A guess for a drop with a free line on a nearly flat sheet.
    pub fn nearly_flat(sheet: &Sheet) -> Self {
        let angle = sheet.angle.to_radians();
        let radius = (sheet.area / (angle - angle.sin() * angle.cos())).sqrt();
        let half_length = radius * angle.sin();
        let curvature = 0.5 * half_length * half_length / (radius * sheet.bending);
        Self { pressure: 1.0 / radius, scaled_center_height: -angle.cos(), curvature, half_length }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tables_of_the_design_come_out() {
        for (length, area, p, curvature, x, y, slope, apparent) in [
            (2.0, 0.1, 0.73628, 0.57756, 0.49561, 0.05936, 10.857, 32.26),
            (2.0, 0.3, 1.91670, 1.01586, 0.48626, 0.10424, 19.322, 88.07),
            (3.0, 0.2, 1.20033, 2.50209, 0.42248, 0.23758, 46.296, 76.77),
            (4.0, 0.3, 2.41839, 2.96560, 0.38723, 0.27805, 57.155, 126.62),
            (4.0, 0.1, -0.63213, 7.24810, 0.08201, 0.40407, 115.779, 112.81),
            (5.0, 0.1, 1.50639, 7.01517, 0.07634, 0.39842, 119.629, 126.23),
        ] {
            let bending = f64::powi(length, -2);
            let sheet = Sheet { bending, thickness: 0.0, area, angle: 90.0, pinned_half_length: Some(0.5) };
            // The line force gives the curvature in the middle: B κ₀ = (1 − q²)/2p.
            let q = (1.0 - 2.0 * p * curvature * bending).sqrt();
            let guess = |scaled_center_height: f64| Unknowns {
                pressure: p,
                scaled_center_height,
                curvature,
                half_length: 0.5,
            };
            let near = |s: &Shape| (s.apparent - apparent).abs() < 0.02;
            let found = [q, -q].iter().find_map(|q| sheet.shape(&guess(*q)).filter(near)).unwrap();
            assert!((found.end[0] - x).abs() < 2e-5 && (found.end[1] - y).abs() < 2e-5, "{found:?}");
            assert!((found.slope.to_degrees() - slope).abs() < 2e-3, "{found:?}");
        }
        let sheet = |angle: f64| {
            let area = std::f64::consts::PI;
            Sheet { bending: 4.0, thickness: 0.0, area, angle, pinned_half_length: None }
        };
        for (angle, wetted, slope) in [(45.0, 4.7747, 20.956), (90.0, 3.0327, 11.013), (120.0, 2.0389, 4.263)]
        {
            let found = sheet(angle).shape(&Unknowns::nearly_flat(&sheet(angle))).unwrap();
            assert!((found.wetted - wetted).abs() < 2e-4, "{found:?}");
            assert!((found.slope.to_degrees() - slope).abs() < 5e-3, "{found:?}");
        }
    }
}
