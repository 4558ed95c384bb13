//! Bounding volume hierarchy over the facets of a surface: closest point, winding number, signed distance.
//!
//! The winding number (A. Jacobson, L. Kavan and O. Sorkine-Hornung, ACM Trans. Graph. 32 (2013) 33) of a closed outward
//! surface is 1 inside and 0 outside; near a hole it takes values in between. The facets of a box farther away than twice
//! its radius act as a dipole, the sum of their area vectors (G. Barill et al., ACM Trans. Graph. 37 (2018) 43). A query
//! costs about the logarithm of the number of facets.

use super::surface::{SurfaceMesh, area_vector};
use crate::Vector;
use std::f64::consts::PI;

/// Most facets of a leaf.
const MAX_LEAF_FACETS: usize = 4;
/// Distance beyond which a box acts as a dipole, in radii of the box.
const DIPOLE_DISTANCE_RADII: f64 = 2.0;

/// Closest point on a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClosestPoint<const D: usize> {
    /// Number of its facet.
    pub facet: u32,
    /// The point, m.
    pub point: Vector<D>,
    /// Its barycentric weights in the facet.
    pub weights: [f64; D],
    /// Its distance squared, m².
    pub distance_squared: f64,
}

/// Box of the tree; fills one cache line in 3D. Its first child follows it in the array.
#[derive(Clone, Copy, Debug)]
struct Node<const D: usize> {
    lower: Vector<D>,
    upper: Vector<D>,
    /// Facets `first..first + count` in the tree's order.
    first: u32,
    count: u32,
    /// Second child; 0 in a leaf.
    second_child: u32,
    /// Next node after this subtree.
    skip_index: u32,
}

/// Far-field approximation of the facets of a node.
#[derive(Clone, Copy, Debug)]
struct Dipole<const D: usize> {
    /// Sum of the area vectors, area-weighted centre, distance of the farthest corner from it.
    area: Vector<D>,
    center: Vector<D>,
    radius: f64,
}

/// Bounding volume hierarchy over the facets of a surface. It keeps a copy of the corners.
#[derive(Clone, Debug)]
pub struct FacetBvh<const D: usize> {
    nodes: Vec<Node<D>>,
    dipoles: Vec<Dipole<D>>,
    facets: Vec<u32>,
    corners: Vec<[Vector<D>; D]>,
}

impl<const D: usize> FacetBvh<D> {
    /// Builds the tree in O(n log n) for n facets.
    pub fn new(mesh: &SurfaceMesh<D>) -> Self {
        let mut items: Vec<(Vector<D>, u32)> = (0..mesh.facets.len())
            .map(|f| (mesh.corners(f).iter().sum::<Vector<D>>() / D as f64, f as u32))
            .collect();
        let mut tree =
            Self { nodes: Vec::new(), dipoles: Vec::new(), facets: Vec::new(), corners: Vec::new() };
        let count = items.len();
        if count > 0 {
            tree.build(mesh, &mut items, 0);
        }
        tree
    }

    /// Adds the subtree of the given facets; `first` is their first place in the tree's order.
    fn build(&mut self, mesh: &SurfaceMesh<D>, items: &mut [(Vector<D>, u32)], first: usize) {
        let index = self.nodes.len();
        let (node, dipole) = node(mesh, items, first);
        self.nodes.push(node);
        self.dipoles.push(dipole);
        if items.len() <= MAX_LEAF_FACETS {
            for (_, facet) in items.iter() {
                self.facets.push(*facet);
                self.corners.push(mesh.corners(*facet as usize));
            }
            self.nodes[index].skip_index = index as u32 + 1;
            return;
        }
        let start = (Vector::repeat(f64::INFINITY), Vector::repeat(f64::NEG_INFINITY));
        let (lower, upper) =
            items.iter().fold(start, |(l, u): (Vector<D>, Vector<D>), (c, _)| (l.inf(c), u.sup(c)));
        let axis = (upper - lower).imax();
        let middle = items.len() / 2;
        items.select_nth_unstable_by(middle, |p, q| p.0[axis].total_cmp(&q.0[axis]).then(p.1.cmp(&q.1)));
        let (left, right) = items.split_at_mut(middle);
        self.build(mesh, left, first);
        self.nodes[index].second_child = self.nodes.len() as u32;
        self.build(mesh, right, first + middle);
        self.nodes[index].skip_index = self.nodes.len() as u32;
    }

