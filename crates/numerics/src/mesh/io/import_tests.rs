//! Import of valid and broken files.

use super::*;
use crate::Matrix;
use crate::mesh::io::read_from_disk;
use crate::shape::{MeshShape, Shape};
use std::sync::Arc;

/// A file with the given content in a new folder.
fn file(name: &str, content: &[u8]) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("meniscus-import-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join(name);
    std::fs::write(&path, content).unwrap();
    path
}

fn load<const D: usize>(path: &Path) -> Result<SurfaceMesh<D>, ImportError> {
    super::load(path, &read_from_disk)
}

/// A cube of side 2 about the origin: quads, outward.
const CUBE: &str = "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n\
    f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

fn inside_out(obj: &str) -> String {
    obj.lines()
        .map(|l| match l.strip_prefix("f ") {
            Some(f) => format!("f {}\n", f.split(' ').rev().collect::<Vec<_>>().join(" ")),
            None => format!("{l}\n"),
        })
        .collect()
}

#[test]
fn mesh_import_of_a_cube_in_all_formats() {
    let cube = load::<3>(&file("cube.obj", CUBE.as_bytes())).unwrap();
    assert_eq!((cube.positions.len(), cube.facets.len()), (8, 12));
    assert!((cube.volume() - 8.0).abs() < 1e-14);
    let turned = load::<3>(&file("inside-out.obj", inside_out(CUBE).as_bytes())).unwrap();
    assert!((turned.volume() - 8.0).abs() < 1e-14);

    let triangles: Vec<stl_io::Triangle> = (0..12)
        .map(|f| stl_io::Triangle {
            normal: stl_io::Normal::new([0.0; 3]),
            vertices: cube
                .corners(f)
                .map(|p| stl_io::Vertex::new([p[0], p[1], p[2]].map(|x| x as f32 * 0.1))),
        })
        .collect();
    let mut bytes = Vec::new();
    stl_io::write_stl(&mut bytes, triangles.iter()).unwrap();
    let stl = load::<3>(&file("cube.STL", &bytes)).unwrap();
    assert_eq!((stl.positions.len(), stl.facets.len()), (8, 12));
    assert!((stl.volume() - 8e-3).abs() < 1e-8);

    let ply = PlyMesh {
        positions: cube.positions.iter().map(|p| [p[0], p[1], p[2]]).collect(),
        faces: cube.facets.clone(),
        ..Default::default()
    };
    let path = file("cube.ply", b"");
    ply.save(&path).unwrap();
    assert_eq!(load::<3>(&path).unwrap(), cube);
}

#[test]
fn mesh_import_of_outlines() {
    // A square with a hole, drawn in either direction, and an island in the hole.
    let square = |r: f64, first: usize, closing: &str| {
        format!("v {r} {r} 0\nv {r} -{r} 0\nv -{r} -{r} 0\nv -{r} {r} 0\n{closing}")
            .replace('#', &first.to_string())
    };
    let text = square(3.0, 1, "l 1 2 3 4 1\n")
        + &square(2.0, 5, "l 5 6\nl 7 6\nl 7 8\nl 8 5\n")
        + &square(1.0, 9, "l -4 -3 -2 -1 -4\n");
    let mesh = load::<2>(&file("rings.obj", text.as_bytes())).unwrap();
    assert!(mesh.is_watertight());
    assert!((mesh.volume() - (36.0 - 16.0 + 4.0)).abs() < 1e-13);
    let tree = crate::mesh::FacetBvh::new(&mesh);
    for (x, inside) in [(0.5, true), (1.5, false), (2.5, true), (3.5, false)] {
        assert_eq!(tree.signed_distance(&Vector::from([x, 0.1])), if inside { -0.5 } else { 0.5 });
    }
}

#[test]
fn mesh_import_names_the_defect() {
    let message =
        |name: &str, content: &str| load::<3>(&file(name, content.as_bytes())).unwrap_err().to_string();
    let hole = message("hole.obj", CUBE.trim_end_matches("f 4 1 5 8\n"));
    assert!(
        hole.contains("hole.obj: the surface is not closed: 4 ") && hole.contains("fill the holes"),
        "{hole}"
    );
    let mixed = message("mixed.obj", &CUBE.replace("f 4 1 5 8", "f 8 5 1 4"));
    assert!(mixed.contains("4 edges lie between facets that face opposite sides"), "{mixed}");
    assert!(message("empty.obj", "v 0 0 0\n").contains("holds no triangles"));
    assert!(message("cube.step", CUBE).contains("use .obj, .stl or .ply"));
    assert!(message("nan.obj", &CUBE.replace("v 1 1 1", "v nan 1 1")).contains("not a finite number"));
    assert!(message("sheet.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 3 2 1\n").contains("no volume"));
    let thin = CUBE.replace("f 1 2 6 5", "v 0 -1 -1\nf 1 2 9\nf 1 9 2 6 5");
    assert!(message("thin.obj", &thin).contains("2 triangles have no area"));
    message("bad.stl", "solid nothing\nfacet");
    message("bad.obj", "f 1 2 9\n");
    let missing = load::<3>(Path::new("/nowhere/at-all.stl")).unwrap_err();
    assert!(matches!(missing, ImportError::Read { .. }));
    let bent = load::<2>(&file("bent.obj", b"v 0 0 0\nv 1 0 1\nv 0 1 0\nl 1 2 3 1\n")).unwrap_err();
    assert!(matches!(bent, ImportError::NotPlanar { vertex: 1, .. }));
    let open = load::<2>(&file("open.obj", b"v 0 0\nv 1 0\nv 0 1\nl 1 2 3\n")).unwrap_err();
    assert!(matches!(open, ImportError::Open { open: 2, .. }));
    assert!(matches!(load::<2>(&file("c.stl", b"")).unwrap_err(), ImportError::Format { .. }));
}

