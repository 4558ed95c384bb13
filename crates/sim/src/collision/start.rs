//! Points of a model's solids where these start, and how near they are to each other.

use super::broad_phase::{Candidates, Way};
use super::places::Places;
use super::points::{Owner, Points, Probing, REACH};
use crate::model::{Model, Wall};
use crate::solid::{Motion, Solid, SolidState};
use meniscus_contact::{Near, Plane, Surface};
use meniscus_elastic::{Assembly, Elastic};
use meniscus_numerics::Vector;
use meniscus_numerics::mesh::surface::area_vector;
use meniscus_numerics::shape::Shape;
use std::collections::BTreeMap;

/// The least reach of a point, over [`REACH`]: one that touches something at the start needs some distance over which the barrier
/// rises, and the barrier's energy of a contact is proportional to it.
const LEAST: f64 = 0.1;
/// Distance of probes of rigid solids, in cells: a surface of a radius of five cells bulges out between them by less than 0.01 cells.
const EDGE: f64 = 0.5;
impl<const D: usize> Points<D> {
    /// Of a model.
    pub fn of(model: &Model<D>) -> Self {
        let (mut owners, mut facets, mut rest, mut bodies) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let (mut first, mut nodes) = (Vec::new(), 0);
        for (solid, is) in model.solids.iter().enumerate() {
            first.push(nodes);
            nodes += is.elastic().map_or(2, |elastic| elastic.masses().len());
            let Some(elastic) = is.elastic() else { continue };
            let (surface, vertices) = elastic.mesh().surface();
            let from = owners.len() as u32;
            owners.extend(vertices.iter().map(|v| Owner::Vertex { solid, vertex: *v as usize }));
            rest.extend_from_slice(&surface.positions);
            facets.extend(surface.facets.iter().map(|f| f.map(|v| v + from)));
        }
        bodies.extend(owners.iter().map(|o: &Owner<D>| o.solid() as u32));
        let (edge, mut probes, mut exposed) = (EDGE * model.grid.dx, Vec::new(), vec![true; owners.len()]);
        for (solid, is) in model.solids.iter().enumerate() {
            if is.elastic().is_some() || model.wetting_walls() == Some(solid) {
                continue;
            }
            for probe in is.shape.probes(edge) {
                probes.push((owners.len() as u32, edge.powi(D as i32 - 1), probe.radius));
                owners.push(Owner::Rigid { solid, at: probe.at });
                rest.push(probe.at);
                bodies.push(solid as u32);
                exposed.push(probe.sharp || probe.radius > 0.0);
            }
        }
        let surface = Surface::new(facets, &rest, bodies).with_points(probes);
        let mut areas = vec![0.0; model.solids.len()];
        surface.points().iter().for_each(|p| areas[owners[*p as usize].solid()] += surface.area(*p));
        let fastest = model.solids.iter().map(start_speed).fold(0.0, f64::max);
        let stop = 0.5 * fastest * fastest / (REACH * model.grid.dx);
        let pressure = |(solid, area): (&Solid<D>, &f64)| {
            let told = solid.motion.is_told() || *area == 0.0;
            let weight = model.gravity.norm() * (2 * D) as f64;
            if told { 0.0 } else { solid.body.mass * (weight + stop) / area }
        };
        let pressures = model.solids.iter().zip(&areas).map(pressure).collect();
        let faces = areas.iter().map(|area| area / (2 * D) as f64).collect();
        let held = held(model);
        let deforming = model.solids.iter().zip(&first).filter_map(|(s, first)| Some((*first, s.elastic()?)));
        let deforming: Vec<(usize, &Elastic<D>)> = deforming.collect();
        let assembly = Assembly::new(&deforming, held.clone());
        let (sides, lifts, probing) = (sides(model), BTreeMap::new(), probing(model));
        let mut all =
            Self { surface, owners, first, held, pressures, faces, sides, lifts, probing, exposed, assembly };
        all.fit_to_start(model);
        all
    }

    /// Reduces the reach of points that are within the barrier's reach of something at the start to that distance, so that no contact
    /// pushes at the start. No reach is less than a part [`LEAST`] of the barrier's.
    fn fit_to_start(&mut self, model: &Model<D>) {
        let (reach, still) = (REACH * model.grid.dx, vec![Vector::zeros(); self.nodes()]);
        let start: Vec<SolidState<D>> = model.solids.iter().map(Solid::start).collect();
        let places = Places::new(model, &start, self, &still, 0.0);
        let at = places.all();
        let near = Candidates::on(&[Way { from: &places, to: &places }], reach, 0.0).near;
        self.draw_back(&near, &at, LEAST * reach);
        let places = Places::new(model, &start, self, &still, 0.0);
        let at = places.all();
        let candidates = Candidates::on(&[Way { from: &places, to: &places }], reach, 0.0);
        let mut reaches = candidates.near.least_distances(&at);
        let mut lifts = BTreeMap::new();
        for meeting in &candidates.meetings {
            let p = meeting.point();
            let distance = meeting.distance(&places, &at[p as usize]) - self.surface.radius(p);
            let nearest = LEAST * reach;
            if distance < nearest {
                lifts.insert(*meeting, nearest - distance);
            }
            reaches[p as usize] = reaches[p as usize].min(distance.max(nearest));
        }
        reaches.iter_mut().for_each(|r| *r = if *r < reach { r.max(LEAST * reach) } else { f64::INFINITY });
        self.surface = std::mem::take(&mut self.surface).with_reaches(reaches);
        self.lifts = lifts;
    }

