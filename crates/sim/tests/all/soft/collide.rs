//! What solids that deform run into: each other, themselves, rigid solids and the sides of the domain, without liquid.

#![allow(clippy::expect_used)]

use meniscus_elastic::{Anchor, ConstitutiveLaw, Elastic, ElasticSpecification, ElementOrder};
use meniscus_numerics::grid::Grid;
use meniscus_numerics::mesh::{Simplex, VolumeMesh};
use meniscus_numerics::shape::Shape;
use meniscus_numerics::{Matrix, Vector};
use meniscus_sim::{Compiled, Model, Numerics, PrescribedMotion, Simulation, Solid, SolidKind, Wall};
use std::sync::Arc;

pub const GRAVITY: f64 = 10.0;
const CELLS: usize = 24;
pub const DX: f64 = 1.0 / CELLS as f64;
pub const DENSITY: f64 = 2.0;

/// Blocks of simplices whose diagonals point away from the middle, between -1 and 1.
pub fn lattice<const D: usize>(n: [usize; D]) -> VolumeMesh<D> {
    let id = |at: &[usize; D]| (0..D).rev().fold(0, |k, a| k * (n[a] + 1) + at[a]);
    let count: usize = n.iter().map(|n| n + 1).product();
    let place = |mut k: usize| {
        Vector::<D>::from_fn(|a, _| {
            let i = k % (n[a] + 1);
            k /= n[a] + 1;
            2.0 * i as f64 / n[a] as f64 - 1.0
        })
    };
    let positions: Vec<Vector<D>> = (0..count).map(place).collect();
    let orders: &[[usize; 3]] = if D == 2 {
        &[[0, 1, 2], [1, 0, 2]]
    } else {
        &[[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]]
    };
    let mut simplices = Vec::new();
    for mut cell in 0..n.iter().product() {
        let low: [usize; D] = std::array::from_fn(|a| {
            let i = cell % n[a];
            cell /= n[a];
            i
        });
        let mirrored: [bool; D] = std::array::from_fn(|a| 2 * low[a] + 1 < n[a]);
        let start: [usize; D] = std::array::from_fn(|a| low[a] + usize::from(mirrored[a]));
        for order in orders {
            let mut at = start;
            let others = std::array::from_fn(|k| {
                let a = order[k];
                at[a] = if mirrored[a] { low[a] } else { low[a] + 1 };
                id(&at) as u32
            });
            let mut simplex = Simplex { root: id(&start) as u32, others };
            if simplex.volume(&positions) < 0.0 {
                simplex.others.swap(0, 1);
            }
            simplices.push(simplex);
        }
    }
    VolumeMesh { positions, simplices }
}

pub fn mapped<const D: usize>(
    mut mesh: VolumeMesh<D>,
    map: impl Fn(&Vector<D>) -> Vector<D>,
) -> VolumeMesh<D> {
    mesh.positions.iter_mut().for_each(|x| *x = map(x));
    mesh
}

pub fn ball<const D: usize>(n: usize, center: Vector<D>, radius: f64) -> VolumeMesh<D> {
    let round = |x: &Vector<D>| {
        let (long, norm) = (x.amax(), x.norm());
        center + if norm > 0.0 { x * (radius * long / norm) } else { Vector::zeros() }
    };
    mapped(lattice([n; D]), round)
}

pub fn block<const D: usize>(n: [usize; D], center: Vector<D>, half: Vector<D>) -> VolumeMesh<D> {
    mapped(lattice(n), |x| center + x.component_mul(&half))
}

pub fn soft<const D: usize>(
    mesh: VolumeMesh<D>,
    young_modulus: f64,
    damping: f64,
    anchors: Vec<Anchor<D>>,
) -> Solid<D> {
    let low = mesh.positions.iter().fold(Vector::repeat(1e9), |l: Vector<D>, x| l.inf(x));
    let high = mesh.positions.iter().fold(Vector::repeat(-1e9), |l: Vector<D>, x| l.sup(x));
    let law = ConstitutiveLaw::neo_hookean(young_modulus, 0.3, ElementOrder::Linear);
    let description = ElasticSpecification { mesh, density: DENSITY, law, damping_ratio: damping, anchors };
    let elastic = Elastic::new(description).expect("a solid");
    let shape = Shape::Box {
        center: (low + high) * 0.5,
        half_size: (high - low) * 0.5,
        rotation: Matrix::identity(),
    };
    let mass: f64 = elastic.masses().iter().sum();
    let mut solid = Solid::new(shape, SolidKind::Deformable(Arc::new(elastic)), DENSITY);
    solid.mass_properties.mass = mass;
    solid
}

