//! Contact angle from a circle, ellipse, sphere or spheroid fitted to the free surface and intersected with a body.

use meniscus_numerics::Vector;
use meniscus_numerics::fit::{Ellipsoid, Sphere};
use serde::Serialize;

use super::components::Component;
use super::contact::{LinePoint, WettedPatch};
use super::solid_boundary::SolidBoundary;
use super::stored_line::AngleAt;

/// Distance from the contact line, in cells, within which the surface is not fitted.
const FIT_START_CELLS: f64 = 1.5;
/// Width of the adjacent band, in cells, in which the residual is also bounded.
const FIT_BAND_CELLS: f64 = 3.0;
/// Residual of the circle, in cells, above which an ellipse is tried. The ellipse must reduce it by the factor below.
const MAX_CIRCLE_RESIDUAL_CELLS: f64 = 0.03;
const ELLIPSE_IMPROVEMENT: f64 = 0.5;
/// Largest residual of a fit, in cells. Moving drops and flat puddles exceed it (an ellipse with 0.13 cells gave 137 degrees
/// for a puddle at 90).
const MAX_FIT_RESIDUAL_CELLS: f64 = 0.1;
/// Least number of points of a fit.
const MIN_FIT_POINTS: usize = 12;
/// Largest distance of the fitted line from the line of the facets, in cells.
const MAX_LINE_OFFSET_CELLS: f64 = 8.0;

/// Shape of a fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum FitShape {
    /// A circle (2D).
    Circle,
    /// An ellipse with a horizontal axis (2D).
    Ellipse,
    /// A sphere (3D).
    Sphere,
    /// A spheroid about a vertical axis (3D).
    Spheroid,
}

/// An angle from a shape fitted to the free surface.
#[derive(Clone, Debug, Serialize)]
pub struct FittedAngle {
    /// Mean over the contact line, degrees, measured through the liquid.
    pub value: f64,
    /// Standard uncertainty, degrees: spread along the line combined with the tilt of the residual over three cells.
    pub uncertainty: f64,
    /// Standard deviation along the line, degrees (2D: half the difference of the two ends).
    pub spread: f64,
    /// Shape of the fit.
    pub shape: FitShape,
    /// Horizontal and vertical semi-axis, m.
    pub radii: [f64; 2],
    /// Root mean square distance of the surface from the fit, m: the larger of the band next to the line and the whole.
    pub residual: f64,
    /// Number of fitted points.
    pub points: usize,
    /// In 2D the intersections with the solid, from left to right.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub places: Vec<AngleAt>,
}

/// A shape fitted to a drop's free surface.
#[derive(Clone, Debug)]
pub(super) struct CapFit<const D: usize> {
    ellipsoid: Ellipsoid<D>,
    /// 1 where the liquid is inside the shape, −1 where it is outside.
    liquid_side: f64,
    shape: FitShape,
    residual: f64,
    points: usize,
}

/// Intersection of a fit with a body: the angle (degrees), the points, and their distance outside the line of the facets (m).
pub(super) struct FittedLine<const D: usize> {
    pub angle: FittedAngle,
    pub points: Vec<LinePoint<D>>,
    pub outward_offsets: Vec<f64>,
}

impl<const D: usize> CapFit<D> {
    /// Fits the free surface of a drop away from its contact lines; `dx` is the cell size (m).
    pub(super) fn of(
        drop: &Component<D>,
        patches: &[WettedPatch<D>],
        bodies: &[SolidBoundary<D>],
        dx: f64,
    ) -> Option<Self> {
        let (points, near) = free_surface_points(drop, patches, bodies, dx);
        if points.len() < MIN_FIT_POINTS {
            return None;
        }
        let sphere = Ellipsoid::from_sphere(&Sphere::fit(&points)?);
        let miss = |ellipsoid: &Ellipsoid<D>| rms(ellipsoid, &points).max(rms(ellipsoid, &near));
        let (mut ellipsoid, mut residual) = (sphere, miss(&sphere));
        let mut shape = if D == 2 { FitShape::Circle } else { FitShape::Sphere };
        if residual > MAX_CIRCLE_RESIDUAL_CELLS * dx
            && let Some(ellipse) = Ellipsoid::fit(&points)
            && miss(&ellipse) < ELLIPSE_IMPROVEMENT * residual
        {
            (ellipsoid, residual) = (ellipse, miss(&ellipse));
            shape = if D == 2 { FitShape::Ellipse } else { FitShape::Spheroid };
        }
        let out = |f: usize| {
            let middle = drop.mesh.corners(f).iter().sum::<Vector<D>>() / D as f64;
            let free = drop.mesh.facets[f].iter().all(|&v| drop.kinds[v as usize] == 0);
            if free { ellipsoid.normal(&middle).dot(&drop.mesh.area_vector(f)) } else { 0.0 }
        };
        let liquid_side = (0..drop.mesh.facets.len()).map(out).sum::<f64>().signum();
        (residual < MAX_FIT_RESIDUAL_CELLS * dx).then_some(Self {
            ellipsoid,
            liquid_side,
            shape,
            residual,
            points: points.len(),
        })
    }

