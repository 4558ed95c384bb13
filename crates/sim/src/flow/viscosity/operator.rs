//! The operator of the viscous step, `M + ½ h Φ'` ([`super`]), by cells.
//!
//! In the middle of liquid, where the cell and those beside it are full and apart from solids, the coefficients are constants: along such
//! stretches of a row the operator is a stencil on the velocity. Only the other cells have coefficients of their own: of these a weighted
//! strain rate is found first, then its divergence. Where both apply, the results are the same to the last bit.
//!
//! A vector holds the components of the velocity one behind the other, each in the order of the list of cells.

use meniscus_numerics::linalg::{Jacobi, LinearOperator, Real, dot_serial};
use meniscus_numerics::{grid::Segment, par, rotation_planes};
use std::ops::Range;
use std::sync::{Mutex, PoisonError};

/// Cells per parallel task.
pub const CELLS_PER_TASK: usize = 1024;

/// Slots of the lower and upper neighbour of a cell along each axis; 0: none.
pub type Neighbours<const D: usize> = [[u32; 2]; D];

/// Coefficients of a cell, of the edges at its lower corner, and of its lower faces.
#[derive(Clone, Copy)]
pub struct Cell<const D: usize> {
    /// The cells beside it.
    pub next: Neighbours<D>,
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
    pub fn full(next: Neighbours<D>, stiffness: f64) -> Self {
        let mut shear = [0.0; D];
        rotation_planes::<D>().iter().enumerate().for_each(|(k, _)| shear[k] = stiffness);
        Self { next, normal: 2.0 * stiffness, shear, face_mass: [1.0; D], is_unknown: [true; D] }
    }

    /// Whether this cell has the coefficients of one in the middle of liquid, and neighbours all around.
    pub fn is_full(&self, stiffness: f64) -> bool {
        let Self { normal, shear, face_mass, is_unknown, .. } = Self::full(self.next, stiffness);
        self.next.iter().flatten().all(|n| *n != 0)
            && (self.normal, self.shear, self.face_mass) == (normal, shear, face_mass)
            && self.is_unknown == is_unknown
    }
}

/// Consecutive cells of the list.
#[derive(Clone, Copy)]
enum Stretch<const D: usize> {
    /// Cells with coefficients of their own, from this one on.
    General(usize),
    /// Cells in the middle of liquid.
    Deep(Shifts<D>),
}

/// Distances in the list from a cell to those around it.
#[derive(Clone, Copy)]
struct Shifts<const D: usize> {
    /// To the lower and upper neighbour along each axis.
    next: [[isize; 2]; D],
    /// To the lower neighbour along the first axis of the upper neighbour along the second.
    corner: [[isize; D]; D],
}

/// The operator `M + ½ h Φ'`: mass plus `h` times half the gradient of `Φ`.
pub struct ViscousOperator<const D: usize> {
    /// Number of cells of the list; the first is a dummy.
    count: usize,
    /// The coefficients of the cells outside deep stretches, and of those beside them, in the order of the list.
    pub cells: Vec<Cell<D>>,
    /// Place of each cell of the list among these; 0: none, but for the first.
    place: Vec<u32>,
    /// The coefficients of a cell in the middle of liquid, without its neighbours.
    full: Cell<D>,
    /// `ν h/Δ²`.
    stiffness: f64,
    /// The stretches.
    stretches: Vec<Stretch<D>>,
    /// Their parts of the list.
    segments: Vec<Segment>,
    /// Parts of the list whose strain rates general cells read; the row is the place of the coefficients of the first.
    strained: Vec<Segment>,
    /// Weighted strain rates of each cell: along the axes, in the planes.
    strain: Mutex<Vec<[[f64; D]; 2]>>,
}

