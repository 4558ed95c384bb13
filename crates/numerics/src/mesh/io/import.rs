//! Import of closed surfaces: `.obj`, `.stl` and `.ply` in 3D, closed polylines (`.obj` elements `l`, `.ply` edges)
//! in 2D. Coordinates are in metres.
//!
//! Coincident vertices are welded (STL repeats them per triangle, OBJ per group). Facets that become degenerate are
//! dropped, and an inverted surface is flipped. The direction of a polyline is ignored: its outermost loops are filled,
//! loops within them are holes, and so on.

use super::ReadFile;
use super::ply::{PlyError, PlyMesh};
use crate::Vector;
use crate::mesh::SurfaceMesh;
use std::collections::HashMap;
use std::io;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why a mesh file cannot be used. Each message says how to repair the file.
#[derive(Debug, Error)]
pub enum ImportError {
    /// The file could not be read.
    #[error("{}: cannot be read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// The content does not match the file name extension.
    #[error("{}: the file is not a readable mesh: {what}; export it again as .obj, .stl or .ply", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        what: String,
    },
    /// The extension is not that of a supported format.
    #[error("{}: {found:?} is not a mesh format of a {dimension}D scene; use {accepted}", path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// Extension found.
        found: String,
        /// Dimension requested.
        dimension: usize,
        /// Extensions accepted.
        accepted: &'static str,
    },
    /// The file has no facets.
    #[error("{}: the file holds no {element}; a {dimension}D scene needs a closed surface of them", path.display())]
    Empty {
        /// The file.
        path: PathBuf,
        /// Missing elements: triangles or edges.
        element: &'static str,
        /// Dimension requested.
        dimension: usize,
    },
    /// A coordinate is not a finite number or an index points past the vertices.
    #[error("{}: facet {facet} has {what}; export the mesh again", path.display())]
    Facet {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        what: &'static str,
        /// Number of the facet, from 0.
        facet: usize,
    },
    /// The surface intersects itself.
    #[error(
        "{}: the surface passes through itself or touches itself near {at:?}; repair it (Blender: Boolean union, \
         or 3D-Print Toolbox, Make Manifold)", path.display()
    )]
    SelfIntersection {
        /// The file.
        path: PathBuf,
        /// Location in the file's coordinates.
        at: Vec<f64>,
    },
    /// A 2D outline does not lie in the plane z = 0.
    #[error("{}: vertex {vertex} has z = {z}; an outline of a 2D scene lies in z = 0", path.display())]
    NotPlanar {
        /// The file.
        path: PathBuf,
        /// Number of the vertex, from 0.
        vertex: usize,
        /// Its z coordinate.
        z: f64,
    },
    /// The surface has holes.
    #[error(
        "{}: the surface is not closed: {open} of its edges (2D: end points) bound an odd number of facets, \
         the first near {near:?}; fill the holes, or remove superfluous facets (Blender finds them: Select > All by \
         Trait > Non Manifold)", path.display()
    )]
    Open {
        /// The file.
        path: PathBuf,
        /// Number of open ridges.
        open: usize,
        /// Location of the first, m.
        near: Vec<f64>,
    },
    /// Neighbouring facets have opposite orientation.
    #[error(
        "{}: {ridges} edges lie between facets that face opposite sides, the first near {near:?}; \
         make the normals consistent (Blender: Mesh > Normals > Recalculate Outside)", path.display()
    )]
    Inconsistent {
        /// The file.
        path: PathBuf,
        /// Number of such ridges.
        ridges: usize,
        /// Location of the first, m.
        near: Vec<f64>,
    },
    /// A triangle is degenerate: it has no area.
    #[error(
        "{}: {facets} triangles have no area, the first near {near:?}; remove them \
         (Blender: Mesh > Clean Up > Degenerate Dissolve)", path.display()
    )]
    Degenerate {
        /// The file.
        path: PathBuf,
        /// Number of such triangles.
        facets: usize,
        /// Location of the first, m.
        near: Vec<f64>,
    },
    /// The surface encloses no volume.
    #[error("{}: the surface encloses no volume; give the shape a thickness", path.display())]
    NoVolume {
        /// The file.
        path: PathBuf,
    },
}

