//! Solids without liquid for the contact cases: meshes, models, and monitors.

use crate::Check;
use crate::measure::{at_least, at_most, bars};
use crate::setup::{block, unit_model, up};
use crate::soak::{EnergyLaw, EnergyMonitor};
use crate::soft::{SoftMaterial, not_made};
use meniscus_elastic::{Anchor, Elastic};
use meniscus_numerics::Vector;
use meniscus_numerics::grid::Grid;
use meniscus_numerics::mesh::{Simplex, VolumeMesh};
use meniscus_numerics::shape::Shape;
use meniscus_sim::{
    Barriers, Compiled, Diagnostics, Model, Numerics, PrescribedMotion, Simulation, Solid, SolidKind,
    StepError, Wall, overlaps,
};
use std::sync::Arc;

/// Gravity in the cases that have it.
pub const GRAVITY: f64 = 10.0;

/// The cube [−1, 1]^D with `n` cells along each axis, of simplices whose diagonals are mirrored about the middle.
pub fn cube_mesh<const D: usize>(n: [usize; D]) -> VolumeMesh<D> {
    let id = |at: &[usize; D]| (0..D).rev().fold(0, |k, a| k * (n[a] + 1) + at[a]);
    let count: usize = n.iter().map(|n| n + 1).product();
    let place = |mut k: usize| {
        Vector::<D>::from_fn(|a, _| {
            let i = k % (n[a] + 1);
            k /= n[a] + 1;
            2.0 * i as f64 / n[a] as f64 - 1.0
        })
    };
    let positions: Vec<Vector<D>> = (0..count).map(place).collect();
    let orders: &[[usize; 3]] = if D == 2 {
        &[[0, 1, 2], [1, 0, 2]]
    } else {
        &[[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]]
    };
    let mut simplices = Vec::new();
    for mut cell in 0..n.iter().product() {
        let low: [usize; D] = std::array::from_fn(|a| {
            let i = cell % n[a];
            cell /= n[a];
            i
        });
        let mirrored: [bool; D] = std::array::from_fn(|a| 2 * low[a] + 1 < n[a]);
        let start: [usize; D] = std::array::from_fn(|a| low[a] + usize::from(mirrored[a]));
        for order in orders {
            let mut at = start;
            let others = std::array::from_fn(|k| {
                let a = order[k];
                at[a] = if mirrored[a] { low[a] } else { low[a] + 1 };
                id(&at) as u32
            });
            let mut simplex = Simplex { root: id(&start) as u32, others };
            if simplex.volume(&positions) < 0.0 {
                simplex.others.swap(0, 1);
            }
            simplices.push(simplex);
        }
    }
    VolumeMesh { positions, simplices }
}

/// The same vertices with quadratic simplices twice as large; the numbers of cells must be even.
pub fn quadratic_cube_mesh<const D: usize>(n: [usize; D]) -> VolumeMesh<D> {
    cube_mesh(n.map(|n| n / 2)).subdivided()
}

/// A mesh with every vertex moved.
pub fn mapped<const D: usize>(
    mut mesh: VolumeMesh<D>,
    map: impl Fn(&Vector<D>) -> Vector<D>,
) -> VolumeMesh<D> {
    mesh.positions.iter_mut().for_each(|x| *x = map(x));
    mesh
}

/// A box of quadratic simplices.
pub fn box_mesh<const D: usize>(n: [usize; D], center: Vector<D>, half: Vector<D>) -> VolumeMesh<D> {
    mapped(quadratic_cube_mesh(n), |x| center + x.component_mul(&half))
}

/// Maps the cube [−1, 1]^D to the unit ball; concentric cubes become spheres.
pub fn cube_to_ball<const D: usize>(x: &Vector<D>) -> Vector<D> {
    let norm = x.norm();
    if norm > 0.0 { x * (x.amax() / norm) } else { Vector::zeros() }
}

/// A vector with the given first and last components; the others are those of the middle of a unit box.
pub fn point_at<const D: usize>(first: f64, last: f64) -> Vector<D> {
    Vector::from_fn(|a, _| match a {
        0 => first,
        a if a + 1 == D => last,
        _ => 0.5,
    })
}

/// A deformable solid with a coefficient of friction.
///
/// # Errors
/// The mesh makes no elastic solid.
pub fn soft<const D: usize>(
    mesh: VolumeMesh<D>,
    material: SoftMaterial,
    friction: f64,
    anchors: Vec<Anchor<D>>,
) -> Result<Solid<D>, StepError> {
    let low = mesh.positions.iter().fold(Vector::repeat(f64::INFINITY), |l: Vector<D>, x| l.inf(x));
    let high = mesh.positions.iter().fold(Vector::repeat(f64::NEG_INFINITY), |l: Vector<D>, x| l.sup(x));
    let elastic = material.elastic(mesh, anchors).map_err(not_made)?;
    let (center, half_size) = ((low + high) * 0.5, (high - low) * 0.5);
    let shape = block(center, half_size);
    let mut solid = Solid::new(shape, SolidKind::Deformable(Arc::new(elastic)), material.density);
    solid.friction = friction;
    Ok(solid)
}

/// A rigid box along the axes.
pub fn rigid_box<const D: usize>(center: Vector<D>, half_size: Vector<D>, kind: SolidKind<D>) -> Solid<D> {
    Solid::new(block(center, half_size), kind, 1.0)
}

