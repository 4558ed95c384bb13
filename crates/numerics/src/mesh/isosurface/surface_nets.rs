//! Extraction of the liquid's surface from a level set on the grid by surface nets.
//!
//! The lattice of cell centres is padded by one ring of air beyond the walls. Each *cube* of $2^D$ neighbouring lattice
//! points that are not all on one side carries one vertex. Each lattice edge between liquid and air carries one dual
//! facet through the vertices of the $2^{D-1}$ cubes around it (S. Gibson, "Constrained elastic surface nets", MICCAI
//! 1998, extended by a projection onto the zero set; see `dual_vertex.rs`). The facet is a segment in 2D and a quad cut
//! along its shorter diagonal in 3D. The vertex of a padded cube lies in the wall plane, so liquid at a wall is closed
//! by facets exactly in that plane. Each vertex stays in its cube, so facets of different cubes do not fold over.
//!
//! The liquid is given as runs. Each row of cubes is scanned from change to change of the $2^{D-1}$ rows of cells around
//! it, so the cost scales with the surface and the number of runs. Vertices are numbered by cube and facets by the lower
//! end of the lattice edge, so the result does not depend on the number of threads.
//!
//! Limit: a cube has one vertex, so two sheets of surface within one cube touch there.

use super::dual_vertex::dual_vertex;
use crate::Vector;
use crate::grid::{CellField, Run, Runs};
use crate::mesh::SurfaceMesh;
use crate::mesh::isosurface::{LIQUID_AIR, LIQUID_SOLID};
use crate::par;

/// Rows of cubes scanned by one task.
const CUBE_ROWS_PER_TASK: usize = 32;

/// The closed surface of the liquid.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Isosurface<const D: usize> {
    /// Vertices (m) and facets, outward.
    pub mesh: SurfaceMesh<D>,
    /// Label of each vertex: [`LIQUID_AIR`], [`LIQUID_SOLID`] or [`super::CONTACT_LINE`].
    pub vertex_kind: Vec<u8>,
    /// Label of each facet: [`LIQUID_AIR`] or [`LIQUID_SOLID`].
    pub facet_kind: Vec<u8>,
}

impl<const D: usize> Isosurface<D> {
    /// Area of the facets with a label, m² (2D: m).
    pub fn area_of_kind(&self, kind: u8) -> f64 {
        let area = |f: usize| if self.facet_kind[f] == kind { self.mesh.area_vector(f).norm() } else { 0.0 };
        crate::par::sum(self.facet_kind.len(), area)
    }
}

/// Surface of the cells in `liquid`, placed on the zero set of `phi` (negative inside, any unit).
///
/// Where neighbouring cells differ in `liquid` but not in the sign of `phi`, the surface crosses midway.
pub fn extract_isosurface<const D: usize>(phi: &CellField<D>, liquid: &Runs) -> Isosurface<D> {
    let rows = CellRows::new(phi, liquid);
    let blocks = par::map(rows.count().div_ceil(CUBE_ROWS_PER_TASK), 1, |b| rows.active_cubes_of(b));
    let mut cubes = ActiveCubes { first: vec![0], ..ActiveCubes::default() };
    cubes.corners.reserve_exact(blocks.iter().map(|b| b.corners.len()).sum());
    for block in &blocks {
        let base = cubes.corners.len() as u32;
        cubes.corners.extend_from_slice(&block.corners);
        let from = cubes.runs.len() as u32;
        cubes.runs.extend(block.runs.iter().map(|s| CubeRun { vertex: s.vertex + base, ..*s }));
        cubes.first.extend(block.ends.iter().map(|&e| e + from));
    }
    let parts = par::map(blocks.len(), 1, |b| rows.dual_faces_of(b, &cubes));
    let vertices = par::map(blocks.len(), 1, |b| rows.dual_vertices_of(b, &cubes));
    assemble(vertices, parts)
}

