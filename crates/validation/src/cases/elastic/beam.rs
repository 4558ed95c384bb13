//! Elastic beams without liquid, against the theories of thin and of thick beams.

use crate::measure::{bars, checks_or_failure};
use crate::soft::{SoftMaterial, failure_in_step};
use crate::{Case, Check, Mode};
use meniscus_elastic::{Anchor, Elastic, ElasticError, ElementOrder, lowest_modes};
use meniscus_numerics::mesh::VolumeMesh;
use meniscus_numerics::{Matrix, Vector};
use meniscus_sim::StepError;

/// The case.
pub const BEAM: Case = Case {
    name: "elastic-beam",
    title: "Cantilevers bend and swing as beams do",
    theory: "2D, plane strain, ν = 0.3, length 20 times the thickness, neo-Hookean: the first three \
        frequencies over those of Timoshenko's beam; the tip's drop under small weight (q L⁴/8B) and, large, \
        by the elastica for q L³/B = 1, 2, 5, 10. 2 and 4 layers of cells; quick: 2.",
    quick: true,
    run: |mode| checks_or_failure(NAME, run(mode)),
};

const NAME: &str = "elastic-beam";
/// Wave numbers of the modes of a clamped beam times its length, and the mean squares of the modes' slopes.
const MODE_CONSTANTS: [(f64, f64); 3] = [(1.875104069, 4.6478), (4.694091133, 32.417), (7.854757438, 77.299)];
/// Load, and drop and axial position of the tip over the length, by the elastica.
const ELASTICA: [(f64, f64, f64); 4] = [
    (1.0, 0.123471, 0.991246),
    (2.0, 0.238507, 0.966893),
    (5.0, 0.495905, 0.846657),
    (10.0, 0.700200, 0.656354),
];
const LENGTH: f64 = 4.0;
const THICKNESS: f64 = 0.2;
const DENSITY: f64 = 1.2;
const YOUNG: f64 = 1e8;
const POISSON: f64 = 0.3;
/// Bending stiffness of the plate.
const BENDING_STIFFNESS: f64 = YOUNG / (1.0 - POISSON * POISSON) * THICKNESS * THICKNESS * THICKNESS / 12.0;
const STEP: f64 = 1e-3;

fn run(mode: Mode) -> Result<Vec<Check>, StepError> {
    let layers: &[usize] = if mode == Mode::Quick { &[2] } else { &[2, 4] };
    let failed = failure_in_step(STEP);
    let mut checks = Vec::new();
    for &layers in layers {
        let what = |text: &str| format!("{text}, {layers} layers");
        let modes = lowest_modes(&cantilever(layers, 0.0).map_err(&failed)?, 3).map_err(&failed)?;
        for (k, (mode, told)) in modes.iter().zip(frequencies()).enumerate() {
            let text = what(&format!("frequency {}", k + 1));
            checks.push(Check::relative(NAME, text, mode.frequency, told, bars(0.04, 0.01)).in_unit("rad/s"));
        }
        let body = cantilever(layers, 0.7).map_err(&failed)?;
        let small = 1e-3;
        let (drop, _) = tip_deflection(&body, small).map_err(&failed)?;
        checks.push(Check::relative(NAME, what("small deflection"), drop, small / 8.0, bars(0.04, 0.01)));
        for (load, drop, along) in ELASTICA {
            let (d, a) = tip_deflection(&body, load).map_err(&failed)?;
            let text = |what_of: &str| what(&format!("{what_of}, q L³/B = {load}"));
            checks.push(Check::relative(NAME, text("tip's drop / L"), d, drop, bars(0.04, 0.02)));
            checks.push(Check::relative(NAME, text("tip's place / L"), a, along, bars(0.04, 0.02)));
        }
    }
    Ok(checks)
}

/// Frequencies of Timoshenko's beam, rad/s: those of the thin beam, corrected for rotary inertia and shear to first order (S. Timoshenko,
/// Phil. Mag. 43 (1922) 125).
fn frequencies() -> [f64; 3] {
    let stiffness = YOUNG / (1.0 - POISSON * POISSON);
    let shear = YOUNG / (2.0 * (1.0 + POISSON)) * 10.0 * (1.0 + POISSON) / (12.0 + 11.0 * POISSON);
    MODE_CONSTANTS.map(|(k, slope)| {
        let thin = (k / LENGTH).powi(2) * (stiffness * THICKNESS * THICKNESS / 12.0 / DENSITY).sqrt();
        let ratio = slope * THICKNESS * THICKNESS / 12.0 / LENGTH.powi(2);
        thin / (1.0 + ratio * (1.0 + stiffness / shear)).sqrt()
    })
}

/// A beam along the first axis, clamped at 0.
fn cantilever(layers: usize, damping: f64) -> Result<Elastic<2>, ElasticError> {
    let half = Vector::<2>::new(0.5 * LENGTH, 0.5 * THICKNESS);
    let mesh = VolumeMesh::of_box(
        &half,
        &half,
        &Matrix::identity(),
        THICKNESS / layers as f64,
        ElementOrder::Quadratic,
    )
    .unwrap_or_default();
    let anchors = vec![Anchor::within(&mesh, |x| x[0] < 1e-9)];
    let material = SoftMaterial { young: YOUNG, poisson: POISSON, density: DENSITY, damping };
    material.elastic(mesh, anchors)
}

/// Drop and axial position of the middle of the tip over the length, at rest under a load `q L³/B`.
fn tip_deflection(body: &Elastic<2>, load: f64) -> Result<(f64, f64), ElasticError> {
    let gravity = load * BENDING_STIFFNESS / (DENSITY * THICKNESS * LENGTH.powi(3));
    let weight: Vec<Vector<2>> = body.masses().iter().map(|m| Vector::<2>::new(0.0, -gravity * m)).collect();
    let mut state = body.rest_state(STEP);
    for _ in 0..2000 {
        body.step(&mut state, STEP, &weight)?;
        let (moves, bends) = (body.kinetic_energy(&state.velocities), body.elastic_energy(&state.positions));
        if moves < 1e-12 * bends && state.time > 0.1 {
            break;
        }
    }
    let rest = &body.rest_mesh().positions;
    let end: Vec<usize> = (0..rest.len()).filter(|v| rest[*v][0] > LENGTH - 1e-9).collect();
    let mean = |a: usize, x: &[Vector<2>]| end.iter().map(|v| x[*v][a]).sum::<f64>() / end.len() as f64;
    Ok(((mean(1, rest) - mean(1, &state.positions)) / LENGTH, mean(0, &state.positions) / LENGTH))
}
