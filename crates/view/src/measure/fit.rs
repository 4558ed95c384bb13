//! The angle at which a drop's free surface, continued as a circle, a sphere or an ellipse, meets a body.

use meniscus_numerics::Vector;
use meniscus_numerics::fit::{Ellipsoid, Sphere};
use serde::Serialize;

use super::body::Body;
use super::contact::{LinePoint, Patch};
use super::drops::Drop;
use super::line::AngleAt;

/// The surface nearer to the line than this is not fitted, in cells.
const AWAY: f64 = 1.5;
/// The band next to it, in cells, in which the fit must hold for the angle to be trusted.
const BAND: f64 = 3.0;
/// An ellipse is taken where the circle misses by more than this, in cells, and the ellipse by less than half of it.
const MISS: f64 = 0.03;
const BETTER: f64 = 0.5;
/// A fit that misses by more than this, in cells, is none: drops on their way are no caps, flat puddles no ellipses (one that
/// missed a puddle by 0.13 cells met its plate at 137 degrees, where the drop did at 90).
const WORST: f64 = 0.1;
/// A fit needs as many points.
const FEWEST: usize = 12;
/// How far the foot of the fitted surface may lie from the line that facets show, in cells.
const FARTHEST: f64 = 8.0;

/// The shape that was fitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum FitShape {
    /// A circle (2D).
    Circle,
    /// An ellipse with a level axis (2D).
    Ellipse,
    /// A sphere (3D).
    Sphere,
    /// A spheroid about an upright axis (3D).
    Spheroid,
}

/// An angle from a shape fitted to the free surface.
#[derive(Clone, Debug, Serialize)]
pub struct FittedAngle {
    /// Mean over the line, degrees through the liquid.
    pub value: f64,
    /// Standard uncertainty, degrees: the spread along the line, and the residual next to the line over three cells.
    pub uncertainty: f64,
    /// Standard deviation along the line, degrees (2D: half the difference of the two ends).
    pub spread: f64,
    /// What was fitted.
    pub shape: FitShape,
    /// Half its level and its upright axis, m.
    pub radii: [f64; 2],
    /// Root mean square distance of the surface from it, next to the line or on the whole, whichever is more, m.
    pub residual: f64,
    /// Points of the surface that it was fitted to.
    pub points: usize,
    /// In 2D where it meets the solid, from left to right.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub places: Vec<AngleAt>,
}

/// A shape fitted to a drop's free surface.
#[derive(Clone, Debug)]
pub(super) struct Fit<const D: usize> {
    it: Ellipsoid<D>,
    /// 1 where the liquid is within the shape, −1 where it is around it.
    side: f64,
    shape: FitShape,
    residual: f64,
    points: usize,
}

/// Where a fitted shape meets a body: the angle (degrees), the feet and how far each is beyond the facets' line (m).
pub(super) struct Feet<const D: usize> {
    pub angle: FittedAngle,
    pub at: Vec<LinePoint<D>>,
    pub beyond: Vec<f64>,
}

impl<const D: usize> Fit<D> {
    /// Fits the surface of a drop away from its contact lines; `dx` is the cell width (m).
    pub(super) fn of(drop: &Drop<D>, patches: &[Patch<D>], bodies: &[Body<D>], dx: f64) -> Option<Self> {
        let (points, near) = free_points(drop, patches, bodies, dx);
        if points.len() < FEWEST {
            return None;
        }
        let sphere = Ellipsoid::round(&Sphere::fit(&points)?);
        let miss = |it: &Ellipsoid<D>| rms(it, &points).max(rms(it, &near));
        let (mut it, mut residual) = (sphere, miss(&sphere));
        let mut shape = if D == 2 { FitShape::Circle } else { FitShape::Sphere };
        if residual > MISS * dx
            && let Some(ellipse) = Ellipsoid::fit(&points)
            && miss(&ellipse) < BETTER * residual
        {
            (it, residual) = (ellipse, miss(&ellipse));
            shape = if D == 2 { FitShape::Ellipse } else { FitShape::Spheroid };
        }
        let out = |f: usize| {
            let middle = drop.mesh.corners(f).iter().sum::<Vector<D>>() / D as f64;
            let free = drop.mesh.facets[f].iter().all(|&v| drop.kinds[v as usize] == 0);
            if free { it.normal(&middle).dot(&drop.mesh.area_vector(f)) } else { 0.0 }
        };
        let side = (0..drop.mesh.facets.len()).map(out).sum::<f64>().signum();
        (residual < WORST * dx).then_some(Self { it, side, shape, residual, points: points.len() })
    }

