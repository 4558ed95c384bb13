//! Closed sides of the domain that wet.

#![allow(clippy::expect_used)]

use meniscus_numerics::Vector;
use meniscus_numerics::fit::Sphere;
use meniscus_numerics::grid::Grid;
use meniscus_numerics::shape::Shape;
use meniscus_sim::{
    Compiled, ContactLine, LineTracker, LiquidRegion, Model, Numerics, Simulation, Solid, SolidKind,
    SolidState, Wall,
};

/// A box of `size` with closed sides, `cells` cells a unit of length.
fn model<const D: usize>(cells: usize, size: Vector<D>) -> Model<D> {
    let count = size.map(|s| (s * cells as f64).round() as usize);
    Model {
        grid: Grid::new(std::array::from_fn(|a| count[a]), 1.0 / cells as f64),
        walls: [[Wall::Slip; 2]; D],
        density: 1.0,
        kinematic_viscosity: 0.3,
        surface_tension: 1.0,
        gravity: Vector::zeros(),
        solids: Vec::new(),
        numerics: Numerics::default(),
    }
}

/// The same, wetted at an angle (degrees).
fn walled<const D: usize>(cells: usize, size: Vector<D>, angle: f64) -> Model<D> {
    model(cells, size).with_wetting_walls(angle.to_radians().cos(), 0.0, None)
}

/// A ball of liquid, radius 1, as far as it is in the domain.
fn ball<const D: usize>(model: Model<D>, center: Vector<D>) -> Simulation<D>
where
    Simulation<D>: Compiled<D>,
{
    let distance = |x: &Vector<D>| (x - center).norm() - 1.0;
    Simulation::new(model, &[LiquidRegion { signed_distance: &distance, velocity: Vector::zeros() }])
}

fn settle<const D: usize>(sim: &mut Simulation<D>, time: f64) {
    while sim.state.time < time {
        sim.step(time - sim.state.time, &mut |_| ()).expect("a step");
    }
}

fn line<const D: usize>(sim: &Simulation<D>) -> ContactLine<D> {
    LineTracker::new(&sim.model, &[sim.model.grid.dx / 1.5]).extract(sim)
}

/// Where the surface crosses the lines between cell centres more than 1.5 cells from all sides.
fn surface<const D: usize>(sim: &Simulation<D>) -> Vec<Vector<D>> {
    let (grid, phi) = (sim.model.grid, &sim.state.phi.data);
    let lattice = grid.lattice();
    let mut points = Vec::new();
    for i in 0..lattice.len() {
        let at = lattice.coordinates(i);
        for a in (0..D).filter(|a| at[*a] + 1 < grid.cells[*a]) {
            let (here, next) = (phi[i], phi[i + lattice.stride[a]]);
            let mut x = grid.center(at);
            x[a] += grid.dx * here / (here - next);
            if (here < 0.0) != (next < 0.0) && x.min() > 1.5 * grid.dx {
                points.push(x);
            }
        }
    }
    points
}

#[test]
fn a_drop_on_a_wall_is_one_on_a_half_space() {
    for angle in [60.0f64, 120.0] {
        let (center, up) = (Vector::<2>::new(1.87, 0.0), Vector::<2>::new(0.0, 1.0));
        let mut on_wall = ball(walled(12, Vector::<2>::new(4.0, 2.5), angle), center);
        let mut solid = Solid::new(Shape::HalfSpace { point: up, normal: up }, SolidKind::Fixed, 1.0);
        solid.young_cosine = angle.to_radians().cos();
        let wide = Model { solids: vec![solid], ..model(12, Vector::<2>::new(4.0, 3.5)) };
        let mut on_solid = ball(wide, center + up);
        settle(&mut on_wall, 10.0);
        settle(&mut on_solid, 10.0);
        let (own, other) = (line(&on_wall), line(&on_solid));
        assert_eq!((own.points.len(), other.points.len()), (2, 2));
        for (p, q) in own.points.iter().zip(&other.points) {
            let off = (p.at - q.at + up).norm() / on_wall.model.grid.dx;
            println!(
                "{angle}: {:.3}, {off:.1e} cells and {:.1e} deg apart",
                p.angle_degrees,
                p.angle_degrees - q.angle_degrees
            );
            assert!(
                (p.angle_degrees - angle).abs() < 1.5
                    && (p.angle_degrees - q.angle_degrees).abs() < 0.05
                    && off < 0.01
            );
        }
    }
}

