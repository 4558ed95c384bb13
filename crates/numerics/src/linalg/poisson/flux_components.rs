//! Connected components of the pressure system, where faces without flux may cut the liquid apart.

use super::system::PoissonInput;
use crate::grid::{Run, Runs};

/// The unknowns, labelled with components connected by positive coefficients; runs are split at faces without flux.
pub(super) fn flux_components<const D: usize>(input: &PoissonInput<D>) -> Runs {
    let mut pieces = split_at_zero_coefficients(input);
    let mut parents: Vec<u32> = (0..pieces.len() as u32).collect();
    let mut stride = 1;
    for axis in 1..D {
        for lower in 0..pieces.len() {
            join_above(input, &pieces, lower, axis, stride, &mut parents);
        }
        stride *= input.grid.cells[axis] as u32;
    }
    let mut labels = vec![u32::MAX; pieces.len()];
    let mut components = 0;
    for (number, piece) in (0..).zip(&mut pieces) {
        let root = root(&mut parents, number) as usize;
        if labels[root] == u32::MAX {
            labels[root] = components;
            components += 1;
        }
        piece.component = labels[root];
    }
    Runs { runs: pieces, components }
}

/// The runs, split where the coefficient between two cells is zero.
fn split_at_zero_coefficients<const D: usize>(input: &PoissonInput<D>) -> Vec<Run> {
    let mut pieces = Vec::with_capacity(input.unknowns.runs.len());
    for run in &input.unknowns.runs {
        let faces = run.row as usize * (input.grid.cells[0] + 1);
        let mut piece = *run;
        for i in run.start + 1..run.end {
            if input.coefficients.axes[0][faces + i as usize] == 0.0 {
                pieces.push(Run { end: i, ..piece });
                piece.start = i;
            }
        }
        pieces.push(piece);
    }
    pieces
}

/// Joins a piece with those above it along an axis.
fn join_above<const D: usize>(
    input: &PoissonInput<D>,
    pieces: &[Run],
    lower: usize,
    axis: usize,
    stride: u32,
    parents: &mut [u32],
) {
    let piece = pieces[lower];
    let extent = input.grid.cells[axis] as u32;
    if piece.row / stride % extent + 1 == extent {
        return;
    }
    let above = piece.row + stride;
    let mut at = input.grid.lattice().coordinates(above as usize * input.grid.cells[0]);
    at[0] = 0;
    let faces = input.grid.face_lattice(axis).index(at);
    let first = pieces.partition_point(|p| (p.row, p.end) <= (above, piece.start));
    for (number, upper) in pieces.iter().enumerate().skip(first) {
        if upper.row != above || upper.start >= piece.end {
            return;
        }
        let overlap =
            faces + piece.start.max(upper.start) as usize..faces + piece.end.min(upper.end) as usize;
        if input.coefficients.axes[axis][overlap].iter().any(|c| *c != 0.0) {
            let (a, b) = (root(parents, lower as u32), root(parents, number as u32));
            parents[a.max(b) as usize] = a.min(b);
        }
    }
}

/// The representative of a piece.
fn root(parents: &mut [u32], mut number: u32) -> u32 {
    while parents[number as usize] != number {
        let above = parents[number as usize];
        parents[number as usize] = parents[above as usize];
        number = above;
    }
    number
}
