//! `meniscus bench`: run times by part.

mod precision;
mod roofline;
mod step;
mod table1;

use super::{print, save, version, with_threads};
use crate::args::BenchArgs;
use crate::failure::{Failure, Result, USAGE};
use meniscus_scene::builtin;
use meniscus_scene::estimate::memory;
use meniscus_scene::file::{LoadOptions, Scene};
use meniscus_validation::bench::pressure::{self, PressureBench, PressureProblem};
use precision::precision;
use roofline::Machine;
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::path::Path;
use step::{StepBench, step};
use table1::table1;

/// Runs the requested benchmarks.
pub fn bench(args: &BenchArgs) -> Result {
    let known = ["pressure", "step", "table1", "precision"];
    if let Some(name) = args.names.iter().find(|name| !known.contains(&name.as_str())) {
        let help = format!("available benchmarks: {}", known.join(", "));
        return Err(Failure::new(USAGE, format!("there is no benchmark `{name}`")).help(help));
    }
    if args.markdown && args.names != ["table1"] && args.names != ["precision"] {
        let help = "use `meniscus bench table1 --markdown` or `meniscus bench precision --markdown`";
        return Err(Failure::new(USAGE, "--markdown prints the table of one of these benchmarks").help(help));
    }
    let times_steps = args.names.is_empty() || args.names.iter().any(|name| name == "step");
    if !times_steps && (!args.scene.is_empty() || args.steps.is_some()) {
        return Err(Failure::new(USAGE, "--scene and --steps belong to `meniscus bench step`"));
    }
    if args.roofline && args.names != ["step"] {
        return Err(Failure::new(USAGE, "--roofline belongs to `meniscus bench step`"));
    }
    if args.resume && args.names != ["precision"] {
        return Err(Failure::new(USAGE, "--resume belongs to `meniscus bench precision`"));
    }
    with_threads(args.threads.map(usize::from), || measure(args))
}

/// Runs the requested benchmarks on the current thread pool.
fn measure(args: &BenchArgs) -> Result {
    let wanted = |name: &str| args.names.is_empty() || args.names.iter().any(|n| n == name);
    let mut results = json!({ "version": version(), "threads": rayon::current_num_threads() });
    if wanted("pressure") {
        results["pressure"] = pressure_solves(args.quick)?;
    }
    if wanted("step") {
        results["step"] = if args.roofline { rooflines(args)? } else { steps(args, None)? };
    }
    // These take long, so they run only on request.
    if args.names.iter().any(|n| n == "table1") {
        results["table1"] = table1(args.quick, args.markdown)?;
    }
    if args.names.iter().any(|n| n == "precision") {
        results["precision"] = precision(args, &results)?;
    }
    if let Some(path) = &args.json {
        save(path, &format!("{results:#}\n"))?;
    }
    Ok(0)
}

fn pressure_solves(quick: bool) -> Result<Value> {
    let n = if quick { 32 } else { 192 };
    print(
        "pressure    n  unknowns   setup s   solve s  iterations  residual   Jacobi s  iterations   peak MB\n",
    )?;
    let mut rows = Vec::new();
    for problem in [PressureProblem::Drop, PressureProblem::Tank] {
        let row = pressure::run(problem, n, 1e-5, true)
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

/// The scenes of `bench step`.
const STEP_SCENES: [&str; 4] = ["drop", "body", "crown-splash", "drop-large"];

/// Whole steps beside the limits of the machine, on one thread and on all.
fn rooflines(args: &BenchArgs) -> Result<Value> {
    let all = rayon::current_num_threads();
    let mut counts = vec![1, all];
    counts.dedup();
    let on = |threads: usize| {
        with_threads(Some(threads), || {
            let machine = Machine::measure();
            Ok(json!({ "machine": machine, "scenes": steps(args, Some(&machine))? }))
        })
    };
    counts.into_iter().map(on).collect::<Result<Vec<_>>>().map(Value::from)
}

/// Times whole steps, and prints them beside the limits of the `machine` if it is given.
fn steps(args: &BenchArgs, machine: Option<&Machine>) -> Result<Value> {
    let named = args.scene.iter().map(String::as_str);
    let names: Vec<&str> = if args.scene.is_empty() { STEP_SCENES.to_vec() } else { named.collect() };
    let count = args.steps.map_or(if args.quick { 3 } else { 8 }, |n| n as usize);
    let mut rows = Vec::new();
    for name in names {
        let (name, scene) = step_scene(name, if args.quick { 32 } else { 192 })?;
        if let Err(error) = memory::check_liquid_memory(&scene, memory::machine_memory()) {
            eprintln!("{name}: skipped: {error}");
            continue;
        }
        let row = step(name, &scene, count)?;
        print(&machine.map_or_else(|| step_rows(&row), |machine| roofline::rows(&row, machine)))?;
        rows.push(row);
    }
    Ok(json!(rows))
}

/// A scene of `bench step` with `n` cells along each side, or any other scene as it is, with the title of its rows.
fn step_scene(name: &str, n: usize) -> Result<(String, Scene)> {
    Ok(match name {
        "drop" => (format!("drop in {n}^3"), drop_scene(n, 1)?),
        "body" => (format!("drop on a free body in {n}^3"), body_scene(n)?),
        "crown-splash" => {
            let resolution = vec![format!("domain.resolution={n}")];
            let options = LoadOptions { sets: resolution, ..LoadOptions::default() };
            (format!("crown-splash {n}^3"), builtin::open(name, &options)?)
        }
        "drop-large" => (format!("drop in {}^3", 2 * n), drop_scene(n, 2)?),
        other => (other.to_string(), builtin::open(other, &LoadOptions::default())?),
    })
}

/// An oscillating drop of radius 0.3 n cells in the middle of a box of `factor` n cells: 0.8 million cells for n = 192.
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

/// Half a ball of liquid on the middle of a free plate that it wets, without gravity, so that both move: 0.8 million cells for n = 192.
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
