//! Drops on long deformable sheets: bending, and the threshold of wrapping.

use crate::measure::{bars, checks_or_failure, line_tracker};
use crate::plate::{Plate, PlateSetup};
use crate::setup::run_to;
use crate::{Case, Check, Mode};
use meniscus_sim::StepError;
use std::f64::consts::{FRAC_PI_2, PI};

/// Open sheets.
pub const OPEN: Case = Case {
    name: "soft-sheet",
    title: "A drop on a soft sheet: wetted length and slope of the sheet's ends",
    theory: "2D, no gravity: a drop (area π, radius R0 = 1, γ = ρ = 1, ν = 0.5) on a free sheet 6.4 long of \
        bending stiffness B = γ L². Its lines lift the sheet, its pressure presses: wetted length and slope of \
        the dry ends by the theory of sheets without thickness, κ = (r² − ρ²)/2rL² where the sheet is ρ away \
        from the centre of the free surface, an arc of radius r. Sheets of 4 cells, 16 cells a unit, t/R0 = \
        0.25 (with that thickness in the theory: slopes up to 4.3 % more, lengths 0.2 %).",
    quick: true,
    run: |mode| checks_or_failure("soft-sheet", open(mode)),
};

/// The threshold of wrapping.
pub const WRAP: Case = Case {
    name: "soft-wrapping",
    title: "From what size on a soft sheet wraps up a drop",
    theory: "2D, no gravity: the same drop and sheet. Above a threshold of R0/L, L = √(B/γ), no open state of \
        that theory exists: at 0.9 times it the sheet stays open, at 1.1 times it wraps the drop, its ends \
        beyond 90 degrees. Sheets of 4 cells, 16 cells a unit, t/R0 = 0.25 (with that thickness in the theory \
        the thresholds are 6 % lower).",
    quick: true,
    run: |mode| checks_or_failure("soft-wrapping", wrap(mode)),
};

/// R0/L, contact angle (degrees), wetted length over R0, slope of the ends (degrees).
const OPEN_SHEETS: [(f64, f64, f64, f64); 9] = [
    (0.25, 45.0, 4.7117, 4.766),
    (0.25, 60.0, 3.9603, 4.089),
    (0.25, 75.52, 3.3586, 3.270),
    (0.25, 120.0, 1.9562, 0.987),
    (0.5, 45.0, 4.7747, 20.956),
    (0.5, 60.0, 4.1048, 18.234),
    (0.5, 75.52, 3.5279, 14.659),
    (0.5, 90.0, 3.0327, 11.013),
    (0.5, 120.0, 2.0389, 4.263),
];
/// Contact angle (degrees), threshold of R0/L.
const THRESHOLDS: [(f64, f64); 7] = [
    (45.0, 0.729),
    (60.0, 0.750),
    (75.52, 0.791),
    (90.0, 0.855),
    (105.0, 0.959),
    (120.0, 1.128),
    (135.0, 1.423),
];
const CELLS: usize = 16;
/// Length of the ends where the slope is measured.
const END_LENGTH: f64 = 0.5;

/// A drop on a sheet with R0/L = `ratio`.
fn plate_setup(angle: f64, ratio: f64) -> PlateSetup {
    PlateSetup {
        length: 6.4,
        thickness: 4.0 / CELLS as f64,
        bending: ratio.powi(-2),
        damping: 1.0,
        area: PI,
        viscosity: 0.5,
        domain_and_plate_height: [6.4, 2.2],
        ..PlateSetup::free(CELLS, angle)
    }
}

fn open(mode: Mode) -> Result<Vec<Check>, StepError> {
    let rows: &[_] = if mode == Mode::Quick { &OPEN_SHEETS[4..5] } else { &OPEN_SHEETS };
    let mut checks = Vec::new();
    for &(ratio, angle, wetted, slope) in rows {
        let mut plate = plate_setup(angle, ratio).start()?;
        let tracker = line_tracker(&plate.sim);
        let found = plate.mean_over_last_fifth(25.0, |p| p.end_slope(END_LENGTH).to_degrees())?;
        let text = |what: &str| format!("{what}, R0/L = {ratio}, θ = {angle}°, {CELLS} cells/R0");
        let long = plate.wetted_length(&tracker);
        checks.extend([
            Check::relative("soft-sheet", text("wetted length / R0"), long, wetted, bars(0.1, 0.04)),
            Check::relative("soft-sheet", text("slope of the ends"), found, slope, bars(0.1, 0.04))
                .in_unit("°"),
        ]);
    }
    Ok(checks)
}

fn wrap(mode: Mode) -> Result<Vec<Check>, StepError> {
    let rows: &[_] = if mode == Mode::Quick { &THRESHOLDS[3..4] } else { &THRESHOLDS };
    let mut checks = Vec::new();
    for &(angle, threshold) in rows {
        for (part, wraps) in [(0.9, 0.0), (1.1, 1.0)] {
            let mut plate = plate_setup(angle, part * threshold).start()?;
            let value = if ends_wrapped(&mut plate)? { 1.0 } else { 0.0 };
            let text = format!("wraps at {part} times the threshold, θ = {angle}°");
            checks.push(Check::absolute("soft-wrapping", text, value, wraps, bars(0.0, 0.0)));
        }
    }
    Ok(checks)
}

/// Whether the sheet's ends rise beyond 90 degrees.
fn ends_wrapped(plate: &mut Plate) -> Result<bool, StepError> {
    for time in 1..=40 {
        run_to(&mut plate.sim, f64::from(time), |_, _| ())?;
        if plate.end_slope(END_LENGTH) > FRAC_PI_2 {
            return Ok(true);
        }
    }
    Ok(false)
}
