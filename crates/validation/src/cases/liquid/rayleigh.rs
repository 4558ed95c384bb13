//! Oscillating drops: frequency, damping, step length, viscosity.

use crate::measure::{at_least, at_most, bars, checks_or_failure, convergence_order, fit_oscillation};
use crate::setup::{DropHistory, DropRun, RADIUS, TENSION, rayleigh_frequency, run_drop};
use crate::{Case, Check, Mode};
use meniscus_sim::StepError;
use meniscus_sim::{Compiled, Simulation};
use std::f64::consts::TAU;

/// Relative amplitude of the perturbation, and the smaller one for convergence, as the theory is linear.
const AMPLITUDE: f64 = 0.02;
const SMALL_AMPLITUDE: f64 = 0.005;

const THEORY: &str = "A drop r = R(1 + ε cos nθ) (2D) or R(1 + ε P_n) (3D), R = 0.5, ε = 0.02, γ = 100, ρ = 1, ν = 0, \
    released at rest, oscillates with ω² = n(n² − 1)γ/ρR³ or n(n − 1)(n + 2)γ/ρR³ (Rayleigh 1879) and loses nothing. \
    Frequency and loss come from a damped oscillation fitted to the mode's amplitude. Order of convergence of the \
    frequency from three grids (2D: 8, 16, 32, 3D: 8, 12, 16 cells per radius), ε = 0.005: at 0.02 the frequency is \
    0.05 % lower on 16 and on 32 cells alike (2D), which is the finite amplitude and no error of the grid. Full: 16 cells per radius; quick: n = 2 \
    with 8 and, in 2D only, n = 3 with 12 cells per radius (8 are 17 per wave of n = 3), bars 4 % and 15 %, 2D \
    order from 6, 8 and 12 cells.";

/// In 2D.
pub const CASE_2D: Case = Case {
    name: "rayleigh-2d",
    title: "Oscillating drop, 2D",
    theory: THEORY,
    quick: true,
    run: |mode| checks_or_failure("rayleigh-2d", modes::<2>("rayleigh-2d", mode)),
};

/// In 3D.
pub const CASE_3D: Case = Case {
    name: "rayleigh-3d",
    title: "Oscillating drop, 3D",
    theory: THEORY,
    quick: true,
    run: |mode| checks_or_failure("rayleigh-3d", modes::<3>("rayleigh-3d", mode)),
};

/// Long steps.
pub const STEPS: Case = Case {
    name: "step-length",
    title: "Oscillating drop with long steps",
    theory: "The frequency of the mode n = 2 (see rayleigh-2d) with steps of 0.5, 5 and 20 times the explicit \
        capillary limit, and no blow-up up to 40 times. Full: 16 cells per radius in 2D, 12 in 3D; quick: 8 cells per \
        radius, 2D, bars twice as wide.",
    quick: true,
    run: |mode| checks_or_failure("step-length", steps(mode)),
};

/// Viscous decay.
pub const LAMB: Case = Case {
    name: "lamb-decay",
    title: "Viscous decay of an oscillating drop",
    theory: "A slightly viscous drop's mode n decays at the rate 2n(n − 1)ν/R² (2D) or (n − 1)(2n + 1)ν/R² (3D) (Lamb, \
        Hydrodynamics, 1932); here n = 2, ν = 0.01: 0.16 and 0.20 per second. The theory is the limit of small ν; \
        the next order is about 2 % here. Numerical damping grows with the step: full: 16 cells per radius, steps of \
        half the explicit limit; quick: 2D at 8 cells per radius, where \
        numerical damping shows, bar 50 %.",
    quick: false,
    run: |mode| checks_or_failure("lamb-decay", lamb(mode)),
};

/// Relaxation of very viscous drops.
pub const STOKES: Case = Case {
    name: "stokes-relaxation",
    title: "A very viscous drop becomes round",
    theory: "A drop whose viscosity outweighs its inertia (ν = 100, an Ohnesorge number of 14) loses the mode n = 2 at the \
        rate γ/ρνR in 2D (R. Hopper, 'Plane Stokes flow driven by capillarity on a free surface', J. Fluid Mech. 213 (1990) \
        349) and 20γ/19ρνR in 3D (W. Reid, 'The oscillations of a viscous liquid drop', Q. Appl. Math. 18 (1960) 86). Rate \
        from one to two relaxation times; steps of 1, 5 and 20 times the explicit capillary limit in 2D, 5 in 3D: ν dt/Δ² of 18, \
        88 and 353. 12 cells per radius; quick: 2D, steps of 5 limits.",
    quick: true,
    run: |mode| checks_or_failure("stokes-relaxation", relaxation(mode)),
};

