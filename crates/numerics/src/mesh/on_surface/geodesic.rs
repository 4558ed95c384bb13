//! Distance along a surface from a contour on it, by fast marching.
//!
//! In the plane of a triangle the distance at a corner `v` is the minimum of `T(q) + |v q|` over the points `q` of the
//! opposite edge (R. Kimmel and J. Sethian, PNAS 95 (1998) 8431). `T` is the cubic through the distances and slopes at the
//! ends of the edge, so fronts may be curved. (Linear `T`, that is planar fronts, is first order with five times the error.)
//! Each vertex stores the direction of the distance's gradient as an angle in its own frame, in which the angles of the
//! facets around it add up to 2π; this holds across creases as well. For an obtuse angle the triangles beyond the opposite
//! edge are unfolded into the plane until a vertex splits the angle into two acute ones.
//!
//! The seeds are the contour's segments, which may cross triangles anywhere. In 2D the distance is that along the segments.

use crate::Vector;
use crate::mesh::{Contour, SurfaceMesh};
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::f64::consts::{PI, TAU};

/// No facet.
const NO_FACET: u32 = u32::MAX;
/// Most triangles unfolded for an obtuse angle.
const MAX_UNFOLDED_TRIANGLES: usize = 12;
/// Largest deviation of the slope at an end from the mean slope. Beyond it fronts collide and `T` is linear.
const MAX_SLOPE_DEVIATION: f64 = 0.5;
/// Newton iterations for the point of an edge that the front came through.
const NEWTON_ITERATIONS: usize = 4;

type Point = [f64; 2];

/// A surface prepared for geodesic distances.
#[derive(Clone, Debug)]
pub struct Geodesic<const D: usize> {
    facets: Vec<[u32; D]>,
    /// Length of the edge opposite to each corner (2D: of the facet), m.
    lengths: Vec<[f64; D]>,
    /// The facets around vertex `v` are `star[first[v]..first[v + 1]]`.
    star_starts: Vec<u32>,
    star: Vec<u32>,
    /// The facet across the edge opposite to each corner.
    opposite_facets: Vec<[u32; D]>,
    /// Angle of the edge from each corner to the next in the frame of the corner's vertex, rad.
    edge_angles: Vec<[f64; D]>,
    /// Factor by which the angles around each vertex are multiplied.
    angle_scales: Vec<f64>,
}

/// State of the fast marching.
struct MarchingFront<'a> {
    negative: &'a dyn Fn(u32) -> bool,
    distance: Vec<f64>,
    /// Direction of the distance's gradient in each vertex' frame, rad.
    gradient_angles: Vec<f64>,
    accepted: Vec<bool>,
    heap: BinaryHeap<Reverse<(u64, u32)>>,
}

/// An accepted vertex in the plane of an unfolded triangle.
#[derive(Clone, Copy)]
struct AcceptedVertex {
    at: Point,
    distance: f64,
    /// Direction of the distance's gradient in the plane, rad.
    gradient_angle: f64,
}

impl<const D: usize> Geodesic<D> {
    /// Prepares consistently oriented facets of a surface, which may have a border.
    pub fn new(positions: &[Vector<D>], facets: &[[u32; D]]) -> Self {
        let length = |a: u32, b: u32| (positions[a as usize] - positions[b as usize]).norm();
        let lengths = |f: &[u32; D]| std::array::from_fn(|k| length(f[(k + 1) % D], f[(k + D - 1) % D]));
        let lengths_2d = |f: &[u32; D]| [length(f[0], f[1]); D];
        let lengths = facets.iter().map(|f| if D == 2 { lengths_2d(f) } else { lengths(f) }).collect();
        let mut star_starts = vec![0; positions.len() + 1];
        facets.iter().flatten().for_each(|v| star_starts[*v as usize + 1] += 1);
        (0..positions.len()).for_each(|v| star_starts[v + 1] += star_starts[v]);
        let (mut fill, mut star) = (star_starts.clone(), vec![0; D * facets.len()]);
        for (f, facet) in facets.iter().enumerate() {
            for v in facet {
                star[fill[*v as usize] as usize] = f as u32;
                fill[*v as usize] += 1;
            }
        }
        let angle_scales = vec![1.0; positions.len()];
        let edge_angles = vec![[0.0; D]; facets.len()];
        let opposite_facets = opposite_facets(facets);
        let mut out = Self {
            facets: facets.to_vec(),
            lengths,
            star_starts,
            star,
            opposite_facets,
            edge_angles,
            angle_scales,
        };
        (0..positions.len()).filter(|_| D == 3).for_each(|v| out.set_vertex_frame(v as u32));
        out
    }

