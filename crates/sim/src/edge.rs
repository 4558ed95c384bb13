//! Edges of solids, on which contact lines rest.
//!
//! On a sharp edge the surface of a solid has no single normal, and the energy of a line has a kink: a line rests there as long
//! as its angle, measured from the wetted side, is between Young's and that plus the turn of the normal (J. W. Gibbs;
//! J. F. Oliver, C. Huh, S. G. Mason, J. Colloid Interface Sci. 59 (1977) 568). A step of finite length crosses the kink,
//! finds the force reversed, and crosses it again: a drop on the edges of a fixed plate never came to rest, and the force on
//! the plate jumped by half of the tension. So the kink is spread over half a cell, the last before the edge: in it the cosine
//! of the angle at which a line rests goes linearly from that on the side to that on the edge, and the force of this spring is
//! taken where the line is at the end of the step (`liquid/friction.rs`).
//!
//! The turn of a smooth surface is no edge. Over a distance `s` the normal turns by `β(s) = β₀ + s κ + O(s³)`, and
//! `β₀ = 2 β(s) − β(2 s)` is the part that does not vanish with the distance. It is taken where the solid starts: what a soft
//! solid bends, and the ridge under a line, are no edges.

use crate::solid::{Solid, SolidState};
use meniscus_numerics::Vector;
use std::f64::consts::{FRAC_PI_2, PI};

/// Distance from an edge, in cells, within which a line is on it.
const REACH: f64 = 0.5;

/// A convex edge ahead of a contact line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// By how much the solid's normal turns, rad.
    turn: f64,
    /// How near it is: 0 at half a cell, 1 on it.
    near: f64,
}

impl Edge {
    /// The cosine of the angle at which a line rests that without the edge would rest at one of the cosine `even`.
    pub fn cosine(&self, even: f64) -> f64 {
        even - self.near * self.range(even)
    }

    /// The slope of that: over a cell that the line goes towards the edge.
    pub fn stiffness(&self, even: f64) -> f64 {
        self.range(even) / REACH
    }

    /// The difference of the cosines on the side and on the edge.
    fn range(&self, even: f64) -> f64 {
        let even = even.clamp(-1.0, 1.0);
        even - (even.acos() + self.turn).min(PI).cos()
    }
}

impl<const D: usize> Solid<D> {
    /// The convex edge next to a place (m) on its surface in the direction `dry` along it, where cells are `dx` m.
    pub(crate) fn edge(
        &self,
        now: &SolidState<D>,
        place: &Vector<D>,
        dry: &Vector<D>,
        dx: f64,
    ) -> Option<Edge> {
        let step = 0.01 * dx;
        let (foot, normal) = self.foot_at_start(now, place, step);
        let (behind, _) = self.foot_at_start(now, &(place - dry * (0.25 * dx)), step);
        let along = foot - behind;
        let along = (along - normal * along.dot(&normal)).try_normalize(0.0)?;
        let beyond = |way: f64| foot + along * (way * dx);
        let turn = |way: f64| {
            let there = self.shape.normal(&beyond(way), step);
            there.dot(&along).atan2(there.dot(&normal))
        };
        let turn = 2.0 * turn(REACH) - turn(2.0 * REACH);
        if turn <= 0.0 {
            return None;
        }
        // What lies beyond the edge is over the side that falls off.
        let over = self.shape.signed_distance(&beyond(REACH)) / dx / turn.min(FRAC_PI_2).sin();
        Some(Edge { turn, near: (over / REACH).clamp(0.0, 1.0) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solid::Motion;
    use meniscus_numerics::Matrix;
    use meniscus_numerics::shape::Shape;

    #[test]
    fn edges_turn_and_smooth_surfaces_do_not() {
        let (center, half_size) = (Vector::<2>::new(5.0, 5.0), Vector::<2>::new(3.0, 1.0));
        let shape = Shape::Box { center, half_size, rotation: Matrix::identity() };
        let plate = Solid::new(shape, Motion::Fixed, 1.0);
        let now = plate.start();
        let edge =
            |x: f64, dry: f64| plate.edge(&now, &Vector::<2>::new(x, 6.0), &Vector::<2>::new(dry, 0.0), 0.1);
        assert!([edge(5.0, 1.0), edge(7.98, -1.0), edge(7.92, 1.0)].iter().all(Option::is_none));
        let found = edge(7.98, 1.0).unwrap();
        assert!((found.turn - FRAC_PI_2).abs() < 1e-6 && (found.near - 0.6).abs() < 1e-6, "{found:?}");
        // On the edge a line of 60 degrees rests up to 150 degrees.
        let sharp = Edge { turn: FRAC_PI_2, near: 1.0 };
        assert!((sharp.cosine(0.5) + 0.75f64.sqrt()).abs() < 1e-12);
        let ball = Solid::new(Shape::Ball { center, radius: 1.6 }, Motion::Fixed, 1.0);
        let top = Vector::<2>::new(5.0, 6.6);
        let smooth = ball.edge(&ball.start(), &top, &Vector::<2>::new(1.0, 0.0), 0.1);
        assert!(smooth.is_none_or(|edge| edge.turn < 1e-4), "{smooth:?}");
    }
}
