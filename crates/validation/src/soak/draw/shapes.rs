//! Bounded random shapes of solids and liquid.

use super::context::{SceneContext, ball, length, lengths, numbers};
use super::random::Random;

/// Use of a shape.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Use {
    /// Liquid; no part is thinner than four cells.
    Liquid,
    /// A rigid solid.
    Rigid,
    /// A deformable solid.
    Soft,
}

/// The region and use of a shape.
pub struct ShapeRegion<'a> {
    /// The context of the scene.
    pub world: &'a SceneContext,
    /// Centre of the ball, m.
    pub center: Vec<f64>,
    /// Its radius, m.
    pub radius: f64,
    /// Use of the shape.
    pub used: Use,
}

impl ShapeRegion<'_> {
    /// Draws a shape of any kind.
    pub fn shape(&self, random: &mut Random) -> String {
        let deep = self.world.dimension == 3;
        let weight = |yes: bool, w: f64| if yes { w } else { 0.0 };
        let (soft, wet) = (self.used == Use::Soft, self.used == Use::Liquid);
        let large = self.radius > 9.0 * self.world.dx;
        let weights = [
            if wet { 5.0 } else { 2.0 },
            if wet { 1.0 } else { 4.0 },
            1.5,
            1.5,
            1.0,
            weight(deep, 1.0),
            0.7,
            0.5,
            0.5,
            weight(large && !wet, 0.3),
            weight(deep && soft, 0.7),
            weight(deep && large && !wet, 0.2),
        ];
        match random.weighted_index(&weights) {
            0 => self.ball(),
            1 => self.plate(random),
            2 => self.capsule(random),
            3 => self.ellipsoid(random),
            4 => self.perturbed(random),
            5 => self.cylinder(random),
            6 => self.union(random),
            7 => self.smooth_union(random),
            8 => self.difference(random),
            9 => self.cow(random),
            10 => self.extrusion(random),
            _ => self.duck(),
        }
    }

    /// The smallest thickness to draw, m.
    fn thinnest(&self) -> f64 {
        self.world.dx * if self.used == Use::Liquid { 4.0 } else { 1.5 }
    }

    fn ball(&self) -> String {
        ball(&self.center, self.radius)
    }

    /// A box of random proportions, often thin, rotated or not.
    fn plate(&self, random: &mut Random) -> String {
        let d = self.world.dimension;
        let mut size: Vec<f64> = (0..d).map(|_| random.uniform(0.4, 1.0)).collect();
        let thin = if random.bernoulli(0.7) { d - 1 } else { random.index_below(d) };
        let largest = 2.0 * self.radius / (d as f64).sqrt();
        size.iter_mut().for_each(|s| *s = (*s * largest).max(self.thinnest()));
        size[thin] = random.log_uniform(self.thinnest(), largest.max(1.01 * self.thinnest()));
        let (center, size) = (lengths(&self.center), lengths(&size));
        format!("{{ box = {{ center = {center}, size = {size}{} }} }}", self.turned(random))
    }

    fn turned(&self, random: &mut Random) -> String {
        if random.bernoulli(0.4) {
            return String::new();
        }
        let angle =
            if random.bernoulli(0.5) { random.uniform(-20.0, 20.0) } else { random.uniform(-180.0, 180.0) };
        if self.world.dimension == 2 {
            return format!(", rotation = \"{angle:.3} deg\"");
        }
        let axis = numbers(&random.direction(3));
        format!(", rotation = {{ axis = {axis}, angle = \"{angle:.3} deg\" }}")
    }

    fn capsule(&self, random: &mut Random) -> String {
        let radius = random.log_uniform(0.5 * self.thinnest(), 0.8 * self.radius.max(self.thinnest()));
        let along = random.direction(self.world.dimension);
        let half = (self.radius - radius).max(0.0);
        let end = |sign: f64| -> Vec<f64> {
            self.center.iter().zip(&along).map(|(c, a)| c + sign * half * a).collect()
        };
        let (a, b) = (lengths(&end(-1.0)), lengths(&end(1.0)));
        format!("{{ capsule = {{ a = {a}, b = {b}, radius = {} }} }}", length(radius))
    }

    fn ellipsoid(&self, random: &mut Random) -> String {
        let radius = |_| (self.radius * random.uniform(0.3, 1.0)).max(0.75 * self.thinnest());
        let radii: Vec<f64> = (0..self.world.dimension).map(radius).collect();
        let (center, radii) = (lengths(&self.center), lengths(&radii));
        format!("{{ ellipsoid = {{ center = {center}, radii = {radii}{} }} }}", self.turned(random))
    }

    fn perturbed(&self, random: &mut Random) -> String {
        let amplitude = random.uniform(0.05, 0.3);
        let (mode, radius) = (2 + random.index_below(4), self.radius / (1.0 + amplitude));
        let (center, radius) = (lengths(&self.center), length(radius));
        format!(
            "{{ perturbed_ball = {{ center = {center}, radius = {radius}, mode = {mode}, amplitude = {amplitude:.3} }} }}"
        )
    }

    fn cylinder(&self, random: &mut Random) -> String {
        let ratio = random.uniform(0.2, 0.9);
        let (radius, height) = (self.radius * (1.0 - ratio * ratio).sqrt(), 2.0 * self.radius * ratio);
        let (center, axis) = (lengths(&self.center), numbers(&random.direction(3)));
        let (radius, height) = (length(radius), length(height.max(self.thinnest())));
        format!(
            "{{ cylinder = {{ center = {center}, axis = {axis}, radius = {radius}, height = {height} }} }}"
        )
    }

    /// Two overlapping balls, and their extent.
    fn two(&self, random: &mut Random) -> [String; 2] {
        let along = random.direction(self.world.dimension);
        let off = random.uniform(0.3, 0.45) * self.radius;
        let at = |sign: f64| -> Vec<f64> {
            self.center.iter().zip(&along).map(|(c, a)| c + sign * off * a).collect()
        };
        let radius = self.radius - off;
        [ball(&at(-1.0), radius), ball(&at(1.0), radius * random.uniform(0.8, 1.0))]
    }

    fn union(&self, random: &mut Random) -> String {
        format!("{{ union = [{}] }}", self.two(random).join(", "))
    }

    fn smooth_union(&self, random: &mut Random) -> String {
        let parts = self.two(random).join(", ");
        format!("{{ smooth_union = {{ parts = [{parts}], width = {} }} }}", length(0.3 * self.radius))
    }

    /// A ball from which another ball is cut.
    fn difference(&self, random: &mut Random) -> String {
        let along = random.direction(self.world.dimension);
        let at: Vec<f64> = self.center.iter().zip(&along).map(|(c, a)| c + self.radius * a).collect();
        let (of, minus) = (self.ball(), ball(&at, random.uniform(0.3, 0.7) * self.radius));
        format!("{{ difference = {{ of = {of}, minus = {minus} }} }}")
    }

    fn cow(&self, random: &mut Random) -> String {
        let long = 1.5 * self.radius;
        let mut feet = self.center.clone();
        feet[self.world.dimension - 1] -= 0.4 * long;
        let turned = if random.bernoulli(0.5) { String::new() } else { self.turned(random) };
        format!("{{ cow = {{ at = {}, length = {}{turned} }} }}", lengths(&feet), length(long))
    }

    fn extrusion(&self, random: &mut Random) -> String {
        let names = ["square", "triangle", "petals-4", "petals-6", "cross", "leaf"];
        let name = names[random.index_below(names.len())];
        let (size, thick) = (length(1.4 * self.radius), length(self.thinnest() * random.uniform(1.0, 2.5)));
        let center = lengths(&self.center);
        format!(
            "{{ extrusion = {{ outline = \"{name}\", size = {size}, thickness = {thick}, center = {center}{} }} }}",
            self.turned(random)
        )
    }

    /// The built-in duck is about two units long; its origin is at its middle.
    fn duck(&self) -> String {
        let scale = format!("{:.6e}", 0.5 * self.radius);
        format!(
            "{{ mesh = {{ file = \"builtin:duck.obj\", scale = {scale}, translate = {} }} }}",
            lengths(&self.center)
        )
    }
}
