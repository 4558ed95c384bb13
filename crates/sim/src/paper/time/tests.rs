use super::geometry::Geometry;
use super::scheme::PaperScheme;
use super::state::PaperState;
use crate::model::Model;
use crate::paper::coupling::solver::Solver;
use crate::paper::fluid::cells::{Face, FaceType};
use crate::paper::fluid::fractions::phi_at_face;
use crate::paper::{Errata, Tensions};
use crate::solid::{Solid, SolidKind};
use meniscus_elastic::{Anchor, ConstitutiveLaw, Elastic, ElasticSpecification, ElementOrder};
use meniscus_numerics::fit::Sphere;
use meniscus_numerics::grid::{Grid, Sampler};
use meniscus_numerics::mesh::VolumeMesh;
use meniscus_numerics::shape::Shape;
use meniscus_numerics::{Matrix, Vector};
use std::f64::consts::PI;
use std::sync::Arc;

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
        assert!(report.particles >= 2, "{report:?}");
        assert!(volume.abs() < 0.02, "{volume}");
        reach(&state) - start
    })
}

#[test]
fn a_drop_draws_together_on_a_hydrophobic_floor_and_spreads_on_a_hydrophilic_one() {
    let [wide, narrow] = growth_of_width::<2>(32, 60);
    assert!(narrow < 0.0 && wide > 0.0, "{wide} {narrow}");
}

#[test]
fn a_drop_in_space_does_the_same() {
    let [wide, narrow] = growth_of_width::<3>(20, 15);
    assert!(narrow < 0.0 && wide > 0.0, "{wide} {narrow}");
}

/// A drop that has come to rest on a floor.
#[derive(Debug)]
struct Rest {
    /// Angle of the circle through its surface more than 1.5 cells above the floor, degrees.
    angle: f64,
    /// Half the width of the line, over that of the drop of its volume with Young's angle.
    width: f64,
    /// Change of the volume.
    volume: f64,
    /// Largest velocity component of a face of the liquid, m/s.
    speed: f64,
}

/// A viscous drop of the volume of half a ball of 0.22 on a floor, after a time (s) from a start with a given angle, degrees.
fn rest(n: usize, [start, degrees]: [f64; 2], errata: Errata, time: f64) -> Rest {
    let (mut scheme, _) = on_a_floor::<2>(n, degrees);
    (scheme.errata, scheme.model.kinematic_viscosity) = (errata, 0.15);
    let mut state = drop_with_angle(&scheme, start);
    let dt = DT * (32.0 / n as f64).powf(1.5);
    for _ in 0..(time / dt).ceil() as usize {
        scheme.step(&mut state, dt).unwrap();
    }
    measure(&scheme, &state, degrees)
}

/// A drop of the area of half a ball of 0.22 that meets the floor with an angle, degrees.
fn drop_with_angle(scheme: &PaperScheme<2>, degrees: f64) -> PaperState<2> {
    let radius = drop_radius(0.5 * PI * 0.22f64.powi(2), degrees);
    let middle = Vector::from([0.5, 0.26 - radius * degrees.to_radians().cos()]);
    scheme.start(&|x| (x - middle).norm() - radius, &Vector::zeros())
}

/// Radius of the circle of a drop of an area on a flat floor.
fn drop_radius(area: f64, degrees: f64) -> f64 {
    let angle = degrees.to_radians();
    (area / (angle - angle.sin() * angle.cos())).sqrt()
}

