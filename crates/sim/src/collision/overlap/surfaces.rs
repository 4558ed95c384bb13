//! Surfaces of deformable solids: points, facets and edges.

use crate::solid::Solids;
use meniscus_numerics::Vector;

/// Surfaces of all deformable solids.
pub struct DeformableSurfaces<const D: usize> {
    /// Positions of the points, m.
    pub positions: Vec<Vector<D>>,
    /// Number of the solid of each point.
    pub owner: Vec<usize>,
    /// Facets, as numbers of points.
    pub facets: Vec<[u32; D]>,
    /// Edges, in 3D only.
    pub edges: Vec<[u32; 2]>,
}

impl<const D: usize> DeformableSurfaces<D> {
    /// Surfaces in the current configuration.
    pub fn new(solids: Solids<'_, D>) -> Self {
        let mut skins =
            Self { positions: Vec::new(), owner: Vec::new(), facets: Vec::new(), edges: Vec::new() };
        for (number, solid) in solids.iter().enumerate() {
            let (first, surface) = (skins.positions.len() as u32, &solid.surface);
            skins.positions.extend(surface.collision.positions(&surface.mesh.positions));
            skins.owner.resize(skins.positions.len(), number);
            skins.facets.extend(surface.collision.facets.iter().map(|f| f.map(|v| v + first)));
        }
        if D == 3 {
            let sides =
                |f: &[u32; D]| [0, 1, 2].map(|k| [f[k], f[(k + 1) % D]]).map(|[a, b]| [a.min(b), a.max(b)]);
            skins.edges = skins.facets.iter().flat_map(sides).collect();
            skins.edges.sort_unstable();
            skins.edges.dedup();
        }
        skins
    }
}
