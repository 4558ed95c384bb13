//! The operator of the viscous step, `M + ½ h Φ'` ([`super::viscosity`]), by cells.
//!
//! A weighted strain rate of each cell is found first, then its divergence. In the middle of liquid, where the cell and those beside it are
//! full and apart from solids, the coefficients are constants: along such stretches of a row the operator is a stencil on the velocity, and
//! no coefficient is read. The results are the same to the last bit.

use meniscus_numerics::linalg::LinearOperator;
use meniscus_numerics::{grid::Segment, par, rotation_planes};
use rayon::prelude::*;
use std::sync::{Mutex, PoisonError};

/// Cells per parallel task.
pub const CELLS_PER_TASK: usize = 1024;

/// Coefficients of a cell, of the edges at its lower corner, and of its lower faces.
#[derive(Clone, Copy)]
pub struct Cell<const D: usize> {
    /// Slots of the lower and upper neighbour along each axis.
    pub next: [[u32; 2]; D],
    /// `2 ν h/Δ²` times the liquid fraction of the cell.
    pub normal: f64,
    /// `ν h/Δ²` times the liquid fraction of the box around the lower edge of each plane.
    pub shear: [f64; D],
    /// Masses of the lower faces.
    pub face_mass: [f64; D],
    /// Whether the lower faces are unknowns.
    pub is_unknown: [bool; D],
}

impl<const D: usize> Cell<D> {
    /// A cell without liquid.
    pub fn empty() -> Self {
        Self { next: [[0; 2]; D], normal: 0.0, shear: [0.0; D], face_mass: [0.0; D], is_unknown: [false; D] }
    }

    /// A cell in the middle of liquid; `stiffness` is `ν h/Δ²`.
    pub fn full(next: [[u32; 2]; D], stiffness: f64) -> Self {
        let mut shear = [0.0; D];
        rotation_planes::<D>().iter().enumerate().for_each(|(k, _)| shear[k] = stiffness);
        Self { next, normal: 2.0 * stiffness, shear, face_mass: [1.0; D], is_unknown: [true; D] }
    }

    fn is_full(&self, stiffness: f64) -> bool {
        let Self { normal, shear, face_mass, is_unknown, .. } = Self::full(self.next, stiffness);
        self.normal == normal
            && self.shear == shear
            && self.face_mass == face_mass
            && self.is_unknown == is_unknown
    }
}

/// Consecutive cells of the list.
#[derive(Clone, Copy)]
enum Stretch<const D: usize> {
    /// Cells with coefficients of their own.
    General,
    /// Cells in the middle of liquid.
    Deep(Shifts<D>),
}

/// Distances in the list from a cell to those around it.
#[derive(Clone, Copy, PartialEq)]
struct Shifts<const D: usize> {
    /// To the lower and upper neighbour along each axis.
    next: [[isize; 2]; D],
    /// To the lower neighbour along the first axis of the upper neighbour along the second.
    corner: [[isize; D]; D],
}

/// The operator `M + ½ h Φ'`: mass plus `h` times half the gradient of `Φ`.
pub struct ViscousOperator<const D: usize> {
    /// All cells; the first is a dummy.
    pub cells: Vec<Cell<D>>,
    /// `ν h/Δ²`.
    stiffness: f64,
    /// The stretches, and their places in the list.
    stretches: Vec<Stretch<D>>,
    segments: Vec<Segment>,
    /// Parts of the list whose strain rates general cells read.
    strained: Vec<Segment>,
    /// Weighted strain rates of each cell: along the axes, in the planes.
    strain: Mutex<Vec<[[f64; D]; 2]>>,
}

