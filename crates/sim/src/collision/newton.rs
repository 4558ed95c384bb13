//! Solids that cannot break: the velocities at the end of a step make an incremental potential least ([`potential`]), together with
//! the liquid's pressure.
//!
//! Newton's method: about the velocities `v` that it has come to, solids answer to impulses with `A⁻¹` ([`Response`]), `A` the second
//! derivatives of the potential there, contacts included. With that answer the pressure is solved for, as in a step without
//! contacts; where it leads is gone to as far as nothing meets and no element turns inside out at the end of the coming step
//! (M. Li et al., "Incremental Potential Contact", 2020), and as the potential falls. Iterations end when the next would move
//! nothing.

pub use super::compliance::Response;
use super::points::REACH;

pub use super::points::{Points, turning};
use super::potential::moments::{Early, Past};

pub use super::potential::slips::Slips;
use super::tie::{End, Tie};

use super::broad_phase::Candidates;
use super::potential::total::{Elimination, Part, Potential, Rigid};
use crate::contact_line::friction::DraggedFace;
use crate::coupling::impulses::Exchange;
use crate::flow::pressure::Pass;
use crate::model::Model;
use crate::model::time_step::Times;
use crate::solid::{Motion, SolidState};
use meniscus_contact::Barrier;
use meniscus_elastic::{Elastic, HALVINGS, ITERATIONS, Incremental, KEEP, StiffnessBlock};
use meniscus_numerics::grid::FaceField;
use meniscus_numerics::linalg::SolveError;
use meniscus_numerics::{Matrix, Vector};

/// Part of its distance that a pair keeps, and of its volume an element, on the straight way to the end of the coming step, at the end of
/// which the barrier holds them.
const BARE: f64 = 0.01;
/// Change of a position at the end of the coming step, in reaches of the barrier, below which Newton's method has converged.
const SETTLED: f64 = 1e-3;
/// The same after an update of the lagged friction, over [`SETTLED`]: the error of a lag that is updated [`RUBS`] times only adds up
/// from step to step.
const RUBBED: f64 = 0.01;
/// Relative residual of the pressure's solve in iterations far from convergence (inexact Newton: S. Eisenstat, H. Walker 1996). An
/// iteration that ends the method has the full accuracy, so that this changes the cost only.
const LOOSE: f64 = 1e-3;
/// Far from convergence: the next iteration would move something by over so many times [`SETTLED`], which one of Newton's iterations
/// does not bring below 1.
const FAR: f64 = 100.0;
/// Most updates of the lagged friction in a step.
const RUBS: usize = 2;
/// Most changes of the velocities by the solids alone after an iteration. What is lagged makes each a hundredth of the one before.
const CHORDS: usize = 4;

/// What a solid that deforms starts from.
pub struct Start<const D: usize> {
    /// What all but the pressure gives to its vertices, N s.
    impulses: Vec<Vector<D>>,
    /// Stiffness that other forces add.
    extra: Vec<StiffnessBlock<D>>,
}

impl<const D: usize> Start<D> {
    /// Of all solids; `line` is what contact lines give them in the time `kick` (s), `extra` the stiffness that other forces add.
    pub fn of(
        model: &Model<D>,
        line: &Exchange<D>,
        extra: Vec<Vec<StiffnessBlock<D>>>,
        kick: f64,
    ) -> Vec<Option<Self>> {
        let start = |(k, extra): (usize, Vec<StiffnessBlock<D>>)| {
            let elastic = model.solids[k].elastic()?;
            let mut impulses: Vec<Vector<D>> =
                elastic.masses().iter().map(|m| model.gravity * (m * kick)).collect();
            line.grips
                .get(&(k as u32))
                .iter()
                .for_each(|grips| crate::solid::deformable::spread(grips, &mut impulses));
            Some(Self { impulses, extra })
        };
        extra.into_iter().enumerate().map(start).collect()
    }
}

/// The solids when the forces of a step act.
#[derive(Clone, Copy)]
pub struct Before<'a, const D: usize> {
    /// The solids, with the velocities before these forces.
    pub solids: &'a [SolidState<D>],
    /// These velocities, of their nodes.
    pub velocities: &'a [Vector<D>],
    /// The elastic slips of friction.
    pub slips: &'a Slips<D>,
}

