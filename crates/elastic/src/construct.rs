//! Construction of a deformable solid from its specification.

use crate::elastic_solid::Elastic;
use crate::linalg::{LinearSolver, SparsityPattern};
use crate::specification::check_material_constant;
use crate::term::continuum::Continuum;
use crate::term::inversion_barrier::InversionBarrier;
use crate::term::quadrature::mean_square_edge;
use crate::{
    Anchor, AnchorMotion, ConstitutiveLaw, Corotated, DiscreteGradientTerm, ElasticError,
    ElasticSpecification, ElementOrder, Lame, NeoHookean, Springs, lowest_modes_to_tolerance,
};
use meniscus_numerics::Vector;
use meniscus_numerics::mesh::{Simplex, VolumeMesh};
use std::sync::Arc;

/// Volume of an element over that of a regular one with its longest edge, below which the element is refused.
const MIN_ELEMENT_QUALITY: f64 = 1e-3;
/// Relative change of the squared lowest frequency at which the iteration for the damping ends.
const DAMPING_FREQUENCY_TOLERANCE: f64 = 1e-3;

/// Parts of a deformable solid with any kind of elements.
#[derive(Debug)]
pub struct ElasticParts<const D: usize> {
    /// The vertices at rest; simplices are not needed.
    pub rest_mesh: VolumeMesh<D>,
    /// Masses of the vertices, kg (2D: kg/m).
    pub masses: Vec<f64>,
    /// Terms of the energy.
    pub terms: Vec<Box<dyn DiscreteGradientTerm<D>>>,
    /// Anchored vertices.
    pub anchors: Vec<Anchor<D>>,
    /// As in [`ElasticSpecification`].
    pub damping_ratio: f64,
    /// Young's modulus, Pa, which scales the stiffness of contacts.
    pub young_modulus: f64,
    /// Order of the elements.
    pub order: ElementOrder,
    /// Barriers against the inversion of elements.
    pub inversion_barriers: Vec<Continuum<InversionBarrier, D>>,
}

impl<const D: usize> Elastic<D> {
    /// A solid from its specification.
    ///
    /// # Errors
    /// [`ElasticError`] where the specification is invalid.
    pub fn new(description: ElasticSpecification<D>) -> Result<Self, ElasticError> {
        Self::with_terms(description, Vec::new())
    }

    /// A solid from its specification with additional terms.
    ///
    /// # Errors
    /// [`ElasticError`] where the specification is invalid.
    pub fn with_terms(
        description: ElasticSpecification<D>,
        extra_terms: Vec<Box<dyn DiscreteGradientTerm<D>>>,
    ) -> Result<Self, ElasticError> {
        let ElasticSpecification { mesh, density, law, damping_ratio, anchors } = description;
        check_material_constant("the density", density, density > 0.0, "more than 0 kg/m³")?;
        check_material_constant(
            "the damping ratio",
            damping_ratio,
            damping_ratio >= 0.0,
            "0 (none) or more",
        )?;
        law.check()?;
        let masses = lumped_masses(&mesh, density)?;
        let mut terms = terms(&mesh, law)?;
        terms.extend(extra_terms);
        Self::of_parts(ElasticParts {
            masses,
            terms,
            anchors,
            damping_ratio,
            young_modulus: young_modulus(&mesh, law),
            order: law.order(),
            inversion_barriers: inversion_barriers(&mesh, law)?,
            rest_mesh: mesh,
        })
    }

    /// A solid from its parts.
    ///
    /// # Errors
    /// [`ElasticError`] where anchors are invalid, or the matrix is too large.
    pub fn of_parts(parts: ElasticParts<D>) -> Result<Self, ElasticError> {
        let ElasticParts { rest_mesh, masses, terms, anchors, damping_ratio, .. } = parts;
        let anchored = anchored_vertices(&rest_mesh, &anchors)?;
        let pattern = Arc::new(SparsityPattern::new(masses.len(), terms.iter().map(|t| t.couplings())));
        let solver = LinearSolver::new(&rest_mesh.positions, &pattern, &anchored)
            .ok_or(ElasticError::TooLarge { vertices: masses.len() })?;
        let mut body = Self {
            rest_mesh,
            masses,
            terms,
            anchors,
            anchored,
            damping_time: 0.0,
            young_modulus: parts.young_modulus,
            order: parts.order,
            solver,
            pattern,
            inversion_barriers: parts.inversion_barriers,
        };
        if damping_ratio > 0.0 {
            let lowest = lowest_modes_to_tolerance(&body, 1, DAMPING_FREQUENCY_TOLERANCE)?;
            body.damping_time = lowest.first().map_or(0.0, |mode| 2.0 * damping_ratio / mode.frequency);
        }
        Ok(body)
    }
}

/// The terms of a constitutive law.
fn terms<const D: usize>(
    mesh: &VolumeMesh<D>,
    law: ConstitutiveLaw,
) -> Result<Vec<Box<dyn DiscreteGradientTerm<D>>>, ElasticError> {
    Ok(match law {
        ConstitutiveLaw::NeoHookean(constants) => {
            vec![Box::new(Continuum::new(mesh, NeoHookean, constants.lame(), constants.order)?)]
        }
        ConstitutiveLaw::Corotated(constants) => {
            vec![Box::new(Continuum::new(mesh, Corotated, constants.lame(), constants.order)?)]
        }
        ConstitutiveLaw::Springs { stiffness } => {
            vec![Box::new(Springs::new(mesh, stiffness))]
        }
    })
}

