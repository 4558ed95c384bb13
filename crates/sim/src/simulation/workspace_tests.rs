#![allow(clippy::unwrap_used)]

use super::*;
use crate::simulation::{LiquidRegion, Simulation};
use crate::solid::Solid;
use meniscus_numerics::shape::Shape;

#[test]
fn liquid_beyond_a_wall_is_none() {
    let grid = Grid::<2>::new([16; 2], 1.0);
    let (center, half_size) = (Vector::<2>::new(7.3, 8.0), Vector::<2>::new(1.0, 20.0));
    let wall =
        Solid::new(Shape::Box { center, half_size, rotation: Matrix::identity() }, SolidKind::Fixed, 1.0);
    let model = Model::of_test(grid, vec![wall]);
    let mut state = State::empty(grid);
    state.solids = model.initial_solids();
    for (cell, phi) in state.phi.data.iter_mut().enumerate() {
        let x = grid.center(grid.lattice().coordinates(cell));
        *phi = (x[0] - 7.3).max(x[1] - 9.2).clamp(-4.0, 4.0);
    }
    let mut workspace = Workspace::new(&model, &mut state);
    let before = workspace.liquid.clone();
    let beyond = grid.lattice().index([8, 8]);
    state.phi.data[beyond] = -0.1;
    workspace.find_liquid(&model, &state);
    assert_eq!(workspace.liquid.components, 2);
    let strays = workspace.find_spurious_components(&model, &before, 1);
    assert_eq!((strays.cells, &strays.leaked), (vec![beyond], &strays.components));
    // However far liquid may come, it does not come through the wall. Liquid that could have reached a cell, or was there, stays.
    let above = grid.lattice().index([3, 11]);
    state.phi.data[above] = -0.1;
    workspace.find_liquid(&model, &state);
    assert_eq!(workspace.find_spurious_components(&model, &before, 3).cells, vec![beyond]);
    assert!(workspace.find_spurious_components(&model, &workspace.liquid.clone(), 1).cells.is_empty());
}

/// Two touching balls move into a pool. Deep within them φ follows the outside, beyond the band.
#[test]
fn a_step_taken_back_leaves_the_drops_that_were() {
    let grid = Grid::<2>::new([40; 2], 1.0);
    let path = crate::PrescribedMotion {
        velocity: Vector::from([0.4, -1.0]),
        angular_velocity: [0.0; 3],
        keyframes: Vec::new(),
    };
    let ball = |x: f64| {
        let shape = Shape::Ball { center: Vector::from([x, 24.0]), radius: 5.5 };
        Solid::new(shape, SolidKind::Prescribed(path.clone()), 1.0)
    };
    let model = Model::of_test(grid, vec![ball(10.0), ball(21.0)]);
    let pool = |x: &Vector<2>| x[1] - 16.3;
    let body = LiquidRegion { signed_distance: &pool, velocity: Vector::zeros() };
    let Simulation { model, mut state, mut workspace, .. } = Simulation::new(model, &[body]);
    let mut changed = 0;
    for _ in 0..40 {
        let before = state.components.clone();
        let snapshot = Snapshot::take(&model, &mut state, &mut workspace);
        crate::simulation::step::step(&model, &mut state, &mut workspace, 0.5, &mut |_| ()).unwrap();
        changed += workspace.overwritten_phi.len();
        snapshot.restore(&model, &mut state, &mut workspace);
        assert_eq!((workspace.liquid.components as usize, &state.components), (before.len(), &before));
        crate::simulation::step::step(&model, &mut state, &mut workspace, 0.5, &mut |_| ()).unwrap();
    }
    assert!(changed > 0);
}