/// A step's search for velocities.
pub struct Descent<'a, const D: usize> {
    potential: Potential<'a, D>,
    /// Velocities that nodes have which are told.
    told: Vec<Vector<D>>,
    elimination: Elimination<D>,
    /// Velocities that it has come to.
    now: Vec<Vector<D>>,
    /// The pairs that may touch with these velocities.
    candidates: Candidates,
    iteration: usize,
    /// Whether the pressure's solve may be [`LOOSE`].
    loose: bool,
    rubs: usize,
    /// Iterations whose second derivatives were not positive definite.
    pub indefinite: u64,
}

impl<'a, const D: usize> Descent<'a, D> {
    /// Before the pressure; `forced` is how all forces but the pressure, contacts and their own make rigid solids move.
    pub fn new(
        model: &'a Model<D>,
        points: &'a Points<D>,
        before: Before<'a, D>,
        forced: &[SolidState<D>],
        starts: &'a [Option<Start<D>>],
        times: Times,
    ) -> Self {
        let Before { solids: before, velocities: old, slips } = before;
        let part = |k: usize| match (&model.solids[k].motion, &starts[k], &before[k].soft) {
            (Motion::Soft(elastic), Some(start), Some(soft)) => {
                let elastic: &'a Elastic<D> = elastic;
                // At the start the velocities of a solid need not agree with what holds it. About the start they would be reversed where
                // they do not, at no loss; from there they come to rest.
                let apart = times.first && elastic.held().contains(&true);
                Part::Soft(Incremental {
                    elastic,
                    state: &soft.body,
                    viscous_at: soft.body.positions.clone(),
                    beyond: vec![Vector::zeros(); start.impulses.len()],
                    extra: &start.extra,
                    impulses: &start.impulses,
                    step: times.kick,
                    lead: if apart { times.kick } else { times.lead },
                    ahead: times.ahead,
                })
            }
            (Motion::Free, ..) => {
                let inertia = model.solids[k].inertia(&before[k]);
                let inertia = Matrix::<D>::from_fn(|r, c| match D {
                    2 if r == 0 && c == 0 => inertia[(2, 2)],
                    2 => f64::from(u8::from(r == c)),
                    _ => inertia[(r, c)],
                });
                let target = [forced[k].velocity, turning(&forced[k].spin)];
                Part::Free(Rigid { mass: model.solids[k].body.mass, inertia, target })
            }
            _ => Part::Told,
        };
        let place = |now: &SolidState<D>| match &now.soft {
            Some(soft) => soft.body.positions.clone(),
            None => vec![now.center; 2],
        };
        let mut told = points.velocities(model, before);
        for (k, solid) in model.solids.iter().enumerate() {
            let (Some(elastic), Some(soft)) = (solid.elastic(), &before[k].soft) else { continue };
            for (v, velocity) in elastic.held_velocities(soft.body.time, times.kick) {
                told[points.first[k] + v] = velocity;
            }
        }
        let mut potential = Potential {
            model,
            solids: before,
            points,
            parts: (0..model.solids.len()).map(part).collect(),
            barrier: Barrier { reach: REACH * model.grid.dx },
            kick: times.kick,
            lead: times.lead,
            ahead: times.ahead,
            settling: times.ahead,
            past: Past::new(model, before, points, old, times.kick - times.lead),
            slips,
            early: Early::default(),
            rubs: Vec::new(),
            pressed: vec![Vector::zeros(); points.nodes()],
        };
        potential.settling = potential.settling();
        let positions = before.iter().flat_map(place).collect();
        let now = vec![Vector::zeros(); points.nodes()];
        let mut descent = Self {
            potential,
            told,
            elimination: Elimination { structure: None, positions },
            now,
            candidates: Candidates::default(),
            iteration: 0,
            loose: false,
            rubs: 0,
            indefinite: 0,
        };
        // The first guess is to go on as before.
        let guess = descent.told.clone();
        let on_the_way = descent.potential.candidates(&descent.now, &guess, descent.margin());
        descent.potential.rubs = descent.potential.rubbing(&descent.now, &on_the_way);
        descent.go(&guess, on_the_way, false);
        descent.recentre();
        descent.potential.early = descent.potential.early(&descent.now, &descent.candidates);
        descent
    }

