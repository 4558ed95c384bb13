//! Energy of the free surface and volume of the liquid, with their exact derivatives, on the dual grid of cell centres.
//!
//! On cubes between cell centres the area `A` of the free surface, the wetted area `W` of the solids, and the volume `V` are
//! functions of the cell values. The surface energy over the tension is `E = A − W cos θ`, with `cos θ = (γ_sa − γ_ls)/γ_la`
//! (Young), and `∂E/∂φ_c / ∂V/∂φ_c` is the curvature, that of the contact line included. Sides mirror: a cube that reaches beyond
//! a side counts half.
//!
//! If the model has any solid, the energy includes gravity everywhere, `E = A − W cos θ + ∫ w·x dV` with
//! `w = −ρ g/γ`. In equilibrium the ratio is then the same constant everywhere, however large a part of the
//! surface a cell represents, and the curvature is the ratio minus `w·x`. Without gravity in the energy the surface
//! within two cells of a wall got the curvature of a cell farther off, and a meniscus with a capillary length of 8
//! cells was 4 % too low. Limit: liquid in free fall with its solid has no hydrostatic pressure; the angle of a drop
//! with Bo = 1 and a radius of 28 cells on a falling plate is wrong by half a degree.

use super::dual_cell::{CornerComponents, DualCell, SimplexSplit, away_from_zero, distribute};
use meniscus_numerics::grid::{Band, CutCells, Grid, Lattice, Runs, Segment, box_rows, segment_points};
use meniscus_numerics::{Vector, par, rotation_planes};
use rayon::prelude::*;
use std::sync::OnceLock;

/// The grid of dual cells and their split into simplices.
pub struct DualGrid<const D: usize> {
    grid: Grid<D>,
    split: SimplexSplit<D>,
    /// The dual cells that solids cut, sorted by `key`.
    solid_cells: Vec<SolidDualCell>,
    /// Bond vector `w = −ρ g Δ²/γ` of the liquid's weight, in 1/cells².
    bond_vector: Vector<D>,
}

/// A dual cell that a solid cuts; `key` is its index in the lattice of dual cells.
struct SolidDualCell {
    key: u32,
    /// The cells of its corners.
    corners: [u32; 8],
    /// Distance to the solid at the corners, in cells.
    psi: [f64; 8],
    /// Bit mask of the corners whose cells have an open face.
    open_corners: u8,
    /// Index of the nearest solid.
    solid: u32,
    /// Cosine of the contact angle there, and of Young's angle.
    contact_cosine: f64,
    young_cosine: f64,
    /// Whether a line there is pinned.
    pinned: bool,
    /// The dual cell when it is full of liquid, with Young's angle.
    flooded: OnceLock<Box<DualCell>>,
}

impl<const D: usize> DualGrid<D> {
    /// The dual grid of a grid, without solids; `bond_vector` is `w = −ρ g Δ²/γ`, in 1/cells².
    pub fn new(grid: Grid<D>, bond_vector: Vector<D>) -> Self {
        Self { grid, split: SimplexSplit::new(), solid_cells: Vec::new(), bond_vector }
    }

    /// Sets `w = −ρ g Δ²/γ`, in 1/cells², for the cubes that are cut from now on.
    pub fn set_bond_vector(&mut self, bond_vector: Vector<D>) {
        self.bond_vector = bond_vector;
    }

    /// Finds the cubes that solids cut; `nearest` returns the index of the nearest solid and the cosine of its contact angle.
    pub fn update_solids(
        &mut self,
        cut_cells: &CutCells<D>,
        nearest: impl Fn(&Vector<D>) -> (u32, f64) + Sync,
    ) {
        let cubes = self.lattice();
        let of_row = |row: &Segment| self.solid_cells_in(row, cut_cells, &nearest);
        let of = |[low, high]: &[[usize; D]; 2]| -> Vec<SolidDualCell> {
            let rows = box_rows(&cubes, [*low, high.map(|n| n + 1)]);
            par::flat_map(rows.len(), 1, |i, found| found.extend(of_row(&rows[i])))
        };
        let mut all: Vec<SolidDualCell> = cut_cells.solid_boxes().iter().flat_map(of).collect();
        all.sort_by_key(|d| d.key);
        all.dedup_by_key(|d| d.key);
        self.solid_cells = all;
    }

