//! Environment lighting: backdrop, soft boxes, key light. It turns with the camera.

use super::sampling::smoothstep;
use crate::folder::V3;

/// Tangent of the key light's half angle.
pub(crate) const KEY_HALF_ANGLE_TANGENT: f64 = 0.09;
/// Radiance that the key light adds to a white surface facing it.
pub(crate) const KEY_IRRADIANCE: f64 = 0.56;
/// Radiance that the environment adds to a white unoccluded surface.
pub(crate) const AMBIENT_IRRADIANCE: f64 = 0.47;

/// The environment.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Environment {
    /// Horizontal viewing direction.
    forward: V3,
    right: V3,
    /// Direction towards the key light.
    pub key: V3,
    /// Direction towards the second soft box.
    rim: V3,
}

/// A colour from three components.
fn rgb(r: f64, g: f64, b: f64) -> V3 {
    V3::new(r, g, b)
}

fn mix(a: V3, b: V3, t: f64) -> V3 {
    a * (1.0 - t) + b * t
}

/// Share of a soft box of half size (`w`, `h`) around the direction `at` that is visible in direction `d`.
fn soft_box(d: &V3, at: &V3, w: f64, h: f64) -> f64 {
    let along = d.dot(at);
    if along <= 0.05 {
        return 0.0;
    }
    let side = at.cross(&V3::z()).try_normalize(1e-9).unwrap_or_else(V3::x);
    let up = side.cross(at);
    let (x, y) = (d.dot(&side) / along, d.dot(&up) / along);
    let edge = |x: f64, half: f64| 1.0 - smoothstep(half * 0.86, half * 1.14, x.abs());
    edge(x, w) * edge(y, h)
}

impl Environment {
    /// The environment of a camera with viewing direction `view`.
    pub(crate) fn new(view: &V3) -> Self {
        let flat = V3::new(view.x, view.y, 0.0);
        let forward = flat.try_normalize(1e-9).unwrap_or_else(V3::y);
        let right = forward.cross(&V3::z());
        Self {
            forward,
            right,
            key: (right * -0.62 + forward * 0.30 + V3::z()).normalize(),
            rim: (right * 0.95 + forward * 0.45 + V3::z() * 0.55).normalize(),
        }
    }

    /// Radiance of the backdrop without lamps; the ground fades into it.
    pub(crate) fn backdrop(&self, d: &V3) -> V3 {
        let horizon = rgb(0.52, 0.565, 0.615);
        let zenith = rgb(0.26, 0.33, 0.43);
        let room = rgb(0.13, 0.16, 0.20);
        let ahead = d.dot(&self.forward);
        let side = d.dot(&self.right).abs();
        let lit = smoothstep(-0.35, 0.75, ahead) * (1.0 - 0.35 * smoothstep(0.35, 1.0, side));
        let height = smoothstep(-0.02, 0.62, d.z);
        mix(mix(room, horizon, lit), mix(room * 0.8, zenith, lit.max(0.35)), height)
    }

    /// Radiance of the environment along a ray in direction `d`.
    pub(crate) fn radiance(&self, d: &V3) -> V3 {
        let key = soft_box(d, &self.key, 0.30, 0.38) * 15.0;
        let rim = soft_box(d, &self.rim, 0.12, 0.55) * 8.0;
        let fill =
            soft_box(d, &(self.right * 0.5 - self.forward + V3::z() * 0.5).normalize(), 0.30, 0.26) * 4.0;
        let top = smoothstep(0.80, 0.97, d.z) * 1.2;
        self.backdrop(d) + rgb(1.0, 0.98, 0.95) * key + rgb(0.93, 0.97, 1.0) * (rim + fill + top)
    }

    /// The radiance with lamps clamped, for rays whose weight is too small to trace further.
    pub(crate) fn clamped_radiance(&self, d: &V3) -> V3 {
        self.radiance(d).map(|x| x.min(1.2))
    }

    /// Ambient irradiance on an unoccluded surface with normal `n`.
    pub(crate) fn ambient(&self, n: &V3) -> V3 {
        let sky = mix(rgb(0.70, 0.71, 0.72), rgb(0.98, 1.0, 1.03), 0.5 + 0.5 * n.z);
        sky * (AMBIENT_IRRADIANCE * (0.86 + 0.14 * n.dot(&self.forward)))
    }
}

/// Encodes a linear colour as 8-bit sRGB with compressed highlights.
pub(crate) fn tone_map(c: &V3) -> [u8; 3] {
    let curve = |x: f64| if x <= 0.7 { x.max(0.0) } else { shoulder(x) };
    let encode = |x: f64| {
        let s = if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
        (s.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
    };
    [c.x, c.y, c.z].map(|x| encode(curve(x)))
}

/// Rises monotonically from 0.7 towards 1.
fn shoulder(x: f64) -> f64 {
    0.7 + 0.3 * (1.0 - (-(x - 0.7) / 0.3).exp())
}
