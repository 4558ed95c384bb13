//! Tests of the viscosity.

use super::*;
use crate::model::resolution::BAND_WIDTH_CELLS;
use crate::model::{Numerics, Wall};
use crate::simulation::workspace::Workspace;
use crate::state::State;
use meniscus_numerics::Vector;
use meniscus_numerics::grid::Grid;
use meniscus_numerics::linalg::{Jacobi, LinearOperator, Preconditioner, dot};

fn model<const D: usize>(cells: usize) -> Model<D> {
    Model {
        grid: Grid::new([cells; D], 1.0 / cells as f64),
        walls: [[Wall::Slip; 2]; D],
        density: 1.0,
        kinematic_viscosity: 0.1,
        surface_tension: 1.0,
        gravity: Vector::zeros(),
        solids: Vec::new(),
        numerics: Numerics::default(),
    }
}

/// Liquid where `distance` is negative, with a velocity on its faces.
fn liquid<const D: usize>(
    model: &Model<D>,
    distance: impl Fn(&Vector<D>) -> f64,
    velocity: impl Fn(&Vector<D>) -> Vector<D>,
) -> (State<D>, Workspace<D>) {
    let grid = &model.grid;
    let mut state = State::empty(*grid);
    let lattice = grid.lattice();
    let limit = BAND_WIDTH_CELLS * grid.dx;
    for i in 0..lattice.len() {
        state.phi.data[i] = distance(&grid.center(lattice.coordinates(i))).clamp(-limit, limit);
    }
    let work = Workspace::new(model, &mut state);
    for a in 0..D {
        state.velocity.axes[a].fill(0.0);
        let faces = grid.face_lattice(a);
        for s in &work.known_faces.liquid_faces()[a] {
            for f in s.row * faces.extent[0] + s.start..s.row * faces.extent[0] + s.end {
                let at = faces.coordinates(f);
                if !model.on_closed_side(a, at[a]) {
                    state.velocity.axes[a][f] = velocity(&grid.face_center(a, at))[a];
                }
            }
        }
    }
    (state, work)
}

fn diffusion<'a, const D: usize>(state: &'a mut State<D>, work: &'a Workspace<D>) -> Diffusion<'a, D> {
    Diffusion {
        velocity: &mut state.velocity,
        phi: &state.phi,
        band: &work.band,
        liquid: &work.liquid,
        liquid_faces: work.known_faces.liquid_faces(),
        cut_cells: &work.cut_cells,
    }
}

fn ball<const D: usize>(x: &Vector<D>) -> f64 {
    (x - Vector::from_fn(|a, _| 0.47 + 0.041 * a as f64)).norm() - 0.26
}

fn rigid_motions_stay<const D: usize>() {
    let model = model::<D>(if D == 2 { 40 } else { 24 });
    let turn = |x: &Vector<D>| {
        let (x, y, z) = (x[0], x[1], x[D - 1]);
        Vector::from_fn(|a, _| match a {
            0 => 0.7 - 2.0 * y + if D == 3 { 0.5 * z } else { 0.0 },
            1 => 2.0 * x - 1.3 * if D == 3 { z } else { 0.0 },
            _ => 0.4 + 1.3 * y - 0.5 * x,
        })
    };
    let (mut state, work) = liquid(&model, ball, turn);
    let before = state.velocity.clone();
    let report = diffusion(&mut state, &work).advance_to(&model, 0.1, 1e-13).unwrap();
    let mut change = 0.0f64;
    for a in 0..D {
        for (new, old) in state.velocity.axes[a].iter().zip(&before.axes[a]) {
            change = change.max((new - old).abs());
        }
    }
    assert!(change < 1e-10, "{D}D: change {change:e}, {report:?}");
}

#[test]
fn uniform_velocity_and_rotation_are_unchanged() {
    rigid_motions_stay::<2>();
    rigid_motions_stay::<3>();
}

