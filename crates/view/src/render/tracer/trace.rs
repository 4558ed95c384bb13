//! Traces rays from the camera and computes their radiance.

use rayon::prelude::*;

use super::bvh::Ray;
use super::environment::{KEY_HALF_ANGLE_TANGENT, KEY_IRRADIANCE};
use super::geometry::Hit;
use super::light::LightMap;
use super::optics::FresnelSplit;
use super::sampling::{pixel_sample, pixel_shift, r2, sample_cone, sample_cosine_hemisphere, smoothstep};
use super::scene::{HitObject, RAY_EPSILON, Scene};
use crate::color_map::linear_from_srgb;
use crate::folder::V3;
use crate::render::Style;
use crate::render::camera::corners;
use crate::render::image::{Canvas, ImageSize};

/// Weight of a path below which it ends in the environment.
const MIN_PATH_WEIGHT: f64 = 0.03;
/// Largest number of surfaces along a path.
const MAX_DEPTH: u32 = 9;
/// Upper bound on the radiance of a sample.
const MAX_SAMPLE_RADIANCE: f64 = 1.8;
/// Factor on the number of samples of pixels that show the liquid.
const LIQUID_SAMPLE_FACTOR: u32 = 3;
/// Rays to the lamp, and to the environment, per sample of a matte surface.
const SHADE_RAYS: u32 = 4;
/// The colours of solids.
const SOLID_COLORS: [[f64; 3]; 5] =
    [[0.50, 0.37, 0.28], [0.34, 0.40, 0.46], [0.38, 0.45, 0.31], [0.52, 0.41, 0.22], [0.43, 0.33, 0.43]];
/// Colour of patterned solids where the contact angle is smallest.
const WETTED_COLOR: V3 = V3::new(0.16, 0.33, 0.45);
/// Default colour of matte liquid.
const MATTE_COLOR: V3 = V3::new(0.10, 0.34, 0.62);
/// The colour of the contact line.
const LINE_COLOR: V3 = V3::new(0.85, 0.06, 0.04);

/// State of a camera path.
#[derive(Clone, Copy)]
struct Path {
    weight: f64,
    depth: u32,
    /// Length of the path from the camera.
    length: f64,
    /// Index of the sample in its pixel, and the pixel's shift of the patterns.
    sample: u32,
    shift: [f64; 2],
}

struct Tracer<'a> {
    scene: &'a Scene<'a>,
    light: LightMap,
}

/// Renders a scene.
pub(crate) fn picture(scene: &Scene, size: ImageSize, samples: u32) -> Canvas {
    let tracer = Tracer { scene, light: LightMap::new(scene) };
    let mut canvas = Canvas::new(size, V3::zeros());
    let mut depth = vec![f64::INFINITY; canvas.pixels.len()];
    let width = canvas.width;
    let samples = samples.max(1);
    let rows = canvas.pixels.par_chunks_mut(width).zip(depth.par_chunks_mut(width));
    rows.enumerate().for_each(|(y, (colors, depths))| {
        for (x, (color, depth)) in colors.iter_mut().zip(depths).enumerate() {
            let shift = pixel_shift(x as u32, y as u32);
            let (mut taken, mut wanted) = (0, samples);
            while taken < wanted {
                let at = pixel_sample(taken, samples);
                let ray = scene.setup.view.ray(x as f64 + at[0], y as f64 + at[1]);
                let path = Path { weight: 1.0, depth: 0, length: 0.0, sample: taken, shift };
                let (light, met) = tracer.follow(&ray, path);
                *color += light.map(|c| c.min(MAX_SAMPLE_RADIANCE));
                *depth =
                    depth.min(met.map_or(f64::INFINITY, |m| m.1) * ray.dir.dot(&scene.setup.view.forward));
                taken += 1;
                if samples > 1 && met.is_some_and(|m| m.0 == HitObject::Liquid) {
                    wanted = LIQUID_SAMPLE_FACTOR * samples;
                }
            }
            *color /= f64::from(taken);
        }
    });
    outline(scene, &mut canvas, &depth);
    canvas
}

