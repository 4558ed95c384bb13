//! Remeshing of a surface: long edges are split, short ones collapsed, and diagonals flipped to Delaunay.
//!
//! T. Brochu and R. Bridson, SIAM J. Sci. Comput. 31 (2009) 2472; edge length bounds of Liu et al., Hydrophobic and
//! Hydrophilic Solid-Fluid Interaction, 4.3.1. A change that would invert a facet, remove a crease or join separate sheets
//! is rejected, so a closed surface stays closed. Works on segments (2D) as well.

use super::SurfaceMesh;
use super::surface::area_vector;
use crate::Vector;

/// Longest and shortest allowed edge, in mean edges.
const EDGE_LENGTH_BOUNDS: [f64; 2] = [1.5, 0.5];
/// Cosine of the largest angle by which a change may turn a facet's normal.
const MIN_NORMAL_COSINE: f64 = 0.9;
/// Area below which a facet may turn by up to 90 degrees, in squares of the mean edge (2D: mean edges).
const DEGENERATE_AREA: f64 = 0.05;
/// Most rounds of changes.
const MAX_ROUNDS: usize = 8;

/// State of the remeshing of a surface.
pub struct Remesher<'a, const D: usize> {
    /// The surface.
    pub mesh: SurfaceMesh<D>,
    /// Tag of each facet, inherited by the facets made from it.
    pub tags: Vec<u8>,
    /// Whether each vertex is fixed; edges between two fixed vertices do not change.
    pub fixed: Vec<bool>,
    /// Projects a new vertex onto the surface.
    pub project: &'a dyn Fn(&Vector<D>) -> Vector<D>,
}

/// Length and vertices of an edge.
type Edge = (f64, [u32; 2]);

/// The facets around each vertex.
struct Stars {
    first: Vec<u32>,
    facets: Vec<u32>,
}

impl Stars {
    fn of(&self, v: u32) -> &[u32] {
        &self.facets[self.first[v as usize] as usize..self.first[v as usize + 1] as usize]
    }
}

