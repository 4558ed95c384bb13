//! How a solid that deforms answers to impulses.
//!
//! Within a step its elasticity spreads a push: the velocities change by `A⁻¹ J` (`soft.rs`), not by `M⁻¹ J`, with which
//! stiff solids would ring. `A` has the stiffness of a stressed solid in it, which a rotation feels: for those that nothing
//! holds, what they do as rigid bodies is taken out and put in exactly, `R = B Bᵀ + Q A⁻¹ Qᵀ` with rigid motions `B` such
//! that `Bᵀ M B = 1`, and `Q = 1 − B Bᵀ M`. It is symmetric, and impulses change both momenta as they should to rounding.

use super::zones::cross;
use crate::soft::SoftSystem;
use crate::solid::SolidState;
use meniscus_elastic::{Elastic, ElasticState};
use meniscus_numerics::{Matrix, Vector};

/// Right-hand sides that are solved for at once.
const AT_ONCE: usize = 32;
/// Norm of a rigid motion that nothing but rounding tells from the others.
const SAME: f64 = 1e-12;
/// Place of what is not known.
const UNKNOWN: u32 = u32::MAX;

/// The answer of a solid, and what is known of it for some of its vertices.
pub struct Response<'a, const D: usize> {
    elastic: &'a Elastic<D>,
    system: &'a SoftSystem<D>,
    /// Rigid motions, and their momenta.
    rigid: Vec<(Vec<f64>, Vec<f64>)>,
    /// Whether what pushes one vertex is taken to move that alone, as if it were loose.
    pub loose: bool,
    /// Place of each vertex among those that are known.
    slots: Vec<u32>,
    known: Vec<u32>,
    /// Velocities at every known vertex for an impulse on one, those that are known before it and itself.
    blocks: Vec<Vec<Matrix<D>>>,
}

impl<'a, const D: usize> Response<'a, D> {
    /// That of a solid where it is now; nothing if it is rigid.
    pub fn new(
        elastic: Option<&'a Elastic<D>>,
        system: Option<&'a SoftSystem<D>>,
        now: &SolidState<D>,
    ) -> Option<Self> {
        let (elastic, system, soft) = (elastic?, system?, now.soft.as_ref()?);
        let slots = vec![UNKNOWN; elastic.masses().len()];
        let (rigid, known, blocks) = (Vec::new(), Vec::new(), Vec::new());
        let mut response = Self { elastic, system, rigid, loose: false, slots, known, blocks };
        if !elastic.held().contains(&true) {
            response.find_rigid(&soft.body.positions, &now.center);
        }
        Some(response)
    }

    /// Finds the rigid motions by Gram and Schmidt.
    fn find_rigid(&mut self, positions: &[Vector<D>], center: &Vector<D>) {
        let planes = (0..D).flat_map(|b| (0..b).map(move |a| (a, b)));
        let turn = |(a, b): (usize, usize)| {
            let speed = move |x: &Vector<D>| {
                Vector::<D>::from_fn(|c, _| match c {
                    c if c == a => center[b] - x[b],
                    c if c == b => x[a] - center[a],
                    _ => 0.0,
                })
            };
            positions.iter().flat_map(|x| speed(x).iter().copied().collect::<Vec<_>>()).collect::<Vec<f64>>()
        };
        let shifts =
            (0..D).map(|a| (0..positions.len() * D).map(|k| f64::from(u8::from(k % D == a))).collect());
        let motions: Vec<Vec<f64>> = shifts.chain(planes.map(turn)).collect();
        for mut motion in motions {
            let whole = dot(&motion, &self.momentum(&motion));
            // Twice, for rounding.
            for (b, p) in self.rigid.iter().chain(&self.rigid) {
                let share = dot(&motion, p);
                motion.iter_mut().zip(b).for_each(|(m, b)| *m -= share * b);
            }
            let left = dot(&motion, &self.momentum(&motion));
            if left > SAME * whole {
                motion.iter_mut().for_each(|m| *m /= left.sqrt());
                let momentum = self.momentum(&motion);
                self.rigid.push((motion, momentum));
            }
        }
    }

