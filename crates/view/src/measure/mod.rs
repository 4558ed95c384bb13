//! Measurements of a stored frame: contact angles, drops, solids.
//!
//! The only input is an output folder. Angles are measured through the liquid. As in an optical goniometer, the contact angle is
//! that between the solid and a shape fitted to the free surface away from the contact line: a circle or sphere, or an ellipse or
//! spheroid if its residual is clearly smaller. The angles stored with the contact line are reported too.

mod averaging;
mod cap_fit;
mod components;
mod contact;
mod deformed_surface;
mod midline;
mod soft;
mod solid_boundary;
mod solids;
mod stored_line;
mod time_window;

use crate::measure::averaging::{Averaging, vertex_kinds};
use std::path::Path;

use serde::Serialize;

pub use cap_fit::{FitShape, FittedAngle};
pub use midline::Midline;
pub use soft::{Ridge, SoftMeasure};
pub use solids::{ContactInterval, Floating, Forces, SolidMeasure};
pub use stored_line::{AngleAt, LocalAngle};
pub use time_window::{TimeStatistics, TimeWindow};

use crate::error::{Result, ViewError};
use crate::folder::{Frame, RunFolder};
use crate::page::time_series::TimeSeries;
use cap_fit::{CapFit, FittedLine};
use components::Component;
use contact::{LinePoint, WettedPatch};
use solid_boundary::SolidBoundary;

/// Least volume of a measured drop, in cells; smaller drops are only counted.
const MIN_MEASURED_CELLS: f64 = 8.0;

/// Frame and averaging window of a measurement.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MeasureOptions {
    /// Time of the frame, s; the closest frame is taken. `None`: the last frame.
    pub at: Option<f64>,
    /// Length of the averaging window that ends with the frame, s. `None`: a tenth of the simulated time.
    pub window: Option<f64>,
}

/// Measurement of one frame of a run. SI units; in 2D areas are lengths and volumes areas.
#[derive(Clone, Debug, Serialize)]
pub struct Measurement {
    /// Name of the scene.
    pub scene: String,
    /// 2 or 3.
    pub dimension: usize,
    /// Cell size, m.
    pub dx: f64,
    /// Frame number.
    pub frame: u32,
    /// Time of the frame, s, if known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time: Option<f64>,
    /// Averaging window; `None` if the time series has no steps in it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub window: Option<TimeWindow>,
    /// Number of drops by the solver's cell-based count. Liquid connected only inside a solid, or by a film too thin for the stored
    /// surface, is one drop there and several here.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub drops_of_solver: Option<usize>,
    /// Number of drops too small to be measured.
    pub small_drops: usize,
    /// The drops, by decreasing volume.
    pub drops: Vec<ComponentMeasure>,
    /// The solids.
    pub solids: Vec<SolidMeasure>,
}

/// A connected component of the liquid.
#[derive(Clone, Debug, Serialize)]
pub struct ComponentMeasure {
    /// Volume, m³ (2D: m²).
    pub volume: f64,
    /// Centre of mass, m.
    pub centroid: Vec<f64>,
    /// Lower corner of its bounding box, m.
    pub lower: Vec<f64>,
    /// Upper corner of its bounding box, m.
    pub upper: Vec<f64>,
    /// Contacts with solids and walls.
    pub contacts: Vec<ContactMeasure>,
}

/// Contact of a drop with a solid or a wall of the domain.
#[derive(Clone, Debug, Serialize)]
pub struct ContactMeasure {
    /// Name of the solid, or the wall's side: `bottom`, `left`, ….
    pub solid: String,
    /// Whether it is a wall of the domain.
    pub wall: bool,
    /// Contact angle from a fit of the free surface.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub angle: Option<FittedAngle>,
    /// Why there is no fitted angle.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub angle_reason: Option<&'static str>,
    /// The angles stored along the contact line.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub local_angle: Option<LocalAngle>,
    /// Mean distance of the contact line from its centroid, m; `None` without a line.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub base_radius: Option<f64>,
    /// Largest distance between a point of the drop's surface and the solid, m.
    pub height: f64,
    /// Wetted area, m² (2D: m).
    pub contact_area: f64,
}

/// Measures one frame of a run.
///
/// # Errors
/// [`ViewError`], also for a time outside the frames.
pub fn measure(dir: &Path, options: &MeasureOptions) -> Result<Measurement> {
    let folder = RunFolder::open(dir)?;
    let Some(dx) = folder.dx else {
        let summary = dir.join("summary.json");
        let what = if summary.is_file() {
            "the cell width `dx` is missing"
        } else {
            "the file does not exist: is this the output folder of a run?"
        };
        return Err(ViewError::content(&summary, what));
    };
    let frame = frame_at(&folder, options.at)?;
    let series = TimeSeries::load_all(&dir.join("timeseries.csv"))?;
    let window = frame.time.and_then(|time| TimeWindow::of(&series, time, options.window));
    let over = Averaging { series, window };
    if folder.dimension == 2 {
        measure_frame::<2>(&folder, &frame, dx, over)
    } else {
        measure_frame::<3>(&folder, &frame, dx, over)
    }
}

