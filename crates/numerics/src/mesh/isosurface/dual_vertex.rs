//! Position of the vertex of a surface-nets cube.
//!
//! Within the cube the level set is the tensor-product cubic (Lagrange, four points along each axis) of the cell
//! values; beyond a wall it is extrapolated linearly. The vertex starts at the mean of the crossings of the cube's
//! edges, each a root of the cubic along its edge. Two projection steps $-\varphi \nabla\varphi / |\nabla\varphi|^2$
//! follow, clamped to the cube. In a padded cube (one at a wall) the coordinate normal to the wall is fixed in its plane.

use super::{CONTACT_LINE, LIQUID_AIR, LIQUID_SOLID};
use crate::Vector;
use crate::grid::CellField;

/// Projection steps onto the zero set.
const PROJECTION_STEPS: usize = 2;

/// Position (m) and label of the vertex of the cube between the cells `at - 1` and `at`. Bit `Σ_a o_a 2^a` of `corners`
/// is set if corner `o` is liquid.
pub(super) fn dual_vertex<const D: usize>(
    phi: &CellField<D>,
    at: [usize; D],
    corners: u8,
) -> (Vector<D>, u8) {
    let cells = phi.grid.cells;
    let padded: [bool; D] = std::array::from_fn(|a| at[a] == 0 || at[a] == cells[a]);
    let at_wall = padded.contains(&true);
    let mut s = Vector::<D>::repeat(0.5);
    let mut kind = if at_wall { LIQUID_SOLID } else { LIQUID_AIR };
    if !at_wall || has_sign_change(at, &cells, corners) {
        let patch = Patch::new(phi, at);
        s = patch.mean_crossing(corners, &std::array::from_fn(|o| is_cell(at, &cells, o)));
        for (x, _) in s.iter_mut().zip(padded).filter(|(_, p)| *p) {
            *x = 0.5;
        }
        for _ in 0..PROJECTION_STEPS {
            patch.project(&mut s, &padded);
        }
        if at_wall {
            kind = CONTACT_LINE;
        }
    }
    (
        Vector::from_fn(|a, _| phi.grid.domain_coordinate_cells(a, at[a] as f64 - 0.5 + s[a]) * phi.grid.dx),
        kind,
    )
}

/// Whether a corner of a cube is a cell and not padding.
fn is_cell<const D: usize>(at: [usize; D], cells: &[usize; D], corner: usize) -> bool {
    corner >> D == 0 && (0..D).all(|a| (at[a] + (corner >> a & 1)).wrapping_sub(1) < cells[a])
}

/// Whether the cells among a cube's corners include both liquid and air.
fn has_sign_change<const D: usize>(at: [usize; D], cells: &[usize; D], corners: u8) -> bool {
    let mut seen = [false; 2];
    for o in (0..1 << D).filter(|&o| is_cell(at, cells, o)) {
        seen[(corners >> o & 1) as usize] = true;
    }
    seen == [true; 2]
}

/// The $4^D$ values around a cube, first axis fastest. Along each axis points 1 and 2 are the cube's corners.
struct Patch<const D: usize> {
    values: [f64; 64],
}

impl<const D: usize> Patch<D> {
    fn new(phi: &CellField<D>, at: [usize; D]) -> Self {
        let lattice = phi.grid.lattice();
        let inner = (0..D).all(|a| at[a] >= 2 && at[a] + 2 <= lattice.extent[a]);
        let clamped = |a: usize, k: usize| (at[a] + k).saturating_sub(2).min(lattice.extent[a] - 1);
        let mut values = [0.0; 64];
        let rows = if D == 2 { 4 } else { 16 };
        for row in 0..rows {
            let mut base = clamped(1, row & 3) * lattice.stride[1];
            if D == 3 {
                base += clamped(D - 1, row >> 2) * lattice.stride[D - 1];
            }
            let out = &mut values[4 * row..4 * row + 4];
            if inner {
                out.copy_from_slice(&phi.data[base + at[0] - 2..base + at[0] + 2]);
            } else {
                (0..4).for_each(|k| out[k] = phi.data[base + clamped(0, k)]);
            }
        }
        let mut patch = Self { values };
        if !inner {
            (0..D).for_each(|a| patch.continue_linearly(a, at[a], lattice.extent[a]));
        }
        patch
    }

