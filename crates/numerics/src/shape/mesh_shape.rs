//! A shape bounded by a closed mesh.

use crate::mesh::import::{self, ImportError};
use crate::mesh::{FacetTree, SurfaceMesh};
use crate::{Matrix, Vector};
use std::path::Path;

/// The inside of a closed surface, with the tree that answers questions about it.
#[derive(Clone, Debug)]
pub struct MeshShape<const D: usize> {
    surface: SurfaceMesh<D>,
    tree: FacetTree<D>,
}

impl<const D: usize> MeshShape<D> {
    /// The inside of a closed, outward surface.
    pub fn new(surface: SurfaceMesh<D>) -> Self {
        let tree = FacetTree::new(&surface);
        Self { surface, tree }
    }

    /// Reads a file (its coordinates in m), checks it, scales it, rotates it about the origin and moves it by
    /// `translate` (m).
    ///
    /// # Errors
    /// What the file lacks and how to mend it.
    pub fn load(
        path: &Path,
        scale: f64,
        rotation: &Matrix<D>,
        translate: &Vector<D>,
    ) -> Result<Self, ImportError> {
        Ok(Self::new(import::load(path)?.transformed(scale, rotation, translate)))
    }

    /// The surface, m.
    pub fn surface(&self) -> &SurfaceMesh<D> {
        &self.surface
    }

    /// The tree over the surface's facets.
    pub fn tree(&self) -> &FacetTree<D> {
        &self.tree
    }

    /// Distance to the surface, negative inside, m.
    pub fn signed_distance(&self, x: &Vector<D>) -> f64 {
        self.tree.signed_distance(x)
    }
}
