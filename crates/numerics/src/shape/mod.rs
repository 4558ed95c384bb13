//! Shapes that fill the domain at the start of a run, and exact fractions of cut cells.

mod fraction;

pub use fraction::plane_box_fraction;
