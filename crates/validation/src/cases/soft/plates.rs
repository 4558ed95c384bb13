//! Drops on deformable solids, against plate theory.

use crate::measure::{at_most, bars, checks_or_failure, line_tracker, soft_motion};
use crate::plate::{Plate, PlateSetup, PlateSupport};
use crate::setup::run_to;
use crate::{Case, Check, Mode};
use meniscus_sim::{Simulation, StepError};

/// Drops that bend plates.
pub const KINK: Case = Case {
    name: "soft-kink",
    title: "A drop bends a thin plate",
    theory: "2D, no gravity: a drop (γ = ρ = 1, area π/2, ν = 0.15) on a plate of bending stiffness B = 20. \
        Its lines lift, its pressure presses: the plate's outer parts are inclined to each other by (2/3) γ \
        sin θ a²/B (small slopes; a is half the wetted width, over which the moment is γ sin θ (a² − x²)/2a), \
        and where one end is clamped the part between stays straight. Plates of 4 to 1.5 cells, 16 cells a \
        unit; quick: 12.",
    quick: true,
    run: |mode| checks_or_failure("soft-kink", kinks(mode)),
};

/// A free strip with a drop.
pub const STRIP: Case = Case {
    name: "soft-strip",
    title: "A soft strip and a drop keep their momentum and their place",
    theory: "2D, no gravity, nothing holds them: a drop (radius 1, γ = ρ = 1, ν = 0.02) out of the middle of a \
        strip 5 long and 4 cells thick, √(B/γ) = 2.3 (it bends by 20 degrees). Momentum and angular momentum \
        over γt and γLt, and the way of the centre of mass.",
    quick: true,
    run: |mode| checks_or_failure("soft-strip", strip(mode)),
};

/// A solid of such stiffness that it does not deform.
pub const STIFF: Case = Case {
    name: "soft-stiff",
    title: "On a stiff elastic plate drops have the angle that they have on a rigid one",
    theory: "2D, no gravity: a drop (area π/2, γ = ρ = 1, ν = 0.3) at rest on a plate clamped at its bottom, elastic (E = 10⁵) \
        and rigid: contact angles. 16 cells a unit; quick: 12.",
    quick: true,
    run: |mode| checks_or_failure("soft-stiff", stiff(mode)),
};

fn kinks(mode: Mode) -> Result<Vec<Check>, StepError> {
    let (cells, layers, angles): (_, &[f64], &[f64]) = match mode {
        Mode::Quick => (12, &[4.0], &[60.0]),
        Mode::Full => (16, &[4.0, 3.0, 2.0, 1.5], &[60.0, 90.0, 120.0]),
    };
    let mut checks = Vec::new();
    for &thick in layers {
        for &angle in angles {
            for (support, length, drop_offset, time, what) in [
                (PlateSupport::Free, 5.6, 0.0, 10.0, "bend of a free plate"),
                (PlateSupport::LeftEnd, 6.0, 0.5, 30.0, "slope of a cantilever's tip"),
            ] {
                let setting = PlateSetup {
                    length,
                    thickness: thick / cells as f64,
                    bending: 20.0,
                    drop_offset,
                    viscosity: 0.15,
                    support,
                    ..PlateSetup::free(cells, angle)
                };
                let a = setting.half_width(angle);
                let exact = 2.0 / 3.0 * angle.to_radians().sin() * a * a / 20.0;
                let (end, left, right) = (0.5 * length, drop_offset - a - 0.2, drop_offset + a + 0.2);
                let value = setting.start()?.mean_over_last_fifth(time, |p| {
                    let tip = p.slope(right, end);
                    if support == PlateSupport::LeftEnd { tip } else { tip - p.slope(-end, left) }
                })?;
                let text = format!("{what}, {thick} cells thick, θ = {angle}°, {cells} cells/R");
                checks.push(Check::relative("soft-kink", text, value, exact, bars(0.08, 0.03)));
            }
        }
    }
    Ok(checks)
}

fn strip(mode: Mode) -> Result<Vec<Check>, StepError> {
    let cells = if mode == Mode::Quick { 10 } else { 14 };
    let mut checks = Vec::new();
    let angles: &[f64] = if mode == Mode::Quick { &[60.0] } else { &[60.0, 90.0, 120.0] };
    for &angle in angles {
        let time = 10.0;
        let setting = PlateSetup {
            thickness: 4.0 / cells as f64,
            bending: 5.5,
            drop_offset: 0.4,
            viscosity: 0.02,
            ..PlateSetup::free(cells, angle)
        };
        let Plate { mut sim, .. } = setting.start()?;
        let sums = |sim: &Simulation<2>| {
            let (books, now) = (sim.diagnostics(), &sim.state.solids[0]);
            let own = soft_motion(sim, 0);
            let mass = own.mass;
            let center = (books.centroid * books.target_volume + now.center_of_mass() * mass)
                / (books.target_volume + mass);
            (
                (books.momentum + own.momentum).norm(),
                (books.angular_momentum[2] + own.angular_momentum[2]).abs(),
                center,
            )
        };
        let (first, dx) = (sums(&sim).2, sim.model.grid.dx);
        let (mut linear, mut angular, mut wander) = (0f64, 0f64, 0f64);
        run_to(&mut sim, time, |sim, _| {
            let (p, l, center) = sums(sim);
            (linear, angular) = (linear.max(p / time), angular.max(l / time));
            wander = wander.max((center - first).norm() / dx);
        })?;
        let what = |text: &str| format!("{text}, θ = {angle}°, {cells} cells/R");
        checks.extend([
            at_most("soft-strip", what("momentum / γt"), linear, bars(1e-8, 1e-12)),
            at_most("soft-strip", what("angular momentum / γRt"), angular, bars(1e-3, 1e-12)),
            at_most("soft-strip", what("way of the centre of mass / Δ"), wander, bars(0.1, 0.01)),
        ]);
    }
    Ok(checks)
}

fn stiff(mode: Mode) -> Result<Vec<Check>, StepError> {
    let (cells, angles): (_, &[f64]) = match mode {
        Mode::Quick => (12, &[60.0]),
        Mode::Full => (16, &[45.0, 60.0, 90.0, 120.0, 135.0]),
    };
    let mut checks = Vec::new();
    for &angle in angles {
        let contact = |support: PlateSupport| {
            let setting = PlateSetup {
                initial_angle: 90.0,
                thickness: 6.0 / cells as f64,
                bending: 1e5,
                support,
                ..PlateSetup::free(cells, angle)
            };
            let mut plate = setting.start()?;
            let tracker = line_tracker(&plate.sim);
            plate.mean_over_last_fifth(15.0, |p| {
                tracker.extract(&p.sim).angle_statistics(None).map_or(0.0, |a| a.0)
            })
        };
        let (soft, rigid) = (contact(PlateSupport::Bottom)?, contact(PlateSupport::Rigid)?);
        let text = format!("contact angle, θ = {angle}°, {cells} cells/R");
        checks.push(Check::absolute("soft-stiff", text, soft, rigid, bars(1.0, 0.5)).in_unit("°"));
    }
    Ok(checks)
}
