//! Runs done again: from checkpoints, on other threads, mirrored, shifted; scenes made smaller.

pub mod accepted;
pub mod evidence;
pub mod repeat;
pub mod scene_transform;
pub mod shrink;
