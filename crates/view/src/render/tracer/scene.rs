//! The surfaces of one picture, and their first intersection with a ray.

use super::bvh::Ray;
use super::geometry::{Capsules, Hit, TriMesh};
use crate::color_map::{ColorBy, linear_from_srgb};
use crate::folder::{Bounds, Frame, V3};
use crate::render::legend::ColorMapping;
use crate::render::setup::RenderSetup;
use crate::render::{RenderOptions, Style};
use crate::wetted::{Depths, move_below};
use meniscus_numerics::mesh::SurfaceMesh;
use meniscus_numerics::mesh::ply::PlyMesh;

/// Height of the drawn ground. It lies below the domain's floor, so that rays hit the bottom of the liquid first.
const GROUND_HEIGHT: f64 = -2e-4;
/// Smallest distance of a hit; closer ones belong to the surface that the ray starts from.
pub(crate) const RAY_EPSILON: f64 = 1e-6;
/// Distance by which a solid must be nearer than the liquid to be hit first.
const LIQUID_TIE_BREAK: f64 = 1e-5;
/// Half width of the contact line, in typical widths of the liquid, and its lower bound in pixels.
const LINE_RADIUS: f64 = 0.02;
const MIN_LINE_RADIUS_PIXELS: f64 = 1.1;
/// Smallest transmittance of a tinted liquid per typical width.
const MIN_TRANSMITTANCE: f64 = 0.02;

/// Object hit by a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum HitObject {
    Liquid,
    Solid(usize),
    Line,
    Ground,
}

/// All surfaces of one picture.
#[derive(Debug)]
pub(crate) struct Scene<'a> {
    pub setup: &'a RenderSetup,
    pub style: Style,
    pub liquid: TriMesh,
    pub solids: Vec<TriMesh>,
    /// Quantity shown by each solid's tint; `None` for a wetting pattern.
    pub shades: Vec<Option<ColorBy>>,
    pub line: Capsules,
    /// Bounds of the liquid.
    pub bounds: Bounds,
    /// Bounds of the solids.
    pub solid_bounds: Bounds,
    /// Absorption coefficient of the liquid per colour, in inverse picture units.
    pub absorption: V3,
}

impl<'a> Scene<'a> {
    pub(crate) fn new(
        setup: &'a RenderSetup,
        frame: &Frame,
        options: &RenderOptions,
        shading: Option<&ColorMapping>,
    ) -> Self {
        let mut points = setup.to_picture_coordinates(&frame.liquid.positions);
        let wetted = setup.wetted(frame, &points);
        let mut bounds = Bounds::EMPTY;
        points.iter().for_each(|&p| bounds.add(p));
        let mut solid_bounds = Bounds::EMPTY;
        let (mut solids, mut shades, mut surfaces) = (Vec::new(), Vec::new(), Vec::new());
        for mesh in frame.solids.values() {
            let points = setup.to_picture_coordinates(&mesh.positions);
            points.iter().for_each(|&p| solid_bounds.add(p));
            let places = shading.map_or_else(Vec::new, |shading| shading.places(mesh));
            shades.push(shading.filter(|_| !places.is_empty()).map(|shading| shading.shade));
            let tint = if places.is_empty() { tint(mesh) } else { places };
            solids.push(TriMesh::new(&points, &mesh.faces, &[], &tint, 0.8));
            surfaces.push(SurfaceMesh { positions: points, facets: mesh.faces.clone() });
        }
        // A gap between the two meshes would appear as a bright seam around the drop's foot.
        let depths = Depths::of_picture(setup.dx.unwrap_or(0.0));
        move_below(&mut points, &frame.liquid.faces, &wetted, &surfaces, &depths);
        // The line stays visible at any distance of the camera.
        let thinnest =
            MIN_LINE_RADIUS_PIXELS * setup.view.pixel_angle() * (bounds.center() - setup.view.eye).norm();
        let radius = (LINE_RADIUS * setup.liquid).max(thinnest);
        let line = frame
            .contact_line
            .as_ref()
            .filter(|_| options.appearance.line)
            .map_or_else(Capsules::default, |mesh| {
                Capsules::new(&setup.to_picture_coordinates(&mesh.positions), mesh, radius)
            });
        Self {
            setup,
            style: options.style.unwrap_or_default(),
            liquid: TriMesh::new(&points, &frame.liquid.faces, &wetted, &[], 0.3),
            solids,
            shades,
            line,
            bounds,
            solid_bounds,
            absorption: absorption(options.appearance.liquid) / setup.liquid,
        }
    }

    /// The first hit beyond [`RAY_EPSILON`].
    pub(crate) fn first_hit(&self, ray: &Ray) -> Option<(HitObject, Hit)> {
        let mut best: Option<(HitObject, Hit)> = None;
        let mut limit = f64::INFINITY;
        if ray.dir.z < 0.0 && self.setup.appearance.floor {
            let t = (GROUND_HEIGHT - ray.origin.z) / ray.dir.z;
            if t > RAY_EPSILON {
                best = Some((
                    HitObject::Ground,
                    Hit { t, geometric_normal: V3::z(), shading_normal: V3::z(), wetted: false, tint: 0.0 },
                ));
                limit = t;
            }
        }
        if let Some(hit) = self.liquid.hit(ray, RAY_EPSILON, limit) {
            limit = hit.t + LIQUID_TIE_BREAK;
            best = Some((HitObject::Liquid, hit));
        }
        for (i, solid) in self.solids.iter().enumerate() {
            if let Some(hit) = solid.hit(ray, RAY_EPSILON, limit) {
                limit = hit.t;
                best = Some((HitObject::Solid(i), hit));
            }
        }
        if let Some(hit) = self.line.hit(ray, RAY_EPSILON, limit) {
            best = Some((HitObject::Line, hit));
        }
        best
    }

    /// Whether a solid intersects the ray before `limit`.
    pub(crate) fn occluded_by_solid(&self, ray: &Ray, limit: f64) -> bool {
        self.solids.iter().any(|s| s.occludes(ray, 1e-4, limit))
    }

    /// Whether the liquid intersects the ray before `limit`.
    pub(crate) fn occluded_by_liquid(&self, ray: &Ray, limit: f64) -> bool {
        self.liquid.occludes(ray, 1e-4, limit)
    }
}

/// Optical depth per colour over one typical width of the liquid: −ln of the given colour, or the default tint.
fn absorption(color: Option<u32>) -> V3 {
    color.map_or(V3::new(0.62, 0.17, 0.07), |color| {
        linear_from_srgb(color).map(|c| -c.max(MIN_TRANSMITTANCE).ln())
    })
}

/// Normalised contact angle of a solid: 0 where it is largest, 1 where it is smallest.
fn tint(mesh: &PlyMesh) -> Vec<f64> {
    let Some(angles) = mesh.scalars.get("young") else { return Vec::new() };
    let low = angles.iter().copied().fold(f64::INFINITY, f64::min);
    let high = angles.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    angles.iter().map(|angle| (high - angle) / (high - low).max(1e-9)).collect()
}
