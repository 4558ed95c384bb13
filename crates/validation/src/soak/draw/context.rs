//! The context of a random scene: domain, liquid, gravity, step, duration, and the free room.

use super::random::Random;
use crate::soak::CaseOptions;
use std::fmt::Write as _;

/// Standard gravity, m/s².
const GRAVITY: f64 = 9.81;
/// Steps that a run should take: enough for solids and drops to meet, few enough for a case to take seconds.
const STEP_COUNT_RANGE: [f64; 2] = [200.0, 600.0];
/// Most tries to find room for an object.
const MAX_PLACEMENT_TRIES: usize = 30;

/// The first random choices of a scene, SI.
pub struct SceneContext {
    /// 2 or 3.
    pub dimension: usize,
    /// Size of the domain, m.
    pub size: Vec<f64>,
    /// Cells along the longest side.
    pub resolution: usize,
    /// Size of a cell, m.
    pub dx: f64,
    /// Density of the liquid, kg/m³.
    pub density: f64,
    /// Tension of the liquid, N/m.
    pub tension: f64,
    /// Viscosity, Pa s.
    pub viscosity: f64,
    /// Gravity, m/s².
    pub gravity: Vec<f64>,
    /// Largest step over the explicit capillary limit; none for the default.
    pub capillary_step: Option<f64>,
    /// Speed of the liquid bodies, m/s.
    pub speed: f64,
    /// Duration, s.
    pub duration: f64,
    /// Height of the floor, m.
    pub floor: f64,
    /// Balls around the placed objects: centre and radius, m.
    pub occupied: Vec<(Vec<f64>, f64)>,
}

impl SceneContext {
    /// Draws the context.
    pub fn draw(random: &mut Random, wish: &CaseOptions) -> Self {
        let dimension = wish.dimension.unwrap_or(if random.bernoulli(0.8) { 2 } else { 3 });
        let (fewest, most) = match (dimension, wish.quick) {
            (2, false) => (32.0, 96.0),
            (2, true) => (32.0, 48.0),
            (_, false) => (20.0, 40.0),
            (_, true) => (20.0, 24.0),
        };
        let longest = random.log_uniform(4e-3, 16e-3);
        // Small resolutions are more frequent, because the cost is a power of the number of cells.
        let resolution = random.log_uniform(fewest, most + 0.99).floor();
        let dx = longest / resolution;
        let wide = random.index_below(dimension);
        let side = |a: usize| {
            let cells = if a == wide { resolution } else { (resolution * random.uniform(0.6, 1.0)).round() };
            cells * dx
        };
        let size: Vec<f64> = (0..dimension).map(side).collect();
        let (density, tension) = (random.log_uniform(700.0, 2000.0), random.log_uniform(0.01, 0.1));
        let viscosity = if random.bernoulli(0.25) { 0.0 } else { random.log_uniform(1e-4, 1.0) };
        let gravity = gravity(random, dimension);
        let capillary_step = random.bernoulli(0.5).then(|| random.log_uniform(0.5, 20.0));
        let across = 0.3 * size.iter().copied().fold(f64::INFINITY, f64::min);
        let weber = if random.bernoulli(0.35) { 0.0 } else { random.log_uniform(0.1, 200.0) };
        let speed = (weber * tension / (density * across)).sqrt();
        let mut world = Self {
            dimension,
            size,
            resolution: resolution as usize,
            dx,
            density,
            tension,
            viscosity,
            gravity,
            capillary_step,
            speed,
            duration: 0.0,
            floor: 0.0,
            occupied: Vec::new(),
        };
        world.duration = world.suitable_duration(across) * if wish.quick { 0.4 } else { 1.0 };
        world
    }

    /// The time in which drops cross the domain and oscillate a few times, limited by [`STEP_COUNT_RANGE`], s. A water drop of two
    /// millimetres takes 60 ms.
    fn suitable_duration(&self, across: f64) -> f64 {
        let height = self.size[self.dimension - 1];
        let fall = self.gravity.iter().map(|g| g * g).sum::<f64>().sqrt();
        let falling = if fall > 0.0 { (2.0 * height / fall).sqrt() } else { f64::INFINITY };
        let flying = if self.speed > 0.0 { height / self.speed } else { f64::INFINITY };
        let swing = (self.density * across.powi(3) / self.tension).sqrt();
        let meeting = falling.min(flying);
        let wanted = if meeting.is_finite() { 1.5 * meeting + swing } else { 4.0 * swing };
        let capillary = 0.36 * (self.density * self.dx.powi(3) / self.tension).sqrt();
        let fastest =
            self.speed.max((fall * height).sqrt()).max((self.tension / (self.density * across)).sqrt());
        let step = (self.capillary_step.unwrap_or(5.0) * capillary).min(0.7 * self.dx / fastest);
        wanted.clamp(STEP_COUNT_RANGE[0] * step, STEP_COUNT_RANGE[1] * step)
    }

