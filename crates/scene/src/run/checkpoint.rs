//! Checkpoints: all that a run needs to continue bit for bit.
//!
//! A file consists of: magic, format version, length of the header, header (`postcard`), the fields of the state as little-endian `f64`
//! in LZ4 blocks, and a checksum of everything before it. Files are written atomically. The last two are kept, so that a damaged one
//! costs some steps and not the run.

use crate::job::RunStatistics;
use crate::output::atomic_file::{self, FileError};
use meniscus_elastic::ElasticState;
use meniscus_numerics::grid::Grid;
use meniscus_numerics::{Matrix, Vector};
use meniscus_sim::{Component, ContactKey, Slip, Slips, Soft, SolidState, State};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::io::Write;
use std::path::{Path, PathBuf};
use thiserror::Error;

const MAGIC: &[u8; 8] = b"MENISCKP";
const VERSION: u32 = 14;
/// Values per compressed block (4 MiB).
const VALUES_PER_BLOCK: usize = 1 << 19;
/// Number of checkpoints that are kept.
const CHECKPOINTS_KEPT: usize = 2;

/// Why a checkpoint cannot be used.
#[derive(Debug, Error)]
pub enum CheckpointError {
    /// The file could not be read.
    #[error(transparent)]
    File(#[from] FileError),
    /// The file is damaged.
    #[error("the checkpoint `{}` is damaged: {what}", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        what: String,
    },
    /// The checkpoint belongs to another scene, grid or the like.
    #[error("the checkpoint `{}` belongs to another {what}", path.display())]
    Foreign {
        /// The file.
        path: PathBuf,
        /// What differs.
        what: &'static str,
    },
}

#[derive(Serialize, Deserialize)]
struct Header {
    scene: u64,
    cells: Vec<u64>,
    dx: f64,
    step: u64,
    /// The scalar fields of the state, in the order in which `write` lists them.
    scalars: [f64; 12],
    components: Vec<ComponentRecord>,
    /// Per solid: centre, rotation by columns, velocity, angular velocity, forces, contact acceleration; for a deformable solid also its
    /// time, all positions, and all velocities.
    solids: Vec<Vec<f64>>,
    /// Per elastic slip the two points and the other solid.
    contacts: Vec<[u32; 3]>,
    /// Per elastic slip its record of numbers.
    slips: Vec<f64>,
    tally: RunStatistics,
    /// Bytes of each compressed block, per array: φ, pressure impulse, then the velocity along each axis.
    blocks: Vec<Vec<u64>>,
}

#[derive(Serialize, Deserialize)]
struct ComponentRecord {
    target_volume: f64,
    volume: f64,
    /// Centroid, lower, upper, velocity.
    vectors: [Vec<f64>; 4],
    angular_momentum_per_density: [f64; 3],
}

fn solid_record<'a, const D: usize>(solid: &'a SolidState<D>) -> Vec<f64> {
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
    let motion = center.iter().chain(rotation).chain(velocity).chain(angular_velocity);
    let vertices = |s: &'a Soft<D>| s.state.positions.iter().chain(&s.state.velocities);
    let vertices = soft.iter().flat_map(vertices).flatten();
    let time = soft.iter().map(|s| &s.state.time);
    let forces = pressure_force.iter().chain(contact_line_force).chain(contact_acceleration);
    motion.chain(forces).chain(time).chain(vertices).copied().collect()
}

