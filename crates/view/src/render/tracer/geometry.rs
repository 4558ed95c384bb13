//! Ray intersection with triangle meshes and capsules.

use meniscus_numerics::mesh::ply::PlyMesh;

use super::bvh::{Bvh, Ray};
use crate::folder::{Bounds, V3};

/// Intersection of a ray with a surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hit {
    pub t: f64,
    /// Outward normal of the facet.
    pub geometric_normal: V3,
    /// Interpolated outward normal.
    pub shading_normal: V3,
    /// Whether the facet touches something opaque (see [`TriMesh::new`]).
    pub wetted: bool,
    /// Tint of the surface, 0 (plain colour) to 1.
    pub tint: f64,
}

#[derive(Clone, Copy, Debug)]
struct Triangle {
    a: V3,
    ab: V3,
    ac: V3,
    corners: [u32; 3],
    wetted: bool,
    tint: [f64; 3],
}

/// A triangle mesh with interpolated normals.
#[derive(Debug, Default)]
pub(crate) struct TriMesh {
    bvh: Bvh,
    triangles: Vec<Triangle>,
    normals: Vec<V3>,
}

impl TriMesh {
    /// A mesh of points in picture coordinates. A facet is wetted if `wetted` is true at all its vertices. Edges sharper than
    /// `crease` (cosine) stay sharp. `tint` is that of each vertex, 0 (none) to 1; there is none where it is too short.
    pub(crate) fn new(points: &[V3], faces: &[[u32; 3]], wetted: &[bool], tint: &[f64], crease: f64) -> Self {
        let (normals, corners) = corner_normals(points, faces, crease);
        let mut boxes = Vec::with_capacity(faces.len());
        let mut all = Vec::with_capacity(faces.len());
        for (face, corners) in faces.iter().zip(corners) {
            let [a, b, c] = face.map(|i| points[i as usize]);
            if (b - a).cross(&(c - a)).norm_squared() <= 0.0 {
                continue;
            }
            let mut bounds = Bounds::EMPTY;
            [a, b, c].into_iter().for_each(|p| bounds.add(p));
            boxes.push(bounds);
            let wetted = face.iter().all(|&i| wetted.get(i as usize).copied().unwrap_or(false));
            let tint = face.map(|i| tint.get(i as usize).copied().unwrap_or(0.0));
            all.push(Triangle { a, ab: b - a, ac: c - a, corners, wetted, tint });
        }
        let bvh = Bvh::new(&boxes);
        let triangles = bvh.order().iter().map(|&i| all[i as usize]).collect();
        Self { bvh, triangles, normals }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }

    /// The first hit with `least < t < limit`.
    pub(crate) fn hit(&self, ray: &Ray, least: f64, limit: f64) -> Option<Hit> {
        let mut best = None;
        self.bvh.visit(ray, limit, |place, limit| match self.triangles[place].intersect(ray) {
            Some((t, u, v)) if t > least && t < limit => {
                best = Some((place, t, u, v));
                t
            }
            _ => limit,
        });
        let (place, t, u, v) = best?;
        let tri = &self.triangles[place];
        let geometric_normal = tri.ab.cross(&tri.ac).normalize();
        let [a, b, c] = tri.corners.map(|i| self.normals[i as usize]);
        let shading_normal =
            (a * (1.0 - u - v) + b * u + c * v).try_normalize(1e-12).unwrap_or(geometric_normal);
        let tint = tri.tint[0] * (1.0 - u - v) + tri.tint[1] * u + tri.tint[2] * v;
        Some(Hit { t, geometric_normal, shading_normal, wetted: tri.wetted, tint })
    }

    /// Whether there is a hit with `least < t < limit`.
    pub(crate) fn occludes(&self, ray: &Ray, least: f64, limit: f64) -> bool {
        let mut found = false;
        self.bvh.visit(ray, limit, |place, limit| match self.triangles[place].intersect(ray) {
            Some((t, ..)) if t > least && t < limit => {
                found = true;
                -1.0
            }
            _ => limit,
        });
        found
    }
}

impl Triangle {
    /// The distance and the barycentric coordinates of the second and third corner.
    fn intersect(&self, ray: &Ray) -> Option<(f64, f64, f64)> {
        const EDGE: f64 = 1e-10;
        let p = ray.dir.cross(&self.ac);
        let det = self.ab.dot(&p);
        if det == 0.0 {
            return None;
        }
        let inverse = 1.0 / det;
        let s = ray.origin - self.a;
        let u = s.dot(&p) * inverse;
        if !(-EDGE..=1.0 + EDGE).contains(&u) {
            return None;
        }
        let q = s.cross(&self.ab);
        let v = ray.dir.dot(&q) * inverse;
        if v < -EDGE || u + v > 1.0 + EDGE {
            return None;
        }
        Some((self.ac.dot(&q) * inverse, u, v))
    }
}

