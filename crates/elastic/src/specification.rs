//! Specification of a deformable solid.

use crate::ElasticError;
use meniscus_numerics::Vector;
use meniscus_numerics::mesh::VolumeMesh;
use meniscus_numerics::mesh::volume::ElementOrder;

/// Specification of a deformable solid.
#[derive(Clone, Debug, PartialEq)]
pub struct ElasticSpecification<const D: usize> {
    /// Mesh at rest.
    pub mesh: VolumeMesh<D>,
    /// Mass density, kg/m³.
    pub density: f64,
    /// Constitutive law.
    pub law: ConstitutiveLaw,
    /// Damping of the lowest elastic mode over the critical damping; that of other modes is proportional to their frequency. Rigid
    /// motions are not damped.
    pub damping_ratio: f64,
    /// Anchored vertices.
    pub anchors: Vec<Anchor<D>>,
}

/// Constitutive law of a solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ConstitutiveLaw {
    /// Hyperelastic continuum for large strains, [`crate::NeoHookean`].
    NeoHookean {
        /// Young's modulus, Pa.
        young_modulus: f64,
        /// Poisson's ratio.
        poisson_ratio: f64,
        /// Order of the elements.
        order: ElementOrder,
    },
    /// Continuum for small strains and large rotations, [`crate::Corotated`].
    Corotated {
        /// Young's modulus, Pa.
        young_modulus: f64,
        /// Poisson's ratio.
        poisson_ratio: f64,
        /// Order of the elements.
        order: ElementOrder,
    },
    /// A spring along every edge, [`crate::Springs`].
    Springs {
        /// Stiffness of each spring, N/m (2D: N/m²).
        stiffness: f64,
    },
}

impl ConstitutiveLaw {
    /// Checks the ranges of the material constants.
    pub(crate) fn check(&self) -> Result<(), ElasticError> {
        match *self {
            Self::NeoHookean { young_modulus, poisson_ratio, .. }
            | Self::Corotated { young_modulus, poisson_ratio, .. } => {
                check_material_constant(
                    "Young's modulus",
                    young_modulus,
                    young_modulus > 0.0,
                    "more than 0 Pa",
                )?;
                let inside = poisson_ratio > -1.0 && poisson_ratio < 0.5;
                check_material_constant(
                    "Poisson's ratio",
                    poisson_ratio,
                    inside,
                    "between -1 and 0.5; rubber has 0.45 to 0.49",
                )
            }
            Self::Springs { stiffness } => {
                check_material_constant("the spring stiffness", stiffness, stiffness > 0.0, "more than 0 N/m")
            }
        }
    }
}

/// Returns an error if a constant is not finite or outside its allowed range.
pub(crate) fn check_material_constant(
    name: &'static str,
    value: f64,
    fits: bool,
    allowed: &'static str,
) -> Result<(), ElasticError> {
    if fits && value.is_finite() { Ok(()) } else { Err(ElasticError::Material { name, value, allowed }) }
}

/// Anchored vertices with their prescribed motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Anchor<const D: usize> {
    /// Numbers of the vertices.
    pub vertices: Vec<u32>,
    /// Prescribed motion.
    pub motion: AnchorMotion<D>,
}

impl<const D: usize> Anchor<D> {
    /// A fixed anchor of all vertices whose rest positions are in a region.
    pub fn within(mesh: &VolumeMesh<D>, region: impl Fn(&Vector<D>) -> bool) -> Self {
        let inside = |v: &u32| region(&mesh.positions[*v as usize]);
        Self {
            vertices: (0..mesh.positions.len() as u32).filter(inside).collect(),
            motion: AnchorMotion::Fixed,
        }
    }
}

/// Prescribed motion of anchored vertices.
#[derive(Clone, Debug, PartialEq)]
pub enum AnchorMotion<const D: usize> {
    /// No motion.
    Fixed,
    /// Constant velocity, m/s, from time 0.
    Velocity(Vector<D>),
    /// Increasing times, s, and displacements from rest, m; linear between, constant before and after.
    Keyframes(Vec<(f64, Vector<D>)>),
}

impl<const D: usize> AnchorMotion<D> {
    /// Displacement from rest at a time, m.
    pub fn displacement(&self, time: f64) -> Vector<D> {
        match self {
            Self::Fixed => Vector::zeros(),
            Self::Velocity(velocity) => velocity * time,
            Self::Keyframes(keys) => {
                let next = keys.partition_point(|k| k.0 <= time);
                match (next.checked_sub(1).and_then(|k| keys.get(k)), keys.get(next)) {
                    (Some(a), Some(b)) => a.1 + (b.1 - a.1) * ((time - a.0) / (b.0 - a.0)),
                    (Some(only), None) | (None, Some(only)) => only.1,
                    (None, None) => Vector::zeros(),
                }
            }
        }
    }
}
