//! Energy of the liquid's surface and volume of the liquid, with their exact derivatives, on the lattice of cell centres.
//!
//! On cubes between cell centres the area `A` of the free surface, the area `W` of the solids under liquid, and the
//! volume `V` are functions of the cell values. The surface's energy over its tension is `E = A − W cos θ`, with `cos θ =
//! (γ_sa − γ_ls)/γ_la` (Young), and `∂E/∂φ_c / ∂V/∂φ_c` is the curvature, that of the contact line included (design,
//! experiments parts 1 and 4). Walls mirror: a cube that reaches beyond a wall counts half.
//!
//! Beside solids the energy has the liquid's weight in it, `E = A − W cos θ + ∫ w·x dV` with `w = −ρ g/γ`: at rest the ratio
//! is then the same constant everywhere, however large the parts of the surface that a cell stands for, and the curvature is
//! that less `w·x`. Without it the surface within two cells of a wall had the curvature of a cell farther off, and a
//! meniscus of 8 cells a capillary length stood 4 % too low. Liquid that falls freely with its solid bears no such pressure:
//! a drop with Bo = 1 on a plate that falls has its angle wrong by half a degree (28 cells a radius).

use super::dual_cell::{CutCube, Split, away_from_zero};
use meniscus_numerics::grid::{Band, CutCells, Grid, Lattice, Runs, in_parallel};
use meniscus_numerics::{Vector, planes};
use rayon::prelude::*;

/// The lattice of cubes and how it splits.
pub struct SurfaceLattice<const D: usize> {
    grid: Grid<D>,
    split: Split<D>,
    /// The cubes that solids cut, sorted.
    dry: Vec<DryCube>,
    /// The liquid's weight `w = −ρ g Δ²/γ`, in 1/cells².
    weight: Vector<D>,
}

/// A cube that a solid cuts.
struct DryCube {
    key: u32,
    /// Distance to the solid at the corners, in cells.
    psi: [f64; 8],
    /// The cells of the corners that have an open face, one bit each.
    open: u8,
    /// Number of the solid that is nearest.
    solid: u32,
    /// Cosine of the contact angle there, and of Young's.
    cosine: f64,
    young: f64,
    /// Whether a line there rests.
    pinned: bool,
    /// What a cube is in which all is liquid.
    flooded: CutCube,
}

impl<const D: usize> SurfaceLattice<D> {
    /// The lattice of a grid, without solids; the liquid's weight is `w = −ρ g Δ²/γ`, in 1/cells².
    pub fn new(grid: Grid<D>, weight: Vector<D>) -> Self {
        Self { grid, split: Split::new(), dry: Vec::new(), weight }
    }

    /// Finds the cubes that solids cut; `nearest` tells the nearest solid's number and the cosine of its contact
    /// angle there.
    pub fn follow(&mut self, cut: &CutCells<D>, nearest: impl Fn(&Vector<D>) -> (u32, f64) + Sync) {
        let (cubes, cells) = (self.cubes(), self.grid.lattice());
        let dry = |at: [usize; D]| {
            let corners = self.corners(at);
            let psi: [f64; 8] = std::array::from_fn(|k| away_from_zero(cut.distance(corners[k] as usize)));
            if psi[..1 << D].iter().all(|v| *v > 0.0) {
                return None;
            }
            let open = (0..1 << D)
                .filter(|k| !cut.closed(cells.coordinates(corners[*k] as usize)))
                .fold(0, |bits, k| bits | 1 << k);
            if open == 0 {
                return None;
            }
            let key = cubes.index(at) as u32;
            let (solid, young) = nearest(&self.grid.corner(at));
            let flooded = CutCube::new(corners, open);
            let mut dry = DryCube { key, psi, open, solid, cosine: young, young, pinned: false, flooded };
            dry.flooded = self.wetted(&dry, &[-1.0; 8], at);
            Some(dry)
        };
        let of = |[low, high]: &[[usize; D]; 2]| -> Vec<DryCube> {
            in_parallel([*low, high.map(|n| n + 1)]).filter_map(dry).collect()
        };
        let mut all: Vec<DryCube> = cut.boxes().iter().flat_map(of).collect();
        all.sort_by_key(|d| d.key);
        all.dedup_by_key(|d| d.key);
        self.dry = all;
    }

