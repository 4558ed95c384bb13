//! Physical and numerical parameters of a run.

use crate::solid::{Solid, SolidState};
use meniscus_elastic::{Elastic, ElasticState};
use meniscus_numerics::Vector;
use meniscus_numerics::grid::{BoundaryExtension, FaceField, Grid, VelocitySampler};

/// Bond number of a cell, `ρ g Δ²/γ` in 1/cells², above which the grid does not resolve the capillary length (three cells).
/// Beyond it the weight in the energy is reduced, because the curvature filter would take it for noise.
const MAX_RESOLVED_CELL_BOND: f64 = 0.1;

/// Boundary condition of a side of the domain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wall {
    /// Impermeable and frictionless; the contact angle is 90 degrees.
    Slip,
    /// Open to air. Liquid leaves through it if the grid extends beyond it ([`Model::with_open_sides`]), as in scenes.
    Open,
}

/// The physical and numerical description of a run.
#[derive(Clone, Debug)]
pub struct Model<const D: usize> {
    /// The grid.
    pub grid: Grid<D>,
    /// The lower and upper side along each axis.
    pub walls: [[Wall; 2]; D],
    /// Density of the liquid, kg/m³.
    pub density: f64,
    /// Kinematic viscosity, m²/s; 0 for an inviscid liquid.
    pub kinematic_viscosity: f64,
    /// Surface tension of the liquid–air interface, N/m.
    pub surface_tension: f64,
    /// Gravity, m/s².
    pub gravity: Vector<D>,
    /// The solids.
    pub solids: Vec<Solid<D>>,
    /// Parameters of the discretisation.
    pub numerics: Numerics,
}

/// Scheme of a time step. A further one is an arm here and a function beside `step`, as that of `simulation/paper_step.rs`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scheme {
    /// Positions first, then one coupled solve for pressure and solids.
    Meniscus,
    /// The seven steps of the paper, with its errata corrected ([`crate::paper`]).
    Paper,
    /// The same as printed, misprints aside.
    PaperAsPrinted,
}

/// Parameters of the discretisation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Numerics {
    /// Scheme of a time step.
    pub scheme: Scheme,
    /// Courant number: largest displacement in a step, in cells.
    pub cfl: f64,
    /// Largest step as a multiple of the explicit capillary limit ([`Model::capillary_dt_limit`]).
    pub capillary_step: f64,
    /// Largest step, s.
    pub max_step: f64,
    /// Tolerance of the pressure solve: relative residual.
    pub tolerance: f64,
    /// Largest number of iterations of the pressure solve.
    pub max_iterations: usize,
    /// Constant step length, s, without bounds by stability; for studies of the step length. A step that fails is halved, and the
    /// length then grows back by at most a quarter a step.
    pub fixed_step: Option<f64>,
    /// Restores the momentum that the discretisation loses; off only in studies of that loss.
    pub restore_momentum: bool,
    /// Contact lines exert forces on solids. Without them solids feel pressure only, as in traditional two-way coupling; their
    /// `young_cosine` should then be 0, so that the contact angle is 90 degrees.
    pub contact_line: bool,
    /// Distance, m, from the contact line on deformable solids over which its force is spread evenly (the paper's R). With 0
    /// the force acts at the line, and the height of the ridge on a thick solid depends on the mesh.
    pub line_radius: f64,
    /// Least number of Newton iterations after the first if any solid is free or deformable; each repeats the
    /// pressure solve.
    pub newton_iterations: u32,
}

impl Default for Numerics {
    fn default() -> Self {
        Self {
            scheme: Scheme::Meniscus,
            cfl: 0.7,
            capillary_step: 5.0,
            max_step: f64::INFINITY,
            tolerance: 1e-6,
            max_iterations: 1000,
            fixed_step: None,
            restore_momentum: true,
            contact_line: true,
            line_radius: 0.0,
            newton_iterations: 0,
        }
    }
}

impl<const D: usize> Model<D> {
    /// Whether forces move any solid, that is, whether one is free or deformable.
    pub fn has_dynamic_solids(&self) -> bool {
        self.solids.iter().any(|s| !s.kind.is_prescribed())
    }

