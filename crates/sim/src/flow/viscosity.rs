//! Viscosity: one implicit step with a traction-free free surface.
//!
//! Variational form (C. Batty and R. Bridson, "Accurate viscous free surfaces for buckling, coiling, and rotating liquids", SCA 2008):
//! the new velocity minimises `½ Σ m_f (u_f − u*_f)² + ½ h Φ(u)` with the dissipation
//! `Φ = ν ∫ 2 Σ_a (∂_a u_a)² + Σ_{a<b} (∂_b u_a + ∂_a u_b)² dV`. Each term is weighted by the liquid fraction of its control volume: a
//! cell for the diagonal terms, the box around an edge (2D: a node) for the shear. The traction at the free surface then vanishes by
//! itself, and rigid motions are unchanged.
//!
//! The mass `m_f` of a face is nearly that of the pressure solve (1 between liquid cells, otherwise the
//! fraction θ of the way to the interface, here by linear interpolation of φ, there by a cubic root), so that
//! this step and the projection are symmetric in nearly the same inner product. Faces outside the liquid that a
//! term needs are unknowns without mass, which follow the liquid.
//!
//! Walls and solids are frictionless: edges on sides or in solids carry no shear, and faces on closed sides keep their velocity. In cut
//! cells fractions and masses are those of the open part. Faces closed by solids have no mass and follow the liquid; as fixed values
//! they made drops glide.

use super::viscous_operator::{Cell, Neighbours, ViscousOperator};
use crate::model::Model;
use meniscus_numerics::grid::{Band, CellField, CutCells, FaceField, Lattice, Runs, Sampler, Segment};
use meniscus_numerics::linalg::{
    Jacobi, SolveError, SolveLimits, SolveReport, conjugate_gradient_in_single_precision,
};
use meniscus_numerics::shape::plane_box_fraction;
use meniscus_numerics::{par, rotation_planes};

/// Relative residual of the solve. 1e-8 takes twice the iterations and changes the decay of a drop by 0.03 %.
const TOLERANCE: f64 = 1e-6;
/// Largest number of iterations.
const MAX_ITERATIONS: usize = 2000;
/// Layers of the band whose air cells may hold a control volume that reaches into the liquid.
const AIR_LAYERS: usize = 3;
/// Distance from the interface, in cells, beyond which all control volumes of a cell are full or empty: 1.6 for an exact distance.
const FULL_CELL_DISTANCE_CELLS: f64 = 2.0;
/// Liquid fractions below this count as zero.
const MIN_LIQUID_FRACTION: f64 = 1e-6;
/// Smallest mass of a face of the liquid, as in the pressure solve.
const MIN_FACE_MASS: f64 = 0.02;

/// The fields of a state that viscosity needs.
pub struct Diffusion<'a, const D: usize> {
    /// Velocity, m/s; changed on the liquid's faces.
    pub velocity: &'a mut FaceField<D>,
    /// Signed distance, m.
    pub phi: &'a CellField<D>,
    /// The cells of the narrow band.
    pub band: &'a Band<D>,
    /// The liquid cells.
    pub liquid: &'a Runs,
    /// Their faces.
    pub liquid_faces: &'a [Vec<Segment>; D],
    /// Open fractions beside solids.
    pub cut_cells: &'a CutCells<D>,
}

impl<const D: usize> Diffusion<'_, D> {
    /// Lets viscosity act for `dt` seconds.
    ///
    /// # Errors
    /// Those of the solver.
    pub fn advance(&mut self, model: &Model<D>, dt: f64) -> Result<SolveReport, SolveError> {
        self.advance_to(model, dt, TOLERANCE)
    }

    fn advance_to(&mut self, model: &Model<D>, dt: f64, tolerance: f64) -> Result<SolveReport, SolveError> {
        let places = UnknownCells::new(model, self);
        let builder = Builder::new(model, self, &places, stiffness(model, dt));
        let deep = builder.deep_cells();
        let operator = builder.operator(&deep);
        let count = places.list.len();
        let mut x = gather(&operator, model, &places, self);
        let b = operator.times_face_mass(&x);
        let jacobi = Jacobi::new(&operator.diagonal());
        let limits = SolveLimits { tolerance, max_iterations: MAX_ITERATIONS };
        let report = conjugate_gradient_in_single_precision(&operator, &jacobi, &b, &mut x, limits)?;
        for a in 0..D {
            let lattice = model.grid.face_lattice(a);
            let (row, x) = (lattice.extent[0], &x[a * count..][..count]);
            par::for_each_segment(&mut self.velocity.axes[a], row, &self.liquid_faces[a], |s, part| {
                let at = lattice.coordinates(s.row * row + s.start);
                let slots = &places.slots[places.lattice.index(at)..][..part.len()];
                for (u, slot) in part.iter_mut().zip(slots).filter(|(_, slot)| **slot != 0) {
                    *u = x[*slot as usize];
                }
            });
        }
        Ok(report)
    }
}

