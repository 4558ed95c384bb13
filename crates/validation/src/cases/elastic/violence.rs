//! Soft solids that are treated badly: twisted, crushed, pulled through a slit, chained.
//!
//! Without liquid. What must hold is what the method promises whatever happens: surfaces never cross (IPC), elements never turn
//! inside out, and where nothing is led any more the energy does not rise in any step.

use crate::dry::{Material, Watch, dry, lattice, led, mapped, plate, quadratic, round, soft, vertices};
use crate::measure::{at_least, at_most, settle};
use crate::setup::run_to;
use crate::{Case, Check, Mode};
use meniscus_elastic::{Anchor, Motion as Led};
use meniscus_numerics::Vector;
use meniscus_numerics::mesh::VolumeMesh;
use meniscus_numerics::shape::Shape;
use meniscus_sim::{Motion, Simulation, Solid, StepError, Wall};
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
    run: |mode| settle(NAME, run(mode)),
};

const NAME: &str = "violence";
const DX: f64 = 1.0 / 24.0;
const STEP: f64 = 5e-3;
/// When what is led comes to its end, and how long it is held there.
const LED: f64 = 1.0;
const HELD: f64 = 0.25;
const BALL: f64 = 0.3;

fn run(mode: Mode) -> Result<Vec<Check>, StepError> {
    let mut checks = tell("crushed ball, 2D", crush::<2>(16));
    checks.extend(tell("slit, 2D", slit::<2>([8, 40])));
    if mode == Mode::Full {
        checks.extend(tell("crushed ball, 3D", crush::<3>(8)));
        checks.extend(tell("slit, 3D", slit::<3>([6, 2, 30])));
        checks.extend(tell("twisted strip, 3D", twist()));
        checks.extend(tell("linked rings, 3D", chain()));
    }
    Ok(checks)
}

/// The checks of a part, which may break off without the others.
fn tell(part: &str, checks: Result<Vec<Check>, StepError>) -> Vec<Check> {
    let of = |check: Check| Check { quantity: format!("{part}: {}", check.quantity), ..check };
    settle(NAME, checks).into_iter().map(of).collect()
}

fn material() -> Material {
    Material { young: 1000.0, poisson: 0.4, density: 2.0, damping: 0.1, friction: 0.3 }
}

/// Without sides.
fn open<const D: usize>(solids: Vec<Solid<D>>) -> Simulation<D> {
    let mut simulation = dry(([8; D], DX), solids, Vector::zeros(), STEP);
    simulation.model.walls = [[Wall::Open; 2]; D];
    Simulation::resume(simulation.model, simulation.state)
}

/// Runs to an end; between `held` times nothing is led.
fn watched<const D: usize>(
    simulation: &mut Simulation<D>,
    end: f64,
    still: impl Fn(f64) -> bool,
) -> Result<Vec<Check>, StepError> {
    let mut watch = Watch::new(&simulation.model, 1.0);
    let mut most = 0f64;
    run_to(simulation, end, |s, report| {
        most = most.max(report.ledger.elastic_energy);
        // What is told its velocity for the coming step may not be moving in the one before, either.
        let now = s.state.time;
        watch.look(s, &report.ledger, still(now - 2.0 * STEP) && still(now + 2.0 * STEP));
    })?;
    let law = watch.law().largest / most;
    Ok(vec![
        at_least(NAME, "narrowest gap / cell", watch.gap / DX, f64::MIN_POSITIVE, 1e-3),
        at_most(NAME, "deepest overlap / cell", watch.overlap / DX, 0.0, None, ""),
        at_least(
            NAME,
            "least volume of an element over that at rest",
            watch.element,
            f64::MIN_POSITIVE,
            1e-2,
        ),
        at_most(NAME, "largest rise of the energy in a step / elastic", law, 1e-6, Some(1e-9), ""),
    ])
}

/// A direction along the last axis.
fn up<const D: usize>(y: f64) -> Vector<D> {
    Vector::from_fn(|a, _| if a + 1 == D { y } else { 0.0 })
}

fn crush<const D: usize>(n: usize) -> Result<Vec<Check>, StepError> {
    let ball = soft(mapped(quadratic([n; D]), |x| round(x) * BALL), material(), Vec::new())?;
    let mut solids = vec![ball];
    // To a fifth of the height between the plates, which are a fifth of a cell away at the start.
    let (gap, way) = (0.2 * DX, 0.8 * BALL + 0.2 * DX);
    for side in [-1.0, 1.0] {
        let keyframes = vec![
            (0.0, up(0.0)),
            (LED, up(-side * way)),
            (LED + HELD, up(-side * way)),
            (LED + 2.0 * HELD, up(0.5 * side)),
        ];
        solids.push(plate(side * (BALL + gap), led(keyframes)));
    }
    let mut simulation = open(solids);
    let end = LED + 4.0 * HELD;
    let still = |t: f64| t > LED && t < LED + HELD || t > LED + 2.0 * HELD;
    let mut checks = watched(&mut simulation, end, still)?;
    let height = |x: &[Vector<D>]| {
        let places = || x.iter().map(|x| x[D - 1]);
        places().fold(f64::NEG_INFINITY, f64::max) - places().fold(f64::INFINITY, f64::min)
    };
    let again = height(vertices(&simulation, 0)) / (2.0 * BALL);
    checks.push(Check::relative(NAME, "height after it was let go", again, 1.0, 0.03, Some(0.01), ""));
    Ok(checks)
}

