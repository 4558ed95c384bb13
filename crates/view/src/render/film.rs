//! A film of the pictures, made by `ffmpeg` if it is installed.

use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// File name of the film.
pub(crate) const NAME: &str = "film.mp4";

/// Writes `film.mp4` into the folder `to`; the error is a message.
pub(crate) fn make(to: &Path, images: &[PathBuf], rate: u32) -> Result<PathBuf, String> {
    let film = to.join(NAME);
    let mut command = Command::new("ffmpeg");
    command.args(["-y", "-loglevel", "error", "-f", "image2pipe", "-c:v", "png"]);
    command.args(["-framerate", &rate.max(1).to_string(), "-i", "-"]);
    command.args(["-vf", "crop=trunc(iw/2)*2:trunc(ih/2)*2,format=yuv420p"]);
    command.args(["-c:v", "libx264", "-crf", "17", "-movflags", "+faststart"]).arg(&film);
    let started = command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped()).spawn();
    let mut child = started.map_err(|e| match e.kind() {
        ErrorKind::NotFound => "ffmpeg was not found (PATH)".to_string(),
        _ => format!("ffmpeg cannot be started: {e}"),
    })?;
    let fed = child.stdin.take().map(|mut pipe| feed(&mut pipe, images));
    let output = child.wait_with_output().map_err(|e| format!("ffmpeg: {e}"))?;
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        return Err(format!("ffmpeg failed: {}", said.lines().last().unwrap_or("no message")));
    }
    fed.unwrap_or(Ok(())).map_err(|e| format!("the pictures cannot be passed to ffmpeg: {e}"))?;
    Ok(film)
}

fn feed(pipe: &mut impl Write, images: &[PathBuf]) -> std::io::Result<()> {
    for image in images {
        pipe.write_all(&std::fs::read(image)?)?;
    }
    Ok(())
}