/// `ν h/Δ²`.
fn stiffness<const D: usize>(model: &Model<D>, dt: f64) -> f64 {
    model.kinematic_viscosity * dt / (model.grid.dx * model.grid.dx)
}

/// The cells whose lower faces are unknowns: liquid, nearby air, and those beyond open upper sides.
struct UnknownCells<const D: usize> {
    /// The cells and one more along each axis, so that every face is the lower face of one of these.
    lattice: Lattice<D>,
    /// Indices of the cells; the first is a dummy.
    list: Vec<u32>,
    /// Slot of a cell in the list; 0: none.
    slots: Vec<u32>,
    /// The parts of the list that are runs of liquid cells.
    runs: Vec<Segment>,
}

impl<const D: usize> UnknownCells<D> {
    fn new(model: &Model<D>, d: &Diffusion<'_, D>) -> Self {
        let cells = model.grid.lattice();
        let lattice = Lattice::new(cells.extent.map(|n| n + 1));
        let (mut list, mut runs) = (vec![0], Vec::with_capacity(d.liquid.runs.len()));
        for run in &d.liquid.runs {
            let start =
                lattice.index(cells.coordinates(run.row as usize * cells.extent[0] + run.start as usize));
            let first = list.len();
            list.extend(start as u32..start as u32 + (run.end - run.start));
            runs.push(Segment { row: 0, start: first, end: list.len() });
        }
        let near = &d.band.cells[d.band.first_layers(AIR_LAYERS)];
        let far = FULL_CELL_DISTANCE_CELLS * model.grid.dx;
        let air = near.iter().filter(|c| (0.0..far).contains(&d.phi.data[**c as usize]));
        list.extend(air.map(|&c| lattice.index(cells.coordinates(c as usize)) as u32));
        for a in (0..D).filter(|a| !model.on_closed_side(*a, cells.extent[*a])) {
            let last = |p: &u32| {
                let at = lattice.coordinates(*p as usize);
                at[a] + 1 == cells.extent[a] && (0..D).all(|b| at[b] < cells.extent[b])
            };
            let beyond: Vec<u32> =
                list[1..].iter().filter(|p| last(p)).map(|p| p + lattice.stride[a] as u32).collect();
            list.extend(beyond);
        }
        // Pages of a zeroed array that are never written take no memory.
        let mut slots = vec![0; lattice.len()];
        list.iter().enumerate().skip(1).for_each(|(i, p)| slots[*p as usize] = i as u32);
        Self { lattice, list, slots, runs }
    }
}

