//! Collisions in which solids deform.
//!
//! Contacts are found, solved for, and looked for again with the velocities that this gives: those that were missed join,
//! until nothing meets in the coming step. Should that not end soon, what still meets goes on as one rigid body (X. Provot,
//! Graphics Interface 1997; R. Bridson, R. Fedkiw, J. Anderson, SIGGRAPH 2002): a linear motion `x + t (v + ω × x)` is one
//! to one for every `t`, so that nothing within it can meet. Both momenta stay as they are.

use super::meet::{Key, Meet};
use super::pair::Pair;
use super::skins::Skins;
use super::touch::{Answers, End, Touch};
use super::zones::Zones;
use super::{Contacts, Probes, Times};
use crate::collide::respond::Response;
use crate::model::Model;
use crate::repairs::Repairs;
use crate::soft::Systems;
use crate::solid::{Motion, SolidState};
use meniscus_numerics::Vector;
use std::collections::BTreeMap;

/// Times that contacts are looked for.
const LOOKS: usize = 8;
/// Times that what meets is made rigid.
const FREEZES: usize = 12;

/// The solids of a model, and how they answer.
pub struct Settling<'a, const D: usize> {
    /// The model.
    pub model: &'a Model<D>,
    /// Probes of rigid solids.
    pub probes: &'a Probes<D>,
    /// The matrices of those that deform.
    pub systems: &'a Systems<D>,
    /// The times of the step.
    pub times: Times,
}

