//! Checks a scene without running it: dimensionless numbers, cost, memory and warnings.

use super::deformable::{SoftReport, reports};
use super::{gaps, memory, thin_liquid};
use crate::build::AnySetup;
use crate::build::displaced_liquid::{DisplacedBody, check_displaced, displaced_bodies};
use crate::error::SceneError;
use crate::estimate::scales::{ball_radius, liquid_volume, norm, radius, smallest_radius, typical_speed};
use crate::expect::ensure_columns;
use crate::file::{Material, Scene, WALLS, Warning};
use crate::units::format_si;
use serde::Serialize;
use std::f64::consts::PI;

/// Core seconds per step and liquid cell: what a million cells in the middle of liquid take. With the constants below, eleven built-in
/// scenes from `drop-on-beam-2d` to `crown-splash` and `fig22-plate-90` took 0.5 to 1.4 times the estimated seconds a step.
const SECONDS_PER_LIQUID_CELL: f64 = 1e-6;
/// Core seconds per step and cell of the liquid's surface: in 3D with solids, and else.
const SECONDS_PER_SURFACE_CELL: [f64; 2] = [2e-4, 6e-5];
/// Core seconds per step and vertex of a deformable solid, in 2D and in 3D, for the two or three iterations of Newton's method that most
/// steps take.
const SECONDS_PER_VERTEX: [f64; 2] = [1.7e-5, 1e-4];
/// Core seconds per step and byte of the factors of deformable solids, for factorisation and solves together.
const SECONDS_PER_FACTOR_BYTE: f64 = 3e-9;
/// Time of deformable solids on one thread over that on two, a number: 1.55 to 1.62 was measured with a soft plate. More threads were not
/// measured and count as two.
const SOLID_SPEEDUP: f64 = 1.55;
/// Seconds per step and byte of the matrix of solids without factors, for some dozen iterative solves. A ball of 58,400 vertices took 32
/// s a step.
const SECONDS_PER_ITERATED_BYTE: f64 = 4e-7;
/// Young's modulus over γ/Δ from which on a contact line gives a solid without damping no more energy than a rigid one: 5 % of γR in
/// 30 ms at a ratio of 500, 0.4 % at 3e4 as with a rigid one (`book/experiments.md`, E34).
const NOISE_FREE_MODULUS_RATIO: f64 = 1e4;
/// A warning is given for fewer cells per radius of a liquid body.
const MIN_CELLS_ACROSS: f64 = 8.0;
/// Fewer cells per capillary length resolve no meniscus: a puddle at 90° is √2 capillary lengths high (de Gennes, Brochard-Wyart & Quéré
/// 2004, chapter 2), here four cells.
pub(super) const MIN_CAPILLARY_LENGTH_CELLS: f64 = 3.0;

