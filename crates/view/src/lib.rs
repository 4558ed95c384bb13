//! Pictures, pages and measurements of Meniscus runs.
//!
//! [`render`] makes a PNG of each stored frame, and a film; [`write_page`] makes one self-contained page. [`measure`] reports
//! angles, radii and heights of a stored frame. All read an output folder and need neither a GPU nor any system package.

mod color_map;
mod error;
mod folder;
mod measure;
mod page;
mod render;
mod wetted;
mod whole_file;

pub use crate::color_map::ColorBy;
pub use crate::error::{Result, ViewError};
pub use crate::folder::{Frame, RunFolder};
pub use crate::measure::{
    AngleAt, ComponentMeasure, ContactInterval, ContactMeasure, FitShape, FittedAngle, Floating, Forces,
    LocalAngle, MeasureOptions, Measurement, Midline, Ridge, SoftMeasure, SolidMeasure, TimeStatistics,
    TimeWindow, measure,
};
pub use crate::page::time_series::TimeSeries;
pub use crate::page::{LiveRun, PageOptions, PageReport, live_page, make_page, write_page};
pub use crate::render::{
    Appearance, Camera, Image, ImageSize, RenderOptions, Rendered, Renderer, Style, render,
};
pub use crate::wetted::WettedFaces;
