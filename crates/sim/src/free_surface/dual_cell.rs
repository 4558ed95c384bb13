//! One dual cell (a cube between cell centres): area of the free surface in it, liquid volume, wetted area, and their exact
//! derivatives by the values of φ at the corners.
//!
//! The cube is split into simplices on which φ is linear: four triangles in 2D, two times five tetrahedra in 3D. Both ways to
//! split count half, so that no direction is preferred.

use meniscus_numerics::shape::ClipSimplex as ClippedSimplex;
use meniscus_numerics::{Matrix, Vector};

/// The liquid in a dual cell, in units of the cell size.
#[derive(Clone, Debug)]
pub struct DualCell {
    /// Cell of each corner (beyond a side its mirror image; in 2D the last four are `u32::MAX`).
    pub corners: [u32; 8],
    /// Bit mask of the corners that are liquid cells.
    pub liquid_corners: u8,
    /// Area of the free surface.
    pub area: f64,
    /// Wetted area of the solid.
    pub wetted_area: f64,
    /// Liquid volume minus one share (1/2^D) for every liquid corner.
    pub excess_volume: f64,
    /// First moment of the excess volume about the origin.
    pub excess_moment: [f64; 3],
    /// −∂/∂φ at each corner of the energy: free area, minus `contact_cosine` times the wetted area, plus the potential energy of
    /// the liquid's weight.
    pub energy_slope: [f64; 8],
    /// −∂volume/∂φ at each corner.
    pub volume_slope: [f64; 8],
    /// Index of the solid in the cube; `u32::MAX` if there is none.
    pub solid: u32,
    /// Cosine of its contact angle.
    pub contact_cosine: f64,
    /// Cosine of Young's angle; the two differ with hysteresis.
    pub young_cosine: f64,
    /// Whether a contact line in it is pinned.
    pub pinned: bool,
    /// Normal part of the free surface's force on the solid, over the tension, integrated along the contact line.
    pub normal_pull: [f64; 3],
    /// Tangent of the solid into the liquid, integrated along the contact line.
    pub wetting_direction: [f64; 3],
    /// Moments of both about the origin (2D: in the last entry).
    pub pull_moments: [[f64; 3]; 2],
}

/// Smallest distance of the surface from a corner, in cells: a simplex cut exactly at a corner has no derivative.
pub const MIN_CORNER_DISTANCE_CELLS: f64 = 1e-6;

/// A value in cells, bounded away from zero; −0 is not liquid, as everywhere.
pub fn away_from_zero(value: f64) -> f64 {
    let size = value.abs().max(MIN_CORNER_DISTANCE_CELLS);
    if value < 0.0 { -size } else { size }
}

/// A simplex of the split cube: corners, its volume, and the gradients of its barycentric coordinates.
struct Simplex<const D: usize> {
    corners: [usize; 4],
    volume: f64,
    gradients: [[f64; D]; 4],
}

/// Corners (bit a = up along axis a) of the simplices of both splits, each counting half.
const TRIANGLES: [[usize; 4]; 4] = [[0, 1, 3, 9], [0, 3, 2, 9], [0, 1, 2, 9], [1, 3, 2, 9]];
const TETRAHEDRA: [[usize; 4]; 10] = [
    [0, 3, 5, 6],
    [1, 0, 3, 5],
    [2, 0, 3, 6],
    [4, 0, 5, 6],
    [7, 3, 5, 6],
    [7, 4, 2, 1],
    [0, 1, 2, 4],
    [3, 1, 2, 7],
    [5, 1, 4, 7],
    [6, 2, 4, 7],
];

/// Both splits of a cube.
pub struct SimplexSplit<const D: usize> {
    free: Vec<Simplex<D>>,
    clipped: Vec<ClippedSimplex<D>>,
}

impl<const D: usize> SimplexSplit<D> {
    /// The splits of the unit cube.
    pub fn new() -> Self {
        let table: &[[usize; 4]] = if D == 2 { &TRIANGLES } else { &TETRAHEDRA };
        let place = |k: usize| Vector::from_fn(|a, _| corner(k)[a]);
        Self {
            free: table.iter().map(|c| simplex(*c)).collect(),
            clipped: table.iter().map(|c| ClippedSimplex::new(c.map(place))).collect(),
        }
    }