    /// The answer of solids about the velocities that it has come to, which they get, with the faces that lines drag.
    ///
    /// # Errors
    /// [`SolveError::Indefinite`].
    pub fn linearise(
        &mut self,
        solids: &mut [SolidState<D>],
        dragged: &mut [DraggedFace],
        (phi, open): (&[f64], &FaceField<D>),
    ) -> Result<Response<D>, SolveError> {
        let failed = SolveError::Indefinite { step: self.potential.kick };
        self.potential.pressed.fill(Vector::zeros());
        let ties = self.ties(dragged, phi, open);
        let (potential, candidates, elimination) = (&self.potential, &self.candidates, &mut self.elimination);
        let mut inverse = |positive| {
            let matrix = potential.matrix(&self.now, candidates, &ties, elimination, positive)?;
            let structure = elimination.structure.as_ref()?;
            let solution = potential.points.assembly.as_ref()?.invert(&matrix, structure)?;
            Some((matrix, solution))
        };
        // The positive part alone is as stiff as can be, and slow: it is for where there is no other way (Longva et al., "Pitfalls of
        // projection", 2023).
        let whole = inverse(false);
        let indefinite = whole.is_none();
        let (matrix, solution) = whole.or_else(|| inverse(true)).ok_or(failed)?;
        self.indefinite += u64::from(indefinite);
        let gradient = self.potential.gradient(&self.now, &self.candidates);
        let mut base: Vec<Vector<D>> = gradient.iter().map(|g| -g).collect();
        let lead = self.lead();
        if lead.iter().any(|t| t.norm_squared() > 0.0) {
            let mut pushed = vec![Vector::zeros(); self.now.len()];
            matrix.add_product(&lead, &mut pushed);
            base.iter_mut().zip(&pushed).for_each(|(r, p)| *r -= p);
        }
        let Potential { model, points, solids: before, .. } = self.potential;
        points.give(model, solids, &self.now);
        Ok(Response::new(model, before, points, solution, (base, lead), ties))
    }

    /// How the pressure of this iteration is solved for.
    pub fn pass(&self) -> Pass {
        let tolerance = self.potential.model.numerics.tolerance;
        Pass {
            again: self.iteration > 0,
            tolerance: if self.loose { tolerance.max(LOOSE) } else { tolerance },
        }
    }

    /// Updates what is lagged of the elastic forces and viscosities to the current velocities.
    fn recentre(&mut self) {
        for (part, first) in self.potential.parts.iter_mut().zip(&self.potential.points.first) {
            if let Part::Soft(soft) = part {
                let count = soft.impulses.len();
                soft.recentre(&self.now[*first..first + count]);
            }
        }
    }

    /// Ties dragged faces to the solids, with the velocities that it has come to.
    fn ties(&self, dragged: &mut [DraggedFace], phi: &[f64], open: &FaceField<D>) -> Vec<Tie<D>> {
        let Potential { model, points, solids, .. } = self.potential;
        let weight = model.density * model.grid.cell_volume();
        let mut ties = Vec::new();
        for (number, f) in dragged.iter_mut().enumerate() {
            let at = model.grid.faces(f.axis).coordinates(f.face);
            let x = model.grid.face_center(f.axis, at);
            let axis = Vector::<D>::from_fn(|a, _| if a == f.axis { 1.0 } else { 0.0 });
            let mut ends = Vec::new();
            for (hold, of) in f.holds.iter_mut().enumerate() {
                let solid = of.solid as usize;
                if model.solids[solid].motion.is_told() {
                    continue;
                }
                let end =
                    End { hold, drag: of.drag, arm: arm(&solids[solid], points.first[solid], &x, &axis) };
                of.of_solid = end.velocity(&self.now);
                ends.push(end);
            }
            if ends.is_empty() {
                continue;
            }
            let upper = model.grid.lattice().index(at);
            let lower = upper - model.grid.lattice().stride[f.axis];
            let sides = [(lower, 1.0), (upper, -1.0)].into_iter().filter(|(c, _)| phi[*c] < 0.0);
            ties.push(Tie {
                number,
                sides: sides.map(|(c, sign)| (c as u32, sign)).collect(),
                open: open.axes[f.axis][f.face],
                mobility: f.mobility(),
                mass: weight * f.mass,
                ends,
            });
        }
        ties
    }

