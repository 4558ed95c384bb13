//! The drop test: a designed set of deformable solids that fall on various grounds, with liquid between.
//!
//! The set is a Latin hypercube (M. D. McKay, R. J. Beckman, W. J. Conover, Technometrics 21 (1979) 239). A round has as many cases as a
//! continuous factor has strata; each stratum of each factor occurs once per round, in an order given by the seed. Shapes and grounds
//! take all of their pairs in 24 cases.
//!
//! Factors: the solid's shape; Young's modulus, 300 Pa to 10 MPa; density, 0.2 to 8 times the liquid's; height of the fall, 1 to 20 mm;
//! contact angle, 20 to 160 degrees; tilt, up to 30 degrees to both sides. The solids are undamped, so that any gain or loss of energy by
//! the method shows.
//!
//! A fall starts shortly above the ground with the speed of the remaining height, because there is no air and the flight only costs time.

use super::context::{ball, corner_box, length, lengths, list};
use super::random::Random;
use crate::soak::{CaseOptions, CaseSet};
use std::fmt::Write as _;

/// Strata of a factor, and cases per round: 2D, 3D.
pub const STRATA: [u64; 2] = [60, 12];
const GRAVITY: f64 = 9.81;
const WATER_DENSITY: f64 = 1000.0;
/// Initial gap between the solid and the ground, m.
const START_GAP: f64 = 0.5e-3;
/// Time after the impact, s: 2D, 3D; enough for solids of the longest period to rebound and return.
const TIME_AFTER_IMPACT: [f64; 2] = [30e-3, 15e-3];

const SHAPES: [&str; 4] = ["block", "ball", "plate", "strip"];
const GROUNDS: [&str; 6] = ["floor", "corner", "rigid-ball", "soft-block", "bath", "carries"];

/// A case of the set.
struct Case {
    dimension: usize,
    shape: usize,
    ground: usize,
    /// Young's moduli of the solid and of the one below it, Pa.
    young: [f64; 2],
    /// Poisson's ratio.
    poisson: f64,
    /// Densities of both, kg/m³.
    density: [f64; 2],
    /// Height of the fall, m.
    height: f64,
    /// Contact angle, degrees.
    angle: f64,
    /// Tilt, rad.
    tilt: f64,
    /// Offset from the middle, m.
    lateral_offset: f64,
    /// Whether frames and duration are shorter.
    quick: bool,
}

/// The text of a scene file of the set; identical on every machine.
pub fn scene(wish: &CaseOptions, case: u64) -> String {
    let dimension = wish.dimension.unwrap_or(2);
    let design = LatinHypercube { seed: wish.seed, dimension, case };
    let number = case % STRATA[dimension - 2];
    let log = |factor: u64, low: f64, high: f64| low * (high / low).powf(design.stratum(factor));
    let even = |factor: u64, low: f64, high: f64| low + (high - low) * design.stratum(factor);
    let drawn = Case {
        dimension,
        shape: ((number + number / 12) % 4) as usize,
        ground: (number / 2 % 6) as usize,
        young: [log(0, 300.0, 1e7), log(1, 300.0, 1e7)],
        poisson: even(2, 0.2, 0.45),
        density: [log(3, 0.2, 8.0) * WATER_DENSITY, log(4, 0.2, 8.0) * WATER_DENSITY],
        height: log(5, 1e-3, 20e-3),
        angle: even(6, 20.0, 160.0),
        tilt: even(7, -30.0, 30.0).to_radians(),
        lateral_offset: even(8, -1e-3, 1e-3),
        quick: wish.quick,
    };
    drawn.text(&format!("{}-{dimension}d-{}-{case}", CaseSet::DropTest.name(), wish.seed))
}

/// Generator of the strata of a case.
struct LatinHypercube {
    seed: u64,
    dimension: usize,
    case: u64,
}

impl LatinHypercube {
    /// The case's value of a factor in its range, 0 to 1: its stratum in a random permutation, and a random position within it.
    fn stratum(&self, factor: u64) -> f64 {
        let count = STRATA[self.dimension - 2];
        let (round, number) = (self.case / count, (self.case % count) as usize);
        let mut random = Random::of(&[self.seed, self.dimension as u64, round, factor]);
        let mut order: Vec<usize> = (0..count as usize).collect();
        (1..order.len()).rev().for_each(|k| order.swap(k, random.index_below(k + 1)));
        let within = Random::of(&[self.seed, self.dimension as u64, self.case, factor, 1]).uniform_unit();
        (order[number] as f64 + within) / count as f64
    }
}

