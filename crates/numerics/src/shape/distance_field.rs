//! A shape's signed distance at all cells of a grid.
//!
//! Along a row of cells, the distance to a mesh uses the result of the previous cell: its closest point bounds the
//! distance, and the sign changes only within a cell of the surface.

use super::{MeshShape, Shape};
use crate::Vector;
use crate::grid::{CellField, Grid};
use crate::par;

impl<const D: usize> Shape<D> {
    /// The signed distance (m, negative inside) at the centre of each cell.
    pub fn signed_distance_field(&self, grid: Grid<D>) -> CellField<D> {
        let mut field = CellField::new(grid, 0.0);
        let lattice = grid.lattice();
        par::map_chunks_mut([&mut field.data], grid.cells[0], |cells, [out]| {
            let first = grid.center(lattice.coordinates(cells.start));
            self.sample_row(&first, grid.dx, out);
        });
        field
    }

    /// The signed distance at points `dx` apart along the first axis.
    fn sample_row(&self, first: &Vector<D>, dx: f64, out: &mut [f64]) {
        let at = |i: usize| {
            let mut x = *first;
            x[0] += i as f64 * dx;
            x
        };
        match self {
            Self::Union(parts) => {
                out.fill(f64::INFINITY);
                let mut part_row = vec![0.0; out.len()];
                for part in parts {
                    part.sample_row(first, dx, &mut part_row);
                    out.iter_mut().zip(&part_row).for_each(|(v, p)| *v = v.min(*p));
                }
            }
            Self::Difference { of, minus } => {
                let mut cut = vec![0.0; out.len()];
                of.sample_row(first, dx, out);
                minus.sample_row(first, dx, &mut cut);
                out.iter_mut().zip(&cut).for_each(|(v, c)| *v = v.max(-c));
            }
            Self::Mesh(mesh) => mesh_row(mesh, at, dx, out),
            _ => out.iter_mut().enumerate().for_each(|(i, v)| *v = self.signed_distance(&at(i))),
        }
    }
}

/// The signed distance to a mesh at points `dx` apart.
fn mesh_row<const D: usize>(mesh: &MeshShape<D>, at: impl Fn(usize) -> Vector<D>, dx: f64, out: &mut [f64]) {
    let tree = mesh.tree();
    let mut last = f64::INFINITY;
    let mut foot: Option<Vector<D>> = None;
    for (i, v) in out.iter_mut().enumerate() {
        let x = at(i);
        // More than one cell from the surface, the sign is that of the previous point.
        let inside =
            if last.is_finite() && last.abs() > 1.0001 * dx { last < 0.0 } else { tree.contains(&x) };
        let within = foot.map_or(f64::INFINITY, |p| (p - x).norm() * (1.0 + 1e-12));
        if let Some(near) = tree.closest_point(&x, within) {
            foot = Some(near.point);
        }
        let distance = foot.map_or(f64::INFINITY, |p| (p - x).norm());
        *v = if inside { -distance } else { distance };
        last = *v;
    }
}
