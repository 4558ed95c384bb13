//! The surfaces of a solid that deforms, in a frame and at the start.

use meniscus_numerics::Vector;

/// The surface of a solid at first and now.
pub(super) struct DeformedSurface {
    /// Vertices at first, m.
    pub reference: Vec<Vector<3>>,
    /// Vertices now, m.
    pub current: Vec<Vector<3>>,
    /// Vertices now less the rigid motion, m; where something is held as they are.
    pub deformed: Vec<Vector<3>>,
    /// Triangles; in 2D edges with the first vertex again.
    pub facets: Vec<[u32; 3]>,
    /// Area vector of each facet at first, outward, m² (2D: m).
    pub area_vectors: Vec<Vector<3>>,
    /// Area that belongs to each vertex at first.
    pub vertex_areas: Vec<f64>,
    /// Vertices that are where they started, in the frame and in the last one. Empty where that is all of them: it does not tell
    /// which are held.
    pub anchored: Vec<bool>,
    /// Largest extent at first, m.
    pub size: f64,
    /// Whether it lies in a plane.
    pub is_planar: bool,
}
