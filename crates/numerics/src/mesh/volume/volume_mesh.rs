//! Mesh of a volume by simplices: triangles in 2D, tetrahedra in 3D.

use crate::mesh::SurfaceMesh;
use crate::{Matrix, Vector};

/// Triangle (2D) or tetrahedron (3D), given by vertex numbers. Its volume is positive if `det [x₁−x₀ … x_D−x₀]` is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Simplex<const D: usize> {
    /// The first vertex, `x₀`.
    pub root: u32,
    /// The others, `x₁ … x_D`.
    pub others: [u32; D],
}

impl<const D: usize> Simplex<D> {
    /// All its vertices.
    pub fn vertices(&self) -> impl Iterator<Item = u32> + '_ {
        std::iter::once(self.root).chain(self.others)
    }

    /// Its edges from the first vertex, `[x₁−x₀ … x_D−x₀]`, m.
    pub fn edges(&self, positions: &[Vector<D>]) -> Matrix<D> {
        let root = positions[self.root as usize];
        Matrix::from_fn(|r, c| positions[self.others[c] as usize][r] - root[r])
    }

    /// Its volume, m³ (2D: area, m²); negative if it is inverted.
    pub fn volume(&self, positions: &[Vector<D>]) -> f64 {
        let e = self.edges(positions);
        let facet: [Vector<D>; D] = std::array::from_fn(|k| e.column(k).into_owned());
        if D == 2 {
            0.5 * (e[(0, 0)] * e[(1, 1)] - e[(0, 1)] * e[(1, 0)])
        } else {
            let across = Vector::<3>::from_fn(|a, _| facet[0][a]);
            let [b, c] = [1, D - 1].map(|k| Vector::<3>::from_fn(|a, _| facet[k][a]));
            across.dot(&b.cross(&c)) / 6.0
        }
    }

    /// The same vertices in an order with positive volume, if the volume is not zero.
    pub fn oriented(mut self, positions: &[Vector<D>]) -> Self {
        if self.volume(positions) < 0.0 {
            self.others.swap(0, 1);
        }
        self
    }

    /// The facet opposite to vertex `k` (0 is the root), outward if the volume is positive.
    pub fn facet(&self, k: usize) -> [u32; D] {
        let mut facet = self.others;
        if k > 0 {
            // The root replaces the omitted vertex, which reverses the orientation.
            facet[k - 1] = self.root;
            facet.swap(0, 1);
        }
        facet
    }
}

/// Volume mesh of simplices.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VolumeMesh<const D: usize> {
    /// Vertices, m.
    pub positions: Vec<Vector<D>>,
    /// Triangles (2D) or tetrahedra (3D), of positive volume.
    pub simplices: Vec<Simplex<D>>,
}

impl<const D: usize> VolumeMesh<D> {
    /// Volume of all simplices, m³ (2D: m²).
    pub fn volume(&self) -> f64 {
        crate::par::sum(self.simplices.len(), |i| self.simplices[i].volume(&self.positions))
    }

    /// The mesh rotated about the origin, then translated by `translate` (m). A reflection as `rotation` inverts the simplices.
    pub fn transformed(mut self, rotation: &Matrix<D>, translate: &Vector<D>) -> Self {
        self.positions.iter_mut().for_each(|x| *x = rotation * *x + translate);
        self
    }

    /// The mesh without unused vertices; the others keep their order.
    pub fn compacted(&self) -> Self {
        let mut number = vec![u32::MAX; self.positions.len()];
        self.simplices.iter().flat_map(|s| s.vertices()).for_each(|v| number[v as usize] = 0);
        let mut positions = Vec::new();
        for (n, x) in number.iter_mut().zip(&self.positions).filter(|(n, _)| **n == 0) {
            *n = positions.len() as u32;
            positions.push(*x);
        }
        let renumbered = |s: &Simplex<D>| Simplex {
            root: number[s.root as usize],
            others: s.others.map(|v| number[v as usize]),
        };
        Self { positions, simplices: self.simplices.iter().map(renumbered).collect() }
    }

    /// Outward boundary facets with the mesh's vertex numbers: those of only one simplex.
    pub fn boundary(&self) -> Vec<[u32; D]> {
        let mut facets: Vec<([u32; D], [u32; D])> = Vec::with_capacity(self.simplices.len() * (D + 1));
        for simplex in &self.simplices {
            for k in 0..=D {
                let facet = simplex.facet(k);
                let mut key = facet;
                key.sort_unstable();
                facets.push((key, facet));
            }
        }
        facets.sort_unstable();
        facets.chunk_by(|a, b| a.0 == b.0).filter(|same| same.len() == 1).map(|same| same[0].1).collect()
    }

    /// The boundary as a surface with its own vertex numbers, and the mesh's vertex for each of its vertices.
    pub fn surface(&self) -> (SurfaceMesh<D>, Vec<u32>) {
        let facets = self.boundary();
        let mut own: Vec<u32> = facets.iter().flatten().copied().collect();
        own.sort_unstable();
        own.dedup();
        let number = |v: u32| own.partition_point(|o| *o < v) as u32;
        let facets = facets.iter().map(|f| f.map(number)).collect();
        let positions = own.iter().map(|v| self.positions[*v as usize]).collect();
        (SurfaceMesh { positions, facets }, own)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::surface::area_vector;

    /// The unit cube cut into simplices along its diagonal, one for each order of the axes.
    fn cube<const D: usize>() -> VolumeMesh<D> {
        let corner = |k: usize| Vector::<D>::from_fn(|a, _| (k >> a & 1) as f64);
        let positions: Vec<Vector<D>> = (0..1 << D).map(corner).collect();
        let orders: &[[usize; 3]] = if D == 2 {
            &[[0, 1, 2], [1, 0, 2]]
        } else {
            &[[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]]
        };
        let simplex = |order: &[usize; 3]| {
            let mut at = 0;
            let others = std::array::from_fn(|k| {
                at |= 1 << order[k];
                at as u32
            });
            Simplex { root: 0, others }.oriented(&positions)
        };
        let simplices = orders.iter().map(simplex).collect();
        VolumeMesh { positions, simplices }
    }

    fn surface_of_a_cube<const D: usize>() {
        let mesh = cube::<D>();
        let (surface, own) = mesh.surface();
        assert!((mesh.volume() - 1.0).abs() < 1e-15);
        assert!(surface.is_watertight() && own.len() == 1 << D);
        assert!((surface.volume() - 1.0).abs() < 1e-15, "{D}D: {}", surface.volume());
        let sum: Vector<D> = (0..surface.facets.len()).map(|f| area_vector(&surface.corners(f))).sum();
        assert!(sum.norm() < 1e-15);
    }

    #[test]
    fn the_surface_of_a_volume_is_closed_and_outward() {
        surface_of_a_cube::<2>();
        surface_of_a_cube::<3>();
    }
}
