//! The surface of a deformable solid in the reference configuration and in a frame.

use meniscus_numerics::Vector;

/// The surface of a solid in the reference and the current configuration.
pub(super) struct DeformedSurface {
    /// Vertices in the reference configuration, m.
    pub reference: Vec<Vector<3>>,
    /// Current vertices, m.
    pub current: Vec<Vector<3>>,
    /// Current vertices without the rigid motion, m; unchanged if the solid has anchored vertices.
    pub deformed: Vec<Vector<3>>,
    /// Triangles; in 2D edges with the first vertex repeated.
    pub facets: Vec<[u32; 3]>,
    /// Outward area vector of each facet in the reference configuration, m² (2D: m).
    pub area_vectors: Vec<Vector<3>>,
    /// Area of each vertex in the reference configuration, m² (2D: m).
    pub vertex_areas: Vec<f64>,
    /// Whether each vertex is anchored: at its reference position both in this frame and in the last one. Empty if all vertices
    /// are, since the anchored ones are then unknown.
    pub anchored: Vec<bool>,
    /// Largest extent in the reference configuration, m.
    pub size: f64,
    /// Whether it lies in a plane.
    pub is_planar: bool,
}
