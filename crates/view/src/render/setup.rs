//! Data common to all pictures of a run: picture coordinates, domain, camera.

use std::collections::BTreeMap;

use super::camera::View;
use super::tracer::environment::Environment;
use super::{Appearance, RenderOptions};
use crate::color_map::linear_from_srgb;
use crate::error::Result;
use crate::folder::{Bounds, Frame, RunFolder, V3};

/// Number of frames sampled for the visible bounds.
const SAMPLED_FRAMES: usize = 24;

/// Data common to all 3D pictures of a run.
#[derive(Clone, Debug)]
pub(crate) struct RenderSetup {
    /// Unit of the picture coordinates, m.
    pub unit: f64,
    /// Origin of the picture coordinates, m; it lies on the ground.
    origin: V3,
    /// The domain in picture coordinates, if known.
    pub domain: Option<Bounds>,
    /// Cell size in picture coordinates, if known.
    pub dx: Option<f64>,
    /// Typical width of the liquid in picture coordinates.
    pub liquid: f64,
    /// Spacing of the ground pattern.
    pub grid: f64,
    /// Origin of the ground pattern.
    pub grid_origin: [f64; 2],
    pub view: View,
    pub environment: Environment,
    /// Optional elements and colours.
    pub appearance: Appearance,
}

/// Ratio of sizes of solid and liquid above which only the part of the solid near the liquid is shown.
const LARGE_SOLID_RATIO: f64 = 1.5;
/// Margin around the liquid in which such a solid is shown, in diagonals of the liquid.
const LARGE_SOLID_MARGIN: f64 = 0.25;

/// Visible bounds over the frames, and the largest volume of the liquid. The bounds contain the liquid, solids of similar size,
/// and the parts of larger solids near the liquid.
pub(crate) fn visible_bounds(folder: &RunFolder) -> Result<(Bounds, f64)> {
    let (mut liquid, mut volume) = (Bounds::EMPTY, 0.0f64);
    // Bounds over all frames and largest size of each solid.
    let mut solids: BTreeMap<String, (Bounds, f64)> = BTreeMap::new();
    for number in RunFolder::evenly_spaced(&folder.frame_numbers, SAMPLED_FRAMES) {
        let frame = folder.frame(number)?;
        liquid.join(&Bounds::of(&frame.liquid.positions));
        for (name, mesh) in &frame.solids {
            let now = Bounds::of(&mesh.positions);
            let (swept_bounds, size) = solids.entry(name.clone()).or_insert((Bounds::EMPTY, 0.0));
            swept_bounds.join(&now);
            *size = size.max(now.size().norm());
        }
        volume = volume.max(enclosed_volume(&frame));
    }
    let mut all = liquid;
    let margin = V3::repeat(LARGE_SOLID_MARGIN * liquid.size().norm());
    for (swept_bounds, size) in solids.values().filter(|(swept_bounds, _)| !swept_bounds.is_empty()) {
        if liquid.is_empty() || *size <= LARGE_SOLID_RATIO * liquid.size().norm() {
            all.join(swept_bounds);
            continue;
        }
        let part = Bounds {
            lower: swept_bounds.lower.sup(&(liquid.lower - margin)),
            upper: swept_bounds.upper.inf(&(liquid.upper + margin)),
        };
        if (0..3).all(|a| part.lower[a] <= part.upper[a]) {
            all.join(&part);
        }
    }
    if all.is_empty() {
        let size = folder.domain.map_or(V3::repeat(1.0), V3::from);
        all = Bounds { lower: V3::zeros(), upper: size };
    }
    Ok((all, volume))
}

/// Volume enclosed by the surface of the liquid.
fn enclosed_volume(frame: &Frame) -> f64 {
    let p = |i: u32| V3::from(frame.liquid.positions[i as usize]);
    let part = |f: &[u32; 3]| p(f[0]).dot(&p(f[1]).cross(&p(f[2])));
    frame.liquid.faces.iter().map(part).sum::<f64>().abs() / 6.0
}

/// The largest number of the form 1, 2 or 5 times a power of ten that does not exceed `x`.
pub(crate) fn round_length(x: f64) -> f64 {
    let power = 10f64.powf(x.max(1e-300).log10().floor());
    let digit = [5.0, 2.0, 1.0].into_iter().find(|d| d * power <= x * (1.0 + 1e-9)).unwrap_or(1.0);
    digit * power
}

impl RenderSetup {
    pub(crate) fn new(folder: &RunFolder, options: &RenderOptions) -> Result<Self> {
        let (mut seen, volume) = visible_bounds(folder)?;
        let size = seen.size().norm().max(1e-12);
        let floor = if folder.domain.is_some() { 0.0f64.min(seen.lower.z) } else { seen.lower.z };
        if seen.lower.z - floor < 0.35 * size {
            seen.lower.z = floor;
        }
        let unit = seen.size().norm().max(1e-12);
        let center = seen.center();
        let origin = V3::new(center.x, center.y, floor);
        let to_picture = |p: V3| (p - origin) / unit;
        let domain =
            folder.domain.map(|d| Bounds { lower: to_picture(V3::zeros()), upper: to_picture(V3::from(d)) });
        let liquid = if volume > 0.0 { volume.cbrt() } else { 0.5 * size };
        let grid = round_length(0.5 * liquid);
        let lines = |a: usize| -((origin[a] / grid).fract() * grid) / unit;
        let camera = options.camera.unwrap_or_default();
        let in_picture = Bounds { lower: to_picture(seen.lower), upper: to_picture(seen.upper) };
        let target = camera.target.map(|at| to_picture(V3::from(at)));
        let view = View::new(&camera, target, &in_picture, unit, options.size);
        Ok(Self {
            unit,
            origin,
            domain,
            dx: folder.dx.map(|dx| dx / unit),
            liquid: liquid / unit,
            grid: grid / unit,
            grid_origin: [lines(0), lines(1)],
            environment: Environment::new(&view.forward),
            appearance: options.appearance,
            view,
        })
    }

    /// Radiance of the background in a direction.
    pub(crate) fn backdrop(&self, direction: &V3) -> V3 {
        self.appearance.background.map_or_else(|| self.environment.backdrop(direction), linear_from_srgb)
    }

    /// Points in picture coordinates, clamped to the ground from below.
    pub(crate) fn to_picture_coordinates(&self, positions: &[[f64; 3]]) -> Vec<V3> {
        let place = |p: &[f64; 3]| {
            let q = (V3::from(*p) - self.origin) / self.unit;
            V3::new(q.x, q.y, q.z.max(0.0))
        };
        positions.iter().map(place).collect()
    }

    /// Whether each vertex of the liquid touches a solid or the ground; side walls do not count.
    pub(crate) fn wetted(&self, frame: &Frame, points: &[V3]) -> Vec<bool> {
        let kind = frame.liquid.scalars.get("kind");
        let near = self.dx.map_or(2e-3, |dx| 1.5 * dx);
        let wet = |(i, p): (usize, &V3)| {
            let marked = kind.and_then(|k| k.get(i)).is_some_and(|&k| k >= 1.0);
            let low = p.z < 1e-3 || (marked && p.z < near);
            let at_side = self.domain.is_some_and(|d| {
                (0..2).any(|a| p[a] < d.lower[a] + near || p[a] > d.upper[a] - near) || p.z > d.upper.z - near
            });
            low || (marked && !at_side)
        };
        points.iter().enumerate().map(wet).collect()
    }
}
