//! Evaluates the `[expect]` section at the end of a run from the files in its folder.

mod series;

use crate::error::SceneError;
use crate::file::{Deflection, Expect, Scene, SeriesBound, Side, WALLS, Wetted, expect_entry};
use crate::output::solid_columns;
use crate::output::summary::{SolidSummary, Summary, Verdict};
use crate::output::time_series::{COLUMNS, TimeSeries, force_columns};
use crate::units::{format_four_digits, format_si};
use series::{bounded_value, energy_growth, quantity, tip_period};
use std::f64::consts::FRAC_PI_2;

pub use series::period;

/// Wetted share from which a surface counts as fully wetted; cells at a gap to the floor may count as dry.
const FULLY_WETTED_SHARE: f64 = 0.98;
/// Ratio of the liquid's force to the contact force on a solid, above which the liquid carries it.
const FLOATING_FORCE_RATIO: f64 = 10.0;

/// Overlap depth, in cells, that is tolerated between touching solids.
const OVERLAP_TOLERANCE_CELLS: f64 = 0.01;

/// Evaluates every expectation of a scene and, where solids deform, the invariants: no element is inverted and nothing overlaps.
pub fn evaluate(scene: &Scene, summary: &Summary, series: &TimeSeries) -> Vec<Verdict> {
    let expect = &scene.expect;
    let mut verdicts = of_run(expect, summary, series);
    verdicts.extend(of_liquid(expect, summary));
    verdicts.extend(of_solids(expect, summary));
    verdicts.extend(expect.series.iter().map(|bound| of_column(bound, series)));
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
    about("series", &mut expect.series.iter().map(|bound| bound.column.clone()));
    names
}

/// Checks that a run of the scene writes the columns that are expected.
///
/// # Errors
/// [`SceneError`] at the name of a column that a run of the scene does not write.
pub fn ensure_columns(scene: &Scene) -> Result<(), SceneError> {
    let solids = || scene.solids.iter().map(|s| (s.name.as_str(), s.material.deforms()));
    let mut columns: Vec<String> = COLUMNS.iter().map(|name| (*name).to_owned()).collect();
    columns.extend(solids().flat_map(|(name, _)| force_columns(name)));
    columns.extend(solids().flat_map(|(name, deforms)| solid_columns(name, scene.domain.dimension, deforms)));
    let count = scene.expect.series.len();
    for (i, bound) in scene.expect.series.iter().enumerate() {
        if !columns.contains(&bound.column) {
            let error =
                SceneError::new(format!("the time series has no column `{}`", bound.column.escape_debug()));
            let error = error.with_help(format!("columns of this scene: {}", columns.join(", ")));
            let path = format!("{}.column", expect_entry("series", count, i));
            return Err(scene.source.at_value(error, &path));
        }
    }
    Ok(())
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

/// A bounded value of a column, without unit.
fn of_column(bound: &SeriesBound, series: &TimeSeries) -> Verdict {
    let value = bounded_value(series, bound);
    let [min, max] = [bound.min, bound.max];
    let bar = match (min, max) {
        (Some(min), Some(max)) => format!("{} to {}", format_value(min, ""), format_value(max, "")),
        (Some(min), None) => format!("at least {}", format_value(min, "")),
        (None, max) => format!("at most {}", format_value(max.unwrap_or(f64::INFINITY), "")),
    };
    let is_within = |v: f64| min.is_none_or(|min| v >= min) && max.is_none_or(|max| v <= max);
    Verdict { quantity: quantity(bound), bar, value, unit: String::new(), pass: value.is_some_and(is_within) }
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
