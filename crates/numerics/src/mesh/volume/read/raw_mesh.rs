//! Unchecked content of a volume mesh file.

/// Vertices and elements of a file.
#[derive(Default)]
pub struct RawMesh {
    /// Coordinates of the vertices, m.
    pub points: Vec<[f64; 3]>,
    /// Elements: number in the file, and vertices as indices into `points`.
    pub elements: Vec<(u64, Vec<u32>)>,
}

/// Use of the elements of a type.
pub enum ElementUse {
    /// A simplex of the mesh's dimension.
    Accepted,
    /// An element of lower dimension.
    Skipped,
    /// An unsupported element; its name.
    Rejected(&'static str),
}