/// The report of a check; SI units, angles in degrees.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// Name of the scene.
    pub name: String,
    /// 2 or 3.
    pub dimension: usize,
    /// Cells along each axis.
    pub cells: Vec<usize>,
    /// Number of cells.
    pub cell_count: f64,
    /// Size of a cell, m.
    pub dx: f64,
    /// Volume of the liquid at the start, m³ (2D: m²), sampled; none if a shape is a mesh.
    pub liquid_volume: Option<f64>,
    /// Cells of liquid.
    pub liquid_cells: Option<f64>,
    /// Every liquid body that solids displace; none where the scene cannot run.
    pub displaced: Vec<DisplacedBody>,
    /// Share of the liquid that is thinner than two cells at the start; none where the scene cannot run.
    pub thin_liquid: Option<f64>,
    /// Estimated memory, bytes.
    pub memory_bytes: f64,
    /// Estimated number of time steps.
    pub steps: f64,
    /// Rough time that a run takes on this machine, s.
    pub run_seconds: f64,
    /// Expected time step, s.
    pub time_step: f64,
    /// The explicit capillary limit 0.36 √(ρ Δ³ / γ), s.
    pub capillary_step: f64,
    /// Length scale of the dimensionless numbers, m: the smallest radius of a liquid body, or that of a ball of the same volume.
    pub radius: Option<f64>,
    /// Velocity scale of the dimensionless numbers, m/s: the largest difference between liquid bodies, or the speed of a single one.
    pub speed: f64,
    /// Capillary length √(γ / ρ g), m; none without gravity.
    pub capillary_length: Option<f64>,
    /// Capillary length in cells.
    pub capillary_length_cells: Option<f64>,
    /// Bo = ρ g R² / γ.
    pub bond: Option<f64>,
    /// We = ρ U² D / γ.
    pub weber: Option<f64>,
    /// Oh = μ / √(ρ γ D).
    pub ohnesorge: Option<f64>,
    /// La = γ ρ D / μ²; none without viscosity.
    pub laplace: Option<f64>,
    /// Re = U D / ν; none without viscosity.
    pub reynolds: Option<f64>,
    /// The liquid bodies.
    pub bodies: Vec<BodyReport>,
    /// Every pair of liquid and solid.
    pub pairs: Vec<PairReport>,
    /// Every deformable solid; none where the scene cannot run.
    pub soft: Vec<SoftReport>,
    /// Warnings about the scene.
    pub warnings: Vec<Warning>,
    /// Why the scene cannot run; none if it can.
    pub cannot_run: Option<String>,
    /// The error, if the scene is invalid (not only unsupported by this version) or its solids need more memory than this machine has.
    #[serde(skip)]
    pub error: Option<SceneError>,
}

/// A liquid body.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BodyReport {
    /// Number in the scene, from 0.
    pub index: usize,
    /// The length that the grid must resolve, m; none for a half-space.
    pub radius: Option<f64>,
    /// Cells per that length.
    pub cells_per_radius: Option<f64>,
}

/// Wetting of a solid by the liquid.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PairReport {
    /// Name of the solid; `walls` for the sides of the domain.
    pub solid: String,
    /// Cosine of Young's angle; none if no tension is given.
    pub young_cosine: Option<f64>,
    /// Young's angle, degrees; none beyond total wetting or drying.
    pub young_angle: Option<f64>,
    /// Smallest and largest angle of a pattern, degrees; none where the angle is uniform.
    pub young_angles: Option<[f64; 2]>,
    /// `partial`, `total wetting`, `no wetting`, `patterned` or `no tension given`.
    pub wetting: &'static str,
    /// Elastocapillary length γ / E, m; none for rigid solids and springs.
    pub elastocapillary_length: Option<f64>,
    /// Bending elastocapillary length √(B / γ) of a shell, m (plates: see `soft`).
    pub bending_elastocapillary_length: Option<f64>,
    /// Friction coefficient of the contact line, Pa s.
    pub line_friction: f64,
}

