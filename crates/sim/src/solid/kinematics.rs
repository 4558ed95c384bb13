//! Solids: their description, state, and motion.
//!
//! A rigid solid rotates about its centre of mass. Between impulses of the liquid its angular momentum `L = I ω` is constant, while `I`
//! rotates with it: the step uses the `ω` of `L` at the midpoint, which conserves `L` exactly and the energy to second order.

use super::deformable::Soft;
use super::mass_properties::MassProperties;
use super::surface::SurfacePoint;
use super::wettability::{Hysteresis, WettabilityLayer};
use meniscus_elastic::Elastic;
use meniscus_numerics::grid::EmbeddedBoundary;
use meniscus_numerics::shape::Shape;
use meniscus_numerics::{Matrix, Vector};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A solid, rigid or deformable.
#[derive(Clone, Debug)]
pub struct Solid<const D: usize> {
    /// Shape and position at the start.
    pub shape: Shape<D>,
    /// What moves it.
    pub kind: SolidKind<D>,
    /// Initial velocity, m/s.
    pub initial_velocity: Vector<D>,
    /// Mass, centre of mass and inertia.
    pub mass_properties: MassProperties<D>,
    /// Distance outside its own surface at which the liquid meets it, m ([`Self::padded`]).
    pub padding: f64,
    /// Cosine of Young's contact angle, `(γ_sa − γ_ls)/γ_la`; beyond ±1 nothing or everything is wetted.
    pub young_cosine: f64,
    /// Layers over `young_cosine` where the cosine varies, the last on top; empty where it is uniform.
    pub pattern: Vec<WettabilityLayer<D>>,
    /// Friction of the contact line, Pa s: force per length over speed.
    pub line_friction: f64,
    /// Contact angle hysteresis; without it no contact line rests.
    pub hysteresis: Option<Hysteresis>,
    /// Coefficient of restitution, 0 to 1. For two solids the geometric mean applies, at a side of the domain that of the solid.
    pub restitution: f64,
    /// Coulomb friction coefficient, combined in the same way.
    pub friction: f64,
}

/// Thickness of a plate, in cells, from which on liquid on its two sides is resolved separately: contact angles of drops at rest are
/// then right within 0.4 degrees (1.4 with 2.25 cells, 1.9 with 2, up to 19 with 1.5).
pub const MIN_PLATE_THICKNESS_CELLS: f64 = 2.5;
/// Restitution of solids without a given value.
pub const DEFAULT_RESTITUTION: f64 = 0.3;
/// Friction of solids without a given value.
pub const DEFAULT_FRICTION: f64 = 0.3;

/// What moves a solid.
#[derive(Clone, Debug)]
pub enum SolidKind<const D: usize> {
    /// It stays at rest.
    Fixed,
    /// A prescribed motion.
    Prescribed(PrescribedMotion<D>),
    /// Rigid motion under gravity, liquid and contacts.
    Rigid,
    /// Deformation under the same and its own elastic forces.
    Deformable(Arc<Elastic<D>>),
}

impl<const D: usize> SolidKind<D> {
    /// Whether the motion does not depend on forces.
    pub fn is_prescribed(&self) -> bool {
        matches!(self, Self::Fixed | Self::Prescribed(_))
    }
}

impl<const D: usize> PartialEq for SolidKind<D> {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Fixed, Self::Fixed) | (Self::Rigid, Self::Rigid) => true,
            (Self::Prescribed(a), Self::Prescribed(b)) => a == b,
            (Self::Deformable(a), Self::Deformable(b)) => Arc::ptr_eq(a, b),
            _ => false,
        }
    }
}

/// A prescribed motion.
#[derive(Clone, Debug, PartialEq)]
pub struct PrescribedMotion<const D: usize> {
    /// Velocity, m/s, where there are no keyframes.
    pub velocity: Vector<D>,
    /// Angular velocity, rad/s (2D: the last entry).
    pub angular_velocity: [f64; 3],
    /// Time, s, and displacement from the start, m; linear in between, constant before and after. Times increase.
    pub keyframes: Vec<(f64, Vector<D>)>,
}

