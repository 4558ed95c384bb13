//! Isosurface stuffing: fills a region given by a signed distance with well-shaped simplices.
//!
//! F. Labelle and J. Shewchuk, "Isosurface Stuffing: Fast Tetrahedral Meshes with Good Dihedral Angles", ACM Trans. Graph. 26
//! (2007) 57. The simplices of a lattice fill space. A vertex with a crossing of the surface near it on one of its edges is
//! warped to the crossing. Simplices that are still crossed are cut at the crossings. So boundary vertices lie on the surface
//! to rounding, facets are second-order accurate, and no angle is small.
//!
//! The lattice is that of the permutohedron, $A_D^*$: triangular in 2D, body-centred cubic in 3D. Its vectors $v_1 … v_D$ and
//! $v_0 = -\sum v_k$ are equivalent. The simplices at a vertex are the paths along $v_{\pi 1} … v_{\pi D}$, one for each order
//! π. In 3D edges along one $v$ are short; those along two are longer by $2 / \sqrt 3$.
//!
//! A crossed simplex is bisected at its crossings one after another in a global order, so neighbours agree on their common
//! facet without tables of cases: long edges before short ones, as in the article's stencils, then edges with the larger
//! inside fraction. Measured angles in degrees: 17 to 141 (dihedral) at planes, 11 to 164 for random signs at the vertices
//! (the article proves 10.7 to 164.8); in 2D 16 to 139. Limit: creases are cut off by up to an edge, and parts thinner than
//! an edge may be lost.

use crate::Vector;
use crate::mesh::volume::block::BlockError;
use crate::mesh::volume::{MeshDefect, Simplex, VolumeMesh};
use crate::par;
use thiserror::Error;

/// Fraction of an edge within which a crossing warps the vertex: long edges, short edges (article, Table 1).
const WARP_THRESHOLDS_3D: [f64; 2] = [0.249_99, 0.411_89];
/// The same in 2D, where all edges are alike; this value maximises the smallest angle (measured).
const WARP_THRESHOLDS_2D: [f64; 2] = [0.4, 0.4];
/// Mean edge of the mesh over the longest edge of the lattice.
const MEAN_EDGE_3D: f64 = 0.923;
/// Most vertices of a lattice, half of which a compact body fills. A solid's matrices need about 8 kB per vertex in 3D.
const MAX_LATTICE_VERTICES: usize = 1 << 22;
/// Most iterations of the root search along an edge, and its tolerance, in edges.
const MAX_ROOT_ITERATIONS: usize = 60;
const ROOT_TOLERANCE: f64 = 1e-13;

/// Relative difference of distance up to which crossings count as equally near.
const EQUAL_DISTANCE_TOLERANCE: f64 = 1e-6;

/// A signed distance, negative inside; point and distance in m.
pub type Distance<'a, const D: usize> = dyn Fn(&Vector<D>) -> f64 + Sync + 'a;

/// Why a region cannot be meshed.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum StuffingError {
    /// The edge is not positive and finite, or the bounds are not finite.
    #[error(
        "a box from {lower:?} to {upper:?} m cannot be filled with a lattice with edges of {edge} m; give a positive length and finite \
         bounds"
    )]
    Size {
        /// Edge requested, m.
        edge: f64,
        /// Lower bounds, m.
        lower: Vec<f64>,
        /// Upper bounds, m.
        upper: Vec<f64>,
    },
    /// The lattice would have too many vertices.
    #[error("a lattice with edges of {edge} m would have {vertices:e} vertices; give longer edges")]
    TooFine {
        /// Edge requested, m.
        edge: f64,
        /// Vertices of the lattice.
        vertices: f64,
    },
    /// The region is empty, or thinner than an edge.
    #[error(
        "no vertex of a lattice with edges of {edge} m lies in the region; give shorter edges, or a region that is not empty"
    )]
    Empty {
        /// Edge requested, m.
        edge: f64,
    },
    /// The region extends beyond the bounds.
    #[error("the region extends beyond its bounds near {near:?} m; give larger bounds")]
    Beyond {
        /// A point of the region outside the bounds, m.
        near: Vec<f64>,
    },
    /// The shape is a box that cannot be a lattice.
    #[error(transparent)]
    Block(#[from] BlockError),
    /// The region is locally thinner than an edge, so the mesh touches itself.
    #[error("the mesh with edges of {edge} m has a defect: {defect}; give shorter edges")]
    Defect {
        /// Edge requested, m.
        edge: f64,
        /// Defect of the mesh.
        defect: MeshDefect,
    },
}

