//! Deformation of a solid: displacements, tip, midline, wetted share, and the ridge pulled up by a contact line.
//!
//! The input is the solid's surface in one frame with the displacement of each vertex. Without stored displacements the first frame
//! serves as the reference configuration: its vertices are the same.

use crate::measure::deformed_surface::DeformedSurface;
use std::f64::consts::FRAC_1_SQRT_2;

use meniscus_numerics::fit::RigidTransform;
use meniscus_numerics::mesh::ply::PlyMesh;
use meniscus_numerics::{Matrix, Vector};
use serde::Serialize;

use super::midline::{self, Midline};
use crate::error;
use crate::folder::{Frame, RunFolder};

/// Ratio of deformation to size attributed to rounding: the solid is rigid or has not moved yet.
const RIGID_TOLERANCE: f64 = 1e-7;
/// Ratio of displacement to size below which a vertex is anchored.
const ANCHORED_TOLERANCE: f64 = 1e-12;
/// Difference of distances, relative to the size, within which vertices count as equally far.
const EQUAL_DISTANCE_TOLERANCE: f64 = 1e-6;
/// Reach of the ridge profile on both sides of the line, and its step, in cells. `phi_c` is cut off at five cells, so the reach
/// is smaller.
const PROFILE_REACH_CELLS: f64 = 4.5;
const PROFILE_STEP_CELLS: f64 = 0.5;
/// Largest number of anchored vertices from which distances are measured.
const MAX_ANCHOR_SAMPLES: usize = 2000;
/// Relative difference of two moments below which a plate counts as square.
const ISOTROPY_TOLERANCE: f64 = 0.02;
/// Ratio of the norm of the area vector around a vertex to its area, below which the vertex is on a sharp edge.
const RIM_THRESHOLD: f64 = 0.9;

/// Deformation of a solid. Lengths in m, angles in degrees.
#[derive(Clone, Debug, Serialize)]
pub struct SoftMeasure {
    /// Largest displacement of the surface.
    pub largest_displacement: f64,
    /// Area-weighted mean displacement of the surface.
    pub mean_displacement: f64,
    /// Largest displacement after subtraction of the best-fitting rigid motion; without subtraction if the solid is anchored.
    pub largest_deflection: f64,
    /// Area-weighted mean of these displacements.
    pub mean_deflection: f64,
    /// Whether part of the surface is anchored; the deflections are then the displacements.
    pub held: bool,
    /// Tip: the part of the reference surface farthest from the anchored part, or from the centroid; its current position. `None` if
    /// the anchored part is unknown because nothing has moved by the last frame.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tip: Option<[f64; 3]>,
    /// Displacement of the tip.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tip_displacement: Option<[f64; 3]>,
    /// Why there is no tip.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tip_reason: Option<&'static str>,
    /// Wetted share of the surface, 0 to 1, if the contact line is stored.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wetted: Option<f64>,
    /// Midline of a plate or strip; `None` for other solids.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub strip: Option<Midline>,
    /// Ridge pulled up by the contact line, if there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ridge: Option<Ridge>,
    /// Why there is no ridge.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ridge_reason: Option<&'static str>,
}

/// Ridge along a contact line.
#[derive(Clone, Debug, Serialize)]
pub struct Ridge {
    /// Height of the ridge: value of the profile at the line minus the mean of its ends.
    pub height: f64,
    /// Distance from the line along the surface (negative where wetted) and mean normal displacement there.
    pub profile: Vec<[f64; 2]>,
}

/// Measures a solid of a frame; `None` for a rigid one.
pub(super) fn measure(
    folder: &RunFolder,
    frame: &Frame,
    name: &str,
    dx: f64,
) -> error::Result<Option<SoftMeasure>> {
    let Some(now) = frame.solids.get(name) else { return Ok(None) };
    let last = folder.frame_numbers[folder.frame_numbers.len() - 1];
    let last = if last == frame.number { None } else { folder.frame(last)?.solids.remove(name) };
    let last = last.filter(|mesh| mesh.positions.len() == now.positions.len());
    if let Some(start) = rest_surface(now) {
        return Ok(Some(DeformedSurface::new(&start, now, last.as_ref()).measure(now, dx)));
    }
    let first = folder.frame(folder.frame_numbers[0])?;
    let Some(start) = first.solids.get(name) else { return Ok(None) };
    if start.positions.len() != now.positions.len()
        || start.faces != now.faces
        || start.edges != now.edges
        || start.positions.is_empty()
    {
        return Ok(None);
    }
    let surfaces = DeformedSurface::new(start, now, last.as_ref());
    Ok(surfaces.is_deformed().then(|| surfaces.measure(now, dx)))
}

