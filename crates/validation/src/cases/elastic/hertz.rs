//! An elastic ball between two plates, against Hertz's theory.
//!
//! There is no liquid. The references hold for small strains. Cylinder (2D, plane strain, force `P` per length, `E* = E/(1 − ν²)`):
//! half-width of the contact `a² = 4 P R/π E*`, pressure in its middle `2 P/π a`, flattening of each side `δ = P/π E* (2 ln(4R/a) − 1)`
//! (K. L. Johnson, "Contact Mechanics", 1985, eq. 5.57). Ball: `a³ = 3 F R/4 E*`, `3 F/2 π a²`, and `a²/R`, which holds for a half-space.
//! A ball pressed from both sides is flattened less, by its exact solution under both pressures (`ball_flattening_ratio`) by a factor
//! of 0.95 at `a = 0.2 R`.
//!
//! The barrier separates ball and plates by a pressure-dependent part of its activation distance, like a soft layer. That distance is a
//! quarter of a cell, which is made small; the flattening is measured on the ball itself.

use crate::measure::{bars, checks_or_failure};
use crate::setup::{run_to, up};
use crate::soft::SoftMaterial;
use crate::solids_only::{
    ContactMonitor, cube_to_ball, mapped, prescribed_motion, quadratic_cube_mesh, rigid_half_space,
    simulation_without_liquid, soft, vertices,
};
use crate::{Case, Check, Mode};
use meniscus_numerics::Vector;
use meniscus_numerics::grid::Grid;
use meniscus_sim::{Compiled, Simulation, StepError, Wall};
use std::f64::consts::PI;

/// The case.
pub const CASE: Case = Case {
    name: "hertz",
    title: "A soft ball between two plates is flattened as Hertz says",
    theory: "No liquid, no friction. A cylinder (2D) and a ball (3D; E = 1000, ν = 0.3, neo-Hookean) between two rigid plates that come \
        together until the contact is about 0.1 (3D: 0.2) of the radius wide, at rest. From the force on the upper side: half-width of \
        the contact, from the second moment of the pressure; pressure in its middle; flattening of a side: Hertz, in 2D with \
        Johnson's eq. 5.57, in 3D with the exact solution of a ball under both pressures (A. I. Lur'e, 'Three-Dimensional Problems \
        of the Theory of Elasticity', 1964). Meshes that are finer where they touch, 8 (3D: 4) elements along the half-width; \
        cells of a 500th and a 1000th of the radius; quick: 2D, the first of them.",
    quick: true,
    run: |mode| checks_or_failure(NAME, run(mode)),
};

const NAME: &str = "hertz";
const RADIUS: f64 = 1.0;
const YOUNG: f64 = 1000.0;
const POISSON: f64 = 0.3;
const STIFFNESS: f64 = YOUNG / (1.0 - POISSON * POISSON);
const STEP: f64 = 1e-2;
/// Time for the plates to close, and for the ball to come to rest.
const PHASE_DURATIONS: [f64; 2] = [0.4, 0.4];
/// Exponent of the refinement of the mesh towards the contacts.
const GRADING_EXPONENT: f64 = 1.7;

fn run(mode: Mode) -> Result<Vec<Check>, StepError> {
    let mut checks = squeeze::<2>([64; 2], RADIUS / 500.0, 0.1)?;
    if mode == Mode::Full {
        checks.extend(squeeze::<2>([64; 2], RADIUS / 1000.0, 0.1)?);
        checks.extend(squeeze::<2>([64; 2], RADIUS / 1000.0, 0.05)?);
        checks.extend(squeeze::<3>([20, 20, 16], RADIUS / 500.0, 0.2)?);
    }
    Ok(checks)
}