    /// Overwrites the points beyond a wall along an axis by linear extrapolation from the two cells next to it.
    fn continue_linearly(&mut self, axis: usize, at: usize, extent: usize) {
        if extent < 2 {
            return;
        }
        let stride: usize = 1 << (2 * axis);
        let (first, last) = (2usize.saturating_sub(at), (extent + 1 - at).min(3));
        for start in (0..1 << (2 * D)).filter(|i| (i / stride).is_multiple_of(4)) {
            let v = |k: usize| start + k * stride;
            // If the second cell from the wall lies outside the patch, the inner neighbour repeats the first.
            let (a, b) = (self.values[v(first)], self.values[v((first + 1).min(3))]);
            (0..first).for_each(|k| self.values[v(k)] = a + (a - b) * (first - k) as f64);
            let (a, b) = (self.values[v(last)], self.values[v(last.saturating_sub(1))]);
            (last + 1..4).for_each(|k| self.values[v(k)] = a + (a - b) * (k - last) as f64);
        }
    }

    /// Mean of the crossings of the edges between liquid and air cells, in cube coordinates 0 to 1.
    fn mean_crossing(&self, corners: u8, real: &[bool; 8]) -> Vector<D> {
        let (mut sum, mut count) = (Vector::<D>::zeros(), 0.0);
        for a in 0..D {
            for o in (0..1usize << D).filter(|o| o >> a & 1 == 0) {
                let p = o | 1 << a;
                if (corners >> o & 1) == (corners >> p & 1) || !real[o] || !real[p] {
                    continue;
                }
                let line = (0..D).filter(|&b| b != a).map(|b| (1 + (o >> b & 1)) << (2 * b)).sum::<usize>();
                let value = |k: usize| self.values[line + (k << (2 * a))];
                let t = edge_crossing([value(0), value(1), value(2), value(3)]);
                sum += Vector::from_fn(|b, _| if b == a { t } else { (o >> b & 1) as f64 });
                count += 1.0;
            }
        }
        if count > 0.0 { sum / count } else { Vector::repeat(0.5) }
    }

    /// One projection step onto the zero set; keeps fixed coordinates and clamps to the cube.
    fn project(&self, s: &mut Vector<D>, fixed: &[bool; D]) {
        let (value, mut gradient) = self.sample(s);
        for (g, _) in gradient.iter_mut().zip(fixed).filter(|(_, f)| **f) {
            *g = 0.0;
        }
        let slope = gradient.norm_squared();
        let step = value / slope;
        if slope > 0.0 && step.is_finite() {
            *s = (*s - gradient * step).map(|x| x.clamp(0.0, 1.0));
        }
    }

    /// Value and gradient of the tensor-product cubic.
    fn sample(&self, s: &Vector<D>) -> (f64, Vector<D>) {
        let w: [[[f64; 4]; 2]; D] = std::array::from_fn(|a| cubic_weights(s[a]));
        let mut value = 0.0;
        let mut gradient = Vector::<D>::zeros();
        for row in 0..1 << (2 * (D - 1)) {
            let v: &[f64] = &self.values[4 * row..4 * row + 4];
            let along = |n: usize| (0..4).map(|k| w[0][n][k] * v[k]).sum::<f64>();
            let across = |axis: usize| -> f64 {
                (1..D).map(|a| w[a][usize::from(a == axis)][row >> (2 * (a - 1)) & 3]).product()
            };
            let here = along(0);
            value += across(0) * here;
            gradient[0] += across(0) * along(1);
            (1..D).for_each(|a| gradient[a] += across(a) * here);
        }
        (value, gradient)
    }
}

/// Lagrange weights at `s` for the points -1, 0, 1, 2, and their derivatives.
fn cubic_weights(s: f64) -> [[f64; 4]; 2] {
    let (l, r, rr) = (s + 1.0, s - 1.0, s - 2.0);
    let value = [-s * r * rr / 6.0, l * r * rr / 2.0, -l * s * rr / 2.0, l * s * r / 6.0];
    let q = s * s;
    let slope = [
        (-3.0 * q + 6.0 * s - 2.0) / 6.0,
        (3.0 * q - 4.0 * s - 1.0) / 2.0,
        (-3.0 * q + 2.0 * s + 2.0) / 2.0,
        (3.0 * q - 1.0) / 6.0,
    ];
    [value, slope]
}

/// Crossing between the second and third of four values: a root of their cubic, 0 to 1; 0.5 if those two do not differ in
/// sign.
fn edge_crossing(v: [f64; 4]) -> f64 {
    if (v[1] < 0.0) == (v[2] < 0.0) {
        return 0.5;
    }
    let (mut low, mut high) = (0.0, 1.0);
    let mut t = v[1] / (v[1] - v[2]);
    for _ in 0..3 {
        let [w, d] = cubic_weights(t);
        let value: f64 = (0..4).map(|k| w[k] * v[k]).sum();
        let slope: f64 = (0..4).map(|k| d[k] * v[k]).sum();
        if (value < 0.0) == (v[1] < 0.0) {
            low = t
        } else {
            high = t
        }
        let newton = t - value / slope;
        t = if newton >= low && newton <= high { newton } else { 0.5 * (low + high) };
    }
    t
}
