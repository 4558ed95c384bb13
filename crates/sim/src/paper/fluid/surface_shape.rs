//! Curvatures of the liquid's surface, from above the solids that it meets.
//!
//! ```text
//! x_φ = x − φ n,    κ(x_φ) by linear interpolation of the curvatures at the cells around
//! ```
//!
//! Within solids the surface is continued as it is above ([`super::continuation`]). A point of the surface nearer to a solid than two cells
//! is moved along the surface away from it, so that no stencil reaches into the solid. Limit: the curvature does not vary over the last
//! two cells.

use super::curvature::curvature;
use meniscus_numerics::grid::{Grid, Sampler};
use meniscus_numerics::{Matrix, Vector};

/// Height, in cells, above solids from which curvatures are taken.
const CLEARANCE_CELLS: f64 = 2.0;
/// Longest way along the surface to there, in cells.
const MAX_WAY_CELLS: f64 = 5.0;
/// Distance from the surface, in cells, beyond which a moved point is given up: the surface is not as flat as that.
const MAX_MISS_CELLS: f64 = 0.5;
/// Length of the projection of a unit direction onto the surface below which it has no direction in it.
const MIN_TANGENT: f64 = 1e-3;
/// Projections of a point onto the surface.
const PROJECTIONS: usize = 3;

/// Signed distance to the nearest solid, m, negative inside, and its normal out of the solid.
pub type SolidSide<'a, const D: usize> = &'a (dyn Fn(&Vector<D>) -> (f64, Vector<D>) + Sync);

/// The liquid's surface, and the solids beside it.
#[derive(Clone, Copy)]
pub struct SurfaceShape<'a, const D: usize> {
    /// The grid.
    pub grid: &'a Grid<D>,
    /// The level set, m: a distance, continued into solids.
    pub phi: Sampler<'a, D>,
    /// Distance to solids, and their normal.
    pub side: SolidSide<'a, D>,
}

