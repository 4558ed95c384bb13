//! Precomputed light on the ground and on top of solids: soft shadows, and light focused by the liquid (caustics), traced from
//! the lamp.

use rayon::prelude::*;

use super::bvh::Ray;
use super::environment::KEY_HALF_ANGLE_TANGENT;
use super::optics::FresnelSplit;
use super::sampling::{hash, orthonormal_basis, r2, sample_cone, sample_cosine_hemisphere, smoothstep};
use super::scene::{HitObject, Scene};
use crate::folder::{Bounds, V3};
use crate::render::Style;

/// Texels along each side of the map.
const MAP_SIDE_TEXELS: usize = 240;
/// Light paths along each side of the grid of paths.
const PATHS_PER_SIDE: u32 = 420;
/// Shadow rays to the lamp per texel.
const KEY_RAYS: u32 = 12;
/// Rays to the environment per texel.
const SKY_RAYS: u32 = 20;
/// Transmittance of the liquid for light of the environment.
const SKY_TRANSMITTANCE: f64 = 0.80;
/// Largest number of interfaces along a light path.
const MAX_CROSSINGS: usize = 10;

/// Light on horizontal surfaces around the liquid.
#[derive(Debug)]
pub(crate) struct LightMap {
    corner: [f64; 2],
    cell: f64,
    /// Per ground texel: visible share of the environment, visible share of the lamp.
    visibility: Vec<[f64; 2]>,
    /// Per texel: light transmitted through the liquid to the ground, and to solids.
    caustics: [Vec<V3>; 2],
}

impl LightMap {
    /// Computes the light map of a scene.
    pub(crate) fn new(scene: &Scene) -> Self {
        let region = shadow_region(scene);
        let width = region.size().x.max(region.size().y);
        let center = region.center();
        let cell = width / MAP_SIDE_TEXELS as f64;
        let corner = [center.x - 0.5 * width, center.y - 0.5 * width];
        let mut map = Self { corner, cell, visibility: Vec::new(), caustics: [Vec::new(), Vec::new()] };
        map.visibility = (0..MAP_SIDE_TEXELS * MAP_SIDE_TEXELS)
            .into_par_iter()
            .map(|i| map.texel_visibility(scene, i))
            .collect();
        map.visibility = blur(&map.visibility, 2.0, |a, b, w| [a[0] + b[0] * w, a[1]], [0.0; 2])
            .into_iter()
            .zip(blur(&map.visibility, 0.8, |a, b, w| [a[0], a[1] + b[1] * w], [0.0; 2]))
            .map(|(sky, key)| [sky[0], key[1]])
            .collect();
        let spread = |paths: Vec<V3>| blur(&paths, 0.9, |a, b, w| a + b * w, V3::zeros());
        map.caustics = map
            .trace_caustics(scene)
            .map(spread)
            .map(|m| m.iter().map(|c| c.map(compress_highlight)).collect());
        map
    }

    /// Share of the environment and light of the lamp that reach a point on the ground.
    pub(crate) fn ground(&self, x: f64, y: f64) -> (f64, V3) {
        let (Some(at), inside) = (self.texels(x, y), self.inside(x, y)) else {
            return (1.0, V3::repeat(1.0));
        };
        let mut light = [0.0; 2];
        let mut through = V3::zeros();
        for (i, w) in at {
            light[0] += self.visibility[i][0] * w;
            light[1] += self.visibility[i][1] * w;
            through += self.caustics[0][i] * w;
        }
        let key = V3::repeat(light[1]) + through;
        (1.0 + (light[0] - 1.0) * inside, V3::repeat(1.0) + (key - V3::repeat(1.0)) * inside)
    }

    /// Light transmitted through the liquid to the top of a solid.
    pub(crate) fn on_solid(&self, x: f64, y: f64) -> V3 {
        let Some(at) = self.texels(x, y) else { return V3::zeros() };
        at.into_iter().fold(V3::zeros(), |sum, (i, w)| sum + self.caustics[1][i] * w)
    }

