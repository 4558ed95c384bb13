use super::geometry::Geometry;
use super::scheme::PaperScheme;
use super::state::PaperState;
use crate::model::Model;
use crate::paper::coupling::solver::Solver;
use crate::paper::fluid::cells::{Face, FaceType};
use crate::paper::fluid::fractions::phi_at_face;
use crate::paper::{Errata, LineImpulse, Tensions};
use crate::solid::{Solid, SolidKind};
use meniscus_numerics::Vector;
use meniscus_numerics::fit::Sphere;
use meniscus_numerics::grid::Grid;
use meniscus_numerics::shape::Shape;

const LIQUID_AIR: f64 = 1.0;
/// Half of the explicit capillary limit on 32 cells.
const DT: f64 = 1e-3;

fn tensions(degrees: f64) -> Tensions {
    let cosine = degrees.to_radians().cos();
    let [liquid_solid, solid_air] = [(-cosine).max(0.0), cosine.max(0.0)];
    Tensions { liquid_air: LIQUID_AIR, liquid_solid, solid_air }
}

const NO_TENSIONS: Tensions = Tensions { liquid_air: 0.0, liquid_solid: 0.0, solid_air: 0.0 };

fn floor<const D: usize>() -> Solid<D> {
    let (mut point, mut normal) = (Vector::zeros(), Vector::zeros());
    (point[1], normal[1]) = (0.26, 1.0);
    Solid::new(Shape::HalfSpace { point, normal }, SolidKind::Fixed, 1.0)
}

/// Half a ball of liquid on a floor.
fn on_a_floor<const D: usize>(n: usize, degrees: f64) -> (PaperScheme<D>, PaperState<D>) {
    let grid = Grid::new([n; D], 1.0 / n as f64);
    let scheme = PaperScheme::new(Model::of_test(grid, vec![floor()]), Some(tensions(degrees)));
    let mut middle = Vector::<D>::repeat(0.5);
    middle[1] = 0.26;
    let state = scheme.start(&|x| (x - middle).norm() - 0.22, &Vector::zeros());
    (scheme, state)
}

/// Half the width of the line.
fn reach<const D: usize>(state: &PaperState<D>) -> f64 {
    state.line.iter().map(|[x, _]| (x[0] - 0.5).abs()).sum::<f64>() / state.line.len() as f64
}

#[test]
fn a_drop_in_free_fall_has_the_velocity_of_gravity() {
    let mut model = Model::of_test(Grid::<2>::new([32; 2], 1.0 / 32.0), Vec::new());
    model.gravity = Vector::from([0.3, -2.0]);
    let scheme = PaperScheme::new(model, Some(NO_TENSIONS));
    let drop = |x: &Vector<2>| (x - Vector::from([0.5, 0.6])).norm() - 0.2;
    let mut state = scheme.start(&drop, &Vector::from([0.1, 0.0]));
    for _ in 0..40 {
        scheme.step(&mut state, DT).unwrap();
    }
    let faces = [17 + 33 * 18, 17 + 32 * 18];
    let exact = [0.1 + 0.3 * 0.04, -2.0 * 0.04];
    for axis in 0..2 {
        let u = state.velocity.axes[axis][faces[axis]];
        assert!((u - exact[axis]).abs() < 1e-3, "{axis}: {u} {}", exact[axis]);
    }
    let drift = scheme.liquid_volume(&state) / state.target_volume - 1.0;
    assert!(drift.abs() < 2e-3, "{drift}");
}