/// The frame closest to a time, or the last one without a time.
fn frame_at(folder: &RunFolder, at: Option<f64>) -> Result<Frame> {
    let last = folder.frame(folder.frame_numbers[folder.frame_numbers.len() - 1])?;
    let Some(at) = at else { return Ok(last) };
    let mut times = Vec::with_capacity(folder.frame_numbers.len());
    for &number in &folder.frame_numbers {
        let Some(time) = folder.time(number)? else {
            return Err(ViewError::content(&folder.dir, format!("the time of frame {number} is not known")));
        };
        times.push(time);
    }
    let (first, end) = (times[0], times[times.len() - 1]);
    // Accept times up to half a frame interval outside the frames.
    let slack = if times.len() > 1 { 0.5 * (end - first) / (times.len() - 1) as f64 } else { 0.0 };
    if !(first - slack..=end + slack).contains(&at) {
        return Err(ViewError::Time { path: folder.dir.clone(), at, first, last: end });
    }
    let nearest = (0..times.len()).min_by(|&i, &j| (times[i] - at).abs().total_cmp(&(times[j] - at).abs()));
    folder.frame(folder.frame_numbers[nearest.unwrap_or(0)])
}

fn measure_frame<const D: usize>(
    folder: &RunFolder,
    frame: &Frame,
    dx: f64,
    over: Averaging,
) -> Result<Measurement> {
    let bodies = SolidBoundary::<D>::all(folder, frame);
    let mesh = solid_boundary::surface::<D>(&frame.liquid);
    let mut drops = Component::all(&mesh, &vertex_kinds(frame));
    let all = drops.len();
    drops.retain(|d| d.volume >= MIN_MEASURED_CELLS * dx.powi(D as i32));
    let lines = stored_line::assign(folder, frame, &drops, &bodies, dx);
    let measured = drops.iter().enumerate();
    let measured = measured.map(|(i, drop)| measure_component(drop, &bodies, &lines[i], dx)).collect();
    let row = frame.time.and_then(|time| time_window::row_at(&over.series, time));
    let counted = row.and_then(|row| over.series.column("drops")?[row]);
    Ok(Measurement {
        solids: solids::measure(folder, frame, &over, &drops, &bodies, dx)?,
        window: over.window,
        drops_of_solver: counted.map(|n| n as usize),
        scene: folder.name(),
        dimension: D,
        dx,
        frame: frame.number,
        time: frame.time,
        small_drops: all - drops.len(),
        drops: measured,
    })
}

fn measure_component<const D: usize>(
    drop: &Component<D>,
    bodies: &[SolidBoundary<D>],
    lines: &[stored_line::StoredLine<D>],
    dx: f64,
) -> ComponentMeasure {
    let patches = contact::patches(drop, bodies, dx);
    let fit = CapFit::of(drop, &patches, bodies, dx);
    let contacts = patches.iter().map(|patch| {
        let stored = &lines[patch.body];
        measure_contact(drop, patch, &bodies[patch.body], fit.as_ref(), stored, dx)
    });
    let (lower, upper) = drop.mesh.bounds();
    let list = |v: &meniscus_numerics::Vector<D>| v.iter().copied().collect::<Vec<f64>>();
    ComponentMeasure {
        volume: drop.volume,
        centroid: list(&drop.centroid),
        lower: list(&lower),
        upper: list(&upper),
        contacts: contacts.collect(),
    }
}

fn measure_contact<const D: usize>(
    drop: &Component<D>,
    patch: &WettedPatch<D>,
    body: &SolidBoundary<D>,
    fit: Option<&CapFit<D>>,
    stored: &stored_line::StoredLine<D>,
    dx: f64,
) -> ContactMeasure {
    // Line for the base radius without a fit. The stored line is preferred: facets locate it only to a cell.
    let line = if stored.points.is_empty() { &patch.line } else { &stored.points };
    let feet = fit.and_then(|fit| fit.intersect(&patch.line, body, dx));
    let area_correction = |feet: &FittedLine<D>| {
        feet.points.iter().zip(&feet.outward_offsets).map(|(p, way)| p.weight * way).sum::<f64>()
    };
    let distances = drop.mesh.positions.iter().filter_map(|x| body.closest(x)).map(|foot| foot.distance);
    ContactMeasure {
        solid: body.name.clone(),
        wall: body.is_wall,
        local_angle: stored.angles(),
        base_radius: base_radius(feet.as_ref().map_or(line, |f| &f.points)),
        height: distances.fold(0.0, f64::max),
        contact_area: patch.area + feet.as_ref().map_or(0.0, area_correction),
        angle_reason: if feet.is_some() {
            None
        } else if patch.line.is_empty() {
            Some("there is no contact line")
        } else if fit.is_none() {
            Some("the free surface is no circle or ellipse (3D: sphere or spheroid) within a tenth of a cell")
        } else {
            Some("the fitted shape does not meet the solid along most of the contact line")
        },
        angle: feet.map(|f| f.angle),
    }
}

/// Mean distance of the points of a line from their centroid, m.
fn base_radius<const D: usize>(line: &[LinePoint<D>]) -> Option<f64> {
    let weight: f64 = line.iter().map(|p| p.weight).sum();
    if weight <= 0.0 || line.len() < 2 {
        return None;
    }
    let middle = line.iter().map(|p| p.at * p.weight).sum::<meniscus_numerics::Vector<D>>() / weight;
    Some(line.iter().map(|p| p.weight * (p.at - middle).norm()).sum::<f64>() / weight)
}
