//! Errors of the construction and the steps of deformable solids.

use thiserror::Error;

/// Reason why a solid cannot be constructed or a step fails. Positions are in metres.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ElasticError {
    /// The mesh has no element.
    #[error("the solid has no elements; make it at least one mesh edge thick")]
    Empty,
    /// Quadratic elements are requested on a mesh whose simplices are not the parts of quadratic ones.
    #[error(
        "the mesh is not subdivided as quadratic elements require; subdivide it (`VolumeMesh::subdivided`)"
    )]
    NotQuadratic,
    /// A quadratic element has no positive volume at a quadrature point at rest.
    #[error(
        "quadratic element {element} is inverted at rest; move the nodes on its edges closer to the edge midpoints"
    )]
    Folded {
        /// Number of the element.
        element: usize,
    },
    /// An element refers to a vertex that does not exist.
    #[error(
        "element {element} refers to vertex {vertex}, but the mesh has only {count} vertices; check the mesh"
    )]
    NoSuchVertex {
        /// Number of the element.
        element: usize,
        /// Number of the vertex.
        vertex: u32,
        /// Vertices of the mesh.
        count: usize,
    },
    /// A rest position is not finite.
    #[error("the rest position of vertex {vertex} is not finite; check the mesh")]
    NonFinitePosition {
        /// Number of the vertex.
        vertex: usize,
    },
    /// An element has a negative volume.
    #[error("element {element} at {center:?} is inverted (volume {volume:e}); exchange two of its vertices")]
    Inverted {
        /// Number of the element.
        element: usize,
        /// The mean of its vertices, m.
        center: Vec<f64>,
        /// Its signed volume, m³ (2D: m²).
        volume: f64,
    },
    /// An element is nearly flat.
    #[error(
        "element {element} at {center:?} is nearly flat: it has {quality:e} of the volume of a regular element with its \
         longest edge; mesh the solid again, or merge vertices that are too close"
    )]
    Flat {
        /// Number of the element.
        element: usize,
        /// The mean of its vertices, m.
        center: Vec<f64>,
        /// Its volume over that of a regular element with its longest edge.
        quality: f64,
    },
    /// A vertex belongs to no element.
    #[error(
        "vertex {vertex} at {place:?} belongs to no element and would have no mass; remove it from the mesh"
    )]
    UnreferencedVertex {
        /// Number of the vertex.
        vertex: usize,
        /// Its rest position, m.
        place: Vec<f64>,
    },
    /// A material constant is out of range.
    #[error("{name} is {value}, but must be {allowed}")]
    Material {
        /// Name of the constant.
        name: &'static str,
        /// The given value.
        value: f64,
        /// The allowed values.
        allowed: &'static str,
    },
    /// An anchor has no vertex.
    #[error("anchor {anchor} contains no vertex of the solid; move its region onto the solid or enlarge it")]
    EmptyAnchor {
        /// Number of the anchor.
        anchor: usize,
    },
    /// An anchor refers to a vertex that does not exist.
    #[error("anchor {anchor} refers to vertex {vertex}, but the mesh has only {count} vertices")]
    NoSuchAnchorVertex {
        /// Number of the anchor.
        anchor: usize,
        /// Number of the vertex.
        vertex: u32,
        /// Vertices of the mesh.
        count: usize,
    },
    /// Times of keyframes are not finite or do not increase.
    #[error(
        "anchor {anchor}: the times of its keyframes must be finite and increase; keyframe {keyframe} violates this"
    )]
    Keyframes {
        /// Number of the anchor.
        anchor: usize,
        /// Number of the keyframe.
        keyframe: usize,
    },
    /// Two anchors contain the same vertex.
    #[error("anchors {first} and {second} both contain vertex {vertex}; make their regions disjoint")]
    OverlappingAnchors {
        /// Number of one of the two.
        first: usize,
        /// Number of the other one.
        second: usize,
        /// Number of the vertex.
        vertex: u32,
    },
    /// All vertices are anchored.
    #[error("every vertex of the solid is fixed or moved; use a rigid or kinematic solid instead")]
    AllAnchored,
    /// There is not enough memory for the factors.
    #[error(
        "the factorised matrix of a solid with {vertices} vertices does not fit into memory; use a coarser mesh"
    )]
    TooLarge {
        /// Vertices of the mesh.
        vertices: usize,
    },
    /// A matrix is not positive definite.
    #[error(
        "the matrix of the solid is not positive definite (time step {step:e} s): its stiffness is too large for this step in \
         double precision, or not a number; use a softer material or shorter steps"
    )]
    NotPositiveDefinite {
        /// Length of the step, s; infinite in a static solve.
        step: f64,
    },
    /// Newton's method did not converge.
    #[error(
        "the velocities in a time step of {step:e} s did not converge in {iterations} iterations; use shorter steps"
    )]
    NotConverged {
        /// Number of Newton iterations.
        iterations: usize,
        /// Length of the step, s.
        step: f64,
    },
    /// Extra stiffness couples vertices that share no element.
    #[error("extra stiffness couples vertices {first} and {second}, which share no element")]
    NotNeighbours {
        /// Number of one of the two.
        first: u32,
        /// Number of the other one.
        second: u32,
    },
    /// A velocity is not finite.
    #[error("the velocity of vertex {vertex} is no longer finite at {time} s; use shorter steps")]
    NotFinite {
        /// Number of the vertex.
        vertex: usize,
        /// Time, s.
        time: f64,
    },
}
