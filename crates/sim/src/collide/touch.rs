//! Contacts of which one side at least deforms, with those of rigid solids among them, and the impulses that keep them.
//!
//! Impulses and velocities at the contacts are related by `u = u₀ + W λ`, `W = G R Gᵀ`, where `R` is how solids answer
//! ([`Response`]) and `G` takes the velocities at contacts. `W` is found exactly, with a solve for every vertex that is
//! touched, and `λ` by Gauss-Seidel under Signorini's and Coulomb's conditions. Above [`MOST`] vertices of a solid `W` is
//! that of loose vertices, which is larger in every direction, and the true velocities are corrected step by step.

use super::respond::Response;
use super::zones::cross;
use crate::exchange::moment;
use crate::solid::SolidState;
use meniscus_numerics::{Matrix, Vector};

/// Sweeps of Gauss-Seidel, each there and back.
const SWEEPS: usize = 300;
/// Change of speed in a sweep, over the speeds there are, that ends it.
const EXACT: f64 = 1e-7;
/// Vertices of a solid that are touched up to which its answer is found exactly.
const MOST: usize = 1200;
/// Corrections of the velocities of more.
const CORRECTIONS: usize = 40;

/// What one side of a contact is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum End<const D: usize> {
    /// A side of the domain.
    Side,
    /// A rigid solid.
    Rigid(usize),
    /// A mean of vertices of a solid that deforms.
    Skin(usize, [(u32, f64); D]),
}

impl<const D: usize> End<D> {
    /// Number of the solid.
    pub fn solid(&self) -> Option<usize> {
        match self {
            Self::Side => None,
            Self::Rigid(i) | Self::Skin(i, _) => Some(*i),
        }
    }

    /// Where a mean of vertices is, m.
    fn place(&self, solids: &[SolidState<D>]) -> Vector<D> {
        match self {
            Self::Skin(i, mean) => solids[*i].soft.as_ref().map_or(Vector::zeros(), |soft| {
                mean.iter().map(|(v, w)| soft.body.positions[*v as usize] * *w).sum()
            }),
            _ => Vector::zeros(),
        }
    }

    /// How fast it moves at a point, m/s.
    pub fn speed(&self, solids: &[SolidState<D>], at: &Vector<D>) -> Vector<D> {
        match self {
            Self::Side => Vector::zeros(),
            Self::Rigid(i) => solids[*i].velocity_at(at),
            Self::Skin(i, mean) => {
                let of = |soft: &crate::Soft<D>| {
                    mean.iter().map(|(v, w)| soft.body.velocities[*v as usize] * *w).sum()
                };
                solids[*i].soft.as_ref().map_or(Vector::zeros(), of)
            }
        }
    }
}

/// A contact.
#[derive(Clone, Debug)]
pub struct Touch<const D: usize> {
    /// What the normal points to, and what it points away from.
    pub ends: [End<D>; 2],
    /// Where rigid ends are, m.
    pub at: Vector<D>,
    /// Its normal.
    pub normal: Vector<D>,
    /// Least speed apart, m/s.
    pub target: f64,
    /// Coulomb's coefficient of friction.
    pub friction: f64,
    /// Whether both were together before, and no hit is.
    pub rests: bool,
    /// Impulse on the first, N s, along the normal.
    pub push: f64,
    /// The same across it.
    pub rub: Vector<D>,
}

impl<const D: usize> Touch<D> {
    /// How fast both move apart, m/s.
    pub fn apart(&self, solids: &[SolidState<D>]) -> Vector<D> {
        self.ends[0].speed(solids, &self.at) - self.ends[1].speed(solids, &self.at)
    }

    /// Impulse on the first, N s.
    pub fn impulse(&self) -> Vector<D> {
        self.normal * self.push + self.rub
    }
}

/// How the search for impulses ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Solved {
    /// Whether the last sweeps converged.
    pub swept: bool,
    /// Whether the corrections of the velocities converged, where the exact answer is not known.
    pub corrected: bool,
}

