//! Cells cut by solids: the open fraction of every face, and the wetted surface in every cell.
//!
//! The solids' signed distance is sampled at the corners of the cells. On a face it is interpolated linearly (2D: along
//! the edge; 3D: on the four triangles around the middle, which has the mean), and the face is open where it is positive.
//! The wetted surface `S` closes the open parts `A_f` of a cell's faces, whose centroids are `r_f`. With the normal out
//! of the cell, for any shape of `S`,
//!
//! `∫_S n dS = −Σ A_f`, `∫_S r × n dS = −Σ r_f × A_f`
//!
//! With these integrals a constant pressure exerts no force and no torque on a body, to rounding, and no surface has to be built.

mod positive_part;

use self::positive_part::{positive_edge_part, positive_square_part};
use super::boxes::{box_rows, face_box, fill_box, segment_points};
use super::{FaceField, Grid, Lattice, Tiles};
use crate::{Aabb, Matrix, Vector, par, rotation_planes};

/// Open fractions closer than this to 0 or 1 are rounded to it: the flow through such a gap is not worth its stiffness.
const MIN_OPEN_FRACTION: f64 = 1e-4;
/// Areas and moments below this, in cells, are rounding errors: positions go up to some hundreds of cells.
const AREA_MOMENT_TOLERANCE: f64 = 1e-11;
/// Points closer than this to a solid's surface, in cells, count as inside, so that rounding does not separate neighbours on it.
const SURFACE_TOLERANCE_CELLS: f64 = 1e-6;
/// Distance assigned far from all solids, in cells.
const FAR_DISTANCE_CELLS: f64 = 1e3;
/// Margin around a solid's bounding box within which its distance is known, in cells.
const DISTANCE_MARGIN_CELLS: f64 = 6.0;
/// Depth to which closed faces are listed, in cells: trajectories and their stencils reach no farther.
const MAX_CLOSED_FACE_DEPTH_CELLS: f64 = 4.0;

/// A solid, given by its signed distance.
#[derive(Clone, Copy)]
pub struct EmbeddedBoundary<'a, const D: usize> {
    /// Distance to its surface, m, negative inside.
    pub signed_distance: &'a (dyn Fn(&Vector<D>) -> f64 + Sync),
    /// A box that contains it, m; may reach beyond the grid.
    pub bounds: Aabb<D>,
}

/// Wetted surface of a solid in a cell. Lengths are in cells; the normal `n` points into the solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutCell<const D: usize> {
    /// The cell.
    pub cell: u32,
    /// Index of the solid nearest to the cell's centre.
    pub solid: u32,
    /// `∫ n dS`.
    pub area_vector: Vector<D>,
    /// `∫ r × n dS` about the origin (2D: in the last entry).
    pub moment: [f64; 3],
    /// `∫ n ⊗ r dS` with `r` from the cell's centre. Times a pressure gradient it is the force of that gradient.
    pub first_moment: Matrix<D>,
}

/// Integrals over the wetted surface in a cell, as in [`CutCell`].
struct SurfaceIntegrals<const D: usize> {
    area_vector: Vector<D>,
    moment: [f64; 3],
    first_moment: Matrix<D>,
}

/// The faces and cells that solids cut.
#[derive(Clone, Debug)]
pub struct CutCells<const D: usize> {
    /// Open fraction of the faces of opened tiles, 0 to 1.
    pub open_fraction: FaceField<D>,
    /// The tiles whose faces have been opened; solids may have closed them since.
    opened: Tiles<D>,
    /// The cells with a wetted surface, sorted.
    pub cells: Vec<CutCell<D>>,
    /// Closed faces within four cells of a surface, per axis, sorted.
    pub closed_faces: [Vec<u32>; D],
    /// Signed distance at the corners of the cells, in cells; empty as long as there is no solid.
    corner_distances_cells: Vec<f64>,
    /// The same at the cell centres.
    center_distances_cells: Vec<f64>,
    /// Box of cells around each solid: lower corner, and one past the upper corner.
    solid_boxes: Vec<[[usize; D]; 2]>,
}

impl<const D: usize> CutCells<D> {
    /// No solid: all faces are open.
    pub fn uncut(grid: Grid<D>) -> Self {
        let mut all = Self::unopened(grid);
        all.open_tiles(&Tiles::all(grid));
        all
    }

