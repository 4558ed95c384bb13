//! Builds a setup from a scene. The only place where the dimension is chosen at run time.

use super::Setup;
use super::shapes::{shape, signed_distance_fn};
use super::thickness::pad_thin_solids;
use crate::error::SceneError;
use crate::estimate::parameters::parameters;
use crate::file::{
    Bounds, Material, Scene, Scheme, ShapeSpec, Solid as SolidSpec, Wall, builtin_name, vector,
};
use crate::job::{ExistingRun, Job, Schedule, Stop};
use crate::output::Folder;
use crate::run::Observer;
use crate::run::checkpoint::Checksum;
use crate::run::{self, Outcome, RunError};
use meniscus_numerics::Vector;
use meniscus_numerics::grid::Grid;
use meniscus_numerics::shape::Shape;
use meniscus_sim::{Model, Numerics, Solid};
use std::path::PathBuf;

/// Initial condition in two or three dimensions.
#[derive(Clone)]
pub enum AnySetup {
    /// Two dimensions.
    D2(Setup<2>),
    /// Three dimensions.
    D3(Setup<3>),
}

impl AnySetup {
    /// The setup of a scene.
    ///
    /// # Errors
    /// [`SceneError`] for a shape that cannot be made.
    pub fn of(scene: &Scene) -> Result<Self, SceneError> {
        match scene.domain.dimension {
            2 => Ok(Self::D2(setup(scene)?)),
            _ => Ok(Self::D3(setup(scene)?)),
        }
    }

    /// Runs the scene into a folder; see [`run::run`].
    ///
    /// # Errors
    /// [`RunError`].
    pub fn run(
        &self,
        job: &Job,
        folder: &Folder,
        existing: ExistingRun,
        stop: &(dyn Fn() -> Option<Stop> + Sync),
        observer: &mut dyn Observer,
    ) -> Result<Outcome, RunError> {
        match self {
            Self::D2(setup) => run::run(setup, job, folder, existing, stop, observer),
            Self::D3(setup) => run::run(setup, job, folder, existing, stop, observer),
        }
    }
}

impl Job {
    /// The job of a scene; `text` is written as `scene.toml` of the output.
    pub fn of(scene: &Scene, text: String) -> Self {
        let output = &scene.output;
        Self {
            name: scene.name.clone(),
            text,
            identity: identity(scene),
            schedule: Schedule::new(output.frame_interval(), output.duration),
            frame_interval: output.frame_interval(),
            frames: None,
            writers: output.formats.iter().filter_map(|format| format.frame_writer()).collect(),
            checkpoint_every: output.checkpoint_every as u64,
            solids: names_and_mesh_edges(scene),
            warnings: Vec::new(),
            description: scene.description.clone(),
            parameters: parameters(scene),
        }
    }
}

/// Name and mesh edge, m, of every solid.
pub(super) fn names_and_mesh_edges(scene: &Scene) -> Vec<(String, f64)> {
    scene.solids.iter().map(|solid| (solid.name.clone(), solid.mesh_edge)).collect()
}

/// A hash that differs between scenes with different results. The duration, additional output and the number of threads do
/// not enter.
fn identity(scene: &Scene) -> u64 {
    let Scene { name, domain, liquid, solids, tension, contact_line, numerics, output, .. } = scene;
    let numerics = crate::file::Numerics { threads: None, ..numerics.clone() };
    let parts = (name, domain, liquid, solids, tension, contact_line, numerics, output.frame_interval());
    let mut sum = Checksum::default();
    sum.update(format!("{parts:?}").as_bytes());
    // Files that cannot be read are reported when the solid is built.
    let contents = files(scene).into_iter().filter_map(|file| scene.files.content(&file).ok());
    contents.for_each(|content| sum.update(&content));
    sum.value()
}

/// The files that a scene refers to, without those that are built in.
fn files(scene: &Scene) -> Vec<PathBuf> {
    let of_solid = |s: &SolidSpec| {
        let moved = s.moved.iter().map(|m| m.shape.clone());
        s.fixed.iter().cloned().chain(moved).chain([s.shape.clone()]).collect::<Vec<_>>()
    };
    let patches = scene.tension.solids.iter().flat_map(|(_, w)| w.patches.iter().map(|p| p.shape.clone()));
    let bodies = scene.liquid.bodies.iter().map(|b| b.shape.clone());
    let shapes: Vec<ShapeSpec> =
        scene.solids.iter().flat_map(of_solid).chain(patches).chain(bodies).collect();
    let mesh = |s: &ShapeSpec| match s {
        // TetGen meshes consist of two files.
        ShapeSpec::Mesh { path, .. } if path.extension().is_some_and(|e| e == "node" || e == "ele") => {
            vec![path.with_extension("node"), path.with_extension("ele")]
        }
        ShapeSpec::Mesh { path, .. } => vec![path.clone()],
        _ => Vec::new(),
    };
    let meshes = shapes.iter().flat_map(ShapeSpec::parts).flat_map(mesh);
    let images = scene.tension.solids.iter().filter_map(|(_, w)| Some(w.image.as_ref()?.path.clone()));
    let is_builtin = |path: &PathBuf| path.to_str().and_then(builtin_name).is_some();
    meshes.chain(images).filter(|path| !is_builtin(path)).collect()
}

