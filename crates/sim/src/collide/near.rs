//! Where solids are near each other.

use super::{Contact, GAP, Probes, speed};
use crate::model::{Model, Wall};
use crate::solid::SolidState;
use meniscus_numerics::Vector;
use meniscus_numerics::shape::Probe;

/// Distance beyond what solids can go in a step in which contacts are seen, in cells: all corners of a face that lies
/// on another, though not quite even.
const SEEN: f64 = 0.1;
/// Contacts of a pair whose normals' cosine is above this are of one face.
const ALIKE: f64 = 0.9;

/// The search for contacts.
pub struct Near<'a, const D: usize> {
    /// The model.
    pub model: &'a Model<D>,
    /// Where the solids are.
    pub solids: &'a [SolidState<D>],
    /// Their probes.
    pub probes: &'a Probes<D>,
    /// Length of the coming step, s; 0: contacts are where solids overlap.
    pub ahead: f64,
}

impl<const D: usize> Near<'_, D> {
    /// Distance up to which a solid and another can meet in the step, m.
    fn reach(&self, i: usize, j: Option<usize>) -> f64 {
        let speed = |i: usize| match self.ahead {
            0.0 => 0.0,
            _ => self.model.solids[i].largest_speed(&self.solids[i]),
        };
        let closing = (speed(i) + j.map_or(0.0, speed)) * self.ahead;
        closing + if self.ahead > 0.0 { (GAP + SEEN) * self.model.grid.dx } else { 0.0 }
    }

    fn contact(
        &self,
        pair: (usize, Option<usize>),
        probe: &Probe<D>,
        distance: f64,
        normal: Vector<D>,
    ) -> Contact<D> {
        let gap = distance - probe.radius;
        let at = probe.at - normal * (probe.radius + 0.5 * gap);
        let mut contact =
            Contact { pair, at, normal, gap, left: gap, target: 0.0, push: 0.0, rub: Vector::zeros() };
        contact.left += self.ahead * speed(self.solids, &contact).dot(&normal);
        contact
    }

    /// Some probes of a solid where it is now.
    fn moved(&self, i: usize, some: impl Fn(&&Probe<D>) -> bool) -> impl Iterator<Item = Probe<D>> {
        let (body, now) = (&self.model.solids[i].body, &self.solids[i]);
        let moved = |p: &Probe<D>| Probe { at: now.center + now.rotation * (p.at - body.center), ..*p };
        self.probes.0[i].iter().filter(some).map(moved)
    }

    /// Contacts of a solid with the closed sides.
    pub fn sides(&self, i: usize, all: &mut Vec<Contact<D>>) {
        let (reach, upper) = (self.reach(i, None), self.model.grid.upper());
        let [low, high] = self.model.solids[i].bounds(&self.solids[i]);
        for a in 0..D {
            for (side, clear) in [low[a], upper[a] - high[a]].into_iter().enumerate() {
                if self.model.walls[a][side] == Wall::Open || clear > reach {
                    continue;
                }
                let inward = if side == 0 { 1.0 } else { -1.0 };
                let normal = Vector::from_fn(|b, _| if a == b { inward } else { 0.0 });
                let wall = if side == 0 { 0.0 } else { upper[a] };
                let distance = |p: &Probe<D>| (p.at[a] - wall) * inward;
                let near = self.moved(i, |_| true).filter(|p| distance(p) - p.radius < reach);
                all.extend(thin(near.map(|p| self.contact((i, None), &p, distance(&p), normal)).collect()));
            }
        }
    }

    /// Contacts of two solids. Of a ball its centre tells all, of a convex other one. Else the sharp probes of both count,
    /// and of the smaller one all: those of a wide face would be in the way of what glides along it.
    pub fn pair(&self, i: usize, j: usize) -> Vec<Contact<D>> {
        let reach = self.reach(i, Some(j));
        let [one, other] = [i, j].map(|k| self.model.solids[k].bounds(&self.solids[k]));
        let clear = |a: usize| one[0][a].max(other[0][a]) - one[1][a].min(other[1][a]);
        if (0..D).any(|a| clear(a) > reach) {
            return Vec::new();
        }
        let size = |[low, high]: [Vector<D>; 2]| (high - low).norm();
        let (small, large) = if size(one) <= size(other) { (i, j) } else { (j, i) };
        let mut all = self.against(small, large, reach, |_| true);
        let round = self.probes.0[small].iter().all(|p| p.radius > 0.0);
        if !(round && self.model.solids[large].shape.is_convex()) {
            all.extend(self.against(large, small, reach, |p| p.sharp || p.radius > 0.0));
        }
        all
    }

    /// Contacts of probes of `i` with every part of `j`.
    fn against(&self, i: usize, j: usize, reach: f64, some: impl Fn(&&Probe<D>) -> bool) -> Vec<Contact<D>> {
        let (solid, now) = (&self.model.solids[j], &self.solids[j]);
        let ([low, high], parts) = (solid.bounds(now), solid.shape.parts());
        let step = 1e-3 * self.model.grid.dx;
        let up = Vector::from_fn(|a, _| if a + 1 == D { 1.0 } else { 0.0 });
        let mut all = Vec::new();
        for p in self.moved(i, some) {
            let r = reach + p.radius;
            if (0..D).any(|a| p.at[a] < low[a] - r || p.at[a] > high[a] + r) {
                continue;
            }
            let x = solid.body.center + now.rotation.tr_mul(&(p.at - now.center));
            for part in &parts {
                let distance = part.signed_distance(&x);
                if distance - p.radius < reach {
                    let normal = now.rotation * part.normal(&x, step);
                    // In its very middle there is none: any is right.
                    let normal = if normal.norm_squared() > 0.0 { normal } else { up };
                    let contact = self.contact((i, Some(j)), &p, distance, normal);
                    let foot = p.at - normal * distance;
                    if self.faces(i, &p.at, -normal, p.radius > 0.0)
                        && self.faces(j, &foot, normal, parts.len() == 1)
                    {
                        all.push(contact);
                    }
                }
            }
        }
        all
    }

    /// Whether a point of a solid's surface is the nearest one for what lies in a direction from it, as it is where solids
    /// touch first; what lies beside an edge can not be touched by the face beyond. `sure`: it need not be asked.
    fn faces(&self, i: usize, x: &Vector<D>, towards: Vector<D>, sure: bool) -> bool {
        let step = 0.1 * self.model.grid.dx;
        sure || self.model.solids[i].distance(&self.solids[i], &(x + towards * step)) > 0.9 * step
    }
}

/// Of the contacts of a pair a few that do as all: of every face the one that is left least distance, then those
/// farthest from all that are taken.
pub fn thin<const D: usize>(mut all: Vec<Contact<D>>) -> Vec<Contact<D>> {
    let mut kept: Vec<Contact<D>> = Vec::new();
    while let Some(first) = all.iter().min_by(|a, b| a.left.total_cmp(&b.left)).cloned() {
        let (group, rest): (Vec<_>, Vec<_>) =
            all.into_iter().partition(|c| c.facing().dot(&first.facing()) > ALIKE);
        all = rest;
        let mut away: Vec<f64> = group.iter().map(|c| (c.at - first.at).norm_squared()).collect();
        kept.push(first);
        for _ in 1..1 << D {
            let Some((far, distance)) = away.iter().copied().enumerate().max_by(|a, b| a.1.total_cmp(&b.1))
            else {
                break;
            };
            if distance == 0.0 {
                break;
            }
            kept.push(group[far].clone());
            let at = group[far].at;
            group.iter().zip(&mut away).for_each(|(c, d)| *d = d.min((c.at - at).norm_squared()));
        }
    }
    kept
}
