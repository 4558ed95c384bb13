//! Two parts of surfaces that may meet: a point and a facet, or (3D) two edges.

use super::skins::Skins;
use meniscus_numerics::Vector;
use meniscus_numerics::mesh::tree::closest_on_facet;

/// Steps of conservative advancement; who needs more hardly moves on, and counts as met.
pub const ADVANCES: usize = 60;
/// Part of an edge that belongs to its ends.
const END: f64 = 1e-6;

/// Two parts, by number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Pair {
    /// A point and a facet.
    Face(u32, u32),
    /// Two edges.
    Edges(u32, u32),
}

/// A mean of points: their numbers and weights.
pub type Mean<const D: usize> = [(u32, f64); D];

/// Where two parts are nearest.
#[derive(Clone, Copy, Debug)]
pub struct Nearest<const D: usize> {
    /// The point of the first, and of the second.
    pub means: [Mean<D>; 2],
    /// Direction from the second to the first; nothing where they touch.
    pub normal: Vector<D>,
    /// Distance, m.
    pub distance: f64,
}

/// A mean of values.
pub fn mean<const D: usize>(of: &[Vector<D>], weights: &Mean<D>) -> Vector<D> {
    weights.iter().map(|(p, w)| of[*p as usize] * *w).sum()
}

impl Pair {
    /// The points of both.
    pub fn points<const D: usize>(&self, skins: &Skins<D>) -> [Vec<u32>; 2] {
        match self {
            Self::Face(p, f) => [vec![*p], skins.facets[*f as usize].to_vec()],
            Self::Edges(a, b) => [a, b].map(|e| skins.edges[*e as usize].ends.to_vec()),
        }
    }

    /// Where they are nearest after `time` (s).
    pub fn nearest<const D: usize>(&self, skins: &Skins<D>, time: f64) -> Nearest<D> {
        let place = |p: u32| skins.at[p as usize] + skins.speed[p as usize] * time;
        let (means, away) = match self {
            Self::Face(p, f) => {
                let facet = &skins.facets[*f as usize];
                let (point, weights) = closest_on_facet(&facet.map(place), &place(*p));
                let own = std::array::from_fn(|k| (*p, if k == 0 { 1.0 } else { 0.0 }));
                let other = std::array::from_fn(|k| (facet[k], weights[k]));
                ([own, other], place(*p) - point)
            }
            Self::Edges(a, b) => {
                let [a, b] = [a, b].map(|e| skins.edges[*e as usize].ends);
                let (s, t) = closest_of_edges(a.map(place), b.map(place));
                let on = |e: [u32; 2], s: f64| -> Mean<D> {
                    std::array::from_fn(|k| {
                        if k == 0 { (e[0], 1.0 - s) } else { (e[1], if k == 1 { s } else { 0.0 }) }
                    })
                };
                let at = |e: [u32; 2], s: f64| place(e[0]) * (1.0 - s) + place(e[1]) * s;
                ([on(a, s), on(b, t)], at(a, s) - at(b, t))
            }
        };
        let distance = away.norm();
        let normal = away.try_normalize(f64::MIN_POSITIVE).unwrap_or(Vector::zeros());
        Nearest { means, normal, distance: distance - self.radius(skins) }
    }

    /// Radius of the ball around its point, m.
    pub fn radius<const D: usize>(&self, skins: &Skins<D>) -> f64 {
        if let Self::Face(p, _) = self { skins.owner[*p as usize].radius } else { 0.0 }
    }

    /// Largest speed with which any point of the one comes to any of the other, m/s.
    pub fn closing<const D: usize>(&self, skins: &Skins<D>) -> f64 {
        let [one, other] = self.points(skins);
        let pairs = one.iter().flat_map(|a| other.iter().map(move |b| (*a as usize, *b as usize)));
        pairs.map(|(a, b)| (skins.speed[a] - skins.speed[b]).norm_squared()).fold(0.0, f64::max).sqrt()
    }

    /// Whether contact between them is one of surfaces from outside, the nearest there: what lies beside is met by others.
    pub fn counts<const D: usize>(&self, skins: &Skins<D>, nearest: &Nearest<D>) -> bool {
        match self {
            Self::Face(p, f) => {
                let on: Vec<u32> = nearest.means[1].iter().filter(|m| m.1 > 0.0).map(|m| m.0).collect();
                let point = mean(&skins.at, &nearest.means[1]);
                let within = skins.normals.get(*p as usize).is_some_and(|n| n.dot(&nearest.normal) > 0.5);
                !within && skins.stands_out(*f, &on, &point, &nearest.normal)
            }
            Self::Edges(a, b) => {
                let edges = [a, b].map(|e| &skins.edges[*e as usize]);
                let inner = |m: &Mean<D>| m[1].1 > END && m[1].1 < 1.0 - END;
                let out = |k: usize, normal: Vector<D>| {
                    let point = mean(&skins.at, &nearest.means[k]);
                    skins.stands_out(edges[k].beside[0], &edges[k].ends, &point, &normal)
                };
                edges.iter().any(|e| e.sharp)
                    && nearest.means.iter().all(inner)
                    && out(1, nearest.normal)
                    && out(0, -nearest.normal)
            }
        }
    }

    /// When they come within `least` (m) in the next `ahead` seconds (s), by conservative advancement: neither can be
    /// missed, whatever they do (B. Mirtich, thesis, Berkeley 1996, §2.3).
    pub fn meets<const D: usize>(&self, skins: &Skins<D>, least: f64, ahead: f64) -> Option<f64> {
        let closing = self.closing(skins);
        let mut time = 0.0;
        for _ in 0..ADVANCES {
            let distance = self.nearest(skins, time).distance;
            if distance <= least {
                return Some(time);
            }
            // A little beyond, or the last steps would never end.
            time += (distance - 0.9 * least) / closing;
            if time.is_nan() || time >= ahead {
                return None;
            }
        }
        Some(time)
    }
}

/// The parameters of the closest points of two segments (C. Ericson, Real-Time Collision Detection, 2005, §5.1.9).
fn closest_of_edges<const D: usize>(a: [Vector<D>; 2], b: [Vector<D>; 2]) -> (f64, f64) {
    let (u, v, r) = (a[1] - a[0], b[1] - b[0], a[0] - b[0]);
    let (uu, vv, uv) = (u.norm_squared(), v.norm_squared(), u.dot(&v));
    let (ur, vr) = (u.dot(&r), v.dot(&r));
    let across = uu * vv - uv * uv;
    let tiny = f64::MIN_POSITIVE;
    let s = if across > 1e-12 * uu * vv { ((uv * vr - ur * vv) / across).clamp(0.0, 1.0) } else { 0.5 };
    let t = ((uv * s + vr) / vv.max(tiny)).clamp(0.0, 1.0);
    let s = ((uv * t - ur) / uu.max(tiny)).clamp(0.0, 1.0);
    (s, ((uv * s + vr) / vv.max(tiny)).clamp(0.0, 1.0))
}
