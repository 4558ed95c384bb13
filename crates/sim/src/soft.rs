//! Solids that deform, as the liquid meets them.
//!
//! Their positions go first, then their velocities, as the liquid's do: `A (v' − v) = h f + J` with the forces `f` at the new
//! positions, what the liquid gives `J`, and `A = M + h D + h²/4 K` and a little more that damps what the step does not resolve
//! (`meniscus_elastic`). The liquid's pressure is solved for with `A⁻¹` in its system, so that how soft or light a solid is sets
//! no limit to the step (design, numerics §1).

use crate::model::Model;
use crate::skin::{Grip, Skin};
use crate::solid::SolidState;
use meniscus_elastic::{Elastic, ElasticError, ElasticState, Linearisation, Reach, StiffnessBlock, System};
use meniscus_numerics::Vector;
use meniscus_numerics::linalg::SolveError;
use meniscus_numerics::mesh::SurfaceMesh;
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::sync::Arc;

/// What a cell gives way, over what a face does, that is nothing: a pocket with no way out but through so little of a solid's
/// surface could have any pressure.
const SLIGHT: f64 = 1e-3;
/// Time, s, over which held vertices have their velocity at the start.
const INSTANT: f64 = 1e-9;

/// Widths of the blocks, doubling from one cell, in which it is asked how a solid gives way.
const WIDTHS: u32 = 5;

/// A cell, and which degrees of freedom flow into it, how much.
type Flow = (u32, Vec<(u32, f64)>);

/// Where a solid that deforms is, and how it moves.
#[derive(Clone, Debug)]
pub struct Soft<const D: usize> {
    /// Positions and velocities of its mesh's vertices.
    pub body: ElasticState<D>,
    /// Its surface there.
    pub skin: Arc<Skin<D>>,
    /// What the contacts that its vertices rest on accelerated each by in the last step, m/s².
    pub held: Vec<Vector<D>>,
}

impl<const D: usize> PartialEq for Soft<D> {
    fn eq(&self, other: &Self) -> bool {
        self.body == other.body && self.held == other.held
    }
}

/// The matrix `A` of a solid for a step.
#[derive(Debug)]
pub struct SoftSystem<const D: usize> {
    matrix: System<D>,
    /// Mass of each vertex, kg.
    masses: Vec<f64>,
    /// The part of it that other forces than the solid's own add.
    extra: Vec<StiffnessBlock<D>>,
}

/// Those of all solids; none of a rigid one.
pub type Systems<const D: usize> = Vec<Option<SoftSystem<D>>>;

/// Factorises the matrices of the solids that deform where they are now, for forces that act for `h` seconds; `stiffness` is what
/// other forces add to each.
///
/// # Errors
/// [`SolveError::Indefinite`] with the number of the solid whose matrix has no factors.
pub fn systems<const D: usize>(
    model: &Model<D>,
    solids: &[SolidState<D>],
    stiffness: Vec<Vec<StiffnessBlock<D>>>,
    h: f64,
) -> Result<Systems<D>, SolveError> {
    let of = |((number, now), extra): ((usize, &SolidState<D>), Vec<_>)| {
        let Some((elastic, soft)) = model.solids[number].elastic().zip(now.soft.as_ref()) else {
            return Ok(None);
        };
        let matrix = elastic.system(&soft.body.positions, h, &extra);
        let matrix = matrix.map_err(|_| SolveError::Indefinite { solid: number, step: h })?;
        Ok(Some(SoftSystem { matrix, masses: elastic.masses().to_vec(), extra }))
    };
    solids.par_iter().enumerate().zip(stiffness).map(of).collect()
}

impl<const D: usize> SoftSystem<D> {
    /// Number of degrees of freedom.
    pub fn freedoms(&self) -> usize {
        D * self.masses.len()
    }

    /// `A⁻¹ x` of `count` vectors one after another, in place.
    pub fn solve_many(&self, x: &mut [f64], count: usize) {
        self.matrix.solve_many(x, count);
    }

    /// What is needed to solve for the degrees of freedom that flow into cells.
    pub fn reach(&self, flows: &[Flow]) -> Reach {
        let all = flows.iter().flat_map(|(_, flow)| flow);
        let vertices: BTreeSet<u32> = all.map(|(k, _)| k / D as u32).collect();
        self.matrix.reach(vertices.into_iter())
    }

