//! Components of two times that became one another, and the rigid motion of what they are together.

use meniscus_numerics::{Matrix, Vector, planes};

/// Components of two times that became one another: which old ones, which new ones.
#[derive(Clone, Debug)]
pub struct Group<const D: usize> {
    /// Old components.
    pub old: Vec<usize>,
    /// New components.
    pub new: Vec<usize>,
    /// What the new ones must be together at the end of the step, if they touch nothing that holds them.
    pub whole: Option<Whole<D>>,
    /// What they must be once they are carried along and before any force acts, if solids hold them.
    pub carried: Option<Whole<D>>,
    /// The part of a vector in directions in which nothing but momentum tells their place: all of it where they touch
    /// nothing, what is along an even wall for drops on it.
    pub placed: Matrix<D>,
    /// Whether their angular momentum is told well enough to be kept.
    pub turns: bool,
}

impl<const D: usize> Group<D> {
    /// These old components became these new ones.
    pub fn new(old: Vec<usize>, new: Vec<usize>) -> Self {
        Self { old, new, whole: None, carried: None, placed: Matrix::zeros(), turns: true }
    }
}

/// Bodies seen as one: mass over density, centre of mass, its velocity, and the angular momentum about it over density.
#[derive(Clone, Debug, PartialEq)]
pub struct Whole<const D: usize> {
    /// Mass over density, m³ (2D: m²).
    pub mass: f64,
    /// Centre of mass, m.
    pub center: Vector<D>,
    /// Its velocity, m/s.
    pub velocity: Vector<D>,
    /// Angular momentum about it over density.
    pub spin: [f64; 3],
}

impl<const D: usize> Whole<D> {
    /// The same body found elsewhere: its momentum and its angular momentum about any point stay.
    pub(super) fn moved_to(self, center: Vector<D>) -> Self {
        Self { spin: self.about(&center), center, ..self }
    }

    /// Angular momentum over density about the point `from`.
    pub fn about(&self, from: &Vector<D>) -> [f64; 3] {
        let (arm, mut sum) = (self.center - from, self.spin);
        for &(a, b, place) in planes::<D>() {
            sum[place] += self.mass * (arm[a] * self.velocity[b] - arm[b] * self.velocity[a]);
        }
        sum
    }
}
