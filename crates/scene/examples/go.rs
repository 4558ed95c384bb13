//! scratch
use meniscus_scene::build::AnySetup;
use meniscus_scene::builtin;
use meniscus_scene::file::LoadOptions;
use meniscus_scene::run::{Schedule, Setup};
fn go<const D: usize>(setup: &Setup<D>, scene: &meniscus_scene::file::Scene, most: u64) {
    let mut sim = setup.simulation();
    let schedule = Schedule::new(scene.output.frame_interval, scene.output.duration);
    let mut frame = 1;
    let mut before: Option<f64> = None;
    let (mut first, mut scale) = (f64::NAN, 1.0);
    let mut largest: Vec<f64> = Vec::new();
    let mut ups = 0.0;
    let mut least = f64::INFINITY;
    let mut again: f64 = 0.0;
    let mut recent: Vec<f64> = Vec::new();
    let quiet = std::env::var("MEN_QUIET").is_ok();
    let mut net = 0.0;
    let l0 = sim.ledger();
    let e0 = l0.kinetic_energy + l0.surface_energy + l0.potential_energy;
    for _ in 0..most {
        if frame > schedule.last_frame() {
            break;
        }
        let longest = if sim.model.numerics.fixed_step.is_some() {
            f64::INFINITY
        } else {
            schedule.longest_step(sim.state.time, frame)
        };
        let report = match sim.step(longest, &mut |_| ()) {
            Ok(r) => r,
            Err(e) => {
                println!("error {e}");
                break;
            }
        };
        if schedule.meets(sim.state.time, frame) {
            sim.state.time = schedule.time(frame);
        }
        if schedule.reaches(sim.state.time, frame) {
            frame += 1;
        }
        let l = &report.ledger;
        let k = l.kinetic_energy + sim.state.outflow_kinetic_energy;
        let rest = l.surface_energy + l.potential_energy + l.elastic_energy;
        let e = rest + 0.5 * (before.unwrap_or(k) + k) + sim.state.outflow_stored_energy;
        before = Some(k);
        if std::env::var("MEN_E").is_ok() {
            eprintln!("E step {} t {:.5e} dt {:.3e} e {:.4e} k {:.4e} surf {:.4e} pot {:.4e} el {:.4e} max {:.3e} drops {} redone {} doubtful {} moved {:.2e} spin {:.2e}", sim.state.step, sim.state.time, report.dt, e, k, l.surface_energy, l.potential_energy, l.elastic_energy, l.max_speed, sim.state.drops.len(), report.repairs.redone, report.repairs.doubtful_steps, report.repairs.momentum_restored, report.repairs.spin_restored);
        }
        if first.is_nan() {
            first = e;
            scale = k.max(l.surface_energy.abs()).max(e0.abs()).max(1e-300);
        }
        recent.push(e);
        if recent.len() >= 8 {
            let m = recent[recent.len() - 8..].iter().sum::<f64>() / 8.0;
            least = least.min(m);
            again = again.max((m - least) / scale);
        }
        ups = f64::max(ups, (e - first) / scale);
        if std::env::var("MEN_WHERE").is_ok() {
            let mut best = (0.0, [0.0; D], 0);
            for a in 0..D {
                let lat = sim.model.grid.faces(a);
                for (i, u) in sim.state.velocity.axes[a].iter().enumerate() {
                    if u.abs() > best.0 {
                        let x = sim.model.grid.face_center(a, lat.coordinates(i));
                        best = (u.abs(), std::array::from_fn(|b| x[b] * 1e3), a);
                    }
                }
            }
            let mut solid = (0.0, [0.0; D], 0);
            for now in &sim.state.solids {
                if let Some(soft) = &now.soft {
                    for (k, v) in soft.body.velocities.iter().enumerate() {
                        if v.norm() > solid.0 {
                            solid = (v.norm(), std::array::from_fn(|b| soft.body.positions[k][b] * 1e3), k);
                        }
                    }
                }
            }
            eprintln!("W step {} liquid {:.3e} at {:?} axis {} solid {:.3e} at {:?} vertex {}", sim.state.step, best.0, best.1, best.2, solid.0, solid.1, solid.2);
        }
        if let Ok(list) = std::env::var("MEN_DUMP") {
            if D == 2 && list.split(',').any(|n| n == sim.state.step.to_string()) {
                let grid = sim.model.grid;
                let lat = grid.lattice();
                println!("step {}", sim.state.step);
                let (mut lo, mut hi) = (grid.cells[1], 0);
                for j in 0..grid.cells[1] {
                    for i in 0..grid.cells[0] {
                        let mut at = [0; D];
                        at[0] = i;
                        at[1] = j;
                        if sim.state.phi.data[lat.index(at)] < 0.0 {
                            lo = lo.min(j);
                            hi = hi.max(j);
                        }
                    }
                }
                for j in (lo.saturating_sub(1)..(hi + 2).min(grid.cells[1])).rev() {
                    let mut row = String::new();
                    for i in 0..grid.cells[0] {
                        let mut at = [0; D];
                        at[0] = i;
                        at[1] = j;
                        let c = lat.index(at);
                        let v = sim.state.phi.data[c] / grid.dx;
                        if std::env::var("MEN_NUM").is_ok() {
                            row.push_str(&format!("{:6.2}", v));
                            continue;
                        }
                        let x = grid.center(at);
                        let solid = sim.distance_to_solids(&x) < 0.0;
                        row.push(if solid {
                            if v < 0.0 { 'W' } else { 'w' }
                        } else if v < -0.5 {
                            '#'
                        } else if v < 0.0 {
                            '+'
                        } else if v < 0.5 {
                            '-'
                        } else {
                            '.'
                        });
                    }
                    println!("{j:3} {row}");
                }
            }
        }
        largest.push(report.repairs.volume_shift_largest);
        net += report.repairs.volume_shift_net / l.volume;
        if !quiet {
            println!(
                "{} sol {:?} t {:.3e} dt {:.2e} E {:.5e} K {:.4e} S {:.4e} P {:.4e} vmax {:.3e} shift {:.2e} net {:.2e} drops {} restored {:.2e} spin {:.2e} del {:.1e}",
                sim.state.step,
                sim.state
                    .solids
                    .iter()
                    .map(|s| (
                        format!("{:.2}", s.velocity.norm()),
                        format!("{:.1e}", s.pressed.norm()),
                        format!("{:.1e}", s.pulled.norm()),
                        format!("{:.0}", s.spin[2])
                    ))
                    .collect::<Vec<_>>(),
                sim.state.time,
                sim.state.last_dt,
                e,
                k,
                l.surface_energy,
                l.potential_energy,
                l.max_speed,
                report.repairs.volume_shift_largest,
                report.repairs.volume_shift_net / l.volume,
                sim.state.drops.len(),
                report.repairs.momentum_restored,
                report.repairs.spin_restored,
                report.repairs.deleted_volume
            );
        }
    }
    if largest.is_empty() {
        return;
    }
    let mut sorted = largest.clone();
    sorted.sort_by(f64::total_cmp);
    let n = sorted.len().max(1);
    let over = sorted.iter().filter(|s| **s > 1e-3).count();
    println!(
        "{} out {:.2e} steps {} shift median {:.2e} p90 {:.2e} max {:.2e} over {} net {:.2e} sum {:.2e} Eup {:.2e} again {:.2e}",
        scene.name,
        sim.state.outflow_volume,
        n,
        sorted[n / 2],
        sorted[n * 9 / 10],
        sorted[n - 1],
        over,
        net,
        sorted.iter().sum::<f64>(),
        ups,
        again
    );
}
fn main() {
    rayon::scope(|_| run());
}
fn run() {
    let args: Vec<String> = std::env::args().collect();
    let most: u64 = args[1].parse().unwrap();
    for path in &args[2..] {
        let scene = builtin::open(path, &LoadOptions::default()).unwrap();

        match AnySetup::of(&scene).unwrap() {
            AnySetup::D2(s) => go(&s, &scene, most),
            AnySetup::D3(s) => go(&s, &scene, most),
        }
    }
}
