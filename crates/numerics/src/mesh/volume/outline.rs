//! Flat outlines: closed curves in the plane, either named or given as a list of points.
//!
//! A named outline is given by its part between two neighbouring mirror lines, the fundamental arc. It is triangulated
//! there and mirrored, so the mesh has all symmetries of the outline.

use super::block::BlockError;
use crate::Vector;
use crate::mesh::{FacetBvh, SurfaceMesh};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_6, PI, TAU};
use thiserror::Error;

/// Number of points of a curved fundamental arc.
const CURVE_POINTS: usize = 240;
/// Smallest radius between petals over the radius of their tips.
const PETAL_WAIST: f64 = 0.38;
/// Width of the leaf over its length.
const LEAF_WIDTH: f64 = 0.5;
/// Gap between the squares of the cross and width of the bridges over it, in sides of a square.
const CROSS_GAP: f64 = 0.1;
const CROSS_BRIDGE: f64 = 0.25;

/// Why points do not form an outline, or why an outline cannot be triangulated. Points count from 0.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum OutlineError {
    /// There are fewer than three points.
    #[error("the outline has {count} points; give three or more")]
    TooFew {
        /// Number of points.
        count: usize,
    },
    /// A coordinate is not a finite number.
    #[error("point {point} of the outline is not finite")]
    NotFinite {
        /// Number of the point.
        point: usize,
    },
    /// Two consecutive points coincide.
    #[error("point {point} of the outline coincides with the next one; remove one of them")]
    Repeated {
        /// Number of the first.
        point: usize,
    },
    /// The outline intersects or touches itself.
    #[error(
        "the sides of the outline that start at points {first} and {second} meet; an outline must not touch itself"
    )]
    SelfIntersection {
        /// Start point of the first side.
        first: usize,
        /// Start point of the second side.
        second: usize,
    },
    /// A length is not a positive number.
    #[error("{what} is {value} m; give a positive length")]
    Size {
        /// Which length.
        what: &'static str,
        /// Its value, m.
        value: f64,
    },
    /// The mesh would have too many vertices.
    #[error("a mesh with edges of {edge} m would have about {vertices:e} vertices; give longer edges")]
    TooFine {
        /// Edge requested, m.
        edge: f64,
        /// Number of vertices that it needs.
        vertices: f64,
    },
    /// The outline is a square that cannot be a lattice.
    #[error(transparent)]
    Block(#[from] BlockError),
    /// The outline is locally thinner than the edge length.
    #[error("the outline is too thin near {near:?} m for edges of {edge} m; give shorter edges")]
    TooCoarse {
        /// Edge requested, m.
        edge: f64,
        /// Location, m.
        near: [f64; 2],
    },
}

/// A closed curve in the plane.
#[derive(Clone, Debug, PartialEq)]
pub struct Outline {
    /// Points (m) from one mirror line counter-clockwise to the next; all points if there are no mirror lines.
    pub(super) fundamental_arc: Vec<Vector<2>>,
    /// Number of mirror lines through the origin, 0 if none is known.
    pub(super) mirror_count: usize,
    /// Angle of the mirror line on which `fundamental_arc` starts, rad.
    pub(super) start_angle: f64,
    /// Side, m, if the outline is a square.
    pub(super) square_side: Option<f64>,
}

impl Outline {
    /// A square of side `size` (m), centred at the origin, with sides along the axes.
    pub fn square(size: f64) -> Self {
        let h = 0.5 * size;
        Self { square_side: Some(size), ..Self::mirrored(4, 0.0, vec![[h, 0.0], [h, h]]) }
    }

    /// An equilateral triangle of side `size` (m), centred at the origin, with one tip up.
    pub fn triangle(size: f64) -> Self {
        let tip = [0.0, size / 3.0f64.sqrt()];
        let r = 0.5 * tip[1];
        Self::mirrored(3, FRAC_PI_6, vec![[r * FRAC_PI_6.cos(), r * FRAC_PI_6.sin()], tip])
    }

    /// Petals around the origin, at least two, the first along the first axis: `r = R (1 + c cos nθ) / (1 + c)`. `size` (m) is
    /// the diameter 2R of the circle through the tips.
    pub fn petals(count: usize, size: f64) -> Self {
        let n = count.max(2);
        let c = (1.0 - PETAL_WAIST) / (1.0 + PETAL_WAIST);
        let point = |k: usize| {
            let angle = PI / n as f64 * k as f64 / CURVE_POINTS as f64;
            let r = 0.5 * size * (1.0 + c * (n as f64 * angle).cos()) / (1.0 + c);
            [r * angle.cos(), r * angle.sin()]
        };
        Self::mirrored(n, 0.0, (0..=CURVE_POINTS).map(point).collect())
    }

