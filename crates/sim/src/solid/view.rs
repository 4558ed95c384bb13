//! Solids in a state of a simulation, and their embedding: the map from the unknowns of a solid to its surface.
//!
//! A rigid solid moves its shape as a whole. The surface of a deformable one is a mesh that moves with the vertices; it follows from
//! the state, and the workspace keeps it.

use super::description::Solid;
use super::kinematics::SolidState;
use super::surface::SolidSurface;
use crate::model::Model;
use meniscus_numerics::Vector;
use meniscus_numerics::grid::EmbeddedBoundary;
use std::ops::Deref;
use std::sync::Arc;

/// Meshed surface of each solid of a model in a state; empty for a rigid solid.
#[derive(Clone, Debug)]
pub struct SolidSurfaces<const D: usize>(Vec<Arc<SolidSurface<D>>>);

impl<const D: usize> SolidSurfaces<D> {
    /// The surfaces of solids in these states.
    pub fn new(solids: &[Solid<D>], states: &[SolidState<D>]) -> Self {
        let at_rest = |solid: &Solid<D>| Arc::new(solid.kind.rest_surface());
        let mut surfaces = Self(solids.iter().map(at_rest).collect());
        surfaces.update(states);
        surfaces
    }

    /// Moves the surfaces to these states.
    pub fn update(&mut self, states: &[SolidState<D>]) {
        for (surface, now) in self.0.iter_mut().zip(states) {
            if let Some(body) = now.as_deformable() {
                *surface = Arc::new(surface.with_positions(&body.vertices.positions));
            }
        }
    }
}

/// The solids of a model in their states.
#[derive(Clone, Copy, Debug)]
pub struct Solids<'a, const D: usize> {
    /// The model.
    pub model: &'a Model<D>,
    /// State of each solid.
    pub states: &'a [SolidState<D>],
    /// Their surfaces.
    pub surfaces: &'a SolidSurfaces<D>,
}

/// A solid in a state. It dereferences to its [`Solid`].
#[derive(Clone, Copy, Debug)]
pub struct SolidView<'a, const D: usize> {
    /// The constant properties of the solid.
    pub solid: &'a Solid<D>,
    /// Its state.
    pub state: &'a SolidState<D>,
    /// Its surface if it deforms; empty for a rigid solid.
    pub surface: &'a SolidSurface<D>,
}

impl<'a, const D: usize> Solids<'a, D> {
    /// The solid with this number.
    pub fn get(self, number: usize) -> SolidView<'a, D> {
        let Self { model, states, surfaces } = self;
        SolidView { solid: &model.solids[number], state: &states[number], surface: &surfaces.0[number] }
    }

    /// All solids in the order of the model.
    pub fn iter(self) -> impl Iterator<Item = SolidView<'a, D>> {
        (0..self.states.len()).map(move |number| self.get(number))
    }

    /// Number of the solid with the smallest signed distance to a point, as the liquid meets it.
    pub fn nearest(&self, x: &Vector<D>) -> Option<usize> {
        if self.states.len() < 2 {
            return (!self.states.is_empty()).then_some(0);
        }
        let mut nearest = (f64::INFINITY, None);
        for (number, solid) in self.iter().enumerate() {
            let [low, high] = solid.bounds();
            let box_distance = (low - x).sup(&(x - high)).sup(&Vector::zeros()).norm();
            // A point in the box may be inside it.
            if box_distance > 0.0 && box_distance - solid.padding >= nearest.0 {
                continue;
            }
            let distance = solid.liquid_distance(x);
            if nearest.1.is_none() || distance < nearest.0 {
                nearest = (distance, Some(number));
            }
        }
        nearest.1
    }

    /// Signed distance to the nearest solid as the liquid meets it, m, negative inside; infinite without solids.
    pub fn liquid_distance(&self, x: &Vector<D>) -> f64 {
        self.nearest(x).map_or(f64::INFINITY, |number| self.get(number).liquid_distance(x))
    }
}

