//! Coupling of pressure and solids.
//!
//! In a liquid cell that a solid cuts, the fluxes through the open faces and into the moving surface sum to zero:
//! `Σ ± α u + ∫ v·n dS = 0`, with the velocity `v` of the surface and `n` into the solid. A free solid receives `∫ p n dS` and its moment
//! in the same solve. Let `F` map the solids' degrees of freedom to the fluxes of the cells, and `A` be the Hessian of their potential
//! ([`crate::collision`]; the mass matrix for a rigid solid without contacts). The system for `λ = p h/ρ` then gains the symmetric
//! positive semidefinite term `ρ F A⁻¹ Fᵀ`, so that light solids are as stable as heavy ones (C. Batty, F. Bertails, R. Bridson, "A fast
//! variational framework for accurate solid-fluid coupling", SIGGRAPH 2007).
//!
//! In this system a surface feels the pressure at the centre of its cell, up to half a diagonal of the cell
//! away. The gradient of a first solution gives the missing impulse on the solids
//! ([`PressureCoupling::off_center_impulses`]), which acts before a second solve.

use super::impulses::{ComponentSolid, CouplingImpulses, Impulse};
use crate::collision::solid_response::{FluxRow, SolidResponse};
use crate::model::Model;
use crate::solid::surface::SurfacePoint;
use crate::solid::{SolidState, Solids, angular_to_node};
use meniscus_numerics::grid::{CutCell, CutCells};
use meniscus_numerics::linalg::{CoupledBodies, InPlaceSolve, SparseColumn};
use meniscus_numerics::{Vector, par};
use std::collections::BTreeMap;

/// The wetted surfaces of the solids, and their motion.
pub struct PressureCoupling<'a, const D: usize> {
    model: &'a Model<D>,
    solids: &'a [SolidState<D>],
    /// Joint response of the solids, if any is movable.
    response: Option<&'a SolidResponse<D>>,
    wetted_surfaces: &'a [WettedSurface<D>],
    /// For each surface piece and tied face the cell, and the flux out of it per component of the nodes' velocities, in areas of a face.
    node_flux_rows: Vec<FluxRow>,
}

/// A piece of solid surface in a liquid cell, with the closest surface point of a deformable solid, where the pressure acts.
pub type WettedSurface<const D: usize> = (CutCell<D>, Option<SurfacePoint<D>>);

/// Solid surfaces in liquid cells (`phi` negative).
pub fn wetted_surfaces<const D: usize>(
    solids: Solids<'_, D>,
    cut_cells: &CutCells<D>,
    phi: &[f64],
) -> Vec<WettedSurface<D>> {
    let gripped = |w: &CutCell<D>| {
        let centroid = surface_centroid_cells(solids.model, w) * solids.model.grid.dx;
        (*w, solids.get(w.solid as usize).surface.closest_point(&centroid))
    };
    let cells = &cut_cells.cells;
    par::filter_map(cells.len(), 64, |i| (phi[cells[i].cell as usize] < 0.0).then(|| gripped(&cells[i])))
}

impl<'a, const D: usize> PressureCoupling<'a, D> {
    /// Coupling at these surfaces; `response` is that of the solids, if any is movable.
    pub fn new(
        model: &'a Model<D>,
        wetted_surfaces: &'a [WettedSurface<D>],
        solids: &'a [SolidState<D>],
        response: Option<&'a SolidResponse<D>>,
    ) -> Self {
        let mut coupling = Self { model, solids, response, wetted_surfaces, node_flux_rows: Vec::new() };
        coupling.node_flux_rows =
            response.map_or_else(Vec::new, |response| coupling.find_node_flux_rows(response));
        coupling
    }

    /// Calls `f(cell, flux)` with the flux into each surface, `∫ v·n dS` in areas of a face, m/s.
    pub fn for_each_flux(&self, mut f: impl FnMut(usize, f64)) {
        for (w, grip) in self.wetted_surfaces {
            let state = &self.solids[w.solid as usize];
            let flux = match (state.as_deformable(), grip) {
                (Some(body), Some(grip)) => {
                    grip.interpolate(|k| body.vertices.velocities[k]).dot(&w.area_vector)
                }
                _ => {
                    let rigid = state.as_rigid();
                    rigid.velocity.dot(&w.area_vector)
                        + Vector::<3>::from(rigid.angular_velocity).dot(&self.area_moment(w))
                }
            };
            f(w.cell as usize, flux);
        }
    }

