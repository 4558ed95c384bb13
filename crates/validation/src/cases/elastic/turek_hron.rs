//! The flag of Turek and Hron without fluid.

use crate::measure::{bars, checks_or_failure};
use crate::soft::{SoftMaterial, failure_in_step};
use crate::{Case, Check, Mode};
use meniscus_elastic::{Anchor, Elastic, ElasticError, ElementOrder};
use meniscus_numerics::mesh::VolumeMesh;
use meniscus_numerics::{Matrix, Vector};
use meniscus_sim::StepError;

/// The case.
pub const FLAG: Case = Case {
    name: "elastic-flag",
    title: "Turek and Hron's flag swings (CSM3)",
    theory: "2D, plane strain: a beam of 0.35 m by 0.02 m at a cylinder of radius 0.05 m, ρ = 1000 kg/m³, E = \
        1.4 MPa, ν = 0.4, let go under 2 m/s²: mean and amplitude of its tip's way, and the frequency, from 5 \
        to 10 s (S. Turek, J. Hron, Fluid-Structure Interaction, Springer 2006, 371-385). 2, 4 and 8 layers of \
        cells; quick: 2.",
    quick: true,
    run: |mode| checks_or_failure(NAME, run(mode)),
};

const NAME: &str = "elastic-flag";
const GRAVITY: f64 = 2.0;
const STEP: f64 = 0.005;
const END: f64 = 10.0;
const RADIUS: f64 = 0.05;
const THICKNESS: f64 = 0.02;
/// End of the flag, m from the cylinder's axis.
const TIP: f64 = 0.4;
/// Cells along the flag per layer.
const CELLS_ALONG_PER_LAYER: usize = 17;
/// Mean and amplitude of the tip's displacement along and across, mm.
const REFERENCE: [(f64, f64); 2] = [(-14.279, 14.280), (-63.541, 65.094)];
const FREQUENCY: f64 = 1.0995;

fn run(mode: Mode) -> Result<Vec<Check>, StepError> {
    let layers: &[usize] = if mode == Mode::Quick { &[2] } else { &[2, 4, 8] };
    let mut checks = Vec::new();
    for &layers in layers {
        let path = tip_displacements(layers).map_err(failure_in_step(STEP))?;
        let mut check = |what: &str, value: f64, told: f64, unit: &'static str| {
            let what = format!("{what}, {layers} layers");
            checks.push(Check::relative(NAME, what, value, told, bars(0.04, 0.01)).in_unit(unit));
        };
        for (a, axis) in ["along", "across"].into_iter().enumerate() {
            let ways = || path.iter().map(|u| 1e3 * u[a]);
            let (low, high) =
                (ways().fold(f64::INFINITY, f64::min), ways().fold(f64::NEG_INFINITY, f64::max));
            check(&format!("mean way {axis}"), 0.5 * (low + high), REFERENCE[a].0, "mm");
            check(&format!("amplitude {axis}"), 0.5 * (high - low), REFERENCE[a].1, "mm");
            if a == 1 {
                check("frequency", frequency(&path, 0.5e-3 * (low + high)), FREQUENCY, "Hz");
            }
        }
    }
    Ok(checks)
}

/// Displacement of the middle of the tip in the second half of the time, m.
fn tip_displacements(layers: usize) -> Result<Vec<Vector<2>>, ElasticError> {
    let (body, tip) = flag(layers)?;
    let weight: Vec<Vector<2>> = body.masses().iter().map(|m| Vector::<2>::new(0.0, -GRAVITY * m)).collect();
    let mut state = body.rest_state(STEP);
    // Velocities lead by half a step, so forces act for half a step before the first.
    for (v, _) in state.velocities.iter_mut().zip(body.anchored()).filter(|(_, held)| !**held) {
        v[1] = -0.5 * STEP * GRAVITY;
    }
    let mut path = Vec::new();
    for _ in 0..(END / STEP).round() as usize {
        body.step(&mut state, STEP, &weight)?;
        path.push(state.positions[tip] - body.rest_mesh().positions[tip]);
    }
    Ok(path.split_off(path.len() / 2))
}

/// The flag from the cylinder to its tip, and the middle vertex of the tip.
fn flag(layers: usize) -> Result<(Elastic<2>, usize), ElasticError> {
    let half = Vector::<2>::new(0.5 * THICKNESS * CELLS_ALONG_PER_LAYER as f64, 0.5 * THICKNESS);
    let edge = THICKNESS / layers as f64;
    let mut mesh = VolumeMesh::of_box(&half, &half, &Matrix::identity(), edge, ElementOrder::Quadratic)
        .unwrap_or_default();
    let length = 2.0 * half[0];
    let anchors = vec![Anchor::within(&mesh, |x| x[0] < 1e-9)];
    for x in &mut mesh.positions {
        let start = (RADIUS * RADIUS - (x[1] - half[1]).powi(2)).sqrt();
        x[0] = start + x[0] / length * (TIP - start);
    }
    let from_tip = |v: &usize| (mesh.positions[*v] - Vector::<2>::new(TIP, half[1])).norm();
    let tip = (0..mesh.positions.len()).min_by(|a, b| from_tip(a).total_cmp(&from_tip(b))).unwrap_or(0);
    let material = SoftMaterial { young: 1.4e6, poisson: 0.4, density: 1000.0, damping: 0.0 };
    Ok((material.elastic(mesh, anchors)?, tip))
}

/// Frequency at which the tip rises through a height, Hz.
fn frequency(path: &[Vector<2>], height: f64) -> f64 {
    let rises: Vec<f64> = (1..path.len())
        .filter(|k| path[k - 1][1] < height && path[*k][1] >= height)
        .map(|k| k as f64 * STEP)
        .collect();
    match rises[..] {
        [first, .., last] => (rises.len() - 1) as f64 / (last - first),
        _ => 0.0,
    }
}
