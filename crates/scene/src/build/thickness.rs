//! Detects solids too thin for the grid.

use crate::error::SceneError;
use crate::file::{Scene, Solid as SolidSpec};
use meniscus_numerics::Vector;
use meniscus_numerics::mesh::SurfaceMesh;
use meniscus_sim::{LineTracker, MIN_PLATE_THICKNESS_CELLS, Model, Solid, SolidSurfaces, Solids};

/// Largest share of a solid's surface that may be thinner than a cell; sharp rims are.
const MAX_THIN_SHARE: f64 = 0.1;
/// Least share of thin surface that makes a solid a plate. Solids with only thin limbs are not padded.
const MIN_PLATE_SHARE: f64 = 0.5;
/// Least thickness, in cells, of a deformable solid with liquid on both sides.
const MIN_SOFT_THICKNESS_CELLS: f64 = 1.5;
/// Relative rounding error of a thickness.
const RELATIVE_ROUNDING: f64 = 1e-6;
/// Samples along a normal to measure a thickness.
const SAMPLES_PER_THICKNESS: u32 = 100;

/// Refuses solids with walls thinner than a cell: they may contain no cell centre, and liquid would pass. Deformable solids
/// need [`MIN_SOFT_THICKNESS_CELLS`] cells. Returns the solids, with thin plates padded ([`Solid::padded`]).
///
/// # Errors
/// [`SceneError`] at the solid's shape.
pub fn pad_thin_solids<const D: usize>(scene: &Scene, model: &Model<D>) -> Result<Vec<Solid<D>>, SceneError> {
    let edges: Vec<f64> = scene.solids.iter().map(|s| s.mesh_edge.max(0.5 * scene.domain.dx)).collect();
    let tracker = LineTracker::new(model, &edges);
    let states = &model.initial_solids();
    let solids = Solids { model, states, surfaces: &SolidSurfaces::new(&model.solids, states) };
    let dx = scene.domain.dx;
    let mut padded = Vec::new();
    for (i, solid) in scene.solids.iter().enumerate() {
        let inside = |x: &Vector<D>| solids.get(i).distance(x) < 0.0;
        let soft = model.solids[i].elastic().is_some();
        let min_cells = if soft { MIN_SOFT_THICKNESS_CELLS * (1.0 - RELATIVE_ROUNDING) } else { 1.0 };
        let surface = tracker.surface(solids, i);
        let thin = thin_share(&surface, min_cells * dx, &inside);
        if thin <= MAX_THIN_SHARE {
            let is_plate = thin_share(&surface, MIN_PLATE_THICKNESS_CELLS * dx, &inside) > MIN_PLATE_SHARE;
            let thickness = if is_plate {
                mean_thickness(&surface, MIN_PLATE_THICKNESS_CELLS * dx, &inside)
            } else {
                f64::INFINITY
            };
            padded.push(model.solids[i].clone().padded(thickness, dx));
            continue;
        }
        let error = match soft {
            true => too_thin_error(scene, solid, thin, mean_thickness(&surface, min_cells * dx, &inside)),
            false => SceneError::new(format!(
                "the solid `{}` is thinner than a cell ({dx:.3e} m) over {:.0} % of its surface: liquid would leak through it",
                solid.name,
                100.0 * thin
            ))
            .with_help("make it thicker (two cells resolve it well), or increase the resolution"),
        };
        return Err(scene.source.at_value(error, &scene.source.first_inside(&format!("solid.{i}.shape"))));
    }
    Ok(padded)
}

/// The error for a deformable solid with mean `thickness`, m, behind the thin share `part` of its surface.
fn too_thin_error(scene: &Scene, solid: &SolidSpec, part: f64, thickness: f64) -> SceneError {
    let dx = scene.domain.dx;
    let longest = scene.domain.cells.iter().max().copied().unwrap_or(1) as f64;
    let message = format!(
        "the solid `{}` is {:.2} cells ({thickness:.3e} m) thick over {:.0} % of its surface: a deformable solid must be at \
         least {MIN_SOFT_THICKNESS_CELLS} cells thick to separate the liquid on its two sides",
        solid.name,
        thickness / dx,
        100.0 * part
    );
    SceneError::new(message).with_help(format!(
        "make it at least {:.3e} m thick (four cells resolve it well), or make the cells smaller: resolution = {:.0}",
        MIN_SOFT_THICKNESS_CELLS * dx,
        (longest * MIN_SOFT_THICKNESS_CELLS * dx / thickness).ceil()
    ))
}

/// Mean thickness, m, of a surface where it is below `max_depth`, m.
fn mean_thickness<const D: usize>(
    surface: &SurfaceMesh<D>,
    max_depth: f64,
    inside: &dyn Fn(&Vector<D>) -> bool,
) -> f64 {
    let (mut sum, mut all) = (0.0, 0.0);
    for facet in 0..surface.facets.len() {
        let area = surface.area_vector(facet);
        let Some(normal) = area.try_normalize(0.0) else { continue };
        let middle = surface.corners(facet).iter().sum::<Vector<D>>() / D as f64;
        let is_in = |k: u32| {
            inside(&(middle - normal * (max_depth * f64::from(k) / f64::from(SAMPLES_PER_THICKNESS))))
        };
        if let Some(k) = (1..=SAMPLES_PER_THICKNESS).find(|k| !is_in(*k)) {
            sum += area.norm() * max_depth * (f64::from(k) - 0.5) / f64::from(SAMPLES_PER_THICKNESS);
            all += area.norm();
        }
    }
    if all > 0.0 { sum / all } else { max_depth }
}

/// The share of a surface where the thickness of the region `inside` is below `dx`, m.
fn thin_share<const D: usize>(surface: &SurfaceMesh<D>, dx: f64, inside: &dyn Fn(&Vector<D>) -> bool) -> f64 {
    let (mut thin, mut all) = (0.0, 0.0);
    for facet in 0..surface.facets.len() {
        let area = surface.area_vector(facet);
        let Some(normal) = area.try_normalize(0.0) else { continue };
        let middle = surface.facets[facet].iter().map(|v| surface.positions[*v as usize]).sum::<Vector<D>>();
        all += area.norm();
        thin += if inside(&(middle / D as f64 - normal * dx)) { 0.0 } else { area.norm() };
    }
    if all > 0.0 { thin / all } else { 0.0 }
}