fn operator_is_symmetric<const D: usize>() {
    // The liquid touches a closed and an open side.
    let mut model = model::<D>(12);
    model.walls[0][1] = Wall::Open;
    model.walls[1][0] = Wall::Open;
    let (mut state, work) = liquid(&model, |x| ball(&(x * 0.6)), |_| Vector::zeros());
    let d = diffusion(&mut state, &work);
    let places = UnknownCells::new(&model, &d);
    let builder = Builder::new(&model, &d, &places, 3.0);
    let operator = builder.operator(&builder.deep_cells());
    let count = places.cells.count();
    let diagonal = operator.diagonal();
    let n = count * D;
    let (mut x, mut image) = (vec![0.0; n], vec![0.0; n]);
    let mut rows = Vec::new();
    for i in 0..n {
        x[i] = if operator.cell(i % count).is_unknown[i / count] { 1.0 } else { 0.0 };
        operator.apply(&x, &mut image);
        assert!((image[i] - diagonal[i]).abs() < 1e-12, "{D}D: diagonal {i}");
        rows.push(image.clone());
        x[i] = 0.0;
    }
    for (i, row) in rows.iter().enumerate() {
        assert!((0..i).all(|j| (row[j] - rows[j][i]).abs() < 1e-12), "{D}D: row {i}");
    }
}

#[test]
fn the_operator_is_symmetric() {
    operator_is_symmetric::<2>();
    operator_is_symmetric::<3>();
}

fn deep_stretches_are_the_general_operator<const D: usize>() {
    let model = model::<D>(32);
    let (mut state, work) = liquid(&model, ball, |_| Vector::zeros());
    let d = diffusion(&mut state, &work);
    let places = UnknownCells::new(&model, &d);
    let builder = Builder::new(&model, &d, &places, 3.0);
    let count = places.cells.count();
    let operators = [builder.deep_cells(), vec![false; count]].map(|deep| builder.operator(&deep));
    assert!(operators[0].deep_cells() > count / 8 && operators[1].deep_cells() == 0);
    assert!(operators[0].diagonal() == operators[1].diagonal(), "{D}D");
    let x: Vec<f64> =
        (0..count * D).map(|i| if i % count == 0 { 0.0 } else { (0.7 * i as f64).sin() }).collect();
    let [deep, general] = operators.map(|operator| {
        let mut image = vec![0.0; x.len()];
        operator.apply(&x, &mut image);
        image
    });
    assert!(deep == general, "{D}D");
}

#[test]
fn the_operator_of_deep_stretches_is_the_general_one() {
    deep_stretches_are_the_general_operator::<2>();
    deep_stretches_are_the_general_operator::<3>();
}

#[test]
fn a_linear_strain_dissipates_what_it_should() {
    let model = model::<2>(64);
    let center = Vector::<2>::new(0.493, 0.508);
    let (mut state, work) = liquid(&model, |x| (x - center).norm() - 0.25, |_| Vector::zeros());
    let d = diffusion(&mut state, &work);
    let places = UnknownCells::new(&model, &d);
    let count = places.cells.count();
    let mut operator = Builder::new(&model, &d, &places, 1.0).operator(&vec![false; count]);
    operator.cells.iter_mut().for_each(|c| c.face_mass = [0.0; 2]);
    let strain = |i: usize, a: usize| {
        let x = model.grid.face_center(a, places.cells.coordinates(i));
        if i == 0 { 0.0 } else { [x[0], -x[1]][a] }
    };
    let x: Vec<f64> = (0..2 * count).map(|i| strain(i % count, i / count)).collect();
    let mut image = vec![0.0; x.len()];
    // With stiffness one the operator is Φ/(ν Δ^(D−2)).
    let dissipation = operator.apply_dot(&x, &mut image);
    let exact = 4.0 * std::f64::consts::PI * 0.25 * 0.25;
    assert!((dissipation / exact - 1.0).abs() < 0.01, "{dissipation} for {exact}");
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    let model = model::<3>(24);
    let bits = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let flow = |x: &Vector<3>| Vector::from_fn(|a, _| (9.0 * x[(a + 1) % 3] + a as f64).sin());
            let (mut state, work) = liquid(&model, ball, flow);
            let report = diffusion(&mut state, &work).advance(&model, 0.05).unwrap();
            assert!(report.iterations > 5);
            state.velocity.axes.map(|v| v.iter().map(|u| u.to_bits()).collect::<Vec<_>>())
        })
    };
    assert_eq!(bits(1), bits(2));
}

/// The systems of a state on all grids, and its velocity on the finest.
fn systems<const D: usize>(
    model: &Model<D>,
    d: &Diffusion<'_, D>,
    stiffness: f64,
) -> (Vec<ViscousSystem<D>>, Vec<f64>) {
    let places = UnknownCells::new(model, d);
    let builder = Builder::new(model, d, &places, stiffness);
    let operator = builder.operator(&builder.deep_cells());
    let x = gather(&operator, model, &places, d);
    let mut systems = vec![ViscousSystem { cells: places.cells, operator, stiffness }];
    add_coarse_systems(&mut systems);
    (systems, x)
}

