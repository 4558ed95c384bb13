//! Pictures of a run: own ray tracer on the CPU, the same bits for any number of threads.

mod bvh;
mod camera;
mod fill;
mod film;
mod flat;
mod geometry;
mod image;
mod label;
mod legend;
mod light;
mod optics;
mod sampling;
mod scene;
mod stage;
mod studio;
mod trace;

use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

pub use camera::Camera;
pub use image::Image;

use crate::error::{Result, ViewError};
use crate::folder::{Frame, RunFolder};
use crate::shade::Shade;
use legend::Shading;

/// How the liquid looks in three dimensions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Style {
    /// Clear: refracts, reflects, tints a little.
    #[default]
    Glass,
    /// Opaque blue.
    Matte,
}

/// How pictures are made.
#[derive(Clone, Debug)]
pub struct RenderOptions {
    /// Width and height (pixels).
    pub size: (u32, u32),
    /// The camera; `None` looks a little from above at all that is to be seen.
    pub camera: Option<Camera>,
    /// The look of the liquid.
    pub style: Style,
    /// What solids are coloured by.
    pub shade: Shade,
    /// Samples per pixel; three times as many where the liquid is seen.
    pub samples: u32,
    /// The frame numbers to picture; `None` for all.
    pub frames: Option<RangeInclusive<u32>>,
    /// Only each `every`-th frame.
    pub every: usize,
    /// Where the pictures go; `None` for `render` in the output folder.
    pub to: Option<PathBuf>,
    /// Make a film of them with `ffmpeg`, if it is on the path.
    pub film: bool,
    /// The film's pictures per second.
    pub rate: u32,
}

impl Default for RenderOptions {
    fn default() -> Self {
        Self {
            size: (640, 360),
            camera: None,
            style: Style::Glass,
            shade: Shade::Plain,
            samples: 4,
            frames: None,
            every: 1,
            to: None,
            film: true,
            rate: 25,
        }
    }
}

/// What has been made.
#[derive(Clone, Debug, Default)]
pub struct Rendered {
    /// The pictures, in order.
    pub images: Vec<PathBuf>,
    /// The film, if it was made.
    pub film: Option<PathBuf>,
    /// Why there is no film, if one was wanted.
    pub no_film: Option<String>,
}

/// Makes pictures of the frames of one run.
#[derive(Debug)]
pub struct Renderer {
    folder: RunFolder,
    numbers: Vec<u32>,
    options: RenderOptions,
    look: Look,
    shading: Option<Shading>,
}

#[derive(Debug)]
enum Look {
    Flat(flat::Window),
    Solid(Box<stage::Stage>),
}

impl Renderer {
    /// Reads through the output folder `dir` and sets up the camera for all its frames.
    pub fn open(dir: &Path, options: &RenderOptions) -> Result<Self> {
        let folder = RunFolder::open(dir)?;
        let wanted = |n: &u32| options.frames.as_ref().is_none_or(|range| range.contains(n));
        let every = options.every.max(1);
        let numbers: Vec<u32> = folder.numbers.iter().copied().filter(wanted).step_by(every).collect();
        if numbers.is_empty() {
            let (first, last) = (folder.numbers[0], folder.numbers[folder.numbers.len() - 1]);
            return Err(ViewError::content(
                dir,
                format!("none of its frames {first} to {last} is asked for"),
            ));
        }
        let look = if folder.dimension == 2 {
            let (seen, _) = stage::seen(&folder)?;
            Look::Flat(flat::Window::new(&folder, &seen, options.size))
        } else {
            Look::Solid(Box::new(stage::Stage::new(&folder, options)?))
        };
        let shading = Shading::of(&folder, options.shade)?;
        Ok(Self { folder, numbers, options: options.clone(), look, shading })
    }

    /// The numbers of the frames to picture.
    pub fn numbers(&self) -> &[u32] {
        &self.numbers
    }

    /// The picture of the frame with a number.
    pub fn image(&self, number: u32) -> Result<Image> {
        Ok(self.picture(&self.folder.frame(number)?))
    }

    /// The picture of a frame.
    fn picture(&self, frame: &Frame) -> Image {
        let shading = self.shading.as_ref();
        match &self.look {
            Look::Flat(window) => flat::picture(window, frame, shading),
            Look::Solid(stage) => {
                let scene = scene::Scene::new(stage, frame, self.options.style, shading);
                let mut canvas = trace::picture(&scene, self.options.size, self.options.samples);
                shading.iter().for_each(|shading| shading.legend(&mut canvas));
                canvas.develop(studio::develop)
            }
        }
    }
}

/// Writes a picture `frame_NNNN.png` of each wanted frame of the output folder `dir`, and a film of them.
/// `done` is told after each picture how many are made and how many there will be.
pub fn render(dir: &Path, options: &RenderOptions, mut done: impl FnMut(usize, usize)) -> Result<Rendered> {
    let renderer = Renderer::open(dir, options)?;
    let to = options.to.clone().unwrap_or_else(|| dir.join("render"));
    std::fs::create_dir_all(&to).map_err(ViewError::io(&to))?;
    let mut made = Rendered::default();
    for &number in renderer.numbers() {
        let path = to.join(format!("frame_{number:04}.png"));
        renderer.image(number)?.save(&path)?;
        made.images.push(path);
        done(made.images.len(), renderer.numbers.len());
    }
    if options.film && made.images.len() > 1 {
        match film::make(&to, &made.images, options.rate) {
            Ok(path) => made.film = Some(path),
            Err(why) => made.no_film = Some(why),
        }
    }
    Ok(made)
}
