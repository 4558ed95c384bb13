//! Boxes cut into cells, and these into simplices around a diagonal.

use meniscus_elastic::{Anchor, ConstitutiveLaw, ElasticSpecification, ElementOrder};
use meniscus_numerics::Vector;
use meniscus_numerics::mesh::{Simplex, VolumeMesh};

/// A box from the origin. All diagonals are parallel.
pub fn block<const D: usize>(cells: [usize; D], size: [f64; D]) -> VolumeMesh<D> {
    let spread = |i: usize| -> [usize; D] {
        let mut others = i;
        std::array::from_fn(|a| {
            let k = others % (cells[a] + 1);
            others /= cells[a] + 1;
            k
        })
    };
    let number = |c: [usize; D]| (0..D).rev().fold(0, |n, a| n * (cells[a] + 1) + c[a]) as u32;
    let count: usize = cells.iter().map(|n| n + 1).product();
    let place = |i: usize| {
        let c = spread(i);
        Vector::from_fn(|a, _| size[a] * c[a] as f64 / cells[a] as f64)
    };
    let mut mesh = VolumeMesh { positions: (0..count).map(place).collect(), simplices: Vec::new() };
    let orders: &[[usize; 3]] = if D == 2 {
        &[[0, 1, 2], [1, 0, 2]]
    } else {
        &[[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]]
    };
    for i in 0..count {
        let low = spread(i);
        if (0..D).any(|a| low[a] == cells[a]) {
            continue;
        }
        for order in orders {
            let mut at = low;
            let others = std::array::from_fn(|k| {
                at[order[k]] += 1;
                number(at)
            });
            let mut simplex = Simplex { root: number(low), others };
            if simplex.volume(&mesh.positions) < 0.0 {
                simplex.others.swap(0, 1);
            }
            mesh.simplices.push(simplex);
        }
    }
    mesh
}

/// A box from the origin of quadratic simplices; even numbers of cells, of vertices next to each other.
pub fn quadratic<const D: usize>(cells: [usize; D], size: [f64; D]) -> VolumeMesh<D> {
    assert!(cells.iter().all(|n| n % 2 == 0), "odd: {cells:?}");
    block(cells.map(|n| n / 2), size).subdivided()
}

/// A solid held at `x = 0`.
pub fn clamped<const D: usize>(
    mesh: VolumeMesh<D>,
    density: f64,
    law: ConstitutiveLaw,
) -> ElasticSpecification<D> {
    let anchors = vec![Anchor::within(&mesh, |x| x[0] < 1e-9)];
    ElasticSpecification { mesh, density, law, damping_ratio: 0.0, anchors }
}

/// A solid that nothing holds.
pub fn free<const D: usize>(
    mesh: VolumeMesh<D>,
    density: f64,
    law: ConstitutiveLaw,
) -> ElasticSpecification<D> {
    ElasticSpecification { mesh, density, law, damping_ratio: 0.0, anchors: Vec::new() }
}

/// A neo-Hookean solid of quadratic simplices.
pub fn rubber(young_modulus: f64, poisson_ratio: f64) -> ConstitutiveLaw {
    ConstitutiveLaw::neo_hookean(young_modulus, poisson_ratio, ElementOrder::Quadratic)
}

/// The same of linear ones.
pub fn linear(young_modulus: f64, poisson_ratio: f64) -> ConstitutiveLaw {
    ConstitutiveLaw::neo_hookean(young_modulus, poisson_ratio, ElementOrder::Linear)
}

/// Numbers between -1 and 1 that are always the same.
pub struct Noise(pub u64);

impl Noise {
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    pub fn vectors<const D: usize>(&mut self, n: usize) -> Vec<Vector<D>> {
        (0..n).map(|_| Vector::from_fn(|_, _| self.next())).collect()
    }
}
