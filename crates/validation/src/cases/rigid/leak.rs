//! A closed cup that is moved, tilted and shaken: leakage through its wall.

use crate::measure::{at_most, bars, checks_or_failure};
use crate::setup::{at_rest, block, unit_model, up};
use crate::{Case, Check, Mode};
use meniscus_numerics::Vector;
use meniscus_numerics::grid::Grid;
use meniscus_numerics::shape::Shape;
use meniscus_sim::{
    Compiled, Model, PrescribedMotion, Repairs, Simulation, Solid, SolidKind, StepError, Wall,
};

/// The case.
pub const CASE: Case = Case {
    name: "leak",
    title: "A closed cup with a thin wall, moved, tilted and shaken",
    theory: "A closed box (a square or cube of 2 L inside, 12 cells per L, in 3D 8, its wall 2 cells thick as \
        it is, and 1.5 and 2 cells, padded; ρ = γ = g = L = 1, ν = 0.01), half full, follows keyframes, up to \
        0.9 L apart along each axis and √(L/g)/2 after each other, so that its velocity jumps by up to 3.6 \
        √(gL) along each axis, and turns at 0.3 √(g/L) at the same time, in 3D about an axis askew to the \
        grid. No liquid may get out: the volume of the parts of liquid cells beyond the wall's outer surface, \
        over the liquid's, as if these cells were full, after 1000 steps and the largest in any step; and the \
        largest change of the volume that the components together have to keep (a droplet that vanishes gives \
        its own to the nearest; one of a few cells does not have its own in every step: case volume). Liquid \
        that has come through the wall, and residues of receding lines within it, are deleted at once and \
        their volume given back to the rest: rows of their own count both before. At 60 and 120 degrees; in 2D \
        at 60 degrees with the cup at eight places on the grid, of which the largest values count. Quick: 2D, 60 \
        degrees, one place.",
    quick: true,
    run,
};

const NAME: &str = "leak";
const STEPS: u64 = 1000;
/// The wall of a cup.
#[derive(Clone, Copy)]
struct CupWall {
    /// Thickness in cells.
    cells: f64,
    /// Whether it is padded for the liquid, as in scenes.
    padded: bool,
}

const WALLS: [CupWall; 3] = [
    CupWall { cells: 2.0, padded: false },
    CupWall { cells: 2.0, padded: true },
    CupWall { cells: 1.5, padded: true },
];
/// Largest displacement of the keyframes along each axis, and time between them.
const AMPLITUDE: f64 = 0.45;
const KEYFRAME_INTERVAL: f64 = 0.5;
/// Bound of the volume deleted in all steps, over that of the liquid. Only
/// [`meniscus_sim::Repairs::leaked_volume`] tells how much of it passed through the wall; the rest remained in
/// it at receding lines.
const MAX_DELETED_VOLUME: f64 = 0.01;

/// Displacements of the cup along each axis, in cells: whether liquid comes through depends on the place.
const PLACES_CELLS: [f64; 8] = [0.0, 0.1, 0.2, 0.3, 0.4, 0.6, 0.7, 0.8];

fn run(mode: Mode) -> Vec<Check> {
    let one = &PLACES_CELLS[..1];
    let checks = |wall| match mode {
        Mode::Quick => vec![check_shaken_cups::<2>(wall, 60.0, one)],
        Mode::Full => vec![
            check_shaken_cups::<2>(wall, 60.0, &PLACES_CELLS),
            check_shaken_cups::<3>(wall, 60.0, one),
            check_shaken_cups::<2>(wall, 120.0, one),
            check_shaken_cups::<3>(wall, 120.0, one),
        ],
    };
    WALLS.into_iter().flat_map(checks).flat_map(|checks| checks_or_failure(NAME, checks)).collect()
}

/// Motion of the cup: to and fro along each axis, in a different order along each.
fn cup_path<const D: usize>() -> PrescribedMotion<D> {
    let place = |k: u32| {
        Vector::from_fn(|a, _| {
            // Multiples of the golden ratio never repeat; even ones go to one side, odd ones to the other.
            let share = (f64::from(k * (a as u32 + 1)) * 0.618_033_988_75).fract();
            let side = if (k >> a).is_multiple_of(2) { 1.0 } else { -1.0 };
            if k == 0 { 0.0 } else { AMPLITUDE * side * (1.0 + 2.0 * share) / 3.0 }
        })
    };
    let angular_velocity = if D == 2 { [0.0, 0.0, 0.3] } else { [0.2, 0.21, 0.08] };
    let keyframes = (0..400).map(|k| (KEYFRAME_INTERVAL * f64::from(k), place(k))).collect();
    PrescribedMotion { velocity: Vector::zeros(), angular_velocity, keyframes }
}

