//! Momentum of every component, and giving back what the discretisation loses.
//!
//! Advection and the surface force are accurate but not conservative. A body of liquid that touches nothing must keep
//! its mean velocity (but for gravity) and its spin: after each step a uniform velocity and a rigid rotation restore
//! both. Rigid motions are free of divergence, so nothing else changes (design, experiments part 2).

use super::pressure::CutFace;
use super::volume::Group;
use crate::model::Model;
use crate::state::Drop;
use meniscus_numerics::Vector;
use meniscus_numerics::grid::{CellField, FaceField, Segment};
use rayon::prelude::*;

/// Planes of rotation: (first axis, second axis, place in an angular momentum vector).
pub const PLANES: [(usize, usize, usize); 3] = [(0, 1, 2), (1, 2, 0), (2, 0, 1)];

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
    /// Σ m u².
    pub energy: f64,
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
            energy: 0.0,
        }
    }

    fn add_face(&mut self, a: usize, m: f64, x: &Vector<D>, u: f64) {
        self.mass[a] += m;
        self.momentum[a] += m * u;
        self.energy += m * u * u;
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
        self.energy += scale * o.energy;
        for a in 0..D {
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
            out.first[a] = self.first[a].map(|x| scale * x);
            out.turning[a] = self.turning[a].map(|x| scale * x);
            out.second[a] = self.second[a].map(|row| row.map(|x| scale * x));
        }
        out
    }

    /// Mean velocity.
    pub fn velocity(&self) -> Vector<D> {
        Vector::from_fn(|a, _| if self.mass[a] > 0.0 { self.momentum[a] / self.mass[a] } else { 0.0 })
    }

    /// Mean position.
    pub fn centroid(&self) -> Vector<D> {
        Vector::from_fn(|b, _| {
            let sum: f64 = (0..D).map(|a| self.first[a][b] / self.mass[a].max(1e-300)).sum();
            sum / D as f64
        })
    }

    /// Angular momentum about the mean position of each axis' faces: a uniform velocity adds nothing.
    pub fn spin(&self) -> [f64; 3] {
        let relative = |a: usize, b: usize| {
            self.turning[a][b] - self.first[a][b] * self.momentum[a] / self.mass[a].max(1e-300)
        };
        let mut spin = [0.0; 3];
        for &(a, b, place) in planes::<D>() {
            spin[place] = relative(b, a) - relative(a, b);
        }
        spin
    }

    /// The rotation rate that carries a given spin: solves the inertia of the faces.
    fn rotation(&self, spin: [f64; 3]) -> [f64; 3] {
        let spread = |a: usize, b: usize, c: usize| {
            self.second[a][b][c] - self.first[a][b] * self.first[a][c] / self.mass[a].max(1e-300)
        };
        // Rotation in plane (a, b): u_b += ω x_a, u_a −= ω x_b.
        let mut inertia = nalgebra3::zeros();
        for (i, &(a, b, _)) in planes::<D>().iter().enumerate() {
            for (j, &(c, d, _)) in planes::<D>().iter().enumerate() {
                let mut sum = 0.0;
                for (axis, arm, s) in [(b, a, 1.0), (a, b, -1.0)] {
                    for (other, lever, t) in [(d, c, 1.0), (c, d, -1.0)] {
                        if axis == other {
                            sum += s * t * spread(axis, arm, lever);
                        }
                    }
                }
                inertia[i][j] = sum;
            }
        }
        let mut right = [0.0; 3];
        planes::<D>().iter().enumerate().for_each(|(i, p)| right[i] = spin[p.2]);
        let solution = nalgebra3::solve(inertia, right, planes::<D>().len());
        let mut rate = [0.0; 3];
        planes::<D>().iter().enumerate().for_each(|(i, p)| rate[p.2] = solution[i]);
        rate
    }
}

fn planes<const D: usize>() -> &'static [(usize, usize, usize)] {
    if D == 2 { &PLANES[..1] } else { &PLANES }
}

/// Three by three systems.
mod nalgebra3 {
    pub fn zeros() -> [[f64; 3]; 3] {
        [[0.0; 3]; 3]
    }

    /// Solves the leading `n` by `n` symmetric system; no rotation where the inertia vanishes.
    pub fn solve(matrix: [[f64; 3]; 3], right: [f64; 3], n: usize) -> [f64; 3] {
        let scale = (0..n).map(|i| matrix[i][i]).fold(0.0, f64::max);
        let full = meniscus_numerics::Matrix::<3>::from_fn(|r, c| {
            if r < n && c < n {
                matrix[r][c]
            } else if r == c {
                scale
            } else {
                0.0
            }
        });
        let right = meniscus_numerics::Vector::<3>::from_fn(|r, _| if r < n { right[r] } else { 0.0 });
        let inverse = if scale > 0.0 { full.try_inverse() } else { None };
        inverse.map_or([0.0; 3], |i| (i * right).into())
    }
}