    /// The dual cells of a row that solids cut.
    fn solid_cells_in(
        &self,
        row: &Segment,
        cut_cells: &CutCells<D>,
        nearest: &(impl Fn(&Vector<D>) -> (u32, f64) + Sync),
    ) -> Vec<SolidDualCell> {
        let cubes = self.lattice();
        // The last cube that a solid touches: its place in the row, and its open corners.
        let mut last: Option<(usize, u8)> = None;
        let cut = |at: [usize; D]| {
            let corners = self.corners(at);
            let psi = corners.map(|c| away_from_zero(cut_cells.distance_cells(c as usize)));
            if psi[..1 << D].iter().all(|v| *v > 0.0) {
                return None;
            }
            let before = last.filter(|(i, _)| i + 1 == at[0]).map(|(_, open)| open);
            let is_open = |k: &usize| match before {
                Some(open) if k & 1 == 0 => open >> (k | 1) & 1 == 1,
                _ => !cut_cells.is_closed(self.corner(at, *k)),
            };
            let open_corners = (0..1 << D).filter(is_open).fold(0, |bits, k| bits | 1 << k);
            last = Some((at[0], open_corners));
            if open_corners == 0 {
                return None;
            }
            let (solid, young_cosine) = nearest(&self.grid.lower_corner(at));
            Some(SolidDualCell {
                key: cubes.index(at) as u32,
                corners,
                psi,
                open_corners,
                solid,
                contact_cosine: young_cosine,
                young_cosine,
                pinned: false,
                flooded: OnceLock::new(),
            })
        };
        segment_points(&cubes, row).filter_map(cut).collect()
    }

    /// Keys, ascending, of the dual cells that the surface crosses or in which liquid wets a solid. Only the signs of `phi` are used.
    pub fn interface_keys(&self, phi: &[f64], band: &Band<D>) -> Vec<u32> {
        let cubes = self.lattice();
        let cells = self.grid.lattice();
        let layer = &band.cells[band.first_layers(1)];
        let mut keys = par::flat_map(layer.len(), 256, |i, keys| {
            let cell = layer[i] as usize;
            if phi[cell] < 0.0 {
                let at = cells.coordinates(cell);
                let corner = |k: usize| std::array::from_fn(|a| at[a] + (k >> a & 1));
                keys.extend((0..1 << D).map(|k| cubes.index(corner(k)) as u32));
            }
        });
        let wet = |d: &SolidDualCell| d.corners[..1 << D].iter().any(|c| phi[*c as usize] < 0.0);
        keys.extend(self.solid_cells.iter().filter(|d| wet(d)).map(|d| d.key));
        keys.par_sort_unstable();
        keys.dedup();
        keys
    }

    /// The dual cells with these keys.
    pub fn dual_cells(&self, phi: &[f64], keys: &[u32]) -> Vec<DualCell> {
        par::map_slice(keys, 1, |&k| self.dual_cell(phi, k))
    }

    /// Computes the dual cells with these keys anew in their memory.
    pub fn update_dual_cells(&self, phi: &[f64], keys: &[u32], dual_cells: &mut [DualCell]) {
        par::for_each_mut(dual_cells, 1, |i, cell| *cell = self.dual_cell(phi, keys[i]));
    }

    /// Every dual cell that the surface crosses or in which liquid wets a solid, in order of memory.
    #[cfg(test)]
    pub fn interface_cells(&self, phi: &[f64], band: &Band<D>) -> Vec<DualCell> {
        self.dual_cells(phi, &self.interface_keys(phi, band))
    }

    /// The contact line of the energy: a point, m, in every dual cell in which it pulls at a solid.
    pub fn contact_line_points(&self, phi: &[f64]) -> Vec<Vector<D>> {
        self.contact_line_cells(phi).into_iter().map(|(_, place)| place).collect()
    }