fn decode_solid<const D: usize>(record: &[f64]) -> Option<SolidState<D>> {
    let (record, vertices) = record.split_at_checked(5 * D + D * D + 3)?;
    let (time, vertices) = vertices.split_at(vertices.len().min(1));
    let (vertices, rest) = vertices.as_chunks::<D>();
    if !rest.is_empty() || vertices.len() % 2 != 0 {
        return None;
    }
    let vertices: Vec<Vector<D>> = vertices.iter().map(|v| Vector::from(*v)).collect();
    let (positions, velocities) = vertices.split_at(vertices.len() / 2);
    let (positions, velocities) = (positions.to_vec(), velocities.to_vec());
    let soft = |time: &f64| Soft::without_surface(ElasticState { positions, velocities, time: *time });
    let soft = time.first().map(soft);
    let (center, rest) = record.split_at(D);
    let (rotation, rest) = rest.split_at(D * D);
    let (velocity, rest) = rest.split_at(D);
    let (angular_velocity, rest) = rest.split_at(3);
    let (pressure_force, rest) = rest.split_at(D);
    let (line_force, rest) = rest.split_at(D);
    Some(SolidState {
        center: Vector::from_column_slice(center),
        rotation: Matrix::from_column_slice(rotation),
        velocity: Vector::from_column_slice(velocity),
        angular_velocity: angular_velocity.try_into().ok()?,
        pressure_force: Vector::from_column_slice(pressure_force),
        contact_line_force: Vector::from_column_slice(line_force),
        contact_acceleration: Vector::from_column_slice(rest),
        soft,
    })
}

fn slip_record<const D: usize>(slip: &Slip<D>) -> Vec<f64> {
    let Slip { displacement, rate, friction_limit } = slip;
    displacement.iter().chain(rate).chain([friction_limit]).copied().collect()
}

fn decode_slips<const D: usize>(touches: &[[u32; 3]], slips: &[f64]) -> Option<Slips<D>> {
    let records = slips.chunks_exact(2 * D + 1);
    if slips.len() != touches.len() * (2 * D + 1) {
        return None;
    }
    let slip = |([first, last, other], record): (&[u32; 3], &[f64])| {
        let (displacement, rest) = record.split_at(D);
        let (rate, hold) = rest.split_at(D);
        let (displacement, rate) = (Vector::from_column_slice(displacement), Vector::from_column_slice(rate));
        (
            ContactKey { points: [*first, *last], other: *other },
            Slip { displacement, rate, friction_limit: hold[0] },
        )
    };
    Some(touches.iter().zip(records).map(slip).collect())
}

impl ComponentRecord {
    fn of<const D: usize>(drop: &Component<D>) -> Self {
        let Component {
            target_volume,
            volume,
            centroid,
            lower,
            upper,
            velocity,
            angular_momentum_per_density,
        } = drop;
        let vectors = [centroid, lower, upper, velocity].map(|v| v.iter().copied().collect());
        Self {
            target_volume: *target_volume,
            volume: *volume,
            vectors,
            angular_momentum_per_density: *angular_momentum_per_density,
        }
    }

    fn decode<const D: usize>(&self) -> Option<Component<D>> {
        if self.vectors.iter().any(|v| v.len() != D) {
            return None;
        }
        let [centroid, lower, upper, velocity] =
            [0, 1, 2, 3].map(|i| Vector::<D>::from_fn(|a, _| self.vectors[i][a]));
        Some(Component {
            target_volume: self.target_volume,
            volume: self.volume,
            centroid,
            lower,
            upper,
            velocity,
            angular_momentum_per_density: self.angular_momentum_per_density,
        })
    }
}

