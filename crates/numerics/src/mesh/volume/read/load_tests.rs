//! Import of valid and broken files.

use super::*;
use crate::mesh::io::read_from_disk;
use crate::mesh::volume::block::block;
use std::fmt::Write;

/// A file with the given content in a new folder.
fn file(name: &str, content: &[u8]) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("meniscus-volume-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join(name);
    std::fs::write(&path, content).unwrap();
    path
}

fn load<const D: usize>(path: &Path) -> Result<VolumeMesh<D>, VolumeImportError> {
    super::load(path, &read_from_disk)
}

fn example<const D: usize>() -> VolumeMesh<D> {
    block([2; D], &Vector::from_fn(|a, _| 1.0 + a as f64))
}

fn coordinates<const D: usize>(x: &Vector<D>) -> [f64; 3] {
    std::array::from_fn(|a| if a < D { x[a] } else { 0.0 })
}

fn vertices<const D: usize>(s: &Simplex<D>) -> Vec<u32> {
    s.vertices().collect()
}

/// Words separated by spaces.
fn words(x: impl IntoIterator<Item = impl std::fmt::Display>) -> String {
    x.into_iter().map(|x| x.to_string()).collect::<Vec<_>>().join(" ")
}

/// Gmsh 2.2 file with a line and a point of the boundary; numbers start at 11.
fn msh_2<const D: usize>(mesh: &VolumeMesh<D>, binary: bool) -> Vec<u8> {
    let kind = if D == 2 { 2 } else { 4 };
    let mut out = format!("$MeshFormat\n2.2 {} 8\n", u8::from(binary)).into_bytes();
    if binary {
        out.extend(1i32.to_le_bytes());
        out.push(b'\n');
    }
    out.extend(b"$EndMeshFormat\n$PhysicalNames\n1\n2 1 \"body of $End\"\n$EndPhysicalNames\n");
    out.extend(format!("$Nodes\n{}\n", mesh.positions.len()).into_bytes());
    for (i, x) in mesh.positions.iter().enumerate() {
        if binary {
            out.extend((i as i32 + 11).to_le_bytes());
            coordinates(x).iter().for_each(|c| out.extend(c.to_le_bytes()));
        } else {
            out.extend(format!("{} {}\n", i + 11, words(coordinates(x))).into_bytes());
        }
    }
    out.extend(format!("\n$EndNodes\n$Elements\n{}\n", mesh.simplices.len() + 1).into_bytes());
    let mut element = |head: [i32; 2], nodes: &[u32]| {
        let nodes: Vec<i32> = nodes.iter().map(|v| *v as i32 + 11).collect();
        if binary {
            let all = [vec![head[1], 1, 2, head[0], 1, 1], nodes].concat();
            all.iter().for_each(|x| out.extend(x.to_le_bytes()));
        } else {
            out.extend(format!("{} {} 2 1 1 {}\n", head[0], head[1], words(nodes)).into_bytes());
        }
    };
    element([1, 1], &[0, 1]);
    for (i, s) in mesh.simplices.iter().enumerate() {
        element([i as i32 + 2, kind], &vertices(s));
    }
    out.extend(b"\n$EndElements\n");
    out
}

