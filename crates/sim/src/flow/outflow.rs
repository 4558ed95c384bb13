//! Open sides: air lies beyond them, and liquid that passes them leaves the domain.
//!
//! The grid extends [`OPEN_SIDE_MARGIN_CELLS`] cells beyond an open side. At the end of each step φ becomes the maximum of φ and the
//! signed distance to the domain within the open sides: the liquid ends at the side with a free surface at air pressure. The volume and
//! energy that left are the differences of the diagnostics before and after, summed up in the state. A component that becomes too small
//! for the grid within a cell of an open side also counts as outflow ([`crate::components::tracking`]).
//!
//! Limit: surface tension acts on the end of a jet at the side, where a continuing jet has no end.

use crate::components::volume::band_labels;
use crate::model::{Model, Wall};
use crate::simulation::diagnostics::{potential_energy, update_diagnostics};
use crate::simulation::workspace::Workspace;
use crate::state::State;
use meniscus_numerics::Vector;

/// Cells of the grid beyond an open side. The six points of the quintic stencil around points up to 2.5 cells beyond the side must lie
/// in the grid: paths from cells beside the side and closest points of cells two away evaluate φ there. A falling column lost 0.5 % of
/// the outflow in each step with 3 cells, and 0.01 % with 5 (`verify open-side`).
pub const OPEN_SIDE_MARGIN_CELLS: usize = 5;

impl<const D: usize> Model<D> {
    /// Extends the grid beyond open sides, as liquid that leaves through them requires.
    #[must_use]
    pub fn with_open_sides(mut self) -> Self {
        let margin = std::array::from_fn(|a| {
            std::array::from_fn(|side| match self.walls[a][side] {
                Wall::Open => OPEN_SIDE_MARGIN_CELLS,
                Wall::Slip => self.grid.margin_cells[a][side],
            })
        });
        self.grid = self.grid.with_margin(margin);
        self
    }

    /// Signed distance of a point to the nearest open side, m, negative within the domain; −∞ where all sides are closed.
    pub(crate) fn open_side_distance(&self, x: &Vector<D>) -> f64 {
        let upper = self.grid.domain_upper();
        let beyond = |a: usize, side: usize| match self.walls[a][side] {
            Wall::Open if side == 0 => -x[a],
            Wall::Open => x[a] - upper[a],
            Wall::Slip => f64::NEG_INFINITY,
        };
        (0..D).flat_map(|a| [beyond(a, 0), beyond(a, 1)]).fold(f64::NEG_INFINITY, f64::max)
    }
}

/// Removes liquid beyond open sides. Components that do not reach beyond one keep every bit.
pub fn remove_outflow<const D: usize>(model: &Model<D>, state: &mut State<D>, work: &mut Workspace<D>) {
    if !model.walls.as_flattened().contains(&Wall::Open) {
        return;
    }
    let lattice = model.grid.lattice();
    let beyond = |cell: u32| model.open_side_distance(&model.grid.center(lattice.coordinates(cell as usize)));
    let labels = band_labels(model, &work.band, &state.phi, &work.liquid);
    let mut is_clipped = vec![false; state.components.len()];
    for (&cell, &label) in work.band.cells.iter().zip(&labels) {
        let (value, side_distance) = (&mut state.phi.data[cell as usize], beyond(cell));
        if *value < side_distance {
            *value = side_distance;
            is_clipped.get_mut(label as usize).into_iter().for_each(|is_clipped| *is_clipped = true);
        }
    }
    if !is_clipped.contains(&true) {
        return;
    }
    let before = volume_and_energies(model, state);
    let liquid = std::mem::take(&mut work.liquid);
    let old_components = std::mem::take(&mut state.components);
    work.find_liquid(model, state);
    work.rebuild_velocity_extension(model, state);
    update_diagnostics(model, state, work);
    for (old, new, _) in liquid.overlaps(&work.liquid) {
        if !is_clipped[old as usize] {
            state.components[new as usize] = old_components[old as usize].clone();
        }
    }
    let after = volume_and_energies(model, state);
    state.outflow_volume += before[0] - after[0];
    state.outflow_kinetic_energy += before[1] - after[1];
    state.outflow_stored_energy += before[2] - after[2];
}

/// Volume, m³, and kinetic and stored energy, J, of the liquid of a state.
fn volume_and_energies<const D: usize>(model: &Model<D>, state: &State<D>) -> [f64; 3] {
    let volume = state.components.iter().map(|d| d.target_volume).sum();
    let surface = model.surface_tension * state.effective_surface_area;
    [volume, state.kinetic_energy, surface + potential_energy(model, state)]
}
