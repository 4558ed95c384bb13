//! Area of the liquid's surface and volume of the liquid, with their exact derivatives, on the lattice of cell centres.
//!
//! Cubes between cell centres are split into simplices on which φ is linear: four triangles in 2D, two times five
//! tetrahedra in 3D, both ways to split counting half, so that no direction is preferred. Then
//! `A(φ)` and `V(φ)` are functions of the cell values, and `∂A/∂φ_c / ∂V/∂φ_c` is the curvature (design, experiments
//! parts 1 and 4). Walls mirror: a cube that reaches beyond a wall counts half.

use meniscus_numerics::Vector;
use meniscus_numerics::grid::{Band, Grid, Lattice, Runs};
use rayon::prelude::*;

/// One surface-carrying cube: its corners' cells and what it contributes, in units of the cell size.
#[derive(Clone, Debug)]
pub struct CutCube {
    /// Cell of each corner (beyond a wall: its mirror image).
    pub corners: [u32; 8],
    /// Area inside the cube.
    pub area: f64,
    /// Liquid volume inside the cube less one share (1/2^D) for every liquid corner.
    pub excess: f64,
    /// First moment of that difference about the origin.
    pub moment: [f64; 3],
    /// Which corners are liquid, one bit each.
    pub wet: u8,
    /// −∂area/∂φ of each corner.
    pub area_slope: [f64; 8],
    /// −∂volume/∂φ of each corner.
    pub volume_slope: [f64; 8],
}

/// The surface passes no corner nearer than this (in cells): a simplex cut exactly at a corner has no derivative.
pub const NEAREST: f64 = 1e-6;

/// A simplex of the split cube: corners, its volume, and the gradients of its barycentric coordinates.
struct Simplex<const D: usize> {
    corners: [usize; 4],
    volume: f64,
    slopes: [[f64; D]; 4],
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

/// The lattice of cubes and how it splits.
pub struct SurfaceLattice<const D: usize> {
    grid: Grid<D>,
    simplices: Vec<Simplex<D>>,
}

impl<const D: usize> SurfaceLattice<D> {
    /// The lattice of a grid.
    pub fn new(grid: Grid<D>) -> Self {
        let table: &[[usize; 4]] = if D == 2 { &TRIANGLES } else { &TETRAHEDRA };
        Self { grid, simplices: table.iter().map(|c| simplex(*c)).collect() }
    }

    /// Every cube that the surface passes, in order of memory.
    pub fn cut(&self, phi: &[f64], band: &Band<D>) -> Vec<CutCube> {
        let cubes = Lattice::new(self.grid.cells.map(|n| n + 1));
        let cells = self.grid.lattice();
        let mut keys: Vec<u32> = band.cells[band.first_layers(1)]
            .par_iter()
            .filter(|&&c| phi[c as usize] < 0.0)
            .flat_map_iter(|&c| {
                let at = cells.coordinates(c as usize);
                (0..1usize << D)
                    .map(move |k| cubes.index(std::array::from_fn(|a| at[a] + (k >> a & 1))) as u32)
            })
            .collect();
        keys.par_sort_unstable();
        keys.dedup();
        keys.par_iter().map(|&k| self.cube(phi, cubes.coordinates(k as usize))).collect()
    }

    /// `at` is one more than the lower corner, so that cubes beyond the lower walls have 0.
    fn cube(&self, phi: &[f64], at: [usize; D]) -> CutCube {
        let cells = self.grid.lattice();
        let mut weight = 1.0;
        for a in 0..D {
            if at[a] == 0 || at[a] == cells.extent[a] {
                weight *= 0.5;
            }
        }
        let mut corners = [0; 8];
        let mut values = [0.0; 8];
        let mut wet = 0u8;
        for k in 0..1 << D {
            let cell = cells.index(std::array::from_fn(|a| {
                (at[a] + (k >> a & 1)).saturating_sub(1).min(cells.extent[a] - 1)
            }));
            corners[k] = cell as u32;
            let value = phi[cell] / self.grid.dx;
            values[k] = value.abs().max(NEAREST).copysign(value);
            if value < 0.0 {
                wet |= 1 << k;
            }
        }
        let mut cube = CutCube {
            corners,
            area: 0.0,
            excess: 0.0,
            moment: [0.0; 3],
            wet,
            area_slope: [0.0; 8],
            volume_slope: [0.0; 8],
        };
        for k in (0..1 << D).filter(|k| wet >> k & 1 == 1) {
            cube.fill(-1.0 / (1 << D) as f64, &[corner(k)]);
        }
        for simplex in &self.simplices {
            if D == 2 {
                cut_triangle(simplex, &values, &mut cube)
            } else {
                cut_tetrahedron(simplex, &values, &mut cube)
            }
        }
        cube.area *= weight;
        cube.excess *= weight;
        for a in 0..D {
            // The half of a mirrored cube that is in the domain lies a quarter of a cell from the wall.
            cube.moment[a] = if at[a] == 0 {
                0.25 * cube.excess
            } else if at[a] == cells.extent[a] {
                (at[a] as f64 - 0.25) * cube.excess
            } else {
                cube.moment[a] * weight + (at[a] as f64 - 0.5) * cube.excess
            };
        }
        for k in 0..1 << D {
            cube.area_slope[k] *= weight;
            cube.volume_slope[k] *= weight;
        }
        cube
    }