pub fn rigid<const D: usize>(center: Vector<D>, half_size: Vector<D>, kind: SolidKind<D>) -> Solid<D> {
    Solid::new(Shape::Box { center, half_size, rotation: Matrix::identity() }, kind, DENSITY)
}

pub fn dry<const D: usize>(solids: Vec<Solid<D>>, gravity: Vector<D>, max_step: f64) -> Simulation<D>
where
    Simulation<D>: Compiled<D>,
{
    let model = Model {
        grid: Grid::new([CELLS; D], DX),
        walls: [[Wall::Slip; 2]; D],
        density: 1.0,
        kinematic_viscosity: 0.0,
        surface_tension: 0.0,
        gravity,
        solids,
        numerics: Numerics { max_step, ..Numerics::default() },
    };
    assert_eq!(meniscus_sim::initial_overlaps(&model), []);
    Simulation::new(model, &[])
}

pub fn run<const D: usize>(simulation: &mut Simulation<D>, time: f64, mut each: impl FnMut(&Simulation<D>)) {
    while simulation.state.time < time * (1.0 - 1e-12) {
        simulation.step(time - simulation.state.time, &mut |_| ()).expect("a step");
        each(simulation);
    }
}

pub fn down<const D: usize>() -> Vector<D> {
    Vector::from_fn(|a, _| if a + 1 == D { -GRAVITY } else { 0.0 })
}

pub fn at<const D: usize>(first: f64, last: f64) -> Vector<D> {
    Vector::from_fn(|a, _| {
        if a == 0 {
            first
        } else if a + 1 == D {
            last
        } else {
            0.5
        }
    })
}

pub fn places<const D: usize>(s: &Simulation<D>, solid: usize) -> &[Vector<D>] {
    &s.state.solids[solid].as_deformable().expect("a soft solid").vertices.positions
}

/// Momentum and angular momentum about the middle of the domain, of all solids that nothing holds.
pub fn books<const D: usize>(s: &Simulation<D>) -> (Vector<D>, Vector<3>) {
    let three = |v: &Vector<D>| Vector::<3>::from_fn(|a, _| if a < D { v[a] } else { 0.0 });
    let mut sum = (Vector::zeros(), Vector::zeros());
    for (solid, now) in s.model.solids.iter().zip(&s.state.solids) {
        if let Some((elastic, body)) = solid.elastic().zip(now.as_deformable()) {
            sum.0 += elastic.momentum(&body.vertices);
            sum.1 += Vector::from(elastic.angular_momentum(&body.vertices));
        } else if solid.kind.is_free_rigid() {
            let rigid = now.as_rigid();
            sum.0 += rigid.velocity * solid.mass_properties.mass;
            sum.1 += solid.angular_momentum(&rigid)
                + three(&rigid.center).cross(&three(&rigid.velocity)) * solid.mass_properties.mass;
        }
    }
    sum
}

/// How deep vertices of solids are in others that deform or are rigid, or outside of the domain, at most, m.
pub fn depth<const D: usize>(s: &Simulation<D>) -> f64 {
    let mut worst = f64::NEG_INFINITY;
    for (i, solid) in s.solids().iter().enumerate() {
        let Some(body) = solid.state.as_deformable() else { continue };
        for x in &body.vertices.positions {
            worst = (0..D).map(|a| (-x[a]).max(x[a] - 1.0)).fold(worst, f64::max);
            let others = s.solids().iter().enumerate().filter(|(j, _)| *j != i);
            worst = others.map(|(_, other)| -other.distance(x)).fold(worst, f64::max);
        }
    }
    meniscus_sim::overlaps(s.solids()).iter().map(|o| o.2).fold(worst, f64::max)
}

