//! Tables of the cost of elements and of their error in bending: cantilevers on lattices and on triangulated outlines against Timoshenko's beam.
//! (Those that are stuffed: `meniscus verify elastic-unstructured`.)

use crate::lattice::{block, clamped};
use meniscus_elastic::{ConstitutiveLaw, Elastic, ElementOrder, TangentWeights, lowest_modes};
use meniscus_numerics::Vector;
use meniscus_numerics::mesh::VolumeMesh;
use meniscus_numerics::mesh::volume::Outline;
use std::time::Instant;

/// Deflection of the tip under its weight along the last axis (unit density and gravity), and lowest frequency, of a beam of thickness 1
/// with E = 1; `stiffness` is the modulus of bending.
fn timoshenko(length: f64, stiffness: f64, poisson: f64) -> [f64; 2] {
    let shear = 1.0 / (2.0 * (1.0 + poisson)) * 10.0 * (1.0 + poisson) / (12.0 + 11.0 * poisson);
    let bending = stiffness / 12.0;
    let thin = (1.875104069f64 / length).powi(2) * bending.sqrt();
    let ratio = 4.6478 / 12.0 / length.powi(2) * (1.0 + stiffness / shear);
    [length.powi(4) / (8.0 * bending) + length * length / (2.0 * shear), thin / (1.0 + ratio).sqrt()]
}

/// A line of the table.
fn tell<const D: usize>(
    name: &str,
    mesh: VolumeMesh<D>,
    order: ElementOrder,
    poisson_ratio: f64,
    told: [f64; 2],
) {
    let law = ConstitutiveLaw::neo_hookean(1.0, poisson_ratio, order);
    let body = Elastic::new(clamped(mesh, 1.0, law)).unwrap();
    let x = &body.rest_mesh().positions;
    let frequency = lowest_modes(&body, 1).unwrap()[0].frequency;
    let weight = |m: &f64| Vector::from_fn(|r, _| if r + 1 == D { *m } else { 0.0 });
    let weight: Vec<Vector<D>> = body.masses().iter().map(weight).collect();
    let moved = body.linear_static_displacements(&weight, &[]).unwrap();
    let high = x.iter().map(|x| x[0]).fold(0.0, f64::max);
    let end: Vec<usize> = (0..x.len()).filter(|v| x[*v][0] > high - 1e-9).collect();
    let drop = end.iter().map(|v| moved[*v][D - 1]).sum::<f64>() / end.len() as f64;
    let start = Instant::now();
    let _ = body.tangent(x, TangentWeights { stiffness: 1.0, project_psd: true, viscosity: 0.0 });
    println!(
        "{name:38} deflection {:+7.2} %, frequency {:+7.2} %, {:5} vertices, {:8} entries, tangent {:.4} s",
        100.0 * (drop / told[0] - 1.0),
        100.0 * (frequency / told[1] - 1.0),
        x.len(),
        body.solver_entries(),
        start.elapsed().as_secs_f64(),
    );
}

#[test]
#[ignore = "half a minute: prints a table"]
fn cantilevers_of_all_elements() {
    let (length, wide) = (20.0, 2.0);
    let outline = Outline::polygon(&[[0.0, 0.0], [length, 0.0], [length, 1.0], [0.0, 1.0]]).unwrap();
    for poisson in [0.3, 0.45, 0.49] {
        for layers in [2usize, 3, 4, 6] {
            for order in [ElementOrder::Linear, ElementOrder::Quadratic] {
                let name = |what: &str| format!("{what} {order:?}, nu {poisson}, {layers} layers");
                let of = |mesh: VolumeMesh<2>| {
                    if order == ElementOrder::Quadratic { mesh.subdivided() } else { mesh }
                };
                let parts = if order == ElementOrder::Quadratic { 2 } else { 1 };
                let told = timoshenko(length, 1.0 / (1.0 - poisson * poisson), poisson);
                let flat = outline.triangulate(parts as f64 / layers as f64).unwrap().mesh;
                tell(&name("2D outline"), of(flat), order, poisson, told);
                if layers % parts > 0 {
                    continue;
                }
                let cells = [20, 1].map(|n| n * layers / parts);
                tell(&name("2D lattice"), of(block(cells, [length, 1.0])), order, poisson, told);
                let cells = [12, 2, 1].map(|n| n * layers / parts);
                let mesh = block(cells, [12.0, wide, 1.0]);
                let mesh = if order == ElementOrder::Quadratic { mesh.subdivided() } else { mesh };
                tell(&name("3D lattice"), mesh, order, poisson, timoshenko(12.0, 1.0, poisson));
            }
        }
    }
}
