//! Wetting walls: closed sides with a contact angle, as a solid around the domain.
//!
//! At 90 degrees a closed side is a mirror. For other angles the grid extends a few cells beyond the closed sides, and a fixed solid
//! fills these cells. It is one solid for all sides, so that liquid passes edges and corners as on any other solid. Solids still
//! collide with the sides themselves ([`crate::collision`]).

use super::wettability::Hysteresis;
use super::{Solid, SolidKind, Solids};
use crate::model::{Model, Wall};
use meniscus_numerics::shape::Shape;
use meniscus_numerics::{Matrix, Vector};

/// Cells of the grid beyond a closed side that wets: the reach of stencils at the side.
pub const WETTING_WALL_MARGIN_CELLS: usize = 3;
/// Length of the walls beyond open sides over the size of the domain, so that they reach beyond the grid.
const WALL_EXTENT_RATIO: f64 = 10.0;

impl<const D: usize> Model<D> {
    /// Adds closed sides with the contact angle of this cosine, a friction of the contact line, Pa s, and a hysteresis.
    /// Call this once, after all other solids are in the model: the walls are the last one. With open sides only nothing changes.
    #[must_use]
    pub fn with_wetting_walls(
        mut self,
        young_cosine: f64,
        line_friction: f64,
        hysteresis: Option<Hysteresis>,
    ) -> Self {
        let margin = std::array::from_fn(|a| {
            std::array::from_fn(|side| match self.walls[a][side] {
                Wall::Slip => WETTING_WALL_MARGIN_CELLS,
                Wall::Open => self.grid.margin_cells[a][side],
            })
        });
        self.grid = self.grid.with_margin(margin);
        if self.has_wetting_walls() {
            let solid = Solid::new(self.exterior_shape(), SolidKind::Fixed, self.density);
            self.solids.push(Solid { young_cosine, line_friction, hysteresis, ..solid });
        }
        self
    }

    /// Number of the solid that represents the closed sides, if their contact angle is not 90 degrees.
    pub fn wetting_wall_solid(&self) -> Option<usize> {
        self.solids.len().checked_sub(1).filter(|_| self.has_wetting_walls())
    }

    /// Whether the grid extends beyond closed sides.
    fn has_wetting_walls(&self) -> bool {
        let beyond = |(wall, cells): (&Wall, &usize)| *wall == Wall::Slip && *cells > 0;
        self.walls.as_flattened().iter().zip(self.grid.margin_cells.as_flattened()).any(beyond)
    }

    /// All space beyond the closed sides.
    fn exterior_shape(&self) -> Shape<D> {
        let upper = self.grid.domain_upper();
        let far = WALL_EXTENT_RATIO * upper.norm();
        let beyond = |a: usize, side: usize| if self.walls[a][side] == Wall::Open { far } else { 0.0 };
        let low = Vector::from_fn(|a, _| -beyond(a, 0));
        let high = Vector::from_fn(|a, _| upper[a] + beyond(a, 1));
        let (center, half_size) = ((low + high) * 0.5, (high - low) * 0.5);
        let inner = Shape::Box { center, half_size, rotation: Matrix::identity() };
        let along = Vector::from_fn(|a, _| if a == 0 { 1.0 } else { 0.0 });
        let all = Shape::HalfSpace { point: along * far, normal: along };
        Shape::Difference { of: Box::new(all), minus: Box::new(inner) }
    }

    /// A point, mirrored at the closed sides if it lies beyond them: the liquid starts there as at 90 degrees, so that liquid that ends
    /// at a side touches it.
    pub(crate) fn mirrored(&self, x: &Vector<D>) -> Vector<D> {
        let upper = self.grid.domain_upper();
        Vector::from_fn(|a, _| match self.walls[a] {
            [_, Wall::Slip] if x[a] > upper[a] => 2.0 * upper[a] - x[a],
            [Wall::Slip, _] if x[a] < 0.0 => -x[a],
            _ => x[a],
        })
    }
}

impl<const D: usize> Solids<'_, D> {
    /// Height of a point above a solid, m, seen from a foot on it with this normal. For the walls only the side of the foot counts:
    /// beside an edge the other side may be nearer.
    pub(crate) fn height_above(
        &self,
        solid: usize,
        foot: &Vector<D>,
        normal: &Vector<D>,
        x: &Vector<D>,
    ) -> f64 {
        match self.model.wetting_wall_solid() == Some(solid) {
            true => (x - foot).dot(normal),
            false => self.get(solid).liquid_distance(x),
        }
    }
}