    /// Closest point to `x` (m) nearer than `max_distance` (m); on a tie the first in the search order.
    pub fn closest_point(&self, x: &Vector<D>, max_distance: f64) -> Option<ClosestPoint<D>> {
        let mut best: Option<ClosestPoint<D>> = None;
        let mut bound = max_distance * max_distance;
        let mut stack = [(0u32, 0.0); 64];
        let mut depth = usize::from(!self.nodes.is_empty());
        while depth > 0 {
            depth -= 1;
            let (at, near) = stack[depth];
            if near >= bound {
                continue;
            }
            let node = &self.nodes[at as usize];
            if node.second_child == 0 {
                for k in node.first as usize..(node.first + node.count) as usize {
                    let (point, weights) = closest_on_facet(&self.corners[k], x);
                    let distance_squared = (point - x).norm_squared();
                    if distance_squared < bound {
                        bound = distance_squared;
                        best = Some(ClosestPoint { facet: self.facets[k], point, weights, distance_squared });
                    }
                }
                continue;
            }
            let child = |i: u32| (i, self.nodes[i as usize].distance_squared(x));
            let (mut near, mut far) = (child(at + 1), child(node.second_child));
            if far.1 < near.1 {
                std::mem::swap(&mut near, &mut far);
            }
            (stack[depth], stack[depth + 1]) = (far, near);
            depth += 2;
        }
        best
    }

    /// Winding number at `x` (m): 1 inside and 0 outside a closed outward surface, accurate to about 0.05.
    pub fn winding_number(&self, x: &Vector<D>) -> f64 {
        let mut sum = 0.0;
        let mut at = 0;
        // A subtree is contiguous, so skipping it is a jump.
        while let Some(node) = self.nodes.get(at) {
            let far = &self.dipoles[at];
            let d = far.center - x;
            let distance = d.norm();
            if distance > DIPOLE_DISTANCE_RADII * far.radius && distance > 0.0 {
                sum += far.area.dot(&d) / (2.0 * (D - 1) as f64 * PI * distance.powi(D as i32));
                at = node.skip_index as usize;
            } else if node.second_child == 0 {
                let range = node.first as usize..(node.first + node.count) as usize;
                sum += self.corners[range].iter().map(|c| facet_winding(c, x)).sum::<f64>();
                at += 1;
            } else {
                at += 1;
            }
        }
        sum
    }

    /// Whether `x` (m) lies inside a closed outward surface.
    pub fn contains(&self, x: &Vector<D>) -> bool {
        let near = self.nodes.first().is_some_and(|root| root.distance_squared(x) == 0.0);
        near && self.winding_number(x) > 0.5
    }

    /// Distance to the surface, negative inside, m. Infinite for an empty surface.
    pub fn signed_distance(&self, x: &Vector<D>) -> f64 {
        let distance =
            self.closest_point(x, f64::INFINITY).map_or(f64::INFINITY, |c| c.distance_squared.sqrt());
        if self.contains(x) { -distance } else { distance }
    }
}

impl<const D: usize> Node<D> {
    /// Squared distance from a point to the box.
    fn distance_squared(&self, x: &Vector<D>) -> f64 {
        let mut sum = 0.0;
        for a in 0..D {
            let d = (self.lower[a] - x[a]).max(x[a] - self.upper[a]).max(0.0);
            sum += d * d;
        }
        sum
    }
}

/// Box and dipole of the given facets.
fn node<const D: usize>(
    mesh: &SurfaceMesh<D>,
    items: &[(Vector<D>, u32)],
    first: usize,
) -> (Node<D>, Dipole<D>) {
    let (mut lower, mut upper) = (Vector::<D>::repeat(f64::INFINITY), Vector::<D>::repeat(f64::NEG_INFINITY));
    let (mut area, mut moment, mut weight) = (Vector::<D>::zeros(), Vector::<D>::zeros(), 0.0);
    for (middle, facet) in items {
        let corners = mesh.corners(*facet as usize);
        corners.iter().for_each(|c| (lower, upper) = (lower.inf(c), upper.sup(c)));
        let a = area_vector(&corners);
        area += a;
        moment += middle * a.norm();
        weight += a.norm();
    }
    let center = if weight > 0.0 { moment / weight } else { (lower + upper) * 0.5 };
    let corners = items.iter().flat_map(|(_, f)| mesh.corners(*f as usize));
    let radius = corners.map(|c| (c - center).norm()).fold(0.0, f64::max);
    let node =
        Node { lower, upper, first: first as u32, count: items.len() as u32, second_child: 0, skip_index: 0 };
    (node, Dipole { area, center, radius })
}

/// Fraction of the full angle (2D) or solid angle (3D) that a facet subtends, positive from inside.
fn facet_winding<const D: usize>(corners: &[Vector<D>; D], x: &Vector<D>) -> f64 {
    let (a, b, c) = (corners[0] - x, corners[1] - x, corners[D - 1] - x);
    if D == 2 {
        return (a[0] * b[1] - a[1] * b[0]).atan2(a.dot(&b)) / (2.0 * PI);
    }
    // A. van Oosterom and J. Strackee, IEEE Trans. Biomed. Eng. 30 (1983) 125.
    let mut volume = 0.0;
    for k in 0..D {
        let (l, m) = ((k + 1) % D, (k + 2) % D);
        volume += a[k] * (b[l] * c[m] - b[m] * c[l]);
    }
    let (na, nb, nc) = (a.norm(), b.norm(), c.norm());
    volume.atan2(na * nb * nc + a.dot(&b) * nc + b.dot(&c) * na + c.dot(&a) * nb) / (2.0 * PI)
}