impl<const D: usize> ViscousOperator<D> {
    /// The operator of the listed cells, of which those in the middle of liquid, with full cells around them, are marked `deep`. `next` and
    /// `coefficients` take a cell's place in the list. `stiffness` is `ν h/Δ²`.
    pub fn new(
        deep: &[bool],
        next: impl Fn(usize) -> Neighbours<D> + Sync,
        coefficients: impl Fn(usize) -> Cell<D> + Sync,
        stiffness: f64,
    ) -> Self {
        let count = deep.len();
        let mut stored: Vec<bool> = deep.iter().map(|deep| !deep).collect();
        let beside = par::filter_map(count, CELLS_PER_TASK, |i| (!deep[i]).then(|| next(i)));
        beside.as_flattened().as_flattened().iter().for_each(|n| stored[*n as usize] = true);
        let (mut list, mut place) = (Vec::new(), vec![0; count]);
        for i in (0..count).filter(|i| stored[*i]) {
            place[i] = list.len() as u32;
            list.push(i);
        }
        let cells = par::map_slice(&list, CELLS_PER_TASK, |i| coefficients(*i));
        let strained = equal_ranges(&stored).into_iter().filter(|r| stored[r.start]);
        let strained = strained.map(|r| Segment { row: place[r.start] as usize, start: r.start, end: r.end });
        let strained = strained.collect();
        let parts = equal_ranges(deep);
        let stretch = |part: &Range<usize>| match place[part.start] as usize {
            _ if deep[part.start] => Stretch::Deep(Shifts::of(&next, part.start)),
            first => Stretch::General(first),
        };
        let stretches = parts.iter().map(stretch).collect();
        let segments =
            parts.iter().map(|part| Segment { row: 0, start: part.start, end: part.end }).collect();
        let strain = Mutex::new(vec![[[0.0; D]; 2]; count]);
        let full = Cell::full([[0; 2]; D], stiffness);
        Self { count, cells, place, full, stiffness, stretches, segments, strained, strain }
    }

    /// The coefficients of a cell of the list; those of one in the middle of liquid may lack its neighbours.
    pub fn cell(&self, i: usize) -> &Cell<D> {
        match self.place[i] as usize {
            0 if i > 0 => &self.full,
            place => &self.cells[place],
        }
    }

    /// The diagonal.
    pub fn diagonal(&self) -> Vec<f64> {
        self.map_diagonal(|entry| entry)
    }

    /// Division by the diagonal; entries that are zero divide to zero.
    pub fn jacobi(&self) -> Jacobi<f32> {
        Jacobi::of_inverse(self.map_diagonal(|entry| if entry > 0.0 { (1.0 / entry) as f32 } else { 0.0 }))
    }

    fn map_diagonal<T: Real>(&self, f: impl Fn(f64) -> T + Sync) -> Vec<T> {
        let deep = self.diagonal_of(&self.full, &|_| &self.full).map(&f);
        let mut diagonal = vec![f(0.0); self.count * D];
        par::map_component_segments(
            &mut diagonal,
            self.count,
            &self.segments,
            |number, s, mut parts: [_; D]| match &self.stretches[number] {
                Stretch::Deep(_) => parts.iter_mut().zip(deep).for_each(|(part, deep)| part.fill(deep)),
                Stretch::General(first) => {
                    for (i, cell) in self.cells[*first..][..s.end - s.start].iter().enumerate() {
                        let own = self.diagonal_of(cell, &|n| self.cell(n)).map(&f);
                        parts.iter_mut().zip(own).for_each(|(part, own)| part[i] = own);
                    }
                }
            },
        );
        diagonal
    }

    /// The stretches of cells that are not in the middle of liquid: parts of the list, and their coefficients.
    pub fn general_stretches(&self) -> (Vec<Segment>, Vec<&[Cell<D>]>) {
        let all = self.stretches.iter().zip(&self.segments);
        all.filter_map(|(stretch, s)| match stretch {
            Stretch::General(first) => Some((*s, &self.cells[*first..][..s.end - s.start])),
            Stretch::Deep(_) => None,
        })
        .unzip()
    }

    /// The product of the face masses and a vector.
    pub fn times_face_mass(&self, x: &[f64]) -> Vec<f64> {
        let (mut product, x) = (vec![0.0; x.len()], self.components(x));
        par::map_component_segments(&mut product, self.count, &self.segments, |number, s, parts: [_; D]| {
            for (a, part) in parts.into_iter().enumerate() {
                let part: &mut [f64] = part;
                part.copy_from_slice(&x[a][s.start..s.end]);
                if let Stretch::General(first) = &self.stretches[number] {
                    part.iter_mut().zip(&self.cells[*first..]).for_each(|(p, cell)| *p *= cell.face_mass[a]);
                }
            }
        });
        product
    }

