//! The pressure solver: conjugate gradients with multigrid on the matrix-free `2D + 1`-point system.

use super::flux_components::flux_components;
use super::multigrid::{
    BLOCK_CELLS, BlockCoefficients, BlockSite, Chunk, DIAGONAL, Hierarchy, LANES, Layout, Level, Operands,
    SpanCoefficients, build_chunks, coarsened, over_chunks_pair, sweep_span,
};
use super::system::{PoissonInput, SparseColumn};
use crate::grid::{CellField, Grid, Run, Runs};
use crate::linalg::krylov::conjugate_gradient_with_workspace;
use crate::linalg::operator::{LinearOperator, Preconditioner, SolveError, SolveLimits, SolveReport};
use crate::linalg::vectors;
use crate::par;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

/// Whether a solve that did not reach the tolerance returns its last iterate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum UnconvergedIterate {
    /// The field is not changed.
    Discard,
    /// The field gets the iterate, from which another solve continues.
    Keep,
}

/// A system on the vectors of a [`PressureSolver`], and how to solve it.
pub(super) struct RelatedSystem<'a, A, M> {
    /// The matrix.
    pub operator: &'a A,
    /// Its preconditioner.
    pub preconditioner: &'a M,
    /// Those floating components of the solver that float in this system too.
    pub floats: &'a [usize],
}

/// A pressure system prepared for solving.
///
/// Internally, vectors hold the unknowns in an order of their own, with some entries between that are always zero;
/// [`gather`](Self::gather), [`scatter`](Self::scatter) and [`entry`](Self::entry) convert. Isolated cells, whose row is all zeros (no
/// face, no Dirichlet value), get the solution 0 for any right-hand side. In floating components (connected by positive coefficients,
/// without any Dirichlet value) the mean is subtracted from the right-hand side and from the solution.
#[derive(Debug)]
pub struct PressureSolver<const D: usize> {
    grid: Grid<D>,
    hierarchy: Hierarchy<D>,
    /// Entries of the cells whose row is all zeros.
    isolated: Vec<usize>,
    /// Vectors that are not in use.
    pool: Mutex<Vec<Vec<f64>>>,
    /// The runs of each floating component, and the number of its cells that are not isolated.
    pub(super) floating: Vec<(Vec<Run>, usize)>,
}

impl<const D: usize> PressureSolver<D> {
    /// Builds the multigrid hierarchy. Time and memory scale with the number of unknowns (plus one word per grid row).
    pub fn new(input: &PoissonInput<D>) -> Self {
        Self::reusing_memory(None, input)
    }

    /// The same in the memory of a solver that is no longer needed, which avoids clearing new pages.
    pub fn reusing_memory(used: Option<Self>, input: &PoissonInput<D>) -> Self {
        let (work, pool) = used.map_or_else(Default::default, |used| (used.hierarchy.into_work(), used.pool));
        let layout = Layout::<D>::new(input.grid.cells, input.unknowns);
        let coarse = coarsened(&layout);
        let severed = AtomicBool::new(false);
        let chunks =
            build_chunks(&layout, coarse.as_ref(), |site, general| assemble(input, site, general, &severed));
        let isolated = isolated(&layout, &chunks);
        let hierarchy = Hierarchy::new(Level { layout, chunks }, coarse, work);
        let mut solver = Self { grid: input.grid, hierarchy, isolated, pool, floating: Vec::new() };
        // Faces without flux may split components that the caller, who goes by cells, sees as one.
        let relabelled = severed.into_inner().then(|| flux_components(input));
        solver.floating = solver.floating_components(input, relabelled.as_ref().unwrap_or(input.unknowns));
        solver
    }

    /// Solves `A x = rhs` to `‖rhs − A x‖₂ ≤ limits.tolerance ‖rhs‖₂` from the initial guess in `x`. Both are dense and
    /// cell-indexed; cells that are no unknowns are neither read nor written. Floating components and isolated cells: see
    /// [`PressureSolver`]; the norm is that of the right-hand side as corrected there.
    ///
    /// # Errors
    /// [`SolveError`] if the tolerance was not reached or a number is not finite; `x` is then unchanged.
    pub fn solve(
        &self,
        rhs: &CellField<D>,
        x: &mut CellField<D>,
        limits: SolveLimits,
    ) -> Result<SolveReport, SolveError> {
        self.solve_with(&self.hierarchy, rhs, x, limits)
    }