impl Case {
    /// Half-size of the solid without its tilt, m; for a ball its radius in all directions.
    fn half(&self) -> Vec<f64> {
        let (wide, high) = match SHAPES[self.shape] {
            "block" => (1.5e-3, 1.2e-3),
            "ball" => (1.5e-3, 1.5e-3),
            "plate" => (3e-3, 0.5e-3),
            _ => (4e-3, if self.dimension == 2 { 0.3e-3 } else { 0.5e-3 }),
        };
        let deep = if SHAPES[self.shape] == "strip" { 0.75e-3 } else { wide };
        if self.dimension == 2 { vec![wide, high] } else { vec![wide, deep, high] }
    }

    /// Half-extents of the tilted solid to the side and down from its middle, m.
    fn half_extents(&self) -> [f64; 2] {
        let half = self.half();
        let (wide, high) = (half[0], half[self.dimension - 1]);
        if SHAPES[self.shape] == "ball" {
            return [wide; 2];
        }
        let (s, c) = (self.tilt.sin().abs(), self.tilt.cos());
        [wide * c + high * s, wide * s + high * c]
    }

    fn size(&self) -> Vec<f64> {
        if self.dimension == 2 { vec![16e-3, 12e-3] } else { vec![12e-3, 8e-3, 10e-3] }
    }

    /// A point, m, from its positions along the first and the last axis; in the middle along the other.
    fn at(&self, x: f64, y: f64) -> Vec<f64> {
        if self.dimension == 2 { vec![x, y] } else { vec![x, 0.5 * self.size()[1], y] }
    }

    fn text(&self, name: &str) -> String {
        let (middle, [wide, low]) = (0.5 * self.size()[0], self.half_extents());
        let ground = self.ground();
        let x =
            if GROUNDS[self.ground] == "corner" { wide + START_GAP } else { middle + self.lateral_offset };
        let center = self.at(x, ground.top + START_GAP + low);
        // The remaining height of the fall beyond the available room.
        let fallen = (self.height - (ground.top - ground.level) - START_GAP).max(0.0);
        let speed = (2.0 * GRAVITY * fallen).sqrt();
        let mut velocity = vec![0.0; self.dimension];
        velocity[self.dimension - 1] = -speed;
        if GROUNDS[self.ground] == "corner" {
            velocity[0] = -0.5 * speed;
        }
        let way = ground.top - ground.level + START_GAP;
        let fall = ((speed * speed + 2.0 * GRAVITY * way).sqrt() - speed) / GRAVITY;
        let after = TIME_AFTER_IMPACT[self.dimension - 2] * if self.quick { 0.3 } else { 1.0 };
        let mut text = self.head(name);
        text += &self.liquid(&ground, &center, &velocity);
        text += &ground.solid;
        text += &self.solid(&center, &velocity);
        self.tail(text, fall + after)
    }

    fn head(&self, name: &str) -> String {
        let resolution = if self.dimension == 2 { 64 } else { 30 };
        let what = format!("{} falls {}: {}", SHAPES[self.shape], length(self.height), GROUNDS[self.ground]);
        let what = what.replace('"', "");
        let mut text = format!("format = 1\nname = \"{name}\"\ndescription = \"{what}\"\n\n[domain]\n");
        let _ = writeln!(text, "dimension = {}\nsize = {}", self.dimension, lengths(&self.size()));
        let _ =
            writeln!(text, "resolution = {resolution}\n\n[liquid]\ndensity = \"{WATER_DENSITY:.1} kg/m^3\"");
        text += "dynamic_viscosity = \"1e-3 Pa s\"\n";
        let _ = writeln!(text, "gravity = {}", list(&self.down(), "m/s^2"));
        text
    }

    fn down(&self) -> Vec<f64> {
        (0..self.dimension).map(|a| if a + 1 == self.dimension { -GRAVITY } else { 0.0 }).collect()
    }

