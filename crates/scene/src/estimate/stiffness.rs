//! Stiffness of deformable solids: elastic wave speed, bending stiffness, and the limit on stiffness at a given step.

use super::scales::longest_step;
use crate::error::SceneError;
use crate::file::{Elastic, Material, Scene, ShapeSpec, Solid as SolidSpec};
use meniscus_numerics::mesh::VolumeMesh;
use meniscus_numerics::{Matrix, Vector};

/// Most elements that an elastic wave may cross in a step. Its square is the ratio of stiffness to mass in the step's matrix, which
/// leaves four digits of double precision.
const MAX_CROSSED_ELEMENTS: f64 = 1e6;
/// Largest ratio of the thickness of a plate to its next longer side.
const MAX_PLATE_ASPECT: f64 = 0.25;

/// P-wave modulus `λ + 2μ`, Pa. For springs it is the mean over all directions at uniform strain, `Σ k l² ⟨cos⁴⟩ / V`.
fn p_wave_modulus<const D: usize>(spec: &SolidSpec, mesh: &VolumeMesh<D>) -> Option<f64> {
    match &spec.material {
        Material::NeoHookean(e) | Material::Corotated(e) => {
            let (young, nu) = (e.young_modulus, e.poisson_ratio);
            Some(young * (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu)))
        }
        Material::Springs { stiffness, .. } => {
            let squares: f64 = edges(mesh).map(|(_, along)| along.norm_squared()).sum();
            let mean = if D == 2 { 3.0 / 8.0 } else { 1.0 / 5.0 };
            Some(stiffness * squares * mean / mesh.volume())
        }
        _ => None,
    }
}

/// Midpoint and edge vector of all edges of a mesh, m.
fn edges<const D: usize>(mesh: &VolumeMesh<D>) -> impl Iterator<Item = (Vector<D>, Vector<D>)> {
    let at = |v: u32| mesh.positions[v as usize];
    mesh.edges().into_iter().map(move |[a, b]| ((at(a) + at(b)) * 0.5, at(b) - at(a)))
}

/// Speed of elastic waves, m/s.
pub fn wave_speed<const D: usize>(spec: &SolidSpec, mesh: &VolumeMesh<D>, density: f64) -> Option<f64> {
    p_wave_modulus(spec, mesh).map(|modulus| (modulus / density).sqrt())
}

/// Thickness (m) and unit normal of a solid whose shape is a plate or a strip.
pub fn plate_thickness_and_normal<const D: usize>(shape: &ShapeSpec) -> Option<(f64, Vector<D>)> {
    let (sizes, rotation): ([f64; 3], Matrix<D>) = match shape {
        ShapeSpec::Box { half_size, rotation, .. } => {
            let size = |a: usize| half_size.get(a).map_or(f64::INFINITY, |h| 2.0 * h);
            (std::array::from_fn(size), crate::file::rotation(rotation))
        }
        ShapeSpec::Extrusion { outline, thickness, rotation, .. } => {
            let (low, high) = crate::file::outline(outline).ok()?.surface().bounds();
            ([high[0] - low[0], high[1] - low[1], *thickness], crate::file::rotation(rotation))
        }
        _ => return None,
    };
    let thin = (0..D).min_by(|a, b| sizes[*a].total_cmp(&sizes[*b]))?;
    let next = (0..D).filter(|a| *a != thin).map(|a| sizes[a]).fold(f64::INFINITY, f64::min);
    (sizes[thin] <= MAX_PLATE_ASPECT * next).then(|| (sizes[thin], rotation.column(thin).into_owned()))
}

/// Bending stiffness `E t³ / 12 (1 - ν²)` of a plate of thickness `t` (m) per width, N m.
pub fn plate_bending_stiffness(e: &Elastic, thickness: f64) -> f64 {
    e.young_modulus * thickness.powi(3) / (12.0 * (1.0 - e.poisson_ratio.powi(2)))
}

/// Bending stiffness of a plate per width, N m (2D: of a strip per depth): `E t³ / 12 (1 - ν²)`. For springs it is that of isotropic
/// bending of the middle surface, `⟨cos⁴⟩ Σ k p⁴ z² / (l² A)`, where `p` is the in-plane length of an edge. Lattices of 5 tetrahedra with
/// 2 and 4 layers give 3.2 and 16.9 k a²; the solver gives 3.1 and 16.8.
pub fn bending_stiffness<const D: usize>(spec: &SolidSpec, mesh: &VolumeMesh<D>) -> Option<f64> {
    let (thickness, normal) = plate_thickness_and_normal::<D>(&spec.shape)?;
    match &spec.material {
        Material::NeoHookean(e) | Material::Corotated(e) => Some(plate_bending_stiffness(e, thickness)),
        Material::Springs { stiffness, .. } => {
            let middle = mesh.positions.iter().sum::<Vector<D>>() / mesh.positions.len() as f64;
            let part = |(at, along): (Vector<D>, Vector<D>)| {
                let flat = (along - normal * along.dot(&normal)).norm_squared();
                flat * flat * (at - middle).dot(&normal).powi(2) / along.norm_squared()
            };
            let mean = if D == 2 { 1.0 } else { 3.0 / 8.0 };
            Some(mean * stiffness * edges(mesh).map(part).sum::<f64>() * thickness / mesh.volume())
        }
        _ => None,
    }
}

