//! Contact of a drop with a body: the wetted facets and the line around them.

use meniscus_numerics::Vector;
use rayon::prelude::*;

use super::components::Component;
use super::solid_boundary::SolidBoundary;

/// Largest distance of a wetted facet from a body, in cells.
const MAX_WETTED_DISTANCE_CELLS: f64 = 1.0;
/// Least cosine between the directions of facet and body for a facet with only contact-line vertices to be wetted.
const MIN_FACING_COSINE: f64 = 0.7;

/// A point of the contact line.
#[derive(Clone, Copy, Debug)]
pub(super) struct LinePoint<const D: usize> {
    /// Position, m.
    pub at: Vector<D>,
    /// Length of line that it represents, m (2D: 1).
    pub weight: f64,
}

/// The contact of a drop with one body.
#[derive(Clone, Debug)]
pub(super) struct WettedPatch<const D: usize> {
    /// Index of the body in the list.
    pub body: usize,
    /// Area of the wetted facets, m² (2D: m).
    pub area: f64,
    /// Boundary between wetted facets and the free surface; empty if there is no free surface.
    pub line: Vec<LinePoint<D>>,
}

/// The contacts of a drop, in the order of the bodies; `dx` is the cell size (m).
pub(super) fn patches<const D: usize>(
    drop: &Component<D>,
    bodies: &[SolidBoundary<D>],
    dx: f64,
) -> Vec<WettedPatch<D>> {
    let facets = drop.mesh.facets.len();
    let wet: Vec<Option<usize>> =
        (0..facets).into_par_iter().map(|f| wetted_boundary(drop, f, bodies, dx)).collect();
    let mut ridges = facet_edges(drop);
    ridges.sort_unstable();
    let touched = |b: usize| wet.contains(&Some(b));
    let patch = |b: usize| {
        let area = (0..facets).filter(|&f| wet[f] == Some(b));
        let area = area.map(|f| drop.mesh.area_vector(f).norm()).sum();
        let between = |pair: &&[([u32; 2], usize)]| {
            let of = pair.iter().map(|r| wet[r.1]);
            of.clone().any(|w| w == Some(b)) && of.clone().any(|w| w.is_none())
        };
        let pairs = ridges.chunk_by(|a, b| a.0 == b.0);
        let line = pairs.filter(between).map(|pair| line_point(drop, pair[0].0)).collect();
        WettedPatch { body: b, area, line }
    };
    (0..bodies.len()).filter(|&b| touched(b)).map(patch).collect()
}

/// The body that a facet touches.
fn wetted_boundary<const D: usize>(
    drop: &Component<D>,
    facet: usize,
    bodies: &[SolidBoundary<D>],
    dx: f64,
) -> Option<usize> {
    let kinds = drop.mesh.facets[facet].map(|v| drop.kinds[v as usize]);
    if kinds.contains(&0) {
        return None;
    }
    let middle = drop.mesh.corners(facet).iter().sum::<Vector<D>>() / D as f64;
    let near = bodies.iter().enumerate().filter(|(_, b)| b.is_near(&middle, MAX_WETTED_DISTANCE_CELLS * dx));
    let near = near.filter_map(|(i, b)| b.closest(&middle).map(|foot| (i, foot)));
    let (body, foot) = near.min_by(|a, b| a.1.distance.total_cmp(&b.1.distance))?;
    let outward = drop.mesh.area_vector(facet).try_normalize(0.0)?;
    (kinds.contains(&1) || outward.dot(&foot.normal) < -MIN_FACING_COSINE).then_some(body)
}

/// The edges of all facets (2D: vertices), each with its facet.
fn facet_edges<const D: usize>(drop: &Component<D>) -> Vec<([u32; 2], usize)> {
    let of = |(f, facet): (usize, &[u32; D])| {
        let facet = *facet;
        (0..D).map(move |k| {
            let (a, b) = (facet[k], if D == 2 { facet[k] } else { facet[(k + 1) % D] });
            ([a.min(b), a.max(b)], f)
        })
    };
    drop.mesh.facets.iter().enumerate().flat_map(of).collect()
}

fn line_point<const D: usize>(drop: &Component<D>, [a, b]: [u32; 2]) -> LinePoint<D> {
    let (p, q) = (drop.mesh.positions[a as usize], drop.mesh.positions[b as usize]);
    LinePoint { at: (p + q) * 0.5, weight: if D == 2 { 1.0 } else { (q - p).norm() } }
}