/// The reference surface from stored displacements; `None` without them.
fn rest_surface(now: &PlyMesh) -> Option<PlyMesh> {
    let mut start = now.clone();
    for (a, name) in ["ux", "uy", "uz"].into_iter().enumerate() {
        let displacement =
            now.scalars.get(name).filter(|u| u.len() == now.positions.len() && !u.is_empty())?;
        start.positions.iter_mut().zip(displacement).for_each(|(x, u)| x[a] -= u);
    }
    Some(start)
}

impl DeformedSurface {
    fn new(start: &PlyMesh, now: &PlyMesh, last: Option<&PlyMesh>) -> Self {
        let points =
            |mesh: &PlyMesh| mesh.positions.iter().map(|p| Vector::<3>::from(*p)).collect::<Vec<_>>();
        let is_planar = start.faces.is_empty();
        let (start_at, now_at) = (points(start), points(now));
        let facets: Vec<[u32; 3]> = if is_planar {
            start.edges.iter().map(|e| [e[0], e[1], e[0]]).collect()
        } else {
            start.faces.clone()
        };
        let area_vectors: Vec<Vector<3>> =
            facets.iter().map(|f| area_vector(&start_at, f, is_planar)).collect();
        let mut vertex_areas = vec![0.0; start_at.len()];
        let corners = if is_planar { 2 } else { 3 };
        for (facet, area) in facets.iter().zip(&area_vectors) {
            facet[..corners].iter().for_each(|v| vertex_areas[*v as usize] += area.norm() / corners as f64);
        }
        let (low, high) = start_at.iter().fold((start_at[0], start_at[0]), |(l, h), x| (l.inf(x), h.sup(x)));
        let size = (high - low).max();
        let is_unmoved =
            |to: &[Vector<3>], v: usize| (start_at[v] - to[v]).norm() <= ANCHORED_TOLERANCE * size;
        let last_at = last.map(points);
        let stays =
            |v: usize| is_unmoved(&now_at, v) && last_at.as_ref().is_none_or(|last| is_unmoved(last, v));
        let mut anchored: Vec<bool> = (0..start_at.len()).map(stays).collect();
        if !anchored.contains(&false) {
            anchored.clear();
        }
        let deformed = if anchored.contains(&true) {
            now_at.clone()
        } else {
            let motion = RigidTransform::fit(&start_at, &now_at);
            now_at.iter().map(|x| motion.inverse_transformed(x)).collect()
        };
        Self {
            reference: start_at,
            current: now_at,
            deformed,
            facets,
            area_vectors,
            vertex_areas,
            anchored,
            size,
            is_planar,
        }
    }

    /// Largest and area-weighted mean distance of the vertices `to` from the reference configuration, m.
    fn max_and_mean_displacement(&self, to: &[Vector<3>]) -> (f64, f64) {
        let displacement = |k: usize| (to[k] - self.reference[k]).norm();
        let all: f64 = self.vertex_areas.iter().sum();
        let sum: f64 = (0..to.len()).map(|k| self.vertex_areas[k] * displacement(k)).sum();
        ((0..to.len()).map(displacement).fold(0.0, f64::max), sum / all)
    }

    /// Whether the deformation exceeds rounding.
    fn is_deformed(&self) -> bool {
        self.max_and_mean_displacement(&self.deformed).0 > RIGID_TOLERANCE * self.size
    }

    /// All measurements.
    fn measure(&self, mesh: &PlyMesh, dx: f64) -> SoftMeasure {
        let (largest_displacement, mean_displacement) = self.max_and_mean_displacement(&self.current);
        let (largest_deflection, mean_deflection) = self.max_and_mean_displacement(&self.deformed);
        let tip = (!self.anchored.is_empty()).then(|| self.tip());
        let phi = mesh.scalars.get("phi_c").filter(|phi| phi.len() == self.current.len());
        let ridge = phi.map_or(Err("no contact line is stored"), |phi| self.ridge(phi, dx));
        SoftMeasure {
            largest_displacement,
            mean_displacement,
            largest_deflection,
            mean_deflection,
            held: self.anchored.contains(&true),
            tip: tip.map(|tip| tip.0.into()),
            tip_displacement: tip.map(|tip| tip.1.into()),
            tip_reason: tip.is_none().then_some("the solid has not moved yet, so its held part is unknown"),
            wetted: phi.and_then(|phi| self.wetted(phi)),
            strip: midline::midline(self),
            ridge_reason: ridge.as_ref().err().copied(),
            ridge: ridge.ok(),
        }
    }

