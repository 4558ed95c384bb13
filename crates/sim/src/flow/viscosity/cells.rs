//! The cells whose lower faces are unknowns of the viscous step.

use super::operator::Neighbours;
use super::{AIR_LAYERS, Diffusion, FULL_CELL_DISTANCE_CELLS};
use crate::model::Model;
use meniscus_numerics::grid::{Lattice, Segment};
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

/// Weights of consecutive places along an axis.
#[derive(Clone, Copy)]
pub struct Taps {
    /// Coordinate of the first place.
    pub first: isize,
    /// The weights.
    pub weights: &'static [f32],
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
        let mut list: Vec<u32> = self.list[1..].par_iter().map(parent).collect();
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

    /// Calls `f` with the slots and weights of the listed cells in a box of taps.
    #[inline]
    pub fn for_each_tap(&self, taps: &[Taps; D], mut f: impl FnMut(usize, f32)) {
        let extent = self.lattice.extent;
        let clipped: [(usize, &[f32]); D] = std::array::from_fn(|a| {
            let Taps { first, weights } = taps[a];
            let skip = first.min(0).unsigned_abs().min(weights.len());
            let first = (first.max(0)) as usize;
            (first, &weights[skip..][..(weights.len() - skip).min(extent[a].saturating_sub(first))])
        });
        let rows: usize = clipped[1..].iter().map(|(_, weights)| weights.len()).product();
        for row in 0..rows {
            let (mut rest, mut weight, mut at) = (row, 1.0, [clipped[0].0; D]);
            for a in 1..D {
                let (first, weights) = clipped[a];
                (at[a], weight) = (first + rest % weights.len(), weight * weights[rest % weights.len()]);
                rest /= weights.len();
            }
            let along = clipped[0].1;
            if along.is_empty() {
                continue;
            }
            let slots = &self.slots[self.lattice.index(at)..][..along.len()];
            for (slot, w) in slots.iter().zip(along).filter(|(slot, _)| **slot != 0) {
                f(*slot as usize, weight * w);
            }
        }
    }
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
