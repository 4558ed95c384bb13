//! Wettability of solids: patterns of the contact angle, and contact angle hysteresis.
//!
//! A pattern is a list of layers over the solid's own cosine, the last on top. It is defined at the initial position of the solid and
//! moves and rotates with it. On the grid the cosine at a point is the mean over a square of a cell's width on the surface. An edge of
//! the pattern thus keeps its position to a fraction of a cell, and the energy of the wetted area is that of the pattern
//! ([`crate::free_surface::energy`] uses one cosine per dual cell).

use meniscus_numerics::Vector;
use meniscus_numerics::shape::Shape;
use std::f64::consts::PI;
use std::sync::Arc;

/// A layer of a pattern. Positions are those of the solid at the start.
#[derive(Clone, Debug)]
pub enum WettabilityLayer<const D: usize> {
    /// The cosine is linear from one point to another, and constant before and beyond. It covers everything.
    Gradient {
        /// Start, m, and the cosine there.
        from: (Vector<D>, f64),
        /// End, m, and the cosine there.
        to: (Vector<D>, f64),
    },
    /// The area of an image.
    Image(Arc<CosineImage>),
    /// The solid's surface within a shape.
    Patch {
        /// The shape, of any extent beyond the solid's surface.
        shape: Shape<D>,
        /// The cosine there.
        cosine: f64,
    },
}

/// An image of the cosine, projected along the last axis (2D: its middle row, along x); bilinear between the pixel centres.
#[derive(Clone, Debug, PartialEq)]
pub struct CosineImage {
    /// Lower and upper end along x and y, m.
    pub bounds: [[f64; 2]; 2],
    /// Pixels along x and y.
    pub size: [usize; 2],
    /// Cosine and opacity (0 to 1) of each pixel, rows from the lowest y up.
    pub pixels: Vec<[f64; 2]>,
}

/// The angles between which a contact line rests.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Hysteresis {
    /// Cosines of the advancing and the receding angle, everywhere.
    Between([f64; 2]),
    /// Angles, rad, by which the advancing angle lies above and the receding angle below the local Young's angle.
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
    /// Cosine times opacity, and opacity, at a point.
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

    /// Distance to the area of the image, m; 0 within.
    fn distance<const D: usize>(&self, x: &Vector<D>) -> f64 {
        let beyond = |a: usize| (self.bounds[a][0] - x[a]).max(x[a] - self.bounds[a][1]).max(0.0);
        (0..D - 1).map(beyond).fold(0.0, f64::max)
    }
}

impl<const D: usize> WettabilityLayer<D> {
    /// The cosine at a point of this layer over the cosine `below`; patches are enlarged by `slack` (m).
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

    /// Distance from a point within which the layer has no edge, m.
    pub(super) fn distance_to_edge(&self, x: &Vector<D>) -> f64 {
        match self {
            Self::Gradient { .. } => f64::INFINITY,
            Self::Image(picture) => picture.distance(x),
            Self::Patch { shape, .. } => shape.signed_distance(x).abs(),
        }
    }
}