impl<const D: usize> ViscousOperator<D> {
    /// The operator of these cells; `stiffness` is `ν h/Δ²`.
    pub fn new(cells: Vec<Cell<D>>, stiffness: f64) -> Self {
        let full: Vec<bool> =
            cells.par_iter().with_min_len(CELLS_PER_TASK).map(|c| c.is_full(stiffness)).collect();
        let is_deep = |i: usize| full[i] && cells[i].next.iter().flatten().all(|n| full[*n as usize]);
        let deep: Vec<bool> =
            (0..cells.len()).into_par_iter().with_min_len(CELLS_PER_TASK).map(is_deep).collect();
        let shifts = |i: usize| deep[i].then(|| Shifts::of(&cells, i));
        let (mut stretches, mut segments) = (Vec::new(), Vec::new());
        let mut start = 0;
        while start < cells.len() {
            let here = shifts(start);
            let last = (start + CELLS_PER_TASK).min(cells.len());
            let end = start + 1 + (start + 1..last).take_while(|i| shifts(*i) == here).count();
            segments.push(Segment { row: stretches.len(), start, end });
            stretches.push(here.map_or(Stretch::General, Stretch::Deep));
            start = end;
        }
        let mut needed = vec![false; cells.len()];
        for (i, cell) in cells.iter().enumerate().filter(|(i, _)| !deep[*i]) {
            needed[i] = true;
            cell.next.iter().flatten().for_each(|n| needed[*n as usize] = true);
        }
        let strained = ranges(&needed);
        let strain = Mutex::new(vec![[[0.0; D]; 2]; cells.len()]);
        Self { cells, stiffness, stretches, segments, strained, strain }
    }

    /// Number of cells in deep stretches.
    #[cfg(test)]
    pub fn deep_cells(&self) -> usize {
        let deep = self.stretches.iter().zip(&self.segments).filter(|(s, _)| matches!(s, Stretch::Deep(_)));
        deep.map(|(_, s)| s.end - s.start).sum()
    }

    /// The diagonal.
    pub fn diagonal(&self) -> Vec<f64> {
        let of = |c: &Cell<D>, a: usize| {
            if !c.is_unknown[a] {
                return 0.0;
            }
            let mut sum = c.face_mass[a] + c.normal + self.cells[c.next[a][0] as usize].normal;
            for (k, &(p, q, _)) in rotation_planes::<D>().iter().enumerate() {
                if a == p || a == q {
                    sum += c.shear[k] + self.cells[c.next[p + q - a][1] as usize].shear[k];
                }
            }
            sum
        };
        let mut diagonal = vec![0.0; self.size()];
        let cells = diagonal.par_chunks_mut(D).zip(&self.cells).with_min_len(CELLS_PER_TASK);
        cells.for_each(|(entries, c)| entries.iter_mut().enumerate().for_each(|(a, d)| *d = of(c, a)));
        diagonal
    }
}

impl<const D: usize> Shifts<D> {
    fn of(cells: &[Cell<D>], i: usize) -> Self {
        let shift = |to: u32| to as isize - i as isize;
        let next = cells[i].next;
        let corner = |a: usize, b: usize| cells[next[b][1] as usize].next[a][0];
        Self {
            next: next.map(|sides| sides.map(shift)),
            corner: std::array::from_fn(|a| {
                std::array::from_fn(|b| if a == b { 0 } else { shift(corner(a, b)) })
            }),
        }
    }
}

/// The ranges of at most [`CELLS_PER_TASK`] entries that are set.
fn ranges(set: &[bool]) -> Vec<Segment> {
    let mut out: Vec<Segment> = Vec::new();
    for (i, _) in set.iter().enumerate().filter(|(_, set)| **set) {
        match out.last_mut() {
            Some(last) if last.end == i && i - last.start < CELLS_PER_TASK => last.end += 1,
            _ => out.push(Segment { row: 0, start: i, end: i + 1 }),
        }
    }
    out
}

impl<const D: usize> LinearOperator for ViscousOperator<D> {
    fn size(&self) -> usize {
        self.cells.len() * D
    }

