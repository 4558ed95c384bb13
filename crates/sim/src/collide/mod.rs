//! Collisions of rigid solids with each other and with the closed sides of the domain; where one deforms, see [`crate::descent`].
//!
//! Where solids are near, probes of the one's surface are held against the other's signed distance, both ways, so that
//! all shapes that have a distance collide: unions, differences, meshes, in 2D and 3D. A few contacts of every pair are
//! kept, and their impulses found by projected Gauss-Seidel in a fixed order: first what hits, which bounces, round after
//! round as the blow is handed on; then what rests (E. Guendelman, R. Bridson, R. Fedkiw, "Nonconvex rigid bodies with
//! stacking", SIGGRAPH 2003, whose order of the two this is). Every impulse acts on both at one point: momentum and spin
//! are kept to rounding.
//!
//! Contacts act before solids touch: no point may come nearer in a step than [`GAP`]. Nothing passes through
//! anything then, whatever its thickness, and a film stays open to the liquid between them that the grid need not see.
//! Solids that overlap all the same (a turning corner goes along an arc) are moved apart, which changes no velocity.
//!
//! Parry and rapier, the well-kept libraries of Rust, were looked at: they have 2D and 3D as two crates, no distances of
//! unions and differences, and a solver that does not know of the liquid's.

mod near;
mod skins;
mod start;

use crate::exchange::moment;
use crate::model::Model;
use crate::repairs::Repairs;
use crate::solid::{Motion, Solid, SolidState};
use meniscus_numerics::shape::Probe;
use meniscus_numerics::{Matrix, Vector};
use near::{Near, thin};

/// Distance that solids keep, in cells: a film that the liquid's cut cells still have as open, and no picture shows. What
/// starts nearer stays so.
const GAP: f64 = 0.05;
/// Distance of probes, in cells: a surface of a radius of five cells bulges out between them by less than 0.01 cells.
const EDGE: f64 = 0.5;
/// Times that a blow is handed on in a step.
const ROUNDS: usize = 12;
/// Sweeps of Gauss-Seidel, there and back; one solid needs a dozen, stacks take all.
const SWEEPS: usize = 300;
/// Change of speed in a sweep, over the speeds there are, that ends it.
const EXACT: f64 = 1e-12;

/// The probes of every solid, where it starts.
#[derive(Clone, Debug)]
pub struct Probes<const D: usize>(Vec<Vec<Probe<D>>>);

impl<const D: usize> Probes<D> {
    /// Those of a model's solids; none where nothing can collide, and none of the sides.
    pub fn of(model: &Model<D>) -> Self {
        let free = model.solids.iter().any(|s| !s.motion.is_told());
        let own = |(i, s): (usize, &Solid<D>)| model.wetting_walls() != Some(i) && s.elastic().is_none();
        let probes = |(i, s): (usize, &Solid<D>)| match free && own((i, s)) {
            true => s.shape.probes(EDGE * model.grid.dx),
            false => Vec::new(),
        };
        Self(model.solids.iter().enumerate().map(probes).collect())
    }

    fn of_solid(&self, number: usize) -> &[Probe<D>] {
        &self.0[number]
    }
}

/// Two solids, or a solid and a side, near each other at a point.
#[derive(Clone, Debug)]
struct Contact<const D: usize> {
    /// The solid that the normal points to, and the other; none for a side.
    pair: (usize, Option<usize>),
    /// Midway between them, m.
    at: Vector<D>,
    normal: Vector<D>,
    /// Distance, m.
    gap: f64,
    /// Distance that is left after the coming step if nothing acts, m.
    left: f64,
    /// Least speed apart that is asked for, m/s.
    target: f64,
    /// Impulse along the normal so far, N s.
    push: f64,
    /// The same across it.
    rub: Vector<D>,
}

impl<const D: usize> Contact<D> {
    /// The normal, away from the same one of both whichever is named first.
    fn facing(&self) -> Vector<D> {
        if self.pair.1 > Some(self.pair.0) { -self.normal } else { self.normal }
    }
}

/// The solids as contacts see them.
struct Contacts<'a, const D: usize> {
    model: &'a Model<D>,
    solids: &'a mut [SolidState<D>],
    /// Inverse mass and moments of inertia; zero for what nothing moves.
    inverse: Vec<(f64, Matrix<3>)>,
    all: Vec<Contact<D>>,
}

/// What the forces of this step did to the solids, before they collide.
struct Forced<'a, const D: usize> {
    before: &'a [SolidState<D>],
    after: Vec<SolidState<D>>,
    times: Times,
}