fn measure(scheme: &PaperScheme<2>, state: &PaperState<2>, degrees: f64) -> Rest {
    let geometry = Geometry::new(scheme, &state.solids, &state.phi);
    let grid = &scheme.model.grid;
    let phi = Sampler::cells(grid, &geometry.surface.data, scheme.model.scalar_boundary());
    let closest = |face: &Face| {
        let (value, slope) = phi_at_face(&phi, grid, *face);
        geometry.types.center(*face) - Vector::from(slope).normalize() * value
    };
    let faces = geometry.types.faces_of(FaceType::LiquidAir);
    let high = faces.iter().map(closest).filter(|x| x[1] > 0.26 + 1.5 * grid.dx);
    let circle = Sphere::fit(&high.map(|x| (x, 1.0)).collect::<Vec<_>>()).unwrap();
    let of = |kind| geometry.types.faces_of(kind).into_iter();
    let moving = of(FaceType::Liquid).chain(of(FaceType::LiquidAir));
    Rest {
        angle: circle.angle_on_plane(&Vector::from([0.5, 0.26]), &Vector::from([0.0, 1.0])),
        width: reach(state) / (drop_radius(state.target_volume, degrees) * degrees.to_radians().sin()),
        volume: scheme.liquid_volume(state) / state.target_volume - 1.0,
        speed: moving.map(|f| state.velocity.axes[f.axis][f.index].abs()).fold(0.0, f64::max),
    }
}

#[test]
fn drops_keep_youngs_angle() {
    for degrees in [45.0, 60.0, 90.0, 120.0, 135.0] {
        let rest = rest(32, [degrees; 2], Errata::CORRECTED, 0.15);
        println!("{degrees}: {rest:.4?}");
        assert!((rest.angle - degrees).abs() < 5.0 && (rest.width - 1.0).abs() < 0.05, "{degrees}: {rest:?}");
        assert!(rest.volume.abs() < 2e-3 && rest.speed < 0.1, "{degrees}: {rest:?}");
    }
}

/// The ball's bottom below the floor is not continued once the line has left it; it came up as a film of air at 0.02 s.
#[test]
fn a_ball_that_a_floor_cuts_spreads_without_a_film_of_air() {
    let (mut scheme, _) = on_a_floor::<2>(38, 60.0);
    scheme.model.kinematic_viscosity = 0.08;
    let mut state = drop_with_angle(&scheme, 146.0);
    for _ in 0..60 {
        scheme.step(&mut state, 6e-4).unwrap();
        assert_eq!(state.line.len(), 2, "{} s", state.time);
    }
}

/// Deflection of the tip of a clamped beam under gravity, without liquid, after steps of 0.05 s, a sixteenth of the longest period and many
/// of the shortest.
fn tip_deflection(implicit_elasticity: bool) -> f64 {
    let (center, half_size) = (Vector::from([0.5, 0.5]), Vector::from([0.25, 0.03]));
    let mesh =
        VolumeMesh::of_box(&center, &half_size, &Matrix::identity(), 0.03, ElementOrder::Quadratic).unwrap();
    let anchors = vec![Anchor::within(&mesh, |x| x[0] < 0.2501)];
    let is_tip = |x: &Vector<2>| (x - Vector::from([0.75, 0.53])).norm() < 1e-9;
    let tip = mesh.positions.iter().position(is_tip).unwrap();
    let law = ConstitutiveLaw::corotated(1e3, 0.3, ElementOrder::Quadratic);
    let specification = ElasticSpecification { mesh, density: 1.0, law, damping_ratio: 0.0, anchors };
    let elastic = Arc::new(Elastic::new(specification).unwrap());
    let shape = Shape::Box { center, half_size, rotation: Matrix::identity() };
    let beam = Solid::new(shape, SolidKind::Deformable(elastic), 1.0);
    let mut model = Model::of_test(Grid::new([32; 2], 1.0 / 32.0), vec![beam]);
    model.gravity = Vector::from([0.0, -1.0]);
    let mut scheme = PaperScheme::new(model, Some(NO_TENSIONS));
    scheme.errata.implicit_elasticity = implicit_elasticity;
    let mut state = scheme.start(&|_| 1.0, &Vector::zeros());
    let deflection =
        |state: &PaperState<2>| 0.53 - state.solids[0].as_deformable().unwrap().vertices.positions[tip][1];
    for _ in 0..100 {
        if deflection(&state).abs() > 1.0 || scheme.step(&mut state, 0.05).is_err() {
            return f64::INFINITY;
        }
    }
    deflection(&state)
}