    /// Indices in `solid_cells` of the cubes with a contact line, and a point of the line in each, m.
    fn contact_line_cells(&self, phi: &[f64]) -> Vec<(usize, Vector<D>)> {
        let cubes = self.lattice();
        let place = |number: usize| {
            let dry = &self.solid_cells[number];
            let values: [f64; 8] = std::array::from_fn(|k| {
                phi.get(dry.corners[k] as usize).map_or(1.0, |v| away_from_zero(v / self.grid.dx))
            });
            let wet = (0..1 << D).filter(|k| values[*k] < 0.0).count();
            let at = cubes.coordinates(dry.key as usize);
            let pulls = || self.dual_cell_with_solid(dry, &values, at).normal_pull != [0.0; 3];
            let lower = Vector::from_fn(|a, _| self.grid.domain_coordinate_cells(a, at[a] as f64 - 0.5));
            let there = wet > 0 && wet < 1 << D && pulls();
            there.then(|| (number, (lower + common_zero(&values, &dry.psi)) * self.grid.dx))
        };
        par::filter_map(self.solid_cells.len(), 256, place)
    }

    /// Sets the contact angles: `wetting` returns the cosine at a point (m) on the solid with an index, and whether the line is
    /// pinned.
    pub fn pin_contact_lines(
        &mut self,
        phi: &[f64],
        wetting: impl Fn(&Vector<D>, u32) -> (f64, bool) + Sync,
    ) {
        let lines = self.contact_line_cells(phi);
        let angle = |(number, place): &(usize, Vector<D>)| wetting(place, self.solid_cells[*number].solid);
        let angles = par::map_slice(&lines, 1, angle);
        // A line may reach any of the cells before the next call; nothing of earlier steps is kept that a checkpoint lacks.
        self.solid_cells
            .iter_mut()
            .for_each(|dry| (dry.contact_cosine, dry.pinned) = (dry.young_cosine, false));
        for ((number, _), (cosine, pinned)) in lines.into_iter().zip(angles) {
            let dry = &mut self.solid_cells[number];
            (dry.contact_cosine, dry.pinned) = (cosine, pinned);
        }
    }

    fn lattice(&self) -> Lattice<D> {
        Lattice::new(self.grid.cells.map(|n| n + 1))
    }

    /// The cells of a cube's corners; a corner beyond a side is a mirror image. `at` is one more than the lower corner, so that
    /// cubes beyond the lower sides have 0.
    fn corners(&self, at: [usize; D]) -> [u32; 8] {
        let cells = self.grid.lattice();
        std::array::from_fn(|k| if k < 1 << D { cells.index(self.corner(at, k)) as u32 } else { u32::MAX })
    }

    /// The cell of corner `k` of the same cube.
    fn corner(&self, at: [usize; D], k: usize) -> [usize; D] {
        std::array::from_fn(|a| (at[a] + (k >> a & 1)).saturating_sub(1).min(self.grid.cells[a] - 1))
    }

    fn dual_cell(&self, phi: &[f64], key: u32) -> DualCell {
        let at = self.lattice().coordinates(key as usize);
        let corners = self.corners(at);
        let values: [f64; 8] = std::array::from_fn(|k| {
            phi.get(corners[k] as usize).map_or(1.0, |v| away_from_zero(v / self.grid.dx))
        });
        let liquid = (0..1 << D).filter(|k| values[*k] < 0.0).fold(0u8, |bits, k| bits | 1 << k);
        if let Ok(i) = self.solid_cells.binary_search_by_key(&key, |d| d.key) {
            let dry = &self.solid_cells[i];
            let is_flooded = u32::from(liquid).count_ones() == 1 << D;
            return if is_flooded {
                self.flooded(dry, at)
            } else {
                self.dual_cell_with_solid(dry, &values, at)
            };
        }
        let mut cube = DualCell::new(corners, liquid);
        self.split.cut(&values, &self.bond_vector_in(at), &mut cube);
        self.move_to_grid(&mut cube, at);
        cube
    }

