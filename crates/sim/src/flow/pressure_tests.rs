use super::*;
use crate::free_surface::curvature::Curvature;
use crate::free_surface::interface_faces::interface_faces;
use crate::model::resolution::BAND_WIDTH_CELLS;
use crate::model::{Numerics, Wall};
use crate::simulation::workspace::Workspace;
use meniscus_numerics::Vector;
use meniscus_numerics::grid::Grid;
use std::f64::consts::PI;

/// A potential without flow through the sides.
fn potential<const D: usize>(x: &Vector<D>) -> f64 {
    (PI * x[0]).cos() * (PI * x[D - 1]).cosh()
}

/// Velocity (rms) that the projection leaves on the interface faces of a potential flow under a sloping surface with that potential
/// on it.
fn left_over<const D: usize>(cells: usize) -> f64 {
    let model = Model {
        grid: Grid::<D>::new([cells; D], 1.0 / cells as f64),
        walls: [[Wall::Slip; 2]; D],
        density: 1.0,
        kinematic_viscosity: 0.0,
        surface_tension: 1.0,
        gravity: Vector::zeros(),
        solids: Vec::new(),
        numerics: Numerics { tolerance: 1e-11, ..Numerics::default() },
    };
    let grid = model.grid;
    let mut state = State::empty(grid);
    let limit = BAND_WIDTH_CELLS * grid.dx;
    for i in 0..grid.lattice().len() {
        let x = grid.center(grid.lattice().coordinates(i));
        let height = x[D - 1] - 0.613 - 0.11 * x[0] - 0.05 * x[0] * x[0];
        state.phi.data[i] = height.clamp(-limit, limit);
    }
    let mut work = Workspace::new(&model, &mut state);
    let known = Curvature {
        kappa: vec![0.0; work.band.cells.len()],
        known: vec![true; work.band.cells.len()],
        ..Curvature::unknown()
    };
    let mut cut = interface_faces(&model, &state.phi, &work.band, &known, &work.cut_cells);
    for f in &mut cut {
        let mut x = grid.center(grid.lattice().coordinates(f.cell));
        x[f.axis] += f.sign * f.theta * grid.dx;
        f.kappa = potential(&x);
    }
    for a in 0..D {
        let faces = grid.face_lattice(a);
        for s in &work.known_faces.liquid_faces()[a] {
            for f in s.row * faces.extent[0] + s.start..s.row * faces.extent[0] + s.end {
                let at = faces.coordinates(f);
                let slope = |x: Vector<D>| {
                    let step = Vector::<D>::from_fn(|b, _| if b == a { 1e-6 } else { 0.0 });
                    (potential(&(x + step)) - potential(&(x - step))) / 2e-6
                };
                if !model.on_closed_side(a, at[a]) {
                    state.velocity.axes[a][f] = slope(grid.face_center(a, at));
                }
            }
        }
    }
    let mut projection = Projection {
        velocity: &mut state.velocity,
        pressure_impulse: &mut state.pressure_impulse,
        phi: &state.phi,
        band: &work.band,
        liquid: &work.liquid,
        liquid_faces: work.known_faces.liquid_faces(),
        interface_faces: &cut,
        dragged_faces: &mut [],
        cut_cells: &mut work.cut_cells,
        solids: &[],
        wetted_surfaces: &[],
        tension_impulse: 1.0,
        impulse_time: 1.0,
        label: &|_| Some(0),
    };
    work.pressure
        .project(
            &model,
            &mut projection,
            None,
            ProjectionOptions { warm_start: false, tolerance: 1e-11 },
            &mut |_| (),
        )
        .unwrap();
    let square = |f: &InterfaceFace| state.velocity.axes[f.axis][f.face].powi(2);
    (cut.iter().map(square).sum::<f64>() / cut.len() as f64).sqrt()
}

#[test]
fn the_velocity_is_second_order_up_to_the_surface() {
    let order = |coarse: f64, fine: f64, times: f64| (coarse / fine).log2() / times.log2();
    let plane = (left_over::<2>(24), left_over::<2>(96));
    let space = (left_over::<3>(12), left_over::<3>(48));
    assert!(order(plane.0, plane.1, 4.0) > 1.7, "{plane:?}");
    assert!(order(space.0, space.1, 4.0) > 1.7, "{space:?}");
}