    /// The same with another preconditioner.
    ///
    /// # Errors
    /// As [`solve`](Self::solve).
    pub fn solve_with(
        &self,
        preconditioner: &impl Preconditioner,
        rhs: &CellField<D>,
        x: &mut CellField<D>,
        limits: SolveLimits,
    ) -> Result<SolveReport, SolveError> {
        let floats: Vec<usize> = (0..self.floating.len()).collect();
        let system = RelatedSystem { operator: self, preconditioner, floats: &floats };
        self.solve_system(&system, rhs, x, limits, UnconvergedIterate::Discard)
    }

    /// The same for an operator built on this one.
    pub(super) fn solve_system(
        &self,
        system: &RelatedSystem<'_, impl LinearOperator, impl Preconditioner>,
        rhs: &CellField<D>,
        x: &mut CellField<D>,
        limits: SolveLimits,
        unfinished: UnconvergedIterate,
    ) -> Result<SolveReport, SolveError> {
        let RelatedSystem { operator, preconditioner, floats } = *system;
        let mut b = self.take();
        self.gather_into(&rhs.data, &mut b);
        self.project_on(floats, &mut b);
        let mut solution = self.take();
        self.gather_into(&x.data, &mut solution);
        self.project_on(floats, &mut solution);
        let mut work = [(); 3].map(|()| self.take());
        let report =
            conjugate_gradient_with_workspace(operator, preconditioner, &b, &mut solution, limits, &mut work);
        let iterate =
            unfinished == UnconvergedIterate::Keep && matches!(report, Err(SolveError::NotConverged { .. }));
        if report.is_ok() || iterate {
            self.project_on(floats, &mut solution);
            self.scatter(&solution, &mut x.data);
        }
        let mut pool = self.pool.lock().unwrap_or_else(PoisonError::into_inner);
        pool.extend(work.into_iter().chain([b, solution]));
        report
    }

    /// A vector with zeros wherever there is no block.
    fn take(&self) -> Vec<f64> {
        let used = self.pool.lock().unwrap_or_else(PoisonError::into_inner).pop();
        let mut vector = used.unwrap_or_default();
        self.finest().layout.prepare(&mut vector, 2);
        vector
    }

    /// The multigrid V-cycle, for solves of related systems.
    pub fn preconditioner(&self) -> &impl Preconditioner {
        &self.hierarchy
    }

    /// Number of grid levels.
    pub fn levels(&self) -> usize {
        self.hierarchy.levels.len()
    }

    /// Entry of an unknown cell (by its coordinates) in the vectors of this solver.
    pub fn entry(&self, cell: [usize; D]) -> Option<usize> {
        let layout = &self.finest().layout;
        let (at, number) = layout.find(layout.row(cell), cell[0] / BLOCK_CELLS)?;
        let i = cell[0] % BLOCK_CELLS;
        let known = layout.masks[number] >> i & 1 == 1;
        known.then(|| (i + Layout::<D>::parity(cell)) % 2 * layout.half_length + at as usize + i / 2)
    }

    /// The same by the cell's index.
    pub(super) fn entry_of(&self, cell: u32) -> Option<usize> {
        self.entry(self.grid.lattice().coordinates(cell as usize))
    }

    /// The grid.
    pub(super) fn grid(&self) -> &Grid<D> {
        &self.grid
    }

    /// The vector of the unknowns of a dense cell-indexed field.
    pub fn gather(&self, field: &[f64]) -> Vec<f64> {
        let mut vector = vec![0.0; self.size()];
        self.gather_into(field, &mut vector);
        vector
    }

    fn gather_into(&self, field: &[f64], vector: &mut [f64]) {
        let Level { layout, chunks } = self.finest();
        let (first, second) = vector.split_at_mut(layout.half_length);
        over_chunks_pair(chunks, [first, second], |chunk, out| {
            let [first, second] = out;
            self.for_each_block(chunk, |start, mask, at, parity| {
                let at = at - chunk.entries.start..at - chunk.entries.start + LANES;
                let (first, second) = (&mut first[at.clone()], &mut second[at]);
                let (even, odd) = if parity == 0 { (first, second) } else { (second, first) };
                if mask == u16::MAX {
                    for (l, pair) in field[start..start + BLOCK_CELLS].as_chunks::<2>().0.iter().enumerate() {
                        (even[l], odd[l]) = (pair[0], pair[1]);
                    }
                } else {
                    for i in 0..BLOCK_CELLS {
                        let value = if mask >> i & 1 == 1 { field[start + i] } else { 0.0 };
                        *(if i % 2 == 0 { &mut even[i / 2] } else { &mut odd[i / 2] }) = value;
                    }
                }
            });
        });
    }

