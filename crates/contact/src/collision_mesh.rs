//! Collision mesh: the points, edges and facets of surfaces, and the pairs of these that are close to each other.

use crate::barrier::Contact;
use crate::broad_phase::{Aabb, overlapping_pairs};
use crate::ccd::{Clearance, collision_free_fraction};
use crate::distance::{ClosestPair, Stencil};
use crate::plane::Plane;
use meniscus_numerics::mesh::surface::area_vector;
use meniscus_numerics::{Vector, par};

/// Surfaces of all bodies (the solids). Points are indices into a list of positions, which may contain others as well.
#[derive(Clone, Debug, Default)]
pub struct CollisionMesh<const D: usize> {
    /// The points.
    points: Vec<u32>,
    /// Points of the facets.
    facets: Vec<[u32; D]>,
    /// Points of the edges; none in 2D.
    edges: Vec<[u32; 2]>,
    /// Rest area of each position, m² (2D: m).
    point_areas: Vec<f64>,
    /// Rest area of each edge, m², and its squared rest length, m².
    edge_measures: Vec<(f64, f64)>,
    /// Radius of a ball around each position, m.
    radii: Vec<f64>,
    /// Upper bound on the activation distance of each position, m.
    activation_distances: Vec<f64>,
    /// Body of each position.
    bodies: Vec<u32>,
}

/// Candidate pairs of features.
#[derive(Clone, Debug, Default)]
pub struct FeaturePairs {
    pairs: Vec<FeaturePair>,
}

/// Two features with the parameters of their contact.
#[derive(Clone, Copy, Debug)]
struct FeaturePair {
    stencil: Stencil,
    area: f64,
    squared_length_product: f64,
    thickness: f64,
    activation_distance: f64,
}

impl<const D: usize> CollisionMesh<D> {
    /// Mesh of facets with the rest positions `rest`; `bodies` gives the body of each position.
    pub fn new(facets: Vec<[u32; D]>, rest: &[Vector<D>], bodies: Vec<u32>) -> Self {
        let mut point_areas = vec![0.0; rest.len()];
        let mut sides: Vec<([u32; 2], f64)> = Vec::new();
        for facet in &facets {
            let area = area_vector(&facet.map(|p| rest[p as usize])).norm() / D as f64;
            for k in 0..D {
                point_areas[facet[k] as usize] += area;
                let [a, b] = [facet[k], facet[(k + 1) % D]];
                sides.push(([a.min(b), a.max(b)], area));
            }
        }
        let mut points: Vec<u32> = facets.iter().flatten().copied().collect();
        points.sort_unstable();
        points.dedup();
        let (mut edges, mut edge_measures) = (Vec::new(), Vec::new());
        if D == 3 {
            sides.sort_by_key(|side| side.0);
            for same in sides.chunk_by(|a, b| a.0 == b.0) {
                let edge = same[0].0;
                let [a, b] = edge.map(|p| rest[p as usize]);
                edges.push(edge);
                edge_measures.push((same.iter().map(|s| s.1).sum(), (b - a).norm_squared()));
            }
        }
        let (radii, activation_distances) = (vec![0.0; rest.len()], vec![f64::INFINITY; rest.len()]);
        Self { points, facets, edges, point_areas, edge_measures, radii, activation_distances, bodies }
    }

    /// Adds isolated points, each with its area (m², 2D: m) and the radius (m) of a ball around it.
    pub fn with_points(mut self, more: impl IntoIterator<Item = (u32, f64, f64)>) -> Self {
        for (point, area, radius) in more {
            self.points.push(point);
            (self.point_areas[point as usize], self.radii[point as usize]) = (area, radius);
        }
        self
    }

    /// Sets an upper bound on the activation distance, m, for each position; a feature has the least of its points.
    pub fn with_activation_distances(self, activation_distances: Vec<f64>) -> Self {
        Self { activation_distances, ..self }
    }

    /// Upper bound on the activation distance of a position, m.
    pub fn activation_distance(&self, point: u32) -> f64 {
        self.activation_distances[point as usize]
    }

    /// Upper bound on the activation distance of two features, m.
    fn pair_activation_distance(&self, stencil: &Stencil) -> f64 {
        stencil.points().iter().map(|p| self.activation_distance(*p)).fold(f64::INFINITY, f64::min)
    }