/// Draws the visible edges of the domain.
fn outline(scene: &Scene, canvas: &mut Canvas, depth: &[f64]) {
    let Some(domain) = scene.setup.domain.filter(|_| scene.setup.appearance.domain) else { return };
    let view = &scene.setup.view;
    let corners = corners(&domain);
    let (width, thick) = (canvas.width, (canvas.height as f64 / 400.0).max(0.8));
    for i in 0..8 {
        for j in (0..3).map(|a| i | 1 << a).filter(|&j| j != i) {
            // Draw short pieces: a piece with an end behind the camera is skipped.
            for k in 0..24 {
                let at = |k: i32| corners[i] + (corners[j] - corners[i]) * (f64::from(k) / 24.0);
                let (Some(a), Some(b)) = (view.project(&at(k)), view.project(&at(k + 1))) else { continue };
                let seen = |x: usize, y: usize, t: f64| {
                    let z = 1.0 / ((1.0 - t) / a.2 + t / b.2);
                    if z < depth[y * width + x] * 1.004 { 0.30 } else { 0.0 }
                };
                piece(canvas, [a.0, a.1], [b.0, b.1], thick, seen);
            }
        }
    }
}

/// Draws a piece of a line without round ends, so that overlapping pieces show no dots.
fn piece(canvas: &mut Canvas, a: [f64; 2], b: [f64; 2], thick: f64, seen: impl Fn(usize, usize, f64) -> f64) {
    let inner = |x, y, t: f64| if t > 0.0 && t < 1.0 { seen(x, y, t) } else { 0.0 };
    canvas.line(a, b, thick, &V3::new(0.10, 0.13, 0.17), inner);
}

