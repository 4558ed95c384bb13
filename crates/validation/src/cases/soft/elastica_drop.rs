//! A drop pinned at the ends of a sheet.

use crate::elastica::{Sheet, Unknowns};
use crate::measure::{bars, bisect, checks_or_failure};
use crate::plate::{Plate, PlateSetup};
use crate::{Case, Check, Mode};
use meniscus_sim::StepError;

/// The case.
pub const CASE: Case = Case {
    name: "elastica-drop",
    title: "A drop on a short soft sheet holds its ends and folds it",
    theory: "2D, no gravity: a drop of area A wets a free sheet of length l = 6 (γ = ρ = 1, ν = 0.5) to its \
        ends, where the line is pinned: places of the ends, seen from the middle, by the theory of the sheet \
        with its thickness (an elastica, B κ' = −p T·(U − O), with the tangent T and the wetted side U of the \
        sheet, the pressure p and the centre O of the free surface; 4 cells, 20 cells a unit, t/l = 0.033; \
        quick: 16, 0.042). And while the drop dries up slowly the sheet folds and opens again below l/L = \
        3.541, L = √(B/γ), and closes above it (by the theory without thickness; with it above 3.57): at 0.9 \
        and at 1.1 times that.",
    quick: false,
    run: |mode| checks_or_failure(NAME, run(mode)),
};

const NAME: &str = "elastica-drop";
const LENGTH: f64 = 6.0;
/// Difference, degrees, between the drop's initial angle on the flat sheet and the contact angle, which pins the line at the ends.
const ANGLE_MARGIN_DEGREES: f64 = 15.0;
/// l/L above which an evaporating drop closes its sheet.
const CLOSING_THRESHOLD: f64 = 3.5412;
/// Initial and final A/l² of the evaporation. At the threshold, 0.14, the sheet reopens or closes. At 1.1 times the threshold its ends
/// meet: the theory with thickness gives 2 x_e/l = 0.33 at 0.11 and 0.15 at 0.08.
const DRYING_AREAS: [f64; 2] = [0.2, 0.08];
/// Duration of the evaporation, and of the observation after it.
const DRYING_TIME: [f64; 2] = [40.0, 10.0];
/// Distance between the ends over l at which the sheet is closing: half of that of the last open state.
const CLOSED_GAP_RATIO: f64 = 0.3;
/// A folded sheet.
struct Folded {
    /// l/L.
    ratio: f64,
    /// A/l².
    area: f64,
    /// For the sheet without thickness: p l/γ, κ l in the middle, and the angle of the liquid with the sheet, degrees.
    pressure: f64,
    curvature: f64,
    apparent: f64,
}

const fn folded(ratio: f64, area: f64, pressure: f64, curvature: f64, apparent: f64) -> Folded {
    Folded { ratio, area, pressure, curvature, apparent }
}

const SHAPES: [Folded; 7] = [
    folded(3.0, 0.2, 1.20033, 2.50209, 76.77),
    folded(2.0, 0.1, 0.73628, 0.57756, 32.26),
    folded(2.0, 0.3, 1.91670, 1.01586, 88.07),
    folded(3.0, 0.1, 0.17480, 1.44347, 31.15),
    folded(4.0, 0.3, 2.41839, 2.96560, 126.62),
    folded(4.0, 0.2, 1.92459, 4.06673, 111.70),
    folded(5.0, 0.2, 2.65753, 4.36529, 130.49),
];

fn run(mode: Mode) -> Result<Vec<Check>, StepError> {
    let (cells, rows): (_, &[_]) = if mode == Mode::Quick { (16, &SHAPES[..1]) } else { (20, &SHAPES) };
    let mut checks = Vec::new();
    for row in rows {
        checks.extend(shape(cells, row)?);
    }
    let parts: &[_] = if mode == Mode::Quick { &[(1.1, 1.0)] } else { &[(0.9, 0.0), (1.1, 1.0)] };
    for &(part, closes) in parts {
        let mut plate = plate_setup(cells, part * CLOSING_THRESHOLD, DRYING_AREAS[0]).start()?;
        let closed = closes_up(&mut plate)?;
        let text = format!("closes at {part} times the threshold, {cells} cells a unit");
        checks.push(Check::absolute(NAME, text, f64::from(u8::from(closed)), closes, bars(0.0, 0.0)));
    }
    Ok(checks)
}

