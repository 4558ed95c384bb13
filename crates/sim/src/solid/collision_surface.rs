//! The surface of a deformable solid that takes part in contacts.
//!
//! In 3D a uniform traction on a quadratic facet has no load on its corners: `∫ N_i dA` is 0 there and a third of the area at each node on
//! an edge (Zienkiewicz & Taylor, "The Finite Element Method", vol. 1). With contacts at the nodes alone the corners of a pressed surface
//! therefore do not touch, while its centres, at `x_c = 4/9 Σ x_ij − 1/9 Σ x_i`, penetrate (experiment E37). The centres are therefore
//! points of the collision surface. Limit: between these points and the nodes the interpolated surface is not tested.

use meniscus_numerics::Vector;
use meniscus_numerics::mesh::VolumeMesh;
use meniscus_numerics::mesh::volume::QuadraticFacet;

/// The collision surface. Its points are the vertices of the solid's surface, then the centres of its quadratic facets.
#[derive(Clone, Debug, Default)]
pub struct CollisionSurface<const D: usize> {
    /// Points of the facets.
    pub facets: Vec<[u32; D]>,
    /// Quadratic facets with a point in their centre; their nodes are vertices of the surface.
    pub centers: Vec<QuadraticFacet>,
}

impl<const D: usize> CollisionSurface<D> {
    /// The collision surface of linear elements: the surface itself.
    pub fn linear(facets: Vec<[u32; D]>) -> Self {
        Self { facets, centers: Vec::new() }
    }

    /// The collision surface of quadratic elements in a mesh with this surface and its vertices' numbers in the mesh. The part of a
    /// facet between the nodes on its edges is divided into three around the centre.
    pub fn quadratic(mesh: &VolumeMesh<D>, mut facets: Vec<[u32; D]>, volume_vertices: &[u32]) -> Self {
        let known = mesh.quadratic_facets();
        let number = |v: u32| volume_vertices.partition_point(|own| *own < v) as u32;
        let mut centers = Vec::new();
        for f in 0..facets.len() {
            let mut edges: Vec<u32> = facets[f].iter().map(|p| volume_vertices[*p as usize]).collect();
            edges.sort_unstable();
            let Some(QuadraticFacet { corners, edges }) =
                <[u32; 3]>::try_from(edges).ok().and_then(|edges| known.get(&edges))
            else {
                continue;
            };
            let center = (volume_vertices.len() + centers.len()) as u32;
            centers.push(QuadraticFacet { corners: corners.map(number), edges: edges.map(number) });
            let whole = facets[f];
            let parts: [[u32; D]; D] =
                std::array::from_fn(|k| std::array::from_fn(|p| if p == k { center } else { whole[p] }));
            facets[f] = parts[0];
            facets.extend_from_slice(&parts[1..]);
        }
        Self { facets, centers }
    }

    /// Positions of all points for those of the surface's vertices, m.
    pub fn positions(&self, vertices: &[Vector<D>]) -> Vec<Vector<D>> {
        let center = |facet: &QuadraticFacet| {
            facet.center_weights().map(|(v, weight)| vertices[v as usize] * weight).sum::<Vector<D>>()
        };
        vertices.iter().copied().chain(self.centers.iter().map(center)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use meniscus_numerics::Matrix;
    use meniscus_numerics::mesh::surface::area_vector;
    use meniscus_numerics::mesh::volume::ElementOrder;

    /// The collision surface of a block is closed and has a point in the centre of each facet of its tetrahedra.
    #[test]
    fn centers_are_points() {
        let half = Vector::repeat(0.5);
        let mesh =
            VolumeMesh::of_box(&Vector::zeros(), &half, &Matrix::identity(), 0.25, ElementOrder::Quadratic)
                .unwrap();
        let (surface, vertices) = mesh.surface();
        let count = surface.facets.len();
        let collision = CollisionSurface::quadratic(&mesh, surface.facets.clone(), &vertices);
        assert_eq!(collision.centers.len() * 4, count);
        assert_eq!(collision.facets.len() * 4, count * 6);
        let at = collision.positions(&surface.positions);
        let areas = collision.facets.iter().map(|f| area_vector(&f.map(|p| at[p as usize])));
        let (sum, all) = areas.fold((Vector::<3>::zeros(), 0.0), |(sum, all), a| (sum + a, all + a.norm()));
        assert!(sum.norm() < 1e-12 && (all - 6.0).abs() < 1e-12, "{sum} {all}");
    }
}