    /// Where it meets a body, sought from a line; none where it does not meet it along most of the line.
    pub(super) fn feet(&self, line: &[LinePoint<D>], body: &Body<D>, dx: f64) -> Option<Feet<D>> {
        let found: Vec<(LinePoint<D>, f64, f64)> =
            line.iter().filter_map(|p| self.foot(p, body, dx)).collect();
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
        let tilt = (self.residual / (BAND * dx)).atan().to_degrees();
        let angle = FittedAngle {
            value,
            uncertainty: spread.hypot(tilt),
            spread,
            shape: self.shape,
            radii: [self.it.level, self.it.upright],
            residual: self.residual,
            points: self.points,
            places: AngleAt::ordered(found.iter().map(|(p, angle, _)| (p.at, *angle))),
        };
        let beyond = found.iter().map(|f| f.2).collect();
        Some(Feet { angle, at: found.into_iter().map(|f| f.0).collect(), beyond })
    }

    /// Slides a point along the body to the fitted shape: the foot, the angle there (degrees), the way outwards (m).
    fn foot(&self, from: &LinePoint<D>, body: &Body<D>, dx: f64) -> Option<(LinePoint<D>, f64, f64)> {
        const ROUNDS: usize = 20;
        const CLOSE: f64 = 1e-4;
        let start = body.closest(&from.at)?;
        let (mut foot, mut angle, mut out) = (start, 0.0, Vector::zeros());
        let mut gap = f64::INFINITY;
        for _ in 0..ROUNDS {
            let normal = self.it.normal(&foot.at) * self.side;
            let cosine = normal.dot(&foot.normal).clamp(-1.0, 1.0);
            let sine = (1.0 - cosine * cosine).sqrt().max(0.05);
            angle = cosine.acos().to_degrees();
            gap = self.it.distance(&foot.at) * self.side;
            if gap.abs() < CLOSE * dx {
                break;
            }
            out = (normal - foot.normal * cosine) / sine;
            let step = (-gap / sine).clamp(-2.0 * dx, 2.0 * dx);
            foot = body.closest(&(foot.at + out * step))?;
        }
        let way = foot.at - start.at;
        let point = LinePoint { at: foot.at, weight: from.weight };
        (gap.abs() < 0.05 * dx && way.norm() < FARTHEST * dx).then(|| (point, angle, way.dot(&out)))
    }
}

type Weighted<const D: usize> = Vec<(Vector<D>, f64)>;

/// The vertices of the free surface with their shares of its area: all away from the lines, and those just so.
fn free_points<const D: usize>(
    drop: &Drop<D>,
    patches: &[Patch<D>],
    bodies: &[Body<D>],
    dx: f64,
) -> (Weighted<D>, Weighted<D>) {
    let mut shares = vec![0.0; drop.mesh.positions.len()];
    for (f, facet) in drop.mesh.facets.iter().enumerate() {
        let share = drop.mesh.area_vector(f).norm() / D as f64;
        facet.iter().for_each(|&v| shares[v as usize] += share);
    }
    let (mut all, mut near) = (Vec::new(), Vec::new());
    for (v, &x) in drop.mesh.positions.iter().enumerate().filter(|(v, _)| drop.kinds[*v] == 0) {
        let reach = (AWAY + BAND) * dx;
        // Far from a body is far from its line: most points need no look at the line.
        let close = patches.iter().filter(|p| bodies[p.body].is_near(&x, reach));
        let squares = close.flat_map(|p| &p.line).map(|p| (p.at - x).norm_squared());
        let distance = squares.fold(f64::INFINITY, f64::min).sqrt();
        if distance > AWAY * dx {
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
