//! The pressure of a step, and what it, contact lines and friction give to the solids.
//!
//! All solids that something can move answer to the pressure together, and with contacts, about the velocities that Newton's method
//! has come to ([`crate::collision`]).

use super::impulses::Exchange;
use super::pressure::{Wet, push_solids, wetted};
use crate::collision::impact::bounce;
use crate::collision::newton::{Before, Descent, Start};
use crate::components::restoration::{Labels, walk};
use crate::components::tracking::{Change, in_band, resolved_volume};
use crate::contact_line::force::{LineImpulses, Lines};
use crate::contact_line::friction::{DraggedFace, friction};
use crate::contact_line::solid_tension::{wetted_skins, wetted_stiffness};
use crate::flow::pressure::{Pass, Projected, Projection};
use crate::free_surface::interface_faces::CutFace;
use crate::model::Model;
use crate::model::time_step::{PhaseEnd, Times};
use crate::simulation::workspace::Workspace;
use crate::solid::SolidState;
use crate::state::State;
use meniscus_numerics::Vector;
use meniscus_numerics::grid::{Band, CutCells, Runs, Sampler, Segment};
use meniscus_numerics::linalg::{SolveError, SolveReport};

/// Results of the pressure's solve.
pub struct Pressed<const D: usize> {
    /// The pressure solves, the last of Newton's iterations where there are any.
    pub solves: [SolveReport; 2],
    /// What line, pressure and friction gave to the solids.
    pub given: [Exchange<D>; 3],
    /// The work, J (2D: J/m), that solids which go as told do through contacts.
    pub contacts: f64,
    /// Newton's iterations for solids and pressure.
    pub iterations: u64,
}

/// Makes the velocity free of divergence and gives the solids, whose velocities were `before` without the forces of this step, their
/// impulses.
///
/// # Errors
/// Those of the solves, which do not converge or meet a matrix that is not definite.
pub fn press<const D: usize>(
    model: &Model<D>,
    (state, before): (&mut State<D>, &[SolidState<D>]),
    work: &mut Workspace<D>,
    change: &Change<D>,
    (cut, dragged): (&[CutFace], &mut [DraggedFace]),
    times: Times,
    phase_end: PhaseEnd<'_>,
) -> Result<Pressed<D>, SolveError> {
    let line = pull_lines(model, state, work, change, cut, times.kick);
    let Pushed { solves, given: [pressure, friction], contacts, iterations } = match model.moves_solids() {
        true => descend(model, (state, before), work, (cut, dragged), &line, times, phase_end)?,
        false => flow_past(model, state, work, (cut, dragged), times, phase_end)?,
    };
    let given = [line, pressure, friction];
    tell_forces(&mut state.solids, &given, times.kick);
    Ok(Pressed { solves, given, contacts, iterations })
}

/// What contact lines give to the solids; what of it belongs to the liquid along even walls shifts that.
fn pull_lines<const D: usize>(
    model: &Model<D>,
    state: &mut State<D>,
    work: &mut Workspace<D>,
    change: &Change<D>,
    cut: &[CutFace],
    kick: f64,
) -> Exchange<D> {
    let inside: Vec<bool> = work.touching(model).iter().map(|t| !t.side).collect();
    let label = work.liquid.component(&model.grid);
    let near = in_band(&work.band, &change.labels);
    let phi = Sampler::cells(&model.grid, &state.phi.data, model.scalar_edges());
    let (solids, cubes) = (&state.solids, &change.cubes);
    let LineImpulses { on_solids: line, on_liquid: along, moment_lost } = if model.numerics.contact_line {
        let skins = &wetted_skins(model, solids, &phi, &label);
        let (phi, wet, centers) = (&state.phi.data, &work.cut.wet, &change.centers);
        let (label, inside) = (&near, &inside);
        Lines { model, solids, phi, cubes, cut, wet, centers, label, inside, skins }.impulses(kick)
    } else {
        let on_liquid = vec![Vector::zeros(); inside.len()];
        LineImpulses { on_solids: Exchange::new(), on_liquid, moment_lost: 0.0 }
    };
    work.repairs.line_moment_lost += moment_lost;
    // Of a drop too small to be resolved the lattice's pull is noise.
    let least = resolved_volume(model);
    let speed = |(j, volume): (&Vector<D>, &f64)| {
        if *volume > least { j / (model.density * volume) } else { Vector::zeros() }
    };
    let along: Vec<Vector<D>> = along.iter().zip(&change.targets).map(speed).collect();
    let labels = Labels::new(&label);
    let of = |cell: usize| labels.of(cell);
    walk(model, &state.phi, work, cut, &of).shift(&mut state.velocity, &along);
    work.repairs.unlabelled += labels.missing();
    line
}

/// What the pressure, friction and contacts do to the solids.
struct Pushed<const D: usize> {
    solves: [SolveReport; 2],
    /// What pressure and friction give.
    given: [Exchange<D>; 2],
    contacts: f64,
    iterations: u64,
}

