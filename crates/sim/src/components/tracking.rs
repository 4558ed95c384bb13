//! What becomes of the liquid's components in a step: which become which, and the volume, place and momentum each must have.

use super::group::Group;
use super::momentum::together;
use super::volume::{Followed, Measured, astray, band_labels, follow, targets};
use crate::contact_line::force::unpulled;
use crate::free_surface::dual_cell::CutCube;
use crate::model::Model;
use crate::model::resolution::{BAND, RESOLVED};
use crate::repairs::Repairs;
use crate::simulation::workspace::Workspace;
use crate::state::{Drop, State};
use meniscus_numerics::grid::{Band, Runs};
use meniscus_numerics::{Matrix, Vector};
use std::f64::consts::PI;

/// From which on it is told how one on a solid turns.
const TURNING: f64 = 3.0;

/// Share of the wetted surface, as seen along the directions in which lines pull at no solid, from which on solids hold a
/// component there as well: it stands in a vessel.
const FACED: f64 = 0.01;

/// What became of the components in a step.
pub struct Change<const D: usize> {
    /// Which became which.
    pub groups: Vec<Group<D>>,
    /// Component that each cell of the band belongs to.
    pub labels: Vec<u32>,
    /// The surface in cubes.
    pub cubes: Vec<CutCube>,
    /// Volumes that the components must have.
    pub targets: Vec<f64>,
    /// Volumes that they have.
    pub volumes: Vec<f64>,
    /// Their centres of mass.
    pub centers: Vec<Vector<D>>,
    /// What a component's volume was wrong by, as a layer on a ball of its volume, in cells.
    pub jump: f64,
    /// What was mended, measured before.
    pub repairs: Repairs,
}

impl<const D: usize> Change<D> {
    /// The components as they are, each become itself.
    pub fn none(model: &Model<D>, state: &State<D>, work: &Workspace<D>) -> Self {
        let labels = band_labels(model, &work.band, &state.phi, &work.liquid);
        let Measured { cubes, volumes, centers } = work.measured_liquid(model, &labels).measure(&state.phi);
        let groups = (0..volumes.len()).map(|c| Group::new(vec![c], vec![c])).collect();
        Self {
            groups,
            labels,
            cubes,
            targets: volumes.clone(),
            volumes,
            centers,
            jump: 0.0,
            repairs: Repairs::default(),
        }
    }
}

/// Follows the components and puts their volumes and centres right.
pub fn keep_volume<const D: usize>(
    model: &Model<D>,
    state: &mut State<D>,
    work: &Workspace<D>,
    before: &Runs,
    dt: f64,
) -> Change<D> {
    let labels = band_labels(model, &work.band, &state.phi, &work.liquid);
    let liquid = work.measured_liquid(model, &labels);
    let measured = liquid.measure(&state.phi);
    let raw = measured.volumes.clone();
    // A component that vanishes within a cell of an open side has left the domain through that side.
    let left = |d: &Drop<D>| model.beyond_open(&(d.centroid + d.velocity * dt)) > -model.grid.dx;
    let mut followed = follow(before, &work.liquid, &state.drops, &measured.centers, dt, left);
    let groups = &mut followed.groups;
    let mut unpulled = unpulled(&measured.cubes, &work.cut.wet, &in_band(&work.band, &labels), raw.len());
    let free = work.faced(&unpulled).into_iter().map(|share| share < FACED);
    unpulled.iter_mut().zip(free).filter(|(_, free)| !free).for_each(|(part, _)| part.fill(0.0));
    expect(model, state, work, groups, &unpulled, dt);
    let (targets, mut lost) = targets(groups, &state.drops, &raw);
    for old in groups.iter().filter(|g| g.new.is_empty()).flat_map(|g| &g.old) {
        let drop = state.drops[*old].clone();
        if left(&drop) {
            lost -= drop.target_volume;
            state.count_outflow(&drop, model.density, &model.gravity);
        }
    }
    state.lost_volume += lost;
    let mut repairs = moved(model, state, &followed, &raw, &targets);
    let off = astray(&followed.groups, &targets, &measured.centers);
    repairs.center_shift = off.iter().map(Vector::norm).fold(0.0, f64::max);
    let groups = followed.groups;
    // A drop too small to be resolved loses its shape in any step: it must not make the others wait.
    let seen = |c: &usize| targets[*c] > resolved_volume(model);
    let depths = (0..raw.len()).filter(seen).map(|c| depth(model, raw[c] - targets[c], targets[c]));
    let jump = depths.fold(0.0, f64::max);
    let limit = BAND * model.grid.dx;
    let (corrected, converged) = liquid.correct(&mut state.phi, measured, &targets, &groups, limit);
    let Measured { cubes, volumes, mut centers } = corrected;
    if !converged {
        repairs.volume_unconverged = 1;
        repairs.volume_residual = misplaced(&volumes, &targets) / total(&targets);
    }
    // Where the surface could not follow all the way, the books do.
    let rest = astray(&groups, &targets, &centers);
    centers.iter_mut().zip(rest).for_each(|(center, rest)| *center += rest);
    Change { groups, labels, cubes, targets, volumes, centers, jump, repairs }
}

