//! `meniscus export`: stored frames in another format.
//!
//! A frame is rebuilt from its PLY files, which have the surfaces and the contact line with all their attributes to the last digit, for
//! every frame. Checkpoints have more, but only of the last two times, and only this version reads them.

use super::print;
use crate::args::{ExportArgs, UpAxis, Wetted};
use crate::failure::{Failure, OUTPUT, Result, USAGE};
use meniscus_scene::output::atomic_file::create_folder;
use meniscus_scene::output::frame::{Format, Frame, FrameMesh, stored_wall_solid};
use meniscus_scene::output::{FileError, Folder};
use meniscus_view::{Frame as StoredFrame, RunFolder, ViewError, WettedFaces};
use std::path::{Path, PathBuf};

/// Converts frames of a run.
pub fn export(args: &ExportArgs) -> Result {
    let run = RunFolder::open(&args.dir).map_err(|error| {
        Failure::new(OUTPUT, error.to_string()).help("give the output folder of a run, such as out/my-scene")
    })?;
    let numbers = chosen_frames(&run, args)?;
    let Some(writer) = args.to.frame_writer() else {
        return Err(Failure::new(USAGE, format!("frames cannot be written as {}", args.to.name())));
    };
    let (folder, removed) = target(args)?;
    let up = match args.up {
        None => run.dimension - 1,
        Some(UpAxis::Y) => 1,
        Some(UpAxis::Z) => 2,
    };
    let (wetted, dx) = wetted_faces(&run, args.wetted)?;
    let (mut without_line, mut has_elements) = (0, false);
    for number in &numbers {
        let mut stored = read(&run, *number)?;
        wetted.apply(&mut stored, run.dimension, dx);
        let frame = rebuilt(&run, stored)?.placed(args.scale, up);
        without_line += usize::from(frame.contact_line.is_none());
        has_elements |= frame.solids.iter().any(|(_, mesh)| mesh.values("ux").is_some());
        writer.write(&folder, u64::from(*number), &frame)?;
    }
    report(args, &folder, numbers.len(), removed)?;
    if args.to == Format::Csv && without_line == numbers.len() {
        eprintln!("warning: no frame has a contact line, so there is no table");
    }
    if args.to == Format::Vtk && has_elements {
        let help = "a run with output.formats = [\"vtk\"] in its scene writes them into frames/";
        eprintln!("note: elements of deformable solids (.vtu) are not in stored frames; {help}");
    }
    Ok(0)
}

/// Numbers of the frames that the arguments choose.
fn chosen_frames(run: &RunFolder, args: &ExportArgs) -> Result<Vec<u32>> {
    let (first, last) = args.frames.unwrap_or((0, u64::MAX));
    let chosen = run.frame_numbers.iter().copied().filter(|n| (first..=last).contains(&u64::from(*n)));
    let chosen: Vec<u32> = chosen.step_by(args.every as usize).collect();
    match (&run.frame_numbers[..], chosen.is_empty()) {
        ([least, .., most], true) | ([least @ most], true) => {
            let message = format!("{} has no frame in the range of --frames", run.dir.display());
            Err(Failure::new(USAGE, message).help(format!("its frames are {least} to {most}")))
        }
        _ => Ok(chosen),
    }
}

/// The frame of the PLY files with a number.
///
/// # Errors
/// A failure of status 4 if there is no such frame, or a file of it cannot be read.
pub fn stored_frame(run: &RunFolder, number: u32) -> Result<Frame> {
    rebuilt(run, read(run, number)?)
}

/// The meshes of a frame.
fn read(run: &RunFolder, number: u32) -> Result<StoredFrame> {
    let help = "the file may be damaged: leave the frame out with --frames, or run the scene again";
    let fail = |error: ViewError| Failure::new(OUTPUT, error.to_string()).help(help);
    run.frame(number).map_err(fail)
}