/// Growth of the half width of a drop on a floor at 45 and at 135 degrees.
fn growth_of_width<const D: usize>(n: usize, steps: usize) -> [f64; 2] {
    [45.0, 135.0].map(|degrees| {
        let (scheme, mut state) = on_a_floor::<D>(n, degrees);
        let (mut start, mut report) = (0.0, None);
        for step in 0..steps {
            report = Some(scheme.step(&mut state, DT * (32.0 / n as f64).powf(1.5)).unwrap());
            if step == 0 {
                start = reach(&state);
            }
        }
        let report = report.unwrap();
        let volume = scheme.liquid_volume(&state) / state.target_volume - 1.0;
        println!("{D}D, {degrees}: from {start:.4} to {:.4}, volume {volume:.1e}, {report:?}", reach(&state));
        assert!(report.particles >= 2 && report.degenerate == 0, "{report:?}");
        assert!(volume.abs() < 0.02, "{volume}");
        reach(&state) - start
    })
}

#[test]
fn a_drop_draws_together_on_a_hydrophobic_floor_and_far_less_on_a_hydrophilic_one() {
    let [wide, narrow] = growth_of_width::<2>(32, 60);
    assert!(narrow < 0.0 && narrow < wide - 0.02, "{wide} {narrow}");
}

#[test]
fn a_drop_spreads_on_a_hydrophilic_floor() {
    let [wide, _] = growth_of_width::<2>(32, 60);
    assert!(wide > 0.0, "{wide}");
}

/// A drop that has come to rest on a floor.
#[derive(Debug)]
struct Rest {
    /// Angle of the circle through its surface more than 1.5 cells above the floor, degrees.
    angle: f64,
    /// Radius of the circle over that of the drop of its volume with Young's angle.
    radius: f64,
    /// Half the width of the line, over that of the same drop.
    width: f64,
    /// Change of the volume.
    volume: f64,
    /// Largest velocity component of a liquid's face, m/s.
    speed: f64,
}

/// From half a ball to rest in a time, s.
fn rest(n: usize, degrees: f64, errata: Errata, time: f64) -> Rest {
    let (mut scheme, _) = on_a_floor::<2>(n, degrees);
    scheme.errata = errata;
    let viscosity = std::env::var("PAPER_VISCOSITY").ok().and_then(|t| t.parse().ok());
    scheme.model.kinematic_viscosity = viscosity.unwrap_or(0.15);
    let young = degrees.to_radians();
    let drop = (0.5 * std::f64::consts::PI * 0.22f64.powi(2) / (young - young.sin() * young.cos())).sqrt();
    let (middle, radius) = match std::env::var("PAPER_START").is_ok() {
        true => (Vector::from([0.5, 0.26 - drop * young.cos()]), drop),
        false => (Vector::from([0.5, 0.26]), 0.22),
    };
    let mut state = scheme.start(&|x| (x - middle).norm() - radius, &Vector::zeros());
    let dt = DT * (32.0 / n as f64).powf(1.5);
    let steps = (time / dt).ceil() as usize;
    let show = std::env::var("PAPER_SHOW").is_ok();
    for step in 0..steps {
        let report = scheme.step(&mut state, dt).unwrap();
        if show && step % (steps / 20).max(1) == 0 {
            println!("{:.3} {:.4?} {}", state.time, measure(&scheme, &state, degrees), report.particles);
            let geometry = Geometry::new(&scheme, &state.solids, &state.phi);
            let lines = scheme.contact_lines(&geometry, &state.solids);
            for (x, f) in lines.positions.iter().zip(&lines.forces) {
                println!("  line {:.4} {:.4} force {:.4} {:.4}", x[0], x[1], f[0], f[1]);
            }
            for axis in 0..2 {
                let best = (0..state.velocity.axes[axis].len())
                    .filter(|i| {
                        matches!(
                            geometry.types.face(Face { axis, index: *i }),
                            FaceType::Liquid | FaceType::LiquidAir
                        )
                    })
                    .max_by(|i, j| {
                        state.velocity.axes[axis][*i].abs().total_cmp(&state.velocity.axes[axis][*j].abs())
                    })
                    .unwrap();
                let at = geometry.types.center(Face { axis, index: best });
                println!(
                    "  axis {axis}: {:.4} at {:.3} {:.3}",
                    state.velocity.axes[axis][best],
                    at[0] * n as f64,
                    at[1] * n as f64
                );
            }
            if std::env::var("PAPER_MAP").is_ok() {
                for row in state.phi.data.chunks(n).rev() {
                    println!("{}", row.iter().map(|v| if *v < 0.0 { '#' } else { '.' }).collect::<String>());
                }
            }
        }
    }
    measure(&scheme, &state, degrees)
}