/// Position and motion of a solid. Plain data.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SolidState<const D: usize> {
    /// Centre of mass, m.
    pub center: Vector<D>,
    /// Rotation since the start.
    pub rotation: Matrix<D>,
    /// Velocity of the centre, m/s.
    pub velocity: Vector<D>,
    /// Angular velocity, rad/s (2D: the last entry).
    pub angular_velocity: [f64; 3],
    /// Force of the liquid's pressure in the last step, N (2D: N/m).
    pub pressure_force: Vector<D>,
    /// Force of surface tension along the contact line in the last step, N (2D: N/m).
    pub contact_line_force: Vector<D>,
    /// Acceleration by contacts in the last step, without impacts, m/s².
    pub contact_acceleration: Vector<D>,
    /// State of a deformable solid. Centre and velocity are then means, rotation and angular velocity unused.
    pub soft: Option<Soft<D>>,
}

impl<const D: usize> Solid<D> {
    /// A homogeneous solid of a density, kg/m³, at rest and with a contact angle of 90 degrees, with [`DEFAULT_RESTITUTION`] and
    /// [`DEFAULT_FRICTION`]. An unbounded solid has no finite mass to move freely: it is fixed.
    pub fn new(shape: Shape<D>, kind: SolidKind<D>, density: f64) -> Self {
        let mut mass_properties = MassProperties::homogeneous(&shape, density);
        if let SolidKind::Deformable(elastic) = &kind {
            mass_properties.mass = elastic.masses().iter().sum();
        }
        let is_massless = kind == SolidKind::Rigid && !mass_properties.mass.is_finite();
        let kind = if is_massless { SolidKind::Fixed } else { kind };
        Self {
            shape,
            kind,
            initial_velocity: Vector::zeros(),
            mass_properties,
            padding: 0.0,
            young_cosine: 0.0,
            pattern: Vec::new(),
            line_friction: 0.0,
            hysteresis: None,
            restitution: DEFAULT_RESTITUTION,
            friction: DEFAULT_FRICTION,
        }
    }

    /// Pads a plate thinner than [`MIN_PLATE_THICKNESS_CELLS`] cells of size `dx` (m): its two sides would share cells, and liquid that
    /// wets one would wet the other. The liquid meets it farther out by half of the missing `thickness` (m); its mass and its own
    /// forces are unchanged.
    pub fn padded(self, thickness: f64, dx: f64) -> Self {
        Self { padding: 0.5 * (MIN_PLATE_THICKNESS_CELLS * dx - thickness).max(0.0), ..self }
    }

    /// State at the start.
    pub fn initial_state(&self) -> SolidState<D> {
        let (velocity, angular_velocity) = match &self.kind {
            SolidKind::Prescribed(path) => (path.mean_velocity(0.0, 1e-9), path.angular_velocity),
            _ => (self.initial_velocity, [0.0; 3]),
        };
        let (center, rotation, none) = (self.mass_properties.center, Matrix::identity(), Vector::zeros());
        let (pressure_force, contact_line_force, contact_acceleration) = (none, none, none);
        let soft = self.elastic().map(|elastic| Soft::initial(elastic, &self.initial_velocity));
        let mut now = SolidState {
            center,
            rotation,
            velocity,
            angular_velocity,
            pressure_force,
            contact_line_force,
            contact_acceleration,
            soft,
        };
        self.elastic().iter().for_each(|elastic| now.update_center_of_mass(elastic));
        now
    }

    /// Signed distance to its current surface, m, negative inside.
    pub fn distance(&self, now: &SolidState<D>, x: &Vector<D>) -> f64 {
        match &now.soft {
            Some(soft) => soft.surface.distance(x),
            None => self.shape.signed_distance(&self.to_reference(now, x)),
        }
    }

    /// Signed distance to the surface at which the liquid meets it, m, negative inside.
    pub fn liquid_distance(&self, now: &SolidState<D>, x: &Vector<D>) -> f64 {
        self.distance(now, x) - self.padding
    }

