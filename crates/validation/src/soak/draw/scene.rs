//! Generates a random scene file from the whole grammar.
//!
//! Not covered: images of the angle and the user's mesh files, which need files; thin sheets and threads, which no version runs yet;
//! numerical options for studies (`fixed_step`, `restore_momentum = false`).

use super::context::{SceneContext, corner_box, half_space, length, list};
use super::random::Random;
use super::shapes::{ShapeRegion, Use};
use super::solids::Solids;
use crate::soak::{CaseOptions, Class};
use std::fmt::Write as _;

/// The text of a scene file; the same for the same options, case and attempt on every machine.
pub fn scene(wish: &CaseOptions, case: u64, attempt: u64) -> String {
    let class = wish.class.map_or(0, |c| 1 + c as u64);
    let kind = 2 * class + u64::from(wish.quick);
    let mut random = Random::of(&[wish.seed, case, attempt, wish.dimension.unwrap_or(0) as u64, kind]);
    let random = &mut random;
    let mut world = SceneContext::draw(random, wish);
    let any = || [Class::Liquid, Class::Rigid, Class::Soft];
    let class = wish.class.unwrap_or_else(|| any()[random.weighted_index(&[0.25, 0.45, 0.3])]);
    let solids = Solids::draw(random, &mut world, class);
    let soft = class == Class::Soft;
    let mut bodies = String::new();
    if random.bernoulli(0.15) {
        bodies += &bath(random, &world);
    }
    let count =
        if bodies.is_empty() { 1 + random.weighted_index(&[0.6, 0.25, 0.15]) } else { random.index_below(3) };
    for _ in 0..count {
        bodies += &body(random, &mut world);
    }
    let [head, tail] = world.text(random, &format!("soak-{}-{case}", wish.seed), soft);
    let line = solids.line(random, &world, soft);
    let tension = 1e3 * world.tension;
    format!(
        "{head}{bodies}{}\n[tension]\nliquid_air = \"{tension:.3} mN/m\"\n{}{line}{tail}",
        solids.text, solids.tension
    )
}

/// A liquid body that fills the lower part of the domain.
fn bath(random: &mut Random, world: &SceneContext) -> String {
    let last = world.dimension - 1;
    let level = world.floor + random.uniform(0.12, 0.4) * (world.size[last] - world.floor);
    let mut at: Vec<f64> = vec![0.0; world.dimension];
    at[last] = level;
    let shape = match random.weighted_index(&[0.5, 0.25, 0.25]) {
        0 => {
            let mut up = vec![0.0; world.dimension];
            up[last] = 1.0;
            half_space(&at, &up)
        }
        1 => {
            let mut upper: Vec<f64> = world.size.iter().map(|s| s * random.uniform(0.3, 1.0)).collect();
            upper[last] = level;
            corner_box(&vec![0.0; world.dimension], &upper)
        }
        _ => {
            let (long, high) = (world.size[0] / (1.0 + random.index_below(2) as f64), 0.05 * world.size[0]);
            let (level, high, long) = (length(level), length(high), length(long));
            format!("{{ wave = {{ level = {level}, amplitude = {high}, wavelength = {long} }} }}")
        }
    };
    format!("\n[[liquid.body]]\nshape = {shape}\n")
}

/// A bounded liquid body, at rest or moving.
fn body(random: &mut Random, world: &mut SceneContext) -> String {
    let radius = random.log_uniform(4.0 * world.dx, (0.25 * world.shortest_side()).max(5.0 * world.dx));
    let center = world.place_ball(random, radius);
    let shape = ShapeRegion { world, center, radius, used: Use::Liquid }.shape(random);
    let mut text = format!("\n[[liquid.body]]\nshape = {shape}\n");
    if world.speed > 0.0 {
        let mut along = random.direction(world.dimension);
        // Half of the directions are made to point down, towards the objects below.
        if random.bernoulli(0.5) {
            let last = world.dimension - 1;
            along[last] = -along[last].abs();
        }
        let velocity: Vec<f64> = along.iter().map(|x| x * world.speed).collect();
        let _ = writeln!(text, "velocity = {}", list(&velocity, "m/s"));
    }
    text
}
