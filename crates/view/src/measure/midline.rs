//! Midline of a plate or strip: slopes, curvature and folding.
//!
//! The line runs along the longest axis, halfway between the two faces and through the middle of the width. A slope is the angle
//! to that axis in the plane of length and thickness, so an initially curved strip has slopes from the start.

use meniscus_numerics::Vector;
use serde::Serialize;

use super::deformed_surface::DeformedSurface;

/// Largest ratio of thickness to length of a plate.
const MAX_THICKNESS_RATIO: f64 = 0.3;
/// Least cosine between the normals of a facet and of the plate for the facet to belong to a face.
const MIN_FACE_COSINE: f64 = 0.7;
/// Bounds on the number of intervals along the line; between them there is one for every two edges.
const SAMPLE_COUNT_RANGE: [f64; 2] = [8.0, 60.0];
/// Half width, in edges, of the band of vertices taken as the middle.
const MIDLINE_HALF_WIDTH_EDGES: f64 = 0.75;

/// Midline of a plate or strip. Lengths in m, angles in degrees.
#[derive(Clone, Debug, Serialize)]
pub struct Midline {
    /// Reference length.
    pub length: f64,
    /// Slopes at both ends.
    pub slopes: [f64; 2],
    /// Change of slope between the ends: 360 degrees for a closed ring.
    pub fold_angle: f64,
    /// Curvature of largest magnitude, 1/m, signed.
    pub curvature: f64,
    /// Distance between the ends relative to the reference length.
    pub opening: f64,
    /// Reference position along the line, from its middle, and current displacement across it.
    pub profile: Vec<[f64; 2]>,
}

/// The midline of a surface; `None` if it is not a plate.
pub(super) fn midline(surface: &DeformedSurface) -> Option<Midline> {
    let (axes, extents) = surface.axes();
    let thin = if surface.is_planar { 1 } else { 2 };
    let (along, normal) = (axes[0], axes[thin]);
    if extents[thin] > MAX_THICKNESS_RATIO * extents[0] || extents[0] <= 0.0 {
        return None;
    }
    let edge = mean_edge(surface);
    let faces = [1.0, -1.0].map(|side| face_vertices(surface, &normal, side));
    let lines = faces.map(|vertices| face_centerline(surface, &axes, vertices, edge));
    let [Some(upper), Some(lower)] = lines else { return None };
    let ends = [upper[0].0.max(lower[0].0), upper[upper.len() - 1].0.min(lower[lower.len() - 1].0)];
    let count = (0.5 * (ends[1] - ends[0]) / edge).round().clamp(SAMPLE_COUNT_RANGE[0], SAMPLE_COUNT_RANGE[1])
        as usize;
    let places: Vec<f64> =
        (0..=count).map(|k| ends[0] + (ends[1] - ends[0]) * k as f64 / count as f64).collect();
    let point = |s: &f64| (interpolate(&upper, *s) + interpolate(&lower, *s)) * 0.5;
    let points: Vec<Vector<3>> = places.iter().map(point).collect();
    let middle = 0.5 * (ends[0] + ends[1]);
    let start = surface.reference.iter().map(|x| x.dot(&normal));
    let (low, high) = start.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
    let bend = MidlineBending::of(&points, &along, &normal)?;
    Some(Midline {
        length: ends[1] - ends[0],
        slopes: bend.slopes.map(f64::to_degrees),
        fold_angle: (bend.slopes[1] - bend.slopes[0]).abs().to_degrees(),
        curvature: bend.curvature,
        opening: (points[count] - points[0]).norm() / (ends[1] - ends[0]),
        profile: places
            .iter()
            .zip(&points)
            .map(|(s, x)| [s - middle, x.dot(&normal) - 0.5 * (low + high)])
            .collect(),
    })
}

/// Mean edge length of the facets in the reference configuration, m.
fn mean_edge(surface: &DeformedSurface) -> f64 {
    let sides: &[[usize; 2]] = if surface.is_planar { &[[0, 1]] } else { &[[0, 1], [1, 2], [2, 0]] };
    let length = |f: &[u32; 3], s: &[usize; 2]| {
        (surface.reference[f[s[0]] as usize] - surface.reference[f[s[1]] as usize]).norm()
    };
    let sum: f64 = surface.facets.iter().flat_map(|f| sides.iter().map(|s| length(f, s))).sum();
    sum / (surface.facets.len() * sides.len()).max(1) as f64
}