    /// The unfolded box of Liu et al. (2022), Fig. 18: a cross of five squares joined by bridges that fold; `size` (m) across.
    pub fn cross(size: f64) -> Self {
        let side = size / (3.0 + 2.0 * CROSS_GAP);
        let [half, bridge, far] = [0.5, 0.5 * CROSS_BRIDGE, 0.5 + CROSS_GAP].map(|x| x * side);
        let end = 0.5 * size;
        let part = [[end, 0.0], [end, half], [far, half], [far, bridge], [half, bridge], [half, half]];
        Self::mirrored(4, 0.0, part.to_vec())
    }

    /// A leaf: two circular arcs that meet in tips on the first axis, `size` (m) from tip to tip, half as wide.
    pub fn leaf(size: f64) -> Self {
        let (a, b) = (0.5 * size, 0.5 * size * LEAF_WIDTH);
        // The circle through the tips and (0, b).
        let radius = (a * a + b * b) / (2.0 * b);
        let full = (a / radius).asin();
        let point = |k: usize| {
            let angle = full * (1.0 - k as f64 / CURVE_POINTS as f64);
            [radius * angle.sin(), radius * angle.cos() - (radius - b)]
        };
        let mut part: Vec<[f64; 2]> = (0..=CURVE_POINTS).map(point).collect();
        part[0] = [a, 0.0];
        Self::mirrored(2, 0.0, part)
    }

    /// The outline through points (m) in either direction; the last is connected to the first.
    ///
    /// # Errors
    /// The points do not form an outline.
    pub fn polygon(points: &[[f64; 2]]) -> Result<Self, OutlineError> {
        if points.len() < 3 {
            return Err(OutlineError::TooFew { count: points.len() });
        }
        if let Some(point) = points.iter().position(|p| !p.iter().all(|c| c.is_finite())) {
            return Err(OutlineError::NotFinite { point });
        }
        let fundamental_arc: Vec<Vector<2>> = points.iter().map(|p| Vector::from(*p)).collect();
        let n = fundamental_arc.len();
        if let Some(point) = (0..n).find(|i| fundamental_arc[*i] == fundamental_arc[(i + 1) % n]) {
            return Err(OutlineError::Repeated { point });
        }
        if let Some([first, second]) = self_intersection(&fundamental_arc) {
            return Err(OutlineError::SelfIntersection { first, second });
        }
        let mut outline = Self { fundamental_arc, mirror_count: 0, start_angle: 0.0, square_side: None };
        if outline.surface().volume() < 0.0 {
            outline.fundamental_arc.reverse();
        }
        Ok(outline)
    }

    fn mirrored(mirror_count: usize, start_angle: f64, part: Vec<[f64; 2]>) -> Self {
        Self {
            fundamental_arc: part.into_iter().map(Vector::from).collect(),
            mirror_count,
            start_angle,
            square_side: None,
        }
    }

    /// The outline as a surface in the plane; curves become polygons of some hundred sides.
    pub fn surface(&self) -> SurfaceMesh<2> {
        let mut positions = Vec::new();
        for k in 0..self.mirror_count {
            // The arc and its mirror image, without the points on mirror lines that the next ones add.
            positions.extend(
                self.fundamental_arc[..self.fundamental_arc.len() - 1]
                    .iter()
                    .map(|x| self.image(x, k, false)),
            );
            positions.extend(self.fundamental_arc[1..].iter().rev().map(|x| self.image(x, k + 1, true)));
        }
        if self.mirror_count == 0 {
            positions.clone_from(&self.fundamental_arc);
        }
        let n = positions.len() as u32;
        SurfaceMesh { positions, facets: (0..n).map(|i| [i, (i + 1) % n]).collect() }
    }

    /// Bounding volume hierarchy for distances to the outline.
    pub fn tree(&self) -> FacetBvh<2> {
        FacetBvh::new(&self.surface())
    }

    /// A point of the fundamental arc rotated to the `k`-th sector, or mirrored into the one before it.
    pub(super) fn image(&self, x: &Vector<2>, k: usize, mirrored: bool) -> Vector<2> {
        let turn = TAU * (k % self.mirror_count.max(1)) as f64 / self.mirror_count.max(1) as f64;
        let reflected = |x: &Vector<2>| {
            let (s, c) = exact_sin_cos(2.0 * self.start_angle);
            Vector::from([c * x[0] + s * x[1], s * x[0] - c * x[1]])
        };
        let y = if mirrored { reflected(x) } else { *x };
        let (s, c) = exact_sin_cos(turn);
        Vector::from([c * y[0] - s * y[1], s * y[0] + c * y[1]])
    }
}

