//! Convergence, closure, orientation and reproducibility of the extracted surface.

use super::*;
use crate::grid::Grid;
use crate::mesh::isosurface::CONTACT_LINE;
use std::f64::consts::PI;

/// The cells with `phi < 0`.
fn negative<const D: usize>(phi: &CellField<D>) -> Runs {
    let mut runs: Vec<Run> = Vec::new();
    let width = phi.grid.cells[0];
    for (index, _) in phi.data.iter().enumerate().filter(|(_, v)| **v < 0.0) {
        let (row, i) = ((index / width) as u32, (index % width) as u32);
        match runs.last_mut() {
            Some(r) if r.row == row && r.end == i => r.end += 1,
            _ => runs.push(Run { row, start: i, end: i + 1, component: 0 }),
        }
    }
    Runs { runs, components: 1 }
}

fn field<const D: usize>(grid: Grid<D>, f: impl Fn(Vector<D>) -> f64) -> CellField<D> {
    let mut phi = CellField::new(grid, 0.0);
    let lattice = grid.lattice();
    for (i, v) in phi.data.iter_mut().enumerate() {
        *v = f(grid.center(lattice.coordinates(i)));
    }
    phi
}

fn surface<const D: usize>(phi: &CellField<D>) -> Isosurface<D> {
    extract_isosurface(phi, &negative(phi))
}

/// Relative errors of volume and area of a ball.
fn ball<const D: usize>(n: usize) -> (f64, f64) {
    let center = Vector::from_fn(|a, _| 0.5 + [0.013, 0.037, -0.021][a]);
    let phi = field(Grid::<D>::new([n; D], 1.0 / n as f64), |x| (x - center).norm() - 0.3);
    let s = surface(&phi);
    assert!(s.mesh.is_watertight() && s.vertex_kind.iter().all(|k| *k == LIQUID_AIR));
    for p in &s.mesh.positions {
        assert!(((p - center).norm() - 0.3).abs() < 0.3 / (n * n) as f64);
    }
    for f in 0..s.mesh.facets.len() {
        let c = s.mesh.corners(f);
        assert!(s.mesh.area_vector(f).dot(&(c[0] - center)) > 0.0);
    }
    let exact = if D == 2 { (PI * 0.09, PI * 0.6) } else { (4.0 / 3.0 * PI * 0.027, 4.0 * PI * 0.09) };
    (s.mesh.volume() / exact.0 - 1.0, s.mesh.area() / exact.1 - 1.0)
}

fn check_convergence<const D: usize>() {
    let errors: Vec<(f64, f64)> = [16, 32, 64, 128].into_iter().map(ball::<D>).collect();
    println!("{D}D ball, volume and area error at 16, 32, 64, 128: {errors:?}");
    for pair in errors.windows(2) {
        assert!((pair[0].0 / pair[1].0) > 3.2 && (pair[0].1 / pair[1].1) > 3.2, "{errors:?}");
    }
    assert!(errors[3].0.abs() < 1e-3 && errors[3].1.abs() < 1e-3);
}

#[test]
fn isosurface_of_a_ball_converges() {
    check_convergence::<2>();
    check_convergence::<3>();
}