/// Solids, and how they answer to impulses.
pub struct Answers<'a, const D: usize> {
    /// Of those that deform.
    pub soft: Vec<Option<Response<'a, D>>>,
    /// Inverse mass and moments of inertia of rigid ones; zero for what nothing moves.
    pub rigid: Vec<(f64, Matrix<3>)>,
}

impl<const D: usize> Answers<'_, D> {
    /// Gets to know what contacts take hold of.
    fn learn(&mut self, touches: &[Touch<D>]) {
        for (i, response) in self.soft.iter_mut().enumerate() {
            let Some(response) = response else { continue };
            let ends = touches.iter().flat_map(|t| &t.ends);
            let mut held: Vec<u32> = ends
                .flat_map(|end| match end {
                    End::Skin(solid, mean) if *solid == i => {
                        mean.iter().filter(|m| m.1 > 0.0).map(|m| m.0).collect()
                    }
                    _ => Vec::new(),
                })
                .collect();
            held.sort_unstable();
            held.dedup();
            response.loose = response.loose || held.len() > MOST;
            response.learn(held.into_iter());
        }
    }

    fn loose(&self) -> bool {
        self.soft.iter().flatten().any(|r| r.loose)
    }

    /// Change of the velocity of one end for an impulse on another, 1/kg.
    fn between(
        &self,
        (one, at): (&End<D>, &Vector<D>),
        (other, from): (&End<D>, &Vector<D>),
        centers: &[Vector<D>],
    ) -> Option<Matrix<D>> {
        match (one, other) {
            (End::Rigid(i), End::Rigid(j)) if i == j && self.rigid[*i].0 > 0.0 => {
                let (lightness, turn) = &self.rigid[*i];
                let column = |c: usize| {
                    let unit = Vector::<D>::from_fn(|a, _| f64::from(u8::from(a == c)));
                    let spin = turn * moment(&(from - centers[*i]), &unit);
                    unit * *lightness + cross(&spin, &(at - centers[*i]))
                };
                Some(Matrix::from_columns(&std::array::from_fn::<_, D, _>(column)))
            }
            (End::Skin(i, one), End::Skin(j, other)) if i == j => {
                let response = self.soft[*i].as_ref()?;
                let mut sum = Matrix::zeros();
                for (v, a) in one.iter().filter(|m| m.1 > 0.0) {
                    for (w, b) in other.iter().filter(|m| m.1 > 0.0) {
                        sum += response.between(*v, *w) * (a * b);
                    }
                }
                Some(sum)
            }
            _ => None,
        }
    }

    /// The rows of `W`: with which others each contact has to do, and how, in order.
    fn rows(&self, touches: &[Touch<D>], centers: &[Vector<D>]) -> Vec<Vec<(u32, Matrix<D>)>> {
        let mut rows = vec![Vec::new(); touches.len()];
        for (i, one) in touches.iter().enumerate() {
            for (j, other) in touches.iter().enumerate().take(i + 1) {
                let mut sum: Option<Matrix<D>> = None;
                for (a, end) in one.ends.iter().enumerate() {
                    for (b, from) in other.ends.iter().enumerate() {
                        if let Some(block) = self.between((end, &one.at), (from, &other.at), centers) {
                            *sum.get_or_insert(Matrix::zeros()) += if a == b { block } else { -block };
                        }
                    }
                }
                if let Some(block) = sum.filter(|m| m.norm_squared() > 0.0) {
                    rows[i].push((j as u32, block));
                    if j < i {
                        rows[j].push((i as u32, block.transpose()));
                    }
                }
            }
        }
        rows
    }

    /// Gives the solids the impulses of some contacts. They act on two surfaces a gap apart: the couple that this makes (by
    /// friction, and by a normal of the place where both will meet) both get back as bodies.
    pub fn give<'t>(&self, solids: &mut [SolidState<D>], touches: impl Iterator<Item = &'t Touch<D>>) {
        let mut pushes: Vec<Vec<f64>> = vec![Vec::new(); solids.len()];
        let mut couples = vec![Vector::<3>::zeros(); solids.len()];
        for touch in touches {
            if let [End::Skin(i, _), End::Skin(j, _)] = &touch.ends {
                let arm = touch.ends[0].place(solids) - touch.ends[1].place(solids);
                let couple = moment(&arm, &touch.impulse()) * 0.5;
                couples[*i] -= couple;
                couples[*j] -= couple;
            }
            for (end, sign) in touch.ends.iter().zip([1.0, -1.0]) {
                let impulse = touch.impulse() * sign;
                match end {
                    End::Rigid(i) => {
                        let (lightness, turn) = &self.rigid[*i];
                        let now = &mut solids[*i];
                        now.velocity += impulse * *lightness;
                        let spun = turn * moment(&(touch.at - now.center), &impulse);
                        (0..3).for_each(|a| now.spin[a] += spun[a]);
                    }
                    End::Skin(i, mean) => {
                        let count = solids[*i].soft.as_ref().map_or(0, |s| s.body.velocities.len());
                        let push = &mut pushes[*i];
                        push.resize(count * D, 0.0);
                        for (v, w) in mean {
                            (0..D).for_each(|a| push[*v as usize * D + a] += w * impulse[a]);
                        }
                    }
                    End::Side => {}
                }
            }
        }
        for (((push, response), couple), now) in pushes.iter_mut().zip(&self.soft).zip(&couples).zip(solids) {
            let (Some(response), Some(soft)) = (response, &mut now.soft) else { continue };
            if !push.is_empty() {
                response.answer(push, 1);
                let (changes, _) = push.as_chunks::<D>();
                soft.body.velocities.iter_mut().zip(changes).for_each(|(v, c)| *v += Vector::from(*c));
                response.turn(&mut soft.body, couple);
            }
        }
    }

    /// Finds the impulses of all contacts of solids that move as `free` without them. Gives back whether
    /// that came to its end.
    pub fn solve(&mut self, free: &[SolidState<D>], touches: &mut [Touch<D>]) -> Solved {
        self.learn(touches);
        let centers: Vec<Vector<D>> = free.iter().map(|now| now.center).collect();
        let rows = self.rows(touches, &centers);
        let mut sweeps = Sweeps::new(free, touches, &rows);
        if !self.loose() {
            return Solved { swept: sweeps.run(touches), corrected: true };
        }
        let mut solved = Solved { swept: true, corrected: false };
        for _ in 0..CORRECTIONS {
            let before: Vec<Vector<D>> = touches.iter().map(Touch::impulse).collect();
            let mut now = free.to_vec();
            self.give(&mut now, touches.iter());
            sweeps.speeds = touches.iter().map(|t| t.apart(&now)).collect();
            solved.swept = sweeps.run(touches);
            let moved = |(t, j): (&Touch<D>, &Vector<D>)| (t.impulse() - j).norm();
            let change = touches.iter().zip(&before).map(moved).fold(0.0, f64::max);
            if change <= 1e-6 * touches.iter().map(|t| t.impulse().norm()).fold(0.0, f64::max) {
                solved.corrected = true;
                break;
            }
        }
        solved
    }
}

