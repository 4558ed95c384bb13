//! Transport: the interface and the velocity move with the liquid, and φ becomes a signed distance again.
//!
//! `∂φ/∂t + u·∇φ = 0` and `∂u/∂t + u·∇u = 0` along the paths of [`crate::flow::advection`], φ in the narrow band and `u` on the faces of
//! the new liquid. Limit: a component that no liquid can have reached is deleted, and counted.

use super::diagnostics::max_velocity_component;
use super::workspace::Workspace;
use crate::components::volume::band_labels;
use crate::flow::advection::{LiquidFaces, advect_interface, advect_velocity};
use crate::flow::paths::pack;
use crate::free_surface::curvature::InterfaceDisplacement;
use crate::free_surface::extension::extend_into_solids;
use crate::model::Model;
use crate::model::resolution::{BAND_LAYERS, BAND_WIDTH_CELLS, GRADIENT_NORM_TOLERANCE};
use crate::solid::Solids;
use crate::state::State;
use meniscus_numerics::grid::{Runs, Sampler, Segment, scatter_segments};
use meniscus_numerics::level_set::{interface_gradient_norm, redistance};
use meniscus_numerics::{Vector, par};

/// Layers of the band in which the curvature is computed.
pub const CURVATURE_LAYERS: usize = 5;
/// Displacement of the interface, in cells, after which φ is redistanced in the whole band.
const REDISTANCE_DISPLACEMENT_CELLS: f64 = 0.7;
/// Layers of the band redistanced in every step: the stencil of the curvature.
const REDISTANCE_LAYERS: usize = 6;

/// Value of φ, in cells, that deleted liquid gets: positive, which is air, and so small that φ changes as little as possible.
const RESIDUE_PHI_CELLS: f64 = 0.01;

/// Relaxation factor of redistancing within solids. No force smooths φ there, and redistancing inverts a zigzag of two cells'
/// period: with factor 1 it persists and disturbs drops at rest (u_rms 1e-2).
const SOLID_REDISTANCE_RELAXATION: f64 = 0.5;

/// Advects φ and returns the liquid cells before. `solids_before` are those before the step.
pub fn move_interface<const D: usize>(
    state: &mut State<D>,
    work: &mut Workspace<D>,
    solids_before: Solids<'_, D>,
    dt: f64,
) -> Runs {
    let model = solids_before.model;
    let values = advect_interface(model, &state.phi, &work.band, &state.velocity, &work.cut_cells, dt);
    work.keep_phi(&state.phi);
    scatter_segments(&mut state.phi.data, model.grid.cells[0], &work.band.segments, &values);
    let extended = extend_into_solids(state, &work.band, &work.cut_cells, solids_before, &work.surfaces);
    (work.non_distance_cells, work.overwritten_phi) = (extended.non_distance_cells, extended.overwritten_phi);
    let displacement_cells = max_velocity_component(model, state, work) * dt / model.grid.dx;
    state.displacement_since_redistancing += displacement_cells;
    let before = std::mem::take(&mut work.liquid);
    let old_band_cells = work.band.cells.clone();
    work.find_liquid(model, state);
    let spurious = work.find_spurious_components(model, &before, (displacement_cells + 1.0).ceil() as usize);
    if !spurious.cells.is_empty() {
        let volume = component_volumes(model, state, work);
        let sum = |some: &[u32]| some.iter().map(|c| volume[*c as usize].max(0.0)).sum::<f64>();
        work.repairs.deleted_cells += spurious.cells.len() as u64;
        work.repairs.deleted_volume += sum(&spurious.components);
        work.repairs.leaked_volume += sum(&spurious.leaked);
        spurious.cells.iter().for_each(|&c| state.phi.data[c] = RESIDUE_PHI_CELLS * model.grid.dx);
        work.find_liquid(model, state);
    }
    let limit = BAND_WIDTH_CELLS * model.grid.dx;
    for cell in old_band_cells {
        if work.band.slot(cell as usize).is_none() {
            let value = &mut state.phi.data[cell as usize];
            *value = limit.copysign(*value);
        }
    }
    before
}

/// Volumes of the components outside solids, m³ (2D: m²).
fn component_volumes<const D: usize>(model: &Model<D>, state: &State<D>, work: &Workspace<D>) -> Vec<f64> {
    let labels = band_labels(model, &work.band, &state.phi, &work.liquid);
    work.volume_correction(model, &labels).measure(&state.phi).volumes
}