/// Initial values on the faces. Unknowns outside the liquid get the mean of their neighbours in it.
fn gather<const D: usize>(
    operator: &ViscousOperator<D>,
    model: &Model<D>,
    places: &UnknownCells<D>,
    diffusion: &Diffusion<'_, D>,
) -> Vec<f64> {
    let (count, faces) = (places.list.len(), std::array::from_fn(|a| model.grid.face_lattice(a)));
    let (faces, velocity): (&[Lattice<D>; D], _) = (&faces, &diffusion.velocity.axes);
    let at = |i: usize| places.lattice.coordinates(places.list[i] as usize);
    let mut x = vec![0.0; count * D];
    par::map_component_segments(&mut x, count, &places.runs, |_, s, parts: [&mut [f64]; D]| {
        let at = at(s.start);
        for (a, part) in parts.into_iter().enumerate() {
            part.copy_from_slice(&velocity[a][faces[a].index(at)..][..part.len()]);
        }
    });
    let value = |at: [usize; D], a: usize| {
        let exists = (0..D).all(|b| b == a || at[b] < model.grid.cells[b]);
        if exists { velocity[a][faces[a].index(at)] } else { 0.0 }
    };
    let (segments, cells) = operator.general_stretches();
    par::map_component_segments(&mut x, count, &segments, |number, s, mut parts: [&mut [f64]; D]| {
        for (k, cell) in cells[number].iter().enumerate().filter(|(k, _)| s.start + k > 0) {
            let own = at(s.start + k);
            for (a, part) in parts.iter_mut().enumerate() {
                if !cell.is_unknown[a] || cell.face_mass[a] > 0.0 {
                    part[k] = value(own, a);
                    continue;
                }
                let near = cell.next.iter().flatten().map(|n| *n as usize);
                let known = near.filter(|n| operator.cell(*n).face_mass[a] > 0.0);
                let (sum, known) = known.fold((0.0, 0.0), |(s, c), n| (s + value(at(n), a), c + 1.0));
                part[k] = sum / f64::max(known, 1.0);
            }
        }
    });
    x
}

/// Computes liquid fractions and coefficients.
struct Builder<'a, const D: usize> {
    model: &'a Model<D>,
    places: &'a UnknownCells<D>,
    phi: &'a [f64],
    sampler: Sampler<'a, D>,
    solids: &'a CutCells<D>,
    stiffness: f64,
}

impl<'a, const D: usize> Builder<'a, D> {
    fn new(
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
    fn operator(&self, deep: &[bool]) -> ViscousOperator<D> {
        let place = |i: usize| self.places.list[i] as usize;
        let beside = |place: usize| self.neighbours(place, self.places.lattice.coordinates(place));
        let next = |i: usize| if i == 0 { [[0; 2]; D] } else { beside(place(i)) };
        let cell = |i: usize| if i == 0 { Cell::empty() } else { self.cell(place(i)) };
        ViscousOperator::new(deep, next, cell, self.stiffness)
    }

    /// Marks the cells of the list that are full, with full cells around them, and apart from solids and sides.
    fn deep_cells(&self) -> Vec<bool> {
        let UnknownCells { lattice, list, runs, .. } = self.places;
        let (mut full, mut deep) = (vec![false; list.len()], vec![false; list.len()]);
        let far = FULL_CELL_DISTANCE_CELLS * self.model.grid.dx;
        par::for_each_segment(&mut full, 0, runs, |s, part| {
            let place = list[s.start] as usize;
            let mut at = lattice.coordinates(place);
            let (start, first) = (at[0], self.model.grid.lattice().index(at));
            for (i, full) in part.iter_mut().enumerate() {
                at[0] = start + i;
                let is_full = self.phi[first + i] < -far;
                *full = is_full && self.is_apart(at, &self.neighbours(place + i, at));
            }
        });
        par::for_each_segment(&mut deep, 0, runs, |s, part| {
            let place = list[s.start] as usize;
            let mut at = lattice.coordinates(place);
            let start = at[0];
            for (i, deep) in part.iter_mut().enumerate().filter(|(i, _)| full[s.start + i]) {
                at[0] = start + i;
                *deep = self.neighbours(place + i, at).iter().flatten().all(|n| full[*n as usize]);
            }
        });
        deep
    }

    /// The slots of the cells beside a place with the coordinates `at`.
    #[inline]
    fn neighbours(&self, place: usize, at: [usize; D]) -> Neighbours<D> {
        let UnknownCells { lattice, slots, .. } = self.places;
        std::array::from_fn(|a| {
            let lower = if at[a] > 0 { slots[place - lattice.stride[a]] } else { 0 };
            [lower, if at[a] < self.model.grid.cells[a] { slots[place + lattice.stride[a]] } else { 0 }]
        })
    }

    fn cell(&self, place: usize) -> Cell<D> {
        let extent = self.model.grid.cells;
        let at = self.places.lattice.coordinates(place);
        let inside = (0..D).all(|a| at[a] < extent[a]);
        let next = self.neighbours(place, at);
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

    /// Mass of the lower face along `a`.
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

#[cfg(test)]
#[path = "viscosity_tests.rs"]
mod tests;
