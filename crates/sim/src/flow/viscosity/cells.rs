//! The cells whose lower faces are unknowns of the viscous step.

use super::operator::Neighbours;
use super::{AIR_LAYERS, Diffusion, FULL_CELL_DISTANCE_CELLS};
use crate::model::Model;
use meniscus_numerics::grid::{Lattice, Segment};
use meniscus_numerics::par;
use rayon::prelude::*;

/// Listed cells of a lattice that has one more cell along each axis than the grid, so that every face is the lower face of one of its
/// cells.
pub struct CellList<const D: usize> {
    /// The lattice.
    pub lattice: Lattice<D>,
    /// Indices of the cells; the first is a dummy.
    pub list: Vec<u32>,
    /// Slot of a cell in the list; 0: none.
    pub slots: Vec<u32>,
    /// Whether the lower and the upper side normal to each axis are closed.
    pub closed: [[bool; 2]; D],
}

/// The unknown cells of a state: liquid, nearby air, and those beyond open upper sides.
pub struct UnknownCells<const D: usize> {
    /// The list.
    pub cells: CellList<D>,
    /// The parts of the list that are runs of liquid cells.
    pub runs: Vec<Segment>,
}

impl<const D: usize> CellList<D> {
    /// The cells with these indices.
    pub fn new(lattice: Lattice<D>, list: Vec<u32>, closed: [[bool; 2]; D]) -> Self {
        // Pages of a zeroed array that are never written take no memory.
        let mut slots = vec![0; lattice.len()];
        list.iter().enumerate().skip(1).for_each(|(i, p)| slots[*p as usize] = i as u32);
        Self { lattice, list, slots, closed }
    }

    /// Number of cells, with the dummy.
    pub fn count(&self) -> usize {
        self.list.len()
    }

    /// Coordinates of a cell of the list.
    pub fn coordinates(&self, i: usize) -> [usize; D] {
        self.lattice.coordinates(self.list[i] as usize)
    }

    /// The cells that hold those of the list on a grid of twice the spacing.
    pub fn coarsened(&self) -> Self {
        let lattice = Lattice::new(self.lattice.extent.map(|n| n / 2 + 1));
        let parent = |p: &u32| lattice.index(self.lattice.coordinates(*p as usize).map(|x| x / 2)) as u32;
        let mut list = par::map_slice(&self.list[1..], 256, parent);
        list.par_sort_unstable();
        list.dedup();
        list.insert(0, 0);
        Self::new(lattice, list, self.closed)
    }

    /// The slots of the cells beside the one with the index `place` and the coordinates `at`.
    #[inline]
    pub fn neighbours(&self, place: usize, at: [usize; D]) -> Neighbours<D> {
        std::array::from_fn(|a| {
            let stride = self.lattice.stride[a];
            let lower = if at[a] > 0 { self.slots[place - stride] } else { 0 };
            [lower, if at[a] + 1 < self.lattice.extent[a] { self.slots[place + stride] } else { 0 }]
        })
    }

    /// Whether a face normal to `a` with this coordinate along `a` lies on a closed side.
    pub fn is_on_closed_side(&self, a: usize, at: usize) -> bool {
        (at == 0 && self.closed[a][0]) || (at + 1 == self.lattice.extent[a] && self.closed[a][1])
    }

    /// Calls `f` with the number and the slot of each place of a cube of `side` places, the first axis fastest.
    #[inline(always)]
    pub fn for_each_slot(&self, first: [isize; D], side: usize, mut f: impl FnMut(usize, usize)) {
        let inside = |a: usize, at: isize| at >= 0 && at < self.lattice.extent[a] as isize;
        let is_inside = (0..D).all(|a| inside(a, first[a]) && inside(a, first[a] + side as isize - 1));
        let across = if D == 3 { [side, side] } else { [side, 1] };
        let mut number = 0;
        for k in 0..across[1] {
            for j in 0..across[0] {
                let mut at = first;
                at[1] += j as isize;
                at[D - 1] += if D == 3 { k as isize } else { 0 };
                if is_inside {
                    let row = self.lattice.index(at.map(|x| x as usize));
                    self.slots[row..][..side]
                        .iter()
                        .enumerate()
                        .for_each(|(i, s)| f(number + i, *s as usize));
                } else {
                    for i in 0..side {
                        let mut at = at;
                        at[0] += i as isize;
                        let exists = (0..D).all(|a| inside(a, at[a]));
                        let slot =
                            if exists { self.slots[self.lattice.index(at.map(|x| x as usize))] } else { 0 };
                        f(number + i, slot as usize);
                    }
                }
                number += side;
            }
        }
    }
}

/// The products of weights along the axes, in the order of [`CellList::for_each_slot`].
pub fn tensor_product<const D: usize>(weights: [&[f32]; D]) -> Vec<f32> {
    weights.iter().fold(vec![1.0], |products, axis| {
        axis.iter().flat_map(|weight| products.iter().map(move |product| product * weight)).collect()
    })
}

impl<const D: usize> UnknownCells<D> {
    /// Lists the cells.
    pub fn new(model: &Model<D>, d: &Diffusion<'_, D>) -> Self {
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
        let closed = std::array::from_fn(|a| [0, cells.extent[a]].map(|at| model.on_closed_side(a, at)));
        for a in (0..D).filter(|a| !closed[*a][1]) {
            let last = |p: &u32| {
                let at = lattice.coordinates(*p as usize);
                at[a] + 1 == cells.extent[a] && (0..D).all(|b| at[b] < cells.extent[b])
            };
            let beyond: Vec<u32> =
                list[1..].iter().filter(|p| last(p)).map(|p| p + lattice.stride[a] as u32).collect();
            list.extend(beyond);
        }
        Self { cells: CellList::new(lattice, list, closed), runs }
    }
}
