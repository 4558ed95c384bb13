//! Pictures of a run by a ray tracer on the CPU. The result is bitwise the same for any number of threads.

mod camera;
mod coverage;
mod film;
mod image;
mod label;
mod legend;
mod options;
mod render_2d;
mod setup;
mod tracer;

use std::path::{Path, PathBuf};

pub use camera::Camera;
pub use image::{Image, ImageSize};
pub use options::{Appearance, RenderOptions, Rendered, Style};

use crate::error::{Result, ViewError};
use crate::folder::{Frame, RunFolder};
use image::Canvas;
use legend::ColorMapping;

/// Number of frames sampled for the filled share of the picture.
const SAMPLED_FRAMES: usize = 8;

/// Renders the frames of one run.
#[derive(Debug)]
pub struct Renderer {
    folder: RunFolder,
    numbers: Vec<u32>,
    options: RenderOptions,
    mode: RenderMode,
    shading: Option<ColorMapping>,
    filled_share: f64,
}

#[derive(Debug)]
enum RenderMode {
    Flat(render_2d::Viewport),
    Solid(Box<setup::RenderSetup>),
}

impl Renderer {
    /// Opens the output folder `dir` and sets up the camera for all its frames.
    pub fn open(dir: &Path, options: &RenderOptions) -> Result<Self> {
        let folder = RunFolder::open(dir)?;
        let wanted = |n: &u32| options.frames.as_ref().is_none_or(|range| range.contains(n));
        let every = options.every.max(1);
        let numbers: Vec<u32> = folder.frame_numbers.iter().copied().filter(wanted).step_by(every).collect();
        if numbers.is_empty() {
            let (first, last) =
                (folder.frame_numbers[0], folder.frame_numbers[folder.frame_numbers.len() - 1]);
            return Err(ViewError::content(
                dir,
                format!("the requested frames do not exist: the run has frames {first} to {last}"),
            ));
        }
        let of_3d =
            [(options.camera.is_some(), "a camera"), (options.style.is_some(), "a style of the liquid")];
        if let Some((_, what)) = of_3d.iter().find(|(given, _)| *given && folder.dimension == 2) {
            return Err(ViewError::content(dir, format!("this run is 2D, but {what} is for 3D runs only")));
        }
        let mode = if folder.dimension == 2 {
            let (seen, _) = setup::visible_bounds(&folder)?;
            RenderMode::Flat(render_2d::Viewport::new(&folder, &seen, options.size))
        } else {
            RenderMode::Solid(Box::new(setup::RenderSetup::new(&folder, options)?))
        };
        let filled_share = max_filled_share(&folder, &numbers, &mode)?;
        if filled_share <= 0.0 && options.camera.is_some() {
            return Err(ViewError::content(
                dir,
                "the pictures would be empty: neither liquid nor solids are in the view of this camera",
            ));
        }
        let shading = ColorMapping::of(&folder, options.shade)?;
        Ok(Self { folder, numbers, options: options.clone(), mode, shading, filled_share })
    }

    /// Numbers of the frames to render.
    pub fn numbers(&self) -> &[u32] {
        &self.numbers
    }

    /// Renders the frame with a number.
    pub fn image(&self, number: u32) -> Result<Image> {
        Ok(self.picture(&self.folder.frame(number)?))
    }

    /// Renders a frame.
    fn picture(&self, frame: &Frame) -> Image {
        let curve = match self.mode {
            RenderMode::Flat(_) => render_2d::encode_srgb,
            RenderMode::Solid(_) => tracer::environment::tone_map,
        };
        let appearance = self.options.appearance;
        if !appearance.transparent {
            return self.canvas(frame, appearance).to_image(curve);
        }
        let over = |color| self.canvas(frame, Appearance { background: Some(color), ..appearance });
        Canvas::matte(&over(0x0000_0000), &over(0x00ff_ffff), curve)
    }

    /// A frame in linear colours.
    fn canvas(&self, frame: &Frame, appearance: Appearance) -> Canvas {
        let shading = self.shading.as_ref();
        match &self.mode {
            RenderMode::Flat(window) => render_2d::picture(window, frame, &appearance, shading),
            RenderMode::Solid(setup) => {
                let mut setup = (**setup).clone();
                setup.appearance = appearance;
                let scene = tracer::scene::Scene::new(&setup, frame, &self.options, shading);
                let mut canvas = tracer::trace::picture(&scene, self.options.size, self.options.samples);
                shading.iter().for_each(|shading| shading.legend(&mut canvas));
                canvas
            }
        }
    }
}