    /// The term `ρ F A⁻¹ Fᵀ` of the pressure system.
    pub fn compliance(&self) -> Option<CoupledBodies<'_>> {
        let response = self.response?;
        let scale = (self.model.density * self.model.grid.cell_volume()).sqrt();
        let scaled =
            |(cell, flow): &FluxRow| (*cell, flow.iter().map(|(k, v)| (*k, v * scale)).collect::<Vec<_>>());
        let flux_rows: Vec<_> = self.node_flux_rows.iter().map(scaled).collect();
        if flux_rows.is_empty() {
            return None;
        }
        let lattice = self.model.grid.lattice();
        let reach = response.reach(&flux_rows);
        let lumped_compliance =
            response.lumped_compliance(&flux_rows, &reach, |cell| lattice.coordinates(cell as usize));
        let mean_pressure_probes =
            mean_pressure_probes(&flux_rows, &lumped_compliance, |k| response.is_rigid(k));
        let solve: Box<InPlaceSolve<'_>> = Box::new(move |x| response.solve_within(&reach, x));
        Some(CoupledBodies {
            dof_count: response.dof_count(),
            flux_rows,
            lumped_compliance,
            solve,
            mean_pressure_probes,
        })
    }

    /// The rows of `node_flux_rows`.
    fn find_node_flux_rows(&self, response: &SolidResponse<D>) -> Vec<FluxRow> {
        let mut flows: Vec<FluxRow> = Vec::new();
        for (w, grip) in self.wetted_surfaces {
            let solid = w.solid as usize;
            let first = (response.first_node(solid) * D) as u32;
            if let Some(grip) = grip {
                let entry = |n: usize| {
                    let (k, a) = (n / D, n % D);
                    (first + grip.vertices[k] * D as u32 + a as u32, grip.weights[k] * w.area_vector[a])
                };
                flows.push((w.cell, (0..D * D).map(entry).collect()));
            } else if self.model.solids[solid].kind.is_free_rigid() {
                let turn: Vector<D> = angular_to_node(&self.area_moment(w).into());
                let entry = |n: usize| (first + n as u32, if n < D { w.area_vector[n] } else { turn[n - D] });
                flows.push((w.cell, (0..2 * D).map(entry).collect()));
            }
        }
        flows.extend(response.tied_flux_rows());
        flows
    }

    /// Calls `f(cell, flux)` with the flux due to velocities of the nodes.
    pub fn for_each_node_flux(&self, velocities: &[Vector<D>], mut f: impl FnMut(usize, f64)) {
        for (cell, flow) in &self.node_flux_rows {
            f(
                *cell as usize,
                flow.iter().map(|(k, v)| v * velocities[*k as usize / D][*k as usize % D]).sum(),
            );
        }
    }

    /// Impulses of the pressure on the nodes, including tied faces, N s; `lambda` is `p h/ρ`.
    pub fn node_impulses(&self, lambda: &[f64]) -> Vec<Vector<D>> {
        let Some(response) = self.response else { return Vec::new() };
        let scale = self.model.density * self.model.grid.face_area();
        let mut all = vec![Vector::zeros(); response.dof_count() / D];
        for (cell, flow) in &self.node_flux_rows {
            let push = scale * lambda[*cell as usize];
            flow.iter().for_each(|(k, v)| all[*k as usize / D][*k as usize % D] += v * push);
        }
        all
    }

    /// Impulses of the pressure on the solids; `lambda` is `p h/ρ`, `label` the component of a liquid cell.
    pub fn impulses(&self, lambda: &[f64], label: impl Fn(usize) -> Option<u32>) -> CouplingImpulses<D> {
        self.collect_impulses(label, |w| {
            let push = lambda[w.cell as usize];
            (w.area_vector * push, Vector::<3>::from(w.moment) * push)
        })
    }

    /// Additional impulses because the pressure at the surfaces differs from that at the cell centres; `slope` is the gradient of
    /// `lambda` in a liquid cell, per cell.
    pub fn off_center_impulses(
        &self,
        slope: impl Fn(usize) -> Vector<D>,
        label: impl Fn(usize) -> Option<u32>,
    ) -> CouplingImpulses<D> {
        self.collect_impulses(label, |w| {
            let push = w.first_moment * slope(w.cell as usize);
            (push, to_3d(&surface_centroid_cells(self.model, w)).cross(&to_3d(&push)))
        })
    }

    /// Sums the impulses of all surfaces. `push` returns linear impulse and moment (in cells) over density and face area.
    fn collect_impulses(
        &self,
        label: impl Fn(usize) -> Option<u32>,
        push: impl Fn(&CutCell<D>) -> (Vector<D>, Vector<3>),
    ) -> CouplingImpulses<D> {
        let scale = self.model.density * self.model.grid.face_area();
        let mut exchange = CouplingImpulses::new();
        for (w, grip) in self.wetted_surfaces {
            let Some(component) = label(w.cell as usize) else { continue };
            let (linear, angular) = push(w);
            let pair = ComponentSolid { component, solid: w.solid };
            match grip {
                Some(grip) => exchange.add_at_surface_point(pair, grip, linear * scale),
                None => {
                    let angular = angular * (scale * self.model.grid.dx);
                    exchange.add(pair, &Impulse { linear: linear * scale, angular }, 1.0);
                }
            }
        }
        exchange
    }

    /// `∫ r × n dS` about the solid's centre, in areas of a face times m.
    fn area_moment(&self, w: &CutCell<D>) -> Vector<3> {
        let center = &self.solids[w.solid as usize].center_of_mass();
        Vector::<3>::from(w.moment) * self.model.grid.dx - to_3d(center).cross(&to_3d(&w.area_vector))
    }
}

