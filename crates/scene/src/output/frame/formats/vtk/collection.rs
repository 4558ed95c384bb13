//! The `.pvd` of a run: which files belong to which time. ParaView opens it as one animation.
//!
//! It is made from the files that are in the folder, so that it is right after a run was resumed, and written anew after each frame.

use crate::output::{FileError, Folder, atomic_file};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::{Read, Write as _};
use std::path::Path;

/// Bytes at the start of a file in which its time is.
const HEAD_BYTES: u64 = 1024;

/// Files of one part of the frames.
pub(super) struct Part {
    /// Name of the files before their number.
    pub name: String,
    /// Their extension.
    pub extension: &'static str,
}

/// Writes `NAME.pvd` with all files of these parts that are in the folder of the frames. The place of a part in the list is its number,
/// the same at all times.
pub(super) fn write(folder: &Folder, name: &str, parts: &[Part]) -> Result<(), FileError> {
    let frames = folder.frames();
    let path = frames.join(format!("{name}.pvd"));
    let mut times = std::fs::read_to_string(&path).map(|old| listed_times(&old)).unwrap_or_default();
    let entries = std::fs::read_dir(&frames).map_err(FileError::of("read", &frames))?;
    let mut found = Vec::new();
    for file in entries.flatten().filter_map(|entry| entry.file_name().into_string().ok()) {
        let Some((number, part)) = place(&file, parts) else { continue };
        // Files that carry no time are not ours.
        let known = times.get(&number).cloned();
        let Some(time) = known.or_else(|| stored_time(&frames.join(&file))) else { continue };
        times.insert(number, time.clone());
        found.push((number, part, file, time));
    }
    found.sort();
    let mut text = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n<Collection>\n",
    );
    for (_, part, file, time) in found {
        let name = &parts[part].name;
        let _ = writeln!(
            text,
            "<DataSet timestep=\"{time}\" group=\"\" part=\"{part}\" name=\"{name}\" file=\"{file}\"/>"
        );
    }
    text += "</Collection>\n</VTKFile>\n";
    atomic_file::write_atomically(&path, |out| out.write_all(text.as_bytes()))
}

/// Number and part of a file, if it is one of the parts.
fn place(file: &str, parts: &[Part]) -> Option<(u64, usize)> {
    let (stem, extension) = file.rsplit_once('.')?;
    let (name, number) = stem.rsplit_once('_')?;
    let part = parts.iter().position(|p| p.extension == extension && p.name == name)?;
    Some((number.parse().ok()?, part))
}

/// Times by the number of the frame in an earlier version of the file.
fn listed_times(text: &str) -> BTreeMap<u64, String> {
    let entry = |line: &str| {
        let number = between(line, "file=\"", "\"")?.rsplit_once('.')?.0.rsplit_once('_')?.1;
        Some((number.parse().ok()?, between(line, "timestep=\"", "\"")?.to_owned()))
    };
    text.lines().filter_map(entry).collect()
}

/// The time in a VTK file, as it is written there.
fn stored_time(path: &Path) -> Option<String> {
    let mut head = Vec::new();
    std::fs::File::open(path).ok()?.take(HEAD_BYTES).read_to_end(&mut head).ok()?;
    let head = String::from_utf8_lossy(&head);
    let time = between(head.split_once("\"TimeValue\"")?.1, ">", "<")?.trim().to_owned();
    time.parse::<f64>().is_ok().then_some(time)
}

/// The part of a text between two delimiters.
fn between<'a>(text: &'a str, before: &str, after: &str) -> Option<&'a str> {
    Some(text.split_once(before)?.1.split_once(after)?.0)
}
