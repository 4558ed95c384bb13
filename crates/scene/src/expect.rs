//! Evaluates the `[expect]` section at the end of a run from the files in its folder.

use crate::file::{Deflection, Expect, Scene, Side, WALLS, Wetted};
use crate::output::summary::{SolidSummary, Summary, Verdict};
use crate::output::time_series::TimeSeries;
use crate::units::{format_four_digits, format_si};
use std::f64::consts::FRAC_PI_2;

/// Wetted share from which a surface counts as fully wetted; cells at a gap to the floor may count as dry.
const FULLY_WETTED_SHARE: f64 = 0.98;
/// Ratio of the liquid's force to the contact force on a solid, above which the liquid carries it.
const FLOATING_FORCE_RATIO: f64 = 10.0;

/// Deviation of a tip's height from its mean, over the largest deviation, below which a crossing of the mean counts as noise. Chosen without
/// experiment.
const NOISE_FRACTION: f64 = 0.1;

/// Overlap depth, in cells, that is tolerated between touching solids.
const OVERLAP_TOLERANCE_CELLS: f64 = 0.01;

/// Evaluates every expectation of a scene and, where solids deform, the invariants: no element is inverted and nothing overlaps.
pub fn evaluate(scene: &Scene, summary: &Summary, series: &TimeSeries) -> Vec<Verdict> {
    let expect = &scene.expect;
    let mut verdicts = of_run(expect, summary, series);
    verdicts.extend(of_liquid(expect, summary));
    verdicts.extend(of_solids(expect, summary));
    verdicts.extend(solid_integrity(summary));
    verdicts
}

/// Names of the expectations of a scene, in the order of [`evaluate`]: the key, and after a dot the solid, side or repair that it is about.
pub fn names(expect: &Expect) -> Vec<String> {
    let runs = [
        ("volume_drift", expect.volume_drift.is_some()),
        ("momentum_error", expect.momentum_error.is_some()),
        ("energy_growth", expect.energy_growth.is_some()),
        ("max_speed", expect.max_speed.is_some()),
        ("period", expect.period.is_some()),
        ("frequency", expect.frequency.is_some()),
    ];
    let mut names: Vec<String> =
        runs.into_iter().filter(|(_, given)| *given).map(|(key, _)| key.to_owned()).collect();
    names.extend(expect.repairs.bounds().into_iter().map(|(name, _)| format!("repairs.{name}")));
    names.extend(expect.drops.map(|_| "drops".to_owned()));
    let mut about = |key: &str, whats: &mut dyn Iterator<Item = String>| {
        names.extend(whats.map(|what| format!("{key}.{what}")));
    };
    about("reach", &mut expect.reach.iter().map(|r| format!("{:?}", r.side).to_lowercase()));
    about("contact_angle", &mut expect.contact_angle.iter().map(|e| e.solid.clone()));
    about("floats", &mut expect.floats.iter().cloned());
    about("sinks", &mut expect.sinks.iter().cloned());
    about("wetted", &mut expect.wetted.iter().map(|e| e.solid.clone()));
    about("position", &mut expect.position.iter().map(|e| e.solid.clone()));
    about("deflection", &mut expect.deflection.iter().map(|e| e.solid.clone()));
    names
}

/// The invariants of deformable solids, the last ones of [`evaluate`].
pub fn solid_integrity(summary: &Summary) -> impl Iterator<Item = Verdict> {
    let element = summary.least_element.map(|least| Verdict {
        quantity: "smallest ratio of an element's volume to its volume at rest".into(),
        bar: "above 0".into(),
        value: Some(least),
        unit: String::new(),
        pass: least > 0.0,
    });
    let overlap = summary.deepest_overlap;
    let overlap = overlap
        .map(|_| at_most("deepest overlap of solids", overlap, OVERLAP_TOLERANCE_CELLS * summary.dx, "m"));
    element.into_iter().chain(overlap)
}