/// Returns the treatment of wetted faces and the size of a cell, m, in terms of which they are moved.
fn wetted_faces(run: &RunFolder, wetted: Wetted) -> Result<(WettedFaces, f64)> {
    let faces = match wetted {
        Wetted::Keep => WettedFaces::Keep,
        Wetted::Sink => WettedFaces::Sink,
        Wetted::Remove => WettedFaces::Remove,
    };
    match (faces, run.dx) {
        (WettedFaces::Sink, None) => {
            let message = format!("{}: the size of a cell is unknown", run.dir.display());
            Err(Failure::new(OUTPUT, message).help("summary.json has no `dx`: leave out --wetted sink"))
        }
        (faces, dx) => Ok((faces, dx.unwrap_or(0.0))),
    }
}

/// A frame of its stored meshes.
fn rebuilt(run: &RunFolder, stored: StoredFrame) -> Result<Frame> {
    let time = stored.time.ok_or_else(|| {
        let message = format!("{}: the time of frame {} is unknown", run.dir.display(), stored.number);
        Failure::new(OUTPUT, message)
            .help("the PLY files have no comment `time`, and summary.json no frame_interval")
    })?;
    // Runs of early versions have files of lines without vertices.
    let line = stored.contact_line.filter(|line| !line.positions.is_empty());
    let mut solids = stored.solids;
    let in_order = run.solid_order().into_iter();
    let in_order = in_order.filter_map(|name| solids.remove(&name).map(|mesh| (name, FrameMesh::from(mesh))));
    Ok(Frame {
        time,
        interval: run.frame_interval,
        unit: 1.0,
        up_axis: run.dimension - 1,
        liquid: stored.liquid.into(),
        solids: in_order.collect(),
        wall_solid: line.as_ref().and_then(|line| stored_wall_solid(&line.comments)),
        contact_line: line.map(FrameMesh::from),
        elements: Vec::new(),
        fields: None,
    })
}

/// The folder of the exported files, which is made. In the default one files of an earlier export are removed; returns how many.
fn target(args: &ExportArgs) -> Result<(Folder, usize)> {
    let Some(out) = &args.out else {
        let out = Folder::at(&args.dir).exports().join(args.to.name());
        create_folder(&out)?;
        let old = files(&out, args.to)?;
        old.iter().try_for_each(|path| std::fs::remove_file(path).map_err(FileError::of("remove", path)))?;
        return Ok((Folder::of_frames(&out), old.len()));
    };
    create_folder(out)?;
    let frames = Folder::at(&args.dir).frames();
    if args.to == Format::Ply && is_same_folder(out, &frames) {
        let message = format!("{} has the frames that are to be exported", frames.display());
        return Err(Failure::new(USAGE, message).help("give another folder with --out"));
    }
    Ok((Folder::of_frames(out), 0))
}

fn is_same_folder(a: &Path, b: &Path) -> bool {
    let real = |path: &Path| path.canonicalize().ok();
    real(a).is_some_and(|a| real(b) == Some(a))
}

/// The files of a format in a folder.
fn files(folder: &Path, format: Format) -> Result<Vec<PathBuf>> {
    let extensions: &[&str] = match format {
        Format::Vtk => &["vtp", "vtu", "pvd"],
        Format::Usd => &["usda"],
        _ => &[format.name()],
    };
    let entries = std::fs::read_dir(folder).map_err(FileError::of("read", folder))?;
    let is_of_format = |path: &PathBuf| {
        path.is_file() && path.extension().and_then(|e| e.to_str()).is_some_and(|e| extensions.contains(&e))
    };
    Ok(entries.flatten().map(|entry| entry.path()).filter(is_of_format).collect())
}

fn report(args: &ExportArgs, folder: &Folder, frames: usize, removed: usize) -> Result<()> {
    let files = files(folder.root(), args.to)?;
    let bytes: u64 = files.iter().filter_map(|path| Some(path.metadata().ok()?.len())).sum();
    let plural = |count: usize| if count == 1 { "" } else { "s" };
    let mut text = format!(
        "exported  {frames} frame{} to {} ({} file{}, {})\n",
        plural(frames),
        folder.root().display(),
        files.len(),
        plural(files.len()),
        indicatif::DecimalBytes(bytes)
    );
    if removed > 0 {
        text += &format!("removed   {removed} files of an earlier export\n");
    }
    print(&text)
}
