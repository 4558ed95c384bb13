//! Formats of frames: written by a run, and exported from its folder.

use crate::common::{PLATE, Place, words};
use meniscus_numerics::mesh::ply::PlyMesh;
use std::path::Path;

/// Files of a folder with an extension, by name.
fn files(folder: &Path, extension: &str) -> Vec<(String, Vec<u8>)> {
    let mut all: Vec<(String, Vec<u8>)> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == extension))
        .map(|path| (path.file_name().unwrap().to_str().unwrap().to_owned(), std::fs::read(&path).unwrap()))
        .collect();
    all.sort();
    all
}

#[test]
fn a_run_and_an_export_write_the_same_files() {
    let place = Place::new("export");
    let scene = PLATE.replace("[\"ply\"]", "[\"ply\", \"vtk\", \"vti\", \"obj\", \"glb\", \"usd\", \"csv\"]");
    std::fs::write(place.path("plate.toml"), scene).unwrap();
    place.expect("run plate.toml --out run --quiet", 0);
    let frames = place.path("run/frames");
    for format in ["ply", "vtk", "obj", "glb", "usd", "csv"] {
        place.expect(&format!("export run --to {format}"), 0);
        let exported = place.path(&format!("run/export/{format}"));
        let extensions = match format {
            "vtk" => vec!["vtp", "pvd"],
            "usd" => vec!["usda"],
            _ => vec![format],
        };
        for extension in extensions {
            let of_run: Vec<_> =
                files(&frames, extension).into_iter().filter(|f| f.0 != "fields.pvd").collect();
            assert!(!of_run.is_empty(), "{extension}");
            assert_eq!(of_run, files(&exported, extension), "{extension}");
        }
    }
    assert_eq!(files(&frames, "vti").len(), files(&frames, "glb").len());
    // A second export leaves no file of the first one.
    place.expect("export run --to obj --frames 1:4 --every 2", 0);
    let names: Vec<String> = files(&place.path("run/export/obj"), "obj").into_iter().map(|f| f.0).collect();
    let solids: Vec<&String> = names.iter().filter(|n| n.starts_with("solid_plate")).collect();
    assert_eq!(solids, ["solid_plate_0001.obj", "solid_plate_0003.obj"]);
    // In 2D y points up already.
    place.expect("export run --to ply --frames 2 --scale 1000 --up z --out big", 0);
    let [old, new] = [frames.join("liquid_0002.ply"), place.path("big/liquid_0002.ply")]
        .map(|path| PlyMesh::load(&path).unwrap());
    let turned: Vec<[f64; 3]> =
        old.positions.iter().map(|[x, y, z]| [x * 1000.0, -z * 1000.0, y * 1000.0]).collect();
    let mut scalars = old.scalars.clone();
    let [y, z] = ["vy", "vz"].map(|name| old.scalars[name].clone());
    scalars.insert("vy".into(), z.iter().map(|v| -v).collect());
    scalars.insert("vz".into(), y);
    assert_eq!((&new.edges, &new.scalars, new.positions), (&old.edges, &scalars, turned));
    assert!(old.comments.contains(&"unit metre".into()) && new.comments.contains(&"unit 0.001 metre".into()));
}

#[test]
fn what_cannot_be_exported_is_told() {
    let place = Place::new("no-export");
    let told = |line: &str, status: i32, parts: &[&str]| {
        let said = words(&place.expect(line, status));
        parts.iter().for_each(|part| assert!(said.contains(part), "`{line}`: {said}"));
    };
    told("export nowhere --to obj", 4, &["nowhere", "output folder of a run"]);
    place.expect("run small.toml --until 0.6ms --out run --quiet", 0);
    told("export run --to obj --frames 90:99", 2, &["no frame in the range", "0 to 2"]);
    told("export run --to ply --out run/frames", 2, &["--out"]);
    told("export run --to csv", 0, &["no frame has a contact line"]);
    std::fs::write(place.path("run/frames/liquid_0001.ply"), "ply\n").unwrap();
    told("export run --to glb", 4, &["liquid_0001.ply", "--frames"]);
}