impl<const D: usize> Remesher<'_, D> {
    /// Remeshes the surface.
    pub fn remesh(&mut self) {
        let edges = self.edges();
        let mean = edges.iter().map(|e| e.0).sum::<f64>() / edges.len().max(1) as f64;
        for _ in 0..MAX_ROUNDS {
            let changes = self.split(EDGE_LENGTH_BOUNDS[0] * mean) + self.collapse(mean) + self.flip(mean);
            if changes == 0 {
                break;
            }
        }
        self.drop_unused();
    }

    /// All edges, sorted by their vertices.
    fn edges(&self) -> Vec<Edge> {
        let mut edges: Vec<[u32; 2]> = Vec::with_capacity(D * self.mesh.facets.len());
        for f in &self.mesh.facets {
            for k in 0..D {
                let (a, b) = (f[k], f[(k + 1) % D]);
                edges.push([a.min(b), a.max(b)]);
            }
        }
        edges.sort_unstable();
        edges.dedup();
        let length = |e: &[u32; 2]| (self.position(e[0]) - self.position(e[1])).norm();
        edges.into_iter().map(|e| (length(&e), e)).collect()
    }

    fn position(&self, v: u32) -> Vector<D> {
        self.mesh.positions[v as usize]
    }

    fn stars(&self) -> Stars {
        let mut first = vec![0; self.mesh.positions.len() + 1];
        self.mesh.facets.iter().flatten().for_each(|v| first[*v as usize + 1] += 1);
        (1..first.len()).for_each(|v| first[v] += first[v - 1]);
        let (mut fill, mut facets) = (first.clone(), vec![0; D * self.mesh.facets.len()]);
        for (f, facet) in self.mesh.facets.iter().enumerate() {
            for v in facet {
                facets[fill[*v as usize] as usize] = f as u32;
                fill[*v as usize] += 1;
            }
        }
        Stars { first, facets }
    }

    fn is_fixed_edge(&self, e: &[u32; 2]) -> bool {
        e.iter().all(|v| self.fixed[*v as usize])
    }

    /// The neighbours of a vertex, sorted.
    fn one_ring(&self, stars: &Stars, v: u32) -> Vec<u32> {
        let around = stars.of(v).iter().flat_map(|f| self.mesh.facets[*f as usize]);
        let mut ring: Vec<u32> = around.filter(|w| *w != v).collect();
        ring.sort_unstable();
        ring.dedup();
        ring
    }

    /// The facets at an edge.
    fn edge_facets(&self, stars: &Stars, [a, b]: [u32; 2]) -> Vec<u32> {
        stars.of(a).iter().copied().filter(|f| self.mesh.facets[*f as usize].contains(&b)).collect()
    }

    /// Splits edges longer than `longest` at their middle, the longest first.
    fn split(&mut self, longest: f64) -> usize {
        let mut long: Vec<Edge> =
            self.edges().into_iter().filter(|e| e.0 > longest && !self.is_fixed_edge(&e.1)).collect();
        long.sort_by(|p, q| q.0.total_cmp(&p.0).then(p.1.cmp(&q.1)));
        let stars = self.stars();
        let mut touched = vec![false; self.mesh.facets.len()];
        let mut count = 0;
        for (_, [a, b]) in long {
            let sides = self.edge_facets(&stars, [a, b]);
            if sides.iter().any(|f| touched[*f as usize]) {
                continue;
            }
            let middle = self.mesh.positions.len() as u32;
            self.mesh.positions.push((self.project)(&((self.position(a) + self.position(b)) * 0.5)));
            self.fixed.push(false);
            for f in sides {
                touched[f as usize] = true;
                let facet = self.mesh.facets[f as usize];
                self.mesh.facets[f as usize] = facet.map(|v| if v == b { middle } else { v });
                self.mesh.facets.push(facet.map(|v| if v == a { middle } else { v }));
                self.tags.push(self.tags[f as usize]);
            }
            count += 1;
        }
        count
    }

    /// Collapses short edges, the shortest first.
    fn collapse(&mut self, mean: f64) -> usize {
        let shortest = EDGE_LENGTH_BOUNDS[1] * mean;
        let mut short: Vec<Edge> =
            self.edges().into_iter().filter(|e| e.0 < shortest && !self.is_fixed_edge(&e.1)).collect();
        short.sort_by(|p, q| p.0.total_cmp(&q.0).then(p.1.cmp(&q.1)));
        let stars = self.stars();
        let mut touched = vec![false; self.mesh.positions.len()];
        let mut gone = vec![false; self.mesh.facets.len()];
        let mut count = 0;
        for (_, [a, b]) in short {
            let rings = [a, b].map(|v| self.one_ring(&stars, v));
            if rings.iter().flatten().any(|v| touched[*v as usize]) {
                continue;
            }
            // Otherwise facets other than those at the edge would be flattened.
            let shared = rings[0].iter().filter(|v| rings[1].binary_search(v).is_ok()).count();
            if shared != 2 * (D - 2) || rings[0].len() + rings[1].len() < 2 * D + 2 {
                continue;
            }
            let Some(place) = self.collapse_position(&stars, [a, b], mean) else { continue };
            self.mesh.positions[a as usize] = place;
            self.fixed[a as usize] |= self.fixed[b as usize];
            self.edge_facets(&stars, [a, b]).into_iter().for_each(|f| gone[f as usize] = true);
            for f in stars.of(b) {
                let facet = &mut self.mesh.facets[*f as usize];
                *facet = facet.map(|v| if v == b { a } else { v });
            }
            rings.iter().flatten().for_each(|v| touched[*v as usize] = true);
            count += 1;
        }
        let mut kept = gone.iter().map(|g| !g);
        self.mesh.facets.retain(|_| kept.next().unwrap_or(true));
        let mut kept = gone.iter().map(|g| !g);
        self.tags.retain(|_| kept.next().unwrap_or(true));
        count
    }

    /// Position at which the ends of an edge can be merged without turning a facet too far.
    fn collapse_position(&self, stars: &Stars, edge: [u32; 2], mean: f64) -> Option<Vector<D>> {
        let [a, b] = edge.map(|v| self.position(v));
        let places = match edge.map(|v| self.fixed[v as usize]) {
            [true, _] => vec![a],
            [_, true] => vec![b],
            _ => vec![(self.project)(&((a + b) * 0.5)), a, b],
        };
        let fits = |place: &Vector<D>| {
            edge.iter().flat_map(|v| stars.of(*v)).all(|f| {
                let facet = self.mesh.facets[*f as usize];
                let inner = edge.iter().all(|v| facet.contains(v));
                let new = facet.map(|v| if edge.contains(&v) { *place } else { self.position(v) });
                inner || self.keeps_orientation(&self.mesh.corners(*f as usize), &new, mean)
            })
        };
        places.into_iter().find(fits)
    }

    /// Whether the normal of a changed facet turns by no more than the bound.
    fn keeps_orientation(&self, old: &[Vector<D>; D], new: &[Vector<D>; D], mean: f64) -> bool {
        let (old, new) = (area_vector(old), area_vector(new));
        let bar =
            if old.norm() < DEGENERATE_AREA * mean.powi(D as i32 - 1) { 0.0 } else { MIN_NORMAL_COSINE };
        new.dot(&old) > bar * old.norm() * new.norm()
    }

    /// Flips edges whose two opposite angles add up to more than 180 degrees.
    fn flip(&mut self, mean: f64) -> usize {
        if D == 2 {
            return 0;
        }
        let stars = self.stars();
        let mut touched = vec![false; self.mesh.positions.len()];
        let mut count = 0;
        for (_, [a, b]) in self.edges() {
            let &[f, g] = self.edge_facets(&stars, [a, b]).as_slice() else { continue };
            let apex = |f: u32| self.mesh.facets[f as usize].into_iter().find(|v| *v != a && *v != b);
            let (Some(c), Some(d)) = (apex(f), apex(g)) else { continue };
            let busy = [a, b, c, d].iter().any(|v| touched[*v as usize]);
            if busy || self.is_fixed_edge(&[a, b]) || self.tags[f as usize] != self.tags[g as usize] {
                continue;
            }
            let angle =
                |v: u32| (self.position(a) - self.position(v)).angle(&(self.position(b) - self.position(v)));
            if angle(c) + angle(d) < std::f64::consts::PI + 1e-3
                || self.one_ring(&stars, c).binary_search(&d).is_ok()
            {
                continue;
            }
            // In `f` vertex `d` replaces `b`, in `g` vertex `c` replaces `a`.
            let new_f = self.mesh.facets[f as usize].map(|v| if v == b { d } else { v });
            let new_g = self.mesh.facets[g as usize].map(|v| if v == a { c } else { v });
            let corners = |t: [u32; D]| t.map(|v| self.position(v));
            let old: Vec<_> = [f, g].iter().map(|t| self.mesh.corners(*t as usize)).collect();
            let flat = |new: [u32; D]| old.iter().all(|o| self.keeps_orientation(o, &corners(new), mean));
            if flat(new_f) && flat(new_g) {
                self.mesh.facets[f as usize] = new_f;
                self.mesh.facets[g as usize] = new_g;
                [a, b, c, d].iter().for_each(|v| touched[*v as usize] = true);
                count += 1;
            }
        }
        count
    }

    /// Removes vertices without facets.
    fn drop_unused(&mut self) {
        let mut number = vec![u32::MAX; self.mesh.positions.len()];
        self.mesh.facets.iter().flatten().for_each(|v| number[*v as usize] = 0);
        number.iter_mut().filter(|n| **n == 0).zip(0..).for_each(|(n, new)| *n = new);
        let mut kept = number.iter().map(|n| *n != u32::MAX);
        self.mesh.positions.retain(|_| kept.next().unwrap_or(true));
        let mut kept = number.iter().map(|n| *n != u32::MAX);
        self.fixed.retain(|_| kept.next().unwrap_or(true));
        self.mesh.facets.iter_mut().for_each(|f| *f = f.map(|v| number[v as usize]));
    }
}
