//! Deformable solids under extreme deformation: twisted, crushed, pulled through a slit, chained.
//!
//! There is no liquid. The method guarantees the invariants under any load: surfaces never cross (IPC), elements never invert, and
//! without prescribed motion the energy rises in no step.

use crate::measure::{at_least, at_most, bar, bars, checks_or_failure};
use crate::setup::{run_to, up};
use crate::soft::SoftMaterial;
use crate::solids_only::{
    ContactMonitor, cube_mesh, cube_to_ball, mapped, prescribed_motion, quadratic_cube_mesh,
    rigid_half_space, simulation_without_liquid, soft, vertices,
};
use crate::{Case, Check, Mode};
use meniscus_elastic::{Anchor, AnchorMotion};
use meniscus_numerics::Vector;
use meniscus_numerics::grid::Grid;
use meniscus_numerics::mesh::VolumeMesh;
use meniscus_numerics::shape::Shape;
use meniscus_sim::{Compiled, Simulation, Solid, SolidKind, StepError, Wall};
use std::f64::consts::TAU;

/// The case.
pub const CASE: Case = Case {
    name: "violence",
    title: "Soft solids that are twisted, crushed and pulled never cross, turn inside out, or win energy",
    theory: "No liquid, E = 1000, ν = 0.4, friction 0.3, cells of 1/24. A ball (radius 0.3) crushed between plates to a fifth of its \
        height and let go: it is as high again as it was. A strip 0.2 thick, with a narrower head, pulled by that through a slit of \
        0.12 between two posts. 3D: a strip of 3 x 0.4 x 0.1 whose ends are turned by three turns and brought together by half \
        of its length; three linked rings pulled to 1.5 times their length. Narrowest gap and least element in every \
        step, deepest overlap, and the largest rise of the energy in a step in which nothing is led, over the largest \
        elastic energy. Quick: 2D.",
    quick: true,
    run: |mode| checks_or_failure(NAME, run(mode)),
};

const NAME: &str = "violence";
const DX: f64 = 1.0 / 24.0;
const STEP: f64 = 5e-3;
/// End of the prescribed motions, and how long the solids are held after it.
const PRESCRIBED_DURATION: f64 = 1.0;
const HOLD_DURATION: f64 = 0.25;
const BALL_RADIUS: f64 = 0.3;

fn run(mode: Mode) -> Result<Vec<Check>, StepError> {
    let mut checks = labelled_checks("crushed ball, 2D", crush::<2>(16));
    checks.extend(labelled_checks("slit, 2D", slit::<2>([8, 40])));
    if mode == Mode::Full {
        checks.extend(labelled_checks("crushed ball, 3D", crush::<3>(8)));
        checks.extend(labelled_checks("slit, 3D", slit::<3>([6, 2, 30])));
        checks.extend(labelled_checks("twisted strip, 3D", twist()));
        checks.extend(labelled_checks("linked rings, 3D", chain()));
    }
    Ok(checks)
}

/// The checks of a part; a part that fails does not stop the others.
fn labelled_checks(part: &str, checks: Result<Vec<Check>, StepError>) -> Vec<Check> {
    let of = |check: Check| Check { quantity: format!("{part}: {}", check.quantity), ..check };
    checks_or_failure(NAME, checks).into_iter().map(of).collect()
}

/// The solids' material.
const MATERIAL: SoftMaterial = SoftMaterial { young: 1000.0, poisson: 0.4, density: 2.0, damping: 0.1 };
/// Coulomb friction coefficient of the solids.
const FRICTION: f64 = 0.3;

/// A simulation without domain walls.
fn without_walls<const D: usize>(solids: Vec<Solid<D>>) -> Simulation<D>
where
    Simulation<D>: Compiled<D>,
{
    let mut simulation = simulation_without_liquid(Grid::new([8; D], DX), solids, Vector::zeros(), STEP);
    simulation.model.walls = [[Wall::Open; 2]; D];
    Simulation::resume(simulation.model, simulation.state)
}

/// Runs to an end. `still` tells at which times no motion is prescribed.
fn run_monitored<const D: usize>(
    simulation: &mut Simulation<D>,
    end: f64,
    still: impl Fn(f64) -> bool,
) -> Result<Vec<Check>, StepError> {
    let mut watch = ContactMonitor::new(&simulation.model, 1.0);
    let mut max_elastic_energy = 0f64;
    run_to(simulation, end, |s, report| {
        max_elastic_energy = max_elastic_energy.max(report.diagnostics.elastic_energy);
        // Prescribed velocities of the next step must vanish in the step before as well.
        let now = s.state.time;
        watch.observe(s, &report.diagnostics, still(now - 2.0 * STEP) && still(now + 2.0 * STEP));
    })?;
    let law = watch.law().largest / max_elastic_energy;
    Ok(vec![
        watch.check_gap(NAME, "narrowest gap / cell", DX, 1e-3),
        at_most(NAME, "deepest overlap / cell", watch.deepest_overlap / DX, bar(0.0)),
        at_least(
            NAME,
            "least volume of an element over that at rest",
            watch.least_element_volume,
            f64::MIN_POSITIVE,
            1e-2,
        ),
        at_most(NAME, "largest rise of the energy in a step / elastic", law, bars(1e-6, 1e-9)),
    ])
}