/// Centroid of the solid surface in a cell, in cells.
fn surface_centroid_cells<const D: usize>(model: &Model<D>, w: &CutCell<D>) -> Vector<D> {
    let center = model.grid.center(model.grid.lattice().coordinates(w.cell as usize)) / model.grid.dx;
    center + w.first_moment.tr_mul(&w.area_vector) / w.area_vector.norm_squared().max(f64::MIN_POSITIVE)
}

/// Columns whose sums over a liquid component show whether solids determine its mean pressure: one for all deformable solids, and one for
/// each degree of freedom of the rigid ones.
fn mean_pressure_probes(flows: &[FluxRow], porous: &[f64], rigid: impl Fn(u32) -> bool) -> Vec<SparseColumn> {
    let gives = flows.iter().zip(porous).filter(|(_, porous)| **porous > 0.0);
    let mut columns = vec![gives.map(|((cell, _), _)| (*cell, 1.0)).collect()];
    let mut of_rigid: BTreeMap<u32, SparseColumn> = BTreeMap::new();
    for (cell, flow) in flows {
        for (k, v) in flow.iter().filter(|(k, _)| rigid(*k)) {
            of_rigid.entry(*k).or_default().push((*cell, *v));
        }
    }
    columns.extend(of_rigid.into_values());
    columns
}

/// Extends a vector to three dimensions.
fn to_3d<const D: usize>(v: &Vector<D>) -> Vector<3> {
    Vector::from_fn(|a, _| if a < D { v[a] } else { 0.0 })
}

