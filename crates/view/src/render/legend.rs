//! Colours of solids by value, and their legend.

use meniscus_numerics::mesh::ply::PlyMesh;

use super::image::Canvas;
use super::label;
use crate::color_map::{ColorBy, ScalarRange, linear_from_srgb, scalar_ranges};
use crate::error::{Result, ViewError};
use crate::folder::RunFolder;

/// Mapping of values to colours, the same for all pictures of a run.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ColorMapping {
    pub shade: ColorBy,
    range: ScalarRange,
}

impl ColorMapping {
    /// The mapping of a run; `None` where solids have their own colours.
    ///
    /// # Errors
    /// If the run has no such values, or frames cannot be read.
    pub(crate) fn of(folder: &RunFolder, shade: ColorBy) -> Result<Option<Self>> {
        if shade == ColorBy::Plain {
            return Ok(None);
        }
        let stored = ColorBy::STORED.into_iter().zip(scalar_ranges(folder)?);
        let range = stored.filter(|(of, _)| *of == shade).find_map(|(_, range)| range);
        let nothing = || {
            let what = format!("no solid in the frames has values of `{}`", shade.name());
            ViewError::content(&folder.dir, what)
        };
        Ok(Some(Self { shade, range: range.ok_or_else(nothing)? }))
    }

    /// Normalised values at a mesh's vertices; empty where there are none.
    pub(crate) fn places(&self, mesh: &PlyMesh) -> Vec<f64> {
        let values = self.shade.values(mesh).unwrap_or_default();
        values.into_iter().map(|v| self.range.normalised(v)).collect()
    }

    /// Draws a colour bar with the ends of the range.
    pub(crate) fn legend(&self, canvas: &mut Canvas) {
        let (w, h) = (canvas.width as f64, canvas.height as f64);
        let (height, ink) = ((h / 28.0).max(8.0), linear_from_srgb(0x0033_3d47));
        let (left, low, width) = (1.2 * height, h - 1.2 * height, 0.25 * w);
        let at = |t: f64| [left + t * width, low];
        let pieces = 64;
        for k in 0..pieces {
            let [from, to] = [k, k + 1].map(|k| f64::from(k) / f64::from(pieces));
            let color = self.shade.color(0.5 * (from + to));
            canvas.line(at(from), at(to), 0.6 * height, &color, |_, _, t| {
                if (0.0..=1.0).contains(&t) { 1.0 } else { 0.0 }
            });
        }
        label::draw(canvas, self.shade.name(), [left, low - 2.3 * height], height, &ink);
        for (value, t) in [(self.range.low, 0.0), (self.range.high, 1.0)] {
            let text = label::value(value, self.shade.unit());
            let middle = at(t)[0] - t * label::width(&text, height);
            label::draw(canvas, &text, [middle, low - 0.8 * height], height, &ink);
        }
    }
}
