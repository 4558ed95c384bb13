//! Liquid displaced by solids at the start.
//!
//! Where a body of liquid and a solid overlap, the solid takes precedence. A pool (any shape but a drop) is expected to be
//! displaced. A drop (ball, ellipsoid or perturbed ball) is not: the scene gets a warning if the drop overlaps a solid by more
//! than a cell and that solid is not fully inside the drop, unless the body says `displaced = true`. A body that is displaced
//! completely is an error.

use super::Setup;
use super::setup::AnySetup;
use crate::error::SceneError;
use crate::estimate::thin_liquid::Obstacles;
use crate::file::{Scene, ShapeSpec, Warning};
use crate::units::{format_si, format_volume};
use meniscus_numerics::grid::Lattice;
use meniscus_numerics::{Vector, par};
use meniscus_sim::{SolidSurfaces, Solids};
use serde::Serialize;

/// Samples along each axis of the bounding box of a body, in two and three dimensions.
const SAMPLES_PER_AXIS: [usize; 2] = [512, 96];
/// Depth of an overlap, in cells, above which a drop gets a warning. A smaller overlap places the drop on the solid.
const OVERLAP_WARNING_CELLS: f64 = 1.0;

/// A body of liquid and the part of it that solids displace.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DisplacedBody {
    /// Number of the body in the scene, from 0.
    pub body: usize,
    /// Sampled volume inside the domain and outside the preceding bodies, m³ (2D: m²).
    pub volume: f64,
    /// Volume displaced by solids, m³ (2D: m²).
    pub displaced: f64,
    /// Depth of the overlap, m.
    pub depth: f64,
    /// Whether it overlaps a solid that is not fully inside it.
    pub cut: bool,
}

/// The displacement of every body of a scene, in order.
pub fn displaced_bodies(scene: &Scene, setup: &AnySetup) -> Vec<DisplacedBody> {
    match setup {
        AnySetup::D2(setup) => displaced_bodies_of(scene, setup),
        AnySetup::D3(setup) => displaced_bodies_of(scene, setup),
    }
}

/// Warnings for drops that solids cut.
///
/// # Errors
/// [`SceneError`] at a body that lies completely inside solids.
pub fn check_displaced(scene: &Scene, all: &[DisplacedBody]) -> Result<Vec<Warning>, SceneError> {
    let mut warnings = Vec::new();
    for d in all {
        let path = format!("liquid.body.{}.shape", d.body);
        let share = d.displaced / d.volume.max(f64::MIN_POSITIVE);
        if d.volume > 0.0 && d.displaced >= d.volume {
            let error =
                SceneError::new("this liquid body lies entirely inside solids: nothing remains of it");
            let error = error.with_help("move it so that at least a part of it lies outside the solids");
            return Err(scene.source.at_value(error, &scene.source.first_inside(&path)));
        }
        let body = &scene.liquid.bodies[d.body];
        if is_drop(&body.shape)
            && !body.displaced
            && d.cut
            && d.depth > OVERLAP_WARNING_CELLS * scene.domain.dx
        {
            let message = format!(
                "this liquid body overlaps a solid by {}: {} of it ({:.1} %) are removed; move it, or set \
                 `displaced = true` in this body if the overlap is intended",
                format_si(d.depth, "m"),
                format_volume(d.displaced, scene.domain.dimension),
                100.0 * share
            );
            warnings.push(Warning { path, message });
        }
    }
    Ok(warnings)
}

fn is_drop(shape: &ShapeSpec) -> bool {
    matches!(shape, ShapeSpec::Ball { .. } | ShapeSpec::PerturbedBall { .. } | ShapeSpec::Ellipsoid { .. })
}

fn displaced_bodies_of<const D: usize>(scene: &Scene, setup: &Setup<D>) -> Vec<DisplacedBody> {
    let (model, states) = (&setup.model, &setup.model.initial_solids());
    let solids = Solids { model, states, surfaces: &SolidSurfaces::new(&model.solids, states) };
    let obstacles = Obstacles::new(solids, scene.domain.dx);
    let immersed = |body: usize, solid: usize| {
        let solid = solids.get(solid);
        let [low, high] = solid.bounds();
        let finite = low.iter().chain(high.iter()).all(|x| x.is_finite());
        finite
            && sample_points(&low, &high, SAMPLES_PER_AXIS[D - 2] / 8)
                .all(|x| solid.distance(&x) > 0.0 || (setup.bodies[body].0)(&x) < 0.0)
    };
    let of_body = |body: usize| {
        let [low, high] = sampling_box::<D>(scene, &scene.liquid.bodies[body].shape);
        let count = SAMPLES_PER_AXIS[D - 2];
        let piece = (high - low).iter().map(|s| s.max(0.0)).product::<f64>() / count.pow(D as u32) as f64;
        let liquid = |x: &Vector<D>| -> Option<f64> {
            let depth = -(setup.bodies[body].0)(x);
            (depth > 0.0 && setup.bodies[..body].iter().all(|b| (b.0)(x) >= 0.0)).then_some(depth)
        };
        let points: Vec<Vector<D>> = sample_points(&low, &high, count).collect();
        // For each liquid point inside a solid: that solid, and the smaller of the depths in body and solid.
        let found: Vec<Option<(usize, f64)>> = par::filter_map(points.len(), 64, |i| {
            let depth = liquid(&points[i])?;
            let nearest = obstacles.distances(&points[i]).min_by(|a, b| a.1.total_cmp(&b.1));
            Some(nearest.filter(|n| n.1 < 0.0).map(|(solid, d)| (solid, depth.min(-d))))
        });
        let inside: Vec<(usize, f64)> = found.iter().copied().flatten().collect();
        let mut solids: Vec<usize> = inside.iter().map(|i| i.0).collect();
        solids.sort_unstable();
        solids.dedup();
        DisplacedBody {
            body,
            volume: found.len() as f64 * piece,
            displaced: inside.len() as f64 * piece,
            depth: 2.0 * inside.iter().map(|i| i.1).fold(0.0, f64::max),
            cut: solids.into_iter().any(|solid| !immersed(body, solid)),
        }
    };
    (0..setup.bodies.len()).map(of_body).collect()
}

/// The bounding box of a body, clipped to the domain.
fn sampling_box<const D: usize>(scene: &Scene, shape: &ShapeSpec) -> [Vector<D>; 2] {
    let size = Vector::<D>::from_fn(|a, _| scene.domain.size[a]);
    let Some(bounds) = shape.bounds(D) else { return [Vector::zeros(), size] };
    let corner = |x: &[f64]| Vector::<D>::from_fn(|a, _| x[a].clamp(0.0, size[a]));
    [corner(&bounds.lower), corner(&bounds.upper)]
}

/// Centres of `count` by `count` (by `count`) equal parts of a box.
fn sample_points<const D: usize>(
    low: &Vector<D>,
    high: &Vector<D>,
    count: usize,
) -> impl Iterator<Item = Vector<D>> + use<D> {
    let (low, step) = (*low, (high - low) / count as f64);
    let lattice = Lattice::<D>::new([count; D]);
    (0..lattice.len()).map(move |i| {
        let at = lattice.coordinates(i);
        low + Vector::from_fn(|a, _| step[a] * (at[a] as f64 + 0.5))
    })
}