/// The setup of a scene of dimension `D`.
///
/// # Errors
/// [`SceneError`] for a shape that cannot be made.
pub fn setup<const D: usize>(scene: &Scene) -> Result<Setup<D>, SceneError> {
    let bodies = scene.liquid.bodies.iter();
    let bodies = bodies.map(|b| Ok((signed_distance_fn(&b.shape, &scene.files)?, vector(&b.velocity))));
    let solids = scene.solids.iter().map(|s| solid(scene, s)).collect::<Result<_, _>>()?;
    let bodies = bodies.collect::<Result<_, SceneError>>()?;
    let model = Model { solids, ..model(scene) };
    check_solids_apart(scene, &model)?;
    let model = Model { solids: pad_thin_solids(scene, &model)?, ..model };
    let model = model.with_open_sides();
    Ok(Setup {
        model: if scene.has_wetting_walls() { with_wetting_domain_walls(scene, model) } else { model },
        bodies,
    })
}

/// The model with wetting domain walls.
fn with_wetting_domain_walls<const D: usize>(scene: &Scene, model: Model<D>) -> Model<D> {
    let (cosine, line) = (scene.domain.wall_contact_angle.cos(), &scene.contact_line);
    model.with_wetting_walls(
        cosine,
        line.uniform_friction(),
        line.hysteresis.as_ref().map(super::wettability::hysteresis),
    )
}

/// Overlap, in cells, attributed to rounding of the numbers in a scene. Surfaces with a gap up to this touch.
const CONTACT_TOLERANCE_CELLS: f64 = 0.01;

/// Refuses a solid from a mesh file that leaves the domain. Other shapes are checked when the scene is validated.
fn check_mesh_inside_domain<const D: usize>(
    scene: &Scene,
    spec: &SolidSpec,
    shape: &Shape<D>,
) -> Result<(), SceneError> {
    if spec.shape.bounds(D).is_some() {
        return Ok(());
    }
    let list = |v: Vector<D>| v.iter().copied().collect::<Vec<f64>>();
    let (lower, upper) = shape.bounds();
    let bounds = Bounds { lower: list(lower), upper: list(upper) };
    let Some((reach, help)) = bounds.describe_outside(&scene.domain.size, 1e-6 * scene.domain.dx) else {
        return Ok(());
    };
    let error = SceneError::new(format!("the solid `{}` extends outside the domain: it {reach}", spec.name))
        .with_help(format!(
            "{help}; `scale` sets the length of a unit of the mesh file, `translate` the position of its origin"
        ));
    let number = scene.solids.iter().position(|s| s.name == spec.name).unwrap_or(0);
    Err(scene.source.at_value(error, &scene.source.first_inside(&format!("solid.{number}.shape"))))
}

/// Refuses unbounded free solids and solids that overlap at the start.
fn check_solids_apart<const D: usize>(scene: &Scene, model: &Model<D>) -> Result<(), SceneError> {
    let at = |i: usize, key: &str| format!("solid.{i}.{key}");
    let name = |i: usize| &scene.solids[i].name;
    let free = |s: &SolidSpec| matches!(s.material, Material::Rigid { fixed: false });
    for (i, solid) in model.solids.iter().enumerate() {
        if free(&scene.solids[i]) && !solid.kind.is_free_rigid() {
            let error =
                SceneError::new(format!("the free solid `{}` is unbounded and has no finite mass", name(i)));
            let help = "use material.rigid = { fixed = true }, or a bounded shape";
            return Err(scene.source.at_value(error.with_help(help), &at(i, "material")));
        }
    }
    let all = meniscus_sim::initial_overlaps(model);
    let deepest = all.into_iter().max_by(|a, b| a.2.total_cmp(&b.2));
    let Some((i, other, depth)) = deepest.filter(|o| o.2 > CONTACT_TOLERANCE_CELLS * model.grid.dx) else {
        return check_initial_gaps(scene, model);
    };
    // Report the later one in the file.
    let (i, other) = other.map_or((i, None), |j| (i.max(j), Some(i.min(j))));
    let what = other.map_or("a closed side of the domain".to_owned(), |j| format!("the solid `{}`", name(j)));
    let error = SceneError::new(format!("the solid `{}` overlaps {what} by {depth:.3e} m", name(i)));
    let error = error.with_help("move them apart; contact without overlap is allowed");
    Err(scene.source.at_value(error, &scene.source.first_inside(&at(i, "shape"))))
}

