//! The geometry of a state: the level set closed along solids, types of cells, surfaces, and `W_s`.

use super::scheme::PaperScheme;
use crate::paper::coupling::solid_map::{SolidMap, joined};
use crate::paper::fluid::cells::{CellTypes, FaceType};
use crate::paper::fluid::fractions::{cell_fraction, closed_along_solids};
use crate::solid::{SolidState, SolidSurfaces, Solids};
use meniscus_numerics::Vector;
use meniscus_numerics::grid::{CellField, Sampler};
use meniscus_numerics::mesh::SurfaceMesh;
use rayon::prelude::*;

/// The geometry of solids and liquid.
#[derive(Clone, Debug)]
pub struct Geometry<const D: usize> {
    /// Surfaces of the deformable solids.
    pub surfaces: SolidSurfaces<D>,
    /// Surfaces of all solids, m.
    pub meshes: Vec<SurfaceMesh<D>>,
    /// The level set, m, closed along the solids.
    pub phi: CellField<D>,
    /// Types of the cells.
    pub types: CellTypes<D>,
    /// `W_s` of all faces beside solids.
    pub map: SolidMap<D>,
}

impl<const D: usize> Geometry<D> {
    /// The geometry of solids in these states and of a level set, m.
    pub fn new(scheme: &PaperScheme<D>, states: &[SolidState<D>], phi: &CellField<D>) -> Self {
        let model = &scheme.model;
        let surfaces = SolidSurfaces::new(&model.solids, states);
        let solids = Solids { model, states, surfaces: &surfaces };
        let distance = |x: &Vector<D>| solids.liquid_distance(x);
        let data = closed_along_solids(&model.grid, &phi.data, &distance);
        let phi = CellField { grid: model.grid, data };
        let types = CellTypes::new(model.grid, model.walls, &phi.data, &distance);
        let mesh = |(number, at_start): (usize, &SurfaceMesh<D>)| {
            let solid = solids.get(number);
            let Some(rigid) = solid.state.rigid() else { return solid.surface.mesh.clone() };
            let positions = at_start.positions.iter().map(|x| solid.to_current(rigid, x)).collect();
            SurfaceMesh { positions, facets: at_start.facets.clone() }
        };
        let meshes: Vec<SurfaceMesh<D>> = scheme.rigid_surfaces.iter().enumerate().map(mesh).collect();
        let mut faces = types.faces_of(FaceType::LiquidSolid);
        faces.extend(types.faces_of(FaceType::SolidAir));
        faces.sort();
        let map = SolidMap::new(&types, faces, &joined(&meshes));
        Self { surfaces, meshes, phi, types, map }
    }

    /// The solids in these states, which must be those of the geometry.
    pub fn solids<'a>(&'a self, scheme: &'a PaperScheme<D>, states: &'a [SolidState<D>]) -> Solids<'a, D> {
        Solids { model: &scheme.model, states, surfaces: &self.surfaces }
    }

    /// The level set for samples.
    pub fn sampler(&self, scheme: &PaperScheme<D>) -> Sampler<'_, D> {
        Sampler::cells(&scheme.model.grid, &self.phi.data, scheme.model.scalar_boundary())
    }
}

impl<const D: usize> PaperScheme<D> {
    /// Volume of the liquid of a level set, m³ (2D: m²).
    pub fn volume(&self, phi: &CellField<D>) -> f64 {
        let grid = &self.model.grid;
        let sampler = Sampler::cells(grid, &phi.data, self.model.scalar_boundary());
        let lattice = grid.lattice();
        let cells = (0..lattice.len()).into_par_iter().with_min_len(256);
        let fractions: Vec<f64> =
            cells.map(|cell| cell_fraction(&sampler, grid, lattice.coordinates(cell))).collect();
        fractions.iter().sum::<f64>() * grid.cell_volume()
    }
}
