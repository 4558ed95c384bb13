//! Restoration of momentum: after advection for liquid that solids hold, and after the forces for liquid that touches none or free ones.

use super::group::ComponentGroup;
use super::momentum::{ComponentFaces, MomentumRestoration, MomentumTargets};
use super::tracking::{ComponentChange, min_rotation_volume};
use crate::coupling::impulses::{CouplingImpulses, Impulse};
use crate::free_surface::curvature::Curvature;
use crate::free_surface::interface_faces::{InterfaceFace, interface_faces};
use crate::model::Model;
use crate::simulation::repairs::Repairs;
use crate::simulation::workspace::Workspace;
use crate::state::State;
use meniscus_numerics::Matrix;
use meniscus_numerics::grid::CellField;
use std::sync::atomic::{AtomicU64, Ordering};

/// Subtracts the impulses given to solids from the target motions. The torque on a small drop is noise and its inertia small: with the
/// rotation that it gives, a drop of radius 2 cells at the rim of a plate reached ten times the capillary speed.
pub fn subtract_solid_impulses<const D: usize>(
    model: &Model<D>,
    groups: &mut [ComponentGroup<D>],
    given: &[CouplingImpulses<D>],
) {
    let count = groups.iter().flat_map(|g| &g.new).max().map_or(0, |c| c + 1);
    let mut sums = vec![Impulse::zero(); count];
    for (pair, impulse) in given.iter().flat_map(|g| &g.pairs) {
        sums[pair.component as usize].add(impulse, 1.0);
    }
    for group in groups {
        let Some(whole) = &mut group.target_motion else { continue };
        for j in &group.new {
            whole.velocity -= sums[*j].linear / (model.density * whole.volume);
            let turning = sums[*j].moment_about(&whole.center) / model.density;
            (0..3).for_each(|i| whole.angular_momentum_per_density[i] -= turning[i]);
        }
        let touches = group.new.iter().any(|j| sums[*j].linear.norm_squared() > 0.0);
        group.keeps_angular_momentum &= !touches || whole.volume > min_rotation_volume(model);
    }
}

/// Restores the momentum that components held by solids lose in advection, before any force acts. Returns how much.
pub fn restore_advected_momentum<const D: usize>(
    model: &Model<D>,
    state: &mut State<D>,
    work: &Workspace<D>,
    change: &ComponentChange<D>,
) -> Repairs {
    if change.groups.iter().all(|g| g.advected_motion.is_none()) {
        return Repairs::default();
    }
    let carried = |g: &ComponentGroup<D>| ComponentGroup {
        target_motion: g.advected_motion.clone(),
        unconstrained_projector: Matrix::zeros(),
        ..g.clone()
    };
    let groups: Vec<ComponentGroup<D>> = change.groups.iter().map(carried).collect();
    let flat = Curvature::unknown();
    let interface_faces = interface_faces(model, &state.phi, &work.band, &flat, &work.cut_cells);
    let targets = MomentumTargets { groups: &groups, ..change.momentum_targets(0.0) };
    let restored = restore_momentum(model, state, work, &interface_faces, &targets);
    Repairs {
        carried_momentum_restored: restored.momentum,
        carried_spin_restored: restored.angular_momentum,
        unlabelled: restored.unlabelled,
        ..Repairs::default()
    }
}

/// Component of each liquid cell. A cell without one counts as part of the first component, and is counted.
pub struct ComponentLabels<'a> {
    known: &'a (dyn Fn(usize) -> Option<u32> + Sync),
    missing: AtomicU64,
}

impl<'a> ComponentLabels<'a> {
    /// Labels from a lookup of known components.
    pub fn new(known: &'a (dyn Fn(usize) -> Option<u32> + Sync)) -> Self {
        Self { known, missing: AtomicU64::new(0) }
    }

    /// Component of a cell.
    pub fn of(&self, cell: usize) -> u32 {
        (self.known)(cell).unwrap_or_else(|| {
            self.missing.fetch_add(1, Ordering::Relaxed);
            0
        })
    }

    /// Number of lookups without a component.
    pub fn missing(&self) -> u64 {
        self.missing.load(Ordering::Relaxed)
    }
}

/// Restores the momentum of every group with a target motion.
pub fn restore_momentum<const D: usize>(
    model: &Model<D>,
    state: &mut State<D>,
    work: &Workspace<D>,
    interface_faces: &[InterfaceFace],
    targets: &MomentumTargets<'_, D>,
) -> MomentumRestoration<D> {
    let of = work.liquid.component_lookup(&model.grid);
    let labels = ComponentLabels::new(&of);
    let label = |cell: usize| labels.of(cell);
    let faces = component_faces(model, &state.phi, work, interface_faces, &label);
    let restored = faces.restore(&mut state.velocity, targets);
    MomentumRestoration { unlabelled: labels.missing(), ..restored }
}

/// Iterator over the faces of each component.
pub fn component_faces<'a, const D: usize>(
    model: &'a Model<D>,
    phi: &'a CellField<D>,
    work: &'a Workspace<D>,
    interface_faces: &'a [InterfaceFace],
    label: &'a (dyn Fn(usize) -> u32 + Sync),
) -> ComponentFaces<'a, D> {
    ComponentFaces {
        model,
        phi,
        faces: work.known_faces.liquid_faces(),
        open_fractions: (!work.cut_cells.cells.is_empty()).then_some(&work.cut_cells.open_fraction),
        interface_faces,
        label,
        component_count: work.liquid.components as usize,
    }
}