    /// Radius of the ball around a position, m.
    pub fn radius(&self, point: u32) -> f64 {
        self.radii[point as usize]
    }

    /// The points.
    pub fn points(&self) -> &[u32] {
        &self.points
    }

    /// Rest area of a position, m² (2D: m).
    pub fn area(&self, point: u32) -> f64 {
        self.point_areas[point as usize]
    }

    /// Whether two features can collide: they share no point, at least one point is movable, and they do not belong to the same rigid
    /// body. `is_rigid` takes a body, `is_immovable` a point.
    fn can_collide(
        &self,
        stencil: &Stencil,
        is_rigid: &impl Fn(u32) -> bool,
        is_immovable: &impl Fn(u32) -> bool,
    ) -> bool {
        let points = stencil.points();
        let (first, second) = points.split_at(stencil.kind.first_count());
        let body = |p: u32| self.bodies[p as usize];
        let (one, other) = (body(first[0]), body(second[0]));
        let moves = !points.iter().all(|p| is_immovable(*p)) && (one != other || !is_rigid(one));
        moves && first.iter().all(|p| !second.contains(p))
    }

    /// Pairs that come closer than `activation_distance`, or their own where it is less, on straight paths between
    /// `configurations`; the result may contain other pairs. All lengths in m.
    pub fn nearby_pairs(
        &self,
        configurations: &[Vec<Vector<D>>],
        activation_distance: f64,
        is_rigid: impl Fn(u32) -> bool + Sync,
        is_immovable: impl Fn(u32) -> bool + Sync,
    ) -> FeaturePairs {
        let swept = |points: &[u32], wider: f64| -> Aabb<D> {
            let ends = points.iter().flat_map(|p| configurations.iter().map(|x| x[*p as usize]));
            let all = ends.fold(None, |all: Option<Aabb<D>>, at| {
                Some(all.map_or([at, at], |[low, high]| [low.inf(&at), high.sup(&at)]))
            });
            let [low, high] = all.unwrap_or([Vector::zeros(); 2]);
            [low.add_scalar(-wider), high.add_scalar(wider)]
        };
        let within = |points: &[u32]| {
            points.iter().map(|p| self.activation_distance(*p)).fold(activation_distance, f64::min)
        };
        let boxes = |list: &[[u32; D]]| par::map_slice(list, 64, |f| swept(f, within(f)));
        let points = par::map_slice(&self.points, 64, |p| swept(&[*p], self.radius(*p)));
        let found = overlapping_pairs(&points, &boxes(&self.facets));
        let of_facets = found.into_iter().map(|(p, f)| {
            let point = self.points[p as usize];
            let stencil = Stencil::point_facet(point, &self.facets[f as usize]);
            let (area, thickness, activation_distance) = (
                self.point_areas[point as usize],
                self.radius(point),
                self.pair_activation_distance(&stencil),
            );
            FeaturePair { stencil, area, squared_length_product: 0.0, thickness, activation_distance }
        });
        let mut pairs: Vec<FeaturePair> =
            of_facets.filter(|p| self.can_collide(&p.stencil, &is_rigid, &is_immovable)).collect();
        let wide = par::map_slice(&self.edges, 64, |e| swept(e, within(e)));
        let slim = par::map_slice(&self.edges, 64, |e| swept(e, 0.0));
        let of_edges = overlapping_pairs(&slim, &wide).into_iter().filter(|(i, j)| i < j).map(|(i, j)| {
            let [i, j] = [i as usize, j as usize];
            let stencil = Stencil::edge_edge(self.edges[i], self.edges[j]);
            let (area, squared_length_product) = (
                0.5 * (self.edge_measures[i].0 + self.edge_measures[j].0),
                self.edge_measures[i].1 * self.edge_measures[j].1,
            );
            FeaturePair {
                stencil,
                area,
                squared_length_product,
                thickness: 0.0,
                activation_distance: self.pair_activation_distance(&stencil),
            }
        });
        pairs.extend(of_edges.filter(|p| self.can_collide(&p.stencil, &is_rigid, &is_immovable)));
        let near = |i: usize| Some(pairs[i]).filter(|p| p.comes_near(configurations, activation_distance));
        FeaturePairs { pairs: par::filter_map(pairs.len(), 256, near) }
    }
}