/// Bounds of sums and repairs, and the rate of an oscillation.
fn of_run(expect: &Expect, summary: &Summary, series: &TimeSeries) -> Vec<Verdict> {
    let drift = Some(summary.volume_error.abs());
    let speed = series.column("max_speed").last().copied();
    let bounds = [
        expect.volume_drift.map(|bound| at_most("volume drift", drift, bound.max, "")),
        expect.momentum_error.map(|bound| at_most("momentum error", summary.momentum_error, bound.max, "")),
        expect.energy_growth.map(|bound| at_most("energy growth", energy_growth(series), bound.max, "")),
        expect.max_speed.map(|bound| at_most("largest speed at the end", speed, bound.max, "m/s")),
        expect
            .period
            .map(|p| within_tolerance("period", period(series), p.value, p.tolerance * p.value, "s")),
        expect.frequency.as_ref().map(|f| {
            let found = match &f.solid {
                Some(solid) => tip_period(series, solid, summary.dimension),
                None => period(series),
            };
            within_tolerance("frequency", found.map(f64::recip), f.value, f.tolerance * f.value, "Hz")
        }),
    ];
    let repairs = expect.repairs.bounds().into_iter().map(|(name, max)| {
        let value =
            summary.relative_repairs().find(|(found, _)| *found == name).map(|(_, value)| value.abs());
        at_most(&format!("repairs: {name}"), value, max, "")
    });
    bounds.into_iter().flatten().chain(repairs).collect()
}

/// Drops, their reach, and contact angles.
fn of_liquid(expect: &Expect, summary: &Summary) -> Vec<Verdict> {
    let drops = expect.drops.map(|drops| drop_count(summary, drops.range()));
    let reach = expect.reach.iter().map(|r| {
        let quantity = format!("reach towards {:?}", r.side).to_lowercase();
        within_tolerance(&quantity, reach(summary, r.side), r.value, r.tolerance, "m")
    });
    let angles = expect.contact_angle.iter().map(|expected| {
        let found = match solid_named(summary, &expected.solid) {
            Some(solid) => solid.contact_angle,
            None => summary.wall_contact_angle.filter(|_| expected.solid == WALLS),
        };
        let (value, tolerance) =
            (expected.value.unwrap_or(FRAC_PI_2).to_degrees(), expected.tolerance.to_degrees());
        within_tolerance(&format!("contact angle on {}", expected.solid), found, value, tolerance, "deg")
    });
    drops.into_iter().chain(reach).chain(angles).collect()
}

fn of_solids(expect: &Expect, summary: &Summary) -> Vec<Verdict> {
    let floats = expect.floats.iter().map(|solid| floats(summary, solid));
    let sinks = expect.sinks.iter().map(|solid| sinks(summary, solid));
    let wetted = expect.wetted.iter().map(|expected| wetted_share(summary, expected));
    let position = expect.position.iter().map(|expected| {
        let solid = solid_named(summary, &expected.solid);
        let off = solid.map(|s| distance(&s.centroid, &expected.value, expected.along.as_deref()));
        let quantity = format!("distance of {} from its expected position", expected.solid);
        at_most(&quantity, off, expected.tolerance, "m")
    });
    let deflection = expect.deflection.iter().map(|expected| deflection(summary, expected));
    floats.chain(sinks).chain(wetted).chain(position).chain(deflection).collect()
}

/// The solid of this name.
fn solid_named<'a>(summary: &'a Summary, name: &str) -> Option<&'a SolidSummary> {
    summary.solids.iter().find(|s| s.name == name)
}

fn at_most(quantity: &str, value: Option<f64>, max: f64, unit: &str) -> Verdict {
    Verdict {
        quantity: quantity.into(),
        bar: format!("at most {}", format_value(max, unit)),
        value,
        unit: unit.into(),
        pass: value.is_some_and(|v| v <= max),
    }
}

fn within_tolerance(
    quantity: &str,
    value: Option<f64>,
    expected: f64,
    tolerance: f64,
    unit: &str,
) -> Verdict {
    Verdict {
        quantity: quantity.into(),
        bar: format!("{} within {}", format_value(expected, unit), format_value(tolerance, unit)),
        value,
        unit: unit.into(),
        pass: value.is_some_and(|v| (v - expected).abs() <= tolerance),
    }
}

/// Number of drops at the end.
fn drop_count(summary: &Summary, [min, max]: [u32; 2]) -> Verdict {
    let count = summary.drops.len() as f64;
    let bar = if min == max { min.to_string() } else { format_bounds(min, max) };
    let pass = count >= f64::from(min) && count <= f64::from(max);
    Verdict { quantity: "drops".into(), bar, value: Some(count), unit: String::new(), pass }
}