    /// The elastic body, if it deforms.
    pub fn elastic(&self) -> Option<&Elastic<D>> {
        if let SolidKind::Deformable(elastic) = &self.kind { Some(elastic) } else { None }
    }

    /// Whether it moves freely as a whole.
    pub fn is_unconstrained(&self) -> bool {
        self.kind == SolidKind::Rigid
            || self.elastic().is_some_and(|elastic| !elastic.anchored().contains(&true))
    }

    /// Current position of the point of a rigid solid that was at `x` at the start, m.
    pub fn to_current(&self, now: &SolidState<D>, x: &Vector<D>) -> Vector<D> {
        now.center + now.rotation * (x - self.mass_properties.center)
    }

    /// Initial position of the point of a rigid solid that is at `x` now, m.
    pub fn to_reference(&self, now: &SolidState<D>, x: &Vector<D>) -> Vector<D> {
        self.mass_properties.center + now.rotation.tr_mul(&(x - now.center))
    }

    /// Outward direction from its surface, by differences over `step` (m); zero where there is none.
    pub fn normal(&self, now: &SolidState<D>, x: &Vector<D>, step: f64) -> Vector<D> {
        if let Some(soft) = &now.soft {
            return soft.surface.normal(x, step);
        }
        let slope: Vector<D> = Vector::from_fn(|a, _| {
            let by = Vector::<D>::from_fn(|b, _| if a == b { step } else { 0.0 });
            self.distance(now, &(x + by)) - self.distance(now, &(x - by))
        });
        slope.try_normalize(0.0).unwrap_or(Vector::zeros())
    }

    /// [`Self::normal`], and [`SolidState::velocity_at`].
    pub fn normal_and_velocity(&self, now: &SolidState<D>, x: &Vector<D>, step: f64) -> [Vector<D>; 2] {
        let surface_point =
            now.soft.as_ref().and_then(|soft| Some((soft, soft.surface.closest_point_and_normal(x, step)?)));
        match surface_point {
            Some((soft, (grip, normal))) => [normal, grip.interpolate(|k| soft.state.velocities[k])],
            None => [self.normal(now, x, step), now.velocity_at(x)],
        }
    }

    /// Largest speed of any of its points, m/s.
    pub fn max_speed(&self, now: &SolidState<D>) -> f64 {
        if let Some(soft) = &now.soft {
            return soft.state.velocities.iter().map(Vector::norm).fold(0.0, f64::max);
        }
        let [low, high] = self.bounds(now);
        let angular_speed = Vector::<3>::from(now.angular_velocity).norm();
        let reach = (low - now.center).abs().sup(&(high - now.center).abs()).norm();
        now.velocity.norm() + if angular_speed > 0.0 { angular_speed * reach } else { 0.0 }
    }

    /// Bounding box of its current surface, m.
    pub fn bounds(&self, now: &SolidState<D>) -> [Vector<D>; 2] {
        if let Some(soft) = &now.soft {
            return soft.surface.bounds();
        }
        let (low, high) = self.shape.bounds();
        if !(high - low).iter().all(|s| s.is_finite()) {
            return [low, high];
        }
        let middle = now.center + now.rotation * (0.5 * (low + high) - self.mass_properties.center);
        let reach = now.rotation.abs() * ((high - low) * 0.5);
        [middle - reach, middle + reach]
    }

