//! Where surfaces of solids that deform meet others in the coming step.
//!
//! Two searches. By the first, parts that come nearer than [`GAP`] along the line between them as it is now: that is what
//! rests, slides and bounces, with normals that hardly change from step to step. By the second, whatever moves linearly
//! and comes much nearer on its way, however it moves: what the first misses because the line between them turns.

use super::GAP;
use super::pair::{ADVANCES, Nearest, Pair, mean};
use super::skins::Skins;
use super::touch::{End, Touch};
use crate::model::{Model, Wall};
use crate::solid::{Solid, SolidState};
use meniscus_contact::boxes::{Extent, overlapping};
use meniscus_numerics::Vector;

/// Distance, in cells, beyond [`GAP`] up to which contacts are kept, whether or not they are needed.
const BESIDE: f64 = 0.02;
/// Distance of what rests, in cells.
const REST: f64 = 1.2 * GAP;
/// Part of the gap that may be lost on the way where the line between both turns.
const LOST: f64 = 0.25;
/// Part of what is missing of the gap that a step makes good.
const REGAIN: f64 = 0.1;

/// What is in contact: told apart by the points that it is made of.
pub type Key = (u8, u32, [u32; 3]);

/// The search.
pub struct Meet<'a, const D: usize> {
    /// The model.
    pub model: &'a Model<D>,
    /// Where the solids are, and how they move.
    pub solids: &'a [SolidState<D>],
    /// Their surfaces.
    pub skins: &'a Skins<D>,
    /// Length of the coming step, s.
    pub ahead: f64,
}

