//! Content of a frame, in two and three dimensions alike.

use std::borrow::Cow;

/// A frame: the surfaces of the liquid and of the solids, and the contact line, at one time; on request also the elements of the solids
/// and fields on the grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Time, s.
    pub time: f64,
    /// Time from one frame to the next, s; `None` if it is not known.
    pub interval: Option<f64>,
    /// Length of one unit of the positions, m: 1, unless the frame is scaled.
    pub unit: f64,
    /// The axis that points up: 1 in 2D, 2 in 3D, unless the frame is turned.
    pub up_axis: usize,
    /// The liquid's surface outside the solids.
    pub liquid: FrameMesh,
    /// Name and surface of each solid, in the order of the scene.
    pub solids: Vec<(String, FrameMesh)>,
    /// The contact line; `None` where nothing is wetted. In 2D it consists of points only.
    pub contact_line: Option<FrameMesh>,
    /// Number that the attribute `solid` of the contact line has at the domain's walls, if they wet.
    pub wall_solid: Option<usize>,
    /// Name and elements of each deformable solid; empty unless [`FrameParts::elements`] asks for them.
    pub elements: Vec<(String, FrameElements)>,
    /// Fields of the liquid; `None` unless [`FrameParts::fields`] asks for them.
    pub fields: Option<FrameFields>,
}

/// The optional parts of a frame, beside its surfaces and its contact line. A format requests those that it writes, because they cost time
/// and memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FrameParts {
    /// The elements of deformable solids.
    pub elements: bool,
    /// Fields on the grid.
    pub fields: bool,
}

impl FrameParts {
    /// The parts that one of the two requests.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Self { elements: self.elements || other.elements, fields: self.fields || other.fields }
    }
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
    /// Attributes, each with a name of its own and one value for each vertex.
    pub attributes: Vec<Attribute>,
}

/// The elements of a deformable solid with attributes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrameElements {
    /// Positions of the vertices, m; in 2D the third coordinate is 0.
    pub positions: Vec<[f64; 3]>,
    /// Elements as vertex numbers: tetrahedra, or in 2D triangles, whose fourth entry repeats the third.
    pub simplices: Vec<[u32; 4]>,
    /// Whether the elements are triangles.
    pub are_triangles: bool,
    /// Attributes of the vertices; vectors have three values for each vertex.
    pub at_vertices: Vec<Attribute>,
    /// Attributes of the elements; tensors have nine values for each element, row after row.
    pub at_elements: Vec<Attribute>,
}

/// Fields at the centres of the cells of the grid.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrameFields {
    /// Number of cells along each axis; 1 along the third one in 2D.
    pub extent: [usize; 3],
    /// Centre of the first cell, m.
    pub first: [f64; 3],
    /// Size of a cell, m.
    pub dx: f64,
    /// Attributes of the cells, the first axis fastest; vectors have three values for each cell.
    pub attributes: Vec<Attribute>,
}

/// A quantity with one or more values for each vertex, element or cell.
#[derive(Clone, Debug, PartialEq)]
pub struct Attribute {
    /// Name, one word.
    pub name: Cow<'static, str>,
    /// Unit, `1` for a number without one.
    pub unit: Cow<'static, str>,
    /// Meaning, a phrase.
    pub meaning: Cow<'static, str>,
    /// Values; those of a vector or tensor one after another.
    pub values: Vec<f64>,
}

impl Frame {
    /// A frame without content at time 0, in metres.
    pub fn empty(up_axis: usize) -> Self {
        Self {
            time: 0.0,
            interval: None,
            unit: 1.0,
            up_axis,
            liquid: FrameMesh::default(),
            solids: Vec::new(),
            contact_line: None,
            wall_solid: None,
            elements: Vec::new(),
            fields: None,
        }
    }

    /// The unit of the positions as text, with this word or symbol for the metre: `metre`, or `0.01 metre`.
    pub fn unit_text(&self, metre: &str) -> String {
        if self.unit == 1.0 { metre.to_owned() } else { format!("{} {metre}", self.unit) }
    }
}

impl Attribute {
    /// An attribute whose texts are constants.
    pub fn new(name: &'static str, unit: &'static str, meaning: &'static str, values: Vec<f64>) -> Self {
        Self { name: name.into(), unit: unit.into(), meaning: meaning.into(), values }
    }
}

impl FrameMesh {
    /// The values of an attribute, if the mesh has it.
    pub fn values(&self, name: &str) -> Option<&[f64]> {
        self.attributes.iter().find(|a| a.name == name).map(|a| a.values.as_slice())
    }

    /// The three attributes that are the components of a vector, at each vertex; `None` if one is missing.
    pub fn vectors(&self, names: [&str; 3]) -> Option<Vec<[f64; 3]>> {
        let [x, y, z] = names.map(|name| self.values(name));
        let of = x?.iter().zip(y?).zip(z?);
        Some(of.map(|((x, y), z)| [*x, *y, *z]).collect())
    }

    /// Normal of each vertex, of length 1: that of the adjacent triangles, weighted with their areas. Vertices without a triangle, and
    /// those whose triangles cancel, have the third axis.
    pub fn normals(&self) -> Vec<[f64; 3]> {
        let mut sums = vec![[0.0; 3]; self.positions.len()];
        for triangle in &self.triangles {
            let [a, b, c] = triangle.map(|v| self.positions[v as usize]);
            let [u, v]: [[f64; 3]; 2] = [b, c].map(|x| std::array::from_fn(|k| x[k] - a[k]));
            let across: [f64; 3] = std::array::from_fn(|k| {
                let (i, j) = ((k + 1) % 3, (k + 2) % 3);
                u[i] * v[j] - u[j] * v[i]
            });
            triangle.iter().for_each(|v| (0..3).for_each(|k| sums[*v as usize][k] += across[k]));
        }
        let unit = |sum: [f64; 3]| {
            // Scaled first: the square of a tiny area is below the smallest number.
            let largest = sum.iter().fold(0.0, |l: f64, x| l.max(x.abs()));
            let scaled = sum.map(|x| x / largest);
            let length = scaled.iter().map(|x| x * x).sum::<f64>().sqrt();
            if largest > 0.0 { scaled.map(|x| x / length) } else { [0.0, 0.0, 1.0] }
        };
        sums.into_iter().map(unit).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normals_are_means_by_area_and_finite() {
        let mesh = FrameMesh {
            positions: vec![[0.0; 3], [2e-200, 0.0, 0.0], [0.0, 1e-100, 0.0], [0.0, 0.0, 1e-100], [1.0; 3]],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..FrameMesh::default()
        };
        let normals = mesh.normals();
        assert_eq!((normals[3], normals[4]), ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]));
        assert!(normals.iter().flatten().all(|x| x.is_finite()));
        let mesh = FrameMesh {
            positions: vec![[0.0; 3], [3.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 4.0]],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..FrameMesh::default()
        };
        assert_eq!(mesh.normals()[0], [0.8, 0.0, 0.6]);
    }
}