/// The vertices of the face on the side `side` (±1) of the normal.
fn face_vertices(surface: &DeformedSurface, normal: &Vector<3>, side: f64) -> Vec<usize> {
    let mut vertices: Vec<usize> = surface
        .facets
        .iter()
        .zip(&surface.area_vectors)
        .filter(|(_, area)| side * area.dot(normal) > MIN_FACE_COSINE * area.norm())
        .flat_map(|(facet, _)| facet.map(|v| v as usize))
        .collect();
    vertices.sort_unstable();
    vertices.dedup();
    vertices
}

/// Centreline of a face: increasing reference position along it, and current position, m. `None` with fewer than four points.
fn face_centerline(
    surface: &DeformedSurface,
    axes: &[Vector<3>; 3],
    vertices: Vec<usize>,
    edge: f64,
) -> Option<Vec<(f64, Vector<3>)>> {
    let across = |v: &usize| if surface.is_planar { 0.0 } else { surface.reference[*v].dot(&axes[1]) };
    let (low, high) = vertices
        .iter()
        .map(across)
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
    let central = |v: &usize| (across(v) - 0.5 * (low + high)).abs() <= MIDLINE_HALF_WIDTH_EDGES * edge;
    let mut all: Vec<(f64, Vector<3>)> = vertices
        .iter()
        .filter(|v| central(v))
        .map(|v| (surface.reference[*v].dot(&axes[0]), surface.deformed[*v]))
        .collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    // Merge each transverse row of vertices into one point.
    let mut line: Vec<(f64, Vector<3>, f64, f64)> = Vec::new();
    for (s, x) in all {
        match line.last_mut() {
            Some((sum, place, count, first)) if s - *first < 0.5 * edge => {
                *sum += s;
                *place += x;
                *count += 1.0;
            }
            _ => line.push((s, x, 1.0, s)),
        }
    }
    (line.len() >= 4).then(|| line.into_iter().map(|(s, x, n, _)| (s / n, x / n)).collect())
}

/// Cubic interpolation of a line through the four closest of its points.
fn interpolate(line: &[(f64, Vector<3>)], s: f64) -> Vector<3> {
    let next = line.partition_point(|p| p.0 < s);
    let first = next.saturating_sub(2).min(line.len() - 4);
    let near = &line[first..first + 4];
    let weight = |k: usize| {
        let others = (0..4).filter(|j| *j != k);
        others.map(|j| (s - near[j].0) / (near[k].0 - near[j].0)).product::<f64>()
    };
    (0..4).map(|k| near[k].1 * weight(k)).sum()
}

/// Slopes at the ends, rad, and curvature of largest magnitude, 1/m.
struct MidlineBending {
    slopes: [f64; 2],
    curvature: f64,
}

impl MidlineBending {
    fn of(points: &[Vector<3>], along: &Vector<3>, normal: &Vector<3>) -> Option<Self> {
        let segments: Vec<Vector<3>> = points.windows(2).map(|p| p[1] - p[0]).collect();
        let mut angles: Vec<f64> = Vec::new();
        for way in &segments {
            let angle = way.dot(normal).atan2(way.dot(along));
            // Unwrap the angle: successive angles differ by less than half a turn.
            let before = angles.last().copied().unwrap_or(0.0);
            let turns = ((before - angle) / std::f64::consts::TAU).round();
            angles.push(angle + turns * std::f64::consts::TAU);
        }
        let n = angles.len();
        if n < 2 {
            return None;
        }
        let bend =
            |k: usize| (angles[k] - angles[k - 1]) / (0.5 * (segments[k].norm() + segments[k - 1].norm()));
        let max_curvature = (1..n)
            .map(bend)
            .fold(0.0, |max_curvature: f64, x| if x.abs() > max_curvature.abs() { x } else { max_curvature });
        let end = |a: f64, b: f64| 1.5 * a - 0.5 * b;
        let slopes = [end(angles[0], angles[1]), end(angles[n - 1], angles[n - 2])];
        Some(Self { slopes, curvature: max_curvature })
    }
}
