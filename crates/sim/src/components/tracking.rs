//! Tracking of the liquid's components in a step: which become which, and the volume, position and momentum each must have.

use super::group::ComponentGroup;
use super::momentum::{MomentumTargets, combined};
use super::volume::{
    ComponentMatch, VolumeMeasurement, band_labels, centroid_corrections, match_components, target_volumes,
};
use crate::contact_line::force::unconstrained_projectors;
use crate::free_surface::dual_cell::DualCell;
use crate::model::Model;
use crate::model::resolution::{BAND_WIDTH_CELLS, MIN_RESOLVED_RADIUS_CELLS};
use crate::simulation::repairs::Repairs;
use crate::simulation::workspace::Workspace;
use crate::state::{Component, State};
use meniscus_numerics::grid::{Band, Runs};
use meniscus_numerics::{Matrix, Vector};
use std::f64::consts::PI;

/// Smallest radius, in cells, of a drop on a solid whose rotation is resolved.
const MIN_ROTATION_RADIUS_CELLS: f64 = 3.0;

/// Wetted fraction facing directions in which contact lines exert no force, from which on solids hold a component in these directions
/// as well, as a vessel does.
const MAX_FACING_WETTED_FRACTION: f64 = 0.01;

/// Change of the components in a step.
pub struct ComponentChange<const D: usize> {
    /// The groups that became one another.
    pub groups: Vec<ComponentGroup<D>>,
    /// Component of each cell of the band.
    pub band_labels: Vec<u32>,
    /// The interface in dual cells.
    pub dual_cells: Vec<DualCell>,
    /// Target volumes of the components, m³ (2D: m²).
    pub target_volumes: Vec<f64>,
    /// Measured volumes, m³ (2D: m²).
    pub volumes: Vec<f64>,
    /// Centres of mass, m.
    pub centers: Vec<Vector<D>>,
    /// Largest volume error of a component, as the thickness of a layer on a ball of its volume, in cells.
    pub volume_error_cells: f64,
    /// Repairs, measured before the corrections.
    pub repairs: Repairs,
}

impl<const D: usize> ComponentChange<D> {
    /// The present components, each unchanged.
    pub fn unchanged(model: &Model<D>, state: &State<D>, work: &Workspace<D>) -> Self {
        let band_labels = band_labels(model, &work.band, &state.phi, &work.liquid);
        let VolumeMeasurement { dual_cells, volumes, centers, .. } =
            work.volume_correction(model, &band_labels).measure(&state.phi);
        let groups = (0..volumes.len()).map(|c| ComponentGroup::new(vec![c], vec![c])).collect();
        Self {
            groups,
            band_labels,
            dual_cells,
            target_volumes: volumes.clone(),
            volumes,
            centers,
            volume_error_cells: 0.0,
            repairs: Repairs::default(),
        }
    }

    /// The motions that the components must have after gravity has acted for `gravity_time` (s).
    pub fn momentum_targets(&self, gravity_time: f64) -> MomentumTargets<'_, D> {
        MomentumTargets {
            groups: &self.groups,
            volumes: &self.target_volumes,
            centers: &self.centers,
            gravity_time,
        }
    }
}