/// Gmsh 4.1 file with two blocks of vertices, the second with parameters.
fn msh_4<const D: usize>(mesh: &VolumeMesh<D>, binary: bool) -> Vec<u8> {
    let mut out = format!("$MeshFormat\n4.1 {} 8\n", u8::from(binary)).into_bytes();
    let text = !binary;
    if binary {
        out.extend(1i32.to_le_bytes());
        out.push(b'\n');
    }
    out.extend(b"$EndMeshFormat\n$Nodes\n");
    let longs = |out: &mut Vec<u8>, x: &[u64]| {
        if text {
            out.extend(format!("{}\n", words(x)).into_bytes());
        } else {
            x.iter().for_each(|x| out.extend(x.to_le_bytes()));
        }
    };
    let ints = |out: &mut Vec<u8>, x: &[i32]| {
        if text {
            out.extend(format!("{} ", words(x)).into_bytes());
        } else {
            x.iter().for_each(|x| out.extend(x.to_le_bytes()));
        }
    };
    let n = mesh.positions.len() as u64;
    longs(&mut out, &[2, n, 5, n + 4]);
    for (from, to, parametric) in [(0, n / 2, 0), (n / 2, n, 1)] {
        ints(&mut out, &[2, 1, parametric]);
        longs(&mut out, &[to - from]);
        (from..to).for_each(|i| longs(&mut out, &[i + 5]));
        for x in &mesh.positions[from as usize..to as usize] {
            let mut all = coordinates(x).to_vec();
            all.extend(vec![0.5; 2 * parametric as usize]);
            if text {
                out.extend(format!("{}\n", words(all)).into_bytes());
            } else {
                all.iter().for_each(|c| out.extend(c.to_le_bytes()));
            }
        }
    }
    out.extend(b"\n$EndNodes\n$Elements\n");
    let m = mesh.simplices.len() as u64;
    longs(&mut out, &[2, m + 1, 1, m + 1]);
    ints(&mut out, &[0, 1, 15]);
    longs(&mut out, &[1]);
    longs(&mut out, &[1, 5]);
    ints(&mut out, &[D as i32, 1, if D == 2 { 2 } else { 4 }]);
    longs(&mut out, &[m]);
    for (i, s) in mesh.simplices.iter().enumerate() {
        let all: Vec<u64> =
            std::iter::once(i as u64 + 2).chain(s.vertices().map(|v| u64::from(v) + 5)).collect();
        longs(&mut out, &all);
    }
    out.extend(b"\n$EndElements\n");
    out
}

fn vtk<const D: usize>(mesh: &VolumeMesh<D>, binary: bool, version: u8) -> Vec<u8> {
    let mut out = format!("# vtk DataFile Version {version}.1\na title\n").into_bytes();
    out.extend(if binary { "BINARY\n" } else { "ASCII\n" }.bytes());
    out.extend(b"DATASET UNSTRUCTURED_GRID\nFIELD FieldData 2\nTIME 1 1 double\n");
    // Bytes that are not text or that look like the next section.
    out.extend(if binary { 0.25f64.to_be_bytes().to_vec() } else { b"0.25".to_vec() });
    out.extend(b"\nSTEPS 2 3 short\n");
    out.extend(if binary { b"\nPOINTS 0 \n\n".to_vec() } else { b"1 2 3 4 5 6".to_vec() });
    out.extend(format!("\nPOINTS {} double\n", mesh.positions.len()).into_bytes());
    for x in mesh.positions.iter().flat_map(coordinates) {
        if binary {
            out.extend(x.to_be_bytes());
        } else {
            out.extend(format!("{x} ").into_bytes());
        }
    }
    let ints = |out: &mut Vec<u8>, x: &[i32]| {
        if binary {
            x.iter().for_each(|x| out.extend(x.to_be_bytes()));
        } else {
            out.extend(format!("{}\n", words(x)).into_bytes());
        }
    };
    let m = mesh.simplices.len() as i32;
    let all: Vec<Vec<i32>> =
        mesh.simplices.iter().map(|s| s.vertices().map(|v| v as i32).collect()).collect();
    let corners = D as i32 + 1;
    if version < 5 {
        out.extend(format!("\nCELLS {m} {}\n", m * (corners + 1)).into_bytes());
        all.iter().for_each(|v| ints(&mut out, &[vec![corners], v.clone()].concat()));
    } else {
        out.extend(
            format!("\nMETADATA\nINFORMATION 0\n\nCELLS {} {}\nOFFSETS vtktypeint64\n", m + 1, m * corners)
                .into_bytes(),
        );
        let longs = |out: &mut Vec<u8>, x: &[i32]| {
            if binary {
                x.iter().for_each(|x| out.extend(i64::from(*x).to_be_bytes()));
            } else {
                out.extend(format!("{}\n", words(x)).into_bytes());
            }
        };
        longs(&mut out, &(0..=m).map(|k| k * corners).collect::<Vec<_>>());
        out.extend(b"\nCONNECTIVITY vtktypeint64\n");
        all.iter().for_each(|v| longs(&mut out, v));
    }
    out.extend(format!("\nCELL_TYPES {m}\n").into_bytes());
    ints(&mut out, &vec![if D == 2 { 5 } else { 10 }; m as usize]);
    out.extend(b"\nCELL_DATA 0\n");
    out
}