/// Volume that is about to be moved, and components that vanished or appeared; `raw` are the volumes as they are.
fn moved<const D: usize>(
    model: &Model<D>,
    state: &State<D>,
    followed: &Followed<D>,
    raw: &[f64],
    targets: &[f64],
) -> Repairs {
    let volume_shift = misplaced(raw, targets);
    let volume_shift_net = raw.iter().zip(targets).map(|(raw, target)| target - raw).sum();
    let volume_shift_largest = volume_shift / total(targets);
    let mut repairs = Repairs { volume_shift, volume_shift_net, volume_shift_largest, ..Repairs::default() };
    for i in &followed.vanished {
        let drop = &state.drops[*i];
        repairs.vanished_volume += drop.target_volume;
        repairs.vanished_momentum += model.density * drop.target_volume * drop.velocity.norm();
    }
    for (new, old) in &followed.appeared {
        repairs.appeared_volume += raw[*new];
        repairs.appeared_momentum += model.density * raw[*new] * state.drops[*old].velocity.norm();
    }
    repairs
}

/// Volume that is in the wrong component or missing: the sum over all of what each has too much or too little.
fn misplaced(volumes: &[f64], targets: &[f64]) -> f64 {
    volumes.iter().zip(targets).map(|(volume, target)| (volume - target).abs()).sum()
}

/// The sum of volumes, above zero.
fn total(volumes: &[f64]) -> f64 {
    volumes.iter().sum::<f64>().max(f64::MIN_POSITIVE)
}

/// Least volume of a drop that the grid resolves, m³ (2D: area, m²).
pub fn resolved_volume<const D: usize>(model: &Model<D>) -> f64 {
    ball_volume::<D>(RESOLVED * model.grid.dx)
}

/// Least volume of a drop of which it is told how solids turn it, m³ (2D: area, m²).
pub fn turning_volume<const D: usize>(model: &Model<D>) -> f64 {
    ball_volume::<D>(TURNING * model.grid.dx)
}

/// Volume of a ball, m³ (2D: area of a disc, m²).
fn ball_volume<const D: usize>(radius: f64) -> f64 {
    (if D == 2 { PI } else { 4.0 / 3.0 * PI }) * radius.powi(D as i32)
}

/// Thickness, in cells, of a layer of volume `change` on a ball of volume `whole`.
fn depth<const D: usize>(model: &Model<D>, change: f64, whole: f64) -> f64 {
    let unit = ball_volume::<D>(1.0);
    let radius = (whole / unit).max(0.0).powf(1.0 / D as f64).max(0.5 * model.grid.dx);
    change.abs() / (D as f64 * unit * radius.powi(D as i32 - 1) * model.grid.dx)
}

/// The component of a cell of the band.
pub fn in_band<'a, const D: usize>(
    band: &'a Band<D>,
    labels: &'a [u32],
) -> impl Fn(usize) -> Option<u32> + 'a {
    |cell| band.slot(cell).map(|s| labels[s]).filter(|l| *l != u32::MAX)
}

/// Finds out what every group that nothing holds must be after the step; `unpulled` is, for each component, the part of a
/// vector in directions in which lines pull at no solid.
pub fn expect<const D: usize>(
    model: &Model<D>,
    state: &State<D>,
    work: &Workspace<D>,
    groups: &mut [Group<D>],
    unpulled: &[Matrix<D>],
    dt: f64,
) {
    if !model.numerics.restore_momentum {
        return;
    }
    let touching = work.touching(model);
    for group in groups {
        let free = group.new.iter().all(|&j| !touching[j].side);
        if !group.old.is_empty() && !group.new.is_empty() && free {
            let touches = group.new.iter().any(|&j| touching[j].free || touching[j].held);
            group.placed = if touches { only(group, unpulled) } else { Matrix::identity() };
            let mut whole = together(group.old.iter().map(|&i| state.drops[i].whole()));
            // A drop whose volume lies within solids altogether has no mass, and so no momentum to be kept.
            if whole.mass <= 0.0 {
                continue;
            }
            whole.center += whole.velocity * dt;
            let held = group.new.iter().any(|&j| touching[j].held);
            group.turns = whole.mass > resolved_volume(model);
            if held { group.carried = Some(whole) } else { group.whole = Some(whole) }
        }
    }
}

/// The one of these parts of vectors that is a group's: nothing if it is of several components.
fn only<const D: usize>(group: &Group<D>, parts: &[Matrix<D>]) -> Matrix<D> {
    match group.new[..] {
        [one] => parts.get(one).copied().unwrap_or(Matrix::zeros()),
        _ => Matrix::zeros(),
    }
}
