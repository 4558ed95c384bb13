//! Joint response `A⁻¹` of all movable solids to impulses, where `A` is the Hessian of the step's potential.

use super::tied_face::{TiedFace, TiedSolid};
use crate::coupling::impulses::CouplingImpulses;
use crate::model::Model;
use crate::solid::surface::distribute_to_vertices;
use crate::solid::{Solid, SolidState, angular_to_node};
use meniscus_elastic::{AssemblyInverse, Reach};
use meniscus_numerics::Vector;
use std::collections::{BTreeMap, BTreeSet};

use super::points::CollisionPoints;
use crate::contact_line::friction::DraggedFace;

/// Lumped compliance of a cell, relative to a full grid face, below which it counts as zero: a pocket that is closed but for so small a
/// part of a solid's surface could have any pressure.
const MIN_COMPLIANCE_RATIO: f64 = 1e-3;
/// Number of block widths, doubling from one cell, for which the compliance is measured.
const BLOCK_WIDTH_COUNT: u32 = 5;

/// A cell, and the degrees of freedom whose velocities make up the flux out of it, with their weights.
pub type FluxRow = (u32, Vec<(u32, f64)>);

/// Response of all solids.
#[derive(Debug)]
pub struct SolidResponse<const D: usize> {
    solution: AssemblyInverse<D>,
    /// The first node of each solid.
    first_node: Vec<usize>,
    /// Mass of each node, kg; moment of inertia of an angular velocity, kg m².
    masses: Vec<f64>,
    /// Whether each node belongs to a rigid solid.
    rigid: Vec<bool>,
    /// Loads at the velocities about which the response is linearised.
    loads: BaseLoads<D>,
}

/// Impulses and prescribed velocity changes of the nodes apart from the pressure.
#[derive(Debug)]
pub struct BaseLoads<const D: usize> {
    /// Impulses on the nodes, N s.
    pub impulses: Vec<Vector<D>>,
    /// Prescribed minus current velocities of the prescribed nodes, m/s.
    pub prescribed_change: Vec<Vector<D>>,
    /// Faces that contact lines tie to solids.
    pub ties: Vec<TiedFace<D>>,
}

impl<const D: usize> SolidResponse<D> {
    /// Response with the inverse matrix `solution`, about the velocities that have these loads.
    pub fn new(
        model: &Model<D>,
        solids: &[SolidState<D>],
        points: &CollisionPoints<D>,
        solution: AssemblyInverse<D>,
        loads: BaseLoads<D>,
    ) -> Self {
        let pairs = model.solids.iter().zip(solids);
        let masses = pairs.flat_map(|(solid, now)| solid.node_masses(now)).collect();
        let rigid = |solid: &Solid<D>| vec![solid.elastic().is_none(); solid.node_count()];
        let rigid = model.solids.iter().flat_map(rigid).collect();
        Self { solution, first_node: points.first_node.clone(), masses, rigid, loads }
    }

    /// Response about other velocities with the same inverse matrix: `impulses` (N s) and `ties` are evaluated there. The prescribed
    /// nodes must already have their velocities.
    pub fn about(self, impulses: Vec<Vector<D>>, ties: Vec<TiedFace<D>>) -> Self {
        let prescribed_change = vec![Vector::zeros(); impulses.len()];
        Self { loads: BaseLoads { impulses, prescribed_change, ties }, ..self }
    }

    /// Number of degrees of freedom.
    pub fn dof_count(&self) -> usize {
        D * self.masses.len()
    }

    /// Whether a degree of freedom belongs to a rigid solid.
    pub fn is_rigid(&self, freedom: u32) -> bool {
        self.rigid[freedom as usize / D]
    }

    /// The first node of a solid.
    pub fn first_node(&self, solid: usize) -> usize {
        self.first_node[solid]
    }

    /// `A⁻¹ b`, in place.
    pub fn solve(&self, b: &mut [Vector<D>]) {
        self.solution.solve(b);
    }

