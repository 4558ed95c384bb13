//! Heavy solids carried by the surface, and the force on a fixed one.

use crate::measure::{at_most, bar, bars, checks_or_failure, surface_points};
use crate::setup::{StepBounds, at_rest, run_to, unit_model, up};
use crate::{Case, Check, Mode};
use meniscus_numerics::Vector;
use meniscus_numerics::grid::Grid;
use meniscus_numerics::shape::Shape;
use meniscus_sim::{Compiled, Model, Simulation, Solid, SolidKind, StepError, Wall};
use std::f64::consts::PI;

/// Floating and sinking solids.
pub const FREE_BODY: Case = Case {
    name: "floating",
    title: "Heavy bodies on the surface",
    theory: "A cylinder (2D; R = ρ = g = 1, γ = 1/Bo, ν = 1) twice as dense as the liquid floats: height of \
        its centre over the undisturbed level by the closed form of the plane meniscus (Keller 1998). The tank \
        is 6 capillary lengths wide to each side and 6.2 R deep, its sides meet the liquid at 90 degrees, the \
        level is that at the sides, and what the meniscus still is below it there. Released at rest 0.1 R \
        above equilibrium with a meniscus that decays as exp(−x/lc); time 40 √(R/g). And 0.9 and 1.1 times as \
        dense as the densest that floats, released at rest at equilibrium: floats, sinks. 12 cells per radius; \
        the sphere (3D) 8, in a tank of 4 capillary lengths, the level by the pressure at its bottom. Quick: \
        8, time 20.",
    quick: true,
    run: |mode| checks_or_failure(FLOATING, free_body(mode)),
};

/// Fixed solids.
pub const FIXED_BODY: Case = Case {
    name: "floating-force",
    title: "Force on a held cylinder in the surface",
    theory: "A cylinder (R = 0.5, γ = 150, ρ = 1, g = 981, ν = 11) held at z/R = −0.5, 0, 0.5 in a level that \
        starts flat: the upward force of pressure and contact line at rest over the closed form (as in \
        `floating`) for the height over the level at the tank's sides, 6 capillary lengths off; and over the \
        weight of the liquid that body and meniscus displace under the level that the pressure at the bottom \
        tells; means over the last tenth of the time. 12 cells per radius. Quick: 8, z = 0, 90 and 150 degrees.",
    quick: false,
    run: |mode| checks_or_failure(FORCE, fixed_body(mode)),
};

const FLOATING: &str = "floating";
const FORCE: &str = "floating-force";
/// Height above equilibrium at which solids are released, R.
const RELEASE_HEIGHT: f64 = 0.1;
/// Duration of the runs, √(R/g).
pub(crate) const TIME: f64 = 40.0;
/// Depth of the tank, and room above the level, R.
const DEPTH: f64 = 6.2;
const HEADSPACE: f64 = 1.5;

/// A cylinder of radius one at the surface of a liquid; all angles in rad.
#[derive(Clone, Copy)]
struct Cylinder {
    bond: f64,
    angle: f64,
}

/// Position of its contact line, and the quantities that follow from it.
#[derive(Clone, Copy)]
struct EquilibriumLine {
    /// Angle of the line from the bottom.
    polar: f64,
    /// Slope angle of the meniscus at the line.
    slope: f64,
    /// Its depth below the undisturbed level, R.
    depth: f64,
    /// Height of the cylinder's centre over the undisturbed level, R.
    center: f64,
    /// Upward force over the tension.
    force: f64,
}

impl Cylinder {
    fn line_at(&self, polar: f64) -> EquilibriumLine {
        let (slope, root) = (self.angle + polar - PI, self.bond.sqrt());
        let (s, c) = polar.sin_cos();
        let depth = 2.0 / root * (0.5 * slope).sin();
        let force = 2.0 * slope.sin() + self.bond * (polar - s * c) + 4.0 * root * s * (0.5 * slope).sin();
        EquilibriumLine { polar, slope, depth, center: c - depth, force }
    }

    /// All positions of the line, from the bottom up.
    fn lines(&self) -> impl Iterator<Item = EquilibriumLine> {
        (1..20_000).map(|i| self.line_at(PI * f64::from(i) / 20_000.0))
    }

    /// Equilibrium of a solid denser than the liquid by a factor: the first line, from below, whose force carries its weight.
    fn floating(&self, density: f64) -> Option<EquilibriumLine> {
        let weight = PI * self.bond * density;
        self.lines().find(|l| l.slope.abs() < PI && l.force >= weight)
    }

    /// The line of the densest solid that floats.
    fn heaviest(&self) -> EquilibriumLine {
        self.lines().max_by(|a, b| a.force.total_cmp(&b.force)).unwrap_or_else(|| self.line_at(0.5 * PI))
    }