    /// Signed distance (m) from a contour on these facets within `band` (m) on both sides, `±band` beyond. The signs of
    /// `values` tell the side of each vertex.
    pub fn distance(&self, mesh: &SurfaceMesh<D>, contour: &Contour, values: &[f64], band: f64) -> Vec<f64> {
        let negative = |v: u32| values[v as usize] < 0.0;
        let mut front = MarchingFront::new(&negative, values.len());
        if D == 2 {
            for p in &contour.points {
                let length = self.lengths[p.facet as usize][0];
                front.propose(p.edge[0], p.fraction * length, 0.0);
                front.propose(p.edge[1], (1.0 - p.fraction) * length, 0.0);
            }
        } else {
            let positions = contour.positions(mesh);
            for (segment, &f) in contour.segments.iter().zip(&contour.facets) {
                self.seed_from_segment(&mut front, f, segment.map(|p| positions[p as usize]), mesh);
            }
        }
        while let Some(v) = front.pop_nearest(band) {
            // A vertex that splits an obtuse angle may have been accepted since the last update.
            for &f in self.vertex_star(v) {
                let k = self.corner(f, v);
                if self.is_obtuse(f, k) {
                    self.update_corner(&mut front, f, k);
                }
            }
            front.accepted[v as usize] = true;
            for &f in self.vertex_star(v) {
                for k in 0..D {
                    self.update_corner(&mut front, f, k);
                }
            }
        }
        let sign = |v: usize| if values[v] < 0.0 { -1.0 } else { 1.0 };
        (0..values.len()).map(|v| sign(v) * front.distance[v].min(band)).collect()
    }

    /// The facets around a vertex.
    pub fn vertex_star(&self, v: u32) -> &[u32] {
        &self.star[self.star_starts[v as usize] as usize..self.star_starts[v as usize + 1] as usize]
    }

    /// The corner of facet `f` that is vertex `v`.
    fn corner(&self, f: u32, v: u32) -> usize {
        self.facets[f as usize].iter().position(|w| *w == v).unwrap_or(0)
    }

    /// Angle of a facet at a corner.
    fn angle(&self, f: u32, k: usize) -> f64 {
        let [_, b] = self.unfold(f, k);
        b[1].atan2(b[0])
    }

    /// Whether the angle of a triangle at a corner is obtuse.
    fn is_obtuse(&self, f: u32, k: usize) -> bool {
        let l = self.lengths[f as usize].map(|x| x * x);
        D == 3 && l[k] > l[(k + 1) % D] + l[(k + 2) % D]
    }

    /// The next two corners of a triangle in its plane, with corner `k` at the origin and the next one on the first axis.
    fn unfold(&self, f: u32, k: usize) -> [Point; 2] {
        let l = &self.lengths[f as usize];
        let (opposite, to_last, to_next) = (l[k], l[(k + 1) % D], l[(k + 2) % D]);
        let x = (to_next * to_next + to_last * to_last - opposite * opposite)
            / (2.0 * to_next.max(f64::MIN_POSITIVE));
        [[to_next, 0.0], [x, (to_last * to_last - x * x).max(0.0).sqrt()]]
    }

    /// Corner `j` of the triangle across the edge from `from` to `to`; the triangles before it lie on the left of this edge.
    fn unfold_apex(&self, g: u32, j: usize, from: Point, to: Point) -> Point {
        let l = &self.lengths[g as usize];
        let (length, to_to, to_from) = (l[j].max(f64::MIN_POSITIVE), l[(j + 2) % D], l[(j + 1) % D]);
        let [a, b] = minus(to, from).map(|x| x / length);
        let x = (to_from * to_from - to_to * to_to + length * length) / (2.0 * length);
        let y = (to_from * to_from - x * x).max(0.0).sqrt();
        [from[0] + x * a + y * b, from[1] + x * b - y * a]
    }

