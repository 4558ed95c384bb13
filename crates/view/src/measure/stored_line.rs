//! Assignment of the stored contact line to drops and bodies.

use meniscus_numerics::Vector;
use meniscus_numerics::mesh::FacetBvh;
use serde::Serialize;

use super::components::Component;
use super::contact::LinePoint;
use super::solid_boundary::SolidBoundary;
use crate::folder::{Frame, RunFolder};

/// Largest distance of a point of the line from its drop, in cells.
const MAX_LINE_DISTANCE_CELLS: f64 = 3.0;

/// Contact angle at a point of a contact line in 2D.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AngleAt {
    /// Position, m.
    pub at: [f64; 2],
    /// Contact angle, degrees, measured through the liquid.
    pub angle: f64,
}

impl AngleAt {
    /// Points with their angles from left to right, then from low to high; empty in 3D.
    pub(super) fn ordered<const D: usize>(known: impl Iterator<Item = (Vector<D>, f64)>) -> Vec<Self> {
        if D == 3 {
            return Vec::new();
        }
        let mut all: Vec<Self> =
            known.map(|(x, angle)| Self { at: std::array::from_fn(|a| x[a]), angle }).collect();
        all.sort_by(|a, b| a.at[0].total_cmp(&b.at[0]).then(a.at[1].total_cmp(&b.at[1])));
        all
    }
}

/// Statistics of the angles along a contact line, degrees, measured through the liquid; weighted by length in 3D.
#[derive(Clone, Debug, Serialize)]
pub struct LocalAngle {
    /// Mean.
    pub mean: f64,
    /// Standard deviation.
    pub std: f64,
    /// Smallest.
    pub min: f64,
    /// Largest.
    pub max: f64,
    /// Number of points of the line.
    pub points: usize,
    /// Length of the line, m (2D: 0).
    pub length: f64,
    /// In 2D the points of the line, from left to right.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub places: Vec<AngleAt>,
}

/// The stored line between one drop and one body.
#[derive(Clone, Debug)]
pub(super) struct StoredLine<const D: usize> {
    pub points: Vec<LinePoint<D>>,
    /// Angle at each point, degrees; NaN if not stored.
    angles: Vec<f64>,
}

impl<const D: usize> StoredLine<D> {
    /// Statistics of the stored angles; `None` without angles.
    pub(super) fn angles(&self) -> Option<LocalAngle> {
        let known: Vec<(f64, f64)> = self
            .points
            .iter()
            .zip(&self.angles)
            .filter(|(_, a)| a.is_finite())
            .map(|(p, a)| (p.weight, *a))
            .collect();
        let weight: f64 = known.iter().map(|k| k.0).sum();
        if weight <= 0.0 {
            return None;
        }
        let mean = known.iter().map(|(w, a)| w * a).sum::<f64>() / weight;
        let square = known.iter().map(|(w, a)| w * (a - mean).powi(2)).sum::<f64>() / weight;
        Some(LocalAngle {
            mean,
            std: square.sqrt(),
            min: known.iter().map(|k| k.1).fold(f64::INFINITY, f64::min),
            max: known.iter().map(|k| k.1).fold(f64::NEG_INFINITY, f64::max),
            points: known.len(),
            length: if D == 2 { 0.0 } else { self.points.iter().map(|p| p.weight).sum() },
            places: AngleAt::ordered(
                self.points.iter().map(|p| p.at).zip(self.angles.iter().copied()).filter(|p| p.1.is_finite()),
            ),
        })
    }
}

/// The part of the stored line between each drop and each body; all empty if no line is stored.
pub(super) fn assign<const D: usize>(
    folder: &RunFolder,
    frame: &Frame,
    drops: &[Component<D>],
    bodies: &[SolidBoundary<D>],
    dx: f64,
) -> Vec<Vec<StoredLine<D>>> {
    let empty = StoredLine { points: Vec::new(), angles: Vec::new() };
    let mut out = vec![vec![empty; bodies.len()]; drops.len()];
    let Some(line) = &frame.contact_line else { return out };
    let mut weights = vec![if D == 2 { 1.0 } else { 0.0 }; line.positions.len()];
    let at = |v: usize| Vector::<D>::from_fn(|a, _| line.positions[v][a]);
    for edge in line.edges.iter().filter(|_| D == 3) {
        let [a, b] = edge.map(|v| v as usize);
        let half = 0.5 * (at(a) - at(b)).norm();
        weights[a] += half;
        weights[b] += half;
    }
    let trees: Vec<FacetBvh<D>> = drops.iter().map(|d| FacetBvh::new(&d.mesh)).collect();
    let names = folder.solid_order();
    for v in 0..line.positions.len() {
        let x = at(v);
        let near = trees.iter().enumerate().filter_map(|(i, t)| {
            Some((i, t.closest_point(&x, MAX_LINE_DISTANCE_CELLS * dx)?.distance_squared))
        });
        let Some((drop, _)) = near.min_by(|a, b| a.1.total_cmp(&b.1)) else { continue };
        let named = line.scalars.get("solid").and_then(|s| names.get(*s.get(v)? as usize));
        let named = named.and_then(|name| bodies.iter().position(|b| !b.is_wall && b.name == *name));
        let Some(body) = named.or_else(|| nearest_boundary(bodies, &x)) else { continue };
        let stored = &mut out[drop][body];
        stored.points.push(LinePoint { at: x, weight: weights[v] });
        stored.angles.push(line.scalars.get("angle").and_then(|a| a.get(v)).copied().unwrap_or(f64::NAN));
    }
    out
}

fn nearest_boundary<const D: usize>(bodies: &[SolidBoundary<D>], x: &Vector<D>) -> Option<usize> {
    let distances = bodies.iter().enumerate().filter_map(|(i, b)| Some((i, b.closest(x)?.distance)));
    distances.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(i, _)| i)
}
