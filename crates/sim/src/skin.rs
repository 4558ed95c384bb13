//! The surface of a solid that deforms, where it is now.

use meniscus_numerics::Vector;
use meniscus_numerics::mesh::tree::Closest;
use meniscus_numerics::mesh::{FacetTree, SurfaceMesh};

/// Barycentric weight from which on a point of a facet is not at its rim.
const RIM: f64 = 1e-6;

/// Where something takes hold of a solid that deforms: a point of a facet of its surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grip<const D: usize> {
    /// The facet's vertices, as numbers of those of the solid's mesh.
    pub vertices: [u32; D],
    /// The point's barycentric weights in it.
    pub weights: [f64; D],
    /// The point, m.
    pub point: Vector<D>,
}

impl<const D: usize> Grip<D> {
    /// What values of the mesh's vertices are at the point.
    pub fn mean(&self, of: impl Fn(usize) -> Vector<D>) -> Vector<D> {
        (0..D).map(|k| of(self.vertices[k] as usize) * self.weights[k]).sum()
    }
}

/// The surface of a solid that deforms.
#[derive(Clone, Debug)]
pub struct Skin<const D: usize> {
    /// The surface, m.
    pub surface: SurfaceMesh<D>,
    /// For each of its vertices the number of the mesh's.
    vertices: Vec<u32>,
    tree: FacetTree<D>,
    bounds: [Vector<D>; 2],
}

impl<const D: usize> Skin<D> {
    /// A surface, and for each of its vertices the number of the mesh's.
    pub fn new(surface: SurfaceMesh<D>, vertices: Vec<u32>) -> Self {
        let tree = FacetTree::new(&surface);
        let (low, high) = surface.bounds();
        Self { surface, vertices, tree, bounds: [low, high] }
    }

    /// The same surface with the mesh's vertices elsewhere.
    pub fn at(&self, positions: &[Vector<D>]) -> Self {
        let facets = self.surface.facets.clone();
        let positions = self.vertices.iter().map(|v| positions[*v as usize]).collect();
        Self::new(SurfaceMesh { positions, facets }, self.vertices.clone())
    }

    /// For each vertex of the surface the number of the mesh's.
    pub fn vertices(&self) -> &[u32] {
        &self.vertices
    }

    /// Lower and upper corner of the box around it, m.
    pub fn bounds(&self) -> [Vector<D>; 2] {
        self.bounds
    }

    /// Distance of a point, m, negative inside.
    pub fn distance(&self, x: &Vector<D>) -> f64 {
        let Some(closest) = self.tree.closest(x, f64::INFINITY) else { return f64::INFINITY };
        closest.distance_squared.sqrt() * if self.is_inside(x, &closest) { -1.0 } else { 1.0 }
    }

    /// Whether a point lies inside, given the nearest point of the surface: what is nearest to the inner part of a facet is on
    /// one side of it, the rest the winding number tells.
    fn is_inside(&self, x: &Vector<D>, closest: &Closest<D>) -> bool {
        match closest.weights.iter().all(|w| *w > RIM) {
            true => (x - closest.point).dot(&self.surface.area_vector(closest.facet as usize)) < 0.0,
            false => self.tree.contains(x),
        }
    }

    /// The nearest point of it.
    pub fn grip(&self, x: &Vector<D>) -> Option<Grip<D>> {
        Some(self.grip_at(&self.tree.closest(x, f64::INFINITY)?))
    }

    fn grip_at(&self, closest: &Closest<D>) -> Grip<D> {
        let vertices = self.surface.facets[closest.facet as usize].map(|v| self.vertices[v as usize]);
        Grip { vertices, weights: closest.weights, point: closest.point }
    }

    /// The nearest point of it, and [`Self::normal`].
    pub fn grip_and_normal(&self, x: &Vector<D>, step: f64) -> Option<(Grip<D>, Vector<D>)> {
        let closest = self.tree.closest(x, f64::INFINITY)?;
        Some((self.grip_at(&closest), self.normal_at(x, &closest, step)))
    }

    /// Direction away from it, on it that of its facet; nothing within `step` (m) of halfway between two of its sides.
    pub fn normal(&self, x: &Vector<D>, step: f64) -> Vector<D> {
        let closest = self.tree.closest(x, f64::INFINITY);
        closest.map_or_else(Vector::zeros, |closest| self.normal_at(x, &closest, step))
    }

    fn normal_at(&self, x: &Vector<D>, closest: &Closest<D>, step: f64) -> Vector<D> {
        let away = x - closest.point;
        if away.norm() <= step {
            let facet = self.surface.area_vector(closest.facet as usize);
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
