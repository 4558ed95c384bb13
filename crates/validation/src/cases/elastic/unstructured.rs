//! Elastic beams on unstructured meshes, against the theory of thick beams and against refined meshes.
//!
//! In 2D a rectangle is triangulated; its deflection `q L⁴/8B + q L²/2S` and lowest frequency are those of Timoshenko's beam in plane
//! strain. In 3D a box rotated about its length is meshed by isosurface stuffing, which cuts off its edges differently on each mesh. Each
//! body is therefore compared with itself: the same polyhedron, clamped in the same elements, on elements half as large. Limit: the finer
//! elements have about a quarter of the measured error, which is thus slightly too small.

use crate::measure::{bars, checks_or_failure};
use crate::setup::up;
use crate::soft::{SoftMaterial, not_made};
use crate::{Case, Check, Mode};
use meniscus_elastic::{Anchor, AnchorMotion, ElasticError, lowest_modes};
use meniscus_numerics::mesh::VolumeMesh;
use meniscus_numerics::mesh::volume::{Outline, stuff};
use meniscus_numerics::shape::Shape;
use meniscus_numerics::{Matrix, Vector};
use meniscus_sim::StepError;

/// The case.
pub const CASE: Case = Case {
    name: "elastic-unstructured",
    title: "Cantilevers bend and swing as they should on meshes without order",
    theory: "Neo-Hookean, ν = 0.3 and 0.45; the deflection under small weight and the lowest frequency, with 2, 3 and 4 vertices \
        after each other through the thickness. 2D: a triangulated beam 20 times as long as thick over Timoshenko's beam in plane \
        strain. 3D: a stuffed strip 9 by 3 by 1, turned by 20 degrees about its length, over the same body with elements half as \
        large. Quick: 2D, and 3D with 2.",
    quick: false,
    run: |mode| checks_or_failure(NAME, run(mode)),
};

const NAME: &str = "elastic-unstructured";
const POISSONS: [f64; 2] = [0.3, 0.45];
/// Length of the 2D beam over its thickness.
const LENGTH: f64 = 20.0;
/// Size of the 3D strip over its thickness, and the length that is clamped.
const STRIP: [f64; 3] = [9.0, 3.0, 1.0];
const CLAMPED_LENGTH: f64 = 1.5;
/// Rotation about its length, rad.
const ROLL_ANGLE: f64 = 0.35;
/// Wave number of the lowest mode of a clamped beam times its length, and the mean square of the mode's slope.
const MODE_CONSTANTS: (f64, f64) = (1.875104069, 4.6478);
/// Tolerance, and that of the state of the art.
const TOLERANCES: (f64, f64) = (0.03, 0.01);

/// Deflection, and lowest frequency, rad/s.
type BeamResponse = [f64; 2];

fn run(mode: Mode) -> Result<Vec<Check>, StepError> {
    let mut checks = Vec::new();
    let mut add = |dimension: usize, layers: usize, poisson: f64, found: BeamResponse, told: BeamResponse| {
        for (k, what) in ["deflection", "frequency"].iter().enumerate() {
            let what = format!("{what}, {dimension}D, {layers} layers, ν = {poisson}");
            checks.push(Check::relative(NAME, what, found[k], told[k], bars(TOLERANCES.0, TOLERANCES.1)));
        }
    };
    for poisson in POISSONS {
        for layers in [2, 3, 4] {
            let mesh = triangulated(2.0 / layers as f64)?;
            let ends = |x: &Vector<2>| x[0] < 1e-9;
            let held = (0..mesh.positions.len() as u32).filter(|v| ends(&mesh.positions[*v as usize]));
            let held = held.collect();
            let found = beam_response(mesh, held, poisson, &|x| x[0] > LENGTH - 1e-9).map_err(not_made)?;
            add(2, layers, poisson, found, timoshenko(poisson));
        }
        let layers: &[usize] = if mode == Mode::Quick { &[2] } else { &[2, 3, 4] };
        for &layers in layers {
            let coarse = stuffed(2.0 / layers as f64)?.subdivided();
            let fine = coarse.subdivided();
            let [found, told] = [(coarse, 1), (fine, 2)].map(|(mesh, times)| {
                let held = clamped_vertices(&mesh, times);
                beam_response(mesh, held, poisson, &|_| true)
            });
            add(3, layers, poisson, found.map_err(not_made)?, told.map_err(not_made)?);
        }
    }
    Ok(checks)
}

