//! The state at the start.

use super::geometry::Geometry;
use super::scheme::PaperScheme;
use super::state::PaperState;
use crate::model::resolution::BAND_WIDTH_CELLS;
use meniscus_numerics::grid::{CellField, FaceField};
use meniscus_numerics::{Vector, par};

impl<const D: usize> PaperScheme<D> {
    /// The state at the start, with the liquid's signed distance, m, and velocity, m/s.
    pub fn start(
        &self,
        signed_distance: &(dyn Fn(&Vector<D>) -> f64 + Sync),
        velocity: &Vector<D>,
    ) -> PaperState<D> {
        let grid = self.model.grid;
        let (lattice, limit) = (grid.lattice(), BAND_WIDTH_CELLS * grid.dx);
        let mut phi = CellField::new(grid, 0.0);
        par::for_each_mut(&mut phi.data, 1, |cell, value| {
            *value = signed_distance(&grid.center(lattice.coordinates(cell))).clamp(-limit, limit);
        });
        let solids = self.model.initial_solids();
        let phi = self.restored_surface(&solids, phi);
        let geometry = Geometry::new(self, &solids, &phi);
        let mut field = FaceField::zeros(grid);
        field.axes.iter_mut().enumerate().for_each(|(axis, values)| values.fill(velocity[axis]));
        self.extend_velocity(&geometry, &solids, &mut field);
        let target_volume = self.volume(&geometry.phi);
        let pressure_impulse = CellField::new(grid, 0.0);
        PaperState {
            time: 0.0,
            phi,
            velocity: field,
            solids,
            line: Vec::new(),
            pressure_impulse,
            target_volume,
        }
    }
}
