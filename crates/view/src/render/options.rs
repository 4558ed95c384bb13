//! How a run is to be drawn, and what was.

use crate::color_map::ColorBy;
use crate::render::camera::Camera;
use std::ops::RangeInclusive;
use std::path::PathBuf;

/// How the liquid looks in three dimensions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Style {
    /// Clear: refracts, reflects, tints a little.
    #[default]
    Glass,
    /// Opaque blue.
    Matte,
}

/// What is drawn beside the liquid and the solids, and in which colours; those of the program where none is given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Appearance {
    /// Whether the checkered floor is drawn (3D).
    pub floor: bool,
    /// Whether the edges of the domain are drawn.
    pub domain: bool,
    /// Whether the contact line is drawn.
    pub line: bool,
    /// The colour behind everything, 0xRRGGBB; bright ones come out a little darker in 3D, as highlights are rolled off.
    pub background: Option<u32>,
    /// The colour of the liquid, 0xRRGGBB; of glass the colour that it takes on where it is as thick as it is wide.
    pub liquid: Option<u32>,
    /// The colour of all solids, 0xRRGGBB.
    pub solids: Option<u32>,
}

impl Default for Appearance {
    fn default() -> Self {
        Self { floor: true, domain: true, line: true, background: None, liquid: None, solids: None }
    }
}

/// How pictures are made.
#[derive(Clone, Debug)]
pub struct RenderOptions {
    /// Width and height (pixels).
    pub size: (u32, u32),
    /// The camera, in 3D only; `None` looks a little from above at all that is to be seen.
    pub camera: Option<Camera>,
    /// The look of the liquid.
    pub style: Style,
    /// What else is drawn, and colours.
    pub appearance: Appearance,
    /// What solids are coloured by.
    pub shade: ColorBy,
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
            appearance: Appearance::default(),
            shade: ColorBy::Plain,
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
    /// Frames of the run.
    pub frames: usize,
    /// The part of the picture that the box around what is to be seen takes up, in the frame where it is largest.
    pub filled_share: f64,
    /// Pictures of an earlier call that were removed.
    pub removed: usize,
    /// The film, if it was made.
    pub film: Option<PathBuf>,
    /// Why there is no film, if one was wanted.
    pub no_film: Option<String>,
}
