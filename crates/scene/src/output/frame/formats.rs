//! The writers of the scene's `output.formats`.

use super::{FrameWriter, PlyWriter};
use crate::file::Format;
use std::sync::Arc;

/// The writer of a format; `None` for one that is not made frame by frame, or not supported.
pub fn frame_writer(format: Format) -> Option<Arc<dyn FrameWriter>> {
    match format {
        Format::Ply => Some(Arc::new(PlyWriter)),
        // The page is made from the folder at the end of a run.
        Format::Page => None,
        Format::Vtk | Format::Obj | Format::Glb | Format::Usd | Format::Vdb | Format::Csv => None,
    }
}