    /// Adds the liquid in the unit cube without solids; `bond_vector` is the energy per volume and height along each axis.
    pub fn cut(&self, values: &[f64; 8], bond_vector: &Vector<D>, dual_cell: &mut DualCell) {
        dual_cell.subtract_corner_shares::<D>();
        for simplex in &self.free {
            let surface = SimplexCut { simplex, values, bond_vector };
            if D == 2 { cut_triangle(&surface, dual_cell) } else { cut_tetrahedron(&surface, dual_cell) }
        }
    }

    /// Adds the liquid in the part of the unit cube where `psi` is positive.
    pub fn cut_with_solid(
        &self,
        values: &[f64; 8],
        psi: &[f64; 8],
        bond_vector: &Vector<D>,
        dual_cell: &mut DualCell,
    ) {
        dual_cell.subtract_corner_shares::<D>();
        for (clipped, simplex) in self.clipped.iter().zip(&self.free) {
            // A corner that does not exist (2D) is outside everything.
            let of = |v: &[f64; 8]| std::array::from_fn(|i| if i <= D { v[simplex.corners[i]] } else { 1.0 });
            let cut = clipped.cut(&of(values), &of(psi));
            dual_cell.area += 0.5 * cut.area;
            dual_cell.wetted_area += 0.5 * cut.wetted_area;
            dual_cell.excess_volume += 0.5 * cut.volume;
            for a in 0..3 {
                dual_cell.excess_moment[a] += 0.5 * cut.moment[a];
                dual_cell.normal_pull[a] += 0.5 * cut.normal_pull[0][a];
                dual_cell.wetting_direction[a] += 0.5 * cut.wetting_direction[0][a];
                dual_cell.pull_moments[0][a] += 0.5 * cut.normal_pull[1][a];
                dual_cell.pull_moments[1][a] += 0.5 * cut.wetting_direction[1][a];
            }
            for i in 0..=D {
                let heavy: f64 = (0..D).map(|a| bond_vector[a] * cut.moment_slope[i][a]).sum();
                let energy = cut.area_slope[i] - dual_cell.contact_cosine * cut.wetted_area_slope[i] + heavy;
                dual_cell.energy_slope[simplex.corners[i]] -= 0.5 * energy;
                dual_cell.volume_slope[simplex.corners[i]] -= 0.5 * cut.volume_slope[i];
            }
        }
    }
}

impl<const D: usize> Default for SimplexSplit<D> {
    fn default() -> Self {
        Self::new()
    }
}

impl DualCell {
    /// A cube in which the surface is not cut yet and the liquid corners' shares are not subtracted yet.
    pub fn new(corners: [u32; 8], liquid_corners: u8) -> Self {
        let zero = [0.0; 8];
        Self {
            corners,
            liquid_corners,
            area: 0.0,
            wetted_area: 0.0,
            excess_volume: 0.0,
            excess_moment: [0.0; 3],
            energy_slope: zero,
            volume_slope: zero,
            solid: u32::MAX,
            contact_cosine: 0.0,
            young_cosine: 0.0,
            pinned: false,
            normal_pull: [0.0; 3],
            wetting_direction: [0.0; 3],
            pull_moments: [[0.0; 3]; 2],
        }
    }

    /// Force of surface and line on the solid, over the tension, integrated along the contact line: normal to the solid that of
    /// the free surface, along it that of equilibrium. The unbalanced tangential part moves the liquid.
    pub fn pull(&self) -> [f64; 3] {
        std::array::from_fn(|a| self.normal_pull[a] + self.contact_cosine * self.wetting_direction[a])
    }

    /// Moment of [`Self::pull`] about the origin (2D: in the last entry).
    pub fn pull_moment(&self) -> [f64; 3] {
        std::array::from_fn(|a| self.pull_moments[0][a] + self.contact_cosine * self.pull_moments[1][a])
    }

