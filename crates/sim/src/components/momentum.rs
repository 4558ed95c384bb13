//! Momentum of every component, and giving back what the discretisation loses.
//!
//! Advection and the surface force are accurate but not conservative. A body of liquid that touches nothing must keep
//! its mean velocity (but for gravity) and its angular momentum: after each step a uniform velocity and a rigid rotation
//! restore both. Rigid motions are free of divergence, so nothing else changes (design, experiments part 2). Bodies that
//! merge or part in a step are one [`Whole`] in it: orbits about the common centre count as well as spins. A centre is
//! that of the surface, which the volume correction keeps on its path; the faces' own centres (one per axis) jitter.

use super::group::Group;
use crate::components::group::Whole;
use crate::free_surface::interface_faces::CutFace;
use crate::model::Model;
use meniscus_numerics::grid::{CellField, FaceField, Segment};
use meniscus_numerics::{Matrix, Vector, planes};
use rayon::prelude::*;
use std::iter::zip;

/// Most that the mass of a body's faces and that of its volume may differ by, as a ratio: beyond, its cells lie between solids and
/// the mean over its faces is not its velocity.
const FLOWING: f64 = 2.0;

/// Sums over the faces of a body, mass in units of a cell's.
#[derive(Clone, Debug, PartialEq)]
pub struct Moments<const D: usize> {
    /// Σ m per axis.
    pub mass: [f64; D],
    /// Σ m u per axis.
    pub momentum: [f64; D],
    /// Σ m x per axis of the face and axis of the position.
    pub first: [[f64; D]; D],
    /// Σ m x_b x_c per axis of the face.
    pub second: [[[f64; D]; D]; D],
    /// Σ m x_b u_a per axis a of the face and axis b of the position.
    pub turning: [[f64; D]; D],
    /// Σ m u² per axis of the face.
    pub energy: [f64; D],
}

impl<const D: usize> Moments<D> {
    /// Nothing.
    pub fn zero() -> Self {
        Self {
            mass: [0.0; D],
            momentum: [0.0; D],
            first: [[0.0; D]; D],
            second: [[[0.0; D]; D]; D],
            turning: [[0.0; D]; D],
            energy: [0.0; D],
        }
    }

    fn add_face(&mut self, a: usize, m: f64, x: &Vector<D>, u: f64) {
        self.mass[a] += m;
        self.momentum[a] += m * u;
        self.energy[a] += m * u * u;
        for b in 0..D {
            self.first[a][b] += m * x[b];
            self.turning[a][b] += m * x[b] * u;
            for c in 0..D {
                self.second[a][b][c] += m * x[b] * x[c];
            }
        }
    }

    /// Adds `scale` times another body.
    pub fn add(&mut self, o: &Self, scale: f64) {
        for a in 0..D {
            self.energy[a] += scale * o.energy[a];
            self.mass[a] += scale * o.mass[a];
            self.momentum[a] += scale * o.momentum[a];
            for b in 0..D {
                self.first[a][b] += scale * o.first[a][b];
                self.turning[a][b] += scale * o.turning[a][b];
                for c in 0..D {
                    self.second[a][b][c] += scale * o.second[a][b][c];
                }
            }
        }
    }

    /// The same body with `mass` on the faces of every axis: their sums differ a little, bodies must not.
    pub fn weighing(&self, mass: f64) -> Self {
        let mut out = Self::zero();
        for a in 0..D {
            let scale = mass / self.mass[a].max(1e-300);
            out.mass[a] = mass;
            out.momentum[a] = scale * self.momentum[a];
            out.energy[a] = scale * self.energy[a];
            out.first[a] = self.first[a].map(|x| scale * x);
            out.turning[a] = self.turning[a].map(|x| scale * x);
            out.second[a] = self.second[a].map(|row| row.map(|x| scale * x));
        }
        out
    }

    /// Mean velocity.
    fn velocity(&self) -> Vector<D> {
        Vector::from_fn(|a, _| if self.mass[a] > 0.0 { self.momentum[a] / self.mass[a] } else { 0.0 })
    }

    /// Mean position of the faces of each axis.
    fn middle(&self) -> [Vector<D>; D] {
        std::array::from_fn(|a| Vector::from_fn(|b, _| self.first[a][b] / self.mass[a].max(1e-300)))
    }

