//! Overlaps of deformable solids in a given configuration. A run cannot start with any.

use super::Overlap;
use super::surfaces::DeformableSurfaces;
use crate::model::Wall;
use crate::solid::Solids;
use meniscus_contact::broad_phase::{Aabb, overlapping_pairs};
use meniscus_numerics::Vector;
use meniscus_numerics::mesh::VolumeMesh;
use meniscus_numerics::mesh::bvh::closest_on_facet;
use meniscus_numerics::mesh::surface::area_vector;
use meniscus_numerics::mesh::volume::Simplex;
use meniscus_numerics::shape::SurfaceSample;

/// Overlaps of deformable solids with sides, rigid solids, each other and themselves. Anchored vertices may be beyond a side or inside a
/// solid with prescribed motion.
pub fn deformable_overlaps<const D: usize>(
    solids: Solids<'_, D>,
    probes: &[Vec<SurfaceSample<D>>],
) -> Vec<Overlap> {
    let (model, surfaces) = (solids.model, DeformableSurfaces::new(solids));
    let mut all = Vec::new();
    for (i, one) in solids.iter().enumerate() {
        let Some((elastic, body)) = one.elastic().zip(one.state.as_deformable()) else { continue };
        let vertices = &one.surface.mesh.positions;
        let is_anchored = |k: usize| elastic.anchored()[one.surface.volume_vertices()[k] as usize];
        let unanchored: Vec<Vector<D>> =
            (0..vertices.len()).filter(|k| !is_anchored(*k)).map(|k| vertices[k]).collect();
        let upper = model.grid.domain_upper();
        let beyond = |x: &Vector<D>| {
            let side = |a: usize| {
                let past =
                    |wall: Wall, depth: f64| if wall == Wall::Slip { depth } else { f64::NEG_INFINITY };
                past(model.walls[a][0], -x[a]).max(past(model.walls[a][1], x[a] - upper[a]))
            };
            (0..D).map(side).fold(f64::NEG_INFINITY, f64::max)
        };
        all.push((i, None, unanchored.iter().map(beyond).fold(0.0, f64::max)));
        for (j, other) in
            solids.iter().enumerate().filter(|(j, _)| *j != i && model.wetting_wall_solid() != Some(*j))
        {
            let within = |x: &Vector<D>| -other.distance(x);
            // Anchored vertices may lie inside a solid with prescribed motion.
            let is_prescribed = other.kind.is_prescribed();
            let mut depth =
                if is_prescribed { &unanchored } else { vertices }.iter().map(within).fold(0.0, f64::max);
            let is_anchored_inside =
                is_prescribed && (0..vertices.len()).any(|k| is_anchored(k) && within(&vertices[k]) >= 0.0);
            if let Some(rigid) = other.state.rigid()
                && !is_anchored_inside
            {
                let at = |p: &SurfaceSample<D>| other.to_current(rigid, &p.position);
                let inside = |p: &SurfaceSample<D>| p.radius - one.surface.distance(&at(p));
                depth = probes[j].iter().map(inside).fold(depth, f64::max);
            }
            // Coincident surfaces are ambiguous; element centres are not.
            depth = element_centers(&body.vertices.positions, elastic.rest_mesh(), other.bounds())
                .filter(|_| !is_anchored_inside)
                .map(|x| within(&x))
                .fold(depth, f64::max);
            all.push((i, Some(j), depth));
        }
    }
    all.extend(surface_crossings(&surfaces));
    all.retain(|o| o.2 > 0.0);
    all
}

/// Current centres of the elements that lie within a box.
fn element_centers<const D: usize>(
    now: &[Vector<D>],
    mesh: &VolumeMesh<D>,
    [low, high]: [Vector<D>; 2],
) -> impl Iterator<Item = Vector<D>> {
    let middle = |s: &Simplex<D>| s.vertices().map(|v| now[v as usize]).sum::<Vector<D>>() / (D + 1) as f64;
    let inside = move |x: &Vector<D>| (0..D).all(|a| low[a] < x[a] && x[a] < high[a]);
    mesh.simplices.iter().map(middle).filter(inside)
}

/// Crossings of surfaces, including self-intersections.
fn surface_crossings<const D: usize>(skins: &DeformableSurfaces<D>) -> Vec<Overlap> {
    let lines: Vec<[u32; 2]> = match D {
        2 => skins.facets.iter().map(|f| [f[0], f[1]]).collect(),
        _ => skins.edges.clone(),
    };
    let place = |p: u32| skins.positions[p as usize];
    let around = |points: &[u32]| -> Aabb<D> {
        let first = place(points[0]);
        points.iter().fold([first; 2], |all, p| [all[0].inf(&place(*p)), all[1].sup(&place(*p))])
    };
    let boxes: Vec<_> = lines.iter().map(|l| around(l)).collect();
    let facets: Vec<_> = skins.facets.iter().map(|f| around(f)).collect();
    let crossing = |(line, facet): (u32, u32)| {
        let (line, facet) = (lines[line as usize], skins.facets[facet as usize]);
        if line.iter().any(|p| facet.contains(p)) {
            return None;
        }
        let depth = crossing_depth(line.map(place), &facet.map(place))?;
        let [one, other] = [line[0], facet[0]].map(|p| skins.owner[p as usize]);
        Some((one, Some(other), depth))
    };
    overlapping_pairs(&boxes, &facets).into_iter().filter_map(crossing).collect()
}

/// Depth by which a line crosses a facet, m: the distance of the nearer end from its plane; `None` if they do not cross.
fn crossing_depth<const D: usize>(line: [Vector<D>; 2], facet: &[Vector<D>; D]) -> Option<f64> {
    let normal = area_vector(facet).try_normalize(0.0)?;
    let [from, to] = line.map(|x| (x - facet[0]).dot(&normal));
    if from * to >= 0.0 {
        return None;
    }
    let x = line[0] + (line[1] - line[0]) * (from / (from - to));
    let aside = (closest_on_facet(facet, &x).0 - x).norm();
    (aside <= 1e-12 * (line[1] - line[0]).norm()).then(|| from.abs().min(to.abs()))
}
