//! Boundaries that liquid can touch: solids as meshes, domain walls as planes.

use meniscus_numerics::Vector;
use meniscus_numerics::mesh::ply::PlyMesh;
use meniscus_numerics::mesh::{FacetBvh, SurfaceMesh};

use crate::folder::{Frame, RunFolder};

/// Cosine between facet normals above which they are smoothed; sharper edges stay sharp.
const CREASE_COSINE: f64 = 0.87;

/// Closest point of a body's surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct ClosestPoint<const D: usize> {
    /// Position, m.
    pub at: Vector<D>,
    /// Unit normal out of the body.
    pub normal: Vector<D>,
    /// Distance from the query point, m.
    pub distance: f64,
}

/// A solid or a wall.
#[derive(Debug)]
pub(super) struct SolidBoundary<const D: usize> {
    /// Name of the solid, or side of the wall.
    pub name: String,
    /// Whether it is a wall of the domain.
    pub is_wall: bool,
    surface: Surface<D>,
}

#[derive(Debug)]
enum Surface<const D: usize> {
    Mesh { mesh: SurfaceMesh<D>, tree: FacetBvh<D>, normals: Vec<[Vector<D>; D]> },
    Wall { axis: usize, at: f64, inward: f64 },
}

impl<const D: usize> SolidBoundary<D> {
    /// The solids of a frame, and the walls if the domain is known.
    pub(super) fn all(folder: &RunFolder, frame: &Frame) -> Vec<Self> {
        let mut bodies: Vec<Self> =
            frame.solids.iter().map(|(name, mesh)| Self::solid(name, &surface(mesh))).collect();
        let sides = [["left", "right"], ["front", "back"], ["bottom", "top"]];
        for axis in 0..D {
            let Some(domain) = folder.domain else { break };
            let names = sides[if axis + 1 == D { 2 } else { axis }];
            for (name, at, inward) in [(names[0], 0.0, 1.0), (names[1], domain[axis], -1.0)] {
                bodies.push(Self {
                    name: name.into(),
                    is_wall: true,
                    surface: Surface::Wall { axis, at, inward },
                });
            }
        }
        bodies
    }

    /// The boundary of a solid with this mesh.
    pub(super) fn solid(name: &str, mesh: &SurfaceMesh<D>) -> Self {
        let normals = corner_normals(mesh);
        let surface = Surface::Mesh { mesh: mesh.clone(), tree: FacetBvh::new(mesh), normals };
        Self { name: name.into(), is_wall: false, surface }
    }

    /// The closest point of the surface; `None` if there is no surface.
    pub(super) fn closest(&self, x: &Vector<D>) -> Option<ClosestPoint<D>> {
        match &self.surface {
            Surface::Wall { axis, at, inward } => {
                let mut foot =
                    ClosestPoint { at: *x, normal: Vector::zeros(), distance: (x[*axis] - at).abs() };
                foot.at[*axis] = *at;
                foot.normal[*axis] = *inward;
                Some(foot)
            }
            Surface::Mesh { mesh, tree, normals } => {
                let near = tree.closest_point(x, f64::INFINITY)?;
                let flat = mesh.area_vector(near.facet as usize).try_normalize(0.0)?;
                let corners = normals[near.facet as usize].iter().zip(near.weights);
                let smooth = corners.fold(Vector::<D>::zeros(), |sum, (n, w)| sum + n * w);
                let normal = smooth.try_normalize(0.0).unwrap_or(flat);
                Some(ClosestPoint { at: near.point, normal, distance: near.distance_squared.sqrt() })
            }
        }
    }

    /// Whether a point is closer than `reach` (m); cheaper than [`Self::closest`].
    pub(super) fn is_near(&self, x: &Vector<D>, reach: f64) -> bool {
        match &self.surface {
            Surface::Wall { axis, at, .. } => (x[*axis] - at).abs() < reach,
            Surface::Mesh { tree, .. } => tree.closest_point(x, reach).is_some(),
        }
    }

    /// Lower and upper corner of the bounding box; `None` for a wall.
    pub(super) fn bounds(&self) -> Option<(Vector<D>, Vector<D>)> {
        match &self.surface {
            Surface::Mesh { mesh, .. } if !mesh.positions.is_empty() => Some(mesh.bounds()),
            _ => None,
        }
    }
}

/// Normal at each facet corner: area-weighted mean over the facets around the vertex within the crease angle.
fn corner_normals<const D: usize>(mesh: &SurfaceMesh<D>) -> Vec<[Vector<D>; D]> {
    let areas: Vec<Vector<D>> = (0..mesh.facets.len()).map(|f| mesh.area_vector(f)).collect();
    let mut around = vec![Vec::new(); mesh.positions.len()];
    for (f, facet) in mesh.facets.iter().enumerate() {
        facet.iter().for_each(|&v| around[v as usize].push(f));
    }
    let corner = |f: usize, v: u32| {
        let smooth =
            |g: &&usize| areas[**g].dot(&areas[f]) > CREASE_COSINE * areas[**g].norm() * areas[f].norm();
        let sum = around[v as usize].iter().filter(smooth).map(|&g| areas[g]).sum::<Vector<D>>();
        sum.try_normalize(0.0).unwrap_or_else(Vector::zeros)
    };
    mesh.facets.iter().enumerate().map(|(f, facet)| facet.map(|v| corner(f, v))).collect()
}

/// The mesh of a file in `D` dimensions: its triangles in 3D, its edges in 2D.
pub(super) fn surface<const D: usize>(mesh: &PlyMesh) -> SurfaceMesh<D> {
    let positions = mesh.positions.iter().map(|p| Vector::from_fn(|a, _| p[a])).collect();
    let facets = if D == 2 {
        mesh.edges.iter().map(|e| std::array::from_fn(|k| e[k])).collect()
    } else {
        mesh.faces.iter().map(|f| std::array::from_fn(|k| f[k])).collect()
    };
    SurfaceMesh { positions, facets }
}
