//! Faces of the liquid that contact lines tie to free rigid solids, in the pressure solve.
//!
//! Such a face gets the velocity `u = (u* + d w·V − g)/(1 + d)` with `d` the drag over the mass, `V` the solid's six velocities,
//! `w·V` its velocity along the face's axis, and `g` the pressure's push; the solid gets `m (d u − d w·V)`. With `V` of the step
//! before the solid were as heavy as a wall in this: the liquid that it moves hands more back than a light solid weighs, and the
//! next step more again (added mass; a box on a drop, pinned, ran away at any length of the step). So `u` is eliminated, and `V`
//! solved for with the pressure: with `J` the solid's flow into the cells, the flow through tied faces is `K = J ± α d/(1+d) w`,
//! the mass `M + Σ m d/(1+d) w wᵀ`, and the system for `λ` stays symmetric and positive.

use crate::liquid::cut_faces::CutFace;
use crate::liquid::friction::DraggedFace;
use crate::model::Model;
use crate::solid::{Motion, SolidState};
use meniscus_numerics::grid::CutCells;
use meniscus_numerics::{Matrix, Vector};
use std::collections::BTreeMap;

/// Velocities of a rigid solid, or impulses on it: of its centre and about it.
pub type Six = Vector<6>;

/// A face tied to a solid.
struct Face {
    /// Place among the dragged faces.
    number: usize,
    /// The liquid cells that it is the upper (+1) and the lower (−1) face of.
    sides: Vec<(usize, f64)>,
    /// The solid's velocity along its axis by the solid's six.
    arm: Six,
    /// Flow through it by the solid's velocity along its axis, in areas of a face.
    flow: f64,
}

/// A free rigid solid that lines tie faces to.
struct Tied {
    faces: Vec<Face>,
    /// Inverse of its mass with what is tied to it.
    lightness: Matrix<6>,
}

/// All of them, by number.
pub struct Ties {
    tied: BTreeMap<usize, Tied>,
}

impl Ties {
    /// Ties dragged faces to the free rigid solids as they move now.
    pub fn new<const D: usize>(
        model: &Model<D>,
        solids: &[SolidState<D>],
        dragged: &mut [DraggedFace],
        phi: &[f64],
        cut_cells: &CutCells<D>,
    ) -> Self {
        let mut tied: BTreeMap<usize, Vec<Face>> = BTreeMap::new();
        for (number, f) in dragged.iter_mut().enumerate() {
            let solid = f.solid as usize;
            if model.solids[solid].motion == Motion::Free {
                let at = model.grid.faces(f.axis).coordinates(f.face);
                let x = model.grid.face_center(f.axis, at);
                f.follow(solids[solid].velocity_at(&x)[f.axis]);
                let upper = model.grid.lattice().index(at);
                let lower = upper - model.grid.lattice().stride[f.axis];
                let sides = [(lower, 1.0), (upper, -1.0)].into_iter().filter(|(c, _)| phi[*c] < 0.0);
                let flow = cut_cells.open.axes[f.axis][f.face] * f.mobility() * f.hold;
                let arm = arm(&(x - solids[solid].center), f.axis);
                tied.entry(solid).or_default().push(Face { number, sides: sides.collect(), arm, flow });
            }
        }
        let weight = model.density * model.grid.cell_volume();
        let whole = |(solid, faces): (usize, Vec<Face>)| {
            let mut mass = Matrix::<6>::identity() * model.solids[solid].body.mass;
            let inertia = model.solids[solid].inverse_inertia(&solids[solid]).try_inverse()?;
            mass.fixed_view_mut::<3, 3>(3, 3).copy_from(&inertia);
            for f in &faces {
                let face = &dragged[f.number];
                mass += f.arm * f.arm.transpose() * (weight * face.mass * face.mobility() * face.hold);
            }
            Some((solid, Tied { faces, lightness: mass.try_inverse()? }))
        };
        Self { tied: tied.into_iter().filter_map(whole).collect() }
    }

    /// Inverse mass of a solid with what is tied to it, if anything is.
    pub fn lightness(&self, solid: usize) -> Option<&Matrix<6>> {
        self.tied.get(&solid).map(|t| &t.lightness)
    }

