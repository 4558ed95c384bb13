//! Tension of the dry surface of a deformable solid.

use crate::error::SceneError;
use crate::file::{Scene, Scheme, Solid as SolidSpec, SolidTension};
use meniscus_elastic::{DiscreteGradientTerm, SurfaceTension};
use meniscus_numerics::mesh::VolumeMesh;

/// The term of a solid, if its dry surface has a tension. In the scheme of the paper the contact line has the tensions of both sides.
///
/// # Errors
/// [`SceneError`] where `neumann` asks for a balance that does not exist.
pub fn term<const D: usize>(
    scene: &Scene,
    spec: &SolidSpec,
    mesh: &VolumeMesh<D>,
) -> Result<Option<Box<dyn DiscreteGradientTerm<D>>>, SceneError> {
    let tension = dry_surface_tension(scene, spec)?.filter(|_| scene.numerics.scheme == Scheme::Meniscus);
    Ok(tension.map(|tension| Box::new(SurfaceTension::new(mesh, tension)) as Box<_>))
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