fn measure(scheme: &PaperScheme<2>, state: &PaperState<2>, degrees: f64) -> Rest {
    let geometry = Geometry::new(scheme, &state.solids, &state.phi);
    let (grid, side) = (&scheme.model.grid, |_: &Vector<2>| (f64::INFINITY, Vector::zeros()));
    let phi = geometry.shape(scheme, &side).phi;
    let closest = |face: &Face| {
        let (value, slope) = phi_at_face(&phi, grid, *face);
        geometry.types.center(*face) - Vector::from(slope).normalize() * value
    };
    let points: Vec<(Vector<2>, f64)> = geometry
        .types
        .faces_of(FaceType::LiquidAir)
        .iter()
        .map(closest)
        .filter(|x| x[1] > 0.26 + 1.5 * grid.dx)
        .map(|x| (x, 1.0))
        .collect();
    let Some(circle) = Sphere::fit(&points) else {
        return Rest {
            angle: f64::NAN,
            radius: f64::NAN,
            width: f64::NAN,
            volume: f64::NAN,
            speed: f64::NAN,
        };
    };
    let floor = Vector::from([0.5, 0.26]);
    let young = degrees.to_radians();
    let exact = (state.target_volume / (young - young.sin() * young.cos())).sqrt();
    let moving = |face: &Face| matches!(geometry.types.face(*face), FaceType::Liquid | FaceType::LiquidAir);
    let faces =
        (0..2).flat_map(|axis| (0..state.velocity.axes[axis].len()).map(move |index| Face { axis, index }));
    let speed = faces.filter(moving).map(|f| state.velocity.axes[f.axis][f.index].abs()).fold(0.0, f64::max);
    Rest {
        angle: circle.angle_on_plane(&floor, &Vector::from([0.0, 1.0])),
        radius: circle.radius / exact,
        width: reach(state) / (exact * young.sin()),
        volume: scheme.volume(&geometry.phi) / state.target_volume - 1.0,
        speed,
    }
}

#[test]
#[ignore = "a measurement: set PAPER_CELLS, PAPER_ANGLES, PAPER_TIME and PAPER_ERRATA"]
fn angles_at_rest() {
    let number = |name: &str, or: f64| std::env::var(name).ok().and_then(|t| t.parse().ok()).unwrap_or(or);
    let mut errata = Errata::CORRECTED;
    for name in std::env::var("PAPER_ERRATA").unwrap_or_default().split(',') {
        match name {
            "printed" => errata = Errata::AS_PRINTED,
            "first" => errata = Errata::FIRST,
            "first_open" => errata = Errata { open_surface: true, exact_line: true, ..Errata::FIRST },
            "owned" => errata.free_faces = false,
            "byfaces" => errata.line_impulse = LineImpulse::ByFaces,
            "fit" => errata.tangent_at_line = false,
            "offset" => errata.exact_line = false,
            "sampled" => errata.balanced_force = false,
            "closed" => (errata.open_surface, errata.exact_line) = (false, false),
            _ => {}
        }
    }
    let angles = std::env::var("PAPER_ANGLES").unwrap_or("45,60,90,120,135".into());
    for degrees in angles.split(',').map(|t| t.parse::<f64>().unwrap()) {
        let clock = std::time::Instant::now();
        let rest = rest(number("PAPER_CELLS", 32.0) as usize, degrees, errata, number("PAPER_TIME", 0.6));
        println!("{degrees}: {rest:.4?} in {:.1} s", clock.elapsed().as_secs_f64());
    }
}

