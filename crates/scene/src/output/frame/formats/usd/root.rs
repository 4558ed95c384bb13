//! `run.usda`: the prims of a run, whose values come from the layers of its frames.
//!
//! It is made from the files that are in the folder, so that it is right after a run was resumed, and written anew after each frame. It
//! is its own manifest: it declares every attribute that clips have values of, without a value.

use super::layer::{self, ROOT, Range};
use super::prim::Prim;
use crate::output::frame::Frame;
use crate::output::{FileError, Folder, atomic_file};

/// Writes `run.usda` with all files `frame_NNNN.usda` of the folder.
pub(super) fn write(folder: &Folder, prims: &[Prim], frame: &Frame) -> Result<(), FileError> {
    let frames = folder.frames();
    let entries = std::fs::read_dir(&frames).map_err(FileError::of("read", &frames))?;
    let mut numbers: Vec<u64> = entries.flatten().filter_map(|e| number(e.file_name().to_str()?)).collect();
    numbers.sort_unstable();
    let (Some(&first), Some(&last)) = (numbers.first(), numbers.last()) else { return Ok(()) };
    atomic_file::write_atomically(&frames.join("run.usda"), |out| {
        layer::write_head(out, &Range { first, last, up_axis: frame.up_axis, unit: frame.unit })?;
        layer::open_root(out, Some(&clips(&numbers)))?;
        layer::write_time(out, None)?;
        prims.iter().try_for_each(|prim| layer::write_prim(out, prim, None))?;
        layer::close_root(out)
    })
}

/// Number of a file `frame_NNNN.usda`.
fn number(file: &str) -> Option<u64> {
    file.strip_prefix("frame_")?.strip_suffix(".usda")?.parse().ok()
}

/// The metadata of clips. A pair of `active` is a time code and the clip from then on; a pair of `times` is a time code of the run and that
/// of the clip. Two pairs at the number of a frame make a jump there, so that values hold until the next one: between frames whose
/// arrays happen to have the same length, programs would interpolate.
fn clips(numbers: &[u64]) -> String {
    let list = |items: Vec<String>| items.join(", ");
    let active = numbers.iter().enumerate().map(|(clip, number)| format!("({number}, {clip})"));
    let paths = numbers.iter().map(|number| format!("@./frame_{number:04}.usda@"));
    let before = |i: usize| i.checked_sub(1).map(|before| numbers[before]);
    let times = numbers.iter().enumerate().flat_map(|(i, number)| {
        let jump = before(i).map(|earlier| format!("({number}, {earlier})"));
        jump.into_iter().chain([format!("({number}, {number})")])
    });
    format!(
        "    clips = {{\n        dictionary default = {{\n            double2[] active = [{}]\n            asset[] assetPaths = [{}]\n            \
         asset manifestAssetPath = @./run.usda@\n            string primPath = \"/{ROOT}\"\n            double2[] times = [{}]\n        }}\n    }}\n",
        list(active.collect()),
        list(paths.collect()),
        list(times.collect())
    )
}