    /// Angular momentum about the mean position of each axis' faces: a uniform velocity adds nothing.
    fn spin(&self) -> [f64; 3] {
        let relative = |a: usize, b: usize| {
            self.turning[a][b] - self.first[a][b] * self.momentum[a] / self.mass[a].max(1e-300)
        };
        let mut spin = [0.0; 3];
        for &(a, b, place) in planes::<D>() {
            spin[place] = relative(b, a) - relative(a, b);
        }
        spin
    }

    /// The body as one whole with its centre where the surface says.
    pub fn whole(&self, center: Vector<D>) -> Whole<D> {
        Whole { mass: self.mass[0], center, velocity: self.velocity(), spin: self.spin() }
    }

    /// Σ m x_b x_c over the faces of axis `a`, about their mean position.
    fn spread(&self, a: usize, b: usize, c: usize) -> f64 {
        self.second[a][b][c] - self.first[a][b] * self.first[a][c] / self.mass[a].max(1e-300)
    }
}

/// The rotation rate that carries a given angular momentum in bodies of the given spread (axis of the faces, two of
/// positions) and mass.
fn rotation<const D: usize>(
    momentum: [f64; 3],
    least: f64,
    spread: impl Fn(usize, usize, usize) -> f64,
) -> [f64; 3] {
    // Rotation in plane (a, b): u_b += ω x_a, u_a −= ω x_b.
    let mut inertia = Matrix::<3>::zeros();
    for (i, &(a, b, _)) in planes::<D>().iter().enumerate() {
        for (j, &(c, d, _)) in planes::<D>().iter().enumerate() {
            for (axis, arm, s) in [(b, a, 1.0), (a, b, -1.0)] {
                for (other, lever, t) in [(d, c, 1.0), (c, d, -1.0)] {
                    if axis == other {
                        inertia[(i, j)] += s * t * spread(axis, arm, lever);
                    }
                }
            }
        }
    }
    let mut right = Vector::<3>::zeros();
    planes::<D>().iter().enumerate().for_each(|(i, p)| right[i] = momentum[p.2]);
    // A body one cell thick has faces at one place only and cannot turn: directions without inertia are left out.
    let inverse = inertia.symmetric_eigen();
    let mut rate = [0.0; 3];
    for (k, value) in inverse.eigenvalues.iter().enumerate().filter(|(_, value)| **value > least) {
        let direction = inverse.eigenvectors.column(k);
        let part = direction.dot(&right) / value;
        planes::<D>().iter().enumerate().for_each(|(i, p)| rate[p.2] += part * direction[i]);
    }
    rate
}

/// What restoring the momentum came to.
pub struct Restored<const D: usize> {
    /// The moments of every component after it.
    pub moments: Vec<Moments<D>>,
    /// Momentum that was given back, kg m/s (2D: kg/s): the sum of the sizes over all bodies.
    pub momentum: f64,
    /// Angular momentum that was given back, kg m²/s (2D: kg m/s), in the same way.
    pub spin: f64,
    /// Bodies that it was not given back to, as they lie between solids.
    pub unrestored: u64,
    /// Times that a cell had no component.
    pub unlabelled: u64,
}

/// What is needed to walk over the faces of each component.
pub struct FaceWalk<'a, const D: usize> {
    /// The model.
    pub model: &'a Model<D>,
    /// Distance, to tell liquid cells.
    pub phi: &'a CellField<D>,
    /// The liquid's faces.
    pub faces: &'a [Vec<Segment>; D],
    /// Shares of them that solids leave open, where there are solids.
    pub open: Option<&'a FaceField<D>>,
    /// Those at the surface.
    pub cut: &'a [CutFace],
    /// Component of a liquid cell.
    pub label: &'a (dyn Fn(usize) -> u32 + Sync),
    /// Number of components.
    pub components: usize,
}