/// Writes the checkpoint of a state into a folder, then removes those that are too old.
///
/// # Errors
/// [`FileError`]; earlier checkpoints are then untouched.
pub fn write<const D: usize>(
    folder: &Path,
    scene: u64,
    state: &State<D>,
    tally: &RunStatistics,
) -> Result<PathBuf, FileError> {
    // Every field is named: a new field must be written to the file, or a resumed run differs.
    let State {
        time,
        step,
        last_dt,
        velocity_lead,
        impulse_time,
        collision_free_dt,
        displacement_since_redistancing,
        phi,
        velocity,
        pressure_impulse,
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
    let fields = [&phi.data, &pressure_impulse.data].into_iter().chain(&velocity.axes);
    let arrays: Vec<Vec<Vec<u8>>> = fields.map(|array| compress(array)).collect();
    let header = Header {
        scene,
        cells: phi.grid.cells.iter().map(|&n| n as u64).collect(),
        dx: phi.grid.dx,
        step: *step,
        scalars: [
            *time,
            *last_dt,
            *velocity_lead,
            *impulse_time,
            *collision_free_dt,
            *displacement_since_redistancing,
            *lost_volume,
            *outflow_volume,
            *outflow_kinetic_energy,
            *outflow_stored_energy,
            *kinetic_energy,
            *effective_surface_area,
        ],
        components: components.iter().map(ComponentRecord::of).collect(),
        solids: solids.iter().map(solid_record).collect(),
        contacts: elastic_slips.keys().map(|t| [t.points[0], t.points[1], t.other]).collect(),
        slips: elastic_slips.values().flat_map(slip_record).collect(),
        tally: tally.clone(),
        blocks: arrays.iter().map(|blocks| blocks.iter().map(|b| b.len() as u64).collect()).collect(),
    };
    let path = folder.join(format!("step_{step:08}.ckpt"));
    let header = postcard::to_stdvec(&header).map_err(|e| FileError {
        action: "write",
        path: path.clone(),
        source: std::io::Error::other(e),
    })?;
    atomic_file::write_atomically(&path, |writer| {
        let mut sum = Checksum::default();
        let mut put = |bytes: &[u8]| {
            sum.update(bytes);
            writer.write_all(bytes)
        };
        put(MAGIC)?;
        put(&VERSION.to_le_bytes())?;
        put(&(header.len() as u64).to_le_bytes())?;
        put(&header)?;
        arrays.iter().flatten().try_for_each(|block| put(block))?;
        writer.write_all(&sum.value().to_le_bytes())
    })?;
    remove_old(folder);
    Ok(path)
}

fn compress(array: &[f64]) -> Vec<Vec<u8>> {
    array
        .par_chunks(VALUES_PER_BLOCK)
        .map(|values| {
            let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
            lz4_flex::block::compress(&bytes)
        })
        .collect()
}

fn remove_old(folder: &Path) {
    let files = list(folder);
    for old in files.iter().skip(CHECKPOINTS_KEPT) {
        let _ = std::fs::remove_file(old);
    }
}

/// Removes the checkpoints newer than the given one, which are damaged.
pub fn remove_newer(path: &Path) {
    let Some(folder) = path.parent() else { return };
    for newer in list(folder).iter().take_while(|file| *file != path) {
        let _ = std::fs::remove_file(newer);
    }
}

/// The checkpoints of a folder, newest first.
pub fn list(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let mut files: Vec<PathBuf> = entries
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| path.extension().is_some_and(|e| e == "ckpt"))
        .collect();
    files.sort();
    files.reverse();
    files
}

/// Reads a checkpoint of the given scene and grid.
///
/// # Errors
/// [`CheckpointError`].
pub fn read<const D: usize>(
    path: &Path,
    scene: u64,
    grid: Grid<D>,
) -> Result<(State<D>, RunStatistics), CheckpointError> {
    let bytes = std::fs::read(path).map_err(FileError::of("read", path))?;
    let foreign = |what| CheckpointError::Foreign { path: path.to_path_buf(), what };
    let damaged = |what: &str| CheckpointError::Damaged { path: path.to_path_buf(), what: what.to_string() };
    let (head, body) = verify(&bytes).map_err(|what| match what {
        Fault::Version => foreign("version of Meniscus"),
        Fault::Damage(what) => damaged(what),
    })?;
    let header: Header = postcard::from_bytes(head).map_err(|_| damaged("its header cannot be read"))?;
    if header.scene != scene {
        return Err(foreign("scene"));
    }
    let same_cells = header.cells.iter().map(|&n| n as usize).eq(grid.cells);
    if !same_cells || header.dx.to_bits() != grid.dx.to_bits() {
        return Err(foreign("grid"));
    }
    let state = decode_state(&header, body, grid).ok_or_else(|| damaged("its fields are incomplete"))?;
    Ok((state, header.tally))
}