    /// The entries of the diagonal of a cell; `beside` takes the places of its neighbours in the list.
    fn diagonal_of<'a>(&self, c: &Cell<D>, beside: &dyn Fn(usize) -> &'a Cell<D>) -> [f64; D] {
        std::array::from_fn(|a| {
            if !c.is_unknown[a] {
                return 0.0;
            }
            let mut sum = c.face_mass[a] + c.normal + beside(c.next[a][0] as usize).normal;
            for (k, &(p, q, _)) in rotation_planes::<D>().iter().enumerate() {
                if a == p || a == q {
                    sum += c.shear[k] + beside(c.next[p + q - a][1] as usize).shear[k];
                }
            }
            sum
        })
    }

    /// Number of cells in deep stretches.
    #[cfg(test)]
    pub fn deep_cells(&self) -> usize {
        self.count - self.general_stretches().0.iter().map(|s| s.end - s.start).sum::<usize>()
    }

    /// The components of a vector.
    fn components<'a, T>(&self, x: &'a [T]) -> [&'a [T]; D] {
        std::array::from_fn(|a| &x[a * self.count..][..self.count])
    }
}

impl<const D: usize> Shifts<D> {
    fn of(next: impl Fn(usize) -> Neighbours<D>, i: usize) -> Self {
        let shift = |to: u32| to as isize - i as isize;
        let own = next(i);
        let corner = |a: usize, b: usize| next(own[b][1] as usize)[a][0];
        Self {
            next: own.map(|sides| sides.map(shift)),
            corner: std::array::from_fn(|a| {
                std::array::from_fn(|b| if a == b { 0 } else { shift(corner(a, b)) })
            }),
        }
    }
}

/// The longest ranges of at most [`CELLS_PER_TASK`] equal entries.
fn equal_ranges(marks: &[bool]) -> Vec<Range<usize>> {
    let mut out: Vec<Range<usize>> = Vec::new();
    for (i, mark) in marks.iter().enumerate() {
        match out.last_mut() {
            Some(last) if marks[last.start] == *mark && last.len() < CELLS_PER_TASK => last.end = i + 1,
            _ => out.push(i..i + 1),
        }
    }
    out
}

impl<T: Real, const D: usize> LinearOperator<T> for ViscousOperator<D> {
    fn size(&self) -> usize {
        self.count * D
    }

    fn apply(&self, x: &[T], y: &mut [T]) {
        self.apply_dot(x, y);
    }

    fn apply_dot(&self, x: &[T], y: &mut [T]) -> f64 {
        let u = self.components(x);
        let mut strain = self.strain.lock().unwrap_or_else(PoisonError::into_inner);
        let strained = |s: &Segment, part: &mut [[[f64; D]; 2]]| {
            let cells = &self.cells[s.row..];
            part.iter_mut().zip(cells).enumerate().for_each(|(i, (strain, cell))| {
                *strain = strain_rates(cell, s.start + i, &u);
            });
        };
        par::for_each_segment(&mut strain, 0, &self.strained, strained);
        let strain = &*strain;
        let products =
            par::map_component_segments(y, self.count, &self.segments, |number, s, v: [&mut [T]; D]| {
                match &self.stretches[number] {
                    Stretch::Deep(shifts) => apply_deep(self.stiffness, shifts, s.start, &u, v),
                    Stretch::General(first) => {
                        let cells = &self.cells[*first..][..s.end - s.start];
                        divergence(cells, s.start, &u, strain, v)
                    }
                }
            });
        products.iter().sum()
    }
}

/// Weighted strain rates of the cell `i`.
#[inline(always)]
fn strain_rates<T: Real, const D: usize>(c: &Cell<D>, i: usize, u: &[&[T]; D]) -> [[f64; D]; 2] {
    let value = |a: usize, i: usize| u[a][i].to_f64();
    let mut s = [[0.0; D]; 2];
    for a in 0..D {
        s[0][a] = c.normal * (value(a, c.next[a][1] as usize) - value(a, i));
    }
    for (k, &(p, q, _)) in rotation_planes::<D>().iter().enumerate() {
        let (below, left) = (value(p, c.next[q][0] as usize), value(q, c.next[p][0] as usize));
        s[1][k] = c.shear[k] * (value(p, i) - below + value(q, i) - left);
    }
    s
}