/// Fills the region where a signed distance (m) is negative with simplices whose edges are about `edge` (m) long. Only the
/// sign and the zeros of the distance between neighbouring lattice vertices matter, so any continuous function that is
/// negative inside will do. `lower` and `upper` (m) bound the region. A lattice vertex lies at the centre of the bounds, so
/// the mesh keeps mirror planes of the region through it along the axes.
///
/// Cost: one distance for each vertex of a lattice that fills the bounds, a few for each crossing.
///
/// # Errors
/// Invalid sizes, or a region that is empty, extends beyond its bounds or is too thin.
pub fn stuff<const D: usize>(
    distance: &Distance<D>,
    lower: &Vector<D>,
    upper: &Vector<D>,
    edge: f64,
) -> Result<VolumeMesh<D>, StuffingError> {
    let mesh = stuff_unchecked(
        distance,
        lower,
        upper,
        edge,
        if D == 2 { WARP_THRESHOLDS_2D } else { WARP_THRESHOLDS_3D },
    )?;
    mesh.check_elements().map_err(|defect| StuffingError::Defect { edge, defect })?;
    Ok(mesh)
}

/// As [`stuff`], with given warp thresholds and without a check.
fn stuff_unchecked<const D: usize>(
    distance: &Distance<D>,
    lower: &Vector<D>,
    upper: &Vector<D>,
    edge: f64,
    warp_thresholds: [f64; 2],
) -> Result<VolumeMesh<D>, StuffingError> {
    let lattice = PermutohedralLattice::new(lower, upper, edge)?;
    let value = |i: usize| distance(&lattice.position(&lattice.point(i)));
    let values = par::map(lattice.len(), 64, value);
    if let Some(i) = (0..values.len()).find(|i| values[*i] < 0.0 && lattice.at_border(*i)) {
        return Err(StuffingError::Beyond { near: lattice.position(&lattice.point(i)).as_slice().to_vec() });
    }
    let cuts = EdgeCrossings::new(&lattice, &values, distance);
    let stuffing = Stuffing::new(&lattice, &values, cuts, warp_thresholds, distance);
    let simplices = stuffing.simplices(distance);
    if simplices.is_empty() {
        return Err(StuffingError::Empty { edge });
    }
    Ok(VolumeMesh { positions: stuffing.positions, simplices }.compacted())
}

/// The lattice around the bounds. A vertex is at `middle + scale q` for integers `q` of one parity (3D) or with an even sum
/// (2D). Vertices are numbered densely.
struct PermutohedralLattice<const D: usize> {
    middle: Vector<D>,
    scale: Vector<D>,
    /// Even offset that makes `q` non-negative.
    offset: [i32; D],
    /// Number of vertices along each axis; in 3D for each parity.
    extent: [usize; D],
}

impl<const D: usize> PermutohedralLattice<D> {
    fn new(lower: &Vector<D>, upper: &Vector<D>, edge: f64) -> Result<Self, StuffingError> {
        let size = upper - lower;
        let listed = |v: &Vector<D>| v.as_slice().to_vec();
        if !(edge > 0.0 && edge.is_finite() && size.iter().all(|s| s.is_finite() && *s >= 0.0)) {
            return Err(StuffingError::Size { edge, lower: listed(lower), upper: listed(upper) });
        }
        let scale = Vector::<D>::from_fn(|a, _| match (D, a) {
            (2, 0) => 0.5 * edge,
            (2, _) => 0.75f64.sqrt() * edge,
            _ => 0.5 * edge / MEAN_EDGE_3D,
        });
        // The lattice extends at least four steps beyond the bounds; the region must not reach the outermost ones.
        let steps = (size * 0.5).component_div(&scale).map(|s| (s / 2.0).ceil() * 2.0 + 4.0);
        let vertices = steps.iter().map(|s| s + 1.0).product::<f64>() * (D - 1) as f64;
        if vertices > MAX_LATTICE_VERTICES as f64 {
            return Err(StuffingError::TooFine { edge, vertices });
        }
        let offset: [i32; D] = std::array::from_fn(|a| steps[a] as i32);
        let extent = std::array::from_fn(|a| offset[a] as usize * if D == 2 && a == 1 { 2 } else { 1 } + 1);
        Ok(Self { middle: (lower + upper) * 0.5, scale, offset, extent })
    }

