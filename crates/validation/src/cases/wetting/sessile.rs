//! Drops on solids without gravity: Young's angle on planes of any position and slope, on a cylinder and a ball.

use crate::measure::{at_least, at_most, bar, bars, checks_or_failure, convergence_order, surface_points};
use crate::setup::{StepBounds, at_rest, run_to, unit_model, up, wetted};
use crate::{Case, Check, Mode};
use meniscus_numerics::fit::Sphere;
use meniscus_numerics::grid::Grid;
use meniscus_numerics::shape::Shape;
use meniscus_numerics::{Matrix, Vector};
use meniscus_sim::{Compiled, Model, Simulation, Solid, SolidKind, StepError, Wall};
use std::f64::consts::PI;

/// Drops on planes in 2D.
pub const CASE_2D: Case = Case {
    name: "sessile-2d",
    title: "Drops on a wall, 2D",
    theory: "Half a disc (radius 1, γ = ρ = 1, ν = 0.5, no gravity) on a frictionless wall spreads or contracts to the \
        segment of a circle that meets the wall at Young's angle. Walls along the grid 0, 0.3 and 0.7 cells off its \
        faces, and tilted by 22.5 and 45 degrees; the worst of them counts. The angle is that of the circle through the \
        surface more than 1.5 cells above the wall. Quick: 8 cells per radius, tilted by 22.5 degrees.",
    quick: true,
    run: |mode| {
        let angles: &[f64] = if mode == Mode::Quick { &[60.0, 120.0] } else { &ANGLES };
        let places: &[WallPlacement] = if mode == Mode::Quick { &TILTED[..1] } else { &PLACES };
        checks_or_failure("sessile-2d", planes::<2>("sessile-2d", mode, angles, places))
    },
};

/// Drops on planes in 3D.
pub const CASE_3D: Case = Case {
    name: "sessile-3d",
    title: "Drops on a wall, 3D",
    theory: "As in 2D, from half a ball; walls 0.3 cells off the grid's faces and tilted by 22.5 degrees about an axis of \
        30 degrees' azimuth. 16 cells per radius. At 150 degrees ν = 1: half a ball has 2.87 π of energy, the drop at rest \
        2.51 π, free 2.52 π, so that with ν = 0.5 what contracts is thrown off.",
    quick: false,
    run: |mode| checks_or_failure("sessile-3d", planes::<3>("sessile-3d", mode, &SOME_ANGLES, &SOME_PLACES)),
};

/// Drops on curved solids, and convergence.
pub const CURVED: Case = Case {
    name: "sessile-curved",
    title: "Drops on a cylinder and a ball, and convergence",
    theory: "A drop of a quarter of the area of a disc (2D), an eighth of the volume of a ball (3D), on it: \
        circles and spheres that meet at Young's angle; ν = 1, so that what contracts is not thrown off. And \
        the order of the error of the angle on a wall tilted by 22.5 degrees, 8, 16 and 32 cells per radius, \
        root mean square over 60, 90 and 120 degrees (2D).",
    quick: false,
    run: |_| checks_or_failure("sessile-curved", curved().and_then(|checks| Ok([checks, order()?].concat()))),
};

/// Drops on a wall with short and long steps.
pub const STEPS: Case = Case {
    name: "sessile-steps",
    title: "Drops on a wall with short and long steps, 2D",
    theory: "The drops of sessile-2d on walls tilted by 22.5 and 45 degrees with steps of 0.5, 10 and 20 times the explicit \
        capillary limit: the angle less that with the usual 5 times; the worst of the walls counts. It must not depend on \
        the steps.",
    quick: false,
    run: |_| checks_or_failure("sessile-steps", steps()),
};

/// Drops on plates as thin as in the paper.
pub const THIN: Case = Case {
    name: "sessile-thin",
    title: "Drops on thin plates, 2D",
    theory: "The drops of sessile-2d on plates 1.5, 2 (padded to 2.5) and 2.67 cells thick (the paper's soft plates) instead of \
        walls, at all its places; their other side is dry. The angle, the worst of the places, and the speed; bars of the \
        soft plates of Fig. 22. Quick: 8 cells per radius, 1.5 and 2.67 cells thick.",
    quick: true,
    run: |mode| checks_or_failure("sessile-thin", thin(mode)),
};

