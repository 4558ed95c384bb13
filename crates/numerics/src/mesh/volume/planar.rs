//! Triangulation of the interior of an outline with triangles of uniform size.
//!
//! The outline is divided evenly between its corners. Interior points start on a triangular lattice and are moved, merged
//! and inserted until the constrained Delaunay triangulation is well shaped. Each point moves to the area-weighted mean of
//! the circumcentres of its triangles (L. Chen, "Mesh smoothing schemes based on optimal Delaunay triangulations", 13th Int.
//! Meshing Roundtable, 2004). An outline with mirror lines is triangulated between two of them and mirrored.

use super::outline::{Outline, OutlineError};
use super::{Simplex, VolumeMesh};
use crate::Vector;
use crate::mesh::{FacetBvh, SurfaceMesh};
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};

/// Cosine of the turning angle below which a point of an outline is a corner.
const MIN_SMOOTH_COSINE: f64 = 0.94;
/// Two sides longer than this, in edges, meet in a corner at any turning angle.
const LONG_SIDE_EDGES: f64 = 0.5;
/// Least distance of an interior point from the outline, in edges: initially, and when it is moved.
const MIN_INSET_EDGES: [f64; 2] = [0.6, 0.4];
/// Number of smoothing rounds, and the interval between rounds of merging and insertion.
const SMOOTHING_ROUNDS: usize = 80;
const ROUNDS_PER_REFINEMENT: usize = 10;
/// Distance below which points are merged, in edges.
const MERGE_DISTANCE_EDGES: f64 = 0.7;
/// Circumradius above which a triangle gets a new point, in edges (regular triangle: 0.58).
const MAX_CIRCUMRADIUS_EDGES: f64 = 0.78;
/// Area below which a triangle is treated as rounding, in squares of the edge.
const MIN_AREA_SQUARE_EDGES: f64 = 1e-9;
/// Most vertices.
const MAX_VERTICES: f64 = 1e6;

/// Triangulation of the interior of an outline.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanarTriangulation {
    /// The triangles.
    pub mesh: VolumeMesh<2>,
    /// Colour of each vertex, different from its neighbours' and as symmetric as the mesh. It gives the order in which
    /// prisms over the triangles are cut.
    pub color: Vec<u32>,
}

impl Outline {
    /// Triangulates the interior with edges about `edge` (m) long. Boundary vertices lie on the outline and include its
    /// corners. Where the outline is thinner than two edges, triangles are flatter.
    ///
    /// # Errors
    /// `edge` is not positive and finite, there would be too many vertices, or edges are too long for the outline.
    pub fn triangulate(&self, edge: f64) -> Result<PlanarTriangulation, OutlineError> {
        if !(edge > 0.0 && edge.is_finite()) {
            return Err(OutlineError::Size { what: "the length of edges", value: edge });
        }
        let vertices = self.surface().volume() / (edge * edge * 0.75f64.sqrt());
        if !(vertices > 0.0 && vertices.is_finite()) {
            return Err(OutlineError::Size {
                what: "the area of the outline over the length of edges",
                value: vertices * edge,
            });
        }
        if vertices > MAX_VERTICES {
            return Err(OutlineError::TooFine { edge, vertices });
        }
        let boundary = self.boundary(edge);
        let mut wedge = Triangulator::new(self, boundary, edge);
        wedge.optimise()?;
        Ok(self.unfold(&wedge))
    }

    /// The divided boundary of the triangulated region: the outline, or its fundamental arc and the two mirror lines.
    fn boundary(&self, edge: f64) -> DividedLoop {
        let mut out = DividedLoop::default();
        if self.mirror_count == 0 {
            let corners = corners(&self.fundamental_arc, true, edge);
            let first = corners.first().copied().unwrap_or(0);
            let n = self.fundamental_arc.len();
            let turned: Vec<Vector<2>> = (0..=n).map(|k| self.fundamental_arc[(first + k) % n]).collect();
            divide_polyline(&turned, edge, 0, &mut out);
            return out;
        }
        let middle = Vector::zeros();
        let (first, last) = (self.fundamental_arc[0], self.fundamental_arc[self.fundamental_arc.len() - 1]);
        divide_polyline(&[middle, first], edge, ON_FIRST, &mut out);
        divide_polyline(&self.fundamental_arc, edge, 0, &mut out);
        divide_polyline(&[last, middle], edge, ON_LAST, &mut out);
        // The first point of a division also lies on the previous line.
        let lines = [ON_FIRST, ON_LAST];
        for (x, on) in out.points.iter().zip(&mut out.on) {
            *on |= if *x == middle { lines[0] | lines[1] } else { 0 };
            *on |= if *x == first { lines[0] } else { 0 };
            *on |= if *x == last { lines[1] } else { 0 };
        }
        out
    }