impl<const D: usize> Forced<'_, D> {
    /// Speed with which the forces drive both together, m/s.
    fn together(&self, c: &Contact<D>) -> f64 {
        (speed(self.before, c) - speed(&self.after, c)).dot(&c.normal)
    }

    /// Speed apart of what approaches and bounces. It does so a little early, and velocities are half a step ahead of
    /// positions: what the forces do on the way to the surface and back is counted, so that a ball comes back as high as
    /// its restitution says.
    fn back(&self, c: &Contact<D>, approach: f64, restitution: f64, early: f64) -> f64 {
        let pull = self.together(c) / self.times.kick;
        let (lead, fall) = (0.5 * pull * self.times.dt, 2.0 * pull * early);
        let touching = (approach - lead).powi(2) + fall;
        (restitution * restitution * touching - fall).max(0.0).sqrt() - lead
    }
}

/// The times of a step, s.
#[derive(Clone, Copy, Debug)]
pub struct Times {
    /// Its length.
    pub dt: f64,
    /// For how long its forces acted.
    pub kick: f64,
    /// Bound of the coming step.
    pub ahead: f64,
}

/// Pushes solids so that they do not meet in the coming step; `before` is how they moved before the forces of this one. Gives
/// back the work, J, of solids that go as told; `record` takes what did not come to its end.
pub fn collide<const D: usize>(
    model: &Model<D>,
    solids: &mut [SolidState<D>],
    probes: &Probes<D>,
    before: &[SolidState<D>],
    times: Times,
    record: &mut Repairs,
) -> f64 {
    let Times { kick, ahead, .. } = times;
    let forced = Forced { before, after: solids.to_vec(), times };
    let mut contacts = Contacts::find(model, solids, probes, ahead);
    let mut work = 0.0;
    for round in 0..=ROUNDS {
        let hits = contacts.hits(&forced);
        if hits.is_empty() {
            break;
        }
        if round == ROUNDS {
            record.contact_rounds += 1;
            break;
        }
        work += contacts.bounce(&hits, record);
        contacts = Contacts::find(model, contacts.solids, probes, ahead);
    }
    let apart = |c: &Contact<D>| -(c.gap - GAP * model.grid.dx).max(0.0) / ahead;
    contacts.all.iter_mut().for_each(|c| c.target = apart(c));
    let free: Vec<SolidState<D>> = contacts.solids.to_vec();
    let every: Vec<usize> = (0..contacts.all.len()).collect();
    work += contacts.solve(&every, record);
    for (now, free) in solids.iter_mut().zip(&free) {
        now.held = (now.velocity - free.velocity) / kick;
        now.braced = std::array::from_fn(|a| (now.spin[a] - free.spin[a]) / kick);
    }
    work
}

/// Adds to the free solids' velocity what the contacts of the last step would in `time` (s). With it the liquid is solved
/// for, and without it they collide: else the liquid beneath a solid at rest would be pushed as if it fell, in every step.
pub fn lean<const D: usize>(solids: &mut [SolidState<D>], time: f64) {
    for now in solids {
        now.velocity += now.held * time;
        (0..3).for_each(|i| now.spin[i] += now.braced[i] * time);
    }
}

/// Moves rigid solids apart that overlap; `record` takes where and how deep.
pub fn part<const D: usize>(
    model: &Model<D>,
    solids: &mut [SolidState<D>],
    probes: &Probes<D>,
    record: &mut Repairs,
) {
    let mut still = solids.to_vec();
    still.iter_mut().for_each(SolidState::stop);
    let mut contacts = Contacts::find(model, &mut still, probes, 0.0);
    contacts.all.retain(|c| c.gap < 0.0);
    contacts.all.iter_mut().for_each(|c| c.target = -c.gap);
    let every: Vec<usize> = (0..contacts.all.len()).collect();
    if !every.is_empty() {
        let depth = contacts.all.iter().map(|c| -c.gap).fold(0.0, f64::max);
        record.parted += every.len() as u64;
        record.parted_depth = record.parted_depth.max(depth);
        record.contact_sweeps += u64::from(!contacts.slide(&every, 0.0));
        for ((now, way), solid) in solids.iter_mut().zip(&still).zip(&model.solids) {
            solid.shift(now, &way.velocity, &way.spin);
        }
    }
}

/// Numbers of two solids that overlap, and how deep, m; no second one for a side of the domain, the same twice for a solid
/// that runs through itself.
pub type Overlap = (usize, Option<usize>, f64);

