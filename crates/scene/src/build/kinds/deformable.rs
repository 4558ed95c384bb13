//! Builds the deformable solids of a scene: mesh, constitutive law, anchors.

use crate::build::shapes::shape;
use crate::error::SceneError;
use crate::estimate::stiffness::check_stiffness;
use crate::file::{
    Elastic as Constants, Material, Scene, SceneFiles, ShapeSpec, Solid as SolidSpec, rotation, vector,
};
use meniscus_elastic::{
    ConstitutiveLaw, Elastic, ElasticError, ElasticSpecification, ElementOrder, Isotropic,
};
use meniscus_numerics::mesh::VolumeMesh;

/// The elastic model of a solid; `None` if it does not deform.
///
/// # Errors
/// [`SceneError`] for a shape that cannot be meshed and for an invalid material.
pub fn elastic<const D: usize>(scene: &Scene, spec: &SolidSpec) -> Result<Option<Elastic<D>>, SceneError> {
    if !spec.material.deforms() {
        return Ok(None);
    }
    let at = |key: &str| {
        let number = scene.solids.iter().position(|s| s.name == spec.name).unwrap_or(0);
        format!("solid.{number}.{key}")
    };
    let Some((law, damping_ratio)) = law(spec) else { return Ok(None) };
    let mesh = mesh::<D>(spec, law.order(), &scene.files).map_err(|message| {
        let error = SceneError::new(format!("the solid `{}` cannot be meshed: {message}", spec.name));
        scene.source.at_value(error, &scene.source.first_inside(&at("shape")))
    })?;
    let anchors = super::constraints::anchors(&mesh, scene, spec, &|key, error| {
        scene.source.at_value(error, &at(key))
    })?;
    let density = spec.density.unwrap_or(scene.liquid.density);
    check_stiffness(scene, spec, &mesh, density)
        .map_err(|error| scene.source.at_value(error, &scene.source.first_inside(&at("material"))))?;
    let description = ElasticSpecification { mesh, density, law, damping_ratio, anchors };
    let terms = crate::build::terms::extra_terms(scene, spec, &description.mesh)?;
    Elastic::with_terms(description, terms).map(Some).map_err(|error| {
        let key = match error {
            ElasticError::Material { .. } => "material",
            _ => "shape",
        };
        let error = SceneError::new(format!("the solid `{}`: {error}", spec.name));
        scene.source.at_value(error, &scene.source.first_inside(&at(key)))
    })
}

/// The constitutive law of a deformable solid, and its damping ratio.
fn law(spec: &SolidSpec) -> Option<(ConstitutiveLaw, f64)> {
    let isotropic = |e: Constants| Isotropic {
        young_modulus: e.young_modulus,
        poisson_ratio: e.poisson_ratio,
        order: ElementOrder::Quadratic,
    };
    match spec.material {
        Material::Springs { stiffness, damping_ratio } => {
            Some((ConstitutiveLaw::Springs { stiffness }, damping_ratio))
        }
        Material::NeoHookean(e) => Some((ConstitutiveLaw::NeoHookean(isotropic(e)), e.damping_ratio)),
        Material::Corotated(e) => Some((ConstitutiveLaw::Corotated(isotropic(e)), e.damping_ratio)),
        _ => None,
    }
}

/// Meshes a solid; the error is a message. Elements of a file are kept; quadratic elements add vertices at the midpoints of its
/// edges.
fn mesh<const D: usize>(
    solid: &SolidSpec,
    order: ElementOrder,
    files: &SceneFiles,
) -> Result<VolumeMesh<D>, String> {
    let (spec, edge) = (&solid.shape, solid.mesh_edge);
    if spec.volume_file().is_some() {
        let mesh = crate::build::shapes::file_volume_mesh::<D>(spec, files)?;
        return Ok(if order == ElementOrder::Quadratic { mesh.subdivided() } else { mesh });
    }
    if let ShapeSpec::Extrusion { outline, thickness, center, rotation: turned } = spec {
        let flat = crate::file::outline(outline).map_err(|e| e.to_string())?;
        let mesh = VolumeMesh::of_outline(&flat, &vector(center), *thickness, &rotation(turned), edge, order);
        return mesh.map_err(|e| e.to_string());
    }
    let shape = shape::<D>(spec, files).map_err(|e| e.to_string())?;
    VolumeMesh::of_shape(&shape, edge, order).map_err(|e| e.to_string())
}
