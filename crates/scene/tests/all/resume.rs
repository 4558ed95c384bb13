//! A simulation that goes on from a copy of its state does the same as one that never stopped, to the last bit.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use meniscus_scene::build;
use meniscus_scene::builtin;
use meniscus_scene::file::LoadOptions;
use meniscus_sim::{Compiled, Simulation, State};

fn differences<const D: usize>(a: &State<D>, b: &State<D>) -> String {
    let count = |x: &[f64], y: &[f64]| x.iter().zip(y).filter(|(x, y)| x.to_bits() != y.to_bits()).count();
    let mut out = String::new();
    let mut note = |what: &str, n: usize| {
        if n > 0 {
            out += &format!("{what}: {n}; ");
        }
    };
    note("phi", count(&a.phi.data, &b.phi.data));
    note("lambda", count(&a.pressure_impulse.data, &b.pressure_impulse.data));
    (0..D).for_each(|i| note("velocity", count(&a.velocity.axes[i], &b.velocity.axes[i])));
    note("drops", usize::from(a.components != b.components));
    let numbers = |s: &State<D>| {
        let sums =
            [s.lost_volume, s.outflow_volume, s.outflow_energy(), s.kinetic_energy, s.effective_surface_area];
        [[s.time, s.last_dt, s.velocity_lead, s.impulse_time, s.displacement_since_redistancing], sums]
            .concat()
    };
    note("numbers", count(&numbers(a), &numbers(b)));
    out
}

fn check<const D: usize>(name: &str, resolution: usize, steps: usize)
where
    Simulation<D>: Compiled<D>,
{
    let sets = vec![format!("domain.resolution={resolution}")];
    let scene = builtin::open(name, &LoadOptions { sets, ..LoadOptions::default() }).unwrap();
    let mut whole: Simulation<D> = build::setup(&scene).unwrap().simulation();
    for step in 0..steps {
        let mut again = Simulation::resume(whole.model.clone(), whole.state.clone());
        let found = differences(&whole.state, &again.state);
        assert!(found.is_empty(), "{name}: after {step} steps resuming changes the state: {found}");
        whole.step(1e-3, &mut |_| {}).unwrap();
        again.step(1e-3, &mut |_| {}).unwrap();
        let found = differences(&whole.state, &again.state);
        assert!(found.is_empty(), "{name}: step {step} after resuming differs: {found}");
    }
}

#[test]
fn a_drop_in_two_dimensions() {
    check::<2>("oscillating-drop-2d", 48, 60);
}

#[test]
fn a_falling_column() {
    check::<2>("dam-break-2d", 48, 60);
}

#[test]
fn colliding_drops_in_three_dimensions() {
    check::<3>("colliding-drops", 32, 30);
}
