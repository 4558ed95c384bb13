//! Types of cells and faces (Fig. 5).
//!
//! A cell is solid if its centre lies within a solid, else liquid if its centre lies within the liquid's level set, else air
//! (Section 5.1). Faces are named after the cells on their two sides. Limit: solids are staircases of whole cells.

use crate::model::Wall;
use meniscus_numerics::grid::Grid;
use meniscus_numerics::{Vector, par};

/// Type of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CellType {
    /// Liquid.
    Liquid,
    /// Solid.
    Solid,
    /// Neither.
    Air,
}

/// Type of a face, by the cells on its two sides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaceType {
    /// Liquid on both sides.
    Liquid,
    /// Liquid and air; also liquid at an open side of the domain.
    LiquidAir,
    /// Liquid and solid: the faces of Eq. 8.
    LiquidSolid,
    /// Solid and air; also a solid at an open side of the domain.
    SolidAir,
    /// On a closed side of the domain.
    ClosedSide,
    /// Solid or air on both sides.
    Other,
}

/// A face of the grid. Its dual cell is the cube of the size of a cell around its centre.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Face {
    /// The axis to which it is normal.
    pub axis: usize,
    /// Its position in [`Grid::face_lattice`].
    pub index: usize,
}

/// The types of all cells.
#[derive(Clone, Debug)]
pub struct CellTypes<const D: usize> {
    grid: Grid<D>,
    walls: [[Wall; 2]; D],
    types: Vec<CellType>,
}

impl<const D: usize> CellTypes<D> {
    /// Types of the cells for a level set at the centres, m, negative in the liquid, and a signed distance to the solids, m, negative
    /// inside.
    pub fn new(
        grid: Grid<D>,
        walls: [[Wall; 2]; D],
        phi: &[f64],
        solid_distance: &(dyn Fn(&Vector<D>) -> f64 + Sync),
    ) -> Self {
        let lattice = grid.lattice();
        let of = |cell: usize| {
            if solid_distance(&grid.center(lattice.coordinates(cell))) < 0.0 {
                CellType::Solid
            } else if phi[cell] < 0.0 {
                CellType::Liquid
            } else {
                CellType::Air
            }
        };
        Self { grid, walls, types: par::map(phi.len(), 256, of) }
    }

    /// The grid.
    pub fn grid(&self) -> &Grid<D> {
        &self.grid
    }

    /// Type of a cell.
    pub fn cell(&self, cell: usize) -> CellType {
        self.types[cell]
    }

    /// Cells of a type in the order of memory.
    pub fn cells(&self, of: CellType) -> Vec<u32> {
        (0..self.types.len() as u32).filter(|c| self.types[*c as usize] == of).collect()
    }

    /// The cells below and above a face; `None` beyond the grid.
    pub fn sides(&self, face: Face) -> [Option<usize>; 2] {
        let (axis, lattice) = (face.axis, self.grid.lattice());
        let at = self.grid.face_lattice(axis).coordinates(face.index);
        let lower = (at[axis] > 0).then(|| {
            let mut below = at;
            below[axis] -= 1;
            lattice.index(below)
        });
        [lower, (at[axis] < self.grid.cells[axis]).then(|| lattice.index(at))]
    }

    /// The faces below and above a cell along an axis.
    pub fn faces(&self, cell: usize, axis: usize) -> [Face; 2] {
        let mut at = self.grid.lattice().coordinates(cell);
        let faces = self.grid.face_lattice(axis);
        let lower = faces.index(at);
        at[axis] += 1;
        [lower, faces.index(at)].map(|index| Face { axis, index })
    }

    /// Type of a face.
    pub fn face(&self, face: Face) -> FaceType {
        let sides = self.sides(face);
        let at_side = usize::from(sides[0].is_some());
        if sides.contains(&None) && self.walls[face.axis][at_side] == Wall::Slip {
            return FaceType::ClosedSide;
        }
        let count = |of| sides.iter().filter(|c| c.map_or(CellType::Air, |c| self.types[c]) == of).count();
        match [CellType::Liquid, CellType::Solid, CellType::Air].map(count) {
            [2, ..] => FaceType::Liquid,
            [1, 1, _] => FaceType::LiquidSolid,
            [1, 0, _] => FaceType::LiquidAir,
            [0, 1, 1] => FaceType::SolidAir,
            _ => FaceType::Other,
        }
    }

    /// Faces of a type, in order.
    pub fn faces_of(&self, of: FaceType) -> Vec<Face> {
        let found = |axis: usize| {
            let face = |index| Some(Face { axis, index }).filter(|f| self.face(*f) == of);
            par::filter_map(self.grid.face_lattice(axis).len(), 256, face)
        };
        (0..D).flat_map(found).collect()
    }

    /// Centre of a face, m.
    pub fn center(&self, face: Face) -> Vector<D> {
        self.grid.face_center(face.axis, self.grid.face_lattice(face.axis).coordinates(face.index))
    }
}
