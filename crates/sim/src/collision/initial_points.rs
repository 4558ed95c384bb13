//! Collision points of a model's solids at the start, and their distances.

use super::broad_phase::{CandidatePairs, Sweep};
use super::configuration::Configuration;
use super::points::{BARRIER_REACH_CELLS, CollisionPoints, PointOwner, ProbeSet};
use crate::model::{Model, Wall};
use crate::solid::surface::SolidSurface;
use crate::solid::{RigidKinematics, Solid, SolidKind, SolidState};
use meniscus_contact::{CollisionMesh, FeaturePairs, Plane};
use meniscus_elastic::{Assembly, Elastic};
use meniscus_numerics::Vector;
use meniscus_numerics::mesh::surface::area_vector;
use meniscus_numerics::mesh::volume::QuadraticFacet;
use meniscus_numerics::shape::Shape;
use std::collections::BTreeMap;

/// Minimum activation distance of a point, relative to [`BARRIER_REACH_CELLS`]. A point in contact at the start needs some distance over
/// which the barrier rises, and the barrier's energy of a contact is proportional to it.
const MIN_REACH_FRACTION: f64 = 0.1;
/// Spacing of the sample points of rigid solids, in cells. Between them a surface of radius five cells bulges by less than 0.01 cells.
const PROBE_SPACING_CELLS: f64 = 0.5;

impl<const D: usize> CollisionPoints<D> {
    /// Collision points of a model.
    pub fn of(model: &Model<D>) -> Self {
        let sampled = SampledSurfaces::of(model);
        let surface = sampled.collision_mesh();
        let SampledSurfaces { owners, exposed, .. } = sampled;
        let mut areas = vec![0.0; model.solids.len()];
        surface.points().iter().for_each(|p| areas[owners[*p as usize].solid()] += surface.area(*p));
        let prescribed_nodes: Vec<bool> = model.solids.iter().flat_map(Solid::prescribed_nodes).collect();
        let first_node = first_nodes(model);
        let assembly = assembly(model, &first_node, prescribed_nodes.clone());
        let mut all = Self {
            surface,
            owners,
            first_node,
            prescribed_nodes,
            weight_pressures: weight_pressures(model, &areas),
            mean_side_areas: areas.iter().map(|area| area / (2 * D) as f64).collect(),
            domain_sides: domain_sides(model),
            gap_offsets: BTreeMap::new(),
            probe_sets: probe_sets(model),
            exposed,
            assembly,
        };
        all.fit_reaches_to_gaps(model);
        all
    }

    /// Reduces the activation distance of points that start within the barrier's range to their initial distance, so that the barrier
    /// exerts no force at the start. The minimum is [`MIN_REACH_FRACTION`] of the barrier's activation distance.
    fn fit_reaches_to_gaps(&mut self, model: &Model<D>) {
        let (reach, still) = (BARRIER_REACH_CELLS * model.grid.dx, vec![Vector::zeros(); self.node_count()]);
        let start = model.initial_solids();
        let places = Configuration::new(model, &start, self, &still, 0.0);
        let at = places.positions();
        let near = CandidatePairs::on(&[Sweep { from: &places, to: &places }], reach).feature_pairs;
        self.retract_points(&near, &at, MIN_REACH_FRACTION * reach);
        let places = Configuration::new(model, &start, self, &still, 0.0);
        let at = places.positions();
        let candidates = CandidatePairs::on(&[Sweep { from: &places, to: &places }], reach);
        let mut reaches = candidates.feature_pairs.min_distances(&at);
        let mut lifts = BTreeMap::new();
        for meeting in &candidates.sdf_pairs {
            let p = meeting.point();
            let distance = meeting.distance(&places, &at[p as usize]) - self.surface.radius(p);
            let nearest = MIN_REACH_FRACTION * reach;
            if distance < nearest {
                lifts.insert(*meeting, nearest - distance);
            }
            reaches[p as usize] = reaches[p as usize].min(distance.max(nearest));
        }
        reaches
            .iter_mut()
            .for_each(|r| *r = if *r < reach { r.max(MIN_REACH_FRACTION * reach) } else { f64::INFINITY });
        self.surface = std::mem::take(&mut self.surface).with_activation_distances(reaches);
        self.gap_offsets = lifts;
    }

    /// Moves points of rigid solids that touch facets at the start into their solids, to the distance `least` (m).
    fn retract_points(&mut self, near: &FeaturePairs, at: &[Vector<D>], least: f64) {
        let mut moves: BTreeMap<u32, (f64, Vector<D>)> = BTreeMap::new();
        for (stencil, gap) in near.gaps(at).filter(|(_, gap)| *gap < least) {
            let (point, rest) = (stencil.points()[0], stencil.points().get(stencil.kind.first_count()..));
            let Some(facet) = rest.and_then(|rest| <[u32; D]>::try_from(rest).ok()) else { continue };
            let outward = area_vector(&facet.map(|p| at[p as usize])).try_normalize(0.0);
            let known = moves.get(&point).is_some_and(|(known, _)| *known <= gap);
            if let Some(outward) = outward.filter(|_| !known && stencil.kind.first_count() == 1) {
                moves.insert(point, (gap, outward));
            }
        }
        for (point, (gap, outward)) in moves {
            if let PointOwner::Rigid { at, .. } = &mut self.owners[point as usize] {
                *at += outward * (least - gap);
            }
        }
    }
}