#[test]
fn a_surface_that_passes_through_itself_is_refused() {
    let load = |text: &str| MeshShape::<3>::load(&file("two.obj", text.as_bytes()), &read_from_disk);
    // The cube and a second one: beside it, overlapping it by half, or sharing a side with it.
    let pair = |shift: f64| {
        let vertex = |line: &str| {
            let x: Vec<f64> = line.split(' ').skip(1).map(|x| x.parse().unwrap()).collect();
            format!("v {} {} {}\n", x[0] + shift, x[1], x[2])
        };
        let facet = |line: &str| {
            let corners = line.split(' ').skip(1).map(|i| format!(" {}", i.parse::<usize>().unwrap() + 8));
            format!("f{}\n", corners.collect::<String>())
        };
        let more = CUBE.lines().map(|l| if l.starts_with('v') { vertex(l) } else { facet(l) });
        CUBE.to_owned() + &more.collect::<String>()
    };
    assert!(load(&pair(2.5)).is_ok());
    for shift in [1.0, 2.0] {
        let error = load(&pair(shift)).unwrap_err().to_string();
        assert!(error.contains("two.obj: the surface passes through itself"), "{error}");
    }
}

#[test]
fn mesh_shape_agrees_with_the_box_it_is() {
    let path = file("shape.obj", CUBE.as_bytes());
    let (s, c) = 0.3f64.sin_cos();
    let rotation = Matrix::<3>::from([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]);
    let center = Vector::from([0.2, 0.1, -0.3]);
    let mesh = MeshShape::load(&path, &read_from_disk).unwrap();
    let mesh = MeshShape::new(mesh.surface().clone().transformed(0.5, &rotation, &center));
    let exact = Shape::Box { center, half_size: Vector::repeat(0.5), rotation };
    let mesh = Shape::Mesh(Arc::new(mesh));
    assert!((mesh.volume().unwrap() - 1.0).abs() < 1e-14);
    assert!((mesh.bounds().1 - exact.bounds().1).norm() < 1e-14);
    for k in 0..4000 {
        let x = Vector::from_fn(|a, _| ((k * [7, 11, 13][a] + 5 * a) % 101) as f64 / 50.0 - 0.93);
        assert!((mesh.signed_distance(&x) - exact.signed_distance(&x)).abs() < 1e-14);
    }
    let mirrored = load::<3>(&path).unwrap().transformed(-2.0, &Matrix::identity(), &Vector::zeros());
    assert!((mirrored.volume() - 64.0).abs() < 1e-12);
}

/// Any bytes give a closed surface or an error.
#[test]
fn mesh_import_survives_broken_files() {
    let cube = load::<3>(&file("whole.obj", CUBE.as_bytes())).unwrap();
    let triangles: Vec<stl_io::Triangle> = (0..12)
        .map(|f| stl_io::Triangle {
            normal: stl_io::Normal::new([0.0; 3]),
            vertices: cube.corners(f).map(|p| stl_io::Vertex::new([p[0], p[1], p[2]].map(|x| x as f32))),
        })
        .collect();
    let mut binary = Vec::new();
    stl_io::write_stl(&mut binary, triangles.iter()).unwrap();
    binary[..5].copy_from_slice(b"solid");
    assert_eq!(load::<3>(&file("solid-binary.stl", &binary)).unwrap().facets.len(), 12);
    let mut ascii = String::from("solid cube\n");
    for f in 0..12 {
        ascii += "facet normal 0 0 0\nouter loop\n";
        cube.corners(f).iter().for_each(|p| ascii += &format!("vertex {} {} {}\n", p[0], p[1], p[2]));
        ascii += "endloop\nendfacet\n";
    }
    ascii += "endsolid cube\n";
    assert_eq!(load::<3>(&file("ascii.stl", ascii.as_bytes())).unwrap().facets.len(), 12);
    let line = "v 0 0\nv 1 0\nv 0 1\nl 1 2 3 1\n";
    for (name, whole) in [
        ("b.stl", &binary[..]),
        ("a.stl", ascii.as_bytes()),
        ("c.obj", CUBE.as_bytes()),
        ("l.obj", line.as_bytes()),
    ] {
        for k in 0..whole.len().min(300) {
            let at = k * whole.len() / whole.len().min(300);
            let mut flipped = whole.to_vec();
            flipped[at] ^= 1 << (k % 8);
            for content in [&flipped[..], &whole[..at]] {
                let path = file(name, content);
                if let Ok(mesh) = load::<3>(&path) {
                    assert!(mesh.is_watertight() && mesh.volume() > 0.0);
                }
                if let Ok(mesh) = load::<2>(&path) {
                    assert!(mesh.is_watertight() && mesh.volume() > 0.0);
                }
            }
        }
    }
}