    /// The same, but only the faces of tiles that are [opened](Self::open_tiles) have an open fraction; the others take no memory.
    pub fn unopened(grid: Grid<D>) -> Self {
        Self {
            open_fraction: FaceField::zeros(grid),
            opened: Tiles::none(grid),
            cells: Vec::new(),
            closed_faces: std::array::from_fn(|_| Vec::new()),
            corner_distances_cells: Vec::new(),
            center_distances_cells: Vec::new(),
            solid_boxes: Vec::new(),
        }
    }

    /// Opens the faces of tiles that are not open yet. Every face belongs to the tile of the cell above it, or else below it.
    pub fn open_tiles(&mut self, tiles: &Tiles<D>) {
        let grid = self.open_fraction.grid;
        for [low, high] in self.opened.add(tiles) {
            for a in 0..D {
                let mut high = high;
                high[a] += usize::from(high[a] == grid.cells[a]);
                fill_box(&mut self.open_fraction.axes[a], &grid.face_lattice(a), [low, high], 1.0);
            }
        }
    }

    /// Recomputes the cut cells for the current position of the solids, in active tiles. Elsewhere all faces are open.
    /// Overlapping solids are merged.
    pub fn rebuild(&mut self, solids: &[EmbeddedBoundary<'_, D>], tiles: &Tiles<D>) {
        self.reset();
        let grid = self.open_fraction.grid;
        if self.corner_distances_cells.is_empty() && !solids.is_empty() {
            self.corner_distances_cells = vec![FAR_DISTANCE_CELLS; corner_lattice(&grid).len()];
            self.center_distances_cells = vec![FAR_DISTANCE_CELLS; grid.lattice().len()];
        }
        self.solid_boxes = solids.iter().map(|s| cells_around(&grid, s.bounds)).collect();
        for (solid, [low, high]) in solids.iter().zip(&self.solid_boxes) {
            let corner = |at: [usize; D]| tiles.is_active_corner(at).then(|| grid.lower_corner(at));
            let center = |at: [usize; D]| tiles.is_active(at).then(|| grid.center(at));
            let (corners, past) = (corner_lattice(&grid), high.map(|n| n + 1));
            take_min_distance(
                solid,
                grid.dx,
                corners,
                [*low, past],
                corner,
                &mut self.corner_distances_cells,
            );
            take_min_distance(
                solid,
                grid.dx,
                grid.lattice(),
                [*low, *high],
                center,
                &mut self.center_distances_cells,
            );
        }
        let faces: Vec<_> = self.solid_boxes.iter().map(|[low, high]| [*low, high.map(|n| n + 1)]).collect();
        self.open_tiles(&tiles.dilated().within(&faces));
        for cells in self.solid_boxes.clone() {
            self.update_open_fractions(cells, tiles);
        }
        self.closed_faces.iter_mut().for_each(|faces| {
            faces.sort_unstable();
            faces.dedup();
        });
        let wet = |cells: &[[usize; D]; 2]| self.cut_cells_in(*cells, solids, tiles);
        let mut wet: Vec<CutCell<D>> = self.solid_boxes.iter().flat_map(wet).collect();
        wet.sort_by_key(|w| w.cell);
        wet.dedup_by_key(|w| w.cell);
        self.cells = wet;
    }

    /// Signed distance of a cell's centre to the nearest solid, in cells, negative inside; a large number more than six cells away.
    pub fn distance_cells(&self, cell: usize) -> f64 {
        self.center_distances_cells.get(cell).copied().unwrap_or(FAR_DISTANCE_CELLS)
    }

    /// Whether an open face connects a cell to one where `phi` is not negative.
    pub fn has_air_neighbour(&self, cell: usize, phi: &[f64]) -> bool {
        let lattice = self.open_fraction.grid.lattice();
        let at = lattice.coordinates(cell);
        (0..2 * D).any(|n| {
            let (a, up) = (n / 2, n % 2);
            if at[a] + up == 0 || at[a] + up == lattice.extent[a] {
                return false;
            }
            let mut face = at;
            face[a] += up;
            let open = self.open_fraction.axes[a][self.open_fraction.grid.face_lattice(a).index(face)] > 0.0;
            open && phi[if up == 1 { cell + lattice.stride[a] } else { cell - lattice.stride[a] }] >= 0.0
        })
    }

    /// Boxes of the cells whose distance to a solid is known: lower corner, and one past the upper corner.
    pub fn solid_boxes(&self) -> &[[[usize; D]; 2]] {
        &self.solid_boxes
    }

    /// Whether a cell has no open face.
    pub fn is_closed(&self, at: [usize; D]) -> bool {
        self.has_open_fraction(at, 0.0)
    }

    /// The cells of a box (lower corner, and one past the upper corner) that open faces within it connect to the cell `from`, which it contains.
    pub fn connected_cells(&self, from: [usize; D], [low, high]: [[usize; D]; 2]) -> Vec<[usize; D]> {
        let place = |at: &[usize; D]| (0..D).rev().fold(0, |k, a| k * (high[a] - low[a]) + at[a] - low[a]);
        let mut seen = vec![false; (0..D).map(|a| high[a] - low[a]).product()];
        seen[place(&from)] = true;
        let mut found = vec![from];
        let mut visited = 0;
        while let Some(&at) = found.get(visited) {
            visited += 1;
            for a in 0..D {
                let faces = self.open_fraction.grid.face_lattice(a);
                let face = faces.index(at);
                for (to, face) in [(at[a].wrapping_sub(1), face), (at[a] + 1, face + faces.stride[a])] {
                    let next = std::array::from_fn(|b| if b == a { to } else { at[b] });
                    let open = (low[a]..high[a]).contains(&to) && self.open_fraction.axes[a][face] > 0.0;
                    if open && !std::mem::replace(&mut seen[place(&next)], true) {
                        found.push(next);
                    }
                }
            }
        }
        found
    }

    /// Whether all faces of a cell have the open fraction `share`.
    fn has_open_fraction(&self, at: [usize; D], share: f64) -> bool {
        (0..D).all(|a| {
            let faces = self.open_fraction.grid.face_lattice(a);
            let f = faces.index(at);
            self.open_fraction.axes[a][f] == share && self.open_fraction.axes[a][f + faces.stride[a]] == share
        })
    }

    fn reset(&mut self) {
        let grid = self.open_fraction.grid;
        self.closed_faces.iter_mut().for_each(Vec::clear);
        for [low, high] in std::mem::take(&mut self.solid_boxes) {
            fill_box(
                &mut self.corner_distances_cells,
                &corner_lattice(&grid),
                [low, high.map(|n| n + 1)],
                FAR_DISTANCE_CELLS,
            );
            fill_box(&mut self.center_distances_cells, &grid.lattice(), [low, high], FAR_DISTANCE_CELLS);
            for a in 0..D {
                fill_box(
                    &mut self.open_fraction.axes[a],
                    &grid.face_lattice(a),
                    face_box([low, high], a),
                    1.0,
                );
            }
        }
    }

    fn update_open_fractions(&mut self, cells: [[usize; D]; 2], tiles: &Tiles<D>) {
        for a in 0..D {
            let lattice = self.open_fraction.grid.face_lattice(a);
            let rows = box_rows(&lattice, face_box(cells, a));
            let mut shares = std::mem::take(&mut self.open_fraction.axes[a]);
            par::for_each_segment(&mut shares, lattice.extent[0], &rows, |s, part| {
                let faces = segment_points(&lattice, s).zip(part);
                faces.filter(|(at, _)| tiles.is_active_face(a, *at)).for_each(|(at, share)| {
                    let cut = || self.open_fraction_and_centroid(a, at).0;
                    *share = self.uncut_open_fraction(a, at).unwrap_or_else(cut);
                });
            });
            let is_near = |at: &[usize; D]| {
                shares[lattice.index(*at)] == 0.0
                    && tiles.is_active_face(a, *at)
                    && self.face_depth_cells(a, *at) < MAX_CLOSED_FACE_DEPTH_CELLS
            };
            let near = par::flat_map(rows.len(), 1, |row, near| {
                let points = segment_points(&lattice, &rows[row]).filter(is_near);
                near.extend(points.map(|at| lattice.index(at) as u32));
            });
            self.closed_faces[a].extend(near);
            self.open_fraction.axes[a] = shares;
        }
    }

    /// Least depth of a face's corners, in cells.
    fn face_depth_cells(&self, axis: usize, at: [usize; D]) -> f64 {
        let lattice = corner_lattice(&self.open_fraction.grid);
        let across = (0..1usize << D).filter(|k| k >> axis & 1 == 0);
        let depth = |k: usize| {
            -self.corner_distances_cells[lattice.index(std::array::from_fn(|b| at[b] + (k >> b & 1)))]
        };
        across.map(depth).fold(f64::INFINITY, f64::min)
    }

    /// The cells of a box with a wetted surface.
    fn cut_cells_in(
        &self,
        cells: [[usize; D]; 2],
        solids: &[EmbeddedBoundary<'_, D>],
        tiles: &Tiles<D>,
    ) -> Vec<CutCell<D>> {
        let lattice = self.open_fraction.grid.lattice();
        let wet = |at: [usize; D]| {
            if self.has_open_fraction(at, 1.0) || self.is_closed(at) {
                return None;
            }
            let SurfaceIntegrals { area_vector, moment, first_moment } = self.surface_integrals(at)?;
            let solid = self.nearest_solid(at, solids)?;
            Some(CutCell { cell: lattice.index(at) as u32, solid, area_vector, moment, first_moment })
        };
        let rows = box_rows(&lattice, cells);
        par::flat_map(rows.len(), 1, |row, found| {
            let points = segment_points(&lattice, &rows[row]).filter(|at| tiles.is_active(*at));
            found.extend(points.filter_map(wet));
        })
    }

    /// Integrals over the wetted surface in a cell, from the open parts of its faces. `None` where they are rounding errors.
    fn surface_integrals(&self, at: [usize; D]) -> Option<SurfaceIntegrals<D>> {
        let grid = self.open_fraction.grid;
        let (mut area_vector, mut moment): (Vector<D>, [f64; 3]) = (Vector::zeros(), [0.0; 3]);
        let (mut first_moment, center): (Matrix<D>, _) = (Matrix::zeros(), grid.center(at) / grid.dx);
        for a in 0..D {
            for side in 0..2 {
                let mut face = at;
                face[a] += side;
                let (share, r) = self.open_fraction_and_centroid(a, face);
                let outward = if side == 1 { share } else { -share };
                area_vector[a] -= outward;
                (0..D).for_each(|b| first_moment[(a, b)] -= outward * (r[b] - center[b]));
                for &(b, c, place) in rotation_planes::<D>() {
                    // r × A, where only the component of A along `a` is not zero.
                    let turn = if c == a {
                        r[b]
                    } else if b == a {
                        -r[c]
                    } else {
                        0.0
                    };
                    moment[place] -= outward * turn;
                }
            }
        }
        // In 3D the areas of two surfaces in a cell may cancel although they exert a torque.
        let turning = rotation_planes::<D>().iter().map(|&(b, c, place)| {
            let [y, z] = [b, c].map(|a| grid.domain_coordinate_cells(a, at[a] as f64 + 0.5));
            (moment[place] - (y * area_vector[c] - z * area_vector[b])).abs()
        });
        if turning.fold(area_vector.amax(), f64::max) < AREA_MOMENT_TOLERANCE {
            return None;
        }
        // On the closed boundary of the open part, `∫ n ⊗ r dS` is its volume times the identity. The surface's
        // contribution to `D` times the volume is its distance times its area.
        let distance = self.mean_distance_cells(at) * area_vector.norm();
        let volume = ((distance - first_moment.trace()) / D as f64).clamp(0.0, 1.0);
        first_moment += Matrix::identity() * volume;
        Some(SurfaceIntegrals { area_vector, moment, first_moment })
    }

    /// Index of the solid nearest to a cell's centre, of those whose distance is known there.
    fn nearest_solid(&self, at: [usize; D], solids: &[EmbeddedBoundary<'_, D>]) -> Option<u32> {
        let x = self.open_fraction.grid.center(at);
        let near = |i: &usize, j: &usize| {
            (solids[*i].signed_distance)(&x).total_cmp(&(solids[*j].signed_distance)(&x))
        };
        let beside = |i: &usize| {
            let [low, high] = self.solid_boxes[*i];
            (0..D).all(|a| (low[a]..high[a]).contains(&at[a]))
        };
        (0..solids.len()).filter(beside).min_by(near).map(|solid| solid as u32)
    }

    /// Mean signed distance over a cell, in cells.
    fn mean_distance_cells(&self, at: [usize; D]) -> f64 {
        let lattice = corner_lattice(&self.open_fraction.grid);
        let corner = |k: usize| {
            self.corner_distances_cells[lattice.index(std::array::from_fn(|a| at[a] + (k >> a & 1)))]
        };
        let corners = (0..1usize << D).map(corner).sum::<f64>() / (1 << D) as f64;
        (2.0 * self.center_distances_cells[self.open_fraction.grid.lattice().index(at)] + corners) / 3.0
    }

    /// Open fraction of a face if it is 0 or 1, because the distance has one sign at all corners.
    #[inline(always)]
    fn uncut_open_fraction(&self, axis: usize, at: [usize; D]) -> Option<f64> {
        let lattice = corner_lattice(&self.open_fraction.grid);
        let base = lattice.index(at);
        let offsets = face_axes::<D>(axis).map(|a| lattice.stride[a]);
        let corners = match D {
            2 => [0, offsets[0], 0, offsets[0]],
            _ => [0, offsets[0], offsets[1], offsets[0] + offsets[1]],
        };
        let is_open = corners.map(|offset| self.corner_distances_cells[base + offset] > 0.0);
        (is_open == [is_open[0]; 4]).then_some(f64::from(u8::from(is_open[0])))
    }

    /// Open fraction of a face, and the centroid of its open part, in cells from the origin.
    fn open_fraction_and_centroid(&self, axis: usize, at: [usize; D]) -> (f64, Vector<D>) {
        let lattice = corner_lattice(&self.open_fraction.grid);
        let (base, along) = (lattice.index(at), face_axes::<D>(axis));
        let corner = |i: usize, j: usize| {
            self.corner_distances_cells[base + i * lattice.stride[along[0]] + j * lattice.stride[along[1]]]
        };
        let (share, [s, t]) = if D == 2 {
            positive_edge_part(corner(0, 0), corner(1, 0))
        } else {
            positive_square_part([[corner(0, 0), corner(0, 1)], [corner(1, 0), corner(1, 1)]])
        };
        let (share, [s, t]) = match share {
            none if none < MIN_OPEN_FRACTION => (0.0, [0.5; 2]),
            all if all > 1.0 - MIN_OPEN_FRACTION => (1.0, [0.5; 2]),
            some => (some, [s, t]),
        };
        let mut centroid =
            Vector::from_fn(|b, _| self.open_fraction.grid.domain_coordinate_cells(b, at[b] as f64));
        centroid[along[0]] += s;
        if D == 3 {
            centroid[along[1]] += t;
        }
        (share, centroid)
    }
}

/// The axes of a face normal to `axis`; in 2D twice the same.
fn face_axes<const D: usize>(axis: usize) -> [usize; 2] {
    match D {
        2 => [1 - axis; 2],
        _ => [(axis + 1) % 3, (axis + 2) % 3],
    }
}

fn corner_lattice<const D: usize>(grid: &Grid<D>) -> Lattice<D> {
    Lattice::new(grid.cells.map(|n| n + 1))
}

/// Takes the minimum of `values` and the distance to a solid, in cells of `dx` (m), at the points of a box of a lattice. `place` returns
/// the position of a point, m, or `None` to skip it.
fn take_min_distance<const D: usize>(
    solid: &EmbeddedBoundary<'_, D>,
    dx: f64,
    lattice: Lattice<D>,
    points: [[usize; D]; 2],
    place: impl Fn([usize; D]) -> Option<Vector<D>> + Sync,
    values: &mut [f64],
) {
    par::for_each_segment(values, lattice.extent[0], &box_rows(&lattice, points), |s, part| {
        for (at, value) in segment_points(&lattice, s).zip(part) {
            let Some(x) = place(at) else { continue };
            let distance = (solid.signed_distance)(&x) / dx;
            let is_on_surface = distance.abs() < SURFACE_TOLERANCE_CELLS;
            *value = value.min(if is_on_surface { -SURFACE_TOLERANCE_CELLS } else { distance });
        }
    });
}

/// The cells that a box touches, and `DISTANCE_MARGIN_CELLS` more on every side.
fn cells_around<const D: usize>(grid: &Grid<D>, bounds: Aabb<D>) -> [[usize; D]; 2] {
    let clamp =
        |a: usize, x: f64| (x + grid.margin_cells[a][0] as f64).clamp(0.0, grid.cells[a] as f64) as usize;
    let low = std::array::from_fn(|a| clamp(a, (bounds[0][a] / grid.dx).floor() - DISTANCE_MARGIN_CELLS));
    let high: [usize; D] =
        std::array::from_fn(|a| clamp(a, (bounds[1][a] / grid.dx).ceil() + DISTANCE_MARGIN_CELLS));
    [low, std::array::from_fn(|a| high[a].max(low[a]))]
}

#[cfg(test)]
mod tests;