/// Vertices and facets as in the file.
#[derive(Default)]
struct RawSurface {
    points: Vec<[f64; 3]>,
    facets: Vec<Vec<u32>>,
}

/// Reads and checks a closed surface and orients it outward; positions in m. `read` gives the content of the file.
///
/// # Errors
/// The file cannot be read or used; the message says how to repair it.
pub fn load<const D: usize>(path: &Path, read: ReadFile) -> Result<SurfaceMesh<D>, ImportError> {
    let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    let read = || read(path).map_err(|source| ImportError::Read { path: path.into(), source });
    let content = |what: String| ImportError::Content { path: path.into(), what };
    let (raw, tolerance) = match (ending.as_str(), D) {
        ("ply", _) => (from_ply::<D>(&read()?).map_err(content)?, 1e-9),
        ("obj", 2) => (obj_lines(&String::from_utf8_lossy(&read()?)).map_err(content)?, 1e-9),
        ("obj", _) => (obj_faces(&read()?).map_err(content)?, 1e-9),
        ("stl", 3) => (stl_faces(&read()?).map_err(content)?, 1e-6),
        _ => {
            let accepted = if D == 2 { ".obj (elements l) or .ply (edges)" } else { ".obj, .stl or .ply" };
            return Err(ImportError::Format { path: path.into(), found: ending, dimension: D, accepted });
        }
    };
    from_raw(path, raw, tolerance)
}

/// Checks the content of a file and makes a closed outward surface of it. `tolerance` is the weld distance over the
/// diagonal of the mesh.
fn from_raw<const D: usize>(
    path: &Path,
    RawSurface { points, facets }: RawSurface,
    tolerance: f64,
) -> Result<SurfaceMesh<D>, ImportError> {
    if facets.is_empty() {
        let element = if D == 2 { "edges" } else { "triangles" };
        return Err(ImportError::Empty { path: path.into(), element, dimension: D });
    }
    let mut mesh = SurfaceMesh::<D> { positions: Vec::with_capacity(points.len()), facets: Vec::new() };
    for (vertex, p) in points.iter().enumerate() {
        if D == 2 && p[2].abs() > 1e-6 * (p[0].abs() + p[1].abs()) {
            return Err(ImportError::NotPlanar { path: path.into(), vertex, z: p[2] });
        }
        mesh.positions.push(Vector::from_fn(|a, _| p[a]));
    }
    for (facet, f) in facets.iter().enumerate() {
        let fail = |what| Err(ImportError::Facet { path: path.into(), what, facet });
        if f.len() != D || f.iter().any(|v| *v as usize >= points.len()) {
            return fail("a vertex that does not exist");
        }
        let v: [u32; D] = std::array::from_fn(|k| f[k]);
        if v.iter().any(|v| !mesh.positions[*v as usize].iter().all(|x| x.is_finite())) {
            return fail("a coordinate that is not a finite number");
        }
        mesh.facets.push(v);
    }
    let mut mesh = weld(&mesh, tolerance);
    if D == 2 {
        orient_loops(&mut mesh);
    }
    check_closed(path, &mesh)?;
    let (lower, upper) = mesh.bounds();
    let least = 1e-14 * (upper - lower).norm().powi(D as i32 - 1);
    let thin: Vec<usize> = (0..mesh.facets.len()).filter(|f| mesh.area_vector(*f).norm() <= least).collect();
    if let Some(first) = thin.first() {
        let near = mesh.corners(*first)[0].as_slice().to_vec();
        return Err(ImportError::Degenerate { path: path.into(), facets: thin.len(), near });
    }
    let volume = mesh.volume();
    if volume.abs() <= 1e-12 * (upper - lower).norm().powi(D as i32) {
        return Err(ImportError::NoVolume { path: path.into() });
    }
    if volume < 0.0 {
        mesh.flip();
    }
    Ok(mesh)
}