fn tetgen<const D: usize>(mesh: &VolumeMesh<D>) -> [String; 2] {
    let mut node = format!("# vertices\n{} {D} 0 1\n", mesh.positions.len());
    for (i, x) in mesh.positions.iter().enumerate() {
        writeln!(node, "{} {} 7", i + 1, words(x.iter())).unwrap();
    }
    let mut ele = format!("{} {} 1\n", mesh.simplices.len(), D + 1);
    for (i, s) in mesh.simplices.iter().enumerate() {
        writeln!(ele, "{} {} 3 # attribute", i + 1, words(s.vertices().map(|v| v + 1))).unwrap();
    }
    [node, ele]
}

fn formats<const D: usize>() {
    let mesh = example::<D>();
    for binary in [false, true] {
        for (name, content) in [
            ("two.msh", msh_2(&mesh, binary)),
            ("four.msh", msh_4(&mesh, binary)),
            ("four.vtk", vtk(&mesh, binary, 4)),
            ("five.VTK", vtk(&mesh, binary, 5)),
        ] {
            let read = load::<D>(&file(&format!("{D}-{binary}-{name}"), &content));
            assert_eq!(read.unwrap(), mesh, "{D}D {name} {binary}");
        }
    }
    let [node, ele] = tetgen(&mesh);
    let name = |ending: &str| format!("block-{D}.{ending}");
    let path = file(&name("node"), node.as_bytes());
    file(&name("ele"), ele.as_bytes());
    assert_eq!(load::<D>(&path).unwrap(), mesh);
    assert_eq!(load::<D>(&path.with_extension("ele")).unwrap(), mesh);
}

#[test]
fn volumes_are_read_in_all_formats() {
    formats::<2>();
    formats::<3>();
}

fn mended<const D: usize>() {
    let mesh = example::<D>();
    let name = format!("mended-{D}.msh");
    let read = |mesh: &VolumeMesh<D>| load::<D>(&file(&name, &msh_2(mesh, false)));
    let mut turned = mesh.clone();
    turned.simplices.iter_mut().for_each(|s| s.others.swap(0, 1));
    assert_eq!(read(&turned).unwrap(), mesh);
    let mut unused = mesh.clone();
    unused.positions.push(Vector::repeat(9.0));
    assert_eq!(read(&unused).unwrap(), mesh);

    let message = |mesh: &VolumeMesh<D>| read(mesh).unwrap_err().to_string();
    let mut mixed = mesh.clone();
    mixed.simplices[3].others.swap(0, 1);
    let text = message(&mixed);
    assert!(
        text.contains(&format!(
            "1 of {} elements are inverted, the first is element 5",
            mesh.simplices.len()
        )),
        "{text}"
    );
    let mut flat = mesh.clone();
    let v = vertices(&flat.simplices[0]);
    flat.positions[v[0] as usize] = (flat.positions[v[1] as usize] + flat.positions[v[2] as usize]) * 0.5;
    assert!(message(&flat).contains("elements have no volume, the first is element 2"));
    let mut pinched = mesh.clone();
    pinched.simplices = mesh.simplices.iter().step_by(if D == 2 { 2 } else { 3 }).copied().collect();
    assert!(message(&pinched).contains("the boundary touches itself at vertex"), "{}", message(&pinched));
    let mut twice = mesh.clone();
    twice.simplices[0].others[0] = twice.simplices[0].root;
    assert!(message(&twice).contains("element 2 has a vertex that does not exist, or the same vertex twice"));
}