/// What is needed to walk over the faces of each component.
pub struct FaceWalk<'a, const D: usize> {
    /// The model.
    pub model: &'a Model<D>,
    /// Distance, to tell liquid cells.
    pub phi: &'a CellField<D>,
    /// The liquid's faces.
    pub faces: &'a [Vec<Segment>; D],
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
            total[component].add_face(f.axis, f.theta, &x, velocity.axes[f.axis][f.face]);
        }
        total
    }

    fn chunk(&self, a: usize, segments: &[Segment], values: &[f64]) -> Vec<(u32, Moments<D>)> {
        let mut out: Vec<(u32, Moments<D>)> = Vec::new();
        for s in segments {
            self.inner(a, s, |face, x, component| match out.iter_mut().find(|(c, _)| *c == component) {
                Some((_, m)) => m.add_face(a, 1.0, x, values[face]),
                None => {
                    let mut m = Moments::zero();
                    m.add_face(a, 1.0, x, values[face]);
                    out.push((component, m));
                }
            });
        }
        out
    }

    /// Calls `f(face, centre, component)` for the faces of a stretch between two liquid cells.
    fn inner(&self, a: usize, s: &Segment, mut f: impl FnMut(usize, &Vector<D>, u32)) {
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
            let label = *component.get_or_insert_with(|| (self.label)(upper));
            f(faces.index(at), &self.model.grid.face_center(a, at), label);
        }
    }

    /// Restores the momentum and spin of every group that touches no side of the domain. `expected` are the drops
    /// before the step. Gives back the moments after.
    pub fn restore(
        &self,
        velocity: &mut FaceField<D>,
        groups: &[Group],
        before: &[Drop<D>],
        targets: &[f64],
        touching: &[bool],
        dt: f64,
    ) -> Vec<Moments<D>> {
        let moments = self.moments(velocity);
        let mut change: Vec<Option<(Vector<D>, [f64; 3], Moments<D>)>> = vec![None; self.components];
        for group in groups {
            if group.old.is_empty() || group.new.is_empty() || group.new.iter().any(|&j| touching[j]) {
                continue;
            }
            let (mean, spin) = together(group.old.iter().map(|&i| {
                let d = &before[i];
                (d.target_volume, d.velocity, d.centroid, d.spin)
            }));
            let mut whole = Moments::zero();
            for &j in &group.new {
                whole.add(&moments[j].weighing(targets[j]), 1.0);
            }
            let expected = mean + self.model.gravity * dt;
            let shift = expected - whole.velocity();
            let now = whole.spin();
            let rate = whole.rotation(std::array::from_fn(|i| spin[i] - now[i]));
            for &j in &group.new {
                change[j] = Some((shift, rate, whole.clone()));
            }
        }
        if change.iter().all(Option::is_none) {
            return moments;
        }
        self.add_motion(velocity, &change);
        self.moments(velocity)
    }

    fn add_motion(&self, velocity: &mut FaceField<D>, change: &[Option<(Vector<D>, [f64; 3], Moments<D>)>]) {
        let motion = |a: usize, x: &Vector<D>, component: u32| -> f64 {
            let Some((shift, rate, whole)) = &change[component as usize] else { return 0.0 };
            let arm = |b: usize| x[b] - whole.first[a][b] / whole.mass[a].max(1e-300);
            let mut u = shift[a];
            for &(p, q, place) in planes::<D>() {
                if a == q {
                    u += rate[place] * arm(p);
                } else if a == p {
                    u -= rate[place] * arm(q);
                }
            }
            u
        };
        for a in 0..D {
            let row = self.model.grid.faces(a).extent[0];
            meniscus_numerics::par::for_each_segment(
                &mut velocity.axes[a],
                row,
                &self.faces[a],
                |s, part| {
                    let base = s.row * row + s.start;
                    self.inner(a, s, |face, x, component| part[face - base] += motion(a, x, component));
                },
            );
        }
        for f in self.cut {
            let x = self.model.grid.face_center(f.axis, self.model.grid.faces(f.axis).coordinates(f.face));
            velocity.axes[f.axis][f.face] += motion(f.axis, &x, (self.label)(f.cell));
        }
    }
}

/// Mean velocity and spin about the common centre of bodies given by mass, velocity, centre and spin.
pub fn together<const D: usize>(
    bodies: impl Iterator<Item = (f64, Vector<D>, Vector<D>, [f64; 3])>,
) -> (Vector<D>, [f64; 3]) {
    let bodies: Vec<_> = bodies.collect();
    let mass: f64 = bodies.iter().map(|b| b.0).sum();
    let mean = |f: &dyn Fn(usize) -> Vector<D>| {
        let sum = (0..bodies.len()).fold(Vector::zeros(), |s: Vector<D>, i| s + f(i) * bodies[i].0);
        if mass > 0.0 { sum / mass } else { sum }
    };
    let (velocity, center) = (mean(&|i| bodies[i].1), mean(&|i| bodies[i].2));
    let mut spin = [0.0; 3];
    for (m, v, c, s) in &bodies {
        let (arm, relative) = (c - center, v - velocity);
        for &(a, b, place) in planes::<D>() {
            spin[place] += s[place] + m * (arm[a] * relative[b] - arm[b] * relative[a]);
        }
    }
    (velocity, spin)
}
