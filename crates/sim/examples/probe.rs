//! Sessile drops (scratch).
use meniscus_numerics::grid::{Grid, Sampler};
use meniscus_numerics::shape::Shape;
use meniscus_numerics::Vector;
use meniscus_sim::*;

fn arg(name: &str, default: f64) -> f64 { std::env::var(name).ok().and_then(|v| v.parse().ok()).unwrap_or(default) }

fn run<const D: usize>() {
    let theta = arg("THETA", 60.0).to_radians();
    let r = arg("R", 16.0);
    let offset = arg("OFFSET", 0.0);
    let tilt = arg("TILT", 0.0).to_radians();
    let az = if D == 3 { arg("AZ", 30.0).to_radians() } else { 0.0 };
    let size = arg("SIZE", 4.0);
    let n = (size * r) as usize;
    let dx = 1.0 / r; // radius of the half ball is 1
    let grid = Grid::<D>::new(std::array::from_fn(|a| if a + 1 == D { (size * r * 0.75) as usize } else { n }), dx);
    let mut normal = Vector::<D>::zeros();
    normal[D - 1] = tilt.cos();
    normal[0] += tilt.sin() * az.cos();
    if D == 3 { normal[1] += tilt.sin() * az.sin(); }
    let mut point = Vector::<D>::repeat(0.5 * size);
    point[D - 1] = (6.0 + offset) * dx + if tilt > 0.0 { 0.5 * size * tilt.tan() * 0.6 } else { 0.0 };
    let mut plate = Solid::new(Shape::HalfSpace { point, normal }, Motion::Fixed, 1.0);
    plate.cosine = theta.cos();
    let model = Model {
        grid, walls: [[Wall::Slip; 2]; D], density: 1.0, kinematic_viscosity: arg("NU", 0.0), surface_tension: 1.0,
        gravity: Vector::zeros(), solids: vec![plate],
        numerics: Numerics { capillary_step: arg("CAP", 5.0), ..Numerics::default() },
    };
    let (rad, c) = if arg("INIT", 0.0) > 0.0 {
        let (s, c) = theta.sin_cos();
        let rad = if D == 2 { (0.5 * std::f64::consts::PI / (theta - s * c)).sqrt() } else { (2.0 / (2.0 - 3.0 * c + c * c * c)).cbrt() };
        (rad, point - normal * (rad * c))
    } else { (1.0, point) };
    let d = |x: &Vector<D>| (x - c).norm() - rad;
    let mut sim = Simulation::new(model, &[Body { distance: &d, velocity: Vector::zeros() }]);
    let v0 = sim.ledger().volume;
    let t_end = arg("T", 12.0);
    let drag = arg("DRAG", 2.0);
    let mut next = 0.0;
    let mut angles = Vec::new();
    while sim.state.time < t_end {
        let report = match sim.step(f64::INFINITY, &mut |_| ()) { Ok(r) => r, Err(e) => { println!("FAIL {e}"); return; } };
        let keep = (-drag * report.dt).exp();
        if drag > 0.0 { for a in 0..D { sim.state.velocity.axes[a].iter_mut().for_each(|u| *u *= keep); } }
        if sim.state.time >= next {
            next += t_end / arg("LINES", 12.0);
            let (angle, rad, res) = fit(&sim, &point, &normal);
            angles.push(angle);
            let l = sim.ledger();
            println!("t {:.3} step {} dt {:.2e} angle {:.2} R {:.3} res {:.1e} urms {:.2e} umax {:.2e} vol {:.1e} drops {} it {} E {:.5} redone {}",
                sim.state.time, sim.state.step, report.dt, angle, rad, res, (2.0 * l.kinetic_energy / l.volume).sqrt(), l.max_speed, l.volume / v0 - 1.0, sim.state.drops.len(), report.iterations, l.surface_energy, report.redone);
        }
    }
}

/// Sphere fit to crossings more than 1.5 dx above the plane; angle from the centre's height.
fn fit<const D: usize>(sim: &Simulation<D>, point: &Vector<D>, normal: &Vector<D>) -> (f64, f64, f64) {
    let grid = sim.model.grid;
    let lattice = grid.lattice();
    let _s = Sampler::cells(&grid, &sim.state.phi.data, sim.model.scalar_edges());
    let mut pts = Vec::new();
    for c in 0..lattice.len() {
        let at = lattice.coordinates(c);
        for a in 0..D {
            if at[a] + 1 >= lattice.extent[a] { continue; }
            let (p, q) = (sim.state.phi.data[c], sim.state.phi.data[c + lattice.stride[a]]);
            if (p < 0.0) != (q < 0.0) {
                let mut x = grid.center(at);
                x[a] += grid.dx * p / (p - q);
                if (x - point).dot(normal) > 1.5 * grid.dx { pts.push(x); }
            }
        }
    }
    // |x|^2 = 2 c.x + k
    let m = D + 1;
    let mut ata = vec![vec![0.0; m + 1]; m];
    for x in &pts {
        let y = x - point;
        let row: Vec<f64> = (0..D).map(|a| 2.0 * y[a]).chain([1.0]).collect();
        let b = y.norm_squared();
        for i in 0..m { for j in 0..m { ata[i][j] += row[i] * row[j]; } ata[i][m] += row[i] * b; }
    }
    for i in 0..m {
        let p = (i..m).max_by(|a, b| ata[*a][i].abs().total_cmp(&ata[*b][i].abs())).unwrap();
        ata.swap(i, p);
        for j in 0..m { if j != i { let f = ata[j][i] / ata[i][i]; for k in i..=m { ata[j][k] -= f * ata[i][k]; } } }
    }
    let s: Vec<f64> = (0..m).map(|i| ata[i][m] / ata[i][i]).collect();
    let c = Vector::<D>::from_fn(|a, _| s[a]);
    let r = (s[D] + c.norm_squared()).sqrt();
    let res = (pts.iter().map(|x| ((x - point - c).norm() - r).powi(2)).sum::<f64>() / pts.len() as f64).sqrt();
    let h = c.dot(normal);
    ((-h / r).clamp(-1.0, 1.0).acos().to_degrees(), r, res / grid.dx)
}

fn main() { if arg("DIM", 2.0) == 3.0 { run::<3>() } else { run::<2>() } }