    /// Volume (m³, 2D: m²) and centre (m) of each component of the liquid. What a cube holds beyond its corners' shares
    /// belongs to its liquid corners in equal parts: then no component has a negative volume.
    pub fn volumes(
        &self,
        liquid: &Runs,
        label: impl Fn(usize) -> Option<u32>,
        cubes: &[CutCube],
    ) -> Vec<(f64, Vector<D>)> {
        let mut sums = self.whole_cells(liquid);
        let middles: Vec<Vector<D>> = sums.iter().map(|(n, moment)| moment / *n).collect();
        for cube in cubes {
            cube.share(&label, |c, part| {
                let (volume, moment) = &mut sums[c as usize];
                *volume += part * cube.excess;
                *moment += Vector::from_fn(|a, _| part * cube.moment[a]);
            });
        }
        let dx = self.grid.dx;
        let center = |(c, (volume, moment)): (usize, (f64, Vector<D>))| {
            // Next to nothing has its centre lost in rounding.
            let center = if volume > 1e-6 { moment / volume } else { middles[c] };
            (volume * self.grid.cell_volume(), center * dx)
        };
        sums.into_iter().enumerate().map(center).collect()
    }

    /// Number of cells and sum of their centres, in cells; half a cell at a wall lies behind its centre.
    fn whole_cells(&self, liquid: &Runs) -> Vec<(f64, Vector<D>)> {
        let cells = self.grid.lattice();
        let mut sums = vec![(0.0, Vector::zeros()); liquid.components as usize];
        for run in &liquid.runs {
            let at = cells.coordinates(run.row as usize * cells.extent[0]);
            let n = (run.end - run.start) as f64;
            let mut moment = Vector::from_fn(|a, _| n * (at[a] as f64 + 0.5));
            moment[0] = 0.5 * n * (run.start + run.end) as f64;
            for a in 0..D {
                let (first, last) =
                    if a == 0 { (run.start as usize, run.end as usize - 1) } else { (at[a], at[a]) };
                let count = if a == 0 { 1.0 } else { n };
                moment[a] -= if first == 0 { 0.125 * count } else { 0.0 };
                moment[a] += if last + 1 == cells.extent[a] { 0.125 * count } else { 0.0 };
            }
            let sum = &mut sums[run.component as usize];
            sum.0 += n;
            sum.1 += moment;
        }
        sums
    }
}

impl CutCube {
    /// Adds (a negative `volume` takes away) a piece with its centre in the middle of `points` of the unit cube.
    fn fill(&mut self, volume: f64, points: &[[f64; 3]]) {
        self.excess += volume;
        for x in points {
            (0..3).for_each(|a| self.moment[a] += volume / points.len() as f64 * x[a]);
        }
    }