    /// The ground under the solid.
    fn ground(&self) -> Ground {
        let middle = 0.5 * self.size()[0];
        let drop = |x: f64, y: f64, radius: f64| Some((self.at(x, y), radius));
        let solid = String::new();
        match GROUNDS[self.ground] {
            "floor" => Ground { level: 0.0, top: 1e-3, drop: drop(middle, 0.0, 1e-3), solid },
            "corner" => Ground { level: 0.0, top: 1.5e-3, drop: drop(0.0, 0.0, 1.5e-3), solid },
            "rigid-ball" => {
                let shape = ball(&self.at(middle, 2.5e-3), 1.5e-3);
                let solid = format!(
                    "\n[[solid]]\nname = \"ground\"\nshape = {shape}\nmaterial.rigid = {{ fixed = true }}\n"
                );
                Ground { level: 4e-3, top: 4.8e-3, drop: drop(middle, 4e-3, 0.8e-3), solid }
            }
            "soft-block" => {
                let (mut lower, mut upper) = (self.at(middle - 2e-3, 0.0), self.at(middle + 2e-3, 2.5e-3));
                if self.dimension == 3 {
                    (lower[1], upper[1]) = (lower[1] - 2e-3, upper[1] + 2e-3);
                }
                let solid = self.soft("ground", &corner_box(&lower, &upper), 1);
                Ground { level: 2.5e-3, top: 3.3e-3, drop: drop(middle, 2.5e-3, 0.8e-3), solid }
            }
            "bath" => Ground { level: 4e-3, top: 4e-3, drop: None, solid },
            _ => Ground { level: 0.0, top: 0.0, drop: None, solid },
        }
    }

    fn liquid(&self, ground: &Ground, center: &[f64], velocity: &[f64]) -> String {
        let body = |shape: String| format!("\n[[liquid.body]]\nshape = {shape}\n");
        if let Some((at, radius)) = &ground.drop {
            return body(ball(at, *radius));
        }
        let last = self.dimension - 1;
        if GROUNDS[self.ground] == "bath" {
            let point = lengths(&self.at(0.0, ground.level));
            let normal: Vec<f64> = (0..self.dimension).map(|a| f64::from(u8::from(a == last))).collect();
            return body(format!("{{ half_space = {{ point = {point}, normal = {normal:?} }} }}"));
        }
        // On its upper side, across the tilt; its half within the solid is not counted as liquid.
        let high = self.half()[last];
        let mut top = center.to_vec();
        let tilt = if SHAPES[self.shape] == "ball" { 0.0 } else { self.tilt };
        (top[0], top[last]) = (top[0] - high * tilt.sin(), top[last] + high * tilt.cos());
        format!("{}velocity = {}\n", body(ball(&top, 0.9e-3)), list(velocity, "m/s"))
    }

    fn solid(&self, center: &[f64], velocity: &[f64]) -> String {
        let half = self.half();
        let shape = if SHAPES[self.shape] == "ball" {
            ball(center, half[0])
        } else {
            let size: Vec<f64> = half.iter().map(|h| 2.0 * h).collect();
            let degrees = self.tilt.to_degrees();
            // A positive rotation about the second axis turns the first axis down: opposite to the tilt in 2D.
            let rotation = if self.dimension == 2 {
                format!("\"{degrees:.3} deg\"")
            } else {
                format!("{{ axis = [0, 1, 0], angle = \"{:.3} deg\" }}", -degrees)
            };
            format!(
                "{{ box = {{ center = {}, size = {}, rotation = {rotation} }} }}",
                lengths(center),
                lengths(&size)
            )
        };
        format!("{}velocity = {}\n", self.soft("falls", &shape, 0), list(velocity, "m/s"))
    }

    /// A solid of the first or the second material.
    fn soft(&self, name: &str, shape: &str, which: usize) -> String {
        let (young, poisson, density) = (self.young[which], self.poisson, self.density[which]);
        format!(
            "\n[[solid]]\nname = \"{name}\"\nshape = {shape}\ndensity = \"{density:.2} kg/m^3\"\nmaterial.neo_hookean = \
             {{ young_modulus = \"{young:.4e} Pa\", poisson_ratio = {poisson:.3}, damping_ratio = 0.0 }}\n"
        )
    }

    fn tail(&self, mut text: String, duration: f64) -> String {
        let angle = format!("{{ contact_angle = \"{:.1} deg\" }}", self.angle);
        text += "\n[tension]\nliquid_air = \"72.8 mN/m\"\n";
        let _ = writeln!(text, "falls = {angle}");
        if matches!(GROUNDS[self.ground], "rigid-ball" | "soft-block") {
            let _ = writeln!(text, "ground = {angle}");
        }
        let ms = duration * 1e3;
        let _ =
            writeln!(text, "\n[output]\nduration = \"{ms:.4} ms\"\nframe_interval = \"{:.4} ms\"", 0.1 * ms);
        text + "formats = [\"ply\"]\n"
    }
}

/// The ground under the solid.
struct Ground {
    /// Height of the ground, m, from which falls are counted.
    level: f64,
    /// Height of the liquid on it, m.
    top: f64,
    /// Centre and radius of a drop on it, m.
    drop: Option<(Vec<f64>, f64)>,
    /// Its section `[[solid]]`, if it is a solid.
    solid: String,
}
