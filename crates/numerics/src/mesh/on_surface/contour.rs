//! Zero contour of vertex values on a surface: marching triangles (2D: marching segments).
//!
//! The values are linear on each facet (W. Lorensen and H. Cline, SIGGRAPH 1987, in one dimension less; Liu et al., Hydrophobic and
//! Hydrophilic Solid-Fluid Interaction, 4.3.1). On a closed surface the contour consists of closed loops.

use crate::Vector;
use crate::mesh::SurfaceMesh;

/// A point of a contour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContourPoint {
    /// Vertices of its edge, the lower number first.
    pub edge: [u32; 2],
    /// Position along the edge, 0 to 1.
    pub fraction: f64,
    /// One of the facets that contain it.
    pub facet: u32,
}

/// The line (2D: the points) where vertex values on a surface are zero.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Contour {
    /// Its points, sorted by edge.
    pub points: Vec<ContourPoint>,
    /// Its segments as point numbers. Seen from outside, negative values lie on their left. None in 2D.
    pub segments: Vec<[u32; 2]>,
    /// The facet of each segment.
    pub facets: Vec<u32>,
}

impl Contour {
    /// The contour on the given facets of a mesh. Facets with a value that is not finite are skipped.
    pub fn of<const D: usize>(facets: &[[u32; D]], values: &[f64]) -> Self {
        let is_negative = |v: u32| values[v as usize] < 0.0;
        let crossed = |f: &&u32| {
            let facet = &facets[**f as usize];
            facet.iter().any(|v| is_negative(*v) != is_negative(facet[0]))
                && facet.iter().all(|v| values[*v as usize].is_finite())
        };
        let all: Vec<u32> = (0..facets.len() as u32).collect();
        let crossed: Vec<u32> = all.iter().filter(crossed).copied().collect();
        let mut ends: Vec<([u32; 2], u32)> = Vec::with_capacity(2 * crossed.len());
        for &f in &crossed {
            ends.extend(crossings(&facets[f as usize], &is_negative).into_iter().flatten().map(|e| (e, f)));
        }
        ends.sort_unstable();
        ends.dedup_by_key(|e| e.0);
        let point = |&(edge, facet): &([u32; 2], u32)| {
            let [a, b] = edge.map(|v| values[v as usize]);
            ContourPoint { edge, fraction: a / (a - b), facet }
        };
        let mut contour = Self { points: ends.iter().map(point).collect(), ..Self::default() };
        for &f in crossed.iter().filter(|_| D == 3) {
            let place = |e: [u32; 2]| ends.binary_search_by_key(&e, |e| e.0).ok().map(|i| i as u32);
            if let [Some(from), Some(to)] =
                crossings(&facets[f as usize], &is_negative).map(|e| e.and_then(place))
            {
                contour.segments.push([from, to]);
                contour.facets.push(f);
            }
        }
        contour
    }

    /// Positions of its points, m.
    pub fn positions<const D: usize>(&self, mesh: &SurfaceMesh<D>) -> Vec<Vector<D>> {
        self.points.iter().map(|p| p.position(mesh)).collect()
    }
}

impl ContourPoint {
    /// Its position, m.
    pub fn position<const D: usize>(&self, mesh: &SurfaceMesh<D>) -> Vector<D> {
        let [a, b] = self.edge.map(|v| mesh.positions[v as usize]);
        a + (b - a) * self.fraction
    }
}

/// The edges of a crossed facet on which the sign changes. In 3D the one on which it changes from negative to positive,
/// counter-clockwise, comes first.
fn crossings<const D: usize>(facet: &[u32; D], is_negative: &impl Fn(u32) -> bool) -> [Option<[u32; 2]>; 2] {
    let mut out = [None; 2];
    for k in 0..D {
        let (a, b) = (facet[k], facet[(k + 1) % D]);
        if is_negative(a) != is_negative(b) && (D == 3 || k == 0) {
            // Counter-clockwise, the wetted part begins at the segment's end and stops at its start: it lies on the left.
            out[usize::from(is_negative(b) && D == 3)] = Some([a.min(b), a.max(b)]);
        }
    }
    out
}
