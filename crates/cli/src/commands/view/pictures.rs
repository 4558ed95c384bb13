//! `meniscus render` and `meniscus page`, also used at the end of `run`.

use crate::args::{PageArgs, RenderArgs};
use crate::commands::print;
use crate::failure::{Failure, OUTPUT, Result, USAGE};
use indicatif::{ProgressBar, ProgressStyle};
use meniscus_view::{Appearance, Camera, ColorBy, PageOptions, RenderOptions, Rendered, Style, ViewError};
use std::io::IsTerminal;
use std::path::{Path, PathBuf};

/// Default size limit of a page, MB; small enough for e-mail.
pub const DEFAULT_PAGE_MB: f64 = 20.0;

/// Filled share of a picture below which a warning is given.
const MIN_FILLED_SHARE: f64 = 0.05;

/// Makes pictures of a run.
pub fn render(args: &RenderArgs) -> Result {
    let options = RenderOptions {
        size: args.size.into(),
        camera: camera(args)?,
        style: args.style.as_deref().map(style).transpose()?,
        shade: args.color.as_deref().map_or(Ok(ColorBy::default()), shade)?,
        every: args.every.max(1) as usize,
        frames: args.frames.map(|(a, b)| frame(a)..=frame(b)),
        to: args.out.clone(),
        appearance: Appearance {
            floor: !args.no_floor,
            domain: !args.no_box,
            line: !args.no_line,
            background: args.background,
            transparent: args.transparent,
            liquid: args.liquid_color,
            solids: args.solid_color,
        },
        ..RenderOptions::default()
    };
    let rendered = pictures(&args.dir, &options, false)?;
    if rendered.filled_share < MIN_FILLED_SHARE && options.camera.is_some() {
        let part = 100.0 * rendered.filled_share;
        eprintln!(
            "warning: the liquid and the solids fill {part:.2} % of the picture; the camera may be too far away or look elsewhere"
        );
    }
    print(&describe(&rendered))?;
    Ok(0)
}

/// Makes a failure of an error with an output folder; where there is none, it tells what to give.
fn of_folder(dir: &Path) -> impl Fn(ViewError) -> Failure + '_ {
    move |error| {
        let failure = Failure::new(OUTPUT, error.to_string());
        let is_run = dir.join("frames").is_dir();
        if is_run { failure } else { failure.help("give the output folder of a run, such as out/my-scene") }
    }
}

/// Makes the page of a run.
pub fn page(args: &PageArgs) -> Result {
    let path = make_page(&args.dir, args.every.max(1), args.max_mb)?;
    print(&format!("page      {}\n", path.display()))?;
    Ok(0)
}

/// A frame's number; numbers that do not fit become the largest one.
fn frame(number: u64) -> u32 {
    u32::try_from(number).unwrap_or(u32::MAX)
}

/// The camera of `--camera` and `--target`, if one of them is given.
fn camera(args: &RenderArgs) -> Result<Option<Camera>> {
    let placed = args.camera.as_deref().map(camera_position).transpose()?;
    if placed.is_none() && args.target.is_none() {
        return Ok(None);
    }
    Ok(Some(Camera { target: args.target, ..placed.unwrap_or_default() }))
}

/// Parses `azimuth,elevation` in degrees, with an optional distance in metres.
fn camera_position(text: &str) -> Result<Camera> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|part| part.trim().parse().ok()).collect();
    let numbers = numbers.filter(|n| n.iter().all(|x| x.is_finite())).unwrap_or_default();
    match numbers[..] {
        [azimuth, elevation] => Ok(Camera { azimuth, elevation, ..Camera::default() }),
        [azimuth, elevation, distance] if distance > 0.0 => {
            Ok(Camera { azimuth, elevation, distance: Some(distance), ..Camera::default() })
        }
        _ => Err(Failure::new(USAGE, format!("`{text}` is not a camera position")).help(
            "give azimuth,elevation in degrees, and optionally the distance in metres: 30,15 or 30,15,0.4",
        )),
    }
}

fn style(text: &str) -> Result<Style> {
    match text {
        "glass" => Ok(Style::Glass),
        "matte" => Ok(Style::Matte),
        _ => Err(Failure::new(USAGE, format!("there is no style `{text}`")).help("use glass or matte")),
    }
}

fn shade(text: &str) -> Result<ColorBy> {
    ColorBy::named(text).ok_or_else(|| {
        let failure = Failure::new(USAGE, format!("solids cannot be coloured by `{text}`"));
        failure.help("use plain, phi_c, strain, displacement or young")
    })
}

/// Makes pictures, with a bar on a terminal unless quiet.
pub fn pictures(dir: &Path, options: &RenderOptions, quiet: bool) -> Result<Rendered> {
    let bar =
        if !quiet && std::io::stderr().is_terminal() { ProgressBar::new(0) } else { ProgressBar::hidden() };
    if let Ok(style) = ProgressStyle::with_template("pictures {pos}/{len} [{bar:24.cyan}] ETA {eta}") {
        bar.set_style(style.progress_chars("=> "));
    }
    let rendered = meniscus_view::render(dir, options, |done, all| {
        bar.set_length(all as u64);
        bar.set_position(done as u64);
    });
    bar.finish_and_clear();
    rendered.map_err(of_folder(dir))
}

/// The location of the pictures as text.
pub fn describe(rendered: &Rendered) -> String {
    let mut out = String::new();
    if let (Some(first), Some(last)) = (rendered.images.first(), rendered.images.last()) {
        let name =
            |path: &Path| path.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
        let folder = first.parent().unwrap_or(Path::new(""));
        let (n, all) = (rendered.images.len(), rendered.frames);
        let some = if n < all { format!("{n} of {all} frames, ") } else { String::new() };
        out += &format!("pictures  {} ({some}{} to {})\n", folder.display(), name(first), name(last));
        if rendered.removed > 0 {
            out += &format!("removed   {} pictures or films of an earlier call\n", rendered.removed);
        }
    }
    if let Some(film) = &rendered.film {
        out += &format!("film      {}\n", film.display());
    } else if let Some(reason) = &rendered.no_film {
        out += &format!("no film   {reason}\n");
    }
    out
}

/// Makes the page. Returns its path.
pub fn make_page(dir: &Path, every: u32, max_mb: f64) -> Result<PathBuf> {
    let options = PageOptions { every: every as usize, max_mb, ..PageOptions::default() };
    let report = meniscus_view::make_page(dir, &options).map_err(of_folder(dir))?;
    let megabytes = report.bytes as f64 * 1e-6;
    if megabytes > max_mb {
        eprintln!(
            "warning: the page takes {megabytes:.2} MB, more than the limit of {max_mb} MB: the page with a single frame is as large"
        );
    }
    Ok(report.path)
}
