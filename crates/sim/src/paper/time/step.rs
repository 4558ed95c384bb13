//! The seven steps of Section 6, with three solves.
//!
//! ```text
//! (1) u^{n+½}, v_s^{n+½*}: explicit forces for half a step                                                  Eq. 16
//! (2) Eq. 11 for v_s^{n+½};   x_s^{n+1} = x_s^n + Δt v_s^{n+½};   u ← u^n                                   Eq. 17
//! (3) v_s^eff = (x_s^{n+1} − x_s^n)/Δt;   u^adv: u^n projected beside v_s^eff, with the volume's correction   Eq. 18
//! (4) φ^{n+1}: φ^n carried by u^adv                                                                         Eq. 19
//! (5) u*: u^n carried by u^adv, with viscosity, gravity and surface tension;   v_s*                         Eq. 20
//! (6) the contact line;   v_c*                                                                              Eq. 21
//! (7) Eq. 15 for v_s^{n+1} and u^{n+1}
//! ```
//!
//! What the paper leaves open: the correction of the volume is a divergence, the same in all of the liquid, that makes up for the missing
//! volume in five steps; a particle of the line has the velocity of the nearest one before.
//!
//! Limits: solids do not feel each other. The scheme damps vibrations (E21).

use super::geometry::{Geometry, solid_side};
use super::line::ContactLines;
use super::scheme::PaperScheme;
use super::solves::{SolidSystem, Solved};
use super::state::PaperState;
use super::transport::{add_viscosity_and_gravity, advect_level_set, advect_velocity};
use crate::model::time_step::MAX_FORCED_DEFORMATION_INCREMENT;
use crate::paper::coupling::line_map::push_faces;
use crate::paper::coupling::momentum::{solid_rows, with_line};
use crate::paper::coupling::solids::SolidUnknowns;
use crate::paper::fluid::cells::Face;
use crate::paper::fluid::surface_tension::SurfaceTension;
use crate::paper::solid::{explicit_velocities, set_prescribed_velocities};
use crate::solid::SolidState;
use meniscus_numerics::Vector;
use meniscus_numerics::grid::FaceField;
use meniscus_numerics::linalg::{SolveError, SolveReport};

/// What a step reports.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PaperReport<const D: usize> {
    /// The solves of steps 2, 3 and 7.
    pub solves: [SolveReport; 3],
    /// The solves of Eq. 6, component by component.
    pub surface_tension: [SolveReport; D],
    /// Number of particles of the contact line.
    pub particles: u64,
    /// Interfaces of particles with too few samples, whose force is left out.
    pub degenerate: u64,
    /// Components of particles whose impulse reaches nothing.
    pub unreached: u64,
    /// Faces beside solids that the samples of the surfaces miss.
    pub unsampled: u64,
}

impl<const D: usize> PaperScheme<D> {
    /// Advances a state by `dt`, s.
    ///
    /// # Errors
    /// [`SolveError`] of one of the solves, and [`SolveError::DeformationTooLarge`]; the state is then as before, but for the velocity beyond
    /// the liquid, which is extrapolated anew.
    pub fn step(&self, state: &mut PaperState<D>, dt: f64) -> Result<PaperReport<D>, SolveError> {
        let mut solids = state.solids.clone();
        set_prescribed_velocities(&self.model, &mut solids, state.time, dt);
        let before = Geometry::new(self, &solids, &state.phi);
        self.extend_velocity(&before, &solids, &mut state.velocity);
        let (mut moved, first) = self.move_solids(state, &before, &solids, dt)?;

        // (3) The velocity of transport, beside solids that move with their velocities in the middle of the step.
        let between = Geometry::new(self, &moved, &before.surface);
        let mut transport = state.velocity.clone();
        let missing = self.missing_volume(&before.phi, state.target_volume);
        let second = self.project_transport([&before, &between], &mut transport, missing, dt)?;
        self.extend_velocity(&between, &moved, &mut transport);
        for ((solid, now), start) in self.model.solids.iter().zip(&mut moved).zip(&solids) {
            solid.set_node_velocities(now, &start.node_velocities());
        }

        // (4) The surface.
        let phi = advect_level_set(&self.model, &between.surface, &transport, dt);
        let after = Geometry::new(self, &moved, &self.restored_surface(&moved, phi));

        // (5) Velocities before the last solve.
        let mut velocity = advect_velocity(&self.model, &state.velocity, &transport, dt);
        add_viscosity_and_gravity(&self.model, &mut velocity, dt);
        let solids = after.solids(self, &moved);
        let side = solid_side(solids);
        let wetted = |x: &Vector<D>| self.wetted_tension(solids, x);
        let force = SurfaceTension {
            types: &after.types,
            shape: after.shape(self, &side),
            liquid_air: self.liquid_air_tension(),
            liquid_solid: &wetted,
            density: self.model.density,
            dt,
            errata: self.errata,
        };
        let surface_tension = force.apply(&mut velocity, self.limits)?;
        let on_solids = force.solid_impulses();

        // (6) and (7) The contact line, and the velocities at the end.
        let lines = match self.contact_line {
            true => self.contact_lines(&after, &moved),
            false => ContactLines::default(),
        };
        let forces = SurfaceForces { lines: &lines, on_solids };
        let (third, unreached) =
            self.final_solve(state, &after, moved.clone(), &forces, &mut velocity, dt)?;
        self.extend_velocity(&after, &state.solids, &mut velocity);
        (state.velocity, state.phi) = (velocity, after.surface.clone());
        state.time += dt;
        Ok(PaperReport {
            solves: [first, second, third],
            surface_tension,
            particles: lines.positions.len() as u64,
            degenerate: lines.degenerate,
            unreached,
            unsampled: after.map.unsampled,
        })
    }

