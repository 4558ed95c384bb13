//! Frames as VTK XML files, which ParaView, VTK and PyVista read.
//!
//! Surfaces in 3D are polygons, contact lines and surfaces in 2D polylines, contact points in 2D vertices. Point data have the names of
//! the PLY attributes, and their units as information keys; every file has its time as the field `TimeValue`.

mod collection;
mod document;
mod image;

use self::collection::Part;
use self::document::Document;
use crate::output::frame::{Frame, FrameElements, FrameMesh, FrameParts, FrameWriter, polylines};
use crate::output::{FileError, Folder, atomic_file};
use std::path::{Path, PathBuf};

pub use image::VtiWriter;

/// VTK's numbers of the types of cells.
const VTK_TRIANGLE: u8 = 5;
const VTK_TETRAHEDRON: u8 = 10;

/// Writes `liquid_NNNN.vtp`, `solid_NAME_NNNN.vtp` and `contact_line_NNNN.vtp`, for each deformable solid `solid_NAME_NNNN.vtu`, and
/// `run.pvd`. Meshes without vertices have no file.
#[derive(Clone, Copy, Debug)]
pub struct VtkWriter;

impl FrameWriter for VtkWriter {
    fn write(&self, folder: &Folder, number: u64, frame: &Frame) -> Result<PathBuf, FileError> {
        let mut parts = Vec::new();
        let mut file = |name: String, extension| {
            let path = folder.frame_file(&name, number, extension);
            parts.push(Part { name, extension });
            path
        };
        let liquid = file("liquid".into(), "vtp");
        save_surface(&liquid, &frame.liquid, frame.time)?;
        let line = file("contact_line".into(), "vtp");
        frame.contact_line.iter().try_for_each(|mesh| save_surface(&line, mesh, frame.time))?;
        for (name, mesh) in &frame.solids {
            save_surface(&file(format!("solid_{name}"), "vtp"), mesh, frame.time)?;
        }
        for (name, elements) in &frame.elements {
            save(&file(format!("solid_{name}"), "vtu"), &unstructured(elements, frame.time))?;
        }
        collection::write(folder, "run", &parts)?;
        Ok(liquid)
    }

    fn parts(&self) -> FrameParts {
        FrameParts { elements: true, fields: false }
    }
}

fn save(path: &Path, document: &Document) -> Result<(), FileError> {
    atomic_file::write_atomically(path, |writer| document.write(writer))
}

fn save_surface(path: &Path, mesh: &FrameMesh, time: f64) -> Result<(), FileError> {
    if mesh.positions.is_empty() { Ok(()) } else { save(path, &poly_data(mesh, time)) }
}

/// A surface, or a contact line.
fn poly_data(mesh: &FrameMesh, time: f64) -> Document {
    let points = mesh.positions.len();
    let lines = polylines(points, &mesh.edges);
    let vertices = if lines.is_empty() && mesh.triangles.is_empty() { points } else { 0 };
    let mut document = Document::new("PolyData", "", time, false);
    let counts = format!(
        " NumberOfPoints=\"{points}\" NumberOfVerts=\"{vertices}\" NumberOfLines=\"{}\" NumberOfStrips=\"0\" NumberOfPolys=\"{}\"",
        lines.len(),
        mesh.triangles.len()
    );
    document.element("Piece", &counts, |d| {
        d.element("PointData", "", |d| mesh.attributes.iter().for_each(|a| d.attribute(a, points)));
        d.element("Points", "", |d| d.positions(&mesh.positions));
        d.element("Verts", "", |d| {
            d.integers("connectivity", 0..vertices as i64);
            d.integers("offsets", 1..=vertices as i64);
        });
        d.element("Lines", "", |d| {
            d.integers("connectivity", lines.iter().flatten().map(|v| i64::from(*v)));
            let mut end = 0;
            d.integers(
                "offsets",
                lines.iter().map(|line| {
                    end += line.len() as i64;
                    end
                }),
            );
        });
        d.element("Polys", "", |d| {
            d.integers("connectivity", mesh.triangles.iter().flatten().map(|v| i64::from(*v)));
            d.integers("offsets", (1..=mesh.triangles.len() as i64).map(|n| 3 * n));
        });
    });
    document
}