enum Fault {
    Version,
    Damage(&'static str),
}

/// Checks magic, version and checksum. Returns the header and the bytes after it.
fn verify(bytes: &[u8]) -> Result<(&[u8], &[u8]), Fault> {
    let cut = Fault::Damage("it is truncated");
    let Some((start, rest)) = bytes.split_at_checked(20) else { return Err(cut) };
    if start[..8] != *MAGIC {
        return Err(Fault::Damage("it does not start with the signature of a checkpoint"));
    }
    if start[8..12] != VERSION.to_le_bytes() {
        return Err(Fault::Version);
    }
    let Some(covered) = bytes.len().checked_sub(8).filter(|&n| n >= 20) else { return Err(cut) };
    let mut sum = Checksum::default();
    sum.update(&bytes[..covered]);
    if bytes[covered..] != sum.value().to_le_bytes() {
        return Err(Fault::Damage("its checksum is wrong"));
    }
    let length = start[12..].iter().rev().fold(0u64, |n, &b| (n << 8) | u64::from(b));
    rest[..covered - 20].split_at_checked(length as usize).ok_or(cut)
}

fn decode_state<const D: usize>(header: &Header, body: &[u8], grid: Grid<D>) -> Option<State<D>> {
    if header.blocks.len() != D + 2 {
        return None;
    }
    let mut state = State::empty(grid);
    let mut rest = body;
    let arrays =
        [&mut state.phi.data, &mut state.pressure_impulse.data].into_iter().chain(&mut state.velocity.axes);
    for (array, blocks) in arrays.zip(&header.blocks) {
        rest = decompress(array, blocks, rest)?;
    }
    let n = header.scalars;
    [
        state.time,
        state.last_dt,
        state.velocity_lead,
        state.impulse_time,
        state.collision_free_dt,
        state.displacement_since_redistancing,
        state.lost_volume,
        ..,
    ] = n;
    [.., state.outflow_volume, state.outflow_kinetic_energy, state.outflow_stored_energy, _, _] = n;
    [.., state.kinetic_energy, state.effective_surface_area] = n;
    state.step = header.step;
    state.components = header.components.iter().map(ComponentRecord::decode).collect::<Option<_>>()?;
    state.solids = header.solids.iter().map(|r| decode_solid(r)).collect::<Option<_>>()?;
    state.elastic_slips = decode_slips(&header.contacts, &header.slips)?;
    Some(state)
}

fn decompress<'a>(array: &mut [f64], blocks: &[u64], body: &'a [u8]) -> Option<&'a [u8]> {
    if blocks.len() != array.len().div_ceil(VALUES_PER_BLOCK) {
        return None;
    }
    let mut rest = body;
    for (values, &length) in array.chunks_mut(VALUES_PER_BLOCK).zip(blocks) {
        let (block, after) = rest.split_at_checked(length as usize)?;
        let raw = lz4_flex::block::decompress(block, values.len() * 8).ok()?;
        let (words, tail) = raw.as_chunks::<8>();
        if words.len() != values.len() || !tail.is_empty() {
            return None;
        }
        for (value, word) in values.iter_mut().zip(words) {
            *value = f64::from_le_bytes(*word);
        }
        rest = after;
    }
    Some(rest)
}

/// A 64-bit checksum that detects any single damaged bit: FNV-1a over 8-byte words. Independent of how the bytes are chunked.
#[derive(Default)]
pub(crate) struct Checksum {
    hash: u64,
    pending: [u8; 8],
    filled: usize,
    length: u64,
}

impl Checksum {
    pub(crate) fn update(&mut self, bytes: &[u8]) {
        self.length += bytes.len() as u64;
        let mut bytes = bytes;
        while self.filled > 0 && !bytes.is_empty() {
            self.push(bytes[0]);
            bytes = &bytes[1..];
        }
        let (words, tail) = bytes.as_chunks::<8>();
        for word in words {
            self.mix(u64::from_le_bytes(*word));
        }
        tail.iter().for_each(|&byte| self.push(byte));
    }

    fn push(&mut self, byte: u8) {
        self.pending[self.filled] = byte;
        self.filled += 1;
        if self.filled == 8 {
            self.filled = 0;
            self.mix(u64::from_le_bytes(self.pending));
            self.pending = [0; 8];
        }
    }

    fn mix(&mut self, word: u64) {
        self.hash = (self.hash ^ 0xcbf2_9ce4_8422_2325 ^ word).wrapping_mul(0x0000_0100_0000_01b3);
        self.hash ^= self.hash >> 29;
    }

    pub(crate) fn value(mut self) -> u64 {
        self.mix(u64::from_le_bytes(self.pending));
        self.mix(self.length);
        self.hash
    }
}

#[cfg(test)]
#[path = "checkpoint_tests.rs"]
mod tests;
