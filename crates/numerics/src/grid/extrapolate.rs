//! Velocity beyond the liquid.
//!
//! Layer by layer outward from the faces where it is known, each face takes the values of its neighbours on the
//! liquid's side, extended along each axis and weighted by the components of the normal (the upwind form of Aslam 2004,
//! "A partial differential equation approach to multidimensional extrapolation", done in one sweep): quadratically in
//! the first layer, linearly in the second, but only where that order would have foretold the last value known, and
//! constantly elsewhere. What a parabola makes of noise is seven times as large: taken everywhere, it drove torn sheets
//! to any speed.

use super::{Band, FaceField, Grid, Sampler, Segment};
use rayon::prelude::*;

/// Layers in which the extension is linear.
const LINEAR: usize = 2;
/// Layers in which it is quadratic: linear there costs a capillary wave 0.08 (kΔ)² of its frequency.
const QUADRATIC: usize = 1;
/// Error of a forecast of the last known value, over that value's step, up to which its order is trusted: waves of 13
/// cells still are.
const TRUSTED: f64 = 0.25;

/// Which faces carry a velocity, and in which layer they got it.
#[derive(Clone, Debug)]
pub struct KnownFaces<const D: usize> {
    grid: Grid<D>,
    /// 0: unknown; 1: in the liquid; `l + 2`: extended in layer `l`.
    marks: [Vec<u8>; D],
    extended: [Vec<u32>; D],
    segments: [Vec<Segment>; D],
}

impl<const D: usize> KnownFaces<D> {
    /// No face is known.
    pub fn new(grid: Grid<D>) -> Self {
        Self {
            grid,
            marks: std::array::from_fn(|a| vec![0; grid.faces(a).len()]),
            extended: std::array::from_fn(|_| Vec::new()),
            segments: std::array::from_fn(|_| Vec::new()),
        }
    }

    /// Forgets all, and sets the velocity of the forgotten faces to zero.
    pub fn clear(&mut self, velocity: &mut FaceField<D>) {
        for a in 0..D {
            let row = self.grid.faces(a).extent[0];
            for s in &self.segments[a] {
                velocity.axes[a][s.row * row + s.start..s.row * row + s.end].fill(0.0);
            }
            self.extended[a].iter().for_each(|&f| velocity.axes[a][f as usize] = 0.0);
        }
        self.forget();
    }

    /// Forgets all.
    pub fn forget(&mut self) {
        for a in 0..D {
            let row = self.grid.faces(a).extent[0];
            for s in &self.segments[a] {
                self.marks[a][s.row * row + s.start..s.row * row + s.end].fill(0);
            }
            self.extended[a].iter().for_each(|&f| self.marks[a][f as usize] = 0);
            self.extended[a].clear();
            self.segments[a].clear();
        }
    }

    /// Marks the faces of the liquid.
    pub fn set_liquid(&mut self, segments: [Vec<Segment>; D]) {
        for a in 0..D {
            let row = self.grid.faces(a).extent[0];
            for s in &segments[a] {
                self.marks[a][s.row * row + s.start..s.row * row + s.end].fill(1);
            }
        }
        self.segments = segments;
    }

    /// The faces of the liquid, per axis.
    pub fn liquid(&self) -> &[Vec<Segment>; D] {
        &self.segments
    }

    /// Extends the velocity over the faces of the band's cells outside the liquid. `closed(axis, side)` tells walls.
    pub fn extrapolate(
        &mut self,
        velocity: &mut FaceField<D>,
        band: &Band<D>,
        phi: &[f64],
        distance: &Sampler<'_, D>,
        closed: impl Fn(usize, usize) -> bool + Sync,
    ) {
        let cells = self.grid.lattice();
        for layer in 0..band.layers.len() - 1 {
            let mark = (layer + 2).min(255) as u8;
            let mut fresh: [Vec<u32>; D] = std::array::from_fn(|_| Vec::new());
            for &cell in &band.cells[band.layers[layer]..band.layers[layer + 1]] {
                if phi[cell as usize] < 0.0 {
                    continue;
                }
                let at = cells.coordinates(cell as usize);
                for a in 0..D {
                    for side in 0..2 {
                        let mut face = at;
                        face[a] += side;
                        let f = self.grid.faces(a).index(face);
                        if self.marks[a][f] == 0 {
                            self.marks[a][f] = mark;
                            fresh[a].push(f as u32);
                        }
                    }
                }
            }
            for a in 0..D {
                let values: Vec<f64> = fresh[a]
                    .par_iter()
                    .map(|&f| {
                        let at = self.grid.faces(a).coordinates(f as usize);
                        let shut =
                            (at[a] == 0 && closed(a, 0)) || (at[a] == self.grid.cells[a] && closed(a, 1));
                        if shut { 0.0 } else { self.extend(&velocity.axes[a], a, at, mark, distance) }
                    })
                    .collect();
                fresh[a].iter().zip(values).for_each(|(&f, v)| velocity.axes[a][f as usize] = v);
                self.extended[a].append(&mut fresh[a]);
            }
        }
    }

