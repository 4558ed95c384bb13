//! How solids are wetted: patterns of the contact angle, and angles between which lines rest.
//!
//! A pattern is a list of layers over the solid's own cosine, the last on top. It belongs to the solid: it is told where the
//! solid starts, and moves and turns with it. On the grid the cosine of a place is the mean over a square of a cell's width
//! on the surface: so an edge of the pattern keeps its place to a fraction of a cell, and the energy of what lies wet under
//! the liquid is that of the pattern ([`crate::free_surface::energy`] takes one cosine for each cube).

use meniscus_numerics::Vector;
use meniscus_numerics::shape::Shape;
use std::f64::consts::PI;
use std::sync::Arc;

/// A layer of a pattern. Places are those of the solid at its start.
#[derive(Clone, Debug)]
pub enum WettabilityLayer<const D: usize> {
    /// The cosine goes linearly from one place to another, and is constant before and beyond. It covers everything.
    Gradient {
        /// Where it starts, m, and the cosine there.
        from: (Vector<D>, f64),
        /// Where it ends, m, and the cosine there.
        to: (Vector<D>, f64),
    },
    /// What a picture covers.
    Image(Arc<CosineImage>),
    /// What a shape covers.
    Patch {
        /// The shape, as large as it likes: only what it has of the solid's surface counts.
        shape: Shape<D>,
        /// The cosine there.
        cosine: f64,
    },
}

/// A picture of the cosine, seen along the last axis (2D: its middle row, along x); bilinear between its pixels' middles.
#[derive(Clone, Debug, PartialEq)]
pub struct CosineImage {
    /// Lower and upper end along x and y, m.
    pub bounds: [[f64; 2]; 2],
    /// Pixels along x and y.
    pub size: [usize; 2],
    /// Cosine of each pixel and how much it covers (0 to 1), rows from the lowest y up.
    pub pixels: Vec<[f64; 2]>,
}

/// The angles between which a contact line rests.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Hysteresis {
    /// Cosines of the advancing and the receding angle, wherever the line is.
    Between([f64; 2]),
    /// By how much (rad) the advancing angle lies above Young's angle of the place, and the receding one below it.
    Around([f64; 2]),
}

impl Hysteresis {
    /// Cosines of the advancing and the receding angle where Young's has the cosine `young_cosine`.
    pub fn cosine_bounds(&self, young_cosine: f64) -> [f64; 2] {
        match self {
            Self::Between(cosines) => *cosines,
            Self::Around([above, below]) => {
                let angle = young_cosine.clamp(-1.0, 1.0).acos();
                [(angle + above).min(PI).cos(), (angle - below).max(0.0).cos()]
            }
        }
    }
}

impl CosineImage {
    /// Cosine times cover, and cover, at a place.
    fn sample<const D: usize>(&self, x: &Vector<D>) -> [f64; 2] {
        let mut cell = [[(0, 0.0); 2]; 2];
        for a in 0..2 {
            let [low, high] = self.bounds[a];
            let share = if a + 1 < D { (x[a] - low) / (high - low) } else { 0.5 };
            if !(0.0..=1.0).contains(&share) {
                return [0.0; 2];
            }
            let last = self.size[a] - 1;
            let place = (share * self.size[a] as f64 - 0.5).clamp(0.0, last as f64);
            let first = (place as usize).min(last);
            let part = place - first as f64;
            cell[a] = [(first, 1.0 - part), ((first + 1).min(last), part)];
        }
        let mut sum = [0.0; 2];
        for (row, tall) in cell[1] {
            for (column, wide) in cell[0] {
                let [cosine, cover] = self.pixels[row * self.size[0] + column];
                sum[0] += tall * wide * cover * cosine;
                sum[1] += tall * wide * cover;
            }
        }
        sum
    }

    /// Distance to what it covers, m; 0 within.
    fn distance<const D: usize>(&self, x: &Vector<D>) -> f64 {
        let beyond = |a: usize| (self.bounds[a][0] - x[a]).max(x[a] - self.bounds[a][1]).max(0.0);
        (0..D - 1).map(beyond).fold(0.0, f64::max)
    }
}

impl<const D: usize> WettabilityLayer<D> {
    /// The cosine at a place, of the layer over what is `below` it; patches are larger by `slack` (m).
    pub(super) fn blend_over(&self, below: f64, x: &Vector<D>, slack: f64) -> f64 {
        match self {
            Self::Gradient { from, to } => {
                let span = to.0 - from.0;
                let share = (x - from.0).dot(&span) / span.norm_squared().max(f64::MIN_POSITIVE);
                from.1 + (to.1 - from.1) * share.clamp(0.0, 1.0)
            }
            Self::Image(picture) => {
                let [cosine, cover] = picture.sample(x);
                cosine + (1.0 - cover) * below
            }
            Self::Patch { shape, cosine } => {
                if shape.signed_distance(x) <= slack {
                    *cosine
                } else {
                    below
                }
            }
        }
    }

    /// Distance, m, within which it has no edge around a place.
    pub(super) fn distance_to_edge(&self, x: &Vector<D>) -> f64 {
        match self {
            Self::Gradient { .. } => f64::INFINITY,
            Self::Image(picture) => picture.distance(x),
            Self::Patch { shape, .. } => shape.signed_distance(x).abs(),
        }
    }
}
