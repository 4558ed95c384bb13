//! What a deformable solid is told to be.

use crate::ElasticError;
use meniscus_numerics::Vector;
use meniscus_numerics::mesh::VolumeMesh;
use meniscus_numerics::mesh::volume::ElementOrder;

/// A deformable solid, as described.
#[derive(Clone, Debug, PartialEq)]
pub struct ElasticSpecification<const D: usize> {
    /// Its mesh at rest.
    pub mesh: VolumeMesh<D>,
    /// Mass density, kg/m³.
    pub density: f64,
    /// What makes it elastic.
    pub law: ConstitutiveLaw,
    /// Damping of the lowest elastic mode as a fraction of the critical one; of others in proportion to their frequency.
    /// Motions without strain are not damped.
    pub damping_ratio: f64,
    /// Vertices that are held.
    pub anchors: Vec<Anchor<D>>,
}

/// What makes a solid elastic.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ConstitutiveLaw {
    /// A continuum for large strains, [`crate::NeoHookean`].
    NeoHookean {
        /// Young's modulus, Pa.
        young_modulus: f64,
        /// Poisson's ratio.
        poisson_ratio: f64,
        /// Of the elements.
        order: ElementOrder,
    },
    /// A continuum for small strains and any rotation, [`crate::Corotated`].
    Corotated {
        /// Young's modulus, Pa.
        young_modulus: f64,
        /// Poisson's ratio.
        poisson_ratio: f64,
        /// Of the elements.
        order: ElementOrder,
    },
    /// A spring along every edge, [`crate::Springs`].
    Springs {
        /// Of each, N/m (2D: N/m²).
        stiffness: f64,
    },
}

impl ConstitutiveLaw {
    /// Refuses what no solid can be.
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
            Self::Springs { stiffness } => check_material_constant(
                "the springs' stiffness",
                stiffness,
                stiffness > 0.0,
                "more than 0 N/m",
            ),
        }
    }
}

/// Refuses a constant that is not finite or not what is allowed.
pub(crate) fn check_material_constant(
    name: &'static str,
    value: f64,
    fits: bool,
    allowed: &'static str,
) -> Result<(), ElasticError> {
    if fits && value.is_finite() { Ok(()) } else { Err(ElasticError::Material { name, value, allowed }) }
}

/// Vertices that are held, or moved as told.
#[derive(Clone, Debug, PartialEq)]
pub struct Anchor<const D: usize> {
    /// Which.
    pub vertices: Vec<u32>,
    /// Where they go.
    pub motion: AnchorMotion<D>,
}

impl<const D: usize> Anchor<D> {
    /// Of all vertices of a mesh at rest in a region, which do not move.
    pub fn within(mesh: &VolumeMesh<D>, region: impl Fn(&Vector<D>) -> bool) -> Self {
        let inside = |v: &u32| region(&mesh.positions[*v as usize]);
        Self {
            vertices: (0..mesh.positions.len() as u32).filter(inside).collect(),
            motion: AnchorMotion::Fixed,
        }
    }
}

/// How held vertices move.
#[derive(Clone, Debug, PartialEq)]
pub enum AnchorMotion<const D: usize> {
    /// Not at all.
    Fixed,
    /// With a constant velocity, m/s, from time 0.
    Velocity(Vector<D>),
    /// Times, s, which rise, and displacements from rest, m; linear between, constant before and after.
    Keyframes(Vec<(f64, Vector<D>)>),
}

impl<const D: usize> AnchorMotion<D> {
    /// The displacement from rest at a time, m.
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