/// The pressure where nothing moves the solids but what they are told.
fn flow_past<const D: usize>(
    model: &Model<D>,
    state: &mut State<D>,
    work: &mut Workspace<D>,
    (cut, dragged): (&[CutFace], &mut [DraggedFace]),
    times: Times,
    phase_end: PhaseEnd<'_>,
) -> Result<Pushed<D>, SolveError> {
    let label = work.liquid.component(&model.grid);
    let wet = wetted(model, &work.cut, &state.solids, &state.phi.data);
    let parts = (&work.band, &work.liquid, work.known.liquid(), &mut work.cut, &wet[..]);
    let mut projection = projection(model, state, parts, (cut, dragged, &label), times.kick);
    let pass = Pass { again: false, tolerance: model.numerics.tolerance };
    let Projected { solves, exchange, .. } =
        work.pressure.project(model, &mut projection, None, pass, phase_end)?;
    let friction = friction(model, state, dragged, &label);
    Ok(Pushed { solves, given: [exchange, friction], contacts: 0.0, iterations: 0 })
}

/// The pressure and solids that move, with all contacts: Newton's iterations.
fn descend<const D: usize>(
    model: &Model<D>,
    (state, before): (&mut State<D>, &[SolidState<D>]),
    work: &mut Workspace<D>,
    (cut, dragged): (&[CutFace], &mut [DraggedFace]),
    line: &Exchange<D>,
    times: Times,
    phase_end: PhaseEnd<'_>,
) -> Result<Pushed<D>, SolveError> {
    let starts = Start::of(model, line, wetted_stiffness(model, state), times.kick);
    push_solids(model, &mut state.solids, line);
    let (points, start) = (work.points.clone(), state.velocity.clone());
    let bounced = bounce(model, &points, &mut state.solids, before, times, &mut work.repairs);
    let slips = std::mem::take(&mut state.slips);
    let old = points.velocities(model, before);
    let from = Before { solids: before, velocities: &old, slips: &slips };
    let mut descent = Descent::new(model, &points, from, &state.solids, &starts, times);
    let label = work.liquid.component(&model.grid);
    let wet = wetted(model, &work.cut, &state.solids, &state.phi.data);
    let mut iteration = 0;
    loop {
        iteration += 1;
        let response = descent.linearise(&mut state.solids, dragged, (&state.phi.data, &work.cut.open))?;
        state.velocity.clone_from(&start);
        let parts = (&work.band, &work.liquid, work.known.liquid(), &mut work.cut, &wet[..]);
        let mut projection = projection(model, state, parts, (cut, dragged, &label), times.kick);
        let Projected { solves, exchange: pressure, change } =
            work.pressure.project(model, &mut projection, Some(&response), descent.pass(), phase_end)?;
        let friction = friction(model, state, dragged, &label);
        let mut pressed = pressure.clone();
        pressed.extend(&friction);
        let pressed = response.impulses(model, before, &pressed);
        if descent.settle(&mut state.solids, &response, &change, pressed)? {
            (state.clear, state.slips) = (descent.clear(), descent.slips());
            work.repairs.indefinite_iterations += descent.indefinite;
            let told = descent.tell_contacts(&mut state.solids);
            return Ok(Pushed {
                solves,
                given: [pressure, friction],
                contacts: told + bounced,
                iterations: iteration,
            });
        }
    }
}

/// Faces that the surface cuts, those that lines drag, and the component of a liquid cell.
type Faces<'a> = (&'a [CutFace], &'a mut [DraggedFace], &'a (dyn Fn(usize) -> Option<u32> + Sync));

/// The grid's part of a projection: band, liquid, its faces, what solids leave open, and their surfaces in liquid cells.
type Parts<'a, const D: usize> =
    (&'a Band<D>, &'a Runs, &'a [Vec<Segment>; D], &'a mut CutCells<D>, &'a [Wet<D>]);

fn projection<'a, const D: usize>(
    model: &Model<D>,
    state: &'a mut State<D>,
    (band, liquid, faces, cut_cells, wet): Parts<'a, D>,
    (cut, dragged, label): Faces<'a>,
    time: f64,
) -> Projection<'a, D> {
    Projection {
        velocity: &mut state.velocity,
        lambda: &mut state.lambda,
        phi: &state.phi,
        band,
        liquid,
        faces,
        cut,
        dragged,
        cut_cells,
        solids: &state.solids,
        wet,
        label,
        jump: model.surface_tension * time / (model.density * model.grid.dx),
        time,
    }
}

/// Keeps with the solids the mean forces of what line, pressure and friction gave them in the time `kick`.
fn tell_forces<const D: usize>(solids: &mut [SolidState<D>], given: &[Exchange<D>; 3], kick: f64) {
    let [line, pressure, friction] = given.each_ref().map(|exchange| exchange.by_solid(solids.len()));
    let pulls = line.into_iter().zip(friction);
    for ((now, (line, friction)), pressure) in solids.iter_mut().zip(pulls).zip(pressure) {
        now.pulled = (line.linear + friction.linear) / kick;
        now.pressed = pressure.linear / kick;
    }
}

/// The work, J, that solids which go as told do on the rest.
pub fn stirred<const D: usize>(model: &Model<D>, state: &State<D>, given: &[Exchange<D>; 3]) -> f64 {
    let mut work = 0.0;
    for ((_, solid), impulse) in given.iter().flat_map(|g| &g.pairs) {
        let now = &state.solids[*solid as usize];
        if model.solids[*solid as usize].motion.is_told() {
            let turning = impulse.about(&now.center).dot(&Vector::<3>::from(now.spin));
            work -= impulse.linear.dot(&now.velocity) + turning;
        }
    }
    work
}
