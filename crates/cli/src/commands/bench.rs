//! `meniscus bench`: where the time goes.

use super::table1::table1;
use super::{print, save, with_threads};
use crate::args::BenchArgs;
use crate::failure::{Failure, Result, USAGE};
use meniscus_scene::build;
use meniscus_scene::builtin;
use meniscus_scene::estimate::memory;
use meniscus_scene::file::{LoadOptions, Scene};
use meniscus_scene::output::summary::peak_memory;
use meniscus_validation::pressure_bench::{self, PressureBench, PressureProblem};
use serde::Serialize;
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::path::Path;
use std::time::Instant;

/// Steps that are done before the clock runs, and while it does.
const WARM: usize = 2;

/// Runs the benchmarks that are asked for.
pub fn bench(args: &BenchArgs) -> Result {
    let known = ["pressure", "step", "table1"];
    if let Some(name) = args.names.iter().find(|name| !known.contains(&name.as_str())) {
        let help = format!("there are: {}", known.join(", "));
        return Err(Failure::new(USAGE, format!("there is no benchmark `{name}`")).help(help));
    }
    with_threads(args.threads.map(usize::from), || measure(args))
}

/// Runs the benchmarks that are asked for on the thread pool that it is called from.
fn measure(args: &BenchArgs) -> Result {
    let wanted = |name: &str| args.names.is_empty() || args.names.iter().any(|n| n == name);
    let mut results =
        json!({ "version": env!("CARGO_PKG_VERSION"), "threads": rayon::current_num_threads() });
    if wanted("pressure") {
        results["pressure"] = pressure(args.quick)?;
    }
    if wanted("step") {
        results["step"] = steps(args.quick)?;
    }
    // It takes long, and is done only where it is asked for.
    if args.names.iter().any(|n| n == "table1") {
        results["table1"] = table1(args.quick)?;
    }
    if let Some(path) = &args.json {
        save(path, &format!("{results:#}\n"))?;
    }
    Ok(0)
}

fn pressure(quick: bool) -> Result<Value> {
    let n = if quick { 32 } else { 192 };
    print(
        "pressure    n  unknowns   setup s   solve s  iterations  residual   Jacobi s  iterations   peak MB\n",
    )?;
    let mut rows = Vec::new();
    for problem in [PressureProblem::Drop, PressureProblem::Tank] {
        let row = pressure_bench::run(problem, n, 1e-5, true)
            .map_err(|e| Failure::new(5, format!("the pressure solve failed: {e}")))?;
        print(&pressure_row(&row))?;
        rows.push(row);
    }
    Ok(json!(rows))
}

fn pressure_row(r: &PressureBench) -> String {
    let name = format!("{:?}", r.problem).to_lowercase();
    format!(
        "{name:8} {:4} {:9} {:9.3} {:9.3} {:11} {:9.1e} {:10.3} {:11} {:9.0}\n",
        r.n,
        r.unknowns,
        r.setup_s,
        r.solve_s,
        r.iterations,
        r.true_residual,
        r.jacobi_s.unwrap_or(f64::NAN),
        r.jacobi_iterations.unwrap_or(0),
        r.peak_memory_mb.unwrap_or(f64::NAN),
    )
}

/// Time per phase of whole steps.
#[derive(Serialize)]
pub struct StepBench {
    name: String,
    cells: usize,
    /// Cells of liquid at the end.
    pub liquid_cells: usize,
    /// Vertices of the solids that deform.
    pub vertices: usize,
    /// Their elements.
    pub elements: usize,
    steps: usize,
    /// Mean length of a step, s.
    pub time_step: f64,
    /// Wall time of a step, s.
    pub seconds_per_step: f64,
    /// Iterations of the pressure solve in a step.
    pub iterations_per_step: f64,
    /// Seconds per step and phase.
    phases: Vec<(String, f64)>,
    /// Largest memory of this process up to here, bytes.
    pub peak_memory_bytes: Option<u64>,
}

fn steps(quick: bool) -> Result<Value> {
    let n = if quick { 32 } else { 192 };
    let crown = LoadOptions { sets: vec![format!("domain.resolution={n}")], ..LoadOptions::default() };
    let crown = builtin::open("crown-splash", &crown)?;
    let scenes = [
        (format!("drop in {n}^3"), drop_scene(n, 1)?),
        (format!("drop on a free body in {n}^3"), body_scene(n)?),
        (format!("crown-splash {n}^3"), crown),
        (format!("drop in {}^3", 2 * n), drop_scene(n, 2)?),
    ];
    let count = if quick { 3 } else { 8 };
    let mut rows = Vec::new();
    for (name, scene) in scenes {
        if let Err(error) = memory::liquid_fits(&scene, memory::of_machine()) {
            eprintln!("{name}: left out: {error}");
            continue;
        }
        let row = step(name, &scene, count)?;
        print(&step_rows(&row))?;
        rows.push(row);
    }
    Ok(json!(rows))
}