    /// Writes a vector of the unknowns into a dense cell-indexed field; other cells are not changed.
    pub fn scatter(&self, vector: &[f64], field: &mut [f64]) {
        let Level { layout, chunks } = self.finest();
        let row = self.grid.cells[0];
        let (mut rest, mut done) = (field, 0);
        let mut jobs = Vec::with_capacity(chunks.len());
        for chunk in chunks {
            let Some(last) = layout.block_runs[chunk.block_runs.clone()].last() else { continue };
            let (part, tail) = rest.split_at_mut((last.row as usize + 1) * row - done);
            jobs.push((chunk, done, part));
            (rest, done) = (tail, (last.row as usize + 1) * row);
        }
        par::map_jobs(jobs, |(chunk, offset, part)| {
            self.for_each_block(chunk, |start, mask, at, parity| {
                let (first, second) = (
                    &vector[at..at + LANES],
                    &vector[layout.half_length + at..layout.half_length + at + LANES],
                );
                let (even, odd) = if parity == 0 { (first, second) } else { (second, first) };
                let start = start - offset;
                if mask == u16::MAX {
                    for (l, pair) in
                        part[start..start + BLOCK_CELLS].as_chunks_mut::<2>().0.iter_mut().enumerate()
                    {
                        *pair = [even[l], odd[l]];
                    }
                } else {
                    (0..BLOCK_CELLS).filter(|i| mask >> i & 1 == 1).for_each(|i| {
                        part[start + i] = if i % 2 == 0 { even[i / 2] } else { odd[i / 2] };
                    });
                }
            });
        });
    }

    /// The diagonal of the matrix (1 at entries that belong to no unknown and at isolated cells).
    pub fn diagonal(&self) -> Vec<f64> {
        let half = self.finest().layout.half_length;
        let mut diagonal = vec![1.0; 2 * half];
        for chunk in &self.finest().chunks {
            for span in &chunk.spans {
                for (colour, part) in diagonal.chunks_mut(half).enumerate() {
                    let part =
                        &mut part[span.entry as usize..span.entry as usize + span.blocks as usize * LANES];
                    match span.coefficients {
                        SpanCoefficients::Uniform(value) => part.fill(value * (2 * D) as f64),
                        SpanCoefficients::General(pack) => {
                            let packs = &chunk.packs_f64[colour][pack as usize..];
                            part.chunks_mut(LANES)
                                .zip(packs)
                                .for_each(|(d, p)| d.copy_from_slice(&p[DIAGONAL]));
                        }
                    }
                }
            }
        }
        diagonal
    }

    /// Subtracts the mean in every floating component and sets isolated cells to zero.
    pub fn project(&self, vector: &mut [f64]) {
        self.project_on(&(0..self.floating.len()).collect::<Vec<_>>(), vector);
    }

    fn project_on(&self, floats: &[usize], vector: &mut [f64]) {
        self.isolated.iter().for_each(|entry| vector[*entry] = 0.0);
        for (runs, count) in floats.iter().map(|f| &self.floating[*f]).filter(|(_, count)| *count > 0) {
            let sum: f64 = runs
                .iter()
                .flat_map(|run| self.run_entries(run))
                .map(|entries| vector[entries].iter().sum::<f64>())
                .sum();
            let mean = sum / *count as f64;
            for entries in runs.iter().flat_map(|run| self.run_entries(run)) {
                vector[entries].iter_mut().for_each(|value| *value -= mean);
            }
        }
        self.isolated.iter().for_each(|entry| vector[*entry] = 0.0);
    }