    /// The line of a solid fixed at a height over the level.
    fn line_at_height(&self, center: f64) -> EquilibriumLine {
        let miss = |l: &EquilibriumLine| (l.center - center).abs();
        self.lines().min_by(|a, b| miss(a).total_cmp(&miss(b))).unwrap_or_else(|| self.line_at(0.5 * PI))
    }
}

fn free_body(mode: Mode) -> Result<Vec<Check>, StepError> {
    let mut checks = Vec::new();
    let quick = mode == Mode::Quick;
    let (cells, time) = if quick { (8, 0.5 * TIME) } else { (12, TIME) };
    let floats: &[(f64, f64)] = if quick {
        &[(1.0, 120.0)]
    } else {
        &[
            (1.0, 120.0),
            (1.0, 150.0),
            (0.5, 90.0),
            (0.5, 120.0),
            (0.5, 150.0),
            (0.25, 90.0),
            (0.25, 120.0),
            (0.25, 150.0),
        ]
    };
    for &(bond, angle) in floats {
        checks.extend(floats_at(bond, angle, cells, time)?);
    }
    let limits: &[(f64, f64)] =
        if quick { &[(1.0, 120.0)] } else { &[(1.0, 90.0), (1.0, 120.0), (0.5, 150.0)] };
    for &(bond, angle) in limits {
        for &share in if quick { &[1.1][..] } else { &[0.9, 1.1] } {
            checks.push(floats_or_sinks(bond, angle, share, cells, time)?);
        }
    }
    if !quick {
        checks.extend(sphere_floats_at(8)?);
    }
    Ok(checks)
}

/// A tank of liquid with a solid, in units of the solid's radius.
#[derive(Clone, Copy)]
pub(crate) struct Tank {
    /// Bond number.
    pub(crate) bond: f64,
    /// Contact angle, degrees.
    pub(crate) angle: f64,
    /// Density of the solid over the liquid's.
    pub(crate) density: f64,
    /// Cells per radius.
    pub(crate) cells: usize,
    /// Half-width of the tank.
    pub(crate) width: f64,
    /// Height of the solid's centre above the level.
    pub(crate) center: f64,
}

impl Tank {
    /// Starts; `surface` is the height of the liquid's surface over the level as a function of the distance from the axis.
    pub(crate) fn start<const D: usize>(self, surface: &(dyn Fn(f64) -> f64 + Sync)) -> Simulation<D>
    where
        Simulation<D>: Compiled<D>,
    {
        self.start_with(surface, StepBounds::default())
    }

    /// The same with bounds of the steps.
    fn start_with<const D: usize>(
        self,
        surface: &(dyn Fn(f64) -> f64 + Sync),
        bounds: StepBounds,
    ) -> Simulation<D>
    where
        Simulation<D>: Compiled<D>,
    {
        let Self { bond, angle, density, cells, width, center } = self;
        let dx = 1.0 / cells as f64;
        let side = 2 * (width * cells as f64).ceil() as usize;
        let high = ((DEPTH + HEADSPACE) * cells as f64) as usize;
        let grid = Grid::<D>::new(std::array::from_fn(|a| if a + 1 == D { high } else { side }), dx);
        let level = initial_level();
        let mut middle = grid.domain_upper() * 0.5;
        middle[D - 1] = level + center;
        let mut body = Solid::new(Shape::Ball { center: middle, radius: 1.0 }, SolidKind::Rigid, density);
        body.young_cosine = angle.to_radians().cos();
        let mut walls = [[Wall::Slip; 2]; D];
        walls[D - 1][1] = Wall::Open;
        let model = Model {
            kinematic_viscosity: 1.0,
            surface_tension: 1.0 / bond,
            gravity: up(-1.0),
            solids: vec![body],
            numerics: bounds.into(),
            ..unit_model(grid, walls)
        };
        let distance = |x: &Vector<D>| {
            let mut arm = x - middle;
            arm[D - 1] = 0.0;
            let r = arm.norm();
            // Height over the surface, as a distance.
            let slope = (surface(r + 0.5 * dx) - surface((r - 0.5 * dx).abs())) / dx;
            (x[D - 1] - level - surface(r)) / (1.0 + slope * slope).sqrt()
        };
        at_rest(model, &distance)
    }
}

/// Initial height of the level.
fn initial_level() -> f64 {
    DEPTH + 0.0123
}