    fn apply(&self, x: &[f64], y: &mut [f64]) {
        let (u, _) = x.as_chunks::<D>();
        let mut strain = self.strain.lock().unwrap_or_else(PoisonError::into_inner);
        par::for_each_segment(&mut strain, 0, &self.strained, |s, part| {
            let cells = &self.cells[s.start..s.end];
            part.iter_mut().zip(cells).enumerate().for_each(|(i, (strain, cell))| {
                *strain = strain_rates(cell, s.start + i, u);
            });
        });
        let strain = &*strain;
        let (v, _) = y.as_chunks_mut::<D>();
        par::for_each_segment(v, 0, &self.segments, |s, part| match &self.stretches[s.row] {
            Stretch::Deep(shifts) => apply_deep(self.stiffness, shifts, s.start, u, part),
            Stretch::General => {
                let cells = &self.cells[s.start..s.end];
                part.iter_mut().zip(cells).enumerate().for_each(|(i, (v, cell))| {
                    *v = divergence(cell, s.start + i, u, strain);
                });
            }
        });
    }
}

/// Weighted strain rates of the cell `i`.
#[inline(always)]
fn strain_rates<const D: usize>(c: &Cell<D>, i: usize, u: &[[f64; D]]) -> [[f64; D]; 2] {
    let (here, mut s) = (u[i], [[0.0; D]; 2]);
    for a in 0..D {
        s[0][a] = c.normal * (u[c.next[a][1] as usize][a] - here[a]);
    }
    for (k, &(p, q, _)) in rotation_planes::<D>().iter().enumerate() {
        let (below, left) = (u[c.next[q][0] as usize][p], u[c.next[p][0] as usize][q]);
        s[1][k] = c.shear[k] * (here[p] - below + here[q] - left);
    }
    s
}

/// The operator in the cell `i`.
#[inline(always)]
fn divergence<const D: usize>(c: &Cell<D>, i: usize, u: &[[f64; D]], strain: &[[[f64; D]; 2]]) -> [f64; D] {
    let (here, mut v) = (&strain[i], [0.0; D]);
    for a in 0..D {
        v[a] = c.face_mass[a] * u[i][a] + strain[c.next[a][0] as usize][0][a] - here[0][a];
    }
    for (k, &(p, q, _)) in rotation_planes::<D>().iter().enumerate() {
        v[p] += here[1][k] - strain[c.next[q][1] as usize][1][k];
        v[q] += here[1][k] - strain[c.next[p][1] as usize][1][k];
    }
    (0..D).filter(|a| !c.is_unknown[*a]).for_each(|a| v[a] = 0.0);
    v
}

/// The operator in a deep stretch from the cell `start` on.
fn apply_deep<const D: usize>(
    stiffness: f64,
    shifts: &Shifts<D>,
    start: usize,
    u: &[[f64; D]],
    v: &mut [[f64; D]],
) {
    let at = |shift: isize| &u[start.wrapping_add_signed(shift)..][..v.len()];
    let (here, next, corner) = (at(0), shifts.next.map(|s| s.map(at)), shifts.corner.map(|s| s.map(at)));
    let normal = 2.0 * stiffness;
    for i in 0..v.len() {
        let h = &here[i];
        let mut value = [0.0; D];
        for a in 0..D {
            let [low, up] = next[a].map(|side| side[i][a]);
            value[a] = h[a] + normal * (h[a] - low) - normal * (up - h[a]);
        }
        for &(p, q, _) in rotation_planes::<D>() {
            // Strain rates at the lower edge of the cell, and at those of the upper neighbours along q and p.
            let ([left, right], [below, above]) =
                (next[p].map(|side| &side[i]), next[q].map(|side| &side[i]));
            let own = stiffness * (h[p] - below[p] + h[q] - left[q]);
            let up_q = stiffness * (above[p] - h[p] + above[q] - corner[p][q][i][q]);
            let up_p = stiffness * (right[p] - corner[q][p][i][p] + right[q] - h[q]);
            value[p] += own - up_q;
            value[q] += own - up_p;
        }
        v[i] = value;
    }
}