    /// Intersects the fit with a body, starting from a line; `None` if at most half of the line has an intersection.
    pub(super) fn intersect(
        &self,
        line: &[LinePoint<D>],
        body: &SolidBoundary<D>,
        dx: f64,
    ) -> Option<FittedLine<D>> {
        let found: Vec<(LinePoint<D>, f64, f64)> =
            line.iter().filter_map(|p| self.intersect_from(p, body, dx)).collect();
        let weight = |l: f64, p: &LinePoint<D>| l + p.weight;
        let all = line.iter().fold(0.0, weight);
        let kept = found.iter().map(|f| &f.0).fold(0.0, weight);
        if kept <= 0.5 * all {
            return None;
        }
        let mean = |f: &dyn Fn(f64) -> f64| {
            found.iter().map(|(p, angle, _)| p.weight * f(*angle)).sum::<f64>() / kept
        };
        let value = mean(&|angle| angle);
        let spread = mean(&|angle| (angle - value).powi(2)).sqrt();
        let tilt = (self.residual / (FIT_BAND_CELLS * dx)).atan().to_degrees();
        let angle = FittedAngle {
            value,
            uncertainty: spread.hypot(tilt),
            spread,
            shape: self.shape,
            radii: [self.ellipsoid.horizontal_semi_axis, self.ellipsoid.vertical_semi_axis],
            residual: self.residual,
            points: self.points,
            places: AngleAt::ordered(found.iter().map(|(p, angle, _)| (p.at, *angle))),
        };
        let outward_offsets = found.iter().map(|f| f.2).collect();
        Some(FittedLine { angle, points: found.into_iter().map(|f| f.0).collect(), outward_offsets })
    }

    /// Slides a point along the body to the fitted shape. Returns the point, the angle (degrees) and the outward offset (m).
    fn intersect_from(
        &self,
        from: &LinePoint<D>,
        body: &SolidBoundary<D>,
        dx: f64,
    ) -> Option<(LinePoint<D>, f64, f64)> {
        const MAX_ITERATIONS: usize = 20;
        const GAP_TOLERANCE_CELLS: f64 = 1e-4;
        let start = body.closest(&from.at)?;
        let (mut foot, mut angle, mut out) = (start, 0.0, Vector::zeros());
        let mut gap = f64::INFINITY;
        for _ in 0..MAX_ITERATIONS {
            let normal = self.ellipsoid.normal(&foot.at) * self.liquid_side;
            let cosine = normal.dot(&foot.normal).clamp(-1.0, 1.0);
            let sine = (1.0 - cosine * cosine).sqrt().max(0.05);
            angle = cosine.acos().to_degrees();
            gap = self.ellipsoid.distance(&foot.at) * self.liquid_side;
            if gap.abs() < GAP_TOLERANCE_CELLS * dx {
                break;
            }
            out = (normal - foot.normal * cosine) / sine;
            let step = (-gap / sine).clamp(-2.0 * dx, 2.0 * dx);
            foot = body.closest(&(foot.at + out * step))?;
        }
        let offset = foot.at - start.at;
        let point = LinePoint { at: foot.at, weight: from.weight };
        (gap.abs() < 0.05 * dx && offset.norm() < MAX_LINE_OFFSET_CELLS * dx)
            .then(|| (point, angle, offset.dot(&out)))
    }
}

type WeightedPoints<const D: usize> = Vec<(Vector<D>, f64)>;

/// Vertices of the free surface with their areas: those away from the lines, and the subset in the band next to them.
fn free_surface_points<const D: usize>(
    drop: &Component<D>,
    patches: &[WettedPatch<D>],
    bodies: &[SolidBoundary<D>],
    dx: f64,
) -> (WeightedPoints<D>, WeightedPoints<D>) {
    let mut shares = vec![0.0; drop.mesh.positions.len()];
    for (f, facet) in drop.mesh.facets.iter().enumerate() {
        let share = drop.mesh.area_vector(f).norm() / D as f64;
        facet.iter().for_each(|&v| shares[v as usize] += share);
    }
    let (mut all, mut near) = (Vec::new(), Vec::new());
    for (v, &x) in drop.mesh.positions.iter().enumerate().filter(|(v, _)| drop.kinds[*v] == 0) {
        let reach = (FIT_START_CELLS + FIT_BAND_CELLS) * dx;
        // A point far from a body is far from its line, so most points need no search of the line.
        let close = patches.iter().filter(|p| bodies[p.body].is_near(&x, reach));
        let squares = close.flat_map(|p| &p.line).map(|p| (p.at - x).norm_squared());
        let distance = squares.fold(f64::INFINITY, f64::min).sqrt();
        if distance > FIT_START_CELLS * dx {
            all.push((x, shares[v]));
            if distance < reach {
                near.push((x, shares[v]));
            }
        }
    }
    (all, near)
}

/// Root mean square distance of points from a shape, m; 0 without points.
fn rms<const D: usize>(it: &Ellipsoid<D>, points: &[(Vector<D>, f64)]) -> f64 {
    let (square, weight) =
        points.iter().fold((0.0, 0.0), |(s, w), (x, share)| (s + share * it.distance(x).powi(2), w + share));
    if weight > 0.0 { (square / weight).sqrt() } else { 0.0 }
}
