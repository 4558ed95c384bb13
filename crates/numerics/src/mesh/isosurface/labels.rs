//! Labels of the parts of the liquid's surface: liquid–air, liquid–solid, contact line.

/// A vertex between liquid and air.
pub const LIQUID_AIR: u8 = 0;
/// A vertex or facet in the plane of a wall, wetted all around.
pub const LIQUID_SOLID: u8 = 1;
/// A vertex in the plane of a wall at the edge of the wetted part.
pub const CONTACT_LINE: u8 = 2;