    /// Part of the factors needed to solve for the degrees of freedom in `flows`.
    pub fn reach(&self, flows: &[FluxRow]) -> Reach {
        let all = flows.iter().flat_map(|(_, flow)| flow);
        let nodes: BTreeSet<u32> = all.map(|(k, _)| k / D as u32).collect();
        self.solution.reach(nodes.into_iter())
    }

    /// `A⁻¹ x` at these degrees of freedom, in place, for one or several vectors in sequence; `x` is 0 at all others.
    pub fn solve_within(&self, reach: &Reach, x: &mut [f64]) {
        let count = x.len() / self.dof_count();
        self.solution.solve_within(reach, x, count);
    }

    /// Diagonal approximation of `F A⁻¹ Fᵀ` for each cell: the row sums of `F M⁻¹ Fᵀ`, an upper bound, times the ratio of the actual
    /// compliance to that of free nodes. Rigid solids contribute nothing. `place` returns the coordinates of a cell.
    pub fn lumped_compliance(
        &self,
        flows: &[FluxRow],
        reach: &Reach,
        place: impl Fn(u32) -> [usize; D],
    ) -> Vec<f64> {
        let soft =
            |flow: &FluxRow| (flow.0, flow.1.iter().filter(|(k, _)| !self.is_rigid(*k)).copied().collect());
        let flows: Vec<FluxRow> = flows.iter().map(soft).collect();
        if flows.iter().all(|(_, flow)| flow.is_empty()) {
            return vec![0.0; flows.len()];
        }
        let mut sums = vec![0.0; self.dof_count()];
        flows.iter().flat_map(|(_, flow)| flow).for_each(|(k, v)| sums[*k as usize] += v.abs());
        let entry = |(k, v): &(u32, f64)| v.abs() * sums[*k as usize] / self.masses[*k as usize / D];
        let all: Vec<f64> = flows.iter().map(|(_, flow)| flow.iter().map(entry).sum()).collect();
        let loose = self.compliance_ratio(&flows, reach, place);
        all.into_iter().map(|give| if give < MIN_COMPLIANCE_RATIO { 0.0 } else { give * loose }).collect()
    }

    /// Compliance relative to that of free nodes, as the mean over pressures that alternate in sign between blocks of 1 to 16 cells.
    /// Stiff sheets of density `ρ_s` and thickness `t` bend under wide blocks only: they respond as free nodes up to a bending stiffness
    /// `h² B/(ρ_s t Δ⁴)` of some hundred, and as rigid solids from 10⁵ on.
    fn compliance_ratio(&self, flows: &[FluxRow], reach: &Reach, place: impl Fn(u32) -> [usize; D]) -> f64 {
        let n = self.dof_count();
        // Both sides of a sheet are pushed in the same direction.
        let sides = flows.iter().map(|(cell, flow)| {
            let along = |a: usize| flow.iter().filter(|(k, _)| *k as usize % D == a).map(|f| f.1).sum();
            let total = Vector::<D>::from_fn(|a, _| along(a));
            (place(*cell), total[total.iamax()].signum(), flow)
        });
        let sides: Vec<_> = sides.collect();
        let mut pushes = vec![0.0; BLOCK_WIDTH_COUNT as usize * n];
        for (width, push) in pushes.chunks_exact_mut(n).enumerate() {
            for (at, side, flow) in &sides {
                let even = at.iter().map(|i| i >> width).sum::<usize>() % 2 == 0;
                let sign = if even { *side } else { -side };
                flow.iter().for_each(|(k, v)| push[*k as usize] += sign * v);
            }
        }
        let mut gives = pushes.clone();
        self.solution.solve_within(reach, &mut gives, BLOCK_WIDTH_COUNT as usize);
        let ratio = |(push, gives): (&[f64], &[f64])| {
            let held: f64 = push.iter().zip(gives).map(|(f, x)| f * x).sum();
            let loose: f64 = push.iter().enumerate().map(|(k, f)| f * f / self.masses[k / D]).sum();
            if loose > 0.0 { held / loose } else { 1.0 }
        };
        let all = pushes.chunks_exact(n).zip(gives.chunks_exact(n));
        all.map(ratio).sum::<f64>() / f64::from(BLOCK_WIDTH_COUNT)
    }

