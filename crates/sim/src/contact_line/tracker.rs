//! The contact line for output and measurements: a level set of codimension one on the solids' surfaces.
//!
//! Every rigid solid carries a mesh finer than the grid. φ at its vertices tells where the solid is wetted. The zero contour is
//! the line, and the geodesic distance from it is `φ_c`, negative where the solid is wetted (paper, 4.3.1).
//!
//! The paper samples φ at the vertices, takes its contour at `ε = Δx` rather than 0, and moves it back by `ε` along the surface.
//! This has an error of `ε (1/sin θ − 1)`, a cell at 30 degrees, and inside solids φ is only an extension. Here φ is sampled
//! `SAMPLE_HEIGHT_CELLS` cells above each vertex, outside, and extrapolated to it with its gradient and second derivative: the
//! offset is normal to the surface instead of along it.
//!
//! The line is computed from model and state; it is not stored, and no step depends on it. The line that moves the liquid is that
//! of the energy on the dual grid ([`super::force`]); [`ContactLine::line_distance_cells`] is the distance between the two.

use super::angle::{Foot, contact_angle};
use crate::contact_line::sampling::{MAX_LINE_PHI_CELLS, UPPER_SAMPLE_HEIGHT_CELLS, phi_at_solid};
use crate::model::Model;
use crate::model::resolution::BAND_WIDTH_CELLS;
use crate::simulation::Simulation;
use crate::solid::Solids;
use meniscus_numerics::grid::{Sampler, VelocitySampler};
use meniscus_numerics::mesh::{Contour, Geodesic, ShapeSurface, SurfaceMesh};
use meniscus_numerics::{Vector, par};

/// Extracts the contact line on the solids of a model.
#[derive(Clone, Debug)]
pub struct LineTracker<const D: usize> {
    /// `None` for a deformable solid, whose own current surface is used.
    solids: Vec<Option<TrackedSurface<D>>>,
}

/// The surface of a solid; of a rigid one in its reference position.
#[derive(Clone, Debug)]
struct TrackedSurface<const D: usize> {
    mesh: SurfaceMesh<D>,
    /// Number of facets of the solid itself, which come first; the others close the mesh at the domain's sides.
    own_facets: usize,
    geodesic: Geodesic<D>,
    /// Normal at each vertex; zero where the surface is cut off.
    normals: Vec<Vector<D>>,
}

/// The contact line of a state.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ContactLine<const D: usize> {
    /// Its points, solid by solid.
    pub points: Vec<LinePoint<D>>,
    /// Its segments as indices of points, the wetted side on the left as seen from outside the solid; none in 2D.
    pub segments: Vec<[u32; 2]>,
    /// For every solid and every vertex of its surface the signed geodesic distance to the line, m, negative where it is wetted;
    /// five cells at most.
    pub phi_c: Vec<Vec<f64>>,
    /// Largest distance from this line of a point of the line that moves the liquid (that of the dual grid's energy), in cells,
    /// five at most; `None` without such a point.
    pub line_distance_cells: Option<f64>,
}

/// A point of the contact line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinePoint<const D: usize> {
    /// Position, m.
    pub at: Vector<D>,
    /// Index of the solid.
    pub solid: u32,
    /// The contact angle through the liquid, degrees.
    pub angle_degrees: f64,
    /// Speed of the liquid across the line, along the solid and relative to it, m/s, positive where the line advances; half a
    /// step ahead, as the velocity is.
    pub speed: f64,
    /// Force on the solid per length of the line, N/m (2D: per point, N/m): `γ sin θ n − γ cos θ_Y m`, with the
    /// solid's normal `n`, its tangent `m` out of the liquid, and Young's angle `θ_Y`. The force in the step
    /// has the angle of the energy in place of `θ_Y` (`force.rs`); with hysteresis the two differ.
    pub force: Vector<D>,
    /// Length of the line that the point represents, m (2D: 1).
    pub length: f64,
}

impl<const D: usize> LineTracker<D> {
    /// Builds a mesh of every rigid solid, with edges of the given lengths (m). That of an unbounded solid ends at the domain's
    /// sides, that of wetting walls at the sides of the grid.
    pub fn new(model: &Model<D>, edges: &[f64]) -> Self {
        let rigid = |number: usize| model.solids[number].elastic().is_none();
        let tracked = |(number, edge): (usize, &f64)| {
            rigid(number).then(|| TrackedSurface::rigid(model, number, *edge))
        };
        Self { solids: (0..model.solids.len()).zip(edges).map(tracked).collect() }
    }