/// Largest share of the picture, over sampled frames, covered by the bounding box of the liquid and the solids.
fn max_filled_share(folder: &RunFolder, numbers: &[u32], look: &RenderMode) -> Result<f64> {
    let mut most = 0.0f64;
    for number in RunFolder::evenly_spaced(numbers, SAMPLED_FRAMES) {
        let frame = folder.frame(number)?;
        let meshes = std::iter::once(&frame.liquid).chain(frame.solids.values());
        let points = meshes.flat_map(|mesh| &mesh.positions);
        most = most.max(match look {
            RenderMode::Flat(window) => covered_share(points.map(|p| window.place(p)), window.size()),
            RenderMode::Solid(stage) => {
                let place = |p: &[f64; 3]| {
                    stage.view.project(&stage.to_picture_coordinates(&[*p])[0]).map(|p| [p.0, p.1])
                };
                covered_share(points.filter_map(place), stage.view.size())
            }
        });
    }
    Ok(most)
}

/// Share of a picture of the given size, in pixels, covered by the bounding box of points.
fn covered_share(points: impl Iterator<Item = [f64; 2]>, size: [f64; 2]) -> f64 {
    let start = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    let (low, high) = points.fold(start, |(low, high), p| {
        ([low[0].min(p[0]), low[1].min(p[1])], [high[0].max(p[0]), high[1].max(p[1])])
    });
    (0..2).map(|a| (high[a].min(size[a]) - low[a].max(0.0)).max(0.0) / size[a]).product()
}

/// The pictures and films of an earlier call in a folder, except the pictures with the given numbers.
fn stale_images(to: &Path, numbers: &[u32]) -> Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(to).map_err(ViewError::io(to))? {
        let path = entry.map_err(ViewError::io(to))?.path();
        let name = path.file_name().and_then(|n| n.to_str()).unwrap_or_default();
        let number = name.strip_prefix("frame_").and_then(|n| n.strip_suffix(".png"));
        let number = number.and_then(|n| n.parse::<u32>().ok());
        if number.is_some_and(|n| !numbers.contains(&n)) || name == film::NAME {
            found.push(path);
        }
    }
    found.sort();
    Ok(found)
}

/// Writes a picture `frame_NNNN.png` of each requested frame of the output folder `dir`, and a film of them. Pictures of an
/// earlier call that this one does not overwrite are removed from `render` in the output folder. After each picture, `done` is
/// called with the number of pictures made and their total.
///
/// # Errors
/// [`ViewError`], also if nothing of the run is in the picture, and if a folder given in the options has pictures that this
/// call would not overwrite.
pub fn render(dir: &Path, options: &RenderOptions, mut done: impl FnMut(usize, usize)) -> Result<Rendered> {
    let renderer = Renderer::open(dir, options)?;
    let to = options.to.clone().unwrap_or_else(|| dir.join("render"));
    std::fs::create_dir_all(&to).map_err(ViewError::io(&to))?;
    let old = stale_images(&to, renderer.numbers())?;
    if options.to.is_some() && !old.is_empty() {
        let what = format!(
            "the folder contains {} pictures or films that this call would not overwrite: remove them, or choose another folder",
            old.len()
        );
        return Err(ViewError::content(&to, what));
    }
    old.iter().try_for_each(|path| std::fs::remove_file(path).map_err(ViewError::io(path)))?;
    let (frames, filled_share) = (renderer.folder.frame_numbers.len(), renderer.filled_share);
    let mut made = Rendered { frames, filled_share, removed: old.len(), ..Rendered::default() };
    for &number in renderer.numbers() {
        let path = to.join(format!("frame_{number:04}.png"));
        renderer.image(number)?.save(&path)?;
        made.images.push(path);
        done(made.images.len(), renderer.numbers.len());
    }
    if options.film && made.images.len() > 1 {
        let film = match options.appearance.transparent {
            true => Err("a film has no transparency".to_owned()),
            false => film::make(&to, &made.images, options.rate),
        };
        match film {
            Ok(path) => made.film = Some(path),
            Err(why) => made.no_film = Some(why),
        }
    }
    Ok(made)
}