/// Joins the vertices and facets of all blocks and triangulates the quads.
fn assemble<const D: usize>(vertices: Vec<Vec<(Vector<D>, u8)>>, parts: Vec<DualFaces<D>>) -> Isosurface<D> {
    let mut out = Isosurface::<D>::default();
    let count = vertices.iter().map(Vec::len).sum();
    out.mesh.positions.reserve_exact(count);
    out.vertex_kind.reserve_exact(count);
    for (position, kind) in vertices.into_iter().flatten() {
        out.mesh.positions.push(position);
        out.vertex_kind.push(kind);
    }
    let positions = &out.mesh.positions;
    let cut: Vec<Vec<([u32; D], u8)>> = par::map_slice(&parts, 1, |p| {
        p.iter().flat_map(|&(v, kind)| triangulate(positions, v, kind)).collect()
    });
    let count = cut.iter().map(Vec::len).sum();
    out.mesh.facets.reserve_exact(count);
    out.facet_kind.reserve_exact(count);
    for (facet, kind) in cut.into_iter().flatten() {
        out.mesh.facets.push(facet);
        out.facet_kind.push(kind);
    }
    out
}

/// Facets of a dual face: itself in 2D, two triangles along the shorter diagonal of the quad in 3D.
fn triangulate<const D: usize>(
    positions: &[Vector<D>],
    v: [u32; 4],
    kind: u8,
) -> impl Iterator<Item = ([u32; D], u8)> + use<D> {
    let length = |a: usize, b: usize| (positions[v[a] as usize] - positions[v[b] as usize]).norm_squared();
    let (first, second) = if D == 2 {
        ([0, 1, 1], [0, 1, 1])
    } else if length(0, 2) <= length(1, 3) {
        ([0, 1, 2], [0, 2, 3])
    } else {
        ([1, 2, 3], [1, 3, 0])
    };
    let pick = move |t: [usize; 3]| std::array::from_fn(|k| v[t[k]]);
    std::iter::once((pick(first), kind)).chain((D == 3).then(|| (pick(second), kind)))
}

/// Dual faces in order: four cube vertices (2D: two, the last repeated) and the label.
type DualFaces<const D: usize> = Vec<([u32; 4], u8)>;

/// Consecutive cubes `start..end` of a row that carry a vertex, and the first one's vertex.
#[derive(Clone, Copy)]
struct CubeRun {
    start: u32,
    end: u32,
    vertex: u32,
}

/// The cubes of one block of rows.
#[derive(Default)]
struct Block {
    runs: Vec<CubeRun>,
    /// Number of cube runs up to the end of each row.
    ends: Vec<u32>,
    /// Liquid corners of each cube: bit `Σ_a o_a 2^a` for corner `o`.
    corners: Vec<u8>,
}

/// All cubes that carry a vertex.
#[derive(Default)]
struct ActiveCubes {
    runs: Vec<CubeRun>,
    /// Row `r` has the cube runs `first[r]..first[r + 1]`.
    first: Vec<u32>,
    corners: Vec<u8>,
}

impl ActiveCubes {
    fn row(&self, row: usize) -> &[CubeRun] {
        &self.runs[self.first[row] as usize..self.first[row + 1] as usize]
    }
}

/// Rows of cells with their runs, and the rows of cubes between them.
struct CellRows<'a, const D: usize> {
    phi: &'a CellField<D>,
    runs: &'a [Run],
    /// Row `r` of cells has the runs `first[r]..first[r + 1]`.
    first: Vec<u32>,
}

impl<'a, const D: usize> CellRows<'a, D> {
    fn new(phi: &'a CellField<D>, liquid: &'a Runs) -> Self {
        let mut first = vec![0; phi.grid.lattice().rows() + 1];
        liquid.runs.iter().for_each(|r| first[r.row as usize + 1] += 1);
        for r in 1..first.len() {
            first[r] += first[r - 1];
        }
        Self { phi, runs: &liquid.runs, first }
    }

    /// Number of rows of cubes.
    fn count(&self) -> usize {
        self.phi.grid.cells[1..].iter().map(|n| n + 1).product()
    }