/// Sine and cosine, exact for multiples of a right angle.
fn exact_sin_cos(angle: f64) -> (f64, f64) {
    let quarters = angle / FRAC_PI_2;
    if (quarters - quarters.round()).abs() < 1e-12 {
        return [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0)][quarters.round().rem_euclid(4.0) as usize];
    }
    angle.sin_cos()
}

/// Two sides of a polygon that share a point other than the corner between neighbours.
fn self_intersection(points: &[Vector<2>]) -> Option<[usize; 2]> {
    let n = points.len();
    let turn = |a: &Vector<2>, b: &Vector<2>, c: &Vector<2>| (b - a).perp(&(c - a));
    let between = |a: &Vector<2>, b: &Vector<2>, c: &Vector<2>| (a - c).dot(&(b - c)) <= 0.0;
    let meet = |i: usize, j: usize| {
        let [a, b, c, d] = [i, (i + 1) % n, j, (j + 1) % n].map(|k| &points[k]);
        if (i + 1) % n == j || (j + 1) % n == i {
            // Neighbours overlap if one folds back onto the other.
            let [before, at, after] = if (i + 1) % n == j { [a, b, d] } else { [c, a, b] };
            return turn(before, at, after) == 0.0 && (before - at).dot(&(after - at)) > 0.0;
        }
        let [u, v, w, z] = [turn(a, b, c), turn(a, b, d), turn(c, d, a), turn(c, d, b)];
        (u * v < 0.0 && w * z < 0.0)
            || (u == 0.0 && between(a, b, c))
            || (v == 0.0 && between(a, b, d))
            || (w == 0.0 && between(c, d, a))
            || (z == 0.0 && between(c, d, b))
    };
    (0..n).find_map(|j| (0..j).find(|i| meet(*i, j)).map(|i| [i, j]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outlines_have_their_size_and_area() {
        let s3 = 3.0f64.sqrt();
        for (outline, area, across) in [
            (Outline::square(2.0), 4.0, [2.0, 2.0]),
            (Outline::triangle(2.0), s3, [2.0, s3]),
            // ½ ∮ r² dθ = π R² (1 + c²/2) / (1 + c)², c = 0.62/1.38
            (Outline::petals(4, 2.0), 1.646_55, [2.0, 2.0]),
            (Outline::petals(6, 2.0), 1.646_55, [2.0, s3]),
            (Outline::cross(3.2), 5.0 + 4.0 * 0.1 * 0.25, [3.2, 3.2]),
            // Two segments of a circle of radius 1.25 with chord 2.
            (Outline::leaf(2.0), 1.398_84, [2.0, 1.0]),
        ] {
            let surface = outline.surface();
            assert!(surface.is_watertight());
            assert!((surface.volume() / area - 1.0).abs() < 1e-3, "{} {area}", surface.volume());
            let (lower, upper) = surface.bounds();
            for a in 0..2 {
                assert!((upper[a] - lower[a] - across[a]).abs() < 0.05 * across[a], "{lower} {upper}");
            }
            assert!(surface.positions.iter().all(|x| x.norm() < 0.5 * across[0] * 1.42));
            assert_eq!(self_intersection(&surface.positions), None);
        }
    }

    #[test]
    fn points_that_are_no_outline_are_refused() {
        let square = [[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]];
        assert!((Outline::polygon(&square).unwrap().surface().volume() - 1.0).abs() < 1e-15);
        assert_eq!(Outline::polygon(&square[..2]), Err(OutlineError::TooFew { count: 2 }));
        let bow = [[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]];
        assert_eq!(Outline::polygon(&bow), Err(OutlineError::SelfIntersection { first: 0, second: 2 }));
        let spike = [[0.0, 0.0], [2.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
        assert!(matches!(Outline::polygon(&spike), Err(OutlineError::SelfIntersection { .. })));
        let twice = [[0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
        assert_eq!(Outline::polygon(&twice), Err(OutlineError::Repeated { point: 1 }));
        let strange = [[0.0, 0.0], [f64::NAN, 0.0], [1.0, 1.0]];
        assert_eq!(Outline::polygon(&strange), Err(OutlineError::NotFinite { point: 1 }));
    }
}
