//! Measurements of solids: floating depth, forces, contact times.

use meniscus_numerics::Vector;
use rayon::prelude::*;
use serde::Serialize;

use std::collections::BTreeMap;

use super::averaging::{Averaging, vertex_kinds};
use super::components::Component;
use super::soft::{self, SoftMeasure};
use super::solid_boundary::SolidBoundary;
use super::time_window::{TimeStatistics, row_at};
use crate::error::Result;
use crate::folder::{Frame, RunFolder};
use crate::page::time_series::TimeSeries;

/// Distance of a wetted vertex from a solid, in cells, below which the liquid touches the solid.
const TOUCHING_CELLS: f64 = 0.75;
/// Distance of the liquid from the domain's sides, in cells, below which it fills the domain as a tank.
const AT_SIDE_CELLS: f64 = 0.5;
/// Share of a tank's surface, farthest from all solids, whose mean height is the undisturbed level.
const UNDISTURBED_SHARE: f64 = 0.25;

/// Measurement of a solid.
#[derive(Clone, Debug, Serialize)]
pub struct SolidMeasure {
    /// Its name.
    pub name: String,
    /// Floating depth, if the liquid fills the domain as a tank.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub floating: Option<Floating>,
    /// Forces of the liquid in the step that ends with the frame. Before the end of the run only their sum is stored.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub forces: Option<Forces>,
    /// Deformation; `None` for a rigid solid.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub soft: Option<SoftMeasure>,
    /// Statistics over the window of the solid's columns in the time series: `force_x`, `angle_left`, `base_radius`, `wetted`,
    /// `deflection`, `tip_x`, …; in the units of those columns.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub window: BTreeMap<String, TimeStatistics>,
    /// Intervals of contact with the liquid, over all frames of the run.
    pub touches: Vec<ContactInterval>,
}

/// Position of a solid relative to the surface of a tank.
#[derive(Clone, Debug, Serialize)]
pub struct Floating {
    /// Height of the undisturbed surface, m.
    pub level: f64,
    /// Height of the middle of the solid's bounding box above it, m.
    pub centre_above_level: f64,
    /// Depth of the lowest point of the solid below it, m.
    pub depth: f64,
}

/// Forces of the liquid on a solid, N (2D: N/m).
#[derive(Clone, Debug, Serialize)]
pub struct Forces {
    /// Total force.
    pub net: Vec<f64>,
    /// Pressure force.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pressure: Option<Vec<f64>>,
    /// Contact-line force.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub line: Option<Vec<f64>>,
}

/// An interval of contact, s. Each end is known to one frame interval.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ContactInterval {
    /// Time of the first frame with contact.
    pub start: f64,
    /// Time of the last frame with contact.
    pub end: f64,
    /// Duration, with each end halfway between a frame with contact and the next one without. `None` if the contact began before the
    /// first frame or continues after the last.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub duration: Option<f64>,
}

/// Measures the solids of a frame.
pub(super) fn measure<const D: usize>(
    folder: &RunFolder,
    frame: &Frame,
    over: &Averaging,
    drops: &[Component<D>],
    bodies: &[SolidBoundary<D>],
    dx: f64,
) -> Result<Vec<SolidMeasure>> {
    let solids: Vec<&SolidBoundary<D>> = bodies.iter().filter(|b| !b.is_wall).collect();
    let touched = contacts_by_frame::<D>(folder, &solids, dx)?;
    let level = undisturbed_level(folder, drops, &solids, dx);
    let series = &over.series;
    let one = |(i, body): (usize, &&SolidBoundary<D>)| {
        let times =
            touched.iter().filter_map(|(time, touched)| Some(((*time)?, touched[i]))).collect::<Vec<_>>();
        Ok(SolidMeasure {
            soft: soft::measure(folder, frame, &body.name, dx)?,
            name: body.name.clone(),
            floating: level.and_then(|level| floating(body, level)),
            forces: forces(folder, frame, &body.name, series),
            window: (over.window.iter().flat_map(|window| window.of_solid(series, &body.name)))
                .filter(|(quantity, _)| D == 3 || quantity != "force_z")
                .collect(),
            touches: contact_intervals(&times),
        })
    };
    solids.iter().enumerate().map(one).collect()
}

/// For each frame its time, and whether liquid touches each solid.
fn contacts_by_frame<const D: usize>(
    folder: &RunFolder,
    solids: &[&SolidBoundary<D>],
    dx: f64,
) -> Result<Vec<(Option<f64>, Vec<bool>)>> {
    if solids.is_empty() {
        return Ok(Vec::new());
    }
    let one = |&number: &u32| {
        let frame = folder.frame(number)?;
        let kinds = vertex_kinds(&frame);
        let wet = || frame.liquid.positions.iter().zip(&kinds).filter(|(_, kind)| **kind > 0);
        let touched = solids.iter().map(|solid| {
            let mesh = frame.solids.get(&solid.name)?;
            let body = SolidBoundary::<D>::solid(&solid.name, &super::solid_boundary::surface(mesh));
            Some(wet().any(|(p, _)| body.is_near(&Vector::from_fn(|a, _| p[a]), TOUCHING_CELLS * dx)))
        });
        Ok((frame.time, touched.map(|t| t.unwrap_or(false)).collect()))
    };
    folder.frame_numbers.par_iter().map(one).collect()
}