/// Deflection per unit of weight, and lowest frequency, of Timoshenko's beam of unit modulus, density and thickness.
fn timoshenko(poisson: f64) -> BeamResponse {
    let bending = 1.0 / (1.0 - poisson * poisson) / 12.0;
    let shear = 1.0 / (2.0 * (1.0 + poisson)) * 10.0 * (1.0 + poisson) / (12.0 + 11.0 * poisson);
    let thin = (MODE_CONSTANTS.0 / LENGTH).powi(2) * bending.sqrt();
    let ratio = MODE_CONSTANTS.1 / 12.0 / LENGTH.powi(2) * (1.0 + 12.0 * bending / shear);
    [LENGTH.powi(4) / (8.0 * bending) + LENGTH * LENGTH / (2.0 * shear), thin / (1.0 + ratio).sqrt()]
}

/// The 2D beam of quadratic triangles with the given edge length.
fn triangulated(edge: f64) -> Result<VolumeMesh<2>, StepError> {
    let outline = Outline::polygon(&[[0.0, 0.0], [LENGTH, 0.0], [LENGTH, 1.0], [0.0, 1.0]]);
    let planar = outline.and_then(|o| o.triangulate(edge)).map_err(not_made)?;
    Ok(planar.mesh.subdivided())
}

/// The 3D strip of linear tetrahedra with the given edge length.
fn stuffed(edge: f64) -> Result<VolumeMesh<3>, StepError> {
    let (s, c) = ROLL_ANGLE.sin_cos();
    let rotation = Matrix::<3>::new(1.0, 0.0, 0.0, 0.0, c, -s, 0.0, s, c);
    let half = Vector::<3>::from(STRIP) * 0.5;
    let shape = Shape::Box { center: half, half_size: half, rotation };
    let (lower, upper) = shape.bounds();
    let mesh = stuff(&|x| shape.signed_distance(x), &lower, &upper, edge).map_err(not_made)?;
    // Rotated back about the middle, so that the thickness is along the last axis.
    Ok(mesh.transformed(&rotation.transpose(), &(half - rotation.transpose() * half)))
}

/// The vertices of elements that lie entirely in the clamped part of the strip; each has been divided `times` times.
fn clamped_vertices(mesh: &VolumeMesh<3>, times: u32) -> Vec<u32> {
    let mut held: Vec<u32> = Vec::new();
    for parts in mesh.simplices.chunks(1 << (3 * times)) {
        let mut vertices = parts.iter().flat_map(|s| s.vertices());
        if vertices.all(|v| mesh.positions[v as usize][0] < CLAMPED_LENGTH) {
            held.extend(parts.iter().flat_map(|s| s.vertices()));
        }
    }
    held.sort_unstable();
    held.dedup();
    held
}

/// Mean transverse deflection, under its weight, of the part of a beam selected by `counts`, and lowest frequency.
fn beam_response<const D: usize>(
    mesh: VolumeMesh<D>,
    held: Vec<u32>,
    poisson: f64,
    counts: &dyn Fn(&Vector<D>) -> bool,
) -> Result<BeamResponse, ElasticError> {
    let anchors = vec![Anchor { vertices: held, motion: AnchorMotion::Fixed }];
    let material = SoftMaterial { young: 1.0, poisson, density: 1.0, damping: 0.0 };
    let body = material.elastic(mesh, anchors)?;
    let modes = lowest_modes(&body, 1)?;
    let positions = &body.rest_mesh().positions;
    let weight = |m: &f64| up(*m);
    let weight: Vec<Vector<D>> = body.masses().iter().map(weight).collect();
    let moved = body.linear_static_displacements(&weight, &[])?;
    let part = (0..positions.len()).filter(|v| counts(&positions[*v]));
    let (sum, all) = part
        .fold((0.0, 0.0), |(sum, all), v| (sum + body.masses()[v] * moved[v][D - 1], all + body.masses()[v]));
    Ok([sum / all, modes.first().map_or(0.0, |mode| mode.frequency)])
}
