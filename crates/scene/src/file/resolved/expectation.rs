//! Expectations of a resolved scene.

use crate::file::grammar::Side;

/// What is checked at the end of a run.
#[derive(Clone, Debug, PartialEq)]
pub enum Expectation {
    /// Largest relative change of volume during the run.
    VolumeDrift {
        /// Bound.
        max: f64,
    },
    /// Relative error of momentum.
    MomentumError {
        /// Bound.
        max: f64,
    },
    /// Growth of the total energy since the start, relative to the largest kind of energy at the start.
    EnergyGrowth {
        /// Bound.
        max: f64,
    },
    /// A repair during the run.
    Repair {
        /// Its name among the repairs of the summary.
        name: String,
        /// Bound, in the unit of the scene file.
        max: f64,
    },
    /// Largest speed at the end.
    MaxSpeed {
        /// Bound, m/s.
        max: f64,
    },
    /// Period, measured from the peaks of the kinetic energy (two in each period).
    Period {
        /// Mode number, for the record.
        mode: Option<u32>,
        /// Expected, s.
        value: f64,
        /// Accepted relative deviation.
        tolerance: f64,
    },
    /// Frequency, measured like the period.
    Frequency {
        /// Mode number, for the record.
        mode: Option<u32>,
        /// Expected, Hz.
        value: f64,
        /// Accepted relative deviation.
        tolerance: f64,
    },
    /// Contact angle at the end.
    ContactAngle {
        /// Name of the solid, or [`crate::file::WALLS`].
        solid: String,
        /// Expected, rad.
        value: f64,
        /// Accepted deviation, rad.
        tolerance: f64,
    },
    /// Connected components of the liquid at the end.
    Drops {
        /// Least number.
        min: u32,
        /// Largest number.
        max: u32,
    },
    /// Extent of the liquid towards a side at the end.
    Reach {
        /// The side.
        side: Side,
        /// Expected coordinate, m.
        value: f64,
        /// Accepted deviation, m.
        tolerance: f64,
    },
    /// At the end the liquid carries a solid that is not fully submerged.
    Floats {
        /// Name of the solid.
        solid: String,
    },
    /// A solid is fully wetted at the end.
    Sinks {
        /// Name of the solid.
        solid: String,
    },
    /// Wetted share of a solid's surface at the end.
    Wetted {
        /// Name of the solid.
        solid: String,
        /// Least share.
        min: f64,
        /// Largest share.
        max: f64,
    },
    /// Centre of mass of a solid at the end.
    Position {
        /// Name of the solid.
        solid: String,
        /// Expected, m.
        value: Vec<f64>,
        /// Accepted distance from it, m.
        tolerance: f64,
        /// Unit direction along which the distance is measured; `None` for the full distance.
        along: Option<Vec<f64>>,
    },
    /// Deflection of a deformable solid at the end.
    Deflection {
        /// Name of the solid.
        solid: String,
        /// Least deflection, m.
        min: f64,
        /// Largest deflection, m; infinite if there is no bound.
        max: f64,
    },
}