/// Gauss-Seidel.
struct Sweeps<'a, const D: usize> {
    rows: &'a [Vec<(u32, Matrix<D>)>],
    own: Vec<Matrix<D>>,
    speeds: Vec<Vector<D>>,
    scale: f64,
}

impl<'a, const D: usize> Sweeps<'a, D> {
    fn new(free: &[SolidState<D>], touches: &[Touch<D>], rows: &'a [Vec<(u32, Matrix<D>)>]) -> Self {
        let mut speeds: Vec<Vector<D>> = touches.iter().map(|t| t.apart(free)).collect();
        let both =
            |t: &Touch<D>| t.ends.iter().map(|e| e.speed(free, &t.at).norm()).fold(t.target.abs(), f64::max);
        let scale = touches.iter().map(both).fold(0.0, f64::max);
        for (row, touch) in rows.iter().zip(touches) {
            let impulse = touch.impulse();
            row.iter().for_each(|(k, w)| speeds[*k as usize] += w.tr_mul(&impulse));
        }
        let own = |(k, row): (usize, &Vec<(u32, Matrix<D>)>)| {
            row.iter().find(|(j, _)| *j as usize == k).map_or(Matrix::zeros(), |(_, w)| *w)
        };
        Self { rows, own: rows.iter().enumerate().map(own).collect(), speeds, scale }
    }

