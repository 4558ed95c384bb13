//! The corpus: small files that readers accept.

use meniscus_numerics::grid::Grid;
use meniscus_numerics::mesh::ply::PlyMesh;
use meniscus_scene::build;
use meniscus_scene::builtin::BUILTINS;
use meniscus_scene::file::{LoadOptions, Scene};
use meniscus_scene::output::Folder;
use meniscus_scene::run::{ExistingRun, Job, SilentObserver, checkpoint};
use std::path::Path;

/// A file.
#[derive(Clone)]
pub struct Input {
    /// Ending of its name.
    pub ending: &'static str,
    /// Its content.
    pub bytes: Vec<u8>,
    /// Ending and content of a file that belongs to it.
    pub companion: Option<(&'static str, &'static str)>,
}

fn input(ending: &'static str, bytes: impl Into<Vec<u8>>) -> Input {
    Input { ending, bytes: bytes.into(), companion: None }
}

const TETRAHEDRON: &str =
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1/1 4/2 3/3\nf 2//1 3//2 4//3\n";
const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nl 1 2 3 4 1\n";
const STL: &str = "solid t\nfacet normal 0 0 -1\nouter loop\nvertex 0 0 0\nvertex 0 1 0\nvertex 1 0 0\nendloop\nendfacet\n\
facet normal 0 -1 0\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 0 1\nendloop\nendfacet\n\
facet normal -1 0 0\nouter loop\nvertex 0 0 0\nvertex 0 0 1\nvertex 0 1 0\nendloop\nendfacet\n\
facet normal 1 1 1\nouter loop\nvertex 1 0 0\nvertex 0 1 0\nvertex 0 0 1\nendloop\nendfacet\nendsolid t\n";
const PLY: &str = "ply\nformat ascii 1.0\ncomment t\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
property uchar kind\nelement face 4\nproperty list uchar int vertex_indices\nend_header\n0 0 0 1\n1 0 0 0\n0 1 0 2\n0 0 1 0\n\
3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
const GMSH2: &str = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 1 1\n$EndNodes\n\
$Elements\n3\n1 2 2 0 1 1 2 3\n2 4 2 0 1 1 2 3 4\n3 4 2 0 1 2 3 4 5\n$EndElements\n";
const GMSH4: &str = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 4 1 4\n3 1 0 4\n1\n2\n3\n4\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n\
$EndNodes\n$Elements\n2 2 1 2\n2 1 2 1\n1 1 2 3\n3 1 4 1\n2 1 2 3 4\n$EndElements\n";
const NODE: &str = "# nodes\n4 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n";
const ELE: &str = "1 4 0\n1 1 2 3 4\n";
const VTK: &str = "# vtk DataFile Version 3.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 double\n0 0 0 1 0 0 0 1 0 0 0 1\n\
CELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n10\n";

fn ply_mesh() -> PlyMesh {
    let mut mesh = PlyMesh {
        positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        faces: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
        ..PlyMesh::default()
    };
    for name in ["kind", "phi_c", "strain"] {
        mesh.scalars.insert(name.into(), vec![0.0, 1.0, 2.0, 0.0]);
    }
    mesh
}

fn binary_ply(mesh: &PlyMesh) -> Vec<u8> {
    let mut bytes = Vec::new();
    mesh.write(&mut bytes).unwrap();
    bytes
}

/// Closed surfaces.
pub fn surfaces() -> Vec<Input> {
    let mut binary_stl = vec![b' '; 80];
    binary_stl.extend(1u32.to_le_bytes());
    binary_stl.extend((0..12).flat_map(|i| (i as f32).to_le_bytes()).chain([0, 0]));
    vec![
        input("obj", TETRAHEDRON),
        input("obj", SQUARE),
        input("stl", STL),
        input("stl", binary_stl),
        input("ply", PLY),
        input("ply", binary_ply(&ply_mesh())),
    ]
}

/// Meshes of elements.
pub fn volumes() -> Vec<Input> {
    let with = |ending, text: &str, other| Input { companion: Some(other), ..input(ending, text) };
    let mut binary_vtk =
        b"# vtk DataFile Version 3.0\nt\nBINARY\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 double\n".to_vec();
    let points: [f64; 12] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
    binary_vtk.extend(points.iter().flat_map(|x| x.to_be_bytes()));
    binary_vtk.extend(b"\nCELLS 1 5\n");
    binary_vtk.extend([4i32, 0, 1, 2, 3].iter().flat_map(|x| x.to_be_bytes()));
    binary_vtk.extend(b"\nCELL_TYPES 1\n");
    binary_vtk.extend(10i32.to_be_bytes());
    vec![
        input("msh", GMSH2),
        input("msh", GMSH4),
        with("node", NODE, ("ele", ELE)),
        with("ele", ELE, ("node", NODE)),
        input("vtk", VTK),
        input("vtk", binary_vtk),
    ]
}

