//! Builds the wettability layers of a solid: gradient, image and patches of the contact angle.

use super::shapes::shape;
use crate::error::SceneError;
use crate::file::vector;
use crate::file::{self, Scene, SceneFiles, SolidTension, Wetting, WettingImage};
use meniscus_sim::{CosineImage, Hysteresis, WettabilityLayer};
use std::io::Cursor;
use std::sync::Arc;

/// Largest number of pixels of an image.
const MAX_PIXELS: usize = 1 << 24;
/// Largest memory of the decoder, bytes, in addition to the pixels.
const MAX_BYTES: usize = 1 << 26;

/// The range of contact angles in which the line does not move.
pub fn hysteresis(h: &file::Hysteresis) -> Hysteresis {
    match *h {
        file::Hysteresis::Between { advancing, receding } => {
            Hysteresis::Between([advancing.cos(), receding.cos()])
        }
        file::Hysteresis::Around { above, below } => Hysteresis::Around([above, below]),
    }
}

/// The layers over the uniform cosine of a solid; the last one wins.
///
/// # Errors
/// [`SceneError`] that points at an unreadable image, or for a shape that cannot be made.
pub fn layers<const D: usize>(
    scene: &Scene,
    solid: &str,
    wetting: &Wetting,
) -> Result<Vec<WettabilityLayer<D>>, SceneError> {
    let mut layers = Vec::new();
    if let SolidTension::Gradient { from, to } = wetting.tension() {
        let [from, to] = [from, to].map(|end| (vector(&end.point), end.contact_angle.cos()));
        layers.push(WettabilityLayer::Gradient { from, to });
    }
    if let Some(image) = &wetting.image {
        let picture = picture(image, &scene.files).map_err(|why| {
            let error = SceneError::new(format!("the image cannot be read: {why}"));
            scene.source.at_value(error, &format!("tension.{solid}.image.file"))
        })?;
        layers.push(WettabilityLayer::Image(Arc::new(picture)));
    }
    for patch in &wetting.patches {
        let (shape, cosine) = (shape(&patch.shape, &scene.files)?, patch.contact_angle.cos());
        layers.push(WettabilityLayer::Patch { shape, cosine });
    }
    Ok(layers)
}

/// Reads an image as contact-angle cosines; the error is a message.
fn picture(image: &WettingImage, files: &SceneFiles) -> Result<CosineImage, String> {
    let file = files.content(&image.path).map_err(|e| e.to_string())?;
    let mut decoder = png::Decoder::new_with_limits(Cursor::new(file), png::Limits { bytes: MAX_BYTES });
    decoder.set_transformations(png::Transformations::normalize_to_color8());
    let mut reader = decoder.read_info().map_err(|e| e.to_string())?;
    let size = [reader.info().width as usize, reader.info().height as usize];
    let length = reader.output_buffer_size().filter(|_| size[0] * size[1] <= MAX_PIXELS);
    let Some(length) = length else {
        return Err(format!("its {} x {} pixels exceed the limit of {MAX_PIXELS}", size[0], size[1]));
    };
    let mut bytes = vec![0; length];
    let frame = reader.next_frame(&mut bytes).map_err(|e| e.to_string())?;
    let samples = frame.color_type.samples();
    let [black, white] = [image.black.cos(), image.white.cos()];
    let pixel = |values: &[u8]| {
        let value = |i: usize| f64::from(values[i]) / 255.0;
        // Luminance (ITU-R BT.709).
        let grey =
            if samples < 3 { value(0) } else { 0.2126 * value(0) + 0.7152 * value(1) + 0.0722 * value(2) };
        [black + (white - black) * grey, if samples % 2 == 0 { value(samples - 1) } else { 1.0 }]
    };
    // The file stores the uppermost row first.
    let rows = bytes.chunks_exact(frame.line_size).take(size[1]).rev();
    let pixels = rows.flat_map(|row| row.chunks_exact(samples).take(size[0]).map(pixel)).collect();
    let ends = |a: usize| match (image.lower.get(a), image.upper.get(a)) {
        (Some(low), Some(high)) => [*low, *high],
        _ => [0.0, 1.0],
    };
    Ok(CosineImage { bounds: [ends(0), ends(1)], size, pixels })
}