    /// Time, s, by which the positions of elastic forces in Eq. 16 are later than the start of a step of `dt`, s.
    fn lookahead(&self, dt: f64) -> f64 {
        if self.errata.implicit_elasticity { dt } else { 0.0 }
    }

    /// Steps 1 and 2: the solids at the end of the step, with their velocities in the middle of it.
    fn move_solids(
        &self,
        state: &PaperState<D>,
        before: &Geometry<D>,
        solids: &[SolidState<D>],
        dt: f64,
    ) -> Result<(Vec<SolidState<D>>, SolveReport), SolveError> {
        let mut velocity = state.velocity.clone();
        add_viscosity_and_gravity(&self.model, &mut velocity, 0.5 * dt);
        let views = before.solids(self, solids);
        let times = [0.5 * dt, self.lookahead(dt)];
        let system = SolidSystem::new(views, &before.meshes, explicit_velocities(views, 0.5 * dt), times);
        let rows = solid_rows(&self.liquid(before, &velocity), &before.map, &system.momentum());
        let Solved { unknowns, report, .. } = self.solve(before, &rows, &mut velocity, 0.0)?;
        let nodes = SolidUnknowns::new(views).node_velocities(&unknowns);
        let mut moved = solids.to_vec();
        for ((solid, now), nodes) in self.model.solids.iter().zip(&mut moved).zip(&nodes) {
            let rate = solid.elastic().map_or(0.0, |elastic| elastic.max_deformation_rate(nodes));
            let (increment, limit) = (rate * dt, MAX_FORCED_DEFORMATION_INCREMENT);
            if increment > limit {
                return Err(SolveError::DeformationTooLarge { increment, limit });
            }
            solid.set_node_velocities(now, nodes);
            solid.advance(now, state.time, dt);
        }
        Ok((moved, report))
    }

    /// Steps 6 and 7: sets the velocities of solids and line, and makes `u*` the velocity at the end of the step. Returns the number of
    /// components of particles whose impulse reaches nothing, too.
    fn final_solve(
        &self,
        state: &mut PaperState<D>,
        after: &Geometry<D>,
        mut moved: Vec<SolidState<D>>,
        forces: &SurfaceForces<'_, D>,
        velocity: &mut FaceField<D>,
        dt: f64,
    ) -> Result<(SolveReport, u64), SolveError> {
        let lines = forces.lines;
        let views = after.solids(self, &moved);
        let times = [dt, 0.5 * self.lookahead(dt)];
        let system = SolidSystem::new(views, &after.meshes, explicit_velocities(views, dt), times);
        let mut on_vertices = lines.vertex_impulses(dt);
        let unreached = match self.errata.free_faces {
            true => Some(self.push_free_faces(lines, after, velocity, &mut on_vertices, dt)),
            false => None,
        };
        let liquid = self.liquid(after, velocity);
        let mut rows = solid_rows(&liquid, &after.map, &system.momentum());
        rows.push_faces(&forces.on_solids);
        if !on_vertices.is_empty() {
            rows.push_vertices(&system.embedding, &on_vertices);
        }
        let (rows, own, unreached) = match unreached {
            Some(unreached) => (rows, vec![[None; D]; lines.positions.len()], unreached),
            None => {
                let line = self.line_system(lines, &state.line, after, &moved, dt);
                let (rows, own) = with_line(rows, &liquid, &after.map, &system.embedding, &line.momentum());
                (rows, own, line.map.unreached)
            }
        };
        let Solved { unknowns, report, pressure } = self.solve(after, &rows, velocity, 0.0)?;
        state.pressure_impulse.data.fill(0.0);
        let cells = pressure.into_iter();
        cells.for_each(|(c, p)| state.pressure_impulse.data[c as usize] = p / self.model.density);
        let velocities: Vec<Vector<D>> = lines.velocities(&own, &unknowns, &system.embedding);
        state.line = lines.positions.iter().zip(velocities).map(|(x, v)| [*x, v]).collect();
        let nodes = SolidUnknowns::new(views).node_velocities(&unknowns[..system.embedding.columns()]);
        for ((solid, now), nodes) in self.model.solids.iter().zip(&mut moved).zip(&nodes) {
            solid.set_node_velocities(now, nodes);
        }
        state.solids = moved;
        Ok((report, unreached))
    }

    /// The line's impulses on liquid–air faces that it does not own (E26); what they have beside the line's forces, the solids' vertices give.
    fn push_free_faces(
        &self,
        lines: &ContactLines<D>,
        after: &Geometry<D>,
        velocity: &mut FaceField<D>,
        on_vertices: &mut [f64],
        dt: f64,
    ) -> u64 {
        let (grid, radius) = (&self.model.grid, self.radius_cells * self.model.grid.dx);
        let impulses: Vec<Vector<D>> = lines.forces.iter().map(|f| f * dt).collect();
        let mass = self.model.density * grid.cell_volume();
        let (beside, unreached) =
            push_faces(&after.types, [&lines.positions, &impulses], radius, mass, velocity);
        lines.add_to_vertices(on_vertices, &beside, -1.0);
        unreached
    }
}

/// Forces of the surface beside those on the liquid.
struct SurfaceForces<'a, const D: usize> {
    /// The contact lines.
    lines: &'a ContactLines<D>,
    /// Impulses of Eq. 6 on solids ([`SurfaceTension::solid_impulses`]).
    on_solids: Vec<(Face, f64)>,
}
