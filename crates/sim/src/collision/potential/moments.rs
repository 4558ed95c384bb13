//! The moments of a step at which distances between solids are compared, and which pairs feel their barrier at which.

use crate::collision::places::Places;
use crate::collision::points::{Meeting, Points};
use crate::model::Model;
use crate::solid::SolidState;
use meniscus_contact::Stencil;
use meniscus_numerics::Vector;
use std::collections::BTreeSet;

/// Solids at a time, and their points.
pub struct Moment<'a, const D: usize> {
    /// The solids.
    pub places: Places<'a, D>,
    /// Where all points are, m.
    pub at: Vec<Vector<D>>,
}

/// The two moments of a step that do not depend on the new velocities.
pub struct Past<'a, const D: usize> {
    /// At the time of the old velocities.
    before: Moment<'a, D>,
    /// When the forces act.
    pub start: Moment<'a, D>,
}

impl<'a, const D: usize> Past<'a, D> {
    /// Of solids that have gone with the old velocities of their nodes for a time `since`, s.
    pub fn new(
        model: &'a Model<D>,
        solids: &'a [SolidState<D>],
        points: &'a Points<D>,
        old: &'a [Vector<D>],
        since: f64,
    ) -> Self {
        let [before, start] =
            [-since, 0.0].map(|time| Moment::new(Places::new(model, solids, points, old, time)));
        Self { before, start }
    }
}

/// The moments of a step at which distances between solids are compared.
pub struct Moments<'a, const D: usize> {
    pub(super) past: &'a Past<'a, D>,
    /// At the time of the new velocities.
    pub early: Moment<'a, D>,
    /// At the end of the coming step.
    pub late: Moment<'a, D>,
}

/// The pairs that feel their barrier at the time of the new velocities, the others at the end of the coming step. Which do depends on the
/// velocities, and where it changes the potential jumps, so that Newton's method would end at the jump: it is lagged, as friction's
/// normal forces are.
#[derive(Clone, Debug, Default)]
pub struct Early {
    pub(super) contacts: BTreeSet<Stencil>,
    pub(super) meetings: BTreeSet<Meeting>,
}

impl Early {
    /// Keeps those that are among others, too. Pairs that may only leave within Newton's iterations do not go to and fro.
    pub fn keep(&mut self, others: &Self) {
        self.contacts.retain(|c| others.contacts.contains(c));
        self.meetings.retain(|m| others.meetings.contains(m));
    }
}

/// One of the two moments at which barriers are felt.
pub struct Felt<'a, const D: usize> {
    moments: &'a Moments<'a, D>,
    pub(super) early: bool,
}

impl<'a, const D: usize> Moments<'a, D> {
    /// Whether a pair that came towards each other is nearer at the time of the new velocities than at the end of the coming step.
    pub(super) fn is_early(&self, distance: impl Fn(&Moment<'a, D>) -> f64) -> bool {
        let Moments { past, early, late } = self;
        distance(early) < distance(late) && distance(&past.before) > distance(&past.start)
    }

    /// Both moments at which barriers are felt.
    pub fn felt(&'a self) -> [Felt<'a, D>; 2] {
        [false, true].map(|early| Felt { moments: self, early })
    }
}

impl<'a, const D: usize> Felt<'a, D> {
    /// The moment.
    pub fn now(&self) -> &'a Moment<'a, D> {
        if self.early { &self.moments.early } else { &self.moments.late }
    }
}

impl<'a, const D: usize> Moment<'a, D> {
    pub(super) fn new(places: Places<'a, D>) -> Self {
        Self { at: places.all(), places }
    }
}