/// Placement of a wall.
#[derive(Clone, Copy)]
struct WallPlacement {
    /// Offset from the grid's faces in cells.
    offset: f64,
    /// Tilt in degrees.
    tilt: f64,
}

const fn along_grid(offset: f64) -> WallPlacement {
    WallPlacement { offset, tilt: 0.0 }
}

const fn tilted(tilt: f64) -> WallPlacement {
    WallPlacement { offset: 0.0, tilt }
}

const ANGLES: [f64; 7] = [30.0, 45.0, 60.0, 90.0, 120.0, 135.0, 150.0];
const SOME_ANGLES: [f64; 5] = [30.0, 60.0, 90.0, 120.0, 150.0];
const PLACES: [WallPlacement; 5] =
    [along_grid(0.0), along_grid(0.3), along_grid(0.7), tilted(22.5), tilted(45.0)];
const TILTED: [WallPlacement; 2] = [tilted(22.5), tilted(45.0)];
const SOME_PLACES: [WallPlacement; 2] = [along_grid(0.3), tilted(22.5)];
/// Contact angle, degrees, from which a contracting half ball jumps off its wall.
const DETACHMENT_ANGLE_DEGREES: f64 = 140.0;
/// Duration of the runs, √(ρR³/γ).
const TIME: f64 = 12.0;

/// A drop on a plane: the side of a plate, or of a half-space.
#[derive(Clone, Copy)]
struct PlaneDrop {
    /// Cells per radius.
    cells: usize,
    /// Young's angle, degrees.
    angle: f64,
    place: WallPlacement,
    bounds: StepBounds,
    /// Thickness of the plate in cells; infinite for a half-space.
    thick: f64,
}

/// Result for a drop.
struct SessileResult {
    /// Angle minus Young's angle, degrees.
    angle: f64,
    /// Base radius and height over those of the circle, minus one.
    sizes: [f64; 2],
    /// Root mean square speed in the drop, over √(γ/ρR).
    speed: f64,
    /// Speed of the drop's centre of mass, over the same.
    mean_speed: f64,
    /// Change of the angle in the last third, degrees.
    angle_change: f64,
}

pub(crate) fn sessile_model<const D: usize>(grid: Grid<D>, solid: Solid<D>) -> Model<D> {
    Model { kinematic_viscosity: 0.5, solids: vec![solid], ..unit_model(grid, [[Wall::Slip; 2]; D]) }
}

/// Radius of the circle or sphere whose cap of this angle (rad) has half the size of the unit disc or ball.
pub(crate) fn cap_radius<const D: usize>(angle: f64) -> f64 {
    let (s, c) = angle.sin_cos();
    if D == 2 { (0.5 * PI / (angle - s * c)).sqrt() } else { (2.0 / ((2.0 + c) * (1.0 - c).powi(2))).cbrt() }
}

fn planes<const D: usize>(
    case: &str,
    mode: Mode,
    angles: &[f64],
    places: &[WallPlacement],
) -> Result<Vec<Check>, StepError>
where
    Simulation<D>: Compiled<D>,
{
    let cells = if mode == Mode::Quick { 8 } else { 16 };
    let mut checks = Vec::new();
    for &angle in angles {
        let wall = PlaneDrop::on_wall(cells, angle, places[0]);
        let rests = wall.at_places::<D>(places)?;
        let worst = |value: fn(&SessileResult) -> f64| worst(&rests, value);
        let middle = (45.0..=135.0).contains(&angle);
        let of_angle = if middle { bars(1.5, 0.5) } else { bars(3.0, 1.5) };
        let what = |text: &str| format!("{text}, θ = {angle}°, {cells} cells/R");
        let found = angle + worst(|r| r.angle);
        checks.push(Check::absolute(case, what("angle"), found, angle, of_angle).in_unit("deg"));
        if mode == Mode::Full {
            if (45.0..=120.0).contains(&angle) {
                let base = 1.0 + worst(|r| r.sizes[0]);
                let height = 1.0 + worst(|r| r.sizes[1]);
                checks.push(Check::relative(case, what("base radius"), base, 1.0, bars(0.02, 0.007)));
                checks.push(Check::relative(case, what("height"), height, 1.0, bars(0.02, 0.007)));
            }
            checks.push(at_most(case, what("u_rms √(ρR/γ)"), worst(|r| r.speed), bars(1e-2, 1e-3)));
            let glide = worst(|r| r.mean_speed);
            checks.push(at_most(case, what("gliding √(ρR/γ)"), glide, bars(1e-2, 1e-3)));
            checks
                .push(at_most(case, what("creep"), worst(|r| r.angle_change), bars(0.5, 0.1)).in_unit("deg"));
        }
    }
    Ok(checks)
}

