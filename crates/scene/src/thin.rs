//! Solids that the grid cannot see.

use crate::error::SceneError;
use crate::file::Scene;
use meniscus_numerics::Vector;
use meniscus_numerics::mesh::SurfaceMesh;
use meniscus_sim::{LineTracker, Model, Solid};

/// Part of a solid's surface behind which it may be thinner than a cell: sharp rims.
const RIMS: f64 = 0.1;

/// Refuses solids with walls thinner than a cell: no cell's centre need lie in them, and liquid would pass.
///
/// # Errors
/// [`SceneError`] at the solid's shape.
pub fn thick_enough<const D: usize>(scene: &Scene, model: &Model<D>) -> Result<(), SceneError> {
    let edges: Vec<f64> = scene.solids.iter().map(|s| s.mesh_edge.max(0.5 * scene.domain.dx)).collect();
    let surfaces = LineTracker::new(model, &edges);
    let start: Vec<_> = model.solids.iter().map(Solid::start).collect();
    for (i, solid) in scene.solids.iter().enumerate() {
        let inside = |x: &Vector<D>| model.solids[i].distance(&start[i], x) < 0.0;
        let thin = thin_part(&surfaces.surface(model, &start, i), scene.domain.dx, inside);
        if thin > RIMS {
            let error = SceneError::new(format!(
                "the solid `{}` is thinner than a cell ({:.3e} m) behind {:.0} % of its surface: liquid would pass",
                solid.name,
                scene.domain.dx,
                100.0 * thin
            ));
            let error = error.with_help("make it thicker (two cells are well seen), or the resolution finer");
            return Err(scene
                .source
                .at_value(error, &scene.source.first_inside(&format!("solid.{i}.shape"))));
        }
    }
    Ok(())
}

/// The part of a surface behind which there is less than a depth `dx` (m) of what is `inside`.
fn thin_part<const D: usize>(surface: &SurfaceMesh<D>, dx: f64, inside: impl Fn(&Vector<D>) -> bool) -> f64 {
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
