//! Step 6: the contact line of a geometry, and its part of the last solve.

use super::geometry::{Geometry, solid_side};
use super::scheme::PaperScheme;
use crate::contact_line::sampling::phi_at_solid;
use crate::paper::LineImpulse;
use crate::paper::contact_line::forces::InterfaceSamples;
use crate::paper::contact_line::level_set::{OFFSET_CELLS, contact_line_level_set};
use crate::paper::contact_line::line_mesh::LineMesh;
use crate::paper::contact_line::mass::{control_volume_mass, intrinsic_mass};
use crate::paper::contact_line::solid_tension::tension_forces;
use crate::paper::coupling::line_map::LineMap;
use crate::paper::coupling::momentum::{LineForces, LineMomentum};
use crate::paper::coupling::sparse_matrix::SparseMatrix;
use crate::paper::fluid::fractions::virtual_density;
use crate::paper::fluid::surface_shape::SurfaceShape;
use crate::solid::{SolidState, SolidView, Solids};
use meniscus_numerics::Vector;
use meniscus_numerics::grid::Sampler;
use meniscus_numerics::mesh::{Geodesic, SurfaceMesh};

/// The contact lines of all solids.
#[derive(Clone, Debug, Default)]
pub struct ContactLines<const D: usize> {
    /// Positions of the particles, m.
    pub positions: Vec<Vector<D>>,
    /// Forces on them, N (2D: N/m); divided by directions, the parts that act on the liquid.
    pub forces: Vec<Vector<D>>,
    /// The parts that act on the solids, N (2D: N/m); zero unless divided by directions.
    pub on_solids: Vec<Vector<D>>,
    /// Their lengths, m (2D: 1).
    pub lengths: Vec<f64>,
    /// The vertices of their facets, counted over the surfaces of all solids, and their weights.
    pub facets: Vec<[(u32, f64); D]>,
    /// Forces of the tensions of deformable solids on the components of the vertices of all surfaces, N (2D: N/m).
    pub solid_tensions: Vec<f64>,
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
    /// Impulses of a step of `dt` (s) on the components of the vertices of all surfaces, N s (2D: N s/m): of the parts of the particles'
    /// forces that act on solids, and of the solids' own tensions.
    pub fn vertex_impulses(&self, dt: f64) -> Vec<f64> {
        let mut all: Vec<f64> = self.solid_tensions.iter().map(|f| f * dt).collect();
        self.add_to_vertices(&mut all, &self.on_solids, dt);
        all
    }

    /// Adds vectors of the particles times a factor to the components of the vertices that carry them.
    pub fn add_to_vertices(&self, components: &mut [f64], vectors: &[Vector<D>], factor: f64) {
        for (facet, vector) in self.facets.iter().zip(vectors) {
            for ((v, weight), a) in facet.iter().flat_map(|corner| (0..D).map(move |a| (*corner, a))) {
                components[v as usize * D + a] += weight * vector[a] * factor;
            }
        }
    }

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

/// The surface of a solid, whose vertices are numbered over the surfaces of all solids.
struct NumberedSurface<'a, const D: usize> {
    mesh: &'a SurfaceMesh<D>,
    first_vertex: u32,
}

impl<const D: usize> PaperScheme<D> {
    /// The contact lines of a geometry of solids in these states, and the forces on them.
    pub(super) fn contact_lines(&self, geometry: &Geometry<D>, states: &[SolidState<D>]) -> ContactLines<D> {
        let solids = geometry.solids(self, states);
        let side = solid_side(solids);
        let shape = geometry.shape(self, &side);
        let mut all = ContactLines::default();
        let mut first = 0;
        for (solid, mesh) in solids.iter().zip(&geometry.meshes) {
            self.add_line(&mut all, solid, &NumberedSurface { mesh, first_vertex: first }, geometry, &shape);
            first += mesh.positions.len() as u32;
        }
        all
    }

    /// Adds the line on a solid's surface.
    fn add_line(
        &self,
        all: &mut ContactLines<D>,
        solid: SolidView<'_, D>,
        surface: &NumberedSurface<'_, D>,
        geometry: &Geometry<D>,
        shape: &SurfaceShape<'_, D>,
    ) {
        let (errata, dx) = (self.errata, self.model.grid.dx);
        let NumberedSurface { mesh, first_vertex: first } = *surface;
        let normal = |x: &Vector<D>| (shape.side)(x).1;
        let closed = geometry.sampler(self);
        let phi = |x: &Vector<D>| match errata.exact_line {
            true => phi_at_solid(&shape.phi, x, &normal(x), dx),
            false => closed.linear(x),
        };
        let offset = if errata.exact_line { 0.0 } else { OFFSET_CELLS * dx };
        let geodesic = Geodesic::new(&mesh.positions, &mesh.facets);
        let phi_c = contact_line_level_set(mesh, &geodesic, &phi, [dx, offset]);
        let line = LineMesh::new(mesh, &phi_c);
        let samples = InterfaceSamples::new(&geometry.types, &shape.phi, mesh, &phi_c);
        let tensions = |x: &Vector<D>| self.tensions_at(solid, x);
        let at_line = errata.tangent_at_line.then_some(shape);
        let (forces, degenerate) = samples.forces(&line, self.radius_cells * dx, &tensions, at_line);
        all.degenerate += degenerate;
        for (p, force) in line.particles.iter().zip(&forces) {
            let by_directions = || force.by_directions(&normal(&p.at), p.length, &tensions(&p.at));
            let [own, on_solid] = match errata.line_impulse {
                LineImpulse::ByDirections => by_directions(),
                _ => [force.force, Vector::zeros()],
            };
            let corners = mesh.facets[p.facet as usize];
            all.positions.push(p.at);
            all.lengths.push(p.length);
            all.forces.push(own);
            all.on_solids.push(on_solid);
            all.facets.push(std::array::from_fn(|k| (first + corners[k], p.weights[k])));
        }
        let own = match errata.solid_tensions && solid.elastic().is_some() {
            true => tension_forces(mesh, &phi_c, &tensions),
            false => vec![Vector::zeros(); mesh.positions.len()],
        };
        all.solid_tensions.extend(own.iter().flat_map(|f| f.iter().copied().collect::<Vec<_>>()));
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
