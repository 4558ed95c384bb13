//! A force term of one's own: a constant load at the tip of a clamped soft plate, which swings and comes to rest.
//! It compares the deflection with that of a thin beam; run it with `cargo run --release --example own_force_term`.

use meniscus_elastic::*;
use meniscus_numerics::Vector;
use meniscus_numerics::mesh::volume::block::block;
use std::error::Error;

/// A constant force, N/m, on a vertex: its energy is linear in the position, so that it has no tangent and couples no vertices.
#[derive(Debug)]
struct PointLoad {
    vertex: usize,
    force: Vector<2>,
    couplings: Cliques,
}

impl ForceTerm<2> for PointLoad {
    fn couplings(&self) -> &Cliques {
        &self.couplings
    }

    fn energy(&self, x: &[Vector<2>]) -> f64 {
        -self.force.dot(&x[self.vertex])
    }

    fn add_forces(&self, _: &[Vector<2>], forces: &mut [Vector<2>]) {
        forces[self.vertex] += self.force;
    }

    fn add_viscous_forces(&self, _: &[Vector<2>], _: &[Vector<2>], _: f64, _: &mut [Vector<2>]) {}

    fn add_tangent(&self, _: &[Vector<2>], _: TangentWeights, _: &mut BlockMatrix<2>) {}
}

impl DiscreteGradientTerm<2> for PointLoad {
    fn add_forces_between(&self, ends: [&[Vector<2>]; 2], forces: &mut [Vector<2>]) {
        self.add_forces(ends[0], forces);
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let (length, thickness, young_modulus, poisson_ratio, force) = (20e-3, 1e-3, 1e6, 0.45, -5e-3);
    let mesh = block([40, 2], &Vector::<2>::new(length, thickness)).subdivided();
    let tip = mesh.positions.iter().position(|x| x[0] > 0.499 * length && x[1].abs() < 1e-9);
    let vertex = tip.ok_or("no vertex at the middle of the end")?;
    let load = PointLoad { vertex, force: Vector::<2>::new(0.0, force), couplings: Cliques::default() };
    let law = ConstitutiveLaw::neo_hookean(young_modulus, poisson_ratio, ElementOrder::Quadratic);
    let anchors = vec![Anchor::within(&mesh, |x| x[0] < -0.499 * length)];
    let plate = ElasticSpecification { mesh, density: 1100.0, law, damping_ratio: 1.0, anchors };
    let plate = Elastic::with_terms(plate, vec![Box::new(load)])?;

    let dt = 0.1 / lowest_modes(&plate, 1)?.first().ok_or("no mode of vibration")?.frequency;
    let mut state = plate.rest_state(dt);
    let no_force = vec![Vector::zeros(); state.positions.len()];
    for _ in 0..400 {
        plate.step(&mut state, dt, &no_force)?;
    }
    let found = state.positions[vertex][1] - plate.rest_mesh().positions[vertex][1];
    // F L³ / (3 E I) with E/(1 - ν²) for E in plane strain and I = h³/12.
    let beam =
        4.0 * force * (1.0 - poisson_ratio * poisson_ratio) / young_modulus * (length / thickness).powi(3);
    println!("deflection of the tip {:.4} mm, of a thin beam {:.4} mm", 1e3 * found, 1e3 * beam);
    if (found / beam - 1.0).abs() < 0.02 { Ok(()) } else { Err("they differ by more than 2 %".into()) }
}