fn thin(mode: Mode) -> Result<Vec<Check>, StepError> {
    let quick = mode == Mode::Quick;
    let (cells, thick): (_, &[f64]) =
        if quick { (8, &[1.5, 8.0 / 3.0]) } else { (16, &[1.5, 2.0, 8.0 / 3.0]) };
    let mut checks = Vec::new();
    for &thick in thick {
        for angle in [60.0, 90.0, 120.0] {
            let plate = PlaneDrop { thick, ..PlaneDrop::on_wall(cells, angle, PLACES[0]) };
            let rests = plate.at_places::<2>(&PLACES)?;
            let off = |value: fn(&SessileResult) -> f64| worst(&rests, value);
            let what = |text: &str| format!("{text}, {thick:.2} cells thick, θ = {angle}°, {cells} cells/R");
            let found = angle + off(|r| r.angle);
            checks.push(
                Check::absolute("sessile-thin", what("angle"), found, angle, bars(3.0, 1.5)).in_unit("deg"),
            );
            let speed = off(|r| r.speed);
            checks.push(at_most("sessile-thin", what("u_rms √(ρR/γ)"), speed, bars(1e-2, 1e-3)));
        }
    }
    Ok(checks)
}

/// The largest of the drops' values by size.
fn worst(rests: &[SessileResult], value: fn(&SessileResult) -> f64) -> f64 {
    rests.iter().map(value).max_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap_or(f64::NAN)
}

/// The middle of the plane that a drop lies on, and the plane's normal.
struct Plane<const D: usize> {
    point: Vector<D>,
    normal: Vector<D>,
}

impl PlaneDrop {
    /// A drop on a half-space with default steps.
    fn on_wall(cells: usize, angle: f64, place: WallPlacement) -> Self {
        Self { cells, angle, place, bounds: StepBounds::default(), thick: f64::INFINITY }
    }

    /// The drop at rest at each of some places.
    fn at_places<const D: usize>(self, places: &[WallPlacement]) -> Result<Vec<SessileResult>, StepError>
    where
        Simulation<D>: Compiled<D>,
    {
        places.iter().map(|place| Self { place: *place, ..self }.relax::<D>()).collect()
    }

    /// Half a disc or ball on the plane, and the plane at which the liquid meets the solid.
    fn start<const D: usize>(&self, room: f64) -> (Simulation<D>, Plane<D>)
    where
        Simulation<D>: Compiled<D>,
    {
        let Self { angle, thick, .. } = *self;
        let dx = 1.0 / self.cells as f64;
        // Room for the overshooting drop around a wall through the middle.
        let half = room * self.cells as f64;
        let grid = Grid::<D>::new([2 * half.ceil() as usize; D], dx);
        let (tilt, azimuth) = (self.place.tilt.to_radians(), if D == 2 { 0.0 } else { PI / 6.0 });
        let mut normal = Vector::<D>::zeros();
        normal[D - 1] = tilt.cos();
        normal[0] += tilt.sin() * azimuth.cos();
        if D == 3 {
            normal[1] += tilt.sin() * azimuth.sin();
        }
        let mut point = grid.domain_upper() * 0.5;
        point[D - 1] += self.place.offset * dx;
        let shape = if thick.is_finite() {
            let mut half_size = 2.0 * grid.domain_upper();
            half_size[D - 1] = 0.5 * thick * dx;
            Shape::Box {
                center: point - normal * half_size[D - 1],
                half_size,
                rotation: rotation_to(&normal),
            }
        } else {
            Shape::HalfSpace { point, normal }
        };
        let mut wall = Solid::new(shape, SolidKind::Fixed, 1.0).padded(thick * dx, dx);
        wall.young_cosine = angle.to_radians().cos();
        let depth = |x: &Vector<D>| (point - x).dot(&normal);
        let start = |x: &Vector<D>| ((x - point).norm() - 1.0).max(depth(x) - 0.5 * thick * dx);
        let mut model = sessile_model(grid, wall);
        model.numerics = self.bounds.into();
        if D == 3 && angle > DETACHMENT_ANGLE_DEGREES {
            model.kinematic_viscosity = 1.0;
        }
        let side = point + normal * model.solids[0].padding;
        (at_rest(model, &start), Plane { point: side, normal })
    }

