//! Surface tension of deformable solids.
//!
//! A wetted surface has less tension than a dry one, by `γ cos θ_Y` (Young). Along the solid the difference balances the free
//! surface's tension at the contact line; where the wetted surface is curved it exerts a pressure. The tangential line force of a
//! drop on a sheet that bends up around it thus acts on the whole wetted surface. With its resultant applied at the lines
//! instead, the ends are held down (at 45 degrees and R0/√(B/γ) = 0.5 they rose by 15 degrees instead of 21).
//!
//! The force on a vertex is `−∂A/∂x` times the tension difference, with `A` the wetted area of its facets.

use super::sampling::phi_at_solid;
use crate::coupling::impulses::ComponentSolid;
use crate::model::Model;
use crate::solid::surface::SurfacePoint;
use crate::solid::{SolidView, Solids};
use meniscus_elastic::StiffnessBlock;
use meniscus_numerics::grid::{CellField, Sampler};
use meniscus_numerics::mesh::SurfaceMesh;
use meniscus_numerics::mesh::surface::{area_gradients, area_hessian_psd};
use meniscus_numerics::{Vector, par};
use std::collections::BTreeMap;

/// Heights above a vertex, in cells, at which the component that wets it is looked up.
const SAMPLE_HEIGHTS_CELLS: [f64; 3] = [0.5, 1.0, 1.5];

/// Vertices of a deformable solid's surface, and the tension force on each, N (2D: N/m).
pub type VertexForces<const D: usize> = Vec<(SurfacePoint<D>, Vector<D>)>;

/// Tension forces by liquid component and deformable solid.
pub type WettedTensions<const D: usize> = BTreeMap<ComponentSolid, VertexForces<D>>;

/// Computes the tension forces of wetted surfaces on deformable solids; `label` is the component of a liquid cell.
pub fn wetted_tension_forces<const D: usize>(
    solids: Solids<'_, D>,
    phi: &Sampler<'_, D>,
    label: &(dyn Fn(usize) -> Option<u32> + Sync),
) -> WettedTensions<D> {
    let mut skins = BTreeMap::new();
    for (number, solid) in solids.iter().enumerate() {
        let (surface, under) = (solid.surface, WettedSolid { model: solids.model, solid, phi, label });
        for (component, forces) in under.forces() {
            let grip = |v: u32| SurfacePoint {
                vertices: [surface.volume_vertices()[v as usize]; D],
                weights: std::array::from_fn(|k| if k == 0 { 1.0 } else { 0.0 }),
                point: surface.mesh.positions[v as usize],
            };
            let pulled = forces.into_iter().map(|(v, force)| (grip(v), force)).collect();
            skins.insert(ComponentSolid { component, solid: number as u32 }, pulled);
        }
    }
    skins
}

/// The positive part of the stiffness of these forces, for the potential of each solid
/// ([`meniscus_elastic::IncrementalPotential::extra_stiffness`]): where wetting raises the tension, beyond 90
/// degrees. Elsewhere the stiffness is negative and left out. The wetted area is that of the forces, after the
/// liquid has moved.
pub fn wetted_tension_stiffness<const D: usize>(
    solids: Solids<'_, D>,
    phi: &CellField<D>,
) -> Vec<Vec<StiffnessBlock<D>>> {
    let model = solids.model;
    let phi = Sampler::cells(&model.grid, &phi.data, model.scalar_boundary());
    let of = |solid: SolidView<'_, D>| {
        let may_repel = solid.young_cosine < 0.0 || !solid.pattern.is_empty();
        match model.numerics.contact_line && may_repel {
            true => WettedSolid { model, solid, phi: &phi, label: &|_| Some(0) }.stiffness(),
            false => Vec::new(),
        }
    };
    solids.iter().map(of).collect()
}

/// A deformable solid and the liquid on it.
struct WettedSolid<'a, const D: usize> {
    model: &'a Model<D>,
    solid: SolidView<'a, D>,
    phi: &'a Sampler<'a, D>,
    label: &'a (dyn Fn(usize) -> Option<u32> + Sync),
}

/// Liquid at a vertex: φ, m, the component that wets it, and the difference of the tensions, N/m.
type VertexSample = (f64, Option<u32>, f64);

