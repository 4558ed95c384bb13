//! Icospheres: spheres of nearly equal triangles, on which geodesic distances and lengths are known exactly.

use super::SurfaceMesh;
use crate::Vector;

/// Unit icosphere: an icosahedron subdivided `levels` times, with `10·4^levels + 2` vertices, all on the sphere.
pub fn icosphere(levels: usize) -> SurfaceMesh<3> {
    let golden = 0.5 * (1.0 + 5.0f64.sqrt());
    let mut positions = Vec::new();
    for axis in 0..3 {
        for signs in 0..4 {
            let sign = |bit: usize| if signs >> bit & 1 == 0 { 1.0 } else { -1.0 };
            let mut x = Vector::<3>::zeros();
            (x[axis], x[(axis + 1) % 3]) = (sign(0), sign(1) * golden);
            positions.push(x.normalize());
        }
    }
    let mut mesh = SurfaceMesh { facets: icosahedron_triangles(&positions), positions };
    for _ in 0..levels {
        mesh = subdivide(&mesh);
    }
    mesh
}

/// Outward triangles of an icosahedron: all triples of mutual neighbours.
fn icosahedron_triangles(x: &[Vector<3>]) -> Vec<[u32; 3]> {
    // Neighbours subtend 63 degrees, other pairs at least 117.
    let near = |i: usize, j: usize| x[i].dot(&x[j]) > 0.4;
    let mut facets = Vec::new();
    for i in 0..x.len() {
        for j in i + 1..x.len() {
            for k in j + 1..x.len() {
                if near(i, j) && near(j, k) && near(k, i) {
                    let outward = x[i].cross(&x[j]).dot(&x[k]) > 0.0;
                    let (j, k) = if outward { (j, k) } else { (k, j) };
                    facets.push([i, j, k].map(|v| v as u32));
                }
            }
        }
    }
    facets
}

/// Splits every triangle into four and puts the new vertices on the sphere.
fn subdivide(mesh: &SurfaceMesh<3>) -> SurfaceMesh<3> {
    let sorted = |a: u32, b: u32| [a.min(b), a.max(b)];
    let mut edges: Vec<[u32; 2]> = mesh
        .facets
        .iter()
        .flat_map(|f| [sorted(f[0], f[1]), sorted(f[1], f[2]), sorted(f[2], f[0])])
        .collect();
    edges.sort_unstable();
    edges.dedup();
    let first = mesh.positions.len();
    let mut positions = mesh.positions.clone();
    let middle = |e: &[u32; 2]| (mesh.positions[e[0] as usize] + mesh.positions[e[1] as usize]).normalize();
    positions.extend(edges.iter().map(middle));
    let middle = |a: u32, b: u32| (first + edges.partition_point(|e| *e < sorted(a, b))) as u32;
    let mut facets = Vec::with_capacity(4 * mesh.facets.len());
    for &[a, b, c] in &mesh.facets {
        let (d, e, f) = (middle(a, b), middle(b, c), middle(c, a));
        facets.extend([[a, d, f], [b, e, d], [c, f, e], [d, e, f]]);
    }
    SurfaceMesh { positions, facets }
}
