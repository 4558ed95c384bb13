//! The geometry of a state: the liquid's surface, the level set closed along solids, types of cells, surfaces of solids, and `W_s`.

use super::scheme::PaperScheme;
use super::state::PaperState;
use super::transport::{SolidMotion, extend_velocity, redistanced};
use crate::model::resolution::BAND_WIDTH_CELLS;
use crate::paper::coupling::solid_map::{SolidMap, joined};
use crate::paper::fluid::cells::{CellTypes, FaceType};
use crate::paper::fluid::continuation::continue_into_solids;
use crate::paper::fluid::fractions::{cell_fraction, closed_along_solids};
use crate::paper::fluid::surface_shape::{SolidSide, SurfaceShape};
use crate::solid::{SolidState, SolidSurfaces, Solids};
use meniscus_numerics::grid::{CellField, FaceField, Sampler};
use meniscus_numerics::mesh::SurfaceMesh;
use meniscus_numerics::{Vector, par};

/// Step of the differences for normals of solids, in cells.
const NORMAL_STEP_CELLS: f64 = 0.01;

/// The geometry of solids and liquid.
#[derive(Clone, Debug)]
pub struct Geometry<const D: usize> {
    /// Surfaces of the deformable solids.
    pub surfaces: SolidSurfaces<D>,
    /// Surfaces of all solids, m.
    pub meshes: Vec<SurfaceMesh<D>>,
    /// The level set of the state, m: the liquid's surface, continued into solids or closed along them
    /// ([`Errata::open_surface`](crate::paper::Errata::open_surface)).
    pub surface: CellField<D>,
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
        let surface = if scheme.errata.open_surface { phi.data.clone() } else { data.clone() };
        let [surface, phi] = [surface, data].map(|data| CellField { grid: model.grid, data });
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
        Self { surfaces, meshes, surface, phi, types, map }
    }

    /// The solids in these states, which must be those of the geometry.
    pub fn solids<'a>(&'a self, scheme: &'a PaperScheme<D>, states: &'a [SolidState<D>]) -> Solids<'a, D> {
        Solids { model: &scheme.model, states, surfaces: &self.surfaces }
    }

    /// The closed level set for samples.
    pub fn sampler(&self, scheme: &PaperScheme<D>) -> Sampler<'_, D> {
        Sampler::cells(&scheme.model.grid, &self.phi.data, scheme.model.scalar_boundary())
    }

    /// The liquid's surface beside solids ([`solid_side`]).
    pub fn shape<'a>(&'a self, scheme: &'a PaperScheme<D>, side: SolidSide<'a, D>) -> SurfaceShape<'a, D> {
        let model = &scheme.model;
        let phi = Sampler::cells(&model.grid, &self.surface.data, model.scalar_boundary());
        SurfaceShape { grid: &model.grid, phi, side }
    }
}

/// Distance to the nearest of some solids, m, and its normal.
pub fn solid_side<const D: usize>(
    solids: Solids<'_, D>,
) -> impl Fn(&Vector<D>) -> (f64, Vector<D>) + Sync + '_ {
    let step = NORMAL_STEP_CELLS * solids.model.grid.dx;
    move |x| {
        let nearest = solids.nearest(x).map(|number| solids.get(number));
        nearest.map_or((f64::INFINITY, Vector::zeros()), |s| (s.liquid_distance(x), s.normal(x, step)))
    }
}

impl<const D: usize> PaperScheme<D> {
    /// Extrapolates a velocity, m/s, over the band around the liquid of a geometry ([`extend_velocity`]).
    pub(super) fn extend_velocity(
        &self,
        geometry: &Geometry<D>,
        states: &[SolidState<D>],
        velocity: &mut FaceField<D>,
    ) {
        let (solids, step) = (geometry.solids(self, states), NORMAL_STEP_CELLS * self.model.grid.dx);
        let motion = |x: &Vector<D>| {
            let nearest = solids.nearest(x).map(|number| solids.get(number));
            nearest.map_or([Vector::zeros(); 2], |solid| solid.normal_and_velocity(x, step))
        };
        let slips = (self.errata.slip && !states.is_empty()).then_some(&motion as SolidMotion<'_, D>);
        extend_velocity(&self.model, &geometry.types, &geometry.phi, slips, velocity);
    }

    /// The level set of a surface that has been carried, m: continued into solids or closed along them, and a distance.
    pub(crate) fn restored_surface(&self, states: &[SolidState<D>], phi: CellField<D>) -> CellField<D> {
        let model = &self.model;
        let surfaces = SolidSurfaces::new(&model.solids, states);
        let solids = Solids { model, states, surfaces: &surfaces };
        let distance = |x: &Vector<D>| solids.liquid_distance(x);
        if !self.errata.open_surface {
            let data = closed_along_solids(&model.grid, &phi.data, &distance);
            return redistanced(model, CellField { grid: model.grid, data });
        }
        if model.solids.is_empty() {
            return redistanced(model, phi);
        }
        let (side, limit) = (solid_side(solids), BAND_WIDTH_CELLS * model.grid.dx);
        let sampler = Sampler::cells(&model.grid, &phi.data, model.scalar_boundary());
        let shape = SurfaceShape { grid: &model.grid, phi: sampler, side: &side };
        redistanced(model, continue_into_solids(&phi, &shape, &distance, limit))
    }

    /// Volume of the liquid of a state, m³ (2D: m²).
    pub fn liquid_volume(&self, state: &PaperState<D>) -> f64 {
        let model = &self.model;
        let surfaces = SolidSurfaces::new(&model.solids, &state.solids);
        let solids = Solids { model, states: &state.solids, surfaces: &surfaces };
        let data = closed_along_solids(&model.grid, &state.phi.data, &|x| solids.liquid_distance(x));
        self.volume(&CellField { grid: model.grid, data })
    }

    /// Volume of the liquid of a closed level set, m³ (2D: m²).
    pub fn volume(&self, phi: &CellField<D>) -> f64 {
        let grid = &self.model.grid;
        let sampler = Sampler::cells(grid, &phi.data, self.model.scalar_boundary());
        let lattice = grid.lattice();
        let fraction = |cell: usize| cell_fraction(&sampler, grid, lattice.coordinates(cell));
        let fractions = par::map(lattice.len(), 256, fraction);
        fractions.iter().sum::<f64>() * grid.cell_volume()
    }
}