    /// Calls `f(component, part)` for every liquid corner; the parts add up to one.
    pub fn share(&self, label: impl Fn(usize) -> Option<u32>, mut f: impl FnMut(u32, f64)) {
        let part = 1.0 / f64::from(self.wet.count_ones());
        for k in (0..8).filter(|k| self.wet >> k & 1 == 1) {
            if let Some(c) = label(self.corners[k] as usize) {
                f(c, part);
            }
        }
    }
}

/// Where a corner of the unit cube is.
fn corner(k: usize) -> [f64; 3] {
    std::array::from_fn(|a| (k >> a & 1) as f64)
}

fn simplex<const D: usize>(corners: [usize; 4]) -> Simplex<D> {
    let point = |k: usize| meniscus_numerics::Vector::<D>::from_fn(|a, _| (corners[k] >> a & 1) as f64);
    let edges = meniscus_numerics::Matrix::<D>::from_fn(|r, c| (point(c + 1) - point(0))[r]);
    // Rows of the inverse are the gradients of the barycentric coordinates 1 … D.
    let inverse = edges.try_inverse().unwrap_or_else(meniscus_numerics::Matrix::zeros);
    let mut slopes = [[0.0; D]; 4];
    for i in 0..D {
        for a in 0..D {
            slopes[i + 1][a] = inverse[(i, a)];
            slopes[0][a] -= inverse[(i, a)];
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
    Simplex { corners, volume: 0.5 * volume, slopes }
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

/// Adds `force · ∂x/∂φ` for a force on a root to the slopes of its edge's corners (with a minus sign).
fn pull<const D: usize>(
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
        let slope: f64 = (0..=D).map(|i| values[simplex.corners[i]] * simplex.slopes[i][a]).sum();
        square += slope * slope;
    }
    square.sqrt().max(1e-12)
}

/// Splits the simplex's corners into liquid ones and others.
fn sides<const D: usize>(simplex: &Simplex<D>, values: &[f64; 8]) -> ([usize; 4], usize) {
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

fn cut_triangle<const D: usize>(s: &Simplex<D>, values: &[f64; 8], cube: &mut CutCube) {
    let (o, wet) = sides(s, values);
    let at = |i: usize| corner(s.corners[o[i]]);
    let (p, q) = match wet {
        0 => return,
        3 => return cube.fill(s.volume, &[at(0), at(1), at(2)]),
        1 => {
            let (p, q) = (root(s, values, o[0], o[1]), root(s, values, o[0], o[2]));
            cube.fill(s.volume * p.t * q.t, &[at(0), p.x, q.x]);
            (p, q)
        }
        _ => {
            let (p, q) = (root(s, values, o[0], o[2]), root(s, values, o[1], o[2]));
            cube.fill(s.volume, &[at(0), at(1), at(2)]);
            cube.fill(-s.volume * (1.0 - p.t) * (1.0 - q.t), &[at(2), p.x, q.x]);
            (p, q)
        }
    };
    let d: [f64; 3] = std::array::from_fn(|i| q.x[i] - p.x[i]);
    let length = (d[0] * d[0] + d[1] * d[1]).sqrt();
    cube.area += 0.5 * length;
    let unit = d.map(|c| 0.5 * c / length.max(1e-12));
    pull(s, values, &q, unit, &mut cube.area_slope);
    pull(s, values, &p, unit.map(|c| -c), &mut cube.area_slope);
    let share = 0.25 * length / gradient_norm(s, values);
    for r in [&p, &q] {
        cube.volume_slope[s.corners[r.a]] += share * (1.0 - r.t);
        cube.volume_slope[s.corners[r.b]] += share * r.t;
    }
}

fn cut_tetrahedron<const D: usize>(s: &Simplex<D>, values: &[f64; 8], cube: &mut CutCube) {
    let (o, wet) = sides(s, values);
    let edge = |i: usize, j: usize| root(s, values, o[i], o[j]);
    let at = |i: usize| corner(s.corners[o[i]]);
    let whole = [at(0), at(1), at(2), at(3)];
    match wet {
        0 => {}
        4 => cube.fill(s.volume, &whole),
        1 => {
            let r = [edge(0, 1), edge(0, 2), edge(0, 3)];
            cube.fill(s.volume * r[0].t * r[1].t * r[2].t, &[at(0), r[0].x, r[1].x, r[2].x]);
            cut_facet(s, values, &r, cube);
        }
        3 => {
            let r = [edge(0, 3), edge(1, 3), edge(2, 3)];
            let dry = (1.0 - r[0].t) * (1.0 - r[1].t) * (1.0 - r[2].t);
            cube.fill(s.volume, &whole);
            cube.fill(-s.volume * dry, &[at(3), r[0].x, r[1].x, r[2].x]);
            cut_facet(s, values, &r, cube);
        }
        _ => {
            let (ac, ad, bc, bd) = (edge(0, 2), edge(0, 3), edge(1, 2), edge(1, 3));
            cube.fill(s.volume * ac.t * ad.t, &[at(0), ac.x, ad.x, at(1)]);
            cube.fill(s.volume * ac.t * bd.t * (1.0 - ad.t), &[ac.x, ad.x, bd.x, at(1)]);
            cube.fill(s.volume * (1.0 - ac.t) * bc.t * bd.t, &[ac.x, bc.x, bd.x, at(1)]);
            cut_facet(s, values, &[ac, ad, bd], cube);
            cut_facet(s, values, &[ac, bd, bc], cube);
        }
    }
}

fn cut_facet<const D: usize>(s: &Simplex<D>, values: &[f64; 8], r: &[Root; 3], cube: &mut CutCube) {
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
        pull(s, values, &r[i], force, &mut cube.area_slope);
    }
    let share = 0.5 * area / (3.0 * gradient_norm(s, values));
    for r in r {
        cube.volume_slope[s.corners[r.a]] += share * (1.0 - r.t);
        cube.volume_slope[s.corners[r.b]] += share * r.t;
    }
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use meniscus_numerics::Vector;
    use meniscus_numerics::grid::Tiles;

    fn measure<const D: usize>(phi: &[f64], grid: Grid<D>) -> (f64, f64, Vec<CutCube>) {
        let inside = Tiles::all(grid).negative_runs(phi).label(&grid);
        let mut band = Band::new(grid);
        band.rebuild(phi, &inside, 3);
        let lattice = SurfaceLattice::new(grid);
        let cubes = lattice.cut(phi, &band);
        let volume: f64 = lattice.volumes(&inside, |_| Some(0), &cubes).iter().map(|v| v.0).sum();
        (cubes.iter().map(|c| c.area).sum(), volume, cubes)
    }

    fn check<const D: usize>() {
        let grid = Grid::<D>::new([14; D], 1.0);
        let lattice = grid.lattice();
        let phi: Vec<f64> = (0..lattice.len())
            .map(|i| {
                let x = grid.center(lattice.coordinates(i));
                let wobble = 0.2 * (1.3 * x[0] + 0.7 * x[1]).sin();
                (x - Vector::from_fn(|a, _| 5.1 + 0.3 * a as f64)).norm() - 3.9 + wobble
            })
            .collect();
        let (_, _, cubes) = measure(&phi, grid);
        let mut slopes = vec![(0.0, 0.0); phi.len()];
        for cube in &cubes {
            for k in 0..1 << D {
                slopes[cube.corners[k] as usize].0 -= cube.area_slope[k];
                slopes[cube.corners[k] as usize].1 -= cube.volume_slope[k];
            }
        }
        for cell in (0..phi.len()).filter(|&c| slopes[c].1 != 0.0).step_by(7) {
            let shifted = |h: f64| {
                let mut p = phi.clone();
                p[cell] += h;
                measure(&p, grid)
            };
            let (up, down) = (shifted(1e-6), shifted(-1e-6));
            assert!(((up.0 - down.0) / 2e-6 - slopes[cell].0).abs() < 1e-6, "area slope in {D}D");
            assert!(((up.1 - down.1) / 2e-6 - slopes[cell].1).abs() < 1e-6, "volume slope in {D}D");
        }
    }

    #[test]
    fn slopes_are_exact_derivatives() {
        check::<2>();
        check::<3>();
    }

    #[test]
    fn half_a_tank_is_half_a_tank() {
        let grid = Grid::<3>::new([6, 5, 8], 0.5);
        let lattice = grid.lattice();
        let phi: Vec<f64> =
            (0..lattice.len()).map(|i| grid.center(lattice.coordinates(i))[2] - 2.1).collect();
        let (area, volume, _) = measure(&phi, grid);
        assert!((area - 30.0).abs() < 1e-12 && (volume - 3.0 * 2.5 * 2.1).abs() < 1e-12);
    }

    #[test]
    fn the_center_is_that_of_the_liquid() {
        let grid = Grid::<3>::new([24, 20, 32], 0.125);
        let lattice = grid.lattice();
        let center = |f: &dyn Fn(Vector<3>) -> f64| {
            let phi: Vec<f64> = (0..lattice.len()).map(|i| f(grid.center(lattice.coordinates(i)))).collect();
            let inside = Tiles::all(grid).negative_runs(&phi).label(&grid);
            let mut band = Band::new(grid);
            band.rebuild(&phi, &inside, 3);
            let measuring = SurfaceLattice::new(grid);
            measuring.volumes(&inside, |_| Some(0), &measuring.cut(&phi, &band))[0].1
        };
        let tank = center(&|x| x[2] - 2.1);
        assert!((tank - Vector::<3>::new(1.5, 1.25, 1.05)).norm() < 1e-12, "{tank}");
        let middle = Vector::<3>::new(1.43, 1.31, 2.07);
        let ball = center(&|x| (x - middle).norm() - 0.9);
        assert!((ball - middle).norm() < 1e-3 * grid.dx, "{ball} {middle}");
    }
}
