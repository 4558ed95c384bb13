//! What a file of a volume mesh holds.

/// What a file holds.
#[derive(Default)]
pub struct Raw {
    /// Coordinates of the vertices.
    pub points: Vec<[f64; 3]>,
    /// Elements: number in the file, places of the vertices in `points`.
    pub elements: Vec<(u64, Vec<u32>)>,
}

/// What is done with an element of a kind.
pub enum Kind {
    /// It is a simplex of the mesh's dimension.
    Taken,
    /// It has a lower dimension.
    Passed,
    /// It cannot be used; its name.
    Refused(&'static str),
}
