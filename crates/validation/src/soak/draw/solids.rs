//! Random solids: material, position, motion, and wetting.

use super::context::{SceneContext, angle, ball, corner_box, half_space, length, lengths, list};
use super::random::Random;
use super::shapes::{ShapeRegion, Use};
use crate::soak::Class;
use std::fmt::Write as _;

/// Kinds of solids.
#[derive(Clone, Copy, PartialEq, Eq)]
enum MotionKind {
    Fixed,
    Kinematic,
    Free,
    Soft,
}

/// The random solids of a scene.
#[derive(Default)]
pub struct Solids {
    /// The sections `[[solid]]`.
    pub text: String,
    /// The lines of `[tension]`.
    pub tension: String,
    /// Names of the solids.
    pub names: Vec<String>,
    /// Whether any solid has both of its surface tensions given, and all deformable ones have.
    pub neumann: bool,
}

impl Solids {
    /// Draws one to four solids of a class.
    pub fn draw(random: &mut Random, world: &mut SceneContext, class: Class) -> Self {
        let mut solids = Self { neumann: class == Class::Soft && random.bernoulli(0.1), ..Self::default() };
        if class == Class::Liquid {
            return solids;
        }
        let count = 1 + random.weighted_index(&[0.5, 0.25, 0.15, 0.1]);
        // The first solid is of the class's own kind; the rest may be of any kind in the class.
        let first = match class {
            Class::Soft => MotionKind::Soft,
            _ => [MotionKind::Fixed, MotionKind::Kinematic, MotionKind::Free]
                [random.weighted_index(&[0.35, 0.15, 0.5])],
        };
        for number in 0..count {
            let kinds = [MotionKind::Fixed, MotionKind::Kinematic, MotionKind::Free, MotionKind::Soft];
            let soft = if class == Class::Soft { 0.5 } else { 0.0 };
            let kind =
                if number == 0 { first } else { kinds[random.weighted_index(&[0.35, 0.1, 0.4, soft])] };
            solids.add(random, world, kind, number);
        }
        solids
    }

    fn add(&mut self, random: &mut Random, world: &mut SceneContext, kind: MotionKind, number: usize) {
        let name = format!("s{number}");
        let ground = kind == MotionKind::Fixed && world.floor == 0.0 && random.bernoulli(0.6);
        let (shape, center, reach) =
            if ground { ground_shape(random, world) } else { bounded(random, world, kind) };
        let _ = writeln!(self.text, "\n[[solid]]\nname = \"{name}\"\nshape = {shape}");
        if matches!(kind, MotionKind::Free | MotionKind::Soft) {
            let density = world.density * random.log_uniform(0.05, 20.0);
            let _ = writeln!(self.text, "density = \"{density:.2} kg/m^3\"");
        }
        match kind {
            MotionKind::Fixed => self.text += "material.rigid = { fixed = true }\n",
            MotionKind::Kinematic => self.text += &kinematic(random, world, &center, reach),
            MotionKind::Free => self.text += "material.rigid = {}\n",
            MotionKind::Soft => self.text += &soft(random, world, &center, reach),
        }
        if matches!(kind, MotionKind::Free | MotionKind::Soft) && random.bernoulli(0.25) {
            let speed = random.log_uniform(0.05, 1.0);
            let along: Vec<f64> = random.direction(world.dimension).iter().map(|x| x * speed).collect();
            let _ = writeln!(self.text, "velocity = {}", list(&along, "m/s"));
        }
        if kind != MotionKind::Fixed && random.bernoulli(0.2) {
            let (back, rough) = (random.uniform_unit(), random.uniform(0.0, 1.0));
            let _ = writeln!(self.text, "collision = {{ restitution = {back:.3}, friction = {rough:.3} }}");
        }
        let tension = if self.neumann && kind == MotionKind::Soft {
            energies(random, world.tension)
        } else {
            wetting(random, world, &center, reach)
        };
        let _ = writeln!(self.tension, "{name} = {{ {tension} }}");
        self.names.push(name);
    }