fn drops<const D: usize>(n: usize, step: f64)
where
    Simulation<D>: Compiled<D>,
{
    let mesh = ball::<D>(n, at(0.5, 0.32), 0.15);
    let mut simulation = dry::<D>(vec![soft(mesh, 4e3, 0.02, Vec::new())], down(), step);
    let (mut worst, mut highest, mut hit) = (f64::NEG_INFINITY, 0.0f64, false);
    run(&mut simulation, 0.5, |s| {
        worst = worst.max(depth(s));
        let now = &s.state.solids[0];
        hit |= now.velocity()[D - 1] > 0.0;
        if hit {
            highest = highest.max(now.center_of_mass()[D - 1]);
        }
    });
    println!("{D}D drop: height {:.3} of 0.17, depth {:.2e} dx", highest - 0.15, worst / DX);
    assert!(worst < 0.0, "{D}D: {worst}");
    assert!(hit);
}

#[test]
fn a_soft_ball_bounces() {
    drops::<2>(8, 1e-3);
    drops::<2>(8, 1.0);
    drops::<3>(4, 4e-3);
}

fn rests<const D: usize>(n: usize, young: f64)
where
    Simulation<D>: Compiled<D>,
{
    let mesh = ball::<D>(n, at(0.5, 0.1525), 0.15);
    let mut simulation = dry::<D>(vec![soft(mesh, young, 1.0, Vec::new())], down(), 2e-3);
    let mut held = Vec::new();
    run(&mut simulation, 1.5, |s| {
        assert!(depth(s) < 0.0, "{}", depth(s));
        if s.state.time > 1.0 {
            held.push(s.state.solids[0].contact_acceleration[D - 1] / GRAVITY);
        }
    });
    let now = &simulation.state.solids[0];
    let weight = held.iter().sum::<f64>() / held.len() as f64;
    let speed = simulation.model.solids[0].max_speed(now);
    println!("{D}D rest: force over weight {weight:.6}, speed {speed:.2e}");
    assert!((weight - 1.0).abs() < 5e-3, "{D}D: {weight}");
    assert!(speed < 2e-3, "{D}D: {speed}");
}

#[test]
fn a_soft_ball_rests_with_its_weight() {
    rests::<2>(16, 400.0);
    rests::<3>(6, 100.0);
}

/// The change of the angular momentum, over the balls' momentum and radius.
fn meet<const D: usize>(n: usize, offset: f64, young: f64, friction: f64, step: f64) -> f64
where
    Simulation<D>: Compiled<D>,
{
    let (one, other) = (ball::<D>(n, at(0.3, 0.5), 0.15), ball::<D>(n, at(0.7, 0.5 + offset), 0.15));
    let mut solids = vec![soft(one, young, 0.0, Vec::new()), soft(other, young, 0.0, Vec::new())];
    solids[0].initial_velocity[0] = 1.0;
    solids[1].initial_velocity[0] = -0.5;
    solids.iter_mut().for_each(|s| s.friction = friction);
    let mut simulation = dry::<D>(solids, Vector::zeros(), step);
    let start = books(&simulation);
    let (mut worst, mut wrong, mut spun) = (f64::NEG_INFINITY, 0.0f64, 0.0f64);
    run(&mut simulation, 0.25, |s| {
        let now = books(s);
        worst = worst.max(depth(s));
        wrong = wrong.max((now.0 - start.0).norm() / start.0.norm());
        spun = spun.max((now.1 - start.1).norm() / (0.15 * start.0.norm()));
    });
    println!(
        "{D}D {offset} E {young:e}: depth {:.2e} dx, momentum {wrong:.1e}, angular {spun:.1e}",
        worst / DX
    );
    assert!(worst < 0.0, "{D}D: {worst}");
    assert!(wrong < 1e-12, "{D}D: {wrong}");
    spun
}