/// Refuses a solid so stiff that its mass is lost to rounding in the step's matrix.
///
/// # Errors
/// [`SceneError`] that gives the largest possible stiffness.
pub fn check_stiffness<const D: usize>(
    scene: &Scene,
    spec: &SolidSpec,
    mesh: &VolumeMesh<D>,
    density: f64,
) -> Result<(), SceneError> {
    let Some(speed) = wave_speed(spec, mesh, density) else { return Ok(()) };
    let shortest = edges(mesh).map(|(_, along)| along.norm()).fold(f64::INFINITY, f64::min);
    let step = longest_step(scene);
    let crossed = speed * step / shortest;
    if crossed <= MAX_CROSSED_ELEMENTS {
        return Ok(());
    }
    let message = format!(
        "the solid `{}` is too stiff for the time step: in {step:.2e} s its elastic waves ({speed:.2e} m/s) cross {crossed:.1e} \
         elements of {shortest:.2e} m; beyond {MAX_CROSSED_ELEMENTS:.0e} elements its mass is lost to rounding errors",
        spec.name
    );
    // Rounded up, so that the advice suffices.
    let more = (crossed / MAX_CROSSED_ELEMENTS).powi(2) * 1.05;
    let help = format!(
        "make it {more:.1e} times softer, use material.rigid, or set numerics.max_step = \"{:.1e} s\"",
        0.95 * step * MAX_CROSSED_ELEMENTS / crossed
    );
    Err(SceneError::new(message).with_help(help))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::file::{LoadOptions, Rotation};
    use std::path::Path;

    fn spec(material: Material, half: &[f64]) -> SolidSpec {
        let text = include_str!("../../../../scenes/drop-on-soft-plate-2d.toml");
        let scene = Scene::from_text("plate.toml", text, Path::new(""), &LoadOptions::default()).unwrap();
        let shape = ShapeSpec::Box {
            center: vec![0.0; half.len()],
            half_size: half.to_vec(),
            rotation: Rotation::NONE,
        };
        SolidSpec { material, shape, ..scene.solids[0].clone() }
    }

    /// The diagonal of a unit square stretched along x with k = 1: l² cos⁴ averaged.
    #[test]
    fn springs_make_waves_and_plates() {
        let springs = Material::Springs { stiffness: 3.0, damping_ratio: 0.0 };
        let size = Vector::<3>::new(12.0, 12.0, 4.0);
        let mesh = meniscus_numerics::mesh::volume::block::block::<3>([12, 12, 4], &size);
        let plate_of = spec(springs.clone(), &[6.0, 6.0, 2.0]);
        // Per cell of Kuhn's lattice: 3 edges of 1, 3 face diagonals of 2, a body diagonal of 3, squared; more at the faces.
        let modulus = p_wave_modulus(&plate_of, &mesh).unwrap() / 3.0;
        assert!(modulus > 12.0 / 5.0 && modulus < 1.35 * 12.0 / 5.0, "{modulus}");
        assert!(plate_thickness_and_normal::<3>(&plate_of.shape).is_none());
        let size = Vector::<3>::new(40.0, 40.0, 4.0);
        let mesh = meniscus_numerics::mesh::volume::block::block::<3>([40, 40, 4], &size);
        let plate_of = spec(springs, &[20.0, 20.0, 2.0]);
        let (thickness, normal) = plate_thickness_and_normal::<3>(&plate_of.shape).unwrap();
        assert!(thickness == 4.0 && normal == Vector::<3>::z());
        // In plane: (2 + 2) 3/8 · 10; across: two diagonals of 1/2 and one of 4/3, 3/8 · 5 each; edges of the plate add a few per cent.
        let exact = 0.375 * (4.0 * 10.0 + (2.0 * 0.5 + 4.0 / 3.0) * 5.0);
        let found = bending_stiffness(&plate_of, &mesh).unwrap() / 3.0;
        assert!((found / exact - 1.0).abs() < 0.05, "{found} {exact}");
    }
}
