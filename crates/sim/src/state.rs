//! The state of a simulation: everything that evolves.

use crate::collision::potential::slips::Slips;
use crate::components::group::RigidMotion;
use crate::solid::SolidState;
use meniscus_numerics::Vector;
use meniscus_numerics::grid::{CellField, FaceField, Grid};
use serde::{Deserialize, Serialize};

/// All data that a time step reads and updates. Plain data: a state that is written to a checkpoint and read back has the same bits.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State<const D: usize> {
    /// Time, s.
    pub time: f64,
    /// Steps done.
    pub step: u64,
    /// Length of the last step, s (0 before the first).
    pub last_dt: f64,
    /// Velocity lead: time by which the velocity is ahead of the positions, s; half a step if the step length is constant.
    pub velocity_lead: f64,
    /// Impulse time of the last step: time for which its forces acted, s.
    pub impulse_time: f64,
    /// Largest length of the next step, s: within it no solids collide and no element inverts.
    pub collision_free_dt: f64,
    /// Estimated displacement of the interface since the last redistancing of the whole band, in cells.
    pub displacement_since_redistancing: f64,
    /// Level set: signed distance to the liquid's surface, m, negative in the liquid; valid in the narrow band, ± its width elsewhere.
    pub phi: CellField<D>,
    /// Velocity, m/s; valid in the liquid and a few cells around it.
    pub velocity: FaceField<D>,
    /// Pressure impulse `p h/ρ` of the liquid cells for the impulse time `h`, m²/s: the initial guess of the next solve.
    pub pressure_impulse: CellField<D>,
    /// The connected components of the liquid, in order of their first cell.
    pub components: Vec<Component<D>>,
    /// The solids, in the order of the model.
    pub solids: Vec<SolidState<D>>,
    /// Elastic slips of friction between solids in contact.
    pub elastic_slips: Slips<D>,
    /// Lost volume, m³ (2D: m²), since the start. It grows only when no liquid is left: the volume of a
    /// component that vanishes goes to the nearest one.
    pub lost_volume: f64,
    /// Volume that has left through open sides, m³ (2D: m²), since the start.
    pub outflow_volume: f64,
    /// Kinetic energy of the volume that has left, J (2D: J per metre).
    pub outflow_kinetic_energy: f64,
    /// Surface and gravitational energy of the volume that has left, J (2D: J per metre).
    pub outflow_stored_energy: f64,
    /// Kinetic energy of the liquid, J (2D: J per metre).
    pub kinetic_energy: f64,
    /// Surface energy over surface tension, m² (2D: m).
    pub effective_surface_area: f64,
}

/// A connected component of the liquid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Component<const D: usize> {
    /// Target volume, m³ (2D: m²).
    pub target_volume: f64,
    /// Measured volume, m³ (2D: m²).
    pub volume: f64,
    /// Centre of mass, m, of the volume within the interface. If nothing touches the component, it moves with `velocity` alone.
    pub centroid: Vector<D>,
    /// Lower corner of the bounding box, m.
    pub lower: Vector<D>,
    /// Upper corner of the bounding box, m.
    pub upper: Vector<D>,
    /// Mean velocity, m/s.
    pub velocity: Vector<D>,
    /// Angular momentum about the centre of mass over the liquid's density, m⁵/s (2D: m⁴/s, in the last entry).
    pub angular_momentum_per_density: [f64; 3],
}

/// The values of the dense fields of a [`State`].
pub(crate) struct DenseFields<const D: usize> {
    phi: Vec<f64>,
    velocity: [Vec<f64>; D],
    pressure_impulse: Vec<f64>,
}

impl<const D: usize> Component<D> {
    /// Rigid motion of the component.
    pub(crate) fn rigid_motion(&self) -> RigidMotion<D> {
        RigidMotion {
            volume: self.target_volume,
            center: self.centroid,
            velocity: self.velocity,
            angular_momentum_per_density: self.angular_momentum_per_density,
        }
    }
}

impl<const D: usize> State<D> {
    /// Counts a component that the grid no longer resolves as outflow through an open side. Its surface energy is unknown and
    /// counts as zero.
    pub(crate) fn record_component_outflow(
        &mut self,
        component: &Component<D>,
        density: f64,
        gravity: &Vector<D>,
    ) {
        let mass = density * component.target_volume;
        self.outflow_volume += component.target_volume;
        self.outflow_kinetic_energy += 0.5 * mass * component.velocity.norm_squared();
        self.outflow_stored_energy -= mass * gravity.dot(&component.centroid);
    }

    /// Takes the dense fields out, so that the rest can be copied at a cost that does not follow the size of the grid.
    pub(crate) fn take_fields(&mut self) -> DenseFields<D> {
        DenseFields {
            phi: std::mem::take(&mut self.phi.data),
            velocity: self.velocity.axes.each_mut().map(std::mem::take),
            pressure_impulse: std::mem::take(&mut self.pressure_impulse.data),
        }
    }

    /// Puts the dense fields back.
    pub(crate) fn put_fields(&mut self, fields: DenseFields<D>) {
        self.phi.data = fields.phi;
        self.velocity.axes = fields.velocity;
        self.pressure_impulse.data = fields.pressure_impulse;
    }

    /// Energy that has left through open sides, J (2D: J per metre).
    pub fn outflow_energy(&self) -> f64 {
        self.outflow_kinetic_energy + self.outflow_stored_energy
    }

    /// Pressure in a liquid cell, Pa, for the given density of the liquid, kg/m³.
    pub fn pressure(&self, density: f64, cell: usize) -> f64 {
        self.pressure_impulse.data[cell] * density / self.impulse_time
    }

    /// An empty state: no liquid, at rest, at time zero.
    pub fn empty(grid: Grid<D>) -> Self {
        Self {
            time: 0.0,
            step: 0,
            last_dt: 0.0,
            velocity_lead: 0.0,
            impulse_time: 0.0,
            collision_free_dt: f64::INFINITY,
            displacement_since_redistancing: 0.0,
            phi: CellField::new(grid, 0.0),
            velocity: FaceField::zeros(grid),
            pressure_impulse: CellField::new(grid, 0.0),
            components: Vec::new(),
            solids: Vec::new(),
            elastic_slips: Slips::new(),
            lost_volume: 0.0,
            outflow_volume: 0.0,
            outflow_kinetic_energy: 0.0,
            outflow_stored_energy: 0.0,
            kinetic_energy: 0.0,
            effective_surface_area: 0.0,
        }
    }
}