    /// The longest that the coming step can be, s: for so long nothing meets or turns inside out on the straight way there, either,
    /// of which a shorter step takes a part.
    pub fn clear(&self) -> f64 {
        let still = vec![Vector::zeros(); self.now.len()];
        let part = self.potential.free_step(&still, &self.now, &self.now, &self.candidates, BARE);
        self.potential.ahead * part
    }

    /// The elastic slips that the next step starts from.
    pub fn slips(&self) -> Slips<D> {
        self.potential.next_slips(&self.now)
    }

    /// Stores in each solid the mean acceleration by its contacts. Returns the work, J (2D: J/m), that solids with told velocities do
    /// through contacts.
    pub fn tell_contacts(&self, solids: &mut [SolidState<D>]) -> f64 {
        let Potential { model, points, kick, .. } = self.potential;
        let given = self.potential.between(&self.now, &self.candidates);
        for (k, now) in solids.iter_mut().enumerate() {
            let (solid, own) = (&model.solids[k], &given[points.first[k]..]);
            now.held = Vector::zeros();
            if let Some(elastic) = solid.elastic() {
                let count = elastic.masses().len();
                now.held = own[..count].iter().sum::<Vector<D>>() / (solid.body.mass * kick);
            } else if solid.motion == Motion::Free {
                now.held = own[0] / (solid.body.mass * kick);
            }
        }
        let told = (0..given.len()).filter(|node| points.held[*node]);
        -told.map(|node| given[node].dot(&self.now[node])).sum::<f64>()
    }

    /// The difference of the told nodes' velocities from what they are told.
    fn lead(&self) -> Vec<Vector<D>> {
        let of = |k: usize| {
            if self.potential.points.held[k] { self.told[k] - self.now[k] } else { Vector::zeros() }
        };
        (0..self.now.len()).map(of).collect()
    }

    /// Changes the velocities by `change`, the `response` to a pressure that gives the nodes the impulses `pressed`, as far as the line
    /// search allows. Returns whether Newton's method has converged; the solids then have the final velocities.
    ///
    /// # Errors
    /// [`SolveError::Unsettled`] after too many iterations.
    pub fn settle(
        &mut self,
        solids: &mut [SolidState<D>],
        response: &Response<D>,
        change: &[Vector<D>],
        pressed: Vec<Vector<D>>,
    ) -> Result<bool, SolveError> {
        let Potential { model, points, .. } = self.potential;
        let mut to: Vec<Vector<D>> = self.now.iter().zip(change).map(|(v, c)| v + c).collect();
        let lead = self.lead();
        (0..to.len()).filter(|k| self.potential.points.held[*k]).for_each(|k| to[k] = self.told[k]);
        self.potential.pressed = pressed;
        let led = lead.iter().any(|l| l.norm_squared() > 0.0);
        let limit = SETTLED * self.potential.barrier.reach / self.potential.ahead;
        let size = to.iter().zip(&self.now).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        let on_the_way = self.potential.candidates(&self.now, &to, self.margin());
        let whole = self.go(&to, on_the_way, !led && size > limit);
        self.iteration += 1;
        self.recentre();
        let early = self.potential.early(&self.now, &self.candidates);
        self.potential.early.keep(&early);
        let (off, settled) = if whole { self.finish(response, limit) } else { (f64::INFINITY, false) };
        let exact = !std::mem::replace(&mut self.loose, off > FAR * limit);
        if settled && exact && self.iteration > model.numerics.newton_iterations as usize {
            points.give(model, solids, &self.now);
            return Ok(true);
        }
        if self.iteration >= ITERATIONS {
            return Err(SolveError::Unsettled { iterations: self.iteration, off: off / limit });
        }
        Ok(false)
    }

