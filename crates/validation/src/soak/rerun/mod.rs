//! Runs done again: from checkpoints, on other threads, mirrored, shifted; scenes made smaller.

pub mod evidence;
pub mod image;
pub mod refuse;
pub mod repeat;
pub mod shrink;