    /// The floating components over which every column sums to zero; its cells that are no unknowns are ignored.
    pub(super) fn floating_with_columns(&self, columns: &[SparseColumn]) -> Vec<usize> {
        let by_entry = |column: &SparseColumn| {
            column.iter().filter_map(|&(cell, v)| self.entry_of(cell).map(|e| (e, v))).collect::<Vec<_>>()
        };
        let columns: Vec<_> = columns.iter().map(by_entry).collect();
        let blind = |floating: &&usize| {
            let runs = self.floating[**floating].0.iter();
            let mut ranges: Vec<_> =
                runs.flat_map(|r| self.run_entries(r)).filter(|r| !r.is_empty()).collect();
            ranges.sort_by_key(|r| r.start);
            let within = |entry: &usize| {
                let k = ranges.partition_point(|r| r.end <= *entry);
                ranges.get(k).is_some_and(|r| r.contains(entry))
            };
            columns.iter().all(|column| {
                let felt = column.iter().filter(|(i, _)| within(i)).map(|(_, v)| v);
                let (sum, size) = felt.fold((0.0, 0.0), |(s, t), v| (s + v, t + v.abs()));
                sum.abs() <= 1e-9 * size
            })
        };
        let all: Vec<usize> = (0..self.floating.len()).collect();
        all.iter().filter(blind).copied().collect()
    }

    fn finest(&self) -> &Level<D> {
        &self.hierarchy.levels[0]
    }

    /// Calls `f` with the first cell, the mask, the entry and the colour of the even cells of every block.
    fn for_each_block(&self, chunk: &Chunk, mut f: impl FnMut(usize, u16, usize, usize)) {
        let layout = &self.finest().layout;
        for stretch in &layout.block_runs[chunk.block_runs.clone()] {
            let parity = Layout::<D>::parity(layout.row_coordinates(stretch.row as usize));
            for b in 0..stretch.blocks as usize {
                let mask = layout.masks[stretch.first_index as usize + b];
                let cell =
                    stretch.row as usize * layout.extent[0] + (stretch.block as usize + b) * BLOCK_CELLS;
                f(cell, mask, stretch.entry as usize + b * LANES, parity);
            }
        }
    }

    /// Entries of the cells of a run.
    fn run_entries(&self, run: &Run) -> [std::ops::Range<usize>; 2] {
        let layout = &self.finest().layout;
        let (row, start, end) = (run.row as usize, run.start as usize, run.end as usize);
        let Some((entry, _)) = layout.find(row, start / BLOCK_CELLS) else { return [0..0, 0..0] };
        let parity = Layout::<D>::parity(layout.row_coordinates(row));
        std::array::from_fn(|odd| {
            let shift =
                (odd + parity) % 2 * layout.half_length + entry as usize - start / BLOCK_CELLS * LANES;
            shift + (start + 1 - odd) / 2..shift + (end + 1 - odd) / 2
        })
    }

    /// The components without Dirichlet values.
    fn floating_components(&self, input: &PoissonInput<D>, unknowns: &Runs) -> Vec<(Vec<Run>, usize)> {
        let mut has_dirichlet = vec![false; unknowns.components as usize];
        for run in &unknowns.runs {
            let row = run.row as usize * self.grid.cells[0];
            let cells = row + run.start as usize..row + run.end as usize;
            if !has_dirichlet[run.component as usize] && input.dirichlet.data[cells].iter().any(|d| *d > 0.0)
            {
                has_dirichlet[run.component as usize] = true;
            }
        }
        let mut slot = vec![usize::MAX; has_dirichlet.len()];
        let mut floating = Vec::new();
        for run in unknowns.runs.iter().filter(|run| !has_dirichlet[run.component as usize]) {
            let slot = &mut slot[run.component as usize];
            if *slot == usize::MAX {
                *slot = floating.len();
                floating.push((Vec::new(), 0));
            }
            let lone = |entries: &std::ops::Range<usize>| {
                let from = self.isolated.partition_point(|e| *e < entries.start);
                entries.len() - (self.isolated.partition_point(|e| *e < entries.end) - from)
            };
            floating[*slot].1 += self.run_entries(run).iter().map(lone).sum::<usize>();
            floating[*slot].0.push(*run);
        }
        floating
    }
}

impl<const D: usize> LinearOperator for PressureSolver<D> {
    fn size(&self) -> usize {
        2 * self.finest().layout.half_length
    }

    fn apply(&self, x: &[f64], y: &mut [f64]) {
        self.apply_dot(x, y);
    }