#[test]
fn both_solvers_give_the_same_step() {
    let step = |solver| {
        let (mut scheme, mut state) = on_a_floor::<2>(24, 60.0);
        scheme.solver = solver;
        scheme.limits.tolerance = 1e-11;
        for _ in 0..3 {
            scheme.step(&mut state, DT).unwrap();
        }
        state
    };
    let [one, other] = [Solver::ConjugateGradient, Solver::Minres].map(step);
    for (a, b) in one.velocity.axes.iter().flatten().zip(other.velocity.axes.iter().flatten()) {
        assert!((a - b).abs() < 1e-6, "{a} {b}");
    }
}

#[test]
fn a_free_ball_in_a_drop_falls_with_it_as_printed_and_corrected() {
    for errata in [Errata::CORRECTED, Errata::AS_PRINTED] {
        let shape = Shape::Ball { center: Vector::<2>::from([0.5, 0.72]), radius: 0.1 };
        let mut model =
            Model::of_test(Grid::new([32; 2], 1.0 / 32.0), vec![Solid::new(shape, SolidKind::Rigid, 1.0)]);
        model.gravity = Vector::from([0.0, -2.0]);
        let mut scheme = PaperScheme::new(model, Some(NO_TENSIONS));
        scheme.errata = errata;
        let mut state = scheme.start(&|x| (x - Vector::from([0.5, 0.55])).norm() - 0.2, &Vector::zeros());
        for _ in 0..20 {
            let report = scheme.step(&mut state, DT).unwrap();
            assert_eq!((report.particles, report.degenerate), (2, 0), "{errata:?}");
        }
        let ball = state.solids[0].as_rigid();
        println!("{errata:?}: {} {}", ball.velocity, ball.center);
        assert!((ball.velocity - Vector::from([0.0, -0.04])).norm() < 2e-3, "{}", ball.velocity);
        assert!((ball.center - Vector::from([0.5, 0.72 - 0.0004])).norm() < 1e-4, "{}", ball.center);
    }
}

/// A free ball of the liquid's density at the surface of a drop that meets it at 90 degrees: circles (spheres) that cross at right angles,
/// at rest. Its largest speed in a time, s, along the axis.
fn ball_at_rest<const D: usize>(n: usize, errata: Errata, time: f64) -> [f64; 2] {
    let (radius, drop, dt) = (0.12, 0.22, DT * (32.0 / n as f64).powf(1.5));
    let (mut below, mut above) = (Vector::<D>::repeat(0.503), Vector::<D>::repeat(0.503));
    (below[1], above[1]) = (0.4, 0.4 + f64::hypot(radius, drop));
    let ball = Solid::new(Shape::Ball { center: above, radius }, SolidKind::Rigid, 1.0);
    let mut scheme =
        PaperScheme::new(Model::of_test(Grid::new([n; D], 1.0 / n as f64), vec![ball]), Some(tensions(90.0)));
    scheme.errata = errata;
    scheme.model.kinematic_viscosity = 0.05;
    let mut state = scheme.start(&|x| (x - below).norm() - drop, &Vector::zeros());
    let (mut first, mut most) = (0.0, 0.0f64);
    for step in 0..(time / dt).ceil() as usize {
        scheme.step(&mut state, dt).unwrap();
        let speed = state.solids[0].as_rigid().velocity.norm();
        most = most.max(speed);
        if step == 0 {
            first = speed / dt;
        }
    }
    println!("{D}D, {n}: first acceleration {first:.3}, velocity {}", state.solids[0].as_rigid().velocity);
    [first, most]
}

#[test]
#[ignore = "a measurement"]
fn free_balls_at_rest() {
    for errata in [Errata::FIRST, Errata::CORRECTED] {
        for n in [32, 64] {
            println!("{n}: {:.4?}", ball_at_rest::<2>(n, errata, 0.02));
        }
    }
}
