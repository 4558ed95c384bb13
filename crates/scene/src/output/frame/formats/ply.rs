//! Frames as binary PLY files, one for each mesh.

use crate::output::frame::known::{NORMAL, WALLS_COMMENT};
use crate::output::frame::{Attribute, Frame, FrameMesh, FrameWriter};
use crate::output::{FileError, Folder, atomic_file};
use meniscus_numerics::mesh::ply::PlyMesh;
use std::path::{Path, PathBuf};

/// Writes `liquid_NNNN.ply`, `solid_NAME_NNNN.ply` and, where there is a contact line, `contact_line_NNNN.ply`.
#[derive(Clone, Copy, Debug)]
pub struct PlyWriter;

impl FrameWriter for PlyWriter {
    fn write(&self, folder: &Folder, number: u64, frame: &Frame) -> Result<PathBuf, FileError> {
        let file = |part: &str| folder.frame_file(part, number, "ply");
        let liquid = file("liquid");
        write(&liquid, &ply(&frame.liquid, frame))?;
        for (name, mesh) in &frame.solids {
            write(&file(&format!("solid_{name}")), &ply(mesh, frame))?;
        }
        // No file without a line: mesh readers refuse one without vertices.
        if let Some(line) = &frame.contact_line {
            let mut mesh = ply(line, frame);
            mesh.comments.extend(frame.wall_solid.map(|n| format!("solid {n} {WALLS_COMMENT}")));
            write(&file("contact_line"), &mesh)?;
        }
        Ok(liquid)
    }
}

fn write(path: &Path, mesh: &PlyMesh) -> Result<(), FileError> {
    atomic_file::write_atomically(path, |writer| mesh.write(writer))
}

fn ply(mesh: &FrameMesh, frame: &Frame) -> PlyMesh {
    let mut comments = vec![
        concat!("Meniscus ", env!("CARGO_PKG_VERSION")).into(),
        format!("time {:?}", frame.time),
        format!("unit {}", frame.unit_text("metre")),
    ];
    if !mesh.edges.is_empty() {
        comments.push("next vertex to which an edge leads, or -1".into());
    }
    comments.extend(mesh.attributes.iter().filter_map(comment));
    let attributes = mesh.attributes.iter().map(|a| (a.name.clone().into_owned(), a.values.clone()));
    let normals = if mesh.triangles.is_empty() { Vec::new() } else { mesh.normals() };
    let component = |(k, name): (usize, &str)| (name.to_owned(), normals.iter().map(|n| n[k]).collect());
    let components = NORMAL.into_iter().enumerate().filter(|_| !normals.is_empty()).map(component);
    PlyMesh {
        positions: mesh.positions.clone(),
        faces: mesh.triangles.clone(),
        edges: mesh.edges.clone(),
        scalars: attributes.chain(components).collect(),
        comments,
    }
}

/// The comment that describes an attribute. Those of the first version keep their text, some of it for several attributes.
fn comment(attribute: &Attribute) -> Option<String> {
    let text = match &*attribute.name {
        "kind" => "kind 0 liquid-air, 1 liquid-solid, 2 contact line",
        "phi_c" => "phi_c distance to the contact line along the surface, negative where wetted",
        "ux" => "ux uy uz way from the place at rest, strain largest |stretch - 1|",
        "young" => "young contact angle at rest in degrees",
        "angle" => "angle in degrees through the liquid, speed in m/s, force in N/m",
        "vx" => "vx vy vz velocity in m/s, half a time step ahead of the positions",
        "vy" | "vz" | "uy" | "uz" | "strain" | "speed" | "fx" | "fy" | "fz" | "solid" => return None,
        _ => return Some(format!("{} {}, {}", attribute.name, attribute.meaning, attribute.unit)),
    };
    Some(text.into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::frame::formats::tests::empty_frame;

    #[test]
    fn attributes_are_described_in_comments() {
        let attribute = |name, unit, meaning| Attribute::new(name, unit, meaning, vec![1.0]);
        let line = FrameMesh {
            positions: vec![[0.0; 3]],
            attributes: vec![
                attribute("angle", "deg", "contact angle"),
                attribute("speed", "m/s", "speed"),
                attribute("curvature", "1/m", "curvature of the line"),
            ],
            ..FrameMesh::default()
        };
        let frame = Frame { time: 0.25, contact_line: Some(line.clone()), ..empty_frame() };
        let mesh = ply(&line, &frame);
        let told = [
            "time 0.25",
            "unit metre",
            "angle in degrees through the liquid, speed in m/s, force in N/m",
            "curvature curvature of the line, 1/m",
        ];
        assert_eq!(mesh.comments[1..], told);
        assert!(["angle", "curvature", "speed"].iter().eq(mesh.scalars.keys()));
    }
}