    /// The current surface of a solid, with the vertices of [`ContactLine::phi_c`].
    pub fn surface(&self, solids: Solids<'_, D>, number: usize) -> SurfaceMesh<D> {
        let solid = solids.get(number);
        let Some(tracked) = &self.solids[number] else { return solid.surface.mesh.clone() };
        let rigid = solid.state.as_rigid();
        let positions = tracked.mesh.positions.iter().map(|x| solid.to_current(&rigid, x)).collect();
        SurfaceMesh { positions, facets: tracked.mesh.facets.clone() }
    }

    /// Extracts the contact line of a simulation's current state.
    pub fn extract(&self, simulation: &Simulation<D>) -> ContactLine<D> {
        let mut line = ContactLine {
            points: Vec::new(),
            segments: Vec::new(),
            phi_c: Vec::new(),
            line_distance_cells: None,
        };
        let seen = LineSampler::new(simulation);
        for (number, tracked) in self.solids.iter().enumerate() {
            match tracked {
                Some(tracked) => tracked.extract(&seen, number, &mut line),
                None => TrackedSurface::deformed(&seen.solids.get(number).surface.mesh)
                    .extract(&seen, number, &mut line),
            }
        }
        line.line_distance_cells = line.max_distance_cells(
            &simulation.workspace.dual_grid.contact_line_points(&simulation.state.phi.data),
            seen.dx,
        );
        line
    }
}

/// The state, as the extraction samples it.
struct LineSampler<'a, const D: usize> {
    solids: Solids<'a, D>,
    phi: Sampler<'a, D>,
    velocity: VelocitySampler<'a, D>,
    dx: f64,
}

impl<'a, const D: usize> LineSampler<'a, D> {
    fn new(simulation: &'a Simulation<D>) -> Self {
        let (model, state) = (&simulation.model, &simulation.state);
        Self {
            solids: simulation.solids(),
            phi: Sampler::cells(&model.grid, &state.phi.data, model.scalar_boundary()),
            velocity: model.velocity_sampler(&state.velocity),
            dx: model.grid.dx,
        }
    }

    /// Whether a point lies in a solid other than `number`, or outside the domain.
    fn is_covered(&self, number: usize, x: &Vector<D>) -> bool {
        let mut others = self.solids.iter().enumerate().filter(|(i, _)| *i != number);
        let [low, high] = self.solids.model.grid.bounds();
        let slack = 1e-9 * high.max();
        (0..D).any(|a| x[a] < low[a] - slack || x[a] > high[a] + slack)
            || others.any(|(_, solid)| solid.liquid_distance(x) < 0.0)
    }

    /// A point of the line.
    fn point(&self, number: usize, at: Vector<D>, length: f64) -> LinePoint<D> {
        let solid = self.solids.get(number);
        let normal = solid.normal(&at, 0.01 * self.dx);
        let foot = at + normal * solid.padding;
        let (_, slope) =
            self.phi.distance_with_gradient(&(foot + normal * (UPPER_SAMPLE_HEIGHT_CELLS * self.dx)));
        let outward = (slope - normal * slope.dot(&normal)).try_normalize(0.0).unwrap_or(Vector::zeros());
        let height = |x: &Vector<D>| self.solids.height_above(number, &foot, &normal, x);
        let foot = Foot {
            at: foot,
            normal,
            dx: self.dx,
            bond_vector: self.solids.model.cell_bond_vector(),
            height: &height,
        };
        let angle =
            contact_angle(&self.phi, &foot).unwrap_or_else(|| slope.dot(&normal).clamp(-1.0, 1.0).acos());
        let young = solid.young_cosine_near(&at, self.dx).clamp(-1.0, 1.0);
        let force = (normal * angle.sin() - outward * young) * self.solids.model.surface_tension;
        let speed = (self.velocity.linear(&foot.at) - solid.velocity_at(&at)).dot(&outward);
        LinePoint { at, solid: number as u32, angle_degrees: angle.to_degrees(), speed, force, length }
    }
}

impl<const D: usize> TrackedSurface<D> {
    fn rigid(model: &Model<D>, number: usize, edge: f64) -> Self {
        let solid = &model.solids[number];
        let (low, high) = solid.shape.bounds();
        let margin = Vector::repeat(2.0 * edge);
        let [first, last] = match model.wetting_wall_solid() == Some(number) {
            true => model.grid.bounds(),
            false => [Vector::zeros(), model.grid.domain_upper()],
        };
        let (low, high) = ((low - margin).sup(&first), (high + margin).inf(&last));
        let surface = ShapeSurface::new(&|x| solid.shape.signed_distance(x), low, high, edge);
        let own = surface.solid_facets().len();
        Self::new(surface.mesh, own)
    }

    fn deformed(mesh: &SurfaceMesh<D>) -> Self {
        Self::new(mesh.clone(), mesh.facets.len())
    }

