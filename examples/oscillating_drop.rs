//! A disc of water oscillates in mode 2 without gravity: its kinetic energy falls and rises twice in each period of 9.5 ms.
//! It prints time and energies every 0.5 ms; run it with `cargo run --release --example oscillating_drop`.

use meniscus_scene::build::AnySimulation;
use meniscus_scene::file::{LoadOptions, Scene};
use std::error::Error;
use std::path::Path;

const SCENE: &str = r#"
format = 1
name = "oscillating-drop"
domain = { dimension = 2, size = ["3 mm", "3 mm"], resolution = 64 }
liquid.density = "1 g/cm^3"
liquid.kinematic_viscosity = "0.01 cm^2/s"
liquid.body = [{ shape.perturbed_ball = { center = ["1.5 mm", "1.5 mm"], radius = "1 mm", mode = 2, amplitude = 0.05 } }]
tension.liquid_air = "72.8 mN/m"
output.duration = "10 ms"
"#;

/// Time between the rows, s.
const INTERVAL: f64 = 0.5e-3;

fn main() -> Result<(), Box<dyn Error>> {
    let scene = Scene::from_text("oscillating-drop.toml", SCENE, Path::new(""), &LoadOptions::default())?;
    let mut simulation = AnySimulation::of(&scene)?;
    let rows = (scene.output.duration / INTERVAL).round() as u32;
    println!("time (ms)  kinetic energy (µJ/m)  surface energy (µJ/m)");
    for row in 0..=rows {
        simulation.run_to(f64::from(row) * INTERVAL)?;
        let sums = simulation.diagnostics();
        let time = 1e3 * simulation.time();
        println!("{time:9.3}  {:21.4}  {:21.4}", 1e6 * sums.kinetic_energy, 1e6 * sums.surface_energy);
    }
    println!("{} steps", simulation.steps());
    Ok(())
}