    /// Current position and displacement of the tip, m.
    fn tip(&self) -> (Vector<3>, Vector<3>) {
        let held: Vec<Vector<3>> =
            self.reference.iter().zip(&self.anchored).filter(|(_, held)| **held).map(|(x, _)| *x).collect();
        let some: Vec<&Vector<3>> =
            held.iter().step_by(held.len().div_ceil(MAX_ANCHOR_SAMPLES).max(1)).collect();
        let middle = self.reference.iter().zip(&self.vertex_areas).map(|(x, w)| x * *w).sum::<Vector<3>>()
            / self.vertex_areas.iter().sum::<f64>();
        let far = |x: &Vector<3>| match some.is_empty() {
            true => (x - middle).norm(),
            false => some.iter().map(|h| (x - *h).norm()).fold(f64::INFINITY, f64::min),
        };
        let distances: Vec<f64> = self.reference.iter().map(far).collect();
        let farthest = distances.iter().copied().fold(0.0, f64::max);
        let mut sums = (Vector::<3>::zeros(), Vector::<3>::zeros(), 0.0);
        for k in
            (0..distances.len()).filter(|k| distances[*k] >= farthest - EQUAL_DISTANCE_TOLERANCE * self.size)
        {
            sums.0 += self.current[k];
            sums.1 += self.current[k] - self.reference[k];
            sums.2 += 1.0;
        }
        (sums.0 / sums.2, sums.1 / sums.2)
    }

    /// Wetted share of the current surface, where the distance to the line, linear on each facet, is negative.
    fn wetted(&self, phi: &[f64]) -> Option<f64> {
        let (mut wet, mut all) = (0.0, 0.0);
        for facet in &self.facets {
            let size = area_vector(&self.current, facet, self.is_planar).norm();
            let mut at: Vec<f64> = facet[..self.corners()].iter().map(|v| phi[*v as usize]).collect();
            at.sort_by(f64::total_cmp);
            if at.iter().any(|v| v.is_nan()) {
                return None;
            }
            all += size;
            wet += size * negative_share(&at);
        }
        (all > 0.0).then(|| wet / all)
    }