    /// Lets half a disc or ball come to rest on the plane.
    fn relax<const D: usize>(&self) -> Result<SessileResult, StepError>
    where
        Simulation<D>: Compiled<D>,
    {
        let young = self.angle.to_radians();
        let radius = cap_radius::<D>(young);
        let (base, height) = (radius * young.sin(), radius * (1.0 - young.cos()));
        let (mut sim, Plane { point, normal }) = self.start::<D>(1.25 * base.max(1.0).max(height) + 1.0);
        let dx = sim.model.grid.dx;
        let measure = |sim: &Simulation<D>| {
            let cap = fit_cap(sim, |x| (x - point).dot(&normal) > 1.5 * dx);
            (cap.angle_on_plane(&point, &normal), cap.radius)
        };
        run_to(&mut sim, TIME * 2.0 / 3.0, |_, _| ())?;
        let before = measure(&sim).0;
        run_to(&mut sim, TIME, |_, _| ())?;
        let (found, size) = measure(&sim);
        let turned = found.to_radians();
        let sizes = [size * turned.sin() / base - 1.0, size * (1.0 - turned.cos()) / height - 1.0];
        let (speed, mean_speed) = rms_and_mean_speed(&sim);
        let (angle, angle_change) = (found - self.angle, found - before);
        Ok(SessileResult { angle, sizes, speed, mean_speed, angle_change })
    }
}

/// The rotation of the last axis to a direction other than its opposite.
fn rotation_to<const D: usize>(normal: &Vector<D>) -> Matrix<D> {
    let up = up::<D>(1.0);
    let both = up + normal;
    Matrix::identity() - both * both.transpose() / (1.0 + normal[D - 1]) + normal * up.transpose() * 2.0
}

/// Fits a cap to the points of the surface selected by `counts`.
pub(crate) fn fit_cap<const D: usize>(sim: &Simulation<D>, counts: impl Fn(&Vector<D>) -> bool) -> Sphere<D> {
    let mut points = surface_points(&sim.model, &sim.state.phi);
    points.retain(|p| counts(&p.at));
    let points: Vec<(Vector<D>, f64)> = points.iter().map(|p| (p.at, p.area)).collect();
    Sphere::fit(&points).unwrap_or(Sphere { center: Vector::zeros(), radius: f64::NAN })
}

/// Root mean square of the speed about the mean velocity, and the mean speed.
pub(crate) fn rms_and_mean_speed<const D: usize>(sim: &Simulation<D>) -> (f64, f64) {
    let books = sim.diagnostics();
    let mass = sim.model.density * books.volume;
    let mean = books.momentum.norm() / mass;
    ((2.0 * books.kinetic_energy / mass - mean * mean).max(0.0).sqrt(), mean)
}

/// The angle less Young's angle of 60 degrees on a wall tilted by 22.5 degrees in 2D, degrees.
pub(crate) fn angle_error(bounds: StepBounds) -> Result<f64, StepError> {
    Ok(PlaneDrop { bounds, ..PlaneDrop::on_wall(16, 60.0, TILTED[0]) }.relax::<2>()?.angle)
}