/// Checks a scene without running it. `threads` is the number of cores of a run, for the time estimate.
pub fn check(scene: &Scene, threads: usize) -> Report {
    let (d, l, gamma) = (&scene.domain, &scene.liquid, scene.tension.liquid_air);
    let volume = liquid_volume(scene);
    let liquid_cells = volume.map(|v| v / d.dx.powi(d.dimension as i32));
    let bodies: Vec<BodyReport> = body_reports(scene);
    let radius = smallest_radius(scene).or_else(|| volume.map(|v| ball_radius(v, d.dimension)));
    let speed = typical_speed(scene);
    let g = norm(&l.gravity);
    let capillary_length = (g > 0.0).then(|| (gamma / (l.density * g)).sqrt());
    let capillary_step = 0.36 * (l.density * d.dx.powi(3) / gamma).sqrt();
    let time_step = expected_time_step(scene, capillary_step, speed, radius);
    let steps = (scene.output.duration / time_step).ceil();
    let cells = d.cell_count();
    let liquid_cell_count = liquid_cells.unwrap_or(cells);
    let [bond, weber, ohnesorge, laplace, reynolds] = dimensionless_numbers(scene, radius, speed);
    let mut warnings = scene.warnings.0.clone();
    more_warnings(scene, &bodies, capillary_length, &mut warnings);
    let built = check_setup(scene, &mut warnings);
    let soft_bytes: f64 = built.soft.iter().map(|s| s.memory_bytes).sum();
    Report {
        name: scene.name.clone(),
        dimension: d.dimension,
        cells: d.cells.clone(),
        cell_count: cells,
        dx: d.dx,
        liquid_volume: volume,
        liquid_cells,
        displaced: built.displaced,
        thin_liquid: built.thin_liquid,
        memory_bytes: memory::liquid_memory(scene.grid_cells(), liquid_cell_count) + soft_bytes,
        steps,
        run_seconds: steps * seconds_per_step(scene, liquid_cell_count, &built.soft, threads),
        time_step,
        capillary_step,
        radius,
        speed,
        capillary_length,
        capillary_length_cells: capillary_length.map(|c| c / d.dx),
        bond,
        weber,
        ohnesorge,
        laplace,
        reynolds,
        bodies,
        pairs: pairs(scene),
        soft: built.soft,
        warnings,
        cannot_run: built.cannot_run,
        error: built.error,
    }
}

/// Results of `check` that need the built setup: grid, meshes and displaced liquid.
struct BuiltReport {
    displaced: Vec<DisplacedBody>,
    thin_liquid: Option<f64>,
    soft: Vec<SoftReport>,
    cannot_run: Option<String>,
    error: Option<SceneError>,
}

/// Builds the setup of a scene if this version can run it, and checks it. Adds warnings.
fn check_setup(scene: &Scene, warnings: &mut Vec<Warning>) -> BuiltReport {
    let supported = crate::file::ensure_runnable(scene);
    let is_unsupported = supported.is_err();
    let setup = supported.and_then(|()| ensure_columns(scene)).and_then(|()| AnySetup::of(scene));
    let displaced = setup.as_ref().map_or_else(|_| Vec::new(), |setup| displaced_bodies(scene, setup));
    let cut = check_displaced(scene, &displaced);
    warnings.extend(cut.as_ref().cloned().unwrap_or_default());
    let thin_liquid = setup.as_ref().ok().map(|setup| unresolved_share(scene, setup, warnings));
    let soft = setup.as_ref().map_or_else(|_| Vec::new(), |setup| reports(scene, setup));
    let fits = setup
        .as_ref()
        .map_or(Ok(()), |setup| memory::check_solid_memory(scene, setup, memory::machine_memory()));
    BuiltReport {
        displaced,
        thin_liquid,
        soft,
        cannot_run: setup.as_ref().err().map(SceneError::line),
        error: setup.err().filter(|_| !is_unsupported).or(fits.err()).or(cut.err()),
    }
}

/// Bo, We, Oh, La and Re of a body of liquid of this radius, m, and speed, m/s.
fn dimensionless_numbers(scene: &Scene, radius: Option<f64>, speed: f64) -> [Option<f64>; 5] {
    let (l, gamma) = (&scene.liquid, scene.tension.liquid_air);
    let (g, nu) = (norm(&l.gravity), l.kinematic_viscosity);
    let diameter = radius.map(|r| 2.0 * r);
    [
        radius.filter(|_| g > 0.0).map(|r| l.density * g * r * r / gamma),
        diameter.map(|x| l.density * speed * speed * x / gamma),
        diameter.map(|x| nu * l.density / (l.density * gamma * x).sqrt()),
        diameter.filter(|_| nu > 0.0).map(|x| gamma * x / (l.density * nu * nu)),
        diameter.filter(|_| nu > 0.0).map(|x| speed * x / nu),
    ]
}