/// Tracks the components and restores their volumes and centres of mass.
pub fn restore_volume<const D: usize>(
    model: &Model<D>,
    state: &mut State<D>,
    work: &Workspace<D>,
    before: &Runs,
    dt: f64,
) -> ComponentChange<D> {
    let band_labels = band_labels(model, &work.band, &state.phi, &work.liquid);
    let liquid = work.volume_correction(model, &band_labels);
    let measured = liquid.measure(&state.phi);
    let measured_volumes = measured.volumes.clone();
    // A component that vanishes within a cell of an open side has left the domain through that side.
    let has_left =
        |d: &Component<D>| model.open_side_distance(&(d.centroid + d.velocity * dt)) > -model.grid.dx;
    let mut followed =
        match_components(before, &work.liquid, &state.components, &measured.centers, dt, has_left);
    let groups = &mut followed.groups;
    let unpulled = unpulled_directions(work, &band_labels, &measured);
    predict_motions(model, state, work, groups, &unpulled, dt);
    let (target_volumes, lost) = target_volumes(groups, &state.components, &measured_volumes);
    record_lost_volume(model, state, groups, lost, has_left);
    let mut repairs = volume_repairs(model, state, &followed, &measured_volumes, &target_volumes);
    let offsets = centroid_corrections(&followed.groups, &target_volumes, &measured.centers);
    repairs.center_shift = offsets.iter().map(Vector::norm).fold(0.0, f64::max);
    let groups = followed.groups;
    let volume_error_cells = largest_volume_error_cells(model, &measured_volumes, &target_volumes);
    let limit = BAND_WIDTH_CELLS * model.grid.dx;
    let (corrected, converged) = liquid.correct(&mut state.phi, measured, &target_volumes, &groups, limit);
    let VolumeMeasurement { dual_cells, volumes, mut centers, .. } = corrected;
    if !converged {
        repairs.volume_unconverged = 1;
        repairs.volume_residual = absolute_volume_error(&volumes, &target_volumes) / total(&target_volumes);
    }
    // Where the interface could not be moved all the way, the recorded centres are corrected.
    let corrections = centroid_corrections(&groups, &target_volumes, &centers);
    centers.iter_mut().zip(corrections).for_each(|(center, corrections)| *center += corrections);
    ComponentChange {
        groups,
        band_labels,
        dual_cells,
        target_volumes,
        volumes,
        centers,
        volume_error_cells,
        repairs,
    }
}

/// For each component the projector onto the directions in which its lines pull at no solid. It is zero for those that solids hold in these
/// directions as a vessel does.
fn unpulled_directions<const D: usize>(
    work: &Workspace<D>,
    band_labels: &[u32],
    measured: &VolumeMeasurement<D>,
) -> Vec<Matrix<D>> {
    let mut unpulled = unconstrained_projectors(
        &measured.dual_cells,
        &work.cut_cells.cells,
        &band_component(&work.band, band_labels),
        measured.volumes.len(),
    );
    let free =
        work.facing_wetted_fraction(&unpulled).into_iter().map(|share| share < MAX_FACING_WETTED_FRACTION);
    unpulled.iter_mut().zip(free).filter(|(_, free)| !free).for_each(|(part, _)| part.fill(0.0));
    unpulled
}

/// Records in the state the volume `lost` by components that vanished, and as outflow that of those that have left the domain.
fn record_lost_volume<const D: usize>(
    model: &Model<D>,
    state: &mut State<D>,
    groups: &[ComponentGroup<D>],
    mut lost: f64,
    has_left: impl Fn(&Component<D>) -> bool,
) {
    for old in groups.iter().filter(|g| g.new.is_empty()).flat_map(|g| &g.old) {
        let drop = state.components[*old].clone();
        if has_left(&drop) {
            lost -= drop.target_volume;
            state.record_component_outflow(&drop, model.density, &model.gravity);
        }
    }
    state.lost_volume += lost;
}

/// Largest volume error of a resolved component, as the thickness of a layer on a ball of its target volume, in cells. An unresolved drop
/// loses its shape in any step and must not shorten the steps of the others.
fn largest_volume_error_cells<const D: usize>(model: &Model<D>, volumes: &[f64], targets: &[f64]) -> f64 {
    let is_resolved = |c: &usize| targets[*c] > min_resolved_volume(model);
    let depths = (0..volumes.len())
        .filter(is_resolved)
        .map(|c| layer_thickness_cells(model, volumes[c] - targets[c], targets[c]));
    depths.fold(0.0, f64::max)
}

/// Volume about to be moved, and components that vanished or appeared; `raw` are the measured volumes.
fn volume_repairs<const D: usize>(
    model: &Model<D>,
    state: &State<D>,
    followed: &ComponentMatch<D>,
    raw: &[f64],
    targets: &[f64],
) -> Repairs {
    let volume_shift = absolute_volume_error(raw, targets);
    let volume_shift_net = raw.iter().zip(targets).map(|(raw, target)| target - raw).sum();
    let volume_shift_largest = volume_shift / total(targets);
    let mut repairs = Repairs { volume_shift, volume_shift_net, volume_shift_largest, ..Repairs::default() };
    for i in &followed.vanished {
        let drop = &state.components[*i];
        repairs.vanished_volume += drop.target_volume;
        repairs.vanished_momentum += model.density * drop.target_volume * drop.velocity.norm();
    }
    for (new, old) in &followed.appeared {
        repairs.appeared_volume += raw[*new];
        repairs.appeared_momentum += model.density * raw[*new] * state.components[*old].velocity.norm();
    }
    repairs
}