    /// All images of the region between two mirror lines.
    fn unfold(&self, wedge: &Triangulator) -> PlanarTriangulation {
        let color = wedge.greedy_coloring();
        if self.mirror_count == 0 {
            return PlanarTriangulation { mesh: wedge.mesh(), color };
        }
        let (n, count) = (self.mirror_count, wedge.points.len());
        let on = |v: usize| wedge.on.get(v).copied().unwrap_or(0);
        let mut mesh = VolumeMesh::<2>::default();
        let mut colors = Vec::new();
        // Vertex of each image of a point. Two sectors share the images on a mirror line, all share the centre.
        let mut number = vec![u32::MAX; 2 * n * count];
        for k in 0..n {
            for mirrored in [true, false] {
                for v in 0..count {
                    let owner = match on(v) {
                        on if on == ON_FIRST | ON_LAST => 0,
                        ON_FIRST => 2 * k,
                        ON_LAST => 2 * ((k + usize::from(!mirrored)) % n),
                        _ => 2 * k + usize::from(!mirrored),
                    };
                    let slot = owner * count + v;
                    if number[slot] == u32::MAX {
                        number[slot] = mesh.positions.len() as u32;
                        mesh.positions.push(self.image(&wedge.points[v], k, mirrored));
                        colors.push(color[v]);
                    }
                    number[(2 * k + usize::from(!mirrored)) * count + v] = number[slot];
                }
                let image = |v: u32| number[(2 * k + usize::from(!mirrored)) * count + v as usize];
                for t in &wedge.triangles {
                    let [a, b, c] = t.map(image);
                    mesh.simplices.push(Simplex { root: a, others: if mirrored { [c, b] } else { [b, c] } });
                }
            }
        }
        PlanarTriangulation { mesh, color: colors }
    }
}

/// Flags of points on the first and the last mirror line.
const ON_FIRST: u8 = 1;
const ON_LAST: u8 = 2;

/// A divided closed polyline, and flags of the mirror lines that contain its points.
#[derive(Default)]
struct DividedLoop {
    points: Vec<Vector<2>>,
    on: Vec<u8>,
}

/// The points of a polyline that must be vertices. In a closed one the last point is followed by the first.
fn corners(line: &[Vector<2>], closed: bool, edge: f64) -> Vec<usize> {
    let n = line.len();
    let corner = |i: &usize| {
        let (a, b) = (line[*i] - line[(i + n - 1) % n], line[(i + 1) % n] - line[*i]);
        let long = a.norm().min(b.norm()) > LONG_SIDE_EDGES * edge;
        long || a.dot(&b) < MIN_SMOOTH_COSINE * a.norm() * b.norm()
    };
    (0..n).filter(|i| (!closed && (*i == 0 || i + 1 == n)) || corner(i)).collect()
}

/// Divides a polyline evenly between its corners and adds all but its last point.
fn divide_polyline(line: &[Vector<2>], edge: f64, on: u8, out: &mut DividedLoop) {
    for ends in corners(line, false, edge).windows(2) {
        let run = &line[ends[0]..=ends[1]];
        let mut length = vec![0.0];
        run.windows(2).for_each(|p| length.push(length[length.len() - 1] + (p[1] - p[0]).norm()));
        let total = length[length.len() - 1];
        let count = (total / edge).round().max(1.0) as usize;
        for k in 0..count {
            let at = total * k as f64 / count as f64;
            let side = length.partition_point(|l| *l <= at).clamp(1, run.len() - 1);
            let share = (at - length[side - 1]) / (length[side] - length[side - 1]);
            out.points.push(run[side - 1] + (run[side] - run[side - 1]) * share);
            out.on.push(on);
        }
    }
}

/// State of a triangulation.
struct Triangulator {
    edge: f64,
    /// Points of the divided boundary, then interior points.
    points: Vec<Vector<2>>,
    /// Mirror line flags of each boundary point.
    on: Vec<u8>,
    /// The boundary.
    tree: FacetBvh<2>,
    triangles: Vec<[u32; 3]>,
}

