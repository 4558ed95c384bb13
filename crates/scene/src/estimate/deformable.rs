//! The part of `meniscus check` about deformable solids.

use super::memory;
use super::scales::longest_step;
use crate::build::{AnySetup, Setup};
use crate::file::{Material, Scene, Solid as SolidSpec};
use crate::units::format_si;
use meniscus_elastic::{Elastic, lowest_modes_to_tolerance};
use meniscus_sim::MIN_PLATE_THICKNESS_CELLS;
use serde::Serialize;
use std::f64::consts::TAU;
use std::fmt::Write as _;

/// Entries of a factor up to which the lowest frequency is computed even if no damping needs it; it takes seconds.
const MAX_ENTRIES_FOR_MODES: usize = 5_000_000;
/// Relative tolerance of the square of the frequency.
const MODE_TOLERANCE: f64 = 1e-3;

/// A deformable solid; SI units, angles in degrees.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SoftReport {
    /// Name of the solid.
    pub solid: String,
    /// Vertices of its mesh.
    pub vertices: usize,
    /// Its triangles (2D) or tetrahedra (3D).
    pub elements: usize,
    /// Anchored vertices, with those of prescribed motion.
    pub held: usize,
    /// Mean length of an edge, m.
    pub edge: f64,
    /// The smallest dihedral angle (2D: angle), degrees.
    pub smallest_angle: f64,
    /// The largest one, degrees.
    pub largest_angle: f64,
    /// The worst radius ratio of an element: 1 for a regular, 0 for a flat one.
    pub worst_radius_ratio: f64,
    /// Mass, kg (2D: kg/m).
    pub mass: f64,
    /// Memory of the solver of its linear systems, bytes.
    pub solver_bytes: f64,
    /// Estimated memory of the solid in all, bytes.
    pub memory_bytes: f64,
    /// Whether the solver factorises the matrix; else it iterates.
    pub factorised: bool,
    /// Speed of elastic waves √((λ + 2μ) / ρ), m/s; approximate for springs.
    pub wave_speed: Option<f64>,
    /// Longest step over the time that a wave takes along an edge.
    pub edges_per_step: Option<f64>,
    /// Lowest frequency, Hz; none where its computation would take long (a `damping_ratio` requests it).
    pub frequency: Option<f64>,
    /// Steps of the longest length per period of that frequency.
    pub steps_per_period: Option<f64>,
    /// Thickness of a plate in cells.
    pub thickness_cells: Option<f64>,
    /// Bending stiffness of a plate per width, N m; approximate for springs.
    pub bending_stiffness: Option<f64>,
    /// Bending elastocapillary length √(B / γ) of a plate, m.
    pub bending_elastocapillary_length: Option<f64>,
}

/// The reports of all deformable solids.
pub(crate) fn reports(scene: &Scene, setup: &AnySetup) -> Vec<SoftReport> {
    match setup {
        AnySetup::D2(setup) => reports_of_setup(scene, setup),
        AnySetup::D3(setup) => reports_of_setup(scene, setup),
    }
}

fn reports_of_setup<const D: usize>(scene: &Scene, setup: &Setup<D>) -> Vec<SoftReport> {
    let solids = scene.solids.iter().zip(&setup.model.solids);
    solids.filter_map(|(spec, solid)| Some(report_of_solid(scene, spec, solid.elastic()?))).collect()
}

