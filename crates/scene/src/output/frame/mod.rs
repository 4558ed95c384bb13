//! Frames of a run: what they contain, how they are extracted from a simulation, and the formats in which they are written.

mod content;
mod extractor;
mod formats;
mod known;
mod placement;
mod polylines;
mod volumes;
mod writer;

pub use content::{Attribute, Frame, FrameElements, FrameFields, FrameMesh, FrameParts};
pub use extractor::{FrameExtractor, NotFinite, liquid_surface};
pub use formats::{
    CsvWriter, Format, GlbWriter, ObjWriter, PlyWriter, UsdWriter, VdbWriter, VtiWriter, VtkWriter,
};
pub use known::stored_wall_solid;
pub use polylines::polylines;
pub use writer::FrameWriter;
