//! The current surface of a deformable solid.

use super::collision_surface::CollisionSurface;
use meniscus_numerics::Vector;
use meniscus_numerics::mesh::bvh::ClosestPoint;
use meniscus_numerics::mesh::{FacetBvh, SurfaceMesh};
use std::collections::BTreeSet;
use std::sync::Arc;

/// Barycentric weight above which a point is in the interior of a facet.
const MIN_INTERIOR_WEIGHT: f64 = 1e-6;
/// Subdivisions of each edge of a triangle that lies partly within a radius: the second moment of a disc with a radius of 3.6 edges is
/// then right within 2 %.
const EDGE_SUBDIVISIONS: usize = 4;

/// A point of a facet of a deformable solid's surface, where a force may act.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint<const D: usize> {
    /// The facet's vertices, as indices of the volume mesh.
    pub vertices: [u32; D],
    /// Barycentric weights of the point.
    pub weights: [f64; D],
    /// The point, m.
    pub point: Vector<D>,
}

impl<const D: usize> SurfacePoint<D> {
    /// Interpolates values at the vertices of the volume mesh to the point.
    pub fn interpolate(&self, of: impl Fn(usize) -> Vector<D>) -> Vector<D> {
        (0..D).map(|k| of(self.vertices[k] as usize) * self.weights[k]).sum()
    }
}

/// Distributes impulses at surface points to the vertices of their facets.
pub fn distribute_to_vertices<const D: usize>(
    grips: &[(SurfacePoint<D>, Vector<D>)],
    vertices: &mut [Vector<D>],
) {
    for (grip, impulse) in grips {
        let corners = grip.vertices.iter().zip(grip.weights);
        corners.for_each(|(vertex, weight)| vertices[*vertex as usize] += impulse * weight);
    }
}

/// The surface of a deformable solid.
#[derive(Clone, Debug)]
pub struct SolidSurface<const D: usize> {
    /// The surface, m.
    pub mesh: SurfaceMesh<D>,
    /// The surface that touches other solids.
    pub collision: Arc<CollisionSurface<D>>,
    /// Index in the volume mesh of each vertex of the surface.
    volume_vertices: Vec<u32>,
    /// Facets around each vertex of the surface.
    vertex_facets: Arc<Vec<Vec<u32>>>,
    tree: FacetBvh<D>,
    bounds: [Vector<D>; 2],
}

impl<const D: usize> SolidSurface<D> {
    /// A surface, and the index in the volume mesh of each of its vertices.
    pub fn new(surface: SurfaceMesh<D>, vertices: Vec<u32>) -> Self {
        let mut around = vec![Vec::new(); surface.positions.len()];
        for (f, facet) in surface.facets.iter().enumerate() {
            facet.iter().for_each(|v| around[*v as usize].push(f as u32));
        }
        let collision = CollisionSurface::linear(surface.facets.clone());
        Self::with_topology(surface, Arc::new(collision), vertices, Arc::new(around))
    }

    fn with_topology(
        mesh: SurfaceMesh<D>,
        collision: Arc<CollisionSurface<D>>,
        volume_vertices: Vec<u32>,
        vertex_facets: Arc<Vec<Vec<u32>>>,
    ) -> Self {
        let tree = FacetBvh::new(&mesh);
        let (low, high) = mesh.bounds();
        Self { mesh, collision, volume_vertices, vertex_facets, tree, bounds: [low, high] }
    }

    /// The same surface with another collision surface.
    pub fn with_collision_surface(self, collision: CollisionSurface<D>) -> Self {
        Self { collision: Arc::new(collision), ..self }
    }

    /// The same surface with other positions of the volume mesh's vertices.
    pub fn with_positions(&self, positions: &[Vector<D>]) -> Self {
        let facets = self.mesh.facets.clone();
        let positions = self.volume_vertices.iter().map(|v| positions[*v as usize]).collect();
        Self::with_topology(
            SurfaceMesh { positions, facets },
            self.collision.clone(),
            self.volume_vertices.clone(),
            self.vertex_facets.clone(),
        )
    }

    /// Index in the volume mesh of each vertex of the surface.
    pub fn volume_vertices(&self) -> &[u32] {
        &self.volume_vertices
    }

    /// Lower and upper corner of the bounding box, m.
    pub fn bounds(&self) -> [Vector<D>; 2] {
        self.bounds
    }