/// Whether the liquid carries a solid that is not fully wetted. The value is its wetted share.
fn floats(summary: &Summary, name: &str) -> Verdict {
    let solid = solid_named(summary, name);
    let up = |force: &[f64]| force.last().copied().unwrap_or(0.0);
    let carried = solid.is_some_and(|s| up(&s.net_force) > FLOATING_FORCE_RATIO * up(&s.contact_force).abs());
    let wetted = solid.map(|s| s.wetted);
    Verdict {
        quantity: format!("wetted share of {name}, which floats"),
        bar: format!("below {FULLY_WETTED_SHARE}, and carried by the liquid alone"),
        value: wetted,
        unit: String::new(),
        pass: carried && wetted.is_some_and(|share| share > 0.0 && share < FULLY_WETTED_SHARE),
    }
}

/// Whether a solid is fully wetted. The value is its wetted share.
fn sinks(summary: &Summary, name: &str) -> Verdict {
    let wetted = solid_named(summary, name).map(|s| s.wetted);
    Verdict {
        quantity: format!("wetted share of {name}, which sinks"),
        bar: format!("at least {FULLY_WETTED_SHARE}"),
        value: wetted,
        unit: String::new(),
        pass: wetted.is_some_and(|share| share >= FULLY_WETTED_SHARE),
    }
}

fn wetted_share(summary: &Summary, expected: &Wetted) -> Verdict {
    let (name, min, max) = (&expected.solid, expected.min.unwrap_or(0.0), expected.max.unwrap_or(1.0));
    let wetted = solid_named(summary, name).map(|s| s.wetted);
    Verdict {
        quantity: format!("wetted share of {name}"),
        bar: format!("{min} to {max}"),
        value: wetted,
        unit: String::new(),
        pass: wetted.is_some_and(|share| share >= min && share <= max),
    }
}

/// Deflection of a solid, m.
fn deflection(summary: &Summary, expected: &Deflection) -> Verdict {
    let (name, min) = (&expected.solid, expected.min.unwrap_or(0.0));
    let max = expected.max.unwrap_or(f64::INFINITY);
    let found = solid_named(summary, name).and_then(|s| s.deflection);
    let bar = match max.is_finite() {
        true => format!("{} to {}", format_value(min, "m"), format_value(max, "m")),
        false => format!("at least {}", format_value(min, "m")),
    };
    let pass = found.is_some_and(|d| d >= min && d <= max);
    Verdict { quantity: format!("deflection of {name}"), bar, value: found, unit: "m".into(), pass }
}

/// Distance of two points, m; along a direction, if there is one.
fn distance(x: &[f64], y: &[f64], along: Option<&[f64]>) -> f64 {
    let off = x.iter().zip(y).map(|(x, y)| x - y);
    match along {
        Some(along) => off.zip(along).map(|(d, a)| d * a).sum::<f64>().abs(),
        None => off.map(|d| d * d).sum::<f64>().sqrt(),
    }
}

fn format_bounds(min: u32, max: u32) -> String {
    if max == u32::MAX { format!("at least {min}") } else { format!("{min} to {max}") }
}

/// A value of an expectation with its unit: at least four digits, with a prefix where the unit takes one.
pub fn format_value(value: f64, unit: &str) -> String {
    match unit {
        "" if value != 0.0 && value.abs() < 0.01 => format!("{value:.2e}"),
        "" => format_four_digits(value),
        "deg" => format!("{} deg", format_four_digits(value)),
        unit => format_si(value, unit),
    }
}

