//! Deformable solids of the cases.

use meniscus_elastic::{Anchor, ConstitutiveLaw, Elastic, ElasticError, ElasticSpecification, ElementOrder};
use meniscus_numerics::Vector;
use meniscus_numerics::mesh::VolumeMesh;
use meniscus_numerics::shape::Shape;
use meniscus_sim::{Solid, SolidKind, StepError};
use std::sync::Arc;

/// A neo-Hookean material.
#[derive(Clone, Copy, Debug)]
pub struct SoftMaterial {
    /// Young's modulus.
    pub young: f64,
    /// Poisson's ratio.
    pub poisson: f64,
    /// Density.
    pub density: f64,
    /// Damping ratio of the lowest mode.
    pub damping: f64,
}

impl SoftMaterial {
    /// The description of a solid with a mesh; its elements are quadratic if the mesh allows it.
    pub fn specification<const D: usize>(
        self,
        mesh: VolumeMesh<D>,
        anchors: Vec<Anchor<D>>,
    ) -> ElasticSpecification<D> {
        let Self { young: young_modulus, poisson: poisson_ratio, density, damping } = self;
        let order =
            if mesh.quadratic_simplices().is_some() { ElementOrder::Quadratic } else { ElementOrder::Linear };
        let law = ConstitutiveLaw::neo_hookean(young_modulus, poisson_ratio, order);
        ElasticSpecification { mesh, density, law, damping_ratio: damping, anchors }
    }

    /// A solid with a mesh, by itself.
    ///
    /// # Errors
    /// [`ElasticError`], if no elastic solid can be made of the mesh.
    pub fn elastic<const D: usize>(
        self,
        mesh: VolumeMesh<D>,
        anchors: Vec<Anchor<D>>,
    ) -> Result<Elastic<D>, ElasticError> {
        Elastic::new(self.specification(mesh, anchors))
    }

    /// A solid of a shape, on a mesh with edges of the given length, whose vertices are held where `held` is true.
    ///
    /// # Errors
    /// [`ElasticError`], if no elastic solid can be made of the mesh.
    pub fn solid<const D: usize>(
        self,
        shape: Shape<D>,
        edge: f64,
        held: impl Fn(&Vector<D>) -> bool,
    ) -> Result<Solid<D>, StepError> {
        let mesh = VolumeMesh::of_shape(&shape, edge, ElementOrder::Quadratic).unwrap_or_default();
        let mut anchors = vec![Anchor::within(&mesh, held)];
        anchors.retain(|anchor| !anchor.vertices.is_empty());
        let elastic = self.elastic(mesh, anchors).map_err(not_made)?;
        Ok(Solid::new(shape, SolidKind::Deformable(Arc::new(elastic)), self.density))
    }
}

/// The error of a case whose solid cannot be made.
pub fn not_made(error: impl ToString) -> StepError {
    failure_in_step(0.0)(error)
}

/// The error of a case in which a step of a length fails in a solid.
pub fn failure_in_step<E: ToString>(dt: f64) -> impl Fn(E) -> StepError {
    move |error| StepError::TooShort { time: 0.0, dt, reason: error.to_string() }
}
