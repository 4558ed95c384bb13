//! The stiffness of thin plates against that of plate theory, for few layers.

use crate::lattice::{block, free, quadratic};
use meniscus_elastic::{ConstitutiveLaw, Elastic, ElementOrder, StiffnessBlock, TangentWeights};
use meniscus_numerics::{Matrix, Vector};

/// Vertex, component, displacement.
type Told = (usize, usize, f64);

/// The energy of a body with a unit Young's modulus, of which some displacements are told by springs that hardly give.
fn energy<const D: usize>(body: &Elastic<D>, told: &[Told]) -> f64 {
    let hold = 1e6;
    let unit = |a: usize| Matrix::from_fn(|r, c| if r == a && c == a { hold } else { 0.0 });
    let extra: Vec<StiffnessBlock<D>> = told
        .iter()
        .map(|(v, a, _)| StiffnessBlock { first: *v as u32, second: *v as u32, block: unit(*a) })
        .collect();
    let mut forces = vec![Vector::<D>::zeros(); body.masses().len()];
    told.iter().for_each(|(v, a, by)| forces[*v][*a] += hold * by);
    let u = body.linear_static_displacements(&forces, &extra).unwrap();
    let mut pull = vec![Vector::zeros(); u.len()];
    body.tangent(
        &body.rest_mesh().positions,
        TangentWeights { stiffness: 1.0, project_psd: true, viscosity: 0.0 },
    )
    .add_product(&u, &mut pull);
    0.5 * u.iter().zip(&pull).map(|(u, p)| u.dot(p)).sum::<f64>()
}

fn plate<const D: usize>(
    cells: [usize; D],
    poisson_ratio: f64,
    order: ElementOrder,
    wide: f64,
) -> Elastic<D> {
    let mut size = cells.map(|n| n as f64 * wide);
    size[D - 1] = cells[D - 1] as f64;
    let law = ConstitutiveLaw::neo_hookean(1.0, poisson_ratio, order);
    let mesh =
        if order == ElementOrder::Quadratic { quadratic::<D>(cells, size) } else { block::<D>(cells, size) };
    Elastic::new(free(mesh, 1e-9, law)).unwrap()
}

/// Bending stiffness over nominal of a plate that bends about one axis and keeps its width.
fn bending<const D: usize>(cells: [usize; D], poisson: f64, order: ElementOrder, wide: f64) -> f64 {
    let body = plate(cells, poisson, order, wide);
    let x = &body.rest_mesh().positions;
    let size = x.iter().fold(Vector::<D>::zeros(), |s, x| s.sup(x));
    let mut told: Vec<Told> = vec![(0, D - 1, 0.0)];
    for (v, x) in x.iter().enumerate() {
        if x[0] < 1e-9 {
            told.push((v, 0, 0.0));
        }
        if x[0] > size[0] - 1e-9 {
            told.push((v, 0, -(x[D - 1] - 0.5 * size[D - 1]) * size[0]));
        }
        if D == 3 && (x[1] < 1e-9 || x[1] > size[1] - 1e-9) {
            told.push((v, 1, 0.0));
        }
    }
    let area: f64 = (0..D - 1).map(|a| size[a]).product();
    2.0 * energy(&body, &told) / area / (size[D - 1].powi(3) / 12.0 / (1.0 - poisson * poisson))
}

/// Twisting stiffness over nominal of a square plate.
fn twisting(side: usize, layers: usize, poisson: f64, order: ElementOrder, wide: f64) -> f64 {
    let body = plate([side, side, layers], poisson, order, wide);
    let positions = &body.rest_mesh().positions;
    let size = positions.iter().fold(Vector::<3>::zeros(), |s, x| s.sup(x));
    let at = |x: f64, y: f64| {
        let off = |v: &usize| (positions[*v] - Vector::from([x, y, 0.0])).norm();
        (0..positions.len()).min_by(|a, b| off(a).total_cmp(&off(b))).unwrap()
    };
    let held = [at(0.0, 0.0), at(size[0], 0.0), at(0.0, size[1])];
    let mut told: Vec<Told> = held.map(|v| (v, 2, 0.0)).to_vec();
    for (v, x) in positions.iter().enumerate() {
        for (a, b) in [(0, 1), (1, 0)] {
            if x[a] < 1e-9 || x[a] > size[a] - 1e-9 {
                told.push((v, b, x[a] * (x[2] - 0.5 * size[2])));
            }
        }
    }
    energy(&body, &told) / (size[0] * size[1]) / (size[2].powi(3) / 12.0 / (1.0 + poisson))
}

#[test]
fn plates_of_few_layers_bend_as_they_should() {
    for poisson in [0.0, 0.3, 0.45, 0.49] {
        for order in [ElementOrder::Linear, ElementOrder::Quadratic] {
            let all: Vec<[f64; 3]> = [2, 4]
                .map(|n| {
                    [
                        bending([16, n], poisson, order, 1.0),
                        bending([8, 4, n], poisson, order, 1.0),
                        twisting(6, n, poisson, order, 1.0),
                    ]
                })
                .to_vec();
            println!("nu {poisson} {order:?}: 2 and 4 layers [2D, 3D, twist]: {all:.4?}");
            if order == ElementOrder::Quadratic {
                // Constant curvature is quadratic, and no error at all but that of the springs which hold.
                assert!(all.iter().flatten().all(|r| (r - 1.0).abs() < 1e-3), "nu {poisson}: {all:?}");
            }
        }
    }
}

#[test]
fn cells_that_are_not_cubes() {
    for wide in [0.5, 0.75, 1.0, 1.33, 2.0] {
        let all = [2, 4].map(|n| {
            let long = 2 * (4.0 / wide) as usize;
            [
                bending([long, 4, n], 0.3, ElementOrder::Quadratic, wide),
                twisting(6, n, 0.3, ElementOrder::Quadratic, wide),
            ]
        });
        println!("{wide} times as wide as high: {all:.4?}");
        assert!(all.iter().flatten().all(|r| (r - 1.0).abs() < 1e-3));
    }
}

/// Springs on edges are a solid with a Poisson ratio of its own; its plates bend with a stiffness that must be measured.
#[test]
fn plates_of_springs() {
    let bending = |layers: usize| {
        let cells = [12, layers];
        let mesh = block::<2>(cells, cells.map(|n| n as f64));
        let body = Elastic::new(free(mesh, 1e-9, ConstitutiveLaw::Springs { stiffness: 1.0 })).unwrap();
        let high = layers as f64;
        let mut told: Vec<Told> = vec![(0, 1, 0.0)];
        for (v, x) in body.rest_mesh().positions.iter().enumerate() {
            if x[0] < 1e-9 || x[0] > 12.0 - 1e-9 {
                told.push((v, 0, -(x[1] - 0.5 * high) * x[0]));
            }
        }
        2.0 * energy(&body, &told) / 12.0
    };
    let found = [1, 2, 4].map(bending);
    println!("springs, squares with a diagonal: B/(k a²) for 1, 2, 4 layers: {found:.3?}");
    // Layers as rods alone: Σ k a y² = 1/2, 2, 10.
    assert!(found.iter().zip([0.5, 2.0, 10.0]).all(|(b, rods)| *b > 0.999 * rods && *b < 1.1 * rods));
}
