//! Momentum kept: of liquid that touches nothing, of liquid and free solids together, and on the way with the flow.

use super::group::Group;
use super::momentum::{FaceWalk, Restored};
use super::tracking::{Change, turning_volume};
use crate::coupling::impulses::{Exchange, Impulse};
use crate::free_surface::curvature::Curvature;
use crate::free_surface::interface_faces::{CutFace, cut_faces};
use crate::model::Model;
use crate::repairs::Repairs;
use crate::simulation::workspace::Workspace;
use crate::state::State;
use meniscus_numerics::Matrix;
use meniscus_numerics::grid::CellField;
use std::sync::atomic::{AtomicU64, Ordering};

/// Takes from the groups what they gave to solids. Of a small drop the torque is noise, and so little turns
/// it that it was flung about at ten times the capillary speed (2 cells a radius, at the rim of a plate).
pub fn give_back<const D: usize>(model: &Model<D>, groups: &mut [Group<D>], given: &[Exchange<D>]) {
    let count = groups.iter().flat_map(|g| &g.new).max().map_or(0, |c| c + 1);
    let mut sums = vec![Impulse::none(); count];
    for ((component, _), impulse) in given.iter().flat_map(|g| &g.pairs) {
        sums[*component as usize].add(impulse, 1.0);
    }
    for group in groups {
        let Some(whole) = &mut group.whole else { continue };
        for j in &group.new {
            whole.velocity -= sums[*j].linear / (model.density * whole.mass);
            let turning = sums[*j].about(&whole.center) / model.density;
            (0..3).for_each(|i| whole.spin[i] -= turning[i]);
        }
        let touches = group.new.iter().any(|j| sums[*j].linear.norm_squared() > 0.0);
        group.turns &= !touches || whole.mass > turning_volume(model);
    }
}

/// Gives back what components that solids hold lost of their momentum on the way: nothing has pushed them yet. Returns how much
/// that was.
pub fn keep_carried<const D: usize>(
    model: &Model<D>,
    state: &mut State<D>,
    work: &Workspace<D>,
    change: &Change<D>,
) -> Repairs {
    if change.groups.iter().all(|g| g.carried.is_none()) {
        return Repairs::default();
    }
    let carried = |g: &Group<D>| Group { whole: g.carried.clone(), placed: Matrix::zeros(), ..g.clone() };
    let groups: Vec<Group<D>> = change.groups.iter().map(carried).collect();
    let flat = Curvature::unknown();
    let cut = cut_faces(model, &state.phi, &work.band, &flat, &work.cut);
    let kept = keep_momentum(model, state, work, &cut, (change, &groups), 0.0);
    Repairs {
        carried_momentum_restored: kept.momentum,
        carried_spin_restored: kept.spin,
        unlabelled: kept.unlabelled,
        ..Repairs::default()
    }
}

/// Components of liquid cells; one without counts as of the first, and is counted.
pub struct Labels<'a> {
    known: &'a (dyn Fn(usize) -> Option<u32> + Sync),
    missing: AtomicU64,
}

impl<'a> Labels<'a> {
    /// Of what is known of the cells.
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

    /// Times that there was none.
    pub fn missing(&self) -> u64 {
        self.missing.load(Ordering::Relaxed)
    }
}

/// Restores the momentum of every group that must have one.
pub fn keep_momentum<const D: usize>(
    model: &Model<D>,
    state: &mut State<D>,
    work: &Workspace<D>,
    cut: &[CutFace],
    (change, groups): (&Change<D>, &[Group<D>]),
    dt: f64,
) -> Restored<D> {
    let of = work.liquid.component(&model.grid);
    let labels = Labels::new(&of);
    let label = |cell: usize| labels.of(cell);
    let walk = walk(model, &state.phi, work, cut, &label);
    let restored = walk.restore(&mut state.velocity, groups, &change.targets, &change.centers, dt);
    Restored { unlabelled: labels.missing(), ..restored }
}

/// A walk over the faces of each component.
pub fn walk<'a, const D: usize>(
    model: &'a Model<D>,
    phi: &'a CellField<D>,
    work: &'a Workspace<D>,
    cut: &'a [CutFace],
    label: &'a (dyn Fn(usize) -> u32 + Sync),
) -> FaceWalk<'a, D> {
    FaceWalk {
        model,
        phi,
        faces: work.known.liquid(),
        open: (!work.cut.wet.is_empty()).then_some(&work.cut.open),
        cut,
        label,
        components: work.liquid.components as usize,
    }
}
