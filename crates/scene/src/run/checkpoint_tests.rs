//! Tests: checkpoints hold a whole state, and damaged or foreign ones are refused.

use super::*;
use meniscus_elastic::ElasticState;
use meniscus_numerics::{Matrix, Vector};
use meniscus_sim::{
    Component, ContactKey, DeformableKinematics, Kinematics, Repairs, RigidKinematics, Slip, SolidState,
};

fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("meniscus-{name}-{}", std::process::id()));
    let _ = std::fs::remove_dir_all(&folder);
    atomic_file::create_folder(&folder).unwrap();
    folder
}

fn example() -> State<2> {
    let mut state = State::empty(Grid::new([31, 17], 0.1));
    state.phi.data.iter_mut().enumerate().for_each(|(i, v)| *v = (i as f64).sin());
    state.velocity.axes[1].iter_mut().enumerate().for_each(|(i, v)| *v = -1.0 / (i as f64 + 3.0));
    state.time = 0.1 + 0.2;
    state.step = 7;
    state.components.push(Component {
        target_volume: 1.0 / 3.0,
        volume: 0.3,
        centroid: Vector::from([0.1, 0.2]),
        lower: Vector::zeros(),
        upper: Vector::from([1.0, 2.0]),
        velocity: Vector::from([-0.0, 1e-300]),
        angular_momentum_per_density: [0.0, 0.0, 0.7],
    });
    let rigid = SolidState {
        pressure_force: Vector::from([0.1, 0.7]),
        contact_line_force: Vector::from([0.2, -0.1]),
        contact_acceleration: Vector::from([0.5, 9.0]),
        ..SolidState::new(Kinematics::Rigid(RigidKinematics {
            center: Vector::from([0.3, 0.4]),
            rotation: Matrix::from_column_slice(&[0.6, 0.8, -0.8, 0.6]),
            velocity: Vector::from([1.0, -2.0]),
            angular_velocity: [0.0, 0.0, 3.0],
        }))
    };
    let vertices = ElasticState {
        time: 0.7,
        positions: vec![Vector::from([0.1, 0.2]), Vector::from([-3.0, 1e-9])],
        velocities: vec![Vector::from([0.3, 0.0]), Vector::from([7.0, -0.1])],
    };
    let (center, velocity) = (Vector::from([-1.45, 0.1]), Vector::from([3.65, -0.05]));
    let deformable = Kinematics::Deformable(DeformableKinematics { center, velocity, vertices });
    state.solids = vec![rigid, SolidState::new(deformable)];
    for (other, friction_limit) in [(0, 3.0), (9, 0.1)] {
        let slip = Slip {
            displacement: Vector::from([1e-9, -0.3]),
            rate: Vector::from([0.1, -0.0]),
            friction_limit,
        };
        state.elastic_slips.insert(ContactKey { points: [4, 7], other }, slip);
    }
    (state.pressure_impulse.data[3], state.kinetic_energy, state.effective_surface_area) = (2.5, 0.1, 0.3);
    state
}

#[test]
fn what_is_written_is_read_bit_for_bit() {
    let folder = folder("checkpoint-round");
    let state = example();
    let repairs = Repairs { volume_shift: 1.0 / 3.0, redone: 5, ..Repairs::default() };
    let tally = RunStatistics { next_frame: 3, mass: 1e-3, repairs, ..RunStatistics::default() };
    let path = write(&folder, 42, &state, &tally).unwrap();
    let (back, tally_back) = read(&path, 42, state.phi.grid).unwrap();
    assert_eq!(back, state);
    assert_eq!(tally_back, tally);
    assert!(matches!(read(&path, 43, state.phi.grid), Err(CheckpointError::Foreign { .. })));
    assert!(matches!(read(&path, 42, Grid::new([30, 17], 0.1)), Err(CheckpointError::Foreign { .. })));
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn any_damaged_byte_is_noticed() {
    let folder = folder("checkpoint-damage");
    let state = example();
    let path = write(&folder, 42, &state, &RunStatistics::default()).unwrap();
    let good = std::fs::read(&path).unwrap();
    for at in (0..good.len()).step_by(7) {
        let mut bad = good.clone();
        bad[at] ^= 0x10;
        std::fs::write(&path, &bad).unwrap();
        assert!(read(&path, 42, state.phi.grid).is_err(), "byte {at}");
        std::fs::write(&path, &good[..at]).unwrap();
        assert!(read(&path, 42, state.phi.grid).is_err(), "cut at {at}");
    }
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn the_last_two_are_kept() {
    let folder = folder("checkpoint-keep");
    let mut state = example();
    for step in [7, 8, 120] {
        state.step = step;
        write(&folder, 1, &state, &RunStatistics::default()).unwrap();
    }
    let names: Vec<_> = list(&folder).iter().map(|p| p.file_name().unwrap().to_owned()).collect();
    assert_eq!(names, ["step_00000120.ckpt", "step_00000008.ckpt"]);
    std::fs::remove_dir_all(&folder).unwrap();
}