/// A contact pushes along the line between two points where they are at the end of the coming step, `a = 1.25 h`. Two that pass each
/// other at a speed `v` have moved by `a v` until then, which makes an angular momentum of `a v` times the push: first order in the
/// step. Friction acts across the gap between them, less than the barrier's reach `d`, which makes `μ d` times the push.
#[test]
fn soft_balls_meet() {
    // They pass at 1.5 times the sine of the line between their centres, 0.13/0.3, and a full rebound pushes with three times the
    // momentum of both.
    let bound =
        |step: f64, friction: f64| 3.0 * (1.25 * step * 1.5 * 0.13 / 0.3 + friction * 0.25 * DX) / 0.15;
    for young in [50.0, 1e3, 1e6] {
        meet::<2>(8, 0.0, young, 0.3, 2e-3);
        for (friction, step) in [(0.0, 2e-3), (0.0, 5e-4), (0.3, 2e-3), (0.3, 5e-4)] {
            let spun = meet::<2>(8, 0.13, young, friction, step);
            assert!(spun < bound(step, friction), "E {young:e}, friction {friction}, step {step}: {spun}");
        }
    }
    for offset in [0.0, 0.13] {
        let spun = meet::<3>(4, offset, 1e3, 0.3, 2e-3);
        assert!(spun < bound(2e-3, 0.3), "3D: {spun}");
    }
}

/// The weight of a block on an incline, and how far it gets.
fn slides<const D: usize>(friction: f64)
where
    Simulation<D>: Compiled<D>,
{
    let alpha = 0.4f64;
    let turned = |x: f64, y: f64| {
        let mut v = Vector::<D>::zeros();
        (v[0], v[D - 1]) = (alpha.cos() * x + alpha.sin() * y, alpha.cos() * y - alpha.sin() * x);
        v
    };
    let (normal, along) = (turned(0.0, 1.0), turned(1.0, 0.0));
    let point = Vector::repeat(0.3);
    let mut floor = Solid::new(Shape::HalfSpace { point, normal }, SolidKind::Fixed, 1.0);
    let (half, low) = (0.08, 0.05 * DX);
    let middle = at(0.25, 0.0);
    let middle = middle + normal * (half + low + (point - middle).dot(&normal));
    let place = |x: &Vector<D>| {
        let mut y = turned(x[0] * half, x[D - 1] * half);
        if D == 3 {
            y[1] = x[1] * half;
        }
        middle + y
    };
    let mut block = soft(mapped(lattice([4; D]), place), 1e4, 0.3, Vec::new());
    (floor.friction, block.friction) = (friction, friction);
    let mut simulation = dry::<D>(vec![floor, block], down(), 1e-3);
    let sticks = friction > alpha.tan();
    // What sticks slips a little as it falls upon the floor.
    let mut from = middle;
    run(&mut simulation, 0.3, |s| {
        assert!(depth(s) < 0.0);
        if sticks && s.state.time < 0.1 {
            from = s.state.solids[1].center_of_mass();
        }
    });
    let way = (simulation.state.solids[1].center_of_mass() - from).dot(&along);
    let expected = 0.5 * GRAVITY * (alpha.sin() - friction * alpha.cos()).max(0.0) * 0.09;
    println!("{D}D incline {friction}: {way:.5} for {expected:.5}");
    assert!(
        (way - expected).abs() < 0.01 * expected + 2e-4,
        "{D}D friction {friction}: {way} for {expected}"
    );
}

#[test]
fn a_soft_block_slides_or_sticks_on_an_incline() {
    for friction in [0.0, 0.2, 0.6] {
        slides::<2>(friction);
    }
    slides::<3>(0.2);
}

/// With no gap at the start but for rounding, on a floor that ends under the block.
fn stands<const D: usize>()
where
    Simulation<D>: Compiled<D>,
{
    let floor = rigid(at(0.5, 0.25), Vector::repeat(0.125), SolidKind::Fixed);
    let mesh =
        block([4; D], at(0.5, 0.5 + 1e-12), Vector::from_fn(|a, _| if a + 1 == D { 0.125 } else { 0.1875 }));
    let mut simulation = dry::<D>(vec![floor, soft(mesh, 1e4, 0.3, Vec::new())], down(), 1e-3);
    let (start, mut worst) = (simulation.state.solids[1].center_of_mass(), f64::NEG_INFINITY);
    run(&mut simulation, 0.1, |s| worst = worst.max(depth(s)));
    let way = (simulation.state.solids[1].center_of_mass() - start).norm();
    println!("{D}D stands: depth {:.2e} dx, way {:.2e} dx", worst / DX, way / DX);
    // It neither sinks in nor is thrown up by more than the least reach of a barrier at the start, 0.1 of 0.25 cells (where points of
    // the floor pushed its facets it was, by 0.03 cells in 2D and 0.14 in 3D). What is no overlap in a scene is 0.01 cells.
    assert!(worst < 0.01 * DX && way < 0.025 * DX, "{D}D: {worst} {way}");
}