    fn momentum(&self, speed: &[f64]) -> Vec<f64> {
        let masses = self.elastic.masses();
        speed.iter().enumerate().map(|(k, v)| v * masses[k / D]).collect()
    }

    /// Makes impulses, N s, of all vertices' components the changes of velocity that they bring, m/s; `count` of them, one
    /// after another.
    pub fn answer(&self, impulses: &mut [f64], count: usize) {
        let length = impulses.len() / count.max(1);
        let mut shares = Vec::with_capacity(count * self.rigid.len());
        for own in impulses.chunks_exact_mut(length) {
            let of: Vec<f64> = self.rigid.iter().map(|(b, _)| dot(own, b)).collect();
            for ((_, p), share) in self.rigid.iter().zip(&of) {
                own.iter_mut().zip(p).for_each(|(j, p)| *j -= share * p);
            }
            shares.extend(of);
        }
        self.system.solve_many(impulses, count);
        for (k, own) in impulses.chunks_exact_mut(length).enumerate() {
            let wrong: Vec<f64> = self.rigid.iter().map(|(_, p)| dot(own, p)).collect();
            let wanted = &shares[k * self.rigid.len()..];
            for (((b, _), wrong), wanted) in self.rigid.iter().zip(&wrong).zip(wanted) {
                own.iter_mut().zip(b).for_each(|(v, b)| *v += (wanted - wrong) * b);
            }
        }
    }

    /// Turns the whole by an angular impulse, N m s, unless something holds it.
    pub fn turn(&self, body: &mut ElasticState<D>, couple: &Vector<3>) {
        if self.rigid.is_empty() || couple.norm_squared() == 0.0 {
            return;
        }
        let masses = self.elastic.masses();
        let all: f64 = masses.iter().sum();
        let center: Vector<D> = body.positions.iter().zip(masses).map(|(x, m)| x * (m / all)).sum();
        let mut inertia = Matrix::<3>::zeros();
        for (x, m) in body.positions.iter().zip(masses) {
            let arm = Vector::<3>::from_fn(|a, _| if a < D { x[a] - center[a] } else { 0.0 });
            inertia += (Matrix::identity() * arm.norm_squared() - arm * arm.transpose()) * *m;
        }
        let spin = inertia.try_inverse().map_or(Vector::zeros(), |i| i * couple);
        for (v, x) in body.velocities.iter_mut().zip(&body.positions) {
            *v += cross(&spin, &(x - center));
        }
    }

    /// Gets to know the answers of some more vertices: a solve for each component of each.
    pub fn learn(&mut self, vertices: impl Iterator<Item = u32>) {
        if self.loose {
            return;
        }
        let first = self.known.len();
        for v in vertices {
            let slot = &mut self.slots[v as usize];
            if *slot == UNKNOWN {
                *slot = self.known.len() as u32;
                self.known.push(v);
            }
        }
        let new = &self.known[first..];
        let length = self.system.freedoms();
        for some in new.chunks(AT_ONCE.div_ceil(D)) {
            let mut columns = vec![0.0; length * D * some.len()];
            for (k, column) in columns.chunks_exact_mut(length).enumerate() {
                column[some[k / D] as usize * D + k % D] = 1.0;
            }
            self.answer(&mut columns, D * some.len());
            for own in columns.chunks_exact(length * D) {
                let last = self.blocks.len();
                let entry = |v: &u32| Matrix::from_fn(|r, c| own[c * length + *v as usize * D + r]);
                self.blocks.push(self.known[..=last].iter().map(entry).collect());
            }
        }
    }

    /// Change of the velocity of one vertex for an impulse on another, 1/kg. Both must be known.
    pub fn between(&self, one: u32, other: u32) -> Matrix<D> {
        if self.loose {
            let free = one == other && !self.elastic.held()[one as usize];
            return if free {
                Matrix::identity() / self.elastic.masses()[one as usize]
            } else {
                Matrix::zeros()
            };
        }
        let [i, j] = [one, other].map(|v| self.slots[v as usize] as usize);
        if i <= j { self.blocks[j][i] } else { self.blocks[i][j].transpose() }
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