impl FeaturePair {
    /// Whether the features may come closer than `reach`, or their own activation distance, between configurations. The
    /// distance decreases by no more than the relative motion of their points.
    fn comes_near<const D: usize>(&self, configurations: &[Vec<Vector<D>>], reach: f64) -> bool {
        let Some((first, others)) = configurations.split_first() else { return false };
        let (kind, start) = (self.stencil.kind, self.stencil.positions(first));
        let motion = |x: &Vec<Vector<D>>| {
            let at = self.stencil.positions(x);
            kind.relative_motion(&std::array::from_fn(|k| at[k] - start[k]))
        };
        let motion = others.iter().map(motion).fold(0.0, f64::max);
        let limit = reach.min(self.activation_distance) + self.thickness + motion;
        kind.least_distance(&start) < limit && ClosestPair::new(kind, &start).distance() < limit
    }
}

impl FeaturePairs {
    /// Whether there are no pairs.
    pub fn is_empty(&self) -> bool {
        self.pairs.is_empty()
    }

    /// Contacts of the pairs closer than `activation_distance` (m) at positions; `stiffness` returns that of two points, Pa.
    pub fn contacts<const D: usize>(
        &self,
        activation_distance: f64,
        x: &[Vector<D>],
        stiffness: impl Fn(u32, u32) -> f64 + Sync,
    ) -> Vec<Contact> {
        let contact = |pair: &FeaturePair| {
            let FeaturePair { stencil, area, squared_length_product, thickness, .. } = *pair;
            let (at, activation_distance) =
                (stencil.positions(x), pair.activation_distance.min(activation_distance));
            let near = stencil.kind.least_distance(&at) < activation_distance + thickness
                && ClosestPair::new(stencil.kind, &at).distance() < activation_distance + thickness;
            let stiffness = || stiffness(stencil.points[0], stencil.points[stencil.kind.first_count()]);
            near.then(|| Contact {
                stencil,
                area,
                stiffness: stiffness(),
                squared_length_product,
                thickness,
                activation_distance,
            })
        };
        par::filter_map(self.pairs.len(), 256, |i| contact(&self.pairs[i]))
    }

    /// Conservative fraction, at most 1, of `displacements` for which every pair keeps `kept_fraction` of its distance.
    pub fn collision_free_fraction<const D: usize>(
        &self,
        x: &[Vector<D>],
        displacements: &[Vector<D>],
        kept_fraction: f64,
    ) -> f64 {
        let part = |pair: &FeaturePair| {
            let clearance = Clearance { thickness: pair.thickness, kept_fraction };
            collision_free_fraction(
                pair.stencil.kind,
                &pair.stencil.positions(x),
                &pair.stencil.positions(displacements),
                clearance,
            )
        };
        par::reduce(self.pairs.len(), 256, 1.0, |i| part(&self.pairs[i]), f64::min)
    }

    /// Smallest distance over the pairs of each position, m; infinite where there is no pair.
    pub fn min_distances<const D: usize>(&self, x: &[Vector<D>]) -> Vec<f64> {
        let mut all = vec![f64::INFINITY; x.len()];
        for pair in &self.pairs {
            let far =
                ClosestPair::new(pair.stencil.kind, &pair.stencil.positions(x)).distance() - pair.thickness;
            pair.stencil.points().iter().for_each(|p| all[*p as usize] = all[*p as usize].min(far));
        }
        all
    }

    /// Features of all pairs and their distances, m.
    pub fn gaps<const D: usize>(&self, x: &[Vector<D>]) -> impl Iterator<Item = (Stencil, f64)> {
        self.pairs.iter().map(|pair| {
            let FeaturePair { stencil, thickness, .. } = *pair;
            (stencil, ClosestPair::new(stencil.kind, &stencil.positions(x)).distance() - thickness)
        })
    }
}

impl<const D: usize> Plane<D> {
    /// Points of a surface that come closer to the plane than `reach` on a linear motion.
    pub fn near_points(
        &self,
        surface: &CollisionMesh<D>,
        x: &[Vector<D>],
        displacements: &[Vector<D>],
        reach: f64,
    ) -> Vec<u32> {
        let close = |p: &u32| {
            let (from, way) = (self.distance(&x[*p as usize]), displacements[*p as usize].dot(&self.normal));
            from + way.min(0.0) < reach + surface.radius(*p)
        };
        surface.points().iter().copied().filter(close).collect()
    }
}