/// Random numbers in -1..1 (SplitMix64).
fn random(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

fn check_random<const D: usize>() {
    for seed in 0..60 {
        let mut next = random(seed);
        let cells = std::array::from_fn(|a| 1 + (seed as usize * (a + 3) + a) % 9);
        let bias = [0.0, 0.7, -0.7][seed as usize % 3];
        let grid = Grid::<D>::new(cells, 0.1);
        let mut phi = CellField::new(grid, 0.0);
        phi.data.iter_mut().for_each(|v| *v = next() + bias);
        let s = surface(&phi);
        assert!(s.mesh.is_watertight(), "{D}D seed {seed}: {} open ridges", s.mesh.open_ridges());
        assert_eq!(s.vertex_kind.len(), s.mesh.positions.len());
        let upper = grid.domain_upper();
        for (p, kind) in s.mesh.positions.iter().zip(&s.vertex_kind) {
            assert!((0..D).all(|a| 0.0 <= p[a] && p[a] <= upper[a]));
            let on_wall = (0..D).any(|a| p[a] == 0.0 || p[a] == upper[a]);
            assert!(*kind == LIQUID_AIR || on_wall);
        }
        for (facet, kind) in s.mesh.facets.iter().zip(&s.facet_kind) {
            let kinds = facet.map(|v| s.vertex_kind[v as usize]);
            if *kind == LIQUID_SOLID {
                assert!(kinds.iter().all(|k| *k != LIQUID_AIR));
                let p = facet.map(|v| s.mesh.positions[v as usize]);
                let flat = |a: usize, x: f64| p.iter().all(|p| p[a] == x);
                assert!((0..D).any(|a| flat(a, 0.0) || flat(a, upper[a])));
            } else {
                assert!(kinds.iter().all(|k| *k != LIQUID_SOLID));
            }
        }
        let filled = phi.data.iter().filter(|v| **v < 0.0).count() as f64 * grid.cell_volume();
        assert!(filled == 0.0 || s.mesh.volume() > 0.0, "{D}D seed {seed}");
    }
}

#[test]
fn isosurface_of_noise_is_closed_and_knows_its_walls() {
    check_random::<2>();
    check_random::<3>();
}

fn check_tank<const D: usize>() {
    let cells = std::array::from_fn(|a| [20, 12, 16][a]);
    let grid = Grid::<D>::new(cells, 0.05);
    let floor: f64 = grid.domain_upper().iter().take(D - 1).product();
    let up = grid.domain_upper()[D - 1];
    for level in [0.5 * up, 0.312, up - 0.0251] {
        let s = surface(&field(grid, |x| x[D - 1] - level));
        assert!(s.mesh.is_watertight());
        assert!((s.mesh.volume() / (floor * level) - 1.0).abs() < 1e-12);
        assert!((s.area_of_kind(LIQUID_AIR) / floor - 1.0).abs() < 1e-12);
        for (p, kind) in s.mesh.positions.iter().zip(&s.vertex_kind) {
            assert_eq!(*kind != LIQUID_SOLID, (p[D - 1] - level).abs() < 1e-12);
        }
    }
    // A full box, then a tilted plane that meets the walls: exact except for the rounded edge at the floor.
    let s = surface(&CellField::new(grid, -1.0));
    assert!((s.mesh.volume() / grid.domain_upper().product() - 1.0).abs() < 1e-12);
    let tilted = surface(&field(grid, |x| x[D - 1] - 0.4 - 0.3 * (x[0] - 0.5)));
    assert!((tilted.mesh.volume() / (floor * 0.4) - 1.0).abs() < 1e-12);
    assert_eq!(surface(&CellField::new(grid, 1.0)), Isosurface::default());
}

#[test]
fn isosurface_of_a_tank_is_exact() {
    check_tank::<2>();
    check_tank::<3>();
}

#[test]
fn isosurface_meets_the_wall_at_the_angle_of_the_level_set() {
    // A cap on the floor: the contact line converges to the circle of the sphere in the wall plane at second order.
    let error = |n: usize| {
        let center = Vector::from([0.5, 0.5, 0.1]);
        let s = surface(&field(Grid::<3>::new([n; 3], 1.0 / n as f64), |x| (x - center).norm() - 0.3));
        assert!(s.mesh.is_watertight());
        let line: Vec<f64> = (0..s.vertex_kind.len())
            .filter(|i| s.vertex_kind[*i] == CONTACT_LINE)
            .map(|i| ((s.mesh.positions[i] - center).norm() - 0.3).abs())
            .collect();
        assert!(line.len() > n);
        let exact = PI * 0.4f64.powi(2) * (0.9 - 0.4) / 3.0;
        (line.into_iter().fold(0.0, f64::max), (s.mesh.volume() / exact - 1.0).abs())
    };
    let (coarse, fine) = (error(32), error(64));
    println!("cap: line and volume error {coarse:?} {fine:?}");
    assert!(coarse.0 > 3.0 * fine.0 && coarse.1 > 3.0 * fine.1 && fine.0 < 0.1 / 64.0);
}

#[test]
fn isosurface_does_not_depend_on_threads() {
    let mut next = random(4);
    let mut phi = CellField::new(Grid::<3>::new([40, 30, 35], 0.1), 0.0);
    phi.data.iter_mut().for_each(|v| *v = next());
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| surface(&phi))
    };
    assert_eq!(on(1), on(5));
}

#[test]
#[ignore = "a measurement: run with --release --nocapture"]
fn isosurface_speed() {
    let n = 192;
    for (name, level) in [("tank", true), ("drop", false)] {
        let phi = field(Grid::<3>::new([n; 3], 1.0 / n as f64), |x| {
            if level {
                x[2] - 0.5 - 0.02 * (20.0 * x[0]).sin()
            } else {
                (x - Vector::repeat(0.5)).norm() - 0.3
            }
        });
        let runs = negative(&phi);
        let mut best = f64::INFINITY;
        let mut facets = 0;
        for _ in 0..7 {
            let start = std::time::Instant::now();
            facets = extract_isosurface(&phi, &runs).mesh.facets.len();
            best = best.min(start.elapsed().as_secs_f64());
        }
        println!("{name} {n}^3: {facets} facets in {:.1} ms", 1e3 * best);
    }
}
