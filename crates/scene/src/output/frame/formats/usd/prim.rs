//! Prims of a frame: meshes, curves and points with their attributes.

use crate::output::frame::known::VELOCITIES;
use crate::output::frame::{Attribute, Frame, FrameMesh, polylines};
use std::collections::BTreeSet;

/// Frames per second at which programs play the frames. Time codes count frames, so a run plays in slow motion.
pub(super) const FRAMES_PER_SECOND: u32 = 24;

/// Width of curves and points over the mean length of the liquid's edges: a line as wide as this hides no facet. Chosen without experiment.
const WIDTH_PER_EDGE: f64 = 0.5;

/// Attributes of a contact line. A frame without one has them, too, as empty arrays.
const LINE_ATTRIBUTES: [&str; 6] = ["angle", "speed", "fx", "fy", "fz", "solid"];

/// The material that a prim is bound to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Material {
    /// Water.
    Liquid,
    /// A dull solid.
    Solid,
    /// A coloured line.
    Line,
}

impl Material {
    /// Name of its prim.
    pub fn name(self) -> &'static str {
        match self {
            Self::Liquid => "liquid",
            Self::Solid => "solid",
            Self::Line => "line",
        }
    }

    /// Colour of what is bound to it in programs that show no materials.
    pub fn display_color(self) -> &'static str {
        match self {
            Self::Liquid => "(0.35, 0.63, 0.86)",
            Self::Solid => "(0.75, 0.73, 0.7)",
            Self::Line => "(0.82, 0.16, 0.16)",
        }
    }
}

/// Name of a prim, the name that programs show, and its material.
pub(super) struct Label {
    /// An identifier.
    pub name: String,
    /// The name as in the scene.
    pub shown: String,
    /// The material.
    pub material: Material,
}

/// Makes identifiers of names, each only once.
#[derive(Default)]
pub(super) struct Naming {
    used: BTreeSet<String>,
}

impl Naming {
    /// The label of a prim with this name.
    pub fn label(&mut self, name: &str, material: Material) -> Label {
        let plain = identifier(name);
        let numbered = (2..).map(|n| format!("{plain}_{n}"));
        let mut candidates = std::iter::once(plain.clone()).chain(numbered);
        let free = candidates.find(|name| !self.used.contains(name)).unwrap_or(plain);
        self.used.insert(free.clone());
        Label { name: free, shown: name.to_owned(), material }
    }
}

/// A text with `_` for every character that an identifier may not have.
fn identifier(text: &str) -> String {
    let allowed = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
    text.chars().map(allowed).collect()
}

/// Values of an attribute.
pub(super) enum Values {
    /// Whole numbers.
    Integers(Vec<i32>),
    /// Numbers.
    Floats(Vec<f32>),
    /// Vectors.
    Vectors(Vec<[f32; 3]>),
}

/// An attribute of a prim whose values change from frame to frame.
pub(super) struct Property {
    /// Type, such as `point3f[]`.
    pub kind: &'static str,
    /// Name with its namespace.
    pub name: String,
    /// How values belong to vertices; `None` for attributes of the schema that say so themselves.
    pub interpolation: Option<&'static str>,
    /// Unit, or empty.
    pub unit: String,
    /// Meaning, or empty.
    pub meaning: String,
    /// The values.
    pub values: Values,
}

impl Property {
    /// An attribute of the schema.
    fn new(kind: &'static str, name: &str, values: Values) -> Self {
        let (unit, meaning) = (String::new(), String::new());
        Self { kind, name: name.to_owned(), interpolation: None, unit, meaning, values }
    }

    fn with_interpolation(self, interpolation: &'static str) -> Self {
        Self { interpolation: Some(interpolation), ..self }
    }

    /// An attribute of the frame as a primvar, at the vertices of `order`.
    fn primvar(attribute: &Attribute, order: &[u32]) -> Self {
        let at = |v: &u32| attribute.values.get(*v as usize).copied().unwrap_or_default();
        let (kind, values) = match &*attribute.name {
            "kind" | "solid" => ("int[]", Values::Integers(order.iter().map(|v| at(v) as i32).collect())),
            _ => ("float[]", Values::Floats(order.iter().map(|v| at(v) as f32).collect())),
        };
        Self {
            kind,
            name: format!("primvars:{}", identifier(&attribute.name)),
            interpolation: Some("vertex"),
            unit: attribute.unit.to_string(),
            meaning: attribute.meaning.to_string(),
            values,
        }
    }
}

/// A prim of the root.
pub(super) struct Prim {
    /// Type: `Mesh`, `BasisCurves` or `Points`.
    pub kind: &'static str,
    /// Its names and its material.
    pub label: Label,
    /// Attributes that are the same in all frames, as text.
    pub fixed: &'static [&'static str],
    /// Attributes that change.
    pub properties: Vec<Property>,
}

/// A contact line without vertices.
pub(super) fn empty_line() -> FrameMesh {
    let attributes = LINE_ATTRIBUTES.map(|name| Attribute::known(name, Vec::new()));
    FrameMesh { attributes: attributes.to_vec(), ..FrameMesh::default() }
}

