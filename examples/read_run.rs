//! Reads the folder of a run without the simulator: the summary, the time series and the meshes of the frames.
//! After the example `own_frame_writer` run it with `cargo run --release --example read_run`, or give a folder behind `--`.

use meniscus_view::{RunFolder, TimeSeries};
use std::error::Error;
use std::path::PathBuf;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().nth(1).unwrap_or_else(|| "out/own-frame-writer".into());
    let folder = PathBuf::from(folder);
    let run = RunFolder::open(&folder)?;
    println!("scene {}, {}D, {} steps", run.summary["scene"], run.dimension, run.summary["steps"]);

    let series = TimeSeries::load_all(&folder.join("timeseries.csv"))?;
    for name in ["time", "liquid_volume", "kinetic_energy", "contact_angle_mean"] {
        let column = series.column(name).ok_or_else(|| format!("there is no column `{name}`"))?;
        match column.iter().rev().find_map(|value| *value) {
            Some(last) => println!("last {name}: {last:e}"),
            None => println!("last {name}: none"),
        }
    }

    println!("frame  time (ms)  vertices  height (mm)  contact points");
    for number in &run.frame_numbers {
        let frame = run.frame(*number)?;
        let time = 1e3 * frame.time.ok_or("a frame without time")?;
        let up = run.dimension - 1;
        let height = frame.liquid.positions.iter().map(|x| x[up]).fold(f64::NEG_INFINITY, f64::max);
        let points = frame.contact_line.map_or(0, |line| line.positions.len());
        let vertices = frame.liquid.positions.len();
        println!("{number:5}  {time:9.3}  {vertices:8}  {:11.4}  {points:14}", 1e3 * height);
    }
    Ok(())
}