impl<const D: usize> Deref for SolidView<'_, D> {
    type Target = Solid<D>;

    fn deref(&self) -> &Solid<D> {
        self.solid
    }
}

impl<const D: usize> SolidView<'_, D> {
    /// Signed distance to its surface, m, negative inside.
    pub fn distance(&self, x: &Vector<D>) -> f64 {
        match self.state.rigid() {
            Some(rigid) => self.shape.signed_distance(&self.to_reference(rigid, x)),
            None => self.surface.distance(x),
        }
    }

    /// Signed distance to the surface at which the liquid meets it, m, negative inside.
    pub fn liquid_distance(&self, x: &Vector<D>) -> f64 {
        self.distance(x) - self.padding
    }

    /// Outward direction from its surface, by differences over `step` (m); zero where there is none.
    pub fn normal(&self, x: &Vector<D>, step: f64) -> Vector<D> {
        if self.state.rigid().is_none() {
            return self.surface.normal(x, step);
        }
        let slope: Vector<D> = Vector::from_fn(|a, _| {
            let by = Vector::<D>::from_fn(|b, _| if a == b { step } else { 0.0 });
            self.distance(&(x + by)) - self.distance(&(x - by))
        });
        slope.try_normalize(0.0).unwrap_or(Vector::zeros())
    }

    /// Velocity of the solid at a point, m/s; that of the closest point of its surface if it deforms.
    pub fn velocity_at(&self, x: &Vector<D>) -> Vector<D> {
        match self.state.as_deformable() {
            None => self.state.as_rigid().velocity_at(x),
            Some(body) => {
                let point = self.surface.closest_point(x);
                point.map_or(body.velocity, |point| point.interpolate(|k| body.vertices.velocities[k]))
            }
        }
    }

    /// [`Self::normal`] and [`Self::velocity_at`].
    pub fn normal_and_velocity(&self, x: &Vector<D>, step: f64) -> [Vector<D>; 2] {
        if let Some(body) = self.state.as_deformable()
            && let Some((point, normal)) = self.surface.closest_point_and_normal(x, step)
        {
            return [normal, point.interpolate(|k| body.vertices.velocities[k])];
        }
        [self.normal(x, step), self.velocity_at(x)]
    }

    /// Bounding box of its surface, m.
    pub fn bounds(&self) -> [Vector<D>; 2] {
        match self.state.rigid() {
            Some(rigid) => self.rigid_bounds(rigid),
            None => self.surface.bounds(),
        }
    }

    /// The solid as cells see it, with padding; `signed_distance` is [`Self::liquid_distance`].
    pub fn embedded_boundary<'b>(
        &self,
        signed_distance: &'b (dyn Fn(&Vector<D>) -> f64 + Sync),
    ) -> EmbeddedBoundary<'b, D> {
        let [low, high] = self.bounds();
        let padding = Vector::repeat(self.padding);
        EmbeddedBoundary { signed_distance, bounds: [low - padding, high + padding] }
    }

    /// Reference position of the surface point next to `x`, m, and the reference normal there, by differences over `step` (m).
    pub(super) fn reference_point_and_normal(&self, x: &Vector<D>, step: f64) -> (Vector<D>, Vector<D>) {
        if let (Some(elastic), Some(point)) = (self.elastic(), self.surface.closest_point(x)) {
            let rest = &elastic.rest_mesh().positions;
            let corners = point.vertices.map(|v| rest[v as usize]);
            let normal = meniscus_numerics::mesh::surface::area_vector(&corners);
            return (point.interpolate(|k| rest[k]), normal.normalize());
        }
        let rigid = self.state.as_rigid();
        let at = self.to_reference(&rigid, x);
        let normal = rigid.rotation.tr_mul(&self.normal(x, step));
        (at - normal * self.shape.signed_distance(&at), normal)
    }
}
