//! Formats of the output, and their writers, one file each.

mod ply;

use super::FrameWriter;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

pub use ply::PlyWriter;

/// A format of the output. Formats that this version does not write can be read, so that the error names them;
/// the schema omits them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Format {
    /// Surfaces of each frame as binary PLY; always written.
    Ply,
    /// One self-contained HTML page of the run.
    Page,
    /// VTK XML with a `.pvd`.
    #[schemars(skip)]
    Vtk,
    /// Wavefront OBJ.
    #[schemars(skip)]
    Obj,
    /// Binary glTF.
    #[schemars(skip)]
    Glb,
    /// USD text.
    #[schemars(skip)]
    Usd,
    /// OpenVDB level sets.
    #[schemars(skip)]
    Vdb,
    /// Tables of vertices.
    #[schemars(skip)]
    Csv,
}

impl Format {
    /// All formats, in the order of their definition.
    pub const ALL: [Self; 8] =
        [Self::Ply, Self::Page, Self::Vtk, Self::Obj, Self::Glb, Self::Usd, Self::Vdb, Self::Csv];

    /// The writer; `None` for a format that is not made frame by frame, or not supported.
    pub fn frame_writer(self) -> Option<Arc<dyn FrameWriter>> {
        match self {
            Self::Ply => Some(Arc::new(PlyWriter)),
            // The page is made from the folder at the end of a run.
            Self::Page => None,
            Self::Vtk | Self::Obj | Self::Glb | Self::Usd | Self::Vdb | Self::Csv => None,
        }
    }
}
