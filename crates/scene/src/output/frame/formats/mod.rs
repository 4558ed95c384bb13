//! Formats of the output, and their writers, one file each.

mod csv;
mod glb;
mod obj;
mod ply;
mod usd;
mod vdb;
mod vtk;

use super::FrameWriter;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

pub use csv::CsvWriter;
pub use glb::GlbWriter;
pub use obj::ObjWriter;
pub use ply::PlyWriter;
pub use usd::UsdWriter;
pub use vdb::VdbWriter;
pub use vtk::{VtiWriter, VtkWriter};

/// A format of the output (docs/formats.md).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Format {
    /// Surfaces of each frame as binary PLY; always written.
    Ply,
    /// One self-contained HTML page of the run.
    Page,
    /// VTK XML for ParaView: surfaces and contact lines (`.vtp`), elements of deformable solids with displacement and strain (`.vtu`),
    /// and `run.pvd` with the times.
    Vtk,
    /// VTK XML for ParaView: level set, velocity and pressure on the grid (`.vti`), and `fields.pvd` with the times.
    Vti,
    /// Surfaces and contact lines of each frame as Wavefront OBJ.
    Obj,
    /// Each frame as one binary glTF file, for slides and the web.
    Glb,
    /// Each frame as USD text (`.usda`), with materials, and `run.usda`, which plays them all; for Houdini, Blender and `usdview`.
    Usd,
    /// OpenVDB (`.vdb`), 3D only: the level set in a band around the surface, and the velocity; for Houdini, Blender and renderers.
    Vdb,
    /// The contact line of each frame as a table: position, angle, speed, force.
    Csv,
}

impl Format {
    /// All formats, in the order of their definition.
    pub const ALL: [Self; 9] =
        [Self::Ply, Self::Page, Self::Vtk, Self::Vti, Self::Obj, Self::Glb, Self::Usd, Self::Vdb, Self::Csv];

    /// The name in scene files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ply => "ply",
            Self::Page => "page",
            Self::Vtk => "vtk",
            Self::Vti => "vti",
            Self::Obj => "obj",
            Self::Glb => "glb",
            Self::Usd => "usd",
            Self::Vdb => "vdb",
            Self::Csv => "csv",
        }
    }

    /// The writer; `None` for a format that is not made frame by frame.
    pub fn frame_writer(self) -> Option<Arc<dyn FrameWriter>> {
        match self {
            Self::Ply => Some(Arc::new(PlyWriter)),
            Self::Vtk => Some(Arc::new(VtkWriter)),
            Self::Vti => Some(Arc::new(VtiWriter)),
            Self::Obj => Some(Arc::new(ObjWriter)),
            Self::Glb => Some(Arc::new(GlbWriter)),
            Self::Usd => Some(Arc::new(UsdWriter)),
            Self::Vdb => Some(Arc::new(VdbWriter)),
            Self::Csv => Some(Arc::new(CsvWriter)),
            // The page is made from the folder at the end of a run.
            Self::Page => None,
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::{Attribute, Frame, FrameElements, FrameFields, FrameMesh};
    use super::*;
    use crate::output::Folder;
    use std::path::PathBuf;

    /// A frame at time 0 without content.
    pub fn empty_frame() -> Frame {
        Frame::empty(2)
    }

    /// A frame with everything: a tetrahedron as liquid and as solid, a line of three vertices, two elements and two cells.
    pub fn full_frame() -> Frame {
        let positions = vec![[0.1, 0.0, 0.0], [1.0, 1e-7, 0.0], [0.0, 1.0 / 3.0, 0.0], [0.0, 0.0, 1.0]];
        let triangles = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        let mesh = FrameMesh { positions: positions.clone(), triangles, ..FrameMesh::default() };
        let with = |mesh: &FrameMesh, all: &[(&'static str, Vec<f64>)]| FrameMesh {
            attributes: all.iter().map(|(name, values)| Attribute::known(name, values.clone())).collect(),
            ..mesh.clone()
        };
        let line = FrameMesh {
            positions: positions[..3].to_vec(),
            edges: vec![[0, 1], [1, 2]],
            ..FrameMesh::default()
        };
        Frame {
            time: 0.1 + 0.2,
            liquid: with(&mesh, &[("kind", vec![0.0, 1.0, 2.0, 0.0])]),
            solids: vec![("plate".into(), with(&mesh, &[("phi_c", vec![-0.25, 0.5, 1.0 / 3.0, 0.0])]))],
            contact_line: Some(with(
                &line,
                &[
                    ("angle", vec![89.5, 90.0, 91.25]),
                    ("speed", vec![-1e-9, 0.0, 2.0]),
                    ("solid", vec![0.0; 3]),
                ],
            )),
            elements: vec![(
                "plate".into(),
                FrameElements {
                    positions,
                    simplices: vec![[0, 1, 2, 3], [3, 2, 1, 0]],
                    are_triangles: false,
                    at_vertices: vec![Attribute::new(
                        "displacement",
                        "m",
                        "",
                        (0..12).map(f64::from).collect(),
                    )],
                    at_elements: vec![Attribute::new(
                        "green_strain",
                        "1",
                        "",
                        (0..18).map(f64::from).collect(),
                    )],
                },
            )],
            fields: Some(FrameFields {
                extent: [2, 1, 1],
                first: [0.5, 0.25, 0.0],
                dx: 0.5,
                attributes: vec![Attribute::new("phi", "m", "", vec![-0.5, 0.25])],
            }),
            ..empty_frame()
        }
    }

    /// A temporary folder of a test, removed at its end.
    pub struct Place(pub Folder);

    impl Place {
        pub fn new(name: &str) -> Self {
            let root = std::env::temp_dir().join(format!("meniscus-{name}-{}", std::process::id()));
            let _ = std::fs::remove_dir_all(&root);
            let folder = Folder::at(&root);
            folder.make().unwrap();
            Self(folder)
        }

        pub fn text(&self, file: &str) -> String {
            std::fs::read_to_string(self.0.frames().join(file)).unwrap()
        }

        /// Names of the files, sorted.
        pub fn files(&self) -> Vec<String> {
            let entries = std::fs::read_dir(self.0.frames()).unwrap();
            let mut all: Vec<String> =
                entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
            all.sort();
            all
        }

        pub fn path(&self, file: &str) -> PathBuf {
            self.0.frames().join(file)
        }
    }

    impl Drop for Place {
        fn drop(&mut self) {
            let _ = std::fs::remove_dir_all(self.0.root());
        }
    }

    #[test]
    fn names_are_those_of_scene_files() {
        for format in Format::ALL {
            assert_eq!(serde_json::to_value(format).unwrap(), format.name());
        }
    }
}