/// Meshes of frames.
pub fn frames() -> Vec<Input> {
    let edges = PlyMesh { faces: Vec::new(), edges: vec![[0, 1], [1, 2], [2, 3], [3, 0]], ..ply_mesh() };
    vec![input("ply", PLY), input("ply", binary_ply(&ply_mesh())), input("ply", binary_ply(&edges))]
}

/// All built-in scenes.
pub fn scenes() -> Vec<Input> {
    let texts = BUILTINS.iter().map(|entry| entry.text);
    texts.map(|text| input("toml", text)).collect()
}

const PAINTED: &str = r#"
format = 1
name = "painted"
domain = { dimension = 3, size = ["4 mm", "4 mm", "3 mm"], resolution = 12 }
liquid = { density = "1 g/cm^3", kinematic_viscosity = "1 mm^2/s", body = [ { shape.ball = { center = ["2 mm", "2 mm", "1.5 mm"], radius = "0.9 mm" } } ] }
solid = [ { name = "plate", shape.half_space = { point = ["2 mm", "2 mm", "0.8 mm"], normal = [0, 0, 1] }, material.rigid = { fixed = true } } ]
[tension]
liquid_air = "72 mN/m"
[tension.plate]
contact_angle = "90 deg"
image = { file = "IMAGE", black = "30 deg", white = "120 deg", lower = ["0 mm", "0 mm"], upper = ["4 mm", "4 mm"] }
[output]
duration = "1 ms"
frame_interval = "1 ms"
formats = ["ply"]
"#;

/// A scene with the place `IMAGE` for the file of an image.
pub fn painted_scene() -> &'static str {
    PAINTED
}

/// Images of a few pixels: grey, and colours with transparency.
pub fn images() -> Vec<Input> {
    let picture = |color, samples: usize| {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, 4, 3);
        encoder.set_color(color);
        let data: Vec<u8> = (0..12 * samples).map(|i| (i * 37 % 256) as u8).collect();
        encoder.write_header().unwrap().write_image_data(&data).unwrap();
        bytes
    };
    vec![input("png", picture(png::ColorType::Grayscale, 1)), input("png", picture(png::ColorType::Rgba, 4))]
}

const SMALL: &str = r#"
format = 1
name = "small"
domain = { dimension = 2, size = ["4 mm", "4 mm"], resolution = 12 }
liquid = { density = "1 g/cm^3", kinematic_viscosity = "1 mm^2/s", body = [ { shape.ball = { center = ["2 mm", "1.5 mm"], radius = "0.9 mm" } } ] }
solid = [ { name = "plate", shape.half_space = { point = ["2 mm", "0.6 mm"], normal = [0, 1] }, material.rigid = { fixed = true } } ]
tension = { liquid_air = "72 mN/m", plate = { contact_angle = "90 deg" } }
output = { duration = "1 ms", frame_interval = "0.5 ms", formats = ["ply"], checkpoint_every = 1 }
"#;

/// The folder of a run of a small scene.
fn run() -> (Folder, Job, Grid<2>) {
    let scene = Scene::from_text("small.toml", SMALL, Path::new("."), &LoadOptions::default()).unwrap();
    let folder = Folder::at(&std::env::temp_dir().join(format!(
        "meniscus-fuzz-run-{}-{:?}",
        std::process::id(),
        std::thread::current().id()
    )));
    let job = Job::of(&scene, scene.to_toml().unwrap());
    let setup = build::setup::<2>(&scene).unwrap();
    meniscus_scene::run::run(&setup, &job, &folder, ExistingRun::Replace, &|| None, &mut SilentObserver)
        .unwrap();
    (folder, job, setup.model.grid)
}

/// Checkpoints, with the identity of their scene and their grid.
pub fn checkpoints() -> (Vec<Input>, u64, Grid<2>) {
    let (folder, job, grid) = run();
    let files = checkpoint::list(&folder.checkpoints());
    let inputs = files.iter().map(|path| input("ckpt", std::fs::read(path).unwrap())).collect();
    std::fs::remove_dir_all(folder.root()).unwrap();
    (inputs, job.identity, grid)
}

/// The time series and the summary of a run.
pub fn tables() -> Vec<Input> {
    let (folder, ..) = run();
    let [series, summary] = [folder.series(), folder.summary()].map(|path| std::fs::read(path).unwrap());
    std::fs::remove_dir_all(folder.root()).unwrap();
    vec![input("csv", series), input("json", summary)]
}