/// Young's modulus of a constitutive law, Pa.
fn young_modulus<const D: usize>(mesh: &VolumeMesh<D>, law: ConstitutiveLaw) -> f64 {
    match law {
        ConstitutiveLaw::NeoHookean(constants) | ConstitutiveLaw::Corotated(constants) => {
            constants.young_modulus
        }
        ConstitutiveLaw::Springs { stiffness } => {
            let edge = |s: &Simplex<D>| s.edges(&mesh.positions).column(0).norm();
            stiffness / mesh.simplices.iter().map(edge).fold(0.0, f64::max).powi(D as i32 - 2)
        }
    }
}

/// The inversion barriers of the elements ([`InversionBarrier`]). Their stiffness is that of the law in uniaxial compression,
/// `λ + 2 μ`. For springs of stiffness `k` it is `k l²/V` in an element of volume `V` with the mean square edge length `l²`.
fn inversion_barriers<const D: usize>(
    mesh: &VolumeMesh<D>,
    law: ConstitutiveLaw,
) -> Result<Vec<Continuum<InversionBarrier, D>>, ElasticError> {
    let lame = |stiffness| Lame { lambda: stiffness, mu: 0.0 };
    match law {
        ConstitutiveLaw::NeoHookean(constants) | ConstitutiveLaw::Corotated(constants) => {
            let Lame { lambda, mu } = constants.lame();
            let lame = lame(lambda + 2.0 * mu);
            let mut all = vec![Continuum::new(mesh, InversionBarrier, lame, ElementOrder::Linear)?];
            if constants.order == ElementOrder::Quadratic {
                all.push(Continuum::new(mesh, InversionBarrier, lame, constants.order)?);
            }
            Ok(all)
        }
        ConstitutiveLaw::Springs { stiffness } => {
            let of = |s| lame(stiffness * mean_square_edge(mesh, s) / s.volume(&mesh.positions));
            Ok(vec![Continuum::of_simplices(mesh, InversionBarrier, mesh.simplices.iter().map(of).collect())])
        }
    }
}

/// Lumped masses of the vertices, kg (2D: kg/m).
fn lumped_masses<const D: usize>(mesh: &VolumeMesh<D>, density: f64) -> Result<Vec<f64>, ElasticError> {
    let (positions, count) = (&mesh.positions, mesh.positions.len());
    if mesh.simplices.is_empty() {
        return Err(ElasticError::Empty);
    }
    if let Some(vertex) = positions.iter().position(|x| !x.iter().all(|c| c.is_finite())) {
        return Err(ElasticError::NonFinitePosition { vertex });
    }
    let mut masses = vec![0.0; count];
    for (element, simplex) in mesh.simplices.iter().enumerate() {
        if let Some(vertex) = simplex.vertices().find(|v| *v as usize >= count) {
            return Err(ElasticError::NoSuchVertex { element, vertex, count });
        }
        let at: Vec<Vector<D>> = simplex.vertices().map(|v| positions[v as usize]).collect();
        let center = || (at.iter().sum::<Vector<D>>() / at.len() as f64).iter().copied().collect();
        let volume = simplex.volume(positions);
        let longest = at.iter().flat_map(|a| at.iter().map(move |b| (a - b).norm())).fold(0.0, f64::max);
        let quality =
            volume / (longest.powi(D as i32) * if D == 2 { 3f64.sqrt() / 4.0 } else { 2f64.sqrt() / 12.0 });
        if quality < -MIN_ELEMENT_QUALITY {
            return Err(ElasticError::Inverted { element, center: center(), volume });
        }
        if quality.is_nan() || quality < MIN_ELEMENT_QUALITY {
            return Err(ElasticError::Flat { element, center: center(), quality });
        }
        simplex.vertices().for_each(|v| masses[v as usize] += density * volume / (D + 1) as f64);
    }
    match masses.iter().position(|m| *m == 0.0) {
        Some(vertex) => Err(ElasticError::UnreferencedVertex {
            vertex,
            place: positions[vertex].iter().copied().collect(),
        }),
        None => Ok(masses),
    }
}

/// Whether each vertex is anchored.
fn anchored_vertices<const D: usize>(
    mesh: &VolumeMesh<D>,
    anchors: &[Anchor<D>],
) -> Result<Vec<bool>, ElasticError> {
    let count = mesh.positions.len();
    let mut by = vec![None; count];
    for (anchor, held) in anchors.iter().enumerate() {
        if held.vertices.is_empty() {
            return Err(ElasticError::EmptyAnchor { anchor });
        }
        if let AnchorMotion::Keyframes(keys) = &held.motion {
            let rises = |k: usize| keys[k].0.is_finite() && (k == 0 || keys[k - 1].0 < keys[k].0);
            if let Some(keyframe) = (0..keys.len()).find(|k| !rises(*k)) {
                return Err(ElasticError::Keyframes { anchor, keyframe });
            }
        }
        for vertex in held.vertices.iter().copied() {
            match by.get_mut(vertex as usize) {
                None => return Err(ElasticError::NoSuchAnchorVertex { anchor, vertex, count }),
                Some(Some(first)) if *first != anchor => {
                    return Err(ElasticError::OverlappingAnchors { first: *first, second: anchor, vertex });
                }
                Some(holder) => *holder = Some(anchor),
            }
        }
    }
    let held: Vec<bool> = by.iter().map(Option::is_some).collect();
    if held.iter().all(|h| *h) { Err(ElasticError::AllAnchored) } else { Ok(held) }
}
