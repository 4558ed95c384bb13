//! The parameters of a scene as numbers, for `summary.json` and the page. They follow from the scene without building its solids.

use super::scales::{ball_radius, liquid_volume, smallest_radius, typical_speed};
use crate::file::{Elastic, Material, Scene, Solid, WALLS};
use serde::{Deserialize, Serialize};

/// A number with a name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Parameter {
    /// The solid that it belongs to, or `walls`; none for the liquid and the whole scene.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub of: Option<String>,
    /// Its name.
    pub name: String,
    /// Its symbol.
    pub symbol: String,
    /// Its value.
    pub value: f64,
    /// The unit of the value: SI, `deg` for angles, empty for pure numbers.
    pub unit: String,
}

/// A list of parameters of one owner.
struct List {
    of: Option<String>,
    all: Vec<Parameter>,
}

impl List {
    fn put(&mut self, name: &str, symbol: &str, value: f64, unit: &str) {
        let (name, symbol, unit) = (name.to_owned(), symbol.to_owned(), unit.to_owned());
        self.all.push(Parameter { of: self.of.clone(), name, symbol, value, unit });
    }
}

/// The parameters of a scene: those of the liquid, then those of each solid.
pub fn parameters(scene: &Scene) -> Vec<Parameter> {
    let mut list = List { of: None, all: Vec::new() };
    liquid(scene, &mut list);
    if scene.domain.wall_contact_angle.cos().abs() > f64::EPSILON {
        list.of = Some(WALLS.to_owned());
        list.put("Young's angle", "θ_Y", scene.domain.wall_contact_angle.to_degrees(), "deg");
    }
    for spec in &scene.solids {
        list.of = Some(spec.name.clone());
        solid(scene, spec, &mut list);
    }
    list.all
}

fn liquid(scene: &Scene, list: &mut List) {
    let (l, gamma) = (&scene.liquid, scene.tension.liquid_air);
    let (rho, nu) = (l.density, l.kinematic_viscosity);
    let g = l.gravity.iter().map(|x| x * x).sum::<f64>().sqrt();
    let speed = typical_speed(scene);
    let of_volume = || liquid_volume(scene).map(|v| ball_radius(v, scene.domain.dimension));
    let radius = smallest_radius(scene).or_else(of_volume);
    radius.iter().for_each(|r| list.put("radius", "R", *r, "m"));
    list.put("density", "ρ", rho, "kg/m³");
    list.put("dynamic viscosity", "μ", rho * nu, "Pa s");
    list.put("surface tension", "γ", gamma, "N/m");
    if speed > 0.0 {
        list.put("speed at the start", "U", speed, "m/s");
    }
    if g > 0.0 {
        list.put("gravity", "g", g, "m/s²");
        list.put("capillary length", "√(γ / ρ g)", (gamma / (rho * g)).sqrt(), "m");
    }
    let Some(r) = radius else { return };
    let d = 2.0 * r;
    list.put("cells per radius", "R / dx", r / scene.domain.dx, "");
    if g > 0.0 {
        list.put("Bond number", "Bo = ρ g R² / γ", rho * g * r * r / gamma, "");
    }
    list.put("Ohnesorge number", "Oh = μ / √(ρ γ D)", nu * rho / (rho * gamma * d).sqrt(), "");
    if speed > 0.0 {
        list.put("Weber number", "We = ρ U² D / γ", rho * speed * speed * d / gamma, "");
    }
    if speed > 0.0 && nu > 0.0 {
        list.put("Reynolds number", "Re = U D / ν", speed * d / nu, "");
    }
}

fn solid(scene: &Scene, spec: &Solid, list: &mut List) {
    let gamma = scene.tension.liquid_air;
    if let Some((_, wetting)) = scene.tension.solids.iter().find(|t| t.0 == spec.name) {
        let degrees = |cosine: f64| cosine.clamp(-1.0, 1.0).acos().to_degrees();
        if wetting.is_uniform() {
            let cosine = wetting.young_cosine(gamma);
            list.put("Young's angle", "θ_Y", degrees(cosine), "deg");
        } else {
            let [low, high] = wetting.cosines(gamma).map(degrees);
            list.put("least Young's angle", "θ_Y", low.min(high), "deg");
            list.put("largest Young's angle", "θ_Y", low.max(high), "deg");
        }
    }
    spec.density.iter().for_each(|rho| list.put("density", "ρ_s", *rho, "kg/m³"));
    match &spec.material {
        Material::NeoHookean(e) | Material::Corotated(e) => elastic(scene, spec, e, list),
        Material::Springs { stiffness, .. } => list.put("stiffness of a spring", "k", *stiffness, "N/m"),
        _ => {}
    }
}

fn elastic(scene: &Scene, spec: &Solid, e: &Elastic, list: &mut List) {
    list.put("Young's modulus", "E", e.young_modulus, "Pa");
    list.put("Poisson's ratio", "ν", e.poisson_ratio, "");
    let plate = match scene.domain.dimension {
        2 => super::stiffness::plate_thickness_and_normal::<2>(&spec.shape).map(|p| p.0),
        _ => super::stiffness::plate_thickness_and_normal::<3>(&spec.shape).map(|p| p.0),
    };
    let Some(t) = plate else { return };
    let bending = super::stiffness::plate_bending_stiffness(e, t);
    list.put("thickness", "t", t, "m");
    list.put("bending stiffness", "B = E t³ / 12 (1 − ν²)", bending, "N m");
    let length = (bending / scene.tension.liquid_air).sqrt();
    list.put("bending elastocapillary length", "√(B / γ)", length, "m");
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::file::LoadOptions;
    use std::path::Path;

    #[test]
    fn a_run_knows_what_it_is_of() {
        let text = include_str!("../../../../scenes/fig12-contact-angle-45-2d.toml");
        let scene = Scene::from_text("x.toml", text, Path::new(""), &LoadOptions::default()).unwrap();
        let all = parameters(&scene);
        let value = |name: &str| all.iter().find(|p| p.name == name).unwrap().value;
        let exact = [("radius", 2e-3), ("surface tension", 0.14142), ("Young's angle", 45.0)];
        for (name, exact) in exact.into_iter().chain([("Bond number", 1e3 * 9.81 * 4e-6 / 0.14142)]) {
            assert!((value(name) / exact - 1.0).abs() < 1e-6, "{name}: {}", value(name));
        }
        assert!(all.iter().all(|p| p.name != "Weber number"), "it starts at rest");
    }
}