/// Settles a drop where sides meet; it must be part of a ball that meets all of them at the angle.
fn corner<const D: usize>(cells: usize, wide: f64, angle: f64, [bar, off]: [f64; 2])
where
    Simulation<D>: Compiled<D>,
{
    let middle = Vector::from_fn(|a, _| [0.31, 0.17, 0.05][a]);
    let mut sim = ball(walled(cells, Vector::<D>::repeat(wide), angle), middle);
    settle(&mut sim, 15.0);
    let points: Vec<(Vector<D>, f64)> = surface(&sim).into_iter().map(|x| (x, 1.0)).collect();
    let fit = Sphere::fit(&points).expect("a ball");
    let along = |a: usize| Vector::from_fn(|b, _| if a == b { 1.0 } else { 0.0 });
    let angles: Vec<f64> = (0..D).map(|a| fit.angle_on_plane(&Vector::zeros(), &along(a))).collect();
    let rough = points.iter().map(|(x, _)| ((x - fit.center).norm() - fit.radius).abs()).fold(0.0, f64::max);
    let (mean, spread) = line(&sim).angle_statistics(Some(0)).expect("a line");
    println!(
        "{D}D, {angle}: {angles:.2?}, {:.3} cells off a ball, on the line {mean:.2} ± {spread:.2}, speed {:.1e}",
        rough * cells as f64,
        sim.diagnostics().max_speed
    );
    assert!(angles.iter().all(|x| (x - angle).abs() < bar) && rough * (cells as f64) < off);
    assert!((mean - angle).abs() < 2.0);
}

#[test]
fn a_drop_where_walls_meet_is_part_of_a_ball() {
    corner::<2>(12, 3.0, 60.0, [1.0, 0.05]);
    corner::<2>(12, 3.0, 120.0, [1.5, 0.05]);
    corner::<3>(8, 2.0, 75.0, [1.5, 0.05]);
    // What a mirror does: an octant.
    corner::<3>(8, 1.75, 89.99, [1.0, 0.05]);
}

#[test]
fn sides_without_an_angle_of_their_own_stay_mirrors() {
    let open = Model { walls: [[Wall::Open; 2]; 2], ..model(8, Vector::<2>::repeat(2.0)) };
    let same = open.clone().with_wetting_walls(0.5, 0.0, None);
    assert_eq!((same.grid, same.solids.len(), same.wetting_wall_solid()), (open.grid, 0, None));
    let half = Model { walls: [[Wall::Slip, Wall::Open]; 2], ..open };
    let half = half.with_wetting_walls(0.5, 0.0, None);
    assert_eq!((half.grid.domain_cells(), half.grid.domain_upper()), ([16; 2], Vector::<2>::repeat(2.0)));
    assert_eq!(
        (half.grid.margin_cells, half.grid.cells),
        (
            [[meniscus_sim::WETTING_WALL_MARGIN_CELLS, 0]; 2],
            [16 + meniscus_sim::WETTING_WALL_MARGIN_CELLS; 2]
        )
    );
}

/// Where a free ball is that falls, and bounces off the floor and the sides beside a puddle; `angle` none: mirrors.
fn thrown(angle: Option<f64>) -> SolidState<2> {
    let size = Vector::<2>::new(6.0, 3.0);
    let mut model = model(8, size);
    model.gravity[1] = -1.0;
    model.numerics.fixed_step = Some(0.02);
    let shape = Shape::Ball { center: Vector::<2>::new(4.5, 2.0), radius: 0.5 };
    let mut thrown = Solid::new(shape, SolidKind::Rigid, 1.0);
    thrown.initial_velocity = Vector::<2>::new(0.7, 0.0);
    model.solids.push(thrown);
    let model = match angle {
        Some(angle) => model.with_wetting_walls(angle.to_radians().cos(), 0.0, None),
        None => model,
    };
    let mut sim = ball(model, Vector::<2>::new(1.2, 0.0));
    settle(&mut sim, 4.0);
    sim.state.solids[0].clone()
}

#[test]
fn solids_run_into_walls_that_wet_as_into_others() {
    let [mirror, wet] = [None, Some(70.0)].map(|angle| thrown(angle).as_rigid());
    println!("{} {}", mirror.center, wet.center);
    assert!((mirror.center - wet.center).norm() < 1e-12 && (mirror.velocity - wet.velocity).norm() < 1e-12);
    assert!(mirror.center[1] < 1.0, "it never fell");
}

#[test]
fn a_bath_climbs_its_walls_and_rests() {
    let mut tank = walled(8, Vector::<2>::new(10.0, 3.5), 45.0);
    tank.gravity[1] = -1.0;
    tank.kinematic_viscosity = 1.0;
    let distance = |x: &Vector<2>| x[1] - 1.71;
    let mut sim =
        Simulation::new(tank, &[LiquidRegion { signed_distance: &distance, velocity: Vector::zeros() }]);
    settle(&mut sim, 15.0);
    let line = line(&sim);
    let higher = (line.points[0].at[1] - line.points[1].at[1]).abs();
    println!(
        "{:?}, speed {:.1e}",
        line.points.iter().map(|p| (p.at[1], p.angle_degrees)).collect::<Vec<_>>(),
        sim.diagnostics().max_speed
    );
    // A meniscus holds cos θ lc² of liquid, which the level lacks.
    let height = line.points[0].at[1] - 1.71 + 2.0 * 0.5f64.sqrt() / 10.0;
    let should = (2.0 - 2.0f64.sqrt()).sqrt();
    assert!((height / should - 1.0).abs() < 0.04 && higher < 0.01, "{height} {should}");
    assert!(sim.diagnostics().max_speed < 0.02);
}
