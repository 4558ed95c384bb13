//! The coefficients of the viscous step: liquid fractions of control volumes, and masses of faces.

use super::cells::{CellList, UnknownCells};
use super::operator::{Cell, Neighbours, ViscousOperator};
use super::{Diffusion, FULL_CELL_DISTANCE_CELLS};
use crate::model::Model;
use meniscus_numerics::grid::{CutCells, Sampler};
use meniscus_numerics::shape::plane_box_fraction;
use meniscus_numerics::{par, rotation_planes};

/// Liquid fractions below this count as zero.
const MIN_LIQUID_FRACTION: f64 = 1e-6;
/// Smallest mass of a face of the liquid, as in the pressure solve.
const MIN_FACE_MASS: f64 = 0.02;

/// Computes liquid fractions and coefficients.
pub struct Builder<'a, const D: usize> {
    model: &'a Model<D>,
    places: &'a UnknownCells<D>,
    phi: &'a [f64],
    sampler: Sampler<'a, D>,
    solids: &'a CutCells<D>,
    stiffness: f64,
}

impl<'a, const D: usize> Builder<'a, D> {
    /// A builder of the coefficients of these cells; `stiffness` is `ν h/Δ²`.
    pub fn new(
        model: &'a Model<D>,
        diffusion: &'a Diffusion<'_, D>,
        places: &'a UnknownCells<D>,
        stiffness: f64,
    ) -> Self {
        let phi = &diffusion.phi.data;
        let sampler = Sampler::cells(&model.grid, phi, model.scalar_boundary());
        Self { model, places, phi, sampler, solids: diffusion.cut_cells, stiffness }
    }

    /// The operator; `deep` marks the cells in the middle of liquid.
    pub fn operator(&self, deep: &[bool]) -> ViscousOperator<D> {
        let cells = &self.places.cells;
        let place = |i: usize| cells.list[i] as usize;
        let beside = |i: usize| cells.neighbours(place(i), cells.coordinates(i));
        let next = |i: usize| if i == 0 { [[0; 2]; D] } else { beside(i) };
        let cell = |i: usize| if i == 0 { Cell::empty() } else { self.cell(place(i)) };
        ViscousOperator::new(deep, next, cell, self.stiffness)
    }

    /// Marks the cells of the list that are full, with full cells around them, and apart from solids and sides.
    pub fn deep_cells(&self) -> Vec<bool> {
        let UnknownCells { cells: CellList { lattice, list, .. }, runs } = self.places;
        let (mut full, mut deep) = (vec![false; list.len()], vec![false; list.len()]);
        let far = FULL_CELL_DISTANCE_CELLS * self.model.grid.dx;
        par::for_each_segment(&mut full, 0, runs, |s, part| {
            let place = list[s.start] as usize;
            let mut at = lattice.coordinates(place);
            let (start, first) = (at[0], self.model.grid.lattice().index(at));
            for (i, full) in part.iter_mut().enumerate() {
                at[0] = start + i;
                let is_full = self.phi[first + i] < -far;
                *full = is_full && self.is_apart(at, &self.places.cells.neighbours(place + i, at));
            }
        });
        par::for_each_segment(&mut deep, 0, runs, |s, part| {
            let place = list[s.start] as usize;
            let mut at = lattice.coordinates(place);
            let start = at[0];
            for (i, deep) in part.iter_mut().enumerate().filter(|(i, _)| full[s.start + i]) {
                at[0] = start + i;
                *deep =
                    self.places.cells.neighbours(place + i, at).iter().flatten().all(|n| full[*n as usize]);
            }
        });
        deep
    }

    fn cell(&self, place: usize) -> Cell<D> {
        let extent = self.model.grid.cells;
        let at = self.places.cells.lattice.coordinates(place);
        let inside = (0..D).all(|a| at[a] < extent[a]);
        let next = self.places.cells.neighbours(place, at);
        let value = if inside { self.phi[self.model.grid.lattice().index(at)] } else { f64::INFINITY };
        let is_full = value < -FULL_CELL_DISTANCE_CELLS * self.model.grid.dx;
        if is_full && self.is_apart(at, &next) {
            return Cell::full(next, self.stiffness);
        }
        // A term with a missing face is left out.
        let whole = |a: usize| next[a][1] != 0 || self.model.on_closed_side(a, at[a] + 1);
        let normal = if !inside || !(0..D).all(whole) {
            0.0
        } else if is_full {
            1.0
        } else {
            self.liquid_fraction(at, &[])
        };
        let mut shear = [0.0; D];
        for (k, &(p, q, _)) in rotation_planes::<D>().iter().enumerate() {
            if inside && next[p][0] != 0 && next[q][0] != 0 {
                shear[k] = self.stiffness * if is_full { 1.0 } else { self.liquid_fraction(at, &[p, q]) };
            }
        }
        let exists = |a: usize| (0..D).all(|b| b == a || at[b] < extent[b]);
        let open = |a: usize| self.solids.open_fraction.axes[a][self.model.grid.face_lattice(a).index(at)];
        let is_unknown: [bool; D] =
            std::array::from_fn(|a| exists(a) && !self.model.on_closed_side(a, at[a]));
        let face_mass =
            std::array::from_fn(|a| if is_unknown[a] { open(a) * self.face_mass(at, a) } else { 0.0 });
        let mut cell = Cell { next, normal: 2.0 * self.stiffness * normal, shear, face_mass, is_unknown };
        if inside && !self.solids.cells.is_empty() {
            self.apply_open_fractions(&mut cell, at);
        }
        cell
    }