/// A drop on a flat sheet; `ratio` is l/L, `area` A/l².
fn plate_setup(cells: usize, ratio: f64, area: f64) -> PlateSetup {
    let initial_angle = cap_angle(area);
    PlateSetup {
        initial_angle,
        length: LENGTH,
        thickness: 4.0 / cells as f64,
        bending: (LENGTH / ratio).powi(2),
        damping: 1.0,
        area: area * LENGTH * LENGTH,
        viscosity: 0.5,
        domain_and_plate_height: [5.6, 2.2],
        ..PlateSetup::free(cells, initial_angle - ANGLE_MARGIN_DEGREES)
    }
}

/// The angle, degrees, of a cap from the ratio of its area to the square of its width.
fn cap_angle(area: f64) -> f64 {
    let over = |angle: f64| (angle - angle.sin() * angle.cos()) / (2.0 * angle.sin()).powi(2);
    bisect([1e-3, 3.0], 60, |angle| over(angle) < area)[0].to_degrees()
}

fn shape(cells: usize, row: &Folded) -> Result<Vec<Check>, StepError> {
    let Folded { ratio, area, .. } = row;
    let setting = plate_setup(cells, *ratio, *area);
    let Some(told) = theoretical_ends(&setting, row) else { return Ok(Vec::new()) };
    let mut plate = setting.start()?;
    let x = plate.mean_over_last_fifth(20.0, |p| p.ends()[0])?;
    let y = plate.ends()[1];
    let text = |what: &str| format!("{what} of the ends, l/L = {ratio}, A/l² = {area}, {cells} cells a unit");
    let check = |what: &str, value: f64, told: f64| {
        let (value, told) = (value / LENGTH, told / LENGTH);
        Check::relative(NAME, text(what), value, told, bars(0.05, 0.02)).in_unit("l")
    };
    Ok(vec![check("place along", x, told[0]), check("height", y, told[1])])
}

/// Theoretical positions of the ends.
fn theoretical_ends(setting: &PlateSetup, row: &Folded) -> Option<[f64; 2]> {
    let (pressure, curvature) = (row.pressure / LENGTH, row.curvature / LENGTH);
    let (bending, half_length) = (setting.bending, 0.5 * LENGTH);
    let (thickness, area, angle) = (setting.thickness, setting.area, setting.angle);
    let sheet = Sheet { bending, thickness, area, angle, pinned_half_length: Some(half_length) };
    let thin = Sheet { thickness: 0.0, ..sheet };
    // In the middle κ = (1 − q²)/2pB.
    let root = (1.0 - 2.0 * pressure * curvature * bending).max(0.0).sqrt();
    let guesses = [root, -root].map(|scaled_center_height| Unknowns {
        pressure,
        scaled_center_height,
        curvature,
        half_length,
    });
    let right = |g: &&Unknowns| thin.shape(g).is_some_and(|s| (s.apparent - row.apparent).abs() < 0.1);
    sheet.shape(guesses.iter().find(right)?).map(|s| s.end)
}

/// Whether the ends meet while the drop evaporates.
fn closes_up(plate: &mut Plate) -> Result<bool, StepError> {
    let [drying, watched] = DRYING_TIME;
    let mut area = DRYING_AREAS[0];
    while plate.sim.state.time < drying + watched {
        let part = (plate.sim.state.time / drying).min(1.0);
        let next = DRYING_AREAS[0] + (DRYING_AREAS[1] - DRYING_AREAS[0]) * part;
        plate.sim.state.components.iter_mut().for_each(|d| d.target_volume *= next / area);
        area = next;
        plate.sim.step(drying + watched - plate.sim.state.time, &mut |_| ())?;
        if 2.0 * plate.ends()[0] < CLOSED_GAP_RATIO * LENGTH {
            return Ok(true);
        }
    }
    Ok(false)
}
