//! Points of all solids' surfaces, and what moves them.
//!
//! A solid that deforms moves with the nodes of its mesh, a rigid one with two: its velocity, and its angular velocity (2D: the
//! first component). Points are functions of the nodes' velocities `v`: `x + a v` of a vertex, `c + a v + exp(a ω) r` of a point
//! of a rigid solid.

use crate::model::Model;
use crate::solid::{Motion, SolidState};
use meniscus_contact::{CollisionMesh, Plane};
use meniscus_elastic::Assembly;
use meniscus_numerics::Vector;
use std::collections::BTreeMap;

/// Reach of the barrier, in cells: two surfaces in contact are within half a cell of each other, so that the grid does not see the gap
/// between them.
pub const BARRIER_REACH_CELLS: f64 = 0.25;
/// What a point is part of.
#[derive(Clone, Copy, Debug)]
pub enum PointOwner<const D: usize> {
    /// A vertex of a solid that deforms: its node.
    Vertex {
        /// Number of the solid.
        solid: usize,
        /// Number of the vertex in its mesh.
        vertex: usize,
    },
    /// A place of a rigid solid at the start.
    Rigid {
        /// Number of the solid.
        solid: usize,
        /// Where it was at the start, m.
        at: Vector<D>,
    },
}

impl<const D: usize> PointOwner<D> {
    /// Number of the solid.
    pub fn solid(&self) -> usize {
        match self {
            Self::Vertex { solid, .. } | Self::Rigid { solid, .. } => *solid,
        }
    }
}

/// A point and something without facets that it may touch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum SdfPair {
    /// A point and a part of a rigid solid.
    Rigid(u32, usize, usize),
    /// A point and a side of the domain.
    Side(u32, usize),
}

impl SdfPair {
    /// The point.
    pub fn point(&self) -> u32 {
        match *self {
            Self::Rigid(p, ..) | Self::Side(p, _) => p,
        }
    }

    /// The other solid; none of a side.
    pub fn solid(&self) -> Option<usize> {
        match *self {
            Self::Rigid(_, solid, _) => Some(solid),
            Self::Side(..) => None,
        }
    }
}

/// The points of a model's solids.
#[derive(Clone, Debug, Default)]
pub struct CollisionPoints<const D: usize> {
    /// Their surfaces: facets of those that deform, and points of the others.
    pub surface: CollisionMesh<D>,
    /// What each point is part of.
    pub owners: Vec<PointOwner<D>>,
    /// The first node of each solid.
    pub first_node: Vec<usize>,
    /// Which nodes have velocities that are told.
    pub prescribed_nodes: Vec<bool>,
    /// Pressure of each solid's weight on one of the `2 D` sides of its surface, and that which takes the kinetic energy of the fastest
    /// start within the barrier's reach, Pa; 0 of those that are told.
    pub weight_pressures: Vec<f64>,
    /// Mean area of one of the `2 D` sides of each solid's surface, m² (2D: m).
    pub mean_side_areas: Vec<f64>,
    /// Closed sides of the domain.
    pub domain_sides: Vec<Plane<D>>,
    /// Distance, m, that is added to that of a point and something without facets, where they touch or overlap at the start (a solid
    /// on the floor; one that is held within a rigid solid).
    pub(super) gap_offsets: BTreeMap<SdfPair, f64>,
    /// Which points of each rigid solid may meet each other one.
    pub(super) probe_sets: BTreeMap<(usize, usize), ProbeSet>,
    /// Points of rigid solids at edges and corners, or with a ball around them.
    pub(super) exposed: Vec<bool>,
    /// How the solids' matrices stand in one; none where memory does not suffice.
    pub assembly: Option<Assembly>,
}

/// Which points of a rigid solid may meet another one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ProbeSet {
    /// All of them: of two solids it is the smaller one.
    All,
    /// Those at edges and corners only: what glides along a wide face meets that by its own points.
    Exposed,
    /// None: the other one is round, this one is convex, and the distances of the other's centres are enough.
    None,
}

impl<const D: usize> CollisionPoints<D> {
    /// Distance, m, that counts as none between a point and something without facets.
    pub fn thickness(&self, meeting: &SdfPair) -> f64 {
        self.surface.radius(meeting.point()) - self.gap_offsets.get(meeting).copied().unwrap_or(0.0)
    }

    /// Whether a point may meet a rigid solid: not one of its own, and not where both stay or go as told.
    pub fn may_collide(&self, model: &Model<D>, point: u32, solid: usize) -> bool {
        let owner = &self.owners[point as usize];
        if owner.solid() == solid || model.solids[solid].motion.is_prescribed() && self.is_prescribed(point) {
            return false;
        }
        match self.probe_sets.get(&(owner.solid(), solid)) {
            Some(ProbeSet::None) => false,
            Some(ProbeSet::Exposed) => self.exposed[point as usize],
            Some(ProbeSet::All) | None => true,
        }
    }

    /// Whether a point stays or goes as told.
    pub fn is_prescribed(&self, point: u32) -> bool {
        self.prescribed_nodes[match self.owners[point as usize] {
            PointOwner::Vertex { solid, vertex } => self.first_node[solid] + vertex,
            PointOwner::Rigid { solid, .. } => self.first_node[solid],
        }]
    }

    /// Velocities of the nodes as solids move now.
    pub fn node_velocities(&self, model: &Model<D>, solids: &[SolidState<D>]) -> Vec<Vector<D>> {
        let mut all = Vec::with_capacity(self.node_count());
        for (_, now) in model.solids.iter().zip(solids) {
            match &now.soft {
                Some(soft) => all.extend_from_slice(&soft.state.velocities),
                None => all.extend([now.velocity, angular_to_node(&now.angular_velocity)]),
            }
        }
        all
    }

    /// Gives the solids the velocities of the nodes.
    pub fn set_node_velocities(
        &self,
        model: &Model<D>,
        solids: &mut [SolidState<D>],
        velocities: &[Vector<D>],
    ) {
        for (k, (solid, now)) in model.solids.iter().zip(solids).enumerate() {
            let own = &velocities[self.first_node[k]..];
            if let (Some(soft), Some(elastic)) = (&mut now.soft, solid.elastic()) {
                let count = soft.state.velocities.len();
                soft.state.velocities.copy_from_slice(&own[..count]);
                now.update_center_of_mass(elastic);
            } else if solid.motion == Motion::Free {
                (now.velocity, now.angular_velocity) = (own[0], angular_from_node(&own[1]));
            }
        }
    }

    /// Number of nodes.
    pub fn node_count(&self) -> usize {
        self.prescribed_nodes.len()
    }
}

/// An angular velocity as a node has it.
pub fn angular_to_node<const D: usize>(angular_velocity: &[f64; 3]) -> Vector<D> {
    Vector::from_fn(|a, _| {
        if D == 3 {
            angular_velocity[a]
        } else if a == 0 {
            angular_velocity[2]
        } else {
            0.0
        }
    })
}

/// A node's angular velocity.
pub fn angular_from_node<const D: usize>(node: &Vector<D>) -> [f64; 3] {
    if D == 3 { std::array::from_fn(|a| node[a]) } else { [0.0, 0.0, node[0]] }
}