impl<const D: usize> Meet<'_, D> {
    fn gap(&self) -> f64 {
        GAP * self.model.grid.dx
    }

    /// The box that points pass through, larger by the gap and what contacts are kept besides.
    fn swept(&self, points: &[u32]) -> Extent<D> {
        let margin = (GAP + BESIDE) * self.model.grid.dx;
        let start = [Vector::repeat(f64::INFINITY), Vector::repeat(f64::NEG_INFINITY)];
        let all = points.iter().fold(start, |all: Extent<D>, p| {
            let p = *p as usize;
            let (from, radius) = (self.skins.at[p], self.skins.owner[p].radius);
            let to = from + self.skins.speed[p] * self.ahead;
            let reach = Vector::repeat(radius);
            [all[0].inf(&(from.inf(&to) - reach)), all[1].sup(&(from.sup(&to) + reach))]
        });
        [all[0] - Vector::repeat(0.5 * margin), all[1] + Vector::repeat(0.5 * margin)]
    }

    /// All parts that can come near each other, in order.
    pub fn pairs(&self) -> Vec<Pair> {
        let skins = self.skins;
        let points: Vec<Extent<D>> = (0..skins.at.len() as u32).map(|p| self.swept(&[p])).collect();
        let facets: Vec<Extent<D>> = skins.facets.iter().map(|f| self.swept(f)).collect();
        let edges: Vec<Extent<D>> = skins.edges.iter().map(|e| self.swept(&e.ends)).collect();
        let apart = |p: &(u32, u32)| !skins.facets[p.1 as usize].contains(&p.0);
        let faces = overlapping(&points, &facets).into_iter().filter(apart).map(|(p, f)| Pair::Face(p, f));
        let strange = |p: &(u32, u32)| {
            let [a, b] = [p.0, p.1].map(|e| skins.edges[e as usize].ends);
            p.0 < p.1 && !a.iter().any(|v| b.contains(v))
        };
        let edges = overlapping(&edges, &edges).into_iter().filter(strange).map(|(a, b)| Pair::Edges(a, b));
        faces.chain(edges).collect()
    }

    /// The contacts along the lines between surfaces as they are.
    pub fn along_lines(&self, pairs: &[Pair], all: &mut Vec<(Key, Touch<D>)>) {
        let dx = self.model.grid.dx;
        for pair in pairs {
            let near = pair.nearest(self.skins, 0.0);
            let reach = (GAP + BESIDE) * dx;
            if near.normal.norm_squared() == 0.0
                || near.distance > reach + pair.closing(self.skins) * self.ahead
                || !pair.counts(self.skins, &near)
            {
                continue;
            }
            let mut touch = self.touch(&near, near.distance);
            let left = near.distance + self.ahead * touch.apart(self.solids).dot(&touch.normal);
            if left < reach || near.distance < REST * dx {
                if self.related(pair) {
                    touch.target = touch.target.min(0.0);
                }
                all.push((key(pair, &near), touch));
            }
        }
    }

    /// The pairs that meet on the way all the same, and when.
    pub fn met(&self, pairs: &[Pair]) -> Vec<(Pair, f64)> {
        let meets = |pair: &Pair| {
            let now = pair.nearest(self.skins, 0.0).distance;
            let least = LOST * self.gap().min(2.0 * now);
            if now <= 1e-9 * self.model.grid.dx {
                return None;
            }
            pair.meets(self.skins, least, self.ahead).map(|time| (*pair, time))
        };
        pairs.iter().filter_map(meets).collect()
    }

    /// The contact of two that meet after a time, with the line between them as it is then.
    pub fn on_the_way(&self, pair: &Pair, time: f64) -> (Key, Touch<D>) {
        let near = pair.nearest(self.skins, time);
        let between = mean(&self.skins.at, &near.means[0]) - mean(&self.skins.at, &near.means[1]);
        let mut touch = self.touch(&near, between.dot(&near.normal) - pair.radius(self.skins));
        (touch.target, touch.rests) = (touch.target.min(0.0), false);
        let (kind, first, rest) = key(pair, &near);
        ((kind + 8, first, rest), touch)
    }

    /// Whether the points of both have a facet in common: a fold's two faces.
    fn related(&self, pair: &Pair) -> bool {
        let [one, other] = pair.points(self.skins);
        one.iter().any(|a| other.iter().any(|b| self.skins.joined(*a, *b)))
    }

    fn touch(&self, near: &Nearest<D>, gap: f64) -> Touch<D> {
        let skins = self.skins;
        let end = |k: usize| {
            let owner = skins.owner[near.means[k][0].0 as usize];
            let vertex = |(p, w): (u32, f64)| (skins.owner[p as usize].vertex.unwrap_or(0), w);
            if owner.vertex.is_some() {
                End::Skin(owner.solid, near.means[k].map(vertex))
            } else {
                End::Rigid(owner.solid)
            }
        };
        // Of a probe the solid that deforms says where.
        let at = mean(&skins.at, &near.means[1]);
        self.contact([end(0), end(1)], at, near.normal, gap)
    }

    fn contact(&self, ends: [End<D>; 2], at: Vector<D>, normal: Vector<D>, gap: f64) -> Touch<D> {
        let missing = self.gap() - gap;
        let target = if missing > 0.0 { REGAIN * missing } else { missing } / self.ahead;
        let friction = self.pairing(&ends, |s| s.friction);
        let rests = gap < REST * self.model.grid.dx;
        Touch { ends, at, normal, target, friction, rests, push: 0.0, rub: Vector::zeros() }
    }

    /// What a property of both makes together: the geometric mean; of a side, the solid's own.
    fn pairing(&self, ends: &[End<D>; 2], of: impl Fn(&Solid<D>) -> f64) -> f64 {
        let own = ends.iter().filter_map(End::solid).map(|i| of(&self.model.solids[i]));
        let own: Vec<f64> = own.collect();
        if let [one, other] = own[..] { (one * other).sqrt() } else { own.iter().sum() }
    }

    /// Contacts of vertices with closed sides.
    pub fn sides(&self, all: &mut Vec<(Key, Touch<D>)>) {
        let upper = self.model.grid.upper();
        for p in 0..self.skins.vertices {
            for (a, side) in (0..D).flat_map(|a| [(a, 0), (a, 1)]) {
                if self.model.walls[a][side] == Wall::Open {
                    continue;
                }
                let inward = if side == 0 { 1.0 } else { -1.0 };
                let normal = Vector::<D>::from_fn(|b, _| if a == b { inward } else { 0.0 });
                let gap = (self.skins.at[p][a] - if side == 0 { 0.0 } else { upper[a] }) * inward;
                let key = (2, p as u32, [(2 * a + side) as u32, 0, 0]);
                all.extend(self.vertex(p, End::Side, (gap, normal)).map(|touch| (key, touch)));
            }
        }
    }

    /// The vertices that would go through a side all the same.
    pub fn met_sides(&self) -> Vec<u32> {
        let upper = self.model.grid.upper();
        let through = |p: &u32| {
            let (at, speed) = (&self.skins.at[*p as usize], &self.skins.speed[*p as usize]);
            (0..D).any(|a| {
                [(at[a], speed[a]), (upper[a] - at[a], -speed[a])].into_iter().enumerate().any(
                    |(side, (gap, v))| {
                        let least = LOST * self.gap().min(2.0 * gap);
                        self.model.walls[a][side] == Wall::Slip && gap > 0.0 && gap + v * self.ahead <= least
                    },
                )
            })
        };
        (0..self.skins.vertices as u32).filter(through).collect()
    }

    /// Contacts of vertices with rigid solids.
    pub fn rigid(&self, all: &mut Vec<(Key, Touch<D>)>) {
        let step = 1e-3 * self.model.grid.dx;
        for (j, now) in self.solids.iter().enumerate().filter(|(_, now)| now.soft.is_none()) {
            let Some(solid) = self.met_by_vertices(j) else { continue };
            let parts = solid.shape.parts();
            for p in self.near_rigid(j) {
                let x = solid.at_start(now, &self.skins.at[p]);
                let reach = self.reach(p, j);
                for (k, part) in parts.iter().enumerate() {
                    let gap = part.signed_distance(&x);
                    if gap > reach {
                        continue;
                    }
                    let normal = now.rotation * part.normal(&x, step);
                    let foot = self.skins.at[p] - normal * gap;
                    let hidden = parts.len() > 1
                        && solid.distance(now, &(foot + normal * (100.0 * step))) < 90.0 * step;
                    if normal.norm_squared() > 0.0 && !hidden {
                        let key = (3, p as u32, [j as u32, k as u32, 0]);
                        all.extend(self.vertex(p, End::Rigid(j), (gap, normal)).map(|touch| (key, touch)));
                    }
                }
            }
        }
    }

    /// A solid unless it is the one around the domain, whose sides are met as such.
    fn met_by_vertices(&self, j: usize) -> Option<&Solid<D>> {
        Some(&self.model.solids[j]).filter(|_| self.model.wetting_walls() != Some(j))
    }

    /// Distance in which a vertex can meet a rigid solid, m.
    fn reach(&self, p: usize, j: usize) -> f64 {
        let fastest = self.model.solids[j].largest_speed(&self.solids[j]);
        (GAP + BESIDE) * self.model.grid.dx + (self.skins.speed[p].norm() + fastest) * self.ahead
    }

    /// The vertices that can meet it.
    fn near_rigid(&self, j: usize) -> impl Iterator<Item = usize> {
        let [low, high] = self.model.solids[j].bounds(&self.solids[j]);
        let inside = move |p: &usize| {
            let (x, reach) = (&self.skins.at[*p], self.reach(*p, j));
            (0..D).all(|a| x[a] > low[a] - reach && x[a] < high[a] + reach)
        };
        (0..self.skins.vertices).filter(inside)
    }

    /// Whether neither a vertex nor what it meets gives way.
    fn is_held(&self, p: usize, other: &End<D>) -> bool {
        let owner = self.skins.owner[p];
        let elastic = self.model.solids[owner.solid].elastic();
        let held = elastic.zip(owner.vertex).is_some_and(|(elastic, v)| elastic.held()[v as usize]);
        held && other.solid().is_none_or(|j| self.model.solids[j].motion.is_told())
    }

    /// The contact of a vertex, if it comes near enough.
    fn vertex(&self, p: usize, other: End<D>, (gap, normal): (f64, Vector<D>)) -> Option<Touch<D>> {
        let owner = self.skins.owner[p];
        if self.is_held(p, &other) {
            return None;
        }
        let mean = std::array::from_fn(|k| (owner.vertex.unwrap_or(0), if k == 0 { 1.0 } else { 0.0 }));
        let dx = self.model.grid.dx;
        let touch = self.contact([End::Skin(owner.solid, mean), other], self.skins.at[p], normal, gap);
        let left = gap + self.ahead * touch.apart(self.solids).dot(&normal);
        (left < (GAP + BESIDE) * dx || gap < REST * dx).then_some(touch)
    }

    /// The vertices that get into rigid solids on the way all the same, and when.
    pub fn met_rigid(&self) -> Vec<(usize, usize, f64)> {
        let mut all = Vec::new();
        for (j, now) in self.solids.iter().enumerate().filter(|(_, now)| now.soft.is_none()) {
            let Some(solid) = self.met_by_vertices(j) else { continue };
            for p in self.near_rigid(j) {
                let distance = |time: f64| {
                    let mut then = now.clone();
                    let momentum = (then.velocity, then.spin);
                    if momentum.0.norm_squared() + Vector::<3>::from(momentum.1).norm_squared() > 0.0 {
                        solid.carry(&mut then, time);
                    }
                    solid.distance(&then, &(self.skins.at[p] + self.skins.speed[p] * time))
                };
                let start = distance(0.0);
                let closing = self.skins.speed[p].norm() + solid.largest_speed(now);
                let least = LOST * self.gap().min(2.0 * start);
                if start <= 1e-9 * self.model.grid.dx || start - closing * self.ahead > least {
                    continue;
                }
                let mut time = 0.0;
                for _ in 0..ADVANCES {
                    let gap = distance(time);
                    if gap <= least {
                        break;
                    }
                    time += (gap - 0.9 * least) / closing;
                    if time >= self.ahead {
                        break;
                    }
                }
                // Within the step it met, or it hardly moved on in the end.
                if time < self.ahead {
                    all.push((p, j, time));
                }
            }
        }
        all
    }

    /// The contact of a vertex that gets into a rigid solid after a time.
    pub fn in_rigid(&self, p: usize, j: usize, time: f64) -> (Key, Touch<D>) {
        let (solid, now) = (&self.model.solids[j], &self.solids[j]);
        let mut then = now.clone();
        solid.carry(&mut then, time);
        let normal =
            solid.normal(&then, &(self.skins.at[p] + self.skins.speed[p] * time), 1e-3 * self.model.grid.dx);
        let owner = self.skins.owner[p];
        let mean = std::array::from_fn(|k| (owner.vertex.unwrap_or(0), if k == 0 { 1.0 } else { 0.0 }));
        let closing = (now.velocity_at(&self.skins.at[p]) - self.skins.speed[p]).dot(&normal);
        let gap = LOST * self.gap() + closing * time;
        let mut touch =
            self.contact([End::Skin(owner.solid, mean), End::Rigid(j)], self.skins.at[p], normal, gap);
        (touch.target, touch.rests) = (touch.target.min(0.0), false);
        ((11, p as u32, [j as u32, 0, 0]), touch)
    }
}

/// What tells a contact from others: of facets that share the nearest corner or edge there is one.
fn key<const D: usize>(pair: &Pair, near: &Nearest<D>) -> Key {
    match pair {
        Pair::Face(p, _) => {
            let mut on = [u32::MAX; 3];
            let corners = near.means[1].iter().filter(|m| m.1 > 0.0).map(|m| m.0);
            on.iter_mut().zip(corners).for_each(|(o, c)| *o = c);
            on.sort_unstable();
            (0, *p, on)
        }
        Pair::Edges(a, b) => (1, *a, [*b, 0, 0]),
    }
}