    /// Coordinates of a row of cubes; the first is unused. Cube `c` lies between the cells `c - 1` and `c`.
    fn row_coordinates(&self, mut row: usize) -> [usize; D] {
        let mut at = [0; D];
        for (c, cells) in at.iter_mut().zip(self.phi.grid.cells).skip(1) {
            *c = row % (cells + 1);
            row /= cells + 1;
        }
        at
    }

    /// The rows of cubes of a block.
    fn rows_of(&self, block: usize) -> std::ops::Range<usize> {
        block * CUBE_ROWS_PER_TASK..((block + 1) * CUBE_ROWS_PER_TASK).min(self.count())
    }

    /// Runs of the rows of cells around a row of cubes. Bit `a - 1` of the index is the side along axis `a`.
    fn adjacent_runs(&self, row: usize) -> [&'a [Run]; 4] {
        let at = self.row_coordinates(row);
        let cells = &self.phi.grid.cells;
        std::array::from_fn(|q| {
            let (mut cell_row, mut stride) = (0, 1);
            for a in 1..D {
                let c = (at[a] + (q >> (a - 1) & 1)).wrapping_sub(1);
                if c >= cells[a] {
                    return &[][..];
                }
                cell_row += c * stride;
                stride *= cells[a];
            }
            if q >> (D - 1) > 0 {
                return &[][..];
            }
            &self.runs[self.first[cell_row] as usize..self.first[cell_row + 1] as usize]
        })
    }

    /// The cubes of a block that carry a vertex.
    fn active_cubes_of(&self, block: usize) -> Block {
        let mut out = Block::default();
        for row in self.rows_of(block) {
            self.walk_row(row, &mut out);
            out.ends.push(out.runs.len() as u32);
        }
        out
    }

    /// Scans a row of cubes from change to change of the cells around it.
    fn walk_row(&self, row: usize, out: &mut Block) {
        let full = (1u8 << (1 << (D - 1))) - 1;
        let mut around = self.adjacent_runs(row);
        let mut inside = 0u8; // bit q: row q is liquid just before `from`
        let mut from = 0u32;
        let mut open = false; // whether the last cube run of `out` may be extended
        loop {
            let before = inside;
            let next = |q: usize, runs: &[Run]| {
                runs.first().map_or(u32::MAX, |r| if before >> q & 1 == 0 { r.start } else { r.end })
            };
            let to = (0..4).map(|q| next(q, around[q])).min().unwrap_or(u32::MAX);
            if to == u32::MAX {
                break;
            }
            // Cubes `from + 1..to` lie between cells of one pattern. Cube `from` was added at the change.
            if before != 0 && before != full {
                (from + 1..to).for_each(|c| push_cube(out, &mut open, c, interleave_zeros(before) * 3));
            }
            for (q, runs) in around.iter_mut().enumerate().filter(|(q, runs)| next(*q, runs) == to) {
                if before >> q & 1 == 1 {
                    *runs = &runs[1..];
                }
                let goes_on = before >> q & 1 == 1 && runs.first().is_some_and(|r| r.start == to);
                inside ^= u8::from(!goes_on) << q;
            }
            let code = interleave_zeros(before) | (interleave_zeros(inside) << 1);
            if code != 0 && code != interleave_zeros(full) * 3 {
                push_cube(out, &mut open, to, code);
            }
            from = to;
        }
    }

    /// Positions (m) and labels of the vertices of a block.
    fn dual_vertices_of(&self, block: usize, cubes: &ActiveCubes) -> Vec<(Vector<D>, u8)> {
        let mut out = Vec::new();
        for row in self.rows_of(block) {
            let mut at = self.row_coordinates(row);
            for s in cubes.row(row) {
                for c in s.start..s.end {
                    at[0] = c as usize;
                    out.push(dual_vertex(self.phi, at, cubes.corners[(s.vertex + c - s.start) as usize]));
                }
            }
        }
        out
    }