    /// Every cube that the surface passes or in which liquid wets a solid, in order of memory.
    pub fn cut(&self, phi: &[f64], band: &Band<D>) -> Vec<CutCube> {
        let cubes = self.cubes();
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
        let wet = |d: &DryCube| d.flooded.corners[..1 << D].iter().any(|c| phi[*c as usize] < 0.0);
        keys.extend(self.dry.iter().filter(|d| wet(d)).map(|d| d.key));
        keys.par_sort_unstable();
        keys.dedup();
        keys.par_iter().map(|&k| self.cube(phi, k)).collect()
    }

    /// The contact line as the energy has it: a point, m, in every cube in which it pulls at a solid.
    pub fn line_places(&self, phi: &[f64]) -> Vec<Vector<D>> {
        self.line_cubes(phi).into_iter().map(|(_, place)| place).collect()
    }

    /// Numbers of the cubes with a contact line, and its place there, m.
    fn line_cubes(&self, phi: &[f64]) -> Vec<(usize, Vector<D>)> {
        let cubes = self.cubes();
        let place = |(number, dry): (usize, &DryCube)| {
            let values: [f64; 8] = std::array::from_fn(|k| {
                phi.get(dry.flooded.corners[k] as usize).map_or(1.0, |v| away_from_zero(v / self.grid.dx))
            });
            let wet = (0..1 << D).filter(|k| values[*k] < 0.0).count();
            let at = cubes.coordinates(dry.key as usize);
            let pulls = || self.wetted(dry, &values, at).lift != [0.0; 3];
            let lower = Vector::from_fn(|a, _| self.grid.from_origin(a, at[a] as f64 - 0.5));
            let there = wet > 0 && wet < 1 << D && pulls();
            there.then(|| (number, (lower + both_zero(&values, &dry.psi)) * self.grid.dx))
        };
        self.dry.par_iter().enumerate().with_min_len(256).filter_map(place).collect()
    }

    /// Sets the angle of the lines: `wetting` tells for a place (m) and the number of its solid the cosine, and whether the
    /// line rests.
    pub fn hold_lines(&mut self, phi: &[f64], wetting: impl Fn(&Vector<D>, u32) -> (f64, bool) + Sync) {
        let lines = self.line_cubes(phi);
        let held: Vec<(f64, bool)> =
            lines.par_iter().map(|(number, place)| wetting(place, self.dry[*number].solid)).collect();
        // A line may come to any of them before it is held again; nothing of earlier steps is kept that a checkpoint has not.
        self.dry.iter_mut().for_each(|dry| (dry.cosine, dry.pinned) = (dry.young, false));
        for ((number, _), (cosine, pinned)) in lines.into_iter().zip(held) {
            let dry = &mut self.dry[number];
            (dry.cosine, dry.pinned) = (cosine, pinned);
        }
    }

    fn cubes(&self) -> Lattice<D> {
        Lattice::new(self.grid.cells.map(|n| n + 1))
    }

    /// The cells of a cube's corners. `at` is one more than the lower corner, so that cubes beyond the lower walls have 0;
    /// beyond a wall stands the mirror image.
    fn corners(&self, at: [usize; D]) -> [u32; 8] {
        let cells = self.grid.lattice();
        let corner = |k: usize, a: usize| (at[a] + (k >> a & 1)).saturating_sub(1).min(cells.extent[a] - 1);
        std::array::from_fn(|k| {
            if k < 1 << D { cells.index(std::array::from_fn(|a| corner(k, a))) as u32 } else { u32::MAX }
        })
    }

    fn cube(&self, phi: &[f64], key: u32) -> CutCube {
        let at = self.cubes().coordinates(key as usize);
        let corners = self.corners(at);
        let values: [f64; 8] = std::array::from_fn(|k| {
            phi.get(corners[k] as usize).map_or(1.0, |v| away_from_zero(v / self.grid.dx))
        });
        let liquid = (0..1 << D).filter(|k| values[*k] < 0.0).fold(0u8, |bits, k| bits | 1 << k);
        if let Ok(i) = self.dry.binary_search_by_key(&key, |d| d.key) {
            let dry = &self.dry[i];
            let flooded = u32::from(liquid).count_ones() == 1 << D;
            return if flooded { dry.flooded.clone() } else { self.wetted(dry, &values, at) };
        }
        let mut cube = CutCube::new(corners, liquid);
        self.split.cut(&values, &self.weight_within(at), &mut cube);
        self.place(&mut cube, at);
        cube
    }