    fn new(mesh: SurfaceMesh<D>, own_facets: usize) -> Self {
        let mut normals = vec![Vector::zeros(); mesh.positions.len()];
        for (f, facet) in mesh.facets[..own_facets].iter().enumerate() {
            let area = mesh.area_vector(f);
            facet.iter().for_each(|v| normals[*v as usize] += area);
        }
        normals.iter_mut().for_each(|n| *n = n.try_normalize(0.0).unwrap_or(Vector::zeros()));
        let geodesic = Geodesic::new(&mesh.positions, &mesh.facets[..own_facets]);
        Self { mesh, own_facets, geodesic, normals }
    }

    /// Appends the line on this solid.
    fn extract(&self, seen: &LineSampler<'_, D>, number: usize, line: &mut ContactLine<D>) {
        let solid = seen.solids.get(number);
        let rigid = solid.state.rigid();
        let moved = |x: &Vector<D>| rigid.map_or(*x, |rigid| solid.to_current(rigid, x));
        let mesh = &self.mesh;
        let value = |v: usize| {
            let n = &self.normals[v];
            let normal = rigid.map_or(*n, |rigid| rigid.rotation * n);
            let x = moved(&mesh.positions[v]) + normal * solid.padding;
            let value = phi_at_solid(&seen.phi, &x, &normal, seen.dx);
            let open = *n != Vector::<D>::zeros()
                && !(value.abs() < MAX_LINE_PHI_CELLS * seen.dx && seen.is_covered(number, &x));
            if open { value } else { f64::NAN }
        };
        let values = par::map(mesh.positions.len(), 256, value);
        let contour = Contour::of(&mesh.facets[..self.own_facets], &values);
        line.phi_c.push(self.geodesic.distance(mesh, &contour, &values, BAND_WIDTH_CELLS * seen.dx));
        let places: Vec<Vector<D>> = contour.positions(mesh).iter().map(moved).collect();
        let mut lengths = vec![if D == 2 { 1.0 } else { 0.0 }; places.len()];
        for segment in &contour.segments {
            let [a, b] = segment.map(|p| places[p as usize]);
            segment.iter().for_each(|p| lengths[*p as usize] += 0.5 * (b - a).norm());
        }
        let first = line.points.len() as u32;
        line.segments.extend(contour.segments.iter().map(|s| s.map(|p| p + first)));
        line.points.extend(par::map(places.len(), 8, |p| seen.point(number, places[p], lengths[p])));
    }
}

impl<const D: usize> ContactLine<D> {
    /// Length of the line, m; `None` in 2D or without a line.
    pub fn length(&self) -> Option<f64> {
        (D == 3 && !self.points.is_empty()).then(|| self.points.iter().map(|p| p.length).sum())
    }

    /// Mean and standard deviation along the line of the contact angle, degrees, on one solid or on all.
    pub fn angle_statistics(&self, solid: Option<u32>) -> Option<(f64, f64)> {
        let counts = |p: &&LinePoint<D>| solid.is_none_or(|s| p.solid == s);
        let sum = |f: &dyn Fn(&LinePoint<D>) -> f64| {
            self.points.iter().filter(counts).map(|p| p.length * f(p)).sum::<f64>()
        };
        let length = sum(&|_| 1.0);
        let mean = sum(&|p| p.angle_degrees) / length;
        let spread = sum(&|p| (p.angle_degrees - mean).powi(2)) / length;
        (length > 0.0).then(|| (mean, spread.sqrt()))
    }

    /// Largest distance of points (m) from the line, in cells.
    fn max_distance_cells(&self, places: &[Vector<D>], dx: f64) -> Option<f64> {
        // Single points count as segments of zero length.
        let alone = (0..self.points.len() as u32).map(|i| [i, i]).filter(|_| D == 2);
        let mut pieces: Vec<[Vector<D>; 2]> = self
            .segments
            .iter()
            .copied()
            .chain(alone)
            .map(|s| s.map(|p| self.points[p as usize].at))
            .collect();
        pieces.sort_by(|p, q| p[0][0].total_cmp(&q[0][0]));
        let reach = (BAND_WIDTH_CELLS + 1.0) * dx;
        let away = |x: &Vector<D>| {
            let from = pieces.partition_point(|p| p[0][0] < x[0] - reach);
            let near = pieces[from..].iter().take_while(|p| p[0][0] <= x[0] + reach);
            near.map(|p| distance_to_segment(x, p)).fold(BAND_WIDTH_CELLS * dx, f64::min) / dx
        };
        let largest = || par::reduce(places.len(), 64, 0.0, |i| away(&places[i]), f64::max);
        (!places.is_empty()).then(largest)
    }
}

/// Distance of a point to a segment.
fn distance_to_segment<const D: usize>(x: &Vector<D>, [a, b]: &[Vector<D>; 2]) -> f64 {
    let along = b - a;
    let t = ((x - a).dot(&along) / along.norm_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    (x - a - along * t).norm()
}
