//! Force terms of deformable solids beside those of the constitutive law, one file each.

mod dry_tension;

use crate::error::SceneError;
use crate::file::{Scene, Solid};
use meniscus_elastic::DiscreteGradientTerm;
use meniscus_numerics::mesh::VolumeMesh;

/// The terms of a solid with this mesh.
///
/// # Errors
/// [`SceneError`] of a term that the scene's values do not admit.
pub fn extra_terms<const D: usize>(
    scene: &Scene,
    spec: &Solid,
    mesh: &VolumeMesh<D>,
) -> Result<Vec<Box<dyn DiscreteGradientTerm<D>>>, SceneError> {
    let all = [dry_tension::term(scene, spec, mesh)?];
    Ok(all.into_iter().flatten().collect())
}
