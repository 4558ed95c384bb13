//! Pictures, pages and measurements of Meniscus runs.
//!
//! [`render`] makes a PNG of each stored frame, and a film; [`write_page`] makes one self-contained page.
//! [`measure`] tells angles, radii and heights of a stored frame. All read an output folder and need neither a GPU nor any system package.

mod error;
mod folder;
mod measure;
mod page;
mod render;
mod shade;

pub use crate::error::{Result, ViewError};
pub use crate::folder::{Frame, RunFolder};
pub use crate::measure::{
    AngleAt, ContactMeasure, ComponentMeasure, FitShape, FittedAngle, Floating, Forces, LocalAngle, TimeStatistics,
    MeasureOptions, Measurement, Ridge, SoftMeasure, SolidMeasure, Midline, ContactInterval, TimeWindow, measure,
};
pub use crate::page::{PageOptions, PageReport, make_page, write_page};
pub use crate::render::{Camera, Image, RenderOptions, Rendered, Renderer, Appearance, Style, render};
pub use crate::shade::ColorBy;
