//! Fields on the grid as VTK image data, in single precision and compressed.

use super::collection::{self, Part};
use super::document::Document;
use crate::output::frame::{Frame, FrameFields, FrameParts, FrameWriter};
use crate::output::{FileError, Folder};
use std::path::PathBuf;

/// Writes `fields_NNNN.vti` with `phi`, `velocity` and `pressure` at the cells' centres, and `fields.pvd`. Nothing where a frame has no
/// fields.
#[derive(Clone, Copy, Debug)]
pub struct VtiWriter;

impl FrameWriter for VtiWriter {
    fn write(&self, folder: &Folder, number: u64, frame: &Frame) -> Result<PathBuf, FileError> {
        let Some(fields) = &frame.fields else { return Ok(folder.frames()) };
        let path = folder.frame_file("fields", number, "vti");
        super::save(&path, &image(fields, frame.time))?;
        collection::write(folder, "fields", &[Part { name: "fields".into(), extension: "vti" }])?;
        Ok(path)
    }

    fn parts(&self) -> FrameParts {
        FrameParts { elements: false, fields: true }
    }
}

/// The cells' centres are the points of the image, so that contours of `phi` are the surface.
fn image(fields: &FrameFields, time: f64) -> Document {
    let FrameFields { extent, first, dx, attributes } = fields;
    let [x, y, z] = extent.map(|n| n.saturating_sub(1));
    let whole = format!("0 {x} 0 {y} 0 {z}");
    let [a, b, c] = first;
    let head =
        format!(" WholeExtent=\"{whole}\" Origin=\"{a:?} {b:?} {c:?}\" Spacing=\"{dx:?} {dx:?} {dx:?}\"");
    let count = extent.iter().product();
    let mut document = Document::new("ImageData", &head, time, true);
    document.element("Piece", &format!(" Extent=\"{whole}\""), |d| {
        d.element("PointData", "", |d| attributes.iter().for_each(|a| d.attribute(a, count)));
    });
    document
}

#[cfg(test)]
mod tests {
    use super::super::document::tests::{attribute_of, parts};
    use super::*;
    use crate::output::frame::formats::tests::{Place, empty_frame, full_frame};

    #[test]
    fn the_image_has_the_grid() {
        let place = Place::new("vti");
        VtiWriter.write(&place.0, 1, &full_frame()).unwrap();
        VtiWriter.write(&place.0, 2, &empty_frame()).unwrap();
        assert_eq!(place.files(), ["fields.pvd", "fields_0001.vti"]);
        let (head, data) = parts(&std::fs::read(place.path("fields_0001.vti")).unwrap());
        assert_eq!(attribute_of(&head, "WholeExtent", "WholeExtent"), "0 1 0 0 0 0");
        assert_eq!(attribute_of(&head, "WholeExtent", "Origin"), "0.5 0.25 0.0");
        let bytes = lz4_flex::block::decompress(&data[32..], 8).unwrap();
        assert_eq!(bytes, [(-0.5f32).to_le_bytes(), 0.25f32.to_le_bytes()].concat());
        assert!(place.text("fields.pvd").contains("timestep=\"0.30000000000000004\""));
    }
}