    /// Sweeps, led on by conjugate gradients where they creep (M. Silcowitz-Hansen, S. Niebe, K. Erleben, The Visual
    /// Computer 26 (2010) 893). Gives back whether they converged.
    fn run(&mut self, touches: &mut [Touch<D>]) -> bool {
        let mut way = vec![Vector::<D>::zeros(); touches.len()];
        let mut last = 0.0;
        for sweep in 0..SWEEPS {
            let before: Vec<Vector<D>> = touches.iter().map(Touch::impulse).collect();
            if self.sweep(touches) <= EXACT * self.scale {
                return true;
            }
            let step = |(t, j): (&Touch<D>, &Vector<D>)| t.impulse() - j;
            let steps: Vec<Vector<D>> = touches.iter().zip(&before).map(step).collect();
            let size: f64 = steps.iter().map(Vector::norm_squared).sum();
            let ratio = if size < last { size / last } else { 0.0 };
            last = size;
            if ratio > 0.0 && sweep + 1 < SWEEPS {
                for (k, touch) in touches.iter_mut().enumerate() {
                    self.shift(k, touch, &(way[k] * ratio));
                }
            }
            way.iter_mut().zip(&steps).for_each(|(w, s)| *w = *w * ratio + s);
        }
        false
    }

    /// All contacts once, there and back. Gives back the largest change of a speed.
    fn sweep(&mut self, touches: &mut [Touch<D>]) -> f64 {
        let count = touches.len();
        let order = (0..count).chain((0..count).rev());
        order.map(|k| self.relax(k, &mut touches[k])).fold(0.0, f64::max)
    }

    /// Changes the impulse of a contact, as far as it can push.
    fn shift(&mut self, k: usize, touch: &mut Touch<D>, by: &Vector<D>) {
        let before = touch.impulse();
        touch.push = (touch.push + by.dot(&touch.normal)).max(0.0);
        let rub = touch.rub + by - touch.normal * by.dot(&touch.normal);
        touch.rub = rub.cap_magnitude(touch.friction * touch.push);
        let change = touch.impulse() - before;
        for (j, w) in &self.rows[k] {
            self.speeds[*j as usize] += w.tr_mul(&change);
        }
    }

    /// Puts one contact right. Gives back how much its speed changed.
    fn relax(&mut self, k: usize, touch: &mut Touch<D>) -> f64 {
        let (own, normal) = (&self.own[k], touch.normal);
        let lightness = normal.dot(&(own * normal));
        if lightness <= 0.0 {
            return 0.0;
        }
        let miss = touch.target - self.speeds[k].dot(&normal);
        let push = (touch.push + miss / lightness).max(0.0);
        let pushed = normal * (push - touch.push);
        let speed = self.speeds[k] + own * pushed;
        let sliding = speed - normal * speed.dot(&normal);
        let ease = |along: &Vector<D>| along.dot(&(own * along)).max(1e-12 * lightness);
        let stop = sliding.try_normalize(0.0).map_or(sliding, |along| sliding / ease(&along));
        let rub = (touch.rub - stop).cap_magnitude(touch.friction * push);
        let impulse = pushed + rub - touch.rub;
        (touch.push, touch.rub) = (push, rub);
        if impulse.norm_squared() == 0.0 {
            return 0.0;
        }
        for (j, w) in &self.rows[k] {
            self.speeds[*j as usize] += w.tr_mul(&impulse);
        }
        (own * impulse).norm()
    }
}
