//! Tests of the energy and its derivatives.

use super::*;
use meniscus_numerics::Vector;
use meniscus_numerics::grid::Tiles;

/// The components at the corners of dual cells around a liquid of one component.
fn of_one(cubes: &[DualCell]) -> Vec<CornerComponents> {
    cubes.iter().map(|cube| cube.corner_components(|_| Some(0))).collect()
}

fn measure<const D: usize>(phi: &[f64], grid: Grid<D>) -> (f64, f64, Vec<DualCell>) {
    let inside = Tiles::all(grid).negative_runs(phi).label(&grid);
    let mut band = Band::new(grid);
    band.rebuild(phi, &inside, 3);
    let lattice = DualGrid::new(grid, Vector::zeros());
    let cubes = lattice.interface_cells(phi, &band);
    let volume: f64 = lattice.component_volumes(&inside, &of_one(&cubes), &cubes).iter().map(|v| v.0).sum();
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

/// A bond vector that points along no axis.
fn weight<const D: usize>() -> Vector<D> {
    Vector::from_fn(|a, _| 0.03 - 0.05 * a as f64)
}

/// Energy and volume beside a ball, and the cubes.
fn measure_beside<const D: usize>(phi: &[f64], grid: Grid<D>) -> (f64, f64, Vec<DualCell>) {
    let ball = |x: &Vector<D>| (x - Vector::from_fn(|a, _| 8.2 - 0.4 * a as f64)).norm() - 3.1;
    let bounds = [Vector::repeat(3.0), Vector::repeat(12.0)];
    let mut cut = CutCells::uncut(grid);
    cut.rebuild(
        &[meniscus_numerics::grid::EmbeddedBoundary { signed_distance: &ball, bounds }],
        &Tiles::all(grid),
    );
    let mut lattice = DualGrid::new(grid, weight());
    lattice.update_solids(&cut, |_| (0, 0.6));
    let inside = Tiles::all(grid).negative_runs(phi);
    let inside = inside.filtered(&grid, |c| !cut.is_closed(grid.lattice().coordinates(c))).label(&grid);
    let mut band = Band::new(grid);
    band.rebuild(phi, &inside, 3);
    let cubes = lattice.interface_cells(phi, &band);
    let (volume, center) = lattice.component_volumes(&inside, &of_one(&cubes), &cubes)[0];
    let energy: f64 = cubes.iter().map(|c| c.area - c.contact_cosine * c.wetted_area).sum();
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
    assert!(cubes.iter().filter(|c| c.normal_pull != [0.0; 3]).count() > if D == 2 { 1 } else { 20 });
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
    let phi: Vec<f64> = (0..lattice.len()).map(|i| grid.center(lattice.coordinates(i))[2] - 2.1).collect();
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
        let measuring = DualGrid::new(grid, Vector::zeros());
        let cubes = measuring.interface_cells(&phi, &band);
        measuring.component_volumes(&inside, &of_one(&cubes), &cubes)[0].1
    };
    let tank = center(&|x| x[2] - 2.1);
    assert!((tank - Vector::<3>::new(1.5, 1.25, 1.05)).norm() < 1e-12, "{tank}");
    let middle = Vector::<3>::new(1.43, 1.31, 2.07);
    let ball = center(&|x| (x - middle).norm() - 0.9);
    assert!((ball - middle).norm() < 1e-3 * grid.dx, "{ball} {middle}");
}