    /// Midpoint of the contact line, in cells, from its moments; `None` without a line.
    pub fn line_center(&self) -> Option<[f64; 3]> {
        // r × l = m for both integrated directions l: (l² − l lᵀ) r = l × m.
        let [lift, wetward] = [self.normal_pull, self.wetting_direction].map(Vector::<3>::from);
        let square = |l: &Vector<3>| Matrix::<3>::identity() * l.norm_squared() - l * l.transpose();
        let [first, second] = self.pull_moments.map(Vector::<3>::from);
        let all = lift.cross(&first) + wetward.cross(&second);
        let place = (square(&lift) + square(&wetward)).cholesky()?.solve(&all);
        Some(place.into())
    }

    /// Length of the contact line, in cells (2D: number of its points).
    pub fn line_length(&self) -> f64 {
        dot(self.wetting_direction, self.wetting_direction).sqrt()
    }

    /// Unit tangent of the contact line; zero without one. In 2D, where the line is a point, it points out of the plane.
    pub fn line_direction(&self) -> [f64; 3] {
        let direction = cross(self.normal_pull, self.wetting_direction);
        let size = dot(direction, direction).sqrt();
        if size > 0.0 { direction.map(|c| c / size) } else { [0.0; 3] }
    }

    /// Multiplies all integrals by a factor.
    pub fn scale(&mut self, by: f64) {
        for part in [&mut self.area, &mut self.wetted_area, &mut self.excess_volume] {
            *part *= by;
        }
        let lists = self
            .excess_moment
            .iter_mut()
            .chain(&mut self.normal_pull)
            .chain(&mut self.wetting_direction)
            .chain(self.pull_moments.as_flattened_mut());
        lists.chain(&mut self.energy_slope).chain(&mut self.volume_slope).for_each(|v| *v *= by);
    }

    /// Subtracts the volume shares of the liquid corners.
    fn subtract_corner_shares<const D: usize>(&mut self) {
        let wet = self.liquid_corners;
        for k in (0..1 << D).filter(|k| wet >> k & 1 == 1) {
            self.add_volume(-1.0 / (1 << D) as f64, &[corner(k)]);
        }
    }

    /// Adds a piece (subtracts it if `volume` is negative) with its centroid in the middle of `points` of the unit cube.
    fn add_volume(&mut self, volume: f64, points: &[[f64; 3]]) {
        self.excess_volume += volume;
        for x in points {
            (0..3).for_each(|a| self.excess_moment[a] += volume / points.len() as f64 * x[a]);
        }
    }

    /// Calls `f(component, part)` for every liquid corner; the parts add up to one.
    pub fn distribute(&self, label: impl Fn(usize) -> Option<u32>, f: impl FnMut(u32, f64)) {
        distribute(&self.corner_components(label), f);
    }

    /// The components of the liquid corners, by the `label` of their cells.
    pub fn corner_components(&self, label: impl Fn(usize) -> Option<u32>) -> CornerComponents {
        // Without an open liquid corner the components at all corners count.
        let corners = if self.liquid_corners == 0 { u8::MAX } else { self.liquid_corners };
        std::array::from_fn(|k| {
            let there = corners >> k & 1 == 1 && self.corners[k] != u32::MAX;
            if there { label(self.corners[k] as usize) } else { None }
        })
    }
}

/// Components at the corners of a dual cell that are liquid.
pub type CornerComponents = [Option<u32>; 8];

/// Calls `f(component, part)` for every corner with a component; the parts add up to one.
pub fn distribute(components: &CornerComponents, mut f: impl FnMut(u32, f64)) {
    let part = 1.0 / components.iter().flatten().count() as f64;
    components.iter().flatten().for_each(|c| f(*c, part));
}

/// Position of a corner of the unit cube.
fn corner(k: usize) -> [f64; 3] {
    std::array::from_fn(|a| (k >> a & 1) as f64)
}

fn simplex<const D: usize>(corners: [usize; 4]) -> Simplex<D> {
    let point = |k: usize| Vector::<D>::from_fn(|a, _| (corners[k] >> a & 1) as f64);
    let edges = Matrix::<D>::from_fn(|r, c| (point(c + 1) - point(0))[r]);
    // Rows of the inverse are the gradients of the barycentric coordinates 1 … D.
    let inverse = edges.try_inverse().unwrap_or_else(Matrix::zeros);
    let mut gradients = [[0.0; D]; 4];
    for i in 0..D {
        for a in 0..D {
            gradients[i + 1][a] = inverse[(i, a)];
            gradients[0][a] -= inverse[(i, a)];
        }
    }
    let central = D == 3 && corners.iter().all(|c| c.count_ones() % 2 == corners[0].count_ones() % 2);
    let volume = if D == 2 {
        0.5
    } else if central {
        1.0 / 3.0
    } else {
        1.0 / 6.0
    };
    Simplex { corners, volume: 0.5 * volume, gradients }
}