/// Merges vertices nearer than `tolerance` times the diagonal; drops unused vertices and degenerate facets.
pub fn weld<const D: usize>(mesh: &SurfaceMesh<D>, tolerance: f64) -> SurfaceMesh<D> {
    let used = mesh.facets.iter().flatten().map(|v| mesh.positions[*v as usize]);
    let start = (Vector::repeat(f64::INFINITY), Vector::repeat(f64::NEG_INFINITY));
    let (lower, upper) = used.fold(start, |(l, u): (Vector<D>, Vector<D>), p| (l.inf(&p), u.sup(&p)));
    let reach = (tolerance * (upper - lower).norm()).max(f64::MIN_POSITIVE);
    let key = |p: &Vector<D>| -> [i64; D] {
        std::array::from_fn(|a| ((p[a] - lower[a]) / (2.0 * reach)).floor() as i64)
    };
    let mut out = SurfaceMesh { positions: Vec::new(), facets: Vec::new() };
    let mut cells: HashMap<[i64; D], Vec<u32>> = HashMap::new();
    let mut number = vec![u32::MAX; mesh.positions.len()];
    for facet in &mesh.facets {
        for v in facet.map(|v| v as usize) {
            if number[v] != u32::MAX {
                continue;
            }
            let p = mesh.positions[v];
            let near = (0..1usize << D).find_map(|corner| {
                let side = |a: usize| if corner >> a & 1 == 1 { reach } else { -reach };
                let cell = cells.get(&key(&(p + Vector::from_fn(|a, _| side(a)))))?;
                cell.iter().copied().find(|w| (out.positions[*w as usize] - p).norm() <= reach)
            });
            number[v] = near.unwrap_or_else(|| {
                out.positions.push(p);
                let new = out.positions.len() as u32 - 1;
                cells.entry(key(&p)).or_default().push(new);
                new
            });
        }
        let f = facet.map(|v| number[v as usize]);
        if (0..D).all(|k| f[k] != f[(k + 1) % D]) {
            out.facets.push(f);
        }
    }
    out
}

/// Checks that each ridge bounds an even number of facets, half of them in each direction.
fn check_closed<const D: usize>(path: &Path, mesh: &SurfaceMesh<D>) -> Result<(), ImportError> {
    let near = |v: u32| mesh.positions[v as usize].as_slice().to_vec();
    let ridges = mesh.ridges();
    let odd = |c: &&[([u32; 2], i32)]| c.len() % 2 == 1;
    let groups = || ridges.chunk_by(|a, b| a.0 == b.0);
    if let Some(first) = groups().find(odd) {
        return Err(ImportError::Open {
            path: path.into(),
            open: groups().filter(odd).count(),
            near: near(first[0].0[0]),
        });
    }
    let turned = |c: &&[([u32; 2], i32)]| c.iter().map(|r| r.1).sum::<i32>() != 0;
    if let Some(first) = groups().find(turned) {
        let ridges = groups().filter(turned).count();
        return Err(ImportError::Inconsistent { path: path.into(), ridges, near: near(first[0].0[0]) });
    }
    Ok(())
}

/// Chains edges into loops; those within an odd number of others run clockwise, all others counter-clockwise.
fn orient_loops<const D: usize>(mesh: &mut SurfaceMesh<D>) {
    let mut touching: Vec<Vec<usize>> = vec![Vec::new(); mesh.positions.len()];
    for (f, facet) in mesh.facets.iter().enumerate() {
        facet.iter().for_each(|v| touching[*v as usize].push(f));
    }
    if touching.iter().any(|t| t.len() != 2) {
        return; // open or branching: the check reports it, or the direction given is kept
    }
    let mut seen = vec![false; mesh.facets.len()];
    let mut loops: Vec<SurfaceMesh<D>> = Vec::new();
    for start in 0..mesh.facets.len() {
        let mut chain = Vec::new();
        let (mut f, mut at) = (start, mesh.facets[start][0]);
        while !seen[f] {
            seen[f] = true;
            let [a, b] = [mesh.facets[f][0], mesh.facets[f][1]];
            let next = if a == at { b } else { a };
            chain.push(std::array::from_fn(|k| if k == 0 { at } else { next }));
            at = next;
            f = touching[at as usize].iter().copied().find(|g| !seen[*g]).unwrap_or(f);
        }
        if !chain.is_empty() {
            loops.push(SurfaceMesh { positions: mesh.positions.clone(), facets: chain });
        }
    }
    loops.iter_mut().filter(|l| l.volume() < 0.0).for_each(SurfaceMesh::flip);
    let trees: Vec<_> = loops.iter().map(crate::mesh::bvh::FacetBvh::new).collect();
    mesh.facets.clear();
    for (i, l) in loops.iter_mut().enumerate() {
        let c = l.corners(0);
        let middle = (c[0] + c[1]) * 0.5;
        let around = (0..trees.len()).filter(|&j| j != i && trees[j].winding_number(&middle) > 0.5).count();
        if around % 2 == 1 {
            l.flip();
        }
        mesh.facets.append(&mut l.facets);
    }
}