    /// Draws points of rigid solids that touch facets at the start back into their solids, to a distance of `least` (m).
    fn draw_back(&mut self, near: &Near, at: &[Vector<D>], least: f64) {
        let mut moves: BTreeMap<u32, (f64, Vector<D>)> = BTreeMap::new();
        for (stencil, gap) in near.gaps(at).filter(|(_, gap)| *gap < least) {
            let (point, rest) = (stencil.points()[0], stencil.points().get(stencil.kind.first()..));
            let Some(facet) = rest.and_then(|rest| <[u32; D]>::try_from(rest).ok()) else { continue };
            let outward = area_vector(&facet.map(|p| at[p as usize])).try_normalize(0.0);
            let known = moves.get(&point).is_some_and(|(known, _)| *known <= gap);
            if let Some(outward) = outward.filter(|_| !known && stencil.kind.first() == 1) {
                moves.insert(point, (gap, outward));
            }
        }
        for (point, (gap, outward)) in moves {
            if let Owner::Rigid { at, .. } = &mut self.owners[point as usize] {
                *at += outward * (least - gap);
            }
        }
    }
}

/// The numbers of two solids, and the gap between them, m.
type Gap = (usize, usize, f64);
/// The number of a solid, that of another one (none for a side of the domain), and the gap between them, m.
type GapOfRigid = (usize, Option<usize>, f64);

/// All gaps below the barrier's reach: between facets and points, and between points and rigid solids or sides.
fn gaps<const D: usize>(model: &Model<D>, solids: &[SolidState<D>]) -> (Vec<Gap>, Vec<GapOfRigid>) {
    let points = Points::of(model);
    let still = vec![Vector::zeros(); points.nodes()];
    let places = Places::new(model, solids, &points, &still, 0.0);
    let found = Candidates::on(&[Way { from: &places, to: &places }], REACH * model.grid.dx, 0.0);
    let at = places.all();
    let solid = |point: u32| points.owners[point as usize].solid();
    let facets = found.near.gaps(&at).map(|(stencil, gap)| {
        let points = stencil.points();
        (solid(points[0]), solid(points[stencil.kind.first()]), gap)
    });
    let rigid = found.meetings.iter().map(|m| {
        let gap = m.distance(&places, &at[m.point() as usize]) - points.thickness(m);
        (solid(m.point()), m.solid(), gap)
    });
    (facets.collect(), rigid.collect())
}

/// The narrowest gap, m, between surfaces of solids that deform, each other's or their own, where they start, with the numbers of the
/// two solids; nothing where all gaps are wider than the barrier's reach. A run needs a gap: the barrier is infinite where there is none.
pub fn narrowest_gap<const D: usize>(model: &Model<D>) -> Option<(usize, usize, f64)> {
    let start: Vec<SolidState<D>> = model.solids.iter().map(Solid::start).collect();
    gaps(model, &start).0.into_iter().min_by(|a, b| a.2.total_cmp(&b.2))
}

/// The narrowest gap, m, between a solid and another one, itself, or a closed side of the domain, as they are now, with their numbers (none
/// for a side); nothing where all gaps are wider than the barrier's reach.
pub fn narrowest_gap_now<const D: usize>(
    model: &Model<D>,
    solids: &[SolidState<D>],
) -> Option<(usize, Option<usize>, f64)> {
    let (facets, rigid) = gaps(model, solids);
    let facets = facets.into_iter().map(|(one, other, gap)| (one, Some(other), gap));
    facets.chain(rigid).min_by(|a, b| a.2.total_cmp(&b.2))
}

/// The closed sides of the domain.
fn sides<const D: usize>(model: &Model<D>) -> Vec<Plane<D>> {
    let upper = model.grid.upper();
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

/// The speed with which a solid starts, or the largest with which it goes as told, m/s.
fn start_speed<const D: usize>(solid: &Solid<D>) -> f64 {
    match &solid.motion {
        Motion::Given(path) => {
            let between = |k: &[(f64, Vector<D>); 2]| (k[1].1 - k[0].1).norm() / (k[1].0 - k[0].0);
            let frames = path.keyframes.array_windows().map(between);
            let start = solid.start();
            frames.fold(solid.largest_speed(&SolidState { velocity: path.velocity, ..start }), f64::max)
        }
        _ => solid.velocity.norm(),
    }
}

/// How each rigid solid is probed against each other one.
fn probing<const D: usize>(model: &Model<D>) -> BTreeMap<(usize, usize), Probing> {
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
            all.insert((small, large), Probing::All);
            let centred = round(small) && model.solids[large].shape.is_convex();
            all.insert((large, small), if centred { Probing::None } else { Probing::Exposed });
        }
    }
    all
}

/// Which nodes have velocities that are told.
fn held<const D: usize>(model: &Model<D>) -> Vec<bool> {
    let of = |solid: &Solid<D>| match solid.elastic() {
        Some(elastic) => elastic.held().to_vec(),
        None => vec![solid.motion.is_told(); 2],
    };
    model.solids.iter().flat_map(of).collect()
}
