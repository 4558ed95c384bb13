//! What is mended in a step is told, and how much of it.

#![allow(clippy::expect_used)]

use meniscus_numerics::Vector;
use meniscus_numerics::grid::Grid;
use meniscus_sim::{LiquidRegion, Model, Numerics, Repairs, Simulation, Solid, Wall};

fn model(solids: Vec<Solid<2>>) -> Model<2> {
    Model {
        grid: Grid::new([32; 2], 1.0 / 32.0),
        walls: [[Wall::Open; 2]; 2],
        density: 2.0,
        kinematic_viscosity: 0.0,
        surface_tension: 1.0,
        gravity: Vector::zeros(),
        solids,
        numerics: Numerics::default(),
    }
}

fn ball(x: f64, y: f64, radius: f64) -> impl Fn(&Vector<2>) -> f64 {
    move |at| (at - Vector::<2>::new(x, y)).norm() - radius
}

fn repairs(simulation: &mut Simulation<2>, steps: usize) -> Repairs {
    let mut sum = Repairs::default();
    (0..steps).for_each(|_| sum.add(&simulation.step(f64::INFINITY, &mut |_| ()).expect("a step").repairs));
    sum
}

/// What is restored is told; where nothing is restored, nothing is, and the momentum has changed by no more than that.
#[test]
fn restored_momentum_is_told() {
    let (one, other) = (ball(0.36, 0.47, 0.13), ball(0.65, 0.55, 0.14));
    let run = |restore: bool| {
        let mut model = model(Vec::new());
        model.numerics.restore_momentum = restore;
        let speed = |u| Vector::<2>::new(u, 0.0);
        let bodies = [
            LiquidRegion { signed_distance: &one, velocity: speed(2.0) },
            LiquidRegion { signed_distance: &other, velocity: speed(-2.0) },
        ];
        let mut simulation = Simulation::new(model, &bodies);
        let start = simulation.diagnostics();
        let sum = repairs(&mut simulation, 30);
        let change = (simulation.diagnostics().momentum - start.momentum).norm();
        (sum, change, start.volume)
    };
    let (kept, change, volume) = run(true);
    assert!(kept.momentum_restored > 1e3 * change && kept.spin_restored > 0.0, "{kept:?}");
    assert!(kept.volume_shift > 0.0 && kept.volume_shift_net.abs() <= kept.volume_shift);
    assert!(kept.volume_shift_largest * volume <= kept.volume_shift * (1.0 + 1e-6));
    let (free, change, _) = run(false);
    assert_eq!((free.momentum_restored, free.spin_restored), (0.0, 0.0));
    assert!(change > 0.0 && change < 10.0 * kept.momentum_restored, "{change} {kept:?}");
}

/// A drop whose cells are gone has vanished: its volume and its momentum are told.
#[test]
fn vanished_drops_are_told() {
    let (large, small) = (ball(0.35, 0.5, 0.2), ball(0.8, 0.5, 0.08));
    let velocity = Vector::<2>::new(0.5, 0.0);
    let bodies = [
        LiquidRegion { signed_distance: &large, velocity },
        LiquidRegion { signed_distance: &small, velocity },
    ];
    let mut model = model(Vec::new());
    // So much volume moved at once would be tried again with a shorter step.
    model.numerics.fixed_step = Some(1e-3);
    let mut simulation = Simulation::new(model, &bodies);
    assert_eq!(repairs(&mut simulation, 1).vanished_volume, 0.0);
    let gone = simulation.state.components[1].target_volume;
    let grid = simulation.model.grid;
    for (i, phi) in simulation.state.phi.data.iter_mut().enumerate() {
        let x = grid.center(grid.lattice().coordinates(i));
        *phi = if x[0] > 0.65 { phi.abs().max(3.0 * grid.dx) } else { *phi };
    }
    let sum = repairs(&mut simulation, 1);
    assert_eq!(sum.vanished_volume, gone);
    let momentum = 2.0 * gone * 0.5;
    assert!((sum.vanished_momentum / momentum - 1.0).abs() < 1e-2, "{sum:?}");
    // The other inherits the volume, so that the shift moves it.
    assert!((sum.volume_shift_net / gone - 1.0).abs() < 1e-2, "{sum:?}");
}