    fn len(&self) -> usize {
        self.extent.iter().product::<usize>() * (D - 1)
    }

    /// The vectors of the paths of simplices.
    fn vectors() -> [[i32; D]; D] {
        if D == 2 {
            std::array::from_fn(|k| std::array::from_fn(|a| [[2, 0], [-1, 1]][k][a]))
        } else {
            std::array::from_fn(|k| std::array::from_fn(|a| if a == k { 1 } else { -1 }))
        }
    }

    /// The number of a vertex, if the lattice contains it.
    fn index(&self, q: &[i32; D]) -> Option<usize> {
        let q: [i32; D] = std::array::from_fn(|a| q[a] + self.offset[a]);
        let parity = q[D - 1] & 1;
        let mut index = 0;
        for a in (0..D).rev() {
            let halved = D == 3 || a == 0;
            let i = usize::try_from(if halved { (q[a] - parity).div_euclid(2) } else { q[a] }).ok()?;
            if i >= self.extent[a] {
                return None;
            }
            index = index * self.extent[a] + i;
        }
        Some(if D == 3 { 2 * index + parity as usize } else { index })
    }

    /// The vertex with a number.
    fn point(&self, index: usize) -> [i32; D] {
        let mut rest = if D == 3 { index / 2 } else { index };
        let mut i = [0; D];
        for a in 0..D {
            i[a] = (rest % self.extent[a]) as i32;
            rest /= self.extent[a];
        }
        let parity = if D == 3 { (index & 1) as i32 } else { i[1] & 1 };
        std::array::from_fn(|a| {
            if D == 3 || a == 0 { 2 * i[a] + parity - self.offset[a] } else { i[a] - self.offset[a] }
        })
    }

    fn position(&self, q: &[i32; D]) -> Vector<D> {
        Vector::from_fn(|a, _| self.middle[a] + self.scale[a] * f64::from(q[a]))
    }

    /// Whether a vertex lies outside the bounds by an edge or more.
    fn at_border(&self, index: usize) -> bool {
        let q = self.point(index);
        (0..D).any(|a| q[a].abs() >= self.offset[a] - 1)
    }

    /// A point moved along some of the vectors (bits of `along`).
    fn translated(q: &[i32; D], along: usize) -> [i32; D] {
        let vectors = Self::vectors();
        std::array::from_fn(|a| {
            q[a] + (0..D).filter(|k| along >> k & 1 == 1).map(|k| vectors[k][a]).sum::<i32>()
        })
    }
}

/// Crossing of the surface with an edge.
#[derive(Clone, Copy)]
struct EdgeCrossing<const D: usize> {
    /// The inside and the outside vertex.
    ends: [u32; 2],
    /// Position along the edge from the inside vertex, 0 to 1.
    fraction: f64,
    long: bool,
    position: Vector<D>,
}

/// Crossings, sorted by the lower and higher vertex of their edges.
struct EdgeCrossings<const D: usize> {
    all: Vec<EdgeCrossing<D>>,
}

impl<const D: usize> EdgeCrossing<D> {
    fn key(&self) -> [u32; 2] {
        [self.ends[0].min(self.ends[1]), self.ends[0].max(self.ends[1])]
    }
}

impl<const D: usize> EdgeCrossings<D> {
    fn new(lattice: &PermutohedralLattice<D>, values: &[f64], distance: &Distance<D>) -> Self {
        let crossing = |i: usize, along: usize| -> Option<EdgeCrossing<D>> {
            let here = lattice.point(i);
            let there = PermutohedralLattice::translated(&here, along);
            let j = lattice.index(&there)?;
            if values[i] * values[j] >= 0.0 {
                return None;
            }
            let inside = values[i] < 0.0;
            let (ends, points) = if inside { ([i, j], [here, there]) } else { ([j, i], [there, here]) };
            let [a, b] = points.map(|q| lattice.position(&q));
            let fraction = root(&|t| distance(&(a + (b - a) * t)), ends.map(|i| values[i]));
            let long = D == 3 && along.count_ones() == 2;
            Some(EdgeCrossing {
                ends: ends.map(|i| i as u32),
                fraction,
                long,
                position: a + (b - a) * fraction,
            })
        };
        let from = |i: usize| (1..1usize << D).filter_map(move |along| crossing(i, along));
        let mut all =
            par::flat_map(values.len(), 64, |i, all: &mut Vec<EdgeCrossing<D>>| all.extend(from(i)));
        all.sort_unstable_by_key(EdgeCrossing::key);
        Self { all }
    }