/// The cup and its liquid at a contact angle (degrees), displaced by `place` cells along each axis.
fn start<const D: usize>(wall: CupWall, angle: f64, place: f64) -> Simulation<D>
where
    Simulation<D>: Compiled<D>,
{
    // Cells per half-width of the cavity.
    let cells = if D == 2 { 12.0 } else { 8.0 };
    let dx = 1.0 / cells;
    let thickness = wall.cells * dx;
    // Room for the diagonal, the motion, and three cells.
    let half = (1.0 + thickness) * (D as f64).sqrt() + AMPLITUDE + 3.0 * dx;
    let grid = Grid::<D>::new([2 * (half * cells).ceil() as usize; D], dx);
    let center = grid.domain_upper() * 0.5 + crate::setup::grid_offset(dx) + Vector::repeat(place * dx);
    let shape = |half_size: f64| block(center, Vector::repeat(half_size));
    let hollow = Shape::Difference { of: Box::new(shape(1.0 + thickness)), minus: Box::new(shape(1.0)) };
    let cup = Solid::new(hollow, SolidKind::Prescribed(cup_path()), 1.0);
    let mut cup = if wall.padded { cup.padded(thickness, dx) } else { cup };
    cup.young_cosine = angle.to_radians().cos();
    let model = Model {
        kinematic_viscosity: 0.01,
        gravity: up(-1.0),
        solids: vec![cup],
        ..unit_model(grid, [[Wall::Slip; 2]; D])
    };
    // The part within the wall is cut off.
    let inside = shape(1.0 + 0.5 * wall.cells * dx);
    let distance = |x: &Vector<D>| (x[D - 1] - center[D - 1]).max(inside.signed_distance(x));
    at_rest(model, &distance)
}

/// Volumes over that of the liquid, each with the text of its row and its bars.
type Volumes = [(&'static str, [f64; 2], f64); 6];

/// Shakes a cup.
fn shaken_cup<const D: usize>(wall: CupWall, angle: f64, place: f64) -> Result<Volumes, StepError>
where
    Simulation<D>: Compiled<D>,
{
    let mut sim = start::<D>(wall, angle, place);
    let full = sim.diagnostics().volume;
    let (mut outside, mut change): (f64, f64) = (0.0, 0.0);
    let mut repairs = Repairs::default();
    while sim.state.step < STEPS {
        repairs.add(&sim.step(f64::INFINITY, &mut |_| ())?.repairs);
        let kept: f64 = sim.state.components.iter().map(|d| d.target_volume).sum();
        change = change.max(((kept + sim.state.lost_volume) / full - 1.0).abs());
        outside = outside.max(volume_beyond_wall(&sim, wall.cells) / full);
    }
    Ok([
        ("volume outside in the end", [1e-6, 0.0], volume_beyond_wall(&sim, wall.cells) / full),
        ("volume outside in any step", [1e-6, 0.0], outside),
        ("volume that came through", [1e-6, 0.0], repairs.leaked_volume / full),
        ("volume deleted", [MAX_DELETED_VOLUME, 0.0], repairs.deleted_volume / full),
        ("change of the volume", [1e-6, 1e-12], change),
        ("volume lost with the last droplet", [1e-4, 1e-8], sim.state.lost_volume / full),
    ])
}

/// Checks the largest volumes over cups at the given places.
fn check_shaken_cups<const D: usize>(
    wall: CupWall,
    angle: f64,
    places: &[f64],
) -> Result<Vec<Check>, StepError>
where
    Simulation<D>: Compiled<D>,
{
    let all: Vec<Volumes> =
        places.iter().map(|place| shaken_cup::<D>(wall, angle, *place)).collect::<Result<_, _>>()?;
    let padded = if wall.padded { ", padded" } else { "" };
    let number = if places.len() > 1 { format!(", {} places", places.len()) } else { String::new() };
    let largest = |row: usize| {
        let (text, [must, aim], _) = all[0][row];
        let text = format!("{text}, {D}D, {} cells{padded}, θ = {angle}°{number}", wall.cells);
        let value = all.iter().map(|v| v[row].2).max_by(f64::total_cmp).unwrap_or(f64::NAN);
        at_most(NAME, text, value, bars(must, aim))
    };
    Ok((0..all[0].len()).map(largest).collect())
}

/// Volume of the parts of liquid cells beyond a wall of the given thickness.
fn volume_beyond_wall<const D: usize>(sim: &Simulation<D>, wall: f64) -> f64 {
    const FINE: usize = 4;
    let (cup, now) = (&sim.model.solids[0], sim.state.solids[0].as_rigid());
    let grid = sim.model.grid;
    let half_size = Vector::repeat(1.0 + wall * grid.dx);
    let hull = block(cup.mass_properties.center, half_size);
    let outside = |x: &Vector<D>| hull.signed_distance(&cup.to_reference(&now, x)) > 0.0;
    let row = grid.cells[0];
    let cells = sim
        .liquid_cells()
        .runs
        .iter()
        .flat_map(|r| (r.start..r.end).map(|i| r.row as usize * row + i as usize));
    let mut points = 0;
    for cell in cells {
        let center = grid.center(grid.lattice().coordinates(cell));
        let place = |k: usize, a: usize| (k / FINE.pow(a as u32) % FINE) as f64 - 0.5 * (FINE - 1) as f64;
        let point = |k: usize| center + Vector::from_fn(|a, _| grid.dx / FINE as f64 * place(k, a));
        points += (0..FINE.pow(D as u32)).filter(|k| outside(&point(*k))).count();
    }
    points as f64 / FINE.pow(D as u32) as f64 * grid.cell_volume()
}