/// The ball between its plates, each of which closes in by `way`.
fn ball_between_plates<const D: usize>(n: [usize; D], dx: f64, way: f64) -> Result<Simulation<D>, StepError>
where
    Simulation<D>: Compiled<D>,
{
    let material = SoftMaterial { young: YOUNG, poisson: POISSON, density: 2.0, damping: 1.0 };
    let graded = |x: &Vector<D>| {
        let across = x.map(|c| c.abs().powf(GRADING_EXPONENT).copysign(c));
        let along = x.map(|c| (1.0 - (1.0 - c.abs()).powf(GRADING_EXPONENT)).copysign(c));
        Vector::from_fn(|a, _| if a + 1 == D { along[a] } else { across[a] })
    };
    let ball = soft(
        mapped(quadratic_cube_mesh(n), |x| cube_to_ball(&graded(x)) * RADIUS),
        material,
        0.0,
        Vec::new(),
    )?;
    let mut solids = vec![ball];
    for side in [-1.0, 1.0] {
        let motion = prescribed_motion(vec![(0.0, up(0.0)), (PHASE_DURATIONS[0], up(-side * way))]);
        let mut plate = rigid_half_space(side * (RADIUS + 0.25 * dx), motion);
        plate.friction = 0.0;
        solids.push(plate);
    }
    let mut simulation = simulation_without_liquid(Grid::new([8; D], dx), solids, Vector::zeros(), STEP);
    // Open sides, so that the domain does not interfere; the grid needs only a few cells.
    simulation.model.walls = [[Wall::Open; 2]; D];
    Ok(Simulation::resume(simulation.model, simulation.state))
}

/// Measures of the contact pressure.
struct PressureMeasure {
    force: f64,
    /// Half-width of the contact.
    half_width: f64,
    /// Pressure in the middle of the contact.
    peak_pressure: f64,
    /// Flattening of a side.
    flattening: f64,
}

fn squeeze<const D: usize>(n: [usize; D], dx: f64, wide: f64) -> Result<Vec<Check>, StepError>
where
    Simulation<D>: Compiled<D>,
{
    let flat = wide * wide * RADIUS * hertz_flattening_ratio::<D>(wide);
    let mut simulation = ball_between_plates(n, dx, flat + 0.1 * dx)?;
    let mut watch = ContactMonitor::new(&simulation.model, STIFFNESS * flat * flat);
    run_to(&mut simulation, PHASE_DURATIONS[0] + PHASE_DURATIONS[1], |s, report| {
        watch.observe(s, &report.diagnostics, s.state.time > PHASE_DURATIONS[0] + 2.0 * STEP);
    })?;
    let Some(found) = measure_contact(&simulation) else { return Ok(Vec::new()) };
    let force = found.force;
    let (width, peak) = if D == 2 {
        let width = (4.0 * force * RADIUS / (PI * STIFFNESS)).sqrt();
        (width, 2.0 * force / (PI * width))
    } else {
        let width = (0.75 * force * RADIUS / STIFFNESS).cbrt();
        (width, 1.5 * force / (PI * width * width))
    };
    let flat = width * width / RADIUS * hertz_flattening_ratio::<D>(width / RADIUS);
    let cells = RADIUS / dx;
    let what = |text: &str| format!("{text}, {D}D, a = {wide} R, {cells} cells/R");
    let mut checks = vec![
        Check::relative(NAME, what("half-width"), found.half_width, width, bars(0.03, 0.01)),
        Check::relative(NAME, what("pressure in the middle"), found.peak_pressure, peak, bars(0.03, 0.01)),
        Check::relative(NAME, what("flattening"), found.flattening, flat, bars(0.03, 0.01)),
        watch.check_gap(NAME, what("narrowest gap / cell"), dx, 0.02),
    ];
    if D == 3 {
        let hertz = 4.0 / 3.0 * STIFFNESS * RADIUS.sqrt() * found.flattening.powf(1.5);
        let told = hertz_flattening_ratio::<D>(width / RADIUS).powf(-1.5);
        let text = what("force / (4/3 E* √R δ^1.5)");
        checks.push(Check::relative(NAME, text, force / hertz, told, bars(0.03, 0.01)));
    }
    Ok(checks)
}

/// The flattening of a side over `a²/R`.
fn hertz_flattening_ratio<const D: usize>(wide: f64) -> f64 {
    // P/π E* = a²/4R in 2D.
    if D == 2 { 0.25 * (2.0 * (4.0 / wide).ln() - 1.0) } else { ball_flattening_ratio(wide) }
}