/// Scales of a frame.
pub(super) struct Scales {
    /// Width of curves and points, in units of the positions.
    width: f32,
    /// Factor from velocities, m/s, to units of the positions a second of playback; `None` if the frames' interval is not known.
    velocity: Option<f64>,
}

impl Scales {
    /// Those of a frame.
    pub fn of(frame: &Frame) -> Self {
        let playback = |interval| interval * f64::from(FRAMES_PER_SECOND) / frame.unit;
        Self { width: width(frame), velocity: frame.interval.map(playback) }
    }
}

/// Triangles with normals.
pub(super) fn triangles(label: Label, mesh: &FrameMesh, scales: &Scales) -> Prim {
    let order: Vec<u32> = (0..mesh.positions.len() as u32).collect();
    let indices = mesh.triangles.iter().flatten().map(|v| *v as i32).collect();
    let normals = mesh.normals().iter().map(|n| n.map(|x| x as f32)).collect();
    let mut properties = vec![
        Property::new("int[]", "faceVertexCounts", Values::Integers(vec![3; mesh.triangles.len()])),
        Property::new("int[]", "faceVertexIndices", Values::Integers(indices)),
        Property::new("normal3f[]", "normals", Values::Vectors(normals)).with_interpolation("vertex"),
    ];
    add_points(&mut properties, mesh, &order, &Scales { width: 0.0, ..*scales });
    Prim { kind: "Mesh", label, fixed: &["uniform token subdivisionScheme = \"none\""], properties }
}

/// Edges as polylines; a closed one ends with its first vertex.
pub(super) fn curves(label: Label, mesh: &FrameMesh, scales: &Scales) -> Prim {
    let lines = polylines(mesh.positions.len(), &mesh.edges);
    let counts = lines.iter().map(|line| line.len() as i32).collect();
    let mut properties = vec![
        Property::new("int[]", "curveVertexCounts", Values::Integers(counts)),
        Property::new("float[]", "widths", Values::Floats(vec![scales.width])).with_interpolation("constant"),
    ];
    add_points(&mut properties, mesh, &lines.concat(), scales);
    let fixed = &["uniform token type = \"linear\"", "uniform token wrap = \"nonperiodic\""];
    Prim { kind: "BasisCurves", label, fixed, properties }
}

/// Points without edges.
pub(super) fn points(label: Label, mesh: &FrameMesh, scales: &Scales) -> Prim {
    let order: Vec<u32> = (0..mesh.positions.len() as u32).collect();
    let widths = Property::new("float[]", "widths", Values::Floats(vec![scales.width]));
    let mut properties = vec![widths.with_interpolation("constant")];
    add_points(&mut properties, mesh, &order, scales);
    Prim { kind: "Points", label, fixed: &[], properties }
}

/// Adds positions, their bounds widened by half a width, velocities, and the attributes of the frame, at the vertices of `order`.
fn add_points(properties: &mut Vec<Property>, mesh: &FrameMesh, order: &[u32], scales: &Scales) {
    let width = scales.width;
    let positions: Vec<[f32; 3]> =
        order.iter().map(|v| mesh.positions[*v as usize].map(|x| x as f32)).collect();
    let bound = |start: f32, of: fn(f32, f32) -> f32, by: f32| -> [f32; 3] {
        std::array::from_fn(|k| positions.iter().map(|x| x[k]).fold(start, of) + by)
    };
    let (low, high) =
        (bound(f32::INFINITY, f32::min, -0.5 * width), bound(f32::NEG_INFINITY, f32::max, 0.5 * width));
    let extent = if positions.is_empty() { vec![[0.0; 3]; 2] } else { vec![low, high] };
    properties.push(Property::new("float3[]", "extent", Values::Vectors(extent)));
    properties.push(Property::new("point3f[]", "points", Values::Vectors(positions)));
    if let Some((factor, all)) = scales.velocity.zip(mesh.vectors(VELOCITIES)) {
        let of = |v: &u32| all[*v as usize].map(|x| (factor * x) as f32);
        let values = Values::Vectors(order.iter().map(of).collect());
        properties.push(Property::new("vector3f[]", "velocities", values));
    }
    properties.extend(mesh.attributes.iter().map(|attribute| Property::primvar(attribute, order)));
}

/// Width of curves and points, in units of the positions: half the mean length of the edges of the liquid's surface, or of the first solid
/// that has edges.
fn width(frame: &Frame) -> f32 {
    let meshes = [&frame.liquid].into_iter().chain(frame.solids.iter().map(|(_, mesh)| mesh));
    let mean = |mesh: &FrameMesh| {
        let sides = mesh.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        let edges: Vec<[u32; 2]> = sides.chain(mesh.edges.iter().copied()).collect();
        let length = |edge: &[u32; 2]| {
            let [a, b] = edge.map(|v| mesh.positions[v as usize]);
            (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
        };
        let sum = edges.iter().map(length).sum::<f64>();
        (sum > 0.0).then(|| sum / edges.len() as f64)
    };
    meshes.filter_map(mean).next().map_or(1e-4, |edge| (WIDTH_PER_EDGE * edge) as f32)
}