fn steps() -> Result<Vec<Check>, StepError> {
    let mut checks = Vec::new();
    for angle in [45.0, 60.0, 90.0, 120.0, 135.0] {
        let angles = |step: f64| -> Result<Vec<f64>, StepError> {
            let bounds = StepBounds { capillary_step: step, ..StepBounds::default() };
            let drop = PlaneDrop { bounds, ..PlaneDrop::on_wall(16, angle, TILTED[0]) };
            Ok(drop.at_places::<2>(&TILTED)?.iter().map(|rest| rest.angle).collect())
        };
        let usual = angles(StepBounds::default().capillary_step)?;
        for step in [0.5, 10.0, 20.0] {
            let turned = angles(step)?.iter().zip(&usual).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            let what = format!("change of the angle, {step} times the limit, θ = {angle}°");
            checks.push(at_most("sessile-steps", what, turned, bar(0.5)).in_unit("deg"));
        }
    }
    Ok(checks)
}

fn curved() -> Result<Vec<Check>, StepError> {
    let mut checks = Vec::new();
    // Height of the drop's apex over the solid's, in radii of the solid.
    let plane = [(30.0, 0.44273), (60.0, 0.60972), (90.0, 0.74911), (120.0, 0.86908), (150.0, 0.96114)];
    let space = [(60.0, 0.51405), (120.0, 0.84051)];
    for (angle, apex) in plane {
        checks.extend(drop_on_ball::<2>(angle, apex)?);
    }
    for (angle, apex) in space {
        checks.extend(drop_on_ball::<3>(angle, apex)?);
    }
    Ok(checks)
}

/// A drop with half the size of a ball of radius 1.25, on that ball; 16 cells per radius of a disc or ball of the drop's size.
fn drop_on_ball<const D: usize>(angle: f64, apex: f64) -> Result<Vec<Check>, StepError>
where
    Simulation<D>: Compiled<D>,
{
    let (cells, solid) = (16.0, 1.25);
    let dx = 1.0 / cells;
    let size = [3.4, 3.4, 4.0];
    let grid =
        Grid::<D>::new(std::array::from_fn(|a| (size[if a + 1 == D { 2 } else { a }] * cells) as usize), dx);
    let mut center = grid.domain_upper() * 0.5 + Vector::from_fn(|a, _| dx * [0.141, 0.273, 0.368][a]);
    center[D - 1] = 1.4;
    let ball = wetted(Shape::Ball { center, radius: solid }, angle);
    // A ball around the top of the solid, whose part outside the solid has the drop's volume.
    let volume = if D == 2 { 0.25 * PI * solid * solid } else { PI / 6.0 * solid.powi(3) };
    let up = up::<D>(1.0);
    let start = |radius: f64| {
        let distance = |x: &Vector<D>| (x - center - up * solid).norm() - radius;
        at_rest(Model { kinematic_viscosity: 1.0, ..sessile_model(grid, ball.clone()) }, &distance)
    };
    let mut radius = 1.0;
    for _ in 0..8 {
        radius *= (volume / start(radius).diagnostics().volume).powf(1.0 / D as f64);
    }
    let mut sim = start(radius);
    run_to(&mut sim, TIME, |_, _| ())?;
    let cap = fit_cap(&sim, |x| (x - center).norm() > solid + 1.5 * dx);
    let found = cap.angle_on_ball(&center, solid);
    let top = (cap.center - center).norm() + cap.radius - solid;
    let what = |text: &str| format!("{text} on a {}, θ = {angle}°", if D == 2 { "cylinder" } else { "ball" });
    let case = "sessile-curved";
    Ok(vec![
        Check::absolute(case, what("angle"), found, angle, bars(2.0, 1.0)).in_unit("deg"),
        Check::relative(case, what("height / R"), top / solid, apex, bars(0.02, 0.01)),
    ])
}

fn order() -> Result<Vec<Check>, StepError> {
    let mut errors = Vec::new();
    for cells in [8, 16, 32] {
        let mut square = 0.0;
        for angle in [60.0, 90.0, 120.0] {
            square += PlaneDrop::on_wall(cells, angle, TILTED[0]).relax::<2>()?.angle.powi(2) / 3.0;
        }
        errors.push((1.0 / cells as f64, square.sqrt()));
    }
    let text =
        format!("order of the angle's error ({:.2}, {:.2}, {:.2}°)", errors[0].1, errors[1].1, errors[2].1);
    Ok(vec![at_least("sessile-curved", text, convergence_order(&errors), 1.0, 1.5)])
}