impl Triangulator {
    fn new(outline: &Outline, boundary: DividedLoop, edge: f64) -> Self {
        let DividedLoop { mut points, on } = boundary;
        let n = points.len() as u32;
        let facets = (0..n).map(|i| [i, (i + 1) % n]).collect();
        let surface = SurfaceMesh { positions: points.clone(), facets };
        let tree = FacetBvh::new(&surface);
        let (lower, upper) = surface.bounds();
        // A triangular lattice through the intersection of the mirror lines, with one direction along the first.
        let middle = if outline.mirror_count > 0 { Vector::zeros() } else { (lower + upper) * 0.5 };
        let (s, c) = outline.start_angle.sin_cos();
        let [along, across] = [[c, s], [-s, c]].map(|d| Vector::from(d) * edge);
        let reach = ((lower - middle).norm().max((upper - middle).norm()) / edge).ceil() as i64 * 2;
        for j in -reach..=reach {
            for i in -reach..=reach {
                let shift = if j.rem_euclid(2) == 1 { 0.5 } else { 0.0 };
                let x = middle + along * (i as f64 + shift) + across * (j as f64 * 0.75f64.sqrt());
                let near = (0..2).all(|a| x[a] > lower[a] && x[a] < upper[a]);
                if near && tree.signed_distance(&x) < -MIN_INSET_EDGES[0] * edge {
                    points.push(x);
                }
            }
        }
        Self { edge, points, on, tree, triangles: Vec::new() }
    }

    fn optimise(&mut self) -> Result<(), OutlineError> {
        for round in 0..SMOOTHING_ROUNDS {
            self.triangulate_points()?;
            if round % ROUNDS_PER_REFINEMENT == ROUNDS_PER_REFINEMENT - 1
                && round + ROUNDS_PER_REFINEMENT < SMOOTHING_ROUNDS
            {
                self.insert_points();
                self.merge_close_points();
            } else {
                self.smooth();
            }
        }
        self.triangulate_points()?;
        match self.points.first() {
            Some(x) if self.triangles.is_empty() => {
                Err(OutlineError::TooCoarse { edge: self.edge, near: [x[0], x[1]] })
            }
            _ => Ok(()),
        }
    }

    /// Constrained Delaunay triangulation of the points inside the boundary.
    fn triangulate_points(&mut self) -> Result<(), OutlineError> {
        let (n, edge) = (self.on.len(), self.edge);
        let near = |v: usize| self.points.get(v).map_or([0.0; 2], |x| [x[0], x[1]]);
        let points: Vec<Point2<f64>> = self.points.iter().map(|x| Point2::new(x[0], x[1])).collect();
        let sides: Vec<[usize; 2]> = (0..n).map(|i| [i, (i + 1) % n]).collect();
        let mut conflict = None;
        let cdt = ConstrainedDelaunayTriangulation::<Point2<f64>>::try_bulk_load_cdt(points, sides, |e| {
            conflict = conflict.or(Some(e[0]));
        });
        let cdt = cdt.map_err(|_| OutlineError::NotFinite { point: 0 })?;
        if conflict.is_some() || cdt.num_vertices() < self.points.len() {
            return Err(OutlineError::TooCoarse { edge, near: near(conflict.unwrap_or(0)) });
        }
        let mut triangles = Vec::new();
        for face in cdt.inner_faces() {
            let t = face.vertices().map(|v| v.fix().index() as u32);
            let center = t.iter().map(|v| self.points[*v as usize]).sum::<Vector<2>>() / 3.0;
            // Rounding can leave flat triangles along a straight side.
            let flat = circumcenter(&self.corners(&t)).1 < MIN_AREA_SQUARE_EDGES * edge * edge;
            if !flat && self.tree.contains(&center) {
                triangles.push(t);
            }
        }
        self.triangles = triangles;
        Ok(())
    }

    fn corners(&self, t: &[u32; 3]) -> [Vector<2>; 3] {
        t.map(|v| self.points[v as usize])
    }