/// Iterations of the diagonal and of multigrid for a flow with waves of all lengths.
fn iterations<const D: usize>(
    model: &Model<D>,
    distance: impl Fn(&Vector<D>) -> f64,
    stiffness: f64,
) -> [usize; 2] {
    let flow = |x: &Vector<D>| Vector::from_fn(|a, _| (9.0 * x[(a + 1) % D] + a as f64).sin());
    let (mut state, work) = liquid(model, distance, flow);
    let (systems, x) = systems(model, &diffusion(&mut state, &work), stiffness);
    let operator = &systems[0].operator;
    let b = operator.times_face_mass(&x);
    let limits = SolveLimits { tolerance: TOLERANCE, max_iterations: MAX_ITERATIONS };
    let jacobi = Jacobi::new(&operator.diagonal());
    let multigrid = Multigrid::new(&systems);
    let solve = |m: &dyn Fn(&mut [f64]) -> SolveReport| m(&mut x.clone()).iterations;
    [
        solve(&|x| conjugate_gradient_in_single_precision(operator, &jacobi, &b, x, limits).unwrap()),
        solve(&|x| conjugate_gradient_in_single_precision(operator, &multigrid, &b, x, limits).unwrap()),
    ]
}

#[test]
fn iterations_of_multigrid_do_not_grow_with_the_stiffness() {
    let waves = |x: &Vector<3>| x[2] - 0.43 - 0.05 * (7.0 * x[0] + 4.0 * x[1]).sin();
    for stiffness in [0.2, 1.0, 2.9, 10.0, 30.0, 100.0, 1000.0] {
        let flat = [
            iterations(&model::<2>(64), ball, stiffness),
            iterations(&model::<2>(64), |x| waves(&Vector::<3>::new(x[0], 0.0, x[1])), stiffness),
            iterations(&model::<3>(48), waves, stiffness),
        ];
        for [diagonal, multigrid] in flat {
            assert!(multigrid <= 12 && multigrid < diagonal, "{stiffness}: {multigrid}, {diagonal} without");
        }
    }
}

fn multigrid_is_symmetric<const D: usize>() {
    // The liquid touches a closed and an open side.
    let mut model = model::<D>(12);
    model.walls[0][1] = Wall::Open;
    model.walls[1][0] = Wall::Open;
    let (mut state, work) = liquid(&model, |x| ball(&(x * 0.6)), |_| Vector::zeros());
    let (systems, _) = systems(&model, &diffusion(&mut state, &work), 300.0);
    let multigrid = Multigrid::new(&systems);
    let operator = &systems[0].operator;
    // Residuals are images: no unknown without liquid has one of its own.
    let image = |seed: f32| {
        let x: Vec<f32> =
            (0..LinearOperator::<f32>::size(operator)).map(|i| (seed * i as f32).sin()).collect();
        let mut y = vec![0.0; x.len()];
        operator.apply(&x, &mut y);
        y
    };
    let [a, b] = [0.7, 1.3].map(image);
    let [mut x, mut y] = [(); 2].map(|()| vec![0.0; a.len()]);
    let norms = [multigrid.apply(&a, &mut x), multigrid.apply(&b, &mut y)];
    let (one, two) = (dot(&x, &b), dot(&a, &y));
    let size = (norms[0] * norms[1]).sqrt();
    assert!(systems.len() > 2 && norms[0] > 0.0 && norms[1] > 0.0);
    // Single precision, amplified by a condition number of some hundreds.
    assert!((one - two).abs() < 1e-4 * size, "{D}D: {one}, {two} of {size}");
}

#[test]
fn multigrid_preconditions_symmetrically() {
    multigrid_is_symmetric::<2>();
    multigrid_is_symmetric::<3>();
}

#[test]
fn stiff_liquids_do_not_depend_on_the_number_of_threads() {
    let mut model = model::<3>(24);
    model.kinematic_viscosity = 10.0;
    let bits = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let flow = |x: &Vector<3>| Vector::from_fn(|a, _| (9.0 * x[(a + 1) % 3] + a as f64).sin());
            let (mut state, work) = liquid(&model, ball, flow);
            let report = diffusion(&mut state, &work).advance(&model, 0.05).unwrap();
            assert!(stiffness(&model, 0.05) > 100.0 && report.iterations < 20, "{report:?}");
            state.velocity.axes.map(|v| v.iter().map(|u| u.to_bits()).collect::<Vec<_>>())
        })
    };
    assert_eq!(bits(1), bits(2));
}
