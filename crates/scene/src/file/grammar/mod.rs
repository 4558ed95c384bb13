//! The grammar of a scene file, exactly as written: `format = 1`.

mod expect;
mod keyframe;
mod quantity;
mod repairs;
mod scene_file;
mod shape;
mod solid;
mod wetting;

pub use expect::{
    ContactAngleFile, DeflectionFile, DropsFile, ExpectFile, FrequencyFile, MaxFile, MaxSpeedFile,
    PeriodFile, PositionFile, ReachFile, Side, WettedFile,
};
pub use keyframe::KeyframeFile;
pub use quantity::{
    Acceleration, Angle, AngularVelocity, Density, DynamicViscosity, Either, Frequency, KinematicViscosity,
    Length, MeshScale, Named, Pressure, Speed, Tension, Time,
};
pub(crate) use quantity::{HELP_MARK, short};
pub use repairs::RepairsFile;
pub use scene_file::{
    BodyFile, DomainFile, Format, LiquidFile, NumericsFile, OutputFile, SceneFile, Scheme, Wall, WallsFile,
};
pub use shape::{
    AxisAngleFile, BallFile, BoxFile, CapsuleFile, CowFile, CylinderFile, DifferenceFile, EllipsoidFile,
    ExtrusionFile, HalfSpaceFile, MeshFile, OutlineName, PerturbedBallFile, RotationFile, ShapeFile,
    SmoothUnionFile, WaveFile,
};
pub use solid::{CollisionFile, MovedFile, SolidFile, SolidMeshFile};
pub use wetting::{
    AngleAtFile, ContactLineFile, GradientFile, HysteresisFile, PatchFile, SolidTensionFile, TensionFile,
    WettingImageFile,
};
