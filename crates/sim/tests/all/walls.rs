//! Closed sides of the domain that wet.

#![allow(clippy::expect_used)]

use meniscus_numerics::grid::{Grid, Sampler};
use meniscus_numerics::shape::Shape;
use meniscus_numerics::{Matrix, Vector};
use meniscus_sim::{Body, ContactLine, LineTracker, Model, Motion, Numerics, Simulation, Solid, Wall};

/// A box of `size` with closed sides, `cells` cells a unit of length.
fn model<const D: usize>(cells: usize, size: Vector<D>) -> Model<D> {
    let count = size.map(|s| (s * cells as f64).round() as usize);
    Model {
        grid: Grid::new(std::array::from_fn(|a| count[a]), 1.0 / cells as f64),
        walls: [[Wall::Slip; 2]; D],
        density: 1.0,
        kinematic_viscosity: 1.5,
        surface_tension: 1.0,
        gravity: Vector::zeros(),
        solids: Vec::new(),
        numerics: Numerics::default(),
    }
}

/// A ball of liquid, radius 1, as far as it is in the domain.
fn ball<const D: usize>(model: Model<D>, center: Vector<D>) -> Simulation<D> {
    let distance = |x: &Vector<D>| (x - center).norm() - 1.0;
    Simulation::new(model, &[Body { distance: &distance, velocity: Vector::zeros() }])
}

fn settle<const D: usize>(sim: &mut Simulation<D>, time: f64) {
    while sim.state.time < time {
        sim.step(time - sim.state.time, &mut |_| ()).expect("a step");
    }
}

fn line<const D: usize>(sim: &Simulation<D>) -> ContactLine<D> {
    LineTracker::new(&sim.model, &[sim.model.grid.dx / 1.5]).find(sim)
}

#[test]
fn a_drop_on_a_wall_is_one_on_a_half_space() {
    for degrees in [60.0f64, 120.0] {
        let cosine = degrees.to_radians().cos();
        let (center, up) = (Vector::<2>::new(1.87, 0.0), Vector::<2>::new(0.0, 1.0));
        let walled = model(12, Vector::<2>::new(4.0, 2.5)).with_wetting_walls(cosine, 0.0, None);
        let mut walled = ball(walled, center);
        let mut solid = Solid::new(Shape::HalfSpace { point: up, normal: up }, Motion::Fixed, 1.0);
        solid.cosine = cosine;
        let wide = Model { solids: vec![solid], ..model(12, Vector::<2>::new(4.0, 3.5)) };
        let mut on_solid = ball(wide, center + up);
        settle(&mut walled, 10.0);
        settle(&mut on_solid, 10.0);
        let (own, other) = (line(&walled), line(&on_solid));
        println!("{degrees}: {:?} {:?}", own.angle(Some(0)), other.angle(Some(0)));
        for (p, q) in own.points.iter().zip(&other.points) {
            println!("   {:e} {:e}", (p.at - q.at + up).norm(), p.angle - q.angle);
        }
    }
}

#[test]
fn a_drop_in_a_corner() {
    for (degrees, nu) in [(60.0f64, 0.3), (89.999, 0.3), (120.0, 0.3)] {
        let cosine = degrees.to_radians().cos();
        let mut model = model(12, Vector::<2>::new(3.5, 3.5)).with_wetting_walls(cosine, 0.0, None);
        model.kinematic_viscosity = nu;
        let mut sim = ball(model, Vector::<2>::new(0.7, 0.7));
        settle(&mut sim, 20.0);
        let book = sim.ledger();
        println!("{degrees} {nu}: {:?} speed {:.2e} ", line(&sim).points.iter().map(|p| (p.angle, p.at)).collect::<Vec<_>>(), book.max_speed);
    }
}

/// Where the surface crosses the lines between cell centres outside solids.
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
            if (here < 0.0) != (next < 0.0) && sim.distance_to_solids(&x) > 0.0 {
                points.push(x);
            }
        }
    }
    points
}

#[test]
fn a_drop_where_three_walls_meet_is_part_of_a_ball() {
    for (degrees, cells, nu) in [(75.0f64, 8, 0.3), (75.0, 8, 0.05), (75.0, 16, 0.3), (105.0, 8, 0.3)] {
        let cosine = degrees.to_radians().cos();
        let model = model(cells, Vector::<3>::repeat(1.75)).with_wetting_walls(cosine, 0.0, None);
        let mut sim = ball(model, Vector::<3>::new(0.31, 0.17, 0.05));
        sim.model.kinematic_viscosity = nu;
        settle(&mut sim, 12.0);
        let points: Vec<_> = surface(&sim).into_iter().filter(|x| x.min() > 1.5 * sim.model.grid.dx).collect();
        // |x|² = 2 c·x + k
        let mut matrix = nalgebra::DMatrix::<f64>::zeros(4, 4);
        let mut rhs = nalgebra::DVector::<f64>::zeros(4);
        for x in &points {
            let row = nalgebra::DVector::from_vec(vec![2.0 * x[0], 2.0 * x[1], 2.0 * x[2], 1.0]);
            matrix += &row * row.transpose();
            rhs += row * x.norm_squared();
        }
        let fit = matrix.lu().solve(&rhs).expect("a fit");
        let c = Vector::<3>::new(fit[0], fit[1], fit[2]);
        let radius = (fit[3] + c.norm_squared()).sqrt();
        let off = points.iter().map(|x| ((x - c).norm() - radius).abs()).fold(0.0, f64::max);
        println!("{degrees} {cells} {nu}: implied {:.2} centre {c:?} should {:.4}, radius {radius}, off {:.4} cells, {} points, speed {:.2e}, angle {:?} length {:?}", (-c.mean() / radius).acos().to_degrees(), -radius * cosine, off / sim.model.grid.dx, points.len(), sim.ledger().max_speed, line(&sim).angle(None), line(&sim).length());
    }
}