impl<const D: usize> FaceWalk<'_, D> {
    /// The moments of every component.
    pub fn moments(&self, velocity: &FaceField<D>) -> Vec<Moments<D>> {
        let mut total = vec![Moments::zero(); self.components];
        for a in 0..D {
            let chunks: Vec<Vec<(u32, Moments<D>)>> =
                self.faces[a].par_chunks(256).map(|c| self.chunk(a, c, &velocity.axes[a])).collect();
            for (component, moments) in chunks.iter().flatten() {
                total[*component as usize].add(moments, 1.0);
            }
        }
        for f in self.cut {
            let x = self.model.grid.face_center(f.axis, self.model.grid.faces(f.axis).coordinates(f.face));
            let component = (self.label)(f.cell) as usize;
            total[component].add_face(f.axis, f.theta * f.open, &x, velocity.axes[f.axis][f.face]);
        }
        total
    }

    fn chunk(&self, a: usize, segments: &[Segment], values: &[f64]) -> Vec<(u32, Moments<D>)> {
        let mut out: Vec<(u32, Moments<D>)> = Vec::new();
        for s in segments {
            self.inner(a, s, |face, x, component, mass| {
                match out.iter_mut().find(|(c, _)| *c == component) {
                    Some((_, m)) => m.add_face(a, mass, x, values[face]),
                    None => {
                        let mut m = Moments::zero();
                        m.add_face(a, mass, x, values[face]);
                        out.push((component, m));
                    }
                }
            });
        }
        out
    }

    /// Calls `f(face, centre, component, mass)` for the faces of a stretch between two liquid cells.
    fn inner(&self, a: usize, s: &Segment, mut f: impl FnMut(usize, &Vector<D>, u32, f64)) {
        let (faces, cells) = (self.model.grid.faces(a), self.model.grid.lattice());
        let mut at = faces.coordinates(s.row * faces.extent[0]);
        let mut component = None;
        for i in s.start..s.end {
            at[0] = i;
            if at[a] == 0 || at[a] == cells.extent[a] {
                component = None;
                continue;
            }
            let upper = cells.index(at);
            if self.phi.data[upper] >= 0.0 || self.phi.data[upper - cells.stride[a]] >= 0.0 {
                component = None;
                continue;
            }
            let face = faces.index(at);
            let mass = self.open.map_or(1.0, |open| open.axes[a][face]);
            // Beyond a face that a solid closes another component may begin.
            if mass == 0.0 {
                component = None;
                continue;
            }
            let label = *component.get_or_insert_with(|| (self.label)(upper));
            f(face, &self.model.grid.face_center(a, at), label, mass);
        }
    }

    /// Whether the faces of a group's bodies hold their mass.
    fn flows(&self, group: &Group<D>, moments: &[Moments<D>], targets: &[f64]) -> bool {
        let faces = group.new.iter().flat_map(|&j| moments[j].mass).sum::<f64>() / D as f64;
        let cells = group.new.iter().map(|&j| targets[j]).sum::<f64>() / self.model.grid.cell_volume();
        faces.max(cells) <= FLOWING * faces.min(cells)
    }

    /// Restores the momentum and angular momentum of every whole; `centers` are those of the components.
    pub fn restore(
        &self,
        velocity: &mut FaceField<D>,
        groups: &[Group<D>],
        targets: &[f64],
        centers: &[Vector<D>],
        dt: f64,
    ) -> Restored<D> {
        let moments = self.moments(velocity);
        let mut restored =
            Restored { moments: Vec::new(), momentum: 0.0, spin: 0.0, unrestored: 0, unlabelled: 0 };
        let mut motions: Vec<Option<Motion<D>>> = vec![None; self.components];
        for group in groups {
            let Some(mut whole) = group.whole.clone() else { continue };
            if !self.flows(group, &moments, targets) {
                restored.unrestored += 1;
                continue;
            }
            let parts: Vec<Moments<D>> = group.new.iter().map(|&j| moments[j].weighing(targets[j])).collect();
            let now = together(zip(&group.new, &parts).map(|(&j, m)| m.whole(centers[j])));
            if !group.placed.is_identity(0.0) {
                whole = whole.moved_to(now.center);
            }
            let arms: Vec<Vector<D>> = group.new.iter().map(|&j| centers[j] - whole.center).collect();
            let shift = whole.velocity + self.model.gravity * dt - now.velocity;
            let lost: [f64; 3] = std::array::from_fn(|i| whole.spin[i] - now.spin[i]);
            restored.momentum += self.model.density * whole.mass * shift.norm();
            if group.turns {
                restored.spin += self.model.density * Vector::<3>::from(lost).norm();
            }
            let spread = |a: usize, b: usize, c: usize| {
                zip(&parts, &arms).map(|(m, r)| m.spread(a, b, c) + m.mass[a] * r[b] * r[c]).sum()
            };
            let least = 1e-6 * whole.mass * self.model.grid.dx.powi(2);
            let rate = if group.turns { rotation::<D>(lost, least, spread) } else { [0.0; 3] };
            for ((&j, m), arm) in zip(&group.new, parts).zip(&arms) {
                let middle = m.middle();
                motions[j] = Some(Motion { velocity: shift + turn(&rate, arm), rate, middle });
            }
        }
        if motions.iter().all(Option::is_none) {
            return Restored { moments, ..restored };
        }
        self.add_motion(velocity, &motions);
        Restored { moments: self.moments(velocity), ..restored }
    }

    /// Adds a velocity to each component.
    pub fn shift(&self, velocity: &mut FaceField<D>, by: &[Vector<D>]) {
        let still = |v: &Vector<D>| Motion { velocity: *v, rate: [0.0; 3], middle: [Vector::zeros(); D] };
        let motions: Vec<Option<Motion<D>>> =
            by.iter().map(|v| v.iter().any(|u| *u != 0.0).then(|| still(v))).collect();
        if motions.iter().any(Option::is_some) {
            self.add_motion(velocity, &motions);
        }
    }

    fn add_motion(&self, velocity: &mut FaceField<D>, motions: &[Option<Motion<D>>]) {
        let motion = |a: usize, x: &Vector<D>, component: u32| -> f64 {
            motions[component as usize]
                .as_ref()
                .map_or(0.0, |m| m.velocity[a] + turn(&m.rate, &(x - m.middle[a]))[a])
        };
        for a in 0..D {
            let row = self.model.grid.faces(a).extent[0];
            meniscus_numerics::par::for_each_segment(
                &mut velocity.axes[a],
                row,
                &self.faces[a],
                |s, part| {
                    let base = s.row * row + s.start;
                    self.inner(a, s, |face, x, component, _| part[face - base] += motion(a, x, component));
                },
            );
        }
        for f in self.cut {
            let x = self.model.grid.face_center(f.axis, self.model.grid.faces(f.axis).coordinates(f.face));
            velocity.axes[f.axis][f.face] += motion(f.axis, &x, (self.label)(f.cell));
        }
    }
}