/// Redistances φ near the interface in every step, in the whole band if it has moved enough or |∇φ| is wrong in 1 % of its cells.
///
/// The curvature is only as smooth as φ, and noise of the advection that persists grows: the frequency of a drop is then wrong by 5 %,
/// with redistancing in every step by 0.3 %.
pub fn restore_signed_distance<const D: usize>(model: &Model<D>, state: &mut State<D>, work: &Workspace<D>) {
    let sampler = Sampler::cells(&model.grid, &state.phi.data, model.scalar_boundary());
    let first_layer = &work.band.cells[work.band.first_layers(1)];
    let outside = |c: u32| work.cut_cells.distance_cells(c as usize) >= 0.0;
    let is_not_distance = |c: u32| {
        (interface_gradient_norm(&model.grid, &state.phi.data, &sampler, c as usize) - 1.0).abs()
            > GRADIENT_NORM_TOLERANCE
    };
    let wrong = |i: usize| (outside(first_layer[i]) && is_not_distance(first_layer[i])).then_some(());
    let count = par::filter_map(first_layer.len(), 1, wrong).len();
    let full_band = state.displacement_since_redistancing > REDISTANCE_DISPLACEMENT_CELLS
        || count * 100 > first_layer.len();
    let layers = if full_band { BAND_LAYERS } else { REDISTANCE_LAYERS };
    let values = redistance(
        &model.grid,
        &work.band,
        layers,
        &state.phi.data,
        &sampler,
        BAND_WIDTH_CELLS * model.grid.dx,
    );
    let cells =
        work.band.cells.iter().zip(values).filter(|(c, _)| work.non_distance_cells.binary_search(c).is_err());
    cells.for_each(|(&c, v)| {
        let value = &mut state.phi.data[c as usize];
        *value += if outside(c) { v - *value } else { SOLID_REDISTANCE_RELAXATION * (v - *value) };
    });
    if full_band {
        state.displacement_since_redistancing = 0.0;
    }
}

/// Displacement of the interface in a step, on the first layers of the band.
pub fn interface_displacements<const D: usize>(
    model: &Model<D>,
    state: &State<D>,
    work: &Workspace<D>,
    dt: f64,
) -> Vec<InterfaceDisplacement<D>> {
    let sampler = Sampler::cells(&model.grid, &state.phi.data, model.scalar_boundary());
    let lattice = model.grid.lattice();
    par::map_slice(&work.band.cells[work.band.first_layers(CURVATURE_LAYERS)], 1, |&c| {
        let at = lattice.coordinates(c as usize);
        let mut displacement_cells = Vector::zeros();
        for a in 0..D {
            let faces = model.grid.face_lattice(a);
            let f = faces.index(at);
            let u = 0.5 * (state.velocity.axes[a][f] + state.velocity.axes[a][f + faces.stride[a]]);
            displacement_cells[a] = u * dt / model.grid.dx;
        }
        InterfaceDisplacement {
            normal: sampler.gradient(at).try_normalize(0.0).unwrap_or(Vector::zeros()),
            displacement_cells,
        }
    })
}

/// Advects the velocity to the faces of the new liquid.
pub fn move_velocity<const D: usize>(
    model: &Model<D>,
    state: &mut State<D>,
    work: &mut Workspace<D>,
    dt: f64,
) {
    let faces: [Vec<Segment>; D] = std::array::from_fn(|a| work.liquid.faces(&model.grid, a));
    let phi = [&work.phi_before, &state.phi];
    let liquid = LiquidFaces { cells: &work.liquid, faces: &faces };
    let values = advect_velocity(model, phi, &state.velocity, liquid, &work.cut_cells, dt);
    work.known_faces.clear_with_velocity(&mut state.velocity);
    for a in 0..D {
        let lattice = model.grid.face_lattice(a);
        let packed = pack(&faces[a]);
        let starts: Vec<usize> = packed.iter().map(|s| s.start).collect();
        let index = |s: &Segment| faces[a].partition_point(|o| (o.row, o.start) < (s.row, s.start));
        par::for_each_segment(&mut state.velocity.axes[a], lattice.extent[0], &faces[a], |s, part| {
            let from = starts[index(s)];
            let mut at = lattice.coordinates(s.row * lattice.extent[0]);
            for (i, u) in part.iter_mut().enumerate() {
                at[0] = s.start + i;
                *u = if model.on_closed_side(a, at[a]) { 0.0 } else { values[a][from + i] };
            }
        });
    }
    work.known_faces.set_liquid_faces(faces);
    work.known_faces.unmark_closed_faces(&work.cut_cells.closed_faces);
}
