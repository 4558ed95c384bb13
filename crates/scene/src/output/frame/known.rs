//! The attributes that frames of this version have, with their units, and frames from stored PLY files.

use super::{Attribute, FrameMesh};
use meniscus_numerics::mesh::ply::PlyMesh;

/// Name, unit and meaning of the attributes of surfaces and contact lines.
const KNOWN: [(&str, &str, &str); 16] = [
    ("kind", "1", "0 liquid-air, 1 liquid-solid, 2 contact line"),
    ("phi_c", "m", "signed distance to the contact line along the surface, negative where wetted"),
    ("ux", "m", DISPLACEMENT),
    ("uy", "m", DISPLACEMENT),
    ("uz", "m", DISPLACEMENT),
    ("vx", "m/s", VELOCITY),
    ("vy", "m/s", VELOCITY),
    ("vz", "m/s", VELOCITY),
    ("strain", "1", "largest |stretch - 1|"),
    ("young", "deg", "Young's contact angle through the liquid"),
    ("angle", "deg", "contact angle through the liquid"),
    ("speed", "m/s", "speed across the line, positive where it advances"),
    ("fx", "N/m", LINE_FORCE),
    ("fy", "N/m", LINE_FORCE),
    ("fz", "N/m", LINE_FORCE),
    ("solid", "1", "number of the solid in the scene"),
];

const DISPLACEMENT: &str = "displacement from the position at rest";
const VELOCITY: &str = "velocity, half a time step ahead of the positions";
const LINE_FORCE: &str = "force on the solid per length of the line";

/// Components of the normal in stored files; they follow from the triangles.
pub(super) const NORMAL: [&str; 3] = ["nx", "ny", "nz"];

/// Components of the velocity.
pub(super) const VELOCITIES: [&str; 3] = ["vx", "vy", "vz"];

/// Comment by which a PLY file of a contact line names the number of the domain's walls, without the number.
pub(super) const WALLS_COMMENT: &str = "are the walls of the domain";

impl Attribute {
    /// An attribute by its name, with the unit and the meaning that it has in all frames; a name that is not known has none.
    pub(super) fn known(name: &'static str, values: Vec<f64>) -> Self {
        let found = KNOWN.iter().find(|known| known.0 == name);
        let &(_, unit, meaning) = found.unwrap_or(&(name, "1", ""));
        Self::new(name, unit, meaning, values)
    }

    /// An attribute of a stored file. Unit and meaning of one that this version does not know are in a comment `NAME MEANING, UNIT`.
    fn stored(name: &str, comments: &[String], values: Vec<f64>) -> Self {
        if let Some(&(name, ..)) = KNOWN.iter().find(|known| known.0 == name) {
            return Self::known(name, values);
        }
        let told = comments.iter().find_map(|c| c.strip_prefix(name)?.strip_prefix(' ')?.rsplit_once(", "));
        let (meaning, unit) = told.unwrap_or(("", "1"));
        let owned = |text: &str| text.to_owned().into();
        Self { name: owned(name), unit: owned(unit), meaning: owned(meaning), values }
    }
}

/// Order of an attribute among those of a mesh: as in frames of a run, others after them by name.
fn order(name: &str) -> usize {
    KNOWN.iter().position(|known| known.0 == name).unwrap_or(KNOWN.len())
}

impl From<PlyMesh> for FrameMesh {
    /// The mesh of a stored file with its attributes.
    fn from(mesh: PlyMesh) -> Self {
        let PlyMesh { positions, faces: triangles, edges, scalars, comments } = mesh;
        let read = |(name, values): (String, Vec<f64>)| Attribute::stored(&name, &comments, values);
        let attributes = scalars.into_iter().filter(|(name, _)| !NORMAL.contains(&name.as_str()));
        let mut attributes: Vec<Attribute> = attributes.map(read).collect();
        attributes.sort_by_key(|a| order(&a.name));
        Self { positions, triangles, edges, attributes }
    }
}

/// The number of the domain's walls that the comments of a stored contact line name.
pub fn stored_wall_solid(comments: &[String]) -> Option<usize> {
    let number = |c: &String| c.strip_prefix("solid ")?.strip_suffix(WALLS_COMMENT)?.trim().parse().ok();
    comments.iter().find_map(number)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stored_attributes_have_units_and_an_order() {
        let mut mesh = PlyMesh {
            positions: vec![[0.0; 3]],
            comments: vec![
                "curvature curvature of the line, its mean, 1/m".into(),
                "solid 3 are the walls of the domain".into(),
            ],
            ..PlyMesh::default()
        };
        for name in ["curvature", "solid", "fx", "angle"] {
            mesh.scalars.insert(name.into(), vec![2.0]);
        }
        assert_eq!(stored_wall_solid(&mesh.comments), Some(3));
        let mesh = FrameMesh::from(mesh);
        let told: Vec<(&str, &str)> = mesh.attributes.iter().map(|a| (&*a.name, &*a.unit)).collect();
        assert_eq!(told, [("angle", "deg"), ("fx", "N/m"), ("solid", "1"), ("curvature", "1/m")]);
        assert_eq!(mesh.attributes[3].meaning, "curvature of the line, its mean");
    }
}