/// Sum of the absolute volume errors of all components.
fn absolute_volume_error(volumes: &[f64], targets: &[f64]) -> f64 {
    volumes.iter().zip(targets).map(|(volume, target)| (volume - target).abs()).sum()
}

/// Sum of volumes, bounded above zero.
fn total(volumes: &[f64]) -> f64 {
    volumes.iter().sum::<f64>().max(f64::MIN_POSITIVE)
}

/// Smallest volume of a resolved drop, m³ (2D: area, m²).
pub fn min_resolved_volume<const D: usize>(model: &Model<D>) -> f64 {
    ball_volume::<D>(MIN_RESOLVED_RADIUS_CELLS * model.grid.dx)
}

/// Smallest volume of a drop whose rotation by solids is resolved, m³ (2D: area, m²).
pub fn min_rotation_volume<const D: usize>(model: &Model<D>) -> f64 {
    ball_volume::<D>(MIN_ROTATION_RADIUS_CELLS * model.grid.dx)
}

/// Volume of a ball, m³ (2D: area of a disc, m²).
fn ball_volume<const D: usize>(radius: f64) -> f64 {
    (if D == 2 { PI } else { 4.0 / 3.0 * PI }) * radius.powi(D as i32)
}

/// Thickness, in cells, of a layer of volume `change` on a ball of volume `whole`.
fn layer_thickness_cells<const D: usize>(model: &Model<D>, change: f64, whole: f64) -> f64 {
    let unit = ball_volume::<D>(1.0);
    let radius = (whole / unit).max(0.0).powf(1.0 / D as f64).max(0.5 * model.grid.dx);
    change.abs() / (D as f64 * unit * radius.powi(D as i32 - 1) * model.grid.dx)
}

/// The component of a cell of the band.
pub fn band_component<'a, const D: usize>(
    band: &'a Band<D>,
    labels: &'a [u32],
) -> impl Fn(usize) -> Option<u32> + 'a {
    |cell| band.slot(cell).map(|s| labels[s]).filter(|l| *l != u32::MAX)
}

/// Finds the target motion of every group that touches no side. `unpulled` is, for each component, the projector onto the directions in
/// which contact lines exert no force on solids.
pub fn predict_motions<const D: usize>(
    model: &Model<D>,
    state: &State<D>,
    work: &Workspace<D>,
    groups: &mut [ComponentGroup<D>],
    unpulled: &[Matrix<D>],
    dt: f64,
) {
    if !model.numerics.restore_momentum {
        return;
    }
    let touching = work.component_contacts(model);
    for group in groups {
        let free = group.new.iter().all(|&j| !touching[j].domain_side);
        if !group.old.is_empty() && !group.new.is_empty() && free {
            let touches = group.new.iter().any(|&j| touching[j].free_solid || touching[j].constrained_solid);
            group.unconstrained_projector =
                if touches { group_projector(group, unpulled) } else { Matrix::identity() };
            let mut motion = combined(group.old.iter().map(|&i| state.components[i].rigid_motion()));
            // A drop entirely within solids has no mass, and so no momentum to restore.
            if motion.volume <= 0.0 {
                continue;
            }
            motion.center += motion.velocity * dt;
            let is_constrained = group.new.iter().any(|&j| touching[j].constrained_solid);
            group.keeps_angular_momentum = motion.volume > min_resolved_volume(model);
            if is_constrained {
                group.advected_motion = Some(motion)
            } else {
                group.target_motion = Some(motion)
            }
        }
    }
}

/// The projector of a group; zero for several components.
fn group_projector<const D: usize>(group: &ComponentGroup<D>, parts: &[Matrix<D>]) -> Matrix<D> {
    match group.new[..] {
        [one] => parts.get(one).copied().unwrap_or(Matrix::zeros()),
        _ => Matrix::zeros(),
    }
}
