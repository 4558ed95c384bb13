//! The camera: its position and the rays through points of the picture.

use super::image::ImageSize;
use super::tracer::bvh::Ray;
use crate::folder::{Bounds, V3};

/// Position of the camera relative to the centre of the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Azimuth about the vertical, degrees; 0 looks along +y, 90 along −x.
    pub azimuth: f64,
    /// Elevation above the horizontal, degrees.
    pub elevation: f64,
    /// Distance to the centre, m; `None` fits the visible bounds into the picture.
    pub distance: Option<f64>,
    /// The point in the centre of the picture, m; `None` is the centre of the visible bounds.
    pub target: Option<[f64; 3]>,
}

impl Default for Camera {
    fn default() -> Self {
        Self { azimuth: 25.0, elevation: 17.0, distance: None, target: None }
    }
}

/// Tangent of half the vertical field of view.
const HALF_FOV_TANGENT: f64 = 0.24;
/// Share of the picture's width and height that the visible bounds fill.
const FILLED_SHARE: f64 = 0.74;
/// Distance of the centre of the scene from that of the picture, in half heights of the picture.
const LOWERED_SHARE: f64 = 0.03;

/// A camera for one picture size.
#[derive(Clone, Copy, Debug)]
pub(crate) struct View {
    pub eye: V3,
    pub forward: V3,
    right: V3,
    up: V3,
    half: [f64; 2],
    size: [f64; 2],
}

impl View {
    /// A view of the bounds `visible`, around the point `target` if it is given. All lengths are in picture coordinates, in which 1 is
    /// `unit` metres.
    pub(crate) fn new(
        camera: &Camera,
        target: Option<V3>,
        visible: &Bounds,
        unit: f64,
        size: ImageSize,
    ) -> Self {
        let (az, el) = (camera.azimuth.to_radians(), camera.elevation.clamp(-89.0, 89.0).to_radians());
        let forward = V3::new(-az.sin() * el.cos(), az.cos() * el.cos(), -el.sin());
        let right = V3::new(az.cos(), az.sin(), 0.0);
        let up = right.cross(&forward);
        let size = [size.width, size.height].map(|n| f64::from(n.max(1)));
        let half = [HALF_FOV_TANGENT * size[0] / size[1], HALF_FOV_TANGENT];
        let center = target.unwrap_or_else(|| visible.center());
        let fit = |target: &V3| {
            corners(visible).iter().fold(1e-6f64, |far, p| {
                let q = p - target;
                let (x, y, depth) = (q.dot(&right).abs(), q.dot(&up).abs(), q.dot(&forward));
                far.max(x / (half[0] * FILLED_SHARE) - depth).max(y / (half[1] * FILLED_SHARE) - depth)
            })
        };
        let distance = camera.distance.map_or_else(|| fit(&center), |d| d / unit);
        // The scene stands a little above the middle, unless that is a point of the user's choice.
        let lowered = if target.is_some() { 0.0 } else { LOWERED_SHARE * distance * HALF_FOV_TANGENT };
        Self { eye: center - up * lowered - forward * distance, forward, right, up, half, size }
    }

    /// Width and height of the picture in pixels.
    pub(crate) fn size(&self) -> [f64; 2] {
        self.size
    }

    /// The ray through a point of the picture, in pixels from its upper left corner.
    pub(crate) fn ray(&self, x: f64, y: f64) -> Ray {
        let u = (2.0 * x / self.size[0] - 1.0) * self.half[0];
        let v = (1.0 - 2.0 * y / self.size[1]) * self.half[1];
        Ray::new(self.eye, (self.forward + self.right * u + self.up * v).normalize())
    }

    /// The projection of a point, in pixels, and its depth; `None` behind the camera.
    pub(crate) fn project(&self, p: &V3) -> Option<(f64, f64, f64)> {
        let q = p - self.eye;
        let depth = q.dot(&self.forward);
        (depth > 1e-3).then(|| {
            let u = q.dot(&self.right) / (depth * self.half[0]);
            let v = q.dot(&self.up) / (depth * self.half[1]);
            ((u + 1.0) * 0.5 * self.size[0], (1.0 - v) * 0.5 * self.size[1], depth)
        })
    }

    /// Angle subtended by a pixel, rad.
    pub(crate) fn pixel_angle(&self) -> f64 {
        2.0 * self.half[1] / self.size[1]
    }
}

/// The eight corners of a box; bit `a` of the index selects the upper corner along axis `a`.
pub(crate) fn corners(b: &Bounds) -> [V3; 8] {
    std::array::from_fn(|i| {
        let pick = |a: usize| if i >> a & 1 == 1 { b.upper[a] } else { b.lower[a] };
        V3::new(pick(0), pick(1), pick(2))
    })
}