fn crush<const D: usize>(n: usize) -> Result<Vec<Check>, StepError>
where
    Simulation<D>: Compiled<D>,
{
    let ball = soft(
        mapped(quadratic_cube_mesh([n; D]), |x| cube_to_ball(x) * BALL_RADIUS),
        MATERIAL,
        FRICTION,
        Vec::new(),
    )?;
    let mut solids = vec![ball];
    // The plates start a fifth of a cell away and compress the ball to a fifth of its height.
    let (gap, way) = (0.2 * DX, 0.8 * BALL_RADIUS + 0.2 * DX);
    for side in [-1.0, 1.0] {
        let keyframes = vec![
            (0.0, up(0.0)),
            (PRESCRIBED_DURATION, up(-side * way)),
            (PRESCRIBED_DURATION + HOLD_DURATION, up(-side * way)),
            (PRESCRIBED_DURATION + 2.0 * HOLD_DURATION, up(0.5 * side)),
        ];
        solids.push(rigid_half_space(side * (BALL_RADIUS + gap), prescribed_motion(keyframes)));
    }
    let mut simulation = without_walls(solids);
    let end = PRESCRIBED_DURATION + 4.0 * HOLD_DURATION;
    let still = |t: f64| {
        t > PRESCRIBED_DURATION && t < PRESCRIBED_DURATION + HOLD_DURATION
            || t > PRESCRIBED_DURATION + 2.0 * HOLD_DURATION
    };
    let mut checks = run_monitored(&mut simulation, end, still)?;
    let height = |x: &[Vector<D>]| {
        let places = || x.iter().map(|x| x[D - 1]);
        places().fold(f64::NEG_INFINITY, f64::max) - places().fold(f64::INFINITY, f64::min)
    };
    let again = height(vertices(&simulation, 0)) / (2.0 * BALL_RADIUS);
    checks.push(Check::relative(NAME, "height after it was let go", again, 1.0, bars(0.03, 0.01)));
    Ok(checks)
}

fn slit<const D: usize>(n: [usize; D]) -> Result<Vec<Check>, StepError>
where
    Simulation<D>: Compiled<D>,
{
    const LONG: f64 = 1.2;
    const THICK: f64 = 0.2;
    const SLIT: f64 = 0.12;
    const POST: f64 = 0.25;
    // The head hangs through the slit and is narrower than it.
    let narrow = |y: f64| if y < -0.8 { 0.35 } else { (0.35 + 0.65 * (y + 0.8) / 0.3).min(1.0) };
    let place = |x: &Vector<D>| {
        let y = x[D - 1];
        Vector::from_fn(|a, _| match a {
            0 => 0.5 * THICK * x[0] * narrow(y),
            a if a + 1 == D => 0.5 * LONG * (y + 0.9),
            _ => 0.1 * x[a],
        })
    };
    let mesh = mapped(quadratic_cube_mesh(n), place);
    let head = -0.04 * LONG + 1e-9;
    let mut pulled = Anchor::within(&mesh, |x: &Vector<D>| x[D - 1] < head);
    let way = LONG + 1.0;
    pulled.motion = AnchorMotion::Keyframes(vec![(0.0, up(0.0)), (PRESCRIBED_DURATION, up(-way))]);
    let strip = soft(mesh, MATERIAL, FRICTION, vec![pulled])?;
    let mut solids = vec![strip];
    for side in [-1.0, 1.0] {
        let center = Vector::from_fn(|a, _| if a == 0 { side * (0.5 * SLIT + POST) } else { 0.0 });
        let shape = if D == 2 {
            Shape::Ball { center, radius: POST }
        } else {
            let axis = Vector::from_fn(|a, _| if a == 1 { 1.0 } else { 0.0 });
            Shape::Cylinder { center, axis, radius: POST, height: 0.6 }
        };
        solids.push(Solid::new(shape, SolidKind::Fixed, 1.0));
    }
    let mut simulation = without_walls(solids);
    let mut checks =
        run_monitored(&mut simulation, PRESCRIBED_DURATION + HOLD_DURATION, |t| t > PRESCRIBED_DURATION)?;
    let top = vertices(&simulation, 0).iter().map(|x| x[D - 1]).fold(f64::NEG_INFINITY, f64::max);
    checks.push(at_most(
        NAME,
        "upper end over the middle of the slit: it is through",
        top.max(0.0),
        bar(0.0),
    ));
    Ok(checks)
}

