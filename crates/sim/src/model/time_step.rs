//! Step lengths: their bounds, and the impulse time of each step (leapfrog with variable step length).

use super::Model;
use crate::solid::SolidState;

/// Called with the name of each phase of a step at its end; the caller owns the clock.
pub type PhaseEnd<'a> = &'a mut dyn FnMut(&'static str);

/// Largest ratio of a step length to the one before.
pub const MAX_DT_GROWTH: f64 = 1.25;
/// Largest change of the deformation gradient of an element in a step at the velocities before it (Frobenius norm). The forces that
/// Newton's method lags differ from those at the midpoint in second order of this change: at 0.5 it takes about ten iterations, at
/// several times that it may diverge (experiment E35).
const MAX_DEFORMATION_INCREMENT: f64 = 0.5;
/// The same at the velocities after the step. A step in which it is larger is tried again with half its length.
pub const MAX_FORCED_DEFORMATION_INCREMENT: f64 = 2.0 * MAX_DEFORMATION_INCREMENT;

/// The times of a step, s.
#[derive(Clone, Copy, Debug)]
pub struct StepTimes {
    /// Step length.
    pub dt: f64,
    /// Impulse time: time for which the forces act.
    pub impulse_time: f64,
    /// Velocity lead after the forces have acted.
    pub velocity_lead: f64,
    /// Bound of the next step length.
    pub lookahead: f64,
    /// Whether no step has been completed before.
    pub is_first: bool,
}

/// Smallest ratio of an impulse time to the one before for which the neutral rule is used. If the step length falls to `r` of
/// the last one, the rule gives the ratio `2 r − 1`, which must be positive. A step halved after a failure is below any such
/// ratio; one that follows a growing speed (`r` > 0.8) is above it. With 0.25 a single step may fall to 0.62.
const MIN_IMPULSE_TIME_RATIO: f64 = 0.25;

/// Impulse time of a step of length `dt`, s (leapfrog with variable step length), between 0.5 and 1.5 times `dt`.
pub fn impulse_time(velocity_lead: f64, dt: f64) -> f64 {
    unbounded_impulse_time(velocity_lead, dt).clamp(0.5 * dt, 1.5 * dt)
}

/// [`impulse_time`] without bounds.
///
/// With the velocity lead `l`, the position `q = x + l v` at the time of the velocity moves by `(Δt − l) v + l' v'` while forces act for
/// `h = Δt − l + l'`. The neutral rule `l' = Δt − l` makes this `h` times the mean velocity: the work of the forces equals the change of
/// `½ v²`, and angular momentum is conserved. If a step shortens abruptly, this leaves no impulse time. Then `l' = Δt/2`, which is
/// larger, and the energy falls by `(l'/h − ½) m (v' − v)²`. [`next_dt`] chooses steps for which the rule holds.
pub fn unbounded_impulse_time(velocity_lead: f64, dt: f64) -> f64 {
    let neutral = 2.0 * (dt - velocity_lead);
    if neutral >= 2.0 * MIN_IMPULSE_TIME_RATIO * velocity_lead { neutral } else { 1.5 * dt - velocity_lead }
}

/// Length of the next step, s, at most `max_dt`, such that steps of equal length reach `remaining_time` (possibly infinite). A
/// step covers half of the last impulse time and half of the next one, which is as close to `max_dt` as possible.
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

/// Divides a time into the fewest steps of equal length not over `max_dt`; `max_dt` if the time is infinite.
pub fn uniform_dt(remaining_time: f64, max_dt: f64) -> f64 {
    if remaining_time.is_finite() {
        remaining_time / (remaining_time / max_dt * (1.0 - 1e-9)).ceil().max(1.0)
    } else {
        max_dt
    }
}

/// Longest step, s, that the Courant number at a speed (m/s), surface tension, gravity and the user allow.
pub fn stable_dt<const D: usize>(model: &Model<D>, speed: f64) -> f64 {
    let n = &model.numerics;
    let fall = model.gravity.norm();
    // speed·dt + ½ fall·dt² = cfl·Δ
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

/// Longest step that may follow one of `dt` (s) at the present speeds of the solids, with a margin for their slowing down in
/// contacts. Contacts are detected over this time, and no step is longer. Over a longer time a solid accelerated by the
/// pressure would seem to hit obstacles on a path that it never travels.
pub fn lookahead_time<const D: usize>(model: &Model<D>, solids: &[SolidState<D>], dt: f64) -> f64 {
    if model.numerics.fixed_step.is_some() {
        return MAX_DT_GROWTH * dt;
    }
    let fastest = model.solids.iter().zip(solids).map(|(s, now)| s.max_speed(now)).fold(0.0, f64::max);
    MAX_DT_GROWTH * dt.min(stable_dt(model, fastest)).min(deformation_dt(model, solids))
}

/// Longest step, s, in which no element of a deformable solid deforms by more than [`MAX_DEFORMATION_INCREMENT`] at the present
/// velocities.
pub fn deformation_dt<const D: usize>(model: &Model<D>, solids: &[SolidState<D>]) -> f64 {
    let rates = model.deformable_solids(solids);
    let rate = rates.map(|(elastic, now)| elastic.max_deformation_rate(&now.velocities)).fold(0.0, f64::max);
    if rate > 0.0 { MAX_DEFORMATION_INCREMENT / rate } else { f64::INFINITY }
}