    /// The solid as cells see it, with padding; `signed_distance` is [`Self::liquid_distance`] in its state.
    pub fn embedded_boundary<'a>(
        &self,
        now: &SolidState<D>,
        signed_distance: &'a (dyn Fn(&Vector<D>) -> f64 + Sync),
    ) -> EmbeddedBoundary<'a, D> {
        let [low, high] = self.bounds(now);
        let padding = Vector::repeat(self.padding);
        EmbeddedBoundary { signed_distance, bounds: [low - padding, high + padding] }
    }

    /// Current inertia matrix, kg m².
    pub fn inertia(&self, now: &SolidState<D>) -> Matrix<3> {
        let turn = embed_in_3d(&now.rotation);
        turn * self.mass_properties.inertia * turn.transpose()
    }

    /// Inverse of the current inertia matrix, 1/(kg m²).
    pub fn inverse_inertia(&self, now: &SolidState<D>) -> Matrix<3> {
        self.inertia(now).try_inverse().unwrap_or_else(Matrix::zeros)
    }

    /// Advances it from `time` by `dt` (s). The velocity of a prescribed motion is then that of the coming step, for which the liquid's
    /// is solved.
    pub fn advance(&self, now: &mut SolidState<D>, time: f64, dt: f64) {
        match &self.kind {
            SolidKind::Fixed => {}
            SolidKind::Prescribed(path) => {
                now.center = self.mass_properties.center + path.displacement(time + dt);
                now.velocity = path.mean_velocity(time + dt, dt);
                now.angular_velocity = path.angular_velocity;
                now.rotation = rotated(&now.rotation, &path.angular_velocity, dt);
            }
            SolidKind::Rigid => {
                now.center += now.velocity * dt;
                let momentum = self.angular_momentum(now);
                let mut half = now.clone();
                half.rotation = rotated(&now.rotation, &now.angular_velocity, 0.5 * dt);
                let spin: [f64; 3] = (self.inverse_inertia(&half) * momentum).into();
                now.rotation = rotated(&now.rotation, &spin, dt);
                now.angular_velocity = (self.inverse_inertia(now) * momentum).into();
            }
            SolidKind::Deformable(elastic) => {
                now.soft.iter_mut().for_each(|soft| soft.advance(elastic, dt));
                now.update_center_of_mass(elastic);
            }
        }
    }

    /// Kinetic energy, J.
    pub fn kinetic_energy(&self, now: &SolidState<D>) -> f64 {
        if let (Some(soft), Some(elastic)) = (&now.soft, self.elastic()) {
            return elastic.kinetic_energy(&soft.state.velocities);
        }
        let turning = self.angular_momentum(now).dot(&Vector::<3>::from(now.angular_velocity));
        0.5 * (self.mass_properties.mass * now.velocity.norm_squared() + turning)
    }

    /// Angular momentum about its centre of mass, kg m²/s.
    pub fn angular_momentum(&self, now: &SolidState<D>) -> Vector<3> {
        let turn = embed_in_3d(&now.rotation);
        turn * (self.mass_properties.inertia * (turn.transpose() * Vector::<3>::from(now.angular_velocity)))
    }
}

impl<const D: usize> SolidState<D> {
    /// Closest point of its surface to `x`, if it deforms.
    pub fn surface_point(&self, x: &Vector<D>) -> Option<SurfacePoint<D>> {
        self.soft.as_ref()?.surface.closest_point(x)
    }

    /// Points of its surface within a radius (m) around `x` and their weights, if it deforms.
    pub fn surface_patch(&self, x: &Vector<D>, radius: f64) -> Vec<(SurfacePoint<D>, f64)> {
        self.soft.as_ref().map_or_else(Vec::new, |soft| soft.surface.patch(x, radius))
    }

    /// Sets all its velocities to zero.
    pub fn stop(&mut self) {
        (self.velocity, self.angular_velocity) = (Vector::zeros(), [0.0; 3]);
        self.soft.iter_mut().for_each(|soft| soft.state.velocities.fill(Vector::zeros()));
    }

    /// Updates centre and velocity to those of its mass, if it deforms.
    pub fn update_center_of_mass(&mut self, elastic: &Elastic<D>) {
        if let Some(soft) = &self.soft {
            (self.center, self.velocity) = soft.center_of_mass_and_velocity(elastic);
        }
    }

    /// Velocity of the solid at a point, m/s.
    pub fn velocity_at(&self, x: &Vector<D>) -> Vector<D> {
        if let Some((soft, grip)) = self.soft.as_ref().zip(self.surface_point(x)) {
            return grip.interpolate(|k| soft.state.velocities[k]);
        }
        let arm = Vector::<3>::from_fn(|a, _| if a < D { x[a] - self.center[a] } else { 0.0 });
        let turning = Vector::<3>::from(self.angular_velocity).cross(&arm);
        self.velocity + Vector::from_fn(|a, _| turning[a])
    }
}