    /// The section `[contact_line]`.
    pub fn line(&self, random: &mut Random, world: &SceneContext, soft: bool) -> String {
        let mut text = String::from("\n[contact_line]\n");
        if random.bernoulli(0.05) && !self.neumann {
            return text + "enabled = false\n";
        }
        if random.bernoulli(0.6) {
            let _ = writeln!(text, "friction = \"{:.4} Pa s\"", random.log_uniform(1e-3, 1.0));
        }
        if random.bernoulli(0.4) {
            let (above, below) = (random.uniform(0.0, 30.0), random.uniform(0.0, 30.0));
            let _ =
                writeln!(text, "hysteresis = {{ above = \"{above:.1} deg\", below = \"{below:.1} deg\" }}");
        }
        if soft && random.bernoulli(0.2) {
            let _ = writeln!(text, "radius = {}", length(world.dx * random.uniform(1.0, 4.0)));
        }
        if self.neumann {
            text += "neumann = true\n";
        }
        text
    }
}

/// A bounded solid: its shape, and the centre (m) and radius (m) of a ball around it.
fn bounded(random: &mut Random, world: &mut SceneContext, kind: MotionKind) -> (String, Vec<f64>, f64) {
    let used = if kind == MotionKind::Soft { Use::Soft } else { Use::Rigid };
    let least = 2.5 * world.dx;
    let radius = random.log_uniform(least, (0.33 * world.shortest_side()).max(1.2 * least));
    let center = world.place_ball(random, radius);
    let place = ShapeRegion { world, center: center.clone(), radius, used };
    (place.shape(random), center, radius)
}

/// A floor, a slope, or a shelf from wall to wall; everything else lies above it.
fn ground_shape(random: &mut Random, world: &mut SceneContext) -> (String, Vec<f64>, f64) {
    let last = world.dimension - 1;
    let thick = random.log_uniform(1.5 * world.dx, 0.25 * world.size[last]);
    let mut top: Vec<f64> = world.size.iter().map(|s| 0.5 * s).collect();
    let reach = top[0];
    if random.bernoulli(0.5) {
        let tilt = if random.bernoulli(0.5) { 0.0 } else { random.uniform(-25.0f64, 25.0).to_radians() };
        let mut normal = vec![0.0; world.dimension];
        (normal[0], normal[last]) = (tilt.sin(), tilt.cos());
        top[last] = thick;
        world.floor = thick + 0.4 * world.size[0] * tilt.tan().abs();
        return (half_space(&top, &normal), top, reach);
    }
    let low = if random.bernoulli(0.5) { 0.0 } else { random.uniform(0.05, 0.2) * world.size[last] };
    let (mut lower, mut upper) = (vec![0.0; world.dimension], world.size.clone());
    (lower[last], upper[last]) = (low, low + thick);
    top[last] = low + thick;
    world.floor = top[last];
    (corner_box(&lower, &upper), top, reach)
}

/// A prescribed motion that stays inside the domain, by keyframes or with a constant velocity.
fn kinematic(random: &mut Random, world: &SceneContext, center: &[f64], reach: f64) -> String {
    let way = |random: &mut Random| -> Vec<f64> {
        let along = |a: usize| {
            let (back, ahead) = (center[a] - reach, world.size[a] - reach - center[a]);
            0.9 * random.uniform(-back.max(0.0), ahead.max(0.0))
        };
        (0..world.dimension).map(along).collect()
    };
    let first = way(random);
    if random.bernoulli(0.5) {
        let (half, second) = (length(0.0), way(random));
        let zero = vec![half; world.dimension].join(", ");
        let (middle, end) = (0.4e3 * world.duration, 0.8e3 * world.duration);
        return format!(
            "material.kinematic = {{ keyframes = [{{ time = \"0 ms\", translate = [{zero}] }}, {{ time = \"{middle:.4} ms\", \
             translate = {} }}, {{ time = \"{end:.4} ms\", translate = {} }}] }}\n",
            lengths(&first),
            lengths(&second)
        );
    }
    let velocity: Vec<f64> = first.iter().map(|w| w / world.duration).collect();
    let turns = if world.dimension == 2 { 1 } else { 3 };
    let turn = if random.bernoulli(0.4) { 0.25 * std::f64::consts::PI / world.duration } else { 0.0 };
    let spin: Vec<f64> = (0..turns).map(|_| random.uniform(-turn, turn)).collect();
    format!(
        "material.kinematic = {{ velocity = {}, angular_velocity = {} }}\n",
        list(&velocity, "m/s"),
        list(&spin, "rad/s")
    )
}