/// The operator in these cells, of which `start` is the first; returns the sum of its products with `u`.
fn divergence<T: Real, const D: usize>(
    cells: &[Cell<D>],
    start: usize,
    u: &[&[T]; D],
    strain: &[[[f64; D]; 2]],
    v: [&mut [T]; D],
) -> f64 {
    let mut product = 0.0;
    for (offset, c) in cells.iter().enumerate() {
        let i = start + offset;
        let (here, mut sum) = (&strain[i], [0.0; D]);
        for a in 0..D {
            sum[a] = c.face_mass[a] * u[a][i].to_f64() + strain[c.next[a][0] as usize][0][a] - here[0][a];
        }
        for (k, &(p, q, _)) in rotation_planes::<D>().iter().enumerate() {
            sum[p] += here[1][k] - strain[c.next[q][1] as usize][1][k];
            sum[q] += here[1][k] - strain[c.next[p][1] as usize][1][k];
        }
        for a in 0..D {
            let sum = if c.is_unknown[a] { sum[a] } else { 0.0 };
            v[a][offset] = T::from_f64(sum);
            product += u[a][i].to_f64() * sum;
        }
    }
    product
}

/// Cells of a deep stretch that go at once.
const BLOCK: usize = 16;

/// The operator in a deep stretch from the cell `start` on; returns the sum of its products with `u`.
fn apply_deep<T: Real, const D: usize>(
    stiffness: f64,
    shifts: &Shifts<D>,
    start: usize,
    u: &[&[T]; D],
    v: [&mut [T]; D],
) -> f64 {
    let mut product = 0.0;
    let stiffness = T::from_f64(stiffness);
    for (a, v) in v.into_iter().enumerate() {
        let count = v.len();
        // The last block overlaps the one before it, so that no cell goes alone.
        for end in (BLOCK..count + BLOCK).step_by(BLOCK).map(|end| end.min(count)) {
            let first = end.saturating_sub(BLOCK);
            match v[first..end].as_chunks_mut::<BLOCK>() {
                ([block], []) => deep_row(stiffness, shifts, a, start + first, u, block),
                (_, few) => deep_row(stiffness, shifts, a, start + first, u, few),
            }
        }
        product += dot_serial(&u[a][start..][..count], v);
    }
    product
}

/// The row of component `a` of the operator in consecutive deep cells from the cell `start` on.
#[inline(always)]
fn deep_row<T: Real, const D: usize>(
    stiffness: T,
    shifts: &Shifts<D>,
    a: usize,
    start: usize,
    u: &[&[T]; D],
    v: &mut [T],
) {
    let count = v.len();
    let at = |component: usize, shift: isize| &u[component][start.wrapping_add_signed(shift)..][..count];
    let (here, [low, up]) = (at(a, 0), shifts.next[a].map(|shift| at(a, shift)));
    let normal = stiffness + stiffness;
    for i in 0..count {
        v[i] = here[i] + normal * (here[i] - low[i]) - normal * (up[i] - here[i]);
    }
    for &(p, q, _) in rotation_planes::<D>().iter().filter(|(p, q, _)| a == *p || a == *q) {
        let b = p + q - a;
        let ([below, above], beside) = (shifts.next[b].map(|shift| at(a, shift)), at(b, 0));
        let [left, over] = [shifts.next[a][0], shifts.next[b][1]].map(|shift| at(b, shift));
        let corner = at(b, shifts.corner[a][b]);
        // The shear rate of the values of `a` and `b` and of those of the cells below, in the order of [`strain_rates`].
        let rate = |a_here: T, a_low: T, b_here: T, b_low: T| {
            let sum = if a == p { a_here - a_low + b_here - b_low } else { b_here - b_low + a_here - a_low };
            stiffness * sum
        };
        for i in 0..count {
            let own = rate(here[i], below[i], beside[i], left[i]);
            v[i] = v[i] + (own - rate(above[i], here[i], over[i], corner[i]));
        }
    }
}