/// Frequency and loss per period of a run.
struct OscillationResult {
    frequency: f64,
    loss: f64,
    decay: f64,
    growth: f64,
    history: DropHistory,
}

fn measure_oscillation<const D: usize>(
    cells: usize,
    n: u32,
    amplitude: f64,
    step: f64,
    periods: f64,
    nu: f64,
) -> Result<OscillationResult, StepError>
where
    Simulation<D>: Compiled<D>,
{
    let omega = rayleigh_frequency::<D>(n);
    let time = periods * TAU / omega;
    let run = DropRun { cells, mode: n, amplitude, viscosity: nu, step, time };
    let history = run_drop::<D>(&run)?;
    let growth = history.amplitudes.iter().fold(0.0f64, |m, a| m.max(a.abs())) / amplitude;
    let fit = fit_oscillation(&history.times, &history.amplitudes, omega);
    let (frequency, decay) = fit.map_or((f64::NAN, f64::NAN), |f| (f.omega, f.decay));
    Ok(OscillationResult { frequency, decay, loss: 1.0 - (-decay * TAU / omega).exp(), growth, history })
}

/// The frequency of mode 2 of a drop of 12 cells per radius in 3D over Rayleigh's, less one, with steps of a multiple of the explicit limit.
pub(crate) fn frequency_error(step: f64) -> Result<f64, StepError> {
    let periods = 1.0 + 0.25 * f64::min(step, 4.0);
    let tone = measure_oscillation::<3>(12, 2, AMPLITUDE, step, periods, 0.0)?;
    Ok(tone.frequency / rayleigh_frequency::<3>(2) - 1.0)
}

fn modes<const D: usize>(name: &str, mode: Mode) -> Result<Vec<Check>, StepError>
where
    Simulation<D>: Compiled<D>,
{
    let quick = mode == Mode::Quick;
    let (step, periods) = if D == 2 { (0.5, 3.0) } else { (2.0, 1.5) };
    let [of_frequency, of_loss] = if quick { [0.04, 0.15] } else { [0.015, 0.05] };
    let mut checks = Vec::new();
    for (n, coarse) in [(2, 8), (3, 12)] {
        if quick && D == 3 && n == 3 {
            continue;
        }
        let cells = if quick { coarse } else { 16 };
        let omega = rayleigh_frequency::<D>(n);
        let tone = measure_oscillation::<D>(cells, n, AMPLITUDE, step, periods, 0.0)?;
        let frequency = format!("frequency, n = {n}");
        checks.push(
            Check::relative(name, frequency, tone.frequency, omega, bars(of_frequency, 0.005))
                .in_unit("rad/s"),
        );
        let loss = format!("loss of amplitude per period, n = {n}");
        checks.push(at_most(name, loss, tone.loss, bars(of_loss, 0.02)));
        if n == 2 {
            let volume = tone.history.volume_error;
            checks.push(at_most(name, "volume error", volume, bars(1e-4, 1e-8)));
        }
    }
    if D == 2 || !quick {
        checks.push(order::<D>(name, quick)?);
    }
    Ok(checks)
}

/// Order of convergence of the frequency of n = 2, with steps proportional to the cells.
fn order<const D: usize>(name: &str, quick: bool) -> Result<Check, StepError>
where
    Simulation<D>: Compiled<D>,
{
    let grids: [usize; 3] = match (D, quick) {
        (2, false) => [8, 16, 32],
        (2, true) => [6, 8, 12],
        _ => [8, 12, 16],
    };
    let omega = rayleigh_frequency::<D>(2);
    let mut errors = Vec::new();
    for cells in grids {
        let (step, periods) = if D == 2 { (0.5, 2.0) } else { (2.0, 1.25) };
        let tone = measure_oscillation::<D>(cells, 2, SMALL_AMPLITUDE, step, periods, 0.0)?;
        errors.push((RADIUS / cells as f64, tone.frequency / omega - 1.0));
    }
    let list: Vec<String> = errors.iter().map(|(_, e)| format!("{:+.2} %", 100.0 * e)).collect();
    let quantity = format!("order of convergence, n = 2 (errors {})", list.join(", "));
    Ok(at_least(name, quantity, convergence_order(&errors), 1.3, 1.8))
}

