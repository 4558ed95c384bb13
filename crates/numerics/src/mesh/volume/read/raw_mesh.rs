//! What a file of a volume mesh holds.

/// What a file holds.
#[derive(Default)]
pub struct RawMesh {
    /// Coordinates of the vertices.
    pub points: Vec<[f64; 3]>,
    /// Elements: number in the file, places of the vertices in `points`.
    pub elements: Vec<(u64, Vec<u32>)>,
}

/// What is done with an element of a kind.
pub enum ElementUse {
    /// It is a simplex of the mesh's dimension.
    Accepted,
    /// It has a lower dimension.
    Skipped,
    /// It cannot be used; its name.
    Rejected(&'static str),
}