    /// Whether a full cell lies so far from solids and sides that all its coefficients are those of unbounded liquid.
    fn is_apart(&self, at: [usize; D], next: &Neighbours<D>) -> bool {
        let lattice = self.model.grid.lattice();
        let here = lattice.index(at);
        self.solids.distance_cells(here) > FULL_CELL_DISTANCE_CELLS
            && next.iter().flatten().all(|n| *n != 0)
            && (0..D).all(|a| self.phi[here - lattice.stride[a]] < 0.0)
    }

    /// Reduces the coefficients of a cell to the part that solids leave open.
    fn apply_open_fractions(&self, cell: &mut Cell<D>, at: [usize; D]) {
        let lattice = self.model.grid.lattice();
        let here = lattice.index(at);
        // Open fraction of a cell-sized box at a distance from the solid.
        let room = |distance: f64| (distance + 0.5).clamp(0.0, 1.0);
        cell.normal *= room(self.solids.distance_cells(here));
        for (k, &(p, q, _)) in rotation_planes::<D>().iter().enumerate() {
            if cell.shear[k] == 0.0 {
                continue;
            }
            let around = [0, lattice.stride[p], lattice.stride[q], lattice.stride[p] + lattice.stride[q]];
            let mean = around.iter().map(|step| self.solids.distance_cells(here - step)).sum::<f64>() / 4.0;
            let open = |axis: usize, down: usize| {
                let faces = self.model.grid.face_lattice(axis);
                self.solids.open_fraction.axes[axis]
                    [faces.index(at) - if down == D { 0 } else { faces.stride[down] }]
            };
            let touches = [open(p, D), open(p, q), open(q, D), open(q, p)].contains(&0.0);
            cell.shear[k] *= if touches { 0.0 } else { room(mean) };
        }
    }

    /// Liquid fraction of a cell-sized box around the centre of the cell, or around the middle of its lower edge: half a cell down
    /// along each of the axes `down`.
    fn liquid_fraction(&self, at: [usize; D], down: &[usize]) -> f64 {
        let mut value = 0.0;
        let mut slope = [0.0; D];
        let count = 1 << down.len();
        for corner in 0..count {
            let mut cell = at.map(|i| i as isize);
            for (n, a) in down.iter().enumerate() {
                cell[*a] -= corner >> n & 1;
            }
            let here = self.sampler.value(cell);
            value += here;
            for (a, slope) in slope.iter_mut().enumerate() {
                *slope += match down.iter().position(|d| *d == a) {
                    Some(n) if corner >> n & 1 == 0 => 2.0 * here,
                    Some(_) => -2.0 * here,
                    None => {
                        let (mut up, mut low) = (cell, cell);
                        up[a] += 1;
                        low[a] -= 1;
                        0.5 * (self.sampler.value(up) - self.sampler.value(low))
                    }
                };
            }
        }
        let scale = 1.0 / count as f64;
        let share = plane_box_fraction(value * scale, slope.map(|s| s * scale));
        if share < MIN_LIQUID_FRACTION { 0.0 } else { share }
    }

    /// Mass of the lower face along `a`, in cells; on a side it is at most half a cell's.
    fn face_mass(&self, at: [usize; D], a: usize) -> f64 {
        let cells = self.model.grid.lattice();
        let side = at[a] == 0 || at[a] == cells.extent[a];
        let mut inner = at;
        inner[a] = inner[a].min(cells.extent[a] - 1);
        let upper = self.phi[cells.index(inner)];
        if side {
            return if upper < 0.0 { 0.5 } else { 0.0 };
        }
        let lower = self.phi[cells.index(at) - cells.stride[a]];
        if upper >= 0.0 && lower >= 0.0 {
            return 0.0;
        }
        let liquid = upper.min(lower);
        if upper.max(lower) < 0.0 { 1.0 } else { (liquid / (liquid - upper.max(lower))).max(MIN_FACE_MASS) }
    }
}