/// Rough wall time of a step on this number of threads, s. The liquid is taken for a ball.
fn seconds_per_step(scene: &Scene, liquid_cells: f64, soft: &[SoftReport], threads: usize) -> f64 {
    let dimension = scene.domain.dimension;
    let [surface_cells, per_surface_cell] = match dimension {
        2 => [2.0 * (PI * liquid_cells).sqrt(), SECONDS_PER_SURFACE_CELL[1]],
        _ => {
            let area = (36.0 * PI).cbrt() * liquid_cells.powf(2.0 / 3.0);
            [area, SECONDS_PER_SURFACE_CELL[usize::from(scene.solids.is_empty())]]
        }
    };
    let liquid = SECONDS_PER_LIQUID_CELL * liquid_cells + per_surface_cell * surface_cells;
    let per_byte = |factorised| if factorised { SECONDS_PER_FACTOR_BYTE } else { SECONDS_PER_ITERATED_BYTE };
    let of_solid = |s: &SoftReport| {
        SECONDS_PER_VERTEX[dimension - 2] * s.vertices as f64 + per_byte(s.factorised) * s.solver_bytes
    };
    let solids: f64 = soft.iter().map(of_solid).sum();
    let speedup = if threads > 1 { SOLID_SPEEDUP } else { 1.0 };
    liquid / (threads.max(1) as f64) + solids / speedup
}

/// Share of the liquid that is thinner than two cells at the start. Adds warnings about it and about gaps between solids.
fn unresolved_share(scene: &Scene, setup: &AnySetup, warnings: &mut Vec<Warning>) -> f64 {
    let (share, place) = match setup {
        AnySetup::D2(setup) => {
            warnings.extend(gaps::warnings(scene, setup));
            let thin = thin_liquid::of_setup(setup);
            (thin.share, thin.place.map(|x| x.as_slice().to_vec()))
        }
        AnySetup::D3(setup) => {
            warnings.extend(gaps::warnings(scene, setup));
            let thin = thin_liquid::of_setup(setup);
            (thin.share, thin.place.map(|x| x.as_slice().to_vec()))
        }
    };
    if let Some(place) = place.filter(|_| share > thin_liquid::WARNING_SHARE) {
        let place: Vec<String> = place.iter().map(|x| format_si(*x, "m")).collect();
        let message = format!(
            "{:.1} % of the liquid is in regions thinner than two cells, near ({}): the grid does not resolve it there",
            100.0 * share,
            place.join(", ")
        );
        warnings.push(Warning { path: "liquid.body".to_owned(), message });
    }
    share
}

/// The expected step, s: the minimum of the capillary limit, the CFL limit at the largest estimated speed, and the given limits.
fn expected_time_step(scene: &Scene, capillary: f64, speed: f64, radius: Option<f64>) -> f64 {
    let (n, l) = (&scene.numerics, &scene.liquid);
    if let Some(fixed) = n.fixed_step {
        return fixed.min(scene.output.frame_interval());
    }
    let height = scene.domain.size.last().copied().unwrap_or(0.0);
    let fall_speed = (norm(&l.gravity) * height).sqrt();
    let capillary_speed = radius.map_or(0.0, |r| (scene.tension.liquid_air / (l.density * r)).sqrt());
    let fastest = speed.max(fall_speed).max(0.5 * capillary_speed);
    let cfl = if fastest > 0.0 { n.cfl * scene.domain.dx / fastest } else { f64::INFINITY };
    (n.capillary_step * capillary).min(cfl).min(n.max_step).min(scene.output.frame_interval())
}

fn body_reports(scene: &Scene) -> Vec<BodyReport> {
    let report = |(index, body): (usize, &crate::file::Body)| {
        let radius = radius(scene, &body.shape);
        BodyReport { index, radius, cells_per_radius: radius.map(|r| r / scene.domain.dx) }
    };
    scene.liquid.bodies.iter().enumerate().map(report).collect()
}