/// Refuses deformable solids whose surfaces touch at the start: the barrier would be infinite.
fn check_initial_gaps<const D: usize>(scene: &Scene, model: &Model<D>) -> Result<(), SceneError> {
    let dx = model.grid.dx;
    let narrowest =
        meniscus_sim::narrowest_initial_gap(model).filter(|gap| gap.2 <= CONTACT_TOLERANCE_CELLS * dx);
    let Some((i, j, _)) = narrowest else { return Ok(()) };
    let (i, j) = (i.max(j), i.min(j));
    let name = |i: usize| &scene.solids[i].name;
    let other = if i == j { "itself".to_owned() } else { format!("the solid `{}`", name(j)) };
    let error = SceneError::new(format!("the deformable solid `{}` touches {other}", name(i)));
    let help = format!("leave a gap of at least {:.1e} m", 2.0 * CONTACT_TOLERANCE_CELLS * dx);
    Err(scene.source.at_value(error.with_help(help), &scene.source.first_inside(&format!("solid.{i}.shape"))))
}

/// The model of a scene of dimension `D`, without its solids.
pub fn model<const D: usize>(scene: &Scene) -> Model<D> {
    let domain = &scene.domain;
    let wall = |axis: usize, side: usize| match domain.walls.get(axis).map(|w| w[side]) {
        Some(Wall::Open) => meniscus_sim::Wall::Open,
        _ => meniscus_sim::Wall::Slip,
    };
    let cells = std::array::from_fn(|a| domain.cells.get(a).copied().unwrap_or(1));
    let n = &scene.numerics;
    Model {
        grid: Grid::new(cells, domain.dx),
        walls: std::array::from_fn(|a| [wall(a, 0), wall(a, 1)]),
        density: scene.liquid.density,
        kinematic_viscosity: scene.liquid.kinematic_viscosity,
        surface_tension: scene.tension.liquid_air,
        gravity: vector(&scene.liquid.gravity),
        solids: Vec::new(),
        numerics: Numerics {
            scheme: match n.scheme {
                Scheme::Meniscus => meniscus_sim::Scheme::Meniscus,
                Scheme::Paper => meniscus_sim::Scheme::Paper,
                Scheme::PaperAsPrinted => meniscus_sim::Scheme::PaperAsPrinted,
            },
            cfl: n.cfl,
            capillary_step: n.capillary_step,
            max_step: n.max_step,
            tolerance: n.tolerance,
            max_iterations: n.max_iterations,
            fixed_step: n.fixed_step,
            restore_momentum: n.restore_momentum,
            contact_line: scene.contact_line.enabled,
            line_radius: scene.contact_line.radius.unwrap_or(0.0),
            newton_iterations: n.newton_iterations,
        },
    }
}

/// A solid of a scene.
fn solid<const D: usize>(scene: &Scene, spec: &SolidSpec) -> Result<Solid<D>, SceneError> {
    let shape = shape(&spec.shape, &scene.files);
    shape.iter().try_for_each(|shape| check_mesh_inside_domain(scene, spec, shape))?;
    let kind = super::kinds::kind(scene, spec)?;
    let mut solid = Solid::new(shape?, kind, spec.density.unwrap_or(scene.liquid.density));
    solid.initial_velocity = vector(&spec.velocity);
    let tension = scene.tension.solids.iter().find(|(name, _)| *name == spec.name);
    (solid.restitution, solid.friction) = (spec.collision.restitution, spec.collision.friction);
    if !scene.contact_line.enabled {
        return Ok(solid);
    }
    solid.line_friction = scene.contact_line.friction_on(&spec.name);
    solid.hysteresis = scene.contact_line.hysteresis.as_ref().map(super::wettability::hysteresis);
    if let Some((_, wetting)) = tension {
        solid.young_cosine = wetting.young_cosine(scene.tension.liquid_air);
        solid.pattern = super::wettability::layers(scene, &spec.name, wetting)?;
    }
    Ok(solid)
}
