//! Parts of solids that go on as one rigid body.

use super::moment;
use super::skins::Skins;
use crate::model::Model;
use crate::solid::{Motion, SolidState};
use meniscus_numerics::{Matrix, Vector};
use std::collections::BTreeMap;

/// Which points go together: a forest of points, after these the solids, of which rigid ones count, and the sides.
pub struct Zones<'a, const D: usize> {
    model: &'a Model<D>,
    parents: Vec<u32>,
    points: usize,
}

impl<'a, const D: usize> Zones<'a, D> {
    /// Every point by itself.
    pub fn new(model: &'a Model<D>, skins: &Skins<D>) -> Self {
        let count = skins.vertices + model.solids.len() + 1;
        Self { model, parents: (0..count as u32).collect(), points: skins.vertices }
    }

    fn root(&self, mut k: usize) -> usize {
        while self.parents[k] as usize != k {
            k = self.parents[k] as usize;
        }
        k
    }

    fn unite(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        self.parents[a.max(b)] = a.min(b) as u32;
    }

    /// Makes points one; of a probe, its solid.
    pub fn join(&mut self, points: &[u32], skins: &Skins<D>) {
        let node = |p: u32| match p as usize {
            p if p < self.points => p,
            p => self.points + skins.owner[p].solid,
        };
        let nodes: Vec<usize> = points.iter().map(|p| node(*p)).collect();
        nodes.windows(2).for_each(|w| self.unite(w[0], w[1]));
    }

    /// Makes a vertex one with a rigid solid.
    pub fn join_rigid(&mut self, point: u32, solid: usize) {
        self.unite(point as usize, self.points + solid);
    }

    /// Makes a vertex one with the sides of the domain.
    pub fn join_side(&mut self, point: u32) {
        self.unite(point as usize, self.points + self.model.solids.len());
    }

    /// Makes what goes together move as a rigid body, with the momentum and the angular momentum that it has; with what
    /// is told in it, as that does. Gives back how many vertices and solids that is.
    pub fn freeze(&self, solids: &mut [SolidState<D>], skins: &Skins<D>) -> u64 {
        let mut zones: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for k in 0..self.parents.len() {
            zones.entry(self.root(k)).or_default().push(k);
        }
        let mut frozen = 0;
        for members in zones.into_values().filter(|m| m.len() > 1) {
            let (velocity, spin, center) = self.motion(&members, solids, skins);
            let at = |x: &Vector<D>| velocity + cross(&spin, &(x - center));
            for k in &members {
                if *k >= self.points {
                    let i = k - self.points;
                    if self.model.solids.get(i).is_some_and(|s| s.motion == Motion::Free) {
                        solids[i].velocity = at(&solids[i].center);
                        solids[i].spin = spin.into();
                        frozen += 1;
                    }
                } else if self.mass(*k, skins).is_some() {
                    let owner = skins.owner[*k];
                    if let (Some(soft), Some(v)) = (&mut solids[owner.solid].soft, owner.vertex) {
                        soft.body.velocities[v as usize] = at(&skins.at[*k]);
                        frozen += 1;
                    }
                }
            }
        }
        frozen
    }

    /// Mass of a vertex; nothing where it is held.
    fn mass(&self, point: usize, skins: &Skins<D>) -> Option<f64> {
        let owner = skins.owner[point];
        let elastic = self.model.solids[owner.solid].elastic()?;
        let vertex = owner.vertex? as usize;
        (!elastic.held()[vertex]).then(|| elastic.masses()[vertex])
    }

    /// Velocity, spin and centre of a zone.
    fn motion(
        &self,
        members: &[usize],
        solids: &[SolidState<D>],
        skins: &Skins<D>,
    ) -> (Vector<D>, Vector<3>, Vector<D>) {
        let mut bodies: Vec<(f64, Vector<D>, Vector<D>, Matrix<3>, Vector<3>)> = Vec::new();
        for k in members {
            let body = match k.checked_sub(self.points) {
                Some(i) if i == solids.len() => return (Vector::zeros(), Vector::zeros(), Vector::zeros()),
                Some(i) => {
                    let (solid, now) = (&self.model.solids[i], &solids[i]);
                    if solid.motion != Motion::Free {
                        return (now.velocity, now.spin.into(), now.center);
                    }
                    let inertia = solid.inverse_inertia(now).try_inverse().unwrap_or_else(Matrix::zeros);
                    (solid.body.mass, now.center, now.velocity, inertia, solid.angular_momentum(now))
                }
                None => match self.mass(*k, skins) {
                    Some(mass) => (mass, skins.at[*k], skins.speed[*k], Matrix::zeros(), Vector::zeros()),
                    None => return (skins.speed[*k], Vector::zeros(), skins.at[*k]),
                },
            };
            bodies.push(body);
        }
        let mass: f64 = bodies.iter().map(|b| b.0).sum();
        let center: Vector<D> = bodies.iter().map(|b| b.1 * (b.0 / mass)).sum();
        let velocity: Vector<D> = bodies.iter().map(|b| b.2 * (b.0 / mass)).sum();
        let (mut inertia, mut turning) = (Matrix::<3>::zeros(), Vector::<3>::zeros());
        for (mass, at, speed, own, spun) in &bodies {
            let arm = Vector::<3>::from_fn(|a, _| if a < D { at[a] - center[a] } else { 0.0 });
            inertia += own + (Matrix::<3>::identity() * arm.norm_squared() - arm * arm.transpose()) * *mass;
            turning += spun + moment(&(at - center), &(speed - velocity)) * *mass;
        }
        let spin = inertia.pseudo_inverse(1e-12 * inertia.norm()).map_or(Vector::zeros(), |i| i * turning);
        (velocity, spin, center)
    }
}

/// `ω × r`.
pub fn cross<const D: usize>(spin: &Vector<3>, arm: &Vector<D>) -> Vector<D> {
    let turning = spin.cross(&Vector::<3>::from_fn(|a, _| if a < D { arm[a] } else { 0.0 }));
    Vector::from_fn(|a, _| turning[a])
}
