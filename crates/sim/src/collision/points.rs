//! Points on the surfaces of all solids, and the nodes that move them.
//!
//! A deformable solid moves with the vertices of its mesh as nodes. A rigid solid has two nodes: its velocity and its angular velocity
//! (2D: the first component). Positions are functions of the nodes' velocities `v`: `x + a v` for a vertex, and `c + a v + exp(a ω) r`
//! for a point of a rigid solid.

use crate::model::Model;
use crate::solid::SolidState;
use meniscus_contact::{CollisionMesh, Plane};
use meniscus_elastic::Assembly;
use meniscus_numerics::Vector;
use meniscus_numerics::mesh::volume::QuadraticFacet;
use std::collections::BTreeMap;

/// Activation distance of the barrier, in cells. The gap of surfaces in contact is then smaller than the grid resolves.
pub const BARRIER_REACH_CELLS: f64 = 0.25;
/// The owner of a point.
#[derive(Clone, Copy, Debug)]
pub enum PointOwner<const D: usize> {
    /// A vertex of a deformable solid.
    Vertex {
        /// Number of the solid.
        solid: usize,
        /// Number of the vertex in its mesh.
        vertex: usize,
    },
    /// The centre of a quadratic facet of a deformable solid.
    FacetCenter {
        /// Number of the solid.
        solid: usize,
        /// The facet, with vertices of its mesh.
        facet: QuadraticFacet,
    },
    /// A material point of a rigid solid.
    Rigid {
        /// Number of the solid.
        solid: usize,
        /// Its initial position, m.
        at: Vector<D>,
    },
}

impl<const D: usize> PointOwner<D> {
    /// Number of the solid.
    pub fn solid(&self) -> usize {
        match self {
            Self::Vertex { solid, .. } | Self::FacetCenter { solid, .. } | Self::Rigid { solid, .. } => {
                *solid
            }
        }
    }
}

/// A point and a rigid solid or side of the domain, with a signed distance instead of facets.
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

    /// The other solid; `None` for a side.
    pub fn solid(&self) -> Option<usize> {
        match *self {
            Self::Rigid(_, solid, _) => Some(solid),
            Self::Side(..) => None,
        }
    }
}

/// Collision points of a model's solids.
#[derive(Clone, Debug, Default)]
pub struct CollisionPoints<const D: usize> {
    /// The surfaces: facets of deformable solids, points of rigid ones.
    pub surface: CollisionMesh<D>,
    /// Owner of each point.
    pub owners: Vec<PointOwner<D>>,
    /// The first node of each solid.
    pub first_node: Vec<usize>,
    /// Whether each node has a prescribed velocity.
    pub prescribed_nodes: Vec<bool>,
    /// Pressure scale of each solid, Pa: its weight on one of the `2 D` sides of its surface, plus the pressure that stops the largest
    /// initial speed within the barrier's activation distance; 0 for prescribed motion.
    pub weight_pressures: Vec<f64>,
    /// Mean area of one of the `2 D` sides of each solid's surface, m² (2D: m).
    pub mean_side_areas: Vec<f64>,
    /// Closed sides of the domain.
    pub domain_sides: Vec<Plane<D>>,
    /// Offset, m, added to the distance of pairs that touch or overlap at the start (a solid on the floor, or anchored in a rigid solid).
    pub(super) gap_offsets: BTreeMap<SdfPair, f64>,
    /// Points of a rigid solid (first) that are tested against another one.
    pub(super) probe_sets: BTreeMap<(usize, usize), ProbeSet>,
    /// Whether a point lies on a sharp edge or corner, or is the centre of a ball; true for vertices.
    pub(super) exposed: Vec<bool>,
    /// Block structure of the joint matrix of all solids; `None` if it exceeds the memory.
    pub assembly: Option<Assembly>,
}

/// Which points of a rigid solid are tested against another one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ProbeSet {
    /// All: it is the smaller of the two.
    All,
    /// Only those at edges and corners: on a wide face the points of the other solid suffice.
    Exposed,
    /// None: it is convex and the other one is round, so the distances of the other's centres suffice.
    None,
}

impl<const D: usize> CollisionPoints<D> {
    /// Distance, m, of a point from a rigid solid or side that counts as contact.
    pub fn thickness(&self, meeting: &SdfPair) -> f64 {
        self.surface.radius(meeting.point()) - self.gap_offsets.get(meeting).copied().unwrap_or(0.0)
    }

    /// Whether a point may touch a rigid solid. It may not touch its own solid, nor if both have prescribed motion.
    pub fn may_collide(&self, model: &Model<D>, point: u32, solid: usize) -> bool {
        let owner = &self.owners[point as usize];
        if owner.solid() == solid || model.solids[solid].kind.is_prescribed() && self.is_prescribed(point) {
            return false;
        }
        match self.probe_sets.get(&(owner.solid(), solid)) {
            Some(ProbeSet::None) => false,
            Some(ProbeSet::Exposed) => self.exposed[point as usize],
            Some(ProbeSet::All) | None => true,
        }
    }

    /// Whether a point has prescribed motion.
    pub fn is_prescribed(&self, point: u32) -> bool {
        match self.owners[point as usize] {
            PointOwner::Vertex { solid, vertex } => self.prescribed_nodes[self.first_node[solid] + vertex],
            PointOwner::FacetCenter { solid, facet } => facet
                .center_weights()
                .all(|(vertex, _)| self.prescribed_nodes[self.first_node[solid] + vertex as usize]),
            PointOwner::Rigid { solid, .. } => self.prescribed_nodes[self.first_node[solid]],
        }
    }

    /// Current velocities of the nodes.
    pub fn node_velocities(&self, solids: &[SolidState<D>]) -> Vec<Vector<D>> {
        solids.iter().flat_map(SolidState::node_velocities).collect()
    }

    /// Sets the velocities of the solids from those of the nodes.
    pub fn set_node_velocities(
        &self,
        model: &Model<D>,
        solids: &mut [SolidState<D>],
        velocities: &[Vector<D>],
    ) {
        for ((solid, now), first) in model.solids.iter().zip(solids).zip(&self.first_node) {
            solid.set_node_velocities(now, &velocities[*first..]);
        }
    }

    /// Number of nodes.
    pub fn node_count(&self) -> usize {
        self.prescribed_nodes.len()
    }
}
