//! Grid faces that contact lines on several solids drag, as masses between liquid and solids.

use meniscus_numerics::Vector;

/// A liquid face that contact lines couple to solids.
///
/// Its velocity is `u = m (u* − g + Σ_s d_s a_s·V)`. Here `d_s` is the drag of the line on solid `s` over the face's mass,
/// `m = 1/(1 + Σ_s d_s)` the mobility, `a_s·V` the velocity of that solid along the face's axis in terms of its nodes, and `g` the
/// gradient of the pressure impulse. The solid receives the impulse `M d_s (u − a_s·V)`, with the mass `M` of the face. Lagged velocities
/// of the solids are unstable for light solids (added mass). Therefore `u` is eliminated, and `V` is solved for with the pressure. The
/// flux of the face is `α m Σ_s d_s a_s`, and its mass matrix `M Σ_s d_s (a_s a_sᵀ − m Σ_r d_r a_s a_rᵀ)` is positive semidefinite.
#[derive(Clone, Debug)]
pub struct TiedFace<const D: usize> {
    /// Index among the dragged faces.
    pub dragged_face: usize,
    /// Adjacent liquid cells: +1 if the face is their upper face, −1 if it is their lower one.
    pub cells: Vec<(u32, f64)>,
    /// Open fraction `α` of the face.
    pub open_fraction: f64,
    /// Mobility `m`.
    pub mobility: f64,
    /// Mass `M`, kg.
    pub mass: f64,
    /// The movable solids.
    pub solids: Vec<TiedSolid<D>>,
}

/// A solid that is coupled to a face.
#[derive(Clone, Debug)]
pub struct TiedSolid<const D: usize> {
    /// Index among the face's drags.
    pub drag_index: usize,
    /// Drag `d_s`.
    pub drag: f64,
    /// Weights `a_s` of the nodes' velocities in the solid's velocity along the axis.
    pub node_weights: Vec<(usize, Vector<D>)>,
}

impl<const D: usize> TiedSolid<D> {
    /// The solid's velocity along the axis, m/s.
    pub fn velocity(&self, nodes: &[Vector<D>]) -> f64 {
        self.node_weights.iter().map(|(node, w)| w.dot(&nodes[*node])).sum()
    }
}

impl<const D: usize> TiedFace<D> {
    /// Calls `f` with each entry of the mass matrix, kg.
    pub fn masses(&self, mut f: impl FnMut(&TiedSolid<D>, &TiedSolid<D>, f64)) {
        for (s, one) in self.solids.iter().enumerate() {
            for (r, other) in self.solids.iter().enumerate() {
                let own = if s == r { one.drag } else { 0.0 };
                f(one, other, self.mass * (own - self.mobility * one.drag * other.drag));
            }
        }
    }
}