impl<const D: usize> PrescribedMotion<D> {
    /// Mean velocity over `dt` from `time`, m/s.
    pub fn mean_velocity(&self, time: f64, dt: f64) -> Vector<D> {
        (self.displacement(time + dt) - self.displacement(time)) / dt
    }

    /// Displacement from the start at a time, m.
    pub fn displacement(&self, time: f64) -> Vector<D> {
        let frames = &self.keyframes;
        let Some(first) = frames.first() else { return self.velocity * time };
        let k = frames.partition_point(|f| f.0 <= time);
        if k == 0 {
            return first.1;
        }
        let (from, Some(to)) = (&frames[k - 1], frames.get(k)) else { return frames[k - 1].1 };
        from.1 + (to.1 - from.1) * ((time - from.0) / (to.0 - from.0))
    }
}

/// A rotation in the plane as one in space.
fn embed_in_3d<const D: usize>(rotation: &Matrix<D>) -> Matrix<3> {
    let own = |r: usize, c: usize| f64::from(u8::from(r == c));
    Matrix::<3>::from_fn(|r, c| if r < D && c < D { rotation[(r, c)] } else { own(r, c) })
}

/// `rotation` followed by a rotation at `angular_velocity` for `dt`.
fn rotated<const D: usize>(rotation: &Matrix<D>, angular_velocity: &[f64; 3], dt: f64) -> Matrix<D> {
    let turn = nalgebra::Rotation3::new(Vector::<3>::from(*angular_velocity) * dt).into_inner();
    Matrix::<D>::from_fn(|r, c| turn[(r, c)]) * rotation
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tumbling_box_keeps_momentum_and_energy() {
        let shape = Shape::Box {
            center: Vector::<3>::zeros(),
            half_size: Vector::<3>::new(0.5, 0.3, 0.1),
            rotation: Matrix::identity(),
        };
        let solid = Solid::new(shape, SolidKind::Rigid, 1.0);
        let mut now = solid.initial_state();
        // Rotation about the middle axis is unstable: the box flips over and over.
        now.angular_velocity = [0.01, 1.0, 0.02];
        let energy =
            |now: &SolidState<3>| solid.angular_momentum(now).dot(&Vector::<3>::from(now.angular_velocity));
        let (momentum, start) = (solid.angular_momentum(&now), energy(&now));
        let mut lowest = 1.0f64;
        for step in 0..4000 {
            solid.advance(&mut now, step as f64 * 0.02, 0.02);
            lowest = lowest.min(now.rotation[(1, 1)]);
            assert!((solid.angular_momentum(&now) - momentum).norm() < 1e-11 * momentum.norm());
            assert!((energy(&now) / start - 1.0).abs() < 2e-3, "{}", energy(&now) / start);
        }
        assert!(lowest < -0.9, "it never flipped: {lowest}");
        assert!((now.rotation.transpose() * now.rotation - Matrix::identity()).norm() < 1e-10);
    }

    #[test]
    fn keyframes_are_met() {
        let path = PrescribedMotion {
            velocity: Vector::<2>::zeros(),
            angular_velocity: [0.0; 3],
            keyframes: vec![(1.0, Vector::<2>::new(0.0, 0.0)), (3.0, Vector::<2>::new(0.4, -0.2))],
        };
        assert_eq!(path.displacement(0.0), Vector::<2>::zeros());
        assert!((path.displacement(2.0) - Vector::<2>::new(0.2, -0.1)).norm() < 1e-15);
        assert_eq!(path.displacement(9.0), Vector::<2>::new(0.4, -0.2));
        let shape = Shape::Ball { center: Vector::<2>::new(0.5, 0.5), radius: 0.1 };
        let solid = Solid::new(shape, SolidKind::Prescribed(path), 1.0);
        let mut now = solid.initial_state();
        solid.advance(&mut now, 2.5, 0.25);
        assert!((solid.distance(&now, &(now.center + Vector::<2>::new(0.3, 0.0))) - 0.2).abs() < 1e-12);
        assert!((now.center - Vector::<2>::new(0.85, 0.325)).norm() < 1e-3, "{}", now.center);
    }
}