/// A swinging drop of radius 0.3 n cells in the middle of a box of `factor` n cells: 0.8 million cells for n = 192.
fn drop_scene(n: usize, factor: usize) -> Result<Scene> {
    let (side, middle) = (3 * factor, 1.5 * factor as f64);
    let point = |v: f64| format!(r#"["{v} mm", "{v} mm", "{v} mm"]"#);
    let (size, center, cells) = (point(side as f64), point(middle), factor * n);
    let text = format!(
        r#"
        format = 1
        name = "bench-drop"
        domain = {{ dimension = 3, size = {size}, resolution = {cells} }}
        liquid = {{ density = "1 g/cm^3", kinematic_viscosity = "0.01 cm^2/s", body = [{{ shape = {{
            perturbed_ball = {{ center = {center}, radius = "0.9 mm", mode = 2, amplitude = 0.05 }} }} }}] }}
        tension = {{ liquid_air = "72.8 mN/m" }}
        output = {{ duration = "1 s" }}
        "#
    );
    Ok(Scene::from_text("bench-drop.toml", &text, Path::new(""), &LoadOptions::default())?)
}

/// As much liquid as half a ball on the middle of a free plate that it wets, without gravity, so that both move: 0.8 million
/// cells for n = 192.
fn body_scene(n: usize) -> Result<Scene> {
    let text = format!(
        r#"
        format = 1
        name = "bench-body"
        domain = {{ dimension = 3, size = ["3 mm", "3 mm", "3 mm"], resolution = {n} }}
        liquid = {{ density = "1 g/cm^3", kinematic_viscosity = "0.01 cm^2/s", body = [{{ shape = {{
            difference = {{
                of = {{ ball = {{ center = ["1.5 mm", "1.5 mm", "0.9 mm"], radius = "1.134 mm" }} }},
                minus = {{ half_space = {{ point = ["0 mm", "0 mm", "0.75 mm"], normal = [0, 0, 1] }} }} }} }} }}] }}
        solid = [{{ name = "plate", density = "1.25 g/cm^3", material = {{ rigid = {{}} }}, shape = {{
            box = {{ lower = ["0.2 mm", "0.2 mm", "0.6 mm"], upper = ["2.8 mm", "2.8 mm", "0.9 mm"] }} }} }}]
        tension = {{ liquid_air = "72.8 mN/m", plate = {{ contact_angle = "80 deg" }} }}
        output = {{ duration = "1 s" }}
        "#
    );
    Ok(Scene::from_text("bench-body.toml", &text, Path::new(""), &LoadOptions::default())?)
}

/// Times `count` steps of a scene in three dimensions.
pub fn step(name: String, scene: &Scene, count: usize) -> Result<StepBench> {
    let mut simulation = build::setup::<3>(scene)?.simulation();
    let mut phases: Vec<(String, f64)> = Vec::new();
    let (mut seconds, mut iterations, mut time) = (0.0, 0, 0.0);
    for i in 0..WARM + count {
        let start = Instant::now();
        let mut last = start;
        let mut phase_end = |phase: &'static str| {
            let now = Instant::now();
            let spent = if i < WARM { 0.0 } else { (now - last).as_secs_f64() / count as f64 };
            match phases.iter_mut().find(|(known, _)| known == phase) {
                Some((_, sum)) => *sum += spent,
                None => phases.push((phase.to_string(), spent)),
            }
            last = now;
        };
        let report = simulation
            .step(scene.output.frame_interval, &mut phase_end)
            .map_err(|e| Failure::new(5, format!("{name}: {e}")))?;
        if i >= WARM {
            seconds += start.elapsed().as_secs_f64();
            iterations += report.iterations();
            time += report.dt;
        }
    }
    let solids = simulation.model.solids.iter();
    let meshes: Vec<_> = solids.filter_map(|s| Some(s.elastic()?.mesh())).collect();
    Ok(StepBench {
        name,
        cells: scene.domain.cells.iter().product(),
        liquid_cells: simulation.liquid_cells().cells(),
        vertices: meshes.iter().map(|m| m.positions.len()).sum(),
        elements: meshes.iter().map(|m| m.simplices.len()).sum(),
        steps: count,
        time_step: time / count as f64,
        seconds_per_step: seconds / count as f64,
        iterations_per_step: iterations as f64 / count as f64,
        phases,
        peak_memory_bytes: peak_memory(),
    })
}

fn step_rows(row: &StepBench) -> String {
    let mut out = format!(
        "{}: {:.3} s/step, {} cells, {} of liquid, {:.1} iterations, peak {:.2} GB\n",
        row.name,
        row.seconds_per_step,
        row.cells,
        row.liquid_cells,
        row.iterations_per_step,
        row.peak_memory_bytes.map_or(f64::NAN, |bytes| bytes as f64 * 1e-9),
    );
    for (phase, seconds) in &row.phases {
        let share = 100.0 * seconds / row.seconds_per_step.max(f64::MIN_POSITIVE);
        let _ = writeln!(out, "    {phase:20} {seconds:9.4} s {share:5.1} %");
    }
    out
}