/// Height of the surface at the tank's sides.
pub(crate) fn level_at_sides<const D: usize>(sim: &Simulation<D>) -> f64 {
    let (dx, wide) = (sim.model.grid.dx, sim.model.grid.domain_upper()[0]);
    let (mut sum, mut weight) = (0.0, 0.0);
    for p in surface_points(&sim.model, &sim.state.phi) {
        if p.at[0] < 4.0 * dx || p.at[0] > wide - 4.0 * dx {
            (sum, weight) = (sum + p.at[D - 1] * p.area, weight + p.area);
        }
    }
    sum / weight
}

/// Height of the undisturbed level. At the sides the meniscus is `depth / cosh((L − edge)/lc)` below it, if the contact line lies at
/// `edge` in this depth.
fn undisturbed_level(sim: &Simulation<2>, edge: f64, depth: f64) -> f64 {
    let length = (sim.model.surface_tension / (sim.model.density * sim.model.gravity.norm())).sqrt();
    let wide = 0.5 * sim.model.grid.domain_upper()[0];
    level_at_sides(sim) + depth / ((wide - edge) / length).cosh()
}

/// Height where the pressure of liquid at rest vanishes, from the pressure at the bottom.
pub(crate) fn level_by_pressure<const D: usize>(sim: &Simulation<D>) -> f64 {
    let fall = sim.model.density * sim.model.gravity.norm();
    sim.state.pressure(sim.model.density, 0) / fall + 0.5 * sim.model.grid.dx
}

/// Height of a floating cylinder's centre over the undisturbed level, R.
pub(crate) struct FloatingHeight {
    /// By the closed form.
    pub(crate) exact: f64,
    /// At the end, and at three quarters of the time.
    pub(crate) found: f64,
    pub(crate) before: f64,
}

/// Lets a cylinder twice as dense as the liquid come to rest from near its equilibrium; none if it cannot float.
pub(crate) fn float(
    bond: f64,
    angle: f64,
    cells: usize,
    time: f64,
    bounds: StepBounds,
) -> Result<Option<FloatingHeight>, StepError> {
    let cylinder = Cylinder { bond, angle: angle.to_radians() };
    let Some(line) = cylinder.floating(2.0) else { return Ok(None) };
    let (edge, length) = (line.polar.sin(), 1.0 / bond.sqrt());
    let surface = |r: f64| -line.depth * (-(r - edge).max(0.0) / length).exp();
    let center = line.center + RELEASE_HEIGHT;
    let tank = Tank { bond, angle, density: 2.0, cells, width: 6.0 * length, center };
    let mut sim = tank.start_with::<2>(&surface, bounds);
    let height = |sim: &Simulation<2>| {
        sim.state.solids[0].center_of_mass()[1] - undisturbed_level(sim, edge, line.depth)
    };
    run_to(&mut sim, 0.75 * time, |_, _| ())?;
    let before = height(&sim);
    run_to(&mut sim, time, |_, _| ())?;
    Ok(Some(FloatingHeight { exact: line.center, found: height(&sim), before }))
}

fn floats_at(bond: f64, angle: f64, cells: usize, time: f64) -> Result<Vec<Check>, StepError> {
    let height = float(bond, angle, cells, time, StepBounds::default())?;
    let Some(FloatingHeight { exact, found, before }) = height else { return Ok(Vec::new()) };
    let what = |text: &str| format!("{text}, 2D, Bo = {bond}, θ = {angle}°, {cells} cells/R");
    Ok(vec![
        Check::absolute(FLOATING, what("centre / R"), found, exact, bars(0.06, 0.02)),
        at_most(FLOATING, what("still moving in the last quarter / R"), found - before, bars(0.02, 0.005)),
    ])
}

/// A solid `share` times as dense as the densest that floats, released in its equilibrium or in that of the densest one.
fn floats_or_sinks(bond: f64, angle: f64, share: f64, cells: usize, time: f64) -> Result<Check, StepError> {
    let cylinder = Cylinder { bond, angle: angle.to_radians() };
    let heaviest = cylinder.heaviest();
    let density = share * heaviest.force / (PI * bond);
    let line = cylinder.floating(density).unwrap_or(heaviest);
    let (edge, length) = (line.polar.sin(), 1.0 / bond.sqrt());
    let surface = |r: f64| -line.depth * (-(r - edge).max(0.0) / length).exp();
    let mut sim =
        Tank { bond, angle, density, cells, width: 6.0 * length, center: line.center }.start::<2>(&surface);
    run_to(&mut sim, time, |_, _| ())?;
    let floats = if sim.wetted_fraction(0) < 0.999 { 1.0 } else { 0.0 };
    let text = format!("floats, D = {share} D_max, 2D, Bo = {bond}, θ = {angle}°, {cells} cells/R");
    Ok(Check::absolute(FLOATING, text, floats, if share < 1.0 { 1.0 } else { 0.0 }, bar(0.0)))
}