/// What solids overlap where they are. Those that nothing moves may.
pub fn overlaps<const D: usize>(model: &Model<D>, solids: &[SolidState<D>]) -> Vec<Overlap> {
    let mut still = solids.to_vec();
    still.iter_mut().for_each(SolidState::stop);
    let mut probes = Probes::of(model);
    let soft = start::soft_overlaps(model, solids, &probes);
    // Surfaces that lie on each other do not tell; a ball inside each does.
    for (probes, solid) in probes.0.iter_mut().zip(&model.solids) {
        let (at, radius) = (solid.body.center, -solid.shape.signed_distance(&solid.body.center));
        probes.extend((radius > 0.0 && radius.is_finite()).then_some(Probe { at, radius, sharp: false }));
    }
    let contacts = Contacts::find(model, &mut still, &probes, 0.0);
    contacts.all.iter().map(|c| (c.pair.0, c.pair.1, -c.gap)).filter(|c| c.2 > 0.0).chain(soft).collect()
}

impl<'a, const D: usize> Contacts<'a, D> {
    /// The contacts of all pairs of which one is free, for a step of `ahead` seconds.
    fn find(model: &'a Model<D>, solids: &'a mut [SolidState<D>], probes: &Probes<D>, ahead: f64) -> Self {
        let free = |i: usize| model.solids[i].motion == Motion::Free;
        let inverse = model.solids.iter().zip(&*solids).map(|(s, now)| match s.motion {
            Motion::Free => (1.0 / s.body.mass, s.inverse_inertia(now)),
            _ => (0.0, Matrix::zeros()),
        });
        let inverse = inverse.collect();
        let near = Near { model, solids, probes, ahead };
        let mut all = Vec::new();
        // Sides are met as such, whatever liquid does at them.
        let rigid = |i: &usize| model.wetting_walls() != Some(*i) && model.solids[*i].elastic().is_none();
        for i in (0..model.solids.len()).filter(rigid) {
            if free(i) {
                near.sides(i, &mut all);
            }
            for j in (0..i).filter(|j| rigid(j) && (free(i) || free(*j))) {
                all.extend(thin(near.pair(i, j)));
            }
        }
        Self { model, solids, inverse, all }
    }

    /// How fast both move apart, m/s.
    fn apart(&self, c: &Contact<D>) -> Vector<D> {
        speed(self.solids, c)
    }

    /// The contacts that something is going to hit, and at what speed it shall leave them. What the forces of the last
    /// step alone brought about is no hit: it rests.
    fn hits(&mut self, forced: &Forced<'_, D>) -> Vec<usize> {
        let (dx, ahead) = (self.model.grid.dx, forced.times.ahead);
        let mut hits = Vec::new();
        for k in 0..self.all.len() {
            let c = &self.all[k];
            let approach = -self.apart(c).dot(&c.normal);
            let resting = 2.0 * forced.together(c).abs() + 1e-6 * dx / ahead;
            if approach > resting && c.gap - approach * ahead < (GAP - 1e-6) * dx {
                let early = (c.gap - GAP * dx).max(0.0);
                let back = forced.back(c, approach, self.pairing(c, |s| s.restitution), early);
                self.all[k].target = if back > resting { back } else { -early / ahead };
                hits.push(k);
            }
        }
        hits
    }

    /// Solves for hits. Energy that they would make (what bounces at several points and rubs can) they do not get: they
    /// stop instead.
    fn bounce(&mut self, hits: &[usize], record: &mut Repairs) -> f64 {
        let given = |i: usize| matches!(self.model.solids[i].motion, Motion::Given(_));
        let told = |c: &Contact<D>| given(c.pair.0) || c.pair.1.is_some_and(given);
        let told = hits.iter().any(|&k| told(&self.all[k]));
        let (start, energy) = (self.solids.to_vec(), self.energy());
        let work = self.solve(hits, record);
        if told || self.energy() <= energy * (1.0 + 1e-12) {
            return work;
        }
        self.solids.clone_from_slice(&start);
        hits.iter().for_each(|&k| self.all[k].target = self.all[k].target.min(0.0));
        record.stopped_bounces += 1;
        self.solve(hits, record)
    }

    fn energy(&self) -> f64 {
        let free = self.model.solids.iter().zip(&*self.solids).filter(|(s, _)| s.motion == Motion::Free);
        free.map(|(s, now)| s.kinetic_energy(now)).sum()
    }