    /// The four texels around a point with their bilinear weights.
    fn texels(&self, x: f64, y: f64) -> Option<[(usize, f64); 4]> {
        let u = (x - self.corner[0]) / self.cell - 0.5;
        let v = (y - self.corner[1]) / self.cell - 0.5;
        let most = MAP_SIDE_TEXELS as f64 - 1.001;
        if !(u >= 0.0 && v >= 0.0 && u <= most && v <= most) {
            return None;
        }
        let (i, j, fu, fv) = (u as usize, v as usize, u.fract(), v.fract());
        let at = j * MAP_SIDE_TEXELS + i;
        Some([
            (at, (1.0 - fu) * (1.0 - fv)),
            (at + 1, fu * (1.0 - fv)),
            (at + MAP_SIDE_TEXELS, (1.0 - fu) * fv),
            (at + MAP_SIDE_TEXELS + 1, fu * fv),
        ])
    }

    /// Weight of the map: 1 in the middle, 0 at the border.
    fn inside(&self, x: f64, y: f64) -> f64 {
        let width = self.cell * MAP_SIDE_TEXELS as f64;
        let edge = |p: f64| smoothstep(0.0, 0.08, p.min(1.0 - p));
        edge((x - self.corner[0]) / width) * edge((y - self.corner[1]) / width)
    }

    /// Visible shares of the environment and of the lamp at a texel, with occlusion by the liquid and the solids.
    fn texel_visibility(&self, scene: &Scene, texel: usize) -> [f64; 2] {
        let (i, j) = (texel % MAP_SIDE_TEXELS, texel / MAP_SIDE_TEXELS);
        let at = |i: usize, c: f64| c + (i as f64 + 0.5) * self.cell;
        let point = V3::new(at(i, self.corner[0]), at(j, self.corner[1]), 0.0);
        let seed = hash(texel as u32);
        let shift = [f64::from(seed & 0xffff) / 65536.0, f64::from(seed >> 16) / 65536.0];
        let sees = |dir: V3, through: f64| {
            let ray = Ray::new(point, dir);
            match () {
                () if scene.occluded_by_solid(&ray, f64::INFINITY) => 0.0,
                () if scene.occluded_by_liquid(&ray, f64::INFINITY) => through,
                () => 1.0,
            }
        };
        let glass = scene.style == Style::Glass;
        let sky: f64 = (0..SKY_RAYS)
            .map(|k| {
                sees(
                    sample_cosine_hemisphere(&V3::z(), r2(k, shift)),
                    if glass { SKY_TRANSMITTANCE } else { 0.0 },
                )
            })
            .sum();
        let lamp = scene.setup.environment.key;
        let key: f64 =
            (0..KEY_RAYS).map(|k| sees(sample_cone(&lamp, KEY_HALF_ANGLE_TANGENT, r2(k, shift)), 0.0)).sum();
        [sky / f64::from(SKY_RAYS), key / f64::from(KEY_RAYS)]
    }

    /// Traces light through the liquid to the ground and to solids.
    fn trace_caustics(&self, scene: &Scene) -> [Vec<V3>; 2] {
        let mut maps = [
            vec![V3::zeros(); MAP_SIDE_TEXELS * MAP_SIDE_TEXELS],
            vec![V3::zeros(); MAP_SIDE_TEXELS * MAP_SIDE_TEXELS],
        ];
        if scene.style != Style::Glass || scene.liquid.is_empty() {
            return maps;
        }
        let lamp = scene.setup.environment.key;
        let (a, b) = orthonormal_basis(&lamp);
        let radius = 0.5 * scene.bounds.size().norm() * 1.02;
        let step = 2.0 * radius / f64::from(PATHS_PER_SIDE);
        let start = |k: u32| {
            let (i, j) = (k % PATHS_PER_SIDE, k / PATHS_PER_SIDE);
            let at = |i: u32| (f64::from(i) + 0.5) * step - radius;
            let dir = -sample_cone(&lamp, KEY_HALF_ANGLE_TANGENT, r2(k, [0.0; 2]));
            let through = scene.bounds.center() + a * at(i) + b * at(j);
            Ray::new(through - dir * (2.0 * radius + 1.0), dir)
        };
        let ends: Vec<Option<(usize, V3, V3)>> = (0..PATHS_PER_SIDE * PATHS_PER_SIDE)
            .into_par_iter()
            .map(|k| trace_light_path(scene, start(k)))
            .collect();
        let share = step * step / (self.cell * self.cell * lamp.z);
        for (layer, point, light) in ends.into_iter().flatten() {
            for (i, w) in self.texels(point.x, point.y).into_iter().flatten() {
                maps[layer][i] += light * (w * share);
            }
        }
        maps
    }
}

