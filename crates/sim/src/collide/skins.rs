//! The surfaces of solids that deform as contacts see them: points that move, and facets and edges between them.

use super::Probes;
use crate::model::Model;
use crate::solid::SolidState;
use meniscus_numerics::Vector;
use meniscus_numerics::mesh::surface::area_vector;
use meniscus_numerics::shape::Probe;

/// Cosine between two facets below which the edge between them is sharp.
const SHARP: f64 = 0.95;
/// Height over a plane, over the distance, that a surface has at most where its points still count as the highest.
const LEVEL: f64 = 0.05;

/// What a point is part of.
#[derive(Clone, Copy, Debug)]
pub struct Owner {
    /// Number of the solid.
    pub solid: usize,
    /// The vertex of its mesh, if it deforms.
    pub vertex: Option<u32>,
    /// Radius of a ball around it, m.
    pub radius: f64,
}

/// An edge of a surface in 3D.
#[derive(Clone, Copy, Debug)]
pub struct Edge {
    /// Its points.
    pub ends: [u32; 2],
    /// The facets beside it; the same twice where there is but one.
    pub beside: [u32; 2],
    /// Whether the surface bends there.
    pub sharp: bool,
}

/// Points of the surfaces of all solids: the vertices of those that deform, then probes of the others.
pub struct Skins<const D: usize> {
    /// Where they are, m.
    pub at: Vec<Vector<D>>,
    /// How fast they are, m/s.
    pub speed: Vec<Vector<D>>,
    /// Whose they are.
    pub owner: Vec<Owner>,
    /// Number of those that are vertices.
    pub vertices: usize,
    /// The facets, as numbers of points.
    pub facets: Vec<[u32; D]>,
    /// The edges, in 3D.
    pub edges: Vec<Edge>,
    /// Directions away from the surface at the vertices.
    pub normals: Vec<Vector<D>>,
    starts: Vec<usize>,
    around: Vec<u32>,
}

impl<const D: usize> Skins<D> {
    /// Those of all solids where they are now.
    pub fn new(model: &Model<D>, solids: &[SolidState<D>], probes: &Probes<D>) -> Self {
        let (mut at, mut owner, mut facets) = (Vec::new(), Vec::new(), Vec::new());
        for (solid, now) in solids.iter().enumerate() {
            let Some(soft) = &now.soft else { continue };
            let first = at.len() as u32;
            at.extend_from_slice(&soft.skin.surface.positions);
            let own = |v: &u32| Owner { solid, vertex: Some(*v), radius: 0.0 };
            owner.extend(soft.skin.vertices().iter().map(own));
            facets.extend(soft.skin.surface.facets.iter().map(|f| f.map(|v| v + first)));
        }
        let vertices = at.len();
        for (solid, now) in solids.iter().enumerate().filter(|(_, now)| now.soft.is_none()) {
            let telling = |p: &&Probe<D>| p.sharp || p.radius > 0.0;
            for p in probes.0[solid].iter().filter(telling) {
                at.push(model.solids[solid].where_now(now, &p.at));
                owner.push(Owner { solid, vertex: None, radius: p.radius });
            }
        }
        let speed = vec![Vector::zeros(); at.len()];
        let (starts, around) = around(&facets, vertices);
        let mut normals = vec![Vector::zeros(); vertices];
        for f in &facets {
            let area = area_vector(&f.map(|p| at[p as usize]));
            f.iter().for_each(|p| normals[*p as usize] += area);
        }
        normals.iter_mut().for_each(|n| *n = n.try_normalize(0.0).unwrap_or(Vector::zeros()));
        let mut skins =
            Self { at, speed, owner, vertices, facets, edges: Vec::new(), normals, starts, around };
        skins.edges = skins.find_edges();
        skins.follow(solids);
        skins
    }

    /// Takes the velocities of the solids.
    pub fn follow(&mut self, solids: &[SolidState<D>]) {
        for ((speed, at), owner) in self.speed.iter_mut().zip(&self.at).zip(&self.owner) {
            let now = &solids[owner.solid];
            *speed = match (&now.soft, owner.vertex) {
                (Some(soft), Some(vertex)) => soft.body.velocities[vertex as usize],
                _ => now.velocity_at(at),
            };
        }
    }

    /// The facets of a point.
    pub fn around(&self, point: u32) -> &[u32] {
        match self.starts.get(point as usize..point as usize + 2) {
            Some([from, to]) => &self.around[*from..*to],
            _ => &[],
        }
    }

    /// Outward area vector of a facet.
    pub fn area(&self, facet: u32) -> Vector<D> {
        area_vector(&self.facets[facet as usize].map(|p| self.at[p as usize]))
    }

    /// Whether a point of the surface on the corners `on` of a facet is, among those around it, the first one that something
    /// meets which comes against `normal`.
    pub fn stands_out(&self, facet: u32, on: &[u32], point: &Vector<D>, normal: &Vector<D>) -> bool {
        if on.len() == D {
            return self.area(facet).dot(normal) > 0.0;
        }
        let mut facing = 0.0;
        for f in self.around(on[0]) {
            let corners = &self.facets[*f as usize];
            if on.iter().all(|p| corners.contains(p)) {
                facing += self.area(*f).dot(normal);
                let above = |p: &u32| {
                    let arm = self.at[*p as usize] - point;
                    arm.dot(normal) > LEVEL * arm.norm()
                };
                if corners.iter().any(above) {
                    return false;
                }
            }
        }
        facing > 0.0
    }

    /// Whether two points are corners of one facet.
    pub fn joined(&self, one: u32, other: u32) -> bool {
        self.around(one).iter().any(|f| self.facets[*f as usize].contains(&other))
    }

    fn find_edges(&self) -> Vec<Edge> {
        if D < 3 {
            return Vec::new();
        }
        let mut all: Vec<([u32; 2], u32)> = Vec::with_capacity(self.facets.len() * D);
        for (f, corners) in self.facets.iter().enumerate() {
            for k in 0..D {
                let (a, b) = (corners[k], corners[(k + 1) % D]);
                all.push(([a.min(b), a.max(b)], f as u32));
            }
        }
        all.sort_unstable();
        let edge = |same: &[([u32; 2], u32)]| {
            let beside = [same[0].1, same[same.len() - 1].1];
            let [one, other] = beside.map(|f| self.area(f));
            let sharp = one.dot(&other) < SHARP * one.norm() * other.norm();
            Edge { ends: same[0].0, beside, sharp }
        };
        all.chunk_by(|a, b| a.0 == b.0).map(edge).collect()
    }
}

/// The facets of each point, one after another, and where those of a point start.
fn around<const D: usize>(facets: &[[u32; D]], points: usize) -> (Vec<usize>, Vec<u32>) {
    let mut pairs: Vec<(u32, u32)> =
        facets.iter().enumerate().flat_map(|(f, corners)| corners.map(|p| (p, f as u32))).collect();
    pairs.sort_unstable();
    let starts = (0..=points as u32).map(|p| pairs.partition_point(|q| q.0 < p)).collect();
    (starts, pairs.into_iter().map(|p| p.1).collect())
}