/// A rigid motion: velocity of the centre, rotation rate, and the mean position of the faces of each axis, about which
/// a rotation leaves the mean velocity alone.
#[derive(Clone)]
struct Motion<const D: usize> {
    velocity: Vector<D>,
    rate: [f64; 3],
    middle: [Vector<D>; D],
}

/// Velocity at `arm` of a rotation.
fn turn<const D: usize>(rate: &[f64; 3], arm: &Vector<D>) -> Vector<D> {
    let mut velocity = Vector::zeros();
    for &(a, b, place) in planes::<D>() {
        velocity[b] += rate[place] * arm[a];
        velocity[a] -= rate[place] * arm[b];
    }
    velocity
}

/// Several bodies as one.
pub fn together<const D: usize>(bodies: impl Iterator<Item = Whole<D>>) -> Whole<D> {
    let bodies: Vec<_> = bodies.collect();
    let mass: f64 = bodies.iter().map(|b| b.mass).sum();
    let mean = |f: &dyn Fn(&Whole<D>) -> Vector<D>| {
        let sum = bodies.iter().fold(Vector::zeros(), |s: Vector<D>, b| s + f(b) * b.mass);
        if mass > 0.0 { sum / mass } else { sum }
    };
    let (center, velocity) = (mean(&|b| b.center), mean(&|b| b.velocity));
    let mut spin = [0.0; 3];
    for b in bodies {
        let relative = Whole { velocity: b.velocity - velocity, ..b };
        zip(&mut spin, relative.about(&center)).for_each(|(sum, s)| *sum += s);
    }
    Whole { mass, center, velocity, spin }
}

#[cfg(test)]
mod tests {
    use super::*;
    use meniscus_numerics::grid::Grid;

    #[test]
    fn closed_faces_part_components() {
        let grid = Grid::<2>::new([6, 3], 1.0);
        let model = Model::of_test(grid, Vec::new());
        let (phi, mut velocity) = (CellField::new(grid, -1.0), FaceField::zeros(grid));
        let (mut open, lattice) = (FaceField::zeros(grid), grid.faces(0));
        for i in 0..7 {
            let face = lattice.index([i, 1]);
            open.axes[0][face] = f64::from(i != 3);
            velocity.axes[0][face] = f64::from(i > 3);
        }
        let faces = [vec![Segment { row: 1, start: 1, end: 6 }], Vec::new()];
        let label = |cell: usize| u32::from(cell % 6 >= 3);
        let open = Some(&open);
        let walk = FaceWalk {
            model: &model,
            phi: &phi,
            faces: &faces,
            open,
            cut: &[],
            label: &label,
            components: 2,
        };
        let moments = walk.moments(&velocity);
        assert_eq!(moments.iter().map(|m| m.mass[0]).collect::<Vec<_>>(), [2.0, 2.0]);
        assert_eq!(moments.iter().map(|m| m.momentum[0]).collect::<Vec<_>>(), [0.0, 2.0]);
    }
}