    /// Profile of the ridge around the line, or why there is none. A ridge has its maximum at the line. Bending of the whole solid has
    /// no maximum there, and the profile must not extend around an edge.
    fn ridge(&self, phi: &[f64], dx: f64) -> Result<Ridge, &'static str> {
        if self.has_edge_near_line(phi, PROFILE_REACH_CELLS * dx) {
            return Err("the contact line is at an edge of the solid");
        }
        let bins = (2.0 * PROFILE_REACH_CELLS / PROFILE_STEP_CELLS).round() as usize + 1;
        let mut sums = vec![[0.0; 2]; bins];
        for (k, normal) in self.normals().iter().enumerate().filter(|n| n.1.norm() > 0.5) {
            let place = (phi[k] / dx + PROFILE_REACH_CELLS) / PROFILE_STEP_CELLS;
            if place.is_finite() && place > -0.5 && place < bins as f64 - 0.5 {
                let bin = &mut sums[place.round().max(0.0) as usize];
                bin[0] += self.vertex_areas[k];
                bin[1] += self.vertex_areas[k] * (self.deformed[k] - self.reference[k]).dot(normal);
            }
        }
        let told = sums.iter().enumerate().filter(|(_, sum)| sum[0] > 0.0);
        let profile: Vec<[f64; 2]> = told
            .map(|(k, sum)| [(k as f64 * PROFILE_STEP_CELLS - PROFILE_REACH_CELLS) * dx, sum[1] / sum[0]])
            .collect();
        let next = profile.iter().position(|p| p[0] >= 0.0).unwrap_or(0);
        let (Some(first), Some(last), true) = (profile.first(), profile.last(), next > 0) else {
            return Err("there is no contact line");
        };
        let (a, b) = (profile[next - 1], profile[next]);
        let at_line = a[1] + (b[1] - a[1]) * (-a[0] / (b[0] - a[0]));
        let crest = profile.iter().max_by(|p, q| p[1].total_cmp(&q[1])).map_or(f64::NAN, |p| p[0]);
        // The profile is resolved to half a step.
        if crest.abs() > PROFILE_STEP_CELLS * dx || last[0] <= 0.0 {
            return Err(
                "the surface is not highest along the contact line: the solid is bent, or has no ridge there",
            );
        }
        Ok(Ridge { height: at_line - 0.5 * (first[1] + last[1]), profile })
    }

    /// Whether an edge of the solid within `reach` (m) of the contact line runs more along it than across; in 2D whether a corner
    /// lies within reach.
    fn has_edge_near_line(&self, phi: &[f64], reach: f64) -> bool {
        let normals = self.normals();
        let near = |v: u32| normals[v as usize] == Vector::<3>::zeros() && phi[v as usize].abs() < reach;
        if self.is_planar {
            return (0..normals.len() as u32).any(near);
        }
        let along = |a: u32, b: u32| {
            let edge_length = (self.reference[a as usize] - self.reference[b as usize]).norm();
            near(a) && near(b) && (phi[a as usize] - phi[b as usize]).abs() < edge_length * FRAC_1_SQRT_2
        };
        self.facets.iter().any(|f| along(f[0], f[1]) || along(f[1], f[2]) || along(f[2], f[0]))
    }

    /// Unit outward normals of the vertices in the reference configuration; zero on sharp edges.
    fn normals(&self) -> Vec<Vector<3>> {
        let corners = self.corners();
        let mut sums = vec![Vector::<3>::zeros(); self.reference.len()];
        for (facet, area) in self.facets.iter().zip(&self.area_vectors) {
            facet[..corners].iter().for_each(|v| sums[*v as usize] += area);
        }
        let even = |(n, w): (&Vector<3>, &f64)| n.norm() > RIM_THRESHOLD * w * corners as f64;
        let normal = |(n, w)| if even((n, w)) { n.normalize() } else { Vector::zeros() };
        sums.iter().zip(&self.vertex_areas).map(normal).collect()
    }

    /// Number of corners of a facet.
    fn corners(&self) -> usize {
        if self.is_planar { 2 } else { 3 }
    }

    /// Second moments of the reference surface about its centroid, m⁴ (2D: m³).
    fn moments(&self) -> Matrix<3> {
        let all: f64 = self.vertex_areas.iter().sum();
        let middle =
            self.reference.iter().zip(&self.vertex_areas).map(|(x, w)| x * *w).sum::<Vector<3>>() / all;
        let n = self.corners() as f64;
        let mut moments = Matrix::<3>::zeros();
        for (facet, area) in self.facets.iter().zip(&self.area_vectors) {
            let at = facet.map(|v| self.reference[v as usize] - middle);
            let sum = at[..self.corners()].iter().sum::<Vector<3>>();
            // Exact on a facet: ∫ x xᵀ = A/(n(n+1)) (Σ xᵢ xᵢᵀ + s sᵀ), s = Σ xᵢ.
            let own: Matrix<3> = at[..self.corners()].iter().map(|x| x * x.transpose()).sum();
            moments += (own + sum * sum.transpose()) * (area.norm() / (n * (n + 1.0)));
        }
        moments
    }

    /// Principal axes by decreasing moment, and extents of the reference surface along them. In 2D the third axis is normal to the
    /// plane.
    pub fn axes(&self) -> ([Vector<3>; 3], [f64; 3]) {
        let eigen = self.moments().symmetric_eigen();
        let mut order = [0, 1, 2];
        order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]));
        let mut axes = order.map(|k| eigen.eigenvectors.column(k).into_owned());
        let [one, two, _] = order.map(|k| eigen.eigenvalues[k]);
        if !self.is_planar && two > (1.0 - ISOTROPY_TOLERANCE) * one {
            // For a square plate choose the axes along the coordinates.
            let within = |a: usize| {
                let e = Vector::<3>::from_fn(|b, _| if a == b { 1.0 } else { 0.0 });
                e - axes[2] * axes[2].dot(&e)
            };
            let along = if within(0).norm() > 0.7 { within(0) } else { within(1) };
            axes[0] = along.normalize();
            axes[1] = axes[2].cross(&axes[0]);
        }
        let extent = |axis: &Vector<3>| {
            let along = self.reference.iter().map(|x| x.dot(axis));
            let (low, high) =
                along.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
            high - low
        };
        let extents = [extent(&axes[0]), extent(&axes[1]), extent(&axes[2])];
        (axes, extents)
    }
}

/// Area vector of a facet, m² (2D: m).
fn area_vector(points: &[Vector<3>], facet: &[u32; 3], flat: bool) -> Vector<3> {
    let [a, b, c] = facet.map(|v| points[v as usize]);
    if flat { Vector::<3>::new(b[1] - a[1], a[0] - b[0], 0.0) } else { (b - a).cross(&(c - a)) * 0.5 }
}

/// Share of a facet where a linear function with the given ascending corner values is negative.
fn negative_share(at: &[f64]) -> f64 {
    match at {
        [a, b] if *a < 0.0 && *b >= 0.0 => a / (a - b),
        [a, b, c] if *a < 0.0 && *b >= 0.0 => a * a / ((a - b) * (a - c)),
        [a, b, c] if *b < 0.0 && *c >= 0.0 => 1.0 - c * c / ((c - a) * (c - b)),
        all => f64::from(u8::from(all.iter().all(|v| *v < 0.0))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_of_facets_are_exact() {
        assert_eq!(negative_share(&[-1.0, 3.0]), 0.25);
        assert_eq!(negative_share(&[-1.0, 1.0, 1.0]), 0.25);
        assert_eq!(negative_share(&[-1.0, -1.0, 1.0]), 0.75);
        assert_eq!(negative_share(&[-2.0, -1.0, -0.5]), 1.0);
        assert_eq!(negative_share(&[0.0, 1.0, 2.0]), 0.0);
    }
}