    /// The shortest side of the domain, m.
    pub fn shortest_side(&self) -> f64 {
        self.size.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// Finds room for a ball of a radius (m), marks it as occupied and returns its centre. If there is none the ball overlaps another,
    /// and the program must refuse the scene.
    pub fn place_ball(&mut self, random: &mut Random, reach: f64) -> Vec<f64> {
        let gap = 0.5 * self.dx;
        let last = self.dimension - 1;
        let mut place = Vec::new();
        for _ in 0..MAX_PLACEMENT_TRIES {
            place = (0..self.dimension)
                .map(|a| {
                    let low = if a == last { self.floor } else { 0.0 } + reach + gap;
                    let high = self.size[a] - reach - gap;
                    if low < high { random.uniform(low, high) } else { 0.5 * (low + high) }
                })
                .collect();
            if self.occupied.iter().all(|(center, radius)| distance(center, &place) > radius + reach + gap) {
                break;
            }
        }
        self.occupied.push((place.clone(), reach));
        place
    }

    /// The sections `[domain]`, `[liquid]` without bodies, `[numerics]` and `[output]`.
    pub fn text(&self, random: &mut Random, name: &str, soft: bool) -> [String; 2] {
        let mut head = format!("format = 1\nname = \"{name}\"\n\n[domain]\ndimension = {}\n", self.dimension);
        let _ = writeln!(head, "size = {}", lengths(&self.size));
        let _ = writeln!(head, "resolution = {}", self.resolution);
        head += &walls(random, self.dimension);
        if random.bernoulli(0.3) {
            let _ = writeln!(head, "wall_contact_angle = \"{:.1} deg\"", angle(random));
        }
        let _ = writeln!(head, "\n[liquid]\ndensity = \"{:.1} kg/m^3\"", self.density);
        let _ = writeln!(head, "dynamic_viscosity = \"{:.4e} Pa s\"", self.viscosity);
        let _ = writeln!(head, "gravity = {}", list(&self.gravity, "m/s^2"));
        let mut tail = String::new();
        let newton = soft && random.bernoulli(0.2);
        if self.capillary_step.is_some() || newton {
            tail += "\n[numerics]\n";
        }
        self.capillary_step.iter().for_each(|c| {
            let _ = writeln!(tail, "capillary_step = {c:.3}");
        });
        if newton {
            tail += "newton_iterations = 3\n";
        }
        let ms = self.duration * 1e3;
        let _ =
            writeln!(tail, "\n[output]\nduration = \"{ms:.4} ms\"\nframe_interval = \"{:.4} ms\"", 0.1 * ms);
        tail += "formats = [\"ply\"]\n";
        [head, tail]
    }
}

/// A gravity vector: mostly down, seldom zero or oblique.
fn gravity(random: &mut Random, dimension: usize) -> Vec<f64> {
    let mut gravity = vec![0.0; dimension];
    if random.bernoulli(0.75) {
        let tilt = if random.bernoulli(0.15) { random.uniform(-0.5, 0.5) } else { 0.0 };
        gravity[0] = GRAVITY * tilt.sin();
        gravity[dimension - 1] = -GRAVITY * tilt.cos();
    }
    gravity
}

fn walls(random: &mut Random, dimension: usize) -> String {
    if random.bernoulli(0.7) {
        return String::new();
    }
    let sides = ["left", "right", "bottom", "top", "front", "back"];
    let open = |side: &&str| format!("{side} = \"{}\"", if random.bernoulli(0.3) { "open" } else { "slip" });
    let sides: Vec<String> = sides[..2 * dimension].iter().map(open).collect();
    format!("walls = {{ {} }}\n", sides.join(", "))
}

/// A contact angle, degrees; the extremes and the middle are frequent.
pub fn angle(random: &mut Random) -> f64 {
    match random.weighted_index(&[0.1, 0.1, 0.1, 0.7]) {
        0 => 0.0,
        1 => 180.0,
        2 => 90.0,
        _ => random.uniform(0.0, 180.0),
    }
}

/// The distance of two points, m.
pub fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| (x - y).powi(2)).sum::<f64>().sqrt()
}

/// A length in scene-file syntax.
pub fn length(x: f64) -> String {
    format!("\"{:.5} mm\"", x * 1e3)
}

/// A point in scene-file syntax.
pub fn lengths(x: &[f64]) -> String {
    let all: Vec<String> = x.iter().map(|x| length(*x)).collect();
    format!("[{}]", all.join(", "))
}

/// A vector with a unit in scene-file syntax.
pub fn list(x: &[f64], unit: &str) -> String {
    let all: Vec<String> = x.iter().map(|x| format!("\"{x:.5} {unit}\"")).collect();
    format!("[{}]", all.join(", "))
}

/// A ball in scene-file syntax.
pub fn ball(center: &[f64], radius: f64) -> String {
    format!("{{ ball = {{ center = {}, radius = {} }} }}", lengths(center), length(radius))
}

/// A box along the axes in scene-file syntax.
pub fn corner_box(lower: &[f64], upper: &[f64]) -> String {
    format!("{{ box = {{ lower = {}, upper = {} }} }}", lengths(lower), lengths(upper))
}

/// A half-space in scene-file syntax.
pub fn half_space(point: &[f64], normal: &[f64]) -> String {
    format!("{{ half_space = {{ point = {}, normal = {} }} }}", lengths(point), numbers(normal))
}

/// A direction in scene-file syntax.
pub fn numbers(x: &[f64]) -> String {
    let all: Vec<String> = x.iter().map(|x| format!("{x:.6}")).collect();
    format!("[{}]", all.join(", "))
}
