//! Checkpoints: all that a run needs to continue bit for bit.
//!
//! A file consists of: magic, format version, blocks, and a checksum of everything before it. The blocks hold the `Content` (`postcard`,
//! numbers with all their bits) in LZ4, each after its length; an empty one is the last. Files are written atomically. The last two are
//! kept, so that a damaged one costs some steps and not the run.

use crate::job::RunStatistics;
use crate::output::atomic_file::{self, FileError};
use meniscus_numerics::grid::Grid;
use meniscus_numerics::par;
use meniscus_sim::State;
use serde::{Deserialize, Serialize};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use thiserror::Error;

const MAGIC: &[u8; 8] = b"MENISCKP";
const VERSION: u32 = 17;
/// Bytes per block before compression.
const BLOCK_BYTES: usize = 1 << 22;
/// Blocks that are compressed side by side.
const BLOCKS_TOGETHER: usize = 8;
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

/// Data in the blocks of a checkpoint. `S` is the state when it is read, and a reference to it when it is written.
#[derive(Serialize, Deserialize)]
struct Content<S> {
    scene: u64,
    statistics: RunStatistics,
    state: S,
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
    let path = folder.join(format!("step_{:08}.ckpt", state.step));
    let content = Content { scene, statistics: tally.clone(), state };
    atomic_file::write_atomically(&path, |writer| {
        let mut file = Summed { writer, sum: Checksum::default() };
        file.write_all(MAGIC)?;
        file.write_all(&VERSION.to_le_bytes())?;
        let blocks = Blocks { file: &mut file, waiting: Vec::new() };
        postcard::to_io(&content, blocks).map_err(io::Error::other)?.finish()?;
        let sum = file.sum.value();
        file.writer.write_all(&sum.to_le_bytes())
    })?;
    remove_old(folder);
    Ok(path)
}

/// A writer that sums up what it writes.
struct Summed<W> {
    writer: W,
    sum: Checksum,
}

impl<W: Write> Write for Summed<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.writer.write(bytes)?;
        self.sum.update(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.writer.flush()
    }
}

/// A writer of compressed blocks.
struct Blocks<W> {
    file: W,
    waiting: Vec<u8>,
}

impl<W: Write> Blocks<W> {
    /// Compresses and writes all that waits.
    fn write_blocks(&mut self) -> io::Result<()> {
        let blocks: Vec<&[u8]> = self.waiting.chunks(BLOCK_BYTES).collect();
        let compressed = par::map_jobs(blocks, lz4_flex::block::compress_prepend_size);
        self.waiting.clear();
        compressed.iter().try_for_each(|block| {
            self.file.write_all(&(block.len() as u64).to_le_bytes())?;
            self.file.write_all(block)
        })
    }

    /// Writes what waits, and the end of the blocks.
    fn finish(mut self) -> io::Result<()> {
        self.write_blocks()?;
        self.file.write_all(&0u64.to_le_bytes())
    }
}

impl<W: Write> Write for Blocks<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let room = BLOCK_BYTES * BLOCKS_TOGETHER - self.waiting.len();
        let taken = bytes.len().min(room);
        self.waiting.extend_from_slice(&bytes[..taken]);
        if taken == room {
            self.write_blocks()?;
        }
        Ok(taken)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
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
    let blocks = verify(&bytes).map_err(|what| match what {
        Fault::Version => foreign("version of Meniscus"),
        Fault::Damage(what) => damaged(what),
    })?;
    let content = decompress(blocks).ok_or_else(|| damaged("its blocks cannot be read"))?;
    // The scene comes first: a state of another one may have another number of dimensions.
    let (own, _): (u64, _) =
        postcard::take_from_bytes(&content).map_err(|_| damaged("it does not name its scene"))?;
    if own != scene {
        return Err(foreign("scene"));
    }
    let content: Content<State<D>> =
        postcard::from_bytes(&content).map_err(|_| damaged("its state cannot be read"))?;
    if content.state.phi.grid != grid {
        return Err(foreign("grid"));
    }
    Ok((content.state, content.statistics))
}

enum Fault {
    Version,
    Damage(&'static str),
}

/// Checks magic, version and checksum. Returns the blocks.
fn verify(bytes: &[u8]) -> Result<&[u8], Fault> {
    let cut = Fault::Damage("it is truncated");
    let Some((start, rest)) = bytes.split_at_checked(12) else { return Err(cut) };
    if start[..8] != *MAGIC {
        return Err(Fault::Damage("it does not start with the signature of a checkpoint"));
    }
    if start[8..12] != VERSION.to_le_bytes() {
        return Err(Fault::Version);
    }
    let Some(covered) = bytes.len().checked_sub(8).filter(|&n| n >= 12) else { return Err(cut) };
    let mut sum = Checksum::default();
    sum.update(&bytes[..covered]);
    if bytes[covered..] != sum.value().to_le_bytes() {
        return Err(Fault::Damage("its checksum is wrong"));
    }
    rest.get(..covered - 12).ok_or(cut)
}

/// The content of blocks.
fn decompress(mut blocks: &[u8]) -> Option<Vec<u8>> {
    let mut compressed = Vec::new();
    loop {
        let (length, rest) = blocks.split_first_chunk::<8>()?;
        let length = usize::try_from(u64::from_le_bytes(*length)).ok()?;
        if length == 0 {
            break;
        }
        let (block, rest) = rest.split_at_checked(length)?;
        compressed.push(block);
        blocks = rest;
    }
    let parts = par::map_jobs(compressed, |block| lz4_flex::block::decompress_size_prepended(block).ok());
    let parts: Option<Vec<Vec<u8>>> = parts.into_iter().collect();
    Some(parts?.concat())
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
