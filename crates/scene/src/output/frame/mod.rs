//! Frames of a run: what they contain, how they are extracted from a simulation, and the formats in which they are written.

mod content;
mod extractor;
mod formats;
mod writer;

pub use content::{Attribute, Frame, FrameMesh};
pub use extractor::{FrameExtractor, NotFinite, liquid_surface};
pub use formats::{Format, PlyWriter};
pub use writer::FrameWriter;