impl<const D: usize> Settling<'_, D> {
    /// Pushes solids so that nothing meets in the coming step. `rigid` are the contacts of rigid solids, with their targets.
    /// Gives back the work, J, of solids that go as told; `record` takes what did not come to its end.
    pub fn settle(&self, solids: &mut [SolidState<D>], rigid: Contacts<'_, D>, record: &mut Repairs) -> f64 {
        let mut answers = self.answers(solids, &rigid);
        let mut touches: BTreeMap<Key, Touch<D>> = BTreeMap::new();
        for (k, contact) in rigid.all.iter().enumerate() {
            touches.insert((16, k as u32, [0; 3]), rigid.touch(contact));
        }
        let free = solids.to_vec();
        let mut skins = Skins::new(self.model, solids, self.probes);
        for look in 0..LOOKS {
            let found = self.look(solids, &skins, look > 0);
            let before = touches.len();
            for (key, touch) in found {
                touches.entry(key).or_insert(touch);
            }
            if touches.len() == before && (look > 0 || before == 0) {
                break;
            }
            let mut all: Vec<Touch<D>> = touches.values().cloned().collect();
            let solved = answers.solve(&free, &mut all);
            record.contact_sweeps += u64::from(!solved.swept);
            record.contact_corrections += u64::from(!solved.corrected);
            record.contact_looks += u64::from(look + 1 == LOOKS);
            solids.clone_from_slice(&free);
            answers.give(solids, all.iter());
            touches.values_mut().zip(all).for_each(|(old, new)| *old = new);
            skins.follow(solids);
        }
        self.freeze(solids, &mut skins, record);
        self.hold(solids, &answers, &touches);
        touches.values().map(|t| self.work(solids, t)).sum()
    }

    fn answers<'b>(&'b self, solids: &[SolidState<D>], rigid: &Contacts<'_, D>) -> Answers<'b, D> {
        let all = self.model.solids.iter().zip(self.systems).zip(solids);
        let soft = all.map(|((solid, system), now)| Response::new(solid.elastic(), system.as_ref(), now));
        Answers { soft: soft.collect(), rigid: rigid.inverse.clone() }
    }

    /// Contacts of the solids as they move now; `close`: also what meets on the way.
    fn look(&self, solids: &[SolidState<D>], skins: &Skins<D>, close: bool) -> Vec<(Key, Touch<D>)> {
        let meet = Meet { model: self.model, solids, skins, ahead: self.times.ahead };
        let mut all = Vec::new();
        let pairs = self.moving(meet.pairs(), skins);
        meet.along_lines(&pairs, &mut all);
        meet.sides(&mut all);
        meet.rigid(&mut all);
        if close {
            all.extend(meet.met(&pairs).iter().map(|(pair, time)| meet.on_the_way(pair, *time)));
            all.extend(meet.met_rigid().iter().map(|(p, j, time)| meet.in_rigid(*p, *j, *time)));
        }
        all
    }

    /// The pairs of which something can be pushed.
    fn moving(&self, pairs: Vec<Pair>, skins: &Skins<D>) -> Vec<Pair> {
        let loose = |p: &u32| !self.is_told(skins, *p);
        pairs.into_iter().filter(|pair| pair.points(skins).iter().flatten().any(loose)).collect()
    }

    /// Whether nothing that happens changes how a point moves.
    fn is_told(&self, skins: &Skins<D>, point: u32) -> bool {
        let owner = skins.owner[point as usize];
        let solid = &self.model.solids[owner.solid];
        match (solid.elastic(), owner.vertex) {
            (Some(elastic), Some(vertex)) => elastic.held()[vertex as usize],
            _ => solid.motion.is_told(),
        }
    }

    /// The last resort; `record` takes how many points it is for, and whether something meets all the same.
    fn freeze(&self, solids: &mut [SolidState<D>], skins: &mut Skins<D>, record: &mut Repairs) {
        let mut zones: Option<Zones<'_, D>> = None;
        let mut frozen = 0;
        for freeze in 0..=FREEZES {
            let meet = Meet { model: self.model, solids, skins, ahead: self.times.ahead };
            let pairs = meet.met(&self.moving(meet.pairs(), skins));
            let rigid = meet.met_rigid();
            let sides: Vec<u32> = meet.met_sides().into_iter().filter(|p| !self.is_told(skins, *p)).collect();
            if pairs.is_empty() && rigid.is_empty() && sides.is_empty() {
                break;
            }
            if freeze == FREEZES {
                record.contact_freezes += 1;
                break;
            }
            let zones = zones.get_or_insert_with(|| Zones::new(self.model, skins));
            pairs.iter().for_each(|(pair, _)| zones.join(&pair.points(skins).concat(), skins));
            rigid.iter().for_each(|(p, j, _)| zones.join_rigid(*p as u32, *j));
            sides.iter().for_each(|p| zones.join_side(*p));
            frozen = zones.freeze(solids, skins);
            skins.follow(solids);
        }
        record.frozen_points += frozen;
    }

    /// Keeps in mind what held the solids: of hits nothing.
    fn hold(
        &self,
        solids: &mut [SolidState<D>],
        answers: &Answers<'_, D>,
        touches: &BTreeMap<Key, Touch<D>>,
    ) {
        let mut held = solids.to_vec();
        held.iter_mut().for_each(SolidState::stop);
        answers.give(&mut held, touches.values().filter(|t| t.rests));
        for ((now, held), solid) in solids.iter_mut().zip(&mut held).zip(&self.model.solids) {
            let kick = self.times.kick;
            if let (Some(elastic), Some(soft), Some(by)) = (solid.elastic(), &mut now.soft, &held.soft) {
                soft.held = by.body.velocities.iter().map(|v| v / kick).collect();
                now.held = by.means(elastic).1 / kick;
                now.follow(elastic);
            } else {
                now.held = held.velocity / kick;
                now.braced = held.spin.map(|s| s / kick);
            }
        }
    }

    /// The work, J, of what goes as told.
    fn work(&self, solids: &[SolidState<D>], touch: &Touch<D>) -> f64 {
        let of = |end: &End<D>| match end {
            End::Rigid(i) if matches!(self.model.solids[*i].motion, Motion::Given(_)) => {
                solids[*i].velocity_at(&touch.at).dot(&touch.impulse())
            }
            _ => 0.0,
        };
        of(&touch.ends[1]) - of(&touch.ends[0])
    }
}

impl<const D: usize> Contacts<'_, D> {
    /// A contact of rigid solids among those of others.
    fn touch(&self, c: &super::Contact<D>) -> Touch<D> {
        Touch {
            ends: [End::Rigid(c.pair.0), c.pair.1.map_or(End::Side, End::Rigid)],
            at: c.at,
            normal: c.normal,
            target: c.target,
            friction: self.pairing(c, |s| s.friction),
            rests: true,
            push: 0.0,
            rub: Vector::zeros(),
        }
    }
}
