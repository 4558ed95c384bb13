//! `meniscus bench table1`: the paper's Table 1 and the times of Meniscus.

use super::super::{grid_text, print, show_progress, version};
use super::step::{StepBench, step};
use crate::failure::Result;
use meniscus_scene::builtin;
use meniscus_scene::estimate::memory;
use meniscus_scene::file::{LoadOptions, Quality, Scene};
use meniscus_scene::output::markdown;
use serde::Serialize;
use serde_json::{Value, json};
use std::fmt::Write as _;
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
    /// A remark on the scene, which follows its name in the table.
    note: &'static str,
}

/// A row without settings and note.
const fn row(
    scene: &'static str,
    figure: &'static str,
    mesh: [usize; 2],
    time_step: f64,
    seconds: f64,
) -> Row {
    Row { scene, figure, vertices: mesh[0], elements: mesh[1], time_step, seconds, set: &[], note: "" }
}

/// The cow starts up to its back in the liquid instead of above it.
const WADING: &[&str] = &[r#"solid.0.shape.cow.at=["2.496 cm", "2.496 cm", "2.3 cm"]"#];

/// The rows of Table 1 for which there are scenes.
static ROWS: [Row; 8] = [
    row("fig15-origami-square", "15", [28_227, 92_160], 6.67e-3, 4.12),
    row("fig21-tank-float", "21 (top)", [7_605, 28_880], 1e-2, 9.94),
    row("fig21-tank-sink", "21 (bot)", [7_605, 28_880], 1e-2, 10.32),
    Row {
        set: WADING,
        note: ", up to its back in the liquid",
        ..row("fig02-soft-cow", "2", [26_069, 143_193], 1e-2, 16.42)
    },
    Row {
        note: " (its mesh is coarser than the paper's)",
        ..row("drop-on-leaf", "11 (top)", [17_244, 70_795], 1.67e-3, 3.06)
    },
    row("fig22-plate-180", "22 (top)", [47_045, 184_320], 4e-2, 3.38),
    row("fig22-plate-90", "22 (mid)", [47_045, 184_320], 4e-2, 3.35),
    row("fig22-plate-0", "22 (bot)", [47_045, 184_320], 4e-2, 3.59),
];

/// A row of the paper and the times of the same scene here.
#[derive(Serialize)]
struct Compared<'a> {
    paper: &'a Row,
    ours: StepBench,
    /// Cells along the axes.
    #[serde(skip)]
    cells: Vec<usize>,
}

/// Times some steps of each scene and prints the table. `quick`: one step each at draft quality. `as_markdown`: rows go to standard
/// error as they come, and at the end the table goes to standard output as a page of Markdown.
pub fn table1(quick: bool, as_markdown: bool) -> Result<Value> {
    let show = |text: &str| show_progress(text, as_markdown);
    show(
        "table1: the paper's number, then ours\n\
         figure    scene                     vertices       elements   liquid cells  iterations        step s       s/step  peak GB\n",
    )?;
    let mut rows = Vec::new();
    for paper in &ROWS {
        let Some(scene) = scene(paper, quick)? else {
            show(&left_out(paper, "neither built in nor in scenes/"))?;
            continue;
        };
        if let Err(error) = memory::check_liquid_memory(&scene, memory::machine_memory()) {
            show(&left_out(paper, &error.to_string()))?;
            continue;
        }
        let ours = step(paper.scene.to_owned(), &scene, if quick { 1 } else { TIMED_STEPS })?;
        show(&line(paper, &ours))?;
        rows.push(Compared { paper, ours, cells: scene.domain.cells });
    }
    if as_markdown {
        print(&page(&rows, quick, rayon::current_num_threads()))?;
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

fn left_out(paper: &Row, reason: &str) -> String {
    format!("{:9} {:21} left out: {reason}\n", paper.figure, paper.scene)
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

/// The table as a page of Markdown, measured on so many threads.
fn page(rows: &[Compared], quick: bool, threads: usize) -> String {
    let mut out = format!("# Times beside the paper's\n\n{}\n", caption(quick, threads));
    out += "| | cells | vertices, the paper's and ours | tetrahedra | step, s | seconds a step | iterations |\n\
            |---|---|---|---|---|---|---|\n";
    rows.iter().for_each(|row| out += &markdown_row(row));
    let measured = |paper: &&Row| rows.iter().any(|row| row.paper.scene == paper.scene);
    let missing: Vec<String> =
        ROWS.iter().filter(|row| !measured(row)).map(|row| format!("`{}`", row.scene)).collect();
    if !missing.is_empty() {
        let _ = writeln!(out, "\nNot measured: {}.", missing.join(", "));
    }
    if let Some(bytes) = rows.iter().filter_map(|row| row.ours.peak_memory_bytes).max() {
        let _ = writeln!(out, "\nThe most memory that any of them took is {:.1} GB.", bytes as f64 * 1e-9);
    }
    out
}

/// The text above the table: machine, program, quality, and how the paper's times differ from these.
fn caption(quick: bool, threads: usize) -> String {
    let quality = if quick {
        "This is a trial: one step of each scene, on the coarse grids of `--quality draft`."
    } else {
        "Cells have the paper's size, 0.052 cm."
    };
    format!(
        "What a step costs in Table 1 of the paper and here: in pairs of numbers the first is the paper's. The paper's times are \
         of sixteen cores and a GPU, ours of {threads} threads ({}, {}; Meniscus {}) for the first steps of each scene; seconds \
         may vary by a quarter from run to run on a machine that others share. The paper's steps are frames, one of which takes \
         many of ours. {quality} The paper does not give the sizes of its tanks, which may be larger than ours. This page is made \
         by `meniscus bench table1{} --markdown`.\n",
        std::env::consts::OS,
        std::env::consts::ARCH,
        version(),
        if quick { " --quick" } else { "" },
    )
}

fn markdown_row(row: &Compared) -> String {
    let (paper, ours) = (row.paper, &row.ours);
    markdown::row(&[
        format!("Fig. {}, `{}`{}", paper.figure, paper.scene, paper.note),
        grid_text(&row.cells),
        format!("{}, {}", paper.vertices, ours.vertices),
        format!("{}, {}", paper.elements, ours.elements),
        format!("{:.1e}, {:.1e}", paper.time_step, ours.time_step),
        format!("{:.2}, {:.2}", paper.seconds, ours.seconds_per_step),
        format!("{:.0}", ours.iterations_per_step),
    ])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_compares_the_rows() {
        let ours =
            StepBench { vertices: 3141, elements: 11_664, seconds_per_step: 0.25, ..StepBench::default() };
        let rows = [Compared { paper: &ROWS[4], ours, cells: vec![156, 96, 96] }];
        let page = page(&rows, false, 2);
        let row = "| Fig. 11 (top), `drop-on-leaf` (its mesh is coarser than the paper's) | 156 × 96 × 96 | 17244, 3141 \
                   | 70795, 11664 | 1.7e-3, 0.0e0 | 3.06, 0.25 | 0 |";
        assert!(page.lines().any(|line| line == row), "{page}");
        assert!(page.contains("2 threads") && page.contains("0.052 cm"), "{page}");
        assert!(page.contains("Not measured: `fig15-origami-square`"), "{page}");
    }

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
