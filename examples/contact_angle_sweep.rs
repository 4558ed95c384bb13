//! A sweep over the contact angle: a drop settles on plates of four materials, and the angle at its contact line is measured.
//! It prints the angle of the scene and the measured one; run it with `cargo run --release --example contact_angle_sweep`.

use meniscus_scene::build::AnySimulation;
use meniscus_scene::builtin;
use meniscus_scene::file::{LoadOptions, Quality};
use std::error::Error;

/// Angles of the plates, degrees.
const ANGLES: [f64; 4] = [45.0, 70.0, 95.0, 120.0];

/// Largest difference of a measured angle, degrees, on this coarse grid.
const TOLERANCE: f64 = 3.0;

fn main() -> Result<(), Box<dyn Error>> {
    println!("angle of the scene (deg)  measured (deg)");
    for angle in ANGLES {
        let measured = measured_angle(angle)?;
        println!("{angle:24.1}  {measured:14.2}");
        if (measured - angle).abs() > TOLERANCE {
            return Err(format!("the angles differ by more than {TOLERANCE} degrees").into());
        }
    }
    Ok(())
}

/// Mean contact angle, degrees, at the end of a built-in scene with another angle of its plate.
fn measured_angle(angle: f64) -> Result<f64, Box<dyn Error>> {
    let sets = vec![format!("tension.plate.contact_angle={angle}deg")];
    let scene = builtin::open("fig12-contact-angle-45-2d", &LoadOptions { sets, quality: Quality::Draft })?;
    let mut simulation = AnySimulation::of(&scene)?;
    simulation.run_to(scene.output.duration)?;
    let line = simulation.frame()?.contact_line.ok_or("the drop does not touch the plate")?;
    let angles = line.values("angle").ok_or("the contact line has no angles")?;
    Ok(angles.iter().sum::<f64>() / angles.len() as f64)
}
