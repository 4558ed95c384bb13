//! Lengths of steps: what bounds them, and for how long forces act in them (leapfrog with steps of any length).

use super::Model;
use crate::solid::SolidState;

/// Called at the end of every phase of a step with its name; the caller owns the clock.
pub type PhaseEnd<'a> = &'a mut dyn FnMut(&'static str);

/// Most that a step may be longer than the one before.
pub const MAX_DT_GROWTH: f64 = 1.25;
/// The times of a step, s.
#[derive(Clone, Copy, Debug)]
pub struct StepTimes {
    /// Its length.
    pub dt: f64,
    /// For how long its forces act.
    pub impulse_time: f64,
    /// How far the velocities are then ahead of the positions.
    pub velocity_lead: f64,
    /// Bound of the coming step.
    pub lookahead: f64,
    /// Whether its forces are the first.
    pub is_first: bool,
}

/// Least ratio of the time for which forces act to that of the step before, with which the neutral rule is followed. The rule takes a step
/// whose length falls to `r` of the last to `2 r − 1`, which has to be positive: a step halved after a failure is below any such ratio, one
/// that follows a growing speed (`r` over 0.8) above it. At 0.25 a single step falls to 0.62.
const MIN_IMPULSE_TIME_RATIO: f64 = 0.25;

/// For how long the forces act at the end of a step (leapfrog with steps of any length; design, numerics §8), within bounds.
pub fn impulse_time(velocity_lead: f64, dt: f64) -> f64 {
    unbounded_impulse_time(velocity_lead, dt).clamp(0.5 * dt, 1.5 * dt)
}

/// The same without bounds. The place `q = x + l v` at the time of a velocity that is `l` ahead moves by `(h − l) v + l' v'` while forces
/// act for `t = h − l + l'`. With `l' = h − l` that is `t` times the mean velocity: the forces' work is what `½ v²` gains, and angular
/// momentum is kept, too. A step that is short all at once leaves no time for that; there `l' = h/2`, which is longer, and the energy
/// falls by `(l'/t − ½) m (v' − v)²`. Coming steps are chosen so that the rule holds ([`next_dt`]).
pub fn unbounded_impulse_time(velocity_lead: f64, dt: f64) -> f64 {
    let neutral = 2.0 * (dt - velocity_lead);
    if neutral >= 2.0 * MIN_IMPULSE_TIME_RATIO * velocity_lead { neutral } else { 1.5 * dt - velocity_lead }
}

/// The coming step, s, where velocities are `velocity_lead` ahead: at most `max_dt`, and such that steps of one length follow until the time
/// `remaining_time` (which may be infinite) is over. Steps go from half of the last time for which forces acted to half of the next one, which
/// is as near to `max_dt` as can be.
pub fn next_dt(velocity_lead: f64, max_dt: f64, remaining_time: f64) -> f64 {
    let impulse_time = max_dt.min(2.0 * (max_dt - velocity_lead));
    if impulse_time < 2.0 * MIN_IMPULSE_TIME_RATIO * velocity_lead
        || remaining_time - velocity_lead < MIN_IMPULSE_TIME_RATIO * velocity_lead
    {
        return uniform_dt(remaining_time, max_dt);
    }
    if remaining_time.is_infinite() {
        return velocity_lead + 0.5 * impulse_time;
    }
    // `remaining_time = velocity_lead + ½ impulse_time + (n − 1) impulse_time` with n steps.
    let steps = ((remaining_time - velocity_lead) / impulse_time * (1.0 - 1e-9) + 0.5).ceil().max(1.0);
    if steps == 1.0 {
        remaining_time
    } else {
        velocity_lead + 0.5 * (remaining_time - velocity_lead) / (steps - 0.5)
    }
}

/// A time divided into as few steps of one length as can be with none over `max_dt`; that where the time is infinite.
pub fn uniform_dt(remaining_time: f64, max_dt: f64) -> f64 {
    if remaining_time.is_finite() {
        remaining_time / (remaining_time / max_dt * (1.0 - 1e-9)).ceil().max(1.0)
    } else {
        max_dt
    }
}

/// The longest step, s, in which nothing at a speed (m/s) goes farther than the Courant number allows, and which tension,
/// gravity and the user allow.
pub fn stable_dt<const D: usize>(model: &Model<D>, speed: f64) -> f64 {
    let n = &model.numerics;
    let fall = model.gravity.norm();
    // speed·h + ½ fall·h² = cfl·Δ
    let max_displacement = n.cfl * model.grid.dx;
    let advective_dt =
        2.0 * max_displacement / (speed + (speed * speed + 2.0 * fall * max_displacement).sqrt()).max(1e-300);
    let capillary_dt = if model.surface_tension > 0.0 {
        n.capillary_step * model.capillary_dt_limit()
    } else {
        f64::INFINITY
    };
    advective_dt.min(n.max_step).min(capillary_dt)
}

/// The longest that the step after one of `dt` (s) can be, as solids move now, or a little slower once they have met: for so
/// long contacts are looked for, and no step is longer. Over a longer time a solid that the pressure threw would seem to meet all there is on a way that it never
/// goes.
pub fn lookahead_time<const D: usize>(model: &Model<D>, solids: &[SolidState<D>], dt: f64) -> f64 {
    if model.numerics.fixed_step.is_some() {
        return MAX_DT_GROWTH * dt;
    }
    let fastest = model.solids.iter().zip(solids).map(|(s, now)| s.max_speed(now)).fold(0.0, f64::max);
    MAX_DT_GROWTH * dt.min(stable_dt(model, fastest))
}