/// A simplex, the values of φ at the corners of its cube, and the bond vector.
struct SimplexCut<'a, const D: usize> {
    simplex: &'a Simplex<D>,
    values: &'a [f64; 8],
    bond_vector: &'a Vector<D>,
}

/// A point where the surface crosses an edge: from liquid corner `a` a fraction `t` toward corner `b`.
#[derive(Clone, Copy)]
struct Root {
    a: usize,
    b: usize,
    t: f64,
    x: [f64; 3],
}

fn root<const D: usize>(simplex: &Simplex<D>, values: &[f64; 8], a: usize, b: usize) -> Root {
    let (ka, kb) = (simplex.corners[a], simplex.corners[b]);
    let t = values[ka] / (values[ka] - values[kb]).min(-1e-12);
    let x = std::array::from_fn(|i| {
        let (xa, xb) = (corner(ka)[i], corner(kb)[i]);
        xa + t * (xb - xa)
    });
    Root { a, b, t, x }
}

/// Adds −`force · ∂x/∂φ` of a force on a root to the slopes at the corners of its edge.
fn add_edge_force<const D: usize>(
    s: &Simplex<D>,
    values: &[f64; 8],
    root: &Root,
    force: [f64; 3],
    slope: &mut [f64; 8],
) {
    let (ka, kb) = (s.corners[root.a], s.corners[root.b]);
    let mut along = 0.0;
    for i in 0..D {
        along += force[i] * ((kb >> i & 1) as f64 - (ka >> i & 1) as f64);
    }
    let span = (values[ka] - values[kb]).min(-1e-12);
    slope[ka] -= along * (1.0 - root.t) / span;
    slope[kb] -= along * root.t / span;
}

fn gradient_norm<const D: usize>(simplex: &Simplex<D>, values: &[f64; 8]) -> f64 {
    let mut square = 0.0;
    for a in 0..D {
        let slope: f64 = (0..=D).map(|i| values[simplex.corners[i]] * simplex.gradients[i][a]).sum();
        square += slope * slope;
    }
    square.sqrt().max(1e-12)
}

impl<const D: usize> SimplexCut<'_, D> {
    /// Adds the derivatives of volume and of the weight's energy that the motion of a facet of this area causes.
    fn add_facet_derivatives(&self, area: f64, facet: &[Root], cube: &mut DualCell) {
        let n = facet.len() as f64;
        let share = area / (n * gradient_norm(self.simplex, self.values));
        let height = |r: &Root| (0..D).map(|a| self.bond_vector[a] * r.x[a]).sum::<f64>();
        let sum: f64 = facet.iter().map(height).sum();
        for r in facet {
            let heavy = share * (height(r) + sum) / (n + 1.0);
            for (corner, part) in [(r.a, 1.0 - r.t), (r.b, r.t)] {
                let corner = self.simplex.corners[corner];
                cube.volume_slope[corner] += share * part;
                cube.energy_slope[corner] += heavy * part;
            }
        }
    }
}

/// Orders the corners of the simplex, liquid ones first, and counts the liquid ones.
fn partition_corners<const D: usize>(simplex: &Simplex<D>, values: &[f64; 8]) -> ([usize; 4], usize) {
    let mut order = [0; 4];
    let mut wet = 0;
    for i in 0..=D {
        if values[simplex.corners[i]] < 0.0 {
            order[wet] = i;
            wet += 1;
        }
    }
    let mut at = wet;
    for i in 0..=D {
        if values[simplex.corners[i]] >= 0.0 {
            order[at] = i;
            at += 1;
        }
    }
    (order, wet)
}