/// The contact pressure at rest, from the forces of the plates on the nodes: the negative of the elastic forces. Nodes within the solid
/// have none.
///
/// The forces are a pressure in the weak form, `Σ f_v ψ(x_v) = ∫ p ψ dA` for a smooth `ψ`. The pressure in the middle is therefore that of
/// the distribution `p √(1 − r²/a²)` with the same integral under `ψ = (1 − r²/a²)²`: `5π/16 a p` in 2D, `2π/7 a² p` in 3D. The flattening
/// is conjugate to the force by the work of the plates.
fn measure_contact<const D: usize>(simulation: &Simulation<D>) -> Option<PressureMeasure> {
    let elastic = simulation.model.solids[0].elastic()?;
    let now = vertices(simulation, 0);
    let forces = elastic.forces(now);
    let across = |v: usize| now[v].rows(0, D - 1).norm_squared();
    let sum = |side: f64, value: &dyn Fn(usize) -> f64| -> f64 {
        let of_side = (0..now.len()).filter(|v| now[*v][D - 1] * side > 0.0);
        of_side.map(|v| forces[v][D - 1] * side * value(v)).sum()
    };
    let force = sum(1.0, &|_| 1.0);
    // The mean of x² over the pressure is a²/4 in 2D, that of r² 2a²/5 in 3D.
    let half_width = (sum(1.0, &across) / force * if D == 2 { 4.0 } else { 2.5 }).sqrt();
    let test = |v: usize| (1.0 - across(v) / half_width.powi(2)).max(0.0).powi(2);
    let integral = if D == 2 { 5.0 / 16.0 * half_width } else { 2.0 / 7.0 * half_width * half_width };
    let height = |side: f64| sum(side, &|v| now[v][D - 1] * side) / sum(side, &|_| 1.0);
    Some(PressureMeasure {
        force,
        half_width,
        peak_pressure: sum(1.0, &test) / (PI * integral),
        flattening: RADIUS - 0.5 * (height(1.0) + height(-1.0)),
    })
}

/// Flattening of a ball at the poles over that of a half-space, `a²/R`, under Hertz's pressures on caps of radius `a` (over the ball's)
/// about both poles.
///
/// The radial traction is a sum of Legendre polynomials `p_n P_n(cos θ)`. Lur'e's displacements are
/// `u_r = [A (n+1)(n−2+4ν) r^(n+1) + B n r^(n−1)] P_n` with `B = −A (n²+2n−1+2ν)/(n−1)`, so that there is no shear at `r = 1`, and
/// `p_n = 2G A [(n+1)(n²−n−2−2ν) − n (n²+2n−1+2ν)]`.
fn ball_flattening_ratio(a: f64) -> f64 {
    const POINTS: usize = 600;
    const TERMS: usize = 3000;
    let points = (0..POINTS).map(|k| {
        let t = (k as f64 + 0.5) / POINTS as f64 * 0.5 * PI;
        let (s, c) = t.sin_cos();
        let x = (1.0 - a * a * s * s).sqrt();
        // Pressure c on the ring of width dt, whose area is 2π a s · a c/x dt.
        [x, c * a * s * a * c / x * 0.5 * PI / POINTS as f64, 1.0, x]
    });
    let mut points: Vec<[f64; 4]> = points.collect();
    let (nu, double_shear) = (POISSON, 1.0 / (1.0 + POISSON));
    let mut sum = 0.0;
    for degree in 0..TERMS {
        let n = degree as f64;
        let moment: f64 = points
            .iter_mut()
            .map(|[x, weight, before, last]| {
                let value = match degree {
                    0 => 1.0,
                    1 => *x,
                    _ => ((2.0 * n - 1.0) * *x * *last - (n - 1.0) * *before) / n,
                };
                if degree > 1 {
                    (*before, *last) = (*last, value);
                }
                *weight * value
            })
            .sum();
        let pressure = -(2.0 * n + 1.0) * moment;
        if degree == 0 {
            sum += pressure * (1.0 - 2.0 * nu);
        } else if degree % 2 == 0 {
            let shear = n * n + 2.0 * n - 1.0 + 2.0 * nu;
            let share = pressure / double_shear / ((n + 1.0) * (n * n - n - 2.0 - 2.0 * nu) - n * shear);
            sum += share * ((n + 1.0) * (n - 2.0 + 4.0 * nu) - n * shear / (n - 1.0));
        }
    }
    // For a half-space of the same stiffness and unit pressure in the middle it is π a/2 E*.
    -sum / (0.5 * PI * a * (1.0 - nu * nu))
}