/// Largest rise of the total energy, with the energy that left through open sides, above its initial value, relative to the largest kind
/// of energy at the start.
fn energy_growth(series: &TimeSeries) -> Option<f64> {
    let names = ["kinetic_energy", "surface_energy", "elastic_energy", "potential_energy"];
    let kinds = names.map(|name| series.column(name));
    let left = ["outflow_kinetic_energy", "outflow_stored_energy"].map(|name| series.column(name));
    let left = |row: usize| left.iter().filter_map(|kind| kind.get(row)).sum::<f64>();
    let total = |row: usize| kinds.iter().map(|kind| kind[row]).sum::<f64>() + left(row);
    let rows = kinds.iter().map(|kind| kind.len()).min().filter(|&n| n > 0)?;
    let scale = kinds.iter().map(|kind| kind[0].abs()).fold(0.0, f64::max);
    let start = total(0);
    let growth = (0..rows).map(|row| total(row) - start).fold(0.0, f64::max);
    if scale > 0.0 { Some(growth / scale) } else { None }
}

/// How far the liquid extends towards a side at the end, m.
fn reach(summary: &Summary, side: Side) -> Option<f64> {
    let last = summary.dimension.checked_sub(1)?;
    let (axis, upper) = match side {
        Side::Left => (0, false),
        Side::Right => (0, true),
        Side::Front => (1, false),
        Side::Back => (1, true),
        Side::Bottom => (last, false),
        Side::Top => (last, true),
    };
    let corners = summary.drops.iter().filter_map(|drop| {
        let corner = if upper { &drop.upper } else { &drop.lower };
        corner.get(axis).copied()
    });
    if upper { corners.reduce(f64::max) } else { corners.reduce(f64::min) }
}

/// Period of an oscillation, s: twice the mean distance of the maxima of the kinetic energy, of which each period has two. A maximum lies
/// midway between the crossings of half its height, which noise in a few steps does not move. None with fewer than two maxima.
pub fn period(series: &TimeSeries) -> Option<f64> {
    let (time, energy) = (series.column("time"), series.column("kinetic_energy"));
    let peaks = peaks(time, energy);
    let (first, last) = (peaks.first()?, peaks.last()?);
    let gaps = peaks.len().checked_sub(1).filter(|&n| n > 0)?;
    Some(2.0 * (last - first) / gaps as f64)
}

/// Times of the maxima on both sides of which the curve falls below half of them.
fn peaks(time: &[f64], curve: &[f64]) -> Vec<f64> {
    let mut times = Vec::new();
    let mut start = 0;
    while let Some((top, end)) = next_peak(curve, start) {
        let half = 0.5 * curve[top];
        let rise = (start..top).rev().find(|&i| curve[i] < half);
        if let Some(rise) = rise {
            let before = crossing(time, curve, rise, half);
            let after = crossing(time, curve, end - 1, half);
            times.push(0.5 * (before + after));
        }
        start = end;
    }
    times
}

/// The largest value from `start` on before the curve falls below half of it, and the index where it does so. It must be twice the
/// smallest value before it, so a curve that only falls from the start has no peak.
fn next_peak(curve: &[f64], start: usize) -> Option<(usize, usize)> {
    let (mut valley, mut top) = (start, start);
    for i in start..curve.len() {
        let risen = curve[top] > 2.0 * curve[valley];
        if risen && curve[i] < 0.5 * curve[top] {
            return Some((top, i));
        }
        if !risen && curve[i] <= curve[valley] {
            (valley, top) = (i, i);
        } else if curve[i] > curve[top] {
            top = i;
        }
    }
    None
}

/// Period of the height of a solid's tip, s: the mean time between upward crossings of its mean, from below [`NOISE_FRACTION`] of the
/// largest deviation to above it. None with fewer than two crossings.
fn tip_period(series: &TimeSeries, solid: &str, dimension: usize) -> Option<f64> {
    let axis = if dimension == 2 { "y" } else { "z" };
    let (time, height) = (series.column("time"), series.column(&format!("tip_{solid}_{axis}")));
    let rows = time.len().min(height.len());
    let span = time.get(rows.checked_sub(1)?)? - time[0];
    let area = |i: usize| 0.5 * (height[i] + height[i + 1]) * (time[i + 1] - time[i]);
    let mean = (0..rows - 1).map(area).sum::<f64>() / span;
    let swing = height[..rows].iter().map(|h| (h - mean).abs()).fold(0.0, f64::max);
    let noise = NOISE_FRACTION * swing;
    let (mut crossings, mut below, mut at) = (Vec::new(), false, 0);
    for (i, &h) in height[..rows].iter().enumerate() {
        below |= h < mean - noise;
        if below && h <= mean {
            at = i;
        }
        if below && h > mean + noise {
            crossings.push(crossing(time, height, at, mean));
            below = false;
        }
    }
    let gaps = crossings.len().checked_sub(1).filter(|&n| n > 0)?;
    Some((crossings[gaps] - crossings[0]) / gaps as f64)
}

