//! Faces of the grid that lines of several solids drag, as masses between liquid and solids.

use meniscus_numerics::Vector;

/// A face of the liquid that contact lines tie to solids.
///
/// It gets the velocity `u = m (u* − g + Σ_s d_s a_s·V)`, with `d_s` the drag of the line on solid `s` over the face's mass,
/// `m = 1/(1 + Σ_s d_s)`, `a_s·V` that solid's velocity along the face's axis by those of its nodes, and `g` the pressure's push; the
/// solid gets `M d_s (u − a_s·V)` with `M` the face's mass. With the solids' velocities of the step before, a light solid ran away:
/// the liquid that it moves hands more back than it weighs (added mass). So `u` is eliminated, and `V` solved for with the
/// pressure: the flow through the face is `α m Σ_s d_s a_s`, the mass `M Σ_s d_s (a_s a_sᵀ − m Σ_r d_r a_s a_rᵀ)`, which is positive
/// semidefinite, and the system stays symmetric.
#[derive(Clone, Debug)]
pub struct TiedFace<const D: usize> {
    /// Place among the dragged faces.
    pub dragged_face: usize,
    /// The liquid cells that it is the upper (+1) and the lower (−1) face of.
    pub cells: Vec<(u32, f64)>,
    /// The face's open part in areas of a face, `α`.
    pub open_fraction: f64,
    /// `m`.
    pub mobility: f64,
    /// `M`, kg.
    pub mass: f64,
    /// The solids that something can move.
    pub solids: Vec<TiedSolid<D>>,
}

/// A solid that a face is tied to.
#[derive(Clone, Debug)]
pub struct TiedSolid<const D: usize> {
    /// Place among the face's holds.
    pub drag_index: usize,
    /// `d_s`.
    pub drag: f64,
    /// The solid's velocity along the axis by those of its nodes, `a_s`.
    pub node_weights: Vec<(usize, Vector<D>)>,
}

impl<const D: usize> TiedSolid<D> {
    /// The solid's velocity along the axis, m/s.
    pub fn velocity(&self, nodes: &[Vector<D>]) -> f64 {
        self.node_weights.iter().map(|(node, w)| w.dot(&nodes[*node])).sum()
    }
}

impl<const D: usize> TiedFace<D> {
    /// Calls `f` with the ends' masses for each other, kg.
    pub fn masses(&self, mut f: impl FnMut(&TiedSolid<D>, &TiedSolid<D>, f64)) {
        for (s, one) in self.solids.iter().enumerate() {
            for (r, other) in self.solids.iter().enumerate() {
                let own = if s == r { one.drag } else { 0.0 };
                f(one, other, self.mass * (own - self.mobility * one.drag * other.drag));
            }
        }
    }
}