    /// Signed distance of a point, m, negative inside.
    pub fn distance(&self, x: &Vector<D>) -> f64 {
        let Some(closest) = self.tree.closest_point(x, f64::INFINITY) else { return f64::INFINITY };
        closest.distance_squared.sqrt() * if self.is_inside(x, &closest) { -1.0 } else { 1.0 }
    }

    /// Whether a point lies inside, given its closest point. If that is in the interior of a facet, the side of the facet decides,
    /// otherwise the winding number.
    fn is_inside(&self, x: &Vector<D>, closest: &ClosestPoint<D>) -> bool {
        match closest.weights.iter().all(|w| *w > MIN_INTERIOR_WEIGHT) {
            true => (x - closest.point).dot(&self.mesh.area_vector(closest.facet as usize)) < 0.0,
            false => self.tree.contains(x),
        }
    }

    /// The closest point of the surface.
    pub fn closest_point(&self, x: &Vector<D>) -> Option<SurfacePoint<D>> {
        Some(self.surface_point(&self.tree.closest_point(x, f64::INFINITY)?))
    }

    fn surface_point(&self, closest: &ClosestPoint<D>) -> SurfacePoint<D> {
        SurfacePoint {
            weights: closest.weights,
            point: closest.point,
            vertices: self.corners(closest.facet as usize),
        }
    }

    /// The corners of a facet, as indices of the volume mesh.
    fn corners(&self, facet: usize) -> [u32; D] {
        self.mesh.facets[facet].map(|v| self.volume_vertices[v as usize])
    }

    /// The connected part of the surface within a radius (m) around the closest point to `x`: quadrature points and weights, which add
    /// up to one. Linear functions are integrated exactly on facets entirely within the radius, and always in 2D. With radius 0 it is
    /// the closest point.
    pub fn patch(&self, x: &Vector<D>, radius: f64) -> Vec<(SurfacePoint<D>, f64)> {
        let Some(closest) = self.tree.closest_point(x, f64::INFINITY) else { return Vec::new() };
        let (mut next, mut visited) = (vec![closest.facet], BTreeSet::from([closest.facet]));
        let mut parts = Vec::new();
        while let Some(facet) = next.pop().filter(|_| radius > 0.0) {
            let corners = self.mesh.corners(facet as usize);
            let within = facet_quadrature(&corners, &closest.point, radius);
            if within.is_empty() && facet != closest.facet {
                continue;
            }
            for (weights, size) in within {
                let point = (0..D).map(|k| corners[k] * weights[k]).sum();
                parts.push((SurfacePoint { vertices: self.corners(facet as usize), weights, point }, size));
            }
            let around =
                self.mesh.facets[facet as usize].iter().flat_map(|v| &self.vertex_facets[*v as usize]);
            next.extend(around.filter(|f| visited.insert(**f)));
        }
        let all: f64 = parts.iter().map(|p| p.1).sum();
        if all == 0.0 {
            return vec![(self.surface_point(&closest), 1.0)];
        }
        parts.into_iter().map(|(grip, size)| (grip, size / all)).collect()
    }

    /// The closest point of the surface, and [`Self::normal`].
    pub fn closest_point_and_normal(&self, x: &Vector<D>, step: f64) -> Option<(SurfacePoint<D>, Vector<D>)> {
        let closest = self.tree.closest_point(x, f64::INFINITY)?;
        Some((self.surface_point(&closest), self.normal_at(x, &closest, step)))
    }

    /// Outward direction from the surface, on it the normal of the facet; zero within `step` (m) of the medial axis.
    pub fn normal(&self, x: &Vector<D>, step: f64) -> Vector<D> {
        let closest = self.tree.closest_point(x, f64::INFINITY);
        closest.map_or_else(Vector::zeros, |closest| self.normal_at(x, &closest, step))
    }

    fn normal_at(&self, x: &Vector<D>, closest: &ClosestPoint<D>, step: f64) -> Vector<D> {
        let away = x - closest.point;
        if away.norm() <= step {
            let facet = self.mesh.area_vector(closest.facet as usize);
            return facet.try_normalize(0.0).unwrap_or(Vector::zeros());
        }
        let away = away.normalize();
        if !self.is_inside(x, closest) {
            return away;
        }
        let depth = -closest.distance_squared.sqrt();
        let deeper = self.distance(&(x + away * step)) < depth;
        if deeper { -away } else { Vector::zeros() }
    }
}