    /// What the surface cuts out of a cube beside a solid.
    fn wetted(&self, dry: &DryCube, values: &[f64; 8], at: [usize; D]) -> CutCube {
        let liquid = (0..1 << D).filter(|k| values[*k] < 0.0).fold(0u8, |bits, k| bits | 1 << k);
        let mut cube = CutCube::new(dry.flooded.corners, liquid & dry.open);
        (cube.solid, cube.cosine, cube.young, cube.pinned) = (dry.solid, dry.cosine, dry.young, dry.pinned);
        self.split.cut_beside(values, &dry.psi, &self.weight_within(at), &mut cube);
        self.place(&mut cube, at);
        cube
    }

    /// The weight in a cube: nothing along axes along which it is mirrored.
    fn weight_within(&self, at: [usize; D]) -> Vector<D> {
        let mirrored = |a: usize| at[a] == 0 || at[a] == self.grid.cells[a];
        Vector::from_fn(|a, _| if mirrored(a) { 0.0 } else { self.weight[a] })
    }

    /// Brings a cube from the unit cube to its place.
    fn place(&self, cube: &mut CutCube, at: [usize; D]) {
        let last = self.grid.cells;
        // The half of a mirrored cube that is in the domain lies a quarter of a cell from the wall.
        let from_origin = |a: usize, i: f64| self.grid.from_origin(a, i);
        let shift = Vector::<D>::from_fn(|a, _| match at[a] {
            0 => from_origin(a, 0.25),
            n if n == last[a] => from_origin(a, n as f64 - 0.25),
            n => from_origin(a, n as f64 - 0.5),
        });
        let high = self.weight.dot(&shift);
        (0..1 << D).for_each(|k| cube.energy_slope[k] += high * cube.volume_slope[k]);
        for &(a, b, place) in planes::<D>() {
            let [x, y] = [a, b].map(|a| from_origin(a, at[a] as f64 - 0.5));
            cube.turns[0][place] += x * cube.lift[b] - y * cube.lift[a];
            cube.turns[1][place] += x * cube.wetward[b] - y * cube.wetward[a];
        }
        let sides = (0..D).filter(|&a| at[a] == 0 || at[a] == last[a]).count();
        cube.scale(0.5f64.powi(sides as i32));
        for a in 0..D {
            let own = if at[a] == 0 || at[a] == last[a] { 0.0 } else { cube.moment[a] };
            cube.moment[a] = own + shift[a] * cube.excess;
        }
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
            let mut moment = Vector::from_fn(|a, _| n * self.grid.from_origin(a, at[a] as f64 + 0.5));
            moment[0] = n * self.grid.from_origin(0, 0.5 * (run.start + run.end) as f64);
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

/// Steps of Newton's iteration to where two fields vanish.
const CROSSINGS: usize = 4;

/// Where in the unit cube two fields with these values at the corners are both zero, near its middle.
fn both_zero<const D: usize>(one: &[f64; 8], other: &[f64; 8]) -> Vector<D> {
    let mut s = Vector::<D>::repeat(0.5);
    for _ in 0..CROSSINGS {
        let fields = [one, other].map(|v| multilinear(v, &s));
        let [(f, p), (g, q)] = fields;
        let (pp, pq, qq) = (p.norm_squared(), p.dot(&q), q.norm_squared());
        let determinant = (pp * qq - pq * pq).max(1e-3 * pp * qq).max(f64::MIN_POSITIVE);
        s -= (p * (qq * f - pq * g) + q * (pp * g - pq * f)) / determinant;
        s = s.map(|x| x.clamp(0.0, 1.0));
    }
    s
}

/// Value and gradient of a field with values at the corners of the unit cube.
fn multilinear<const D: usize>(values: &[f64; 8], s: &Vector<D>) -> (f64, Vector<D>) {
    let weight = |k: usize, a: usize| if k >> a & 1 == 1 { s[a] } else { 1.0 - s[a] };
    let rest = |k: usize, a: usize| (0..D).filter(|b| *b != a).map(|b| weight(k, b)).product::<f64>();
    let corners = || (0..1usize << D).map(|k| (k, values[k]));
    let slope =
        |a: usize| corners().map(|(k, v)| v * rest(k, a) * if k >> a & 1 == 1 { 1.0 } else { -1.0 }).sum();
    (corners().map(|(k, v)| v * rest(k, D)).sum(), Vector::from_fn(|a, _| slope(a)))
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
        let lattice = SurfaceLattice::new(grid, Vector::zeros());
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
                slopes[cube.corners[k] as usize].0 -= cube.energy_slope[k];
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

    /// A liquid's weight that points along no axis.
    fn weight<const D: usize>() -> Vector<D> {
        Vector::from_fn(|a, _| 0.03 - 0.05 * a as f64)
    }

    /// Energy and volume beside a ball, and the cubes.
    fn measure_beside<const D: usize>(phi: &[f64], grid: Grid<D>) -> (f64, f64, Vec<CutCube>) {
        let ball = |x: &Vector<D>| (x - Vector::from_fn(|a, _| 8.2 - 0.4 * a as f64)).norm() - 3.1;
        let bounds = [Vector::repeat(3.0), Vector::repeat(12.0)];
        let mut cut = CutCells::none(grid);
        cut.rebuild(&[meniscus_numerics::grid::CutBy { distance: &ball, bounds }], &Tiles::all(grid));
        let mut lattice = SurfaceLattice::new(grid, weight());
        lattice.follow(&cut, |_| (0, 0.6));
        let inside = Tiles::all(grid).negative_runs(phi);
        let inside = inside.filtered(&grid, |c| !cut.closed(grid.lattice().coordinates(c))).label(&grid);
        let mut band = Band::new(grid);
        band.rebuild(phi, &inside, 3);
        let cubes = lattice.cut(phi, &band);
        let (volume, center) = lattice.volumes(&inside, |_| Some(0), &cubes)[0];
        let energy: f64 = cubes.iter().map(|c| c.area - c.cosine * c.wetted).sum();
        (energy + volume * center.dot(&weight()), volume, cubes)
    }

    fn check_beside<const D: usize>() {
        let grid = Grid::<D>::new([14; D], 1.0);
        let lattice = grid.lattice();
        let phi: Vec<f64> = (0..lattice.len())
            .map(|i| {
                let x = grid.center(lattice.coordinates(i));
                (x - Vector::from_fn(|a, _| 5.1 + 0.3 * a as f64)).norm() - 3.9
            })
            .collect();
        let (_, _, cubes) = measure_beside(&phi, grid);
        assert!(cubes.iter().filter(|c| c.lift != [0.0; 3]).count() > if D == 2 { 1 } else { 20 });
        let mut slopes = vec![(0.0, 0.0); phi.len()];
        for cube in &cubes {
            for k in 0..1 << D {
                slopes[cube.corners[k] as usize].0 -= cube.energy_slope[k];
                slopes[cube.corners[k] as usize].1 -= cube.volume_slope[k];
            }
        }
        let (mut worst, mut checked) = ((0.0f64, 0.0f64), 0);
        for cell in (0..phi.len()).filter(|&c| slopes[c].1 != 0.0 && phi[c].abs() > 1e-3) {
            let shifted = |h: f64| {
                let mut p = phi.clone();
                p[cell] += h;
                measure_beside(&p, grid)
            };
            if D == 3 && cell % 5 != 0 {
                continue;
            }
            let (up, down) = (shifted(1e-6), shifted(-1e-6));
            worst.0 = worst.0.max(((up.0 - down.0) / 2e-6 - slopes[cell].0).abs());
            worst.1 = worst.1.max(((up.1 - down.1) / 2e-6 - slopes[cell].1).abs());
            checked += 1;
        }
        assert!(checked > 10 && worst.0 < 1e-5 && worst.1 < 1e-5, "{D}D: {worst:?} of {checked}");
    }

    #[test]
    fn slopes_beside_a_solid_are_exact_derivatives() {
        check_beside::<2>();
        check_beside::<3>();
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
            let measuring = SurfaceLattice::new(grid, Vector::zeros());
            measuring.volumes(&inside, |_| Some(0), &measuring.cut(&phi, &band))[0].1
        };
        let tank = center(&|x| x[2] - 2.1);
        assert!((tank - Vector::<3>::new(1.5, 1.25, 1.05)).norm() < 1e-12, "{tank}");
        let middle = Vector::<3>::new(1.43, 1.31, 2.07);
        let ball = center(&|x| (x - middle).norm() - 0.9);
        assert!((ball - middle).norm() < 1e-3 * grid.dx, "{ball} {middle}");
    }
}
