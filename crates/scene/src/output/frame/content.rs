//! Content of a frame, in two and three dimensions alike.

/// A frame: the surfaces of the liquid and of the solids, and the contact line, at one time.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Time, s.
    pub time: f64,
    /// The liquid's surface outside the solids.
    pub liquid: FrameMesh,
    /// Name and surface of each solid, in the order of the scene.
    pub solids: Vec<(String, FrameMesh)>,
    /// The contact line; `None` where nothing is wetted. In 2D it consists of points only.
    pub contact_line: Option<FrameMesh>,
    /// Number that the attribute `solid` of the contact line has at the domain's walls, if they wet.
    pub wall_solid: Option<usize>,
}

/// A mesh with attributes: triangles in 3D, edges in 2D, edges or points for a contact line.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrameMesh {
    /// Positions of the vertices, m; in 2D the third coordinate is 0.
    pub positions: Vec<[f64; 3]>,
    /// Triangles as vertex numbers, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Edges as vertex numbers.
    pub edges: Vec<[u32; 2]>,
    /// Attributes, each with a name of its own.
    pub attributes: Vec<Attribute>,
}

/// A quantity with one value for each vertex of a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Attribute {
    /// Name, one word.
    pub name: &'static str,
    /// Unit, `1` for a number without one.
    pub unit: &'static str,
    /// Meaning, a phrase.
    pub meaning: &'static str,
    /// Values, as many as vertices.
    pub values: Vec<f64>,
}

impl FrameMesh {
    /// The values of an attribute, if the mesh has it.
    pub fn values(&self, name: &str) -> Option<&[f64]> {
        self.attributes.iter().find(|a| a.name == name).map(|a| a.values.as_slice())
    }
}
