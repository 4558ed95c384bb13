//! Images in memory, line drawing and PNG files.

use std::borrow::Cow;
use std::ops::Range;
use std::path::Path;

use crate::error::{Result, ViewError};
use crate::folder::V3;
use crate::whole_file;

/// An image in linear colours.
#[derive(Clone, Debug)]
pub(crate) struct Canvas {
    pub width: usize,
    pub height: usize,
    pub pixels: Vec<V3>,
}

/// An image in 8-bit sRGB, rows from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    /// Pixels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Red, green, blue of each pixel.
    pub rgb: Vec<u8>,
    /// Opacity of each pixel, if the background is transparent; the colours are not multiplied by it.
    pub opacity: Option<Vec<u8>>,
}

/// Size of a picture, in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ImageSize {
    /// Pixels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl From<(u32, u32)> for ImageSize {
    fn from((width, height): (u32, u32)) -> Self {
        Self { width, height }
    }
}

impl From<ImageSize> for [f64; 2] {
    fn from(size: ImageSize) -> Self {
        [size.width, size.height].map(f64::from)
    }
}

impl Canvas {
    pub(crate) fn new(size: ImageSize, color: V3) -> Self {
        let [width, height] = [size.width, size.height].map(|n| n.max(1) as usize);
        Self { width, height, pixels: vec![color; width * height] }
    }

    /// Blends `color` over a pixel.
    pub(crate) fn blend(&mut self, x: usize, y: usize, color: &V3, alpha: f64) {
        let p = &mut self.pixels[y * self.width + x];
        *p = *p * (1.0 - alpha) + color * alpha;
    }

    /// Draws a line with round ends. `alpha` is a function of the pixel and of the position along the line (0 to 1).
    pub(crate) fn line(
        &mut self,
        a: [f64; 2],
        b: [f64; 2],
        width: f64,
        color: &V3,
        alpha: impl Fn(usize, usize, f64) -> f64,
    ) {
        let reach = width * 0.5 + 1.0;
        let Some((xs, ys)) = self.range(a, b, reach) else { return };
        for y in ys {
            for x in xs.clone() {
                let (cover, t) = line_coverage(a, b, width, x, y);
                if cover > 0.0 {
                    let a = cover * alpha(x, y, t);
                    self.blend(x, y, color, a);
                }
            }
        }
    }

    /// Raises the first component of each pixel to the share of it that a line covers.
    pub(crate) fn cover(&mut self, a: [f64; 2], b: [f64; 2], width: f64) {
        let Some((xs, ys)) = self.range(a, b, width * 0.5 + 1.0) else { return };
        for y in ys {
            for x in xs.clone() {
                let p = &mut self.pixels[y * self.width + x];
                p.x = p.x.max(line_coverage(a, b, width, x, y).0);
            }
        }
    }

    /// Ranges of the pixels around a line; `None` outside the picture.
    fn range(&self, a: [f64; 2], b: [f64; 2], reach: f64) -> Option<(Range<usize>, Range<usize>)> {
        let span = |k: usize, n: usize| {
            let from = (a[k].min(b[k]) - reach).floor().clamp(0.0, n as f64);
            let to = (a[k].max(b[k]) + reach).ceil().clamp(0.0, n as f64);
            (from < to).then_some(from as usize..to as usize)
        };
        Some((span(0, self.width)?, span(1, self.height)?))
    }

    /// Encodes the image with the tone curve `curve`.
    pub(crate) fn to_image(&self, curve: impl Fn(&V3) -> [u8; 3]) -> Image {
        Image {
            width: self.width as u32,
            height: self.height as u32,
            rgb: self.pixels.iter().flat_map(curve).collect(),
            opacity: None,
        }
    }

    /// The image without a background, from the same picture over black and over white (triangulation matting, Smith & Blinn 1996): a
    /// pixel of colour `c` and opacity `α` is `α c` over black and `1 − α` brighter over white.
    pub(crate) fn matte(over_black: &Self, over_white: &Self, curve: impl Fn(&V3) -> [u8; 3]) -> Image {
        let opacity = |(black, white): (&V3, &V3)| (1.0 - (white - black).mean()).clamp(0.0, 1.0);
        let opacities: Vec<f64> = over_black.pixels.iter().zip(&over_white.pixels).map(opacity).collect();
        let color =
            |(black, opacity): (&V3, &f64)| if *opacity > 0.0 { black / *opacity } else { V3::zeros() };
        let pixels = over_black.pixels.iter().zip(&opacities).map(color).collect();
        let image = Self { pixels, ..*over_black }.to_image(curve);
        let bytes = opacities.iter().map(|a| (a * 255.0).round() as u8).collect();
        Image { opacity: Some(bytes), ..image }
    }
}

/// The share of a pixel that a line with round ends covers, and the closest position along the line (0 to 1).
fn line_coverage(a: [f64; 2], b: [f64; 2], width: f64, x: usize, y: usize) -> (f64, f64) {
    let d = [b[0] - a[0], b[1] - a[1]];
    let length = d[0] * d[0] + d[1] * d[1];
    let p = [x as f64 + 0.5 - a[0], y as f64 + 0.5 - a[1]];
    let t = if length > 0.0 { ((p[0] * d[0] + p[1] * d[1]) / length).clamp(0.0, 1.0) } else { 0.0 };
    let away = (p[0] - t * d[0]).hypot(p[1] - t * d[1]);
    ((width * 0.5 + 0.5 - away).clamp(0.0, width.min(1.0)), t)
}

impl Image {
    /// The samples of the pixels one after another: red, green, blue, and the opacity if there is one.
    fn samples(&self) -> Cow<'_, [u8]> {
        let Some(opacity) = &self.opacity else { return Cow::Borrowed(&self.rgb) };
        let pixels = self.rgb.chunks_exact(3).zip(opacity);
        Cow::Owned(pixels.flat_map(|(c, a)| [c[0], c[1], c[2], *a]).collect())
    }

    /// Writes the image as a PNG file.
    pub fn save(&self, path: &Path) -> Result<()> {
        whole_file::write(path, |file| {
            let mut encoder = png::Encoder::new(file, self.width, self.height);
            let color = if self.opacity.is_some() { png::ColorType::Rgba } else { png::ColorType::Rgb };
            encoder.set_color(color);
            encoder.set_depth(png::BitDepth::Eight);
            let fail = |source| ViewError::Png { path: path.into(), source };
            let mut writer = encoder.write_header().map_err(fail)?;
            writer.write_image_data(&self.samples()).map_err(fail)?;
            writer.finish().map_err(fail)
        })
    }
}
