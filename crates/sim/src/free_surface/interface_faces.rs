//! Faces between liquid and air (ghost fluid): where the interface crosses between two cell centres, and its curvature there.

use super::curvature::Curvature;
use crate::model::Model;
use meniscus_numerics::grid::{Band, CellField, CutCells, Sampler};
use meniscus_numerics::par;

/// Smallest distance of the interface from the liquid's cell centre, as a fraction of a cell: the pressure system divides by it.
const MIN_THETA: f64 = 0.02;
/// Maximum number of iterations to the root of a cubic; each shrinks its bracket.
const MAX_ROOT_ITERATIONS: usize = 30;

/// A face between a liquid cell and air.
#[derive(Clone, Copy, Debug)]
pub struct InterfaceFace {
    /// Normal axis.
    pub axis: usize,
    /// Position in the face lattice.
    pub face: usize,
    /// The liquid cell.
    pub cell: usize,
    /// +1 where the air is above, −1 where it is below.
    pub sign: f64,
    /// Fraction of the segment from the liquid's cell centre to the interface.
    pub theta: f64,
    /// Curvature there, 1/cells.
    pub kappa: f64,
    /// Whether the curvature is known; otherwise it is 0.
    pub is_curvature_known: bool,
    /// Open fraction of the face.
    pub open_fraction: f64,
    /// Fraction of an impulse that remains after drag, 0 to 1.
    pub mobility: f64,
}

/// Finds the interface faces, with the position (cubic root) and curvature of the interface.
pub fn interface_faces<const D: usize>(
    model: &Model<D>,
    phi: &CellField<D>,
    band: &Band<D>,
    curvature: &Curvature,
    solids: &CutCells<D>,
) -> Vec<InterfaceFace> {
    let lattice = model.grid.lattice();
    let sampler = Sampler::cells(&model.grid, &phi.data, model.scalar_boundary());
    let value = |slot: Option<usize>| {
        slot.filter(|s| curvature.known.get(*s) == Some(&true)).map(|s| curvature.kappa[s])
    };
    let find = |cell: usize, at: [usize; D], n: usize| {
        let (axis, up) = (n / 2, n % 2);
        let edge = if up == 1 { at[axis] + 1 == lattice.extent[axis] } else { at[axis] == 0 };
        let other =
            if up == 1 { cell + lattice.stride[axis] } else { cell.wrapping_sub(lattice.stride[axis]) };
        if edge || phi.data[other] < 0.0 {
            return None;
        }
        let step = if up == 1 { 1 } else { -1 };
        let theta = interface_crossing(&sampler, at, axis, step).clamp(MIN_THETA, 1.0);
        let here = value(band.slot(cell));
        let there = value(band.slot(other));
        let kappa = match (here, there) {
            (Some(i), Some(a)) => Some((1.0 - theta) * i + theta * a),
            (one, other) => one.or(other),
        };
        let mut face = at;
        face[axis] += up;
        let face = model.grid.face_lattice(axis).index(face);
        let open_fraction = solids.open_fraction.axes[axis][face];
        (open_fraction > 0.0).then_some(InterfaceFace {
            axis,
            face,
            cell,
            sign: step as f64,
            theta,
            kappa: kappa.unwrap_or(0.0),
            is_curvature_known: kappa.is_some(),
            open_fraction,
            mobility: 1.0,
        })
    };
    let layer = &band.cells[band.first_layers(1)];
    par::flat_map(layer.len(), 1, |i, faces| {
        let cell = layer[i] as usize;
        if phi.data[cell] < 0.0 {
            let at = lattice.coordinates(cell);
            faces.extend((0..2 * D).filter_map(|n| find(cell, at, n)));
        }
    })
}

/// Fraction of the segment from the centre of liquid cell `at` to its neighbour's at which the cubic through four values is zero.
fn interface_crossing<const D: usize>(
    sampler: &Sampler<'_, D>,
    at: [usize; D],
    axis: usize,
    step: isize,
) -> f64 {
    let value = |n: isize| {
        let mut cell = at.map(|i| i as isize);
        cell[axis] += n * step;
        sampler.value(cell)
    };
    let f = [value(-1), value(0), value(1), value(2)];
    let linear = f[1] / (f[1] - f[2]);
    let cubic = |t: f64| {
        let (a, b, c) = (t + 1.0, t - 1.0, t - 2.0);
        -t * b * c / 6.0 * f[0] + a * b * c / 2.0 * f[1] - a * t * c / 2.0 * f[2] + a * t * b / 6.0 * f[3]
    };
    // The cubic has the signs of its end values: regula falsi, with the other end's value halved, cannot leave the segment.
    let (mut low, mut high, mut at_low, mut at_high) = (0.0, 1.0, f[1], f[2]);
    let mut t = linear;
    for _ in 0..MAX_ROOT_ITERATIONS {
        let v = cubic(t);
        if v.abs() <= 1e-13 * (f[2] - f[1]) {
            break;
        }
        if v < 0.0 {
            (low, at_low, at_high) = (t, v, 0.5 * at_high);
        } else {
            (high, at_high, at_low) = (t, v, 0.5 * at_low);
        }
        t = (low * at_high - high * at_low) / (at_high - at_low);
    }
    t
}