/// The material of a deformable solid, its mesh, and its anchored part.
fn soft(random: &mut Random, world: &SceneContext, center: &[f64], reach: f64) -> String {
    let young = random.log_uniform(10.0, 1e9);
    let damping = if random.bernoulli(0.5) { 0.0 } else { random.uniform(0.0, 0.3) };
    let mut text = match random.weighted_index(&[0.4, 0.35, 0.25]) {
        // Springs as stiff along a cell as a material of this modulus.
        2 => {
            let stiffness = young * world.dx.powi(world.dimension as i32 - 2);
            format!(
                "material.springs = {{ stiffness = \"{stiffness:.4e} N/m\", damping_ratio = {damping:.3} }}\n"
            )
        }
        law => {
            let name = ["neo_hookean", "corotated"][law];
            let poisson = random.uniform(0.0, 0.49);
            format!(
                "material.{name} = {{ young_modulus = \"{young:.4e} Pa\", poisson_ratio = {poisson:.3}, damping_ratio = {damping:.3} }}\n"
            )
        }
    };
    if random.bernoulli(0.2) {
        let _ = writeln!(text, "mesh = {{ edge = {} }}", length(world.dx * random.uniform(0.6, 1.5)));
    }
    if random.bernoulli(0.5) {
        let _ = writeln!(text, "{}", anchored_part(random, world, center, reach));
    }
    text
}

/// Anchors or moves the part on one side of a plane through the ball around a solid.
fn anchored_part(random: &mut Random, world: &SceneContext, center: &[f64], reach: f64) -> String {
    let (axis, low) = (random.index_below(world.dimension), random.bernoulli(0.5));
    let depth = random.uniform(0.2, 0.7) * reach;
    let (mut lower, mut upper): (Vec<f64>, Vec<f64>) = center.iter().map(|c| (c - reach, c + reach)).unzip();
    if low {
        upper[axis] = lower[axis] + depth
    } else {
        lower[axis] = upper[axis] - depth
    }
    let part = corner_box(&lower, &upper);
    if random.bernoulli(0.85) {
        return format!("fixed = [{part}]");
    }
    let speed = random.uniform(0.0, 0.3) * reach / world.duration;
    let velocity: Vec<f64> = random.direction(world.dimension).iter().map(|x| x * speed).collect();
    format!("moved = [{{ shape = {part}, velocity = {} }}]", list(&velocity, "m/s"))
}

/// Wetting of a solid: an angle, both tensions, a gradient, and patches over them.
fn wetting(random: &mut Random, world: &SceneContext, center: &[f64], reach: f64) -> String {
    let base = match random.weighted_index(&[0.7, 0.15, 0.15]) {
        0 => format!("contact_angle = \"{:.2} deg\"", angle(random)),
        1 => energies(random, world.tension),
        _ => {
            let along = random.direction(world.dimension);
            let end = |sign: f64| -> Vec<f64> {
                center.iter().zip(&along).map(|(c, a)| c + sign * reach * a).collect()
            };
            let (from, to) = (lengths(&end(-1.0)), lengths(&end(1.0)));
            let (one, other) = (angle(random), angle(random));
            format!(
                "gradient = {{ from = {{ point = {from}, contact_angle = \"{one:.2} deg\" }}, to = {{ point = {to}, \
                 contact_angle = \"{other:.2} deg\" }} }}"
            )
        }
    };
    if random.bernoulli(0.85) {
        return base;
    }
    let at: Vec<f64> =
        random.direction(world.dimension).iter().zip(center).map(|(a, c)| c + 0.5 * reach * a).collect();
    let patch = ball(&at, reach * random.uniform(0.3, 0.8));
    let angle = angle(random);
    format!("{base}, patches = [{{ shape = {patch}, contact_angle = \"{angle:.2} deg\" }}]")
}

/// Both surface tensions of a solid, for an angle between 10 and 170 degrees.
fn energies(random: &mut Random, tension: f64) -> String {
    let difference = tension * random.uniform(10.0f64, 170.0).to_radians().cos();
    let wet = random.uniform(0.0, 1.0) * tension + (-difference).max(0.0);
    let (wet, dry) = (1e3 * wet, 1e3 * (wet + difference));
    format!("liquid_solid = \"{wet:.4} mN/m\", solid_air = \"{dry:.4} mN/m\"")
}