impl<const D: usize> WettedSolid<'_, D> {
    /// Forces on the vertices of the surface, by component.
    fn forces(&self) -> BTreeMap<u32, BTreeMap<u32, Vector<D>>> {
        let surface = &self.solid.surface.mesh;
        let seen = self.sample_vertices(surface);
        let mut forces: BTreeMap<u32, BTreeMap<u32, Vector<D>>> = BTreeMap::new();
        for (f, facet) in surface.facets.iter().enumerate() {
            let corners = facet.map(|v| seen[v as usize]);
            let Some(component) = corners.iter().find_map(|c| c.1) else { continue };
            let tension = facet_tension(&corners);
            let of = forces.entry(component).or_default();
            for (v, slope) in facet.iter().zip(area_gradients(&surface.corners(f))) {
                *of.entry(*v).or_insert_with(Vector::zeros) -= slope * tension;
            }
        }
        forces
    }

    /// Stiffness of the facets whose tension is positive.
    fn stiffness(&self) -> Vec<StiffnessBlock<D>> {
        let skin = self.solid.surface;
        let seen = self.sample_vertices(&skin.mesh);
        let mut blocks = Vec::new();
        for (f, facet) in skin.mesh.facets.iter().enumerate() {
            let tension = facet_tension(&facet.map(|v| seen[v as usize]));
            if tension <= 0.0 {
                continue;
            }
            let stiffness = area_hessian_psd(&skin.mesh.corners(f));
            let vertices = facet.map(|v| skin.volume_vertices()[v as usize]);
            let pairs = (0..D).flat_map(|i| (i..D).map(move |j| (i, j)));
            blocks.extend(pairs.map(|(i, j)| {
                let (first, second, block) = (vertices[i], vertices[j], stiffness[i][j] * tension);
                StiffnessBlock { first, second, block }
            }));
        }
        blocks
    }

    /// Samples all vertices of the surface.
    fn sample_vertices(&self, surface: &SurfaceMesh<D>) -> Vec<VertexSample> {
        let mut normals = vec![Vector::zeros(); surface.positions.len()];
        for (f, facet) in surface.facets.iter().enumerate() {
            let area = surface.area_vector(f);
            facet.iter().for_each(|v| normals[*v as usize] += area);
        }
        let positions = &surface.positions;
        par::map(positions.len(), 256, |v| self.sample_vertex(&positions[v], &normals[v]))
    }

    /// Samples a vertex; `normal` need not be a unit vector.
    fn sample_vertex(&self, x: &Vector<D>, normal: &Vector<D>) -> VertexSample {
        let dx = self.model.grid.dx;
        let Some(normal) = normal.try_normalize(0.0) else { return (dx, None, 0.0) };
        let x = &(x + normal * self.solid.padding);
        let phi = phi_at_solid(self.phi, x, &normal, dx);
        let at = |h: &f64| (self.label)(self.cell(&(x + normal * (h * dx)))?);
        let component = if phi < 0.0 { SAMPLE_HEIGHTS_CELLS.iter().find_map(at) } else { None };
        let cosine = self.solid.young_cosine_near(x, dx).clamp(-1.0, 1.0);
        (phi, component, -self.model.surface_tension * cosine)
    }

    /// The cell that contains a point.
    fn cell(&self, x: &Vector<D>) -> Option<usize> {
        let grid = &self.model.grid;
        let from = (x - grid.lower_corner([0; D])) / grid.dx;
        let inside = (0..D).all(|a| from[a] >= 0.0 && from[a] < grid.cells[a] as f64);
        inside.then(|| grid.lattice().index(std::array::from_fn(|a| from[a] as usize)))
    }
}

/// The mean tension that wetting adds to a facet with these corners, N/m.
fn facet_tension<const D: usize>(corners: &[VertexSample; D]) -> f64 {
    corners.iter().map(|c| c.2).sum::<f64>() / D as f64 * negative_fraction(corners.map(|c| c.0))
}