/// The time between rows `i` and `i + 1` at which the curve takes the value `level`.
fn crossing(time: &[f64], curve: &[f64], i: usize, level: f64) -> f64 {
    let fraction = (level - curve[i]) / (curve[i + 1] - curve[i]);
    time[i] + fraction.clamp(0.0, 1.0) * (time[i + 1] - time[i])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn damped(decay: f64, noise: f64) -> TimeSeries {
        let mut text = String::from("time,kinetic_energy\n");
        let mut random = 1u64;
        for i in 0..400 {
            random = random.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            let t = f64::from(i) * 0.01 + 1e-9 * (random >> 40) as f64;
            let jitter = 1.0 + noise * ((random >> 33) as f64 / 2f64.powi(31) - 0.5);
            text += &format!("{t},{}\n", (-2.0 * decay * t).exp() * (2.0 * t * 2.5).sin().powi(2) * jitter);
        }
        TimeSeries::parse(&text)
    }

    #[test]
    fn period_from_kinetic_energy() {
        let expected = 2.0 * std::f64::consts::PI / 5.0;
        let measured = period(&damped(0.0, 0.0)).unwrap();
        assert!((measured / expected - 1.0).abs() < 1e-3, "{measured} {expected}");
        let measured = period(&damped(0.1, 0.02)).unwrap();
        assert!((measured / expected - 1.0).abs() < 5e-3, "{measured} {expected}");
        assert_eq!(period(&TimeSeries::default()), None);
    }

    #[test]
    fn an_impact_is_no_peak() {
        let mut text = String::from("time,kinetic_energy\n");
        for i in 0..200 {
            let t = f64::from(i) * 0.01;
            let impact = if i < 20 { 5.0 + t } else { 0.0 };
            text += &format!("{t},{}\n", impact + (5.0 * t).sin().powi(2));
        }
        let measured = period(&TimeSeries::parse(&text));
        let expected = 0.4 * std::f64::consts::PI;
        // With 60 samples per maximum, the midpoints of its flanks are off by less than a sample.
        assert!(measured.is_some_and(|m| (m / expected - 1.0).abs() < 5e-3), "{measured:?}");
    }

    #[test]
    fn a_tip_swings_about_its_mean() {
        let mut text = String::from("time,tip_beam_z\n");
        for i in 0..500 {
            let t = f64::from(i) * 1e-4;
            let height = 0.03 - 1e-4 * (-20.0 * t).exp() * (400.0 * t).sin() + 1e-6 * (9e4 * t).sin();
            text += &format!("{t},{height}\n");
        }
        let series = TimeSeries::parse(&text);
        let measured = tip_period(&series, "beam", 3).unwrap();
        let expected = 2.0 * std::f64::consts::PI / 400.0;
        assert!((measured / expected - 1.0).abs() < 5e-3, "{measured} {expected}");
        assert_eq!(tip_period(&series, "leaf", 3), None);
        assert_eq!(tip_period(&TimeSeries::default(), "beam", 3), None);
    }

    #[test]
    fn energy_growth_is_relative() {
        let table = TimeSeries::parse(
            "kinetic_energy,surface_energy,elastic_energy,potential_energy\n0,2,0,0\n1,1.5,0,0\n0,1,1.2,0\n",
        );
        assert_eq!(energy_growth(&table), Some(0.25));
        let bent = TimeSeries::parse(
            "kinetic_energy,surface_energy,elastic_energy,potential_energy\n0,2,0,0\n0,1.5,1.5,0\n",
        );
        assert_eq!(energy_growth(&bent), Some(0.5));
        let drained = TimeSeries::parse(
            "kinetic_energy,surface_energy,elastic_energy,potential_energy,outflow_kinetic_energy,outflow_stored_energy\n\
             0,2,0,0,0,0\n0,1,0,0,1,0.5\n",
        );
        assert_eq!(energy_growth(&drained), Some(0.25));
    }
}
