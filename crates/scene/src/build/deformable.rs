//! Builds the deformable solids of a scene: mesh, constitutive law, anchors, surface tension.

use super::shapes::shape;
use crate::error::SceneError;
use crate::estimate::stiffness::check_stiffness;
use crate::file::{
    Elastic as Constants, Material, Scene, SceneFiles, ShapeSpec, Solid as SolidSpec, SolidTension, rotation,
    vector,
};
use meniscus_elastic::{
    ConstitutiveLaw, Elastic, ElasticError, ElasticSpecification, ElementOrder, SurfaceTension,
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
    let order = match law {
        ConstitutiveLaw::Springs { .. } => ElementOrder::Linear,
        ConstitutiveLaw::NeoHookean { order, .. } | ConstitutiveLaw::Corotated { order, .. } => order,
    };
    let mesh = mesh::<D>(spec, order, &scene.files).map_err(|message| {
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
    let tension = dry_surface_tension(scene, spec)?;
    let terms = tension.map(|tension| Box::new(SurfaceTension::new(&description.mesh, tension)) as Box<_>);
    Elastic::with_terms(description, terms.into_iter().collect()).map(Some).map_err(|error| {
        let key = match error {
            ElasticError::Material { .. } => "material",
            _ => "shape",
        };
        let error = SceneError::new(format!("the solid `{}`: {error}", spec.name));
        scene.source.at_value(error, &scene.source.first_inside(&at(key)))
    })
}

/// Tension of the dry surface, N/m: the given one under `neumann`, else the least that is admissible. The liquid and the contact
/// line add the difference where it is wetted.
fn dry_surface_tension(scene: &Scene, spec: &SolidSpec) -> Result<Option<f64>, SceneError> {
    if !scene.contact_line.neumann {
        return Ok(least_dry_tension(scene, spec));
    }
    let name = &spec.name;
    let refuse = |message: String, help: String| {
        Err(scene.source.at_value(SceneError::new(message).with_help(help), "contact_line.neumann"))
    };
    let own = scene.tension.solids.iter().find(|(other, _)| other == name).map(|(_, w)| w);
    match own.map(|wetting| (wetting, wetting.tension(), wetting.is_uniform())) {
        Some((wetting, SolidTension::Energies { solid_air, .. }, true)) => {
            if wetting.young_cosine(scene.tension.liquid_air).abs() <= 1.0 {
                return Ok(Some(solid_air));
            }
            let message = format!(
                "no Neumann balance exists at a contact line on the solid `{name}`: `solid_air` and `liquid_solid` differ by \
                 more than `liquid_air` (total wetting or no wetting)"
            );
            refuse(
                message,
                format!("bring the tensions of `tension.{name}` closer together, or remove `neumann`"),
            )
        }
        _ => refuse(
            format!("`neumann` needs uniform tensions `liquid_solid` and `solid_air` of the solid `{name}`"),
            format!(
                "give both, without `image` and `patches`: `tension.{name} = {{ liquid_solid = \"30 mN/m\", solid_air = \"50 mN/m\" }}`, or remove `neumann`"
            ),
        ),
    }
}

/// The least tension of a dry surface, N/m, with which its tension where liquid wets it, `γ_sa − γ cos θ_Y`, is nowhere negative. A
/// negative tension has no ground state: a surface soft enough to be stretched by it folds at the size of its facets.
fn least_dry_tension(scene: &Scene, spec: &SolidSpec) -> Option<f64> {
    let (_, wetting) = scene.tension.solids.iter().find(|(name, _)| *name == spec.name)?;
    let [_, largest_cosine] = wetting.cosines(scene.tension.liquid_air);
    let is_needed = scene.contact_line.enabled && largest_cosine > 0.0;
    is_needed.then(|| scene.tension.liquid_air * largest_cosine.min(1.0))
}

/// The constitutive law of a deformable solid, and its damping ratio.
fn law(spec: &SolidSpec) -> Option<(ConstitutiveLaw, f64)> {
    let order = ElementOrder::Quadratic;
    match spec.material {
        Material::Springs { stiffness, damping_ratio } => {
            Some((ConstitutiveLaw::Springs { stiffness }, damping_ratio))
        }
        Material::NeoHookean(Constants { young_modulus, poisson_ratio, damping_ratio }) => {
            Some((ConstitutiveLaw::NeoHookean { young_modulus, poisson_ratio, order }, damping_ratio))
        }
        Material::Corotated(Constants { young_modulus, poisson_ratio, damping_ratio }) => {
            Some((ConstitutiveLaw::Corotated { young_modulus, poisson_ratio, order }, damping_ratio))
        }
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
        let mesh = super::shapes::file_volume_mesh::<D>(spec, files)?;
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