    /// A dual cell that a solid cuts when it is full of liquid. Several phases of a step read it.
    fn flooded(&self, dry: &SolidDualCell, at: [usize; D]) -> DualCell {
        let flooded = || Box::new(self.cut_with_angle(dry, &[-1.0; 8], at, dry.young_cosine, false));
        dry.flooded.get_or_init(flooded).as_ref().clone()
    }

    /// Computes a dual cell that a solid cuts.
    fn dual_cell_with_solid(&self, dry: &SolidDualCell, values: &[f64; 8], at: [usize; D]) -> DualCell {
        self.cut_with_angle(dry, values, at, dry.contact_cosine, dry.pinned)
    }

    /// The same with the cosine of the contact angle, and whether the line is pinned.
    fn cut_with_angle(
        &self,
        dry: &SolidDualCell,
        values: &[f64; 8],
        at: [usize; D],
        contact_cosine: f64,
        pinned: bool,
    ) -> DualCell {
        let liquid = (0..1 << D).filter(|k| values[*k] < 0.0).fold(0u8, |bits, k| bits | 1 << k);
        let mut cube = DualCell::new(dry.corners, liquid & dry.open_corners);
        (cube.solid, cube.young_cosine) = (dry.solid, dry.young_cosine);
        (cube.contact_cosine, cube.pinned) = (contact_cosine, pinned);
        self.split.cut_with_solid(values, &dry.psi, &self.bond_vector_in(at), &mut cube);
        self.move_to_grid(&mut cube, at);
        cube
    }

    /// The bond vector in a cube: zero along axes along which it is mirrored.
    fn bond_vector_in(&self, at: [usize; D]) -> Vector<D> {
        let mirrored = |a: usize| at[a] == 0 || at[a] == self.grid.cells[a];
        Vector::from_fn(|a, _| if mirrored(a) { 0.0 } else { self.bond_vector[a] })
    }

    /// Moves a cube from the unit cube to its position.
    fn move_to_grid(&self, cube: &mut DualCell, at: [usize; D]) {
        let last = self.grid.cells;
        // The centre of the half of a mirrored cube that is in the domain is a quarter of a cell from the side.
        let from_origin = |a: usize, i: f64| self.grid.domain_coordinate_cells(a, i);
        let shift = Vector::<D>::from_fn(|a, _| match at[a] {
            0 => from_origin(a, 0.25),
            n if n == last[a] => from_origin(a, n as f64 - 0.25),
            n => from_origin(a, n as f64 - 0.5),
        });
        let high = self.bond_vector.dot(&shift);
        if high != 0.0 {
            (0..1 << D).for_each(|k| cube.energy_slope[k] += high * cube.volume_slope[k]);
        }
        if cube.solid != u32::MAX {
            for &(a, b, place) in rotation_planes::<D>() {
                let [x, y] = [a, b].map(|a| from_origin(a, at[a] as f64 - 0.5));
                cube.pull_moments[0][place] += x * cube.normal_pull[b] - y * cube.normal_pull[a];
                cube.pull_moments[1][place] += x * cube.wetting_direction[b] - y * cube.wetting_direction[a];
            }
        }
        let sides = (0..D).filter(|&a| at[a] == 0 || at[a] == last[a]).count();
        if sides > 0 {
            cube.scale(0.5f64.powi(sides as i32));
        }
        for a in 0..D {
            let own = if at[a] == 0 || at[a] == last[a] { 0.0 } else { cube.excess_moment[a] };
            cube.excess_moment[a] = own + shift[a] * cube.excess_volume;
        }
    }

