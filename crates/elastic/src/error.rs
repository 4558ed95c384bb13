//! What can be wrong with a deformable solid.

use thiserror::Error;

/// Why a solid cannot be made, or a step not be taken. Places are in metres.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ElasticError {
    /// There is no element.
    #[error("the solid has no element; give it a volume that is at least a mesh cell thick")]
    Empty,
    /// Quadratic simplices are asked for on a mesh that has none.
    #[error(
        "the simplices of the mesh are not the parts of quadratic ones; divide it (`VolumeMesh::divided`)"
    )]
    NotQuadratic,
    /// A quadratic simplex that is turned inside out at a point.
    #[error(
        "the quadratic element {element} is folded at rest; move the nodes on its edges nearer to their middles"
    )]
    Folded {
        /// Its number.
        element: usize,
    },
    /// An element names a vertex that does not exist.
    #[error("element {element} names vertex {vertex}, but there are only {count}; the mesh is damaged")]
    NoSuchVertex {
        /// Its number.
        element: usize,
        /// Its number.
        vertex: u32,
        /// Vertices of the mesh.
        count: usize,
    },
    /// A position that is not finite.
    #[error("vertex {vertex} of the mesh at rest is not at a finite place")]
    NonFinitePosition {
        /// Its number.
        vertex: usize,
    },
    /// An element of negative volume.
    #[error("element {element} at {center:?} is inverted (volume {volume:e}); exchange two of its vertices")]
    Inverted {
        /// Its number.
        element: usize,
        /// The mean of its vertices, m.
        center: Vec<f64>,
        /// Its signed volume, m³ (2D: m²).
        volume: f64,
    },
    /// An element without volume to speak of.
    #[error(
        "element {element} at {center:?} is flat: {quality:e} of the volume of a regular one with its longest edge; \
         mesh the solid anew, or merge vertices that are too close"
    )]
    Flat {
        /// Its number.
        element: usize,
        /// The mean of its vertices, m.
        center: Vec<f64>,
        /// That ratio.
        quality: f64,
    },
    /// A vertex of no element.
    #[error(
        "vertex {vertex} at {place:?} belongs to no element and would have no mass; leave it out of the mesh"
    )]
    UnreferencedVertex {
        /// Its number.
        vertex: usize,
        /// Where it is, m.
        place: Vec<f64>,
    },
    /// A material constant that no solid has.
    #[error("{name} is {value}, but must be {allowed}")]
    Material {
        /// Of what.
        name: &'static str,
        /// What was given.
        value: f64,
        /// What would do.
        allowed: &'static str,
    },
    /// An anchor that holds nothing.
    #[error(
        "anchor {anchor} touches no vertex of the solid; move its region onto the solid or make it larger"
    )]
    EmptyAnchor {
        /// Its number.
        anchor: usize,
    },
    /// An anchor of a vertex that does not exist.
    #[error("anchor {anchor} holds vertex {vertex}, but there are only {count}")]
    NoSuchAnchorVertex {
        /// Its number.
        anchor: usize,
        /// Its number.
        vertex: u32,
        /// Vertices of the mesh.
        count: usize,
    },
    /// Keyframes out of order.
    #[error(
        "anchor {anchor}: the times of its keyframes must be finite and rise; they do not at keyframe {keyframe}"
    )]
    Keyframes {
        /// Its number.
        anchor: usize,
        /// Its number.
        keyframe: usize,
    },
    /// Two anchors of one vertex.
    #[error("anchors {first} and {second} both hold vertex {vertex}; let their regions not overlap")]
    OverlappingAnchors {
        /// One of the two.
        first: usize,
        /// The other.
        second: usize,
        /// Its number.
        vertex: u32,
    },
    /// All vertices are held.
    #[error("every vertex of the solid is held; make it a rigid solid")]
    AllAnchored,
    /// Memory did not suffice.
    #[error("the factors of a solid of {vertices} vertices do not fit into memory; make its mesh coarser")]
    TooLarge {
        /// Of the mesh.
        vertices: usize,
    },
    /// A matrix that is not positive definite.
    #[error(
        "the solid's matrix is not positive definite (step {step:e} s): its stiffness is too large for the step to be \
         resolved in double precision, or not a number"
    )]
    NotPositiveDefinite {
        /// Its length, s.
        step: f64,
    },
    /// Newton's method that did not end.
    #[error(
        "the velocities of a step of {step:e} s did not converge in {iterations} iterations; take shorter steps"
    )]
    NotConverged {
        /// Newton's iterations.
        iterations: usize,
        /// Length of the step, s.
        step: f64,
    },
    /// Extra stiffness between vertices that are no neighbours.
    #[error("extra stiffness between vertices {first} and {second}, which share no element")]
    NotNeighbours {
        /// One of the two.
        first: u32,
        /// The other.
        second: u32,
    },
    /// A velocity that is not finite.
    #[error("the velocity of vertex {vertex} is no longer finite at {time} s; take shorter steps")]
    NotFinite {
        /// Its number.
        vertex: usize,
        /// When, s.
        time: f64,
    },
}