    /// `A⁻¹ x` of these degrees of freedom, in place; `x` is 0 for all others.
    pub fn solve_within(&self, reach: &Reach, x: &mut [f64]) {
        self.matrix.solve_within(reach, x, 1);
    }

    /// The part of a solid's velocity that a step does not resolve, m/s.
    pub fn fast(&self, elastic: &Elastic<D>, body: &ElasticState<D>) -> Vec<Vector<D>> {
        elastic.fast(&self.matrix, body)
    }

    /// `A v`, N s: the impulses that bring changes of velocity, m/s.
    pub fn impulses(&self, velocities: &[Vector<D>]) -> Vec<Vector<D>> {
        let mut impulses = vec![Vector::zeros(); velocities.len()];
        self.matrix.matrix().add_product(velocities, &mut impulses);
        impulses
    }

    /// The system about `velocities` that a solid has come to which started with `body` and unresolved velocities `fast`, and
    /// what is wrong with them, N s, if `impulses` are those of all forces but its own.
    ///
    /// # Errors
    /// [`ElasticError`].
    pub fn about(
        self,
        elastic: &Elastic<D>,
        (body, fast): (&ElasticState<D>, &[Vector<D>]),
        impulses: &[Vector<D>],
        velocities: &[Vector<D>],
    ) -> Result<(Self, Vec<Vector<D>>), ElasticError> {
        let Self { matrix, masses, extra } = self;
        let step = matrix.step();
        // Its memory is that of the next.
        drop(matrix);
        let start = Linearisation { state: body, fast, extra: &extra, step };
        let (matrix, wrong) = elastic.relinearised(&start, impulses, velocities)?;
        Ok((Self { matrix, masses, extra }, wrong))
    }

    /// `A⁻¹ x` of vectors, in place.
    pub fn solve_vectors(&self, x: &mut [Vector<D>]) {
        self.matrix.solve_vectors(x);
    }

    /// What each cell by itself would give way if the vertices were loose, a bound of `F M⁻¹ Fᵀ` by the sums of its rows, times
    /// the share of that which they are loose. `place` tells where a cell is.
    pub fn porous(&self, flows: &[Flow], reach: &Reach, place: impl Fn(u32) -> [usize; D]) -> Vec<f64> {
        let mut sums = vec![0.0; self.freedoms()];
        flows.iter().flat_map(|(_, flow)| flow).for_each(|(k, v)| sums[*k as usize] += v.abs());
        let entry = |(k, v): &(u32, f64)| v.abs() * sums[*k as usize] / self.masses[*k as usize / D];
        let all: Vec<f64> = flows.iter().map(|(_, flow)| flow.iter().map(entry).sum()).collect();
        let loose = self.looseness(flows, reach, place);
        all.into_iter().map(|give| if give < SLIGHT { 0.0 } else { give * loose }).collect()
    }

    /// What pressures give way to over what they would if the vertices were loose: the mean over pushes to and fro in blocks of
    /// 1 to 16 cells. Stiff sheets bend under wide ones only (design, numerics §1: as if loose up to a bending stiffness of some
    /// hundred, as if rigid from 10⁵ on).
    fn looseness(&self, flows: &[Flow], reach: &Reach, place: impl Fn(u32) -> [usize; D]) -> f64 {
        let n = self.freedoms();
        // Both sides of a sheet are pushed the same way.
        let sides = flows.iter().map(|(cell, flow)| {
            let along = |a: usize| flow.iter().filter(|(k, _)| *k as usize % D == a).map(|f| f.1).sum();
            let total = Vector::<D>::from_fn(|a, _| along(a));
            (place(*cell), total[total.iamax()].signum(), flow)
        });
        let sides: Vec<_> = sides.collect();
        let mut pushes = vec![0.0; WIDTHS as usize * n];
        for (width, push) in pushes.chunks_exact_mut(n).enumerate() {
            for (at, side, flow) in &sides {
                let even = at.iter().map(|i| i >> width).sum::<usize>() % 2 == 0;
                let sign = if even { *side } else { -side };
                flow.iter().for_each(|(k, v)| push[*k as usize] += sign * v);
            }
        }
        let mut gives = pushes.clone();
        self.matrix.solve_within(reach, &mut gives, WIDTHS as usize);
        let ratio = |(push, gives): (&[f64], &[f64])| {
            let held: f64 = push.iter().zip(gives).map(|(f, x)| f * x).sum();
            let loose: f64 = push.iter().enumerate().map(|(k, f)| f * f / self.masses[k / D]).sum();
            if loose > 0.0 { held / loose } else { 1.0 }
        };
        let all = pushes.chunks_exact(n).zip(gives.chunks_exact(n));
        all.map(ratio).sum::<f64>() / f64::from(WIDTHS)
    }
}