/// Fraction of a facet where a linear function with these values at its corners is negative.
fn negative_fraction<const D: usize>(values: [f64; D]) -> f64 {
    let negative = values.iter().filter(|v| **v < 0.0).count();
    if negative == 0 || negative == D {
        return if negative == D { 1.0 } else { 0.0 };
    }
    // The corner that is alone on its side, and the fraction that it cuts off.
    let alone = values.iter().position(|v| (*v < 0.0) == (negative == 1)).unwrap_or(0);
    let others = (0..D).filter(|k| *k != alone);
    let cut: f64 = others.map(|k| values[alone] / (values[alone] - values[k])).product();
    if negative == 1 { cut } else { 1.0 - cut }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::resolution::BAND_WIDTH_CELLS;
    use crate::solid::{Kinematics, Solid, SolidKind, SolidSurfaces};
    use meniscus_elastic::{ConstitutiveLaw, Elastic, ElasticSpecification, ElementOrder};
    use meniscus_numerics::Matrix;
    use meniscus_numerics::grid::Grid;
    use meniscus_numerics::mesh::{Simplex, VolumeMesh};
    use meniscus_numerics::shape::Shape;
    use std::sync::Arc;

    const GAMMA: f64 = 0.7;

    /// A triangle that is wetted all around at a contact angle (degrees).
    fn drowned(angle: f64) -> Model<2> {
        let (center, half_size) = (Vector::repeat(0.5), Vector::repeat(0.2));
        let shape = Shape::Box { center, half_size, rotation: Matrix::identity() };
        let positions = [[0.3, 0.35], [0.7, 0.4], [0.45, 0.65]].map(Vector::from).to_vec();
        let mesh = VolumeMesh { positions, simplices: vec![Simplex { root: 0, others: [1, 2] }] };
        let law = ConstitutiveLaw::neo_hookean(1.0, 0.3, ElementOrder::Linear);
        let anchors = Vec::new();
        let description = ElasticSpecification { mesh, density: 1.0, law, damping_ratio: 0.0, anchors };
        let elastic = Elastic::new(description).unwrap_or_else(|e| panic!("{e}"));
        let mut solid = Solid::new(shape, SolidKind::Deformable(Arc::new(elastic)), 1.0);
        solid.young_cosine = angle.to_radians().cos();
        Model { surface_tension: GAMMA, ..Model::of_test(Grid::new([32; 2], 1.0 / 32.0), vec![solid]) }
    }

    /// φ of a domain full of liquid.
    fn full(model: &Model<2>) -> CellField<2> {
        CellField::new(model.grid, -BAND_WIDTH_CELLS * model.grid.dx)
    }

    /// The forces on the vertices after coordinate `moved` has changed by `way`, m.
    fn pulls(model: &Model<2>, moved: usize, way: f64) -> [Vector<2>; 3] {
        let (mut states, phi) = (model.initial_solids(), full(model));
        if let Kinematics::Deformable(body) = &mut states[0].kinematics {
            body.vertices.positions[moved / 2][moved % 2] += way;
        }
        let surfaces = &SolidSurfaces::new(&model.solids, &states);
        let phi = Sampler::cells(&model.grid, &phi.data, model.scalar_boundary());
        let solids = Solids { model, states: &states, surfaces };
        let mut forces = [Vector::zeros(); 3];
        for (grip, force) in wetted_tension_forces(solids, &phi, &|_| Some(0)).values().flatten() {
            forces[grip.vertices[0] as usize] += force;
        }
        forces
    }

    fn stiffness(model: &Model<2>) -> Vec<StiffnessBlock<2>> {
        let states = &model.initial_solids();
        let solids = Solids { model, states, surfaces: &SolidSurfaces::new(&model.solids, states) };
        wetted_tension_stiffness(solids, &full(model)).swap_remove(0)
    }

    #[test]
    fn the_stiffness_is_the_slope_of_the_forces() {
        let model = drowned(120.0);
        let mut blocks = [[Matrix::<2>::zeros(); 3]; 3];
        for StiffnessBlock { first, second, block } in &stiffness(&model) {
            let [i, j] = [*first as usize, *second as usize];
            blocks[i][j] += block;
            if i != j {
                blocks[j][i] += block.transpose();
            }
        }
        let way = 1e-6;
        for moved in 0..6 {
            let [more, less] = [way, -way].map(|way| pulls(&model, moved, way));
            for (i, row) in blocks.iter().enumerate() {
                let slope = (less[i] - more[i]) / (2.0 * way);
                let told = row[moved / 2].column(moved % 2);
                assert!((slope - told).norm() < 1e-7 * GAMMA / 0.4, "{i}, {moved}: {slope} for {told}");
            }
        }
        // Below 90 degrees the stiffness would be negative.
        assert!(stiffness(&drowned(60.0)).is_empty());
    }

    #[test]
    fn shares_of_facets() {
        assert_eq!(
            [negative_fraction([-1.0, 3.0]), negative_fraction([1.0, -1.0]), negative_fraction([1.0, 2.0])],
            [0.25, 0.5, 0.0]
        );
        assert_eq!(
            [negative_fraction([-1.0, 1.0, 3.0]), negative_fraction([1.0, -1.0, -1.0])],
            [0.125, 0.75]
        );
    }
}
