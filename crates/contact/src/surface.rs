//! Surfaces of points, facets and edges, and what of them is near each other.

use crate::advance::{Clearance, free_step};
use crate::barrier::Contact;
use crate::boxes::{Extent, overlapping};
use crate::distance::{Closest, Stencil};
use crate::plane::Plane;
use meniscus_numerics::Vector;
use meniscus_numerics::mesh::surface::area_vector;
use rayon::prelude::*;

/// The surfaces of all bodies together. Its points are numbers in a list of positions, which may have others as well.
#[derive(Clone, Debug, Default)]
pub struct Surface<const D: usize> {
    /// The points.
    points: Vec<u32>,
    /// The facets, by their points.
    facets: Vec<[u32; D]>,
    /// The edges, by their points; none in 2D.
    edges: Vec<[u32; 2]>,
    /// Area at rest for which each position stands, m² (2D: m).
    areas: Vec<f64>,
    /// The same of edges, and their squared length at rest, m².
    spans: Vec<(f64, f64)>,
    /// Radius of a ball around each position, m.
    radii: Vec<f64>,
    /// Distance, m, from which on each position does not feel others, where that is less than the barrier's reach.
    reaches: Vec<f64>,
    /// Body to which each position belongs.
    bodies: Vec<u32>,
}

/// Pairs that may be near each other.
#[derive(Clone, Debug, Default)]
pub struct Near {
    pairs: Vec<Pair>,
}

/// Two features and for which part of the surface they stand.
#[derive(Clone, Copy, Debug)]
struct Pair {
    stencil: Stencil,
    area: f64,
    lengths: f64,
    thickness: f64,
    reach: f64,
}

impl<const D: usize> Surface<D> {
    /// Of facets with their points at `rest`; `bodies` says to which body each position belongs.
    pub fn new(facets: Vec<[u32; D]>, rest: &[Vector<D>], bodies: Vec<u32>) -> Self {
        let mut areas = vec![0.0; rest.len()];
        let mut sides: Vec<([u32; 2], f64)> = Vec::new();
        for facet in &facets {
            let area = area_vector(&facet.map(|p| rest[p as usize])).norm() / D as f64;
            for k in 0..D {
                areas[facet[k] as usize] += area;
                let [a, b] = [facet[k], facet[(k + 1) % D]];
                sides.push(([a.min(b), a.max(b)], area));
            }
        }
        let mut points: Vec<u32> = facets.iter().flatten().copied().collect();
        points.sort_unstable();
        points.dedup();
        let (mut edges, mut spans) = (Vec::new(), Vec::new());
        if D == 3 {
            sides.sort_by_key(|side| side.0);
            for same in sides.chunk_by(|a, b| a.0 == b.0) {
                let edge = same[0].0;
                let [a, b] = edge.map(|p| rest[p as usize]);
                edges.push(edge);
                spans.push((same.iter().map(|s| s.1).sum(), (b - a).norm_squared()));
            }
        }
        let (radii, reaches) = (vec![0.0; rest.len()], vec![f64::INFINITY; rest.len()]);
        Self { points, facets, edges, areas, spans, radii, reaches, bodies }
    }

    /// The same with some of the other positions as points of it, each with the area (m², 2D: m) for which it stands and the radius
    /// (m) of a ball around it.
    pub fn with_points(mut self, more: impl IntoIterator<Item = (u32, f64, f64)>) -> Self {
        for (point, area, radius) in more {
            self.points.push(point);
            (self.areas[point as usize], self.radii[point as usize]) = (area, radius);
        }
        self
    }

    /// The same with a reach, m, of each position; a facet's or an edge's is the least of its points'.
    pub fn with_reaches(self, reaches: Vec<f64>) -> Self {
        Self { reaches, ..self }
    }

    /// Distance, m, from which on a position does not feel others, where that is less than the barrier's reach.
    pub fn reach(&self, point: u32) -> f64 {
        self.reaches[point as usize]
    }