impl<const D: usize> SurfaceShape<'_, D> {
    /// The level set and its gradient at a point (m), by differences of linear interpolants over a cell.
    fn value_and_normal(&self, x: &Vector<D>) -> (f64, Vector<D>) {
        let half = 0.5 * self.grid.dx;
        let slope: Vector<D> = Vector::from_fn(|a, _| {
            let step: Vector<D> = Vector::from_fn(|b, _| if a == b { half } else { 0.0 });
            (self.phi.linear(&(x + step)) - self.phi.linear(&(x - step))) / (2.0 * half)
        });
        (self.phi.linear(x), slope.try_normalize(0.0).unwrap_or(Vector::zeros()))
    }

    /// The closest point of the surface, m, and the normal out of the liquid there.
    fn on_surface(&self, x: &Vector<D>) -> (Vector<D>, Vector<D>) {
        let mut at = *x;
        for _ in 0..PROJECTIONS {
            let (value, normal) = self.value_and_normal(&at);
            at -= normal * value;
        }
        (at, self.value_and_normal(&at).1)
    }

    /// A point of the surface near that closest to `x` (m), clear of solids if the surface leads away from them.
    fn clear_point(&self, x: &Vector<D>) -> Vector<D> {
        let (at, normal) = self.on_surface(x);
        let (distance, away) = (self.side)(&at);
        let missing = CLEARANCE_CELLS * self.grid.dx - distance;
        if missing <= 0.0 {
            return at;
        }
        let along = away - normal * away.dot(&normal);
        let Some(direction) = along.try_normalize(MIN_TANGENT) else { return at };
        let way = (missing / along.norm()).min(MAX_WAY_CELLS * self.grid.dx);
        let moved = self.on_surface(&(at + direction * way)).0;
        let is_on_surface = self.phi.linear(&moved).abs() < MAX_MISS_CELLS * self.grid.dx;
        if is_on_surface && (self.side)(&moved).0 > distance { moved } else { at }
    }

    /// Whether the surface closest to `x` (m) is outside solids, or leads out of them along its tangent.
    pub fn leaves_solid(&self, x: &Vector<D>) -> bool {
        let (at, normal) = self.on_surface(x);
        let (distance, away) = (self.side)(&at);
        if distance >= 0.0 {
            return true;
        }
        let along = away - normal * away.dot(&normal);
        let Some(direction) = along.try_normalize(MIN_TANGENT) else { return false };
        let emerged = at - direction * (distance / along.norm());
        self.phi.linear(&emerged).abs() < MAX_MISS_CELLS * self.grid.dx
    }

    /// Mean of a quantity of cells around a point (m), by the weights of linear interpolation.
    fn interpolate<T>(&self, x: &Vector<D>, of: impl Fn([isize; D]) -> T, mut add: impl FnMut(f64, T)) {
        let place: Vector<D> =
            Vector::from_fn(|a, _| x[a] / self.grid.dx + self.grid.margin_cells[a][0] as f64 - 0.5);
        for corner in 0..1usize << D {
            let bit = |a: usize| (corner >> a) & 1;
            let weight = |a: usize| {
                let upper = place[a] - place[a].floor();
                if bit(a) == 1 { upper } else { 1.0 - upper }
            };
            let cell = std::array::from_fn(|a| {
                let last = self.grid.cells[a] as isize - 1;
                (place[a].floor() as isize + bit(a) as isize).clamp(0, last)
            });
            add((0..D).map(weight).product(), of(cell));
        }
    }

    /// Mean curvature of the surface, the sum of the principal ones, 1/m, near the point of it closest to `x` (m).
    pub fn curvature(&self, x: &Vector<D>) -> f64 {
        let mut sum = 0.0;
        let at = self.clear_point(x);
        self.interpolate(&at, |cell| curvature(&self.phi, self.grid.dx, cell), |weight, k| sum += weight * k);
        sum
    }

    /// Normal of the surface out of the liquid at the point closest to `x` (m), and the curvature, 1/m, of its section along a unit
    /// direction projected onto it, positive where it bends towards the liquid.
    pub fn bend(&self, x: &Vector<D>, direction: &Vector<D>) -> (Vector<D>, f64) {
        let (_, normal) = self.on_surface(x);
        let at = self.clear_point(x);
        let across = self.value_and_normal(&at).1;
        let along = direction - across * across.dot(direction);
        let tangent = along.try_normalize(MIN_TANGENT).unwrap_or(Vector::zeros());
        let mut bend = 0.0;
        self.interpolate(
            &at,
            |cell| tangent.dot(&(self.second_derivatives(cell) * tangent)),
            |weight, k| bend += weight * k,
        );
        let most = 1.0 / self.grid.dx;
        (normal, bend.clamp(-most, most))
    }

    /// Second derivative of the level set along a unit direction near a point (m), 1/m, from the bend of the surface.
    pub fn second_derivative(&self, x: &Vector<D>, direction: &Vector<D>) -> f64 {
        let normal = self.value_and_normal(x).1;
        self.bend(x, direction).1 * (1.0 - normal.dot(direction).powi(2))
    }

    /// Second derivatives of the level set at a cell, 1/m, by central differences.
    fn second_derivatives(&self, at: [isize; D]) -> Matrix<D> {
        let value = |steps: [(usize, isize); 2]| {
            let mut cell = at;
            steps.iter().for_each(|(a, step)| cell[*a] += step);
            self.phi.value(cell)
        };
        let square = self.grid.dx * self.grid.dx;
        Matrix::from_fn(|a, b| {
            if a == b {
                return (value([(a, 1), (a, 0)]) - 2.0 * self.phi.value(at) + value([(a, -1), (a, 0)]))
                    / square;
            }
            let along = |i: isize| value([(a, i), (b, 1)]) - value([(a, i), (b, -1)]);
            0.25 * (along(1) - along(-1)) / square
        })
    }
}