/// The intervals of contact in a sequence of frames (time, contact).
fn contact_intervals(frames: &[(f64, bool)]) -> Vec<ContactInterval> {
    let mut out = Vec::new();
    let mut from = 0;
    for part in frames.chunk_by(|a, b| a.1 == b.1) {
        let to = from + part.len();
        if part[0].1 {
            let (start, end) = (part[0].0, part[part.len() - 1].0);
            let before = from.checked_sub(1).map(|i| 0.5 * (frames[i].0 + start));
            let after = frames.get(to).map(|f| 0.5 * (end + f.0));
            out.push(ContactInterval { start, end, duration: before.zip(after).map(|(a, b)| b - a) });
        }
        from = to;
    }
    out
}

/// Forces on a solid: from the summary at the end of the run, otherwise the sum from the time series.
fn forces(folder: &RunFolder, frame: &Frame, name: &str, series: &TimeSeries) -> Option<Forces> {
    forces_at_end(folder, frame, name).or_else(|| {
        let row = row_at(series, frame.time?)?;
        let axes = ["x", "y", "z"].into_iter().take(folder.dimension);
        let of = |axis: &str| series.column(&format!("force_{name}_{axis}"))?[row];
        Some(Forces { net: axes.map(of).collect::<Option<_>>()?, pressure: None, line: None })
    })
}

/// Forces on a solid from the summary, if the frame is at the end of the run.
fn forces_at_end(folder: &RunFolder, frame: &Frame, name: &str) -> Option<Forces> {
    let end = folder.summary.get("simulated_seconds")?.as_f64()?;
    let is_end = frame.time.is_some_and(|t| (t - end).abs() <= 1e-9 * end.abs());
    let solids = folder.summary.get("solids")?.as_array()?;
    let solid = solids.iter().find(|s| s.get("name").and_then(|n| n.as_str()) == Some(name))?;
    let list = |key: &str| -> Option<Vec<f64>> {
        solid.get(key)?.as_array()?.iter().map(serde_json::Value::as_f64).collect()
    };
    let net = list("net_force").filter(|_| is_end)?;
    Some(Forces { net, pressure: list("pressure_force"), line: list("line_force") })
}

/// Height of a tank's undisturbed surface, m: the mean over the quarter of its area horizontally farthest from all solids.
/// `None` if the liquid does not reach the bottom and all sides.
fn undisturbed_level<const D: usize>(
    folder: &RunFolder,
    drops: &[Component<D>],
    solids: &[&SolidBoundary<D>],
    dx: f64,
) -> Option<f64> {
    let domain = folder.domain?;
    let tank = drops.iter().find(|drop| {
        let (low, high) = drop.mesh.bounds();
        let sides =
            (0..D - 1).all(|a| low[a] < AT_SIDE_CELLS * dx && high[a] > domain[a] - AT_SIDE_CELLS * dx);
        sides && low[D - 1] < AT_SIDE_CELLS * dx
    })?;
    let boxes: Vec<_> = solids.iter().filter_map(|s| s.bounds()).collect();
    let away = |x: &Vector<D>| {
        let outside = |(low, high): &(Vector<D>, Vector<D>)| {
            let off = |a: usize| (low[a] - x[a]).max(x[a] - high[a]).max(0.0);
            (0..D - 1).map(|a| off(a).powi(2)).sum::<f64>()
        };
        boxes.iter().map(outside).fold(f64::INFINITY, f64::min)
    };
    let mut parts: Vec<(f64, f64, f64)> = Vec::new();
    for (f, facet) in tank.mesh.facets.iter().enumerate() {
        let area = tank.mesh.area_vector(f)[D - 1];
        if area > 0.0 && facet.iter().all(|&v| tank.kinds[v as usize] == 0) {
            let middle = tank.mesh.corners(f).iter().sum::<Vector<D>>() / D as f64;
            parts.push((away(&middle), middle[D - 1], area));
        }
    }
    parts.sort_by(|a, b| b.0.total_cmp(&a.0));
    let wanted = UNDISTURBED_SHARE * parts.iter().map(|p| p.2).sum::<f64>();
    let (mut height, mut area) = (0.0, 0.0);
    for (_, z, part) in parts {
        if area >= wanted {
            break;
        }
        height += z * part;
        area += part;
    }
    (area > 0.0).then(|| height / area)
}

fn floating<const D: usize>(body: &SolidBoundary<D>, level: f64) -> Option<Floating> {
    let (low, high) = body.bounds()?;
    let up = D - 1;
    Some(Floating { level, centre_above_level: 0.5 * (low[up] + high[up]) - level, depth: level - low[up] })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contact_times_are_known_where_both_ends_are_seen() {
        let row = |text: &str| -> Vec<(f64, bool)> {
            text.chars().enumerate().map(|(i, c)| (0.5 * i as f64, c == '#')).collect()
        };
        assert_eq!(
            contact_intervals(&row("..##.")),
            [ContactInterval { start: 1.0, end: 1.5, duration: Some(1.0) }]
        );
        let open = |start, end| ContactInterval { start, end, duration: None };
        assert_eq!(contact_intervals(&row("#..#")), [open(0.0, 0.0), open(1.5, 1.5)]);
        assert_eq!(contact_intervals(&row("...")), []);
        assert_eq!(contact_intervals(&[]), []);
    }
}
