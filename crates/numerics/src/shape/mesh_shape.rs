//! A shape bounded by a closed mesh.

use crate::Vector;
use crate::mesh::io::ReadFile;
use crate::mesh::io::import::{self, ImportError};
use crate::mesh::{FacetBvh, SurfaceMesh};
use crate::par;
use std::path::Path;

/// Distance from a facet, relative to its size, at which its two sides are tested.
const SIDE_TEST_OFFSET: f64 = 1e-3;
/// Maximum number of facets that are tested for self-intersection.
const MAX_TESTED_FACETS: usize = 20_000;

/// The interior of a closed surface, with a tree for queries.
#[derive(Clone, Debug)]
pub struct MeshShape<const D: usize> {
    surface: SurfaceMesh<D>,
    tree: FacetBvh<D>,
}

impl<const D: usize> MeshShape<D> {
    /// The interior of a closed surface with outward orientation.
    pub fn new(surface: SurfaceMesh<D>) -> Self {
        let tree = FacetBvh::new(&surface);
        Self { surface, tree }
    }

    /// Reads a file (its coordinates in m) and checks it. `read` gives the content of the file.
    ///
    /// # Errors
    /// [`ImportError`] describes the defect of the file and how to repair it.
    pub fn load(path: &Path, read: ReadFile) -> Result<Self, ImportError> {
        let shape = Self::new(import::load(path, read)?);
        match shape.self_intersection() {
            None => Ok(shape),
            Some(at) => {
                Err(ImportError::SelfIntersection { path: path.to_owned(), at: at.iter().copied().collect() })
            }
        }
    }

    /// A point, m, where the surface intersects or touches itself: there its winding number is not 1 just inside, or not
    /// 0 just outside. Of large meshes only some facets are tested.
    fn self_intersection(&self) -> Option<Vector<D>> {
        let count = self.surface.facets.len();
        let wrong = |facet: usize| {
            let corners = self.surface.corners(facet);
            let middle = corners.iter().sum::<Vector<D>>() / D as f64;
            let size = corners.iter().map(|x| (x - middle).norm()).fold(0.0, f64::max);
            let normal = self.surface.area_vector(facet).try_normalize(0.0)? * (SIDE_TEST_OFFSET * size);
            let winds = |x: Vector<D>, times: f64| (self.tree.winding_number(&x) - times).abs() < 0.3;
            (!winds(middle - normal, 1.0) || !winds(middle + normal, 0.0)).then_some(middle)
        };
        let stride = count.div_ceil(MAX_TESTED_FACETS).max(1);
        par::filter_map(count.div_ceil(stride), 16, |i| wrong(i * stride)).into_iter().next()
    }

    /// The surface, m.
    pub fn surface(&self) -> &SurfaceMesh<D> {
        &self.surface
    }

    /// The tree over the surface's facets.
    pub fn tree(&self) -> &FacetBvh<D> {
        &self.tree
    }

    /// Distance to the surface, negative inside, m.
    pub fn signed_distance(&self, x: &Vector<D>) -> f64 {
        self.tree.signed_distance(x)
    }
}