    /// Dual faces of the lattice edges that start at the lowest corners of the cubes of a block.
    fn dual_faces_of(&self, block: usize, cubes: &ActiveCubes) -> DualFaces<D> {
        let mut out = Vec::new();
        for row in self.rows_of(block) {
            let mut at = self.row_coordinates(row);
            if cubes.row(row).is_empty() {
                continue;
            }
            let mut below = LowerCubes::new(self, cubes, row, at);
            for s in cubes.row(row) {
                for c in s.start..s.end {
                    at[0] = c as usize;
                    let code = cubes.corners[(s.vertex + c - s.start) as usize];
                    self.add_faces_of_cube(at, code, &mut below, &mut out);
                }
            }
        }
        out
    }

    /// Dual faces of the edges from the lowest corner of a cube to its neighbours along the axes.
    fn add_faces_of_cube(&self, at: [usize; D], code: u8, below: &mut LowerCubes, out: &mut DualFaces<D>) {
        let low = code & 1;
        for a in 0..D {
            if (code >> (1 << a) & 1) == low {
                continue;
            }
            let mut face = [0; 4];
            let (b, c) = ((a + 1) % D, (a + 2) % D);
            // Counter-clockwise about axis a; in 2D from the lower to the upper cube along y, and back along x.
            let steps = if D == 3 {
                [1 << b | 1 << c, 1 << c, 0, 1 << b]
            } else if a == 0 {
                [1 << b, 0, 0, 0]
            } else {
                [0, 1 << b, 1 << b, 1 << b]
            };
            for (v, step) in face.iter_mut().zip(steps) {
                *v = below.vertex(at[0] as u32, step);
            }
            if low == 0 {
                if D == 3 {
                    face.swap(1, 3);
                } else {
                    face = [face[1], face[0], face[0], face[0]];
                }
            }
            let wall = at[a] == 0 || at[a] == self.phi.grid.cells[a];
            out.push((face, if wall { LIQUID_SOLID } else { LIQUID_AIR }));
        }
    }
}

/// Appends a cube to the cube runs of the row.
fn push_cube(out: &mut Block, open: &mut bool, cube: u32, code: u8) {
    match out.runs.last_mut() {
        Some(s) if *open && s.end == cube => s.end += 1,
        _ => out.runs.push(CubeRun { start: cube, end: cube + 1, vertex: out.corners.len() as u32 }),
    }
    *open = true;
    out.corners.push(code);
}

/// Moves bit q to bit 2q.
fn interleave_zeros(q: u8) -> u8 {
    (q & 1) | ((q & 2) << 1) | ((q & 4) << 2) | ((q & 8) << 3)
}

/// Lookup of the vertices of the cubes at and below a cube that advances along its row.
struct LowerCubes<'a> {
    /// Cube runs of the row itself and of the rows below along the second, the third and both axes.
    rows: [&'a [CubeRun]; 4],
}

impl<'a> LowerCubes<'a> {
    fn new<const D: usize>(
        rows: &CellRows<'a, D>,
        cubes: &'a ActiveCubes,
        row: usize,
        at: [usize; D],
    ) -> Self {
        let over = if D == 3 { rows.phi.grid.cells[1] + 1 } else { 0 };
        let inside = |q: usize| (1..D).all(|a| q >> (a - 1) & 1 == 0 || at[a] > 0) && q >> (D - 1) == 0;
        Self {
            rows: std::array::from_fn(|q| {
                let down = (q & 1) + (q >> 1) * over;
                if inside(q) { cubes.row(row - down) } else { &[][..] }
            }),
        }
    }

    /// Vertex of the cube at `step` (bit a: one down along axis a) from cube `c` of the row. `c` must not decrease between calls.
    fn vertex(&mut self, c: u32, step: usize) -> u32 {
        let (c, q) = (c - (step as u32 & 1), step >> 1);
        // One cube of slack: the next call may be for the cube before this one.
        while self.rows[q].first().is_some_and(|s| s.end + 1 < c) {
            self.rows[q] = &self.rows[q][1..];
        }
        let holds = |s: &&CubeRun| s.start <= c && c < s.end;
        self.rows[q].iter().take(4).find(holds).map_or(0, |s| s.vertex + c - s.start)
    }
}

#[cfg(test)]
#[path = "surface_nets_tests.rs"]
mod tests;