#[test]
fn volumes_are_turned_or_refused() {
    mended::<2>();
    mended::<3>();
}

#[test]
fn volume_import_names_the_defect() {
    let text = String::from_utf8(msh_2(&example::<3>(), false)).unwrap();
    let message =
        |name: &str, content: &str| load::<3>(&file(name, content.as_bytes())).unwrap_err().to_string();
    let bad = message("word.msh", &text.replacen("\n12 ", "\nx12 ", 1));
    assert!(bad.contains("word.msh, line 11: `x12` where a vertex' number should be"), "{bad}");
    assert!(message("old.msh", &text.replace("2.2 0", "1.0 0")).contains("use 2.2 or 4.1"));
    assert!(message("cut.msh", &text[..text.len() / 2]).contains("is missing"));
    let count = example::<3>().simplices.len() + 1;
    let few = text.replace(&format!("$Elements\n{count}\n"), &format!("$Elements\n{}\n", count - 1));
    assert!(message("few.msh", &few).contains("more in `$Elements` than its count says"));
    let [node, ele] = tetgen(&example::<3>());
    file("few.ele", ele.replacen(&format!("{} ", count - 1), &format!("{} ", count - 2), 1).as_bytes());
    assert!(message("few.node", &node).contains("more lines than the"));
    assert!(
        message("far.msh", &text.replace("\n2 4 2 1 1 11 ", "\n2 4 2 1 1 999 "))
            .contains("element 2 has a vertex")
    );
    assert!(
        message("hexa.msh", &text.replace("\n1 1 2 1 1 11 12", "\n1 5 2 1 1 11 12 13 14 15 16 17 18"))
            .contains("element 1 is a hexahedron; mesh with tetrahedra")
    );
    assert!(
        message("none.vtk", "# vtk DataFile Version 3.0\n\nASCII\nDATASET UNSTRUCTURED_GRID\nCELL_TYPES 0\n")
            .contains("holds no tetrahedra")
    );
    assert!(
        message("grid.vtk", "# vtk DataFile Version 3.0\n\nASCII\nDATASET POLYDATA\n")
            .contains("UNSTRUCTURED_GRID")
    );
    assert!(message("solid.stl", "").contains("use .msh (Gmsh)"));
    assert!(message("alone.node", "0 3 0 0\n").contains("alone.ele: cannot be read"));
    let plane = load::<2>(&file("plane.msh", &msh_2(&example::<3>(), false))).unwrap_err().to_string();
    assert!(plane.contains("is a tetrahedron; mesh with triangles"), "{plane}");
    let huge = message("huge.msh", &text.replace("$Nodes\n27", "$Nodes\n99999999999"));
    assert!(huge.contains("more than the file can hold"), "{huge}");
}

/// Any bytes give a mesh or an error.
#[test]
fn volume_import_survives_broken_files() {
    let mesh = example::<2>();
    for binary in [false, true] {
        for (name, whole) in [
            ("a.msh", msh_2(&mesh, binary)),
            ("b.msh", msh_4(&mesh, binary)),
            ("c.vtk", vtk(&mesh, binary, 4)),
            ("d.vtk", vtk(&mesh, binary, 5)),
        ] {
            for k in 0..80 {
                let at = k * whole.len() / 80;
                let mut flipped = whole.clone();
                flipped[at] ^= 1 << (k % 8);
                for content in [&flipped[..], &whole[..at]] {
                    if let Ok(mesh) = load::<2>(&file(name, content)) {
                        assert_eq!(mesh.check_elements(), Ok(()));
                    }
                }
            }
        }
    }
}