impl Tracer<'_> {
    /// Radiance along a ray, the object it hits and its distance.
    fn follow(&self, ray: &Ray, path: Path) -> (V3, Option<(HitObject, f64)>) {
        let studio = &self.scene.setup.environment;
        let Some((thing, hit)) = self.scene.first_hit(ray) else {
            let light =
                if path.depth == 0 { self.scene.setup.backdrop(&ray.dir) } else { studio.radiance(&ray.dir) };
            // A lamp seen through the drop would be far too bright; limit the weighted radiance.
            let light = light.map(|c| c.min(MAX_SAMPLE_RADIANCE / path.weight.max(MIN_PATH_WEIGHT)));
            return (light, None);
        };
        let path = Path { length: path.length + hit.t, ..path };
        let point = ray.at(hit.t);
        let light = match thing {
            HitObject::Ground => self.ground(ray, &point, &path),
            HitObject::Solid(i) => {
                let normal = if ray.dir.dot(&hit.geometric_normal) > 0.0 {
                    -hit.shading_normal
                } else {
                    hit.shading_normal
                };
                let color = match self.scene.shades[i] {
                    Some(shade) => shade.color(hit.tint),
                    None => {
                        let own = || V3::from(SOLID_COLORS[i % SOLID_COLORS.len()]);
                        self.scene
                            .setup
                            .appearance
                            .solids
                            .map_or_else(own, linear_from_srgb)
                            .lerp(&WETTED_COLOR, hit.tint)
                    }
                };
                self.diffuse(&point, &normal, &color, &path)
            }
            HitObject::Line => self.clear_coat(ray, &point, &hit, LINE_COLOR, &path),
            HitObject::Liquid if self.scene.style == Style::Matte => {
                let color = self.scene.setup.appearance.liquid.map_or(MATTE_COLOR, linear_from_srgb);
                self.clear_coat(ray, &point, &hit, color, &path)
            }
            HitObject::Liquid => self.dielectric(ray, &point, &hit, path),
        };
        (light, Some((thing, hit.t)))
    }

    fn dielectric(&self, ray: &Ray, point: &V3, hit: &Hit, path: Path) -> V3 {
        let side = FresnelSplit::new(&ray.dir, hit);
        let mut light = V3::zeros();
        if side.reflectance > 0.0 {
            light += self.branch(point, &side.reflected, path, side.reflectance, !side.entering);
        }
        if let Some(dir) = side.refracted {
            light += self.branch(point, &dir, path, 1.0 - side.reflectance, side.entering);
        }
        light
    }

    /// Weighted radiance of the reflected or refracted ray; `wet` if it runs in the liquid.
    fn branch(&self, point: &V3, dir: &V3, path: Path, part: f64, wet: bool) -> V3 {
        let weight = path.weight * part;
        if weight < MIN_PATH_WEIGHT || path.depth >= MAX_DEPTH {
            return self.scene.setup.environment.clamped_radiance(dir) * part;
        }
        let next = Path { weight, depth: path.depth + 1, ..path };
        let (light, met) = self.follow(&Ray::new(*point, *dir), next);
        let t = met.map_or(0.0, |(_, t)| if wet { t } else { 0.0 });
        light.component_mul(&(self.scene.absorption * -t).map(f64::exp)) * part
    }

    /// Shades the ground: fine squares that fade into the backdrop.
    fn ground(&self, ray: &Ray, point: &V3, path: &Path) -> V3 {
        let stage = self.scene.setup;
        let blurred = path.length * stage.view.pixel_angle() * if path.depth > 0 { 2.5 } else { 1.2 };
        let width = blurred / ray.dir.z.abs().max(0.05).sqrt();
        let (x, y) = (point.x - stage.grid_origin[0], point.y - stage.grid_origin[1]);
        let pattern = squares(x / stage.grid, y / stage.grid, width / stage.grid);
        let away = point.x.hypot(point.y);
        let near = 1.0 - smoothstep(0.9, 3.2, away);
        let albedo = 0.74 + near * (0.10 * (pattern - 0.5));
        let (sky, key) = self.light.ground(point.x, point.y);
        let lamp = KEY_IRRADIANCE * stage.environment.key.z;
        let light = stage.environment.ambient(&V3::z()) * sky + key * lamp;
        let pool = 1.0 - 0.30 * smoothstep(0.35, 2.6, away);
        let shown = V3::new(albedo * 0.985, albedo, albedo * 1.015).component_mul(&light) * pool;
        let fade = smoothstep(1.0, 4.2, away);
        shown * (1.0 - fade) + stage.backdrop(&ray.dir) * fade
    }

    /// Shades a diffuse surface lit by the lamp and the environment.
    fn diffuse(&self, point: &V3, normal: &V3, color: &V3, path: &Path) -> V3 {
        let studio = &self.scene.setup.environment;
        let rays = if path.depth == 0 { SHADE_RAYS } else { 2 };
        let from = point + normal * (20.0 * RAY_EPSILON);
        let (mut sky, mut lamp) = (0.0, 0.0);
        for k in 0..rays {
            let u = r2(path.sample * SHADE_RAYS + k, path.shift);
            let out = Ray::new(from, sample_cosine_hemisphere(normal, u));
            let reach = 0.35;
            sky += if self.scene.occluded_by_solid(&out, reach) { 0.25 } else { 1.0 };
            let to_lamp = Ray::new(from, sample_cone(&studio.key, KEY_HALF_ANGLE_TANGENT, u));
            let facing = to_lamp.dir.dot(normal);
            if facing > 0.0 && !self.scene.occluded_by_solid(&to_lamp, f64::INFINITY) {
                lamp += facing * self.lit_through_liquid(&to_lamp, normal);
            }
        }
        let mut light = studio.ambient(normal) * (sky / f64::from(rays))
            + V3::repeat(KEY_IRRADIANCE * lamp / f64::from(rays));
        light += self.light.on_solid(point.x, point.y) * (KEY_IRRADIANCE * studio.key.z * upward(normal));
        color.component_mul(&light)
    }

    /// Share of the lamp's direct light behind the liquid. On upward faces the caustics of the light map replace it.
    fn lit_through_liquid(&self, to_lamp: &Ray, normal: &V3) -> f64 {
        if !self.scene.occluded_by_liquid(to_lamp, f64::INFINITY) {
            return 1.0;
        }
        if self.scene.style == Style::Matte { 0.0 } else { 0.7 * (1.0 - upward(normal)) }
    }

    /// Shades a coloured surface with a clear coat.
    fn clear_coat(&self, ray: &Ray, point: &V3, hit: &Hit, color: V3, path: &Path) -> V3 {
        let dry = Hit { wetted: false, ..*hit };
        let normal =
            if ray.dir.dot(&hit.geometric_normal) > 0.0 { -hit.shading_normal } else { hit.shading_normal };
        let body = self.diffuse(point, &normal, &color, path);
        let side = FresnelSplit::new(&ray.dir, &dry);
        if !side.entering {
            return body;
        }
        let shine = self.scene.setup.environment.clamped_radiance(&side.reflected);
        body * (1.0 - side.reflectance) + shine * side.reflectance
    }
}

/// Degree to which a face is horizontal, where the light map applies: 1 facing up, 0 on steep faces.
fn upward(normal: &V3) -> f64 {
    smoothstep(0.15, 0.75, normal.z)
}

/// Checkerboard averaged over a window of the given width: 0 or 1 far from edges.
fn squares(x: f64, y: f64, width: f64) -> f64 {
    let w = width.max(1e-4);
    let wave = |p: f64| {
        let tooth = |p: f64| (p * 0.5 - (p * 0.5).floor() - 0.5).abs();
        2.0 * (tooth(p - 0.5 * w) - tooth(p + 0.5 * w)) / w
    };
    0.5 - 0.5 * wave(x) * wave(y)
}