/// The faces (2D: edges) of a PLY file.
fn from_ply<const D: usize>(bytes: &[u8]) -> Result<RawSurface, String> {
    let mesh = PlyMesh::from_bytes(bytes).map_err(|e| match e {
        PlyError::Io { source, .. } => source.to_string(),
        PlyError::Format { what, .. } => what,
    })?;
    let facets = if D == 2 {
        mesh.edges.iter().map(|e| e.to_vec()).collect()
    } else {
        mesh.faces.iter().map(|f| f.to_vec()).collect()
    };
    Ok(RawSurface { points: mesh.positions, facets })
}

/// The triangles of all groups of an OBJ file; polygons are split into fans.
fn obj_faces(bytes: &[u8]) -> Result<RawSurface, String> {
    let options = tobj::LoadOptions {
        triangulate: true,
        ignore_lines: true,
        ignore_points: true,
        ..Default::default()
    };
    let no_materials = |_: &Path| Ok(Default::default());
    let (models, _) =
        tobj::load_obj_buf(&mut io::Cursor::new(bytes), &options, no_materials).map_err(|e| e.to_string())?;
    let RawSurface { mut points, mut facets } = RawSurface::default();
    for model in models {
        let base = points.len() as u32;
        points.extend(model.mesh.positions.chunks_exact(3).map(|p| [p[0], p[1], p[2]].map(f64::from)));
        facets.extend(
            model.mesh.indices.chunks_exact(3).map(|f| f.iter().map(|v| v + base).collect::<Vec<_>>()),
        );
    }
    Ok(RawSurface { points, facets })
}

/// The polylines of an OBJ file as edges.
fn obj_lines(text: &str) -> Result<RawSurface, String> {
    let RawSurface { mut points, facets: mut edges } = RawSurface::default();
    for (number, line) in text.lines().enumerate() {
        let wrong = || format!("line {}: {line:?}", number + 1);
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let x: Vec<f64> =
                    words.take(3).map(str::parse).collect::<Result<_, _>>().map_err(|_| wrong())?;
                let [x, y, rest @ ..] = &x[..] else { return Err(wrong()) };
                points.push([*x, *y, rest.first().copied().unwrap_or(0.0)]);
            }
            Some("l") => {
                let index = |word: &str| {
                    let i: i64 = word.split('/').next()?.parse().ok()?;
                    u32::try_from(if i < 0 { points.len() as i64 + i } else { i - 1 }).ok()
                };
                let v: Vec<u32> = words.map(index).collect::<Option<_>>().ok_or_else(wrong)?;
                edges.extend(v.windows(2).map(<[u32]>::to_vec));
            }
            _ => {}
        }
    }
    Ok(RawSurface { points, facets: edges })
}

/// The triangles of an STL file, ASCII or binary. A binary file is recognised by its length, not by its title.
fn stl_faces(bytes: &[u8]) -> Result<RawSurface, String> {
    let mut bytes = bytes.to_vec();
    let count = bytes.get(80..84).map(|b| u64::from(u32::from_le_bytes([b[0], b[1], b[2], b[3]])));
    let needed = count.map_or(84, |n| 84 + 50 * n);
    if bytes.len() as u64 == needed {
        bytes[..5].fill(b' ');
    } else if !bytes.starts_with(b"solid") {
        return Err(format!("{} bytes, but its head announces {needed}", bytes.len()));
    }
    let mesh = stl_io::read_stl(&mut io::Cursor::new(bytes)).map_err(|e| e.to_string())?;
    let points = mesh.vertices.iter().map(|v| [v[0], v[1], v[2]].map(f64::from)).collect();
    let facets = mesh.faces.iter().map(|f| f.vertices.iter().map(|v| *v as u32).collect()).collect();
    Ok(RawSurface { points, facets })
}

#[cfg(test)]
#[path = "import_tests.rs"]
mod tests;
