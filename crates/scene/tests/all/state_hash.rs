//! A hash of all that a state holds. Every field is named: one that is new does not compile until it is in the hash.

use meniscus_elastic::ElasticState;
use meniscus_numerics::grid::{CellField, FaceField};
use meniscus_sim::{Component, ContactKey, Slip, Soft, SolidState, State};

/// FNV-1a over the bits of numbers (G. Fowler, L. Noll, K.-P. Vo 1991).
struct Fnv(u64);

impl Fnv {
    fn bits(&mut self, bits: u64) {
        for byte in bits.to_le_bytes() {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }

    fn all<'a>(&mut self, values: impl IntoIterator<Item = &'a f64>) {
        values.into_iter().for_each(|value| self.bits(value.to_bits()));
    }
}

fn of(put: impl FnOnce(&mut Fnv)) -> u64 {
    let mut fnv = Fnv(0xcbf2_9ce4_8422_2325);
    put(&mut fnv);
    fnv.0
}

/// The hash of numbers.
pub fn of_values(values: &[f64]) -> u64 {
    of(|fnv| fnv.all(values))
}

/// The hashes of the parts of a state.
pub fn hashes<const D: usize>(state: &State<D>) -> Vec<(&'static str, u64)> {
    let State {
        time,
        step,
        last_dt,
        velocity_lead,
        impulse_time,
        collision_free_dt,
        displacement_since_redistancing,
        phi: CellField { data: phi, grid: _ },
        velocity: FaceField { axes: velocity, grid: _ },
        pressure_impulse: CellField { data: lambda, grid: _ },
        components,
        solids,
        elastic_slips,
        lost_volume,
        outflow_volume,
        outflow_kinetic_energy,
        outflow_stored_energy,
        kinetic_energy,
        effective_surface_area,
    } = state;
    let times = of(|fnv| {
        fnv.bits(*step);
        fnv.all([
            time,
            last_dt,
            velocity_lead,
            impulse_time,
            collision_free_dt,
            displacement_since_redistancing,
        ]);
    });
    let sums = of(|fnv| {
        fnv.all([lost_volume, outflow_volume, outflow_kinetic_energy, outflow_stored_energy]);
        fnv.all([kinetic_energy, effective_surface_area]);
    });
    let elastic_slips = of(|fnv| {
        for (ContactKey { points, other }, Slip { displacement, rate, friction_limit }) in elastic_slips {
            points.iter().chain([other]).for_each(|n| fnv.bits(u64::from(*n)));
            fnv.all(displacement.iter().chain(rate.iter()).chain([friction_limit]));
        }
    });
    vec![
        ("times", times),
        ("sums", sums),
        ("phi", of_values(phi)),
        ("velocity", of(|fnv| velocity.iter().for_each(|axis| fnv.all(axis)))),
        ("lambda", of_values(lambda)),
        ("drops", of(|fnv| components.iter().for_each(|drop| put_drop(fnv, drop)))),
        ("solids", of(|fnv| solids.iter().for_each(|solid| put_solid(fnv, solid)))),
        ("slips", elastic_slips),
    ]
}

/// The hash of a state.
pub fn hash<const D: usize>(state: &State<D>) -> u64 {
    of(|fnv| hashes(state).iter().for_each(|(_, part)| fnv.bits(*part)))
}

fn put_drop<const D: usize>(fnv: &mut Fnv, drop: &Component<D>) {
    let Component { target_volume, volume, centroid, lower, upper, velocity, angular_momentum_per_density } =
        drop;
    fnv.all([target_volume, volume]);
    [centroid, lower, upper, velocity].iter().for_each(|vector| fnv.all(vector.iter()));
    fnv.all(angular_momentum_per_density);
}

fn put_solid<const D: usize>(fnv: &mut Fnv, solid: &SolidState<D>) {
    let SolidState {
        center,
        rotation,
        velocity,
        angular_velocity,
        pressure_force,
        contact_line_force,
        contact_acceleration,
        soft,
    } = solid;
    [center, velocity, pressure_force, contact_line_force, contact_acceleration]
        .iter()
        .for_each(|vector| fnv.all(vector.iter()));
    fnv.all(rotation.iter());
    fnv.all(angular_velocity);
    // The surface follows from the positions.
    let Some(Soft { state: ElasticState { positions, velocities, time }, surface: _ }) = soft else { return };
    positions.iter().chain(velocities).for_each(|vector| fnv.all(vector.iter()));
    fnv.bits(time.to_bits());
}

/// Sums of a state that tell how far two are apart: time, energies and areas, volume, centre of mass and momentum of the liquid, centres
/// and velocities of solids.
pub fn sums<const D: usize>(state: &State<D>) -> Vec<f64> {
    let volume: f64 = state.components.iter().map(|d| d.volume).sum();
    let of_drops = |of: &dyn Fn(&Component<D>) -> f64| state.components.iter().map(of).sum::<f64>();
    let mut sums = vec![state.time, state.kinetic_energy, state.effective_surface_area, volume];
    sums.extend((0..D).map(|a| of_drops(&|d| d.volume * d.centroid[a])));
    sums.extend(state.solids.iter().flat_map(|s| s.center.iter().copied().collect::<Vec<f64>>()));
    sums
}
