//! Diagnostics of a state: volume, momentum and energy.

use super::repairs::Repairs;
use super::workspace::{Workspace, component_bounds};
use crate::components::moments::Moments;
use crate::components::momentum::{MomentumTargets, combined};
use crate::components::restoration::restore_momentum;
use crate::components::tracking::ComponentChange;
use crate::flow::pressure::{FlowSolves, divergence_max};
use crate::free_surface::curvature::Curvature;
use crate::free_surface::dual_cell::DualCell;
use crate::free_surface::interface_faces::{InterfaceFace, interface_faces};
use crate::model::Model;
use crate::solid::Solids;
use crate::state::{Component, State};
use meniscus_elastic::{Elastic, ElasticState};
use meniscus_numerics::grid::Segment;
use meniscus_numerics::{Vector, par};

/// Sums over the whole liquid. In 2D everything is per metre of depth.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnostics<const D: usize> {
    /// Volume, m³.
    pub volume: f64,
    /// Target volume, m³.
    pub target_volume: f64,
    /// Sum of the absolute volume errors of the components over the total volume, with the sign of the net error. An excess of
    /// one component does not cancel a deficit of another.
    pub volume_error: f64,
    /// Centre of mass, m.
    pub centroid: Vector<D>,
    /// Momentum, kg m/s.
    pub momentum: Vector<D>,
    /// Angular momentum about the origin, kg m²/s; in 2D only the last entry.
    pub angular_momentum: [f64; 3],
    /// Kinetic energy of the liquid and of dynamic solids, J.
    pub kinetic_energy: f64,
    /// Surface tension times effective surface area, J.
    pub surface_energy: f64,
    /// Elastic energy of deformable solids at the time of the velocities, J.
    pub elastic_energy: f64,
    /// Smallest ratio of the volume (2D: area) of an element to that at rest, not positive if one is inverted; `None` without
    /// deformable solids.
    pub least_element: Option<f64>,
    /// Potential energy −mass × gravity · centre of mass of the liquid and of dynamic solids, J.
    pub potential_energy: f64,
    /// Largest velocity component of the liquid, m/s.
    pub max_speed: f64,
    /// Largest divergence in a liquid cell, 1/s.
    pub divergence_max: f64,
}

/// Report of an accepted step.
#[derive(Clone, Debug, PartialEq)]
pub struct StepReport<const D: usize> {
    /// Step length, s.
    pub dt: f64,
    /// Courant number: `dt/Δ` times the larger of the liquid's largest velocity component and the speed of the
    /// fastest solid, before the step.
    pub cfl: f64,
    /// The linear solves, those of the last Newton iteration if there are any.
    pub solves: FlowSolves,
    /// Newton iterations for solids and pressure; 0 if the motion of all solids is prescribed.
    pub newton_iterations: u64,
    /// Repairs of the step, and how often it was halved and repeated.
    pub repairs: Repairs,
    /// Diagnostics after the step.
    pub diagnostics: Diagnostics<D>,
}

impl<const D: usize> StepReport<D> {
    /// Iterations of the pressure solves together.
    pub fn iterations(&self) -> usize {
        self.solves.pressure.iter().map(|solve| solve.iterations).sum()
    }
}

/// Surface energy over surface tension, m² (2D: m).
pub fn effective_surface_area<const D: usize>(model: &Model<D>, dual_cells: &[DualCell]) -> f64 {
    dual_cells.iter().map(|c| c.area - c.young_cosine * c.wetted_area).sum::<f64>() * model.grid.face_area()
}

/// Kinetic energy `½ ρ ∫ u²` of the liquid, J, with the moments of each component scaled to its volume.
pub fn kinetic_energy<const D: usize>(model: &Model<D>, moments: &[Moments<D>], volumes: &[f64]) -> f64 {
    let energies = moments.iter().zip(volumes).map(|(m, volume)| m.scaled_to_mass(*volume).energy);
    0.5 * model.density * energies.flatten().sum::<f64>()
}

/// Measures the components of the liquid.
pub fn measure_components<const D: usize>(
    model: &Model<D>,
    work: &Workspace<D>,
    interface_faces: &[InterfaceFace],
    moments: &[Moments<D>],
    change: &ComponentChange<D>,
) -> Vec<Component<D>> {
    let label = work.liquid.component_lookup(&model.grid);
    let half = 0.5 * model.grid.dx;
    let mut components: Vec<Component<D>> = component_bounds(model, &work.liquid)
        .into_iter()
        .zip(moments)
        .enumerate()
        .map(|(c, ((low, high), m))| {
            let motion = m.scaled_to_mass(change.target_volumes[c]).rigid_motion(change.centers[c]);
            Component {
                target_volume: change.target_volumes[c],
                volume: change.volumes[c],
                centroid: motion.center,
                // The box of the cell centres is extended to a side next to it; the loop below extends it to the interface.
                lower: low.map(|x| if x < 1.5 * half { 0.0 } else { x }),
                upper: Vector::from_fn(|a, _| {
                    let side = model.grid.domain_upper()[a];
                    if high[a] > side - 1.5 * half { side } else { high[a] }
                }),
                velocity: motion.velocity,
                angular_momentum_per_density: motion.angular_momentum_per_density,
            }
        })
        .collect();
    for f in interface_faces {
        let Some(c) = label(f.cell) else { continue };
        let drop = &mut components[c as usize];
        let x = model.grid.center(model.grid.lattice().coordinates(f.cell))[f.axis];
        let surface = x + f.sign * f.theta * model.grid.dx;
        drop.lower[f.axis] = drop.lower[f.axis].min(surface);
        drop.upper[f.axis] = drop.upper[f.axis].max(surface);
    }
    components
}

