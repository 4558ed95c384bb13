//! The solves of steps 2, 3 and 7.

use super::geometry::Geometry;
use super::scheme::PaperScheme;
use crate::paper::coupling::momentum::{Liquid, MomentumRows, SolidMomentum};
use crate::paper::coupling::solids::SolidUnknowns;
use crate::paper::coupling::sparse_matrix::SparseMatrix;
use crate::paper::coupling::system::CoupledSystem;
use crate::paper::fluid::cells::FaceType;
use crate::solid::Solids;
use meniscus_numerics::Vector;
use meniscus_numerics::grid::{CellField, FaceField};
use meniscus_numerics::linalg::{SolveError, SolveReport};
use meniscus_numerics::mesh::SurfaceMesh;

/// Number of steps in which missing volume is made up for.
const CORRECTION_STEPS: f64 = 5.0;
/// Largest part of the volume that a step makes up for.
const MAX_CORRECTION: f64 = 0.01;

/// The matrices of the solids, and their velocities before a solve.
#[derive(Clone, Debug)]
pub struct SolidSystem {
    /// `J`.
    pub embedding: SparseMatrix,
    mass: SparseMatrix,
    damping: SparseMatrix,
    start: Vec<f64>,
    is_prescribed: Vec<bool>,
}

/// The solution of a coupled system.
#[derive(Clone, Debug)]
pub struct Solved {
    /// The unknown velocities, m/s.
    pub unknowns: Vec<f64>,
    /// How the solver ended.
    pub report: SolveReport,
    /// Liquid cells, and the pressure times the length of the step there, Pa s.
    pub pressure: Vec<(u32, f64)>,
}

impl SolidSystem {
    /// The system of solids with surfaces, m, and of the velocities of their nodes before the solve. Their forces act for `dt`, s, and belong
    /// to positions `lookahead`, s, later ([`Errata::implicit_elasticity`](crate::paper::Errata::implicit_elasticity)).
    pub fn new<const D: usize>(
        solids: Solids<'_, D>,
        surfaces: &[SurfaceMesh<D>],
        starts: Vec<Vec<Vector<D>>>,
        [dt, lookahead]: [f64; 2],
    ) -> Self {
        let unknowns = SolidUnknowns::new(solids);
        Self {
            embedding: unknowns.embedding(surfaces),
            mass: unknowns.mass(),
            damping: unknowns.implicit_forces(dt, lookahead),
            start: unknowns.values(starts),
            is_prescribed: unknowns.is_prescribed(),
        }
    }

    /// What their momentum rows are made of.
    pub fn momentum(&self) -> SolidMomentum<'_> {
        SolidMomentum {
            embedding: &self.embedding,
            mass: &self.mass,
            damping: &self.damping,
            velocity: &self.start,
            is_prescribed: &self.is_prescribed,
        }
    }
}

impl<const D: usize> PaperScheme<D> {
    /// The liquid of a geometry with a velocity `u*`, m/s.
    pub(super) fn liquid<'a>(
        &'a self,
        geometry: &'a Geometry<D>,
        velocity: &'a FaceField<D>,
    ) -> Liquid<'a, D> {
        Liquid {
            types: &geometry.types,
            phi: geometry.sampler(self),
            density: self.model.density,
            velocity,
            errata: self.errata,
        }
    }

    /// Solves Eq. 11 or 15 from `u*`, which becomes the velocity after the solve.
    pub(super) fn solve(
        &self,
        geometry: &Geometry<D>,
        rows: &MomentumRows,
        velocity: &mut FaceField<D>,
        source: f64,
    ) -> Result<Solved, SolveError> {
        let mut system = CoupledSystem::new(&geometry.types, self.model.density, velocity, rows);
        system.add_source(source, self.model.grid.dx);
        let mut x = vec![0.0; system.right.len()];
        let report = self.solver.solve(&system, &mut x, self.limits)?;
        let unknowns = system.apply(&geometry.types, rows, &x, velocity).to_vec();
        let pressure = system.pressure_impulses(&x, self.model.density, self.model.grid.dx);
        Ok(Solved { unknowns, report, pressure: system.cells.into_iter().zip(pressure).collect() })
    }

    /// Step 3: projects a velocity beside solids that have moved from one geometry to another one in `dt`, s.
    pub(super) fn project_transport(
        &self,
        [before, after]: [&Geometry<D>; 2],
        velocity: &mut FaceField<D>,
        missing: f64,
        dt: f64,
    ) -> Result<SolveReport, SolveError> {
        let ends = before.meshes.iter().zip(&after.meshes);
        let vertices = ends.flat_map(|(from, to)| from.positions.iter().zip(&to.positions));
        let effective: Vec<f64> = vertices
            .flat_map(|(from, to)| {
                let moved = (to - from) / dt;
                (0..D).map(move |a| moved[a])
            })
            .collect();
        let map = &after.map;
        let is_wetted = |i: &usize| after.types.face(map.faces[*i]) == FaceType::LiquidSolid;
        let wetted: Vec<usize> = (0..map.faces.len()).filter(is_wetted).collect();
        let values = map.on_components().select(&wetted).multiply(&effective);
        // One given unknown a face.
        let count = wetted.len();
        let rows = MomentumRows {
            owned: wetted.iter().map(|i| map.faces[*i]).collect(),
            map: SparseMatrix::new(count, (0..count as u32).map(|i| vec![(i, 1.0)])),
            mass: SparseMatrix::new(count, vec![Vec::new(); count]),
            momentum: vec![0.0; count],
            prescribed: values.into_iter().map(Some).collect(),
        };
        let part = (missing / CORRECTION_STEPS).clamp(-MAX_CORRECTION, MAX_CORRECTION);
        Ok(self.solve(after, &rows, velocity, part / dt)?.report)
    }

    /// The part of the volume that is missing.
    pub(super) fn missing_volume(&self, phi: &CellField<D>, target: f64) -> f64 {
        let volume = self.volume(phi);
        if volume > 0.0 { (target - volume) / volume } else { 0.0 }
    }
}
