//! A hash of all that a state holds: of what a checkpoint of it holds.

#![allow(clippy::unwrap_used)]

use meniscus_sim::{Component, State};

/// FNV-1a over bytes (G. Fowler, L. Noll, K.-P. Vo 1991).
fn fnv(bytes: impl IntoIterator<Item = u8>) -> u64 {
    let mix = |hash: u64, byte: u8| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
    bytes.into_iter().fold(0xcbf2_9ce4_8422_2325, mix)
}

/// The hash of numbers.
pub fn of_values(values: &[f64]) -> u64 {
    fnv(values.iter().flat_map(|value| value.to_le_bytes()))
}

/// The hash of a state.
pub fn hash<const D: usize>(state: &State<D>) -> u64 {
    fnv(postcard::to_stdvec(state).unwrap())
}

/// Sums of a state that tell how far two are apart: time, energies and areas, volume, centre of mass and momentum of the liquid, centres
/// and velocities of solids.
pub fn sums<const D: usize>(state: &State<D>) -> Vec<f64> {
    let volume: f64 = state.components.iter().map(|d| d.volume).sum();
    let of_drops = |of: &dyn Fn(&Component<D>) -> f64| state.components.iter().map(of).sum::<f64>();
    let mut sums = vec![state.time, state.kinetic_energy, state.effective_surface_area, volume];
    sums.extend((0..D).map(|a| of_drops(&|d| d.volume * d.centroid[a])));
    sums.extend(state.solids.iter().flat_map(|s| s.center_of_mass().iter().copied().collect::<Vec<f64>>()));
    sums
}