    /// Sets the angle of every edge from a vertex in the vertex' frame.
    fn set_vertex_frame(&mut self, v: u32) {
        let star = self.vertex_star(v).to_vec();
        let (mut turned, mut total, mut closed) = (0, 0.0, false);
        let mut seen = vec![false; star.len()];
        while let Some(s) = seen.iter().position(|s| !s) {
            // Back to the border, if there is one, then forward.
            let mut f = star[s];
            for _ in 0..star.len() {
                match self.opposite_facets[f as usize][(self.corner(f, v) + 2) % D] {
                    NO_FACET => break,
                    before => f = before,
                }
            }
            loop {
                let Some(place) = star.iter().position(|g| *g == f).filter(|p| !seen[*p]) else {
                    closed = turned == 0;
                    break;
                };
                seen[place] = true;
                let k = self.corner(f, v);
                self.edge_angles[f as usize][k] = total;
                total += self.angle(f, k);
                match self.opposite_facets[f as usize][(k + 1) % D] {
                    NO_FACET => break,
                    next => f = next,
                }
            }
            turned += 1;
        }
        if closed && turned == 1 && total > 0.0 {
            let stretch = TAU / total;
            self.angle_scales[v as usize] = stretch;
            for f in star {
                let k = self.corner(f, v);
                self.edge_angles[f as usize][k] *= stretch;
            }
        }
    }