fn pairs(scene: &Scene) -> Vec<PairReport> {
    let gamma = scene.tension.liquid_air;
    let line = &scene.contact_line;
    let report = |solid: &str, cosine: Option<f64>| PairReport {
        solid: solid.to_owned(),
        young_cosine: cosine,
        young_angle: cosine.filter(|c| c.abs() <= 1.0).map(|c| c.acos().to_degrees()),
        young_angles: None,
        wetting: match cosine {
            None => "no tension given",
            Some(c) if c >= 1.0 => "total wetting",
            Some(c) if c <= -1.0 => "no wetting",
            Some(_) => "partial",
        },
        elastocapillary_length: None,
        bending_elastocapillary_length: None,
        line_friction: line.friction_on(solid),
    };
    let mut out = vec![report(WALLS, Some(scene.domain.wall_contact_angle.cos()))];
    for s in &scene.solids {
        let tension = scene.tension.solids.iter().find(|t| t.0 == s.name);
        let mut pair = report(&s.name, tension.map(|t| t.1.young_cosine(gamma)));
        match &s.material {
            Material::Shell { young_modulus, poisson_ratio, thickness, .. } => {
                let bending = young_modulus * thickness.powi(3) / (12.0 * (1.0 - poisson_ratio.powi(2)));
                pair.bending_elastocapillary_length = Some((bending / gamma).sqrt());
            }
            Material::NeoHookean(e) | Material::Corotated(e) => {
                pair.elastocapillary_length = Some(gamma / e.young_modulus);
            }
            _ => {}
        }
        if let Some((_, wetting)) = tension.filter(|t| !t.1.is_uniform()) {
            let [low, high] = wetting.cosines(gamma).map(|c| c.clamp(-1.0, 1.0).acos().to_degrees());
            (pair.young_angles, pair.wetting) = (Some([high, low]), "patterned");
        }
        out.push(pair);
    }
    out
}

fn more_warnings(scene: &Scene, bodies: &[BodyReport], capillary: Option<f64>, out: &mut Vec<Warning>) {
    for b in bodies {
        if let Some(n) = b.cells_per_radius.filter(|n| 2.0 * n < MIN_CELLS_ACROSS) {
            let message = format!(
                "this liquid body is only {:.1} cells across; at least {MIN_CELLS_ACROSS} are recommended",
                2.0 * n
            );
            out.push(Warning { path: format!("liquid.body.{}.shape", b.index), message });
        }
    }
    if let Some(n) = capillary.map(|c| c / scene.domain.dx).filter(|n| *n < 1.0) {
        let message =
            format!("the capillary length is only {n:.2} cells: the grid hardly resolves capillary effects");
        out.push(Warning { path: "tension.liquid_air".to_owned(), message });
    }
    for s in &scene.solids {
        if !scene.tension.solids.iter().any(|t| t.0 == s.name) {
            let message = format!(
                "no tension or contact angle is given for the solid `{}`: a contact angle of 90 degrees is used",
                s.name
            );
            out.push(Warning { path: "tension".to_owned(), message });
        }
    }
    out.extend(undamped_solids(scene));
    if scene.expect.is_empty() {
        let message = "no results are checked at the end of the run: add [expect]".to_owned();
        out.push(Warning { path: "expect".to_owned(), message });
    }
}

/// Warnings about soft solids without damping.
fn undamped_solids(scene: &Scene) -> impl Iterator<Item = Warning> {
    let stiff = NOISE_FREE_MODULUS_RATIO * scene.tension.liquid_air / scene.domain.dx;
    let is_soft = move |material: &Material| match material {
        Material::NeoHookean(e) | Material::Corotated(e) => e.damping_ratio == 0.0 && e.young_modulus < stiff,
        Material::Springs { damping_ratio, .. } => *damping_ratio == 0.0,
        _ => false,
    };
    let solids = scene.solids.iter().enumerate();
    solids.filter(move |(_, s)| scene.contact_line.enabled && is_soft(&s.material)).map(|(i, s)| {
        let message = format!(
            "the solid `{}` deforms without damping: noise of a contact line on it adds energy from step to step; give a \
             `damping_ratio` of 0.05 or more in its material",
            s.name
        );
        Warning { path: format!("solid.{i}.material"), message }
    })
}