/// A rigid half-space with its face at a height, towards the middle.
pub fn rigid_half_space<const D: usize>(height: f64, kind: SolidKind<D>) -> Solid<D> {
    let shape = Shape::HalfSpace { point: up(height), normal: up(-height.signum()) };
    Solid::new(shape, kind, 1.0)
}

/// A motion prescribed by times and displacements.
pub fn prescribed_motion<const D: usize>(keyframes: Vec<(f64, Vector<D>)>) -> SolidKind<D> {
    SolidKind::Prescribed(PrescribedMotion {
        velocity: Vector::zeros(),
        angular_velocity: [0.0; 3],
        keyframes,
    })
}

/// A domain without liquid.
pub fn simulation_without_liquid<const D: usize>(
    grid: Grid<D>,
    solids: Vec<Solid<D>>,
    gravity: Vector<D>,
    max_step: f64,
) -> Simulation<D>
where
    Simulation<D>: Compiled<D>,
{
    let model = Model {
        surface_tension: 0.0,
        gravity,
        solids,
        numerics: Numerics { max_step, ..Numerics::default() },
        ..unit_model(grid, [[Wall::Slip; 2]; D])
    };
    Simulation::new(model, &[])
}

/// Gravity along the last axis.
pub fn gravity<const D: usize>() -> Vector<D> {
    up(-GRAVITY)
}

/// Positions of the vertices of a deformable solid; none for a rigid one.
pub fn vertices<const D: usize>(simulation: &Simulation<D>, solid: usize) -> &[Vector<D>] {
    simulation.state.solids[solid].as_deformable().map_or(&[], |body| &body.vertices.positions)
}

/// Area vectors of the surface vertices of a deformable solid, m² (2D: m): the integrals of the elements' shape functions over the
/// facets. A quadratic facet gives its corners 1/6 each and its middle 4/6; in 3D it gives the middles of its edges 1/3 each. The linear
/// parts of a facet distribute theirs accordingly.
pub fn vertex_area_vectors<const D: usize>(elastic: &Elastic<D>, positions: &[Vector<D>]) -> Vec<Vector<D>> {
    let mesh = elastic.rest_mesh();
    let parents = mesh.quadratic_simplices().unwrap_or_default();
    let (corner, middle) = if D == 2 || parents.is_empty() { (1.0, 2.0) } else { (0.0, 1.0) };
    let mut shares = vec![corner; positions.len()];
    parents.iter().flat_map(|p| &p.nodes()[D + 1..]).for_each(|v| shares[*v as usize] = middle);
    let (mut surface, numbers) = mesh.surface();
    surface.positions.iter_mut().zip(&numbers).for_each(|(x, v)| *x = positions[*v as usize]);
    let mut areas = vec![Vector::zeros(); positions.len()];
    for (f, facet) in surface.facets.iter().enumerate() {
        let vertices = facet.map(|k| numbers[k as usize] as usize);
        let all: f64 = vertices.iter().map(|v| shares[*v]).sum();
        let area = surface.area_vector(f) / all;
        vertices.iter().for_each(|v| areas[*v] += area * shares[*v]);
    }
    areas
}

/// Monitors the invariants of solids: no crossing, no inversion, no gain of energy.
pub struct ContactMonitor<const D: usize> {
    barriers: Barriers<D>,
    energy: EnergyMonitor<D>,
    /// The narrowest gap so far.
    pub narrowest_gap: f64,
    /// The deepest overlap of two solids so far.
    pub deepest_overlap: f64,
    /// The smallest volume of an element so far over its rest volume.
    pub least_element_volume: f64,
    /// Number of steps.
    pub steps: u64,
}

impl<const D: usize> ContactMonitor<D> {
    /// Starts to monitor; `scale` is the energy that scales rises.
    pub fn new(model: &Model<D>, scale: f64) -> Self {
        Self {
            barriers: Barriers::of(model),
            energy: EnergyMonitor::new(model, scale),
            narrowest_gap: f64::INFINITY,
            deepest_overlap: 0.0,
            least_element_volume: f64::INFINITY,
            steps: 0,
        }
    }

    /// Observes a step; `isolated` says that there was no external work in it and the one before.
    pub fn observe(&mut self, simulation: &Simulation<D>, ledger: &Diagnostics<D>, isolated: bool) {
        let (model, solids) = (&simulation.model, &simulation.state.solids);
        self.narrowest_gap = self.narrowest_gap.min(self.barriers.narrowest_gap(model, solids));
        self.deepest_overlap =
            overlaps(simulation.solids()).iter().map(|o| o.2).fold(self.deepest_overlap, f64::max);
        self.least_element_volume =
            self.least_element_volume.min(ledger.least_element.unwrap_or(f64::INFINITY));
        self.steps += 1;
        if isolated {
            self.energy.record(simulation, ledger);
        } else {
            self.energy.reset();
        }
    }

    /// Checks that solids never touched: the narrowest gap over the size of a cell.
    pub fn check_gap(&self, case: &str, quantity: impl Into<String>, dx: f64, aim: f64) -> Check {
        at_least(case, quantity, self.narrowest_gap / dx, f64::MIN_POSITIVE, aim)
    }

    /// Checks the largest rise of the energy in an isolated step over the scale.
    pub fn check_rise(&self, case: &str, quantity: impl Into<String>) -> Check {
        at_most(case, quantity, self.law().largest, bars(1e-6, 1e-9))
    }

    /// The energy law in the isolated steps.
    pub fn law(&self) -> &EnergyLaw {
        self.energy.law()
    }
}