fn cut_triangle<const D: usize>(surface: &SimplexCut<'_, D>, cube: &mut DualCell) {
    let (s, values) = (surface.simplex, surface.values);
    let (o, wet) = partition_corners(s, values);
    let at = |i: usize| corner(s.corners[o[i]]);
    let (p, q) = match wet {
        0 => return,
        3 => return cube.add_volume(s.volume, &[at(0), at(1), at(2)]),
        1 => {
            let (p, q) = (root(s, values, o[0], o[1]), root(s, values, o[0], o[2]));
            cube.add_volume(s.volume * p.t * q.t, &[at(0), p.x, q.x]);
            (p, q)
        }
        _ => {
            let (p, q) = (root(s, values, o[0], o[2]), root(s, values, o[1], o[2]));
            cube.add_volume(s.volume, &[at(0), at(1), at(2)]);
            cube.add_volume(-s.volume * (1.0 - p.t) * (1.0 - q.t), &[at(2), p.x, q.x]);
            (p, q)
        }
    };
    let d: [f64; 3] = std::array::from_fn(|i| q.x[i] - p.x[i]);
    let length = (d[0] * d[0] + d[1] * d[1]).sqrt();
    cube.area += 0.5 * length;
    let unit = d.map(|c| 0.5 * c / length.max(1e-12));
    add_edge_force(s, values, &q, unit, &mut cube.energy_slope);
    add_edge_force(s, values, &p, unit.map(|c| -c), &mut cube.energy_slope);
    surface.add_facet_derivatives(0.5 * length, &[p, q], cube);
}

fn cut_tetrahedron<const D: usize>(surface: &SimplexCut<'_, D>, cube: &mut DualCell) {
    let (s, values) = (surface.simplex, surface.values);
    let (o, wet) = partition_corners(s, values);
    let edge = |i: usize, j: usize| root(s, values, o[i], o[j]);
    let at = |i: usize| corner(s.corners[o[i]]);
    let whole = [at(0), at(1), at(2), at(3)];
    match wet {
        0 => {}
        4 => cube.add_volume(s.volume, &whole),
        1 => {
            let r = [edge(0, 1), edge(0, 2), edge(0, 3)];
            cube.add_volume(s.volume * r[0].t * r[1].t * r[2].t, &[at(0), r[0].x, r[1].x, r[2].x]);
            cut_facet(surface, &r, cube);
        }
        3 => {
            let r = [edge(0, 3), edge(1, 3), edge(2, 3)];
            let dry = (1.0 - r[0].t) * (1.0 - r[1].t) * (1.0 - r[2].t);
            cube.add_volume(s.volume, &whole);
            cube.add_volume(-s.volume * dry, &[at(3), r[0].x, r[1].x, r[2].x]);
            cut_facet(surface, &r, cube);
        }
        _ => {
            let (ac, ad, bc, bd) = (edge(0, 2), edge(0, 3), edge(1, 2), edge(1, 3));
            cube.add_volume(s.volume * ac.t * ad.t, &[at(0), ac.x, ad.x, at(1)]);
            cube.add_volume(s.volume * ac.t * bd.t * (1.0 - ad.t), &[ac.x, ad.x, bd.x, at(1)]);
            cube.add_volume(s.volume * (1.0 - ac.t) * bc.t * bd.t, &[ac.x, bc.x, bd.x, at(1)]);
            cut_facet(surface, &[ac, ad, bd], cube);
            cut_facet(surface, &[ac, bd, bc], cube);
        }
    }
}

fn cut_facet<const D: usize>(surface: &SimplexCut<'_, D>, r: &[Root; 3], cube: &mut DualCell) {
    let (s, values) = (surface.simplex, surface.values);
    let edge = |i: usize, j: usize| -> [f64; 3] { std::array::from_fn(|k| r[j].x[k] - r[i].x[k]) };
    let normal = cross(edge(0, 1), edge(0, 2));
    let double = (normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]).sqrt();
    if double < 1e-14 {
        return;
    }
    let unit = normal.map(|c| c / double);
    let area = 0.5 * double;
    cube.area += 0.5 * area;
    for i in 0..3 {
        let force = cross(unit, edge((i + 1) % 3, (i + 2) % 3)).map(|c| 0.25 * c);
        add_edge_force(s, values, &r[i], force, &mut cube.energy_slope);
    }
    surface.add_facet_derivatives(0.5 * area, r, cube);
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