fn report_of_solid<const D: usize>(scene: &Scene, spec: &SolidSpec, body: &Elastic<D>) -> SoftReport {
    let (mesh, step) = (body.rest_mesh(), longest_step(scene));
    let quality = mesh.quality();
    let density = spec.density.unwrap_or(scene.liquid.density);
    let wave_speed = super::stiffness::wave_speed(spec, mesh, density);
    let frequency = lowest_frequency(spec, body);
    let bending = super::stiffness::bending_stiffness(spec, mesh);
    SoftReport {
        solid: spec.name.clone(),
        vertices: quality.vertices,
        elements: quality.simplices,
        held: body.anchored().iter().filter(|h| **h).count(),
        edge: quality.edge_lengths[1],
        smallest_angle: quality.smallest_angle.0.to_degrees(),
        largest_angle: quality.largest_angle.0.to_degrees(),
        worst_radius_ratio: quality.worst_radius_ratio.0,
        mass: body.masses().iter().sum(),
        solver_bytes: memory::solver_bytes(body),
        memory_bytes: memory::solid_memory(body),
        factorised: body.is_factorised(),
        wave_speed,
        edges_per_step: wave_speed.map(|c| c * step / quality.edge_lengths[1]),
        frequency,
        steps_per_period: frequency.map(|f| 1.0 / (f * step)),
        thickness_cells: super::stiffness::plate_thickness_and_normal::<D>(&spec.shape)
            .map(|p| p.0 / scene.domain.dx),
        bending_stiffness: bending,
        bending_elastocapillary_length: bending.map(|b| (b / scene.tension.liquid_air).sqrt()),
    }
}

/// The lowest frequency, Hz: known from the damping, else computed where that is fast.
fn lowest_frequency<const D: usize>(spec: &SolidSpec, body: &Elastic<D>) -> Option<f64> {
    let ratio = match &spec.material {
        Material::NeoHookean(e) | Material::Corotated(e) => e.damping_ratio,
        Material::Springs { damping_ratio, .. } => *damping_ratio,
        _ => return None,
    };
    if ratio > 0.0 && body.damping_time() > 0.0 {
        return Some(2.0 * ratio / body.damping_time() / TAU);
    }
    if body.solver_entries() > MAX_ENTRIES_FOR_MODES {
        return None;
    }
    lowest_modes_to_tolerance(body, 1, MODE_TOLERANCE).ok()?.first().map(|mode| mode.frequency / TAU)
}

impl SoftReport {
    /// The report as lines of plain text for `meniscus check`, each a label and its text.
    pub(crate) fn lines(&self, dimension: usize) -> Vec<(String, String)> {
        let (element, angle) =
            if dimension == 2 { ("triangles", "angles") } else { ("tetrahedra", "dihedral angles") };
        let unit = if dimension == 2 { "kg/m" } else { "kg" };
        let held = match self.held {
            0 => "none fixed or moved: the solid is free".to_owned(),
            held => format!("{held} fixed or moved"),
        };
        let mut lines = vec![(
            format!("{} deforms", self.solid),
            format!(
                "{} vertices ({held}), {} {element}, edges of {}, {:.4e} {unit}",
                self.vertices,
                self.elements,
                format_si(self.edge, "m"),
                self.mass
            ),
        )];
        let mut line = |value: String| lines.push((String::new(), value));
        let factors = match self.factorised {
            true => format!("matrix factorised in {:.1} MB", self.solver_bytes * 1e-6),
            false => "matrix solved iteratively (its factors would need more than 2 GB)".into(),
        };
        line(format!(
            "{angle} of {:.1} to {:.1} deg, worst radius ratio {:.3}, {factors}",
            self.smallest_angle, self.largest_angle, self.worst_radius_ratio,
        ));
        if let (Some(speed), Some(edges)) = (self.wave_speed, self.edges_per_step) {
            line(format!("elastic wave speed {}, {edges:.1} mesh edges per step", format_si(speed, "m/s")));
        }
        if let (Some(f), Some(steps)) = (self.frequency, self.steps_per_period) {
            let few = if steps < 20.0 { ": too few to resolve this vibration" } else { "" };
            line(format!("lowest frequency {}, {steps:.1} steps per period{few}", format_si(f, "Hz")));
        }
        let mut plate = String::new();
        if let Some(cells) = self.thickness_cells {
            let _ = write!(plate, "a plate of {cells:.2} cells");
            if cells < MIN_PLATE_THICKNESS_CELLS {
                let _ = write!(plate, ", padded to {MIN_PLATE_THICKNESS_CELLS} cells for the liquid");
            }
        }
        if let (Some(b), Some(l)) = (self.bending_stiffness, self.bending_elastocapillary_length) {
            let _ = write!(
                plate,
                ", bending stiffness B = {b:.4e} N m, bending elastocapillary length √(B/γ) = {}",
                format_si(l, "m")
            );
        }
        if !plate.is_empty() {
            line(plate);
        }
        lines
    }
}