    /// After a whole one of Newton's iterations: where no velocity would change by `limit`, m/s, any more, too little for the pressure to
    /// be found anew, what is lagged is updated, and solids alone go the rest of the way, with the same second derivatives. Returns how
    /// far the next iteration would go, m/s, and whether Newton's method has converged.
    fn finish(&mut self, response: &Response<D>, limit: f64) -> (f64, bool) {
        let (mut change, mut off) = self.correction(response);
        let mut tolerance = limit;
        if off < limit && self.rubs < RUBS {
            self.potential.early = self.potential.early(&self.now, &self.candidates);
            self.potential.rubs = self.potential.rubbing(&self.now, &self.candidates);
            self.rubs += 1;
            (change, off) = self.correction(response);
            tolerance = RUBBED * limit;
        }
        for _ in 0..CHORDS {
            if off >= limit || off < RUBBED * limit {
                break;
            }
            let to: Vec<Vector<D>> = self.now.iter().zip(&change).map(|(v, c)| v + c).collect();
            let candidates = std::mem::take(&mut self.candidates);
            if !self.go(&to, candidates, false) {
                return (f64::INFINITY, false);
            }
            self.recentre();
            (change, off) = self.correction(response);
        }
        (off, off < tolerance)
    }

    /// What the next iteration would change the velocities by with this response and no other pressure, m/s, and the largest of it.
    fn correction(&self, response: &Response<D>) -> (Vec<Vector<D>>, f64) {
        let mut change = self.potential.gradient(&self.now, &self.candidates);
        response.solve(&mut change);
        change.iter_mut().for_each(|c| *c = -*c);
        let largest = change.iter().map(Vector::norm).fold(0.0, f64::max);
        (change, largest)
    }

    /// How much nearer, m, solids come to each other by all changes of [`Self::finish`] at most.
    fn margin(&self) -> f64 {
        2.0 * CHORDS as f64 * SETTLED * self.potential.barrier.reach
    }

    /// Goes on the way to other velocities, on which these `candidates` may meet, as far as nothing does, and, where that is asked for, as
    /// the potential falls; returns whether that is all the way.
    fn go(&mut self, to: &[Vector<D>], candidates: Candidates, falls: bool) -> bool {
        let (next, whole) = self.advanced(to, &candidates, falls);
        // Points of solids that turn leave the straight way between its ends.
        self.candidates =
            if whole { candidates } else { self.potential.candidates(&next, &next, self.margin()) };
        self.now = next;
        whole
    }

    /// How far that is; whether it is all the way.
    fn advanced(&self, to: &[Vector<D>], candidates: &Candidates, falls: bool) -> (Vec<Vector<D>>, bool) {
        let change: Vec<Vector<D>> = to.iter().zip(&self.now).map(|(t, v)| t - v).collect();
        let along = |part: f64| -> Vec<Vector<D>> {
            if part == 1.0 {
                return to.to_vec();
            }
            self.now.iter().zip(&change).map(|(v, c)| v + c * part).collect()
        };
        let mut part = self.potential.free_step(&self.now, &change, to, candidates, KEEP);
        if !falls {
            return (along(part), part == 1.0);
        }
        let from = self.potential.value(&self.now, candidates);
        let slack = 1e-12 * from.abs();
        for _ in 0..HALVINGS {
            let next = along(part);
            if self.potential.value(&next, candidates) <= from + slack {
                return (next, part == 1.0);
            }
            part *= 0.5;
        }
        (self.now.clone(), false)
    }
}

/// The velocity along an axis of a solid's point nearest to `x`, by those of its nodes, from the `first` on.
fn arm<const D: usize>(
    solid: &SolidState<D>,
    first: usize,
    x: &Vector<D>,
    axis: &Vector<D>,
) -> Vec<(usize, Vector<D>)> {
    match solid.grip(x) {
        Some(grip) => (0..D).map(|k| (first + grip.vertices[k] as usize, axis * grip.weights[k])).collect(),
        None => {
            let moment = crate::coupling::impulses::moment(&(x - solid.center), axis);
            vec![(first, *axis), (first + 1, turning(&moment.into()))]
        }
    }
}
