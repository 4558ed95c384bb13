//! Advection of the interface in a prescribed flow, without forces.

use crate::components::tracking::restore_volume;
use crate::model::Model;
use crate::simulation::diagnostics::update_diagnostics;
use crate::simulation::transport::{move_interface, restore_signed_distance};
use crate::simulation::workspace::Workspace;
use crate::simulation::{Compiled, LiquidRegion, Simulation};
use crate::solid::Solids;
use crate::state::State;
use meniscus_numerics::Vector;
use meniscus_numerics::grid::Segment;

/// A liquid carried by a prescribed velocity, for tests of the advection.
pub struct PrescribedFlow<const D: usize> {
    /// The fixed parameters.
    pub model: Model<D>,
    /// The evolving state.
    pub state: State<D>,
    workspace: Workspace<D>,
}

impl<const D: usize> PrescribedFlow<D> {
    /// The liquid within the zero level set of a signed distance.
    pub fn new(mut model: Model<D>, signed_distance: &(dyn Fn(&Vector<D>) -> f64 + Sync)) -> Self
    where
        Simulation<D>: Compiled<D>,
    {
        // The momentum of a prescribed flow is not corrected.
        model.numerics.restore_momentum = false;
        let Simulation { model, mut state, .. } =
            Simulation::new(model, &[LiquidRegion { signed_distance, velocity: Vector::zeros() }]);
        let workspace = Workspace::new(&model, &mut state);
        Self { model, state, workspace }
    }

    /// Moves the interface for `dt` (s) in a steady flow (m/s) and redistances φ as a step does. With `volume`, it restores the volume,
    /// too.
    pub fn step(&mut self, flow: &dyn Fn(&Vector<D>) -> Vector<D>, dt: f64, volume: bool) {
        let (model, state, work) = (&self.model, &mut self.state, &mut self.workspace);
        for a in 0..D {
            let faces = model.grid.face_lattice(a);
            for (i, u) in state.velocity.axes[a].iter_mut().enumerate() {
                *u = flow(&model.grid.face_center(a, faces.coordinates(i)))[a];
            }
        }
        let (solids, surfaces) = (state.solids.clone(), work.surfaces.clone());
        let at_rest = Solids { model, states: &solids, surfaces: &surfaces };
        let before = move_interface(state, work, at_rest, dt);
        restore_signed_distance(model, state, work);
        let faces: [Vec<Segment>; D] = std::array::from_fn(|a| work.liquid.faces(&model.grid, a));
        work.known_faces.clear_marks();
        work.known_faces.set_liquid_faces(faces);
        let targets = volume.then(|| restore_volume(model, state, work, &before, dt).target_volumes);
        update_diagnostics(model, state, work);
        for (drop, target) in state.components.iter_mut().zip(targets.into_iter().flatten()) {
            drop.target_volume = target;
        }
        state.time += dt;
        state.step += 1;
        state.last_dt = dt;
    }
}
