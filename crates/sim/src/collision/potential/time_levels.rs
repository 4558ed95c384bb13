//! Time levels of a step at which distances between solids are evaluated, and the pairs whose barrier uses each.

use crate::collision::configuration::Configuration;
use crate::collision::points::{CollisionPoints, SdfPair};
use crate::model::Model;
use crate::solid::SolidState;
use meniscus_contact::Stencil;
use meniscus_numerics::Vector;
use std::collections::BTreeSet;
use std::sync::OnceLock;

/// Configuration of the solids at a time.
pub struct TimeLevel<'a, const D: usize> {
    /// The solids.
    pub configuration: Configuration<'a, D>,
    /// Positions of all points, m, once they have been asked for.
    positions: OnceLock<Vec<Vector<D>>>,
}

/// The two time levels that do not depend on the new velocities.
pub struct OldTimeLevels<'a, const D: usize> {
    /// At the time of the old velocities.
    before: TimeLevel<'a, D>,
    /// At the start of the coming step, when the forces act.
    pub start: TimeLevel<'a, D>,
}

impl<'a, const D: usize> OldTimeLevels<'a, D> {
    /// Levels of solids that have moved with the old velocities of their nodes for the time `since`, s.
    pub fn new(
        model: &'a Model<D>,
        solids: &'a [SolidState<D>],
        points: &'a CollisionPoints<D>,
        old: &'a [Vector<D>],
        since: f64,
    ) -> Self {
        let [before, start] =
            [-since, 0.0].map(|time| TimeLevel::new(Configuration::new(model, solids, points, old, time)));
        Self { before, start }
    }
}

/// All time levels of a step.
pub struct TimeLevels<'a, const D: usize> {
    pub(super) past: &'a OldTimeLevels<'a, D>,
    /// At the time of the new velocities.
    pub early: TimeLevel<'a, D>,
    /// At the end of the coming step.
    pub late: TimeLevel<'a, D>,
}

/// The pairs whose barrier is evaluated at the time of the new velocities instead of the end of the coming step. The choice depends on
/// the velocities and makes the potential discontinuous, so it is lagged, like the normal forces of friction.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EarlyPairs {
    pub(super) contacts: BTreeSet<Stencil>,
    pub(super) sdf_pairs: BTreeSet<SdfPair>,
}

impl EarlyPairs {
    /// Keeps only pairs that are also in `others`. As pairs can only leave during the Newton iterations, the set cannot alternate.
    pub fn retain_common(&mut self, others: &Self) {
        self.contacts.retain(|c| others.contacts.contains(c));
        self.sdf_pairs.retain(|m| others.sdf_pairs.contains(m));
    }
}

/// One of the two time levels at which barriers are evaluated.
pub struct BarrierLevel<'a, const D: usize> {
    moments: &'a TimeLevels<'a, D>,
    pub(super) early: bool,
}

impl<'a, const D: usize> TimeLevels<'a, D> {
    /// Whether an approaching pair is nearer at the time of the new velocities than at the end of the coming step.
    pub(super) fn is_early(&self, distance: impl Fn(&TimeLevel<'a, D>) -> f64) -> bool {
        let TimeLevels { past, early, late } = self;
        distance(early) < distance(late) && distance(&past.before) > distance(&past.start)
    }

    /// Both time levels at which barriers are evaluated.
    pub fn barrier_levels(&'a self) -> [BarrierLevel<'a, D>; 2] {
        [false, true].map(|early| BarrierLevel { moments: self, early })
    }
}

impl<'a, const D: usize> BarrierLevel<'a, D> {
    /// The time level.
    pub fn time_level(&self) -> &'a TimeLevel<'a, D> {
        if self.early { &self.moments.early } else { &self.moments.late }
    }
}

impl<'a, const D: usize> TimeLevel<'a, D> {
    pub(super) fn new(configuration: Configuration<'a, D>) -> Self {
        Self { configuration, positions: OnceLock::new() }
    }

    /// Positions of all points, m.
    pub fn positions(&self) -> &[Vector<D>] {
        self.positions.get_or_init(|| self.configuration.positions())
    }
}