    /// Calls `f(cell, flow)` for the tied faces of a solid: flow out of the cell by the solid's six velocities.
    pub fn flows(&self, solid: usize, mut f: impl FnMut(usize, Six)) {
        for face in self.tied.get(&solid).iter().flat_map(|t| &t.faces) {
            face.sides.iter().for_each(|(cell, sign)| f(*cell, face.arm * (sign * face.flow)));
        }
    }

    /// The impulses on the solids, by number, of the liquid's motion before the pressure, the surface's tension and `bends`.
    pub fn pushes<const D: usize>(
        &self,
        model: &Model<D>,
        dragged: &[DraggedFace],
        velocity: impl Fn(&DraggedFace) -> f64,
        (cut, bends, jump): (&[CutFace], &[f64], f64),
    ) -> BTreeMap<usize, Six> {
        let weight = model.density * model.grid.cell_volume();
        let surface: BTreeMap<(usize, usize), f64> = (cut.iter().enumerate())
            .map(|(k, c)| {
                let bend = bends.get(k).copied().unwrap_or(0.0);
                ((c.axis, c.face), c.open * c.sign * (jump * c.kappa + c.theta * bend) / model.grid.dx)
            })
            .collect();
        let push = |face: &Face| {
            let f = &dragged[face.number];
            let tension = surface.get(&(f.axis, f.face)).copied().unwrap_or(0.0) * f.mobility() * f.hold;
            face.arm * (weight * (f.mass * f.given(velocity(f)) - tension))
        };
        self.tied.iter().map(|(solid, t)| (*solid, t.faces.iter().map(push).sum())).collect()
    }

    /// Adds the change of the solids' velocities to the tied faces; `velocity` adds to one face.
    pub fn carry(
        &self,
        dragged: &mut [DraggedFace],
        change: &BTreeMap<usize, Six>,
        mut velocity: impl FnMut(&DraggedFace, f64),
    ) {
        for (solid, change) in change {
            for face in self.tied.get(solid).iter().flat_map(|t| &t.faces) {
                let f = &mut dragged[face.number];
                let by = face.arm.dot(change);
                f.follow(f.of_solid + by);
                velocity(f, f.mobility() * f.hold * by);
            }
        }
    }
}

/// The velocity along an axis at a place from the centre, by a solid's six.
fn arm<const D: usize>(r: &Vector<D>, axis: usize) -> Six {
    let along = Vector::<D>::from_fn(|a, _| if a == axis { 1.0 } else { 0.0 });
    let turning = crate::exchange::moment(r, &along);
    Six::from_fn(|i, _| {
        if i < D.min(3) {
            along[i]
        } else if i < 3 {
            0.0
        } else {
            turning[i - 3]
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solid::Solid;
    use meniscus_numerics::grid::Grid;
    use meniscus_numerics::shape::Shape;

    #[test]
    fn a_light_solid_is_carried_along_and_momentum_is_kept() {
        for (density, drag) in [(1e-3, 1e3), (1.0, 1e3), (1e3, 1e3), (1e-3, 0.5)] {
            let grid = Grid::<2>::new([8; 2], 1.0);
            let shape = Shape::Ball { center: Vector::from([4.0, 4.5]), radius: 1.0 };
            let model = Model {
                surface_tension: 0.0,
                ..Model::of_test(grid, vec![Solid::new(shape, Motion::Free, density)])
            };
            let solids = vec![model.solids[0].start()];
            // The face at the ball's centre, with liquid of half a cell that moves at 1 m/s.
            let mut dragged = vec![DraggedFace::of_test(0, grid.faces(0).index([4, 4]), 0.5, drag)];
            let phi = vec![1.0; grid.lattice().len()];
            let ties = Ties::new(&model, &solids, &mut dragged, &phi, &CutCells::none(grid));
            let mut u = dragged[0].slowed(1.0);
            let pushes = ties.pushes(&model, &dragged, |_| u, (&[], &[], 0.0));
            let change = BTreeMap::from([(0, ties.lightness(0).unwrap() * pushes[&0])]);
            ties.carry(&mut dragged, &change, |_, by| u += by);
            let (mass, v) = (model.solids[0].body.mass, change[&0][0]);
            assert!((0.5 * u + mass * v - 0.5).abs() < 1e-12, "{density} {drag}: {u} {v}");
            assert!((0.5 * dragged[0].given(u) - mass * v).abs() < 1e-12, "{density} {drag}: {u} {v}");
            // With the velocity of the step's end neither overtakes the other.
            assert!(u >= v, "{density} {drag}: {u} {v}");
        }
    }
}