    fn apply_dot(&self, x: &[f64], y: &mut [f64]) -> f64 {
        let Level { layout, chunks } = self.finest();
        let (x0, x1) = x.split_at(layout.half_length);
        let (y0, y1) = y.split_at_mut(layout.half_length);
        let parts = over_chunks_pair(chunks, [y0, y1], |chunk, out| {
            let mut sums = [0.0; LANES];
            let [y0, y1] = out;
            for span in &chunk.spans {
                let range = span.entry as usize..span.entry as usize + span.blocks as usize * LANES;
                let local = range.start - chunk.entries.start..range.end - chunk.entries.start;
                for colour in 0..2 {
                    let (own, other) = if colour == 0 { (x0, x1) } else { (x1, x0) };
                    let out = if colour == 0 { &mut y0[local.clone()] } else { &mut y1[local.clone()] };
                    let packs = &chunk.packs_f64[colour];
                    let operands = Operands { colour, packs, scale: 1.0, other, own: [own, own] };
                    sweep_span::<f64, D>(span, &operands, out, |row| row.diagonal * row.a - row.sum);
                    vectors::dot_lanes(out, &own[range.clone()], &mut sums);
                }
            }
            sums.iter().sum::<f64>()
        });
        parts.iter().sum()
    }
}

/// Reads the coefficients of a block of the finest level; returns the value if they are all equal. Sets `severed` if one
/// between two unknowns is zero.
fn assemble<const D: usize>(
    input: &PoissonInput<D>,
    site: &BlockSite<D>,
    general: &mut BlockCoefficients,
    severed: &AtomicBool,
) -> Option<f64> {
    let cell = input.grid.lattice().index(site.at);
    let faces: [(usize, usize); D] = std::array::from_fn(|a| {
        let lattice = input.grid.face_lattice(a);
        (lattice.index(site.at), lattice.stride[a])
    });
    let full = site.neighbour_masks.as_flattened().iter().fold(site.mask, |all, mask| all & mask) == u16::MAX;
    if full {
        let value = input.coefficients.axes[0][faces[0].0];
        let same = |values: &[f64]| values.iter().fold(true, |ok, v| ok & (*v == value));
        let uniform = value > 0.0
            && input.dirichlet.data[cell..cell + BLOCK_CELLS].iter().fold(true, |ok, d| ok & (*d == 0.0))
            && (0..D).all(|a| {
                let (face, stride) = faces[a];
                let data = &input.coefficients.axes[a];
                same(&data[face..face + BLOCK_CELLS])
                    && same(&data[face + stride..face + stride + BLOCK_CELLS])
            });
        if uniform {
            return Some(value);
        }
    }
    let parity = Layout::<D>::parity(site.at);
    for i in (0..BLOCK_CELLS).filter(|i| site.mask >> i & 1 == 1) {
        let (colour, lane) = ((i + parity) % 2, i / 2);
        for (a, (face, stride)) in faces.into_iter().enumerate() {
            for side in (0..2).filter(|side| site.neighbour_masks[a][*side] >> i & 1 == 1) {
                let value = input.coefficients.axes[a][face + i + side * stride];
                if value == 0.0 {
                    severed.store(true, Ordering::Relaxed);
                }
                general.packs[colour][2 * a + side][lane] = value;
            }
        }
        general.dirichlet[colour][lane] = input.dirichlet.data[cell + i];
    }
    None
}

/// Entries of the unknowns whose row is all zeros, sorted.
fn isolated<const D: usize>(layout: &Layout<D>, chunks: &[Chunk]) -> Vec<usize> {
    let mut entries = Vec::new();
    for chunk in chunks {
        let mut kinds = chunk.block_coefficients.iter();
        for stretch in &layout.block_runs[chunk.block_runs.clone()] {
            let parity = Layout::<D>::parity(layout.row_coordinates(stretch.row as usize));
            for b in 0..stretch.blocks as usize {
                let Some(SpanCoefficients::General(pack)) = kinds.next() else { continue };
                let mask = layout.masks[stretch.first_index as usize + b];
                for i in (0..BLOCK_CELLS).filter(|i| mask >> i & 1 == 1) {
                    let (colour, lane) = ((i + parity) % 2, i / 2);
                    let wide = &chunk.packs_f64[colour][*pack as usize];
                    let empty = (0..DIAGONAL).all(|k| wide[k][lane] == 0.0);
                    if empty && chunk.dirichlet[colour][*pack as usize][lane] == 0.0 {
                        entries.push(colour * layout.half_length + stretch.entry as usize + b * LANES + lane);
                    }
                }
            }
        }
    }
    entries.sort_unstable();
    entries
}