/// Largest velocity component on the liquid's faces, m/s.
pub fn max_velocity_component<const D: usize>(
    model: &Model<D>,
    state: &State<D>,
    work: &Workspace<D>,
) -> f64 {
    (0..D)
        .map(|a| {
            let row = model.grid.face_lattice(a).extent[0];
            let values = &state.velocity.axes[a];
            let stretch = |s: &Segment| {
                values[s.row * row + s.start..s.row * row + s.end].iter().fold(0.0f64, |m, v| m.max(v.abs()))
            };
            let segments = &work.known_faces.liquid_faces()[a];
            par::reduce(segments.len(), 1, 0.0, |i| stretch(&segments[i]), f64::max)
        })
        .fold(0.0, f64::max)
}

/// Potential energy of the liquid and of dynamic solids, J.
pub fn potential_energy<const D: usize>(model: &Model<D>, state: &State<D>) -> f64 {
    let liquid_energy = |d: &Component<D>| -d.target_volume * model.gravity.dot(&d.centroid);
    let solids = model.solids.iter().zip(&state.solids).filter(|(s, _)| !s.kind.is_prescribed());
    let solids: f64 =
        solids.map(|(s, now)| -s.mass_properties.mass * model.gravity.dot(&now.center_of_mass())).sum();
    model.density * state.components.iter().map(liquid_energy).sum::<f64>() + solids
}

/// Kinetic, elastic and surface energy of the liquid and of dynamic solids, J.
pub fn energy_without_gravity<const D: usize>(model: &Model<D>, state: &State<D>) -> f64 {
    total_kinetic_energy(model, state)
        + elastic_energy(model, state)
        + model.surface_tension * state.effective_surface_area
}

/// Elastic energy of the solids at the time of the velocities, J. A step conserves its sum with their kinetic energy
/// (`meniscus_elastic::IncrementalPotential`).
fn elastic_energy<const D: usize>(model: &Model<D>, state: &State<D>) -> f64 {
    let energy = |(elastic, now): (&Elastic<D>, &ElasticState<D>)| {
        let mut ahead = now.clone();
        elastic.advance_positions(&mut ahead, state.velocity_lead);
        elastic.elastic_energy(&ahead.positions)
    };
    model.deformable_solids(&state.solids).map(energy).sum()
}

/// [`Diagnostics::least_element`].
fn least_element<const D: usize>(model: &Model<D>, state: &State<D>) -> Option<f64> {
    let solids = model.deformable_solids(&state.solids);
    solids.map(|(elastic, now)| elastic.min_volume_ratio(&now.positions)).reduce(f64::min)
}

/// Kinetic energy of the liquid and of dynamic solids, J.
fn total_kinetic_energy<const D: usize>(model: &Model<D>, state: &State<D>) -> f64 {
    let solids = model.solids.iter().zip(&state.solids).filter(|(s, _)| !s.kind.is_prescribed());
    state.kinetic_energy + solids.map(|(s, now)| s.kinetic_energy(now)).sum::<f64>()
}

/// Updates components and energies of a new state. The velocity must be known on the liquid's faces.
pub fn update_diagnostics<const D: usize>(model: &Model<D>, state: &mut State<D>, work: &Workspace<D>) {
    let change = ComponentChange::unchanged(model, state, work);
    let flat = Curvature::unknown();
    let interface_faces = interface_faces(model, &state.phi, &work.band, &flat, &work.cut_cells);
    let targets = MomentumTargets { groups: &[], ..change.momentum_targets(0.0) };
    let moments = restore_momentum(model, state, work, &interface_faces, &targets).moments;
    state.components = measure_components(model, work, &interface_faces, &moments, &change);
    state.kinetic_energy = kinetic_energy(model, &moments, &change.target_volumes);
    state.effective_surface_area = effective_surface_area(model, &change.dual_cells);
}

/// Diagnostics of a state.
pub fn diagnostics<const D: usize>(
    model: &Model<D>,
    state: &State<D>,
    work: &Workspace<D>,
) -> Diagnostics<D> {
    let components = &state.components;
    let all = combined(components.iter().map(Component::rigid_motion));
    let mass = model.density * all.volume;
    let excess = || components.iter().map(|d| d.volume - d.target_volume);
    let absolute_error = excess().map(f64::abs).sum::<f64>().copysign(excess().sum());
    Diagnostics {
        volume: components.iter().map(|d| d.volume).sum(),
        target_volume: all.volume,
        volume_error: absolute_error / all.volume.max(f64::MIN_POSITIVE),
        centroid: all.center,
        momentum: all.velocity * mass,
        angular_momentum: all.angular_momentum_about(&Vector::zeros()).map(|l| model.density * l),
        kinetic_energy: total_kinetic_energy(model, state),
        surface_energy: model.surface_tension * state.effective_surface_area,
        elastic_energy: elastic_energy(model, state),
        least_element: least_element(model, state),
        potential_energy: potential_energy(model, state),
        max_speed: max_velocity_component(model, state, work),
        divergence_max: divergence_max(
            Solids { model, states: &state.solids, surfaces: &work.surfaces },
            state,
            &work.liquid,
            &work.cut_cells,
        ),
    }
}
