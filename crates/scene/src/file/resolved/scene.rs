//! A resolved scene in SI units, with defaults filled in and checked. Vectors have `dimension` entries.

use super::expectation::Expectation;
use super::shape::ShapeSpec;
use super::tension::{ContactLine, Tensions};
use super::warning::Warnings;
use crate::file::grammar::{Format, Scheme, Wall};
use crate::file::material::Material;
use crate::file::scene_files::SceneFiles;
use crate::file::source::Source;
use std::f64::consts::FRAC_PI_2;

/// Name of the closed sides of the domain where a solid's name is expected.
pub const WALLS: &str = "walls";

/// A valid scene. [`crate::file::ensure_runnable`] checks that this version can run it.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// Name, also of the output folder.
    pub name: String,
    /// Source of the scene.
    pub based_on: Option<String>,
    /// Description.
    pub description: Option<String>,
    /// Cost of a run, in words.
    pub cost: Option<String>,
    /// Simulated domain.
    pub domain: Domain,
    /// The liquid.
    pub liquid: Liquid,
    /// The solids.
    pub solids: Vec<Solid>,
    /// Tensions.
    pub tension: Tensions,
    /// The contact line.
    pub contact_line: ContactLine,
    /// Choices of the discretisation.
    pub numerics: Numerics,
    /// Output options.
    pub output: Output,
    /// Expectations, checked at the end of a run.
    pub expect: Vec<Expectation>,
    /// Warnings; not part of equality.
    pub warnings: Warnings,
    /// Source positions for errors; not part of equality.
    pub source: Source,
    /// The files that the scene names; not part of equality.
    pub files: SceneFiles,
}

/// The simulated box, from the origin to `size`.
#[derive(Clone, Debug, PartialEq)]
pub struct Domain {
    /// 2 or 3.
    pub dimension: usize,
    /// Size, m: `cells` times `dx`.
    pub size: Vec<f64>,
    /// Cells along each axis.
    pub cells: Vec<usize>,
    /// Size of a cell, m.
    pub dx: f64,
    /// Walls on the lower and upper side along each axis.
    pub walls: Vec<[Wall; 2]>,
    /// Contact angle at the closed sides, rad.
    pub wall_contact_angle: f64,
}

impl Domain {
    /// Number of cells.
    pub fn cell_count(&self) -> f64 {
        self.cells.iter().map(|&n| n as f64).product()
    }

    /// Whether the contact angle at the closed sides differs from 90 degrees, the angle of a mirror.
    pub fn walls_are_wetting(&self) -> bool {
        (self.wall_contact_angle - FRAC_PI_2).abs() > 1e-9
    }
}

impl Scene {
    /// Whether the contact angle at the closed sides differs from 90 degrees and the contact line is enabled.
    pub fn has_wetting_walls(&self) -> bool {
        self.domain.walls_are_wetting() && self.contact_line.enabled
    }

    /// Number of cells of the grid, including the margins beyond open and wetting sides.
    pub fn grid_cells(&self) -> f64 {
        let beyond = |w: &Wall| match w {
            Wall::Open => meniscus_sim::OPEN_SIDE_MARGIN_CELLS,
            Wall::Slip if self.has_wetting_walls() => meniscus_sim::WETTING_WALL_MARGIN_CELLS,
            Wall::Slip => 0,
        };
        let along = |(n, sides): (&usize, &[Wall; 2])| (n + sides.iter().map(beyond).sum::<usize>()) as f64;
        self.domain.cells.iter().zip(&self.domain.walls).map(along).product()
    }
}

/// The liquid.
#[derive(Clone, Debug, PartialEq)]
pub struct Liquid {
    /// Density, kg/m³.
    pub density: f64,
    /// Kinematic viscosity, m²/s.
    pub kinematic_viscosity: f64,
    /// Gravity, m/s².
    pub gravity: Vec<f64>,
    /// Bodies at the start; where they overlap the first one counts.
    pub bodies: Vec<Body>,
}

/// A body of liquid at the start.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// Region.
    pub shape: ShapeSpec,
    /// Start velocity, m/s.
    pub velocity: Vec<f64>,
    /// Whether solids cut it at the start on purpose; suppresses the warning.
    pub displaced: bool,
}

/// A solid.
#[derive(Clone, Debug, PartialEq)]
pub struct Solid {
    /// Name.
    pub name: String,
    /// Density, kg/m³; `None` if it was not given for a solid that does not move freely.
    pub density: Option<f64>,
    /// Shape.
    pub shape: ShapeSpec,
    /// Edge length of its mesh, m.
    pub mesh_edge: f64,
    /// Material.
    pub material: Material,
    /// Start velocity, m/s.
    pub velocity: Vec<f64>,
    /// Coefficient of restitution.
    pub restitution: f64,
    /// Coefficient of friction between solids.
    pub friction: f64,
    /// Vertices inside these shapes do not move.
    pub fixed: Vec<ShapeSpec>,
    /// Parts with prescribed motion.
    pub moved: Vec<Moved>,
}

/// A part of a solid with prescribed motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Moved {
    /// Region that selects its vertices at the start.
    pub shape: ShapeSpec,
    /// Constant velocity, m/s, used without keyframes.
    pub velocity: Vec<f64>,
    /// Time, s, and displacement, m; times increase.
    pub keyframes: Vec<(f64, Vec<f64>)>,
}

/// Parameters of the discretisation.
#[derive(Clone, Debug, PartialEq)]
pub struct Numerics {
    /// The scheme.
    pub scheme: Scheme,
    /// CFL number: largest displacement per step, in cells.
    pub cfl: f64,
    /// Largest step, s; infinite if there is none.
    pub max_step: f64,
    /// Tolerance on the relative residual.
    pub tolerance: f64,
    /// Largest number of iterations of a linear solve.
    pub max_iterations: usize,
    /// Largest step as a multiple of the explicit capillary limit.
    pub capillary_step: f64,
    /// Least number of Newton iterations of a step after the first, if any solid is free or deformable.
    pub newton_iterations: u32,
    /// Fixed time step, s.
    pub fixed_step: Option<f64>,
    /// Restore the momentum that the discretisation loses.
    pub restore_momentum: bool,
    /// Number of threads; `None`: all available.
    pub threads: Option<usize>,
}

/// Output options.
#[derive(Clone, Debug, PartialEq)]
pub struct Output {
    /// Simulated time, s.
    pub duration: f64,
    /// Time between frames, s.
    pub frame_interval: f64,
    /// Formats, sorted, with `ply`.
    pub formats: Vec<Format>,
    /// Frames between checkpoints.
    pub checkpoint_every: usize,
}