/// Quadrature of the part of a facet within a radius (m) of a point: barycentric weights of points, and sizes.
fn facet_quadrature<const D: usize>(
    corners: &[Vector<D>; D],
    center: &Vector<D>,
    radius: f64,
) -> Vec<([f64; D], f64)> {
    let near = |x: &Vector<D>| (x - center).norm() <= radius;
    let size = meniscus_numerics::mesh::surface::area_vector(corners).norm();
    if corners.iter().all(near) {
        return vec![([1.0 / D as f64; D], size)];
    }
    if D == 2 {
        // Parameters at which the segment crosses the circle.
        let (edge, from) = (corners[1] - corners[0], corners[0] - center);
        let (square, along) = (edge.norm_squared(), edge.dot(&from));
        let root = (along * along - square * (from.norm_squared() - radius * radius)).max(0.0).sqrt();
        let [first, last] = [-root, root].map(|r| ((r - along) / square).clamp(0.0, 1.0));
        let middle = 0.5 * (first + last);
        let weights = std::array::from_fn(|k| if k == 0 { 1.0 - middle } else { middle });
        return if last > first { vec![(weights, (last - first) * size)] } else { Vec::new() };
    }
    let mut parts = Vec::new();
    for i in 0..EDGE_SUBDIVISIONS {
        for j in 0..EDGE_SUBDIVISIONS - i {
            // The triangle at (i, j), and the inverted one beside it.
            for turned in 0..if i + j + 1 < EDGE_SUBDIVISIONS { 2 } else { 1 } {
                let third = (1 + turned) as f64 / 3.0;
                let [a, b] = [i, j].map(|n| (n as f64 + third) / EDGE_SUBDIVISIONS as f64);
                let weights: [f64; D] = std::array::from_fn(|k| [1.0 - a - b, a, b][k]);
                if near(&(0..D).map(|k| corners[k] * weights[k]).sum()) {
                    parts.push((weights, size / (EDGE_SUBDIVISIONS * EDGE_SUBDIVISIONS) as f64));
                }
            }
        }
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patches_of_a_square_and_of_a_line() {
        let n = 12;
        let at = |i: usize, j: usize| (i * (n + 1) + j) as u32;
        let place = |k: usize| Vector::<3>::new((k / (n + 1)) as f64, (k % (n + 1)) as f64, 0.0) / n as f64;
        let positions: Vec<_> = (0..(n + 1) * (n + 1)).map(place).collect();
        let square = |k: usize| (k / n, k % n);
        let facets = (0..n * n).map(square).flat_map(|(i, j)| {
            [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]
        });
        let surface = SurfaceMesh { facets: facets.collect(), positions };
        let vertices = (0..surface.positions.len() as u32).collect();
        let skin = SolidSurface::new(surface, vertices);
        let x = Vector::<3>::new(0.47, 0.52, 0.1);
        let patch = skin.patch(&x, 0.3);
        let all: f64 = patch.iter().map(|p| p.1).sum();
        let middle: Vector<3> = patch.iter().map(|(grip, part)| grip.point * *part).sum();
        let square: f64 = patch.iter().map(|(g, part)| (g.point - middle).norm_squared() * part).sum();
        assert!((all - 1.0).abs() < 1e-12 && (middle - Vector::<3>::new(0.47, 0.52, 0.0)).norm() < 2e-3);
        assert!((square / 0.045 - 1.0).abs() < 0.02, "{square}");
        assert_eq!(skin.patch(&x, 0.0).len(), 1);

        let positions = (0..11).map(|k| Vector::<2>::new(0.1 * k as f64, 0.0)).collect();
        let facets = (0..10).map(|k| [k, k + 1]).collect();
        let skin = SolidSurface::new(SurfaceMesh { positions, facets }, (0..11).collect());
        let patch = skin.patch(&Vector::<2>::new(0.43, 0.2), 0.26);
        let second: f64 = patch.iter().map(|(g, part)| g.point[0] * part).sum();
        assert!(
            (second - 0.43).abs() < 1e-12 && (patch.iter().map(|p| p.1).sum::<f64>() - 1.0).abs() < 1e-12
        );
        let short = skin.patch(&Vector::<2>::new(0.43, 0.2), 0.02);
        assert!(short.len() == 1 && (short[0].0.point[0] - 0.43).abs() < 1e-12);
    }
}