/// Points on the surfaces of all solids at the start: vertices of deformable ones, followed by samples of rigid ones.
struct SampledSurfaces<const D: usize> {
    owners: Vec<PointOwner<D>>,
    /// Facets of deformable solids.
    facets: Vec<[u32; D]>,
    /// Positions, m.
    positions: Vec<Vector<D>>,
    /// Whether a point lies on a sharp edge or corner, or is the centre of a ball; true for vertices.
    exposed: Vec<bool>,
    /// Points of rigid solids, each with its area (m², 2D: m) and the radius (m) of a ball around it.
    probes: Vec<(u32, f64, f64)>,
}

impl<const D: usize> SampledSurfaces<D> {
    /// The points of all solids except the wetting walls.
    fn of(model: &Model<D>) -> Self {
        let mut all = Self {
            owners: Vec::new(),
            facets: Vec::new(),
            positions: Vec::new(),
            exposed: Vec::new(),
            probes: Vec::new(),
        };
        for (number, solid) in model.solids.iter().enumerate() {
            all.add_vertices(number, &solid.kind.rest_surface());
        }
        for (number, solid) in model.solids.iter().enumerate() {
            if solid.elastic().is_none() && model.wetting_wall_solid() != Some(number) {
                all.add_samples(number, &solid.shape, PROBE_SPACING_CELLS * model.grid.dx);
            }
        }
        all
    }

    /// Adds the collision surface of a deformable solid.
    fn add_vertices(&mut self, solid: usize, surface: &SolidSurface<D>) {
        let (numbers, from) = (surface.volume_vertices(), self.owners.len() as u32);
        let number = |v: u32| numbers[v as usize];
        let vertex = |v: &u32| PointOwner::Vertex { solid, vertex: *v as usize };
        let center = |QuadraticFacet { corners, edges }: &QuadraticFacet| {
            let facet = QuadraticFacet { corners: corners.map(number), edges: edges.map(number) };
            PointOwner::FacetCenter { solid, facet }
        };
        self.owners.extend(numbers.iter().map(vertex).chain(surface.collision.centers.iter().map(center)));
        self.positions.extend(surface.collision.positions(&surface.mesh.positions));
        self.facets.extend(surface.collision.facets.iter().map(|f| f.map(|v| v + from)));
        self.exposed.resize(self.owners.len(), true);
    }

    /// Adds samples, at most `edge` (m) apart, of the surface of a rigid solid.
    fn add_samples(&mut self, solid: usize, shape: &Shape<D>, edge: f64) {
        for sample in shape.surface_samples(edge) {
            self.probes.push((self.owners.len() as u32, edge.powi(D as i32 - 1), sample.radius));
            self.owners.push(PointOwner::Rigid { solid, at: sample.position });
            self.positions.push(sample.position);
            self.exposed.push(sample.sharp || sample.radius > 0.0);
        }
    }

    /// The mesh of all surfaces.
    fn collision_mesh(&self) -> CollisionMesh<D> {
        let bodies = self.owners.iter().map(|owner| owner.solid() as u32).collect();
        CollisionMesh::new(self.facets.clone(), &self.positions, bodies)
            .with_points(self.probes.iter().copied())
    }
}

/// The first node of each solid.
fn first_nodes<const D: usize>(model: &Model<D>) -> Vec<usize> {
    let next = |nodes: &mut usize, solid: &Solid<D>| {
        let first = *nodes;
        *nodes += solid.node_count();
        Some(first)
    };
    model.solids.iter().scan(0, next).collect()
}

/// Pressure scale of each solid, Pa ([`CollisionPoints::weight_pressures`]); `areas` are those of the solids' surfaces.
fn weight_pressures<const D: usize>(model: &Model<D>, areas: &[f64]) -> Vec<f64> {
    let fastest = model.solids.iter().map(initial_speed).fold(0.0, f64::max);
    let stop = 0.5 * fastest * fastest / (BARRIER_REACH_CELLS * model.grid.dx);
    let pressure = |(solid, area): (&Solid<D>, &f64)| {
        let is_prescribed = solid.kind.is_prescribed() || *area == 0.0;
        let weight = model.gravity.norm() * (2 * D) as f64;
        if is_prescribed { 0.0 } else { solid.mass_properties.mass * (weight + stop) / area }
    };
    model.solids.iter().zip(areas).map(pressure).collect()
}