/// The elements of a solid.
fn unstructured(elements: &FrameElements, time: f64) -> Document {
    let (points, cells) = (elements.positions.len(), elements.simplices.len());
    let (corners, kind) = if elements.are_triangles { (3, VTK_TRIANGLE) } else { (4, VTK_TETRAHEDRON) };
    let mut document = Document::new("UnstructuredGrid", "", time, false);
    let counts = format!(" NumberOfPoints=\"{points}\" NumberOfCells=\"{cells}\"");
    document.element("Piece", &counts, |d| {
        d.element("PointData", "", |d| elements.at_vertices.iter().for_each(|a| d.attribute(a, points)));
        d.element("CellData", "", |d| elements.at_elements.iter().for_each(|a| d.attribute(a, cells)));
        d.element("Points", "", |d| d.positions(&elements.positions));
        d.element("Cells", "", |d| {
            let all = elements.simplices.iter().flat_map(|s| &s[..corners]);
            d.integers("connectivity", all.map(|v| i64::from(*v)));
            d.integers("offsets", (1..=cells as i64).map(|n| n * corners as i64));
            d.bytes("types", &vec![kind; cells]);
        });
    });
    document
}

#[cfg(test)]
mod tests {
    use super::document::tests::{array, attribute_of, doubles, longs, parts};
    use super::*;
    use crate::output::frame::formats::tests::{Place, full_frame};

    fn read(place: &Place, file: &str) -> Vec<u8> {
        std::fs::read(place.path(file)).unwrap()
    }

    #[test]
    fn surfaces_lines_and_elements_come_back() {
        let (place, frame) = (Place::new("vtk"), full_frame());
        VtkWriter.write(&place.0, 7, &frame).unwrap();
        let names = [
            "contact_line_0007.vtp",
            "liquid_0007.vtp",
            "run.pvd",
            "solid_plate_0007.vtp",
            "solid_plate_0007.vtu",
        ];
        assert_eq!(place.files(), names);
        let liquid = read(&place, "liquid_0007.vtp");
        let (head, _) = parts(&liquid);
        assert!(head.contains(">0.30000000000000004<"));
        assert_eq!(attribute_of(&head, "NumberOfPolys", "NumberOfPolys"), "4");
        assert_eq!(doubles(&array(&liquid, "Points")), frame.liquid.positions.concat());
        assert_eq!(array(&liquid, "kind"), [0, 1, 2, 0]);
        let solid = read(&place, "solid_plate_0007.vtp");
        assert_eq!(doubles(&array(&solid, "phi_c")), frame.solids[0].1.values("phi_c").unwrap());
        assert!(parts(&solid).0.contains("UNITS_LABEL"));
        let line = read(&place, "contact_line_0007.vtp");
        let (head, data) = parts(&line);
        assert_eq!(attribute_of(&head, "NumberOfLines", "NumberOfLines"), "1");
        let lines = head.split("<Lines>").nth(1).unwrap();
        let at: usize = attribute_of(lines, "connectivity", "offset").parse().unwrap();
        assert_eq!(longs(&data[at + 8..at + 32]), [0, 1, 2]);
        let elements = read(&place, "solid_plate_0007.vtu");
        assert_eq!(longs(&array(&elements, "connectivity")), [0, 1, 2, 3, 3, 2, 1, 0]);
        assert_eq!(
            (longs(&array(&elements, "offsets")), array(&elements, "types")),
            (vec![4, 8], vec![10, 10])
        );
        assert_eq!(doubles(&array(&elements, "green_strain")).len(), 18);
        assert_eq!(attribute_of(&parts(&elements).0, "green_strain", "NumberOfComponents"), "9");
    }

    #[test]
    fn the_collection_lists_what_is_in_the_folder() {
        let (place, mut frame) = (Place::new("pvd"), full_frame());
        for (number, time) in [0.0, 0.1, 0.2].into_iter().enumerate() {
            frame.time = time;
            VtkWriter.write(&place.0, number as u64, &frame).unwrap();
        }
        let listed = |place: &Place| {
            let text = place.text("run.pvd");
            let of = |line: &str| {
                (attribute_of(line, "DataSet", "timestep"), attribute_of(line, "DataSet", "file"))
            };
            text.lines().filter(|l| l.starts_with("<DataSet")).map(of).collect::<Vec<_>>()
        };
        assert_eq!(listed(&place).len(), 12);
        // A resumed run removes the collection and the frames that it writes again.
        place.0.remove_frames_from(2).unwrap();
        assert!(!place.path("run.pvd").exists());
        (frame.time, frame.contact_line) = (0.25, None);
        VtkWriter.write(&place.0, 2, &frame).unwrap();
        let all = listed(&place);
        assert_eq!(all[1], ("0.0".into(), "contact_line_0000.vtp".into()));
        assert_eq!(all[4], ("0.1".into(), "liquid_0001.vtp".into()));
        assert_eq!(
            all[8..],
            [
                ("0.25".into(), "liquid_0002.vtp".into()),
                ("0.25".into(), "solid_plate_0002.vtp".into()),
                ("0.25".into(), "solid_plate_0002.vtu".into()),
            ]
        );
    }
}