/// Traces one ray of the lamp. Returns layer, end point and remaining light if it went through the liquid.
fn trace_light_path(scene: &Scene, mut ray: Ray) -> Option<(usize, V3, V3)> {
    let mut light = V3::repeat(1.0);
    let mut wet = false;
    for _ in 0..MAX_CROSSINGS {
        let (thing, hit) = scene.first_hit(&ray)?;
        let point = ray.at(hit.t);
        match thing {
            HitObject::Ground if wet => return Some((0, point, light)),
            HitObject::Solid(_) if wet => return Some((1, point, light)),
            HitObject::Liquid => {
                wet = true;
                if ray.dir.dot(&hit.geometric_normal) > 0.0 {
                    light.component_mul_assign(&(scene.absorption * -hit.t).map(f64::exp));
                }
                let side = FresnelSplit::new(&ray.dir, &hit);
                let (dir, part) = match side.refracted {
                    Some(dir) => (dir, 1.0 - side.reflectance),
                    None => (side.reflected, 1.0),
                };
                light *= part;
                ray = Ray::new(point, dir);
            }
            _ => return None,
        }
    }
    None
}

/// Compresses light above 1.
fn compress_highlight(light: f64) -> f64 {
    if light > 1.0 { 1.0 + (light - 1.0) / (1.0 + 0.30 * (light - 1.0)) } else { light }
}

/// Region of the ground that the liquid and the solids can shadow.
fn shadow_region(scene: &Scene) -> Bounds {
    let mut all = Bounds::EMPTY;
    let lamp = scene.setup.environment.key;
    for bounds in [&scene.bounds, &scene.solid_bounds] {
        if bounds.is_empty() {
            continue;
        }
        for corner in crate::render::camera::corners(bounds) {
            all.add(V3::new(corner.x, corner.y, 0.0));
            all.add(corner - lamp * (corner.z / lamp.z));
        }
    }
    let center = all.center();
    let half = (all.size() * 0.62 + V3::repeat(0.25)).inf(&V3::repeat(2.5));
    Bounds { lower: center - half, upper: center + half }
}

/// Separable Gaussian blur of a map. `add` adds a weighted value to a sum.
fn blur<T: Copy + Send + Sync>(
    map: &[T],
    sigma: f64,
    add: impl Fn(T, T, f64) -> T + Sync,
    zero: T,
) -> Vec<T> {
    let reach = (3.0 * sigma).ceil() as i64;
    let weights: Vec<f64> = (-reach..=reach).map(|k| (-0.5 * (k as f64 / sigma).powi(2)).exp()).collect();
    let total: f64 = weights.iter().sum();
    let pass = |map: &[T], along_rows: bool| -> Vec<T> {
        let one = |i: usize| {
            let (x, y) = (i % MAP_SIDE_TEXELS, i / MAP_SIDE_TEXELS);
            weights.iter().zip(-reach..).fold(zero, |sum, (w, k)| {
                let move_by = |p: usize| (p as i64 + k).clamp(0, MAP_SIDE_TEXELS as i64 - 1) as usize;
                let from = if along_rows {
                    y * MAP_SIDE_TEXELS + move_by(x)
                } else {
                    move_by(y) * MAP_SIDE_TEXELS + x
                };
                add(sum, map[from], w / total)
            })
        };
        (0..MAP_SIDE_TEXELS * MAP_SIDE_TEXELS).into_par_iter().map(one).collect()
    };
    pass(&pass(map, true), false)
}
