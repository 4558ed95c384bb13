//! `meniscus bench table1`: the paper's Table 1 and the times of Meniscus.

use super::print;
use super::step_bench::{StepBench, step};
use crate::failure::Result;
use meniscus_scene::builtin;
use meniscus_scene::estimate::memory;
use meniscus_scene::file::{LoadOptions, Quality, Scene};
use serde::Serialize;
use serde_json::{Value, json};
use std::path::Path;

/// Timed steps of a scene.
const TIMED_STEPS: usize = 3;

/// A row of the paper's Table 1, measured on sixteen cores and a GPU.
#[derive(Clone, Copy, Debug, Serialize)]
struct Row {
    /// The corresponding scene.
    scene: &'static str,
    /// Figure of the paper.
    figure: &'static str,
    /// Vertices of the solid.
    vertices: usize,
    /// Its tetrahedra.
    elements: usize,
    /// The paper's time step, s; with its speeds it must be the time between frames.
    time_step: f64,
    /// Wall time per step, s.
    seconds: f64,
    /// Settings of the scene with which its first steps cost as much as later ones.
    set: &'static [&'static str],
}

/// A row without settings.
const fn row(
    scene: &'static str,
    figure: &'static str,
    mesh: [usize; 2],
    time_step: f64,
    seconds: f64,
) -> Row {
    Row { scene, figure, vertices: mesh[0], elements: mesh[1], time_step, seconds, set: &[] }
}

/// The cow starts up to its back in the liquid instead of above it.
const WADING: &[&str] = &[r#"solid.0.shape.cow.at=["2.496 cm", "2.496 cm", "2.3 cm"]"#];

/// The rows of Table 1 for which there are scenes.
const ROWS: [Row; 8] = [
    row("fig15-origami-square", "15", [28_227, 92_160], 6.67e-3, 4.12),
    row("fig21-tank-float", "21 (top)", [7_605, 28_880], 1e-2, 9.94),
    row("fig21-tank-sink", "21 (bot)", [7_605, 28_880], 1e-2, 10.32),
    Row { set: WADING, ..row("fig02-soft-cow", "2", [26_069, 143_193], 1e-2, 16.42) },
    row("drop-on-leaf", "11 (top)", [17_244, 70_795], 1.67e-3, 3.06),
    row("fig22-plate-180", "22 (top)", [47_045, 184_320], 4e-2, 3.38),
    row("fig22-plate-90", "22 (mid)", [47_045, 184_320], 4e-2, 3.35),
    row("fig22-plate-0", "22 (bot)", [47_045, 184_320], 4e-2, 3.59),
];

/// Times some steps of each scene and prints the table. `quick`: one step each at draft quality.
pub fn table1(quick: bool) -> Result<Value> {
    print(
        "table1: the paper's number, then ours\n\
         figure    scene                     vertices       elements   liquid cells  iterations        step s       s/step  peak GB\n",
    )?;
    let mut rows = Vec::new();
    for paper in &ROWS {
        let Some(scene) = scene(paper, quick)? else {
            print(&format!(
                "{:9} {:21} left out: neither built in nor in scenes/\n",
                paper.figure, paper.scene
            ))?;
            continue;
        };
        if let Err(error) = memory::check_liquid_memory(&scene, memory::machine_memory()) {
            print(&format!("{:9} {:21} left out: {error}\n", paper.figure, paper.scene))?;
            continue;
        }
        let ours = step(paper.scene.to_owned(), &scene, if quick { 1 } else { TIMED_STEPS })?;
        print(&line(paper, &ours))?;
        rows.push(json!({ "paper": paper, "ours": ours }));
    }
    Ok(json!(rows))
}

/// The scene of a row with its settings, built in or from `scenes/` of the current folder; none if there is none.
fn scene(row: &Row, quick: bool) -> Result<Option<Scene>> {
    let quality = if quick { Quality::Draft } else { Quality::Normal };
    let sets = row.set.iter().map(ToString::to_string).collect();
    let options = LoadOptions { quality, sets };
    if builtin::find(row.scene).is_some() {
        return Ok(Some(builtin::open(row.scene, &options)?));
    }
    let path = Path::new("scenes").join(row.scene).with_extension("toml");
    Ok(if path.is_file() { Some(Scene::load(&path, &options)?) } else { None })
}

fn line(paper: &Row, ours: &StepBench) -> String {
    format!(
        "{:9} {:21} {:>6} {:>6}  {:>6} {:>6}  {:>12}  {:>10.1}  {:>6.2e} {:>6.2e} {:>5.2} {:>6.2}  {:>7.2}\n",
        paper.figure,
        paper.scene,
        paper.vertices,
        ours.vertices,
        paper.elements,
        ours.elements,
        ours.liquid_cells,
        ours.iterations_per_step,
        paper.time_step,
        ours.time_step,
        paper.seconds,
        ours.seconds_per_step,
        ours.peak_memory_bytes.map_or(f64::NAN, |bytes| bytes as f64 * 1e-9),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_the_papers() {
        // 5-tetrahedra lattices of 96 x 96 x 2, 38 x 38 x 4 and 96 x 96 x 4 cells.
        let lattice = |n: [usize; 3]| ((n[0] + 1) * (n[1] + 1) * (n[2] + 1), 5 * n[0] * n[1] * n[2]);
        for (i, n) in [(0, [96, 96, 2]), (1, [38, 38, 4]), (5, [96, 96, 4])] {
            assert_eq!((ROWS[i].vertices, ROWS[i].elements), lattice(n), "{}", ROWS[i].scene);
        }
        assert!(ROWS.iter().all(|r| r.seconds > 0.0));
    }
}