    /// Moves every interior point to the area-weighted mean of the circumcentres around it.
    fn smooth(&mut self) {
        let mut sums = vec![(Vector::<2>::zeros(), 0.0); self.points.len()];
        for t in &self.triangles {
            let corners = self.corners(t);
            let (center, area) = circumcenter(&corners);
            // The circumcentre of an obtuse triangle can be far away: limit it to one edge from the centroid.
            let middle = corners.iter().sum::<Vector<2>>() / 3.0;
            let to = center - middle;
            let center = middle + to * (self.edge / to.norm().max(self.edge));
            for v in t {
                sums[*v as usize].0 += center * area;
                sums[*v as usize].1 += area;
            }
        }
        for v in self.on.len()..self.points.len() {
            let to = sums[v].0 / sums[v].1;
            if sums[v].1 > 0.0 && self.tree.signed_distance(&to) < -MIN_INSET_EDGES[1] * self.edge {
                self.points[v] = to;
            }
        }
    }

    /// Removes interior points that are too close to others.
    fn merge_close_points(&mut self) {
        let n = self.on.len();
        let mut gone = vec![false; self.points.len()];
        for t in &self.triangles {
            for k in 0..3 {
                let [a, b] = [t[k], t[(k + 1) % 3]].map(|v| v as usize);
                let close = (self.points[a] - self.points[b]).norm() < MERGE_DISTANCE_EDGES * self.edge;
                let last = a.max(b);
                if close && last >= n && !gone[a] && !gone[b] {
                    gone[last] = true;
                }
            }
        }
        let mut kept = gone.iter().map(|g| !g);
        self.points.retain(|_| kept.next().unwrap_or(true));
    }

    /// Inserts points at the centroids of large triangles.
    fn insert_points(&mut self) {
        let mut large: Vec<(f64, Vector<2>)> = Vec::new();
        for t in &self.triangles {
            let corners = self.corners(t);
            let radius = (circumcenter(&corners).0 - corners[0]).norm();
            if radius > MAX_CIRCUMRADIUS_EDGES * self.edge {
                large.push((radius, corners.iter().sum::<Vector<2>>() / 3.0));
            }
        }
        large.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut added: Vec<Vector<2>> = Vec::new();
        for (_, x) in large {
            let free = added.iter().all(|y| (x - y).norm() > self.edge);
            if free && self.tree.signed_distance(&x) < -MIN_INSET_EDGES[1] * self.edge {
                added.push(x);
            }
        }
        self.points.extend(added);
    }

    /// Greedy colouring: each point gets the least colour that no neighbour has yet.
    fn greedy_coloring(&self) -> Vec<u32> {
        let n = self.points.len();
        let mut pairs: Vec<[u32; 2]> = Vec::new();
        for t in &self.triangles {
            for k in 0..3 {
                pairs.extend([[t[k], t[(k + 1) % 3]], [t[(k + 1) % 3], t[k]]]);
            }
        }
        pairs.sort_unstable();
        let around =
            |v: u32| &pairs[pairs.partition_point(|p| p[0] < v)..pairs.partition_point(|p| p[0] <= v)];
        let mut color = vec![u32::MAX; n];
        // Breadth first, so that a regular lattice needs only three colours.
        let mut queue: Vec<u32> = Vec::new();
        for start in 0..n as u32 {
            let mut at = queue.len();
            if color[start as usize] == u32::MAX {
                queue.push(start);
            }
            while at < queue.len() {
                let v = queue[at];
                at += 1;
                if color[v as usize] != u32::MAX {
                    continue;
                }
                let taken: Vec<u32> = around(v).iter().map(|p| color[p[1] as usize]).collect();
                color[v as usize] = (0..).find(|c| !taken.contains(c)).unwrap_or(0);
                queue.extend(around(v).iter().map(|p| p[1]).filter(|w| color[*w as usize] == u32::MAX));
            }
        }
        color
    }

    fn mesh(&self) -> VolumeMesh<2> {
        let simplices = self.triangles.iter().map(|t| Simplex { root: t[0], others: [t[1], t[2]] }).collect();
        VolumeMesh { positions: self.points.clone(), simplices }
    }
}

/// Circumcentre and area of a triangle.
fn circumcenter([a, b, c]: &[Vector<2>; 3]) -> (Vector<2>, f64) {
    let (u, v) = (b - a, c - a);
    let double = u.perp(&v);
    let (p, q) = (u.norm_squared(), v.norm_squared());
    let at = Vector::from([v[1] * p - u[1] * q, u[0] * q - v[0] * p]) / (2.0 * double);
    (if at.iter().all(|x| x.is_finite()) { a + at } else { (a + b + c) / 3.0 }, 0.5 * double.abs())
}

#[cfg(test)]
#[path = "planar_tests.rs"]
mod tests;