fn steps(mode: Mode) -> Result<Vec<Check>, StepError> {
    let name = "step-length";
    if mode == Mode::Quick {
        return steps_in::<2>(name, 8, 2.0);
    }
    let mut checks = steps_in::<2>(name, 16, 1.0)?;
    checks.extend(steps_in::<3>(name, 12, 1.0)?);
    Ok(checks)
}

fn steps_in<const D: usize>(name: &str, cells: usize, wider: f64) -> Result<Vec<Check>, StepError>
where
    Simulation<D>: Compiled<D>,
{
    let omega = rayleigh_frequency::<D>(2);
    let mut checks = Vec::new();
    for (step, must, aim) in [(0.5, 0.02, 0.01), (5.0, 0.03, 0.01), (20.0, 0.05, 0.02), (40.0, 0.0, 0.0)] {
        let periods = if D == 2 { 3.0 } else { 1.0 + 0.25 * f64::min(step, 4.0) };
        let tone = measure_oscillation::<D>(cells, 2, AMPLITUDE, step, periods, 0.0)?;
        if must > 0.0 {
            let quantity = format!("frequency, {D}D, steps {step} × the limit");
            let frequency = tone.frequency;
            checks.push(
                Check::relative(name, quantity, frequency, omega, bars(wider * must, aim)).in_unit("rad/s"),
            );
        }
        let quantity = format!("largest amplitude over the first, {D}D, steps {step} × the limit");
        checks.push(Check::absolute(name, quantity, tone.growth, 1.0, bars(0.1, 0.02)));
    }
    Ok(checks)
}

fn lamb(mode: Mode) -> Result<Vec<Check>, StepError> {
    let (name, nu) = ("lamb-decay", 0.01);
    let unit = nu / (RADIUS * RADIUS);
    if mode == Mode::Quick {
        let plane = measure_oscillation::<2>(8, 2, AMPLITUDE, 1.0, 4.0, nu)?;
        return Ok(vec![
            Check::relative(name, "decay rate, 2D", plane.decay, 4.0 * unit, bars(0.5, 0.03)).in_unit("1/s"),
        ]);
    }
    let plane = measure_oscillation::<2>(16, 2, AMPLITUDE, 0.5, 6.0, nu)?;
    let space = measure_oscillation::<3>(16, 2, AMPLITUDE, 0.5, 2.0, nu)?;
    Ok(vec![
        Check::relative(name, "decay rate, 2D", plane.decay, 4.0 * unit, bars(0.1, 0.03)).in_unit("1/s"),
        Check::relative(name, "decay rate, 3D", space.decay, 5.0 * unit, bars(0.1, 0.03)).in_unit("1/s"),
    ])
}

fn relaxation(mode: Mode) -> Result<Vec<Check>, StepError> {
    if mode == Mode::Quick {
        return Ok(vec![relaxes::<2>(5.0)?]);
    }
    Ok(vec![relaxes::<2>(1.0)?, relaxes::<2>(5.0)?, relaxes::<2>(20.0)?, relaxes::<3>(5.0)?])
}

/// The rate at which a very viscous drop loses mode 2 over that of the theory.
fn relaxes<const D: usize>(step: f64) -> Result<Check, StepError>
where
    Simulation<D>: Compiled<D>,
{
    let viscosity = 100.0;
    let rate = TENSION / (viscosity * RADIUS) * if D == 2 { 1.0 } else { 20.0 / 19.0 };
    let run = DropRun { cells: 12, mode: 2, amplitude: AMPLITUDE, viscosity, step, time: 2.0 / rate };
    let DropHistory { times, amplitudes, .. } = run_drop::<D>(&run)?;
    let middle = times.partition_point(|t| *t < 1.0 / rate);
    let last = times.len() - 1;
    let found = (amplitudes[middle] / amplitudes[last]).ln() / (times[last] - times[middle]);
    let what = format!("rate of relaxation over that of Stokes flow, {D}D, steps {step} × the limit");
    Ok(Check::relative("stokes-relaxation", what, found / rate, 1.0, bars(0.05, 0.01)))
}
