//! Specification of a deformable solid.

use crate::{ElasticError, Lame};
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
    NeoHookean(Isotropic),
    /// Continuum for small strains and large rotations, [`crate::Corotated`].
    Corotated(Isotropic),
    /// A spring along every edge, [`crate::Springs`].
    Springs {
        /// Stiffness of each spring, N/m (2D: N/m²).
        stiffness: f64,
    },
}

/// Constants of an isotropic continuum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Isotropic {
    /// Young's modulus, Pa.
    pub young_modulus: f64,
    /// Poisson's ratio.
    pub poisson_ratio: f64,
    /// Order of the elements.
    pub order: ElementOrder,
}

impl Isotropic {
    /// Lamé's parameters.
    pub(crate) fn lame(&self) -> Lame {
        Lame::new(self.young_modulus, self.poisson_ratio)
    }

    fn check(&self) -> Result<(), ElasticError> {
        let young = self.young_modulus;
        check_material_constant("Young's modulus", young, young > 0.0, "more than 0 Pa")?;
        let inside = self.poisson_ratio > -1.0 && self.poisson_ratio < 0.5;
        let allowed = "between -1 and 0.5; rubber has 0.45 to 0.49";
        check_material_constant("Poisson's ratio", self.poisson_ratio, inside, allowed)
    }
}

impl ConstitutiveLaw {
    /// [`Self::NeoHookean`] with Young's modulus in Pa.
    pub fn neo_hookean(young_modulus: f64, poisson_ratio: f64, order: ElementOrder) -> Self {
        Self::NeoHookean(Isotropic { young_modulus, poisson_ratio, order })
    }

    /// [`Self::Corotated`] with Young's modulus in Pa.
    pub fn corotated(young_modulus: f64, poisson_ratio: f64, order: ElementOrder) -> Self {
        Self::Corotated(Isotropic { young_modulus, poisson_ratio, order })
    }

    /// Order of the elements.
    pub fn order(&self) -> ElementOrder {
        match self {
            Self::NeoHookean(constants) | Self::Corotated(constants) => constants.order,
            Self::Springs { .. } => ElementOrder::Linear,
        }
    }

    /// Checks the ranges of the material constants.
    pub(crate) fn check(&self) -> Result<(), ElasticError> {
        match *self {
            Self::NeoHookean(constants) | Self::Corotated(constants) => constants.check(),
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