    /// The same of two features.
    fn reach_of(&self, stencil: &Stencil) -> f64 {
        stencil.points().iter().map(|p| self.reach(*p)).fold(f64::INFINITY, f64::min)
    }

    /// Radius of the ball around a position, m.
    pub fn radius(&self, point: u32) -> f64 {
        self.radii[point as usize]
    }

    /// The points.
    pub fn points(&self) -> &[u32] {
        &self.points
    }

    /// Area at rest for which a position stands, m² (2D: m).
    pub fn area(&self, point: u32) -> f64 {
        self.areas[point as usize]
    }

    /// Whether two features can meet: they have no point in common, and not both belong to one rigid body or to what nothing moves. `rigid` says of a body whether it is rigid, `still` of a point whether nothing moves it.
    fn may_meet(
        &self,
        stencil: &Stencil,
        rigid: &impl Fn(u32) -> bool,
        still: &impl Fn(u32) -> bool,
    ) -> bool {
        let points = stencil.points();
        let (first, second) = points.split_at(stencil.kind.first());
        let body = |p: u32| self.bodies[p as usize];
        let (one, other) = (body(first[0]), body(second[0]));
        let moves = !points.iter().all(|p| still(*p)) && (one != other || !rigid(one));
        moves && first.iter().all(|p| !second.contains(p))
    }

    /// The pairs that come nearer than `reach`, or their own where that is less, and a `margin` on the straight way between some
    /// configurations, and some more. All in m.
    pub fn near(
        &self,
        configurations: &[Vec<Vector<D>>],
        reach: f64,
        margin: f64,
        rigid: impl Fn(u32) -> bool + Sync,
        still: impl Fn(u32) -> bool + Sync,
    ) -> Near {
        let swept = |points: &[u32], wider: f64| -> Extent<D> {
            let ends = points.iter().flat_map(|p| configurations.iter().map(|x| x[*p as usize]));
            let all = ends.fold(None, |all: Option<Extent<D>>, at| {
                Some(all.map_or([at, at], |[low, high]| [low.inf(&at), high.sup(&at)]))
            });
            let [low, high] = all.unwrap_or([Vector::zeros(); 2]);
            [low.add_scalar(-wider), high.add_scalar(wider)]
        };
        let within = |points: &[u32]| points.iter().map(|p| self.reach(*p)).fold(reach, f64::min) + margin;
        let boxes = |list: &[[u32; D]]| list.par_iter().map(|f| swept(f, within(f))).collect::<Vec<_>>();
        let points: Vec<Extent<D>> = self.points.par_iter().map(|p| swept(&[*p], self.radius(*p))).collect();
        let found = overlapping(&points, &boxes(&self.facets));
        let of_facets = found.into_iter().map(|(p, f)| {
            let point = self.points[p as usize];
            let stencil = Stencil::point_facet(point, &self.facets[f as usize]);
            let (area, thickness, reach) =
                (self.areas[point as usize], self.radius(point), self.reach_of(&stencil));
            Pair { stencil, area, lengths: 0.0, thickness, reach }
        });
        let mut pairs: Vec<Pair> = of_facets.filter(|p| self.may_meet(&p.stencil, &rigid, &still)).collect();
        let wide: Vec<Extent<D>> = self.edges.par_iter().map(|e| swept(e, within(e))).collect();
        let slim: Vec<Extent<D>> = self.edges.par_iter().map(|e| swept(e, 0.0)).collect();
        let of_edges = overlapping(&slim, &wide).into_iter().filter(|(i, j)| i < j).map(|(i, j)| {
            let [i, j] = [i as usize, j as usize];
            let stencil = Stencil::edge_edge(self.edges[i], self.edges[j]);
            let (area, lengths) =
                (0.5 * (self.spans[i].0 + self.spans[j].0), self.spans[i].1 * self.spans[j].1);
            Pair { stencil, area, lengths, thickness: 0.0, reach: self.reach_of(&stencil) }
        });
        pairs.extend(of_edges.filter(|p| self.may_meet(&p.stencil, &rigid, &still)));
        let pairs =
            pairs.into_par_iter().with_min_len(256).filter(|p| p.comes_near(configurations, reach, margin));
        Near { pairs: pairs.collect() }
    }
}