/// Closest point on a facet and its barycentric weights (C. Ericson, Real-Time Collision Detection, 2005, §5.1.5).
pub fn closest_on_facet<const D: usize>(corners: &[Vector<D>; D], x: &Vector<D>) -> (Vector<D>, [f64; D]) {
    let weights = if D == 2 {
        let t = segment_parameter(&corners[0], &corners[1], x);
        [1.0 - t, t, 0.0]
    } else {
        closest_barycentric([&corners[0], &corners[1], &corners[D - 1]], x)
    };
    let weights: [f64; D] = std::array::from_fn(|k| weights[k]);
    let point = corners.iter().zip(weights).fold(Vector::zeros(), |sum: Vector<D>, (c, w)| sum + c * w);
    (point, weights)
}

/// Parameter, 0 to 1, of the closest point on a segment.
fn segment_parameter<const D: usize>(a: &Vector<D>, b: &Vector<D>, x: &Vector<D>) -> f64 {
    let e = b - a;
    ((x - a).dot(&e) / e.norm_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0)
}

/// Barycentric weights of the closest point on a triangle.
fn closest_barycentric<const D: usize>([a, b, c]: [&Vector<D>; 3], x: &Vector<D>) -> [f64; 3] {
    let (ab, ac) = (b - a, c - a);
    let (ap, bp, cp) = (x - a, x - b, x - c);
    let (d1, d2, d3) = (ab.dot(&ap), ac.dot(&ap), ab.dot(&bp));
    let (d4, d5, d6) = (ac.dot(&bp), ab.dot(&cp), ac.dot(&cp));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let (va, vb, vc) = (d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2);
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let t = segment_parameter(a, b, x);
        return [1.0 - t, t, 0.0];
    }
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let t = segment_parameter(a, c, x);
        return [1.0 - t, 0.0, t];
    }
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        let t = segment_parameter(b, c, x);
        return [0.0, 1.0 - t, t];
    }
    let sum = va + vb + vc;
    [va / sum, vb / sum, vc / sum]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::{CellField, Grid, Run, Runs};
    use crate::mesh::extract_isosurface;

    /// Mesh of a dumbbell of two balls, extracted from the grid.
    fn mesh<const D: usize>(n: usize) -> SurfaceMesh<D> {
        let grid = Grid::<D>::new([n; D], 1.0 / n as f64);
        let mut phi = CellField::new(grid, 0.0);
        let mut runs: Vec<Run> = Vec::new();
        for k in 0..phi.data.len() {
            let x = grid.center(grid.lattice().coordinates(k));
            let ball = |c: f64, r: f64| (x - Vector::repeat(c)).norm() - r;
            phi.data[k] = ball(0.35, 0.2).min(ball(0.65, 0.25));
            if phi.data[k] < 0.0 {
                let (row, start) = ((k / n) as u32, (k % n) as u32);
                runs.push(Run { row, start, end: start + 1, component: 0 });
            }
        }
        extract_isosurface(&phi, &Runs { runs, components: 1 }).mesh
    }

    fn check<const D: usize>() {
        let mesh = mesh::<D>(24);
        assert!(mesh.is_watertight());
        let tree = FacetBvh::new(&mesh);
        let m = if D == 2 { 40usize } else { 14 };
        let mut worst: f64 = 0.0;
        for mut k in 0..m.pow(D as u32) {
            let x = Vector::<D>::from_fn(|_, _| {
                let i = k % m;
                k /= m;
                (i as f64 + 0.31) / m as f64 * 1.2 - 0.1
            });
            let brute = (0..mesh.facets.len())
                .map(|f| (closest_on_facet(&mesh.corners(f), &x).0 - x).norm_squared())
                .fold(f64::INFINITY, f64::min);
            let found = tree.closest_point(&x, f64::INFINITY).unwrap();
            assert_eq!(found.distance_squared, brute);
            let rebuilt: Vector<D> =
                (0..D).map(|i| mesh.corners(found.facet as usize)[i] * found.weights[i]).sum();
            assert!((rebuilt - found.point).norm() < 1e-14);
            assert_eq!(tree.closest_point(&x, 0.5 * brute.sqrt()), None);
            let exact: f64 = (0..mesh.facets.len()).map(|f| facet_winding(&mesh.corners(f), &x)).sum();
            assert!((exact - exact.round()).abs() < 1e-9);
            worst = worst.max((tree.winding_number(&x) - exact).abs());
            let ball = |c: f64, r: f64| (x - Vector::repeat(c)).norm() - r;
            let distance = ball(0.35, 0.2).min(ball(0.65, 0.25));
            if distance.abs() > 0.01 {
                assert_eq!(distance < 0.0, tree.signed_distance(&x) < 0.0);
            }
        }
        println!("{D}D: {} facets, winding number off by at most {worst}", mesh.facets.len());
        assert!(worst < 0.1);
    }

    #[test]
    fn mesh_tree_finds_closest_points_and_sides() {
        check::<2>();
        check::<3>();
        assert_eq!(
            FacetBvh::<3>::new(&SurfaceMesh::default()).signed_distance(&Vector::zeros()),
            f64::INFINITY
        );
    }
}