/// Applies impulses to the free rigid solids.
pub fn apply_impulses_to_rigid<const D: usize>(
    model: &Model<D>,
    solids: &mut [SolidState<D>],
    exchange: &CouplingImpulses<D>,
) {
    let sums = exchange.by_solid(solids.len());
    for ((now, solid), sum) in solids.iter_mut().zip(&model.solids).zip(sums) {
        if let Some(rigid) = solid.free_rigid_mut(now) {
            rigid.velocity += sum.linear / solid.mass_properties.mass;
            let spin = Vector::<3>::from(rigid.angular_velocity)
                + solid.inverse_inertia(rigid) * sum.moment_about(&rigid.center);
            rigid.angular_velocity = spin.into();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::newton::NewtonSolver;
    use crate::collision::points::CollisionPoints;
    use crate::collision::potential::solid_terms::DeformableLoads;
    use crate::flow::pressure::{FlowSolves, Projection, ProjectionOptions};
    use crate::free_surface::curvature::Curvature;
    use crate::free_surface::interface_faces::interface_faces;
    use crate::model::resolution::BAND_WIDTH_CELLS;
    use crate::model::time_step::StepTimes;
    use crate::simulation::workspace::Workspace;
    use crate::solid::{Solid, SolidKind};
    use crate::state::State;
    use meniscus_numerics::Matrix;
    use meniscus_numerics::grid::{FaceField, Grid};
    use meniscus_numerics::shape::Shape;
    use std::f64::consts::PI;

    struct Projected<const D: usize> {
        state: State<D>,
        impulses: Vec<Impulse<D>>,
        solves: FlowSolves,
        fastest: f64,
    }

    /// One pressure solve in a unit box filled up to `height`, with the same velocity on all open faces.
    fn project<const D: usize>(
        cells: usize,
        solids: Vec<Solid<D>>,
        height: f64,
        velocity: Vector<D>,
    ) -> Projected<D> {
        let mut model = Model::of_test(Grid::new([cells; D], 1.0 / cells as f64), solids);
        (model.surface_tension, model.numerics.tolerance) = (0.0, 1e-10);
        let grid = model.grid;
        let mut state = State::empty(grid);
        state.solids = model.initial_solids();
        let limit = BAND_WIDTH_CELLS * grid.dx;
        for i in 0..grid.lattice().len() {
            let x = grid.center(grid.lattice().coordinates(i));
            state.phi.data[i] = (x[D - 1] - height).clamp(-limit, limit);
        }
        let mut work = Workspace::new(&model, &mut state);
        let flat = Curvature::unknown();
        let cut = interface_faces(&model, &state.phi, &work.band, &flat, &work.cut_cells);
        let faces = work.known_faces.liquid_faces().clone();
        let open = work.cut_cells.open_fraction.clone();
        let walk = |mut f: Box<dyn FnMut(usize, usize) + '_>| {
            for a in 0..D {
                let lattice = grid.face_lattice(a);
                for s in &faces[a] {
                    for face in s.row * lattice.extent[0] + s.start..s.row * lattice.extent[0] + s.end {
                        let shut = model.on_closed_side(a, lattice.coordinates(face)[a])
                            || open.axes[a][face] == 0.0;
                        if !shut {
                            f(a, face);
                        }
                    }
                }
            }
        };
        let mut start = state.velocity.clone();
        walk(Box::new(|a, face| start.axes[a][face] = velocity[a]));
        state.velocity = start;
        let surfaces = work.surfaces.clone();
        let solids = Solids { model: &model, states: &state.solids, surfaces: &surfaces };
        let wet = wetted_surfaces(solids, &work.cut_cells, &state.phi.data);
        let mut projection = Projection {
            velocity: &mut state.velocity,
            pressure_impulse: &mut state.pressure_impulse,
            phi: &state.phi,
            band: &work.band,
            liquid: &work.liquid,
            liquid_faces: &faces,
            interface_faces: &cut,
            dragged_faces: &mut [],
            cut_cells: &mut work.cut_cells,
            solids: &state.solids,
            wetted_surfaces: &wet,
            tension_impulse: 0.0,
            label: &|_| Some(0),
            impulse_time: 1.0,
        };
        let response = response(solids, &work.collision_points);
        let found = work
            .pressure
            .project(
                &model,
                &mut projection,
                response.as_ref(),
                ProjectionOptions { warm_start: false, tolerance: 1e-10 },
                &mut |_| (),
            )
            .unwrap();
        let impulses = found.pressure_impulses.by_solid(model.solids.len());
        apply_impulses_to_rigid(&model, &mut state.solids, &found.pressure_impulses);
        let solves = found.solves;
        let mut fastest = 0.0f64;
        walk(Box::new(|a, face| fastest = fastest.max(state.velocity.axes[a][face].abs())));
        Projected { state, impulses, solves, fastest }
    }

    /// Response of free solids without other forces.
    fn response<const D: usize>(
        solids: Solids<'_, D>,
        points: &CollisionPoints<D>,
    ) -> Option<SolidResponse<D>> {
        let times =
            StepTimes { dt: 1.0, impulse_time: 1.0, velocity_lead: 1e-9, lookahead: 1e-9, is_first: false };
        let starts: Vec<Option<DeformableLoads<D>>> = solids.iter().map(|_| None).collect();
        let slips = crate::Slips::new();
        let velocities = &points.node_velocities(solids.states);
        let from = crate::collision::newton::OldSolids { solids, velocities, elastic_slips: &slips };
        let mut descent = NewtonSolver::new(points, from, solids.states, &starts, times);
        let open = FaceField::zeros(solids.model.grid);
        solids
            .model
            .has_dynamic_solids()
            .then(|| descent.linearise(&mut solids.states.to_vec(), &mut [], &[], &open).unwrap())
    }

    fn ball<const D: usize>(radius: f64) -> Shape<D> {
        Shape::Ball { center: Vector::from_fn(|a, _| 0.49 + 0.017 * a as f64), radius }
    }

    fn volume<const D: usize>(radius: f64) -> f64 {
        if D == 2 { PI * radius * radius } else { 4.0 / 3.0 * PI * radius.powi(3) }
    }

    fn liquid_at_rest_lifts<const D: usize>() {
        // A submerged ball, and an inclined bottom.
        let slope = Vector::<D>::from_fn(|a, _| if a + 1 == D { 1.0 } else { 0.3 });
        let bottom = Shape::HalfSpace { point: Vector::from_fn(|_, _| 0.11), normal: slope };
        let solids =
            vec![Solid::new(ball(0.22), SolidKind::Fixed, 1.0), Solid::new(bottom, SolidKind::Fixed, 1.0)];
        let fall = Vector::from_fn(|a, _| if a + 1 == D { -1.0 } else { 0.0 });
        let p = project::<D>(if D == 2 { 64 } else { 40 }, solids, 0.873, fall);
        // The velocity error is the solver's tolerance, 1e-10. The cut cells' volume is second-order accurate.
        assert!(p.fastest < 1e-9, "{D}D: {}", p.fastest);
        let (volume, bar) = (volume::<D>(0.22), if D == 2 { 0.002 } else { 0.008 });
        let lift = p.impulses[0].linear;
        assert!((lift[D - 1] / volume - 1.0).abs() < bar, "{D}D: {}", lift[D - 1] / volume);
        // Sliver cells without a neighbour above or below have no pressure gradient.
        assert!((0..D - 1).all(|a| lift[a].abs() < 1e-6 * volume), "{D}D: {lift}");
        let turning = p.impulses[0].moment_about(&p.state.solids[0].center_of_mass());
        assert!(turning.norm() < 1e-4 * volume * 0.22, "{D}D: {:e}", turning.norm() / volume / 0.22);
    }

    #[test]
    fn liquid_at_rest_stays_and_lifts_a_body() {
        liquid_at_rest_lifts::<2>();
        liquid_at_rest_lifts::<3>();
    }

    /// Speed that a ball retains from its initial velocity in a shell full of liquid, and the number of iterations.
    fn kept_speed<const D: usize>(cells: usize, density: f64) -> (f64, usize) {
        let all = Shape::Box {
            center: Vector::repeat(0.5),
            half_size: Vector::repeat(1.0),
            rotation: Matrix::identity(),
        };
        let shell = Shape::Difference { of: Box::new(all), minus: Box::new(ball(0.45)) };
        let mut inner = Solid::new(ball(0.2), SolidKind::Rigid, density);
        inner.initial_velocity[0] = 1.0;
        let p =
            project::<D>(cells, vec![inner, Solid::new(shell, SolidKind::Fixed, 1.0)], 9.0, Vector::zeros());
        (p.state.solids[0].velocity()[0], p.solves.pressure.iter().map(|s| s.iterations).sum())
    }

    fn added_mass_is_right<const D: usize>(cells: usize, bar: f64) {
        // Potential flow between concentric balls (Lamb, Hydrodynamics, §93): the liquid adds (bᴰ + (D−1) aᴰ)/((D−1)(bᴰ − aᴰ))
        // times the mass that the ball displaces.
        let (a, b) = (0.2f64.powi(D as i32), 0.45f64.powi(D as i32));
        let d = D as f64 - 1.0;
        let added = (b + d * a) / (d * (b - a));
        for density in [0.01, 0.1, 1.0, 10.0, 100.0] {
            let (speed, iterations) = kept_speed::<D>(cells, density);
            let found = density / speed - density;
            assert!((found / added - 1.0).abs() < bar, "{D}D, density {density}: {found} for {added}");
            assert!(iterations <= 20, "{D}D, density {density}: {iterations} iterations");
        }
    }

    #[test]
    fn a_ball_in_a_shell_feels_the_added_mass() {
        added_mass_is_right::<2>(80, 0.003);
        added_mass_is_right::<3>(48, 0.01);
    }
}