    /// The value of the face `at` from faces marked before `mark`.
    fn extend(
        &self,
        values: &[f64],
        axis: usize,
        at: [usize; D],
        mark: u8,
        distance: &Sampler<'_, D>,
    ) -> f64 {
        let lattice = self.grid.faces(axis);
        let here = lattice.index(at);
        let known = |f: usize| {
            let m = self.marks[axis][f];
            m != 0 && m < mark
        };
        let normal = face_normal(axis, at, distance);
        let (mut sum, mut total) = (0.0, 0.0);
        let (mut plain, mut count) = (0.0, 0.0);
        for b in 0..D {
            for down in [true, false] {
                let room = if down { at[b] } else { lattice.extent[b] - 1 - at[b] };
                if room == 0 {
                    continue;
                }
                let step =
                    |n: usize| if down { here - n * lattice.stride[b] } else { here + n * lattice.stride[b] };
                let first = step(1);
                if !known(first) {
                    continue;
                }
                plain += values[first];
                count += 1.0;
                if (normal[b] > 0.0) == down && normal[b] != 0.0 {
                    let value = |n: usize| (room >= n && known(step(n))).then(|| values[step(n)]);
                    let line = [value(1), value(2), value(3), value(4)];
                    let value = next(line, (mark as usize).saturating_sub(2));
                    sum += normal[b].abs() * value;
                    total += normal[b].abs();
                }
            }
        }
        if total > 1e-3 {
            sum / total
        } else if count > 0.0 {
            plain / count
        } else {
            0.0
        }
    }
}

/// What follows the first of the known values of a line in extension layer `layer`.
fn next(line: [Option<f64>; 4], layer: usize) -> f64 {
    let [Some(one), Some(two), Some(three), four] = line else { return line[0].unwrap_or(0.0) };
    let step = one - two;
    let bend = step - (two - three);
    let trusted = |error: f64| error.abs() <= TRUSTED * step.abs();
    match four {
        Some(four) if layer < QUADRATIC && trusted(bend - (two - 2.0 * three + four)) => one + step + bend,
        _ if layer < LINEAR && trusted(bend) => one + step,
        _ => one,
    }
}

/// Direction away from the liquid at a face (unit length but where φ is flat).
fn face_normal<const D: usize>(axis: usize, at: [usize; D], distance: &Sampler<'_, D>) -> [f64; D] {
    let upper = at.map(|i| i as isize);
    let mut lower = upper;
    lower[axis] -= 1;
    let mut normal = [0.0; D];
    for b in 0..D {
        normal[b] = if b == axis {
            distance.value(upper) - distance.value(lower)
        } else {
            let slope = |mut cell: [isize; D]| {
                cell[b] += 1;
                let up = distance.value(cell);
                cell[b] -= 2;
                up - distance.value(cell)
            };
            0.25 * (slope(upper) + slope(lower))
        };
    }
    let norm = normal.iter().map(|n| n * n).sum::<f64>().sqrt();
    if norm > 0.0 { normal.map(|n| n / norm) } else { normal }
}

#[cfg(test)]
mod tests {
    use super::super::{Edge, Tiles};
    use super::*;
    use crate::Vector;

    fn linear_fields_go_on_linearly<const D: usize>() {
        let grid = Grid::<D>::new([20; D], 0.05);
        let lattice = grid.lattice();
        let center = Vector::from_fn(|_, _| 0.51);
        let phi: Vec<f64> = (0..lattice.len())
            .map(|i| (grid.center(lattice.coordinates(i)) - center).norm() - 0.26)
            .collect();
        let inside = Tiles::all(grid).negative_runs(&phi);
        let mut band = Band::new(grid);
        band.rebuild(&phi, &inside, 3);
        let exact = |x: &Vector<D>| 1.0 + 2.0 * x[0] - 3.0 * x[1] + 0.5 * x[D - 1];
        let mut velocity = FaceField::zeros(grid);
        let mut known = KnownFaces::new(grid);
        known.set_liquid(std::array::from_fn(|a| inside.faces(&grid, a)));
        for a in 0..D {
            let faces = grid.faces(a);
            for f in (0..faces.len()).filter(|&f| known.marks[a][f] == 1) {
                velocity.axes[a][f] = exact(&grid.face_center(a, faces.coordinates(f)));
            }
        }
        let distance = Sampler::cells(&grid, &phi, [[Edge::Even; 2]; D]);
        known.extrapolate(&mut velocity, &band, &phi, &distance, |_, _| true);
        for a in 0..D {
            let faces = grid.faces(a);
            let errors: Vec<f64> = (0..faces.len())
                .filter(|&f| known.marks[a][f] == 2)
                .map(|f| (velocity.axes[a][f] - exact(&grid.face_center(a, faces.coordinates(f)))).abs())
                .collect();
            // A line of two faces, at the top of a ball, is too short to tell.
            let exact = errors.iter().filter(|e| **e < 1e-12).count();
            let worst = errors.iter().fold(0.0f64, |m, e| m.max(*e));
            assert!(
                exact * 100 >= errors.len() * 90 && worst < 0.03,
                "{D}D {a}: {exact} of {} {worst:e}",
                errors.len()
            );
        }
    }

    #[test]
    fn extension_of_a_linear_field_is_exact() {
        linear_fields_go_on_linearly::<2>();
        linear_fields_go_on_linearly::<3>();
    }

    #[test]
    fn only_what_is_smooth_is_extended_by_its_bend() {
        let line =
            |f: &dyn Fn(f64) -> f64, known: usize| std::array::from_fn(|i| (i < known).then(|| f(i as f64)));
        let parabola = |n: f64| 2.0 - n + 0.02 * n * n;
        assert!((next(line(&parabola, 4), 0) - parabola(-1.0)).abs() < 1e-14);
        // Without a fourth value, or farther out: linearly. Farther still: constantly.
        for value in [next(line(&parabola, 3), 0), next(line(&parabola, 4), 1)] {
            assert!((value - (2.0 * parabola(0.0) - parabola(1.0))).abs() < 1e-14);
        }
        assert_eq!(next(line(&parabola, 4), 2), 2.0);
        assert_eq!(next(line(&parabola, 2), 0), 2.0);
        let noise = |n: f64| (n * std::f64::consts::PI).cos().round();
        assert_eq!(next(line(&noise, 4), 0), 1.0);
    }
}