impl Pair {
    /// Whether its features may come nearer than `reach`, or their own, and a `margin` between configurations: they come nearer by no more
    /// than their points move against each other.
    fn comes_near<const D: usize>(&self, configurations: &[Vec<Vector<D>>], reach: f64, margin: f64) -> bool {
        let Some((first, others)) = configurations.split_first() else { return false };
        let (kind, start) = (self.stencil.kind, self.stencil.of(first));
        let motion = |x: &Vec<Vector<D>>| {
            let at = self.stencil.of(x);
            kind.relative_motion(&std::array::from_fn(|k| at[k] - start[k]))
        };
        let motion = others.iter().map(motion).fold(0.0, f64::max);
        let limit = reach.min(self.reach) + margin + self.thickness + motion;
        kind.least_distance(&start) < limit && Closest::new(kind, &start).distance() < limit
    }
}

impl Near {
    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.pairs.is_empty()
    }

    /// Those nearer than `reach` (m) at positions; `stiffness` is that between two bodies' points, Pa.
    pub fn contacts<const D: usize>(
        &self,
        reach: f64,
        x: &[Vector<D>],
        stiffness: impl Fn(u32, u32) -> f64 + Sync,
    ) -> Vec<Contact> {
        let contact = |pair: &Pair| {
            let Pair { stencil, area, lengths, thickness, .. } = *pair;
            let (at, reach) = (stencil.of(x), pair.reach.min(reach));
            let near = stencil.kind.least_distance(&at) < reach + thickness
                && Closest::new(stencil.kind, &at).distance() < reach + thickness;
            let stiffness = || stiffness(stencil.points[0], stencil.points[stencil.kind.first()]);
            near.then(|| Contact { stencil, area, stiffness: stiffness(), lengths, thickness, reach })
        };
        self.pairs.par_iter().with_min_len(256).filter_map(contact).collect()
    }

    /// The largest part of a way, up to all of it, on which every pair keeps `keep` of its distance.
    pub fn free_step<const D: usize>(&self, x: &[Vector<D>], ways: &[Vector<D>], keep: f64) -> f64 {
        let part = |pair: &Pair| {
            let clearance = Clearance { thickness: pair.thickness, keep };
            free_step(pair.stencil.kind, &pair.stencil.of(x), &pair.stencil.of(ways), clearance)
        };
        self.pairs.par_iter().with_min_len(256).map(part).reduce(|| 1.0, f64::min)
    }

    /// The least distance, m, of each of `count` positions from what it may meet; infinite where there is nothing.
    pub fn least_distances<const D: usize>(&self, x: &[Vector<D>]) -> Vec<f64> {
        let mut all = vec![f64::INFINITY; x.len()];
        for pair in &self.pairs {
            let far = Closest::new(pair.stencil.kind, &pair.stencil.of(x)).distance() - pair.thickness;
            pair.stencil.points().iter().for_each(|p| all[*p as usize] = all[*p as usize].min(far));
        }
        all
    }

    /// The features of all pairs, and their distances, m.
    pub fn gaps<const D: usize>(&self, x: &[Vector<D>]) -> impl Iterator<Item = (Stencil, f64)> {
        self.pairs.iter().map(|pair| {
            let Pair { stencil, thickness, .. } = *pair;
            (stencil, Closest::new(stencil.kind, &stencil.of(x)).distance() - thickness)
        })
    }
}

impl<const D: usize> Plane<D> {
    /// The points of a surface that are nearer to it than `reach` somewhere on a way.
    pub fn near(&self, surface: &Surface<D>, x: &[Vector<D>], ways: &[Vector<D>], reach: f64) -> Vec<u32> {
        let close = |p: &u32| {
            let (from, way) = (self.distance(&x[*p as usize]), ways[*p as usize].dot(&self.normal));
            from + way.min(0.0) < reach + surface.radius(*p)
        };
        surface.points().iter().copied().filter(close).collect()
    }
}