    /// The index of the crossing between two vertices.
    fn between(&self, a: u32, b: u32) -> Option<usize> {
        self.all.binary_search_by_key(&[a.min(b), a.max(b)], EdgeCrossing::key).ok()
    }
}

/// The lattice warped to the surface.
struct Stuffing<'a, const D: usize> {
    lattice: &'a PermutohedralLattice<D>,
    /// Positions of the lattice's vertices, then of the crossings.
    positions: Vec<Vector<D>>,
    /// Side of each lattice vertex: -1 inside, 0 on the surface, 1 outside.
    side: Vec<i8>,
    cuts: EdgeCrossings<D>,
    /// Rank of each crossing in the order of cutting.
    rank: Vec<u32>,
}

impl<'a, const D: usize> Stuffing<'a, D> {
    fn new(
        lattice: &'a PermutohedralLattice<D>,
        values: &[f64],
        cuts: EdgeCrossings<D>,
        warp_thresholds: [f64; 2],
        distance: &Distance<D>,
    ) -> Self {
        let sign = |v: &f64| if *v < 0.0 { -1 } else { i8::from(*v > 0.0) };
        let mut side: Vec<i8> = values.iter().map(sign).collect();
        let mut positions: Vec<Vector<D>> =
            (0..lattice.len()).map(|i| lattice.position(&lattice.point(i))).collect();
        // Each vertex is warped to the nearest crossing within the threshold.
        let mut draws: Vec<(u32, f64, usize)> = Vec::new();
        for (k, cut) in cuts.all.iter().enumerate() {
            let reach = warp_thresholds[usize::from(!cut.long)];
            for (end, at) in [(cut.ends[0], cut.fraction), (cut.ends[1], 1.0 - cut.fraction)] {
                if at < reach {
                    draws.push((end, (cut.position - positions[end as usize]).norm(), k));
                }
            }
        }
        draws.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
        for near in draws.chunk_by(|a, b| a.0 == b.0) {
            let vertex = near[0].0 as usize;
            let alike = near.iter().take_while(|n| n.1 <= near[0].1 * (1.0 + EQUAL_DISTANCE_TOLERANCE));
            let alike: Vec<Vector<D>> = alike.map(|n| cuts.all[n.2].position).collect();
            positions[vertex] = warped_position(&positions[vertex], values[vertex], &alike, distance);
            side[vertex] = 0;
        }
        positions.extend(cuts.all.iter().map(|c| c.position));
        let mut order: Vec<usize> = (0..cuts.all.len()).collect();
        order.sort_unstable_by(|a, b| {
            let (c, d) = (&cuts.all[*a], &cuts.all[*b]);
            d.long.cmp(&c.long).then(d.fraction.total_cmp(&c.fraction)).then(a.cmp(b))
        });
        let mut rank = vec![0; order.len()];
        order.iter().enumerate().for_each(|(place, k)| rank[*k] = place as u32);
        Self { lattice, positions, side, cuts, rank }
    }

    /// All simplices of the region.
    fn simplices(&self, distance: &Distance<D>) -> Vec<Simplex<D>> {
        const ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [1, 0, 2], [0, 2, 1], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
        let orders = &ORDERS[..if D == 2 { 2 } else { 6 }];
        par::flat_map(self.side.len(), 64, |i, out| {
            let q = self.lattice.point(i);
            for order in orders {
                let mut along = 0;
                let mut vertices = [i as u32; 4];
                let whole = (0..D).all(|k| {
                    along |= 1 << order[k];
                    let next = self.lattice.index(&PermutohedralLattice::translated(&q, along));
                    vertices[k + 1] = next.unwrap_or(0) as u32;
                    next.is_some()
                });
                if whole {
                    self.clip(vertices, distance, out);
                }
            }
        })
    }