/// Block structure of the joint matrix of all solids; `None` if it exceeds the memory.
fn assembly<const D: usize>(
    model: &Model<D>,
    first_node: &[usize],
    prescribed_nodes: Vec<bool>,
) -> Option<Assembly> {
    let deforming = model.solids.iter().zip(first_node);
    let deforming: Vec<(usize, &Elastic<D>)> =
        deforming.filter_map(|(solid, first)| Some((*first, solid.elastic()?))).collect();
    Assembly::new(&deforming, prescribed_nodes)
}

/// Numbers of two solids, and the gap between them, m.
type Gap = (usize, usize, f64);
/// Numbers of a solid and of another one (`None` for a side of the domain), and the gap between them, m.
type SdfGap = (usize, Option<usize>, f64);

/// All gaps below the barrier's activation distance: mesh features with each other, and points with rigid solids or sides.
fn gaps<const D: usize>(model: &Model<D>, solids: &[SolidState<D>]) -> (Vec<Gap>, Vec<SdfGap>) {
    let points = CollisionPoints::of(model);
    let still = vec![Vector::zeros(); points.node_count()];
    let places = Configuration::new(model, solids, &points, &still, 0.0);
    let found =
        CandidatePairs::on(&[Sweep { from: &places, to: &places }], BARRIER_REACH_CELLS * model.grid.dx);
    let at = places.positions();
    let solid = |point: u32| points.owners[point as usize].solid();
    let facets = found.feature_pairs.gaps(&at).map(|(stencil, gap)| {
        let points = stencil.points();
        (solid(points[0]), solid(points[stencil.kind.first_count()]), gap)
    });
    let rigid = found.sdf_pairs.iter().map(|m| {
        let gap = m.distance(&places, &at[m.point() as usize]) - points.thickness(m);
        (solid(m.point()), m.solid(), gap)
    });
    (facets.collect(), rigid.collect())
}

/// The narrowest initial gap, m, between the surface of a deformable solid and itself or another solid's, with the numbers of both;
/// `None` if all exceed the barrier's activation distance. A run needs a positive gap, because the barrier is infinite at zero.
pub fn narrowest_initial_gap<const D: usize>(model: &Model<D>) -> Option<(usize, usize, f64)> {
    gaps(model, &model.initial_solids()).0.into_iter().min_by(|a, b| a.2.total_cmp(&b.2))
}

/// The narrowest current gap, m, between a solid and another one, itself or a closed side of the domain (`None`), with their numbers;
/// `None` if all exceed the barrier's activation distance.
pub fn narrowest_current_gap<const D: usize>(
    model: &Model<D>,
    solids: &[SolidState<D>],
) -> Option<(usize, Option<usize>, f64)> {
    let (facets, rigid) = gaps(model, solids);
    let facets = facets.into_iter().map(|(one, other, gap)| (one, Some(other), gap));
    facets.chain(rigid).min_by(|a, b| a.2.total_cmp(&b.2))
}

/// Closed sides of the domain.
fn domain_sides<const D: usize>(model: &Model<D>) -> Vec<Plane<D>> {
    let upper = model.grid.domain_upper();
    let mut all = Vec::new();
    for a in 0..D {
        for (up, wall) in model.walls[a].iter().enumerate() {
            if *wall == Wall::Slip {
                let sign = 1.0 - 2.0 * up as f64;
                let normal = Vector::from_fn(|b, _| if a == b { sign } else { 0.0 });
                all.push(Plane { point: if up == 0 { Vector::zeros() } else { upper }, normal });
            }
        }
    }
    all
}

/// Initial speed of a solid, or the maximum speed of its prescribed motion, m/s.
fn initial_speed<const D: usize>(solid: &Solid<D>) -> f64 {
    match &solid.kind {
        SolidKind::Prescribed(path) => {
            let between = |k: &[(f64, Vector<D>); 2]| (k[1].1 - k[0].1).norm() / (k[1].0 - k[0].0);
            let frames = path.keyframes.array_windows().map(between);
            let start = RigidKinematics { velocity: path.velocity, ..solid.initial_state().as_rigid() };
            frames.fold(solid.max_rigid_speed(&start), f64::max)
        }
        _ => solid.initial_velocity.norm(),
    }
}

/// Points of each rigid solid that are tested against each other one.
fn probe_sets<const D: usize>(model: &Model<D>) -> BTreeMap<(usize, usize), ProbeSet> {
    let size = |k: usize| {
        let (low, high) = model.solids[k].shape.bounds();
        (high - low).norm()
    };
    let rigid: Vec<usize> =
        (0..model.solids.len()).filter(|k| model.solids[*k].elastic().is_none()).collect();
    let round = |k: usize| matches!(model.solids[k].shape, Shape::Ball { .. } | Shape::Capsule { .. });
    let mut all = BTreeMap::new();
    for i in &rigid {
        for j in rigid.iter().filter(|j| *j < i) {
            let (small, large) = if size(*i) <= size(*j) { (*i, *j) } else { (*j, *i) };
            all.insert((small, large), ProbeSet::All);
            let centred = round(small) && model.solids[large].shape.is_convex();
            all.insert((large, small), if centred { ProbeSet::None } else { ProbeSet::Exposed });
        }
    }
    all
}
