//! Labels of the liquid's surface: liquid–air, liquid–solid, contact line.

/// A vertex or facet between liquid and air.
pub const LIQUID_AIR: u8 = 0;
/// A facet in the plane of a wall, or a vertex whose surroundings in that plane are wetted.
pub const LIQUID_SOLID: u8 = 1;
/// A vertex in the plane of a wall at the edge of the wetted area.
pub const CONTACT_LINE: u8 = 2;
