//! Moments of a component of the liquid: sums over its faces.

use super::group::RigidMotion;
use meniscus_numerics::{Vector, rotation_planes};

/// Moments of a component: sums over its faces, with masses in units of a cell's.
#[derive(Clone, Debug, PartialEq)]
pub struct Moments<const D: usize> {
    /// Σ m per axis.
    pub mass: [f64; D],
    /// Σ m u per axis.
    pub momentum: [f64; D],
    /// Σ m x per axis of the face and axis of the position.
    pub first_moment: [[f64; D]; D],
    /// Σ m x_b x_c per axis of the face.
    pub second_moment: [[[f64; D]; D]; D],
    /// Σ m x_b u_a per axis a of the face and axis b of the position.
    pub moment_of_momentum: [[f64; D]; D],
    /// Σ m u² per axis of the face.
    pub energy: [f64; D],
}

impl<const D: usize> Moments<D> {
    /// All sums zero.
    pub fn zero() -> Self {
        Self {
            mass: [0.0; D],
            momentum: [0.0; D],
            first_moment: [[0.0; D]; D],
            second_moment: [[[0.0; D]; D]; D],
            moment_of_momentum: [[0.0; D]; D],
            energy: [0.0; D],
        }
    }

    /// Adds a face normal to axis `a` of mass `m` at `x` with the velocity `u`.
    pub fn add_face(&mut self, a: usize, m: f64, x: &Vector<D>, u: f64) {
        let mut row = RowSums::default();
        row.add(m, x[0], u);
        self.add_row(a, &row, x);
    }

    /// Adds the faces of a row along the first axis, one of which is at `x`.
    pub fn add_row(&mut self, a: usize, row: &RowSums, x: &Vector<D>) {
        self.mass[a] += row.mass;
        self.momentum[a] += row.momentum;
        self.energy[a] += row.energy;
        let first = |b: usize| if b == 0 { row.first_moment } else { row.mass * x[b] };
        for b in 0..D {
            self.first_moment[a][b] += first(b);
            self.moment_of_momentum[a][b] +=
                if b == 0 { row.moment_of_momentum } else { row.momentum * x[b] };
            for c in 0..D {
                self.second_moment[a][b][c] += match (b, c) {
                    (0, 0) => row.second_moment,
                    (0, c) => row.first_moment * x[c],
                    (b, c) => first(c) * x[b],
                };
            }
        }
    }

    /// Adds `scale` times the moments of another component.
    pub fn add(&mut self, o: &Self, scale: f64) {
        for a in 0..D {
            self.energy[a] += scale * o.energy[a];
            self.mass[a] += scale * o.mass[a];
            self.momentum[a] += scale * o.momentum[a];
            for b in 0..D {
                self.first_moment[a][b] += scale * o.first_moment[a][b];
                self.moment_of_momentum[a][b] += scale * o.moment_of_momentum[a][b];
                for c in 0..D {
                    self.second_moment[a][b][c] += scale * o.second_moment[a][b][c];
                }
            }
        }
    }

    /// The same component with `mass` on the faces of each axis, whose sums differ slightly otherwise.
    pub fn scaled_to_mass(&self, mass: f64) -> Self {
        let mut out = Self::zero();
        for a in 0..D {
            let scale = mass / self.mass[a].max(1e-300);
            out.mass[a] = mass;
            out.momentum[a] = scale * self.momentum[a];
            out.energy[a] = scale * self.energy[a];
            out.first_moment[a] = self.first_moment[a].map(|x| scale * x);
            out.moment_of_momentum[a] = self.moment_of_momentum[a].map(|x| scale * x);
            out.second_moment[a] = self.second_moment[a].map(|row| row.map(|x| scale * x));
        }
        out
    }

    /// Mean velocity.
    fn velocity(&self) -> Vector<D> {
        Vector::from_fn(|a, _| if self.mass[a] > 0.0 { self.momentum[a] / self.mass[a] } else { 0.0 })
    }

    /// Mean position of the faces of each axis.
    pub fn mean_positions(&self) -> [Vector<D>; D] {
        std::array::from_fn(|a| Vector::from_fn(|b, _| self.first_moment[a][b] / self.mass[a].max(1e-300)))
    }

    /// Angular momentum about the mean position of each axis' faces, to which a uniform velocity adds nothing.
    fn angular_momentum(&self) -> [f64; 3] {
        let relative = |a: usize, b: usize| {
            self.moment_of_momentum[a][b]
                - self.first_moment[a][b] * self.momentum[a] / self.mass[a].max(1e-300)
        };
        let mut angular_momentum = [0.0; 3];
        for &(a, b, place) in rotation_planes::<D>() {
            angular_momentum[place] = relative(b, a) - relative(a, b);
        }
        angular_momentum
    }

    /// Rigid motion of the component, with its centre from the interface.
    pub fn rigid_motion(&self, center: Vector<D>) -> RigidMotion<D> {
        RigidMotion {
            volume: self.mass[0],
            center,
            velocity: self.velocity(),
            angular_momentum_per_density: self.angular_momentum(),
        }
    }

    /// Σ m x_b x_c over the faces of axis `a`, about their mean position.
    pub fn central_second_moment(&self, a: usize, b: usize, c: usize) -> f64 {
        self.second_moment[a][b][c]
            - self.first_moment[a][b] * self.first_moment[a][c] / self.mass[a].max(1e-300)
    }
}

/// The sums of [`Moments`] over the faces of a row along the first axis, with its coordinate alone.
#[derive(Default)]
pub struct RowSums {
    mass: f64,
    momentum: f64,
    energy: f64,
    first_moment: f64,
    second_moment: f64,
    moment_of_momentum: f64,
}

impl RowSums {
    #[inline(always)]
    /// Adds a face of mass `m` at the coordinate `x` with the velocity `u`.
    pub fn add(&mut self, m: f64, x: f64, u: f64) {
        self.mass += m;
        self.momentum += m * u;
        self.energy += m * u * u;
        self.first_moment += m * x;
        self.second_moment += m * x * x;
        self.moment_of_momentum += m * x * u;
    }
}