impl<const D: usize> Soft<D> {
    /// The solid at the start.
    pub fn start(elastic: &Elastic<D>, velocity: &Vector<D>) -> Self {
        let mut body = elastic.at_rest(INSTANT);
        let free = body.velocities.iter_mut().zip(elastic.held()).filter(|(_, held)| !**held);
        free.for_each(|(v, _)| *v = *velocity);
        Self::of(elastic, body)
    }

    /// The solid as a checkpoint has it: [`crate::Simulation::resume`] gives it its surface.
    pub fn bare(body: ElasticState<D>, held: Vec<Vector<D>>) -> Self {
        Self { body, skin: Arc::new(Skin::new(SurfaceMesh::default(), Vec::new())), held }
    }

    /// The solid in a state of its own.
    pub fn of(elastic: &Elastic<D>, body: ElasticState<D>) -> Self {
        let (surface, vertices) = elastic.mesh().surface();
        let skin = Arc::new(Skin::new(surface, vertices).at(&body.positions));
        let held = vec![Vector::zeros(); body.positions.len()];
        Self { body, skin, held }
    }

    /// The same with its surface.
    pub fn dressed(self, elastic: &Elastic<D>) -> Self {
        Self { held: self.held, ..Self::of(elastic, self.body) }
    }

    /// Moves it by its velocity.
    pub fn advance(&mut self, elastic: &Elastic<D>, dt: f64) {
        elastic.advance_positions(&mut self.body, dt);
        self.skin = Arc::new(self.skin.at(&self.body.positions));
    }

    /// Where the point of its surface nearest to `x` was at the start, m, and its normal there.
    pub fn at_start(&self, elastic: &Elastic<D>, x: &Vector<D>) -> Option<(Vector<D>, Vector<D>)> {
        let rest = &elastic.mesh().positions;
        let grip = self.skin.grip(x)?;
        let corners = grip.vertices.map(|v| rest[v as usize]);
        let normal = meniscus_numerics::mesh::surface::area_vector(&corners);
        Some((grip.mean(|k| rest[k]), normal.normalize()))
    }

    /// Centre of mass, m, and its velocity, m/s.
    pub fn means(&self, elastic: &Elastic<D>) -> (Vector<D>, Vector<D>) {
        let masses = elastic.masses();
        let mass: f64 = masses.iter().sum();
        let mean = |of: &[Vector<D>]| of.iter().zip(masses).map(|(x, m)| x * (m / mass)).sum();
        (mean(&self.body.positions), mean(&self.body.velocities))
    }
}

impl<const D: usize> SolidState<D> {
    /// Adds what gravity (m/s²) and its own forces do to its velocity in the time of `system`, if it deforms.
    pub fn accelerate(&mut self, elastic: &Elastic<D>, system: &SoftSystem<D>, gravity: &Vector<D>) {
        if let Some(soft) = &mut self.soft {
            let weight: Vec<Vector<D>> = elastic.masses().iter().map(|m| gravity * *m).collect();
            soft.body.velocities = elastic.free_velocities(&system.matrix, &soft.body, &weight);
        }
        self.follow(elastic);
    }

    /// Adds to its velocity what impulses (N s) where it is gripped do, if it deforms.
    pub fn push(&mut self, elastic: &Elastic<D>, system: &SoftSystem<D>, grips: &[(Grip<D>, Vector<D>)]) {
        let Some(soft) = &mut self.soft else { return };
        let mut steps = vec![Vector::zeros(); soft.body.velocities.len()];
        spread(grips, &mut steps);
        system.solve_vectors(&mut steps);
        soft.body.velocities.iter_mut().zip(steps).for_each(|(v, step)| *v += step);
        self.follow(elastic);
    }
}

/// Adds impulses where a solid is gripped to those of its vertices.
pub fn spread<const D: usize>(grips: &[(Grip<D>, Vector<D>)], vertices: &mut [Vector<D>]) {
    for (grip, impulse) in grips {
        let corners = grip.vertices.iter().zip(grip.weights);
        corners.for_each(|(vertex, weight)| vertices[*vertex as usize] += impulse * weight);
    }
}