/// A sphere with Bo = 1 and 120 degrees; the positions of line and centre are those of the axisymmetric meniscus.
fn sphere_floats_at(cells: usize) -> Result<Vec<Check>, StepError> {
    let (polar, center) = (102.185_f64.to_radians(), -0.7127);
    let (edge, depth) = (polar.sin(), polar.cos() - center);
    let surface = |r: f64| {
        let out = r.max(edge);
        -depth * (edge - out).exp() * (edge / out).sqrt()
    };
    let tank =
        Tank { bond: 1.0, angle: 120.0, density: 2.0, cells, width: 4.0, center: center + RELEASE_HEIGHT };
    let mut sim = tank.start::<3>(&surface);
    run_to(&mut sim, 0.5 * TIME, |_, _| ())?;
    let found = sim.state.solids[0].center_of_mass()[2] - level_by_pressure(&sim);
    let text = format!("centre / R, 3D, Bo = 1, θ = 120°, {cells} cells/R");
    Ok(vec![Check::absolute(FLOATING, text, found, center, bars(0.06, 0.02))])
}

fn fixed_body(mode: Mode) -> Result<Vec<Check>, StepError> {
    let (cells, heights): (usize, &[f64]) =
        if mode == Mode::Quick { (8, &[0.0]) } else { (12, &[-0.5, 0.0, 0.5]) };
    let mut checks = Vec::new();
    for &angle in if mode == Mode::Quick { &[90.0, 150.0][..] } else { &[30.0, 90.0, 150.0] } {
        for &height in heights {
            checks.extend(force(angle, height, cells)?);
        }
    }
    Ok(checks)
}

/// The cylinder of the tables, R = 0.5, fixed `height` R above an initially flat level.
fn force(angle: f64, height: f64, cells: usize) -> Result<Vec<Check>, StepError> {
    let (radius, tension, fall) = (0.5, 150.0, 981.0);
    let cylinder = Cylinder { bond: fall * radius * radius / tension, angle: f64::to_radians(angle) };
    let (bond, width) = (cylinder.bond, 6.0 / cylinder.bond.sqrt());
    let mut sim = Tank { bond, angle, density: 1.0, cells, width, center: height }.start::<2>(&|_| 0.0);
    sim.model.solids[0].kind = SolidKind::Fixed;
    // In units of R, ρ and g; forces in ρ g R².
    let (mut impulse, mut level, mut time) = (0.0, 0.0, 0.0);
    run_to(&mut sim, 0.5 * TIME, |sim, report| {
        if sim.state.time > 0.45 * TIME {
            let now = &sim.state.solids[0];
            impulse += (now.pressure_force + now.contact_line_force)[1] * report.dt;
            level += level_by_pressure(sim) * report.dt;
            time += report.dt;
        }
    })?;
    let scale = fall * radius * radius;
    let [found, level] = [impulse / time * scale, level / time];
    let center = sim.state.solids[0].center_of_mass()[1];
    let near = cylinder.line_at_height(center - level_at_sides(&sim));
    let above = center - undisturbed_level(&sim, near.polar.sin(), near.depth);
    let expected = cylinder.line_at_height(above).force * tension;
    let what = |text: &str| format!("{text}, θ = {angle}°, z = {height} R, {cells} cells/R");
    // The force equals the weight of the liquid displaced by solid and meniscus below the level.
    let displaced = (sim.model.grid.domain_upper()[0] * level - sim.diagnostics().volume) * scale;
    Ok(vec![
        Check::relative(FORCE, what("upward force"), found, expected, bars(0.02, 0.01)).in_unit("dyn/cm"),
        Check::relative(FORCE, what("against the liquid displaced"), found, displaced, bars(0.02, 0.01))
            .in_unit("dyn/cm"),
    ])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_closed_form_gives_the_tables() {
        let cylinder = |bond: f64, angle: f64| Cylinder { bond, angle: angle.to_radians() };
        let rest = cylinder(0.5, 120.0).floating(2.0).map(|l| l.center);
        assert!(rest.is_some_and(|z| (z + 1.1064).abs() < 1e-3), "{rest:?}");
        assert!(cylinder(1.0, 90.0).floating(2.0).is_none());
        let most = cylinder(1.0, 90.0).heaviest().force / PI;
        assert!((most - 1.8491).abs() < 1e-3, "{most}");
        let pull = cylinder(981.0 * 0.25 / 150.0, 30.0).line_at_height(-0.5).force * 150.0;
        assert!((pull - 550.29).abs() < 0.2, "{pull}");
    }
}