/// Normals at facet corners: the mean over those facets around the vertex that are within the crease angle of the corner's
/// facet, weighted by their angle at the vertex. Equal normals are shared.
fn corner_normals(points: &[V3], faces: &[[u32; 3]], crease: f64) -> (Vec<V3>, Vec<[u32; 3]>) {
    let facet = |f: &[u32; 3]| {
        let [a, b, c] = f.map(|i| points[i as usize]);
        (b - a).cross(&(c - a)).try_normalize(1e-300).unwrap_or_else(V3::zeros)
    };
    let facets: Vec<V3> = faces.iter().map(facet).collect();
    let mut around: Vec<Vec<(u32, f64)>> = vec![Vec::new(); points.len()];
    for (f, face) in faces.iter().enumerate() {
        for k in 0..3 {
            let [p, q, r] = [0, 1, 2].map(|j| points[face[(k + j) % 3] as usize]);
            around[face[k] as usize].push((f as u32, (q - p).angle(&(r - p))));
        }
    }
    let mut normals: Vec<V3> = Vec::with_capacity(points.len());
    let mut corners = vec![[0u32; 3]; faces.len()];
    let mut own: Vec<Vec<u32>> = vec![Vec::new(); points.len()];
    for (f, face) in faces.iter().enumerate() {
        for (k, &v) in face.iter().enumerate() {
            let near =
                around[v as usize].iter().filter(|(g, _)| facets[*g as usize].dot(&facets[f]) >= crease);
            let sum = near.fold(V3::zeros(), |s, (g, angle)| s + facets[*g as usize] * *angle);
            let normal = sum.try_normalize(1e-12).unwrap_or(facets[f]);
            let known = own[v as usize].iter().find(|&&i| normals[i as usize] == normal);
            corners[f][k] = known.copied().unwrap_or_else(|| {
                normals.push(normal);
                own[v as usize].push(normals.len() as u32 - 1);
                normals.len() as u32 - 1
            });
        }
    }
    (normals, corners)
}

/// Capsules along edges.
#[derive(Debug, Default)]
pub(crate) struct Capsules {
    bvh: Bvh,
    ends: Vec<[V3; 2]>,
    radius: f64,
}

impl Capsules {
    pub(crate) fn new(points: &[V3], mesh: &PlyMesh, radius: f64) -> Self {
        let ends = |e: &[u32; 2]| e.map(|i| points[i as usize]);
        let bounds = |e: [V3; 2]| {
            let mut b = Bounds::EMPTY;
            for p in e {
                b.add(p - V3::repeat(radius));
                b.add(p + V3::repeat(radius));
            }
            b
        };
        let boxes: Vec<Bounds> = mesh.edges.iter().map(|e| bounds(ends(e))).collect();
        let bvh = Bvh::new(&boxes);
        let ends = bvh.order().iter().map(|&i| ends(&mesh.edges[i as usize])).collect();
        Self { bvh, ends, radius }
    }

    /// The first hit with `least < t < limit`.
    pub(crate) fn hit(&self, ray: &Ray, least: f64, limit: f64) -> Option<Hit> {
        let mut best: Option<(f64, V3)> = None;
        self.bvh.visit(ray, limit, |place, limit| {
            match intersect_capsule(ray, self.ends[place], self.radius) {
                Some((t, n)) if t > least && t < limit => {
                    best = Some((t, n));
                    t
                }
                _ => limit,
            }
        });
        best.map(|(t, n)| Hit { t, geometric_normal: n, shading_normal: n, wetted: false, tint: 0.0 })
    }
}

/// Distance at which a ray enters the capsule between two points, and the normal there.
fn intersect_capsule(ray: &Ray, [a, b]: [V3; 2], radius: f64) -> Option<(f64, V3)> {
    let (ba, oa) = (b - a, ray.origin - a);
    let (baba, bard, baoa) = (ba.dot(&ba), ba.dot(&ray.dir), ba.dot(&oa));
    let (rdoa, oaoa) = (ray.dir.dot(&oa), oa.dot(&oa));
    let qa = baba - bard * bard;
    let qb = baba * rdoa - baoa * bard;
    let qc = baba * oaoa - baoa * baoa - radius * radius * baba;
    let h = qb * qb - qa * qc;
    if h < 0.0 {
        return None;
    }
    let mut y = baoa;
    if qa > 1e-14 * baba {
        let t = (-qb - h.sqrt()) / qa;
        y = baoa + t * bard;
        if y > 0.0 && y < baba {
            let n = (oa + ray.dir * t - ba * (y / baba)) / radius;
            return Some((t, n));
        }
    }
    let oc = if y <= 0.0 { oa } else { ray.origin - b };
    let half = ray.dir.dot(&oc);
    let h = half * half - (oc.dot(&oc) - radius * radius);
    (h > 0.0).then(|| {
        let t = -half - h.sqrt();
        (t, (oc + ray.dir * t) / radius)
    })
}
