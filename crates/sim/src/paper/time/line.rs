//! Step 6: the contact line of a geometry, and its part of the last solve.

use super::geometry::Geometry;
use super::scheme::PaperScheme;
use crate::paper::contact_line::forces::InterfaceSamples;
use crate::paper::contact_line::level_set::contact_line_level_set;
use crate::paper::contact_line::line_mesh::LineMesh;
use crate::paper::contact_line::mass::{control_volume_mass, intrinsic_mass};
use crate::paper::coupling::line_map::LineMap;
use crate::paper::coupling::momentum::{LineForces, LineMomentum};
use crate::paper::coupling::sparse_matrix::SparseMatrix;
use crate::paper::fluid::fractions::virtual_density;
use crate::solid::{SolidState, Solids};
use meniscus_numerics::Vector;
use meniscus_numerics::grid::Sampler;
use meniscus_numerics::mesh::Geodesic;

/// The contact lines of all solids.
#[derive(Clone, Debug, Default)]
pub struct ContactLines<const D: usize> {
    /// Positions of the particles, m.
    pub positions: Vec<Vector<D>>,
    /// Forces on them, N (2D: N/m).
    pub forces: Vec<Vector<D>>,
    /// Their lengths, m (2D: 1).
    pub lengths: Vec<f64>,
    /// The vertices of their facets, counted over the surfaces of all solids, and their weights.
    pub facets: Vec<[(u32, f64); D]>,
    /// Interfaces with too few samples.
    pub degenerate: u64,
}

/// The line before the last solve.
#[derive(Clone, Debug)]
pub struct LineSystem<const D: usize> {
    /// `W_c`.
    pub map: LineMap<D>,
    intrinsic_mass: Vec<f64>,
    velocity: Vec<Vector<D>>,
}

impl<const D: usize> LineSystem<D> {
    /// What its momentum rows are made of.
    pub fn momentum(&self) -> LineMomentum<'_, D> {
        LineMomentum { map: &self.map, intrinsic_mass: &self.intrinsic_mass, velocity: &self.velocity }
    }
}

impl<const D: usize> ContactLines<D> {
    /// Velocities of the particles after a solve, m/s: those of their own unknowns, and of the solid's surface in components without.
    pub fn velocities(
        &self,
        own: &[[Option<usize>; D]],
        unknowns: &[f64],
        embedding: &SparseMatrix,
    ) -> Vec<Vector<D>> {
        let surface = embedding.multiply(&unknowns[..embedding.columns()]);
        let of = |(own, facet): (&[Option<usize>; D], &[(u32, f64); D])| {
            Vector::from_fn(|a, _| {
                let of_solid = |(v, weight): &(u32, f64)| surface[*v as usize * D + a] * weight;
                own[a].map_or_else(|| facet.iter().map(of_solid).sum(), |j| unknowns[j])
            })
        };
        own.iter().zip(&self.facets).map(of).collect()
    }
}

impl<const D: usize> PaperScheme<D> {
    /// The contact lines of a geometry, and the forces on them.
    pub(super) fn contact_lines(&self, geometry: &Geometry<D>) -> ContactLines<D> {
        let (phi, dx) = (geometry.sampler(self), self.model.grid.dx);
        let (mut all, mut first) = (ContactLines::default(), 0);
        for mesh in &geometry.meshes {
            let geodesic = Geodesic::new(&mesh.positions, &mesh.facets);
            let phi_c = contact_line_level_set(mesh, &geodesic, &|x| phi.linear(x), dx);
            let line = LineMesh::new(mesh, &phi_c);
            let samples = InterfaceSamples::new(&geometry.types, &phi, mesh, &phi_c);
            let (forces, degenerate) = samples.forces(&line, self.radius_cells * dx, &self.tensions);
            all.degenerate += degenerate;
            all.forces.extend(forces.iter().map(|f| f.force));
            for p in &line.particles {
                let corners = mesh.facets[p.facet as usize];
                all.positions.push(p.at);
                all.lengths.push(p.length);
                all.facets.push(std::array::from_fn(|k| (first + corners[k], p.weights[k])));
            }
            first += mesh.positions.len() as u32;
        }
        all
    }

    /// The line's part of the last solve, from the particles before, with positions, m, and velocities, m/s.
    pub(super) fn line_system(
        &self,
        lines: &ContactLines<D>,
        before: &[[Vector<D>; 2]],
        geometry: &Geometry<D>,
        solids: &[SolidState<D>],
        dt: f64,
    ) -> LineSystem<D> {
        let (model, dx) = (&self.model, self.model.grid.dx);
        let radius = self.radius_cells * dx;
        let nearest = |x: &Vector<D>| {
            let distance = |p: &&[Vector<D>; 2]| (p[0] - x).norm_squared();
            let nearest = before.iter().min_by(|p, q| distance(p).total_cmp(&distance(q)));
            nearest.map_or(Vector::zeros(), |p| p[1])
        };
        let velocity: Vec<Vector<D>> = lines.positions.iter().map(nearest).collect();
        let intrinsic: Vec<f64> =
            lines.lengths.iter().map(|length| intrinsic_mass(model.density, dx, *length)).collect();
        let lumped = match self.errata.intrinsic_mass_in_eq_21 {
            true => Vec::new(),
            false => self.lumped_masses(lines, geometry, solids, radius),
        };
        let forces = LineForces {
            velocity: &velocity,
            force: &lines.forces,
            intrinsic_mass: &intrinsic,
            lumped_mass: &lumped,
        };
        LineSystem {
            map: LineMap::new(&geometry.types, &lines.positions, radius, self.errata),
            velocity: forces.intermediate_velocities(dt, self.errata),
            intrinsic_mass: intrinsic,
        }
    }

    /// The lumped masses `m_c` of Section 4.3.1.
    fn lumped_masses(
        &self,
        lines: &ContactLines<D>,
        geometry: &Geometry<D>,
        states: &[SolidState<D>],
        radius: f64,
    ) -> Vec<f64> {
        let (model, grid) = (&self.model, &self.model.grid);
        let solids = Solids { model, states, surfaces: &geometry.surfaces };
        let lattice = grid.lattice();
        let distance = |c: usize| solids.liquid_distance(&grid.center(lattice.coordinates(c)));
        let distances: Vec<f64> = (0..lattice.len()).map(distance).collect();
        let solid = Sampler::cells(grid, &distances, model.scalar_boundary());
        let densities = [model.density, self.solid_density];
        let density = virtual_density(grid, &geometry.sampler(self), &solid, densities);
        let mass = |(x, length): (&Vector<D>, &f64)| {
            intrinsic_mass(model.density, grid.dx, *length) + control_volume_mass(grid, &density, x, radius)
        };
        lines.positions.iter().zip(&lines.lengths).map(mass).collect()
    }
}
