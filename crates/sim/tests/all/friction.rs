//! Friction from step to step: what rests does not creep, what slides does so as Coulomb says.

use crate::soft::collide::{DX, GRAVITY, down, dry, lattice, mapped, run, soft};
use meniscus_numerics::shape::Shape;
use meniscus_numerics::{Matrix, Vector};
use meniscus_sim::{Compiled, Simulation, Solid, SolidKind};

const ALPHA: f64 = 0.4;
const HALF: f64 = 0.08;

/// A block on a slope, and the direction down it. The block lies where the barrier begins to press.
fn slope<const D: usize>(rigid: bool, friction: f64, step: f64) -> (Simulation<D>, Vector<D>)
where
    Simulation<D>: Compiled<D>,
{
    let turn = Matrix::<D>::from_fn(|r, c| match (r, c) {
        (0, 0) => ALPHA.cos(),
        (0, c) if c + 1 == D => ALPHA.sin(),
        (r, 0) if r + 1 == D => -ALPHA.sin(),
        (r, c) if r + 1 == D && c + 1 == D => ALPHA.cos(),
        (r, c) => f64::from(u8::from(r == c)),
    });
    let (normal, point) = (turn.column(D - 1).into_owned(), Vector::repeat(0.3));
    let middle = point + normal * (HALF + 0.2 * DX);
    let mut floor = Solid::new(Shape::HalfSpace { point, normal }, SolidKind::Fixed, 1.0);
    let mut block = if rigid {
        let shape = Shape::Box { center: middle, half_size: Vector::repeat(HALF), rotation: turn };
        Solid::new(shape, SolidKind::Rigid, 2.0)
    } else {
        soft(mapped(lattice([4; D]), |x: &Vector<D>| middle + turn * x * HALF), 1e4, 0.3, Vec::new())
    };
    (floor.friction, block.friction, block.restitution) = (friction, friction, 0.0);
    (dry(vec![floor, block], down(), step), turn.column(0).into_owned())
}

/// Creep of a block that friction holds, in a number of steps, over its side.
fn creep<const D: usize>(rigid: bool, step: f64)
where
    Simulation<D>: Compiled<D>,
{
    let (mut simulation, along) = slope::<D>(rigid, 0.6, step);
    let place = |s: &Simulation<D>| s.state.solids[1].center_of_mass().dot(&along);
    // By then blocks have stopped rocking from their fall on the barrier.
    run(&mut simulation, 2.0, |_| ());
    let start = place(&simulation);
    run(&mut simulation, 2.1, |_| ());
    let creep = (place(&simulation) - start) / (2.0 * HALF);
    println!("{D}D rigid {rigid}, steps of {step:.1e}: creep {creep:.2e} in 0.1 s");
    assert!(creep.abs() < 1e-5, "{D}D rigid {rigid}, steps of {step}: {creep}");
}

#[test]
fn what_friction_holds_stays() {
    creep::<2>(false, 1e-3);
}

#[test]
fn rigid_ones_stay_with_steps_of_any_length() {
    for step in [2e-3, 5e-4] {
        creep::<2>(true, step);
    }
    creep::<3>(true, 2e-3);
}

/// A rigid block slides as Coulomb says, once it no longer rocks from its fall on the barrier.
fn slides<const D: usize>(friction: f64)
where
    Simulation<D>: Compiled<D>,
{
    let (mut simulation, along) = slope::<D>(true, friction, 1e-3);
    let speed = |s: &Simulation<D>| s.state.solids[1].velocity().dot(&along);
    run(&mut simulation, 0.25, |_| ());
    let start = speed(&simulation);
    run(&mut simulation, 0.35, |_| ());
    let gained = speed(&simulation) - start;
    let expected = GRAVITY * (ALPHA.sin() - friction * ALPHA.cos()) * 0.1;
    println!("{D}D friction {friction}: {gained:.5} for {expected:.5} m/s");
    assert!((gained / expected - 1.0).abs() < 0.01, "{D}D friction {friction}: {gained} for {expected}");
}

#[test]
fn a_rigid_block_slides_as_coulomb_says() {
    for friction in [0.0, 0.2, 0.35] {
        slides::<2>(friction);
    }
    slides::<3>(0.2);
}

/// A rigid ball on a soft slab that gravity is aslant to: friction makes it roll, about the slab's surface, from which the barrier keeps
/// its own away.
#[test]
fn a_ball_rolls_on_a_soft_slab() {
    let mesh =
        crate::soft::collide::block::<2>([24, 4], Vector::from([0.5, 0.3]), Vector::from([0.45, 0.05]));
    let held = meniscus_elastic::Anchor::within(&mesh, |x: &Vector<2>| x[1] < 0.26);
    let mut slab = soft(mesh, 1e5, 0.3, vec![held]);
    let reach = 0.25 * DX;
    let (center, radius) = (Vector::from([0.2, 0.45 + reach]), 0.1);
    let mut ball = Solid::new(Shape::Ball { center, radius }, SolidKind::Rigid, 2.0);
    (slab.friction, ball.friction, ball.restitution) = (0.6, 0.6, 0.0);
    let gravity = Vector::from([GRAVITY * ALPHA.sin(), -GRAVITY * ALPHA.cos()]);
    let mut simulation = dry::<2>(vec![slab, ball], gravity, 1e-3);
    run(&mut simulation, 0.3, |_| ());
    let now = simulation.state.solids[1].as_rigid();
    let rolling = now.velocity[0] / -now.angular_velocity[2];
    let expected = 0.5 * GRAVITY * ALPHA.sin() / (1.0 + 0.5 * (radius / rolling).powi(2)) * 0.09;
    let way = now.center[0] - center[0];
    println!("ball on a slab: {way:.5} for {expected:.5}, rolling radius {rolling:.5} of {radius}");
    assert!((way / expected - 1.0).abs() < 0.02, "{way} for {expected}");
    assert!(rolling > radius && rolling < radius + reach, "{rolling}");
}