    /// Finds the impulses of some contacts. Gives back the work of solids that go as told.
    fn solve(&mut self, some: &[usize], record: &mut Repairs) -> f64 {
        record.contact_sweeps += u64::from(!self.slide(some, 1.0));
        let work = |&k: &usize| {
            let c = &self.all[k];
            let impulse = c.normal * c.push + c.rub;
            let of = |i: usize| {
                if self.inverse[i].0 == 0.0 { self.solids[i].velocity_at(&c.at).dot(&impulse) } else { 0.0 }
            };
            c.pair.1.map_or(0.0, of) - of(c.pair.0)
        };
        some.iter().map(work).sum()
    }

    /// Gauss-Seidel; `rough` is what friction counts. Gives back whether it came to its end.
    fn slide(&mut self, some: &[usize], rough: f64) -> bool {
        for &k in some {
            (self.all[k].push, self.all[k].rub) = (0.0, Vector::zeros());
        }
        let of = |c: &Contact<D>, i: usize| self.solids[i].velocity_at(&c.at).norm();
        let fastest = |c: &Contact<D>| {
            c.pair.1.map_or(c.target.abs(), |j| of(c, j).max(c.target.abs())).max(of(c, c.pair.0))
        };
        let scale = some.iter().map(|&k| fastest(&self.all[k])).fold(0.0, f64::max);
        for sweep in 0..2 * SWEEPS {
            let mut change = 0.0f64;
            for n in 0..some.len() {
                let k = some[if sweep % 2 == 0 { n } else { some.len() - 1 - n }];
                change = change.max(self.relax(k, rough));
            }
            if change <= EXACT * scale {
                return true;
            }
        }
        false
    }

    /// Puts one contact right. Gives back how much its speed changed.
    fn relax(&mut self, k: usize, rough: f64) -> f64 {
        let c = self.all[k].clone();
        let friction = rough * self.pairing(&c, |s| s.friction);
        let miss = c.target - self.apart(&c).dot(&c.normal);
        let push = (c.push + miss / self.lightness(&c, &c.normal)).max(0.0);
        let pushed = c.normal * (push - c.push);
        self.give(&c, &pushed);
        let speed = self.apart(&c);
        let across = speed - c.normal * speed.dot(&c.normal);
        let stop = across.try_normalize(0.0).map_or(across, |along| across / self.lightness(&c, &along));
        let rub = (c.rub - stop).cap_magnitude(friction * push);
        let rubbed = rub - c.rub;
        self.give(&c, &rubbed);
        (self.all[k].push, self.all[k].rub) = (push, rub);
        let impulse = pushed + rubbed;
        impulse.try_normalize(0.0).map_or(0.0, |n| impulse.norm() * self.lightness(&c, &n))
    }

    /// Change of the speed apart along a direction for an impulse along it, 1/kg.
    fn lightness(&self, c: &Contact<D>, along: &Vector<D>) -> f64 {
        let of = |i: usize| {
            let turning = moment(&(c.at - self.solids[i].center), along);
            self.inverse[i].0 + turning.dot(&(self.inverse[i].1 * turning))
        };
        of(c.pair.0) + c.pair.1.map_or(0.0, of)
    }

    /// Gives an impulse to the first and takes it from the second.
    fn give(&mut self, c: &Contact<D>, impulse: &Vector<D>) {
        let sides = [Some((c.pair.0, 1.0)), c.pair.1.map(|j| (j, -1.0))];
        for (i, sign) in sides.into_iter().flatten() {
            let (lightness, turn) = &self.inverse[i];
            let now = &mut self.solids[i];
            now.velocity += impulse * (sign * lightness);
            let spun = turn * moment(&(c.at - now.center), impulse) * sign;
            (0..3).for_each(|a| now.spin[a] += spun[a]);
        }
    }

    /// What a property of both makes together: the geometric mean; of a side, the solid's own.
    fn pairing(&self, c: &Contact<D>, of: impl Fn(&Solid<D>) -> f64) -> f64 {
        let first = of(&self.model.solids[c.pair.0]);
        (first * c.pair.1.map_or(first, |j| of(&self.model.solids[j]))).sqrt()
    }
}

/// How fast both move apart at a contact, m/s.
fn speed<const D: usize>(solids: &[SolidState<D>], c: &Contact<D>) -> Vector<D> {
    let other = c.pair.1.map_or(Vector::zeros(), |j| solids[j].velocity_at(&c.at));
    solids[c.pair.0].velocity_at(&c.at) - other
}
