//! Extrusion of triangulated outlines: prisms over the triangles, cut into tetrahedra.
//!
//! A prism is cut into three along diagonals that rise from the vertex of lower colour to that of higher colour. So
//! neighbours agree and the diagonals of a prism form no cycle (J. Dompierre et al., "How to subdivide pyramids, prisms
//! and hexahedra into tetrahedra", 8th Int. Meshing Roundtable, 1999). Neighbouring vertices differ in colour, so no direction
//! is preferred. Adjacent layers are mirror images and their number is even, so the mesh has the symmetries of the
//! triangulation and is symmetric about its mid-plane.

use super::block::cell_count;
use super::outline::{Outline, OutlineError};
use super::planar::PlanarTriangulation;
use super::quadratic::ElementOrder;
use super::{Simplex, VolumeMesh};
use crate::shape::MeshShape;
use crate::{Matrix, Vector};

impl PlanarTriangulation {
    /// Prisms over the triangles in layers about the plane, cut into tetrahedra; `thickness` (m) is the total. An even
    /// number of layers makes both sides alike.
    pub fn extruded(&self, layers: usize, thickness: f64) -> VolumeMesh<3> {
        let flat = &self.mesh.positions;
        let mut mesh = VolumeMesh::<3>::default();
        for layer in 0..=layers {
            let z = (layer as f64 / layers.max(1) as f64 - 0.5) * thickness;
            mesh.positions.extend(flat.iter().map(|x| Vector::from([x[0], x[1], z])));
        }
        let at = |layer: usize, v: u32| (layer * flat.len()) as u32 + v;
        for layer in 0..layers {
            let from = layer + layer % 2;
            let to = layer + 1 - layer % 2;
            for triangle in &self.mesh.simplices {
                let mut v = [triangle.root, triangle.others[0], triangle.others[1]];
                v.sort_unstable_by_key(|v| self.color[*v as usize]);
                let ([a, b, c], [d, e, f]) = (v.map(|v| at(from, v)), v.map(|v| at(to, v)));
                for [root, x, y, z] in [[a, b, c, f], [a, b, e, f], [a, d, e, f]] {
                    mesh.simplices.push(Simplex { root, others: [x, y, z] }.oriented(&mesh.positions));
                }
            }
        }
        mesh
    }
}

impl<const D: usize> VolumeMesh<D> {
    /// An outline with vertices about `edge` (m) apart, extruded by `thickness` (m) along the last axis (2D: its interior,
    /// `thickness` is ignored). The outline's origin goes to `center` (m), in the middle of the thickness. The columns of
    /// `rotation` are its axes, as in [`Shape::Extrusion`](crate::shape::Shape::Extrusion). There are at least two layers. A
    /// square becomes a [`block`](super::block::block).
    ///
    /// # Errors
    /// A length is not positive and finite, there would be too many vertices, or edges are too long for the outline.
    pub fn of_outline(
        outline: &Outline,
        center: &Vector<D>,
        thickness: f64,
        rotation: &Matrix<D>,
        edge: f64,
        order: ElementOrder,
    ) -> Result<Self, OutlineError> {
        let length = |what, value: f64| match value > 0.0 && value.is_finite() {
            true => Ok(()),
            false => Err(OutlineError::Size { what, value }),
        };
        length("the length of edges", edge)?;
        if D == 3 {
            length("the thickness", thickness)?;
        }
        if let Some(side) = outline.square_side {
            length("the side of the square", side)?;
            let half = Vector::from_fn(|a, _| 0.5 * if a < 2 { side } else { thickness });
            return Ok(Self::of_box(center, &half, rotation, edge, order)?);
        }
        let parts = if order == ElementOrder::Quadratic { 2 } else { 1 };
        let planar = outline.triangulate(edge * parts as f64)?;
        let wide = |positions: &[Vector<3>]| {
            positions.iter().map(|x| Vector::from_fn(|a, _| x[a])).collect::<Vec<Vector<D>>>()
        };
        let mesh = if D == 2 {
            let flat: Vec<Vector<3>> =
                planar.mesh.positions.iter().map(|x| Vector::from([x[0], x[1], 0.0])).collect();
            let simplex =
                |s: &Simplex<2>| Simplex { root: s.root, others: std::array::from_fn(|k| s.others[k]) };
            Self { positions: wide(&flat), simplices: planar.mesh.simplices.iter().map(simplex).collect() }
        } else {
            let solid = planar.extruded(cell_count(thickness, edge, 2) / parts, thickness);
            let simplex =
                |s: &Simplex<3>| Simplex { root: s.root, others: std::array::from_fn(|k| s.others[k]) };
            Self {
                positions: wide(&solid.positions),
                simplices: solid.simplices.iter().map(simplex).collect(),
            }
        };
        let mesh = if order == ElementOrder::Quadratic {
            mesh.subdivided_curved(&outline_displacements(outline, &planar, &mesh))
        } else {
            mesh
        };
        Ok(mesh.transformed(rotation, center))
    }
}

/// Displacements (m) of edge nodes of an extruded triangulation onto the outline.
fn outline_displacements<const D: usize>(
    outline: &Outline,
    planar: &PlanarTriangulation,
    mesh: &VolumeMesh<D>,
) -> Vec<([u32; 2], Vector<D>)> {
    let (flat, shape) = (&planar.mesh, MeshShape::new(outline.surface()));
    let (bent, edges) = (flat.subdivided_onto(&|x| shape.signed_distance(x)), flat.edges());
    let count = flat.positions.len() as u32;
    let shift = |edge: [u32; 2]| {
        let [a, b] = edge.map(|v| v % count);
        let number = edges.binary_search(&[a.min(b), a.max(b)]).ok()?;
        let middle = (flat.positions[a as usize] + flat.positions[b as usize]) * 0.5;
        let displacement = bent.positions[flat.positions.len() + number] - middle;
        (displacement != Vector::<2>::zeros())
            .then(|| (edge, Vector::from_fn(|r, _| if r < 2 { displacement[r] } else { 0.0 })))
    };
    mesh.edges().into_iter().filter_map(shift).collect()
}