    /// Seeds the front from a contour segment in a triangle.
    fn seed_from_segment(
        &self,
        front: &mut MarchingFront<'_>,
        f: u32,
        segment: [Vector<D>; 2],
        mesh: &SurfaceMesh<D>,
    ) {
        let corners = self.facets[f as usize].map(|v| mesh.positions[v as usize]);
        for k in 0..D {
            let (origin, next) = (corners[k], corners[(k + 1) % D]);
            let x = (next - origin).try_normalize(0.0).unwrap_or(Vector::zeros());
            let last = corners[(k + 2) % D] - origin;
            let y = (last - x * last.dot(&x)).try_normalize(0.0).unwrap_or(Vector::zeros());
            let [p, q] = segment.map(|s| [(s - origin).dot(&x), (s - origin).dot(&y)]);
            let e = minus(q, p);
            let t = (-dot(p, e) / dot(e, e).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
            let foot = [p[0] + t * e[0], p[1] + t * e[1]];
            // If the segment passes through the corner itself, take the direction across it.
            let near = dot(foot, foot) < 1e-12 * dot(e, e);
            let to = if near { [e[1], -e[0]] } else { foot };
            let v = self.facets[f as usize][k];
            let to = if near && !(front.negative)(v) { [-to[0], -to[1]] } else { to };
            front.propose(v, norm(foot), self.gradient_angle(f, k, direction(to)));
            self.seed_opposite_vertex(front, f, k, [p, q]);
        }
    }

    /// Seeds the vertex across the edge opposite to corner `k` from a segment in the plane of the triangle. The point of the
    /// contour nearest to a vertex need not lie in one of its own triangles.
    fn seed_opposite_vertex(&self, front: &mut MarchingFront<'_>, f: u32, k: usize, [p, q]: [Point; 2]) {
        let g = self.opposite_facets[f as usize][k];
        if g == NO_FACET {
            return;
        }
        let sides = [self.facets[f as usize][(k + 1) % D], self.facets[f as usize][(k + 2) % D]];
        let [from, to] = self.unfold(f, k);
        let Some(j) = self.facets[g as usize].iter().position(|w| !sides.contains(w)) else { return };
        let (v, at, e) = (self.facets[g as usize][j], self.unfold_apex(g, j, from, to), minus(q, p));
        let t = dot(minus(at, p), e) / dot(e, e).max(f64::MIN_POSITIVE);
        let towards = minus([p[0] + t * e[0], p[1] + t * e[1]], at);
        let left = cross(e, minus(at, p)) > 0.0;
        let through = cross(towards, minus(from, at)) > 0.0 && cross(towards, minus(to, at)) < 0.0;
        if (0.0..=1.0).contains(&t) && left == (front.negative)(v) && through {
            let turn = direction(towards) - direction(minus(to, at));
            front.propose(v, norm(towards), self.gradient_angle(g, j, turn.rem_euclid(TAU)));
        }
    }

    /// Gradient angle, in the frame of the vertex at corner `k`, of a front that comes from the direction `towards` in the
    /// facet's plane.
    fn gradient_angle(&self, f: u32, k: usize, towards: f64) -> f64 {
        let v = self.facets[f as usize][k] as usize;
        self.edge_angles[f as usize][k] + towards * self.angle_scales[v] + PI
    }

    /// Updates corner `k` of a facet from the other corners.
    fn update_corner(&self, front: &mut MarchingFront<'_>, f: u32, k: usize) {
        let facet = &self.facets[f as usize];
        let v = facet[k];
        if front.accepted[v as usize] {
            return;
        }
        let passed = |w: u32| front.is_accepted(w, v);
        let (a, b) = (facet[(k + 1) % D], facet[(k + D - 1) % D]);
        if D == 2 {
            if passed(a) {
                front.propose(v, front.distance[a as usize] + self.lengths[f as usize][0], 0.0);
            }
            return;
        }
        let [at, bt] = self.unfold(f, k);
        let near = passed(a).then(|| self.accepted_vertex(front, f, (k + 1) % D, at, minus(bt, at)));
        let far = passed(b).then(|| self.accepted_vertex(front, f, (k + 2) % D, bt, [-bt[0], -bt[1]]));
        let mut best: Option<(f64, f64)> = None;
        let mut better = |found: (f64, f64)| {
            if best.is_none_or(|(d, _)| found.0 < d) {
                best = Some(found);
            }
        };
        near.iter().chain(&far).for_each(|p| better((p.distance + norm(p.at), direction(p.at))));
        let between = if self.is_obtuse(f, k) { self.obtuse_split_vertex(front, f, k) } else { None };
        let pairs = match between {
            Some(c) => [near.zip(Some(c)), Some(c).zip(far)],
            None => [near.zip(far), None],
        };
        pairs.into_iter().flatten().filter_map(|(p, q)| update_through_side(&p, &q)).for_each(&mut better);
        if let Some((distance, towards)) = best {
            front.propose(v, distance, self.gradient_angle(f, k, towards));
        }
    }

    /// The accepted vertex at corner `k` of a facet, placed at `at`; `next` is the vector to the next corner.
    fn accepted_vertex(
        &self,
        front: &MarchingFront<'_>,
        f: u32,
        k: usize,
        at: Point,
        next: Point,
    ) -> AcceptedVertex {
        let v = self.facets[f as usize][k] as usize;
        let gradient_angle = direction(next) + front.gradient_angles[v] - self.edge_angles[f as usize][k];
        AcceptedVertex { at, distance: front.distance[v], gradient_angle }
    }

    /// The vertex that splits the obtuse angle at corner `k` into acute ones, if there is one and it is accepted.
    fn obtuse_split_vertex(&self, front: &MarchingFront<'_>, f: u32, k: usize) -> Option<AcceptedVertex> {
        let v = self.facets[f as usize][k];
        let [mut from, mut to] = self.unfold(f, k);
        let whole = direction(to);
        let mut g = self.opposite_facets[f as usize][k];
        let mut edge = [self.facets[f as usize][(k + 1) % D], self.facets[f as usize][(k + 2) % D]];
        for _ in 0..MAX_UNFOLDED_TRIANGLES {
            if g == NO_FACET {
                return None;
            }
            let j = self.facets[g as usize].iter().position(|w| !edge.contains(w))?;
            let c = self.facets[g as usize][j];
            let at = self.unfold_apex(g, j, from, to);
            let turn = direction(at);
            if turn > 0.5 * PI {
                // Too close to the last corner: continue across the edge towards the first one.
                (g, to, edge[1]) = (self.opposite_facets[g as usize][(j + 1) % D], at, c);
            } else if turn < whole - 0.5 * PI {
                (g, from, edge[0]) = (self.opposite_facets[g as usize][(j + 2) % D], at, c);
            } else {
                return front.is_accepted(c, v).then(|| self.accepted_vertex(front, g, j, at, minus(to, at)));
            }
        }
        None
    }
}

impl<'a> MarchingFront<'a> {
    fn new(negative: &'a dyn Fn(u32) -> bool, count: usize) -> Self {
        let (distance, gradient_angles) = (vec![f64::INFINITY; count], vec![0.0; count]);
        Self { negative, distance, gradient_angles, accepted: vec![false; count], heap: BinaryHeap::new() }
    }

    /// Whether vertex `w` is accepted and on the same side of the contour as `v`.
    fn is_accepted(&self, w: u32, v: u32) -> bool {
        self.accepted[w as usize] && (self.negative)(w) == (self.negative)(v)
    }