    /// Boundary extension of scalars beyond the sides.
    pub fn scalar_boundary(&self) -> [[BoundaryExtension; 2]; D] {
        self.walls.map(|sides| {
            sides.map(|w| if w == Wall::Slip { BoundaryExtension::Even } else { BoundaryExtension::Clamp })
        })
    }

    /// Boundary extension of the velocity component along `axis` beyond the sides.
    pub fn velocity_boundary(&self, axis: usize) -> [[BoundaryExtension; 2]; D] {
        let mut edges = self.scalar_boundary();
        edges[axis] = self.walls[axis]
            .map(|w| if w == Wall::Slip { BoundaryExtension::Odd } else { BoundaryExtension::Clamp });
        edges
    }

    /// Samples a velocity with the boundary extensions of the domain's sides.
    pub fn velocity_sampler<'a>(&self, velocity: &'a FaceField<D>) -> VelocitySampler<'a, D> {
        VelocitySampler::new(&self.grid, velocity, |axis| self.velocity_boundary(axis))
    }

    /// Whether face `i` along `axis`, normal to it, lies on an impermeable side.
    pub fn on_closed_side(&self, axis: usize, i: usize) -> bool {
        (i == 0 && self.walls[axis][0] == Wall::Slip)
            || (i == self.grid.cells[axis] && self.walls[axis][1] == Wall::Slip)
    }

    /// States of the solids at the start.
    pub fn initial_solids(&self) -> Vec<SolidState<D>> {
        self.solids.iter().map(Solid::initial_state).collect()
    }

    /// The deformable solids, and the positions and velocities of their vertices in these states.
    pub fn deformable_solids<'a>(
        &'a self,
        states: &'a [SolidState<D>],
    ) -> impl Iterator<Item = (&'a Elastic<D>, &'a ElasticState<D>)> {
        let of = |(solid, now): (&'a Solid<D>, &'a SolidState<D>)| {
            Some((solid.elastic()?, &now.as_deformable()?.vertices))
        };
        self.solids.iter().zip(states).filter_map(of)
    }

    /// Bond vector `−ρ g Δ²/γ`, 1/cells²: the weight in the energy, reduced above [`MAX_RESOLVED_CELL_BOND`]; zero without solids.
    pub(crate) fn cell_bond_vector(&self) -> Vector<D> {
        if self.solids.is_empty() || self.surface_tension <= 0.0 {
            return Vector::zeros();
        }
        let bond = self.gravity * (-self.density * self.grid.dx.powi(2) / self.surface_tension);
        bond / (1.0 + (bond.norm() / MAX_RESOLVED_CELL_BOND).powi(2))
    }

    /// Fraction of the liquid's weight that [`Self::cell_bond_vector`] neglects, 0 to 1.
    pub(crate) fn neglected_weight_fraction(&self) -> f64 {
        let full = self.gravity.norm() * self.density * self.grid.dx.powi(2) / self.surface_tension;
        let resolved = self.cell_bond_vector().norm();
        if resolved > 0.0 { 1.0 - resolved / full } else { 0.0 }
    }

    /// Explicit capillary limit of the step of a one-phase liquid, s: `2/ω_max = 0.36 √(ρ Δ³/γ)`.
    pub fn capillary_dt_limit(&self) -> f64 {
        0.36 * (self.density * self.grid.dx.powi(3) / self.surface_tension).sqrt()
    }
}

#[cfg(test)]
impl<const D: usize> Model<D> {
    /// A liquid of density and tension 1 without viscosity and gravity, between closed sides.
    pub(crate) fn of_test(grid: Grid<D>, solids: Vec<Solid<D>>) -> Self {
        Self {
            grid,
            walls: [[Wall::Slip; 2]; D],
            density: 1.0,
            kinematic_viscosity: 0.0,
            surface_tension: 1.0,
            gravity: Vector::zeros(),
            solids,
            numerics: Numerics::default(),
        }
    }
}