    /// Volume (m³, 2D: m²) and centroid (m) of each component of the liquid. The excess volume of a cube belongs to its liquid
    /// corners in equal parts: then no component has a negative volume.
    pub fn component_volumes(
        &self,
        liquid: &Runs,
        components: &[CornerComponents],
        dual_cells: &[DualCell],
    ) -> Vec<(f64, Vector<D>)> {
        let mut sums = self.cell_counts(liquid);
        let middles: Vec<Vector<D>> = sums.iter().map(|(n, moment)| moment / *n).collect();
        for (cube, components) in dual_cells.iter().zip(components) {
            distribute(components, |c, part| {
                let (volume, moment) = &mut sums[c as usize];
                *volume += part * cube.excess_volume;
                *moment += Vector::from_fn(|a, _| part * cube.excess_moment[a]);
            });
        }
        let dx = self.grid.dx;
        let center = |(c, (volume, moment)): (usize, (f64, Vector<D>))| {
            // The centroid of a tiny volume is lost in rounding.
            let center = if volume > 1e-6 { moment / volume } else { middles[c] };
            (volume * self.grid.cell_volume(), center * dx)
        };
        sums.into_iter().enumerate().map(center).collect()
    }

    /// Number of cells of each component, and sum of their centres, in cells. The outer half of a cell at a side counts half-way
    /// between its centre and the side.
    fn cell_counts(&self, liquid: &Runs) -> Vec<(f64, Vector<D>)> {
        let cells = self.grid.lattice();
        let mut sums = vec![(0.0, Vector::zeros()); liquid.components as usize];
        for run in &liquid.runs {
            let at = cells.coordinates(run.row as usize * cells.extent[0]);
            let n = (run.end - run.start) as f64;
            let mut moment =
                Vector::from_fn(|a, _| n * self.grid.domain_coordinate_cells(a, at[a] as f64 + 0.5));
            moment[0] = n * self.grid.domain_coordinate_cells(0, 0.5 * (run.start + run.end) as f64);
            for a in 0..D {
                let (first, last) =
                    if a == 0 { (run.start as usize, run.end as usize - 1) } else { (at[a], at[a]) };
                let count = if a == 0 { 1.0 } else { n };
                moment[a] -= if first == 0 { 0.125 * count } else { 0.0 };
                moment[a] += if last + 1 == cells.extent[a] { 0.125 * count } else { 0.0 };
            }
            let sum = &mut sums[run.component as usize];
            sum.0 += n;
            sum.1 += moment;
        }
        sums
    }
}

/// Number of Newton iterations to the common zero of two fields.
const CROSSING_ITERATIONS: usize = 4;

/// Point of the unit cube, near its middle, where two fields with these values at the corners are both zero.
fn common_zero<const D: usize>(one: &[f64; 8], other: &[f64; 8]) -> Vector<D> {
    let mut s = Vector::<D>::repeat(0.5);
    for _ in 0..CROSSING_ITERATIONS {
        let fields = [one, other].map(|v| multilinear(v, &s));
        let [(f, p), (g, q)] = fields;
        let (pp, pq, qq) = (p.norm_squared(), p.dot(&q), q.norm_squared());
        let determinant = (pp * qq - pq * pq).max(1e-3 * pp * qq).max(f64::MIN_POSITIVE);
        s -= (p * (qq * f - pq * g) + q * (pp * g - pq * f)) / determinant;
        s = s.map(|x| x.clamp(0.0, 1.0));
    }
    s
}

/// Value and gradient of the multilinear field with these values at the corners of the unit cube.
fn multilinear<const D: usize>(values: &[f64; 8], s: &Vector<D>) -> (f64, Vector<D>) {
    let weight = |k: usize, a: usize| if k >> a & 1 == 1 { s[a] } else { 1.0 - s[a] };
    let rest = |k: usize, a: usize| (0..D).filter(|b| *b != a).map(|b| weight(k, b)).product::<f64>();
    let corners = || (0..1usize << D).map(|k| (k, values[k]));
    let slope =
        |a: usize| corners().map(|(k, v)| v * rest(k, a) * if k >> a & 1 == 1 { 1.0 } else { -1.0 }).sum();
    (corners().map(|(k, v)| v * rest(k, D)).sum(), Vector::from_fn(|a, _| slope(a)))
}

#[cfg(test)]
#[path = "energy_tests.rs"]
mod tests;