    /// Proposes a distance (m) and gradient angle for a vertex; the smallest distance is kept.
    fn propose(&mut self, v: u32, distance: f64, slope: f64) {
        if distance < self.distance[v as usize] {
            self.distance[v as usize] = distance;
            self.gradient_angles[v as usize] = slope;
            // The bit patterns of non-negative numbers sort like the numbers.
            self.heap.push(Reverse((distance.to_bits(), v)));
        }
    }

    /// The nearest vertex within the band that is not accepted. It is not marked as accepted here.
    fn pop_nearest(&mut self, band: f64) -> Option<u32> {
        while let Some(Reverse((bits, v))) = self.heap.pop() {
            if f64::from_bits(bits) > band {
                return None;
            }
            if !self.accepted[v as usize] {
                return Some(v);
            }
        }
        None
    }
}

/// Distance at the origin of a front that passes through the edge between two vertices, and the direction to the point
/// of passage; `None` if the front does not pass between them.
fn update_through_side(p: &AcceptedVertex, q: &AcceptedVertex) -> Option<(f64, f64)> {
    let side = minus(q.at, p.at);
    let length = norm(side);
    let along = side.map(|x| x / length);
    let mean = (q.distance - p.distance) / length;
    if !(length > 0.0 && mean.abs() < 1.0) {
        return None;
    }
    let slopes = [p, q].map(|p| (p.gradient_angle - direction(side)).cos());
    let [first, last] =
        if slopes.iter().all(|s| (s - mean).abs() < MAX_SLOPE_DEVIATION) { slopes } else { [mean; 2] };
    // T = p + x (mean + (1 − s)² (first − mean) − s (1 − s) (last − mean)), s = x / length.
    let (u, w) = ((first - mean) * length, (last - mean) * length);
    let cubic = |s: f64| p.distance + mean * length * s + s * (1.0 - s) * (u * (1.0 - s) - w * s);
    let rise = |s: f64| mean * length + u * (1.0 - s) * (1.0 - 3.0 * s) + w * s * (3.0 * s - 2.0);
    let bend = |s: f64| u * (6.0 * s - 4.0) + w * (6.0 * s - 2.0);
    let at = |s: f64| [p.at[0] + s * side[0], p.at[1] + s * side[1]];
    let height = (p.at[0] * along[1] - p.at[1] * along[0]).abs();
    let mut s = (-dot(p.at, along) - mean * height / (1.0 - mean * mean).sqrt()) / length;
    for _ in 0..NEWTON_ITERATIONS {
        s = s.clamp(0.0, 1.0);
        let x = at(s);
        let far = norm(x).max(f64::MIN_POSITIVE);
        let lean = dot(x, along) / far;
        let curve = bend(s) + length * length * (1.0 - lean * lean) / far;
        if curve <= 0.0 {
            return None;
        }
        s -= (rise(s) + length * lean) / curve;
    }
    ((0.0..=1.0).contains(&s)).then(|| (cubic(s) + norm(at(s)), direction(at(s))))
}

/// The facet across the edge opposite to each corner. Where more than two share an edge, they are paired in order.
fn opposite_facets<const D: usize>(facets: &[[u32; D]]) -> Vec<[u32; D]> {
    let mut out = vec![[NO_FACET; D]; facets.len()];
    if D == 2 {
        return out;
    }
    let mut edges: Vec<([u32; 2], bool, u32, usize)> = Vec::with_capacity(D * facets.len());
    for (f, facet) in facets.iter().enumerate() {
        for k in 0..D {
            let (a, b) = (facet[(k + 1) % D], facet[(k + 2) % D]);
            edges.push(([a.min(b), a.max(b)], a < b, f as u32, k));
        }
    }
    edges.sort_unstable();
    for same in edges.chunk_by(|a, b| a.0 == b.0) {
        let split = same.partition_point(|e| !e.1);
        for (d, u) in same[..split].iter().zip(&same[split..]) {
            out[d.2 as usize][d.3] = u.2;
            out[u.2 as usize][u.3] = d.2;
        }
    }
    out
}

fn minus(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1]]
}

fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn cross(a: Point, b: Point) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

fn norm(a: Point) -> f64 {
    dot(a, a).sqrt()
}

fn direction(a: Point) -> f64 {
    a[1].atan2(a[0])
}

#[cfg(test)]
#[path = "geodesic_tests.rs"]
mod tests;