#[test]
fn a_soft_block_stands_on_a_rigid_floor_without_a_gap() {
    stands::<2>();
    stands::<3>();
}

fn ball_on_beam<const D: usize>(n: [usize; D], half: Vector<D>)
where
    Simulation<D>: Compiled<D>,
{
    let mesh = block(n, at(0.5, 0.3), half);
    let ends = Anchor::within(&mesh, |x: &Vector<D>| (x[0] - 0.5).abs() > half[0] - 1e-9);
    let beam = soft(mesh, 2e5, 0.05, vec![ends]);
    let center = at(0.45, 0.55);
    let ball = Solid::new(Shape::Ball { center, radius: 0.12 }, SolidKind::Rigid, DENSITY);
    let mut simulation = dry::<D>(vec![beam, ball], down(), 5e-3);
    let (mut worst, mut lowest) = (f64::NEG_INFINITY, 1.0f64);
    run(&mut simulation, 0.6, |s| {
        worst = worst.max(depth(s));
        lowest = lowest.min(s.state.solids[1].center_of_mass()[D - 1]);
    });
    println!("{D}D beam: depth {:.2e} dx, lowest {lowest:.3}", worst / DX);
    assert!(worst < 0.0, "{D}D: {worst}");
    // It touches the beam at rest at 0.45, and rests on it within the barrier's reach.
    assert!(lowest > 0.2 && lowest < 0.45 + 0.25 * DX, "{D}D: {lowest}");
}

#[test]
fn a_rigid_ball_falls_on_a_soft_beam() {
    ball_on_beam::<2>([24, 2], Vector::from([0.42, 0.02]));
    ball_on_beam::<3>([12, 6, 2], Vector::from([0.42, 0.2, 0.03]));
}

fn squeezed<const D: usize>(n: [usize; D])
where
    Simulation<D>: Compiled<D>,
{
    let mut half = Vector::repeat(0.2);
    half[D - 1] = 0.06;
    let flat = Vector::from_fn(|a, _| if a + 1 == D { 0.04 } else { 0.35 });
    let plate = soft(block(n, at(0.5, 0.36), half), 1e3, 0.1, Vec::new());
    let floor = rigid(at(0.5, 0.25), flat, SolidKind::Fixed);
    let path = PrescribedMotion {
        velocity: Vector::zeros(),
        angular_velocity: [0.0; 3],
        keyframes: vec![(0.0, Vector::zeros()), (0.3, at::<D>(0.0, -0.075) - (at::<D>(0.0, 0.0)))],
    };
    let lid = rigid(at(0.5, 0.48), flat, SolidKind::Prescribed(path));
    let mut simulation = dry::<D>(vec![floor, plate, lid], Vector::zeros(), 5e-3);
    let mut worst = f64::NEG_INFINITY;
    run(&mut simulation, 0.5, |s| worst = worst.max(depth(s)));
    let speed = simulation.model.solids[1].max_speed(&simulation.state.solids[1]);
    println!("{D}D squeezed: depth {:.2e} dx, speed {speed:.1e}", worst / DX);
    assert!(worst < 0.0, "{D}D: {worst}");
    assert!(speed < 0.05, "{D}D: {speed}");
}

#[test]
fn a_soft_plate_is_squeezed() {
    squeezed::<2>([12, 4]);
    squeezed::<3>([6, 6, 2]);
}

/// Two solids of one mesh at one place: no vertex of one is inside the other.
fn same_place<const D: usize>()
where
    Simulation<D>: Compiled<D>,
{
    let solid = || soft(block([4; D], Vector::repeat(0.5), Vector::repeat(0.1)), 1e3, 0.0, Vec::new());
    let model = Model { solids: vec![solid(), solid()], ..dry(Vec::new(), Vector::zeros(), 1.0).model };
    let deepest = meniscus_sim::initial_overlaps(&model).iter().map(|o| o.2).fold(0.0, f64::max);
    assert!(deepest > 0.05, "{D}D: {deepest}");
}

#[test]
fn solids_at_the_same_place_overlap() {
    same_place::<2>();
    same_place::<3>();
}