fn slit<const D: usize>(n: [usize; D]) -> Result<Vec<Check>, StepError> {
    const LONG: f64 = 1.2;
    const THICK: f64 = 0.2;
    const SLIT: f64 = 0.12;
    const POST: f64 = 0.25;
    // The head hangs through the slit, and is narrower than that.
    let narrow = |y: f64| if y < -0.8 { 0.35 } else { (0.35 + 0.65 * (y + 0.8) / 0.3).min(1.0) };
    let place = |x: &Vector<D>| {
        let y = x[D - 1];
        Vector::from_fn(|a, _| match a {
            0 => 0.5 * THICK * x[0] * narrow(y),
            a if a + 1 == D => 0.5 * LONG * (y + 0.9),
            _ => 0.1 * x[a],
        })
    };
    let mesh = mapped(quadratic(n), place);
    let head = -0.04 * LONG + 1e-9;
    let mut pulled = Anchor::within(&mesh, |x: &Vector<D>| x[D - 1] < head);
    let way = LONG + 1.0;
    pulled.motion = Led::Keyframes(vec![(0.0, up(0.0)), (LED, up(-way))]);
    let strip = soft(mesh, material(), vec![pulled])?;
    let mut solids = vec![strip];
    for side in [-1.0, 1.0] {
        let center = Vector::from_fn(|a, _| if a == 0 { side * (0.5 * SLIT + POST) } else { 0.0 });
        let shape = if D == 2 {
            Shape::Ball { center, radius: POST }
        } else {
            let axis = Vector::from_fn(|a, _| if a == 1 { 1.0 } else { 0.0 });
            Shape::Cylinder { center, axis, radius: POST, height: 0.6 }
        };
        solids.push(Solid::new(shape, Motion::Fixed, 1.0));
    }
    let mut simulation = open(solids);
    let mut checks = watched(&mut simulation, LED + HELD, |t| t > LED)?;
    let top = vertices(&simulation, 0).iter().map(|x| x[D - 1]).fold(f64::NEG_INFINITY, f64::max);
    checks.push(at_most(
        NAME,
        "upper end over the middle of the slit: it is through",
        top.max(0.0),
        0.0,
        None,
        "",
    ));
    Ok(checks)
}

/// The way of a vertex whose end of a strip is turned about the first axis and moved along it.
fn turned(x: &Vector<3>, turns: f64, way: f64) -> Led<3> {
    const FRAMES: usize = 96;
    let frame = |k: usize| {
        let part = k as f64 / FRAMES as f64;
        let (s, c) = (TAU * turns * part).sin_cos();
        let to = Vector::<3>::new(x[0] + way * part, c * x[1] - s * x[2], s * x[1] + c * x[2]);
        (LED * part, to - x)
    };
    Led::Keyframes((0..=FRAMES).map(frame).collect())
}

fn twist() -> Result<Vec<Check>, StepError> {
    let half = Vector::<3>::new(1.5, 0.2, 0.05);
    let mesh = mapped(quadratic([48, 6, 2]), |x| x.component_mul(&half));
    let end = |side: f64| {
        let own = (0..mesh.positions.len()).filter(|v| mesh.positions[*v][0] * side > half[0] - 1e-9);
        let motion = |v: usize| turned(&mesh.positions[v], 1.5 * side, -0.75 * side);
        own.map(|v| Anchor { vertices: vec![v as u32], motion: motion(v) }).collect::<Vec<_>>()
    };
    let anchors = [end(-1.0), end(1.0)].concat();
    let mut simulation = open(vec![soft(mesh.clone(), material(), anchors)?]);
    watched(&mut simulation, LED + HELD, |t| t > LED)
}

/// A ring about an axis: a bar of square section whose ends are one.
fn ring(center: Vector<3>, upright: bool) -> VolumeMesh<3> {
    const AROUND: usize = 24;
    const WIDE: usize = 3;
    const RADIUS: f64 = 0.3;
    const HALF: f64 = 0.05;
    let layer = (WIDE + 1) * (WIDE + 1);
    // The last layer is the first one.
    let bar = lattice([AROUND, WIDE, WIDE]);
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
        (simplex.root, simplex.rest) = (number(simplex.root), simplex.rest.map(number));
        if simplex.volume(&positions) < 0.0 {
            simplex.rest.swap(0, 1);
        }
    }
    VolumeMesh { positions, simplices }
}

fn chain() -> Result<Vec<Check>, StepError> {
    let mut solids = Vec::new();
    for k in 0..3 {
        let mesh = ring(Vector::<3>::new(0.4 * (k as f64 - 1.0), 0.0, 0.0), k == 1);
        // The outer halves of the outer rings' ends are led, to both sides.
        let side = k as f64 - 1.0;
        let mut outer = Anchor::within(&mesh, |x: &Vector<3>| side * x[0] > 0.66);
        outer.motion =
            Led::Keyframes(vec![(0.0, Vector::zeros()), (LED, Vector::<3>::new(0.35 * side, 0.0, 0.0))]);
        let anchors = if k == 1 { Vec::new() } else { vec![outer] };
        solids.push(soft(mesh, material(), anchors)?);
    }
    watched(&mut open(solids), LED + HELD, |t| t > LED)
}
