//! Repeated runs: from checkpoints, on other threads, mirrored, shifted; shrunk scenes.

pub mod accepted;
pub mod evidence;
pub mod repeat;
pub mod scene_transform;
pub mod shrink;
