//! Frames as Wavefront OBJ, a file for each mesh.
//!
//! Surfaces in 3D are triangles with smooth vertex normals; surfaces in 2D and contact lines are polylines, the contact points in 2D are
//! points. The format has no attributes of vertices.

use crate::output::frame::{Frame, FrameMesh, FrameWriter, polylines};
use crate::output::{FileError, Folder, atomic_file};
use std::io::{self, Write};
use std::path::PathBuf;

/// Writes `liquid_NNNN.obj`, `solid_NAME_NNNN.obj` and `contact_line_NNNN.obj`. Meshes without vertices have no file.
#[derive(Clone, Copy, Debug)]
pub struct ObjWriter;

impl FrameWriter for ObjWriter {
    fn write(&self, folder: &Folder, number: u64, frame: &Frame) -> Result<PathBuf, FileError> {
        let solids = frame.solids.iter().map(|(name, mesh)| (format!("solid_{name}"), mesh));
        let line = frame.contact_line.iter().map(|mesh| ("contact_line".to_owned(), mesh));
        let meshes = [("liquid".to_owned(), &frame.liquid)].into_iter().chain(solids).chain(line);
        for (name, mesh) in meshes.filter(|(_, mesh)| !mesh.positions.is_empty()) {
            let path = folder.frame_file(&name, number, "obj");
            atomic_file::write_atomically(&path, |file| write(file, &name, mesh, frame))?;
        }
        Ok(folder.frame_file("liquid", number, "obj"))
    }
}

fn write(file: &mut impl Write, name: &str, mesh: &FrameMesh, frame: &Frame) -> io::Result<()> {
    let (version, time, unit) = (env!("CARGO_PKG_VERSION"), frame.time, frame.unit_text("metre"));
    writeln!(file, "# Meniscus {version}\n# time {time:?} s\n# unit {unit}\no {name}")?;
    mesh.positions.iter().try_for_each(|[x, y, z]| writeln!(file, "v {x:?} {y:?} {z:?}"))?;
    if !mesh.triangles.is_empty() {
        // Seven digits, as a renderer has them.
        mesh.normals().iter().try_for_each(|n| {
            let [x, y, z] = n.map(|x| x as f32);
            writeln!(file, "vn {x:?} {y:?} {z:?}")
        })?;
        for [a, b, c] in mesh.triangles.iter().map(|t| t.map(|v| v + 1)) {
            writeln!(file, "f {a}//{a} {b}//{b} {c}//{c}")?;
        }
    }
    let mut element = |letter: &str, vertices: &mut dyn Iterator<Item = u32>| {
        write!(file, "{letter}")?;
        for vertex in vertices {
            write!(file, " {}", vertex + 1)?;
        }
        writeln!(file)
    };
    polylines(mesh.positions.len(), &mesh.edges)
        .into_iter()
        .try_for_each(|line| element("l", &mut line.into_iter()))?;
    if mesh.triangles.is_empty() && mesh.edges.is_empty() {
        element("p", &mut (0..mesh.positions.len() as u32))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::frame::formats::tests::{Place, empty_frame, full_frame};

    /// The numbers behind the letters of a file's elements.
    fn numbers(text: &str, letter: &str) -> Vec<Vec<f64>> {
        let of = |line: &str| {
            let words = line.split_whitespace().skip(1);
            words.map(|w| w.split('/').next().unwrap().parse().unwrap()).collect()
        };
        text.lines().filter(|l| l.split_whitespace().next() == Some(letter)).map(of).collect()
    }

    #[test]
    fn files_have_the_vertices_triangles_normals_and_polylines() {
        let place = Place::new("obj");
        let mut frame = full_frame();
        ObjWriter.write(&place.0, 0, &frame).unwrap();
        assert_eq!(place.files(), ["contact_line_0000.obj", "liquid_0000.obj", "solid_plate_0000.obj"]);
        let text = place.text("liquid_0000.obj");
        let positions: Vec<Vec<f64>> = frame.liquid.positions.iter().map(|x| x.to_vec()).collect();
        assert_eq!(numbers(&text, "v"), positions);
        assert_eq!(numbers(&text, "f")[1], [1.0, 2.0, 4.0]);
        assert_eq!(numbers(&text, "vn").len(), 4);
        assert!(text.contains("# time 0.30000000000000004 s"));
        assert_eq!(numbers(&place.text("contact_line_0000.obj"), "l"), [[1.0, 2.0, 3.0]]);

        frame.contact_line.as_mut().unwrap().edges.clear();
        let frame = Frame { contact_line: frame.contact_line, ..empty_frame() };
        ObjWriter.write(&place.0, 1, &frame).unwrap();
        assert_eq!(numbers(&place.text("contact_line_0001.obj"), "p"), [[1.0, 2.0, 3.0]]);
        assert!(!place.files().contains(&"liquid_0001.obj".to_owned()));
    }
}
