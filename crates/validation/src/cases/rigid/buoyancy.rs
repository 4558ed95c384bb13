//! Solids in liquid without surface tension: Archimedes' principle and added mass.

use super::floating::{TIME, Tank, level_at_sides};
use crate::measure::{bars, bisect, checks_or_failure};
use crate::setup::{at_rest, block, grid_offset, run_to, unit_model, up};
use crate::{Case, Check, Mode};
use meniscus_numerics::Vector;
use meniscus_numerics::grid::Grid;
use meniscus_numerics::shape::Shape;
use meniscus_sim::{Compiled, Model, Simulation, Solid, SolidKind, StepError, Wall};
use std::f64::consts::PI;

/// Light floating solids.
pub const BUOYANCY: Case = Case {
    name: "buoyancy",
    title: "A light cylinder afloat, without tension",
    theory: "A cylinder (2D; R = ρ = g = 1, ν = 1, γ = 0) D times as dense as the liquid, released 0.1 R above equilibrium, \
        comes to rest where the share D of it is under water (Archimedes): height of its centre over the level at the sides, \
        6 R off. 12 cells per radius, time 40 √(R/g). Quick: D = 0.5, 8 cells, time 20.",
    quick: true,
    run: |mode| checks_or_failure("buoyancy", buoyancy(mode)),
};

/// Solids that start to rise or sink in liquid-filled shells.
pub const ADDED_MASS: Case = Case {
    name: "added-mass",
    title: "Added mass in a shell full of liquid",
    theory: "A cylinder or ball of radius Ri in the middle of a fixed shell of radius Ro full of inviscid liquid is let go \
        under gravity: potential flow (Lamb, Hydrodynamics, §93) adds (Ro² + Ri²)/(Ro² − Ri²) times the mass that it \
        displaces, for balls (Ro³ + 2 Ri³)/(2 (Ro³ − Ri³)). The added mass by how far it gets in 10 steps, 0.02 Ri in \
        all. 12 cells per Ri. Quick: 2D, Ro/Ri = 2.",
    quick: true,
    run: |mode| checks_or_failure("added-mass", added_mass(mode)),
};

fn buoyancy(mode: Mode) -> Result<Vec<Check>, StepError> {
    if mode == Mode::Quick {
        return Ok(vec![check_floating_height(0.5, 8, 0.5 * TIME)?]);
    }
    [0.25, 0.5, 0.75].into_iter().map(|density| check_floating_height(density, 12, TIME)).collect()
}

fn check_floating_height(density: f64, cells: usize, time: f64) -> Result<Check, StepError> {
    // Half the angle of the circle's arc below the level.
    let is_low = |half: f64| half - 0.5 * (2.0 * half).sin() < PI * density;
    let expected = bisect([0.0, PI], 42, is_low)[0].cos();
    let (bond, center) = (f64::INFINITY, expected + 0.1);
    let mut sim = Tank { bond, angle: 90.0, density, cells, width: 6.0, center }.start::<2>(&|_| 0.0);
    sim.model.numerics.max_step = 0.1;
    run_to(&mut sim, time, |_, _| ())?;
    let found = sim.state.solids[0].center_of_mass()[1] - level_at_sides(&sim);
    let text = format!("centre / R, D = {density}, {cells} cells/R");
    Ok(Check::absolute("buoyancy", text, found, expected, bars(0.02, 0.01)))
}

fn added_mass(mode: Mode) -> Result<Vec<Check>, StepError> {
    if mode == Mode::Quick {
        return Ok(vec![added_mass_in_shell::<2>(2.0, 0.1)?]);
    }
    let mut checks = Vec::new();
    for (ratio, density) in [(2.0, 0.01), (2.0, 0.1), (2.0, 3.0), (3.0, 0.1), (4.0, 0.1)] {
        checks.push(added_mass_in_shell::<2>(ratio, density)?);
    }
    for (ratio, density) in [(2.0, 0.01), (2.0, 0.1), (3.0, 0.1)] {
        checks.push(added_mass_in_shell::<3>(ratio, density)?);
    }
    Ok(checks)
}

fn added_mass_in_shell<const D: usize>(ratio: f64, density: f64) -> Result<Check, StepError>
where
    Simulation<D>: Compiled<D>,
{
    const STEPS: u32 = 10;
    let (cells, way) = (12.0, 0.02);
    let dx = 1.0 / cells;
    let grid = Grid::<D>::new([((2.0 * ratio + 0.5) * cells) as usize; D], dx);
    let center = grid.domain_upper() * 0.5 + grid_offset(dx);
    let all = block(center, Vector::repeat(2.0 * ratio));
    let hole = Shape::Ball { center, radius: ratio };
    let shell = Shape::Difference { of: Box::new(all), minus: Box::new(hole) };
    let inner = Solid::new(Shape::Ball { center, radius: 1.0 }, SolidKind::Rigid, density);
    let model = Model {
        surface_tension: 0.0,
        gravity: up(-1.0),
        solids: vec![inner, Solid::new(shell, SolidKind::Fixed, 1.0)],
        ..unit_model(grid, [[Wall::Slip; 2]; D])
    };
    let (d, outer) = (D as f64 - 1.0, ratio.powi(D as i32));
    let expected = (outer + d) / (d * (outer - 1.0));
    let full = |x: &Vector<D>| x[D - 1] - 100.0 * ratio;
    let mut sim = at_rest(model, &full);
    let start = sim.state.solids[0].center_of_mass()[D - 1];
    let time = (2.0 * way * (density + expected) / (1.0 - density).abs()).sqrt();
    for _ in 0..STEPS {
        sim.step(time / f64::from(STEPS), &mut |_| ())?;
    }
    let risen = sim.state.solids[0].center_of_mass()[D - 1] - start;
    let found = 0.5 * (1.0 - density) * sim.state.time.powi(2) / risen - density;
    let text = format!("added over displaced mass, {D}D, Ro/Ri = {ratio}, D = {density}");
    Ok(Check::relative("added-mass", text, found, expected, bars(0.04, 0.01)))
}