#[test]
fn a_beam_comes_to_rest_where_gravity_bends_it_in_long_steps() {
    // Euler and Bernoulli: ρ g L⁴ (1 − ν²) / (E h²) · 3/2 in plane strain.
    let exact = 1.5 * 0.5f64.powi(4) * 0.91 / (1e3 * 0.06f64.powi(2));
    let [implicit, explicit] = [true, false].map(tip_deflection);
    println!("{implicit} {explicit} {exact}");
    // Shear adds, and the large deflection takes away, some tenths of a per cent.
    assert!((implicit / exact - 1.0).abs() < 0.01, "{implicit} {exact}");
    assert!(explicit.is_infinite(), "explicit elasticity should be unstable: {explicit}");
}

/// `PAPER_CELLS`, `PAPER_ANGLES` (start/Young, comma), `PAPER_TIME` and `PAPER_ERRATA` choose what is measured.
#[test]
#[ignore = "a measurement"]
fn angles_at_rest() {
    let text = |name: &str, or: &str| std::env::var(name).unwrap_or(or.to_string());
    let number = |text: &str| text.parse::<f64>().unwrap();
    let mut errata = Errata::CORRECTED;
    for name in text("PAPER_ERRATA", "").split(',') {
        match name {
            "printed" => errata = Errata::AS_PRINTED,
            "first" => errata = Errata::FIRST,
            "owned" => errata.free_faces = false,
            "fit" => errata.tangent_at_line = false,
            "offset" => errata.exact_line = false,
            "sampled" => errata.balanced_force = false,
            "held" => errata.slip = false,
            _ => {}
        }
    }
    for pair in text("PAPER_ANGLES", "90/45,90/60,90/90,90/120,90/135").split(',') {
        let angles = pair.split('/').map(number).collect::<Vec<_>>();
        let cells = number(&text("PAPER_CELLS", "32")) as usize;
        let rest = rest(cells, [angles[0], angles[1]], errata, number(&text("PAPER_TIME", "0.6")));
        println!("{pair}: {rest:.4?}");
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
fn a_free_ball_in_balance_with_a_drop_stays_nearly_at_rest() {
    let [_, speed] = ball_at_rest::<2>(32, Errata::CORRECTED, 0.01);
    assert!(speed < 0.06, "{speed}");
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

/// Mean velocity along a wall that is tilted by 45 degrees of half a ball without tension that gravity drives
/// along it, over that of free fall.
fn slide(errata: Errata) -> f64 {
    let (along, normal) = (Vector::<2>::from([1.0, 1.0]).normalize(), Vector::from([-1.0, 1.0]).normalize());
    let middle = Vector::from([0.45, 0.4]);
    let wall = Solid::new(Shape::HalfSpace { point: middle, normal }, SolidKind::Fixed, 1.0);
    let grid = Grid::new([32; 2], 1.0 / 32.0);
    let mut scheme = PaperScheme::new(Model::of_test(grid, vec![wall]), Some(NO_TENSIONS));
    (scheme.errata, scheme.model.gravity, scheme.model.kinematic_viscosity) = (errata, along * 2.0, 0.05);
    scheme.contact_line = false;
    let mut state = scheme.start(&|x| (x - middle).norm() - 0.22, &Vector::zeros());
    for _ in 0..50 {
        scheme.step(&mut state, DT).unwrap();
    }
    let types = Geometry::new(&scheme, &state.solids, &state.phi).types;
    let mean = |axis: usize| {
        let faces = types.faces_of(FaceType::Liquid).into_iter().filter(|face| face.axis == axis);
        let values: Vec<f64> = faces.map(|face| state.velocity.axes[axis][face.index]).collect();
        values.iter().sum::<f64>() / values.len() as f64
    };
    Vector::from([mean(0), mean(1)]).dot(&along) / (2.0 * 50.0 * DT)
}

#[test]
fn a_drop_slides_down_a_tilted_wall_as_if_it_fell() {
    let [slips, held] = [true, false].map(|slip| slide(Errata { slip, ..Errata::CORRECTED }));
    println!("{slips} {held}");
    // Measured: 0.944 and 0.835. What the first one lacks is not explained.
    assert!((slips - 1.0).abs() < 0.07 && held < 0.88, "{slips} {held}");
}