/// Motion of a vertex of a strip's end that is turned about the first axis and moved along it.
fn twist_keyframes(x: &Vector<3>, turns: f64, way: f64) -> AnchorMotion<3> {
    const FRAMES: usize = 96;
    let frame = |k: usize| {
        let part = k as f64 / FRAMES as f64;
        let (s, c) = (TAU * turns * part).sin_cos();
        let to = Vector::<3>::new(x[0] + way * part, c * x[1] - s * x[2], s * x[1] + c * x[2]);
        (PRESCRIBED_DURATION * part, to - x)
    };
    AnchorMotion::Keyframes((0..=FRAMES).map(frame).collect())
}

fn twist() -> Result<Vec<Check>, StepError> {
    let half = Vector::<3>::new(1.5, 0.2, 0.05);
    let mesh = mapped(quadratic_cube_mesh([48, 6, 2]), |x| x.component_mul(&half));
    let end = |side: f64| {
        let own = (0..mesh.positions.len()).filter(|v| mesh.positions[*v][0] * side > half[0] - 1e-9);
        let motion = |v: usize| twist_keyframes(&mesh.positions[v], 1.5 * side, -0.75 * side);
        own.map(|v| Anchor { vertices: vec![v as u32], motion: motion(v) }).collect::<Vec<_>>()
    };
    let anchors = [end(-1.0), end(1.0)].concat();
    let mut simulation = without_walls(vec![soft(mesh.clone(), MATERIAL, FRICTION, anchors)?]);
    run_monitored(&mut simulation, PRESCRIBED_DURATION + HOLD_DURATION, |t| t > PRESCRIBED_DURATION)
}

/// A ring about an axis: a bar of square section whose ends coincide.
fn ring(center: Vector<3>, upright: bool) -> VolumeMesh<3> {
    const AROUND: usize = 24;
    const WIDE: usize = 3;
    const RADIUS: f64 = 0.3;
    const HALF: f64 = 0.05;
    let layer = (WIDE + 1) * (WIDE + 1);
    // The last layer is identified with the first.
    let bar = cube_mesh([AROUND, WIDE, WIDE]);
    let own = |v: u32| (v as usize % (AROUND + 1), v as usize / (AROUND + 1));
    let number = |v: u32| {
        let (along, across) = own(v);
        ((along % AROUND) * layer + across) as u32
    };
    let mut positions = vec![Vector::zeros(); AROUND * layer];
    for v in 0..bar.positions.len() as u32 {
        let x = bar.positions[v as usize];
        let (s, c) = (TAU * 0.5 * (x[0] + 1.0)).sin_cos();
        let (r, off) = (RADIUS + HALF * x[1], HALF * x[2]);
        let local =
            Vector::<3>::new(r * c, if upright { off } else { r * s }, if upright { r * s } else { off });
        positions[number(v) as usize] = center + local;
    }
    let mut simplices = bar.simplices;
    for simplex in &mut simplices {
        (simplex.root, simplex.others) = (number(simplex.root), simplex.others.map(number));
        if simplex.volume(&positions) < 0.0 {
            simplex.others.swap(0, 1);
        }
    }
    VolumeMesh { positions, simplices }
}

fn chain() -> Result<Vec<Check>, StepError> {
    let mut solids = Vec::new();
    for k in 0..3 {
        let mesh = ring(Vector::<3>::new(0.4 * (k as f64 - 1.0), 0.0, 0.0), k == 1);
        // The outer halves of the outer rings have prescribed motion, away from each other.
        let side = k as f64 - 1.0;
        let mut outer = Anchor::within(&mesh, |x: &Vector<3>| side * x[0] > 0.66);
        outer.motion = AnchorMotion::Keyframes(vec![
            (0.0, Vector::zeros()),
            (PRESCRIBED_DURATION, Vector::<3>::new(0.35 * side, 0.0, 0.0)),
        ]);
        let anchors = if k == 1 { Vec::new() } else { vec![outer] };
        solids.push(soft(mesh, MATERIAL, FRICTION, anchors)?);
    }
    run_monitored(&mut without_walls(solids), PRESCRIBED_DURATION + HOLD_DURATION, |t| {
        t > PRESCRIBED_DURATION
    })
}
