//! Options and report of rendering.

use crate::color_map::ColorBy;
use crate::render::camera::Camera;
use crate::render::image::ImageSize;
use std::ops::RangeInclusive;
use std::path::PathBuf;

/// Look of the liquid in three dimensions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Style {
    /// Clear: refracting, reflecting, slightly tinted.
    #[default]
    Glass,
    /// Opaque blue.
    Matte,
}

/// Optional elements and colours. `None` stands for the default colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Appearance {
    /// Draw the checkered floor (3D).
    pub floor: bool,
    /// Draw the edges of the domain.
    pub domain: bool,
    /// Draw the contact line.
    pub line: bool,
    /// Background colour, 0xRRGGBB. In 3D tone mapping darkens bright colours slightly.
    pub background: Option<u32>,
    /// Leave the background out of the picture, which then has an opacity. Behind clear liquid the surroundings stay, as refraction
    /// shows them.
    pub transparent: bool,
    /// Colour of the liquid, 0xRRGGBB; for glass the colour at a thickness of one typical width.
    pub liquid: Option<u32>,
    /// Colour of all solids, 0xRRGGBB.
    pub solids: Option<u32>,
}

impl Default for Appearance {
    fn default() -> Self {
        Self {
            floor: true,
            domain: true,
            line: true,
            background: None,
            transparent: false,
            liquid: None,
            solids: None,
        }
    }
}

/// Options of rendering.
#[derive(Clone, Debug)]
pub struct RenderOptions {
    /// Size of the pictures.
    pub size: ImageSize,
    /// The camera, in 3D only; `None` looks slightly from above and shows everything.
    pub camera: Option<Camera>,
    /// Look of the liquid, in 3D only; `None` for glass.
    pub style: Option<Style>,
    /// Optional elements and colours.
    pub appearance: Appearance,
    /// Quantity that colours solids.
    pub shade: ColorBy,
    /// Samples per pixel; three times as many on the liquid.
    pub samples: u32,
    /// Numbers of the frames to render; `None` for all.
    pub frames: Option<RangeInclusive<u32>>,
    /// Render only each `every`-th frame.
    pub every: usize,
    /// Folder of the pictures; `None` for `render` in the output folder.
    pub to: Option<PathBuf>,
    /// Make a film with `ffmpeg`, if it is on the path.
    pub film: bool,
    /// Frame rate of the film, 1/s.
    pub rate: u32,
}

impl Default for RenderOptions {
    fn default() -> Self {
        Self {
            size: ImageSize { width: 640, height: 360 },
            camera: None,
            style: None,
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

/// Report on rendered pictures.
#[derive(Clone, Debug, Default)]
pub struct Rendered {
    /// The pictures, in order.
    pub images: Vec<PathBuf>,
    /// Number of frames of the run.
    pub frames: usize,
    /// Largest share of the picture, over sampled frames, covered by the bounding box of the liquid and the solids.
    pub filled_share: f64,
    /// Number of removed pictures of an earlier call.
    pub removed: usize,
    /// The film, if it was made.
    pub film: Option<PathBuf>,
    /// Why a requested film was not made.
    pub no_film: Option<String>,
}
