//! What a resolved scene expects of its end.

use crate::file::Side;

/// What is checked at the end of a run.
#[derive(Clone, Debug, PartialEq)]
pub enum Expectation {
    /// Worst relative change of volume of the run.
    VolumeDrift {
        /// Bound.
        max: f64,
    },
    /// Relative error of momentum.
    MomentumError {
        /// Bound.
        max: f64,
    },
    /// Growth of the total energy over its start, relative to the largest kind of energy there.
    EnergyGrowth {
        /// Bound.
        max: f64,
    },
    /// Something that was mended in the run.
    Repair {
        /// Its name among the repairs of the summary.
        name: String,
        /// Bound, as [`crate::atomic_file::RepairsFile`] has it.
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
        /// Name of the solid, or [`crate::atomic_file::WALL_CASES`].
        solid: String,
        /// Expected, rad.
        value: f64,
        /// Accepted deviation, rad.
        tolerance: f64,
    },
    /// Connected components of the liquid at the end.
    Drops {
        /// At least.
        min: u32,
        /// At most.
        max: u32,
    },
    /// How far the liquid reaches towards a side at the end.
    Reach {
        /// Towards which side.
        side: Side,
        /// Expected coordinate, m.
        value: f64,
        /// Accepted deviation, m.
        tolerance: f64,
    },
    /// The liquid carries a solid at the end, which sticks out of it.
    Floats {
        /// Name of the solid.
        solid: String,
    },
    /// A solid is wholly wetted at the end.
    Sinks {
        /// Name of the solid.
        solid: String,
    },
    /// Share of a solid's surface that is wetted at the end.
    Wetted {
        /// Name of the solid.
        solid: String,
        /// At least.
        min: f64,
        /// At most.
        max: f64,
    },
    /// Where the centre of mass of a solid is at the end.
    Position {
        /// Name of the solid.
        solid: String,
        /// Expected, m.
        value: Vec<f64>,
        /// Accepted distance from it, m.
        tolerance: f64,
        /// Unit direction along which alone the distance counts.
        along: Option<Vec<f64>>,
    },
    /// How far a solid that deforms is bent at the end.
    Deflection {
        /// Name of the solid.
        solid: String,
        /// At least, m.
        min: f64,
        /// At most, m; infinite if there is no bound.
        max: f64,
    },
}