    /// Converts coupling impulses to impulses on the nodes.
    pub fn node_impulses(
        &self,
        model: &Model<D>,
        solids: &[SolidState<D>],
        exchange: &CouplingImpulses<D>,
    ) -> Vec<Vector<D>> {
        let mut all = vec![Vector::zeros(); self.masses.len()];
        let sums = exchange.by_solid(solids.len());
        for (k, solid) in model.solids.iter().enumerate() {
            if solid.kind.is_free_rigid() {
                let about = sums[k].moment_about(&solids[k].center_of_mass());
                all[self.first_node[k]] = sums[k].linear;
                all[self.first_node[k] + 1] = angular_to_node(&about.into());
            }
        }
        for (solid, grips) in &exchange.point_impulses {
            distribute_to_vertices(grips, &mut all[self.first_node[*solid as usize]..]);
        }
        all
    }

    /// Flux rows of the tied faces: the cell, and the flow out of it per component of the nodes' velocities.
    pub fn tied_flux_rows(&self) -> Vec<FluxRow> {
        let of = |tie: &TiedFace<D>| {
            let entries = |sign: f64| {
                let of = |end: &TiedSolid<D>| {
                    let flow = sign * tie.open_fraction * tie.mobility * end.drag;
                    let entry = |(node, w): &(usize, Vector<D>)| {
                        (0..D).map(|a| ((node * D + a) as u32, flow * w[a])).collect::<Vec<_>>()
                    };
                    end.node_weights.iter().flat_map(entry).collect::<Vec<_>>()
                };
                tie.solids.iter().flat_map(of).collect::<Vec<_>>()
            };
            tie.cells.iter().map(|(cell, sign)| (*cell, entries(*sign))).collect::<Vec<_>>()
        };
        self.loads.ties.iter().flat_map(of).collect()
    }

    /// Impulses on the nodes without the pressure of the cells, N s: the base impulses, those of the tied faces with their `velocity` and
    /// the surface `tension`, and `more`.
    pub fn impulses_without_pressure(
        &self,
        model: &Model<D>,
        dragged: &[DraggedFace],
        velocity: impl Fn(&DraggedFace) -> f64,
        tension: BTreeMap<(usize, usize), f64>,
        more: Option<Vec<Vector<D>>>,
    ) -> Vec<Vector<D>> {
        let weight = model.density * model.grid.cell_volume();
        let mut impulses = self.loads.impulses.clone();
        more.iter().flatten().zip(&mut impulses).for_each(|(more, j)| *j += more);
        for tie in &self.loads.ties {
            let f = &dragged[tie.dragged_face];
            let pulled = tension.get(&(f.axis, f.face)).copied().unwrap_or(0.0) * tie.mobility;
            for end in &tie.solids {
                let push = weight
                    * (f.volume_cells * f.drags[end.drag_index].impulse_on_solid(velocity(f))
                        - pulled * end.drag);
                end.node_weights.iter().for_each(|(node, w)| impulses[*node] += w * push);
            }
        }
        impulses
    }

    /// Change of the nodes' velocities, m/s, due to these impulses and to the prescribed motion.
    pub fn velocity_change(&self, mut impulses: Vec<Vector<D>>) -> Vec<Vector<D>> {
        self.solve(&mut impulses);
        impulses.iter().zip(&self.loads.prescribed_change).map(|(c, lead)| c + lead).collect()
    }

    /// Adds the change of the nodes' velocities to the solids' velocities at tied faces. `velocity` receives the change of each face.
    pub fn update_tied_faces(
        &self,
        dragged: &mut [DraggedFace],
        change: &[Vector<D>],
        mut velocity: impl FnMut(&DraggedFace, f64),
    ) {
        for tie in &self.loads.ties {
            let f = &mut dragged[tie.dragged_face];
            let mut sum = 0.0;
            for end in &tie.solids {
                let by = end.velocity(change);
                f.drags[end.drag_index].solid_velocity += by;
                sum += end.drag * by;
            }
            velocity(f, tie.mobility * sum);
        }
    }
}