    /// Adds the inside part of a simplex (its first `D + 1` vertices).
    fn clip(&self, vertices: [u32; 4], distance: &Distance<D>, out: &mut Vec<Simplex<D>>) {
        let used = &vertices[..=D];
        let side = |v: u32| self.side.get(v as usize).copied().unwrap_or(0);
        if used.iter().all(|v| side(*v) > 0) {
            return;
        }
        let mut first: Option<(u32, usize, [usize; 2])> = None;
        for i in 0..=D {
            for j in 0..i {
                if side(used[i]) * side(used[j]) < 0 {
                    // Two lattice vertices on different sides have a crossing between them.
                    let Some(k) = self.cuts.between(used[i], used[j]) else { return };
                    if first.is_none_or(|f| self.rank[k] < f.0) {
                        first = Some((self.rank[k], k, [i, j]));
                    }
                }
            }
        }
        if let Some((_, k, ends)) = first {
            for end in ends {
                let mut part = vertices;
                part[end] = (self.side.len() + k) as u32;
                self.clip(part, distance, out);
            }
            return;
        }
        let simplex = Simplex { root: vertices[0], others: std::array::from_fn(|k| vertices[k + 1]) };
        let all_on_surface = used.iter().all(|v| side(*v) == 0);
        let inside = used.iter().all(|v| side(*v) <= 0);
        if inside && (!all_on_surface || distance(&simplex.center(&self.positions)) < 0.0) {
            out.push(simplex.oriented(&self.positions));
        }
    }
}

/// Warped position of a vertex with equally near crossings: a single crossing itself, else the surface in the direction of
/// their mean, which preserves mirror symmetry.
fn warped_position<const D: usize>(
    vertex: &Vector<D>,
    value: f64,
    crossings: &[Vector<D>],
    distance: &Distance<D>,
) -> Vector<D> {
    let toward = (crossings.iter().sum::<Vector<D>>() / crossings.len() as f64 - vertex) * 2.0;
    let at = |t: f64| vertex + toward * t;
    let beyond = distance(&at(1.0));
    if crossings.len() == 1 || value * beyond >= 0.0 {
        return crossings[0];
    }
    at(if value < 0.0 {
        root(&|t| distance(&at(t)), [value, beyond])
    } else {
        root(&|t| -distance(&at(t)), [-value, -beyond])
    })
}

/// Crossing of a surface with the segment to `from + displacement` from inside, to `from - displacement` from outside, if any.
pub(super) fn surface_crossing<const D: usize>(
    from: &Vector<D>,
    displacement: &Vector<D>,
    distance: &Distance<D>,
) -> Option<Vector<D>> {
    let here = distance(from);
    let displacement = displacement * -here.signum();
    let there = distance(&(from + displacement));
    if here == 0.0 || here * there > 0.0 {
        return None;
    }
    let sign = -here.signum();
    Some(
        from + displacement
            * root(&|t| sign * distance(&(from + displacement * t)), [sign * here, sign * there]),
    )
}

/// The zero, 0 to 1, of a function that is negative at 0 and positive at 1, with the given values there: false position with
/// halved weights (Illinois), and bisection steps.
fn root(f: &dyn Fn(f64) -> f64, [mut low_value, mut high_value]: [f64; 2]) -> f64 {
    let (mut low, mut high, mut last) = (0.0, 1.0, 0);
    let mut t = 0.5;
    for step in 0..MAX_ROOT_ITERATIONS {
        let guess = low + (high - low) * low_value / (low_value - high_value);
        t = if step % 8 < 6 && guess > low && guess < high { guess } else { 0.5 * (low + high) };
        let value = f(t);
        if value == 0.0 || high - low < ROOT_TOLERANCE {
            break;
        }
        let sign = if value < 0.0 { -1 } else { 1 };
        if sign < 0 {
            (low, low_value) = (t, value);
            high_value *= if last < 0 { 0.5 } else { 1.0 };
        } else {
            (high, high_value) = (t, value);
            low_value *= if last > 0 { 0.5 } else { 1.0 };
        }
        last = sign;
    }
    t
}

#[cfg(test)]
#[path = "isosurface_stuffing_tests.rs"]
mod tests;
